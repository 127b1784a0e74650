//! What an adapter cannot do, or may not go on with, is a typed error.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::Subject;
use super::stage::{Room, Stage, dull, lamp, sphere, whole};
use crate::adapter::{Adapter, AdapterError, LayerRequest, Output};
use crate::bounds::Bounds;
use crate::prototype::{Fragment, Geometry, Optics, Prototype};
use crate::scene::{Instance, NativeFile, Pose};

/// A language that nobody reads.
const LANGUAGE: &str = "no-such-language";

fn native() -> NativeFile {
    NativeFile {
        path: format!("film/thing.{LANGUAGE}").into(),
        root: "film".into(),
        text: b"\x00 \xff neither text nor { a scene".to_vec(),
    }
}

fn assert_unsupported<T>(result: Result<T, AdapterError>, what: &str) {
    match result {
        Err(AdapterError::Unsupported { .. }) => {}
        Err(other) => panic!("{what}: refused, but not as unsupported: {other}"),
        Ok(_) => panic!("{what}: not refused"),
    }
}

/// Text and picture are both refused, by both halves of the adapter.
fn assert_both_refuse(adapter: &dyn Adapter, request: &LayerRequest<'_>, what: &str) {
    let room = Room::plain();
    assert_unsupported(adapter.scene_text(request), what);
    assert_unsupported(adapter.render(request, &room.run), what);
    room.assert_empty();
}

/// A fragment in a language that the abilities do not name.
pub fn fragments_of_another_language_are_refused(subject: &Subject) {
    let adapter = subject.adapter();
    let fragment = Fragment {
        file: native(),
        language: LANGUAGE.into(),
    };
    let room = Room::plain();
    let said = adapter.inspect(&[&fragment], &[], &room.run);
    assert_unsupported(said, "a look at an unknown language");
    let mut stage = Stage::empty();
    let prototype = stage.prototypes.insert(Prototype {
        path: fragment.file.path.clone(),
        hash: "0123456789abcdef".into(),
        geometry: Geometry::Fragment(fragment),
        bounds: Bounds::Unbounded,
        optics: Optics::Opaque,
        extents: Vec::new(),
        unlayerable: None,
    });
    let pose = Pose::IDENTITY;
    stage.scene.instances.push(Instance { prototype, pose });
    for output in [Output::ColourOverBackground, Output::Depth] {
        let request = stage.request(output, vec![stage.shot(0, whole(stage.size))]);
        assert_both_refuse(&*adapter, &request, "an unknown language");
    }
}

/// An adapter that reads no fragments reads no declarations and no sky either.
pub fn surroundings_of_no_known_language_are_refused(subject: &Subject) {
    let adapter = subject.adapter();
    if !adapter.abilities().fragments.is_empty() {
        // Declarations are in the one language that it reads.
        return;
    }
    let file = native();
    let declared = std::slice::from_ref(&file);
    assert_unsupported(adapter.surroundings(declared, None), "declarations");
    assert_unsupported(adapter.surroundings(&[], Some(&file)), "a sky");
    assert!(adapter.surroundings(&[], None).is_ok(), "nothing is around");
    let mut stage = Stage::of([sphere(0.0, 0.0, 0.0, 1.0)]);
    stage.scene.includes.push(file.clone());
    let shots = vec![stage.shot(0, whole(stage.size))];
    let request = stage.request(Output::ColourOverBackground, shots);
    assert_both_refuse(&*adapter, &request, "declarations");
    stage.scene.includes.clear();
    stage.scene.sky = Some(file);
    let shots = vec![stage.shot(0, whole(stage.size))];
    let request = stage.request(Output::ColourOverBackground, shots);
    assert_both_refuse(&*adapter, &request, "a sky");
}

/// More than any renderer draws in a moment.
fn endless() -> Stage {
    let solid = |k: u32| {
        let k = f64::from(k);
        dull(sphere(k % 16.0 - 8.0, k / 16.0 - 6.0, k % 7.0, 0.8))
    };
    let mut stage = Stage::of((0..192).map(solid)).lit(lamp(3.0, 20.0, -9.0));
    stage.size.width = 4000;
    stage.size.height = 3000;
    stage
}

/// A run that was cancelled before, and one that is cancelled while it draws.
pub fn a_cancelled_run_stops(subject: &Subject) {
    let adapter = subject.adapter();
    let stage = endless();
    let shots = (0..4).map(|k| stage.shot(k, whole(stage.size))).collect();
    let request = stage.request(Output::ColourOverBackground, shots);
    for after in [0, 400] {
        let room = Room::plain();
        let cancel = &room.run.cancel;
        cancel.store(after == 0, Ordering::Relaxed);
        let started = Instant::now();
        let result = std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(after));
                cancel.store(true, Ordering::Relaxed);
            });
            adapter.render(&request, &room.run)
        });
        let error = result
            .map(|_| "it was drawn")
            .expect_err("it was cancelled");
        assert!(matches!(error, AdapterError::Cancelled), "{error}");
        assert!(
            started.elapsed() < Duration::from_secs(20),
            "that took long"
        );
        room.assert_empty();
    }
}

/// A call that takes longer than it may is stopped, and says so.
pub fn a_late_run_is_stopped(subject: &Subject) {
    let adapter = subject.adapter();
    let stage = endless();
    let shots = (0..4).map(|k| stage.shot(k, whole(stage.size))).collect();
    let request = stage.request(Output::ColourOverBackground, shots);
    let mut room = Room::plain();
    room.run.timeout = Duration::from_millis(300);
    let started = Instant::now();
    let result = adapter.render(&request, &room.run);
    let error = result.map(|_| "it was drawn").expect_err("it was late");
    assert!(matches!(error, AdapterError::TimedOut { .. }), "{error}");
    assert!(
        started.elapsed() < Duration::from_secs(20),
        "that took long"
    );
    room.assert_empty();
}
