//! decor's own memory does not grow with the film: what is kept is a décor or
//! two, never the frames. It is the resident memory of decor alone: neither the
//! renderer's, nor the renderer's files, wherever these lie.
#![cfg(target_os = "linux")]

mod common;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use common::fixture;

/// The bundled airplane in so many frames, of so many pixels a side where that is
/// stated: the film's file.
fn longer(folder: &Path, frames: u32, side: Option<u32>) -> std::path::PathBuf {
    let source = fixture("plane");
    for entry in std::fs::read_dir(&source).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
    }
    let text = std::fs::read_to_string(source.join("plane.anim")).unwrap();
    let film = folder.join("longer.anim");
    let mut text = replaced(&text, "*images 25\n", &format!("*images {frames}\n"));
    if let Some(side) = side {
        text = replaced(&text, "*size 320 240\n", &format!("*size {side} {side}\n"));
    }
    std::fs::write(&film, text).unwrap();
    film
}

fn replaced(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "{old}");
    text.replace(old, new)
}

/// The peak of decor's own memory while it renders so many frames, in KiB.
fn peak_kib(frames: u32, side: Option<u32>, options: &[&str]) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let film = longer(folder.path(), frames, side);
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("decor"))
        .args(["render", "-q", "--no-fallback", "--jobs", "8", "-o"])
        .arg(folder.path().join("out"))
        .args(options)
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
    let (short, long) = (peak_kib(25, None, &[]), peak_kib(100, None, &[]));
    // One frame of 320 by 240 takes 1.8 MiB as colour and depth: 75 more would
    // be 135 MiB.
    assert!(long < short + 16 * 1024, "{short} KiB, then {long} KiB");
}

/// What the issue promises: 64 bytes a pixel. One frame as colour and depth, all
/// in memory, would be 24 of them, and several are under way at once.
#[test]
fn a_large_picture_takes_64_bytes_a_pixel() {
    const SIDE: u32 = 1024;
    for (frames, mode) in [(4, "full"), (12, "exact"), (12, "equivalent")] {
        let kib = peak_kib(frames, Some(SIDE), &["--mode", mode]);
        let bytes = kib * 1024 / u64::from(SIDE * SIDE);
        assert!(bytes < 64, "{mode}: {bytes} bytes a pixel");
    }
}
