//! A random film: still and moving observers and objects, all lights, mirrors
//! and glass, with shadows and without, antialiased and not, in odd sizes.

use std::fmt::Write as _;
use std::path::Path;

use super::dice::Dice;
use super::objects::{FRAGMENTS, GROUNDS, NAMES, OPTICAL, SKIES, SOLIDS};

/// The first frame of every random film.
pub const FIRST_FRAME: u32 = 3;
/// How many frames it has.
pub const FRAMES: u32 = 4;

/// What a film is to be; the dice decide where this does not.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    /// With shadows, or without.
    pub shadows: Option<bool>,
    /// With the observer at rest, or not.
    pub observer_still: Option<bool>,
    /// With antialiasing 0.1 of depth 3, or without any.
    pub antialias: Option<bool>,
}

/// What a film came out as.
#[derive(Clone, Copy, Debug)]
pub struct RandomFilm {
    /// Are shadows cast?
    pub shadows: bool,
    /// Does the observer stand still?
    pub observer_still: bool,
    /// Is it antialiased?
    pub antialias: bool,
    /// Columns of a frame: no multiple of 32.
    pub width: u64,
    /// Rows of a frame: no multiple of 32.
    pub height: u64,
    /// Its lights.
    pub lights: u64,
}

impl RandomFilm {
    /// Writes `film.anim` and its objects into `folder`.
    pub fn write(dice: &mut Dice, wanted: Wanted, folder: &Path) -> Self {
        let save = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        let all = FRAGMENTS.iter().chain(&SOLIDS);
        for (name, text) in all.chain(&OPTICAL).chain(&GROUNDS) {
            save(name, text);
        }
        save("names.inc", NAMES);
        let film = Self {
            shadows: wanted.shadows.unwrap_or_else(|| dice.chance(80)),
            observer_still: wanted.observer_still.unwrap_or_else(|| dice.chance(70)),
            antialias: wanted.antialias.unwrap_or_else(|| dice.chance(50)),
            width: odd_size(dice, 60, 200),
            height: odd_size(dice, 50, 140),
            lights: 1 + dice.below(3),
        };
        let mut text = format!("@{FIRST_FRAME}\n");
        film.push_view(dice, wanted, &mut text);
        let _ = writeln!(text, "*background {}", dice.rgb(0.0, 1.0));
        if dice.chance(30) {
            let sky = dice.pick(SKIES);
            save("sky.inc", sky);
            text.push_str("*sky sky.inc\n");
        }
        let _ = writeln!(text, "*shadows {}", u8::from(film.shadows));
        film.push_lights(dice, &mut text);
        let objects = objects(dice);
        text.push_str(&objects.concat());
        if dice.chance(20) {
            // A second scene: one object is gone, the others are back at their
            // places; now and then the lights are others.
            let _ = writeln!(text, "@{}", FIRST_FRAME + 1 + dice.below(3) as u32);
            if dice.chance(30) {
                film.push_lights(dice, &mut text);
            }
            let gone = dice.below(objects.len() as u64) as usize;
            for (k, line) in objects.iter().enumerate() {
                if k != gone {
                    text.push_str(line);
                }
            }
        }
        save("film.anim", &text);
        film
    }

    fn push_view(&self, dice: &mut Dice, wanted: Wanted, text: &mut String) {
        let (mut eye_way, mut aim_way) = (String::new(), String::new());
        if !self.observer_still {
            let step = (-0.15, 0.15);
            eye_way = format!("  {}", dice.place(step, step, (-0.1, 0.3)));
            aim_way = format!("  {}", dice.place(step, step, step));
        }
        let eye = dice.place((-3.0, 3.0), (1.0, 4.0), (-18.0, -7.0));
        let _ = write!(
            text,
            "*eye {eye}{eye_way}\n*aim 0 0.5 0{aim_way}\n*angles {} {}\n\
             *size {} {}\n*frames {FRAMES}\n*include names.inc\n",
            dice.within(30.0, 80.0),
            dice.within(30.0, 70.0),
            self.width,
            self.height
        );
        if self.antialias {
            let usual = wanted.antialias.is_some() || dice.chance(70);
            let (threshold, depth) = if usual {
                (0.1, 3)
            } else {
                (dice.within(0.05, 0.4), 2 + dice.below(2))
            };
            let _ = writeln!(text, "*antialias {threshold} {depth}");
        }
    }

