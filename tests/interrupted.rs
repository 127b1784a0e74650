//! Ctrl-C, and a wish to end, in the middle of the work: status 130, no process,
//! no working file, no half-written frame; what is there is whole, and is kept by
//! `--resume`.
#![cfg(target_os = "linux")]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::fixture;

/// Nothing here takes so long, also on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// decor at work in a temporary folder of its own.
struct Work {
    folder: tempfile::TempDir,
    child: Child,
}

impl Work {
    fn begin(film: &Path, options: &[&str]) -> Self {
        Self::resume(tempfile::tempdir().unwrap(), film, options)
    }

    fn resume(folder: tempfile::TempDir, film: &Path, options: &[&str]) -> Self {
        let temporary = folder.path().join("tmp");
        std::fs::create_dir_all(&temporary).unwrap();
        let child = Command::new(assert_cmd::cargo::cargo_bin("decor"))
            .arg("render")
            .arg(film)
            .args(["--json", "-o"])
            .arg(folder.path().join("out"))
            .args(options)
            .env("TMPDIR", &temporary)
            .env("DECOR_CACHE", folder.path().join("cache"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        Self { folder, child }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// Frames that are in their places.
    fn frames(&self) -> Vec<PathBuf> {
        let Ok(entries) = std::fs::read_dir(self.out()) else {
            return Vec::new();
        };
        let paths = entries.map(|entry| entry.unwrap().path());
        paths
            .filter(|path| path.extension().is_some_and(|e| e == "png"))
            .collect()
    }

    /// Renderers that decor has started: processes with its folder for temporary
    /// files in their environment.
    fn renderers(&self) -> Vec<i32> {
        let mark = format!("TMPDIR={}", self.folder.path().join("tmp").display());
        let processes = std::fs::read_dir("/proc").unwrap().flatten();
        let numbers = processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        numbers
            .filter(|&pid: &i32| pid != self.child.id().cast_signed())
            .filter(|pid| {
                let environment = std::fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
                environment
                    .split(|&byte| byte == 0)
                    .any(|word| word == mark.as_bytes())
            })
            .collect()
    }

    /// Waits until it is so.
    fn until(&mut self, what: &str, mut is_so: impl FnMut(&mut Self) -> bool) {
        let begun = Instant::now();
        while !is_so(self) {
            assert!(begun.elapsed() < PATIENCE, "{what}: never");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Sends a signal in the middle of the work; nothing may be left.
    fn stop(mut self, signal: &str) -> tempfile::TempDir {
        self.until("some frames and some renderers", |work| {
            assert!(
                work.child.try_wait().unwrap().is_none(),
                "it has ended by itself"
            );
            !work.frames().is_empty() && work.renderers().len() > 1
        });
        let pid = self.child.id().to_string();
        let sent = Command::new("kill").args([signal, &pid]).status().unwrap();
        assert!(sent.success());
        self.until("the end", |work| work.child.try_wait().unwrap().is_some());
        assert_eq!(self.child.wait().unwrap().code(), Some(130));
        assert_eq!(self.renderers(), Vec::<i32>::new());
        let temporary = std::fs::read_dir(self.folder.path().join("tmp")).unwrap();
        let left: Vec<_> = temporary.map(|entry| entry.unwrap().path()).collect();
        assert!(left.is_empty(), "{left:?}");
        for entry in std::fs::read_dir(self.out()).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            assert!(!name.ends_with(".part"), "{name}");
        }
        for frame in self.frames() {
            image::open(&frame).unwrap_or_else(|error| panic!("{}: {error}", frame.display()));
        }
        self.folder
    }
}

#[test]
fn ctrl_c_ends_a_film_and_all_renderers() {
    let film = fixture("plane/plane.anim");
    let options = ["--mode", "full", "--jobs", "4", "--frames", "0-24"];
    let folder = Work::begin(&film, &options).stop("-INT");
    // What is there is kept.
    let kept = Work::resume(folder, &film, &[&options[..], &["--resume"]].concat());
    let mut kept = kept;
    assert!(kept.child.wait().unwrap().success());
    assert_eq!(kept.frames().len(), 25);
    let text = std::fs::read_to_string(kept.out().join("decor.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(summary["frames_kept"].as_u64().unwrap() > 0, "{text}");
}

#[test]
fn a_wish_to_end_is_ctrl_c() {
    let film = fixture("plane/plane.anim");
    Work::begin(&film, &["--mode", "full", "--jobs", "4"]).stop("-TERM");
}

#[test]
fn ctrl_c_ends_a_plain_scene_and_all_renderers() {
    let scene = tempfile::tempdir().unwrap();
    let path = scene.path().join("turning.pov");
    let text = "camera { location <0, 1, -4> look_at 0 }\n\
                light_source { <4, 5, -4> rgb 1 }\n\
                plane { y, -1 pigment { checker rgb 1 rgb <0.2, 0.3, 0.4> } finish { reflection 0.4 } }\n\
                box { -0.7, 0.7 rotate 360 * clock * y pigment { rgb <1, 0.5, 0.1> } }\n";
    std::fs::write(&path, text).unwrap();
    let switches = [
        "--jobs", "4", "--", "+KFF40", "+W240", "+H180", "+A0.1", "+AM2", "+R4",
    ];
    Work::begin(&path, &switches).stop("-INT");
}
