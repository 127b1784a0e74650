//! Scenes that nobody wrote for decor: their objects are where decor says that
//! they are, what moves can be taken away, and nothing that a scene does makes
//! decor say what is wrong.

mod common;

use std::time::Duration;

use common::unedited::Film;
use decor_povray::unedited::{Extent, Kind, boxes};
use glam::DVec3;

/// Objects of every kind, about as large as 2, around the origin.
const KINDS: &[&str] = &[
    "sphere{0,1",
    "box{-.7,.8",
    "cone{-y,1,y,.2",
    "cylinder{-x,y,.4",
    "torus{.9,.3",
    "union{sphere{.5*x,.6} box{-.6,0}",
    "merge{sphere{.5*x,.6} box{-.6,0}",
    "intersection{sphere{0,1} box{-.8,.8}",
    "difference{box{-.8,.8} sphere{0,.9}",
    "difference{sphere{0,1} plane{y,0}",
    "object{sphere{0,.5} scale <1,2,.5>",
    "disc{0,<1,1,-1>,1,.3",
    "triangle{-x,y,<1,-.5,.3>",
    "smooth_triangle{-x,-z,y,-z,<1,-.5,.3>,-z",
    "mesh{triangle{-x,y,x} triangle{-x,-y,z}",
    "mesh2{vertex_vectors{4,-x,y,x,<0,-1,1>} face_indices{2,<0,1,2>,<0,2,3>}",
    "blob{threshold .4 sphere{-.4*x,.9,1} cylinder{0,y,.5,1} sphere{.3*x,.4,-1}",
    "text{ttf \"cyrvetic.ttf\" \"gQ\" .3,0",
    "height_field{function 16,16{x*y} translate -.5 scale 1.5",
    "isosurface{function{x*x+y*y*y+z*z-.4} contained_by{box{-1,1}} max_gradient 6",
    "isosurface{function{x*x+y*y*2+z*z-.4} max_gradient 6",
    "parametric{function{u},function{v},function{u*v} <-1,-1>,<1,1> contained_by{box{-1.1,1.1}} precompute 8 x,y,z",
    "julia_fractal{<-.08,0,-.83,-.02> quaternion sqr max_iteration 6 precision 20",
    "lathe{cubic_spline 5 <.2,-1>,<.6,-.8>,<.8,0>,<.3,.7>,<0,1>",
    "sor{5 <.5,-1>,<.5,-.7>,<.8,0>,<.3,.7>,<.2,.9>",
    "prism{cubic_spline -.5,.5,8 <-1,-1>,<-1,1>,<1,1>,<.5,0>,<1,-1>,<-1,-1>,<-1,1>,<1,1>",
    "prism{conic_sweep linear_spline .2,1,4 <-1,-1>,<0,1>,<1,-1>,<-1,-1>",
    "polygon{4 <-1,-1>,<0,1>,<1,-.3>,<-1,-1>",
    "quadric{<1,2,1>,0,0,-.7",
    "superellipsoid{<.3,1.6>",
    "bicubic_patch{type 1 u_steps 3 v_steps 3 <-1,-1,0><-.3,-1,1><.3,-1,1><1,-1,0><-1,-.3,1><-.3,-.3,2><.3,-.3,2><1,-.3,1><-1,.3,1><-.3,.3,2><.3,.3,2><1,.3,1><-1,1,0><-.3,1,1><.3,1,1><1,1,0>",
    "sphere_sweep{linear_spline 3, -x,.2, y,.4, x,.1",
    "sphere_sweep{cubic_spline 5, -2*x,.2, -x,.2, y,.4, x,.1, <2,-1,0>,.2",
    "sphere_sweep{b_spline 5, -2*x,.3, -x,.2, y,.5, x,.3, <2,-1,0>,.2",
    "ovus{.8,.4",
    "sphere{0,1 clipped_by{box{-.5,2}}",
    "sphere{0,1 bounded_by{box{-.1,.1}}",
    "sphere{0,1 inverse",
    "union{union{sphere{-x,.3} rotate z*30} bounded_by{sphere{<-.87,-.5,0>,.25}}",
    "intersection{plane{y,.5} plane{-y,.5} plane{x,.5} plane{-x,.5} plane{z,.5} plane{-z,.5}",
    "quadric{<1,0,1>,0,0,-.3 clipped_by{box{-.9,.9}}",
];

