//! `decor stream`, through pipes that stay open: a scene is written, and only
//! when its frame is there the next.

#[path = "../common/mod.rs"]
mod common;
mod pipes;
mod worlds;

use std::path::Path;
use std::process::Command;

use common::{Run, differing_pixels};
use pipes::Pipes;
use serde_json::{Value, json};
use worlds::{Random, Seen, World, check_frame, objects_folder, turning_worlds};

#[test]
fn two_hundred_scenes_with_sudden_turns() {
    let mut seen = Seen::default();
    let thesis = ["--measure", "thesis", "--threshold", "2"];
    for (seed, options) in [
        (1, &["--period", "9"][..]),
        (2, &["--period", "auto"]),
        (3, &["--period", "15", "--threshold", "0.5"]),
        (4, &thesis),
    ] {
        let objects = objects_folder();
        let out = objects.path().join("frames");
        let common = ["--renderer", "reference", "--no-fallback"];
        let mut pipes = Pipes::open(objects.path(), &out, &[&common[..], options].concat());
        let (worlds, surprises) = turning_worlds(seed);
        for (number, world) in worlds.iter().enumerate() {
            pipes.send(&world.scene(number as u32));
        }
        let summary = pipes.ends_well();
        assert_eq!(summary["frames"], 200);
        for line in &pipes.frames {
            let number = line["frame"].as_u64().unwrap() as usize;
            let start = line["period"].as_u64().unwrap();
            let begin = &pipes.begins[&start];
            // The thesis's own measure promises no bound.
            if options != thesis {
                check_frame(number, start as usize, begin, &worlds, &mut seen);
            }
        }
        // The periods follow each other, and none fails without a reason.
        let mut next = 0;
        let mut failed = 0;
        for period in &pipes.periods {
            assert_eq!(period["start"], next);
            next += period["length"].as_u64().unwrap();
            if period["end"] == "prediction_failed" {
                failed += 1;
                let start = period["start"].as_u64().unwrap();
                assert!(
                    surprises.range(start + 1..=next).next().is_some(),
                    "{period}"
                );
                assert!(!period["failed"].as_str().unwrap().is_empty());
            }
        }
        assert_eq!(next, 200);
        assert_eq!(pipes.begins.len(), pipes.periods.len());
        assert!(failed >= 8, "{failed} of {} surprises", surprises.len());
        let strays = strays(&pipes, objects.path(), &worlds);
        println!(
            "{} periods, {failed} failed, {strays:?}",
            pipes.periods.len()
        );
    }
    assert!(seen.slow > 1000 && seen.immobile > 100, "{seen:?}");
    assert!(seen.clipped > 100 && seen.fast > 1000, "{seen:?}");
    assert!(seen.dissolved > 500 && seen.largest_px > 0.5, "{seen:?}");
}

/// Against the frames rendered whole: pixels whose colour none of their
/// neighbours two pixels around has there, in each frame.
fn strays(pipes: &Pipes, folder: &Path, worlds: &[World]) -> Vec<usize> {
    const CLOSE: u16 = 24;
    let film = folder.join("film.jsonl");
    let lines = worlds
        .iter()
        .zip(0..)
        .map(|(world, number)| world.scene(number).to_string());
    std::fs::write(&film, lines.collect::<Vec<_>>().join("\n")).unwrap();
    let whole = folder.join("whole");
    Run::new([
        "render",
        "--renderer",
        "reference",
        "--mode",
        "full",
        "-q",
        "-o",
    ])
    .arg(&whole)
    .arg(&film)
    .succeeds();
    let strays = |number: u64| {
        let (width, height, ours) = common::pixels(&pipes.file(number));
        let (_, _, theirs) = common::pixels(&whole.join(format!("frame_{number:04}.png")));
        let (width, height) = (width as usize, height as usize);
        let near = |at: usize, side: usize| at.saturating_sub(2)..(at + 3).min(side);
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let is_stray = |&(x, y): &(usize, usize)| {
            let pixel = ours[y * width + x];
            let close = |other: [u16; 3]| (0..3).all(|c| pixel[c].abs_diff(other[c]) <= CLOSE);
            !near(y, height).any(|y| near(x, width).any(|x| close(theirs[y * width + x])))
        };
        places.filter(is_stray).count()
    };
    (0..worlds.len() as u64).map(strays).collect()
}

