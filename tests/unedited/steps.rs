//! Frames that show the same are rendered once; and films that are long enough find
//! out by themselves what pays.

use crate::common::Run;
use crate::trial::{ALWAYS, Tried, both};

const SCENE: &str = "\
#version 3.7; global_settings { assumed_gamma 1 }
light_source { <-9, 20, -30>, rgb 1 }
plane { y, -1 pigment { checker rgb .3, rgb .9 } }
";

fn tried(text: &str, switches: &[&str], options: &[&str]) -> Tried {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.pov"), format!("{SCENE}{text}\n")).unwrap();
    let out = folder.path().join("out");
    let switches = [&["+W96", "+H64"], switches].concat();
    let tried = both(folder.path(), "s.pov", &switches, options, &out);
    tried.assert_identical(text);
    tried
}

fn numbers(tried: &Tried) -> [u64; 2] {
    ["frames_repeated", "renderer_frames"].map(|name| tried.summary[name].as_u64().unwrap())
}

#[test]
fn steps_and_pauses_are_rendered_once() {
    let still = "camera { location <0, 1, -8> look_at 0 }";
    let step = format!("{still} sphere {{ x * floor(clock*4), 1 pigment {{ rgb x }} }}");
    std::thread::scope(|scope| {
        scope.spawn(|| {
            // Five places in twelve frames.
            let whole = tried(&step, &["+KFF12", "+A0.2", "+UA", "+FN16"], &[]);
            assert_eq!(numbers(&whole), [7, 5], "{}", whole.summary);
        });
        scope.spawn(|| {
            let coherent = tried(&step, &["+KFF12"], ALWAYS);
            assert_eq!(coherent.whole(), "");
            assert_eq!(numbers(&coherent)[0], 7, "{}", coherent.summary);
        });
        scope.spawn(|| {
            // By name.
            let named = "#declare N = 4; #declare T = clock * N;
                camera { location <0, 1, -8> look_at 0 }
                sphere { <floor(T) - 2, 0, 0>, 1 pigment { rgb x } }";
            let named = tried(named, &["+KFF12"], ALWAYS);
            assert_eq!(numbers(&named)[0], 7, "{}", named.summary);
        });
        scope.spawn(|| {
            // All frames are whole ones, but a pause is one picture.
            let camera = "camera { location <min(clock, 0.5), 1, -8> look_at 0 }";
            let paused = tried(camera, &["+KFF9", "+SF3", "+EF8"], ALWAYS);
            assert!(paused.whole().contains("the camera moves"));
            assert_eq!(numbers(&paused), [3, 3], "{}", paused.summary);
        });
        scope.spawn(|| {
            // Something else moves on, or is random.
            let more = format!("{step} sphere {{ y * clock, .3 }}");
            assert_eq!(numbers(&tried(&more, &["+KFF6"], &[]))[0], 0);
            let more = format!("{step} #declare A = seed(now);");
            assert_eq!(numbers(&tried(&more, &["+KFF6"], &[]))[0], 0);
        });
    });
}

#[test]
fn explain_says_how_many_frames_repeat() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.pov");
    std::fs::write(&file, format!("{SCENE} sphere {{ x * (clock > 0.5), 1 }}")).unwrap();
    let said = |json: &[&str]| {
        let run = Run::new(["explain"]).args(json).arg(&file);
        let ended = run.args(["--", "+KFF10"]).ends();
        assert_eq!(ended.status, 0, "{}", ended.stderr);
        ended.stdout
    };
    let said_json = said(&["--json"]);
    assert!(said_json.contains("\"frames_repeated\":8"), "{said_json}");
    let said = said(&[]);
    assert!(said.contains("8 of 10 frames show the same"), "{said}");
}

#[test]
fn a_long_film_finds_out_beside_whole_frames() {
    let text = "\
camera { location <0, 4, -9> look_at 0 }
light_source { <20, 20, -10>, rgb 1 area_light x*9, z*9, 9, 9 }
#for (I, -3, 3) sphere { <I, 0, I*I/3>, .7 pigment { rgb .5 } finish { reflection .3 } } #end
sphere { <6*clock - 3, .5, -3>, .2 pigment { rgb x } no_reflection no_shadow }";
    let tried = tried(text, &["+W224", "+H168", "+KFF48"], &[]);
    // A fast machine has better to do than to ask.
    let whole = tried.whole();
    assert!(
        ["", "whole frames take no longer"].contains(&whole.as_str()),
        "{whole}"
    );
    println!("{}", tried.summary);
}
