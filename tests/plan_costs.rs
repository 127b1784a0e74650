//! What a plan is said to cost: counts that come true, probes that are kept, and
//! seconds that are near the truth.

mod common;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use common::{Run, fixture};
use decor::film;
use decor::objects::Cache;
use decor::plan::{Costs, CostsFrom, Mode, Wishes, Work, plan, whole_work};
use decor::probe;
use decor::segmentation::Measure;
use decor::stage::Stage;
use decor_api::RunContext;
use serde_json::Value;

/// A call with a cache of its own.
fn decor(cache: &Path, args: &[&str], film: &Path) -> Value {
    Run::new(args)
        .arg(film)
        .env("DECOR_CACHE", cache)
        .succeeds()
        .summary()
}

/// The bundled cloud, smaller, with an observer who moves slowly.
fn ladybirds(folder: &Path, frames: u32) -> PathBuf {
    let source = fixture("ladybirds");
    let text = std::fs::read_to_string(source.join("ladybirds.anim")).unwrap();
    let text = text
        .replace("*size 320 240", "*size 160 120")
        .replace("*images 25", &format!("*images {frames}"))
        .replace("*eye 0 0 -40  0 0 4", "*eye 0 0 -40  0 0 0.2")
        .replace("*aim 0 0 60  0 0 4", "*aim 0 0 60  0 0 0.2");
    std::fs::copy(source.join("ladybird.ron"), folder.join("ladybird.ron")).unwrap();
    let path = folder.join("slow.anim");
    std::fs::write(&path, text).unwrap();
    path
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(0.0)
}

#[test]
fn what_is_counted_is_what_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let slow = ladybirds(folder.path(), 6);
    let cases: [(&Path, &[&str]); 5] = [
        (&fixture("contact/contact.anim"), &["--mode", "exact"]),
        (&fixture("contact/contact.anim"), &["--mode", "preview"]),
        (&fixture("contact/contact.anim"), &["--mode", "full"]),
        (&slow, &["--period", "3"]),
        (
            &slow,
            &["--period", "4", "--threshold", "0.1", "--no-fallback"],
        ),
    ];
    for (film, wishes) in cases {
        let with = |verb: &[&'static str]| -> Vec<String> {
            let words = verb
                .iter()
                .copied()
                .chain(["--renderer", "reference", "--json"]);
            words
                .chain(wishes.iter().copied())
                .map(str::to_owned)
                .collect()
        };
        let out = tempfile::tempdir().unwrap();
        let planned = Run::new(with(&["plan"])).arg(film).succeeds().summary();
        let done = Run::new(with(&["render"]))
            .arg(film)
            .arg("-o")
            .arg(out.path())
            .succeeds()
            .summary();
        let passes = |names: &[&str], what: &str| -> f64 {
            names
                .iter()
                .map(|name| number(&planned["passes"][*name][what]))
                .sum()
        };
        let traced = |pass: &str| number(&done["pixels_traced"][pass]);
        let case = format!("{} {wishes:?}", film.display());
        // What a décor dissolves into is one picture more at most: how much of it
        // the next décor shows too is found out when both are rendered.
        let periods = done["periods"].as_array().unwrap().iter();
        let dissolving = periods.filter(|p| !p["dissolves_until"].is_null()).count();
        let targets = dissolving as f64 * number(&done["width"]) * number(&done["height"]);
        let near = |planned: f64, traced: f64| {
            assert!(
                (planned..=planned + targets).contains(&traced),
                "{case}: {planned} planned, {traced} traced, {targets} of targets"
            );
        };
        near(passes(&["decor"], "pixels"), traced("decor"));
        assert_eq!(passes(&["fast"], "pixels"), traced("fast"), "{case}");
        assert_eq!(passes(&["blocks"], "pixels"), traced("blocks"), "{case}");
        assert_eq!(passes(&["whole"], "pixels"), traced("whole"), "{case}");
        let depths = ["decor_depth", "fast_depth", "whole_depth"];
        near(passes(&depths, "pixels"), traced("depth"));
        let all = ["decor", "fast", "blocks", "whole"];
        let pictures = passes(&all, "pictures") + passes(&depths, "pictures");
        let drawn = number(&done["renderer_frames"]);
        let most = pictures + 2.0 * dissolving as f64;
        assert!((pictures..=most).contains(&drawn), "{case}: {drawn}");
        let covered = passes(&all, "covered");
        assert!(covered > 0.0 && covered < passes(&all, "pixels"), "{case}");
    }
}

