//! Runs a renderer: its own process group, a watchdog, the end of what it says.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

use process_wrap::std::{CommandWrap, ProcessGroup};

use crate::adapter::{AdapterError, RunContext};
use ending::{Ending, Waiting};

mod ending;

/// How much of a program's output is kept for the message when it fails.
const TAIL_BYTES: usize = 4096;

/// How much of what a program answers on stdout is read. More is no answer.
pub const ANSWER_BYTES: usize = 1 << 20;

/// Finds a program: by the environment variable `variable` where it is set,
/// else by `name` on the path.
///
/// # Errors
/// [`AdapterError::Missing`] with `install` as the way out.
pub fn find_program(variable: &str, name: &str, install: &str) -> Result<PathBuf, AdapterError> {
    let stated = std::env::var_os(variable).filter(|value| !value.is_empty());
    let wanted = stated.unwrap_or_else(|| name.into());
    which::which(&wanted).map_err(|_| AdapterError::Missing {
        program: wanted.to_string_lossy().into_owned(),
        install: install.to_owned(),
    })
}

/// The version that a program prints, on either stream, after `prefix` at a
/// line's beginning: the next word.
///
/// # Errors
/// Where the program does not run, or prints no such line.
pub fn version(program: &Path, flag: &str, prefix: &str) -> Result<String, AdapterError> {
    let folder = std::env::temp_dir();
    let call = ProcessCall {
        program,
        args: vec![flag.into()],
        folder: &folder,
        doing: "its version".into(),
        log: None,
    };
    let mut run = RunContext::new(&folder);
    run.timeout = Duration::from_secs(20);
    let (ended, answer) = call.supervised(Some(Vec::new()), &run)?;
    let ended = call.well(ended)?;
    let answer = String::from_utf8_lossy(&answer);
    let stated = ended
        .stderr
        .lines()
        .chain(answer.lines())
        .find_map(|line| line.strip_prefix(prefix))
        .and_then(|rest| rest.split_whitespace().next());
    stated
        .map(str::to_owned)
        .ok_or_else(|| AdapterError::Failed {
            program: program.display().to_string(),
            status: "no version".into(),
            doing: call.doing.clone(),
            stderr: ended.stderr,
        })
}

/// One run of a program.
#[derive(Clone, Debug)]
pub struct ProcessCall<'a> {
    /// The program.
    pub program: &'a Path,
    /// Its arguments.
    pub args: Vec<String>,
    /// The folder that it runs in.
    pub folder: &'a Path,
    /// What it is to do, for messages: `frames 0 to 24, colour`.
    pub doing: String,
    /// Where all that it prints is kept, if anywhere.
    pub log: Option<PathBuf>,
}

/// How a program ended.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Its exit status.
    pub status: ExitStatus,
    /// What it printed on stderr; of very much, the end.
    pub stderr: String,
}

