//! From two paths to a verdict.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::super::folders::{Match, PairingError, Side, pair};
use super::super::verdict::{Limit, Tolerances, Verdict};
use super::super::{CompareError, Comparison, Entry, Options, compare, report, words};
use super::{write_float, write_png, write_rgb};

/// Two folders, `a` and `b`.
struct Folders {
    _root: TempDir,
    a: PathBuf,
    b: PathBuf,
}

impl Folders {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let (a, b) = (root.path().join("a"), root.path().join("b"));
        fs::create_dir(&a).unwrap();
        fs::create_dir(&b).unwrap();
        Self { _root: root, a, b }
    }

    /// Four equal frames of 4 × 3 in both.
    fn of_frames() -> Self {
        let folders = Self::new();
        for k in 0..4 {
            for side in [&folders.a, &folders.b] {
                write_rgb(&frame(side, k), (4, 3), &grey());
            }
        }
        folders
    }

    fn compare(&self, options: &Options) -> Comparison {
        compare(&self.a, &self.b, options, |_| {}).unwrap()
    }

    fn strictly(&self) -> Comparison {
        self.compare(&Options::default())
    }
}

fn frame(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("frame_{number:04}.png"))
}

fn grey() -> Vec<u8> {
    vec![100; 36]
}

fn pair_of<'a>(comparison: &'a Comparison, name: &str) -> &'a super::super::pair::PairReport {
    let found = comparison.entries.iter().find_map(|entry| match entry {
        Entry::Pair(pair) if pair.name == name => Some(&**pair),
        _ => None,
    });
    found.unwrap()
}

#[test]
fn equal_folders_are_identical() {
    let comparison = Folders::of_frames().strictly();
    assert_eq!(comparison.verdict, Verdict::Within);
    assert_eq!(
        (comparison.totals.frames(), comparison.totals.identical),
        (4, 4)
    );
    assert_eq!(comparison.totals.worst, None);
    let mut text = Vec::new();
    words::write(&comparison, &mut text).unwrap();
    assert_eq!(
        String::from_utf8(text).unwrap(),
        "identical: 4\nwithin: 4 pairs, 4 within, identical\n"
    );
}

#[test]
fn one_wrong_pixel_is_found_by_name_and_place() {
    let folders = Folders::of_frames();
    let mut bytes = grey();
    bytes[3 * (4 + 2) + 2] = 110;
    write_rgb(&frame(&folders.b, 2), (4, 3), &bytes);
    let comparison = folders.strictly();
    assert_eq!(comparison.verdict, Verdict::Failed);
    let worst = &comparison.entries[comparison.totals.worst.unwrap()];
    assert_eq!(worst.name(), "frame_0002.png");
    let place = pair_of(&comparison, "frame_0002.png")
        .metrics
        .as_ref()
        .unwrap()
        .largest;
    let place = place.unwrap();
    assert_eq!((place.x, place.y, place.channel.name()), (2, 1, "B"));
    assert_eq!((place.a, place.b), (100.0 / 255.0, 110.0 / 255.0));
    let summary =
        report::summary_line(&folders.a, &folders.b, &comparison, &Tolerances::default()).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["type"], "summary");
    assert_eq!(summary["worst"]["name"], "frame_0002.png");
    assert_eq!(summary["worst"]["largest"]["x"], 2);
    assert_eq!(
        (&summary["failed"], &summary["within"]),
        (&1.into(), &3.into())
    );
    assert_eq!(summary["differing"], 1);
}

#[test]
fn a_missing_frame_fails_and_is_named() {
    let folders = Folders::of_frames();
    fs::remove_file(frame(&folders.b, 1)).unwrap();
    fs::remove_file(frame(&folders.a, 3)).unwrap();
    let comparison = folders.strictly();
    assert_eq!(comparison.verdict, Verdict::Failed);
    assert_eq!(comparison.totals.missing_from_b, ["frame_0001.png"]);
    assert_eq!(comparison.totals.missing_from_a, ["frame_0003.png"]);
    let line = report::entry_line(&comparison.entries[1], &Tolerances::default()).unwrap();
    assert_eq!(
        line,
        r#"{"type":"missing","name":"frame_0001.png","missing_from":"b","verdict":"failed"}"#
    );
}

