//! Merged frames against the stock renderer's own: pixel by pixel, 16 bits.

mod common;

use common::{Run, differing_pixels};

/// Renders a bundled film merged and plainly, and compares all frames.
fn check(film: &str, extra: &[&str]) -> serde_json::Value {
    let folder = tempfile::tempdir().unwrap();
    let (merged, plain) = (folder.path().join("merged"), folder.path().join("plain"));
    let path = common::fixture(film);
    let render = |out: &std::path::Path, extra: &[&str]| {
        Run::new(["render"])
            .arg(&path)
            .args(["--format", "png16", "--json", "-o"])
            .arg(out)
            .args(extra)
            .succeeds()
            .summary()
    };
    let summary = render(&merged, extra);
    let baseline = render(&plain, &["--baseline"]);
    assert_eq!(summary["frames"], baseline["frames"]);
    for number in 0..summary["frames"].as_u64().unwrap() {
        let name = format!("frame_{number:04}.png");
        let wrong = differing_pixels(&merged.join(&name), &plain.join(&name));
        assert!(
            wrong.is_empty(),
            "{film} {name}: {} pixels: {:?}",
            wrong.len(),
            &wrong[..wrong.len().min(9)]
        );
    }
    summary
}

#[test]
fn plane() {
    let summary = check("plane/plane.anim", &[]);
    assert_eq!(summary["fallback"], false);
    let traced = summary["pixels_traced"]["fast"].as_u64().unwrap()
        + summary["pixels_traced"]["decor"].as_u64().unwrap();
    assert!(
        traced < summary["pixels_full"].as_u64().unwrap() / 2,
        "{summary:#}"
    );
}

#[test]
fn contact() {
    // Small and crowded: frame by frame would be cheaper, but touches nothing. A
    // preview merges by depth, whatever blocks would cost.
    let options = ["--mode", "preview", "--threshold", "0", "--no-fallback"];
    let summary = check("contact/contact.anim", &options);
    assert_eq!(summary["fallback"], false);
    assert!(summary["pixels_traced"]["fast"].as_u64().unwrap() > 0);
    check("contact/contact.anim", &["--no-fallback"]);
}

#[test]
fn chess() {
    let summary = check("chess/chess.anim", &["--no-fallback"]);
    assert_eq!(summary["fallback"], false);
    // Glass and metal are drawn again, from the full scene.
    assert!(summary["pixels_traced"]["blocks"].as_u64().unwrap() > 0);
}

#[test]
fn plane_exactly() {
    let summary = check("plane/plane.anim", &["--mode", "exact"]);
    assert!(summary["pixels_traced"]["blocks"].as_u64().unwrap() > 0);
}

#[test]
fn plane_frame_by_frame_in_a_pool() {
    let summary = check("plane/plane.anim", &["--mode", "full"]);
    assert!(summary["renderer_calls"].as_u64().unwrap() > 1);
}

#[test]
fn ladybirds() {
    // The observer moves: nothing stays, and every frame is rendered whole.
    let summary = check("ladybirds/ladybirds.anim", &[]);
    assert_eq!(summary["fallback"], true);
}
