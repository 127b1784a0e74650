//! Calls of Mitsuba: a folder of their own, the scene's files in it, and the
//! layers out of the pictures.

use std::path::{Path, PathBuf};

use decor_api::process::ProcessCall;
use decor_api::{AdapterError, Layer, LayerRequest, Output, RunContext};

use crate::picture::{Picture, size_of};
use crate::scene_text::{Pass, Rendered, Script, Take};

/// Files a call: their names must fit on a command line.
const MOST_FILES: usize = 500;

/// How exact depth is, relative to the distance: single precision, with what a
/// few operations lose.
const DEPTH_PRECISION: f64 = 1e-6;

/// How much farther apart two surfaces are along a ray than across: of a ray
/// that meets them at 30°.
const SLANT: f64 = 2.0;

/// One request and where it runs.
pub(crate) struct LayerCall<'a> {
    pub program: &'a Path,
    pub request: &'a LayerRequest<'a>,
    pub script: &'a Script,
}

impl LayerCall<'_> {
    /// Renders everything; one layer a shot.
    pub fn run(&self, run: &RunContext) -> Result<Vec<Layer>, AdapterError> {
        let folder = Folder::new(run, &self.request.label, &self.script.files)?;
        let names: Vec<&Rendered> = self.script.takes.iter().flat_map(|t| &t.passes).collect();
        let frames = self.script.takes.len();
        for (k, part) in names.chunks(MOST_FILES).enumerate() {
            let call = ProcessCall {
                program: self.program,
                args: arguments(run, part),
                folder: &folder.path,
                doing: self.doing(),
                log: run.keep.then(|| folder.file(&format!("mitsuba_{k}.log"))),
            };
            run.tally.add_call(if k == 0 { frames } else { 0 });
            call.run_well(run)?;
        }
        let takes = self.script.takes.iter().zip(&self.request.shots);
        takes
            .map(|(take, shot)| {
                let layer = match self.request.output {
                    Output::Depth => depth(take, &folder),
                    output => self.colour(take, &folder, output, shot.scene.background.0),
                };
                folder.forget_pictures(take);
                layer
            })
            .collect()
    }

    fn doing(&self) -> String {
        let pass = match self.request.output {
            Output::Depth => "depth",
            _ => "colour",
        };
        let frames = self.script.takes.iter().map(|take| take.frame);
        match (frames.clone().min(), frames.max()) {
            (Some(first), Some(last)) if first != last => {
                format!("{pass} of frames {first} to {last}")
            }
            (Some(first), _) => format!("{pass} of frame {first}"),
            _ => pass.to_owned(),
        }
    }

    fn colour(
        &self,
        take: &Take,
        folder: &Folder,
        output: Output,
        background: [f64; 3],
    ) -> Result<Layer, AdapterError> {
        let window = take.window;
        let mut sums = vec![[0.0_f64; 4]; window.pixels()];
        let uniform = self.script.ambient.uniform();
        for rendered in &take.passes {
            let side = match rendered.pass {
                Pass::Looks => self.script.per_side,
                _ => 1,
            };
            let picture = folder.picture(rendered, take, side)?;
            let is_looks = rendered.pass == Pass::Looks;
            for (sum, (x, y)) in sums.iter_mut().zip(places(take)) {
                let found = if is_looks {
                    self.shining(&picture, x, y, side)
                } else {
                    picture.pixel(x, y).map(f64::from)
                };
                for (sum, found) in sum.iter_mut().zip(found).take(3) {
                    *sum += found;
                }
                // The same in every picture.
                sum[3] = found[3];
            }
        }
        let told = take.passes.iter().any(|r| r.pass == Pass::Looks);
        let ambient = uniform.filter(|_| !told).unwrap_or_default();
        let behind = match output {
            Output::ColourOverBackground => Some(background),
            _ => None,
        };
        let finished = |[r, g, b, coverage]: [f64; 4]| {
            let mut colour = [r, g, b];
            for (k, channel) in colour.iter_mut().enumerate() {
                *channel += f64::from(ambient[k]) * coverage;
                *channel += behind.map_or(0.0, |behind| behind[k] * (1.0 - coverage));
            }
            let [r, g, b] = colour.map(|c| c as f32);
            let coverage = if behind.is_some() { 1.0 } else { coverage };
            [r, g, b, coverage as f32]
        };
        Ok(Layer {
            window,
            colour: Some(sums.into_iter().map(finished).collect()),
            depth: None,
            depth_quantum: (0.0, 0.0),
        })
    }

    /// What shines by itself in a pixel, and how much of it is covered: the mean
    /// of its samples.
    fn shining(&self, picture: &Picture, x: u32, y: u32, side: u32) -> [f64; 4] {
        let mut sum = [0.0; 4];
        for (i, j) in (0..side).flat_map(|j| (0..side).map(move |i| (i, j))) {
            let sample = picture.pixel(x * side + i, y * side + j);
            let coverage = f64::from(sample[3]);
            let [r, g, b] = self.script.ambient.of(sample).map(f64::from);
            for (sum, value) in sum.iter_mut().zip([r, g, b, 1.0]) {
                *sum += value * coverage;
            }
        }
        sum.map(|v| v / f64::from(side * side))
    }
}

