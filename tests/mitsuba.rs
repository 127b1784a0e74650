//! The second renderer: a neutral film on Mitsuba, against Mitsuba alone and
//! against the other renderers. Mitsuba and POV-Ray are really called.

mod common;

use std::path::Path;

use common::{Run, fixture};
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

fn render(out: &Path, renderer: &str, options: &[&str]) {
    let run = Run::new(["render", "--renderer", renderer, "--format", "exr"]);
    let run = run.arg(fixture("neutral/neutral.anim")).arg("-o").arg(out);
    let ended = run.args(options).ends();
    assert_eq!(ended.status, 0, "{renderer}: {}", ended.stderr);
}

/// One channel of a frame.
fn channel(folder: &Path, frame: u32, name: &str) -> Vec<f32> {
    let path = folder.join(format!("frame_{frame:04}.exr"));
    let image = read_first_flat_layer_from_file(&path).unwrap();
    let channels = image.layer_data.channel_data.list;
    let found = channels.into_iter().find(|c| c.name.to_string() == name);
    match found.unwrap().sample_data {
        FlatSamples::F32(samples) => samples,
        other => panic!("{other:?}"),
    }
}

#[test]
fn exact_and_full_are_what_mitsuba_alone_gives() {
    let work = tempfile::tempdir().unwrap();
    let alone = work.path().join("alone");
    render(&alone, "mitsuba", &["--baseline"]);
    for mode in ["full", "exact"] {
        let ours = work.path().join(mode);
        render(&ours, "mitsuba", &["--mode", mode, "--no-fallback"]);
        for frame in 0..4 {
            for name in ["R", "G", "B"] {
                let (a, b) = (channel(&alone, frame, name), channel(&ours, frame, name));
                assert_eq!(a.len(), 192 * 144);
                let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
                let apart = apart.fold(0.0, f32::max);
                assert!(apart <= 1e-5, "{mode}, frame {frame}, {name}: {apart}");
            }
        }
    }
}

#[test]
fn equivalent_is_hardly_apart_from_mitsuba_alone() {
    let work = tempfile::tempdir().unwrap();
    let (alone, ours) = (work.path().join("alone"), work.path().join("ours"));
    render(&alone, "mitsuba", &["--baseline"]);
    render(&ours, "mitsuba", &["--mode", "equivalent", "--no-fallback"]);
    for frame in 0..4 {
        let (a, b) = (channel(&alone, frame, "R"), channel(&ours, frame, "R"));
        let apart = a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > 0.01);
        let apart = apart.count();
        assert!(apart * 200 <= a.len(), "frame {frame}: {apart}");
    }
}

#[test]
fn three_renderers_see_the_same_things_at_the_same_distance() {
    let work = tempfile::tempdir().unwrap();
    let depth = |renderer: &str| {
        let out = work.path().join(renderer);
        render(&out, renderer, &["--mode", "full", "--frames", "0-0"]);
        channel(&out, 0, "Z")
    };
    let reference = depth("reference");
    let seen = reference.iter().filter(|z| z.is_finite()).count();
    assert!(seen > 8000, "{seen} pixels show something");
    for renderer in ["mitsuba", "povray"] {
        let found = depth(renderer);
        assert_eq!(found.len(), reference.len());
        // Where one sees another thing than the other does: beyond a thousandth.
        let same = |a: f32, b: f32| a == b || (a - b).abs() <= 1e-3 * b;
        let pairs = || found.iter().copied().zip(reference.iter().copied());
        let other = pairs().filter(|&(a, b)| !same(a, b)).count();
        assert!(other * 2000 <= found.len(), "{renderer}: {other} pixels");
        let pairs = pairs().filter(|&(a, b)| same(a, b) && a.is_finite());
        let off = pairs.map(|(a, b)| (a / b - 1.0).abs());
        let mut off: Vec<f32> = off.collect();
        off.sort_by(f32::total_cmp);
        let beyond = off.iter().filter(|o| **o > 1e-5).count();
        assert!(
            beyond * 2000 <= off.len(),
            "{renderer}: {beyond} of {}",
            off.len()
        );
    }
}
