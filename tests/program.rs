//! The program as its users meet it.

mod common;

use common::{Run, differing_pixels, fixture};

#[test]
fn usage_errors_are_status_64() {
    for args in [
        &["render", "film.anim"][..],
        &["no-such-verb"],
        &["render", "film.anim", "-o", "x", "--mode", "magic"],
        &[
            "render",
            "film.anim",
            "-o",
            "x",
            "--baseline",
            "--mode",
            "full",
        ],
        &["render", "film.anim", "-o", "x", "--frames", "9-3"],
        &["render", "film.anim", "-o", "x", "--period", "0"],
        &["convert", "a.anim", "b.txt"],
    ] {
        let ended = Run::new(args).ends();
        assert_eq!(ended.status, 64, "{args:?}: {}", ended.stderr);
    }
    let film = fixture("contact/contact.anim");
    let ended = Run::new(["plan", "--renderer", "nobody"]).arg(film).ends();
    assert_eq!(ended.status, 64, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("povray, mitsuba,"),
        "{}",
        ended.stderr
    );
}

#[test]
fn help_and_version_are_no_errors() {
    for args in [
        &["--help"][..],
        &["--version"],
        &["render", "--help"],
        &["compare", "--help"],
    ] {
        assert!(!Run::new(args).succeeds().stdout.is_empty());
    }
    assert!(Run::new(["man"]).succeeds().stdout.contains(".TH decor"));
    assert!(
        Run::new(["completions", "bash"])
            .succeeds()
            .stdout
            .contains("decor")
    );
}

#[test]
fn a_bad_film_is_status_3_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for film in [
        "broken/unknown_keyword.anim",
        "broken/missing_object.anim",
        "broken/empty.jsonl",
    ] {
        let ended = Run::new(["render", "-o"])
            .arg(&out)
            .arg(fixture(film))
            .ends();
        assert_eq!(ended.status, 3, "{film}: {}", ended.stderr);
        assert!(!out.exists(), "{film}");
    }
    let ended = Run::new(["render", "--frames", "5-99", "-o"])
        .arg(&out)
        .arg(fixture("contact/contact.anim"))
        .ends();
    assert_eq!(ended.status, 3, "{}", ended.stderr);
    assert!(!out.exists());
}

