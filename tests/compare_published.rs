//! FLIP, SSIM and PSNR against their published implementations: NVIDIA's
//! evaluator (`flip-evaluator`) and `scikit-image`, run here on the same pictures.
//!
//! Where Python lacks them they are installed, once, into a virtual environment
//! below Cargo's target folder. Where that is impossible the test fails.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use decor::compare::flip;
use decor::compare::seen::Seen;
use rand::rngs::StdRng;
use rand::{RngExt as _, SeedableRng as _};

/// Four digits: half a unit of the fourth is at least this part of a value.
const FOUR_DIGITS: f64 = 0.5e-4;

/// A single wrong pixel is a mean of very faint errors, of which the evaluator's
/// single precision leaves three digits.
const FAINT: (&str, f64) = ("one wrong pixel", 0.5e-3);

const PACKAGES: [&str; 2] = ["flip-evaluator>=1.7,<2", "scikit-image>=0.24,<1"];

/// A Python that has the packages.
fn python() -> PathBuf {
    let imports = |python: &Path| {
        let script = "import flip_evaluator, skimage.metrics";
        let output = Command::new(python).args(["-c", script]).output();
        output.is_ok_and(|output| output.status.success())
    };
    let system = PathBuf::from("python3");
    if imports(&system) {
        return system;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("published-metrics");
    let python = folder.join("bin/python");
    if !imports(&python) {
        // Whatever a stopped run left is made again.
        let mut venv = Command::new(&system);
        venv.args(["-m", "venv", "--clear"]).arg(&folder);
        succeeds(&mut venv, "Debian's python3-venv has it");
        let mut pip = Command::new(&python);
        pip.args(["-m", "pip", "install", "--quiet", "--no-input"])
            .args(PACKAGES);
        succeeds(&mut pip, "PyPI has to be in reach");
    }
    python
}

fn succeeds(command: &mut Command, help: &str) -> Output {
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?} does not start ({help}): {error}"));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?} ({help}):\n{stderr}");
    output
}

/// An RGB picture of 16 bits.
#[derive(Clone)]
struct Picture {
    width: u32,
    height: u32,
    values: Vec<[u16; 3]>,
}

impl Picture {
    fn new(width: u32, height: u32, value: impl Fn(u32, u32) -> [u16; 3]) -> Self {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let values = places.map(|(x, y)| value(x, y)).collect();
        Self {
            width,
            height,
            values,
        }
    }

    /// A picture of this repository, of 8 bits.
    fn documented(name: &str, width: u32, height: u32) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("docs")
            .join(name);
        let picture = image::open(path).unwrap().to_rgb8();
        assert!(picture.width() >= width && picture.height() >= height);
        Self::new(width, height, |x, y| {
            picture.get_pixel(x, y).0.map(|byte| u16::from(byte) * 257)
        })
    }

    /// Every value through `change`.
    fn changed(&self, mut change: impl FnMut(usize, u16) -> u16) -> Self {
        let mut other = self.clone();
        for (k, value) in other.values.as_flattened_mut().iter_mut().enumerate() {
            *value = change(k, *value);
        }
        other
    }

    fn write(&self, png: &Path, raw: &Path) {
        let bytes = |byte_order: fn(u16) -> [u8; 2]| -> Vec<u8> {
            let values = self.values.as_flattened().iter();
            values.flat_map(|&value| byte_order(value)).collect()
        };
        std::fs::write(raw, bytes(u16::to_le_bytes)).unwrap();
        let file = std::fs::File::create(png).unwrap();
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Sixteen);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&bytes(u16::to_be_bytes)).unwrap();
        writer.finish().unwrap();
    }
}

