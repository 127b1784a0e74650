//! One call of POV-Ray for a part of a plain scene's frames.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use decor_api::process::ProcessCall;
use decor_api::{AdapterError, RunContext};

use super::reader::Reader;
use super::{Order, PlainScene, quoted};
use crate::patiently;

/// What pictures are called where decor lets POV-Ray write them: POV-Ray is not
/// sure of names that are not ASCII.
const NAME: &str = "frame";

/// The options that POV-Ray and decor must have read alike.
const CHECKED: &[&str] = &[
    "Initial_Frame",
    "Final_Frame",
    "Frame_Step",
    "Width",
    "Height",
];

/// A part of the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The first frame.
    pub first: u32,
    /// The last frame.
    pub last: u32,
    /// Threads; `None` leaves them to the user's options and to POV-Ray.
    pub threads: Option<usize>,
}

/// What a call does besides.
#[derive(Default)]
pub(crate) struct More<'a> {
    /// Switches behind all others.
    pub switches: Vec<String>,
    /// The state file of a frame: its blocks are taken over, and all that are
    /// there in the end are given back.
    pub state: Option<&'a (dyn Fn(u32) -> Vec<u8> + Sync)>,
}

/// What a call gives.
pub(crate) struct Called {
    /// The frames' files, in order.
    pub pictures: Vec<(u32, PathBuf)>,
    /// Their state files, where there were any.
    pub states: Vec<(u32, PathBuf)>,
    /// What POV-Ray said.
    pub said: String,
}

/// So many calls were made: each has a folder of its own.
static CALLS: AtomicUsize = AtomicUsize::new(0);

impl PlainScene {
    /// Renders a part, and gives its frames' files, in order. They lie in a
    /// folder of their own below `run.work`, or where POV-Ray puts them
    /// ([`Order::OwnPictures`]).
    ///
    /// # Errors
    /// Any [`AdapterError`].
    pub fn render(
        &self,
        part: Part,
        run: &RunContext,
    ) -> Result<Vec<(u32, PathBuf)>, AdapterError> {
        let label = format!("part-{:05}-{:05}", part.first, part.last);
        let called = self.call(part, &label, &More::default(), run)?;
        Ok(called.pictures)
    }

    /// One call of POV-Ray, in a folder named after `label`.
    pub(crate) fn call(
        &self,
        part: Part,
        label: &str,
        more: &More<'_>,
        run: &RunContext,
    ) -> Result<Called, AdapterError> {
        patiently(|| self.call_once(part, label, more, run))
    }

    fn call_once(
        &self,
        part: Part,
        label: &str,
        more: &More<'_>,
        run: &RunContext,
    ) -> Result<Called, AdapterError> {
        let work = match more.state {
            None => run.work.join(label),
            Some(_) => {
                let number = CALLS.fetch_add(1, Ordering::Relaxed);
                run.work.join(format!("{label}-{number:05}"))
            }
        };
        std::fs::create_dir_all(&work).map_err(AdapterError::io(&work))?;
        let numbers = || (part.first..=part.last).step_by(self.frames.step as usize);
        let mut states = Vec::new();
        if let Some(state) = more.state {
            for n in numbers() {
                // POV-Ray removes the one, and what it wrote stays in the other.
                let own = work.join(format!("{NAME}{}.pov-state", self.frames.suffix(n)));
                let kept = work.join(format!("{NAME}{}.blocks", self.frames.suffix(n)));
                std::fs::write(&own, state(n)).map_err(AdapterError::io(&own))?;
                std::fs::hard_link(&own, &kept).map_err(AdapterError::io(&kept))?;
                states.push((n, kept));
            }
        }
        let ini = work.join("options.ini");
        let mut args = self.arguments(part, &work, &ini)?;
        args.extend(more.switches.iter().cloned());
        if more.state.is_some() {
            args.push("+C".into());
        }
        let call = ProcessCall {
            program: &self.program,
            args,
            folder: &self.folder,
            doing: match part {
                _ if self.frames.digits.is_none() => "the picture".into(),
                Part { first, last, .. } if first == last => format!("frame {first}"),
                Part { first, last, .. } => format!("frames {first} to {last}"),
            },
            log: run.keep.then(|| work.join("povray.log")),
        };
        run.tally.add_call(numbers().count());
        let ended = call.run_well(run)?;
        self.check_options(&ini)?;
        let folder = self.pictures(&work);
        let stem = if folder == work { NAME } else { &self.stem };
        let pictures = numbers().map(|n| {
            let file = format!("{stem}{}.{}", self.frames.suffix(n), self.ending);
            let path = folder.join(file);
            self.check_picture(&path)?;
            Ok((n, path))
        });
        Ok(Called {
            pictures: pictures.collect::<Result<_, AdapterError>>()?,
            states,
            said: ended.stderr,
        })
    }

