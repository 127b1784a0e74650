//! A renderer that is missing, killed, hanging, or that writes too little: a
//! clear error with status 4, no half-written frame, no process left behind.

mod common;

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use common::{Run, fixture};

/// A program that says it is POV-Ray, and then does as `script` says.
fn fake(folder: &Path, script: &str) -> PathBuf {
    let path = folder.join("povray");
    let text = format!(
        "#!/bin/sh\nif [ \"$1\" = --version ]; then echo 'POV-Ray 3.7.0.10' >&2; exit 0; fi\n{script}\n"
    );
    std::fs::write(&path, text).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

struct Fault {
    stderr: String,
    folder: tempfile::TempDir,
}

/// Renders `contact` with a fake renderer: it must fail with status 4 and leave
/// no frame behind.
fn fails(script: &str, extra: &[&str]) -> Fault {
    let folder = tempfile::tempdir().unwrap();
    let program = fake(folder.path(), script);
    let out = folder.path().join("out");
    let temporary = folder.path().join("tmp");
    std::fs::create_dir(&temporary).unwrap();
    let ended = Run::new(["render"])
        .arg(fixture("contact/contact.anim"))
        .arg("-o")
        .arg(&out)
        .args(["--no-fallback"])
        .args(extra)
        .env("DECOR_POVRAY", &program)
        .env("TMPDIR", &temporary)
        .env("FAKE_FOLDER", folder.path())
        .ends();
    assert_eq!(ended.status, 4, "{}", ended.stderr);
    let left: Vec<_> = std::fs::read_dir(&temporary)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    assert!(left.is_empty(), "temporary files are left: {left:?}");
    if let Ok(entries) = std::fs::read_dir(&out) {
        let frames: Vec<_> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .filter(|name| name.starts_with("frame_") || name.ends_with(".part"))
            .collect();
        assert!(frames.is_empty(), "frames are left: {frames:?}");
    }
    Fault {
        stderr: ended.stderr,
        folder,
    }
}

/// The stderr without the line breaks of its layout.
fn words(text: &str) -> String {
    text.replace(['│', '\n'], " ")
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}

#[test]
fn missing() {
    let folder = tempfile::tempdir().unwrap();
    let ended = Run::new(["render"])
        .arg(fixture("contact/contact.anim"))
        .arg("-o")
        .arg(folder.path().join("out"))
        .env("DECOR_POVRAY", "/no/such/povray")
        .ends();
    assert_eq!(ended.status, 4);
    let said = words(&ended.stderr);
    assert!(said.contains("/no/such/povray was not found"), "{said}");
    assert!(said.contains("apt-get install povray"), "{said}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn killed() {
    let fault = fails("echo half a frame >&2; kill -9 $$", &[]);
    let said = words(&fault.stderr);
    assert!(said.contains("povray failed (signal: 9"), "{said}");
    assert!(said.contains("half a frame"), "{said}");
}

#[test]
fn failing() {
    let said = words(&fails("echo 'Parse Error: no such thing' >&2; exit 1", &[]).stderr);
    assert!(
        said.contains("exit status: 1") && said.contains("no such thing"),
        "{said}"
    );
}

#[test]
fn hanging() {
    let script = "sleep 600 & echo $! >> \"$FAKE_FOLDER/children\"; echo $$ >> \"$FAKE_FOLDER/children\"; wait";
    let fault = fails(script, &["--timeout", "1"]);
    let said = words(&fault.stderr);
    assert!(
        said.contains("did not finish") && said.contains("within 1 s"),
        "{said}"
    );
    let children = std::fs::read_to_string(fault.folder.path().join("children")).unwrap();
    assert!(children.lines().count() >= 2);
    for pid in children.lines() {
        // Killed is not yet gone: the kernel has a moment.
        let gone = (0..200).any(|_| {
            let stat = std::fs::read_to_string(format!("/proc/{pid}/stat"));
            let alive = stat.is_ok_and(|stat| !stat.contains(") Z"));
            if alive {
                std::thread::sleep(std::time::Duration::from_millis(20));
            }
            !alive
        });
        assert!(gone, "process {pid} is left behind");
    }
}

#[test]
fn silent() {
    // It ends well and writes nothing: no picture, and the state file stays empty.
    for (format, reason) in [("png", "cannot be read"), ("exr", "pixels are missing")] {
        let said = words(&fails("exit 0", &["--format", format]).stderr);
        assert!(
            said.contains("povray wrote") && said.contains(reason),
            "{said}"
        );
    }
}

#[test]
fn short() {
    // It writes half a record into every state file.
    let linear = ["--format", "exr"];
    let script = "for f in *.kept; do printf 'POVRAYMS\\000\\000\\003\\160' >> $f; done; exit 0";
    let said = words(&fails(script, &linear).stderr);
    assert!(said.contains("povray wrote"), "{said}");
}

#[test]
fn garbled() {
    let script = "for f in *.kept; do echo 'this is no render state file' > $f; done; exit 0";
    let said = words(&fails(script, &["--format", "exr"]).stderr);
    assert!(said.contains("it is not a render state file"), "{said}");
}

#[test]
fn a_full_or_forbidden_target_is_status_5() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    std::fs::write(&out, "a file where a folder should be").unwrap();
    let ended = Run::new(["render", "--renderer", "reference"])
        .arg(fixture("contact/contact.anim"))
        .arg("-o")
        .arg(&out)
        .ends();
    assert_eq!(ended.status, 5, "{}", ended.stderr);
}
