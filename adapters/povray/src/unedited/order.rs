//! What stands against rendering blocks apart: options that change what a block
//! is, and what makes a pixel depend on those that were traced before it.
//!
//! POV-Ray draws random numbers in one row for all pixels (`crand`, some media
//! ([`super::media`]), jitter of lights and rainbows), and some things remember what
//! rays found before (radiosity, `evaluate` of isosurfaces): where blocks are left
//! out, the others come out otherwise. Radiosity, photons and subsurface scattering
//! are refused with the text ([`super::analyse`]). Focal blur only looks random: its
//! samples depend on the place in the picture alone.
//!
//! For each light it remembers, too, the object that stopped the last shadow ray,
//! and asks that one first. It is asked a little differently, which shows where
//! surfaces are nearer than 0.001 to each other, on surfaces that are found only
//! roughly (`julia_fractal`), and where a CSG object has glass and opaque parts
//! and a texture of its own ([`super::mixed`]). No text tells all that: so a frame is traced both
//! ways, and where the two differ, all frames are rendered whole.
//!
//! Blocks of another side than POV-Ray's own (`+BS`) are not used: each row of a block
//! then begins behind another pixel, and in 5 of 230 random scenes one pixel of a
//! frame came out otherwise, by up to 0.04, without antialiasing and with method 2.

use std::collections::HashSet;

use decor_api::Size;

use super::analysis::Refusal;
use super::blocks::{Grid, Sampling};
use super::media;
use super::mixed::mixed;
use super::source::Sources;
use crate::PovRay;
use crate::call::LayerSource;
use crate::plain::{Order, PlainScene};
use crate::tokens::{Kind, tokens};

/// Words that draw random numbers, or remember.
const WORDS: &[(&str, &str)] = &[
    ("crand", "`crand` is random"),
    ("bokeh", "the samples of `bokeh` are drawn at random"),
    ("jitter", "`jitter` is random"),
    ("evaluate", "`evaluate` remembers what rays found before"),
    // 2 to 45 of 20 000 pixels of POV-Ray's own examples.
    (
        "julia_fractal",
        "shadows on `julia_fractal` depend on the pixels that were traced before",
    ),
];

impl PlainScene {
    /// Its blocks.
    pub fn grid(&self) -> Grid {
        let (width, height) = self.size;
        Grid {
            size: Size { width, height },
        }
    }

    /// Where POV-Ray looks for a pixel.
    pub fn sampling(&self) -> Sampling {
        match (self.is_on("Antialias"), self.number("Sampling_Method")) {
            (false, _) => Sampling::Once,
            (true, Some(2.0)) => Sampling::Corners,
            (true, _) => Sampling::Neighbours,
        }
    }

    /// Why its blocks cannot be rendered apart, if so.
    pub fn refusals(&self, povray: &PovRay, sources: &Sources) -> Vec<Refusal> {
        let mut all: Vec<Refusal> = self.option_refusals(povray).into_iter().collect();
        all.extend(word_refusals(povray, sources));
        all.extend(media::random(sources));
        all
    }

    fn option_refusals(&self, povray: &PovRay) -> Vec<Refusal> {
        let option = |reason: &str| Refusal {
            file: String::new(),
            line: 0,
            reason: reason.to_owned(),
        };
        let mut list = Vec::new();
        if povray.source() != LayerSource::StateFile {
            list.push(option("blocks need POV-Ray 3.7"));
        }
        match &self.order {
            Order::Free => {}
            Order::Chained(reason) | Order::OwnPictures(reason) => list.push(option(reason)),
        }
        let set = |name: &str| self.number(name).is_some_and(|value| value > 1.0);
        if self.number("Version").is_some_and(|version| version < 3.5) {
            // Media, for one, were sampled otherwise.
            list.push(option("an older version's language is asked for"));
        }
        let part = ["Start_Column", "Start_Row", "End_Column", "End_Row"];
        if part.iter().any(|name| self.number(name).is_some()) {
            list.push(option("only a part of the picture is rendered"));
        }
        if ["Render_Block_Size", "Render_Block_Step", "Render_Pattern"]
            .iter()
            .any(|name| self.number(name).is_some())
        {
            list.push(option("blocks are not POV-Ray's usual ones"));
        }
        if set("Preview_Start_Size") || set("Preview_End_Size") {
            list.push(option("a mosaic preview is asked for"));
        }
        if self.is_on("Radiosity_From_File") || self.is_on("Radiosity_To_File") {
            list.push(option("radiosity is read or written"));
        }
        list
    }
}

