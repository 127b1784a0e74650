//! `decor sweep`: what it measures, what it keeps, what it says.

mod common;
mod moving;

use std::path::{Path, PathBuf};

use common::{Ended, Run};
use serde_json::Value;

fn sweep(film: &Path, out: &Path, extra: &[&str]) -> Ended {
    Run::new(["sweep", "--renderer", "reference", "-o"])
        .arg(out)
        .arg(film)
        .args(extra)
        .succeeds()
}

/// The lines of `--json` but for the summary.
fn settings(ended: &Ended) -> Vec<Value> {
    let lines: Vec<Value> = ended
        .stdout
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let settings: Vec<Value> = lines
        .into_iter()
        .filter(|line| line["type"] == "setting")
        .collect();
    assert!(!settings.is_empty());
    settings
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// The folders in which something was made, with when it was done.
fn made(out: &Path) -> Vec<(PathBuf, std::time::SystemTime)> {
    let mut made: Vec<_> = std::fs::read_dir(out.join("cache"))
        .expect("the cache")
        .map(|entry| entry.expect("an entry").path().join("made.json"))
        .filter(|path| path.is_file())
        .map(|path| {
            let time = path.metadata().and_then(|data| data.modified());
            (path, time.expect("a time"))
        })
        .collect();
    made.sort();
    made
}

#[test]
fn errors_grow_with_the_threshold_and_agree_with_compare() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let out = folder.path().join("sweep");
    let grid = ["--thresholds", "0.2,0.4,2", "--json"];
    let ended = sweep(&film, &out, &grid);
    let lines = settings(&ended);
    assert_eq!(lines.len(), 8, "full, exact and two modes with three each");
    for mode in ["full", "exact"] {
        let line = lines.iter().find(|l| l["mode"] == mode).unwrap();
        assert_eq!(number(&line["errors"]["max"]), 0.0, "{line:#}");
        assert!(line["errors"]["psnr"].is_null());
    }
    for mode in ["equivalent", "preview"] {
        let of_mode: Vec<&Value> = lines.iter().filter(|l| l["mode"] == mode).collect();
        let flips: Vec<f64> = of_mode
            .iter()
            .map(|l| number(&l["errors"]["flip"]))
            .collect();
        assert!(
            flips.is_sorted() && flips[0] < flips[2],
            "{mode}: {flips:?}"
        );
        // The larger the threshold, the less is rendered.
        let traced: Vec<f64> = of_mode
            .iter()
            .map(|l| number(&l["speedup"]["traced"]))
            .collect();
        assert!(
            traced.is_sorted() && traced[0] < traced[2],
            "{mode}: {traced:?}"
        );
        for line in of_mode {
            let (kept, allowed) = (&line["errors"]["motion_px"], &line["threshold_px"]);
            assert!(number(kept) <= number(allowed), "{line:#}");
        }
    }
    // The same numbers as of the two verbs by hand.
    let (plain, merged) = (folder.path().join("plain"), folder.path().join("merged"));
    let render = |out: &Path, extra: &[&str]| {
        Run::new(["render", "--renderer", "reference", "-o"])
            .arg(out)
            .arg(&film)
            .args(extra)
            .succeeds();
    };
    render(&plain, &["--baseline"]);
    let one = lines
        .iter()
        .find(|l| l["name"] == "equivalent 0.4 px")
        .unwrap();
    let options: Vec<&str> = one["options"].as_str().unwrap().split(' ').collect();
    render(&merged, &options);
    let compared = Run::new(["compare", "--json", "--fail", "0.016"])
        .args([&plain, &merged])
        .ends()
        .summary();
    for metric in ["max", "rms", "psnr", "ssim", "flip"] {
        assert_eq!(one["errors"][metric], compared[metric], "{metric}");
    }
    assert_eq!(one["errors"]["flicker"], compared["flicker"]["share_added"]);
}

#[test]
fn a_setting_that_is_beaten_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let out = folder.path().join("sweep");
    let ended = sweep(&film, &out, &["--thresholds", "2,4", "--json"]);
    let lines = settings(&ended);
    for line in &lines {
        let beaten = !line["beaten_by"].is_null();
        assert_eq!(line["on_front"], !beaten, "{line:#}");
        let told = line["why"].as_str().is_some_and(|why| why.len() > 20);
        let same = !line["same_plan_as"].is_null();
        assert_eq!(told, beaten || same, "{line:#}");
    }
    // The observer moves: whoever wants no error gets whole frames.
    let exact = lines.iter().find(|l| l["mode"] == "exact").unwrap();
    assert_eq!(exact["same_plan_as"], 1);
    assert_eq!(exact["fallback"], true);
    let why = exact["why"].as_str().unwrap();
    assert!(
        why.contains("every frame is rendered whole, because the observer moves"),
        "{why}"
    );
    // Within either threshold, everything stays in one décor.
    let four = lines
        .iter()
        .find(|l| l["name"] == "equivalent 4 px")
        .unwrap();
    assert_eq!(four["same_plan_as"], 3, "{four:#}");
    let markdown = sweep(&film, &out, &["--thresholds", "2,4"]).stdout;
    assert!(
        markdown.contains("What was measured of 3 (equivalent 2 px)"),
        "{markdown}"
    );
}