/// What films have, and what metrics find hard. (Not single steps of 16 bits: of
/// them the evaluator's single precision leaves FLIP three digits.)
fn pairs() -> Vec<(&'static str, Picture, Picture)> {
    let mut random = StdRng::seed_from_u64(7);
    let mut noise = |most: u16| {
        let random: Vec<u16> = (0..300_000)
            .map(|_| random.random_range(0..=most))
            .collect();
        move |k: usize| random[k % random.len()]
    };
    let ladybirds = Picture::documented("explain-ladybirds.png", 300, 210);
    let plane = Picture::documented("plane.png", 200, 140);
    let gradient = Picture::new(129, 131, |x, y| {
        [x as u16 * 500, y as u16 * 490, (x + y) as u16 * 240]
    });
    let grey = Picture::new(70, 60, |_, _| [100 * 257; 3]);
    let stripes = Picture::new(
        11,
        300,
        |_, y| if y / 3 % 2 == 0 { [0; 3] } else { [65535; 3] },
    );
    let (grain, other_grain) = (noise(65535), noise(65535));
    let noisy = Picture::new(65, 37, |_, _| [0; 3]).changed(|k, _| grain(k));
    let small_noise = noise(2000);
    let bit = noise(1);
    vec![
        (
            "a film's frame, some light more",
            ladybirds.clone(),
            ladybirds.changed(|_, value| value.saturating_add(value / 50)),
        ),
        (
            "a film's frame, moved by a pixel",
            ladybirds.clone(),
            Picture::new(300, 210, |x, y| {
                ladybirds.values[(y * 300 + x.saturating_sub(1)) as usize]
            }),
        ),
        (
            "a film's frame in 32 steps",
            plane.clone(),
            plane.changed(|_, value| value / 2048 * 2114),
        ),
        (
            "a frame and its mirror image",
            plane.clone(),
            Picture::new(200, 140, |x, y| plane.values[(y * 200 + 199 - x) as usize]),
        ),
        (
            "a gradient with noise",
            gradient.clone(),
            gradient.changed(|k, value| value.saturating_add(small_noise(k))),
        ),
        (
            "one step of 8 bits here and there",
            gradient.clone(),
            gradient.changed(|k, value| value + 257 * bit(k)),
        ),
        (
            "a wrong block",
            grey.clone(),
            grey.changed(|k, value| {
                let (x, y) = (k / 3 % 70, k / 3 / 70);
                let wrong = (30..42).contains(&x) && (20..32).contains(&y);
                if wrong { value + 8000 } else { value }
            }),
        ),
        (
            "noise and other noise",
            noisy.clone(),
            noisy.changed(|k, _| other_grain(k)),
        ),
        (
            "stripes and their negative, narrow",
            stripes.clone(),
            stripes.changed(|_, value| 65535 - value),
        ),
        (
            "green against blue, the farthest colours",
            Picture::new(64, 64, |_, _| [0, 65535, 0]),
            Picture::new(64, 64, |_, _| [0, 0, 65535]),
        ),
        // The last one is not of the ten: see `FAINT`.
        (
            "one wrong pixel",
            grey.clone(),
            grey.changed(|k, value| if k / 3 == 31 * 70 + 40 { 65535 } else { value }),
        ),
    ]
}

#[test]
fn flip_ssim_and_psnr_are_those_of_the_published_implementations() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: String| folder.path().join(name);
    let pairs = pairs();
    assert_eq!(pairs.len(), 10 + 1);
    let mut questions = String::new();
    for side in ["a", "b"] {
        std::fs::create_dir(at(side.to_owned())).unwrap();
    }
    for (k, (_, a, b)) in pairs.iter().enumerate() {
        let mut question = serde_json::json!({
            "width": a.width,
            "height": a.height,
            "map": at(format!("{k}.map")).to_str().unwrap(),
        });
        for (side, picture) in [("a", a), ("b", b)] {
            let raw = at(format!("{k}.{side}"));
            picture.write(&at(format!("{side}/{k:02}.png")), &raw);
            question[side] = raw.to_str().unwrap().into();
        }
        questions += &format!("{question}\n");
    }

    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compare_published/measure.py");
    let mut published = Command::new(python())
        .arg(script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    published
        .stdin
        .take()
        .unwrap()
        .write_all(questions.as_bytes())
        .unwrap();
    let published = lines(&published.wait_with_output().unwrap());
    assert_eq!(published.len(), pairs.len());

    let ours = assert_cmd::Command::cargo_bin("decor")
        .unwrap()
        .current_dir(folder.path())
        .args(["compare", "a", "b", "--json"])
        .output()
        .unwrap();
    let ours = lines(&ours);
    for (k, (name, _, _)) in pairs.iter().enumerate() {
        assert!((published[k]["ppd"].as_f64().unwrap() - 67.020_643).abs() < 1e-5);
        for metric in ["flip", "ssim", "psnr"] {
            let (ours, theirs) = (&ours[k][metric], &published[k][metric]);
            println!("{name}: {metric}: {ours}, published {theirs}");
            let (ours, theirs) = (ours.as_f64().unwrap(), theirs.as_f64().unwrap());
            let digits = if *name == FAINT.0 {
                FAINT.1
            } else {
                FOUR_DIGITS
            };
            assert!(
                (ours - theirs).abs() <= digits * theirs.abs(),
                "{name}: {metric} is {ours}, published {theirs}"
            );
        }
        // The evaluator's own mean, as far as it has digits.
        let quoted = published[k]["quoted_flip"].as_f64().unwrap();
        assert!((ours[k]["flip"].as_f64().unwrap() / quoted - 1.0).abs() < 1e-3);

        let map = std::fs::read(at(format!("{k}.map"))).unwrap();
        let published = map.chunks_exact(4).map(|bytes| {
            let bytes: [u8; 4] = bytes.try_into().unwrap();
            f32::from_le_bytes(bytes)
        });
        let read =
            |side: &str| decor::compare::picture::Picture::read(&at(format!("{side}/{k:02}.png")));
        let seen = Seen::new(&read("a").unwrap(), &read("b").unwrap(), None).unwrap();
        let map = flip::map(&seen, flip::PIXELS_PER_DEGREE);
        assert_eq!(map.len(), published.len());
        let farthest = map.iter().zip(published).map(|(a, b)| (a - b).abs());
        let farthest = farthest.fold(0.0, f32::max);
        println!("{name}: flip: the pixels are within {farthest}");
        assert!(
            farthest < 2e-4,
            "{name}: a pixel of the map is off by {farthest}"
        );
    }
}

fn lines(output: &Output) -> Vec<serde_json::Value> {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let read = |line: &str| serde_json::from_str(line).unwrap();
    text.lines().map(read).collect()
}
