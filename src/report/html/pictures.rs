//! The frames as data inside the page.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::Shown;
use crate::compare::Entry;
use crate::compare::pair::PairReport;
use crate::compare::picture::{Form, Picture, PictureError};

/// Why a picture is not in the page.
#[derive(Debug, thiserror::Error)]
pub enum PictureDataError {
    /// It could be read before.
    #[error("{} cannot be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: PictureError,
    },
    /// It cannot be made a PNG.
    #[error("{} cannot be shown", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: png::EncodingError,
    },
}

/// The frames as JSON for a `script` element: the pictures, each once, and for each
/// comparison its frames with the pictures' numbers.
pub(super) fn json(shown: &[Shown<'_>], worst: &[Vec<usize>]) -> Result<String, PictureDataError> {
    let mut pictures: Vec<String> = Vec::new();
    let mut numbers: HashMap<PathBuf, usize> = HashMap::new();
    let mut number = |path: &Path| match numbers.get(path) {
        Some(&number) => Ok(number),
        None => {
            pictures.push(data(path)?);
            numbers.insert(path.to_owned(), pictures.len() - 1);
            Ok(pictures.len() - 1)
        }
    };
    let mut list = Vec::new();
    for (one, worst) in shown.iter().zip(worst) {
        let mut frames = Vec::new();
        for &k in worst {
            if let Some(Entry::Pair(pair)) = one.comparison.entries.get(k) {
                frames.push(serde_json::json!({
                    "name": pair.name,
                    "words": words(pair),
                    "a": number(&pair.a)?,
                    "b": number(&pair.b)?,
                }));
            }
        }
        list.push(serde_json::json!({ "label": one.label, "frames": frames }));
    }
    // `</script>` in a name would end the element.
    let all = serde_json::json!({ "pictures": pictures, "shown": list });
    Ok(all.to_string().replace('<', "\\u003c"))
}

fn words(pair: &PairReport) -> String {
    let mut words = match pair.reasons.as_slice() {
        [] => pair.verdict.words().to_owned(),
        reasons => format!("{}: {}", pair.verdict.words(), reasons.join("; ")),
    };
    if let Some((x, y)) = pair.moved {
        words += &format!("; B is A moved by ({x}, {y}) pixels");
    }
    words
}

/// A picture as an address: a PNG of 8 bits as it is, any other as a display
/// takes it.
fn data(path: &Path) -> Result<String, PictureDataError> {
    let read = |source| PictureDataError::Read {
        path: path.to_owned(),
        source,
    };
    let picture = Picture::read(path).map_err(read)?;
    let bytes = if picture.form == Form::Png8 {
        std::fs::read(path).map_err(|error| read(PictureError::Open(error)))?
    } else {
        encoded(&picture.as_display(false)).map_err(|source| PictureDataError::Encode {
            path: path.to_owned(),
            source,
        })?
    };
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}

fn encoded(picture: &Picture) -> Result<Vec<u8>, png::EncodingError> {
    let bytes: Vec<u8> = picture
        .values
        .iter()
        // The conversion saturates; NaN becomes black.
        .flat_map(|[r, g, b, _]| [r, g, b].map(|value| (value * 255.0 + 0.5) as u8))
        .collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, picture.size.width, picture.size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}
