//! Random films: `equivalent` at threshold 0 without antialiasing and shadows, and `exact` with
//! anything, are the stock renderer's own frames. `DECOR_RANDOM_FILMS` films are
//! tried (default 6), from the seed `DECOR_RANDOM_SEED` (default 1); a film that
//! fails is kept, and its folder named.

mod common;

use std::fmt::Write as _;
use std::path::Path;

use common::{Run, differing_pixels};

/// A small generator of numbers: the same films everywhere (SplitMix64).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        // Short numbers: a film is read by people.
        ((low + unit * (high - low)) * 1000.0).round() / 1000.0
    }

    fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len() as u64) as usize]
    }

    fn rgb(&mut self) -> String {
        format!(
            "{} {} {}",
            self.within(0.0, 1.0),
            self.within(0.0, 1.0),
            self.within(0.0, 1.0)
        )
    }
}

const FRAGMENTS: [(&str, &str); 9] = [
    (
        "plain.inc",
        "#declare S = 0.8;\nbox { -S, S pigment { rgb <0.8,0.3,0.2> } finish { phong 0.6 } }\n",
    ),
    (
        "checker.inc",
        "#declare S = 1.1;\nsphere { 0, S pigment { checker rgb 1, rgb <0.1,0.3,0.8> scale 0.31 } }\n",
    ),
    (
        "bored.inc",
        "difference { sphere { 0, 1 } cylinder { -2*x, 2*x, 0.5 } cylinder { -2*y, 2*y, 0.4 pigment { rgb y } } pigment { rgb <0.9,0.9,0.2> } }\n",
    ),
    (
        "glass.inc",
        "sphere { 0, 0.9 pigment { rgbt <0.9,1,0.9,0.8> } finish { phong 1 } interior { ior 1.4 } }\n",
    ),
    (
        "mirror.inc",
        "cylinder { -y, y, 0.7 pigment { rgb 0.2 } finish { reflection 0.7 } }\n",
    ),
    (
        "cloud.inc",
        "union { #local I = 0; #while (I < 9) sphere { <sin(I), cos(2*I), sin(3*I)>, 0.3 } #local I = I + 1; #end pigment { bozo scale 0.3 color_map { [0 rgb 0.2][1 rgb <1,0.7,0.4>] } } }\n",
    ),
    ("named.inc", "object { Thing texture { Skin } }\n"),
    (
        "torus.inc",
        "torus { 0.8, 0.25 pigment { gradient y color_map { [0 rgb x][1 rgb z] } scale 0.5 } normal { bumps 0.4 scale 0.1 } }\n",
    ),
    (
        "library.inc",
        "#include \"colors.inc\"\n#include \"woods.inc\"\nbox { -0.7, 0.7 texture { pigment { P_WoodGrain1A color_map { M_Wood1A } } } }\n",
    ),
];

const SOLIDS: [(&str, &str); 4] = [
    (
        "ball.ron",
        "material((colour: (0.2, 0.7, 0.3), phong: (amount: 0.5, size: 30)), sphere(radius: 1))",
    ),
    (
        "ring.ron",
        "difference(cylinder(base: (0, -0.3, 0), cap: (0, 0.3, 0), radius: 1), [cylinder(base: (0, -1, 0), cap: (0, 1, 0), radius: 0.6)])",
    ),
    (
        "jewel.ron",
        "material((colour: (0.9, 0.2, 0.3), transmission: 0.7, ior: 1.5), intersection([sphere(radius: 1), box(min: (-0.7, -0.7, -0.7), max: (0.7, 0.7, 0.7))]))",
    ),
    (
        "floor.ron",
        "material((colour: (0.6, 0.6, 0.5)), plane(normal: (0, 1, 0), distance: 0))",
    ),
];

