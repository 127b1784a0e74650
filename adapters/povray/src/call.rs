//! One call of POV-Ray: a folder of its own, the scene's files in it, the
//! switches, and the frames' pixels out of it.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use decor_api::process::ProcessCall;
use decor_api::{
    AdapterError, Blocks, Layer, LayerRequest, NativeFile, Output, Picture, Region, Rendered,
    RunContext, SceneText, Size, Window,
};

use crate::depth::{DepthCode, Precision};
use crate::scene_text::{Framing, MAIN, Numbering, in_crop, switches, window_of};
use crate::state::{self, Wanted};
use crate::{encode, picture};

/// Some blocks' records.
const BUFFER: usize = 1 << 16;

/// What layers are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerSource {
    /// The render state file of 3.7: single precision, any set of blocks.
    StateFile,
    /// 16-bit pictures: every version has them.
    Pictures,
}

impl LayerSource {
    /// How exact its pixels are.
    pub fn precision(self) -> Precision {
        match self {
            Self::StateFile => Precision::Single,
            Self::Pictures => Precision::Integer16,
        }
    }
}

/// A folder for one call. It goes with the value, unless it is kept.
pub struct Folder {
    path: PathBuf,
    _temporary: Option<tempfile::TempDir>,
}

impl Folder {
    /// Makes the folder, named after `label`, and writes the files of a scene.
    pub fn new(run: &RunContext, label: &str, text: &SceneText) -> Result<Self, AdapterError> {
        let folder = if run.keep {
            let path = run.work.join(label);
            std::fs::create_dir_all(&path).map_err(AdapterError::io(&path))?;
            Self {
                path,
                _temporary: None,
            }
        } else {
            let temporary = tempfile::Builder::new()
                .prefix(&format!("{label}-"))
                .tempdir_in(&run.work)
                .map_err(AdapterError::io(&run.work))?;
            Self {
                path: temporary.path().to_owned(),
                _temporary: Some(temporary),
            }
        };
        for (name, bytes) in &text.files {
            folder.write(name, bytes)?;
        }
        Ok(folder)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), AdapterError> {
        let path = self.file(name);
        std::fs::write(&path, bytes).map_err(AdapterError::io(&path))
    }

    /// Makes the folders of `files` library paths: what a scene reads besides
    /// its text (images, height fields) lies there. Debian's POV-Ray may read
    /// only below its working folder, so they are linked into it.
    pub fn library_switches<'f>(
        &self,
        files: impl Iterator<Item = &'f NativeFile>,
    ) -> Result<Vec<String>, AdapterError> {
        let mut folders: Vec<&Path> = Vec::new();
        for file in files {
            for folder in [file.path.parent().unwrap_or(Path::new("/")), &file.root] {
                if !folders.contains(&folder) {
                    folders.push(folder);
                }
            }
        }
        let mut switches = Vec::new();
        for (k, folder) in folders.into_iter().enumerate() {
            let name = format!("library_{k}");
            let link = self.file(&name);
            match std::os::unix::fs::symlink(folder, &link) {
                Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
                    return Err(AdapterError::Io {
                        path: link,
                        source: error,
                    });
                }
                _ => {}
            }
            switches.push(format!("+L{name}"));
        }
        Ok(switches)
    }
}

/// All renderer-native files that a request reads.
pub fn native_files<'r>(request: &'r LayerRequest<'_>) -> impl Iterator<Item = &'r NativeFile> {
    let around = request
        .shots
        .first()
        .into_iter()
        .flat_map(|shot| shot.scene.includes.iter().chain(&shot.scene.sky));
    around.chain(fragments(request.prototypes))
}

/// The files of all fragments of a table.
pub fn fragments(table: &decor_api::PrototypeTable) -> impl Iterator<Item = &NativeFile> {
    table
        .iter()
        .filter_map(|(_, prototype)| match &prototype.geometry {
            decor_api::Geometry::Fragment(fragment) => Some(&fragment.file),
            decor_api::Geometry::Neutral(_) => None,
        })
}

