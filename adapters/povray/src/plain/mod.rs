//! Plain POV-Ray animations, as they are: a scene driven by `clock`, its INI
//! file, POV-Ray's usual switches.
//!
//! POV-Ray itself reads the user's files and switches, and works in the folder
//! of the file that was named: `decor render films/a.ini` renders what
//! `cd films; povray a.ini` renders. decor only adds at the end, where the last
//! option wins: which frames (`+SF`, `+EF`), where to (`Output_File_Name`), how
//! many threads, no display, no pause, no talk. The clock of a frame follows
//! from the options alone, so frames of several calls are those of one.
//!
//! decor reads the same options ([`reader`], [`settings`], [`words`]) for what it
//! must know itself: which frames there are and what their files are called
//! ([`frames`]), and whether they can be rendered in any order ([`depend`]). Each
//! call makes POV-Ray state its options (`Create_Ini`): where the two do not
//! agree, the call fails ([`call`]).
//!
//! What POV-Ray reads and does not use is no obstacle: `Field_Render` means
//! nothing to 3.7. Refused, with the reason: commands of the shell (they are
//! never run), `Real_Time_Raytracing` and `Clockless_Animation`, which write no
//! pictures. Replaced: `Display`, `Pause_When_Done`, `Verbose`, `Output_To_File`,
//! `Continue_Trace`, `Create_Ini`, `Work_Threads` and the folder of
//! `Output_File_Name`; message files (`All_File`, …) go with the working files.
//!
//! POV-Ray 3.7 opens no file whose *name* is not ASCII; folders may be called as
//! they like. Names with blanks are quoted for it.
//!
//! One call with one thread is the measure: POV-Ray with several threads does
//! not agree with itself where a scene has `crand`, jittered area lights,
//! focal blur, or shadows through glass. Jitter of the antialiasing depends on
//! the pixel alone.

mod call;
mod depend;
mod frames;
mod reader;
mod settings;
mod words;

use std::path::{Path, PathBuf};

use decor_api::{AdapterError, PictureFormat};

use crate::PovRay;

pub(crate) use call::More;
pub use call::Part;
pub use depend::Order;
pub use frames::Frames;

use depend::Looking;
use reader::{Reader, Refused};
use settings::Settings;

/// A plain scene with its options, read and looked at.
#[derive(Clone, Debug)]
pub struct PlainScene {
    program: PathBuf,
    /// Where POV-Ray works: the folder of the file that was named.
    pub folder: PathBuf,
    /// The words of the command line.
    command: Vec<String>,
    settings: Settings,
    /// Its frames.
    pub frames: Frames,
    /// Columns and rows.
    pub size: (u32, u32),
    /// The ending of its pictures: `png`.
    pub ending: &'static str,
    /// The names of its pictures without folder, number and ending.
    pub stem: String,
    /// Whether its frames depend on each other.
    pub order: Order,
    /// The user's files that were read.
    pub files: Vec<PathBuf>,
    /// The same scene, options and files have the same key.
    pub key: String,
}

/// Is it a plain scene's name: `.pov`, `.ini`, `.ini[section]`?
pub fn is_plain(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let name = match name.split_once('[') {
        Some((name, rest)) if rest.ends_with(']') => name,
        _ => &name,
    };
    let ending = name.rsplit_once('.').map(|(_, ending)| ending);
    ending.is_some_and(|e| e.eq_ignore_ascii_case("pov") || e.eq_ignore_ascii_case("ini"))
}

