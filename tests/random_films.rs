//! Random films through the whole program, against the stock renderer's own
//! frames. `DECOR_RANDOM_FILMS` films are tried by each test (default 12), from
//! the seed `DECOR_RANDOM_SEED` (default 1). Every film is printed with the share
//! of pixels that was traced (`--no-capture` shows it); one that fails is kept,
//! and its folder named.

mod common;
mod support;

use support::random_film::Wanted;
use support::trial::{Trial, number, try_films, try_these};

/// A step of 8 bits, in 16 bits.
const STEP: u16 = 257;

fn count() -> u64 {
    number("DECOR_RANDOM_FILMS", 12)
}

/// Any film; every fourth has what is layered without any knowledge of shadows.
fn wanted_of_all(k: u64) -> Wanted {
    let plain = k % 4 == 1;
    Wanted {
        shadows: plain.then_some(false),
        observer_still: plain.then_some(true),
        ..Wanted::default()
    }
}

fn no_pixel_differs(trial: &mut Trial, out: &str) {
    for (name, pixels) in trial.differences(out, "plain") {
        let mut wrong = pixels.iter().filter(|(_, far)| *far > 0);
        if let Some((place, far)) = wrong.next() {
            let more = wrong.count();
            trial.fail(format!(
                "{out} {name}: {place:?} by {far} of 65535, and {more} more pixels"
            ));
        }
    }
}

/// `exact` with anything, and `equivalent` at threshold 0 without antialiasing
/// and shadows, give the renderer's own frames: not one pixel differs.
#[test]
fn random_films_are_the_renderers_own() {
    let layered = try_films(count(), wanted_of_all, |trial| {
        if trial.render("plain", &["--baseline"]).is_none() {
            return;
        }
        let mut runs = vec![("exact", vec!["--mode", "exact", "--no-fallback"])];
        if !trial.film.antialias && !trial.film.shadows {
            runs.push(("merged", vec!["--threshold", "0", "--no-fallback"]));
        }
        for (out, options) in runs {
            let Some(layered) = trial.render_layered(out, &options) else {
                continue;
            };
            if out == "exact" && trial.film.observer_still && !trial.film.shadows && !layered {
                trial.fail("exact: nothing was kept of what stands still".to_owned());
            }
            no_pixel_differs(trial, out);
        }
    });
    assert!(layered > 0 || count() < 2, "no film was layered");
}

/// Films in which `exact` was not: the picture's border cut a block that was
/// antialiased in a crop, as a whole one.
#[test]
fn films_that_were_wrong_once() {
    let exact = ["--mode", "exact", "--no-fallback"];
    try_these(2026, &[61, 71, 105], wanted_of_all, |trial| {
        if trial.render("plain", &["--baseline"]).is_some()
            && trial.render_layered("exact", &exact).is_some()
        {
            no_pixel_differs(trial, "exact");
        }
    });
}

/// `equivalent` with shadows, an observer at rest and threshold 0. Without
/// antialiasing no pixel is off by more than 2/255; with it (0.1, depth 3) at
/// most 0.1 % of the pixels of a frame by more than 4/255, none by more than
/// 32/255.
#[test]
fn shadows_fall_across_layers() {
    try_films(
        count(),
        |k| Wanted {
            shadows: Some(true),
            observer_still: Some(true),
            antialias: Some(k % 2 == 1),
        },
        |trial| {
            if trial.render("plain", &["--baseline"]).is_none() {
                return;
            }
            let options = ["--threshold", "0", "--no-fallback"];
            if trial.render_layered("equivalent", &options).is_none() {
                return;
            }
            let (near, share, far) = if trial.film.antialias {
                (4 * STEP, 0.001, 32 * STEP)
            } else {
                (2 * STEP, 0.0, 2 * STEP)
            };
            for (name, pixels) in trial.differences("equivalent", "plain") {
                let off = pixels.iter().filter(|(_, by)| *by > near).count();
                let worst = pixels.iter().max_by_key(|(_, by)| *by);
                let Some(&(place, by)) = worst else { continue };
                if by > far || off as f64 > share * pixels.len() as f64 {
                    trial.fail(format!(
                        "{name}: {off} of {} pixels off by more than {near} of 65535; {place:?} by {by}",
                        pixels.len()
                    ));
                }
            }
        },
    );
}