/// The scenes of a bundled film, a frame each: all of them stated, none carried
/// on by velocities.
fn scenes_of(film: &Path, folder: &Path) -> Vec<Value> {
    let lines = folder.join("film.jsonl");
    Run::new(["convert"]).arg(film).arg(&lines).succeeds();
    let text = std::fs::read_to_string(&lines).unwrap();
    let mut first: Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    first.as_object_mut().unwrap().remove("frames");
    let film = decor::film::read(film, false).unwrap();
    let scene = |number: u32| {
        let state = film.frame(number);
        let objects: Vec<Value> = state
            .objects
            .iter()
            .map(|object| {
                json!({"path": object.path, "name": object.name,
                       "position": object.pose.position.to_array(),
                       "angles": object.pose.angles_deg.to_array(),
                       "velocity": object.motion.velocity.to_array(),
                       "angles_velocity": object.motion.angles_velocity_deg.to_array()})
            })
            .collect();
        let mut scene = if number == 0 {
            first.clone()
        } else {
            json!({"scene": number})
        };
        scene["objects"] = objects.into();
        scene
    };
    film.frames().map(scene).collect()
}

/// A film's scenes streamed are the film rendered, where nothing slow is kept.
#[test]
fn a_stream_of_a_film_is_the_film() {
    let folder = tempfile::tempdir().unwrap();
    let film = common::fixture("contact/contact.anim");
    let objects = film.parent().unwrap();
    let (streamed, rendered) = (folder.path().join("stream"), folder.path().join("film"));
    let scenes = scenes_of(&film, folder.path());
    let options = ["--threshold", "0", "--no-fallback", "--format", "png16"];
    let mut pipes = Pipes::open(
        objects,
        &streamed,
        &[&options[..], &["--renderer", "reference"]].concat(),
    );
    for scene in &scenes {
        pipes.send(scene);
    }
    let summary = pipes.ends_well();
    // Still objects stay in one décor, however long the stream is.
    assert_eq!(summary["periods"].as_array().unwrap().len(), 1, "{summary}");
    assert_eq!(summary["pixels_traced"]["decor"], 200 * 150);
    Run::new(["render", "--renderer", "reference", "-q", "-o"])
        .arg(&rendered)
        .arg(&film)
        .args(options)
        .succeeds();
    assert_eq!(scenes.len(), 12);
    for number in 0..12 {
        let file = |out: &Path| out.join(format!("frame_{number:04}.png"));
        let wrong = differing_pixels(&file(&streamed), &file(&rendered));
        assert_eq!(wrong.len(), 0, "frame {number}");
    }
}

/// The same with POV-Ray, whose stock frames the stream's are.
#[test]
fn ten_scenes_with_povray() {
    let folder = tempfile::tempdir().unwrap();
    let film = common::fixture("contact/contact.anim");
    let objects = film.parent().unwrap();
    let (streamed, plain) = (folder.path().join("stream"), folder.path().join("plain"));
    let scenes = scenes_of(&film, folder.path());
    let keep = folder.path().join("kept");
    let options = ["--threshold", "0", "--no-fallback", "--keep"];
    let options = [&options[..], &[keep.to_str().unwrap()]].concat();
    let mut pipes = Pipes::open(objects, &streamed, &options);
    for scene in &scenes[..10] {
        pipes.send(scene);
    }
    let summary = pipes.ends_well();
    assert_eq!(summary["frames"], 10);
    assert_eq!(summary["renderer"], "povray");
    assert_eq!(summary["periods"].as_array().unwrap().len(), 1);
    assert!(keep.join("period_0000").is_dir());
    Run::new(["render", "--baseline", "-q", "--frames", "0-9", "-o"])
        .arg(&plain)
        .arg(&film)
        .succeeds();
    for number in 0..10 {
        let file = |out: &Path| out.join(format!("frame_{number:04}.png"));
        let wrong = differing_pixels(&file(&streamed), &file(&plain));
        assert_eq!(wrong.len(), 0, "frame {number}");
    }
}

