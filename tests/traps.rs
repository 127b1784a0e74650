//! Films that a review broke: what fragments, declarations and a sky share
//! without saying so. All are the renderer's own frames now.

mod common;

use common::{Run, differing_pixels};

struct Trap {
    name: &'static str,
    include: &'static str,
    sky: &'static str,
    moving: &'static str,
    still: &'static str,
}

const MOVING: &str = "sphere { 0, 0.8 pigment { rgb <1,1,0> } }";
const STILL: &str =
    "box { <-3,-1,-1>, <3,1,1> pigment { checker rgb <1,.2,.2> rgb <.2,1,.2> scale .5 } }";

const TRAPS: [Trap; 8] = [
    Trap {
        name: "a name of the library declared anew",
        include: "",
        sky: "",
        moving: "#include \"colors.inc\"\n#declare Red = rgb <0,1,0>; sphere { 0, .8 pigment { Red } }",
        still: "#include \"colors.inc\"\nbox { <-3,-1,-1>, <3,1,1> pigment { Red } }",
    },
    Trap {
        name: "random numbers of a common stream",
        include: "#declare R = seed(42);",
        sky: "",
        moving: "sphere { 0, .8 pigment { rgb <rand(R), 1, 0> } }",
        still: "box { <-3,-1,-1>, <3,1,1> pigment { rgb <rand(R), rand(R), 0> } }",
    },
    Trap {
        name: "a macro that counts",
        include: "#declare N = 0; #macro Next() #declare N = N + 1; N #end",
        sky: "",
        moving: "sphere { 0, .8 pigment { rgb <Next()/4, 1, 0> } }",
        still: "box { <-3,-1,-1>, <3,1,1> pigment { rgb Next()/4 } }",
    },
    Trap {
        name: "everything mirrors by default",
        include: "#default { finish { reflection 0.7 } }",
        sky: "",
        moving: MOVING,
        still: STILL,
    },
    Trap {
        name: "a sky with names",
        include: "",
        sky: "#declare Shade = finish { reflection 0.8 }\nsky_sphere { pigment { rgb <.3,.4,.8> } }",
        moving: MOVING,
        still: "#ifdef (Shade) #declare F = Shade; #else #declare F = finish { phong 1 } #end\nbox { <-3,-1,-1>, <3,1,1> pigment { rgb 1 } finish { F } }",
    },
    Trap {
        name: "a sky that calls for fog",
        include: "#macro Mist() fog { distance 12 rgb <.6,.6,.7> } #end",
        sky: "Mist()",
        moving: MOVING,
        still: STILL,
    },
    Trap {
        name: "a colour of one number",
        include: "",
        sky: "",
        moving: "sphere { 0, .8 pigment { color 0.5 } }",
        still: STILL,
    },
    Trap {
        name: "text that is read as scene",
        include: "",
        sky: "",
        moving: MOVING,
        still: "#include \"strings.inc\"\nbox { <-3,-1,-1>, <3,1,1> pigment { rgb 1 } Parse_String(\"finish { reflection 0.8 }\") }",
    },
];

#[test]
fn what_is_shared_in_silence() {
    for trap in TRAPS {
        let folder = tempfile::tempdir().unwrap();
        let mut film = String::from(
            "@0\n*eye 0 2 -8\n*aim 0 0 0\n*angles 60 46\n*size 96 64\n*frames 2\n\
             *background 0.2 0.3 0.5\n*light -30 60 -40 1 1 1 point\n",
        );
        for (name, word, text) in [
            ("names.inc", "include", trap.include),
            ("air.inc", "sky", trap.sky),
        ] {
            if !text.is_empty() {
                std::fs::write(folder.path().join(name), text).unwrap();
                film.push_str(&format!("*{word} {name}\n"));
            }
        }
        film.push_str("!moving -1 0.5 -2 0 0 0 0.5 0.1 0 0 5 0\n!still 0 0 2 0 20 0\n");
        std::fs::write(folder.path().join("moving.inc"), trap.moving).unwrap();
        std::fs::write(folder.path().join("still.inc"), trap.still).unwrap();
        std::fs::write(folder.path().join("film.anim"), film).unwrap();
        let render = |out: &str, extra: &[&str]| {
            let ended = Run::new(["render", "-q", "--format", "png16"])
                .arg(folder.path().join("film.anim"))
                .arg("-o")
                .arg(folder.path().join(out))
                .args(extra)
                .ends();
            assert_eq!(ended.status, 0, "{}: {}", trap.name, ended.stderr);
        };
        render("plain", &["--baseline"]);
        render("merged", &["--threshold", "0", "--no-fallback"]);
        let name = "frame_0001.png";
        let wrong = differing_pixels(
            &folder.path().join("merged").join(name),
            &folder.path().join("plain").join(name),
        );
        assert_eq!(wrong.len(), 0, "{}", trap.name);
    }
}

#[test]
fn frames_of_another_job_are_not_resumed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ball.ron"), "sphere(radius: 1)").unwrap();
    let (film, out) = (folder.path().join("film.anim"), folder.path().join("out"));
    let write = |background: &str| {
        let text = format!(
            "@0\n*eye 0 1 -6\n*aim 0 0 0\n*angles 50 40\n*size 32 24\n*frames 3\n*fond {background}\n!ball 0 0 0 0 0 0\n"
        );
        std::fs::write(&film, text).unwrap();
    };
    let render = |extra: &[&str]| {
        Run::new(["render", "--renderer", "reference", "--json", "-o"])
            .arg(&out)
            .arg(&film)
            .args(extra)
            .succeeds()
            .summary()
    };
    write("0 0 1");
    render(&[]);
    let first_job = render(&["--resume"]);
    assert_eq!(first_job["frames_kept"], 3);
    // Another film is begun, and interrupted before its first frame.
    write("1 0 0");
    let job = render(&[])["job"].as_str().unwrap().to_owned();
    write("0 0 1");
    render(&[]);
    std::fs::write(out.join(".decor-job"), format!("{job}\n")).unwrap();
    write("1 0 0");
    assert_eq!(render(&["--resume"])["frames_kept"], 0);
    // A plain run's frames are not the merged run's.
    let baseline = render(&["--baseline"]);
    assert_ne!(baseline["job"].as_str().unwrap(), job);
    assert_eq!(render(&["--resume"])["frames_kept"], 0);
}
