//! Files: every kind of PNG, EXR, and what is none.

use png::{BitDepth, ColorType};
use proptest::prelude::*;

use super::super::picture::{Form, Picture, PictureError};
use super::{write_float, write_png, write_rgb};

#[test]
fn png_of_every_kind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let read = |kind: (ColorType, BitDepth), bytes: &[u8]| {
        write_png(&path, (1, 1), kind, bytes);
        Picture::read(&path).unwrap()
    };
    let grey = read((ColorType::Grayscale, BitDepth::Eight), &[51]);
    assert_eq!(grey.values, [[0.2, 0.2, 0.2, 1.0]]);
    assert!(!grey.has_alpha);
    let grey_alpha = read((ColorType::GrayscaleAlpha, BitDepth::Eight), &[51, 102]);
    assert_eq!(grey_alpha.values, [[0.2, 0.2, 0.2, 0.4]]);
    assert!(grey_alpha.has_alpha);
    let rgb = read((ColorType::Rgb, BitDepth::Eight), &[0, 51, 255]);
    assert_eq!(
        (rgb.form, rgb.values[0]),
        (Form::Png8, [0.0, 0.2, 1.0, 1.0])
    );
    let rgba = read(
        (ColorType::Rgba, BitDepth::Sixteen),
        &[0, 1, 0x33, 0x33, 255, 255, 0, 0],
    );
    assert_eq!(rgba.form, Form::Png16);
    assert_eq!(rgba.values, [[1.0 / 65535.0, 0.2, 1.0, 0.0]]);
    let bits = read((ColorType::Grayscale, BitDepth::One), &[0x80]);
    assert_eq!(bits.values, [[1.0; 4]]);
}

#[test]
fn exr_with_and_without_depth() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_float(&path, (2, 1), &[0.5, 7.0], Some(&[3.0, f32::INFINITY]));
    let picture = Picture::read(&path).unwrap();
    assert_eq!(picture.values, [[0.5, 0.5, 0.5, 1.0], [7.0, 7.0, 7.0, 1.0]]);
    assert_eq!(picture.depth, Some(vec![3.0, f32::INFINITY]));
    assert_eq!((picture.form, picture.origin), (Form::Exr, (0, 0)));
    write_float(&path, (2, 1), &[0.5, 7.0], None);
    assert_eq!(Picture::read(&path).unwrap().depth, None);
}

#[test]
fn linear_becomes_srgb() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_float(
        &path,
        (5, 1),
        &[0.0, 0.002, 0.214_041_14, 1.0, f32::NAN],
        None,
    );
    let display = Picture::read(&path).unwrap().as_display(false);
    let expected = [0.0, 0.02584, 0.5, 1.0];
    for (value, expected) in display.values.iter().zip(expected) {
        assert!((value[0] - expected).abs() < 1e-6, "{value:?}");
    }
    assert!(display.values[4][0].is_nan(), "it has to be found");
}

#[test]
fn straight_colour_is_divided_by_alpha() {
    let half = Picture {
        values: vec![[0.107_020_57, 0.0, 0.5, 0.5], [0.0; 4]],
        has_alpha: true,
        ..super::picture(2, Form::Exr, &[[0.0; 3]; 2])
    };
    let straight = half.as_display(true);
    assert!((straight.values[0][0] - 0.5).abs() < 1e-6);
    assert_eq!(straight.values[0][2], 1.0);
    assert_eq!(
        straight.values[1], [0.0; 4],
        "nothing is not divided by nothing"
    );
}

#[test]
fn what_is_no_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    assert!(matches!(Picture::read(&path), Err(PictureError::Open(_))));
    for bytes in [&b""[..], b"\x89P", b"text", b"GIF89a..."] {
        std::fs::write(&path, bytes).unwrap();
        assert!(
            matches!(Picture::read(&path), Err(PictureError::UnknownFormat)),
            "{bytes:?}"
        );
    }
}

#[test]
fn a_file_that_was_cut_off_is_no_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    write_rgb(
        &png,
        (16, 16),
        &(0..=255).cycle().take(768).collect::<Vec<u8>>(),
    );
    let ramp: Vec<f32> = (0..256).map(|k| (k as f32).sin()).collect();
    write_float(&exr, (16, 16), &ramp, Some(&ramp));
    for path in [png, exr] {
        let whole = std::fs::read(&path).unwrap();
        for kept in (0..whole.len()).step_by(7).chain([whole.len() - 1]) {
            std::fs::write(&path, &whole[..kept]).unwrap();
            assert!(
                Picture::read(&path).is_err(),
                "{} of {kept} bytes",
                path.display()
            );
        }
    }
}

#[test]
fn a_header_is_not_believed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    write_rgb(&path, (1, 1), &[1, 2, 3]);
    let mut bytes = std::fs::read(&path).unwrap();
    // IHDR: its width and height at 16, its check sum at 29.
    bytes[16..24].copy_from_slice(&[0x7f, 0, 0, 0, 0x7f, 0, 0, 0]);
    let sum = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&sum.to_be_bytes());
    std::fs::write(&path, &bytes).unwrap();
    assert!(matches!(
        Picture::read(&path),
        Err(PictureError::TooLarge { .. } | PictureError::Png(_))
    ));
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            (sum >> 1) ^ (0xedb8_8320 * (sum & 1))
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever is in a file, reading it ends, and ends without a panic.
    #[test]
    fn damaged_files_end_in_a_result(
        places in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 1..4),
        linear in any::<bool>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let ramp: Vec<f32> = (0..64).map(|k| (k as f32).sin()).collect();
        if linear {
            write_float(&path, (8, 8), &ramp, Some(&ramp));
        } else {
            write_rgb(&path, (8, 8), &(0..192).collect::<Vec<u8>>());
        }
        let mut bytes = std::fs::read(&path).unwrap();
        for (place, byte) in places {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = byte;
        }
        std::fs::write(&path, bytes).unwrap();
        let _ = Picture::read(&path);
    }
}
