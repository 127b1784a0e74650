//! How many renderers fit into memory at once, before any has run: a rough estimate,
//! that only matters where there are tens of thousands of objects.

use decor_api::{Csg, Geometry, Prototype};

use crate::stage::Stage;

/// A renderer with an empty scene.
const PROCESS_BYTES: f64 = 40e6;

/// A pixel of its picture.
const PIXEL_BYTES: f64 = 40.0;

/// A shape of a placed object, with its texture and its transformations. POV-Ray
/// takes 26 kB for a ladybird of some forty.
const SHAPE_BYTES: f64 = 1_000.0;

/// A triangle: placed copies of a mesh share them.
const TRIANGLE_BYTES: f64 = 250.0;

/// The share of the free memory that renderers may fill.
const SHARE: f64 = 0.6;

/// As many calls at once as fit into memory, `jobs` at most: one, in any case.
pub fn that_fit(stage: &Stage, jobs: usize) -> usize {
    match available_bytes() {
        Some(available) => fitting(jobs, call_bytes(stage), available),
        None => jobs,
    }
}

fn fitting(jobs: usize, each_bytes: f64, available_bytes: f64) -> usize {
    ((SHARE * available_bytes / each_bytes) as usize).clamp(1, jobs.max(1))
}

/// What a call may hold that draws the first frame, roughly.
fn call_bytes(stage: &Stage) -> f64 {
    let state = stage.film.frame(*stage.film.frames().start());
    let placed = state.objects.iter().map(|object| {
        let prototype = stage.prototype(object);
        SHAPE_BYTES * shapes(prototype).max(prototype.extents.len() as f64)
    });
    let table = stage.library.table.iter();
    let triangles = table.map(|(_, prototype)| TRIANGLE_BYTES * triangles(prototype));
    let pixels = stage.size().pixels() as f64;
    PROCESS_BYTES + PIXEL_BYTES * pixels + placed.sum::<f64>() + triangles.sum::<f64>()
}

/// Shapes of a description; those of a text are guessed by its length.
fn shapes(prototype: &Prototype) -> f64 {
    const TEXT_BYTES: f64 = 100.0;
    fn tree(csg: &Csg) -> f64 {
        1.0 + csg.children().into_iter().map(tree).sum::<f64>()
    }
    match &prototype.geometry {
        Geometry::Neutral(csg) => tree(csg),
        Geometry::Fragment(fragment) => fragment.file.text.len() as f64 / TEXT_BYTES,
    }
}

fn triangles(prototype: &Prototype) -> f64 {
    fn tree(csg: &Csg) -> f64 {
        let own = match csg {
            Csg::Mesh(mesh) => mesh.triangles.len() as f64,
            _ => 0.0,
        };
        own + csg.children().into_iter().map(tree).sum::<f64>()
    }
    match &prototype.geometry {
        Geometry::Neutral(csg) => tree(csg),
        Geometry::Fragment(_) => 0.0,
    }
}

/// The memory that is free or can be freed, where the system says.
fn available_bytes() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kib: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(1024.0 * kib)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_fit_where_each_holds_more_and_one_always_does() {
        assert_eq!(fitting(16, 60e6, 20e9), 16);
        assert_eq!(fitting(16, 3e9, 20e9), 4);
        assert_eq!(fitting(16, 100e9, 20e9), 1);
        assert_eq!(fitting(0, 60e6, 20e9), 1);
    }

    #[test]
    fn the_system_says_what_is_free() {
        if cfg!(target_os = "linux") {
            assert!(available_bytes().is_some_and(|bytes| bytes > 1e6));
        }
    }
}
