//! Plain animations by coherence: what is the same in several frames is traced
//! once, and every frame is the one that POV-Ray alone would have given.
//!
//! ```text
//! text → Look (what moves; why not)
//! whole frames from the first moment on; what do two of them cost? (beside, price)
//! beside them, where that is a little of the film: boxes, a sample of the middle
//!     frame's blocks: does coherence promise to pay? (sounding)
//! if so, no more whole frames: boxes → geometry, proxies (masks, purse) → the
//!     dirty blocks of each frame that is left
//! a frame both ways: the same? beside it: sources (frames that trace for others),
//!     and then the rest (rest)
//! ```
//!
//! At every step frames may turn out to be better rendered whole; then what is
//! left is. Whole frames that were finished are finished ones in any case.

mod beside;
mod film;
mod masks;
mod price;
mod purse;
mod rest;
mod sounding;
mod unlike;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use decor_api::{AdapterError, RunContext};
use decor_povray::PovRay;
use decor_povray::plain::PlainScene;
use decor_povray::unedited::{self, Analysis, Refusal, Sources, Steps, schedule};

use super::delivery::Delivery;
use super::pool::Workers;
use super::{Done, workers};
use crate::render::RenderError;
use beside::Promise;
use film::{Film, Found, Trial};
use rest::Rest;
use sounding::{USUAL, promises};

pub use price::{Costs, Price};

/// A scene's text, looked at.
#[derive(Clone, Debug)]
pub struct Look {
    /// The files.
    pub sources: Sources,
    /// What they say of motion.
    pub analysis: Analysis,
    /// Why all frames are rendered whole; empty: they need not be.
    pub whole: Vec<Refusal>,
    /// What the clock says, where nothing else tells frames apart.
    steps: Option<Steps>,
}

impl Look {
    /// Looks at a scene.
    ///
    /// # Errors
    /// [`AdapterError::Io`] where the scene cannot be read.
    pub fn at(povray: &PovRay, scene: &PlainScene) -> Result<Self, AdapterError> {
        let sources = Sources::read(povray, scene)?;
        let options = unedited::Options::of(scene);
        let analysis = unedited::analyse(&sources, &options);
        let mut whole = scene.refusals(povray, &sources);
        let steps = analysis.steps.clone().filter(|_| whole.is_empty());
        for refusal in &analysis.whole {
            if !whole.contains(refusal) {
                whole.push(refusal.clone());
            }
        }
        Ok(Self {
            sources,
            analysis,
            whole,
            steps,
        })
    }

    /// Frames that show the same as an earlier one of these: that one, and them.
    ///
    /// # Errors
    /// What goes wrong with POV-Ray.
    pub fn repeated(
        &self,
        povray: &PovRay,
        scene: &PlainScene,
        frames: &BTreeSet<u32>,
        run: &RunContext,
    ) -> Result<BTreeMap<u32, Vec<u32>>, AdapterError> {
        match &self.steps {
            Some(steps) => steps.repeated(povray, scene, frames, run),
            None => Ok(BTreeMap::new()),
        }
    }
}

/// What a plan says of coherence.
#[derive(Clone, Debug, Default)]
pub struct Forecast {
    /// Why all frames are rendered whole; empty: they need not be.
    pub whole: Vec<String>,
    /// The share of blocks that may change from frame to frame.
    pub dirty: Option<f64>,
    /// Why geometry does not tell that.
    pub proxies_only: Option<String>,
    /// What frames cost, where some were rendered to know.
    pub costs: Option<Costs>,
    /// All frames whole, and by coherence.
    pub prices: Option<(Price, Price)>,
}

/// Renders frames that do not need each other.
pub fn render(
    povray: &PovRay,
    delivery: &Delivery<'_>,
    look: &Look,
    always: bool,
    run: &RunContext,
) -> Result<Done, RenderError> {
    let repeated = look.repeated(povray, delivery.scene, &delivery.options.wanted, run)?;
    let later: BTreeSet<u32> = repeated.values().flatten().copied().collect();
    let delivery = &Delivery {
        repeated: &repeated,
        ..*delivery
    };
    let wanted = &(&delivery.options.wanted - &later);
    let pixels = u64::from(delivery.scene.size.0) * u64::from(delivery.scene.size.1);
    let mut done = Done {
        repeated: later.len() as u64,
        ..Done::default()
    };
    let mut film = Film {
        povray,
        scene: delivery.scene,
        look,
        frames: wanted.iter().copied().collect(),
        workers: workers(delivery, wanted.len()),
        run,
        given: Mutex::default(),
        composed: AtomicU64::default(),
    };
    let mut reasons: Vec<String> = look.whole.iter().map(ToString::to_string).collect();
    if reasons.is_empty() && wanted.len() < 3 {
        reasons.push("there are too few frames".into());
    }
    if !reasons.is_empty() {
        super::whole(delivery, wanted, None, run)?;
        done.whole = reasons;
        done.whole_pixels = wanted.len() as u64 * pixels;
        return Ok(done);
    }
    let (mut trial, promise) = if always {
        let trial = film.trial()?;
        for (frame, file) in trial.traced.iter().flat_map(|traced| &traced.pictures) {
            film.give(delivery, *frame, file)?;
        }
        let promise = Promise {
            dirtier: USUAL.0,
            boxes: None,
        };
        (trial, Found::This(promise))
    } else {
        film.whole_or_promise(delivery, &mut done)?
    };
    let found = match promise {
        Found::This(mut promise) => {
            film.forget_given(&mut trial, &mut promise);
            coherent(&film, delivery, &trial, promise, always, &mut done)?
        }
        Found::Whole(reasons) => Found::Whole(reasons),
    };
    trial.remove_blocks();
    if let Found::Whole(reasons) = found {
        let left = wanted.iter().filter(|frame| !film.is_given(**frame));
        let left: BTreeSet<u32> = left.copied().collect();
        if !left.is_empty() {
            super::whole(delivery, &left, Some(trial.costs.whole_s()), run)?;
        }
        done.whole = reasons;
    }
    let composed = film.composed.load(Ordering::Relaxed);
    done.whole_pixels = (wanted.len() as u64 - composed) * pixels;
    Ok(done)
}