#[test]
fn different_sizes_are_not_comparable_and_damage_is_unreadable() {
    let folders = Folders::of_frames();
    write_rgb(&frame(&folders.b, 0), (3, 4), &grey());
    let comparison = folders.strictly();
    assert_eq!(comparison.verdict, Verdict::NotComparable);
    let pair = pair_of(&comparison, "frame_0000.png");
    assert_eq!(pair.reasons, ["A has 4×3 pixels, B has 3×4"]);
    let line = report::entry_line(&comparison.entries[0], &Tolerances::default()).unwrap();
    let line: serde_json::Value = serde_json::from_str(&line).unwrap();
    assert_eq!(line["verdict"], "not-comparable");
    assert!(line["max"].is_null());

    fs::write(frame(&folders.a, 3), b"\x89PNG and no more").unwrap();
    let comparison = folders.strictly();
    assert_eq!(comparison.verdict, Verdict::Unreadable);
    assert_eq!(comparison.totals.pairs, [2, 0, 0, 1, 1]);
    assert_eq!(
        comparison.totals.worst, None,
        "no pair with numbers differs"
    );
    let reason = &pair_of(&comparison, "frame_0003.png").reasons[0];
    assert!(
        reason.contains("frame_0003.png: it is no whole PNG"),
        "{reason}"
    );
}

#[test]
fn swapped_depth_is_found_where_the_colour_is_equal() {
    let folders = Folders::new();
    let (a, b) = (folders.a.join("f.exr"), folders.b.join("f.exr"));
    write_float(&a, (2, 1), &[0.5; 2], Some(&[2.0, 8.0]));
    write_float(&b, (2, 1), &[0.5; 2], Some(&[8.0, 2.0]));
    let comparison = folders.strictly();
    assert_eq!(comparison.verdict, Verdict::Failed);
    let metrics = pair_of(&comparison, "f.exr").metrics.as_ref().unwrap();
    assert_eq!(metrics.unequal, 0);
    let depth = metrics.depth.as_ref().unwrap();
    assert_eq!((depth.max_absolute, depth.max_relative), (6.0, 0.75));
    let verdict = |fail_depth: f64| {
        let tolerances = Tolerances {
            fail_depth,
            ..Tolerances::default()
        };
        let options = Options {
            tolerances,
            ..Options::default()
        };
        folders.compare(&options).verdict
    };
    assert_eq!(verdict(0.74), Verdict::Failed);
    assert_eq!(verdict(0.75), Verdict::Within);
    write_float(&b, (2, 1), &[0.5; 2], Some(&[2.0, f32::INFINITY]));
    assert_eq!(verdict(1e9), Verdict::Failed, "a surface is not nothing");
    assert_eq!(verdict(f64::INFINITY), Verdict::Within);
}

#[test]
fn eight_bits_equal_the_same_sixteen() {
    let folders = Folders::new();
    let all: Vec<u8> = (0..=255).cycle().take(768).collect();
    write_rgb(&folders.a.join("f.png"), (16, 16), &all);
    let doubled: Vec<u8> = all.iter().flat_map(|&byte| [byte, byte]).collect();
    let sixteen = (png::ColorType::Rgb, png::BitDepth::Sixteen);
    write_png(&folders.b.join("f.png"), (16, 16), sixteen, &doubled);
    let comparison = folders.strictly();
    assert_eq!(comparison.verdict, Verdict::Within);
    let pair = pair_of(&comparison, "f.png");
    assert!(pair.identical());
    assert!(
        pair.notes[0].starts_with("8 bits against 16"),
        "{:?}",
        pair.notes
    );
    // One step of 16 bits is not lost.
    let mut doubled = doubled;
    doubled[1] = 1;
    write_png(&folders.b.join("f.png"), (16, 16), sixteen, &doubled);
    let metrics = folders.strictly().totals;
    assert_eq!((metrics.max, metrics.unequal), (1.0 / 65535.0, 1));
}

