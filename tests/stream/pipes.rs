//! The program with its pipes open.

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serde_json::Value;

use crate::common;

/// Nothing here takes so long, unless it hangs.
pub const LONG: Duration = Duration::from_secs(120);

/// The program with its pipes.
pub struct Pipes {
    pub child: Child,
    pub stdin: Option<ChildStdin>,
    pub lines: Receiver<Value>,
    pub out: PathBuf,
    /// Lines of `begin`, by their first frame.
    pub begins: BTreeMap<u64, Value>,
    /// Lines of `period`.
    pub periods: Vec<Value>,
    /// Lines of `frame`.
    pub frames: Vec<Value>,
    pub summary: Option<Value>,
}

impl Drop for Pipes {
    fn drop(&mut self) {
        // A test that failed leaves nothing behind.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Pipes {
    pub fn open(folder: &Path, out: &Path, options: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_decor"))
            .args(["stream", "--json", "--folder"])
            .arg(folder)
            .arg("-o")
            .arg(out)
            .args(options)
            .env("NO_COLOR", "1")
            .env_remove("DECOR_LOG")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let stdout = BufReader::new(child.stdout.take().unwrap());
        let (send, lines) = channel();
        std::thread::spawn(move || {
            for line in stdout.lines() {
                let value = serde_json::from_str(&line.unwrap()).expect("JSON");
                if send.send(value).is_err() {
                    break;
                }
            }
        });
        Self {
            stdin: child.stdin.take(),
            child,
            lines,
            out: out.to_owned(),
            begins: BTreeMap::new(),
            periods: Vec::new(),
            frames: Vec::new(),
            summary: None,
        }
    }

    /// The next line that the program prints.
    pub fn next(&mut self) -> Option<Value> {
        let line = match self.lines.recv_timeout(LONG) {
            Ok(line) => line,
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => return None,
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) => panic!("nothing comes out"),
        };
        match line["type"].as_str().unwrap() {
            "begin" => {
                self.begins
                    .insert(line["start"].as_u64().unwrap(), line.clone());
            }
            "period" => self.periods.push(line.clone()),
            "frame" => self.frames.push(line.clone()),
            "summary" => self.summary = Some(line.clone()),
            other => panic!("a line of {other}"),
        }
        Some(line)
    }

    pub fn write(&mut self, text: &str) {
        let stdin = self.stdin.as_mut().unwrap();
        stdin.write_all(text.as_bytes()).unwrap();
        stdin.write_all(b"\n").unwrap();
        stdin.flush().unwrap();
    }

    /// Waits for a frame; it is whole, and no later one is there.
    pub fn wait_for(&mut self, number: u64) {
        loop {
            let line = self.next().expect("a frame");
            if line["type"] == "frame" {
                assert_eq!(line["frame"], number);
                let file = self.file(number);
                assert_eq!(line["file"].as_str().unwrap(), file.to_str().unwrap());
                common::pixels(&file);
                assert!(!self.file(number + 1).exists());
                return;
            }
        }
    }

    /// Writes a scene and waits for its frame.
    pub fn send(&mut self, scene: &Value) {
        self.write(&scene.to_string());
        self.wait_for(scene["scene"].as_u64().unwrap());
    }

    pub fn file(&self, number: u64) -> PathBuf {
        self.out.join(format!("frame_{number:04}.png"))
    }

    /// Ends the stream; gives the exit status and stderr.
    pub fn end(&mut self) -> (i32, String) {
        self.stdin = None;
        while self.next().is_some() {}
        let mut stderr = String::new();
        let mut pipe = self.child.stderr.take().unwrap();
        std::io::Read::read_to_string(&mut pipe, &mut stderr).unwrap();
        (self.child.wait().unwrap().code().unwrap_or(-1), stderr)
    }

    pub fn ends_well(&mut self) -> Value {
        let (status, stderr) = self.end();
        assert_eq!(status, 0, "{stderr}");
        let summary = self.summary.clone().expect("a summary");
        let file = std::fs::read_to_string(self.out.join("decor.json")).unwrap();
        let file: Value = serde_json::from_str(&file).unwrap();
        assert_eq!(file, summary);
        let kept: Vec<Value> = self.periods.iter().map(untyped).collect();
        assert_eq!(summary["periods"].as_array().unwrap(), &kept);
        assert_eq!(summary["frames"], self.frames.len());
        summary
    }
}

pub fn untyped(line: &Value) -> Value {
    let mut line = line.clone();
    line.as_object_mut().unwrap().remove("type");
    line
}
