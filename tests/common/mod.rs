//! What the tests of the program share.
#![allow(dead_code)]

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// A bundled film.
pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures")
        .join(name)
}

/// A call of the program.
pub struct Run(pub Command);

/// How it ended.
pub struct Ended {
    pub stdout: String,
    pub stderr: String,
    pub status: i32,
}

impl Run {
    /// The program with these arguments, and nothing of the user's own around.
    pub fn new<I: IntoIterator<Item = S>, S: AsRef<OsStr>>(args: I) -> Self {
        let mut command = Command::cargo_bin("decor").expect("the program was built");
        command
            .args(args)
            .env("NO_COLOR", "1")
            .env_remove("DECOR_LOG");
        Self(command)
    }

    pub fn arg(mut self, arg: impl AsRef<OsStr>) -> Self {
        self.0.arg(arg);
        self
    }

    pub fn args<I: IntoIterator<Item = S>, S: AsRef<OsStr>>(mut self, args: I) -> Self {
        self.0.args(args);
        self
    }

    pub fn env(mut self, key: &str, value: impl AsRef<OsStr>) -> Self {
        self.0.env(key, value);
        self
    }

    pub fn ends(mut self) -> Ended {
        let output = self.0.output().expect("the program starts");
        Ended {
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
            status: output.status.code().unwrap_or(-1),
        }
    }

    pub fn succeeds(self) -> Ended {
        let ended = self.ends();
        assert_eq!(ended.status, 0, "{}", ended.stderr);
        ended
    }
}

impl Ended {
    /// The last line of `--json`.
    pub fn summary(&self) -> serde_json::Value {
        let line = self.stdout.lines().last().expect("a line of JSON");
        let value: serde_json::Value = serde_json::from_str(line).expect("JSON");
        assert_eq!(value["type"], "summary");
        value
    }
}

/// A PNG's pixels as integers, and its size.
pub fn pixels(path: &Path) -> (u32, u32, Vec<[u16; 3]>) {
    let file = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut reader = png::Decoder::new(std::io::Cursor::new(file))
        .read_info()
        .unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    let channels = info.color_type.samples();
    let values: Vec<u16> = match info.bit_depth {
        png::BitDepth::Sixteen => data
            .chunks_exact(2)
            .map(|b| u16::from_be_bytes([b[0], b[1]]))
            .collect(),
        _ => data.iter().map(|&b| u16::from(b)).collect(),
    };
    let pixels = values
        .chunks_exact(channels)
        .map(|p| [p[0], p[1], p[2]])
        .collect();
    (info.width, info.height, pixels)
}

/// The places where two pictures differ at all.
pub fn differing_pixels(a: &Path, b: &Path) -> Vec<(u32, u32)> {
    let (width, height, left) = pixels(a);
    let (other_width, other_height, right) = pixels(b);
    assert_eq!((width, height), (other_width, other_height));
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places
        .zip(left.iter().zip(&right))
        .filter(|(_, (a, b))| a != b)
        .map(|(p, _)| p)
        .collect()
}
