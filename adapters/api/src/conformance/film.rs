//! Films that are not as one expects them.

use glam::DVec3;

use super::Subject;
use super::stage::{Room, Stage, at, cuboid, drawn, sphere, whole};
use super::text::many_names;
use crate::adapter::{Output, RunContext};
use crate::scene::Instance;

/// Unicode, blanks, quotes and line breaks in names, in colour too, and in the
/// label of what is kept.
pub fn names_may_be_odd(subject: &Subject) {
    let adapter = subject.adapter();
    let stage = many_names();
    for output in [Output::ColourOverBackground, Output::Depth] {
        let shots = vec![stage.shot(0, whole(stage.size))];
        let mut request = stage.request(output, shots);
        request.label = "d\u{e9}cor 0001 'a'".into();
        let mut room = Room::plain();
        room.run.keep = true;
        let layers = drawn(adapter.render(&request, &room.run));
        assert_eq!(layers.len(), 1);
        if output == Output::Depth {
            stage.oracle().assert_depth(&layers[0]);
        }
    }
}

/// The work folder has a name that users have, and so has its parent.
pub fn folders_may_be_odd(subject: &Subject) {
    let adapter = subject.adapter();
    let stage = Stage::of([sphere(0.5, 0.0, 0.0, 2.0)]);
    let room = Room::odd();
    let work = room.run.work.join("with = and # ; %20");
    std::fs::create_dir(&work).expect("a folder");
    let run = RunContext::new(&work);
    for output in [Output::ColourOverBackground, Output::Depth] {
        let shots = vec![stage.shot(0, whole(stage.size))];
        let layers = drawn(adapter.render(&stage.request(output, shots), &run));
        if output == Output::Depth {
            stage.oracle().assert_depth(&layers[0]);
        }
    }
    std::fs::remove_dir(&work).expect("nothing is left in it");
    room.assert_empty();
}

/// A hundred rows of a hundred, of two prototypes.
pub fn ten_thousand_instances_are_drawn(subject: &Subject) {
    let mut stage = Stage::empty().seen_from(DVec3::new(5.0, 30.0, -60.0), DVec3::ZERO);
    stage.size.width = 41;
    stage.size.height = 31;
    let ball = stage.prototype("ball", sphere(0.0, 0.0, 0.0, 0.45));
    let cube = stage.prototype("cube", cuboid([-0.4; 3], [0.4; 3]));
    for k in 0..10_000_u32 {
        let (row, column) = (k / 100, k % 100);
        stage.scene.instances.push(Instance {
            prototype: if (row + column) % 3 == 0 { cube } else { ball },
            pose: at(f64::from(column) - 49.5, 0.0, f64::from(row) - 49.5),
        });
    }
    // So far away their edges are too close to judge by: a few large ones stand
    // in front of them.
    stage.add(sphere(0.0, 0.0, 0.0, 9.0), at(-8.0, 8.0, -25.0));
    let layer = stage.draw(&*subject.adapter(), Output::Depth);
    stage.oracle().assert_depth(&layer);
}

/// After calls that went well, none of their files is left, and no process.
pub fn nothing_is_left_behind(subject: &Subject) {
    let adapter = subject.adapter();
    let stage = many_names();
    let room = Room::plain();
    let outputs = [
        Output::ColourOverBackground,
        Output::ColourAlone { with_sky: false },
        Output::Depth,
    ];
    for output in outputs {
        let shots = (0..3).map(|k| stage.shot(k, whole(stage.size))).collect();
        let layers = drawn(adapter.render(&stage.request(output, shots), &room.run));
        assert_eq!(layers.len(), 3);
    }
    let (calls, frames) = room.run.tally.read();
    assert!(calls >= 3, "{calls} calls were counted");
    assert!(frames >= 9, "{frames} frames were counted");
    room.assert_empty();
}
