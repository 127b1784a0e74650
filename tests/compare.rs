//! `decor compare`, the program: exit statuses, and what it prints.

use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::*;

fn png(path: &Path, (width, height): (u32, u32), value: u8) {
    let mut picture = image::RgbImage::from_pixel(width, height, image::Rgb([100; 3]));
    picture.put_pixel(1, 1, image::Rgb([value, 100, 100]));
    picture.save(path).unwrap();
}

fn decor_compare(folder: &Path, args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("decor")
        .unwrap()
        .current_dir(folder)
        .arg("compare")
        .args(args)
        .assert()
}

#[test]
fn every_exit_status() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    png(&at("a.png"), (4, 4), 100);
    png(&at("b.png"), (4, 4), 120);
    png(&at("wide.png"), (5, 4), 100);
    std::fs::write(at("broken.png"), b"\x89PNG").unwrap();
    std::fs::create_dir(at("empty")).unwrap();
    std::fs::write(at("file"), b"").unwrap();
    let status = |args: &[&str], code: i32| {
        decor_compare(folder.path(), args).code(code);
    };
    status(&["a.png", "a.png"], 0);
    status(&["a.png", "b.png"], 2);
    status(&["a.png", "b.png", "--fail", "0.1"], 0);
    status(&["a.png", "b.png", "--fail", "0.1", "--warn", "0.01"], 1);
    status(
        &["a.png", "b.png", "--fail", "0.1", "--hard-warn", "0.01"],
        1,
    );
    status(
        &["a.png", "b.png", "--fail", "0.1", "--warn-percent", "5"],
        1,
    );
    status(&["a.png", "b.png", "--fail-percent", "7"], 0);
    status(
        &[
            "a.png",
            "b.png",
            "--fail-percent",
            "7",
            "--hard-fail",
            "0.05",
        ],
        2,
    );
    status(&["a.png", "wide.png"], 3);
    status(&["a.png", "empty"], 3);
    status(&["empty", "empty"], 3);
    status(&["a.png", "broken.png"], 4);
    status(&["a.png", "none.png"], 4);
    status(&["a.png", "b.png", "--diff", "file/x"], 5);
    status(&["a.png", "b.png", "--fail", "-1"], 64);
    status(&["a.png", "b.png", "--fail", "nan"], 64);
    status(&["a.png", "b.png", "--fail-percent", "101"], 64);
    status(&["a.png"], 64);
}

#[test]
fn json_lines_end_with_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    for side in ["a", "b"] {
        let side = folder.path().join(side);
        std::fs::create_dir(&side).unwrap();
        for k in 0..10 {
            png(&side.join(format!("frame_{k:04}.png")), (4, 4), 100);
        }
    }
    png(&folder.path().join("b/frame_0007.png"), (4, 4), 102);
    let output = decor_compare(folder.path(), &["a", "b", "--json", "--diff", "d"]).code(2);
    let text = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    let lines: Vec<serde_json::Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 11);
    for (k, line) in lines[..10].iter().enumerate() {
        assert_eq!(line["type"], "pair");
        assert_eq!(line["name"], format!("frame_{k:04}.png"));
        assert_eq!(line["verdict"], if k == 7 { "failed" } else { "within" });
        assert!(folder.path().join(line["diff"].as_str().unwrap()).is_file());
    }
    assert!(lines[0]["psnr"].is_null());
    assert_eq!(lines[7]["differing"], 1);
    assert_eq!(lines[7]["share_above"], 1.0 / 16.0);
    let summary = &lines[10];
    assert_eq!(
        (&summary["type"], &summary["verdict"]),
        (&"summary".into(), &"failed".into())
    );
    assert_eq!(summary["worst"]["name"], "frame_0007.png");
    assert_eq!(summary["max"], 2.0 / 255.0);
}

#[test]
fn in_words() {
    let folder = tempfile::tempdir().unwrap();
    png(&folder.path().join("a.png"), (4, 4), 100);
    png(&folder.path().join("b.png"), (4, 4), 151);
    decor_compare(folder.path(), &["a.png", "a.png"])
        .success()
        .stdout(predicate::str::ends_with("within: 1 pair, identical\n"));
    decor_compare(folder.path(), &["a.png", "b.png"])
        .code(2)
        .stdout(predicate::str::contains("(1, 1) R 0.39215687 / 0.5921569"))
        .stdout(predicate::str::contains("\nfailed: 1 pair;"));
    decor_compare(folder.path(), &["--help"])
        .success()
        .stdout(predicate::str::contains("Exit status: 0 within"));
}