#[test]
fn png_against_exr_is_compared_as_seen() {
    let folders = Folders::new();
    write_rgb(&folders.a.join("f_1.png"), (1, 1), &[128; 3]);
    // sRGB 128 is 0.2158605 linear.
    write_float(&folders.b.join("f_1.exr"), (1, 1), &[0.215_860_5], None);
    let comparison = folders.strictly();
    let pair = pair_of(&comparison, "f_1.png");
    assert!(pair.metrics.as_ref().unwrap().max < 1e-6);
    assert!(
        pair.notes
            .iter()
            .any(|note| note.starts_with("B is linear"))
    );
}

#[test]
fn pairing_by_name_then_by_stem() {
    let folders = Folders::new();
    let touch = |folder: &Path, names: &[&str]| {
        for name in names {
            fs::write(folder.join(name), "").unwrap();
        }
    };
    touch(
        &folders.a,
        &["1.png", "2.png", "3.png", "3.exr", "4.PNG", "decor.json"],
    );
    touch(
        &folders.b,
        &["1.png", "2.exr", "3.PNG", "4.exr", "5.exr", ".x.part"],
    );
    fs::create_dir(folders.b.join("folder.png")).unwrap();
    let shown: Vec<String> = pair(&folders.a, &folders.b)
        .unwrap()
        .into_iter()
        .map(|one| match one {
            Match::Pair { a, b, .. } => {
                let name = |path: PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
                format!("{} = {}", name(a), name(b))
            }
            Match::Missing { name, from } => format!("{name} not in {}", from.letter()),
        })
        .collect();
    assert_eq!(
        shown,
        [
            "1.png = 1.png",
            "2.png = 2.exr",
            "3.PNG not in A",
            "3.exr not in B",
            "3.png not in B",
            "4.PNG = 4.exr",
            "5.exr not in A",
        ]
    );
}

#[test]
fn nothing_to_compare() {
    let folders = Folders::of_frames();
    let empty = folders.a.join("empty");
    fs::create_dir(&empty).unwrap();
    assert!(matches!(
        pair(&empty, &folders.b),
        Err(PairingError::Empty { .. })
    ));
    let verdict = |a: &Path, b: &Path| compare(a, b, &Options::default(), |_| {}).unwrap().verdict;
    assert_eq!(verdict(&empty, &folders.b), Verdict::NotComparable);
    assert_eq!(
        verdict(&frame(&folders.a, 0), &folders.b),
        Verdict::NotComparable
    );
    assert_eq!(
        verdict(&folders.a.join("none"), &folders.b),
        Verdict::Unreadable
    );
}

#[test]
fn tolerances_as_of_idiff() {
    let folders = Folders::of_frames();
    // Of 12 pixels one is wrong by 10 steps, one by 2.
    let mut bytes = grey();
    bytes[0] = 110;
    bytes[3] = 102;
    write_rgb(&frame(&folders.b, 0), (4, 3), &bytes);
    let step = |steps: f64| steps / 255.0;
    let limit = |steps: f64, percent: f64| Limit {
        level: step(steps),
        percent,
    };
    let judged = |fail, hard_fail, warn, hard_warn| {
        let tolerances = Tolerances {
            fail,
            hard_fail,
            warn,
            hard_warn,
            ..Tolerances::default()
        };
        let options = Options {
            tolerances,
            ..Options::default()
        };
        folders.compare(&options).verdict
    };
    use Verdict::{Failed, Warning, Within};
    assert_eq!(judged(limit(9.0, 0.0), None, None, None), Failed);
    assert_eq!(judged(limit(10.0, 0.0), None, None, None), Within);
    assert_eq!(judged(limit(1.0, 16.0), None, None, None), Failed);
    assert_eq!(judged(limit(1.0, 17.0), None, None, None), Within);
    assert_eq!(
        judged(limit(1.0, 17.0), Some(step(9.0)), None, None),
        Failed
    );
    assert_eq!(
        judged(limit(1.0, 17.0), Some(step(10.0)), None, None),
        Within
    );
    assert_eq!(
        judged(limit(10.0, 0.0), None, Some(limit(1.0, 0.0)), None),
        Warning
    );
    assert_eq!(
        judged(limit(10.0, 0.0), None, Some(limit(1.0, 17.0)), None),
        Within
    );
    assert_eq!(
        judged(limit(10.0, 0.0), None, None, Some(step(5.0))),
        Warning
    );
    assert_eq!(
        judged(limit(9.0, 0.0), None, Some(limit(1.0, 0.0)), None),
        Failed
    );
}

