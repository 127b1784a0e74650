//! INI files and switches, against what POV-Ray says that it read; names and
//! numbers of frames, against the files that it writes.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use super::settings::Value;
use super::*;

fn povray() -> PovRay {
    PovRay::find().expect("POV-Ray is installed")
}

/// An INI file, and the words of a command line that read it.
struct Case {
    what: &'static str,
    ini: &'static str,
    words: &'static [&'static str],
}

const fn case(what: &'static str, ini: &'static str, words: &'static [&'static str]) -> Case {
    Case { what, ini, words }
}

const CASES: &[Case] = &[
    case(
        "plain",
        "Width=64\nHeight = 48\nInput_File_Name=s.pov\n",
        &["a.ini"],
    ),
    case(
        "capitals",
        "wIdTh=64\nINPUT_FILE_NAME=s.pov\n+kFf7",
        &["a.ini"],
    ),
    case(
        "comments",
        "; Width=1\n# Height=2\nWidth=64 ; Height=9\nHeight=48#x\nInput_File_Name=s.pov",
        &["a.ini"],
    ),
    case(
        "sections",
        "Input_File_Name=s.pov\nWidth=64\n[low]\nWidth=32\n[High]\nWidth=640\nHeight=9\n",
        &["a.ini"],
    ),
    case(
        "a named section",
        "Input_File_Name=s.pov\nWidth=64\n[low]\nWidth=32\n[High]\nWidth=640\nHeight=9\n",
        &["a.ini[hIGH]"],
    ),
    case(
        "a section twice",
        "Input_File_Name=s.pov\n[a]\nWidth=32\n[b]\nWidth=640\n[a]\nHeight=9",
        &["a.ini[a]"],
    ),
    case(
        "a section that is not there",
        "Input_File_Name=s.pov\nWidth=5\n[a]\nWidth=32",
        &["a.ini[c]"],
    ),
    case(
        "switches in a file",
        "Input_File_Name=s.pov\n+W32 +H24 -A +Q3\n",
        &["a.ini"],
    ),
    case(
        "an option behind switches",
        "Input_File_Name=s.pov\n+kf0.1666 +kff20 +kc declare=fp=0\n",
        &["a.ini"],
    ),
    case(
        "two options on a line",
        "Width=32 Height=24\nInput_File_Name=s.pov\n",
        &["a.ini"],
    ),
    case(
        "a switch behind an option",
        "Width=32 +H24\nInput_File_Name=s.pov\n",
        &["a.ini"],
    ),
    case(
        "a name that swallows an option",
        "Input_File_Name=s.pov Width=32\n",
        &["a.ini"],
    ),
    case(
        "a blank before the end of the line",
        "Input_File_Name=s.pov \nWidth=32\n",
        &["a.ini"],
    ),
    case(
        "a blank before a comment line",
        "Input_File_Name=s.pov \n;\nWidth=32\n",
        &["a.ini"],
    ),
    case(
        "a blank at the end",
        "Width=32\nInput_File_Name=s.pov ",
        &["a.ini"],
    ),
    case(
        "a name with blanks",
        "Input_File_Name=my own scene.pov ; yes\nWidth=32\n",
        &["a.ini"],
    ),
    case(
        "quotes",
        "Input_File_Name=\"my own scene.pov\"\nOutput_File_Name='x y'\nWidth=\"32\"",
        &["a.ini"],
    ),
    case(
        "tabs",
        "\tWidth\t=\t32\t\n\tInput_File_Name=s.pov\n",
        &["a.ini"],
    ),
    case(
        "carriage returns",
        "Width=32\r\nInput_File_Name=s.pov\r\n+KFF8\r\nHeight=24\r\n",
        &["a.ini"],
    ),
    case(
        "words for on",
        "Input_File_Name=s.pov\nAntialias=On\nJitter=0\nCyclic_Animation=yes\nBounding=maybe\nTest_Abort=TRUE",
        &["a.ini"],
    ),
    case(
        "numbers with tails",
        "Input_File_Name=s.pov\nWidth=32px\nFinal_Clock=2.5s\nHeight=24.9",
        &["a.ini"],
    ),
    case(
        "declarations",
        "Input_File_Name=s.pov\nDeclare=a=1\nDeclare=b=-2.5\n",
        &["a.ini", "Declare=c=1e3"],
    ),
    case(
        "declarations behind commas",
        "Input_File_Name=s.pov\nDeclare=a=1,b=2, c=3\n",
        &["a.ini"],
    ),
    case(
        "library folders",
        "Input_File_Name=s.pov\nLibrary_Path=lib\n+Lother\nmore/\n",
        &["a.ini", "+L/usr/share"],
    ),
    case("a scene as a word", "s.pov\nWidth=3", &["a.ini"]),
    case("a scene in quotes", "\"my s.pov\"\nWidth=3", &["a.ini"]),
    case(
        "the last one wins",
        "Input_File_Name=s.pov\nWidth=3\nWidth=5\n",
        &["+W9", "a.ini", "+H7", "+H8"],
    ),
    case(
        "file types",
        "Input_File_Name=s.pov\nOutput_File_Type=P\nBits_Per_Color=16",
        &["a.ini"],
    ),
    case(
        "file types with bits",
        "Input_File_Name=s.pov\nOutput_File_Type=N16",
        &["a.ini"],
    ),
    case(
        "switches with bits",
        "Input_File_Name=s.pov\n+FN16",
        &["a.ini"],
    ),
    case("grey", "Input_File_Name=s.pov\n+FNg", &["a.ini"]),
    case("no output", "Input_File_Name=s.pov\n-F", &["a.ini"]),
    case(
        "subsets as shares",
        "Input_File_Name=s.pov\n+KFF10 +SF0.25 +EF0.5",
        &["a.ini"],
    ),
    case(
        "subsets as numbers",
        "Input_File_Name=s.pov\n+KFF10\nSubset_Start_Frame=3\nSubset_End_Frame=4.5",
        &["a.ini"],
    ),
    case(
        "frames",
        "Input_File_Name=s.pov\n+KFI2 +KFF10 +KI-1 +KF2.5 +STP3",
        &["a.ini"],
    ),
    case(
        "thresholds",
        "Input_File_Name=s.pov\n+A0.2 +R3 +J0.5 +AM2",
        &["a.ini"],
    ),
    case(
        "partial",
        "Input_File_Name=s.pov\n+SC0.25 +EC40 +SR3 +ER0.75",
        &["a.ini"],
    ),
    case(
        "both spellings",
        "Input_File_Name=s.pov\nBits_Per_Colour=7\n",
        &["a.ini"],
    ),
    case("quoted switches", "+I\"my s.pov\"\n+O'x y' +W3", &["a.ini"]),
    case("words with blanks", "Width=3", &["a.ini", "+H5 +W7 s.pov"]),
    case(
        "quoted words",
        "Width=3",
        &["a.ini", "\"my s.pov\"", "Output_File_Name=\"x y\""],
    ),
    case(
        "another file",
        "Input_File_Name=s.pov\nInclude_Ini=b.ini\nHeight=3",
        &["a.ini"],
    ),
    case(
        "another file as a word",
        "b.ini\nInput_File_Name=s.pov\nHeight=3",
        &["a.ini"],
    ),
    case(
        "another file's section",
        "b.ini[x]\nInput_File_Name=s.pov\nHeight=3",
        &["a.ini"],
    ),
    case("no ending", "Input_File_Name=s.pov\nHeight=3", &["a"]),
    case(
        "commas on the command line",
        "Width=3",
        &["a.ini", "+Ia,b.pov"],
    ),
    case(
        "field rendering",
        "Input_File_Name=s.pov\nField_Render=on\n+UO",
        &["a.ini"],
    ),
    case(
        "old options",
        "Input_File_Name=s.pov\nBuffer_Size=3\nWidth=5",
        &["a.ini"],
    ),
];

