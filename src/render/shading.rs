//! The calls behind shadow maps: the décor light by light, once a period, and in
//! every frame the light that arrives.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use decor_api::{
    ArrivalRequest, ArrivalShot, Bounds, Camera, Instance, Layer, LightKind, Output, Region,
    RunContext, Scene, SurfacePoint,
};

use super::RenderError;
use super::execution::{Execution, only};
use super::ground::PeriodGround;
use super::influenced::Blocks;
use super::shown::decor_objects;
use crate::film::{FrameState, ObjectId};
use crate::influence::{Cause, Mask, may_shade};
use crate::plan::{FramePlan, Period};
use crate::shadow::{LightLayers, Shade};

/// The décor light by light, for those lights that something fast can block.
pub type Lighting = Vec<LightLayers>;

/// The shaded pixels of some frames.
pub type Shades = HashMap<u32, Shade>;

/// Of one pixel in question: its index, and what it is lit by.
struct Asked<'a> {
    index: u32,
    colour: [f32; 4],
    lighting: &'a Lighting,
}

impl Execution<'_> {
    /// A picture of a period's décor light by light.
    pub fn lighting(
        &self,
        period: &Period,
        scene: &Scene,
        frame: u32,
    ) -> Result<Lighting, RenderError> {
        let fast = fast_bounds(self, period);
        let kept: Vec<Bounds> = scene
            .instances
            .iter()
            .map(|i| {
                self.stage
                    .library
                    .table
                    .get(i.prototype)
                    .bounds
                    .posed(&i.pose)
            })
            .collect();
        let blocked = |light: &decor_api::Light| {
            let may = |caster: &Bounds| kept.iter().any(|to| may_shade(light, caster, to));
            fast.iter().any(may)
        };
        let lights: Vec<usize> = (0..scene.lights.len())
            .filter(|&k| blocked(&scene.lights[k]))
            .collect();
        if lights.is_empty() {
            return Ok(Vec::new());
        }
        let picture = |lights: Vec<decor_api::Light>, shadows: bool, label: String| {
            let scene = Arc::new(Scene {
                lights,
                shadows,
                ..scene.clone()
            });
            let size = self.stage.size();
            let region = Region::Window(size.window());
            let colour = Output::ColourOverBackground;
            self.traced
                .shadow
                .fetch_add(size.pixels() as u64, Ordering::Relaxed);
            let request = self.request_of(frame, &scene, &region, colour, label);
            Ok::<Layer, RenderError>(only(self.call(&request, None)?)?)
        };
        let dark = picture(Vec::new(), scene.shadows, format!("dark_{frame:04}"))?;
        let mut all = Vec::new();
        for k in lights {
            let light = scene.lights[k];
            let lit = picture(vec![light], true, format!("light_{k}_{frame:04}"))?;
            let has_area = matches!(light.kind, LightKind::Area { .. });
            let unshaded = has_area
                .then(|| picture(vec![light], false, format!("unshaded_{k}_{frame:04}")))
                .transpose()?;
            all.push(LightLayers::new(k, &dark, &lit, unshaded.as_ref()));
        }
        Ok(all)
    }

    /// The pixels of some frames that what moves shades.
    pub fn shades(
        &self,
        period: &Period,
        frames: Range<u32>,
        ground: &PeriodGround,
        masks: &HashMap<u32, Mask>,
        blocks: &Blocks,
    ) -> Result<Shades, RenderError> {
        let mut asked: HashMap<u32, Vec<Asked<'_>>> = HashMap::new();
        let mut shots = Vec::new();
        // Of each shot: its frame, its light, and which pixels its points are.
        let mut about: Vec<(u32, usize, Vec<usize>)> = Vec::new();
        for number in frames.clone() {
            let is_mapped = matches!(
                period.frames[(number - period.start) as usize],
                FramePlan::Layered { shadows: Some(plan), .. } if plan.by_map
            );
            let (true, Some(mask)) = (is_mapped, masks.get(&number)) else {
                continue;
            };
            let state = self.stage.film.frame(number);
            let (pixels, points) = self.questioned(ground, number, mask, blocks);
            let casters = self.casters(period, &state);
            for (k, light) in state.lights.iter().enumerate() {
                let reached: Vec<usize> = (0..pixels.len())
                    .filter(|&p| {
                        let lighting = pixels[p].lighting;
                        lighting.iter().any(|l| l.light == k) && light.may_reach(points[p].position)
                    })
                    .collect();
                if reached.is_empty() {
                    continue;
                }
                let has_area = matches!(light.kind, LightKind::Area { .. });
                shots.push(ArrivalShot {
                    frame: number,
                    light: *light,
                    casters: if has_area {
                        casters.all.clone()
                    } else {
                        casters.fast.clone()
                    },
                    points: reached.iter().map(|&p| points[p]).collect(),
                });
                self.traced
                    .shadow
                    .fetch_add(reached.len() as u64, Ordering::Relaxed);
                about.push((number, k, reached));
            }
            asked.insert(number, pixels);
        }
        let mut changed: HashMap<u32, Vec<[f32; 4]>> = asked
            .iter()
            .map(|(number, pixels)| (*number, pixels.iter().map(|p| p.colour).collect()))
            .collect();
        if !shots.is_empty() {
            let request = ArrivalRequest {
                prototypes: &self.stage.library.table,
                includes: self.stage.includes(),
                shots,
                label: format!("arrival_{:04}", frames.start),
            };
            let _slot = self.slots.take();
            let run = RunContext {
                threads: Some(1),
                ..self.run.clone()
            };
            let shares = self.stage.adapter.arriving_light(&request, &run)?;
            for ((number, light, reached), shares) in about.into_iter().zip(shares) {
                let (Some(pixels), Some(colours)) = (asked.get(&number), changed.get_mut(&number))
                else {
                    continue;
                };
                for (p, share) in reached.into_iter().zip(shares) {
                    let pixel = &pixels[p];
                    for layers in pixel.lighting.iter().filter(|l| l.light == light) {
                        let change = layers.change(pixel.index as usize, share);
                        for (colour, change) in colours[p].iter_mut().zip(change) {
                            *colour += change;
                        }
                    }
                }
            }
        }
        let shade = |(number, pixels): (u32, Vec<Asked<'_>>)| {
            let colours = changed.remove(&number).unwrap_or_default();
            let pixels = pixels.iter().zip(colours);
            let pixels = pixels.map(|(pixel, colour)| (pixel.index, colour));
            (number, Shade::new(pixels.collect()))
        };
        Ok(asked.into_iter().map(shade).collect())
    }

    /// The pixels of a frame that may be shaded, and the places of their
    /// surfaces. Those in blocks are rendered anyway.
    fn questioned<'g>(
        &self,
        ground: &'g PeriodGround,
        number: u32,
        mask: &Mask,
        blocks: &Blocks,
    ) -> (Vec<Asked<'g>>, Vec<SurfacePoint>) {
        let size = self.stage.size();
        let (first, last) = (ground.view.camera, ground.view.target_camera);
        let (mut pixels, mut points) = (Vec::new(), Vec::new());
        for y in 0..size.height {
            for x in 0..size.width {
                let drawn = || blocks.get(&number).is_some_and(|b| b.has_pixel(x, y));
                if !mask.has(x, y, Cause::Shadowed) || drawn() {
                    continue;
                }
                let Some(seen) = ground.pixel(number, x, y) else {
                    continue;
                };
                let camera: Camera = match last {
                    Some(last) if seen.is_target => last,
                    _ => first,
                };
                if !seen.depth.is_finite() {
                    continue;
                }
                let ray = camera.direction(size, f64::from(x) + 0.5, f64::from(y) + 0.5);
                let (fx, fy) = camera.focal(size);
                points.push(SurfacePoint {
                    position: camera.eye + ray.normalize() * seen.depth,
                    footprint: seen.depth / fx.min(fy),
                });
                pixels.push(Asked {
                    index: y * size.width + x,
                    colour: seen.colour,
                    lighting: seen.lighting,
                });
            }
        }
        (pixels, points)
    }

    fn casters(&self, period: &Period, state: &FrameState<'_>) -> Casters {
        let kept = decor_objects(period);
        // The décor has the shadows of what rests.
        let fast = self.stage.scene(state, |object| {
            !kept.contains(&object.id) && !period.resting.contains(&object.id)
        });
        let all = self.stage.scene(state, |_| true);
        Casters {
            fast: fast.instances.into(),
            all: all.instances.into(),
        }
    }
}

struct Casters {
    fast: Arc<[Instance]>,
    all: Arc<[Instance]>,
}

/// What moves in a period, in each of its frames.
fn fast_bounds(execution: &Execution<'_>, period: &Period) -> Vec<Bounds> {
    let fast: HashSet<ObjectId> = period
        .objects
        .iter()
        .filter(|o| period.is_moving(o))
        .map(|o| o.object)
        .collect();
    let mut bounds = Vec::new();
    for number in period.numbers() {
        for object in &execution.stage.film.frame(number).objects {
            if fast.contains(&object.id) {
                bounds.push(execution.stage.prototype(object).bounds.posed(&object.pose));
            }
        }
    }
    bounds
}
