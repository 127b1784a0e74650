//! One call of POV-Ray: its switches, and the frames' pixels out of its folder.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;

use decor_api::process::ProcessCall;
use decor_api::{
    AdapterError, Blocks, Layer, LayerRequest, Output, Picture, Region, Rendered, RunContext,
    SceneText, Size, Window,
};

use crate::depth::{DepthCode, Precision};
use crate::folder::{Folder, keep_state, native_files, read_file, state_switches, take_state};
use crate::scene_text::{Framing, MAIN, Numbering, in_crop, switches, window_of};
use crate::state::{self, Wanted};
use crate::{encode, picture};

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
            folder.remove_pictures();
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

fn bad(path: &Path, error: &dyn std::error::Error) -> AdapterError {
    AdapterError::BadOutput {
        program: "povray".into(),
        file: path.to_owned(),
        reason: error.to_string(),
    }
}