/// Levels of a channel that an object's number is written with, and their bytes.
const LEVELS: [(f64, u8); 4] = [(0.0, 0), (0.1, 89), (0.4, 170), (1.0, 255)];

const COLUMNS: usize = 8;
const ROWS: usize = 6;
const CELL: f64 = 4.0;

fn centre(k: usize) -> (f64, f64) {
    let (column, row) = (k % COLUMNS, k / COLUMNS);
    (
        (column as f64 + 0.5) * CELL - COLUMNS as f64 * CELL / 2.0,
        (row as f64 + 0.5) * CELL - ROWS as f64 * CELL / 2.0,
    )
}

/// All kinds, turned by the clock, seen along z or along -x.
fn zoo(along_x: bool) -> String {
    let mut text = String::from(
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\n#default{finish{ambient 0 diffuse 0 emission 1}}\n",
    );
    text += if along_x {
        "camera{orthographic location 50*x direction -x right z*32 up y*24}\n"
    } else {
        "camera{orthographic location -50*z direction z right x*32 up y*24}\n"
    };
    for (k, kind) in KINDS.iter().enumerate() {
        let number = k + 1;
        let level = |digit: usize| LEVELS[number / 4_usize.pow(digit as u32) % 4].0;
        let (a, b) = centre(k);
        let at = if along_x {
            format!("<0,{b},{a}>")
        } else {
            format!("<{a},{b},0>")
        };
        text += &format!(
            "{kind} pigment{{rgb <{},{},{}>}} rotate <70*clock,40*clock,99*clock> translate {at}}}\n",
            level(0),
            level(1),
            level(2)
        );
    }
    text
}

/// The number that a pixel says.
fn number(pixel: &[u8]) -> usize {
    let digit = |byte: u8| {
        let near = LEVELS
            .iter()
            .position(|(_, level)| level.abs_diff(byte) < 12);
        near.unwrap_or_else(|| panic!("no level: {byte}"))
    };
    digit(pixel[0]) + 4 * digit(pixel[1]) + 16 * digit(pixel[2])
}

#[test]
fn boxes_contain_objects_of_every_kind() {
    // Flat ones are not seen from the side.
    let mut seen = vec![0; KINDS.len()];
    for along_x in [false, true] {
        let film = Film::new(&[("a.pov", &zoo(along_x))], &[]);
        assert_eq!(film.analysis.whole, [], "nothing is refused");
        assert_eq!(film.analysis.moving().count(), KINDS.len());
        let found = film.boxes();
        assert_eq!(found.whole, [], "everything has an end");
        assert_eq!(found.frames[0].camera, None, "it is orthographic");
        let objects: Vec<usize> = film.analysis.moving().map(|(index, _)| index).collect();
        for (frame, picture) in found.frames.iter().zip(film.pictures(&film.scene)) {
            let (columns, rows, bytes) = picture;
            let (step_x, step_y) = (32.0 / columns as f64, 24.0 / rows as f64);
            for (at, pixel) in bytes.chunks(3).enumerate() {
                let number = number(pixel);
                if number == 0 {
                    continue;
                }
                seen[number - 1] += 1;
                let x = ((at % columns) as f64 + 0.5) * step_x - 16.0;
                let y = 12.0 - ((at / columns) as f64 + 0.5) * step_y;
                let statement = objects[number - 1];
                // A ray goes through the middle of a pixel: no margin.
                let is_inside = |extent: Extent| {
                    let Extent::Box { min, max } = extent else {
                        panic!("{} has no box", KINDS[number - 1])
                    };
                    let across = if along_x {
                        (min.z, max.z)
                    } else {
                        (min.x, max.x)
                    };
                    (across.0..=across.1).contains(&x) && (min.y..=max.y).contains(&y)
                };
                let mut its = frame.objects.iter().filter(|p| p.statement == statement);
                let inside = its.any(|placed| is_inside(placed.extent));
                assert!(inside, "{} at {x} {y}", KINDS[number - 1]);
            }
            for placed in &frame.objects {
                let Extent::Box { min, max } = placed.extent else {
                    panic!("it has an end")
                };
                assert!(
                    (max - min).max_element() < 8.0,
                    "no box is absurd: {min} {max}"
                );
            }
        }
    }
    for (kind, seen) in KINDS.iter().zip(seen) {
        assert!(seen > 3, "{kind} is not seen");
    }
}