/// The lines that POV-Ray writes: `Keyword=value`, texts in quotes.
fn stated(text: &str) -> BTreeMap<String, Vec<String>> {
    let mut stated = BTreeMap::<String, Vec<String>>::new();
    for line in text.lines() {
        let (name, value) = line.split_once('=').expect("an option");
        let value = value
            .strip_prefix('"')
            .and_then(|v| v.strip_suffix('"'))
            .unwrap_or(value);
        stated
            .entry(name.to_owned())
            .or_default()
            .push(value.to_owned());
    }
    stated
}

fn same(name: &str, ours: &Value, its: Option<&String>) -> bool {
    let Some(its) = its else { return false };
    match ours {
        Value::Whole(n) => its == &n.to_string(),
        // POV-Ray prints six digits.
        Value::Real(x) => its
            .parse::<f32>()
            .is_ok_and(|y| (x - y).abs() <= 1e-5 * x.abs()),
        Value::Switch(on) => its == if *on { "On" } else { "Off" },
        Value::Text(text) if name == "Output_File_Type" && text == "S" => true,
        Value::Text(text) => its == text,
    }
}

/// What POV-Ray says of these words in this folder.
fn ask(povray: &PovRay, folder: &Path, words: &[&str]) -> BTreeMap<String, Vec<String>> {
    let out = folder.join("stated.ini");
    let ended = Command::new(povray.program())
        .args(words)
        .arg(format!(
            "Create_Ini={}",
            quoted(out.to_str().unwrap()).unwrap()
        ))
        .args(["-D", "-V"])
        .current_dir(folder)
        .output()
        .expect("POV-Ray starts");
    let text = std::fs::read_to_string(&out)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&ended.stderr)));
    stated(&text)
}

