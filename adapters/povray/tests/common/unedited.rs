//! Scenes that nobody wrote for decor, each in a folder of its own.

use std::path::Path;

use decor_api::RunContext;
use decor_povray::PovRay;
use decor_povray::plain::{Part, PlainScene};
use decor_povray::unedited::{Analysis, Boxes, Options, Sources, analyse, boxes};

const INI: &str = "Input_File_Name=a.pov\nWidth=160\nHeight=120\nBounding=off\n\
                   Initial_Frame=1\nFinal_Frame=2\nInitial_Clock=.2\nFinal_Clock=.9\n";

/// A scene in a folder of its own.
pub struct Film {
    pub povray: PovRay,
    pub folder: tempfile::TempDir,
    pub work: tempfile::TempDir,
    pub scene: PlainScene,
    pub sources: Sources,
    pub analysis: Analysis,
}

impl Film {
    pub fn new(files: &[(&str, &str)], switches: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in [("a.ini", INI)].iter().chain(files) {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("it has one")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        }
        let povray = PovRay::find().expect("POV-Ray is installed");
        let switches: Vec<String> = switches.iter().map(ToString::to_string).collect();
        let scene = povray.plain(&folder.path().join("a.ini"), &switches, None);
        let scene = scene.expect("a scene");
        let sources = Sources::read(&povray, &scene).expect("its files");
        let analysis = analyse(&sources, &Options::of(&scene));
        Self {
            povray,
            folder,
            work: tempfile::tempdir().expect("a folder"),
            scene,
            sources,
            analysis,
        }
    }

    pub fn run(&self) -> RunContext {
        RunContext::new(self.work.path())
    }

    pub fn boxes(&self) -> Boxes {
        let ends = (self.scene.frames.first, self.scene.frames.last);
        boxes(
            &self.povray,
            &self.scene,
            &self.sources,
            &self.analysis,
            ends,
            &self.run(),
        )
        .expect("an answer")
    }

    pub fn whole(&self) -> String {
        let refusals: Vec<String> = self.boxes().whole.iter().map(ToString::to_string).collect();
        refusals.join("\n")
    }

    pub fn pictures(&self, scene: &PlainScene) -> Vec<Picture> {
        let part = Part {
            first: scene.frames.first,
            last: scene.frames.last,
            threads: Some(1),
        };
        let files = scene.render(part, &self.run()).expect("pictures");
        files.iter().map(|(_, path)| picture(path)).collect()
    }

    /// Files in the scene's folder.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("a folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }
}

/// Columns, rows, and three bytes a pixel.
pub type Picture = (usize, usize, Vec<u8>);

fn picture(path: &Path) -> Picture {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("a picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("it fits")];
    let info = reader.next_frame(&mut bytes).expect("its pixels");
    assert_eq!(info.color_type, png::ColorType::Rgb);
    bytes.truncate(info.buffer_size());
    (info.width as usize, info.height as usize, bytes)
}
