//! The pure half: a request in the renderer's language. A renderer in-process
//! has no text; its tests hold trivially.

use std::collections::BTreeSet;
use std::path::Path;

use super::Subject;
use super::stage::{Stage, at, cuboid, lamp, plane, sphere, whole};
use crate::adapter::{Output, SceneText};
use crate::scene::{Instance, Pose};

/// Paths of prototypes that a careless translator takes for one name, for a word
/// of its language, or for a name of its own.
const NAMES: [&str; 20] = [
    "a b",
    "a_b",
    "a-b",
    "A_B",
    "a.b",
    "\u{e4}",
    "a\u{308}",
    "\u{c4}",
    "sphere",
    "union",
    "</scene>",
    "P1",
    "P01",
    "Decor_P1",
    "1",
    "../up/there.ron",
    "quote\"s.ron",
    "it's.ron",
    "line\nbreak.ron",
    "",
];

/// A prototype of each name, of another size each, in rows.
pub(super) fn many_names() -> Stage {
    let mut stage = Stage::empty();
    for (k, name) in (0_u32..).zip(NAMES) {
        let k = f64::from(k);
        let solid = sphere(0.0, 0.0, 0.0, 0.4 + 0.02 * k);
        let prototype = stage.prototype(name, solid);
        let pose = at(2.0 * (k % 5.0) - 4.0, 1.8 * (k / 5.0).floor() - 2.7, 0.0);
        stage.scene.instances.push(Instance { prototype, pose });
    }
    stage
}

fn busy() -> Stage {
    let mut stage = many_names().lit(lamp(3.0, 8.0, -6.0));
    stage.add(plane([0.0, 1.0, 0.0], -4.0), Pose::IDENTITY);
    stage.add(cuboid([-1.0; 3], [1.0; 3]), at(0.1, 0.2, 0.3));
    stage
}

fn text(subject: &Subject, stage: &Stage, output: Output) -> SceneText {
    let request = stage.request(output, vec![stage.shot(3, whole(stage.size))]);
    let text = subject.adapter().scene_text(&request);
    text.unwrap_or_else(|error| panic!("no text: {error}"))
}

/// The same request has the same text, from another adapter value too.
pub fn the_text_is_deterministic(subject: &Subject) {
    let outputs = [
        Output::ColourOverBackground,
        Output::ColourAlone { with_sky: false },
        Output::Depth,
    ];
    for output in outputs {
        let first = text(subject, &busy(), output);
        for _ in 0..3 {
            assert!(first == text(subject, &busy(), output), "{output:?}");
        }
    }
}

/// Another pose, light or camera is another text.
pub fn the_text_says_what_changed(subject: &Subject) {
    let output = Output::ColourOverBackground;
    let first = text(subject, &busy(), output);
    if first.files.is_empty() {
        return;
    }
    let mut moved = busy();
    moved.scene.instances[4].pose.position.x += 1e-9;
    let mut brighter = busy();
    brighter.scene.lights[0].colour.0[1] = 0.5;
    let mut from_elsewhere = busy();
    from_elsewhere.scene.camera.eye.y += 1e-9;
    for other in [moved, brighter, from_elsewhere] {
        assert!(first != text(subject, &other, output));
    }
}

/// Files lie in the call's own folder, each under its own name.
pub fn files_have_plain_names_of_their_own(subject: &Subject) {
    let text = text(subject, &busy(), Output::ColourOverBackground);
    let mut names = BTreeSet::new();
    for (name, _) in &text.files {
        let plain = Path::new(name).file_name().is_some_and(|n| n == &**name);
        assert!(plain, "`{name}` is no plain file name");
        // Where upper and lower case are one, these would be one file.
        assert!(names.insert(name.to_lowercase()), "`{name}` is there twice");
    }
}

/// Prototypes that are nearly called the same are still told apart.
pub fn names_cannot_clash(subject: &Subject) {
    let stage = many_names();
    let layer = stage.draw(&*subject.adapter(), Output::Depth);
    stage.oracle().assert_depth(&layer);
}