#[test]
fn the_films_numbers_are_those_of_all_pixels() {
    let folders = Folders::new();
    // 1 pixel wrong by the whole range, 3 right: mean square 1/4.
    write_rgb(&folders.a.join("1.png"), (1, 1), &[0; 3]);
    write_rgb(&folders.b.join("1.png"), (1, 1), &[255; 3]);
    write_rgb(&folders.a.join("2.png"), (3, 1), &[7; 9]);
    write_rgb(&folders.b.join("2.png"), (3, 1), &[7; 9]);
    let totals = folders.strictly().totals;
    assert_eq!(
        (totals.pixels, totals.rms(), totals.share_above()),
        (4, 0.5, 0.25)
    );
    assert!((totals.psnr() - 6.020_599_913_279_624).abs() < 1e-12);
}

#[test]
fn difference_pictures_are_three_panels() {
    let folders = Folders::of_frames();
    let mut bytes = grey();
    bytes[0] = 103;
    write_rgb(&frame(&folders.b, 1), (4, 3), &bytes);
    let diff = folders.b.join("diff");
    let options = Options {
        diff: Some(diff.clone()),
        ..Options::default()
    };
    let comparison = folders.compare(&options);
    assert!(comparison.diff_error.is_none());
    let path = diff.join("frame_0001.diff.png");
    assert_eq!(
        pair_of(&comparison, "frame_0001.png").diff.as_deref(),
        Some(&*path)
    );
    let picture = super::Picture::read(&path).unwrap();
    assert_eq!(
        (picture.size.width, picture.size.height),
        (4 + 2 + 4 + 2 + 4, 3)
    );
    let value = |x: usize| picture.values[x].map(|v| (v * 255.0).round() as u8);
    assert_eq!(value(0), [100, 100, 100, 255]);
    assert_eq!(value(6), [103, 100, 100, 255]);
    assert_eq!(value(12), [48, 0, 0, 255]);
    assert_eq!(value(13), [0, 0, 0, 255]);
    assert_eq!(fs::read_dir(&diff).unwrap().count(), 4);
}

#[test]
fn difference_pictures_are_not_put_among_frames() {
    let folders = Folders::of_frames();
    let options = Options {
        diff: Some(folders.a.join(".")),
        ..Options::default()
    };
    let result = compare(&folders.a, &folders.b, &options, |_| {});
    assert!(matches!(result, Err(CompareError::DiffAmongFrames { .. })));
    // Beside two files they may lie, but not replace one.
    let beside = |b: &str| {
        let b = folders.a.join(b);
        write_rgb(&b, (4, 3), &grey());
        compare(&frame(&folders.a, 0), &b, &options, |_| {}).is_ok()
    };
    assert!(beside("other.png"));
    assert!(!beside("frame_0000.diff.png"));
}

#[test]
fn numbers_that_json_lacks_are_words() {
    let folders = Folders::new();
    write_float(&folders.a.join("f.exr"), (1, 1), &[f32::NAN], None);
    write_float(&folders.b.join("f.exr"), (1, 1), &[0.1], None);
    let comparison = folders.strictly();
    let line = report::entry_line(&comparison.entries[0], &Tolerances::default()).unwrap();
    let line: serde_json::Value = serde_json::from_str(&line).unwrap();
    assert_eq!(line["max"], "inf");
    assert_eq!(
        (&line["largest"]["a"], &line["largest"]["b"]),
        (&"nan".into(), &0.1.into())
    );
    assert_eq!((&line["rms"], &line["psnr"]), (&1.0.into(), &0.0.into()));
    assert_eq!(line["not_finite"], 1);
    assert_eq!(comparison.entries[0].verdict(), Verdict::Failed);
    assert_eq!(Side::A.letter(), 'A');
}