impl PovRay {
    /// Reads a plain scene: `file` is a `.pov` or an `.ini`, with `[section]` if
    /// need be; `switches` follow it on the command line. `format`, where it is
    /// stated, goes before what the options say.
    ///
    /// # Errors
    /// [`AdapterError::BadInput`] where something is missing, where POV-Ray would
    /// not take the options, or where decor refuses them.
    pub fn plain(
        &self,
        file: &Path,
        switches: &[String],
        format: Option<PictureFormat>,
    ) -> Result<PlainScene, AdapterError> {
        let bad = |reason: String| AdapterError::BadInput {
            file: file.to_owned(),
            reason,
        };
        let parent = file.parent().filter(|p| !p.as_os_str().is_empty());
        let folder = parent.unwrap_or(Path::new("."));
        let folder = std::path::absolute(folder).map_err(AdapterError::io(folder))?;
        let name = file.file_name().and_then(|name| name.to_str());
        let name = name.ok_or_else(|| bad("its name is no text".into()))?;

        let mut command =
            vec![quoted(name).ok_or_else(|| bad("POV-Ray cannot quote its name".into()))?];
        command.extend_from_slice(switches);
        let format_switch = format.map(|format| match format {
            PictureFormat::Png => "+FN8",
            PictureFormat::Png16 => "+FN16",
            PictureFormat::Exr => "+FE",
        });
        command.extend(format_switch.map(str::to_owned));
        let settings = self
            .read(&folder, &command)
            .map_err(|refused| match refused.file {
                Some(file) => AdapterError::BadInput {
                    file,
                    reason: refused.reason,
                },
                None => bad(refused.reason),
            })?;
        if let Some(reason) = refusal(&settings) {
            return Err(bad(reason));
        }

        let scene = settings.text("Input_File_Name");
        let scene = scene.ok_or_else(|| bad("it names no scene (Input_File_Name)".into()))?;
        let path = depend::find(&folder, &settings.library, scene, &[".pov", ".POV"]);
        let path = path.ok_or_else(|| AdapterError::BadInput {
            file: folder.join(scene),
            reason: "there is no such scene".into(),
        })?;
        let ending = frames::ending(settings.text("Output_File_Type"));
        let stem = frames::stem(&settings, ending);
        let looking = Looking {
            folder: &folder,
            settings: &settings,
            library: &self.library,
            words: &self.words,
            pictures: (&stem, ending),
        };
        let look = looking.look(&path);
        if format.is_some() && matches!(look.order, Order::OwnPictures(_)) {
            return Err(bad(
                "its frames read each other: their format cannot be changed".into(),
            ));
        }
        let pixels = |name, default| {
            let stated = settings.whole(name).unwrap_or(default);
            u32::try_from(stated).ok().filter(|n| *n > 0)
        };
        let size = pixels("Width", 160).zip(pixels("Height", 120));
        let size = size.ok_or_else(|| bad("the picture has no pixels".into()))?;
        let mut key = blake3::Hasher::new();
        key.update(format!("{} {command:?} {settings:?}", self.abilities.version).as_bytes());
        for (path, text) in &look.files {
            key.update(path.as_os_str().as_encoded_bytes()).update(text);
        }
        for path in &look.named {
            key.update(path.as_os_str().as_encoded_bytes());
            // What cannot be read is POV-Ray's to complain of.
            key.update(&std::fs::read(path).unwrap_or_default());
        }
        Ok(PlainScene {
            program: self.program.clone(),
            frames: Frames::of(&settings),
            folder,
            command,
            size,
            ending,
            stem,
            order: look.order,
            files: look.files.into_iter().map(|(path, _)| path).collect(),
            key: key.finalize().to_hex().to_string(),
            settings,
        })
    }

    /// The options as POV-Ray reads them.
    fn read(&self, folder: &Path, command: &[String]) -> Result<Settings, Refused> {
        let mut reader = Reader::new(folder);
        match self.first_ini(folder) {
            Some(file) => reader.ini(&file.to_string_lossy())?,
            None => reader.settings.library.extend(self.library.first()),
        }
        for word in command {
            reader.word(word)?;
        }
        let more = std::env::var("POVINC").ok();
        reader.settings.library.extend(more);
        Ok(reader.settings)
    }

