//! POV-Ray's own animations, and heavy scenes of its own with something that
//! moves.

use std::path::{Path, PathBuf};

use crate::trial::{ALWAYS, both};

fn examples() -> PathBuf {
    let folder = PathBuf::from("/usr/share/doc/povray/examples");
    assert!(
        folder.is_dir(),
        "install Debian's povray-examples: {} is missing",
        folder.display()
    );
    folder
}

/// Each animation: how many of its blocks may change, at most.
#[test]
fn animations_of_the_examples() {
    const ANIMATIONS: &[(&str, f64)] = &[
        ("clockd", 0.7),
        ("ambient", 0.95),
        ("vect1", 0.95),
        ("float3", 0.95),
        ("speclr", 0.95),
    ];
    std::thread::scope(|scope| {
        for (name, most) in ANIMATIONS {
            scope.spawn(move || {
                let folder = examples().join("animations").join(name);
                let work = tempfile::tempdir().unwrap();
                let switches = ["+W160", "+H120", "+SF1", "+EF6"];
                let ini = format!("{name}.ini");
                let tried = both(&folder, &ini, &switches, ALWAYS, work.path());
                tried.assert_identical(name);
                assert_eq!(tried.whole(), "", "{name}");
                let dirty = tried.summary["dirty_blocks"].as_f64().unwrap();
                assert!(dirty <= *most, "{name}: {dirty}");
                println!("{name}: {:.1} % dirty", 100.0 * dirty);
            });
        }
    });
}

/// Scenes of the folder `advanced`, with a ball that crosses the picture.
#[test]
fn heavy_scenes_with_something_that_moves() {
    const SCENES: &[(&str, &str)] = &[
        (
            "woodbox.pov",
            "sphere { <-1 + 2 * clock, 1, -1>, .1 pigment { rgb y } }",
        ),
        (
            "glasschess/glasschess.pov",
            "sphere { <0, clock, 0>, .4 pigment { rgb z } }",
        ),
    ];
    std::thread::scope(|scope| {
        for (scene, moving) in SCENES {
            scope.spawn(move || with_something_that_moves(scene, moving));
        }
    });
}

fn with_something_that_moves(scene: &str, moving: &str) {
    let source = examples().join("advanced").join(scene);
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(source.parent().unwrap()).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    let name = Path::new(scene).file_name().unwrap().to_str().unwrap();
    let mut text = std::fs::read(&source).unwrap();
    text.extend_from_slice(format!("\n{moving}\n").as_bytes());
    std::fs::write(folder.path().join(name), text).unwrap();
    let switches = ["+W128", "+H96", "+KFF4", "+A0.3"];
    let tried = both(
        folder.path(),
        name,
        &switches,
        ALWAYS,
        &folder.path().join("out"),
    );
    tried.assert_identical(scene);
    println!(
        "{scene}: {} {}",
        tried.summary["dirty_blocks"],
        tried.whole()
    );
}