#[test]
fn what_has_no_end_is_rendered_whole() {
    let endless = [
        ("object{P}", "no end"),
        ("union{sphere{0,1} object{P}}", "no end"),
        ("merge{sphere{0,1} object{P inverse}}", "no end"),
        ("quadric{<1,0,1>,0,0,-1}", "no end"),
        ("poly{2,<1,0,0,0,1,0,0,0,0,-1>}", "no end"),
        ("union{#if(clock>9) sphere{0,1} #end}", "no end"),
    ];
    for (object, reason) in endless {
        let object = object.strip_suffix('}').expect("a brace");
        let scene = format!("#version 3.7;\n#declare P=plane{{y,0}}\n{object} rotate clock*x}}\n");
        let film = Film::new(&[("a.pov", &scene)], &["+KFF1", "+KFI1"]);
        assert_eq!(film.analysis.whole, []);
        let whole = film.whole();
        assert!(whole.contains(reason), "{object}: {whole}");
    }
}

/// Objects, from statements in loops, macros, files and values.
const ROOM: &str = r#"#version 3.7;
#include "colors.inc"
#include "sub/parts.inc"
camera { perspective location <0, 2, -9> right x*4/3 // wide
  look_at <0, 1, 0> angle 50 }
light_source { <3, 4, -5> color White rotate y*30 translate x }
light_source { <1000, 2000, -500> White shadowless }
plane { <1, 2, 0>, -1 pigment { White } }
#macro decor0_D(A) sphere { A, .25 } #end
#macro Ball(A) sphere { A, .5 pigment { Red } } #end
#declare I = 0;
#while (I < 3) Ball(<I, clock, 0>) #declare I = I + 1; #end
Ball(<-3, 0, 0>)
union { Ball(<-2, 0, 0>) Ball(<-1, 0, clock>) }
#declare Pair = union { Ball(0) Ball(<1, clock, 0>) }
object { Pair translate 5*y }
decor0_D(<0, 0, 4 + clock>)
sphere { <0, 9, 0>, 1 }
"#;

const PARTS: &str =
    "#local Z = clock;\nbox { <0, 0, 2>, <1, 1, 2.5 + Z> }\n#declare Still = box { -.1, .1 }\n";