/// Renders what is left, or says why it is better rendered whole.
fn coherent(
    film: &Film<'_>,
    delivery: &Delivery<'_>,
    trial: &Trial,
    promise: Promise,
    always: bool,
    done: &mut Done,
) -> Result<Found<()>, RenderError> {
    let boxes = match promise.boxes {
        Some(boxes) => boxes,
        None => film.boxes(&film.frames, film.run)?,
    };
    let boxes = match boxes {
        Found::This(boxes) => boxes,
        Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
    };
    let masks = match film.masks(&boxes, Some((trial, always)))? {
        Found::This(masks) => masks,
        Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
    };
    done.block_pixels += masks.pixels;
    done.dirty = Some(masks.share());
    if let Some(block) = masks.unlike {
        return Ok(Found::Whole(vec![unlike::reason(block)]));
    }
    let plan = schedule(film.scene.grid(), &masks.dirty, &trial.frames, |_| false);
    let stock = Price::of(plan.frames(), trial.costs.whole_s(), &film.workers);
    let price = film.price(&trial.costs, &plan, promise.dirtier);
    tracing::debug!(
        dirty = masks.share(),
        traced = plan.traced(),
        sources = plan.sources.len(),
        ?stock,
        ?price,
        "masks"
    );
    if !always && !price.beats(&stock) {
        return Ok(Found::Whole(vec![DEAR.into()]));
    }
    let rest = Rest {
        film,
        delivery,
        trial,
        masks: &masks,
        plan: &plan,
        always,
    };
    rest.render(done)
}

/// Why frames are rendered whole that need not be.
const DEAR: &str = "whole frames take no longer";

/// What a plan can say: where everything is, what that touches; and with `probe`,
/// which renders two frames, what it costs.
///
/// # Errors
/// What goes wrong with POV-Ray.
pub fn forecast(
    povray: &PovRay,
    scene: &PlainScene,
    look: &Look,
    frames: Vec<u32>,
    most: usize,
    probe: bool,
    run: &RunContext,
) -> Result<Forecast, RenderError> {
    let mut said = Forecast {
        whole: look.whole.iter().map(ToString::to_string).collect(),
        ..Forecast::default()
    };
    if !said.whole.is_empty() || frames.len() < 3 {
        return Ok(said);
    }
    let film = Film {
        povray,
        scene,
        look,
        workers: Workers {
            stated: None,
            most: most.min(frames.len()),
            cores: crate::probe::cores(),
        },
        frames,
        run,
        given: Mutex::default(),
        composed: AtomicU64::default(),
    };
    let trial = if probe { Some(film.trial()?) } else { None };
    said.costs = trial.as_ref().map(|trial| trial.costs);
    if let Some(trial) = &trial {
        let (costs, left) = (&trial.costs, film.frames.len() - trial.frames.len());
        let sounding = match film.sounding()? {
            Found::This(found) => found,
            Found::Whole(reasons) => {
                said.whole = reasons;
                return Ok(said);
            }
        };
        said.dirty = Some(sounding.share);
        let share = sounding.share * sounding.dirtier(costs);
        if !price::may_pay(costs, left, &film.workers)
            || !promises(costs, share, left, &film.workers)
        {
            let whole = Price::of(film.frames.len(), costs.whole_s(), &film.workers);
            said.whole = vec![DEAR.into()];
            said.prices = Some((whole, whole));
            return Ok(said);
        }
    }
    let boxes = match film.boxes(&film.frames, run)? {
        Found::This(boxes) => boxes,
        Found::Whole(reasons) => {
            said.whole = reasons;
            return Ok(said);
        }
    };
    let masks = match film.masks(&boxes, trial.as_ref().map(|trial| (trial, false)))? {
        Found::This(masks) => masks,
        Found::Whole(reasons) => {
            said.whole = reasons;
            return Ok(said);
        }
    };
    if let Some(block) = masks.unlike {
        said.whole = vec![unlike::reason(block)];
        return Ok(said);
    }
    said.proxies_only.clone_from(&masks.proxies_only);
    let known = masks.proxies_only.is_none() || masks.pixels > 0;
    said.dirty = known.then(|| masks.share());
    if let Some(trial) = trial {
        let costs = trial.costs;
        let plan = schedule(scene.grid(), &masks.dirty, &trial.frames, |_| false);
        let all = film.frames.len();
        let stock = Price::of(all, costs.whole_s(), &film.workers);
        let first = Price::of(trial.frames.len(), costs.whole_s(), &film.workers);
        let coherent = first.and(film.price(&costs, &plan, 1.0));
        if !coherent.beats(&stock) {
            said.whole = vec![DEAR.into()];
        }
        said.prices = Some((stock, coherent));
    }
    Ok(said)
}
