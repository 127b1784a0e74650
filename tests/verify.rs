//! `decor render --verify`: what must pass passes, what must fail fails.

mod common;

use common::{Ended, Run, fixture};

fn render(film: &str, extra: &[&str]) -> Ended {
    let folder = tempfile::tempdir().unwrap();
    Run::new(["render", "--renderer", "reference", "--json", "-o"])
        .arg(folder.path().join("out"))
        .arg(fixture(film))
        .args(extra)
        .ends()
}

/// A threshold of hundreds of pixels: nothing is rendered again, and what moves
/// stands still.
const FROZEN: [&str; 5] = ["--mode", "preview", "--threshold", "500", "--no-fallback"];

#[test]
fn exact_frames_pass_without_any_tolerance() {
    let ended = render(
        "contact/contact.anim",
        &["--mode", "exact", "--no-fallback", "--verify", "4"],
    );
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let summary = ended.summary();
    assert_eq!(summary["fallback"], false);
    let verified = &summary["verified"];
    assert_eq!(verified["passed"], true);
    assert_eq!(verified["tolerance"], 0.0);
    assert_eq!(verified["max"], 0.0);
    assert_eq!(verified["psnr"], serde_json::Value::Null);
    assert_eq!(verified["frames"].as_array().unwrap().len(), 4);
}

#[test]
fn a_film_that_stands_still_fails_with_status_1() {
    let ended = render(
        "contact/contact.anim",
        &[&FROZEN[..], &["--verify", "3"]].concat(),
    );
    assert_eq!(ended.status, 1, "{}", ended.stderr);
    let summary = ended.summary();
    let verified = &summary["verified"];
    assert_eq!(verified["passed"], false);
    assert_eq!(verified["tolerance"], 0.016);
    assert!(verified["max"].as_f64().unwrap() > 0.1, "{verified:#}");
    assert!(verified["psnr"].as_f64().unwrap() < 60.0, "{verified:#}");
    // The last frame is the farthest from the décor's.
    let failed: Vec<u64> = verified["failed"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(serde_json::Value::as_u64)
        .collect();
    assert!(failed.contains(&11), "{verified:#}");
    // The time of the verification is its own.
    assert!(verified["wall_s"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_tolerance_decides() {
    let lax = ["--verify", "3", "--verify-fail", "1"];
    let ended = render("contact/contact.anim", &[&FROZEN[..], &lax].concat());
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let lax = ["--verify", "3", "--verify-fail-percent", "100"];
    let ended = render("contact/contact.anim", &[&FROZEN[..], &lax].concat());
    assert_eq!(ended.status, 0, "{}", ended.stderr);
}

#[test]
fn with_povray_too() {
    let folder = tempfile::tempdir().unwrap();
    let ended = Run::new(["render", "--frames", "0-5", "--verify", "2", "--json", "-o"])
        .arg(folder.path())
        .arg(fixture("plane/plane.anim"))
        .args(["--mode", "exact"])
        .ends();
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    assert_eq!(ended.summary()["verified"]["differing"], 0);
}

#[test]
fn the_depth_is_verified_too() {
    let ended = render(
        "contact/contact.anim",
        &[
            "--mode",
            "exact",
            "--no-fallback",
            "--format",
            "exr",
            "--verify",
            "2",
        ],
    );
    assert_eq!(ended.status, 0, "{}", ended.stderr);
}

#[test]
fn what_makes_no_sense_is_wrong_usage() {
    for extra in [
        &["--verify", "0"][..],
        &["--verify-fail", "0.1"],
        &["--verify", "2", "--baseline"],
        &["--verify", "2", "--verify-fail-percent", "101"],
    ] {
        let ended = render("contact/contact.anim", extra);
        assert_eq!(ended.status, 64, "{extra:?}: {}", ended.stderr);
    }
    let ended = render("unedited/orbit.ini", &["--verify", "2"]);
    assert_eq!(ended.status, 64, "{}", ended.stderr);
}