/// Mitsuba hangs for ever in its writer with one or two threads.
fn arguments(run: &RunContext, files: &[&Rendered]) -> Vec<String> {
    let threads = run.threads.unwrap_or_else(cores).max(4);
    let mut args: Vec<String> = ["-m", "scalar_rgb", "-t"].map(String::from).to_vec();
    args.push(threads.to_string());
    args.extend(files.iter().map(|file| format!("{}.xml", file.name)));
    args
}

pub(crate) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Where the pixels of a take's window are in its pictures.
fn places(take: &Take) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (window, drawn) = (take.window, take.drawn);
    (window.y..window.bottom())
        .flat_map(move |y| (window.x..window.right()).map(move |x| (x - drawn.x, y - drawn.y)))
}

fn depth(take: &Take, folder: &Folder) -> Result<Layer, AdapterError> {
    let depth = match take.passes.first() {
        None => vec![f64::INFINITY; take.window.pixels()],
        Some(rendered) => {
            let picture = folder.picture(rendered, take, 1)?;
            let pixels = places(take).map(|(x, y)| {
                let [t, _, _, coverage] = picture.pixel(x, y);
                let t = if coverage > 0.0 { t } else { 0.0 };
                let (x, y) = (x + take.drawn.x, y + take.drawn.y);
                take.sensor.distance(x, y, t)
            });
            pixels.collect()
        }
    };
    Ok(Layer {
        window: take.window,
        colour: None,
        depth: Some(depth),
        depth_quantum: (SLANT * take.deviation, DEPTH_PRECISION),
    })
}

/// A folder for a call. It goes with the value, unless it is kept.
struct Folder {
    path: PathBuf,
    keep: bool,
    _temporary: Option<tempfile::TempDir>,
}

impl Folder {
    fn new(
        run: &RunContext,
        label: &str,
        files: &[(String, Vec<u8>)],
    ) -> Result<Self, AdapterError> {
        let folder = if run.keep {
            let path = run.work.join(label);
            std::fs::create_dir_all(&path).map_err(AdapterError::io(&path))?;
            Self {
                path,
                keep: true,
                _temporary: None,
            }
        } else {
            let temporary = tempfile::Builder::new()
                .prefix(&format!("{label}-"))
                .tempdir_in(&run.work)
                .map_err(AdapterError::io(&run.work))?;
            Self {
                path: temporary.path().to_owned(),
                keep: false,
                _temporary: Some(temporary),
            }
        };
        for (name, bytes) in files {
            let path = folder.file(name);
            std::fs::write(&path, bytes).map_err(AdapterError::io(&path))?;
        }
        Ok(folder)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    fn picture(
        &self,
        rendered: &Rendered,
        take: &Take,
        enlarged: u32,
    ) -> Result<Picture, AdapterError> {
        let path = self.file(&format!("{}.exr", rendered.name));
        Picture::read(&path, size_of(take.drawn, enlarged))
    }

    /// Frames are many, and a kept folder is for scene files and logs.
    fn forget_pictures(&self, take: &Take) {
        for rendered in &take.passes {
            let _ = std::fs::remove_file(self.file(&format!("{}.exr", rendered.name)));
            if !self.keep {
                let _ = std::fs::remove_file(self.file(&format!("{}.xml", rendered.name)));
            }
        }
    }
}