#[test]
fn statements_are_placed_in_every_frame() {
    let film = Film::new(&[("a.pov", ROOM), ("sub/parts.inc", PARTS)], &[]);
    assert_eq!(film.analysis.whole, []);
    let found = film.boxes();
    assert_eq!(found.whole, []);
    assert_eq!(
        film.files(),
        ["a.ini", "a.pov", "sub"],
        "nothing is written there"
    );
    let rest = std::fs::read_dir(film.work.path())
        .expect("a folder")
        .count();
    assert_eq!(rest, 0, "working files go");

    for (frame, clock) in found.frames.iter().zip([0.2, 0.9]) {
        let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() < 1e-4;
        let has = |min: DVec3, max: DVec3| {
            let same = |extent: Extent| match extent {
                Extent::Box { min: a, max: b } => near(a, min) && near(b, max),
                _ => false,
            };
            frame
                .objects
                .iter()
                .filter(|placed| same(placed.extent))
                .count()
        };
        let ball = |x: f64, y: f64, z: f64, r: f64| {
            let at = DVec3::new(x, y, z);
            has(at - r, at + r)
        };
        for x in 0..3 {
            assert_eq!(ball(f64::from(x), clock, 0.0, 0.5), 1);
        }
        assert_eq!(ball(-3.0, 0.0, 0.0, 0.5), 1);
        assert_eq!(ball(-2.0, 0.0, 0.0, 0.5), 0, "it is a part of a union");
        assert_eq!(
            has(
                DVec3::new(-2.5, -0.5, -0.5),
                DVec3::new(-0.5, 0.5, 0.5 + clock)
            ),
            1
        );
        assert_eq!(
            has(
                DVec3::new(-0.5, 4.5, -0.5),
                DVec3::new(1.5, 5.5 + clock, 0.5)
            ),
            1
        );
        assert_eq!(ball(0.0, 0.0, 4.0 + clock, 0.25), 1);
        assert_eq!(
            has(DVec3::new(0.0, 0.0, 2.0), DVec3::new(1.0, 1.0, 2.5 + clock)),
            1
        );
        assert_eq!(ball(0.0, 9.0, 0.0, 1.0), 1);
        let planes = frame
            .objects
            .iter()
            .filter_map(|placed| match placed.extent {
                Extent::Plane { point, normal } => Some((point, normal)),
                _ => None,
            });
        let planes: Vec<(DVec3, DVec3)> = planes.collect();
        let normal = DVec3::new(1.0, 2.0, 0.0).normalize();
        assert_eq!(planes.len(), 1);
        assert!((planes[0].1.dot(normal).abs() - 1.0).abs() < 1e-9);
        assert!((planes[0].0.dot(normal) + 1.0).abs() < 1e-6);
        assert_eq!(frame.objects.len(), 10);

        assert_eq!(
            frame.lights.len(),
            1,
            "a light without shadows touches nothing"
        );
        let light = glam::DQuat::from_rotation_y(30_f64.to_radians()) * DVec3::new(3.0, 4.0, -5.0);
        assert!(
            (frame.lights[0] - light - DVec3::X).length() < 1e-6,
            "{}",
            frame.lights[0]
        );
        let camera = frame.camera.as_ref().expect("it is plain");
        let words: Vec<&str> = camera.iter().map(|(word, _)| word.as_str()).collect();
        assert_eq!(words, ["location", "right", "look_at", "angle"]);
        assert_eq!(camera[0].1, DVec3::new(0.0, 2.0, -9.0));
        assert_eq!(camera[3].1, DVec3::splat(50.0));
    }
}

#[test]
fn what_moves_can_be_taken_away() {
    let film = Film::new(&[("a.pov", ROOM), ("sub/parts.inc", PARTS)], &[]);
    let to = film.work.path().join("copy");
    std::fs::create_dir(&to).expect("a folder");
    let mut edits = film.analysis.hidden();
    edits.push(
        film.sources
            .behind("sphere { <2, 0, -2>, .5 pigment { Blue } } // more"),
    );
    let copy = film.sources.rewritten(&edits, &to).expect("a copy");
    let ini = film.folder.path().join("a.ini");
    let hidden = film
        .povray
        .plain(&ini, &copy.switches, None)
        .expect("a scene");
    let hidden = film.pictures(&hidden);

    // The same, by hand: the macro places where it still does.
    let statements = film.analysis.moving().map(|(_, s)| s.line);
    let moving: Vec<usize> = statements.collect();
    assert_eq!(moving, [14, 16, 9, 10, 2]);
    let still = ROOM
        .replace("Ball(<I, clock, 0>)", "")
        .replace("\nBall(<-3, 0, 0>)", "")
        .replace("union { Ball(<-2, 0, 0>) Ball(<-1, 0, clock>) }", "")
        .replace("object { Pair translate 5*y }", "")
        .replace("\ndecor0_D(<0, 0, 4 + clock>)", "")
        + "sphere { <2, 0, -2>, .5 pigment { Blue } }";
    let still = Film::new(&[("a.pov", &still), ("sub/parts.inc", "")], &[]);
    let still = still.pictures(&still.scene);
    assert!(hidden == still, "nothing else goes, and nothing stays");
    assert!(hidden != film.pictures(&film.scene));
}