#[test]
fn a_probe_is_kept_until_the_film_changes() {
    let (cache, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let film = ladybirds(folder.path(), 5);
    let plan = |more: &[&str]| {
        let args: Vec<&str> = ["plan", "--json"].iter().chain(more).copied().collect();
        decor(cache.path(), &args, &film)
    };
    let before = plan(&[]);
    assert_eq!(before["costs"], "built-in");
    let probed = plan(&["--probe"]);
    assert_eq!(probed["costs"], "probe");
    assert!(number(&probed["probe_wall_s"]) > 0.0 && number(&probed["probe_cpu_s"]) > 0.0);
    for more in [&[][..], &["--probe"]] {
        let after = plan(more);
        assert_eq!(after["costs"], "cached");
        assert_eq!(after["probe_wall_s"], 0.0);
        for key in ["predicted_wall_s", "baseline_wall_s", "baseline_cpu_s"] {
            let (a, b) = (number(&after[key]), number(&probed[key]));
            assert!((a / b - 1.0).abs() < 1e-9, "{key}: {a} and {b}");
        }
    }
    let text = std::fs::read_to_string(&film).unwrap();
    std::fs::write(&film, text.replace("*size 160 120", "*size 160 128")).unwrap();
    assert_eq!(plan(&[])["costs"], "built-in");
}

/// CPU time, and with room: other tests run beside this one. How near the
/// prediction really is, is measured by `scripts/cost-report`.
#[test]
fn predicted_cpu_time_is_near_the_truth() {
    let (cache, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let film = ladybirds(folder.path(), 24);
    for period in ["3", "12"] {
        let wishes = ["--json", "--no-fallback", "--period", period];
        let args: Vec<&str> = ["plan", "--probe"].iter().chain(&wishes).copied().collect();
        let planned = decor(cache.path(), &args, &film);
        let out = tempfile::tempdir().unwrap();
        let done = Run::new(["render"].iter().chain(&wishes))
            .arg(&film)
            .arg("-o")
            .arg(out.path())
            .succeeds()
            .summary();
        let ratio = number(&planned["predicted_cpu_s"]) / number(&done["cpu_s"]);
        assert!((0.5..2.0).contains(&ratio), "period {period}: {ratio}");
    }
}

/// A stage for the in-process renderer.
fn stage(path: &Path) -> Stage {
    let film = film::read(path, false).unwrap();
    let adapter = decor::renderers::find("reference").unwrap();
    let work = tempfile::tempdir().unwrap();
    let run = RunContext::new(work.path());
    Stage::set(film, adapter, false, &Cache::disabled(), &run).unwrap()
}

fn wishes(stage: &Stage) -> Wishes {
    Wishes {
        mode: Mode::Equivalent,
        threshold_px: 1.0,
        measure: Measure::Bound,
        period: None,
        budget: None,
        shadow_way: decor::plan::ShadowWay::Auto,
        frames: (*stage.film.frames().start(), *stage.film.frames().end()),
        with_depth: false,
        fallback: true,
    }
}

#[test]
fn a_renderer_in_process_is_probed_too() {
    let folder = tempfile::tempdir().unwrap();
    let stage = stage(&ladybirds(folder.path(), 8));
    let plan = plan(&stage, wishes(&stage), &Costs::default()).unwrap();
    let cache = Cache::in_folder(folder.path().join("cache"));
    assert_eq!(probe::known(&stage, &cache).from, CostsFrom::BuiltIn);
    let run = RunContext::new(folder.path());
    let probed = probe::probe(&stage, &plan, &cache, &run).unwrap();
    assert_eq!(probed.from, CostsFrom::Probe);
    assert_eq!(probed.costs.call_sleep_s, 0.0);
    assert!(probed.costs.colour.of(1.0, 0.5) > 0.0);
    assert!(probed.price.wall_s > 0.0);
    let kept = probe::known(&stage, &cache);
    assert_eq!((kept.from, kept.costs), (CostsFrom::Cached, probed.costs));
    assert_eq!(Arc::strong_count(&run.cancel), 1, "a call is still there");
}

#[test]
fn long_films_are_worth_a_probe_and_short_ones_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let short = stage(&ladybirds(folder.path(), 5));
    assert!(!probe::worth_probing(&short, &wishes(&short)));
    let path = ladybirds(folder.path(), 5000);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("*size 160 120", "*size 640 480")).unwrap();
    let long = stage(&path);
    assert!(probe::worth_probing(&long, &wishes(&long)));
}

#[test]
fn what_a_probe_reads_is_a_part_of_its_price() {
    let folder = tempfile::tempdir().unwrap();
    let crowd = |frames| {
        let path = ladybirds(folder.path(), frames);
        let mut text = std::fs::read_to_string(&path).unwrap();
        let places = (0..20_000).map(|k| (k % 200 - 100, k / 200));
        text.extend(places.map(|(x, z)| format!("!ladybird.ron {x} -9 {z} 0 0 0\n")));
        std::fs::write(&path, text).unwrap();
        stage(&path)
    };
    // A second a frame, and eight to read the scene for the probe's pictures.
    let short = crowd(20);
    assert!(!probe::worth_probing(&short, &wishes(&short)));
    let long = crowd(1000);
    assert!(probe::worth_probing(&long, &wishes(&long)));
}

#[test]
fn the_longer_the_film_the_more_it_costs() {
    let folder = tempfile::tempdir().unwrap();
    let stage = stage(&ladybirds(folder.path(), 40));
    let costs = Costs::default();
    let price = |frames: (u32, u32)| {
        let wishes = Wishes {
            frames,
            ..wishes(&stage)
        };
        let works = plan(&stage, wishes.clone(), &Costs::default())
            .unwrap()
            .works(&stage);
        let sum: decor::plan::Price = costs.film(&works, 8, 2).into_iter().sum();
        let stock = costs.stock(&whole_work(&stage, &wishes), 2);
        (sum, stock)
    };
    let (short, short_stock) = price((0, 9));
    let (long, long_stock) = price((0, 39));
    assert!(long.cpu_s > 3.0 * short.cpu_s && long.wall_s > short.wall_s);
    assert!(long_stock.cpu_s > 3.5 * short_stock.cpu_s);
    let of = |work: Work| work.totals().iter().map(|(_, t)| t.pixels).sum::<f64>();
    assert_eq!(
        of(whole_work(&stage, &wishes(&stage))),
        40.0 * 160.0 * 120.0
    );
}
