//! What is nearer than everything behind it is merged without any depth.

mod common;

use std::path::Path;

use common::{Run, differing_pixels};
use serde_json::Value;

const FRAMES: u32 = 6;

/// A ball flies to the right, before a wall on a floor or behind it.
fn film(folder: &Path, depth: f64, head: &str) {
    let ball = "sphere { 0, 0.9 pigment { rgb <1,0.6,0> } finish { phong 1 } }";
    let wall = "box { <-3,-2,-0.2>, <3,2,0.2> pigment { checker rgb 1 rgb 0.4 scale 0.5 } }";
    let floor = "box { <-30,-2.2,-30>, <30,-2,30> pigment { checker rgb 0.9 rgb 0.2 } }";
    for (name, text) in [("ball", ball), ("wall", wall), ("floor", floor)] {
        std::fs::write(folder.join(format!("{name}.inc")), text).unwrap();
    }
    let film = format!(
        "@0\n*eye 0 0.5 -10\n*aim 0 0 10\n*angles 50 38\n*size 320 240\n*images {FRAMES}\n{head}\n\
         *background 0.2 0.3 0.5\n*light -30 60 -40 1 1 1 point\n\
         !wall 0 0 0 0 0 0\n!floor 0 0 0 0 0 0\n!ball -3 0.4 {depth} 0 0 0  0.5 0 0 0 0 0\n"
    );
    std::fs::write(folder.join("film.anim"), film).unwrap();
}

fn render(folder: &Path, out: &str, extra: &[&str]) -> Value {
    Run::new(["render", "--json"])
        .arg(folder.join("film.anim"))
        .arg("-o")
        .arg(folder.join(out))
        .args(extra)
        .succeeds()
        .summary()
}

/// The pixels of depth that were traced, and how many of the frames are not plain
/// POV-Ray's.
fn previewed(depth: f64, head: &str) -> (u64, usize) {
    let folder = tempfile::tempdir().unwrap();
    film(folder.path(), depth, head);
    let extra = ["--mode", "preview", "--threshold", "0", "--no-fallback"];
    let summary = render(folder.path(), "own", &extra);
    let traced = &summary["pixels_traced"];
    assert!(traced["fast"].as_u64().unwrap() > 0, "nothing is merged");
    render(folder.path(), "plain", &["--baseline"]);
    let wrong = (0..FRAMES).map(|number| {
        let name = format!("frame_{number:04}.png");
        let frame = |out: &str| folder.path().join(out).join(&name);
        differing_pixels(&frame("own"), &frame("plain")).len()
    });
    (traced["depth"].as_u64().unwrap(), wrong.sum())
}

#[test]
fn before_the_wall_no_depth_is_traced() {
    assert_eq!(previewed(-4.0, "*shadows 0"), (0, 0));
}

#[test]
fn behind_it_depth_is_traced() {
    let (depth, wrong) = previewed(3.0, "*shadows 0");
    assert!(depth > 0);
    assert_eq!(wrong, 0);
}

#[test]
fn edges_are_mixed_by_their_coverage() {
    let (depth, wrong) = previewed(-4.0, "*shadows 0\n*antialias 0.1 3");
    assert_eq!(depth, 0);
    // What is mixed of two antialiased layers is nearly what one picture has.
    let edges = 60 * FRAMES as usize;
    assert!((1..edges * 4).contains(&wrong), "{wrong} pixels");
}