fn disagreement(povray: &PovRay, case: &Case) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.ini"), case.ini).unwrap();
    let other = "Antialias=on\nWidth=11\n[x]\nWidth=12\n";
    std::fs::write(folder.path().join("b.ini"), other).unwrap();
    let mut its = ask(povray, folder.path(), case.words);
    let words: Vec<String> = case
        .words
        .iter()
        .map(|w| (*w).to_owned())
        .chain(["-D".into(), "-V".into()])
        .collect();
    let ours = match povray.read(folder.path(), &words) {
        Ok(settings) => settings,
        Err(refused) => return Some(format!("{}: {refused:?}", case.what)),
    };
    for (name, value) in ours.values() {
        let its = its.remove(name);
        if !same(name, value, its.as_ref().and_then(|list| list.first())) {
            return Some(format!(
                "{}: {name} is {value:?}, POV-Ray says {its:?}",
                case.what
            ));
        }
    }
    let folders = |list: &[String]| -> Vec<String> {
        let mut folders: Vec<String> = Vec::new();
        for folder in list.iter().map(|f| f.trim_end_matches('/').to_owned()) {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
        folders
    };
    let its_folders = its.remove("Library_Path").unwrap_or_default();
    if folders(&ours.library) != folders(&its_folders) {
        return Some(format!(
            "{}: {:?}, POV-Ray says {its_folders:?}",
            case.what, ours.library
        ));
    }
    let its_declares = its.remove("Declare").unwrap_or_default();
    let numbers = |list: &[String]| -> Vec<(String, f64)> {
        list.iter()
            .map(|d| d.split_once('=').expect("a name"))
            .map(|(name, value)| (name.to_owned(), value.parse().expect("a number")))
            .collect()
    };
    if numbers(&ours.declares) != numbers(&its_declares) {
        return Some(format!(
            "{}: {:?}, POV-Ray says {its_declares:?}",
            case.what, ours.declares
        ));
    }
    its.remove("Create_Ini");
    its.remove("Work_Threads");
    (!its.is_empty()).then(|| format!("{}: only POV-Ray knows {its:?}", case.what))
}

