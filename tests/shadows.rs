//! Shadows, mirrors and glass between what moves and what does not: the bundled
//! films against the stock renderer.

mod common;

use std::path::{Path, PathBuf};

use common::{Run, differing_pixels, pixels};

const FRAMES: u32 = 6;

/// A bundled film, with or without antialiasing.
fn film(folder: &Path, name: &str, antialias: &str) -> PathBuf {
    let source = common::fixture(name);
    let target = folder.join(name);
    std::fs::create_dir_all(&target).unwrap();
    for entry in std::fs::read_dir(&source).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, target.join(path.file_name().unwrap())).unwrap();
    }
    let path = target.join(format!("{name}.anim"));
    let text = std::fs::read_to_string(&path).unwrap();
    let others = text.lines().filter(|line| !line.starts_with("*antialias"));
    let edited: Vec<&str> = std::iter::once(antialias).chain(others).collect();
    std::fs::write(&path, edited.join("\n")).unwrap();
    path
}

fn render(film: &Path, out: &Path, options: &[&str]) -> serde_json::Value {
    Run::new(["render"])
        .arg(film)
        .args(["--format", "png16", "--json", "--frames", "0-5", "-o"])
        .arg(out)
        .args(options)
        .succeeds()
        .summary()
}

fn frame(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("frame_{number:04}.png"))
}

/// Renders the film with `options` and plainly; gives the summary and the folders.
fn both(film: &Path, options: &[&str]) -> (serde_json::Value, PathBuf, PathBuf) {
    let folder = film.parent().unwrap();
    let (ours, plain) = (folder.join("ours"), folder.join("plain"));
    let summary = render(film, &ours, options);
    render(film, &plain, &["--baseline"]);
    assert_eq!(summary["fallback"], false, "{summary}");
    (summary, ours, plain)
}

fn check_exact(name: &str) {
    for antialias in ["*antialias off", "*antialias 0.1 3"] {
        let folder = tempfile::tempdir().unwrap();
        let film = film(folder.path(), name, antialias);
        let (summary, ours, plain) = both(&film, &["--mode", "exact", "--no-fallback"]);
        assert!(summary["pixels_traced"]["blocks"].as_u64().unwrap() > 0);
        for number in 0..FRAMES {
            let wrong = differing_pixels(&frame(&ours, number), &frame(&plain, number));
            assert!(
                wrong.is_empty(),
                "{name}, {antialias}, frame {number}: {:?}",
                &wrong[..wrong.len().min(9)]
            );
        }
        println!("{name}, {antialias}: {}", summary["pixels_traced"]);
    }
}

#[test]
fn shadows_exactly() {
    check_exact("shadows");
}

#[test]
fn mirrors_exactly() {
    check_exact("mirrors");
}

#[test]
fn soft_shadows_exactly() {
    check_exact("area");
}

/// Pixels that are brighter by more than a fifth in `a` than in `b`, as are their
/// four neighbours.
fn dark_pixels(a: &Path, b: &Path) -> usize {
    let (width, height, left) = pixels(a);
    let right = pixels(b).2;
    let brighter = |x: u32, y: u32| {
        let i = (y * width + x) as usize;
        let sum = |p: &[u16; 3]| p.iter().map(|&c| u32::from(c)).sum::<u32>();
        sum(&left[i]) > sum(&right[i]) + 150
    };
    let inner = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y)));
    inner
        .filter(|&(x, y)| {
            brighter(x, y)
                && brighter(x - 1, y)
                && brighter(x + 1, y)
                && brighter(x, y - 1)
                && brighter(x, y + 1)
        })
        .count()
}

/// The largest difference of a channel, of 65 535.
fn largest(a: &Path, b: &Path) -> u16 {
    let (left, right) = (pixels(a).2, pixels(b).2);
    let channels = left.iter().flatten().zip(right.iter().flatten());
    channels.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// The thesis's shadow map, by the lights that arrive.
#[test]
fn shadow_maps() {
    for name in ["shadows", "area"] {
        let folder = tempfile::tempdir().unwrap();
        let film = film(folder.path(), name, "*antialias off");
        let options = ["--threshold", "0", "--shadows", "map", "--no-fallback"];
        let (summary, ours, plain) = both(&film, &options);
        let traced = &summary["pixels_traced"];
        assert!(traced["shadow"].as_u64().unwrap() > 0, "{traced}");
        assert_eq!(traced["blocks"], 0, "{traced}");
        for number in 0..FRAMES {
            let far = largest(&frame(&ours, number), &frame(&plain, number));
            assert!(far <= 2 * 257, "{name}, frame {number}: {far}/65535");
        }
    }
}

/// An observer that moves slowly, before things that stand still and one that
/// flies: shadows fall on a décor that is up to a pixel old.
#[test]
fn shadows_fall_on_a_decor_that_a_moving_observer_sees() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("stone.ron"),
        "material((colour: (0.8, 0.7, 0.6)), sphere(radius: 1))",
    )
    .unwrap();
    let mut text = String::from(
        "*size 160 120\n*images 8\n*shadows 1\n*angles 50 38.5\n\
         *eye 0 3 -30  0.004 0 0\n*aim 0 0 0  0.004 0 0\n*light 0 60 -10 1 1 1 point\n",
    );
    for k in 0..30 {
        let (x, z) = (f64::from(k % 6) * 3.0 - 7.5, f64::from(k / 6) * 3.0);
        text += &format!("!stone.ron {x} -2 {z} 0 0 0\n");
    }
    text += "!stone.ron -4 3 2 0 0 0  1 0 0  0 0 0 name=bird\n";
    let path = folder.path().join("stones.anim");
    std::fs::write(&path, text).unwrap();
    let plain = folder.path().join("plain");
    let run = |out: &Path, options: &[&str]| {
        Run::new(["render"])
            .arg(&path)
            .args(["--json", "-o"])
            .arg(out)
            .args(options)
            .succeeds()
            .summary()
    };
    run(&plain, &["--baseline"]);
    let wrong = |options: &[&str]| {
        let out = folder.path().join("ours");
        let summary = run(&out, options);
        assert_eq!(summary["periods"][0]["whole"], serde_json::Value::Null);
        assert_eq!(summary["periods"][0]["objects"]["fast"], 1, "{summary}");
        // What is up to a pixel old differs at its edges, everywhere: only what
        // is dark in one picture and bright in the other, and there in many.
        let count = |n| dark_pixels(&frame(&out, n), &frame(&plain, n));
        (summary, (0..8).map(count).max().unwrap())
    };
    let common = ["--period", "8", "--no-fallback", "--threshold", "1"];
    let (_, without) = wrong(&[&common[..], &["--mode", "preview"]].concat());
    for way in ["map", "blocks"] {
        let (summary, with) = wrong(&[&common[..], &["--shadows", way]].concat());
        let traced = &summary["pixels_traced"];
        let used = traced[if way == "map" { "shadow" } else { "blocks" }].as_u64();
        assert!(used.unwrap() > 0, "{way}: {traced}");
        println!("{way}: {with} pixels of a frame differ, {without} without shadows across layers");
        assert!(with * 3 < without, "{way}: {with} of {without}");
    }
}