    /// Do pictures stay where they were written?
    pub fn leaves_pictures(&self) -> bool {
        matches!(self.order, Order::OwnPictures(_))
    }

    /// Where the pictures of a call are written.
    fn pictures(&self, work: &Path) -> PathBuf {
        if !self.leaves_pictures() {
            return work.to_owned();
        }
        let stated = self.settings.text("Output_File_Name").unwrap_or_default();
        let name = if stated.is_empty() {
            self.settings.text("Input_File_Name").unwrap_or_default()
        } else {
            stated
        };
        self.folder
            .join(name.rsplit_once('/').map_or("", |(folder, _)| folder))
    }

    fn arguments(&self, part: Part, work: &Path, ini: &Path) -> Result<Vec<String>, AdapterError> {
        let in_quotes = |path: &Path| {
            path.to_str()
                .and_then(quoted)
                .ok_or_else(|| AdapterError::BadInput {
                    file: path.to_owned(),
                    reason: "POV-Ray cannot quote the name of this folder".into(),
                })
        };
        let mut args = self.command.clone();
        if self.frames.digits.is_some() {
            args.extend([format!("+SF{}", part.first), format!("+EF{}", part.last)]);
        }
        if !self.leaves_pictures() {
            args.push(format!("Output_File_Name={}", in_quotes(&work.join(NAME))?));
        }
        args.push(format!("Create_Ini={}", in_quotes(ini)?));
        args.extend(["Output_To_File=on", "-C", "-D", "-P", "-V"].map(str::to_owned));
        args.extend(part.threads.map(|threads| format!("+WT{threads}")));
        Ok(args)
    }

    /// POV-Ray states its options: they must be what was planned with.
    fn check_options(&self, file: &Path) -> Result<(), AdapterError> {
        let bad = |reason| AdapterError::BadOutput {
            program: "povray".into(),
            file: file.to_owned(),
            reason,
        };
        let mut stated = Reader::new(&self.folder);
        stated
            .ini(&file.to_string_lossy())
            .map_err(|refused| bad(refused.reason))?;
        let stated = stated.settings;
        for name in CHECKED {
            let (its, ours) = (stated.whole(name), self.settings.whole(name));
            if its != ours {
                return Err(bad(format!(
                    "it reads {name} as {its:?}, decor as {ours:?}: please report this"
                )));
            }
        }
        let cyclic = "Cyclic_Animation";
        if stated.is_on(cyclic) != self.settings.is_on(cyclic) {
            return Err(bad(format!(
                "it does not read {cyclic} as decor does: please report this"
            )));
        }
        Ok(())
    }

    /// Is the picture there, and whole as far as its ends say?
    fn check_picture(&self, path: &Path) -> Result<(), AdapterError> {
        let bad = |reason: String| AdapterError::BadOutput {
            program: "povray".into(),
            file: path.to_owned(),
            reason,
        };
        let mut file = File::open(path).map_err(|error| bad(error.to_string()))?;
        let length = file
            .metadata()
            .map_err(|error| bad(error.to_string()))?
            .len();
        if length == 0 {
            return Err(bad("it is empty".into()));
        }
        if self.ending != "png" {
            return Ok(());
        }
        let mut ends = [0; 36];
        let read = |file: &mut File, ends: &mut [u8; 36]| -> std::io::Result<()> {
            file.read_exact(&mut ends[..24])?;
            file.seek(SeekFrom::End(-12))?;
            file.read_exact(&mut ends[24..])
        };
        read(&mut file, &mut ends).map_err(|error| bad(error.to_string()))?;
        let number =
            |at: usize| u32::from_be_bytes([ends[at], ends[at + 1], ends[at + 2], ends[at + 3]]);
        if (number(16), number(20)) != self.size {
            return Err(bad(format!(
                "it has {} by {} pixels",
                number(16),
                number(20)
            )));
        }
        if &ends[28..32] != b"IEND" {
            return Err(bad("its end is missing".into()));
        }
        Ok(())
    }
}