/// A moving observer with POV-Ray, a turn, and a target to dissolve towards.
#[test]
fn a_turn_with_povray() {
    let objects = objects_folder();
    let out = objects.path().join("frames");
    let options = ["--no-fallback", "--period", "5"];
    let mut pipes = Pipes::open(objects.path(), &out, &options);
    let mut random = Random(5);
    let mut world = World::new(&mut random);
    world.eye_velocity = [0.05, 0.0, 0.1];
    let mut worlds = vec![world];
    for number in 1..10 {
        let mut world = worlds.last().unwrap().after(1.0);
        if number == 3 {
            // More than the threshold in one step.
            world.eye[0] += 4.0;
            world.eye_velocity[0] = -0.05;
        }
        worlds.push(world);
    }
    for (number, world) in worlds.iter().enumerate() {
        pipes.send(&world.scene(number as u32));
    }
    pipes.ends_well();
    let ends: Vec<(u64, &str)> = pipes
        .periods
        .iter()
        .map(|p| (p["length"].as_u64().unwrap(), p["end"].as_str().unwrap()))
        .collect();
    assert_eq!(ends, [(3, "prediction_failed"), (5, "asked"), (2, "done")]);
    let mut seen = Seen::default();
    for line in &pipes.frames {
        let (number, start) = (&line["frame"], line["period"].as_u64().unwrap());
        let number = number.as_u64().unwrap() as usize;
        check_frame(
            number,
            start as usize,
            &pipes.begins[&start],
            &worlds,
            &mut seen,
        );
    }
    assert!(seen.dissolved > 20, "{seen:?}");
}

/// A cockpit turns with its pilot, before a sky: only the sky shows a turn.
#[test]
fn a_sky_is_verified_too() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "cockpit.inc",
        "// bounds: 0 0 5 4\n\
         difference { box { <-2, -1.5, 4.9>, <2, 1.5, 5.1> } box { <-1.5, -1, 4>, <1.5, 1, 6> }\n\
         pigment { rgb <0.3, 0.5, 0.2> } finish { ambient 0 diffuse 0 emission 1 } }\n",
    );
    write(
        "sky.inc",
        "sky_sphere { pigment { gradient x color_map { [0 rgb <0.1, 0.2, 0.9>] \
         [0.5 rgb <0.9, 0.4, 0.1>] [1 rgb <0.1, 0.2, 0.9>] } scale 0.2 } }\n",
    );
    let scene = |number: u32, degrees: f64, speed: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let turn = speed.to_radians();
        json!({"scene": number, "size": [96, 64], "angles": [60, 40], "sky": "sky.inc",
               "eye": {"position": [0, 0, 0]},
               "aim": {"position": [sin, 0, cos], "velocity": [turn * cos, 0, -turn * sin]},
               "objects": [{"path": "cockpit.inc", "position": [0, 0, 0],
                            "angles": [0, degrees, 0], "angles_velocity": [0, speed, 0]}]})
    };
    let out = folder.path().join("frames");
    let options = ["--no-fallback", "--period", "6"];
    let mut pipes = Pipes::open(folder.path(), &out, &options);
    let scenes = [
        scene(0, 0.0, 0.01),
        scene(1, 0.01, 0.01),
        scene(2, 3.0, 0.02),
        scene(3, 3.02, 0.02),
    ];
    for scene in &scenes {
        pipes.send(scene);
    }
    pipes.ends_well();
    assert_eq!(pipes.periods.len(), 2, "{:?}", pipes.periods);
    assert!(pipes.periods.iter().all(|p| p["length"] == 2));
    let failed = &pipes.periods[0]["failed"];
    assert_eq!(failed, "the sky moves farther in the picture");
    // Frames 0 and 2 are décors: POV-Ray's own pictures.
    let film = folder.path().join("film.jsonl");
    let lines: Vec<String> = scenes.iter().map(Value::to_string).collect();
    std::fs::write(&film, lines.join("\n")).unwrap();
    let plain = folder.path().join("plain");
    Run::new(["render", "--baseline", "-q", "-o"])
        .arg(&plain)
        .arg(&film)
        .succeeds();
    for number in [0, 2] {
        let plain = plain.join(format!("frame_{number:04}.png"));
        assert!(differing_pixels(&pipes.file(number), &plain).is_empty());
    }
}

