//! Plain POV-Ray animations, as they are: what `decor render scene.ini` gives,
//! against what POV-Ray alone gives of the same files and switches.
//!
//! The measure is one call of POV-Ray with one thread: with several it does not
//! agree with itself where shadows fall through glass.

mod common;
#[path = "common/stock.rs"]
mod stock;

use std::path::Path;

use common::{Ended, Run, fixture};
use stock::{assert_same, content, pictures, povray};

/// A copy of the small scenes, to write in.
fn scenes() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    copy(&fixture("unedited"), folder.path());
    folder
}

fn copy(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let place = to.join(entry.file_name());
        if entry.path().is_dir() {
            std::fs::create_dir(&place).unwrap();
            copy(&entry.path(), &place);
        } else {
            std::fs::copy(entry.path(), place).unwrap();
        }
    }
}

fn render(file: &Path, out: &Path, more: &[&str]) -> Ended {
    let run = Run::new(["render", "--json"]).arg(file).arg("-o").arg(out);
    run.args(more).ends()
}

/// One of POV-Ray's own animations, every frame.
fn example(name: &str, frames: usize) {
    let folder = Path::new("/usr/share/doc/povray/examples/animations").join(name);
    let ini = folder.join(format!("{name}.ini"));
    assert!(
        ini.is_file(),
        "install Debian's povray-examples: {} is missing",
        ini.display()
    );
    let work = tempfile::tempdir().unwrap();
    let (ours, its) = (work.path().join("ours"), work.path().join("its"));
    std::fs::create_dir(&its).unwrap();
    let ended = render(&ini, &ours, &["--", "+W320", "+H240"]);
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let summary = ended.summary();
    assert_eq!(summary["frames"], frames);
    assert_eq!(summary["in_order"], serde_json::Value::Null);
    let out = format!("+O{}/", its.display());
    let ini = format!("{name}.ini");
    povray(&folder, &[&ini, "+W320", "+H240", &out]);
    assert_same(&ours, &its, frames);
}

#[test]
fn float1_of_the_examples() {
    example("float1", 51);
}

#[test]
fn vect1_of_the_examples() {
    example("vect1", 60);
}

#[test]
fn splinefollow_of_the_examples() {
    example("splinefollow", 20);
}

/// INI files, sections and switches: decor's frames are POV-Ray's.
#[test]
fn frames_are_those_of_povray_alone() {
    const CASES: &[(&str, &[&str], usize)] = &[
        ("orbit.ini", &[], 12),
        ("orbit.ini[low]", &[], 4),
        ("orbit.ini", &["+SF3", "+EF5", "Declare=Turns=2"], 3),
        ("orbit.ini", &["+SF0.5", "-KC", "+KI0.25", "+KF0.75"], 7),
        ("orbit.ini", &["+KFI98", "+KFF101", "Frame_Step=2"], 2),
        ("orbit.ini", &["+J1", "+AM2", "+A0.05", "+EF2"], 2),
        (
            "orbit.ini",
            &["+SC0.25", "+EC0.75", "+SR10", "+ER40", "+EF1"],
            1,
        ),
        ("orbit.ini[types]", &["+FN16", "+UA"], 3),
        ("orbit.ini[types]", &["+FP", "+Oball.ppm"], 3),
        ("orbit.ini[types]", &["+FT", "+Osome.where"], 3),
        ("orbit.ini[types]", &["+FC"], 3),
        ("orbit.ini[types]", &["+FJ", "Compression=90"], 3),
        ("orbit.ini[types]", &["+FB"], 3),
        ("orbit.ini[types]", &["+FE"], 3),
        ("orbit.ini[types]", &["+FH"], 3),
        ("orbit.ini[types]", &["-F", "+FNg"], 3),
        (
            "orbit.pov",
            &["+W32", "+H24", "+Lparts", "+K0.3", "Declare=Turns=1"],
            1,
        ),
        (
            "orbit.pov",
            &[
                "+W32",
                "+H24",
                "+Lparts",
                "+KFF2",
                "Declare=Turns=1",
                "+P",
                "+D",
            ],
            2,
        ),
    ];
    // POV-Ray sleeps most of the time.
    std::thread::scope(|scope| {
        for (file, switches, frames) in CASES {
            scope.spawn(|| is_as_povray_alone(file, switches, *frames));
        }
    });
}