/// Switches of every call: nothing is left to a configuration file.
pub fn fixed_switches() -> Vec<String> {
    vec![
        format!("+I{MAIN}"),
        "-D".into(),
        "-V".into(),
        "-P".into(),
        "+Q9".into(),
    ]
}

/// One render of a request.
#[derive(Clone, Copy)]
pub struct LayerCall<'a> {
    /// The program.
    pub program: &'a Path,
    /// What to render.
    pub request: &'a LayerRequest<'a>,
    /// How depth is written, in a depth pass.
    pub code: Option<DepthCode>,
    /// Where the pixels come from.
    pub source: LayerSource,
}

/// What a call is to leave.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Leaves {
    /// Linear pixels.
    Layers,
    /// POV-Ray's own encoding, in so many bits a channel.
    Pictures(u8),
}

impl<'a> LayerCall<'a> {
    /// Runs the call; one layer a shot.
    pub fn run(
        self,
        text: &SceneText,
        run: &RunContext,
    ) -> Result<Rendered<'a, Layer>, AdapterError> {
        let folder = self.called(text, Leaves::Layers, run)?;
        let shots = self.request.shots.len();
        Ok(Rendered::new(shots, move |k| self.read(&folder, k)))
    }

    /// Runs the call; one picture a shot, for frames of 8 or of 16 bits.
    ///
    /// A whole picture is POV-Ray's own. Of one that is drawn in some blocks only, it
    /// would encode every pixel all the same, which takes it longer than all else that
    /// it does for a few blocks: those are taken from the state file.
    pub fn run_encoded(
        self,
        text: &SceneText,
        bits: u8,
        run: &RunContext,
    ) -> Result<Rendered<'a, Picture>, AdapterError> {
        let leaves = match self.side()? {
            Some(_) => Leaves::Layers,
            None => Leaves::Pictures(bits),
        };
        let folder = self.called(text, leaves, run)?;
        let shots = self.request.shots.len();
        Ok(Rendered::new(shots, move |k| match leaves {
            Leaves::Layers => self.encoded(&folder, bits, k),
            Leaves::Pictures(_) => self.picture(&folder, bits, k),
        }))
    }

    /// Runs the call, and gives its folder.
    fn called(
        &self,
        text: &SceneText,
        leaves: Leaves,
        run: &RunContext,
    ) -> Result<Folder, AdapterError> {
        let request = self.request;
        let framing = Framing::of(request);
        let numbering = Numbering::of(request);
        let folder = Folder::new(run, &request.label, text)?;

        let antialias = if self.code.is_some() {
            None
        } else {
            request.antialias
        };
        let mut args = fixed_switches();
        args.extend(switches(framing, request.size, antialias));
        args.extend(numbering.args());
        args.extend(folder.library_switches(native_files(request))?);
        if let Some(threads) = run.threads {
            args.push(format!("+WT{threads}"));
        }
        if let Some(side) = self.side()?.filter(|side| *side != state::BLOCK) {
            args.push(format!("+BS{side}"));
        }
        args.extend(match leaves {
            Leaves::Layers => self.output_switches(),
            Leaves::Pictures(bits) => encoded_switches(bits),
        });
        if leaves == Leaves::Layers && self.source == LayerSource::StateFile {
            self.prepare_states(&folder, framing, numbering)?;
        }

        let call = ProcessCall {
            program: self.program,
            args,
            folder: folder.path(),
            doing: request.describe(),
            log: run.keep.then(|| folder.file("povray.log")),
        };
        run.tally.add_call(request.shots.len());
        call.run_well(run)?;
        if run.keep {
            remove_pictures(folder.path());
        }
        Ok(folder)
    }

    fn output_switches(&self) -> Vec<String> {
        let alpha = matches!(self.request.output, Output::ColourAlone { with_sky: false });
        let mut args = match self.source {
            LayerSource::StateFile => state_switches("layer"),
            LayerSource::Pictures if alpha => vec!["+FN16".into(), "+Olayer.png".into()],
            LayerSource::Pictures => vec!["+FP16".into(), "+Olayer.ppm".into()],
        };
        args.push(if alpha { "+UA".into() } else { "-UA".into() });
        if self.source == LayerSource::Pictures {
            args.push(if self.code.is_some() {
                "File_Gamma=1".into()
            } else {
                "File_Gamma=srgb".into()
            });
            let window = self.rendered();
            // Starts are 1-based; a 1 would be read as a share of the whole.
            if window.x > 0 {
                args.push(format!("+SC{}", window.x + 1));
            }
            if window.y > 0 {
                args.push(format!("+SR{}", window.y + 1));
            }
            if window.right() < self.request.size.width && !self.is_crop() {
                args.push(format!("+EC{}", window.right()));
            }
            if window.bottom() < self.request.size.height && !self.is_crop() {
                args.push(format!("+ER{}", window.bottom()));
            }
        }
        args
    }

    fn is_crop(&self) -> bool {
        Framing::of(self.request) != Framing::Full
    }

    /// The part of the full picture that all shots need, where it is the full
    /// picture's camera that renders them.
    fn rendered(&self) -> Window {
        if self.is_crop() {
            return Window::EMPTY;
        }
        let windows = self
            .request
            .shots
            .iter()
            .map(|shot| self.window(&shot.region));
        windows.fold(Window::EMPTY, Window::union)
    }

    /// The window of the picture that a shot's layer covers.
    fn window(&self, region: &Region) -> Window {
        window_of(region, self.request.size)
    }

    /// The size of the part that POV-Ray renders, and the numbers that the
    /// blocks of a region have there; `None` for a window.
    fn mask(&self, framing: Framing, region: &Region) -> Option<(Blocks, Size)> {
        let Region::Blocks(blocks) = region else {
            return None;
        };
        let (size, side) = (self.request.size, blocks.side);
        let Framing::Crop { cut, .. } = framing else {
            return Some((blocks.clone(), size));
        };
        let columns = |size: Size| size.width.div_ceil(side);
        let around = self.window(region);
        let (left, top) = (around.x / side, around.y / side);
        let moved = blocks.numbers.iter().map(|id| {
            let (column, row) = (id % columns(size), id / columns(size));
            (row - top) * columns(cut) + (column - left)
        });
        let moved = Blocks {
            side,
            numbers: moved.collect(),
        };
        Some((moved, cut))
    }

    /// The side of the blocks of all shots, where some are asked for.
    fn side(&self) -> Result<Option<u32>, AdapterError> {
        let shots = self.request.shots.iter();
        let mut sides = shots.filter_map(|shot| match &shot.region {
            Region::Blocks(blocks) => Some(blocks.side),
            Region::Window(_) => None,
        });
        let Some(side) = sides.next() else {
            return Ok(None);
        };
        let what = if sides.any(|other| other != side) {
            "blocks of several sides in one call".to_owned()
        } else if self.request.antialias.is_some() && side != state::BLOCK {
            format!("blocks of {side} pixels with antialiasing")
        } else if side < state::LEAST {
            format!("blocks of {side} pixels")
        } else {
            return Ok(Some(side));
        };
        Err(AdapterError::Unsupported {
            what,
            adapter: "povray".into(),
        })
    }

    fn prepare_states(
        &self,
        folder: &Folder,
        framing: Framing,
        numbering: Numbering,
    ) -> Result<(), AdapterError> {
        for (k, shot) in self.request.shots.iter().enumerate() {
            let mask = self.mask(framing, &shot.region);
            let says = |to: &mut dyn Write| match &mask {
                None => to.write_all(&state::empty()),
                Some((blocks, size)) => state::write_masked(to, *size, blocks),
            };
            keep_state(folder, "layer", &numbering.suffix(k), says)?;
        }
        Ok(())
    }

    /// Where the pixels of a shot are in what POV-Ray rendered.
    fn rendered_window(&self, window: Window) -> Window {
        if self.is_crop() {
            in_crop(window)
        } else {
            window
        }
    }

    /// Reads the picture of a shot, and removes it.
    fn picture(&self, folder: &Folder, bits: u8, k: usize) -> Result<Picture, AdapterError> {
        let window = self.window(&self.request.shots[k].region);
        let suffix = Numbering::of(self.request).suffix(k);
        let path = folder.file(&format!("layer{suffix}.ppm"));
        let rendered = self.rendered_window(window);
        let read = || picture::encoded(BufReader::new(File::open(&path)?), rendered, bits);
        let bytes = read().map_err(|error| bad(&path, &error))?;
        let _ = std::fs::remove_file(&path);
        Ok(Picture { window, bytes })
    }

    /// Reads what a frame's file has of a shot, from its state file.
    fn encoded(&self, folder: &Folder, bits: u8, k: usize) -> Result<Picture, AdapterError> {
        // Word by word: what a map of arrays becomes takes three times as long.
        let of_8 = |[red, green, blue, _]: [f32; 4]| {
            let byte = encode::srgb_8;
            [byte(red), byte(green), byte(blue)]
        };
        let of_16 = |[red, green, blue, _]: [f32; 4]| {
            let word = |value: f32| (encode::srgb(value, 65535) as u16).to_be_bytes();
            let ([r, s], [g, h], [b, c]) = (word(red), word(green), word(blue));
            [r, s, g, h, b, c]
        };
        let window = self.window(&self.request.shots[k].region);
        let bytes = if bits == 8 {
            self.stated(folder, k, [0; 3], of_8)?.into_flattened()
        } else {
            self.stated(folder, k, [0; 6], of_16)?.into_flattened()
        };
        Ok(Picture { window, bytes })
    }

    /// What `of` makes of the pixels of a shot in its state file; `empty` stands where
    /// nothing was asked for.
    fn stated<T: Clone>(
        &self,
        folder: &Folder,
        k: usize,
        empty: T,
        of: impl Fn([f32; 4]) -> T,
    ) -> Result<Vec<T>, AdapterError> {
        let region = &self.request.shots[k].region;
        let rendered = self.rendered_window(self.window(region));
        let suffix = Numbering::of(self.request).suffix(k);
        let (path, file) = take_state(folder, "layer", &suffix)?;
        let mask = self.mask(Framing::of(self.request), region);
        let wanted = match &mask {
            None => Wanted::All,
            Some((blocks, size)) => Wanted::Blocks(blocks, *size),
        };
        let pixels = state::pixels_as(file, rendered, wanted, empty, of);
        pixels.map_err(|error| bad(&path, &error))
    }

    fn read(&self, folder: &Folder, k: usize) -> Result<Layer, AdapterError> {
        let region = &self.request.shots[k].region;
        let window = self.window(region);
        let rendered = self.rendered_window(window);
        let suffix = Numbering::of(self.request).suffix(k);
        let colour = match self.source {
            LayerSource::StateFile => {
                if let Some(code) = self.code {
                    let depth = self.stated(folder, k, f64::INFINITY, |pixel| code.decode(pixel));
                    return Ok(self.depth(window, depth?, code));
                }
                self.stated(folder, k, [0.0; 4], |pixel| pixel)?
            }
            LayerSource::Pictures => {
                let alpha = matches!(self.request.output, Output::ColourAlone { with_sky: false });
                let ending = if alpha { "png" } else { "ppm" };
                let path = folder.file(&format!("layer{suffix}.{ending}"));
                let bytes = read_file(&path)?;
                let coding = if self.code.is_some() {
                    picture::Coding::Linear
                } else {
                    picture::Coding::Srgb
                };
                picture::pixels(&bytes, rendered, coding).map_err(|error| bad(&path, &error))?
            }
        };
        Ok(match self.code {
            Some(code) => {
                let depth = colour.iter().map(|&pixel| code.decode(pixel)).collect();
                self.depth(window, depth, code)
            }
            None => Layer {
                window,
                colour: Some(colour),
                depth: None,
                depth_quantum: (0.0, 0.0),
            },
        })
    }

    fn depth(&self, window: Window, depth: Vec<f64>, code: DepthCode) -> Layer {
        Layer {
            window,
            depth: Some(depth),
            colour: None,
            depth_quantum: code.quantum(self.source.precision()),
        }
    }
}