/// A program that states no velocities is predicted by what it did.
#[test]
fn velocities_that_nobody_states() {
    let objects = objects_folder();
    let out = objects.path().join("frames");
    let options = ["--renderer", "reference", "--no-fallback", "--period", "10"];
    let mut pipes = Pipes::open(objects.path(), &out, &options);
    let mut random = Random(11);
    let mut world = World::new(&mut random);
    world.eye_velocity = [0.02, 0.01, 0.03];
    world.things[1].velocity = [0.5, 0.0, 0.0];
    let mut worlds = Vec::new();
    for number in 0..41 {
        let now = world.after(f64::from(number));
        let mut stated = now.clone();
        stated.eye_velocity = [0.0; 3];
        stated.things[1].velocity = [0.0; 3];
        pipes.send(&stated.scene(number));
        worlds.push(now);
    }
    pipes.ends_well();
    // The first scene says that everything stays.
    let lengths: Vec<u64> = pipes
        .periods
        .iter()
        .map(|p| p["length"].as_u64().unwrap())
        .collect();
    assert_eq!(lengths, [1, 10, 10, 10, 10]);
    let mut seen = Seen::default();
    for line in &pipes.frames {
        let (number, start) = (&line["frame"], line["period"].as_u64().unwrap());
        let number = number.as_u64().unwrap() as usize;
        check_frame(
            number,
            start as usize,
            &pipes.begins[&start],
            &worlds,
            &mut seen,
        );
    }
    assert!(seen.slow > 100 && seen.fast > 20, "{seen:?}");
}

