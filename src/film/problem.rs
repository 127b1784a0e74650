//! What can be wrong with a film: one variant for each distinct error, with
//! what is wrong as its message and what was expected beside it.

use thiserror::Error;

/// One thing that is wrong with a film.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the variants and fields mean.
pub enum Problem {
    // The file.
    #[error("the film cannot be read")]
    Unreadable {
        #[source]
        source: std::io::Error,
    },
    #[error("`{name}` is not a film's name")]
    UnknownForm { name: String },
    #[error("the film has no frame")]
    NoFrame,
    #[error("{more} more errors are not shown")]
    TooMany { more: usize },

    // The line.
    #[error("this is not UTF-8 text")]
    NotUtf8,
    #[error("`{word}` begins no statement")]
    NotAStatement { word: String },
    #[error("unknown keyword `*{word}`")]
    UnknownKeyword {
        word: String,
        near: Option<&'static str>,
    },
    #[error("the quotation mark is never closed")]
    OpenQuote,
    #[error("a quotation mark stands inside a word")]
    StrayQuote,
    #[error("{statement} has {found} field{}", plural(*found))]
    FieldCount {
        statement: &'static str,
        expected: &'static str,
        found: usize,
    },
    #[error("`{text}` is not a number")]
    NotANumber { text: String },
    #[error("`{text}` is not a finite number")]
    NotFinite { text: String },
    #[error("`{text}` is not a whole number")]
    NotWhole { text: String },
    #[error("`{text}` is neither yes nor no")]
    NotABoolean { text: String },
    #[error("unknown type of light `{text}`")]
    UnknownLight {
        text: String,
        near: Option<&'static str>,
    },
    #[error("`name=` must be the last field")]
    NameNotLast,
    #[error("this is not JSON: {reason}")]
    NotJson { reason: String },
    #[error("this is not a scene: {reason}")]
    NotAScene {
        reason: String,
        expected: String,
        near: Option<String>,
    },
    #[error("a light of type `{kind}` needs `{field}`")]
    LightWithout {
        kind: &'static str,
        field: &'static str,
    },
    #[error("a light of type `{kind}` has no `{field}`")]
    LightWithForeign {
        kind: &'static str,
        field: &'static str,
    },
    #[error("an empty list of {what} says nothing")]
    EmptyList { what: &'static str },

    // Scenes and the whole film.
    #[error("`{text}` is not a scene number")]
    SceneNumber { text: String },
    #[error("scene {number} comes after scene {before}")]
    SceneNotGrowing { number: u32, before: u32 },
    #[error("scene {number} lies beyond the film's last frame, {last}")]
    SceneBeyond { number: u32, last: u32 },
    #[error("a film has at least one frame")]
    NoImages,
    #[error("{images} frames from frame {first} on pass the largest frame number")]
    TooManyFrames { first: u32, images: u32 },
    #[error("{what} holds for the whole film and was {before} on line {line}")]
    Restated {
        what: &'static str,
        before: String,
        line: usize,
    },
    #[error("{what} is stated twice in one scene, first on line {line}")]
    StatedTwice { what: &'static str, line: usize },
    #[error("the film never states {what}")]
    Missing { what: &'static str },
    #[error("the first scene does not state {what}")]
    MissingFirst { what: &'static str },

    // The camera.
    #[error("{value} is no opening angle")]
    OpeningAngle { value: f64 },
    #[error("{value} is no size of a picture")]
    SizeOutOfRange { value: String },
    #[error("the up direction has no length")]
    UpWithoutLength,
    #[error("{} the eye is at the aim", moment(*frame))]
    EyeIsAim { frame: Option<u32> },
    #[error("{} the up direction is parallel to the view", moment(*frame))]
    UpAlongView { frame: Option<u32> },
    #[error("in frame {frame} {what} is no longer at a finite place")]
    NotFiniteLater { what: String, frame: u32 },

    #[error("in frame {frame} the aim is too far from the eye")]
    TooFarApart { frame: u32 },

    // Colours, lights, antialiasing.
    #[error("{value} is no part of a colour")]
    NegativeColour { value: f64 },
    #[error("the light stands where it points to")]
    LightWithoutDirection,
    #[error("{value} is no {what} of a spot")]
    SpotAngle { what: &'static str, value: f64 },
    #[error("the spot's radius, {radius}, is larger than its falloff, {falloff}")]
    SpotOrder { radius: f64, falloff: f64 },
    #[error("{value} is no tightness")]
    Tightness { value: f64 },
    #[error("{value} is no number of samples")]
    AreaSamples { value: String },
    #[error("a side of the area light has samples but no length")]
    AreaSide,
    #[error("{value} is no distance to fade at")]
    FadeDistance { value: f64 },
    #[error("{value} is no power to fade with")]
    FadePower { value: f64 },
    #[error("{value} is no threshold of antialiasing")]
    AntialiasThreshold { value: f64 },
    #[error("{value} is no depth of antialiasing")]
    AntialiasDepth { value: String },

    // Objects and files.
    #[error("the path is empty")]
    EmptyPath,
    #[error("the name is empty")]
    EmptyName,
    #[error("{what} holds a quotation mark or a control character")]
    Unwritable { what: &'static str },
    #[error("`{path}` is absolute")]
    AbsolutePath { path: String },
    #[error("`{path}` leaves the film's folder")]
    LeavesFolder { path: String },
    #[error("`{path}` does not exist")]
    MissingFile { path: String, tried: Vec<String> },
    #[error("`{path}` is not a file")]
    NotAFile { path: String },
    #[error("`{path}` cannot be looked at")]
    UnreachableFile {
        path: String,
        #[source]
        source: std::io::Error,
    },
    #[error("`.{ending}` is no ending of an object description")]
    UnknownEnding { ending: String },
    #[error("two objects of this scene are named `{name}`, the first on line {line}")]
    SameName { name: String, line: usize },
    #[error("`{name}` is what an unnamed object of this film is called")]
    NameTaken { name: String },
}

impl Problem {
    /// What was expected instead, for the label under the place.
    pub fn expected(&self) -> String {
        use Problem as P;
        let text = match self {
            P::Unreadable { .. } | P::UnreachableFile { .. } => "expected a readable file",
            P::UnknownForm { .. } => "expected a name that ends in .anim or .jsonl",
            P::NoFrame => "expected at least one scene",
            P::TooMany { .. } => "here is the next one",
            P::NotUtf8 => "expected UTF-8 text",
            P::NotAStatement { .. } => {
                "expected `@` and a scene number, `*` and a keyword, `!` and a path, or `#`"
            }
            P::UnknownKeyword { .. } => {
                return format!("expected one of {}", super::keyword::all());
            }
            P::OpenQuote => "expected a closing quotation mark on this line",
            P::StrayQuote => {
                "expected the quotation marks around a whole path or name, and a blank after them"
            }
            P::FieldCount { expected, .. } => return format!("expected {expected}"),
            P::NotANumber { .. } | P::NotFinite { .. } => "expected a finite number",
            P::NotWhole { .. } => "expected a whole number, 0 or more",
            P::NotABoolean { .. } => "expected 0 or 1",
            P::UnknownLight { .. } => {
                "expected ponctuelle or point, soleil or sun, spot, zone or area"
            }
            P::NameNotLast => "expected at the end of the line",
            P::NotJson { reason } if reason == "number out of range" => "expected a finite number",
            P::NotJson { .. } => "expected one JSON object on this line",
            P::NotAScene { expected, .. } => return format!("expected {expected}"),
            P::LightWithout { field, .. } => return format!("expected `{field}`"),
            P::LightWithForeign { .. } => "expected nothing here",
            P::EmptyList { .. } => "expected at least one element, or no list",
            P::SceneNumber { .. } => "expected a whole number from 0 to 4294967295",
            P::SceneNotGrowing { before, .. } => {
                return format!("expected a number above {before}");
            }
            P::SceneBeyond { last, .. } => return format!("expected {last} at most"),
            P::NoImages => "expected 1 or more",
            P::TooManyFrames { .. } => "expected a last frame of 4294967295 at most",
            P::Restated { before, .. } => return format!("expected {before} again, or nothing"),
            P::StatedTwice { .. } => "expected once in a scene",
            P::Missing { what } => return format!("expected {what}"),
            P::MissingFirst { what } => return format!("expected {what} in this scene"),
            P::OpeningAngle { .. } => "expected degrees between 0 and 180, both excluded",
            P::SizeOutOfRange { .. } => "expected pixels from 1 to 65535",
            P::UpWithoutLength => "expected a direction",
            P::EyeIsAim { .. } => "expected two different points",
            P::UpAlongView { .. } => "expected a view that is not along the up direction",
            P::NotFiniteLater { .. } => "expected positions that stay finite",
            P::TooFarApart { .. } => "expected a distance that is a finite number",
            P::NegativeColour { .. } => "expected 0 or more",
            P::LightWithoutDirection => "expected two different points",
            P::SpotAngle { what, .. } if *what == "radius" => "expected degrees from 0 to 90",
            P::SpotAngle { .. } => "expected degrees above 0, up to 90",
            P::SpotOrder { .. } => "expected the radius to be the smaller one",
            P::Tightness { .. } => "expected 0 or more",
            P::AreaSamples { .. } => "expected a whole number from 1 to 65535",
            P::AreaSide => "expected a side of some length, or 1 sample",
            P::FadeDistance { .. } => "expected a distance above 0",
            P::FadePower { .. } => "expected 0 or more",
            P::AntialiasThreshold { .. } => "expected 0 or more",
            P::AntialiasDepth { .. } => "expected a whole number from 1 to 9",
            P::EmptyPath => "expected the path of a file",
            P::EmptyName => "expected a name",
            P::Unwritable { .. } => "expected text that can stand in quotation marks on one line",
            P::AbsolutePath { .. } => "expected a path relative to the film's folder",
            P::LeavesFolder { .. } => "expected a path inside the film's folder",
            P::MissingFile { tried, .. } if tried.is_empty() => "expected an existing file",
            P::MissingFile { tried, .. } => return format!("looked for {}", tried.join(", ")),
            P::NotAFile { .. } => "expected a file",
            P::UnknownEnding { .. } => {
                "expected .inc, .pov, .ron, .obj, .ply, .stl, .gltf, .glb or no ending"
            }
            P::SameName { .. } | P::NameTaken { .. } => "expected another name",
        };
        text.to_owned()
    }

    /// Does a line end where its JSON goes on?
    pub(super) fn is_unfinished_json(&self) -> bool {
        matches!(self, Self::NotJson { reason } if reason.starts_with("EOF"))
    }

    /// What may help, where something may.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::UnknownKeyword { near, .. } => {
                near.map(|near| format!("did you mean `*{near}`?"))
            }
            Self::UnknownLight { near, .. } => near.map(|near| format!("did you mean `{near}`?")),
            Self::NotANumber { text } if text.replace(',', ".").parse::<f64>().is_ok() => {
                Some("the decimal sign is a point".to_owned())
            }
            Self::AbsolutePath { .. } | Self::LeavesFolder { .. } => {
                Some("`--allow-outside` allows it".to_owned())
            }
            Self::NotAScene { near, .. } => {
                let near = near.as_ref();
                near.map(|near| format!("did you mean `{near}`?"))
            }
            Self::NotJson { .. } if self.is_unfinished_json() => {
                Some("every scene stands on one line of its own".to_owned())
            }
            Self::EmptyList { .. } => Some(
                "a scene that leaves the list out keeps the last one; the format has no way to \
                 say that nothing is left"
                    .to_owned(),
            ),
            Self::Missing { what } | Self::MissingFirst { what } => example(what),
            Self::NameTaken { .. } => Some(
                "an object without `name=` is called by its path and its number among the \
                 objects of that path"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

/// How a thing that every film needs is stated, in both forms.
fn example(what: &str) -> Option<String> {
    let (anim, json) = match what {
        "the eye" => ("*eye 0 2 -10", r#""eye": {"position": [0, 2, -10]}"#),
        "the aim" => ("*aim 0 0 0", r#""aim": {"position": [0, 0, 0]}"#),
        "the opening angles" => ("*angles 60 45", r#""angles": [60, 45]"#),
        "the size" => ("*size 320 240", r#""size": [320, 240]"#),
        _ => return None,
    };
    Some(format!("for example `{anim}`, or in JSON `{json}`"))
}

fn plural(n: usize) -> &'static str {
    if n == 1 { "" } else { "s" }
}

fn moment(frame: Option<u32>) -> String {
    match frame {
        Some(frame) => format!("advanced to frame {frame},"),
        None => "in this scene".to_owned(),
    }
}
