//! Programs that die, hang or do nothing: another one in the renderer's place.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::Subject;
use super::stage::{Room, Stage, assert_no_process_in, sphere, whole};
use crate::adapter::{AdapterError, Output};

/// What stands in for the renderer.
const NAME: &str = "stand-in";

/// Draws with a shell script in the renderer's place; the error that follows.
fn with_script(subject: &Subject, room: &Room, script: &str, output: Output) -> AdapterError {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(NAME);
    // It works in its own folder: that is how what it leaves behind is found.
    let script = format!("#!/bin/sh\ncd \"$(dirname \"$0\")\"\n{script}\n");
    write_program(&path, &script);
    let error = draw(subject, room, &path, output);
    assert_no_process_in(folder.path());
    error
}

/// Written by another process: a thread of this one that starts a program at the
/// same time would hand it the open file, and Linux starts no file that is open
/// for writing.
fn write_program(path: &Path, script: &str) {
    let written = Command::new("/bin/sh")
        .args(["-c", "printf %s \"$2\" >\"$1\" && chmod 755 \"$1\"", "sh"])
        .arg(path)
        .arg(script)
        .status()
        .expect("a shell");
    assert!(written.success(), "no script could be written");
}

fn draw(subject: &Subject, room: &Room, path: &Path, output: Output) -> AdapterError {
    let adapter = subject.around(path);
    let stage = Stage::of([sphere(0.0, 0.0, 0.0, 2.0)]);
    let shots = (0..2).map(|k| stage.shot(k, whole(stage.size))).collect();
    let result = adapter.render(&stage.request(output, shots), &room.run);
    room.assert_empty();
    match result {
        Err(error) => error,
        Ok(_) => panic!("no renderer was there, and yet something was drawn"),
    }
}

/// Its last words and its exit status are in the message.
pub fn a_program_that_fails_is_quoted(subject: &Subject) {
    let script = "echo its last words >&2; exit 3";
    for output in [Output::ColourOverBackground, Output::Depth] {
        let error = with_script(subject, &Room::plain(), script, output);
        assert!(matches!(error, AdapterError::Failed { .. }), "{error}");
        let message = error.to_string();
        assert!(message.contains("its last words"), "{message}");
        assert!(message.contains('3'), "{message}");
        assert!(message.contains(NAME), "{message}");
    }
}

/// A signal is no success.
pub fn a_program_that_is_killed_is_a_failure(subject: &Subject) {
    let error = with_script(subject, &Room::plain(), "kill -9 $$", Output::Depth);
    assert!(matches!(error, AdapterError::Failed { .. }), "{error}");
    assert!(error.to_string().contains("signal"), "{error}");
}

/// The whole group goes, and what it said is in the message.
pub fn a_program_that_hangs_is_stopped_with_its_children(subject: &Subject) {
    let mut room = Room::plain();
    room.run.timeout = Duration::from_millis(500);
    let started = Instant::now();
    let script = "echo waiting for nothing >&2; sleep 300 & sleep 300; wait";
    let error = with_script(subject, &room, script, Output::Depth);
    assert!(matches!(error, AdapterError::TimedOut { .. }), "{error}");
    assert!(error.to_string().contains("waiting for nothing"), "{error}");
    assert!(
        started.elapsed() < Duration::from_secs(20),
        "that took long"
    );
}

/// Nobody waits for a program that will not end.
pub fn a_program_that_hangs_can_be_cancelled(subject: &Subject) {
    let room = Room::plain();
    let cancel = std::sync::Arc::clone(&room.run.cancel);
    let started = Instant::now();
    let watch = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(300));
        cancel.store(true, Ordering::Relaxed);
    });
    let error = with_script(subject, &room, "sleep 300 & sleep 300", Output::Depth);
    watch.join().expect("the watch");
    assert!(matches!(error, AdapterError::Cancelled), "{error}");
    assert!(
        started.elapsed() < Duration::from_secs(20),
        "that took long"
    );
}

/// A program that ends well has still to leave a picture.
pub fn a_program_that_writes_nothing_is_found_out(subject: &Subject) {
    for output in [Output::ColourOverBackground, Output::Depth] {
        let error = with_script(subject, &Room::plain(), "exit 0", output);
        assert!(matches!(error, AdapterError::BadOutput { .. }), "{error}");
    }
}

/// It was there when it was found, and is gone.
pub fn a_program_that_is_not_there_is_an_error(subject: &Subject) {
    let path = Path::new("/nowhere/at all/stand-in");
    let error = draw(subject, &Room::plain(), path, Output::Depth);
    let typed = matches!(
        error,
        AdapterError::Start { .. } | AdapterError::Missing { .. }
    );
    assert!(typed, "{error}");
    assert!(error.to_string().contains(NAME), "{error}");
}
