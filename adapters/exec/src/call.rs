//! One call of the program: its command, its folder, its question and answer.

use std::path::{Path, PathBuf};

use decor_api::process::ProcessCall;
use decor_api::{AdapterError, RunContext};

use crate::INSTALL;
use crate::answer;
use crate::protocol::{Ask, Reply};

/// A program with its arguments.
#[derive(Clone, Debug)]
pub struct Command {
    program: PathBuf,
    args: Vec<String>,
    /// Where arguments that are relative paths begin.
    folder: PathBuf,
}

impl Command {
    /// A program without arguments.
    pub fn new(program: PathBuf) -> Self {
        Self {
            program,
            args: Vec::new(),
            folder: std::env::current_dir().unwrap_or_else(|_| PathBuf::from("/")),
        }
    }

    /// Words as a shell splits them; the first is looked for.
    pub fn parse(line: &str) -> Result<Self, AdapterError> {
        let missing = |program: &str| AdapterError::Missing {
            program: program.to_owned(),
            install: INSTALL.to_owned(),
        };
        let mut words = shlex::split(line)
            .ok_or_else(|| {
                missing(&format!(
                    "a program in `{line}`, whose quotes do not close,"
                ))
            })?
            .into_iter();
        let wanted = words.next().filter(|word| !word.is_empty());
        let wanted = wanted.ok_or_else(|| missing("a program to call"))?;
        let program = which::which(&wanted).map_err(|_| missing(&wanted))?;
        let mut command = Self::new(program);
        command.args = words.collect();
        Ok(command)
    }

    /// The program.
    pub fn program(&self) -> &Path {
        &self.program
    }

    /// What people call it: `ray.py` rather than `python3`, where its first
    /// argument is a file.
    pub fn name(&self) -> String {
        let script = self.args.first().map(Path::new);
        let script = script.filter(|file| self.folder.join(file).is_file());
        let path = script.unwrap_or(&self.program);
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// Asks, and gives the answer of a program that ended well.
    pub fn ask(&self, ask: &Ask, doing: &str, run: &RunContext) -> Result<Reply, AdapterError> {
        let call = ProcessCall {
            program: &self.program,
            args: self.args.clone(),
            folder: &self.folder,
            doing: format!("{doing} ({})", self.name()),
            log: None,
        };
        let answer = call.ask(json(ask, self)?, run)?;
        answer::read(&self.name(), &answer)
    }

    /// The error for an answer that is not one to what was asked.
    pub fn unexpected(&self, reply: Reply) -> AdapterError {
        match reply {
            Reply::Failed { why, .. } => AdapterError::Failed {
                program: self.name(),
                status: "it says so itself".into(),
                doing: "what it was asked".into(),
                stderr: why,
            },
            Reply::Unsupported { what, .. } => AdapterError::Unsupported {
                adapter: self.name(),
                what,
            },
            Reply::Hello { .. } => answer::nonsense(&self.name(), "it says hello unasked"),
            Reply::Done { .. } => answer::nonsense(&self.name(), "it was not to draw anything"),
        }
    }
}

/// A question on a line.
pub fn json(ask: &Ask, command: &Command) -> Result<Vec<u8>, AdapterError> {
    let mut bytes = serde_json::to_vec(ask).map_err(|error| AdapterError::Start {
        program: command.name(),
        source: error.into(),
    })?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// A folder for one call. It goes with the value, unless it is kept.
pub struct Folder {
    path: PathBuf,
    _temporary: tempfile::TempDir,
}

impl Folder {
    /// A new one, named after `label`. No file of another call is in it, which
    /// could be taken for this one's.
    pub fn new(run: &RunContext, label: &str) -> Result<Self, AdapterError> {
        let mut temporary = tempfile::Builder::new()
            .prefix(&format!("{label}-"))
            .tempdir_in(&run.work)
            .map_err(AdapterError::io(&run.work))?;
        temporary.disable_cleanup(run.keep);
        Ok(Self {
            path: std::path::absolute(temporary.path()).map_err(AdapterError::io(&run.work))?,
            _temporary: temporary,
        })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes a file into it.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), AdapterError> {
        let path = self.file(name);
        std::fs::write(&path, bytes).map_err(AdapterError::io(&path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_split_as_a_shell_does() {
        let command = Command::parse("sh 'a file.py' --fast \"x y\"").unwrap();
        assert!(command.program().is_absolute());
        assert_eq!(command.args, ["a file.py", "--fast", "x y"]);
        assert_eq!(command.name(), "sh");
        for line in ["", "   ", "'open", "no-such-program-anywhere x"] {
            let error = Command::parse(line).unwrap_err();
            assert!(matches!(error, AdapterError::Missing { .. }), "{line}");
        }
    }

    #[test]
    fn a_script_is_called_by_its_own_name() {
        let folder = tempfile::tempdir().unwrap();
        let script = folder.path().join("ray.py");
        std::fs::write(&script, "").unwrap();
        let command = Command::parse(&format!("sh '{}'", script.display())).unwrap();
        assert_eq!(command.name(), "ray.py");
    }
}