#[test]
fn old_scenes_and_headers_are_read() {
    let old = "#version 1.0\n#declare P = clock\ncamera { location <0, 0, -9> look_at <0, 0, 0> }\n\
               object { sphere { <0, 0, 0> 1 } translate <P, 0, 0> }\n\
               object { light_source { <9, 9, -9> color red 1 green 1 blue 1 } }\n";
    let film = Film::new(&[("a.pov", old)], &["+KFF1", "+KFI1"]);
    assert_eq!(film.whole(), "");
    let header = "#version 3.7;\n#declare V = clock;\nbox { V, V + 1 }\n";
    let scene = "sphere { V, 1 }";
    let film = Film::new(
        &[("a.pov", scene), ("h.inc", header)],
        &["Include_Header=h.inc"],
    );
    let found = film.boxes();
    assert_eq!(found.whole, []);
    assert_eq!(found.frames[1].objects.len(), 2);
    assert_eq!(film.analysis.moving().count(), 2);
}

#[test]
fn hostile_scenes_are_rendered_whole() {
    // A scene that is read for ever.
    let film = Film::new(&[("a.pov", "sphere{clock,1}\n#while(1) #end\n")], &[]);
    assert_eq!(film.analysis.whole, []);
    let mut run = film.run();
    run.timeout = Duration::from_secs(3);
    let found = boxes(
        &film.povray,
        &film.scene,
        &film.sources,
        &film.analysis,
        (1, 2),
        &run,
    );
    let whole = &found.expect("an answer").whole;
    assert!(
        whole[0].reason.contains("did not read it within 3 s"),
        "{whole:?}"
    );

    // One that stops, or that is no scene.
    for scene in ["sphere{clock,1} #error \"stop\"", "sphere{clock,Unknown}"] {
        let whole = Film::new(&[("a.pov", scene)], &[]).whole();
        assert!(whole.contains("does not take decor's copy"), "{whole}");
    }

    // One that writes: decor does not even run it.
    let scene = "#fopen F \"out.txt\" write\n#write(F, clock)\nsphere{clock,1}\n";
    let film = Film::new(&[("a.pov", scene)], &[]);
    let whole = film.whole();
    assert!(
        whole.contains("a.pov:1: it reads or writes a file"),
        "{whole}"
    );
    assert_eq!(film.files(), ["a.ini", "a.pov"]);

    // One that is included from outside is read there, and not changed.
    let outside = tempfile::tempdir().expect("a folder");
    let file = outside.path().join("out.inc");
    std::fs::write(&file, "sphere { clock, 1 }").expect("a file");
    let scene = format!("#include \"{}\"\n", file.display());
    let film = Film::new(&[("a.pov", &scene)], &[]);
    let found = film.boxes();
    assert_eq!((found.whole.len(), found.frames[0].objects.len()), (0, 1));
    assert_eq!(
        std::fs::read_to_string(&file).expect("a file"),
        "sphere { clock, 1 }"
    );
    assert!(matches!(film.analysis.statements[0].kind, Kind::Object(_)));

    // Names that look like decor's own.
    let scene = "#macro decor0_D(N,O) #end #macro decor1_n() 7 #end #declare decor2_F=1; #declare V_=2;\n\
                 sphere{clock,decor2_F} sphere{decor1_n(),V_}\n";
    let film = Film::new(&[("a.pov", scene)], &[]);
    let found = film.boxes();
    assert_eq!((found.whole.len(), found.frames[0].objects.len()), (0, 2));
}