#[test]
fn what_is_finished_is_kept_and_the_same_report_comes_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let out = folder.path().join("sweep");
    let grid = ["--thresholds", "0.4", "--modes", "full,equivalent"];
    sweep(&film, &out, &grid);
    let first = made(&out);
    assert_eq!(first.len(), 3, "stock, full, equivalent");
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let (report, json) = (read("report.html"), read("sweep.json"));
    sweep(&film, &out, &grid);
    assert_eq!(made(&out), first, "nothing was made again");
    assert_eq!(read("report.html"), report);
    assert_eq!(read("sweep.json"), json);
    // More thresholds go on from there.
    let more = ["--thresholds", "0.2,0.4", "--modes", "full,equivalent"];
    sweep(&film, &out, &more);
    let then = made(&out);
    assert!(first.iter().all(|one| then.contains(one)));
    assert_eq!(then.len(), 4);
    // One that was interrupted has no note, and is made anew, alone.
    let victim = &first[1].0;
    std::fs::remove_file(victim).unwrap();
    sweep(&film, &out, &grid);
    let now = made(&out);
    let again: Vec<_> = now.iter().filter(|one| !then.contains(one)).collect();
    assert_eq!(again.len(), 1);
    assert_eq!(&again[0].0, victim);
}

#[test]
fn the_same_twice_but_for_times() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::contact(folder.path());
    let grid = ["--thresholds", "0.3,1", "--periods", "auto,4", "--json"];
    let run = |name: &str| {
        let ended = sweep(&film, &folder.path().join(name), &grid);
        let mut lines = settings(&ended);
        for line in &mut lines {
            let line = line.as_object_mut().unwrap();
            // Times, and what follows from them.
            for timed in [
                "wall_s",
                "cpu_s",
                "speedup_full",
                "on_front",
                "beaten_by",
                "why",
            ] {
                assert!(line.remove(timed).is_some(), "{timed}");
            }
            let speedup = line.remove("speedup").unwrap();
            line.insert("traced".into(), speedup["traced"].clone());
        }
        lines
    };
    assert_eq!(run("one"), run("two"));
}

#[test]
fn every_format() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let out = folder.path().join("sweep");
    let grid = ["--thresholds", "0.4", "--modes", "full,preview"];
    let print = |format: &str| {
        let extra = [&grid[..], &["--format", format]].concat();
        sweep(&film, &out, &extra).stdout
    };
    let markdown = print("markdown");
    assert!(
        markdown.contains("| 2 | **preview 0.4 px** |"),
        "{markdown}"
    );
    let csv = print("csv");
    let mut rows = csv::Reader::from_reader(csv.as_bytes());
    let modes: Vec<String> = rows
        .records()
        .map(|row| row.unwrap()[1].to_owned())
        .collect();
    assert_eq!(modes, ["full", "preview"]);
    let html = print("html");
    assert_eq!(
        html,
        std::fs::read_to_string(out.join("report.html")).unwrap()
    );
    // Nothing from anywhere else.
    for word in ["http://", "https://", "src=\"", "<link rel=\"stylesheet\""] {
        assert!(!html.contains(word), "{word}");
    }
    let json = print("json");
    let summary: Value = serde_json::from_str(json.lines().last().unwrap()).unwrap();
    assert_eq!(summary["type"], "summary");
    assert_eq!(summary["settings"], 2);
    assert!(summary["machine"]["cores"].as_u64().unwrap() > 0);
    // The classes object by object are in the file.
    let whole = std::fs::read_to_string(out.join("sweep.json")).unwrap();
    let whole: Value = serde_json::from_str(&whole).unwrap();
    let objects = whole["objects"].as_array().unwrap().len();
    let period = &whole["measured"][1]["periods"][0];
    assert_eq!(period["classes"].as_str().unwrap().len(), objects);
    assert!(
        period["classes"].as_str().unwrap().contains('s'),
        "{period}"
    );
}

#[test]
fn against_the_pool_and_without_antialiasing() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let text = std::fs::read_to_string(&film).unwrap();
    assert!(text.contains("*antialias off"));
    std::fs::write(&film, text.replace("*antialias off", "*antialias 0.1 3")).unwrap();
    let out = folder.path().join("sweep");
    let extra = [
        "--modes",
        "full",
        "--antialias",
        "as-is,off",
        "--against",
        "full",
        "--json",
    ];
    let lines = settings(&sweep(&film, &out, &extra));
    assert_eq!(lines.len(), 2);
    assert_eq!(number(&lines[0]["errors"]["max"]), 0.0);
    assert_eq!(number(&lines[0]["speedup"]["wall"]), 1.0);
    // Edges are jagged without.
    assert!(
        number(&lines[1]["errors"]["flip"]) > 0.001,
        "{:#}",
        lines[1]
    );
}

#[test]
fn wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    for args in [
        &["--thresholds", "1,x"][..],
        &["--thresholds", "-1"],
        &["--periods", "0"],
        &["--modes", "magic"],
        &["--runs", "0"],
    ] {
        let ended = Run::new(["sweep", "-o", "nowhere"])
            .arg(&film)
            .args(args)
            .ends();
        assert_eq!(ended.status, 64, "{args:?}: {}", ended.stderr);
    }
    let scene = common::fixture("unedited/orbit.ini");
    let ended = Run::new(["sweep", "-o", "nowhere"]).arg(scene).ends();
    assert_eq!(ended.status, 64, "{}", ended.stderr);
}