/// A film in a folder of its own.
fn film(objects: &[(&str, &str)], lines: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in objects {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let head = "@0\n*eye 0 1 -6\n*aim 0 0 0\n*angles 50 40\n*size 64 48\n*frames 4\n*light 9 9 -9 1 1 1 point\n";
    std::fs::write(folder.path().join("film.anim"), format!("{head}{lines}\n")).unwrap();
    folder
}

#[test]
fn fragments_that_a_layer_cannot_hold() {
    let clock = "sphere { <clock, 0, 0>, 0.7 pigment { rgb 1 } }";
    let folder = film(&[("moving.inc", clock)], "!moving 0 0 0 0 0 0");
    let render = |out: &str, extra: &[&str]| {
        Run::new(["render", "-q", "--format", "png16"])
            .arg(folder.path().join("film.anim"))
            .arg("-o")
            .arg(folder.path().join(out))
            .args(extra)
            .ends()
    };
    let refused = render("merged", &[]);
    assert_eq!(refused.status, 3);
    assert!(
        refused.stderr.contains("clock") && refused.stderr.contains("--mode full"),
        "{}",
        refused.stderr
    );
    // Frame by frame the clock runs as in the stock renderer.
    assert_eq!(render("full", &["--mode", "full"]).status, 0);
    assert_eq!(render("plain", &["--baseline"]).status, 0);
    for frame in 0..4 {
        let name = format!("frame_{frame:04}.png");
        let (a, b) = (
            folder.path().join("full").join(&name),
            folder.path().join("plain").join(&name),
        );
        assert_eq!(differing_pixels(&a, &b), []);
    }
    let (first, last) = ("full/frame_0000.png", "full/frame_0003.png");
    let moved = differing_pixels(&folder.path().join(first), &folder.path().join(last));
    assert!(!moved.is_empty(), "the clock stands still");
}

#[test]
fn a_fragment_that_povray_cannot_read_is_named() {
    let folder = film(
        &[
            ("bad.inc", "sphere { 0, oops }"),
            ("good.inc", "sphere { 0, 1 }"),
        ],
        "!good 0 0 0 0 0 0\n!bad 0 0 0 0 0 0",
    );
    let ended = Run::new(["plan"])
        .arg(folder.path().join("film.anim"))
        .ends();
    assert_eq!(ended.status, 3, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("bad.inc") && ended.stderr.contains("oops"),
        "{}",
        ended.stderr
    );
}

#[test]
fn lights_and_objects_among_declarations_are_refused() {
    for text in [
        "light_source { 0 rgb 1 }",
        "sphere { 0, 1 }",
        "camera { location 0 }",
    ] {
        let folder = film(
            &[("names.inc", text), ("ball.inc", "sphere { 0, 1 }")],
            "*include names.inc\n!ball 0 0 0 0 0 0",
        );
        let ended = Run::new(["plan"])
            .arg(folder.path().join("film.anim"))
            .ends();
        assert_eq!(ended.status, 3, "{text}: {}", ended.stderr);
    }
}

#[test]
fn names_with_blanks_and_accents_and_files_beside_fragments() {
    let objects = [
        (
            "une bête.inc",
            "#include \"pièce jointe.inc\"\nobject { Piece pigment { rgb <1,0.5,0> } }",
        ),
        (
            "pièce jointe.inc",
            "#declare Piece = box { -0.8, 0.8 rotate 30*y }",
        ),
        (
            "other.inc",
            "#ifdef (Piece) #error \"a name leaked\" #end sphere { 0, 0.6 pigment { rgb z } }",
        ),
    ];
    let folder = film(
        &objects,
        "!\"une bête.inc\" -1 0 0 0 0 0 0.2 0 0 0 0 0\n!other 1 0 0 0 0 0",
    );
    let render = |out: &str, extra: &[&str]| {
        let ended = Run::new(["render", "-q", "--format", "png16", "--no-fallback"])
            .arg(folder.path().join("film.anim"))
            .arg("-o")
            .arg(folder.path().join(out))
            .args(extra)
            .ends();
        assert_eq!(ended.status, 0, "{}", ended.stderr);
    };
    render("merged", &[]);
    render("plain", &["--baseline"]);
    let name = "frame_0003.png";
    let (a, b) = (
        folder.path().join("merged").join(name),
        folder.path().join("plain").join(name),
    );
    assert_eq!(differing_pixels(&a, &b), []);
}

#[test]
fn an_interrupted_run_is_resumed() {
    let folder = film(
        &[("ball.ron", "sphere(radius: 1)")],
        "!ball 0 0 0 0 0 0 0.1 0 0 0 0 0",
    );
    let out = folder.path().join("out");
    let render = |extra: &[&str]| {
        Run::new([
            "render",
            "--renderer",
            "reference",
            "--json",
            "--resume",
            "-o",
        ])
        .arg(&out)
        .arg(folder.path().join("film.anim"))
        .args(extra)
        .succeeds()
        .summary()
    };
    assert_eq!(render(&[])["frames_kept"], 0);
    std::fs::remove_file(out.join("frame_0002.png")).unwrap();
    let again = render(&[]);
    assert_eq!(again["frames_kept"], 3);
    assert!(out.join("frame_0002.png").is_file());
    // Another job keeps nothing.
    assert_eq!(render(&["--mode", "full"])["frames_kept"], 0);
}

#[test]
fn scene_files_are_kept_where_asked() {
    let folder = film(
        &[("ball.ron", "sphere(radius: 1)")],
        "!ball 0 0 0 0 0 0 0.1 0 0 0 0 0",
    );
    let keep = folder.path().join("kept");
    Run::new(["render", "-q", "--no-fallback", "-o"])
        .arg(folder.path().join("out"))
        .arg("--keep")
        .arg(&keep)
        .arg(folder.path().join("film.anim"))
        .succeeds();
    let folders: Vec<_> = std::fs::read_dir(&keep)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    assert!(
        folders
            .iter()
            .any(|f| f.join("scene.pov").is_file() && f.join("povray.log").is_file())
    );
}

#[test]
fn frames_are_told_one_by_one_and_the_summary_last() {
    let folder = film(
        &[("ball.ron", "sphere(radius: 1)")],
        "!ball 0 0 0 0 0 0 0.1 0 0 0 0 0",
    );
    let ended = Run::new(["render", "--renderer", "reference", "--json", "-o"])
        .arg(folder.path().join("out"))
        .arg(folder.path().join("film.anim"))
        .succeeds();
    let frames = ended
        .stdout
        .lines()
        .filter(|l| l.contains("\"type\":\"frame\""))
        .count();
    assert_eq!(frames, 4);
    let summary = ended.summary();
    for key in [
        "frames",
        "width",
        "height",
        "renderer",
        "mode",
        "threshold_px",
        "periods",
        "wall_s",
        "cpu_s",
        "renderer_calls",
        "renderer_frames",
        "pixels_traced",
        "pixels_full",
        "fallback",
    ] {
        assert!(!summary[key].is_null(), "{key} is missing");
    }
    for pass in ["decor", "fast", "depth", "shadow", "blocks"] {
        assert!(summary["pixels_traced"][pass].is_u64(), "{pass} is missing");
    }
    let kept = std::fs::read_to_string(folder.path().join("out/decor.json")).unwrap();
    let kept: serde_json::Value = serde_json::from_str(&kept).unwrap();
    assert_eq!(kept["job"], summary["job"]);
}

#[test]
fn plans_are_lines_of_json_too() {
    let ended = Run::new(["plan", "--json"])
        .arg(fixture("plane/plane.anim"))
        .succeeds();
    let first: serde_json::Value =
        serde_json::from_str(ended.stdout.lines().next().unwrap()).unwrap();
    assert_eq!(first["type"], "period");
    assert_eq!(first["length"], 25);
    let classes: Vec<&str> = first["objects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|o| o["class"].as_str().unwrap())
        .collect();
    assert_eq!(classes.iter().filter(|c| **c == "fast").count(), 1);
    assert!(ended.summary()["predicted_wall_s"].as_f64().unwrap() > 0.0);
}

#[test]
fn films_are_converted_there_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let (there, back) = (
        folder.path().join("film.jsonl"),
        fixture("plane/plane.anim"),
    );
    let ended = Run::new(["convert"]).arg(&back).arg(&there).succeeds();
    assert!(ended.stderr.contains("belongs there"), "{}", ended.stderr);
    // Beside the film there is nothing to say, however its name is given.
    let beside = film(&[("ball.ron", "sphere(radius: 1)")], "!ball 0 0 0 0 0 0");
    let mut run = Run::new(["convert", "film.anim", "film.jsonl"]);
    run.0.current_dir(beside.path());
    assert_eq!(run.succeeds().stderr, "");
    let lines = std::fs::read_to_string(&there).unwrap();
    assert!(
        lines
            .lines()
            .all(|line| serde_json::from_str::<serde_json::Value>(line).is_ok())
    );
}

#[test]
fn the_doctor_finds_povray_healthy() {
    let ended = Run::new(["doctor", "--json"]).succeeds();
    let povray = ended
        .stdout
        .lines()
        .find(|l| l.contains("\"name\":\"povray\""))
        .unwrap();
    let povray: serde_json::Value = serde_json::from_str(povray).unwrap();
    assert_eq!(povray["found"], true);
    assert!(
        povray["checks"]
            .as_array()
            .unwrap()
            .iter()
            .all(|c| c["ok"] == true),
        "{povray}"
    );
    assert_eq!(ended.summary()["broken"], 0);
}

#[test]
fn the_reference_renderer_needs_no_installation() {
    let folder = tempfile::tempdir().unwrap();
    for (out, extra) in [("merged", "--no-fallback"), ("plain", "--baseline")] {
        Run::new([
            "render",
            "-q",
            "--renderer",
            "reference",
            "--format",
            "png16",
            extra,
            "-o",
        ])
        .arg(folder.path().join(out))
        .arg(fixture("contact/contact.anim"))
        .env("PATH", "/nowhere")
        .succeeds();
    }
    for frame in 0..12 {
        let name = format!("frame_{frame:04}.png");
        let (a, b) = (
            folder.path().join("merged").join(&name),
            folder.path().join("plain").join(&name),
        );
        assert_eq!(differing_pixels(&a, &b), [], "{name}");
    }
}

#[test]
fn povray_missing_and_not_needed() {
    // Without POV-Ray a neutral film is drawn in-process, and says so; one of
    // fragments is refused.
    let folder = tempfile::tempdir().unwrap();
    let render = |film: &str| {
        let mut run = Run::new(["render", "-q", "-o"])
            .arg(folder.path().join("out"))
            .arg(fixture(film));
        run.0.env("PATH", "/nowhere").env_remove("DECOR_POVRAY");
        run.ends()
    };
    let drawn = render("contact/contact.anim");
    assert_eq!(drawn.status, 0, "{}", drawn.stderr);
    assert!(
        drawn.stderr.contains("reference renderer instead"),
        "{}",
        drawn.stderr
    );
    let refused = render("plane/plane.anim");
    assert_eq!(refused.status, 4, "{}", refused.stderr);
    assert!(
        refused.stderr.contains("apt-get install povray"),
        "{}",
        refused.stderr
    );
}

#[test]
fn a_frame_is_explained_in_words_json_and_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("why.png");
    let explain = || {
        Run::new([
            "explain",
            "--renderer",
            "reference",
            "--no-fallback",
            "--frame",
            "6",
        ])
        .arg(fixture("contact/contact.anim"))
    };
    let words = explain().arg("-o").arg(&picture).succeeds().stdout;
    assert!(
        words
            .lines()
            .any(|l| l.starts_with("slider ") && l.contains(" fast ") && l.contains("px >")),
        "{words}"
    );
    assert!(
        words
            .lines()
            .any(|l| l.contains(" immobile ") && l.contains("does not move")),
        "{words}"
    );
    let (width, height, pixels) = common::pixels(&picture);
    assert_eq!(width, 800);
    assert!(height > 600, "the legend is below the frame");
    // The colours of the classes that the frame has.
    for colour in [[120, 170, 255], [255, 80, 40]] {
        assert!(
            pixels.iter().filter(|p| **p == colour).count() > 200,
            "{colour:?}"
        );
    }
    let json = explain().args(["--json", "--object", "slider"]).succeeds();
    assert_eq!(json.summary()["objects"], 1);
    let object: serde_json::Value =
        serde_json::from_str(json.stdout.lines().next().unwrap()).unwrap();
    assert_eq!(object["class"], "fast");
    let number = |key: &str| object[key].as_f64().unwrap();
    assert!(
        number("translation_px") > 1.0 && number("area_px") > 10.0,
        "{object}"
    );
    assert!(number("rotation_px") < 1e-9, "it slides: {object}");

    assert_eq!(explain().args(["--object", "nobody"]).ends().status, 64);
    let beyond = Run::new(["explain", "--frame", "99"])
        .arg(fixture("contact/contact.anim"))
        .ends();
    assert_eq!(beyond.status, 3);
}

