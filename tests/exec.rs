//! The whole program with a renderer that is not built in: the example of the
//! protocol, by name.

mod common;

use std::path::Path;

use common::{Run, differing_pixels};

const FILM: &str = "\
*size 96 64
*images 4
*shadows 1
*eye 0 2 -8
*aim 0 0 0
*angles 50 34
*background 0.1 0.2 0.4
*light 6 9 -7  0.9 0.9 0.9  point
!ball.ron   -2 0 0    0 0 0
!crate.ron  2 0 1     0 30 0
!ball.ron   0 1 -1    0 0 0  0.5 0 0.1  0 0 0  name=mover
";

/// A folder with a film, and the example with a part of its text replaced.
fn stage(abilities: (&str, &str)) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("film.anim"), FILM).unwrap();
    for (name, solid) in [
        ("ball", "sphere(radius: 0.8)"),
        ("crate", "box(min: (-1, -1, -1), max: (1, 1, 1))"),
    ] {
        let file = folder.path().join(format!("{name}.ron"));
        std::fs::write(file, solid).unwrap();
    }
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("adapters/exec/example/raycast.py");
    let text = std::fs::read_to_string(example).unwrap();
    assert!(text.contains(abilities.0));
    let program = folder.path().join("renderer.py");
    std::fs::write(&program, text.replace(abilities.0, abilities.1)).unwrap();
    let renderer = format!("exec:python3 '{}'", program.display());
    (folder, renderer)
}

fn render(folder: &Path, renderer: &str, out: &str, options: &[&str]) -> serde_json::Value {
    let run = Run::new([
        "render",
        "--json",
        "--renderer",
        renderer,
        "--format",
        "png16",
    ]);
    let run = run
        .arg(folder.join("film.anim"))
        .arg("-o")
        .arg(folder.join(out));
    run.args(options).succeeds().summary()
}

fn compare(folder: &Path, a: &str, b: &str) {
    for frame in 0..4 {
        let file = |out: &str| folder.join(out).join(format!("frame_{frame:04}.png"));
        assert_eq!(differing_pixels(&file(a), &file(b)), [], "frame {frame}");
    }
}

#[test]
fn exact_is_what_the_program_alone_gives() {
    let (folder, renderer) = stage(("\"crop_grid\": 1", "\"crop_grid\": 1"));
    render(folder.path(), &renderer, "plain", &["--baseline"]);
    let said = render(
        folder.path(),
        &renderer,
        "exact",
        &["--mode", "exact", "--no-fallback"],
    );
    // It masks no blocks: they lie in windows, and not all is drawn again.
    let traced = said["pixels_traced"]["blocks"].as_u64().unwrap();
    assert!(
        traced > 0 && traced < said["pixels_full"].as_u64().unwrap(),
        "{said}"
    );
    compare(folder.path(), "plain", "exact");
}

#[test]
fn a_program_whose_windows_are_their_own_renders_whole_frames() {
    let (folder, renderer) = stage(("\"crop_grid\": 1", "\"crop_grid\": None"));
    render(folder.path(), &renderer, "plain", &["--baseline"]);
    let said = render(
        folder.path(),
        &renderer,
        "exact",
        &["--mode", "exact", "--no-fallback"],
    );
    assert_eq!(
        said["pixels_traced"]["whole"], said["pixels_full"],
        "{said}"
    );
    let why = said["periods"][0]["whole"].as_str().unwrap();
    assert!(why.contains("this renderer draws no"), "{why}");
    compare(folder.path(), "plain", "exact");
}

#[test]
fn the_doctor_examines_a_program() {
    let (_folder, renderer) = stage(("\"crop_grid\": 1", "\"crop_grid\": 1"));
    let well = Run::new(["doctor", "--renderer", &renderer]).succeeds();
    assert!(
        well.stdout.contains("ok    the depth of a sphere"),
        "{}",
        well.stdout
    );
    let (_folder, renderer) = stage(("NEAREST = 1e-9", "NEAREST = 4.5"));
    let ill = Run::new(["doctor", "--renderer", &renderer]).ends();
    assert_eq!(
        (ill.status, ill.stdout.contains("FAIL")),
        (4, true),
        "{}",
        ill.stdout
    );
    let gone = Run::new(["doctor", "--renderer", "exec:no-such-program"]).ends();
    assert_eq!(gone.status, 4, "{}", gone.stderr);
}