fn is_as_povray_alone(file: &str, switches: &[&str], frames: usize) {
    let folder = scenes();
    let (ours, its) = (folder.path().join("ours"), folder.path().join("its"));
    std::fs::create_dir(&its).unwrap();
    let mut more = vec!["--"];
    more.extend_from_slice(switches);
    let ended = render(&folder.path().join(file), &ours, &more);
    assert_eq!(ended.status, 0, "{file} {switches:?}: {}", ended.stderr);
    // Only the folder of the pictures is another one.
    let name = switches
        .iter()
        .find_map(|s| s.strip_prefix("+O"))
        .unwrap_or_default();
    let out = format!("+Oits/{name}");
    let mut words = vec![file];
    words.extend(
        switches
            .iter()
            .filter(|s| !s.starts_with("+O") && **s != "+P" && **s != "+D"),
    );
    words.extend([out.as_str(), "Output_To_File=on", "-P"]);
    povray(folder.path(), &words);
    assert_same(&ours, &its, frames);
    assert_eq!(ended.summary()["frames"], frames, "{file} {switches:?}");
}

#[test]
fn names_with_blanks_in_folders_with_accents() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("là bas");
    copy_to(&fixture("unedited"), &place);
    std::fs::rename(place.join("orbit.pov"), place.join("my orbit.pov")).unwrap();
    let (ours, its) = (folder.path().join("öut put"), place.join("its"));
    std::fs::create_dir(&its).unwrap();
    let switches = ["+W32", "+H24", "+Lparts", "+KFF2", "Declare=Turns=1"];
    let mut more = vec!["--"];
    more.extend(switches);
    let ended = render(&place.join("my orbit.pov"), &ours, &more);
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let mut words = vec!["\"my orbit.pov\""];
    words.extend(switches);
    words.push("+Oits/");
    povray(&place, &words);
    assert_same(&ours, &its, 2);
    assert!(ours.join("my orbit2.png").is_file());
}

fn copy_to(from: &Path, to: &Path) {
    std::fs::create_dir(to).unwrap();
    copy(from, to);
}

#[test]
fn a_part_a_resumed_run_a_baseline_and_another_format() {
    let folder = scenes();
    let ini = folder.path().join("orbit.ini[low]");
    let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
    let part = render(&ini, &ours, &["--frames", "4-5", "--jobs", "2"]);
    assert_eq!(part.summary()["frames"], 2, "{}", part.stderr);
    assert_eq!(pictures(&ours).len(), 2);
    // What an interrupted run of the whole leaves: these frames, and a note.
    let again = render(&ini, &ours, &["--resume"]).summary();
    assert_eq!(
        (&again["frames"], &again["frames_kept"]),
        (&4.into(), &2.into())
    );
    assert_eq!(again["renderer_frames"], 2);
    let nothing = render(&ini, &ours, &["--resume"]).summary();
    assert_eq!(
        (&nothing["frames_kept"], &nothing["renderer_calls"]),
        (&4.into(), &0.into())
    );
    let stock = render(&ini, &plain, &["--baseline"]);
    assert_eq!(stock.summary()["mode"], "baseline", "{}", stock.stderr);
    assert_eq!(stock.summary()["renderer_calls"], 1);
    assert_same(&ours, &plain, 4);
    // Another scene text is another job.
    let scene = folder.path().join("orbit.pov");
    let text = std::fs::read_to_string(&scene)
        .unwrap()
        .replace("Gray80", "Red");
    std::fs::write(&scene, text).unwrap();
    let changed = render(&ini, &ours, &["--resume"]).summary();
    assert_eq!(changed["frames_kept"], 0);

    let deep = folder.path().join("deep");
    let keep = folder.path().join("kept");
    let keep = keep.to_str().unwrap();
    let ended = render(
        &ini,
        &deep,
        &["--format", "png16", "--frames", "4", "--keep", keep],
    );
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let (_, _, pixels) = common::pixels(&deep.join("orbit4.png"));
    assert!(pixels.iter().flatten().any(|v| *v > 255), "16 bits");
    let logs = std::fs::read_dir(keep).unwrap().count();
    assert_eq!(logs, 1);
    let outside = render(&ini, &deep, &["--frames", "1-9"]);
    assert_eq!(outside.status, 3, "{}", outside.stderr);
}

#[test]
fn frames_that_depend_on_files_are_rendered_in_order() {
    let folder = scenes();
    let (ours, its) = (folder.path().join("ours"), folder.path().join("its"));
    std::fs::create_dir(&its).unwrap();
    let switches = ["+W48", "+H36", "+KFF4"];
    let mut more = vec!["--"];
    more.extend(switches);
    let scene = folder.path().join("diary.pov");
    let ended = render(&scene, &ours, &more);
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let reason = ended.summary()["in_order"].as_str().unwrap().to_owned();
    assert!(
        reason.contains("diary.pov:9") && reason.contains("write"),
        "{reason}"
    );
    assert!(ended.stderr.contains(&reason));
    assert_eq!(ended.summary()["renderer_calls"], 1);
    let mut words = vec!["diary.pov", "+Oits/"];
    words.extend(switches);
    povray(folder.path(), &words);
    assert_same(&ours, &its, 4);
    // A part needs what comes before it.
    let part = folder.path().join("part");
    let ended = render(
        &scene,
        &part,
        &["--frames", "3-4", "--", "+W48", "+H36", "+KFF4"],
    );
    assert_eq!(ended.summary()["renderer_frames"], 4, "{}", ended.stderr);
    assert_eq!(pictures(&part).len(), 2);
    assert_eq!(
        content(&part.join("diary4.png")),
        content(&its.join("diary4.png"))
    );
}

