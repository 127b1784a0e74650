//! Which blocks moving objects can touch in a frame, by geometry: where their
//! boxes are seen, and where the shadows of their boxes can be.
//!
//! It knows a plain perspective camera and lights that are points; mirrors and
//! what bends rays are dirty wherever their boxes are seen. Where a scene has
//! more than that, it says so, and POV-Ray's proxies alone decide ([`super::proxy`]).
//! It is generous: boxes for objects, hulls for what is seen of them, and
//! [`MARGIN_PX`] around. So a block is dirty only if both agree.

use glam::{DVec2, DVec3};

use super::analysis::{Analysis, Kind};
use super::blocks::{Blocks, Grid};
use super::boxes::{Extent, FrameBoxes};
use super::hulls::Hulls;
use super::solid::{Solid, corners};
use super::view::{Rectangle, View, touches};

/// Around a block: pixels are sampled up to half a pixel from their centres,
/// and boxes are of single precision.
const MARGIN_PX: f64 = 3.0;

/// So far away shadows end, in units of the scene: as far as POV-Ray traces.
const FAR: f64 = 1e7;

/// What is the same in all frames.
#[derive(Clone, Debug)]
pub struct Geometry {
    grid: Grid,
    view: View,
    windows: Vec<Rectangle>,
    still: Vec<Still>,
    lights: Vec<DVec3>,
    moving: Vec<bool>,
    /// Where still things mirror or bend rays.
    bent: Blocks,
    /// Where shadows can fall on a still thing.
    receivers: Blocks,
    /// Receivers without end that are no planes.
    endless: bool,
}

/// A still object as it was placed.
type Still = (usize, Extent);

impl Geometry {
    /// What is known from the first frame.
    ///
    /// # Errors
    /// Why geometry does not suffice, in words.
    pub fn new(grid: Grid, analysis: &Analysis, first: &FrameBoxes) -> Result<Self, String> {
        if let Some(reason) = analysis.proxies_only.first() {
            return Err(reason.to_string());
        }
        if first.lost_light {
            return Err("where a light is is not known".into());
        }
        let words = first.camera.as_ref();
        let view = words.and_then(|words| View::of(words, grid.size));
        let view = view.ok_or("the camera is not a plain perspective one")?;
        let look = &analysis.statements;
        let moving = look.iter().map(|s| s.moves).collect::<Vec<_>>();
        let mut known = Self {
            grid,
            windows: (0..grid.count()).map(|b| window(grid, b)).collect(),
            view,
            still: Vec::new(),
            lights: first.lights.clone(),
            moving,
            bent: Blocks::none(grid),
            receivers: Blocks::none(grid),
            endless: false,
        };
        known.still = known.still_of(first);
        for (statement, extent) in &known.still.clone() {
            let bends = look.get(*statement).is_none_or(|s| s.bends);
            if look.get(*statement).is_some_and(|s| !is_object(&s.kind)) {
                continue;
            }
            match (extent, bends) {
                (Extent::Box { min, max }, _) => {
                    let seen = known.seen(&corners(*min, *max));
                    known.receivers = known.receivers.or(&seen);
                    if bends {
                        known.bent = known.bent.or(&seen);
                    }
                }
                (Extent::Plane { .. } | Extent::Endless, true) => {
                    return Err("something without end mirrors or bends rays".into());
                }
                (Extent::Plane { .. }, false) => {}
                (Extent::Endless, false) => known.endless = true,
            }
        }
        Ok(known)
    }

    /// The blocks that are dirty in a frame.
    pub fn dirty(&self, frame: &FrameBoxes) -> Blocks {
        if !self.is_still(frame) {
            return Blocks::all(self.grid);
        }
        let moved = frame.objects.iter().filter(|o| self.moves(o.statement));
        let solids = moved.map(Solid::of);
        match solids.collect::<Option<Vec<Solid>>>() {
            Some(solids) => self.touched_by(&solids),
            None => Blocks::all(self.grid),
        }
    }

    /// The blocks that are dirty in any frame of a group, of which `one` is one.
    pub fn dirty_in(&self, hulls: &Hulls, one: &FrameBoxes) -> Blocks {
        if self.is_still(one) {
            self.touched_by(&hulls.solids)
        } else {
            Blocks::all(self.grid)
        }
    }