impl ProcessCall<'_> {
    /// Runs the program to its end and returns how it ended, good or bad. When
    /// this returns, no process of its group is left.
    ///
    /// # Errors
    /// [`AdapterError::Start`], [`AdapterError::TimedOut`],
    /// [`AdapterError::Cancelled`].
    pub fn run(&self, run: &RunContext) -> Result<Ended, AdapterError> {
        Ok(self.supervised(None, run)?.0)
    }

    /// Runs the program with `question` on its stdin; what it wrote on stdout by
    /// its good end, up to one byte more than [`ANSWER_BYTES`].
    ///
    /// # Errors
    /// As [`run_well`](Self::run_well).
    pub fn ask(&self, question: Vec<u8>, run: &RunContext) -> Result<Vec<u8>, AdapterError> {
        let (ended, answer) = self.supervised(Some(question), run)?;
        self.well(ended)?;
        Ok(answer)
    }

    fn supervised(
        &self,
        question: Option<Vec<u8>>,
        run: &RunContext,
    ) -> Result<(Ended, Vec<u8>), AdapterError> {
        let name = self.program_name();
        tracing::debug!(program = %name, args = ?self.args, folder = %self.folder.display());
        let talk = || match question {
            Some(_) => Stdio::piped(),
            None => Stdio::null(),
        };
        let mut command = Command::new(self.program);
        command
            .args(&self.args)
            .current_dir(self.folder)
            .stdin(talk())
            .stdout(talk())
            .stderr(Stdio::piped());
        let mut wrapped = CommandWrap::from(command);
        wrapped.wrap(ProcessGroup::leader());
        let mut child = wrapped.spawn().map_err(|source| AdapterError::Start {
            program: self.program.display().to_string(),
            source,
        })?;
        let pipe = child.stderr().take();
        let reader = thread::spawn(move || pipe.map(drain).unwrap_or_default());
        let pipe = child.stdout().take();
        let listener = pipe.map(|pipe| thread::spawn(move || head(pipe)));
        let pipe = child.stdin().take();
        let teller = pipe.zip(question).map(|(mut pipe, question)| {
            thread::spawn(move || {
                // A program may end without reading: how it ended says more.
                let _ = pipe.write_all(&question);
            })
        });

        let waiting = Waiting::begin(&*child);
        let stop = || run.is_cancelled();
        let used = |time| run.tally.add_cpu(time);
        let ending = waiting.ending(&mut *child, run.timeout, stop, used);
        // The group goes even where its leader ended by itself: what it started
        // must not outlive it, and would keep the pipe open. That nobody is
        // left to be killed is the usual case, not an error.
        let _ = child.start_kill();
        waiting.end();
        let status = child.wait();
        let text = reader.join().unwrap_or_default();
        let answer = listener.and_then(|thread| thread.join().ok());
        let answer = answer.unwrap_or_default();
        let _ = teller.map(thread::JoinHandle::join);
        if let Some(log) = &self.log {
            let written = std::fs::File::create(log).and_then(|mut file| file.write_all(&text));
            written.map_err(AdapterError::io(log))?;
        }
        let ended = ending.and_then(|ending| Ok((ending, status?)));
        match ended {
            Ok((Ending::TooLong, _)) => Err(AdapterError::TimedOut {
                program: name,
                doing: self.doing.clone(),
                limit: run.timeout,
                stderr: tail(&text),
            }),
            Ok((Ending::Stopped, _)) => Err(AdapterError::Cancelled),
            Ok((Ending::Ended, status)) => {
                let stderr = String::from_utf8_lossy(&text).into_owned();
                Ok((Ended { status, stderr }, answer))
            }
            Err(source) => Err(AdapterError::Start {
                program: name,
                source,
            }),
        }
    }

    /// Runs the program; a bad end is an error.
    ///
    /// # Errors
    /// As [`run`](Self::run), and [`AdapterError::Failed`].
    pub fn run_well(&self, run: &RunContext) -> Result<Ended, AdapterError> {
        self.well(self.run(run)?)
    }

    fn well(&self, ended: Ended) -> Result<Ended, AdapterError> {
        if ended.status.success() {
            return Ok(ended);
        }
        Err(AdapterError::Failed {
            program: self.program_name(),
            status: ended.status.to_string(),
            doing: self.doing.clone(),
            stderr: tail(ended.stderr.as_bytes()),
        })
    }

    fn program_name(&self) -> String {
        let name = self.program.file_name().unwrap_or(self.program.as_os_str());
        name.to_string_lossy().into_owned()
    }
}

/// Reads to the end. Only the last part is of interest, but a pipe that nobody
/// empties stops the program.
fn drain(mut pipe: impl Read) -> Vec<u8> {
    const KEPT: usize = 1 << 20;
    /// Renderers write a line at a time: who has read one waits for more, and is woken
    /// once for all of them.
    const PAUSE: Duration = Duration::from_millis(4);
    let mut kept = Vec::new();
    let mut buffer = [0_u8; 8192];
    while let Ok(n) = pipe.read(&mut buffer) {
        if n == 0 {
            break;
        }
        kept.extend_from_slice(&buffer[..n]);
        if kept.len() > 2 * KEPT {
            kept.drain(..kept.len() - KEPT);
        }
        if n < buffer.len() / 2 {
            thread::sleep(PAUSE);
        }
    }
    kept
}

/// Reads to the end, and keeps the beginning.
fn head(mut pipe: impl Read) -> Vec<u8> {
    let mut kept = Vec::new();
    let limit = ANSWER_BYTES as u64 + 1;
    // What was read before an error is what there is.
    let _ = pipe.by_ref().take(limit).read_to_end(&mut kept);
    let _ = std::io::copy(&mut pipe, &mut std::io::sink());
    kept
}

