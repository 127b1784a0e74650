//! Scenes that mean no good.

use std::path::Path;

use crate::common::Run;
use crate::trial::{ALWAYS, both};

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Renders a scene's text by both; the files that lie beside it then.
fn beside(text: &str) -> (crate::trial::Tried, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("scenes");
    std::fs::create_dir(&scenes).unwrap();
    std::fs::write(scenes.join("s.pov"), text).unwrap();
    let switches = ["+W96", "+H64", "+KFF5", "-A"];
    let tried = both(
        &scenes,
        "s.pov",
        &switches,
        ALWAYS,
        &folder.path().join("out"),
    );
    let names = files(&scenes);
    (tried, names)
}

const SCENE: &str = "\
camera { location <0, 1, -6> look_at 0 }
light_source { <4, 8, -6>, 1 }
plane { y, -1 pigment { checker rgb 1, rgb .3 } }
sphere { <clock * 2 - 1, 0, 0>, .5 pigment { rgb <1, .4, .2> } }
";

#[test]
fn no_file_lies_where_povray_alone_would_have_left_none() {
    let (tried, names) = beside(SCENE);
    tried.assert_identical("the scene");
    assert_eq!(
        (tried.whole(), names),
        (String::new(), vec!["s.pov".to_owned()])
    );
    let writing = format!("#fopen F \"notes.txt\" write\n#write(F, clock)\n#fclose F\n{SCENE}");
    let (tried, names) = beside(&writing);
    tried.assert_identical("a scene that writes");
    assert!(tried.summary["in_order"].is_string(), "{}", tried.summary);
    assert_eq!(names, ["notes.txt", "s.pov"]);
}

#[test]
fn macros_that_look_like_decors_own() {
    let macros = "\
#macro decor0_proxy(A, B) sphere { A, B } #end
#macro decor_() #end
#declare decor0_language = 3;
#declare decor1_ = 7;
";
    let (tried, _) = beside(&format!("{macros}{SCENE}decor0_proxy(<0, 1, clock>, .3)\n"));
    tried.assert_identical("decor's names");
}

/// What ends a scene early, hides its end, or turns its language.
#[test]
fn scenes_that_end_in_strange_ways() {
    for end in [
        "// no line ends this",
        "/* a comment */",
        "#version 3.5;\n",
        "#declare Last = 3",
        "#if (clock > 2) sphere {",
        "#default { pigment { rgb 1 } finish { reflection .3 } }",
        "/* open",
    ] {
        let text = format!("{SCENE}{end}");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("s.pov"), &text).unwrap();
        let file = folder.path().join("s.pov");
        let out = folder.path().join("probe");
        let plainly = Run::new(["render", "--mode", "full", "--json"]).arg(&file);
        let switches = ["--", "+W32", "+H24", "+KFF3"];
        let ended = plainly.arg("-o").arg(&out).args(switches).ends();
        if ended.status == 0 {
            beside(&text).0.assert_identical(end);
            continue;
        }
        let coherent = Run::new(["render", "--no-fallback", "--json"]).arg(&file);
        let also = coherent.arg("-o").arg(&out).args(switches).ends();
        assert_eq!(also.status, ended.status, "{end}: {}", also.stderr);
    }
}

#[test]
fn a_scene_that_never_ends_is_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let endless = "#declare K = 1; #while (K > clock - 9) #declare K = K + 1; #end";
    std::fs::write(folder.path().join("s.pov"), format!("{SCENE}{endless}")).unwrap();
    let run = Run::new(["render", "--no-fallback", "--timeout", "3"]);
    let out = folder.path().join("out");
    let run = run.arg(folder.path().join("s.pov")).arg("-o").arg(&out);
    let ended = run.args(["--", "+W32", "+H24", "+KFF4"]).ends();
    assert_eq!(ended.status, 4, "{}", ended.stderr);
    assert!(ended.stderr.contains("did not finish"), "{}", ended.stderr);
    assert!(files(&out).iter().all(|name| !name.ends_with(".png")));
}

/// All files below a folder, by their names in it.
fn tree(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap();
                names.push(name.to_string_lossy().into_owned());
            }
        }
    }
    names.sort();
    names
}

/// Files that a scene reads or writes beside its own folder: those are there in the
/// end that POV-Ray alone leaves, with the same content.
#[test]
fn what_lies_outside_of_the_folder() {
    let moving = "sphere { <0, 1 + clock, 0>, .3 pigment { rgb z } }\n";
    let cases = [
        ("#include \"../outside.inc\"\n", false),
        (
            "#fopen F \"../notes.txt\" append\n#write(F, clock)\n#fclose F\n",
            true,
        ),
        (
            "#macro Out() #fopen F \"../more.txt\" write #write(F, 1) #fclose F #end Out()\n",
            true,
        ),
    ];
    for (text, writes) in cases {
        let [ours, its] = [(); 2].map(|()| tempfile::tempdir().unwrap());
        for folder in [&ours, &its] {
            std::fs::create_dir(folder.path().join("scenes")).unwrap();
            std::fs::write(folder.path().join("outside.inc"), moving).unwrap();
            let scene = folder.path().join("scenes/s.pov");
            std::fs::write(scene, format!("{SCENE}{text}")).unwrap();
        }
        let switches = ["+W96", "+H64", "+KFF4", "-A", "+WT1"];
        let out = tempfile::tempdir().unwrap();
        let run = Run::new(["render", "--json"]).args(ALWAYS);
        let run = run
            .arg(ours.path().join("scenes/s.pov"))
            .arg("-o")
            .arg(out.path());
        let ended = run.arg("--").args(switches).ends();
        assert_eq!(ended.status, 0, "{text}: {}", ended.stderr);
        let alone = tempfile::tempdir().unwrap();
        let to = format!("+O{}/", alone.path().display());
        let words = [&["s.pov"], &switches[..], &[to.as_str()]].concat();
        crate::stock::povray(&its.path().join("scenes"), &words);
        assert_eq!(tree(ours.path()), tree(its.path()), "{text}");
        for name in tree(its.path()) {
            let content = |folder: &tempfile::TempDir| std::fs::read(folder.path().join(&name));
            assert_eq!(
                content(&ours).unwrap(),
                content(&its).unwrap(),
                "{text}: {name}"
            );
        }
        for picture in crate::stock::pictures(alone.path()) {
            let name = picture.file_name().unwrap();
            let same =
                crate::stock::content(&out.path().join(name)) == crate::stock::content(&picture);
            assert!(same, "{text}: {name:?}");
        }
        let mode = &ended.summary()["mode"];
        assert_eq!(mode, if writes { "full" } else { "exact" }, "{text}");
    }
}
