//! decor's own memory does not grow with the film: what is kept is a décor or
//! two, never the frames.
#![cfg(target_os = "linux")]

mod common;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use common::fixture;

/// The bundled airplane in so many frames: the film's file.
fn longer(folder: &Path, frames: u32) -> std::path::PathBuf {
    let source = fixture("plane");
    for entry in std::fs::read_dir(&source).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
    }
    let text = std::fs::read_to_string(source.join("plane.anim")).unwrap();
    assert!(text.contains("*images 25\n"));
    let film = folder.join("longer.anim");
    let text = text.replace("*images 25\n", &format!("*images {frames}\n"));
    std::fs::write(&film, text).unwrap();
    film
}

/// The peak of decor's own memory while it renders so many frames, in KiB.
fn peak_kib(frames: u32) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let film = longer(folder.path(), frames);
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("decor"))
        .args(["render", "-q", "--no-fallback", "--jobs", "8", "-o"])
        .arg(folder.path().join("out"))
        .arg(&film)
        .env("DECOR_CACHE", folder.path().join("cache"))
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
        peak = kib.unwrap_or(peak);
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(child.wait().unwrap().success());
    assert!(peak > 0);
    peak
}

#[test]
fn memory_does_not_grow_with_the_film() {
    let (short, long) = (peak_kib(25), peak_kib(100));
    // One frame of 320 by 240 takes 1.8 MiB as colour and depth: 75 more would
    // be 135 MiB.
    assert!(long < short + 16 * 1024, "{short} KiB, then {long} KiB");
}
