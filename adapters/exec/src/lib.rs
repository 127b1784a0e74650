//! decor's adapter for any program that speaks its JSON protocol:
//! `--renderer 'exec:PROGRAM ARGUMENTS'`. Nothing of decor is rebuilt for it.
//!
//! ```text
//! LayerRequest ─ translate ─→ protocol::Render ─ JSON on stdin ─→ PROGRAM
//! Layer ←─ picture ←─ OpenEXR files in a folder   JSON on stdout ←─┘
//! ```
//!
//! Every call is a process of its own, with one object on its stdin and one on
//! its stdout. It starts with `hello`: the program says what it can do, and is
//! then held to it. Whatever it does wrong (it hangs, dies, answers something
//! else, writes another picture than was asked for) is an error that names it.
//!
//! `docs/adapters.md` describes the protocol for who writes such a program;
//! [`protocol`] has its types; `example/` has one in Python.

mod answer;
mod call;
mod picture;
pub mod protocol;
mod translate;

use std::path::{Path, PathBuf};
use std::time::Duration;

use decor_api::{
    Abilities, Adapter, AdapterError, Baseline, DepthKind, Health, Layer, LayerRequest, LayerShot,
    Output, RunContext, SceneText, encode, health,
};

use crate::call::Command;
use crate::protocol::Reply;

/// How `--renderer` begins for such a program.
pub const PREFIX: &str = "exec:";

/// What to do where there is none.
pub const INSTALL: &str = "name a program that speaks the protocol of docs/adapters.md: \
                           --renderer 'exec:PROGRAM ARGUMENTS'";

const NAME: &str = "exec";

/// How long a program may take to say hello.
const PATIENCE: Duration = Duration::from_secs(30);

/// Half a step of the 32-bit floats that depth is written with, as a share.
const SINGLE: f64 = 6e-8;

/// A program behind decor.
#[derive(Clone, Debug)]
pub struct Exec {
    command: Command,
    can: protocol::Abilities,
    abilities: Abilities,
}

impl Exec {
    /// The program of a command line (`python3 'my renderer.py' --fast`), asked
    /// who it is. Quotes are a shell's; nothing else is.
    ///
    /// # Errors
    /// [`AdapterError::Missing`] where there is no such program; else what goes
    /// wrong when it is asked.
    pub fn find(command: &str) -> Result<Self, AdapterError> {
        let command = Command::parse(command)?;
        let folder = std::env::temp_dir();
        let mut run = RunContext::new(folder);
        run.timeout = PATIENCE;
        let hello = protocol::Ask::Hello {
            protocol: protocol::VERSION,
        };
        match command.ask(&hello, "its abilities", &run)? {
            Reply::Hello {
                name,
                version,
                abilities,
                ..
            } => {
                let program = command.name();
                let this = Self::new(command, format!("{name} {version}").trim(), abilities);
                this.check()
                    .map_err(|why| answer::nonsense(&program, &why))?;
                Ok(this)
            }
            other => Err(command.unexpected(other)),
        }
    }

    /// The program at `path`, whose abilities are known: it is not called.
    pub fn at(path: &Path, version: &str, abilities: protocol::Abilities) -> Self {
        Self::new(Command::new(path.to_owned()), version, abilities)
    }

    fn new(command: Command, version: &str, can: protocol::Abilities) -> Self {
        let abilities = Abilities {
            version: version.to_owned(),
            csg: can.csg,
            fragments: &[],
            depth_with_colour: false,
            depth: DepthKind::AlongRay,
            sample_position: (can.sample_position[0], can.sample_position[1]),
            crop_grid: can.crop_grid,
            block_mask: can.block_mask,
            // The protocol counts blocks of this side.
            finest_block: translate::BLOCK,
            // It is asked for the window around them.
            masks_in_crops: can.block_mask,
            hidden_casters: can.hidden_casters,
            ray_list: false,
            coverage: can.coverage,
            shadows: can.shadows,
            optics: can.optics,
            jobs: can.jobs,
            call_overhead_s: can.call_overhead_s,
            picture_cpu_s: can.picture_cpu_s,
            // One for each program of a run: there are few.
            units: Box::leak(can.units.clone().into_boxed_str()),
        };
        Self {
            command,
            can,
            abilities,
        }
    }

    /// The program.
    pub fn program(&self) -> &Path {
        self.command.program()
    }