#[test]
fn scenes_that_are_left_out_are_shown() {
    let objects = objects_folder();
    let out = objects.path().join("frames");
    let mut pipes = Pipes::open(objects.path(), &out, &["--renderer", "reference"]);
    let world = World::new(&mut Random(2));
    pipes.send(&world.scene(4));
    // Blank lines show nothing.
    pipes.write("");
    pipes.write(&world.scene(8).to_string());
    for number in 5..8 {
        loop {
            let line = pipes.next().expect("a frame");
            if line["type"] == "frame" {
                assert_eq!(line["frame"], number);
                break;
            }
        }
    }
    pipes.wait_for(8);
    // What the stream says of its length, it keeps at its end.
    pipes.write(r#"{"scene":9,"frames":8}"#);
    pipes.wait_for(9);
    let summary = pipes.ends_well();
    assert_eq!(summary["first_frame"], 4);
    assert_eq!(summary["frames"], 8);
    assert!(pipes.file(11).exists() && !pipes.file(12).exists());
}

#[test]
fn what_a_later_scene_names_is_read_then() {
    let objects = objects_folder();
    let out = objects.path().join("frames");
    let options = ["--renderer", "reference", "--no-fallback"];
    let mut pipes = Pipes::open(objects.path(), &out, &options);
    let mut world = World::new(&mut Random(2));
    pipes.send(&world.scene(0));
    pipes.send(&world.scene(1));
    // It was not even there.
    std::fs::copy(
        objects.path().join("brick.ron"),
        objects.path().join("late.ron"),
    )
    .unwrap();
    world.things[2].path = "late";
    pipes.send(&world.scene(2));
    pipes.ends_well();
    assert_eq!(pipes.periods[0]["end"], "prediction_failed");
    let failed = pipes.periods[0]["failed"].as_str().unwrap();
    assert_eq!(failed, "thing_2 has another description in frame 2");
    assert!(!differing_pixels(&pipes.file(1), &pipes.file(2)).is_empty());
}

#[test]
fn a_bad_line_ends_the_stream_and_no_more() {
    let objects = objects_folder();
    let world = World::new(&mut Random(2));
    for (line, says) in [
        (r#"{"scene":2,"eey":{}}"#, "eey"),
        (r#"{"scene":1}"#, "scene 1"),
        (
            r#"{"scene":2,"objects":[{"path":"nowhere","position":[0,0,0]}]}"#,
            "nowhere",
        ),
        ("scene 2", "JSON"),
    ] {
        let out = tempfile::tempdir().unwrap();
        let mut pipes = Pipes::open(objects.path(), out.path(), &["--renderer", "reference"]);
        pipes.send(&world.scene(0));
        pipes.send(&world.scene(1));
        pipes.write(line);
        let (status, stderr) = pipes.end();
        assert_eq!(status, 3, "{stderr}");
        assert!(stderr.contains(says), "{stderr}");
        assert!(stderr.contains("stdin"), "{stderr}");
        assert!(pipes.file(0).exists() && pipes.file(1).exists());
        assert_eq!(pipes.summary.as_ref().unwrap()["frames"], 2);
        assert!(out.path().join("decor.json").exists());
    }
    // A stream of nothing is none.
    let out = tempfile::tempdir().unwrap();
    let mut pipes = Pipes::open(objects.path(), out.path(), &["--renderer", "reference"]);
    let (status, stderr) = pipes.end();
    assert_eq!(status, 3, "{stderr}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_stream_that_waits() {
    let objects = objects_folder();
    let out = objects.path().join("frames");
    let mut pipes = Pipes::open(objects.path(), &out, &["--renderer", "reference"]);
    pipes.send(&World::new(&mut Random(2)).scene(0));
    let interrupt = Command::new("kill")
        .args(["-INT", &pipes.child.id().to_string()])
        .status();
    assert!(interrupt.unwrap().success());
    // Stdin stays open.
    while pipes.next().is_some() {}
    assert_eq!(pipes.child.wait().unwrap().code(), Some(130));
    assert_eq!(pipes.summary.as_ref().unwrap()["frames"], 1);
    assert!(out.join("decor.json").exists());
}

#[test]
fn a_budget_changes_the_threshold_a_step_at_a_time() {
    let objects = objects_folder();
    let world = {
        let mut world = World::new(&mut Random(2));
        world.eye_velocity = [0.02, 0.0, 0.05];
        world
    };
    // Nothing is so fast, and nothing so slow.
    for (budget, last) in [("1e-9", 3.0), ("1000", 0.4)] {
        let out = tempfile::tempdir().unwrap();
        let options = ["--renderer", "reference", "--no-fallback", "--period", "3"];
        let budget = [
            "--budget",
            budget,
            "--threshold-min",
            "0.4",
            "--threshold-max",
            "3",
        ];
        let mut pipes = Pipes::open(
            objects.path(),
            out.path(),
            &[&options[..], &budget].concat(),
        );
        for number in 0..24 {
            pipes.send(&world.after(f64::from(number)).scene(number));
        }
        pipes.ends_well();
        let thresholds: Vec<f64> = pipes
            .periods
            .iter()
            .map(|p| p["threshold_px"].as_f64().unwrap())
            .collect();
        assert_eq!(thresholds[0], 1.0);
        for pair in thresholds.windows(2) {
            let step = (pair[1] / pair[0]).ln().abs() / std::f64::consts::SQRT_2.ln();
            assert!(step < 1.0 + 1e-9, "{thresholds:?}");
        }
        assert_eq!(*thresholds.last().unwrap(), last, "{thresholds:?}");
    }
}