    fn push_lights(&self, dice: &mut Dice, text: &mut String) {
        for _ in 0..self.lights {
            let place = dice.place((-30.0, 30.0), (8.0, 40.0), (-40.0, 5.0));
            let towards = dice.place((-2.0, 2.0), (-1.0, 2.0), (-2.0, 3.0));
            let mut kind = match dice.below(4) {
                0 => "point".to_owned(),
                1 => format!("sun {towards}"),
                2 => {
                    let radius = dice.within(2.0, 15.0);
                    let falloff = radius + dice.within(0.5, 10.0);
                    format!("spot {towards} {radius} {falloff} {}", dice.below(4))
                }
                _ => {
                    let (u, v) = (dice.within(1.0, 5.0), dice.within(1.0, 5.0));
                    let (columns, rows) = (1 + dice.below(4), 2 + dice.below(3));
                    format!("area {u} 0 1 0 {v} 1 {columns} {rows}")
                }
            };
            if dice.chance(20) {
                let _ = write!(kind, " fade {} 2", dice.within(20.0, 40.0));
            }
            // Together they do not burn the picture out.
            let high = 1.2 / self.lights as f64;
            let _ = writeln!(
                text,
                "*light {place} {} {kind}",
                dice.rgb(0.15 * high, high)
            );
        }
    }
}

/// A size from `low` up, that leaves a part of a block at the edge.
fn odd_size(dice: &mut Dice, low: u64, range: u64) -> u64 {
    let size = low + dice.below(range);
    if size.is_multiple_of(32) {
        size + 1
    } else {
        size
    }
}

/// The lines of the objects: at least one moves, and one does not.
fn objects(dice: &mut Dice) -> Vec<String> {
    let mut lines = Vec::new();
    // In a busy film almost everything changes; in a quiet one most stays, so
    // that what was kept is put to the test.
    let busy = dice.chance(40);
    if dice.chance(75) {
        let (path, _) = dice.pick(&GROUNDS);
        let height = dice.within(-1.5, -0.5);
        lines.push(format!("!{path} 0 {height} 0 0 0 0 name=ground\n"));
    }
    for k in 0..4 + dice.below(6) {
        let path = if dice.chance(if busy { 35 } else { 5 }) {
            dice.pick(&OPTICAL).0
        } else if dice.chance(45) {
            dice.pick(&SOLIDS).0
        } else {
            dice.pick(&FRAGMENTS).0
        };
        let turn = (-180.0, 180.0);
        let place = dice.place((-4.0, 4.0), (-1.0, 3.0), (-3.0, 5.0));
        let mut line = format!("!{path} {place} {}", dice.place(turn, turn, turn));
        let moves = match k {
            0 => true,
            1 => false,
            _ => dice.chance(if busy { 40 } else { 10 }),
        };
        if moves {
            // Large steps and small ones; some only turn.
            let reach = *dice.pick(&[0.0, 0.02, 0.2, 1.0]);
            let spin = if reach == 0.0 {
                20.0
            } else {
                *dice.pick(&[0.0, 2.0, 30.0])
            };
            let (way, angle) = ((-reach, reach), (-spin, spin));
            let _ = write!(
                line,
                "  {} {}",
                dice.place(way, (-reach / 2.0, reach / 2.0), way),
                dice.place(angle, angle, angle)
            );
        }
        let _ = writeln!(line, " name=object{k}");
        lines.push(line);
    }
    lines
}
