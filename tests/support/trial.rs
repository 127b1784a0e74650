//! Many random films at once: each is written, rendered and judged in a folder
//! of its own, and kept where it fails.

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use super::dice::Dice;
use super::random_film::{FIRST_FRAME, FRAMES, RandomFilm, Wanted};
use crate::common::{Run, pixels};

/// Renders sleep most of their time: so many films at once.
const AT_ONCE: u64 = 4;

/// A number of the environment.
pub fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable)
        .ok()
        .and_then(|v| v.parse().ok())
        .unwrap_or(default)
}

/// A pixel's place, and the largest difference of a channel, of 65 535.
pub type Difference = ((u32, u32), u16);

/// A film under trial: a folder with `film.anim`, and what was found wrong.
pub struct Trial {
    pub film: RandomFilm,
    folder: PathBuf,
    wrong: Vec<String>,
    remarks: Vec<String>,
    layered: bool,
}

impl Trial {
    /// Renders the film into `out`; `None` where that fails.
    pub fn render(&mut self, out: &str, options: &[&str]) -> Option<serde_json::Value> {
        let ended = Run::new(["render", "--format", "png16", "-q", "--json"])
            .arg(self.folder.join("film.anim"))
            .arg("-o")
            .arg(self.folder.join(out))
            .args(options)
            .env("DECOR_CACHE", self.folder.join("cache"))
            .ends();
        if ended.status == 0 {
            return Some(ended.summary());
        }
        let options = options.join(" ");
        self.fail(format!(
            "{options}: status {}: {}",
            ended.status, ended.stderr
        ));
        None
    }

    /// Renders with these options, notes the share of traced pixels, and gives
    /// whether any period has a décor; `None` where the render fails.
    pub fn render_layered(&mut self, out: &str, options: &[&str]) -> Option<bool> {
        let summary = self.render(out, options)?;
        let traced = summary["pixels_traced"].as_object().expect("passes");
        let traced: u64 = traced.values().map(|n| n.as_u64().expect("pixels")).sum();
        let share = 100.0 * traced as f64 / summary["pixels_full"].as_f64().expect("pixels");
        let periods = summary["periods"].as_array().expect("periods");
        let layered = periods.iter().any(|period| period["whole"].is_null());
        let how = if layered { "layered" } else { "whole" };
        self.remarks
            .push(format!("{out}: {how}, {share:.0} % traced"));
        self.layered |= layered;
        Some(layered)
    }

    /// Notes what is wrong.
    pub fn fail(&mut self, what: String) {
        self.wrong.push(what);
    }

    /// The frames of two renders, one after the other: name, and for each pixel
    /// its place and the largest difference of a channel, of 65 535.
    pub fn differences(&self, a: &str, b: &str) -> Vec<(String, Vec<Difference>)> {
        (FIRST_FRAME..FIRST_FRAME + FRAMES)
            .map(|frame| {
                let name = format!("frame_{frame:04}.png");
                let of = |out: &str| pixels(&self.folder.join(out).join(&name));
                let ((width, height, left), (w, h, right)) = (of(a), of(b));
                assert_eq!((width, height), (w, h), "{name}: the size of {a} and {b}");
                let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
                let far = left.iter().zip(&right).map(|(p, q)| {
                    let channels = p.iter().zip(q).map(|(a, b)| a.abs_diff(*b));
                    channels.max().unwrap_or(0)
                });
                (name, places.zip(far).collect())
            })
            .collect()
    }
}

/// Tries `count` films and prints a line for each. All that fail are kept, and
/// named together.
///
/// # Panics
/// Where a film fails. Gives the number of films that had a décor otherwise.
pub fn try_films(
    count: u64,
    wanted: impl Fn(u64) -> Wanted + Sync,
    judge: impl Fn(&mut Trial) + Sync,
) -> u64 {
    let films: Vec<u64> = (0..count).collect();
    try_these(number("DECOR_RANDOM_SEED", 1), &films, wanted, judge)
}

/// [`try_films`] with these films of a seed.
///
/// # Panics
/// As it does.
pub fn try_these(
    seed: u64,
    films: &[u64],
    wanted: impl Fn(u64) -> Wanted + Sync,
    judge: impl Fn(&mut Trial) + Sync,
) -> u64 {
    let count = films.len() as u64;
    println!("{count} random films of seed {seed}");
    let (next, layered) = (AtomicU64::new(0), AtomicU64::new(0));
    let failures = Mutex::new(Vec::new());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed) as usize;
            let Some(&k) = films.get(index) else { break };
            let folder = tempfile::tempdir().unwrap();
            let mut dice = Dice::of(seed, k);
            let film = RandomFilm::write(&mut dice, wanted(k), folder.path());
            let mut trial = Trial {
                film,
                folder: folder.path().to_owned(),
                wrong: Vec::new(),
                remarks: Vec::new(),
                layered: false,
            };
            judge(&mut trial);
            layered.fetch_add(u64::from(trial.layered), Ordering::Relaxed);
            println!("film {k}: {film:?}: {}", trial.remarks.join("; "));
            if !trial.wrong.is_empty() {
                let kept = folder.keep();
                let wrong = trial.wrong.join("\n  ");
                failures.lock().unwrap().push(format!(
                    "film {k} of seed {seed}, kept in {}:\n  {wrong}",
                    kept.display()
                ));
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE.min(count) {
            scope.spawn(work);
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    let layered = layered.into_inner();
    println!("{layered} of {count} films were layered");
    layered
}
