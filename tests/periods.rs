//! Periods under a moving observer, rendered: what happens at the joints.

mod common;

use std::path::{Path, PathBuf};

use common::{Run, differing_pixels};

/// The bundled cloud of ladybirds at another speed and size.
fn ladybirds(folder: &Path, speed: f64, frames: u32, size: (u32, u32)) -> PathBuf {
    let text = std::fs::read_to_string(common::fixture("ladybirds/ladybirds.anim")).unwrap();
    let path = folder.join("ladybirds.anim");
    let edited: Vec<String> = text
        .lines()
        .map(|line| match line.split(' ').next() {
            Some("*size") => format!("*size {} {}", size.0, size.1),
            Some("*images") => format!("*images {frames}"),
            Some("*eye") => format!("*eye 0 0 -40 0 0 {speed}"),
            Some("*aim") => format!("*aim 0 0 60 0 0 {speed}"),
            _ => line.to_owned(),
        })
        .collect();
    std::fs::write(&path, edited.join("\n")).unwrap();
    std::fs::copy(
        common::fixture("ladybirds/ladybird.ron"),
        folder.join("ladybird.ron"),
    )
    .unwrap();
    path
}

fn render(film: &Path, out: &Path, options: &[&str]) -> serde_json::Value {
    Run::new(["render"])
        .arg(film)
        .args(["--json", "-o"])
        .arg(out)
        .args(options)
        .succeeds()
        .summary()
}

fn frame(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("frame_{number:04}.png"))
}

#[test]
fn the_joint_of_two_decors_is_dissolved() {
    let folder = tempfile::tempdir().unwrap();
    let film = ladybirds(folder.path(), 0.02, 60, (160, 128));
    let (soft, hard) = (folder.path().join("soft"), folder.path().join("hard"));
    let common = ["--threshold", "1", "--period", "20", "--no-fallback"];
    let summary = render(&film, &soft, &common);
    // Preview is the plain merge of the same décors.
    render(
        &film,
        &hard,
        &[&common[..], &["--mode", "preview"]].concat(),
    );
    for period in summary["periods"].as_array().unwrap() {
        // Every pixel is the décors'.
        assert_eq!(period["objects"]["fast"], 0, "{period}");
        assert!(period["objects"]["slow"].as_u64().unwrap() > 50, "{period}");
    }
    let jump =
        |out: &Path, number| differing_pixels(&frame(out, number), &frame(out, number + 1)).len();
    for joint in [19, 39] {
        let (soft, hard) = (jump(&soft, joint), jump(&hard, joint));
        println!("joint at {joint}: {soft} pixels change, {hard} without the dissolve");
        assert!(
            hard > 200,
            "nothing happens at {joint}: the test shows nothing"
        );
        assert!(soft * 10 <= hard, "{soft} of {hard} pixels at {joint}");
    }
    // Both show the décors' own pictures.
    for number in [0, 20, 40] {
        assert_eq!(
            differing_pixels(&frame(&soft, number), &frame(&hard, number)),
            []
        );
    }
    // And between, about as many pixels change in every frame.
    let jumps: Vec<usize> = (0..40).map(|n| jump(&soft, n)).collect();
    let (least, most) = (jumps.iter().min().unwrap(), jumps.iter().max().unwrap());
    println!("{least} to {most} pixels change from frame to frame");
    assert!(*most < 3 * least.max(&5), "{jumps:?}");
}

#[test]
fn the_order_of_a_dissolve_is_the_seed_s() {
    let folder = tempfile::tempdir().unwrap();
    let film = ladybirds(folder.path(), 0.02, 12, (80, 64));
    let common = ["--period", "8", "--no-fallback"];
    let of = |name: &str, extra: &[&str]| {
        let out = folder.path().join(name);
        render(&film, &out, &[&common[..], extra].concat());
        (0..12)
            .map(|n| std::fs::read(frame(&out, n)).unwrap())
            .collect::<Vec<_>>()
    };
    let once = of("once", &["--jobs", "1"]);
    assert!(once == of("again", &["--jobs", "7"]));
    let other = of("other", &["--seed", "1"]);
    assert!(once != other);
    assert!(once[0] == other[0] && once[8] == other[8]);
}

