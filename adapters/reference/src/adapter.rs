//! The adapter: requests in, layers out.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use decor_api::{
    Abilities, Adapter, AdapterError, ArrivalRequest, Baseline, BlockMask, DepthKind, Health,
    Layer, LayerRequest, LayerShot, Output, Region, RunContext, Scene, SceneText, encode, health,
};

use crate::arrival;
use crate::model::Models;
use crate::picture::Frame;
use crate::shade::Shader;
use crate::world::World;

/// The side of the blocks of [`Region::Blocks`], in pixels.
pub use decor_api::BLOCK;

const NAME: &str = "reference";

/// The in-process ray caster. It needs no installation and holds no state.
#[derive(Clone, Debug)]
pub struct Reference {
    abilities: Abilities,
}

impl Default for Reference {
    fn default() -> Self {
        Self {
            abilities: Abilities {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                csg: true,
                fragments: &[],
                depth_with_colour: true,
                depth: DepthKind::AlongRay,
                sample_position: (0.5, 0.5),
                crop_grid: Some(BLOCK),
                block_mask: true,
                // It draws pixel by pixel.
                finest_block: 1,
                masks_in_crops: true,
                hidden_casters: true,
                ray_list: true,
                coverage: true,
                shadows: true,
                optics: true,
                // One call already uses every core.
                jobs: 1,
                call_overhead_s: 0.0,
                picture_cpu_s: 0.0,
                units: "scene units; lights fade only where the film says so",
            },
        }
    }
}

impl Reference {
    /// The adapter.
    pub fn new() -> Self {
        Self::default()
    }

    fn layer(
        &self,
        models: &Models,
        request: &LayerRequest<'_>,
        shot: &LayerShot,
        watch: &Watch<'_>,
    ) -> Result<Layer, AdapterError> {
        let seen = World::new(models, &shot.scene)?;
        // Depth takes no notice of what is hidden.
        let all = if shot.scene.hidden.is_empty() || request.output == Output::Depth {
            None
        } else {
            Some(World::with_hidden(models, &shot.scene)?)
        };
        let frame = Frame {
            shader: Shader {
                seen: &seen,
                world: all.as_ref().unwrap_or(&seen),
                scene: &shot.scene,
            },
            camera: &shot.scene.camera,
            size: request.size,
            output: request.output,
            antialias: request.antialias,
        };
        let may_go_on = || watch.may_go_on(shot.frame);
        match &shot.region {
            Region::Window(window) => {
                if window.intersection(request.size.window()) != *window && !window.is_empty() {
                    return Err(unsupported(format!("{window:?}: the picture is smaller")));
                }
                frame.draw(*window, &|_, _| true, &may_go_on)
            }
            Region::Blocks(blocks) => {
                let mask = BlockMask::new(blocks, request.size).map_err(unsupported)?;
                frame.draw(mask.window(), &|x, y| mask.contains(x, y), &may_go_on)
            }
        }
    }
}