    /// Are the abilities such as there can be?
    fn check(&self) -> Result<(), String> {
        let can = &self.can;
        let share = |v: f64| (0.0..=1.0).contains(&v);
        let wrong = if self.abilities.version.trim().is_empty() {
            "its name and version are empty".to_owned()
        } else if can.jobs == 0 {
            "jobs is 0".to_owned()
        } else if !(can.call_overhead_s >= 0.0 && can.call_overhead_s.is_finite()) {
            format!("call_overhead_s is {}", can.call_overhead_s)
        } else if !(can.picture_cpu_s >= 0.0 && can.picture_cpu_s.is_finite()) {
            format!("picture_cpu_s is {}", can.picture_cpu_s)
        } else if !can.sample_position.into_iter().all(share) {
            format!("sample_position is {:?}", can.sample_position)
        } else if !can.depth_quantum.iter().all(|q| *q >= 0.0 && q.is_finite()) {
            format!("depth_quantum is {:?}", can.depth_quantum)
        } else if can.crop_grid == Some(0) {
            "crop_grid is 0".to_owned()
        } else if can.block_mask
            && !can
                .crop_grid
                .is_some_and(|g| translate::BLOCK.is_multiple_of(g))
        {
            format!(
                "block_mask needs a crop_grid that divides {}",
                translate::BLOCK
            )
        } else {
            return Ok(());
        };
        Err(wrong)
    }

    fn refused(&self, what: String) -> AdapterError {
        AdapterError::Unsupported {
            adapter: format!("{NAME} ({})", self.command.name()),
            what,
        }
    }

    fn quantum(&self) -> (f64, f64) {
        let [absolute, relative] = self.can.depth_quantum;
        (absolute, relative.max(SINGLE))
    }
}

impl Adapter for Exec {
    fn name(&self) -> &'static str {
        NAME
    }

    fn abilities(&self) -> &Abilities {
        &self.abilities
    }

    /// The object that the program is asked, but for the folder and the number
    /// of threads, which are the run's.
    fn scene_text(&self, request: &LayerRequest<'_>) -> Result<SceneText, AdapterError> {
        if let Some(what) = translate::obstacle(request, &self.can) {
            return Err(self.refused(what));
        }
        let ask = translate::render(request, &self.can, PathBuf::from("."), None);
        let json = call::json(&protocol::Ask::Render(Box::new(ask)), &self.command)?;
        Ok(SceneText {
            files: vec![("request.json".to_owned(), json)],
        })
    }

    fn render(
        &self,
        request: &LayerRequest<'_>,
        run: &RunContext,
    ) -> Result<Vec<Layer>, AdapterError> {
        if let Some(what) = translate::obstacle(request, &self.can) {
            return Err(self.refused(what));
        }
        if run.is_cancelled() {
            return Err(AdapterError::Cancelled);
        }
        let folder = call::Folder::new(run, &request.label)?;
        let ask = translate::render(request, &self.can, folder.path().to_owned(), run.threads);
        let layers = ask.shots.len();
        if layers > 0 {
            run.tally.add_call(layers);
            let ask = protocol::Ask::Render(Box::new(ask));
            if run.keep {
                folder.write("request.json", &call::json(&ask, &self.command)?)?;
            }
            match self.command.ask(&ask, &request.describe(), run)? {
                Reply::Done { layers: done, .. } if done == layers => {}
                Reply::Done { layers: done, .. } => {
                    let why = format!("it drew {done} layers of {layers}");
                    return Err(answer::nonsense(&self.command.name(), &why));
                }
                Reply::Unsupported { what, .. } => return Err(self.refused(what)),
                other => return Err(self.command.unexpected(other)),
            }
        }
        let shots = request.shots.iter().enumerate();
        shots
            .map(|(k, shot)| self.layer(request, shot, &folder.file(&translate::file(k))))
            .collect()
    }

    /// Whole frames in one call, encoded by decor: the program writes layers
    /// alone.
    fn baseline(
        &self,
        request: &Baseline<'_>,
        run: &RunContext,
    ) -> Result<Vec<(u32, PathBuf)>, AdapterError> {
        encode::baseline(self, request, run)
    }

    fn encode(&self, linear: f32, max: u32) -> u32 {
        encode::step(linear, max)
    }

    fn health(&self, run: &RunContext) -> Health {
        let (absolute, relative) = self.quantum();
        let limit = absolute + 5.0 * relative;
        let depth = health::depth(self, run, limit).map_err(|e| e.to_string());
        Health {
            program: Some(self.program().to_owned()),
            version: Some(self.abilities.version.clone()),
            checks: vec![("the depth of a sphere".to_owned(), depth)],
            install: INSTALL.to_owned(),
        }
    }
}

impl Exec {
    fn layer(
        &self,
        request: &LayerRequest<'_>,
        shot: &LayerShot,
        file: &Path,
    ) -> Result<Layer, AdapterError> {
        let window = translate::window(request, &shot.region);
        let depth = request.output == Output::Depth;
        let (colour, depth) = if window.is_empty() {
            ((!depth).then(Vec::new), depth.then(Vec::new))
        } else {
            match picture::read(file, window, request.output) {
                Ok(picture::Pixels::Colour(pixels)) => (Some(pixels), None),
                Ok(picture::Pixels::Depth(depths)) => (None, Some(depths)),
                Err(reason) => {
                    return Err(AdapterError::BadOutput {
                        program: self.command.name(),
                        file: file.to_owned(),
                        reason,
                    });
                }
            }
        };
        Ok(Layer {
            window,
            colour,
            depth,
            depth_quantum: self.quantum(),
        })
    }
}