#[test]
fn nothing_slow_is_what_threshold_0_means() {
    let folder = tempfile::tempdir().unwrap();
    let film = common::fixture("contact/contact.anim");
    let (zero, exact) = (folder.path().join("zero"), folder.path().join("exact"));
    let common = ["--frames", "0-7", "--no-fallback", "--format", "png16"];
    render(&film, &zero, &[&common[..], &["--threshold", "0"]].concat());
    render(&film, &exact, &[&common[..], &["--mode", "exact"]].concat());
    for number in 0..8 {
        let file = |out: &Path| std::fs::read(frame(out, number)).unwrap();
        assert!(file(&zero) == file(&exact), "frame {number}");
    }
}

/// A cockpit that turns with its pilot before a sky: the sky moves and the
/// cockpit does not.
#[test]
fn a_sky_moves_by_the_observer_s_rotation() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("cockpit.inc"),
        "// bounds: 0 0 5 4\n\
         difference { box { <-2, -1.5, 4.9>, <2, 1.5, 5.1> } box { <-1.5, -1, 4>, <1.5, 1, 6> }\n\
         pigment { rgb <0.3, 0.5, 0.2> } finish { ambient 0 diffuse 0 emission 1 } }\n",
    )
    .unwrap();
    std::fs::write(
        folder.path().join("sky.inc"),
        "sky_sphere { pigment { gradient x color_map { [0 rgb <0.1, 0.2, 0.9>] \
         [0.5 rgb <0.9, 0.4, 0.1>] [1 rgb <0.1, 0.2, 0.9>] } scale 0.2 } }\n",
    )
    .unwrap();
    let film = |degrees: f64| {
        let mut text = String::from("*size 96 64\n*angles 60 40\n*sky sky.inc\n");
        for number in 0..6 {
            let angle = degrees * f64::from(number);
            let (sin, cos) = angle.to_radians().sin_cos();
            text += &format!(
                "@{number}\n*eye 0 0 0\n*aim {sin} 0 {cos}\n!cockpit.inc 0 0 0 0 {angle} 0\n"
            );
        }
        let path = folder.path().join(format!("film_{degrees}.anim"));
        std::fs::write(&path, text).unwrap();
        path
    };
    for (degrees, kept) in [(3.0, false), (0.01, true)] {
        let path = film(degrees);
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        let summary = render(&path, &ours, &["--no-fallback", "--period", "6"]);
        render(&path, &plain, &["--baseline"]);
        assert_eq!(summary["periods"][0]["whole"], serde_json::Value::Null);
        assert_eq!(summary["periods"][0]["objects"]["slow"], 1);
        // A sky that is drawn anew costs a picture a frame.
        let fast = summary["pixels_traced"]["fast"].as_u64().unwrap();
        assert_eq!(fast, if kept { 0 } else { 6 * 96 * 64 });
        for number in 0..6 {
            let differing = differing_pixels(&frame(&ours, number), &frame(&plain, number)).len();
            if kept {
                // It moves by a tenth of a pixel: colours change a little.
                let far = farthest_colours(&frame(&ours, number), &frame(&plain, number));
                assert!(far <= 4, "a difference of {far} in frame {number}");
            } else {
                // Edges of the cockpit alone.
                assert!(differing <= 20, "{differing} pixels in frame {number}");
            }
        }
    }
}

/// The largest difference of a channel.
fn farthest_colours(a: &Path, b: &Path) -> u16 {
    let (left, right) = (common::pixels(a).2, common::pixels(b).2);
    let channels = left.iter().flatten().zip(right.iter().flatten());
    channels.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}
