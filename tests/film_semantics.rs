//! What a film means: what carries over, what moves, who is who.

use std::path::Path;

use decor::film::{self, Film, FilmErrors, FilmStream, Problem};
use decor_api::{Antialias, Fade, LightKind, Rgb, Size};
use glam::DVec3;

const HEAD: &str = "*eye 0 2 -10\n*aim 0 0 0\n*angles 60 45\n*size 320 240\n";

/// A folder with some descriptions; the film's text is relative to it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "a.inc",
        "b.inc",
        "my house #1.inc",
        "sky.inc",
        "more.inc",
        "c.ron",
    ] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    folder
}

fn try_film(text: impl AsRef<[u8]>) -> Result<Film, FilmErrors> {
    let folder = folder();
    film::anim::parse("test.anim", text.as_ref(), folder.path(), false)
}

fn read(text: impl AsRef<[u8]>) -> Film {
    try_film(text).unwrap_or_else(|errors| panic!("{:?}", miette::Report::new(errors)))
}

fn body(text: &str) -> Film {
    read(format!("@0\n{HEAD}{text}"))
}

/// The names of the objects of a frame.
fn names(film: &Film, frame: u32) -> Vec<String> {
    let state = film.frame(frame);
    state.objects.iter().map(|o| o.name.to_owned()).collect()
}

#[test]
fn the_smallest_film_is_one_black_frame() {
    let film = read(HEAD);
    assert_eq!(film.frames(), 0..=0);
    assert_eq!(
        film.size(),
        Size {
            width: 320,
            height: 240
        }
    );
    let frame = film.frame(0);
    assert_eq!(frame.camera.eye, DVec3::new(0.0, 2.0, -10.0));
    assert_eq!(frame.background, Rgb([0.0; 3]));
    assert!(!frame.shadows && frame.objects.is_empty() && frame.lights.is_empty());
    assert!(frame.antialias.is_none() && frame.sky.is_none());
    assert_eq!(film.includes().count(), 0);
}

