//! Scenes as people write them, at random: cameras, lights, CSG, glass, mirrors,
//! macros, loops, includes, random numbers, and a clock that moves some of it.

use std::fmt::Write as _;
use std::path::Path;

use crate::dice::Dice;

/// A scene with its include file and its switches.
pub struct RandomScene {
    scene: String,
    include: String,
    switches: Vec<String>,
}

const HEAD: &str = r##"#version 3.7;
global_settings { assumed_gamma 1 max_trace_level 6 }
#include "colors.inc"
#include "transforms.inc"
#declare V = clock * 2 - 1;
#declare P = vrotate(<1, .3, 0>, y * V * 120);
#macro Chain(N, A)
  union { #local I = 0; #while (I < N) sphere { <.3 * I, A * I, 0>, .2 } #local I = I + 1; #end }
#end
#macro Put(A, B) object { Chain(3, A) translate B pigment { rgb <.2, .8, .4> } } #end
#include "own.inc"
"##;

impl RandomScene {
    /// The scene that the dice show.
    pub fn of(dice: &mut Dice) -> Self {
        let mut text = HEAD.to_owned();
        camera(dice, &mut text);
        lights(dice, &mut text);
        surroundings(dice, &mut text);
        for _ in 0..3 + dice.below(6) {
            let at = format!(
                "rotate {} translate {}",
                place(dice, (0.0, 90.0), (0.0, 90.0), (0.0, 90.0)),
                place(dice, (-3.0, 3.0), (0.0, 2.5), (-1.5, 3.0))
            );
            let look = texture(dice);
            let line = object(dice, &format!("{look} {at}"));
            let _ = writeln!(text, "{line}");
        }
        for _ in 0..1 + dice.below(3) {
            let line = moving(dice);
            let _ = writeln!(text, "{line}");
        }
        Self {
            scene: text,
            include: include(dice),
            switches: switches(dice),
        }
    }

    /// Writes its files.
    pub fn write(&self, folder: &Path) {
        std::fs::write(folder.join("s.pov"), &self.scene).unwrap();
        std::fs::write(folder.join("own.inc"), &self.include).unwrap();
    }

    /// Its switches.
    pub fn switches(&self) -> Vec<&str> {
        self.switches.iter().map(String::as_str).collect()
    }
}

fn place(dice: &mut Dice, x: (f64, f64), y: (f64, f64), z: (f64, f64)) -> String {
    format!("<{}>", dice.place(x, y, z).replace(' ', ","))
}

fn colour(dice: &mut Dice) -> String {
    format!("<{}>", dice.rgb(0.0, 1.0).replace(' ', ","))
}

fn switches(dice: &mut Dice) -> Vec<String> {
    let antialias: &[&str] = match dice.below(5) {
        0 => &["-A"],
        1 => &["+A0.1", "+R2"],
        2 => &["+A0.1", "+AM2", "+R2"],
        3 => &["+A0.2", "-J"],
        _ => &["+A0.05", "+AM2", "+R2", "+J2"],
    };
    let format: &[&str] = match dice.below(6) {
        0 => &["+FN16"],
        1 => &["+FP"],
        2 => &["+FN", "+UA"],
        3 => &["+FT", "+TH"],
        _ => &["+FN"],
    };
    let size: &[&str] = if dice.chance(50) {
        &["+W160", "+H120"]
    } else {
        &["+W150", "+H101"]
    };
    let words = size.iter().chain(antialias).chain(format);
    let mut list: Vec<String> = words.map(|word| (*word).to_owned()).collect();
    list.push(format!("+KFF{}", 4 + dice.below(2)));
    list
}

fn camera(dice: &mut Dice, text: &mut String) {
    let from = place(dice, (-3.0, 3.0), (0.5, 4.0), (-7.0, -4.0));
    let to = place(dice, (-0.5, 0.5), (0.2, 1.0), (-0.5, 0.5));
    let angle = dice.within(35.0, 75.0);
    let line = match dice.below(10) {
        0 if dice.chance(50) => format!(
            "location {from} look_at {to} angle {angle} aperture .2 blur_samples 7 focal_point 0"
        ),
        0..=4 => {
            format!("location {from} look_at {to} right x*image_width/image_height angle {angle}")
        }
        5..=6 => format!("perspective location {from} up y right 4/3*x direction z*1.3 look_at 0"),
        7 => format!(
            "location <0,1,-6> direction z*1.2 up y right -x*4/3 rotate {} translate .2*y",
            place(dice, (0.0, 15.0), (-30.0, 30.0), (-10.0, 10.0))
        ),
        8 => format!("fisheye location {from} look_at {to} angle 120"),
        _ => format!("orthographic location {from} look_at {to} right 6*x up 4.5*y"),
    };
    let _ = writeln!(text, "camera {{ {line} }}");
}

fn lights(dice: &mut Dice, text: &mut String) {
    for _ in 0..1 + dice.below(3) {
        let at = place(dice, (-6.0, 6.0), (3.0, 9.0), (-7.0, 4.0));
        let bright = dice.within(0.3, 0.8);
        let kind = *dice.pick(&[
            "",
            "",
            "shadowless",
            "spotlight point_at 0 radius 20 falloff 40",
            "fade_distance 5 fade_power 2",
            "rotate y*40",
            "area_light x, z, 3, 3 adaptive 1",
            "parallel point_at 0",
        ]);
        let _ = writeln!(text, "light_source {{ {at} color rgb {bright} {kind} }}");
    }
}

fn surroundings(dice: &mut Dice, text: &mut String) {
    if dice.chance(50) {
        text.push_str(
            "sky_sphere { pigment { gradient y color_map { [0 rgb .9] [1 rgb <.2,.4,.9>] } } }\n",
        );
    }
    if dice.chance(20) {
        text.push_str("fog { distance 30 rgb .6 }\n");
    }
    if dice.chance(8) {
        let kind = *dice.pick(&["emission .05", "absorption .2", "scattering { 1, .2 }"]);
        let _ = writeln!(
            text,
            "sphere {{ {}, 1 hollow pigment {{ rgbt 1 }} interior {{ media {{ {kind} samples 3 \
             density {{ bozo }} }} }} }}",
            place(dice, (-2.0, 2.0), (0.0, 2.0), (-1.0, 2.0))
        );
    }
    if dice.chance(4) {
        text.push_str("media { scattering { 1, .02 } samples 2 method 3 }\n");
    }
    if dice.chance(85) {
        let mirror = if dice.chance(25) {
            "finish { reflection .3 }"
        } else {
            ""
        };
        let tilt = if dice.chance(20) { "rotate z*5" } else { "" };
        let look = texture(dice);
        let _ = writeln!(text, "plane {{ y, -.5 {look} {mirror} {tilt} }}");
    }
    if dice.chance(30) {
        let look = texture(dice);
        let _ = writeln!(text, "plane {{ z, 6 {look} rotate y*10 }}");
    }
}

fn texture(dice: &mut Dice) -> String {
    let c = colour(dice);
    let pigment = match dice.below(10) {
        0 => format!(
            "pigment {{ rgbt <{},{}> }}",
            dice.rgb(0.0, 1.0).replace(' ', ","),
            dice.within(0.3, 0.95)
        ),
        1 => format!(
            "pigment {{ rgbf <{},{}> }}",
            dice.rgb(0.0, 1.0).replace(' ', ","),
            dice.within(0.3, 0.95)
        ),
        2..=3 => format!("pigment {{ checker rgb {c} rgb .2 scale .4 }}"),
        4 => format!("pigment {{ bozo color_map {{ [0 rgb {c}] [1 rgb 1] }} scale .3 }}"),
        _ => format!("pigment {{ rgb {c} }}"),
    };
    let finish = match dice.below(8) {
        0..=1 => "finish { phong .6 }",
        2 => "finish { reflection .4 }",
        _ => "",
    };
    let normal = if dice.chance(15) {
        "normal { bumps .5 scale .1 }"
    } else {
        ""
    };
    format!("{pigment} {finish} {normal}")
}

/// An object with these modifiers.
fn object(dice: &mut Dice, more: &str) -> String {
    let r = dice.within(0.2, 0.6);
    let shape = match dice.below(10) {
        0 => format!("sphere {{ 0, {r}"),
        1 => format!(
            "box {{ -{r}, {}",
            place(dice, (0.1, 0.6), (0.1, 0.9), (0.1, 0.6))
        ),
        2 => format!(
            "cylinder {{ -{r}*y, {}*x, {}",
            dice.within(0.2, 0.8),
            dice.within(0.05, 0.3)
        ),
        3 => format!(
            "torus {{ {}, {}",
            dice.within(0.4, 0.7),
            dice.within(0.05, 0.2)
        ),
        4 => format!("cone {{ 0, {r}, y, {}", dice.within(0.0, 0.2)),
        5 => "text { ttf \"cyrvetic.ttf\" \"Fz\" .2, 0".to_owned(),
        6 => "blob { threshold .4 sphere { 0, .7, 1 } sphere { <.4,.1,0>, .6, 1 }".to_owned(),
        7 => "difference { box { -.4, .4 } sphere { 0, .5 }".to_owned(),
        8 => "disc { 0, y, .6".to_owned(),
        _ => "superellipsoid { <.4, .6> scale .4".to_owned(),
    };
    // Rays go another way behind the surface.
    let bends = more.contains("rgbt") || more.contains("rgbf");
    let inside = if bends && dice.chance(40) {
        "interior { ior 1.4 }"
    } else {
        ""
    };
    format!("{shape} {more} {inside} }}")
}

const MOTIONS: &[&str] = &[
    "translate <2*clock-1, sin(clock*6), 0>",
    "rotate y*360*clock",
    "translate x*V",
    "scale 1+.5*clock",
    "rotate <90*clock, 0, 45>",
    "translate P",
    "translate <0, (frame_number-1)*.4, 0>",
    "translate y*int(clock*2)",
];

fn moving(dice: &mut Dice) -> String {
    let (look, by) = (texture(dice), *dice.pick(MOTIONS));
    let to = format!(
        "translate {}",
        place(dice, (-2.0, 2.0), (0.2, 1.5), (-1.0, 2.0))
    );
    match dice.below(20) {
        0..=6 => object(dice, &format!("{look} {by} {to}")),
        7..=8 => object(
            dice,
            &format!("pigment {{ rgb <clock, 1-clock, .5> }} {to}"),
        ),
        9..=10 => {
            let at = place(dice, (-2.0, 2.0), (0.0, 1.0), (-1.0, 1.0));
            format!("Put(.2*clock, {at})\nPut(.3, <0,0,1>)")
        }
        11..=12 => {
            let one = object(dice, &format!("{look} {to}"));
            format!("#if (clock > .4) {one} #end")
        }
        13..=14 => {
            let (still, moved) = (object(dice, &look), object(dice, &format!("{look} {by}")));
            let third = if dice.chance(50) {
                "#if (V > 0) sphere { <1,1,0>, .3 } #end".to_owned()
            } else {
                object(dice, &format!("{look} translate <1.4, .6, 0>"))
            };
            format!("union {{ {still} {moved} {third} {to} }}")
        }
        15..=16 => {
            let one = object(dice, &format!("{look} translate x*I*.5 {to}"));
            format!("#declare I = 0; #while (I < 3+2*clock) {one} #declare I = I + 1; #end")
        }
        17..=18 => {
            let mut one = object(dice, &format!("{look} {by}"));
            if dice.chance(60) {
                let others = ["-1.1*x", "<.3, 1.2, .5>"]
                    .map(|at| object(dice, &format!("{look} translate {at}")));
                let [two, three] = others;
                one = format!(
                    "union {{ {one} union {{ {two} {three} scale .8 }} {look} rotate z*40*clock }}"
                );
            }
            format!(
                "#declare Ob = {one}\nobject {{ Ob {to} }}\nobject {{ Ob {to} translate -.7*x }}"
            )
        }
        _ => format!(
            "#declare R1 = seed(7); #declare I = 0;\n\
             #while (I < int(2+3*clock)) #declare Q = rand(R1); #declare I = I + 1; #end\n\
             sphere {{ <rand(R1)*2-1, rand(R1), 0>, .3 {look} }}"
        ),
    }
}

fn include(dice: &mut Dice) -> String {
    if dice.chance(60) {
        return "#declare UserBall = sphere { 0, .25 }\n".into();
    }
    let look = texture(dice);
    let one = object(dice, &format!("{look} translate <Z, 1, 0>"));
    let ball = texture(dice);
    format!(
        "#local Z = clock;\n{one}\n#declare UserBall = sphere {{ 0, .25 {ball} }}\n\
         object {{ UserBall translate <-1, 0, -1> }}\n"
    )
}