/// The switches of a call whose pixels are read from the state file. The picture itself
/// is not read: the format is the one that takes least time. At 1024 × 1024 a black
/// picture costs 0.06 s of CPU in all as RGBE, 0.11 as PNG, 0.13 as PPM.
pub fn state_switches(name: &str) -> Vec<String> {
    vec!["+FH".into(), format!("+O{name}.{SCRATCH}"), "+C".into()]
}

/// The ending of the picture beside a state file.
const SCRATCH: &str = "hdr";

/// The switches for frames in POV-Ray's own encoding.
fn encoded_switches(bits: u8) -> Vec<String> {
    vec![
        format!("+FP{bits}"),
        "+Olayer.ppm".into(),
        "-UA".into(),
        "File_Gamma=srgb".into(),
        // What is laid beside it is not dithered.
        "Dither=off".into(),
    ]
}

/// Writes the state file of the frame that POV-Ray names `name` and `suffix`.
/// POV-Ray takes over what it says, and deletes it when the frame is done: a
/// second link to it survives.
pub fn keep_state(
    folder: &Folder,
    name: &str,
    suffix: &str,
    says: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), AdapterError> {
    let path = folder.file(&format!("{name}{suffix}.pov-state"));
    let kept = folder.file(&format!("{name}{suffix}.kept"));
    let write = || {
        let mut file = BufWriter::with_capacity(BUFFER, File::create(&path)?);
        says(&mut file)?;
        file.flush()
    };
    write().map_err(AdapterError::io(&path))?;
    // In a kept folder there may be one of an earlier run.
    let _ = std::fs::remove_file(&kept);
    let _ = std::fs::remove_file(folder.file(&format!("{name}{suffix}.{SCRATCH}")));
    std::fs::hard_link(&path, &kept).map_err(AdapterError::io(&kept))
}

