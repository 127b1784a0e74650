//! The note of an unfinished run: for `--resume`.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::frames::WriteError;
use crate::frames::write_safely;

/// Where the job of an unfinished run is noted, and which frames it has
/// finished: a line each. What else is in the folder is another job's.
pub const JOB_FILE: &str = ".decor-job";

/// The note of an unfinished run.
pub struct JobLog {
    path: PathBuf,
    file: Mutex<File>,
}

impl JobLog {
    /// Notes the job, and the frames that are kept.
    pub fn begin(out: &Path, job: &str, kept: &BTreeSet<u32>) -> Result<Self, WriteError> {
        let path = out.join(JOB_FILE);
        let lines: String = kept.iter().map(|frame| format!("{frame}\n")).collect();
        write_safely(&path, format!("{job}\n{lines}").as_bytes())?;
        let file = std::fs::OpenOptions::new().append(true).open(&path);
        let file = file.map_err(|source| WriteError::Io {
            path: path.clone(),
            source,
        })?;
        Ok(Self {
            path,
            file: Mutex::new(file),
        })
    }

    /// One more frame is in its place.
    pub fn finished(&self, frame: u32) {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        // A frame that is not noted is rendered again: no harm is done.
        let _ = file.write_all(format!("{frame}\n").as_bytes());
    }

    /// The run is complete: nobody needs the note.
    pub fn end(&self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// The frames that an earlier run of the same job has left, finished or not,
/// called as `name` says. Frames are renamed into place: one that is there is
/// whole.
pub fn finished(
    out: &Path,
    job: &str,
    frames: (u32, u32),
    name: &dyn Fn(u32) -> String,
) -> BTreeSet<u32> {
    let noted: BTreeSet<u32> = match std::fs::read_to_string(out.join(JOB_FILE)) {
        Ok(note) => {
            let mut lines = note.lines();
            if lines.next() != Some(job) {
                return BTreeSet::new();
            }
            lines.filter_map(|line| line.parse().ok()).collect()
        }
        Err(_) => {
            let complete = || {
                let text = std::fs::read_to_string(out.join("decor.json")).ok()?;
                let value: serde_json::Value = serde_json::from_str(&text).ok()?;
                let same = value.get("job")?.as_str()? == job;
                let number = |key: &str| u32::try_from(value.get(key)?.as_u64()?).ok();
                let first = number("first_frame")?;
                // Plain scenes have frames with a step between them.
                let last = number("last_frame")
                    .or_else(|| Some(first.saturating_add(number("frames")?) - 1))?;
                same.then(|| (first..=last).collect())
            };
            complete().unwrap_or_default()
        }
    };
    let wanted = noted.range(frames.0..=frames.1).copied();
    wanted.filter(|n| out.join(name(*n)).is_file()).collect()
}