/// Words of the user's files, and of what they use of the library's.
fn word_refusals(povray: &PovRay, sources: &Sources) -> Vec<Refusal> {
    let mut list = Vec::new();
    let mut named: HashSet<String> = HashSet::new();
    for file in sources.files.iter().filter(|file| !file.library) {
        let found = tokens(&file.text);
        list.extend(mixed(&found).into_iter().map(|line| {
            Refusal {
                file: file.name.clone(),
                line,
                reason: "shadows of an opaque CSG object with a part of glass depend on the \
                     pixels that were traced before"
                    .into(),
            }
        }));
        for token in found {
            if token.kind != Kind::Word {
                continue;
            }
            if let Some((_, reason)) = WORDS.iter().find(|(word, _)| token.is(word)) {
                list.push(Refusal {
                    file: file.name.clone(),
                    line: token.line,
                    reason: (*reason).to_owned(),
                });
            }
            named.insert(token.text().into_owned());
        }
    }
    for file in sources.files.iter().filter(|file| file.library) {
        let definitions = povray.words.of(&file.path, &povray.library);
        let mut open: Vec<&String> = definitions.keys().filter(|w| named.contains(*w)).collect();
        let mut seen: HashSet<&String> = open.iter().copied().collect();
        while let Some(name) = open.pop() {
            for word in definitions.get(name).into_iter().flatten() {
                if let Some((_, reason)) = WORDS.iter().find(|(known, _)| word == known) {
                    list.push(Refusal {
                        file: file.name.clone(),
                        line: 0,
                        reason: format!("`{name}`: {reason}"),
                    });
                }
                if definitions.contains_key(word) && seen.insert(word) {
                    open.push(word);
                }
            }
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusals(text: &str, ini: &str) -> Vec<String> {
        let povray = PovRay::find().expect("POV-Ray is installed");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("s.pov"), text).unwrap();
        let ini = format!("Input_File_Name=s.pov\nFinal_Frame=3\n{ini}\n");
        std::fs::write(folder.path().join("a.ini"), ini).unwrap();
        let scene = povray
            .plain(&folder.path().join("a.ini"), &[], None)
            .unwrap();
        let sources = Sources::read(&povray, &scene).unwrap();
        let all = scene.refusals(&povray, &sources);
        all.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn what_is_random_is_refused_by_file_and_line() {
        for text in [
            "sphere { 0, 1 }",
            "media { method 3 emission 1 }",
            "camera { aperture 1 blur_samples 9 }",
        ] {
            assert_eq!(refusals(text, ""), Vec::<String>::new(), "{text}");
        }
        for (text, reason) in [
            ("\nsphere { 0, 1 finish { crand .1 } }", "s.pov:2: `crand`"),
            ("camera { aperture 1 bokeh { rgb 1 } }", "`bokeh`"),
            ("media { method 2 }", "media"),
            (
                "light_source { 0, 1 area_light x,y,2,2 jitter }",
                "`jitter`",
            ),
            (
                "isosurface { function { x } evaluate 1, 2, 1 }",
                "remembers",
            ),
        ] {
            let all = refusals(text, "");
            assert!(all.len() == 1 && all[0].contains(reason), "{text}: {all:?}");
        }
        // A comment is none, and a name only looks like one.
        assert!(refusals("// crand\n#declare jitters = 1;", "").is_empty());
    }

    #[test]
    fn options_that_change_blocks_are_refused() {
        for (ini, reason) in [
            ("Start_Column=3", "a part of the picture"),
            ("End_Row=0.5", "a part of the picture"),
            ("Render_Block_Size=16", "usual"),
            ("Preview_Start_Size=8", "mosaic"),
            ("Version=3.1", "older version"),
        ] {
            let all = refusals("sphere { 0, 1 }", ini);
            assert!(all.len() == 1 && all[0].contains(reason), "{ini}: {all:?}");
        }
        let written = refusals("#fopen F \"x\" write", "");
        assert!(written[0].contains("writes a file"), "{written:?}");
    }

    #[test]
    fn where_pixels_are_sampled() {
        let povray = PovRay::find().expect("POV-Ray is installed");
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.pov");
        std::fs::write(&file, "").unwrap();
        for (switches, sampling) in [
            (&["-A", "+AM2"][..], Sampling::Once),
            (&[], Sampling::Once),
            (&["+A"], Sampling::Neighbours),
            (&["+A0.1", "+AM1"], Sampling::Neighbours),
            (&["+AM2", "Antialias=on"], Sampling::Corners),
        ] {
            let switches: Vec<String> = switches.iter().map(|s| (*s).to_owned()).collect();
            let scene = povray.plain(&file, &switches, None).unwrap();
            assert_eq!(scene.sampling(), sampling, "{switches:?}");
        }
    }
}