/// Opens what became of a state file, and removes it and its picture: frames
/// are many, and what was read of them is not kept.
pub fn take_state(
    folder: &Folder,
    name: &str,
    suffix: &str,
) -> Result<(PathBuf, BufReader<File>), AdapterError> {
    let path = folder.file(&format!("{name}{suffix}.kept"));
    let file = File::open(&path).map_err(|error| unreadable(&path, &error))?;
    let _ = std::fs::remove_file(&path);
    let _ = std::fs::remove_file(folder.file(&format!("{name}{suffix}.{SCRATCH}")));
    Ok((path, BufReader::with_capacity(BUFFER, file)))
}

/// Reads what POV-Ray wrote.
pub fn read_file(path: &Path) -> Result<Vec<u8>, AdapterError> {
    std::fs::read(path).map_err(|error| unreadable(path, &error))
}

fn unreadable(path: &Path, error: &std::io::Error) -> AdapterError {
    AdapterError::BadOutput {
        program: "povray".into(),
        file: path.to_owned(),
        reason: format!("it cannot be read: {error}"),
    }
}

fn bad(path: &Path, error: &dyn std::error::Error) -> AdapterError {
    AdapterError::BadOutput {
        program: "povray".into(),
        file: path.to_owned(),
        reason: error.to_string(),
    }
}

/// A kept folder holds text and logs; the renderer's intermediate pictures
/// would fill a disk.
fn remove_pictures(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|e| e == "pov-state") {
            let _ = std::fs::remove_file(path);
        }
    }
}
