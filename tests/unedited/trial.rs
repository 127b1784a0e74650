//! One animation, by decor and by POV-Ray alone.

use std::path::Path;

use crate::common::Run;
use crate::stock::{content, pictures, povray};

/// Options by which coherence is used where it does not pay.
pub const ALWAYS: &[&str] = &["--mode", "exact", "--no-fallback"];

/// What decor says of a run, and the names of frames that are not POV-Ray's.
pub struct Tried {
    pub summary: serde_json::Value,
    pub stderr: String,
    pub frames: usize,
    pub differing: Vec<String>,
}

impl Tried {
    /// Why frames were rendered whole, as one text; empty where they were not.
    pub fn whole(&self) -> String {
        let list = self.summary["rendered_whole"].as_array();
        let reasons = list.into_iter().flatten().filter_map(|r| r.as_str());
        reasons.collect::<Vec<_>>().join("; ")
    }

    /// Every frame is POV-Ray's.
    pub fn assert_identical(&self, what: &str) {
        assert!(self.frames > 0, "{what}: no frames");
        assert!(
            self.differing.is_empty(),
            "{what}: {:?} differ; {}",
            self.differing,
            self.summary
        );
    }
}

/// Renders `file` of a folder by both, into folders below `work`.
///
/// # Panics
/// Where one of them fails, or where their frames have other names.
pub fn both(folder: &Path, file: &str, switches: &[&str], options: &[&str], work: &Path) -> Tried {
    let (ours, its) = (work.join("ours"), work.join("its"));
    std::fs::create_dir_all(&its).unwrap();
    let run = Run::new(["render", "--json"]).arg(folder.join(file));
    let ended = run
        .arg("-o")
        .arg(&ours)
        .args(options)
        .arg("--")
        .args(switches)
        .ends();
    assert_eq!(ended.status, 0, "{file} {switches:?}: {}", ended.stderr);
    let out = format!("+O{}/", its.display());
    let mut words = vec![file];
    words.extend(switches);
    words.push(&out);
    povray(folder, &words);
    let names = |folder: &Path| -> Vec<String> {
        let list = pictures(folder);
        list.iter()
            .map(|p| p.file_name().unwrap().to_string_lossy().into_owned())
            .collect()
    };
    assert_eq!(names(&ours), names(&its), "{file} {switches:?}");
    let differing = names(&its)
        .into_iter()
        .filter(|name| content(&ours.join(name)) != content(&its.join(name)));
    Tried {
        differing: differing.collect(),
        frames: names(&its).len(),
        summary: ended.summary(),
        stderr: ended.stderr,
    }
}
