//! The machine that something was measured on.

use std::fmt;

use serde::Serialize;

use crate::probe;

/// The machine, as far as the system tells.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// The name of its processor.
    pub processor: String,
    /// The cores that decor may use.
    pub cores: usize,
    /// Its memory in bytes.
    pub memory: Option<u64>,
    /// The system and the architecture.
    pub system: String,
    /// How decor was built: `release` or `debug`.
    pub build: &'static str,
}

impl Machine {
    /// This one.
    pub fn here() -> Self {
        let (os, architecture) = (std::env::consts::OS, std::env::consts::ARCH);
        Self {
            processor: probe::processor().to_string(),
            cores: probe::cores(),
            memory: memory(),
            system: format!("{os} {architecture}"),
            build: if cfg!(debug_assertions) {
                "debug"
            } else {
                "release"
            },
        }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cores = if self.cores == 1 { "core" } else { "cores" };
        write!(f, "{}, {} {cores}", self.processor, self.cores)?;
        if let Some(memory) = self.memory {
            write!(f, ", {:.1} GiB", memory as f64 / f64::from(1 << 30))?;
        }
        write!(f, ", {}", self.system)?;
        if self.build == "debug" {
            write!(f, ", a debug build of decor")?;
        }
        Ok(())
    }
}

/// `MemTotal` of Linux, in bytes.
fn memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}