/// Everything stands still but the observer: what is near is fast in the picture, and
/// its shadow rests on what is far.
#[test]
fn a_decor_has_the_shadows_of_what_only_the_observer_passes() {
    let folder = tempfile::tempdir().unwrap();
    let stone = "material((colour: (0.8, 0.7, 0.6)), sphere(radius: 1))";
    std::fs::write(folder.path().join("stone.ron"), stone).unwrap();
    let mut text = String::from(
        "*size 200 150\n*images 12\n*shadows 1\n*angles 50 38.5\n\
         *eye 0 3 -30  0.02 0 0\n*aim 0 0 0  0.02 0 0\n*light 0 5.5 -28 1 1 1 point\n",
    );
    for k in 0..80 {
        let (x, z) = (
            f64::from(k % 10) * 4.0 - 18.0,
            f64::from(k / 10) * 6.0 + 6.0,
        );
        text += &format!("!stone.ron {x} -1.5 {z} 0 0 0 name=far_{k}\n");
    }
    for (k, x) in [-4.0, -2.0, 0.5].into_iter().enumerate() {
        text += &format!("!stone.ron {x} 3.2 -14 0 0 0 name=near_{k}\n");
    }
    let path = folder.path().join("stones.anim");
    std::fs::write(&path, &text).unwrap();
    let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
    let run = |out: &Path, options: &[&str]| {
        let run = Run::new(["render"]).arg(&path).args(["--json", "-o"]);
        run.arg(out).args(options).succeeds().summary()
    };
    run(&plain, &["--baseline"]);
    let dark = || (0..12).map(|n| dark_pixels(&frame(&ours, n), &frame(&plain, n)));
    let common = ["--period", "6", "--no-fallback", "--threshold", "1"];
    run(&ours, &[&common[..], &["--mode", "preview"]].concat());
    let without = dark().max().unwrap();
    let summary = run(&ours, &common);
    let with = dark().max().unwrap();
    assert!(without > 50, "shadows of near stones are seen: {without}");
    assert!(
        with * 10 < without,
        "{with} of {without} pixels lack a shadow"
    );
    for period in summary["periods"].as_array().unwrap() {
        assert_eq!(period["whole"], serde_json::Value::Null, "{period}");
        assert!(period["objects"]["fast"].as_u64().unwrap() >= 3, "{period}");
    }
    let traced = &summary["pixels_traced"];
    assert_eq!(traced["whole"], 0, "{traced}");
    println!("{with} pixels lack a shadow, {without} in preview; {traced}");
}

/// What reaches everywhere is rendered everywhere, and said.
#[test]
fn radiosity_and_photons_are_rendered_whole() {
    for (word, text) in [
        ("radiosity", "global_settings { radiosity { count 10 } }\n"),
        ("photons", "global_settings { photons { count 100 } }\n"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let film = film(folder.path(), "contact", "*antialias off");
        let path = film.parent().unwrap().join("settings.inc");
        std::fs::write(&path, text).unwrap();
        let film_text = std::fs::read_to_string(&film).unwrap();
        std::fs::write(&film, format!("*include settings.inc\n{film_text}")).unwrap();
        let plan = Run::new(["plan", "--json", "--frames", "0-5"])
            .arg(&film)
            .succeeds();
        assert!(plan.stdout.contains(word), "{}", plan.stdout);
        let folder = film.parent().unwrap();
        let summary = render(&film, &folder.join("ours"), &[]);
        assert_eq!(summary["fallback"], true, "{summary}");
        let why = summary["periods"][0]["whole"].as_str().unwrap();
        assert!(why.contains(word), "{why}");
    }
}
