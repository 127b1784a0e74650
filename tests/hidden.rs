//! What the décor hides is not rendered: a ball behind a wall.

mod common;

use std::path::Path;

use common::{Run, differing_pixels};
use serde_json::Value;

/// A ball flies to the right, `depth` behind the eye's aim; a wall stands between
/// them. `eye` is how fast the observer comes nearer.
fn film(folder: &Path, from: f64, eye: f64) {
    let ball = "sphere { 0, 1.4 pigment { rgb <1,0.6,0> } finish { phong 1 } }";
    let wall = "box { <-3,-2,-0.2>, <3,2,0.2> pigment { checker rgb 1 rgb 0.4 scale 0.5 } }";
    let floor = "plane { y, -2 pigment { checker rgb 0.9 rgb 0.2 } }";
    for (name, text) in [("ball", ball), ("wall", wall), ("floor", floor)] {
        std::fs::write(folder.join(format!("{name}.inc")), text).unwrap();
    }
    // Of a floor without an end something is always near.
    let ground = if eye == 0.0 {
        "!floor 0 0 0 0 0 0\n"
    } else {
        ""
    };
    let film = format!(
        "@0\n*eye 0 0.5 -10  0 0 {eye}\n*aim 0 0 10  0 0 {eye}\n*angles 50 38\n*size 320 240\n\
         *images 48\n*shadows 0\n*background 0.2 0.3 0.5\n*light -30 60 -40 1 1 1 point\n\
         !wall 0 0 0 0 0 0\n{ground}!ball {from} 0 4 0 0 0  0.04 0 0 0 0 0\n"
    );
    std::fs::write(folder.join("film.anim"), film).unwrap();
}

fn render(folder: &Path, out: &str, extra: &[&str]) -> Value {
    Run::new(["render", "--format", "png16", "--json"])
        .arg(folder.join("film.anim"))
        .arg("-o")
        .arg(folder.join(out))
        .args(extra)
        .succeeds()
        .summary()
}

/// The pixels of fast layers and of blocks.
fn traced(folder: &Path, extra: &[&str]) -> u64 {
    let summary = render(folder, "own", extra);
    assert_eq!(summary["fallback"], false);
    let traced = &summary["pixels_traced"];
    let drawn = ["fast", "blocks"].map(|pass| traced[pass].as_u64().unwrap());
    drawn.iter().sum()
}

/// How many pixels are not plain POV-Ray's.
fn wrong(folder: &Path) -> usize {
    let numbers = (0..48).map(|number| {
        let name = format!("frame_{number:04}.png");
        let frame = |out: &str| folder.join(out).join(&name);
        differing_pixels(&frame("own"), &frame("plain")).len()
    });
    numbers.sum()
}

#[test]
fn behind_a_wall() {
    // From -1 to 0.88: behind the wall all the time. From 2 on it comes out.
    for (from, is_hidden) in [(-1.0, true), (2.0, false)] {
        let folder = tempfile::tempdir().unwrap();
        film(folder.path(), from, 0.0);
        render(folder.path(), "plain", &["--baseline"]);
        for mode in ["exact", "equivalent", "preview"] {
            let extra = ["--mode", mode, "--no-fallback", "--threshold", "0"];
            let drawn = traced(folder.path(), &extra);
            assert_eq!(drawn == 0, is_hidden, "{mode}: {drawn}");
            assert_eq!(wrong(folder.path()), 0, "{mode}");
        }
    }
}

#[test]
fn before_an_observer_who_moves() {
    let extra = ["--no-fallback", "--threshold", "3", "--period", "48"];
    for (from, is_hidden) in [(-1.0, true), (2.0, false)] {
        let folder = tempfile::tempdir().unwrap();
        film(folder.path(), from, 0.0025);
        let drawn = traced(folder.path(), &extra);
        assert_eq!(drawn == 0, is_hidden, "{drawn}: the décor is a little off");
    }
}