    fn is_still(&self, frame: &FrameBoxes) -> bool {
        self.still_of(frame) == self.still && frame.lights == self.lights && !frame.lost_light
    }

    fn touched_by(&self, solids: &[Solid]) -> Blocks {
        let mut dirty = self.bent.clone();
        for solid in solids {
            let points = solid.points();
            dirty = dirty.or(&self.seen(&points));
            for light in &self.lights {
                dirty = dirty.or(&self.shadowed(&points, *light));
            }
        }
        dirty
    }

    fn moves(&self, statement: usize) -> bool {
        self.moving.get(statement).is_none_or(|moves| *moves)
    }

    fn still_of(&self, frame: &FrameBoxes) -> Vec<Still> {
        let all = frame.objects.iter();
        all.filter(|o| !self.moves(o.statement))
            .map(|o| (o.statement, o.extent))
            .collect()
    }

    /// Where the hull of these points can be seen.
    fn seen(&self, points: &[DVec3]) -> Blocks {
        match self.view.outline(points) {
            // Not a number: nothing is certain.
            Err(()) => Blocks::all(self.grid),
            Ok(outline) => self.within(&outline),
        }
    }

    fn within(&self, outline: &[DVec2]) -> Blocks {
        Blocks::of(self.grid, |block| touches(outline, &self.windows[block]))
    }

    /// Where the shadow of a box can be seen on something still.
    fn shadowed(&self, corners: &[DVec3], light: DVec3) -> Blocks {
        let beyond = corners.iter().map(|corner| {
            let ray = *corner - light;
            *corner + ray.normalize_or(ray) * FAR
        });
        let mut hull = corners.to_vec();
        hull.extend(beyond);
        let streak = self.seen(&hull);
        if self.endless {
            return streak;
        }
        let planes = self.still.iter().filter_map(|(_, extent)| match extent {
            Extent::Plane { point, normal } => Some(self.on_plane(corners, light, *point, *normal)),
            _ => None,
        });
        let on_planes = planes.fold(Blocks::none(self.grid), |sum, on| sum.or(&on));
        streak.and(&self.receivers.or(&on_planes))
    }

    /// Where the shadow of a box can be seen on a plane.
    fn on_plane(&self, corners: &[DVec3], light: DVec3, point: DVec3, normal: DVec3) -> Blocks {
        let height = (light - point).dot(normal);
        // The light is above, on whichever side it is.
        let (height, normal) = (height.abs(), normal * height.signum());
        let heights: Vec<f64> = corners.iter().map(|c| (c - point).dot(normal)).collect();
        let above = |h: &f64| *h >= height * (1.0 - 1e-9);
        if heights.iter().all(|h| *h < 0.0) {
            // Behind the plane as the light sees it.
            return Blocks::none(self.grid);
        }
        let certain = height > 1e-9 && height.is_finite() && heights.iter().all(|h| h.is_finite());
        if certain && heights.iter().all(above) {
            // Further than the light.
            return Blocks::none(self.grid);
        }
        if !certain || heights.iter().any(above) {
            return Blocks::all(self.grid);
        }
        let cast: Vec<DVec3> = corners
            .iter()
            .zip(&heights)
            .map(|(corner, h)| light + (corner - light) * (height / (height - h)))
            .collect();
        self.seen(&cast)
    }
}

fn is_object(kind: &Kind) -> bool {
    matches!(kind, Kind::Object(_))
}

/// A block with its margin; method 1 looks one pixel further up and to the left.
fn window(grid: Grid, block: usize) -> Rectangle {
    let window = grid.window(block);
    let (x, y) = (f64::from(window.x), f64::from(window.y));
    Rectangle {
        least: DVec2::new(x - 1.0 - MARGIN_PX, y - 1.0 - MARGIN_PX),
        greatest: DVec2::new(
            f64::from(window.right()) + MARGIN_PX,
            f64::from(window.bottom()) + MARGIN_PX,
        ),
    }
}

#[cfg(test)]
#[path = "geometry_tests.rs"]
mod tests;