#[test]
fn options_are_read_as_povray_reads_them() {
    let povray = povray();
    // POV-Ray sleeps most of the time.
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let cases: Vec<_> = CASES
            .iter()
            .map(|case| scope.spawn(|| disagreement(&povray, case)))
            .collect();
        cases
            .into_iter()
            .filter_map(|case| case.join().unwrap())
            .collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_povray_does_not_take_is_refused() {
    let povray = povray();
    for (ini, why) in [
        ("Width=foo\nInput_File_Name=s.pov", "line 1"),
        ("Input_File_Name=s.pov\nNo_Such_Option=3", "line 2"),
        ("Input_File_Name=s.pov\n\n+ZZ9", "line 3"),
        ("Input_File_Name=s.pov\nOutput_File_Type=Z", "file type"),
        ("Input_File_Name=s.pov\nmissing.ini", "no such INI file"),
        ("Input_File_Name=s.pov\na.ini", "without end"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.ini"), ini).unwrap();
        std::fs::write(folder.path().join("s.pov"), "").unwrap();
        let refused = povray.plain(&folder.path().join("a.ini"), &[], None);
        let message = refused.expect_err(ini).to_string();
        assert!(message.contains(why), "{ini}: {message}");
        if why == "without end" {
            // POV-Ray itself would read on until it crashes.
            continue;
        }
        let its = Command::new(povray.program())
            .args(["a.ini", "-D", "-V"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(!its.status.success(), "POV-Ray takes {ini}");
    }
}

#[test]
fn commands_and_shows_are_refused_with_the_reason() {
    let povray = povray();
    for (line, why) in [
        (
            "Post_Frame_Command=touch ran",
            "Post_Frame_Command would run",
        ),
        (
            "Pre_Scene_Command=\"touch ran\"",
            "Pre_Scene_Command would run",
        ),
        ("Real_Time_Raytracing=on", "writes none"),
        ("Clockless_Animation=on", "writes none"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let ini = format!("Input_File_Name=s.pov\n{line}\n");
        std::fs::write(folder.path().join("a.ini"), ini).unwrap();
        std::fs::write(folder.path().join("s.pov"), "").unwrap();
        let refused = povray.plain(&folder.path().join("a.ini"), &[], None);
        let message = refused.expect_err(line).to_string();
        assert!(message.contains(why), "{line}: {message}");
    }
}

/// Frames and names, against the files that appear.
#[test]
fn frames_are_those_that_povray_writes() {
    const SWITCHES: &[&str] = &[
        "",
        "+KFF12",
        "+KFF9 +KC",
        "+KFF3 +KC",
        "+KFF10 +SF0.25 +EF0.5",
        "+KFF10 +KC +SF0.25 +EF0.5",
        "+KFF30 +SF0.1 +EF0.2",
        "+KFF12 +SF3 +EF5",
        "+KFF5 +SF4",
        "+KFF5 +EF0.5",
        "+KFF3 Subset_End_Frame=0",
        "+KFF3 +SF5",
        "+KFF3 +EF5",
        "+KFI1 +KFF1",
        "+KFI0 +KFF0",
        "+KFI0 +KFF2",
        "+KFF1",
        "+KFI2 +KFF2",
        "+KFI9 +KFF11",
        "+KFI3",
        "+KFI4 +KFF2",
        "+KFF12 +STP5",
        "+KFF12 +STP5 +SF2",
        "+KFF12 +STP0",
        "+KFF2 +Ofoo",
        "+KFF2 +Ofoo.png",
        "+KFF2 +Ofoo.ppm",
        "+KFF2 +Ofoo.",
        "+KFF2 +O.png",
        "+KFF2 +Osub/",
        "+KFF2 +Osub/foo.bar.png",
        "+FP +KFF2",
        "+FT +Ofoo.png",
        "+FC",
        "+FJ",
        "+FB",
        "+FE",
        "+FH",
        "+FN16 +Ofoo.PNG",
    ];
    let povray = povray();
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let cases: Vec<_> = SWITCHES
            .iter()
            .map(|switches| scope.spawn(|| names_differ(&povray, switches)))
            .collect();
        cases
            .into_iter()
            .filter_map(|case| case.join().unwrap())
            .collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn names_differ(povray: &PovRay, switches: &str) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("my.scene.pov");
    std::fs::write(&scene, "camera { location -3*z } sphere { 0, 1 }").unwrap();
    let sub = folder.path().join("sub");
    std::fs::create_dir(&sub).unwrap();
    let words: Vec<String> = ["+W4", "+H4", "-A", switches].map(str::to_owned).to_vec();
    let plain = povray.plain(&scene, &words, None).unwrap();
    let mut ours: Vec<String> = plain.frames.numbers().map(|n| plain.name(n)).collect();
    ours.sort();
    let ended = Command::new(povray.program())
        .arg("my.scene.pov")
        .args(&words)
        .args(["-D", "-V"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(
        ended.status.success(),
        "{switches}: {}",
        String::from_utf8_lossy(&ended.stderr)
    );
    let names = |folder: &Path| -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
        entries
            .filter(|e| e.path().is_file())
            .map(|e| e.file_name().into_string().unwrap())
            .collect()
    };
    let mut its = names(folder.path());
    its.extend(names(&sub));
    its.retain(|name| name != "my.scene.pov");
    its.sort();
    (ours != its).then(|| format!("{switches}: {ours:?}, POV-Ray writes {its:?}"))
}

#[test]
fn what_is_a_plain_scene() {
    for yes in ["a.pov", "x/a.INI", "a.ini[low]", "a b.Pov"] {
        assert!(is_plain(Path::new(yes)), "{yes}");
    }
    for no in ["a.anim", "a.ini[low", "ini", "a.pov.bak", "a[b].anim"] {
        assert!(!is_plain(Path::new(no)), "{no}");
    }
}