    /// The INI file that POV-Ray reads before anything else.
    fn first_ini(&self, folder: &Path) -> Option<PathBuf> {
        let home = std::env::var_os("HOME")
            .filter(|home| !home.is_empty())
            .map(PathBuf::from);
        let stated = std::env::var_os("POVINI").map(|name| folder.join(name));
        let real = self.program.canonicalize().ok();
        let prefix = real
            .as_deref()
            .and_then(Path::parent)
            .and_then(Path::parent);
        // Debian's prefix is /usr, its configuration in /etc.
        let beside = prefix.filter(|prefix| *prefix != Path::new("/usr"));
        let etc: Vec<PathBuf> = beside
            .into_iter()
            .chain([Path::new("/"), Path::new("/usr/local")])
            .map(|root| root.join("etc"))
            .collect();
        let system = etc.iter().map(|etc| etc.join("povray/3.7/povray.ini"));
        let candidates = stated
            .into_iter()
            .chain([folder.join("povray.ini")])
            .chain(home.iter().map(|home| home.join(".povray/3.7/povray.ini")))
            .chain(system)
            .chain(home.iter().map(|home| home.join(".povrayrc")))
            .chain(etc.iter().map(|etc| etc.join("povray.ini")));
        candidates
            .into_iter()
            .find(|path| std::fs::File::open(path).is_ok() && path.is_file())
    }
}

impl PlainScene {
    /// The name of a frame's file, POV-Ray's own.
    pub fn name(&self, frame: u32) -> String {
        format!("{}{}.{}", self.stem, self.frames.suffix(frame), self.ending)
    }

    /// The number that an option was set to, if it was.
    pub(crate) fn number(&self, option: &str) -> Option<f32> {
        self.settings.real(option)
    }

    /// Was an option turned on?
    pub(crate) fn is_on(&self, option: &str) -> bool {
        self.settings.is_on(option)
    }

    /// The words of the command line.
    pub(crate) fn command(&self) -> &[String] {
        &self.command
    }

    /// The options as they were read.
    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// A file as POV-Ray looks for it, tried with the endings too.
    pub(crate) fn find(&self, name: &str, endings: &[&str]) -> Option<PathBuf> {
        depend::find(&self.folder, &self.settings.library, name, endings)
    }

    /// What POV-Ray was told, in words: for people.
    pub fn found(&self) -> Vec<String> {
        let text = |value: &settings::Value| match value {
            settings::Value::Whole(n) => n.to_string(),
            settings::Value::Real(x) => x.to_string(),
            settings::Value::Switch(on) => (if *on { "on" } else { "off" }).to_owned(),
            settings::Value::Text(text) => text.clone(),
        };
        let values = self.settings.values();
        let mut list: Vec<String> = values
            .map(|(name, value)| format!("{name}={}", text(value)))
            .collect();
        list.extend(
            self.settings
                .declares
                .iter()
                .map(|d| format!("Declare={d}")),
        );
        list.extend(
            self.settings
                .library
                .iter()
                .map(|l| format!("Library_Path={l}")),
        );
        list
    }
}

/// Why decor does not render with these options, if it does not.
fn refusal(settings: &Settings) -> Option<String> {
    let shell = [
        "Pre_Scene",
        "Pre_Frame",
        "Post_Frame",
        "Post_Scene",
        "User_Abort",
        "Fatal_Error",
    ];
    for command in shell.map(|when| format!("{when}_Command")) {
        if settings
            .text(&command)
            .is_some_and(|text| !text.trim().is_empty())
        {
            return Some(format!(
                "{command} would run a program: decor runs none; render without it, and run it yourself"
            ));
        }
    }
    ["Real_Time_Raytracing", "Clockless_Animation"]
        .into_iter()
        .find(|name| settings.is_on(name))
        .map(|name| format!("{name} shows frames and writes none: turn it off"))
}

/// In quotes, for POV-Ray.
pub(crate) fn quoted(text: &str) -> Option<String> {
    let quote = ['"', '\'']
        .into_iter()
        .find(|quote| !text.contains(*quote))?;
    Some(format!("{quote}{text}{quote}"))
}

#[cfg(test)]
mod tests;
