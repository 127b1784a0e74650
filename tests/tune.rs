//! `decor tune`: what it finds holds over the whole film.

mod common;
mod moving;

use std::path::Path;

use common::Run;
use serde_json::Value;

/// Tunes and renders; gives the summary, and the whole film against plain frames.
fn tuned(film: &Path, renderer: &str, target: &str) -> (Value, Value) {
    let folder = tempfile::tempdir().unwrap();
    let (plain, out) = (folder.path().join("plain"), folder.path().join("tuned"));
    let ended = Run::new([
        "tune",
        "--renderer",
        renderer,
        "--json",
        "--render",
        "--no-fallback",
    ])
    .args(["--target", target, "-o"])
    .arg(&out)
    .arg(film)
    .succeeds();
    let probes = ended
        .stdout
        .lines()
        .filter(|l| l.contains(r#""type":"probe""#));
    let looked: std::collections::BTreeSet<String> = probes
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .map(|probe| probe["value"].to_string())
        .collect();
    // Thresholds with one plan have one value, and were looked at once.
    assert!(looked.len() <= 5, "{}", ended.stdout);
    Run::new(["render", "--baseline", "--renderer", renderer, "-o"])
        .arg(&plain)
        .arg(film)
        .succeeds();
    let compared = Run::new(["compare", "--json", "--fail", "0.016"])
        .args([&plain, &out])
        .ends();
    (ended.summary(), compared.summary())
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// The target holds over the whole film, and what was predicted is near.
fn holds(film: &Path, renderer: &str, metric: &str, value: f64) -> Value {
    let (summary, film) = tuned(film, renderer, &format!("{metric}={value}"));
    let found = match metric {
        "flicker" => &film["flicker"]["share_added"],
        metric => &film[metric],
    };
    if metric == "psnr" {
        // Null: nothing differs.
        assert!(
            found.is_null() || number(found) >= value,
            "{found}: {summary:#}"
        );
    } else if metric == "ssim" {
        assert!(number(found) >= value, "{found}: {summary:#}");
    } else {
        assert!(number(found) <= value, "{found}: {summary:#}");
        assert!(
            number(found) <= number(&summary["at_worst"]) + 1e-12,
            "{found}: {summary:#}"
        );
    }
    summary
}

#[test]
fn ladybirds() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    for (metric, value) in [
        ("flip", 0.005),
        ("psnr", 33.0),
        ("ssim", 0.99),
        ("rms", 0.02),
        ("flicker", 0.0012),
    ] {
        let summary = holds(&film, "reference", metric, value);
        // It is no frame by frame: there is something to win.
        assert_eq!(summary["mode"], "equivalent", "{metric}: {summary:#}");
        assert_eq!(summary["whole"], false, "{metric}: {summary:#}");
    }
}

#[test]
fn contact() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::contact(folder.path());
    for (metric, value) in [("flip", 0.004), ("psnr", 36.0)] {
        let summary = holds(&film, "reference", metric, value);
        assert_eq!(summary["whole"], false, "{metric}: {summary:#}");
    }
}

#[test]
fn plane() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::plane(folder.path());
    let summary = holds(&film, "povray", "flip", 0.01);
    assert_eq!(summary["whole"], false, "{summary:#}");
}

#[test]
fn a_quality_that_nothing_layered_has_cheaply_is_rendered_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let summary = Run::new(["tune", "--renderer", "reference", "--json"])
        .args(["--target", "max=0.001"])
        .arg(&film)
        .succeeds()
        .summary();
    assert_eq!(summary["mode"], "exact");
    assert_eq!(summary["sure"], "certain");
    // Where layers are to be used at any price: by a threshold so small that all
    // that moves is drawn in blocks from the full scene.
    let (summary, film) = tuned(&film, "reference", "max=0.001");
    assert!(number(&summary["threshold_px"]) < 0.2, "{summary:#}");
    assert_eq!(film["verdict"], "within");
    assert_eq!(number(&film["max"]), 0.0);
}

#[test]
fn a_motion_is_a_matter_of_the_plan() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let (summary, _) = tuned(&film, "reference", "motion=0.3");
    assert_eq!(summary["sure"], "certain");
    assert_eq!(summary["plain_frames"], 0);
    assert!(number(&summary["value"]) <= 0.3, "{summary:#}");
    assert!(number(&summary["value"]) > 0.0, "{summary:#}");
}

#[test]
fn a_better_quality_has_a_smaller_threshold() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let threshold = |target: &str| {
        let summary = Run::new(["tune", "--renderer", "reference", "--json", "--target"])
            .arg(target)
            .arg(&film)
            .succeeds()
            .summary();
        number(&summary["threshold_px"])
    };
    let found = ["flip=0.002", "flip=0.006", "flip=0.05"].map(threshold);
    assert!(found[0] < found[1] && found[1] < found[2], "{found:?}");
    // The same again finds the same.
    assert_eq!(threshold("flip=0.006"), found[1]);
}

#[test]
fn wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    for args in [
        &["--target", "beauty=1"][..],
        &["--target", "flip=0.1", "--render"],
        &["--target", "flip=0.1", "-o", "x"],
        &["--target", "flip=0.1", "--mode", "exact"],
        &[
            "--target",
            "flip=0.1",
            "--threshold-min",
            "5",
            "--threshold-max",
            "1",
        ],
        &[],
    ] {
        let ended = Run::new(["tune"]).arg(&film).args(args).ends();
        assert_eq!(ended.status, 64, "{args:?}: {}", ended.stderr);
    }
}