#[test]
fn frames_that_show_earlier_frames() {
    let (here, there) = (scenes(), scenes());
    let ours = here.path().join("ours");
    let switches = ["+W48", "+H36", "+KFF3"];
    let mut more = vec!["--"];
    more.extend(switches);
    let ended = render(&here.path().join("echo.pov"), &ours, &more);
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let reason = ended.summary()["in_order"].as_str().unwrap().to_owned();
    assert!(
        reason.contains("echo.pov:11") && reason.contains("may be a frame"),
        "{reason}"
    );
    let mut words = vec!["echo.pov"];
    words.extend(switches);
    povray(there.path(), &words);
    assert_same(&ours, there.path(), 3);
}

#[test]
fn errors_have_their_status_and_leave_no_frame() {
    let folder = scenes();
    let out = folder.path().join("out");
    let scene = folder.path().join("scene.pov");
    let ends = |text: &str, more: &[&str]| {
        std::fs::write(&scene, text).unwrap();
        let ended = render(&scene, &out, more);
        assert!(!out.exists() || pictures(&out).is_empty());
        ended
    };
    let missing = render(&folder.path().join("nobody.ini"), &out, &[]);
    assert_eq!(missing.status, 3, "{}", missing.stderr);
    let missing = render(&folder.path().join("nobody.pov"), &out, &[]);
    assert_eq!(missing.status, 3, "{}", missing.stderr);
    assert!(missing.stderr.contains("nobody.pov"), "{}", missing.stderr);
    let refused = ends("", &["--", "Post_Frame_Command=ls"]);
    assert_eq!(refused.status, 3, "{}", refused.stderr);
    let refused = ends("", &["--", "+ZZ"]);
    assert_eq!(refused.status, 3, "{}", refused.stderr);

    let wrong = ends("sphere { 0, oops }", &["--", "+W8", "+H8", "+KFF3"]);
    assert_eq!(wrong.status, 4, "{}", wrong.stderr);
    assert!(wrong.stderr.contains("oops"), "{}", wrong.stderr);

    let endless = "#declare K = 1; #while (K > 0) #declare K = K + 1; #end";
    let late = ends(endless, &["--timeout", "2", "--", "+W8", "+H8", "+KFF3"]);
    assert_eq!(late.status, 4, "{}", late.stderr);
    assert!(late.stderr.contains("did not finish"), "{}", late.stderr);
}

#[test]
fn what_a_plain_scene_does_not_take() {
    let folder = scenes();
    let ini = folder.path().join("orbit.ini");
    let out = folder.path().join("out");
    for more in [
        &["--mode", "equivalent"][..],
        &["--threshold", "2"],
        &["--period", "5"],
        &["--renderer", "reference"],
        &["--apng", "x.png", "--", "+FP"],
    ] {
        let ended = render(&ini, &out, more);
        assert_eq!(ended.status, 64, "{more:?}: {}", ended.stderr);
        assert!(!out.exists());
    }
    let film = fixture("contact/contact.anim");
    let ended = render(&film, &out, &["--", "+W3"]);
    assert_eq!(ended.status, 64, "{}", ended.stderr);
    let ended = Run::new(["explain", "--frame", "99"]).arg(&ini).ends();
    assert_eq!(ended.status, 3, "{}", ended.stderr);
}

#[test]
fn a_plan_says_what_was_found() {
    let folder = scenes();
    let plan = |file: &str, more: &[&str]| {
        Run::new(["plan", "--json"])
            .arg(folder.path().join(file))
            .args(more)
            .succeeds()
            .summary()
    };
    let orbit = plan("orbit.ini[Low]", &[]);
    assert_eq!((&orbit["frames"], &orbit["width"]), (&4.into(), &48.into()));
    assert_eq!(orbit["first_file"], "orbit3.png");
    assert_eq!(orbit["in_order"], serde_json::Value::Null);
    let files = orbit["files"].as_array().unwrap();
    assert!(
        files
            .iter()
            .any(|f| f.as_str().unwrap().ends_with("planet.inc")),
        "{files:?}"
    );
    let diary = plan("diary.pov", &["--", "+KFF5"]);
    assert_eq!(diary["jobs"], 1);
    assert!(diary["in_order"].is_string());
}