#[test]
fn the_threshold_decides_what_is_kept() {
    let film = film(
        &[("ball.ron", "sphere(radius: 1)")],
        "!ball 1.5 0 0 0 0 0 0.02 0 0 0 0 0\n!ball -2 0 3 0 0 0 name=still",
    );
    let class = |extra: &[&str]| {
        let ended = Run::new(["plan", "--json", "--renderer", "reference", "--no-fallback"])
            .arg(film.path().join("film.anim"))
            .args(extra)
            .succeeds();
        let first: serde_json::Value =
            serde_json::from_str(ended.stdout.lines().next().unwrap()).unwrap();
        let objects = first["objects"].as_array().unwrap().clone();
        let ball = objects.iter().find(|o| o["name"] == "ball#0").unwrap();
        (
            ball["class"].as_str().unwrap().to_owned(),
            first["threshold_px"].as_f64().unwrap(),
        )
    };
    // 0.06 in three frames, at 69 pixels of focal length and a distance of 5 to
    // the front of the ball: 0.8 pixels.
    assert_eq!(class(&["--threshold", "2"]), ("slow".into(), 2.0));
    assert_eq!(
        class(&["--threshold", "2", "--measure", "thesis"]),
        ("slow".into(), 2.0)
    );
    assert_eq!(class(&["--threshold", "0.1"]), ("fast".into(), 0.1));
    assert_eq!(class(&["--mode", "exact"]), ("fast".into(), 0.0));
    assert_eq!(class(&["--mode", "preview"]), ("slow".into(), 4.0));
}