impl Adapter for Reference {
    fn name(&self) -> &'static str {
        NAME
    }

    fn abilities(&self) -> &Abilities {
        &self.abilities
    }

    fn scene_text(&self, request: &LayerRequest<'_>) -> Result<SceneText, AdapterError> {
        let scenes = || request.shots.iter().map(|shot| &*shot.scene);
        scenes().try_for_each(refuse_native)?;
        Models::prepare(request.prototypes, scenes())?;
        Ok(SceneText { files: Vec::new() })
    }

    fn render(
        &self,
        request: &LayerRequest<'_>,
        run: &RunContext,
    ) -> Result<Vec<Layer>, AdapterError> {
        let scenes = || request.shots.iter().map(|shot| &*shot.scene);
        scenes().try_for_each(refuse_native)?;
        let models = Models::prepare(request.prototypes, scenes())?;
        let watch = Watch {
            run,
            started: Instant::now(),
        };
        run.tally.add_call(request.shots.len());
        with_threads(run, || {
            let shots = request.shots.iter();
            shots
                .map(|shot| self.layer(&models, request, shot, &watch))
                .collect()
        })
    }

    fn arriving_light(
        &self,
        request: &ArrivalRequest<'_>,
        run: &RunContext,
    ) -> Result<Vec<Vec<[f32; 3]>>, AdapterError> {
        if let Some(file) = request.includes.first() {
            return Err(AdapterError::native(NAME, file));
        }
        let watch = Watch {
            run,
            started: Instant::now(),
        };
        run.tally.add_call(request.shots.len());
        with_threads(run, || {
            arrival::fractions(request, &|frame| watch.may_go_on(frame))
        })
    }

    fn baseline(
        &self,
        request: &Baseline<'_>,
        run: &RunContext,
    ) -> Result<Vec<(u32, PathBuf)>, AdapterError> {
        let folder = run.work.join("reference");
        std::fs::create_dir_all(&folder).map_err(AdapterError::io(&folder))?;
        let scenes = || request.frames.iter().map(|(_, scene)| &**scene);
        scenes().try_for_each(refuse_native)?;
        let models = Models::prepare(request.prototypes, scenes())?;
        let watch = Watch {
            run,
            started: Instant::now(),
        };
        run.tally.add_call(request.frames.len());
        with_threads(run, || {
            let mut files = Vec::with_capacity(request.frames.len());
            for (frame, scene) in &request.frames {
                let shot = LayerShot {
                    frame: *frame,
                    scene: Arc::clone(scene),
                    region: Region::Window(request.size.window()),
                };
                let whole = LayerRequest {
                    prototypes: request.prototypes,
                    size: request.size,
                    output: Output::ColourOverBackground,
                    antialias: request.antialias,
                    film: Some(request.film),
                    shots: Vec::new(),
                    label: String::new(),
                };
                let layer = self.layer(&models, &whole, &shot, &watch)?;
                let ending = request.format.extension();
                let file = folder.join(format!("baseline_{frame:04}.{ending}"));
                encode::write(&layer, request.size, request.format, &file, NAME)?;
                files.push((*frame, file));
            }
            Ok(files)
        })
    }

    fn encode(&self, linear: f32, max: u32) -> u32 {
        encode::step(linear, max)
    }

    fn health(&self, run: &RunContext) -> Health {
        let depth = health::depth(self, run, 1e-9).map_err(|e| e.to_string());
        Health {
            program: None,
            version: Some(self.abilities.version.clone()),
            checks: vec![("the depth of a sphere".to_owned(), depth)],
            install: "nothing: it is part of decor".to_owned(),
        }
    }
}

/// Something that it cannot draw.
pub(crate) fn unsupported(what: String) -> AdapterError {
    AdapterError::Unsupported {
        adapter: NAME.to_owned(),
        what,
    }
}

fn refuse_native(scene: &Scene) -> Result<(), AdapterError> {
    match scene.includes.iter().chain(&scene.sky).next() {
        Some(file) => Err(AdapterError::native(NAME, file)),
        None => Ok(()),
    }
}

/// Runs `work` with as many threads as the run allows.
fn with_threads<T: Send>(
    run: &RunContext,
    work: impl FnOnce() -> Result<T, AdapterError> + Send,
) -> Result<T, AdapterError> {
    let Some(threads) = run.threads else {
        return work();
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.max(1))
        .build()
        .map_err(|error| AdapterError::Start {
            program: format!("{threads} threads"),
            source: std::io::Error::other(error),
        })?;
    pool.install(work)
}

/// Ends a call that was stopped, or that takes too long.
struct Watch<'a> {
    run: &'a RunContext,
    started: Instant,
}

impl Watch<'_> {
    fn may_go_on(&self, frame: u32) -> Result<(), AdapterError> {
        if self.run.is_cancelled() {
            return Err(AdapterError::Cancelled);
        }
        if self.started.elapsed() > self.run.timeout {
            return Err(AdapterError::TimedOut {
                program: format!("the {NAME} adapter"),
                doing: format!("frame {frame}"),
                limit: self.run.timeout,
                stderr: String::new(),
            });
        }
        Ok(())
    }
}