fn tail(text: &[u8]) -> String {
    let from = text.len().saturating_sub(TAIL_BYTES);
    let text = String::from_utf8_lossy(&text[from..]);
    let lines: Vec<&str> = text
        .lines()
        .map(str::trim_end)
        .filter(|l| !l.is_empty())
        .collect();
    lines[lines.len().saturating_sub(12)..].join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::Ordering;
    use std::time::Instant;

    fn shell<'a>(script: &str, folder: &'a Path) -> ProcessCall<'a> {
        ProcessCall {
            program: Path::new("/bin/sh"),
            args: vec!["-c".into(), script.into()],
            folder,
            doing: "a test".into(),
            log: None,
        }
    }

    fn is_alive(pid: &str) -> bool {
        // A zombie that nobody has waited for yet still has a folder.
        std::fs::read_to_string(format!("/proc/{}/stat", pid.trim()))
            .is_ok_and(|stat| !stat.contains(") Z"))
    }

    /// Who was killed by an orphan's signal is not awaited by anybody here: the
    /// kernel has a moment.
    fn is_gone(pid: &str) -> bool {
        (0..200).any(|_| {
            let alive = is_alive(pid);
            if alive {
                thread::sleep(Duration::from_millis(20));
            }
            !alive
        })
    }

    #[test]
    fn a_failure_shows_the_status_and_the_last_words() {
        let folder = tempfile::tempdir().unwrap();
        let error = shell("echo one >&2; echo last words >&2; exit 3", folder.path())
            .run_well(&RunContext::new(folder.path()))
            .unwrap_err()
            .to_string();
        assert!(error.contains("exit status: 3"), "{error}");
        assert!(error.contains("last words"), "{error}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_cpu_time_of_a_call_is_counted() {
        let folder = tempfile::tempdir().unwrap();
        let of = |script: &str| {
            let run = RunContext::new(folder.path());
            shell(script, folder.path()).run_well(&run).unwrap();
            run.tally.cpu().as_secs_f64()
        };
        let idle = of("exec sleep 0.2");
        // The shell's own account of itself, in hundredths.
        let busy = of("i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done; times > own");
        let own = std::fs::read_to_string(folder.path().join("own")).unwrap();
        let seconds: f64 = own
            .lines()
            .next()
            .unwrap()
            .split_whitespace()
            .map(|t| {
                t.trim_start_matches("0m")
                    .trim_end_matches('s')
                    .parse::<f64>()
            })
            .map(|t| t.expect("seconds"))
            .sum();
        assert!(idle < 0.05, "{idle}");
        assert!((busy - seconds).abs() < 0.05, "{busy} and {seconds}");
    }

    #[test]
    fn a_killed_program_is_a_failure() {
        let folder = tempfile::tempdir().unwrap();
        let error = shell("kill -9 $$", folder.path())
            .run_well(&RunContext::new(folder.path()))
            .unwrap_err()
            .to_string();
        assert!(error.contains("signal: 9"), "{error}");
    }

    #[test]
    fn the_watchdog_kills_the_whole_group() {
        let folder = tempfile::tempdir().unwrap();
        let mut run = RunContext::new(folder.path());
        run.timeout = Duration::from_millis(300);
        let script = "sleep 600 & echo $! > child; echo waiting >&2; wait";
        let error = shell(script, folder.path()).run_well(&run).unwrap_err();
        assert!(matches!(&error, AdapterError::TimedOut { stderr, .. } if stderr == "waiting"));
        let pid = std::fs::read_to_string(folder.path().join("child")).unwrap();
        assert!(is_gone(&pid), "process {pid} is still there");
    }

    #[test]
    fn what_a_program_leaves_behind_is_killed_too() {
        let folder = tempfile::tempdir().unwrap();
        let run = RunContext::new(folder.path());
        let started = Instant::now();
        shell("sleep 600 & echo $! > child", folder.path())
            .run_well(&run)
            .unwrap();
        assert!(
            started.elapsed() < Duration::from_secs(60),
            "it waited for the pipe"
        );
        let pid = std::fs::read_to_string(folder.path().join("child")).unwrap();
        assert!(is_gone(&pid), "process {pid} is still there");
    }

    #[test]
    fn a_question_is_answered_however_long_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let run = RunContext::new(folder.path());
        let long = vec![b'x'; 3 * ANSWER_BYTES];
        let answer = |script| shell(script, folder.path()).ask(long.clone(), &run);
        assert_eq!(answer("wc -c").unwrap().trim_ascii(), b"3145728");
        assert_eq!(answer("cat").unwrap().len(), ANSWER_BYTES + 1);
        assert_eq!(answer("echo unread").unwrap(), b"unread\n");
        let error = answer("cat; exit 2").unwrap_err().to_string();
        assert!(error.contains("exit status: 2"), "{error}");
    }

    #[test]
    fn stopping_stops() {
        let folder = tempfile::tempdir().unwrap();
        let run = RunContext::new(folder.path());
        run.cancel.store(true, Ordering::Relaxed);
        let error = shell("sleep 600", folder.path()).run(&run).unwrap_err();
        assert!(matches!(error, AdapterError::Cancelled));
    }

    #[test]
    fn a_missing_program_says_what_to_install() {
        let error = find_program(
            "DECOR_NO_SUCH_VARIABLE",
            "no-such-renderer",
            "install it with x",
        )
        .unwrap_err()
        .to_string();
        assert_eq!(error, "no-such-renderer was not found; install it with x");
    }
}
