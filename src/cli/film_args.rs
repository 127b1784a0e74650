//! What every verb that reads a film is told.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use clap::Args;
use decor_api::{Adapter, AdapterError, RunContext};

use super::Failure;
use crate::film::{self, Film};
use crate::objects::Cache;
use crate::plan::{Budget, Mode, ShadowWay, Wishes};
use crate::segmentation::Measure;
use crate::stage::Stage;
use crate::{render, renderers};

/// The film and its renderer.
#[derive(Debug, Args)]
pub struct FilmArgs {
    /// The film: an .anim file, or .jsonl; or a plain POV-Ray scene, .ini or .pov.
    pub film: PathBuf,
    /// POV-Ray's own switches, for a plain POV-Ray scene.
    #[arg(last = true, value_name = "SWITCHES")]
    pub switches: Vec<String>,
    /// The renderer: povray, mitsuba, reference or exec:PROGRAM [default: povray; reference where
    /// POV-Ray is not installed and the film does not need it].
    #[arg(long, value_name = "NAME")]
    pub renderer: Option<String>,
    /// Object paths may leave the film's folder.
    #[arg(long)]
    pub allow_outside: bool,
    /// Only these frames: A-B, both included, or a single A.
    #[arg(long, value_name = "A-B", value_parser = frame_range)]
    pub frames: Option<(u32, u32)>,
    /// Seconds that one call of the renderer may take.
    #[arg(long, value_name = "SECONDS", default_value_t = 3600.0, value_parser = positive)]
    pub timeout: f64,
}

/// What the plan is made for.
#[derive(Debug, Args)]
pub struct PlanWishes {
    /// What the frames promise [default: equivalent].
    #[arg(long, value_enum)]
    pub mode: Option<Mode>,
    /// Objects may move so far in the picture, in pixels, and stay in the décor
    /// [default: 0, 1, 4 by mode].
    #[arg(long, value_name = "PX", value_parser = not_negative)]
    pub threshold: Option<f64>,
    /// Which measure of motion decides.
    #[arg(long, value_enum, default_value_t = Measure::Bound)]
    pub measure: Measure,
    /// Frames per décor: a number, or auto.
    #[arg(long, value_name = "N|auto", value_parser = period)]
    pub period: Option<Period>,
    /// Seconds for a frame: the threshold adapts.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub budget: Option<f64>,
    /// The smallest threshold that --budget may choose.
    #[arg(long, value_name = "PX", default_value_t = 0.25, value_parser = not_negative)]
    pub threshold_min: f64,
    /// The largest one.
    #[arg(long, value_name = "PX", default_value_t = 16.0, value_parser = not_negative)]
    pub threshold_max: f64,
    /// How shadows of what moves come onto the décor.
    #[arg(long, value_enum, default_value_t = ShadowWay::Auto)]
    pub shadows: ShadowWay,
    /// Use décors also where frame by frame would be cheaper.
    #[arg(long)]
    pub no_fallback: bool,
}

/// Frames per décor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Period {
    /// As decor sees fit.
    Auto,
    /// At most so many.
    Frames(u32),
}

impl PlanWishes {
    /// The threshold, as it was stated or by the mode.
    fn threshold_px(&self, mode: Mode) -> f64 {
        self.threshold.unwrap_or(mode.default_threshold_px())
    }

    /// The wishes for some frames of a film.
    pub fn wishes(&self, frames: (u32, u32), with_depth: bool) -> Wishes {
        let mode = self.mode.unwrap_or(Mode::Equivalent);
        Wishes {
            mode,
            threshold_px: self.threshold_px(mode),
            measure: self.measure,
            period: match self.period {
                Some(Period::Frames(n)) => Some(n),
                _ => None,
            },
            budget: self.budget.map(|frame_s| Budget {
                frame_s,
                least_px: self.threshold_min.min(self.threshold_max),
                most_px: self.threshold_max,
            }),
            shadow_way: self.shadows,
            frames,
            with_depth,
            fallback: !self.no_fallback,
        }
    }
}