#[test]
fn lights_have_their_types_in_both_languages() {
    let text = "*ombres 1\n*fond 0.1 0.2 0.3\n*images 7\n\
        *source 1 2 3 1 .5 0 ponctuelle fade 10 2\n\
        *source 1 2 3 1 1 1 soleil\n\
        *source 1 2 3 1 1 1 soleil 4 5 6\n\
        *source 1 2 3 1 1 1 spot 0 0 0 20 30 1.5\n\
        *source 1 2 3 1 1 1 zone 1 0 0 0 1 0 2 3\n";
    let french = body(text);
    let mut english = text.to_owned();
    for (a, b) in [
        ("*ombres", "*shadows"),
        ("*fond", "*background"),
        ("*images", "*frames"),
        ("*source", "*light"),
        ("ponctuelle", "point"),
        ("soleil", "sun"),
        ("zone", "area"),
    ] {
        english = english.replace(a, b);
    }
    let english = body(&english);
    assert_eq!(french.frame(0), english.frame(0));
    assert_eq!(french.frames(), 0..=6);
    let frame = french.frame(6);
    assert!(frame.shadows);
    assert_eq!(frame.background, Rgb([0.1, 0.2, 0.3]));
    let [point, sun, sun_to, spot, area] = frame.lights else {
        panic!("{:?}", frame.lights);
    };
    assert_eq!(point.colour, Rgb([1.0, 0.5, 0.0]));
    assert_eq!(point.position, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(
        point.fade,
        Some(Fade {
            distance: 10.0,
            power: 2.0
        })
    );
    let towards = DVec3::ZERO;
    assert_eq!(sun.kind, LightKind::Sun { towards });
    let towards = DVec3::new(4.0, 5.0, 6.0);
    assert_eq!(sun_to.kind, LightKind::Sun { towards });
    assert_eq!(
        spot.kind,
        LightKind::Spot {
            towards: DVec3::ZERO,
            radius_deg: 20.0,
            falloff_deg: 30.0,
            tightness: 1.5
        }
    );
    assert_eq!(
        area.kind,
        LightKind::Area {
            u: DVec3::X,
            v: DVec3::Y,
            nu: 2,
            nv: 3
        }
    );
}

#[test]
fn the_environment_carries_over() {
    let film = body(
        "*shadows 1\n*light 0 9 0 1 1 1 point\n*light 0 8 0 1 1 1 point\n*sky sky.inc\n\
         *antialias 0.1 3\n*background 1 0 0\n\
         @2\n*light 0 7 0 1 1 1 point\n*angles 90 90\n\
         @4\n*shadows 0\n*antialias off\n*up 1 0 0\n*background 0 0 0\n",
    );
    let [one, two, four] = [1, 2, 4].map(|n| film.frame(n));
    assert_eq!(
        (one.lights.len(), two.lights.len(), four.lights.len()),
        (2, 1, 1)
    );
    assert!(one.shadows && two.shadows && !four.shadows);
    let antialias = Some(Antialias {
        threshold: 0.1,
        depth: 3,
    });
    assert_eq!(
        [one.antialias, two.antialias, four.antialias],
        [antialias, antialias, None]
    );
    assert_eq!(four.sky.unwrap().path(), Path::new("sky.inc"));
    assert_eq!(two.background, Rgb([1.0, 0.0, 0.0]));
    assert_eq!(four.background, Rgb([0.0; 3]));
    assert!((one.camera.half_width - 30_f64.to_radians().tan()).abs() < 1e-15);
    assert!((four.camera.half_width - 1.0).abs() < 1e-15);
    assert_eq!(two.camera.right, DVec3::X);
    assert!(four.camera.up.x > 0.999);
}

#[test]
fn what_is_kept_is_advanced_from_where_it_was_stated() {
    let film = read(
        "@5\n*eye 0 0 -10 0.1 0 0\n*aim 0 0 0 0 0.3 0\n*angles 60 45\n*size 8 8\n*images 10\n\
         !a 1 2 3 10 20 30 0.1 0.2 0.3 1 2 3\n\
         @7\n*aim 0 0 1\n\
         @9\n!a 100 0 0 0 0 0 1 0 0 0 0 0\n",
    );
    assert_eq!(film.frames(), 5..=14);
    assert_eq!(film.scene_numbers().collect::<Vec<_>>(), [5, 7, 9]);
    // Never summed up: 3·0.1 is not 0.1 + 0.1 + 0.1.
    let eight = film.frame(8);
    assert_eq!(eight.camera.eye.x, 3.0 * 0.1);
    assert_eq!(eight.aim, DVec3::new(0.0, 0.0, 1.0));
    assert_eq!(film.frame(6).aim, DVec3::new(0.0, 0.3, 0.0));
    let pose = eight.objects[0].pose;
    assert_eq!(
        pose.position,
        DVec3::new(1.0 + 3.0 * 0.1, 2.0 + 3.0 * 0.2, 3.0 + 3.0 * 0.3)
    );
    assert_eq!(pose.angles_deg, DVec3::new(13.0, 26.0, 39.0));
    // A stated position wins over a velocity.
    assert_eq!(film.frame(9).objects[0].pose.position.x, 100.0);
    assert_eq!(film.frame(14).objects[0].pose.position.x, 105.0);
    assert_eq!(film.frame(14).camera.eye.x, 9.0 * 0.1);
    assert_eq!(film.frame(9).objects[0].motion.velocity, DVec3::X);
    // What was not known in frame 8: velocities went on.
    let predicted = film.predicted(8, 9).unwrap();
    assert_eq!(predicted.objects[0].pose.position.x, 1.0 + 4.0 * 0.1);
    assert!(film.predicted(8, 7).is_none() && film.predicted(4, 7).is_none());
}

#[test]
fn a_velocity_that_is_left_out_is_none_and_does_not_carry_over() {
    let film = body("!a 0 0 0 0 0 0 1 1 1 1 1 1\n@3\n!a 5 0 0 0 0 0\n@6\n*aim 1 0 0\n");
    assert_eq!(
        film.frame(6).objects[0].pose.position,
        DVec3::new(5.0, 0.0, 0.0)
    );
}

#[test]
fn what_stands_still_keeps_every_bit() {
    let film = body("*images 1000000\n!a -0 0.1 1e-300 1e8 -0.0 7 0 -0 0 0 0 0\n");
    let bits = |n| {
        let pose = film.frame(n).objects[0].pose;
        let all = [pose.position.to_array(), pose.angles_deg.to_array()];
        all.map(|v| v.map(f64::to_bits))
    };
    for n in [1, 2, 999_999] {
        assert_eq!(bits(0), bits(n));
    }
}

#[test]
fn a_long_film_takes_no_room() {
    let film = body("*images 4294967295\n!a 0 0 0 0 0 0 1 0 0 0 0 0\n");
    assert_eq!(film.frames(), 0..=4_294_967_294);
    let last = film.frame(4_294_967_294);
    assert_eq!(last.objects[0].pose.position.x, 4_294_967_294.0);
}

#[test]
fn objects_are_listed_all_or_not_at_all() {
    let film = body("!a 0 0 0 0 0 0\n!b 0 0 0 0 0 0\n@1\n*shadows 1\n@2\n!b 0 0 0 0 0 0\n");
    assert_eq!(names(&film, 0), ["a#0", "b#0"]);
    assert_eq!(names(&film, 1), ["a#0", "b#0"]);
    assert_eq!(names(&film, 2), ["b#0"]);
}

#[test]
fn identity_is_the_name_or_the_place_among_the_unnamed() {
    let film = body(
        "!a 0 0 0 0 0 0\n!a 1 0 0 0 0 0 name=ball\n!a 2 0 0 0 0 0\n!a.inc 3 0 0 0 0 0\n\
         @1\n!b 0 0 0 0 0 0 name=ball\n!a 2 0 0 0 0 0\n\
         @2\n!a 0 0 0 0 0 0\n!a 1 0 0 0 0 0\n!a 2 0 0 0 0 0\n",
    );
    assert_eq!(names(&film, 0), ["a#0", "ball", "a#1", "a.inc#0"]);
    assert_eq!(names(&film, 1), ["ball", "a#0"]);
    assert_eq!(names(&film, 2), ["a#0", "a#1", "a#2"]);
    let all: Vec<_> = film.identities().iter().map(|i| i.name()).collect();
    assert_eq!(all, ["a#0", "ball", "a#1", "a.inc#0", "a#2"]);
    let (zero, one) = (film.frame(0), film.frame(1));
    assert_eq!(zero.objects[1].id, one.objects[0].id);
    assert_eq!(film.identity(one.objects[0].id).name(), "ball");
    assert!(film.identity(one.objects[0].id).is_named());
    // The same object, with another description.
    assert_eq!(zero.objects[1].path, Path::new("a"));
    assert_eq!(one.objects[0].path, Path::new("b"));
    let file = film.descriptions()[one.objects[0].description.0 as usize].file();
    assert!(file.is_absolute() && file.ends_with("b.inc"));
}

#[test]
fn includes_hold_for_the_whole_film() {
    let film = body("*include more.inc\n@3\n*include a.inc\n*include more.inc\n");
    let paths: Vec<_> = film.includes().map(|file| file.path()).collect();
    assert_eq!(paths, [Path::new("more.inc"), Path::new("a.inc")]);
}

#[test]
fn lines_before_the_first_scene_are_its_own() {
    let film = read(
        "# a film\n*size 8 8\n*angles 60 45\n@5\n*eye 0 0 -9\n*aim 0 0 0\n!a 0 0 0 0 0 0\n@6\n",
    );
    assert_eq!(film.frames(), 5..=6);
    assert_eq!(film.scene_numbers().collect::<Vec<_>>(), [5, 6]);
}

#[test]
fn text_is_read_as_it_comes() {
    let plain = body("!\"my house #1.inc\" 0 0 0 0 0 0 name=\"the house\"\n");
    let text = format!(
        "\u{feff}# début\n\n{HEAD}  !\t\"my house #1.inc\"  0 0 0\t0 0 0 name=\"the house\" # là\n"
    );
    let dos = read(text.replace('\n', "\r\n"));
    assert_eq!(names(&dos, 0), ["the house"]);
    assert_eq!(names(&plain, 0), names(&dos, 0));
    assert_eq!(plain.frame(0), dos.frame(0));
    // No line end at the end.
    assert_eq!(read(HEAD.trim_end()).frames(), 0..=0);
}

#[test]
fn whole_film_values_may_be_repeated() {
    let film = body("*images 3\n*taille 320 240\n@1\n*taille 320 240\n*frames 3\n");
    assert_eq!(film.frames(), 0..=2);
    // The size may come late.
    let film = read("@0\n*eye 0 2 -10\n*aim 0 0 0\n*angles 60 45\n@1\n*size 4 4\n");
    assert_eq!(film.size().width, 4);
}

#[test]
fn a_path_may_leave_where_that_is_allowed() {
    let folder = folder();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let text = format!("{HEAD}!../a 0 0 0 0 0 0\n");
    let read = |outside| film::anim::parse("t.anim", text.as_bytes(), &inner, outside);
    let errors = read(false).unwrap_err();
    assert!(matches!(
        errors.errors()[0].problem(),
        Problem::LeavesFolder { .. }
    ));
    assert!(read(true).is_ok());
}

#[test]
fn a_film_is_read_from_its_folder() {
    let folder = folder();
    let text = format!("{HEAD}*frames 3\n!a 0 0 0 0 0 0\n");
    std::fs::write(folder.path().join("film.anim"), text).unwrap();
    let film = film::read(&folder.path().join("film.anim"), false).unwrap();
    assert_eq!(film.folder(), folder.path());
    let json = film::Form::JsonLines.write(&film);
    std::fs::write(folder.path().join("film.jsonl"), json).unwrap();
    let again = film::read(&folder.path().join("film.jsonl"), false).unwrap();
    assert_eq!(film, again);
}

#[test]
fn the_documented_scene_is_a_scene() {
    let documentation = include_str!("../src/film/jsonl.rs");
    let start = documentation.find("```json").unwrap();
    let lines = documentation[start..].lines().skip(1);
    let json: String = lines
        .take_while(|line| !line.contains("```"))
        .map(|line| line.trim_start_matches("//!"))
        .collect();
    let folder = folder();
    for name in ["colours.inc", "clouds.inc", "ball.inc", "floor.ron"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    let film = film::jsonl::parse("doc.jsonl", json.as_bytes(), folder.path(), false);
    let film = film.unwrap_or_else(|errors| panic!("{:?}", miette::Report::new(errors)));
    assert_eq!(film.frames(), 0..=24);
    let frame = film.frame(10);
    assert_eq!((frame.lights.len(), frame.objects.len()), (4, 2));
    assert_eq!(frame.objects[0].pose.position.x, 10.0 * 0.1);
}

#[test]
fn a_stream_gives_each_frame_as_a_file_would() {
    let folder = folder();
    let text = br#"{"scene":3,"size":[8,8],"frames":9,"eye":{"position":[0,0,-9],"velocity":[0,0,0.1]},"aim":{"position":[0,0,0]},"angles":[60,45],"objects":[{"path":"a","position":[0,0,0],"velocity":[0.1,0,0]}]}

{"scene":4,"objects":[{"path":"a","position":[5,0,0]},{"path":"b","name":"new","position":[1,0,0],"velocity":[0,0.1,0]}]}
{"scene":8,"shadows":true}
"#;
    let film = film::jsonl::parse("f.jsonl", text, folder.path(), false).unwrap();
    let mut stream = FilmStream::new("stdin", folder.path(), false);
    let mut shown = Vec::new();
    let mut lines = text.split_inclusive(|b| *b == b'\n');
    loop {
        let line = lines.next();
        let frames = match line {
            Some(line) => stream.push_line(line).unwrap(),
            None => stream.finish().unwrap(),
        };
        for n in frames.into_iter().flatten() {
            assert_eq!(stream.frame(n).unwrap(), film.frame(n), "frame {n}");
            shown.push(n);
        }
        if line.is_none() {
            break;
        }
    }
    assert_eq!(shown, film.frames().collect::<Vec<_>>());
    assert_eq!(stream.size(), Some(film.size()));
    assert_eq!(stream.identities(), film.identities());
    assert_eq!(stream.descriptions(), film.descriptions());
    assert_eq!(stream.includes().count(), 0);
    assert!(stream.frame(3).is_none());
}