/// Writes a random film; gives whether it is free of antialiasing and shadows.
fn write_film(dice: &mut Dice, folder: &Path) -> bool {
    for (name, text) in FRAGMENTS.iter().chain(&SOLIDS) {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let declarations = "#declare Thing = superellipsoid { <0.4,0.4> scale 0.8 }\n\
                        #declare Skin = texture { pigment { granite scale 0.5 } }\n";
    std::fs::write(folder.join("names.inc"), declarations).unwrap();
    let skies = [
        "sky_sphere { pigment { gradient y color_map { [0 rgb <0.8,0.8,1>][1 rgb <0.1,0.2,0.7>] } } }\n",
        "fog { distance 25 rgb <0.7,0.7,0.8> }\nbackground { rgb <0.7,0.7,0.8> }\n",
    ];
    let (width, height) = (60 + dice.below(120), 50 + dice.below(80));
    let (antialias, shadows) = (dice.chance(40), dice.chance(20));
    let mut film = String::from("@3\n");
    let eye = (
        dice.within(-3.0, 3.0),
        dice.within(1.0, 4.0),
        dice.within(-12.0, -7.0),
    );
    let _ = write!(
        film,
        "*eye {} {} {}\n*aim 0 0.5 0\n*angles {} {}\n*size {width} {height}\n*frames 4\n*include names.inc\n",
        eye.0,
        eye.1,
        eye.2,
        dice.within(30.0, 80.0),
        dice.within(30.0, 70.0)
    );
    let _ = writeln!(film, "*background {}", dice.rgb());
    if dice.chance(40) {
        std::fs::write(folder.join("sky.inc"), dice.pick(&skies)).unwrap();
        film.push_str("*sky sky.inc\n");
    }
    if antialias {
        let _ = writeln!(
            film,
            "*antialias {} {}",
            dice.within(0.05, 0.4),
            2 + dice.below(2)
        );
    }
    let _ = writeln!(film, "*shadows {}", u8::from(shadows));
    for _ in 0..1 + dice.below(3) {
        let place = format!(
            "{} {} {}",
            dice.within(-30.0, 30.0),
            dice.within(10.0, 40.0),
            dice.within(-40.0, 0.0)
        );
        let kind = *dice.pick(&[
            "point",
            "sun 0 0 0",
            "spot 0 0 0 20 40 2",
            "area 4 0 0 0 4 0 3 3",
            "point fade 30 2",
        ]);
        let _ = writeln!(film, "*light {place} {} {kind}", dice.rgb());
    }
    for k in 0..4 + dice.below(7) {
        let neutral = dice.chance(40);
        let path = if neutral {
            dice.pick(&SOLIDS).0
        } else {
            dice.pick(&FRAGMENTS).0
        };
        let floor = path == "floor.ron";
        let place = if floor {
            (0.0, dice.within(-1.5, -0.5), 0.0)
        } else {
            (
                dice.within(-4.0, 4.0),
                dice.within(-1.0, 3.0),
                dice.within(-3.0, 5.0),
            )
        };
        let mut angle = || {
            if floor {
                0.0
            } else {
                dice.within(-180.0, 180.0)
            }
        };
        let angles = (angle(), angle(), angle());
        let _ = write!(
            film,
            "!{path} {} {} {} {} {} {}",
            place.0, place.1, place.2, angles.0, angles.1, angles.2
        );
        if !floor && dice.chance(40) {
            let _ = write!(
                film,
                " {} {} {} {} 0 {}",
                dice.within(-1.0, 1.0),
                dice.within(-0.5, 0.5),
                dice.within(-1.0, 1.0),
                dice.within(-20.0, 20.0),
                dice.within(-30.0, 30.0)
            );
        }
        let _ = writeln!(film, " name=object{k}");
    }
    std::fs::write(folder.join("film.anim"), film).unwrap();
    !antialias && !shadows
}

/// POV-Ray with one thread. With more, it does not agree with itself: which
/// thread takes which block is left to chance, and each remembers what shadowed
/// its last point. Where shadows fall through glass, single pixels depend on it.
fn one_thread(folder: &Path) -> std::path::PathBuf {
    use std::os::unix::fs::PermissionsExt as _;
    let path = folder.join("povray");
    let text =
        "#!/bin/sh\n[ \"$1\" = --version ] && exec povray --version\nexec povray \"$@\" +WT1\n";
    std::fs::write(&path, text).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable)
        .ok()
        .and_then(|v| v.parse().ok())
        .unwrap_or(default)
}

#[test]
fn random_films_are_the_renderers_own() {
    let seed = number("DECOR_RANDOM_SEED", 1);
    for k in 0..number("DECOR_RANDOM_FILMS", 6) {
        let folder = tempfile::tempdir().unwrap();
        let mut dice = Dice(seed.wrapping_mul(1_000_003).wrapping_add(k));
        let simple = write_film(&mut dice, folder.path());
        let povray = one_thread(folder.path());
        let render = |out: &str, extra: &[&str]| {
            let ended = Run::new(["render", "--format", "png16", "-q"])
                .arg(folder.path().join("film.anim"))
                .arg("-o")
                .arg(folder.path().join(out))
                .args(extra)
                .env("DECOR_CACHE", folder.path().join("cache"))
                .env("DECOR_POVRAY", &povray)
                .ends();
            (ended.status, ended.stderr)
        };
        let mut wrong = Vec::new();
        let mut runs = vec![
            ("plain", vec!["--baseline"]),
            ("exact", vec!["--mode", "exact", "--no-fallback"]),
        ];
        if simple {
            runs.push(("merged", vec!["--no-fallback", "--threshold", "0"]));
        }
        for (out, extra) in &runs {
            let (status, stderr) = render(out, extra);
            if status != 0 {
                wrong.push(format!("{out}: status {status}: {stderr}"));
            } else if *out != "plain" {
                for frame in 3..7 {
                    let name = format!("frame_{frame:04}.png");
                    let (a, b) = (
                        folder.path().join(out).join(&name),
                        folder.path().join("plain").join(&name),
                    );
                    let pixels = differing_pixels(&a, &b);
                    if !pixels.is_empty() {
                        wrong.push(format!(
                            "{out} {name}: {} pixels, first {:?}",
                            pixels.len(),
                            pixels[0]
                        ));
                    }
                }
            }
        }
        if !wrong.is_empty() {
            let kept = folder.keep();
            panic!(
                "film {k} of seed {seed}, kept in {}:\n{}",
                kept.display(),
                wrong.join("\n")
            );
        }
    }
}