pub(super) fn period(text: &str) -> Result<Period, String> {
    if text == "auto" {
        return Ok(Period::Auto);
    }
    match text.parse() {
        Ok(n) if n > 0 => Ok(Period::Frames(n)),
        _ => Err("a number of frames, at least 1, or `auto`".into()),
    }
}

fn frame_range(text: &str) -> Result<(u32, u32), String> {
    let number = |part: &str| {
        part.parse::<u32>()
            .map_err(|_| format!("`{part}` is no frame number"))
    };
    match text.split_once('-') {
        None => number(text).map(|n| (n, n)),
        Some((a, b)) => {
            let (a, b) = (number(a)?, number(b)?);
            if a <= b {
                Ok((a, b))
            } else {
                Err(format!("{a} is after {b}"))
            }
        }
    }
}

pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("a number of pixels, at least 0".into()),
    }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("a number above 0".into()),
    }
}

impl FilmArgs {
    /// Reads the film alone.
    pub fn read(&self) -> Result<Film, Failure> {
        film::read(&self.film, self.allow_outside).map_err(Failure::input)
    }

    /// The frames that are asked for.
    pub fn wanted(&self, film: &Film) -> (u32, u32) {
        self.frames
            .unwrap_or((*film.frames().start(), *film.frames().end()))
    }

    /// How long a call may take.
    pub fn timeout(&self) -> Duration {
        Duration::from_secs_f64(self.timeout.min(1e9))
    }

    /// The film with its objects, for its renderer.
    pub fn stage(&self, cancel: &Arc<AtomicBool>) -> Result<Stage, Failure> {
        if !self.switches.is_empty() {
            return Err(Failure::usage(
                "switches after -- are POV-Ray's, for a plain scene (.ini, .pov)",
            ));
        }
        self.stage_of(self.read()?, cancel)
    }

    /// A film that was read, with its objects.
    pub fn stage_of(&self, film: Film, cancel: &Arc<AtomicBool>) -> Result<Stage, Failure> {
        let adapter = self.adapter(&film)?;
        let work = render::WorkFolder::new(None)?;
        let mut run = RunContext::new(&work.path);
        run.timeout = self.timeout();
        run.cancel = Arc::clone(cancel);
        let cache = Cache::open();
        Ok(Stage::set(film, adapter, self.allow_outside, &cache, &run)?)
    }

    /// The renderer that was asked for. Where none was, and POV-Ray is missing,
    /// a film that no part of needs it is drawn in-process.
    fn adapter(&self, film: &Film) -> Result<Arc<dyn Adapter>, Failure> {
        if let Some(name) = &self.renderer {
            return match renderers::find(name) {
                Err(AdapterError::Missing { program, install }) if !renderers::is_known(name) => {
                    Err(Failure::usage(format!("{program} is not known; {install}")))
                }
                other => Ok(other?),
            };
        }
        let default = &renderers::ADAPTERS[0];
        match (default.find)() {
            Err(error @ AdapterError::Missing { .. })
                if std::env::var_os("DECOR_POVRAY").is_none() =>
            {
                if needs_povray(film) {
                    return Err(error.into());
                }
                eprintln!("decor: {error}\ndecor: drawing with the reference renderer instead");
                Ok(renderers::find("reference")?)
            }
            other => Ok(other?),
        }
    }
}

fn needs_povray(film: &Film) -> bool {
    let native = |file: &film::NamedFile| {
        file.file()
            .extension()
            .is_some_and(|e| e == "inc" || e == "pov")
    };
    let sky = film.scene_numbers().any(|n| film.frame(n).sky.is_some());
    sky || film.includes().next().is_some() || film.descriptions().iter().any(native)
}

/// A flag that Ctrl-C sets.
pub fn cancelled_by_ctrl_c() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&flag);
    // Without a handler Ctrl-C still ends the program, if less cleanly.
    if let Err(error) =
        ctrlc::set_handler(move || set.store(true, std::sync::atomic::Ordering::Relaxed))
    {
        tracing::warn!(%error, "Ctrl-C will not be handled");
    }
    flag
}
