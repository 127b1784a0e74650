//! Programs that do something else than they were asked: an error that names
//! them, never a picture.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use decor_api::{
    Adapter, AdapterError, Camera, Layer, LayerRequest, LayerShot, Output, PrototypeTable, Region,
    Rgb, RunContext, Scene, Size,
};
use decor_exec::Exec;
use glam::DVec3;

const SIZE: Size = Size {
    width: 7,
    height: 5,
};

/// The example with something wrong about it, as a program of its own.
struct Mutant {
    folder: tempfile::TempDir,
}

impl Mutant {
    /// `replace` is replaced in the example's text, where it has to be.
    fn new(replace: &str, by: &str) -> Self {
        let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("example/raycast.py");
        let text = std::fs::read_to_string(example).unwrap();
        assert!(text.contains(replace), "the example has no `{replace}`");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("mutant.py"), text.replace(replace, by)).unwrap();
        Self { folder }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("mutant.py")
    }

    fn find(&self) -> Result<Exec, AdapterError> {
        Exec::find(&format!("python3 '{}'", self.path().display()))
    }

    /// Draws an empty frame, of which every pixel is known.
    fn draw(&self, output: Output) -> Result<Vec<Layer>, AdapterError> {
        let prototypes = PrototypeTable::default();
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 45.0)).unwrap();
        let scene = Scene {
            camera,
            lights: Vec::new(),
            shadows: false,
            background: Rgb([0.5; 3]),
            includes: Vec::new(),
            sky: None,
            instances: Vec::new(),
            hidden: Vec::new(),
        };
        let request = LayerRequest {
            prototypes: &prototypes,
            size: SIZE,
            output,
            antialias: None,
            shots: vec![LayerShot {
                frame: 3,
                scene: Arc::new(scene),
                region: Region::Window(SIZE.window()),
            }],
            film: None,
            label: "fault".into(),
        };
        let work = tempfile::tempdir().unwrap();
        let run = RunContext::new(work.path());
        let result = self.find()?.render(&request, &run);
        let left = std::fs::read_dir(work.path()).unwrap().count();
        assert_eq!(left, 0, "files are left behind");
        result
    }
}

/// The error is a bad output of the program, and says what of it.
fn assert_found_out(result: Result<Vec<Layer>, AdapterError>, shown: &str) {
    let error = result.expect_err(shown);
    let message = error.to_string();
    assert!(matches!(error, AdapterError::BadOutput { .. }), "{message}");
    assert!(message.contains("mutant.py"), "{message}");
    assert!(message.contains(shown), "{message}");
}

#[test]
fn the_example_itself_draws() {
    let layers = Mutant::new("", "").draw(Output::Depth).unwrap();
    assert_eq!(layers[0].depth, Some(vec![f64::INFINITY; SIZE.pixels()]));
}

#[test]
fn pictures_that_are_not_what_was_asked_for() {
    let channels = "channels = {\"Z\": distance}";
    let depth = |by: &str| Mutant::new(channels, by).draw(Output::Depth);
    assert_found_out(depth("channels = {\"Y\": distance}"), "no channel Z");
    assert_found_out(depth("channels = {\"Z\": distance * numpy.nan}"), "NaN");
    assert_found_out(depth("channels = {\"Z\": 0 * x - 1}"), "-1");
    assert_found_out(depth("channels = {\"Z\": 0 * x}"), "depth of pixel 0 is 0");
    let wide = Mutant::new(
        "columns, rows, channels)\n\n",
        "rows, columns, channels)\n\n",
    );
    assert_found_out(wide.draw(Output::Depth), "5 × 7 pixels");
    let other = Mutant::new("20000630", "20000631");
    assert_found_out(other.draw(Output::Depth), "OpenEXR");
    let elsewhere = Mutant::new("shot[\"file\"])", "\"another.exr\")");
    assert_found_out(elsewhere.draw(Output::Depth), "cannot be read");

    let over = Output::ColourOverBackground;
    let open = Mutant::new("colour[3] = 1.0\n        channels", "channels");
    assert_found_out(open.draw(over), "A is 0");
    let thick = Mutant::new(
        "colour[3] = 1.0\n        channels",
        "colour[3] = 2.0\n        channels",
    );
    assert_found_out(thick.draw(over), "coverage of pixel 0 is 2");
    let bright = Mutant::new("zip(\"RGBA\", colour)", "zip(\"RGBA\", colour / 0)");
    assert_found_out(bright.draw(over), "pixel 0");
}

#[test]
fn answers_that_are_none() {
    let says = |by: &str| Mutant::new("    reply = answer", by).draw(Output::Depth);
    assert_found_out(says("    print('loading')\n    reply = answer"), "loading");
    assert_found_out(says("    return\n    reply = answer"), "answered nothing");
    let much = "    print('x' * (1 << 21))\n    reply = answer";
    assert_found_out(says(much), "more than");
    let fewer = Mutant::new("\"layers\": len(request[\"shots\"])", "\"layers\": 0");
    assert_found_out(fewer.draw(Output::Depth), "0 layers of 1");
    let greeting = Mutant::new(
        "{\"reply\": \"done\", \"layers\"",
        "{\"reply\": \"done\", \"images\"",
    );
    assert_found_out(greeting.draw(Output::Depth), "images");
    let again = Mutant::new("request[\"ask\"] == \"hello\"", "True");
    assert_found_out(again.draw(Output::Depth), "hello unasked");
}

#[test]
fn abilities_that_cannot_be() {
    let says = |by: &str| {
        let mutant = Mutant::new("\"crop_grid\": 1,", by);
        mutant.find().map(|_| Vec::new())
    };
    assert_found_out(says("\"crop_grid\": 0,"), "crop_grid is 0");
    assert_found_out(says("\"crop_grid\": -1,"), "-1");
    assert_found_out(says("\"cropgrid\": 1,"), "cropgrid");
    assert_found_out(says("\"block_mask\": True,"), "crop_grid that divides 32");
    assert_found_out(says("\"sample_position\": [0.5, 7],"), "7");
    let other = Mutant::new("PROTOCOL = 1", "PROTOCOL = 2");
    assert_found_out(other.find().map(|_| Vec::new()), "version 1");
}

#[test]
fn what_a_program_refuses_is_typed() {
    let refuses = Mutant::new(
        "            for shot in",
        "            raise Unsupported('a torus')\n            for shot in",
    );
    let error = refuses.draw(Output::Depth).unwrap_err();
    assert!(matches!(error, AdapterError::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("a torus"), "{error}");
    let fails = Mutant::new(
        "        try:",
        "        return {\"reply\": \"failed\", \"why\": \"no licence\"}\n        try:",
    );
    let error = fails.draw(Output::Depth).unwrap_err();
    assert!(matches!(error, AdapterError::Failed { .. }), "{error}");
    assert!(error.to_string().contains("no licence"), "{error}");
    let dies = Mutant::new("        try:", "        1 / 0\n        try:");
    let error = dies.draw(Output::Depth).unwrap_err();
    assert!(matches!(error, AdapterError::Failed { .. }), "{error}");
    assert!(error.to_string().contains("ZeroDivisionError"), "{error}");
}

#[test]
fn a_program_that_is_not_there_is_missing() {
    for command in ["no-such-program", "", "'open"] {
        let error = Exec::find(command).unwrap_err();
        assert!(matches!(error, AdapterError::Missing { .. }), "{error}");
    }
}
