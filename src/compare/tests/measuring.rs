//! Numbers against hand-computed ones, and their properties.

use proptest::prelude::*;

use super::super::metrics::{Channel, Levels, Metrics, Place, measure};
use super::super::picture::{Form, Picture};
use super::{STRICT, picture};

fn strict(a: &Picture, b: &Picture) -> Metrics {
    measure(a, b, &STRICT, None).unwrap()
}

#[test]
fn rms_and_psnr_by_hand() {
    // One channel of four pixels (12 values) is wrong by 1/2:
    // mean square = 0.25 / 12, RMS = 0.5 / √12, PSNR = 10 · log₁₀ 48.
    let a = picture(2, Form::Exr, &[[0.0; 3]; 4]);
    let mut b = a.clone();
    b.values[2][1] = 0.5;
    let metrics = strict(&a, &b);
    assert!((metrics.rms() - 0.144_337_567_297_406_44).abs() < 1e-15);
    assert!((metrics.psnr() - 16.812_412_373_755_87).abs() < 1e-12);
    assert_eq!(metrics.max, 0.5);
    let place = Place {
        x: 0,
        y: 1,
        channel: Channel::G,
        a: 0.0,
        b: 0.5,
    };
    assert_eq!(metrics.largest, Some(place));
    assert_eq!(
        (metrics.pixels, metrics.unequal, metrics.differing),
        (4, 1, 1)
    );
    assert_eq!(metrics.share_above(), 0.25);
}

#[test]
fn every_value_off_by_a_step_of_8_bits_is_48_decibels() {
    // PSNR = 20 · log₁₀ 255 = 48.1308 dB.
    let a = picture(2, Form::Png8, &[[100.0 / 255.0; 3]; 4]);
    let b = picture(2, Form::Png8, &[[101.0 / 255.0; 3]; 4]);
    let metrics = strict(&a, &b);
    assert!((metrics.psnr() - 48.130_803_608_679_1).abs() < 1e-9);
    assert_eq!(
        metrics.max,
        1.0 / 255.0,
        "exactly one step, not a float near it"
    );
}

#[test]
fn a_tolerance_of_one_step_lets_every_step_pass() {
    let levels = Levels {
        fail: 1.0 / 255.0,
        ..STRICT
    };
    for step in 0..255_u8 {
        let a = picture(1, Form::Png8, &[[f32::from(step) / 255.0; 3]]);
        let b = picture(1, Form::Png8, &[[f32::from(step + 1) / 255.0; 3]]);
        let metrics = measure(&a, &b, &levels, None).unwrap();
        assert_eq!((metrics.unequal, metrics.differing), (1, 0), "step {step}");
    }
}

#[test]
fn nan_is_a_difference_even_from_itself() {
    let mut a = picture(2, Form::Exr, &[[0.25; 3]; 4]);
    a.values[3][2] = f32::NAN;
    let b = picture(2, Form::Exr, &[[0.25; 3]; 4]);
    for other in [&a, &b] {
        let metrics = strict(&a, other);
        assert_eq!(metrics.not_finite, 1);
        assert_eq!((metrics.unequal, metrics.differing), (1, 1));
        assert_eq!(metrics.max, f64::INFINITY);
        let place = metrics.largest.unwrap();
        assert_eq!((place.x, place.y, place.channel), (1, 1, Channel::B));
        // It counts as the whole range of one value in twelve.
        assert!((metrics.mean_square - 1.0 / 12.0).abs() < 1e-15);
    }
    let tolerant = Levels {
        fail: f64::INFINITY,
        ..STRICT
    };
    let metrics = measure(&a, &b, &tolerant, None).unwrap();
    assert_eq!(metrics.differing, 1, "no tolerance tolerates it");
}

#[test]
fn infinity_equals_itself_only() {
    let a = picture(1, Form::Exr, &[[f32::INFINITY; 3]]);
    let b = picture(1, Form::Exr, &[[f32::NEG_INFINITY; 3]]);
    assert!(strict(&a, &a).identical());
    assert_eq!(strict(&a, &b).not_finite, 1);
}

#[test]
fn alpha_counts_where_both_have_it_but_not_in_the_mean() {
    let a = picture(1, Form::Png8, &[[0.5; 3]]);
    let mut b = a.clone();
    b.values[0][3] = 0.0;
    b.has_alpha = true;
    assert!(strict(&a, &b).identical());
    let mut a = a;
    a.has_alpha = true;
    let metrics = strict(&a, &b);
    assert_eq!((metrics.max, metrics.unequal), (1.0, 1));
    assert_eq!(metrics.largest.unwrap().channel, Channel::A);
    assert_eq!(metrics.mean_square, 0.0);
}

#[test]
fn depth_by_hand() {
    let inf = f32::INFINITY;
    let with_depth = |depth: [f32; 6]| Picture {
        depth: Some(depth.to_vec()),
        ..picture(3, Form::Exr, &[[0.0; 3]; 6])
    };
    let a = with_depth([1.0, inf, 4.0, inf, 100.0, f32::NAN]);
    let b = with_depth([1.0, inf, 5.0, 7.0, 101.0, 2.0]);
    let metrics = strict(&a, &b);
    assert_eq!(metrics.unequal, 0, "the colour is equal");
    assert!(!metrics.identical());
    let depth = metrics.depth.unwrap();
    assert_eq!(depth.max_absolute, 1.0);
    assert_eq!(depth.max_relative, 0.2);
    assert_eq!((depth.surface_in_one, depth.not_a_number), (1, 1));
    assert_eq!((depth.unequal, depth.differing), (4, 4));
    let place = depth.largest.unwrap();
    assert_eq!((place.x, place.y), (0, 1), "a missing surface is the worst");
    let levels = Levels {
        fail_depth: 0.1,
        ..STRICT
    };
    let depth = measure(&a, &b, &levels, None).unwrap().depth.unwrap();
    assert_eq!(depth.differing, 3, "0.2, the missing surface, NaN");
}

#[test]
fn a_shifted_picture_is_not_the_picture() {
    let ramp: Vec<[f32; 3]> = (0..64).map(|k| [(k % 8) as f32 / 8.0; 3]).collect();
    let shifted: Vec<[f32; 3]> = (0..64).map(|k| [((k + 1) % 8) as f32 / 8.0; 3]).collect();
    let (a, b) = (
        picture(8, Form::Exr, &ramp),
        picture(8, Form::Exr, &shifted),
    );
    let metrics = strict(&a, &b);
    assert_eq!(metrics.unequal, 64);
    // At the edge the ramp begins anew.
    assert_eq!(metrics.max, 0.875);
    let place = metrics.largest.unwrap();
    assert_eq!((place.x, place.y), (7, 0), "the first of the largest");
}

#[test]
fn sizes_must_agree() {
    let a = picture(2, Form::Exr, &[[0.0; 3]; 4]);
    let b = picture(4, Form::Exr, &[[0.0; 3]; 4]);
    assert!(measure(&a, &b, &STRICT, None).is_none());
}

fn any_value() -> impl Strategy<Value = f32> {
    prop_oneof![
        20 => -2.0..10.0_f32,
        1 => prop_oneof![Just(f32::INFINITY), Just(f32::NAN), Just(0.0), Just(-0.0)],
    ]
}

fn any_picture() -> impl Strategy<Value = Picture> {
    let values = prop::collection::vec(prop::array::uniform4(any_value()), 35);
    let depth = prop::collection::vec(any_value(), 35);
    (values, depth).prop_map(|(values, depth)| Picture {
        values,
        depth: Some(depth),
        has_alpha: true,
        ..picture(5, Form::Exr, &[[0.0; 3]; 35])
    })
}

proptest! {
    #[test]
    fn identical_without_nan_is_identical(mut a in any_picture()) {
        for value in a.values.iter_mut().flatten().chain(a.depth.iter_mut().flatten()) {
            if value.is_nan() {
                *value = 1.0;
            }
        }
        let metrics = strict(&a, &a);
        prop_assert!(metrics.identical());
        prop_assert_eq!(metrics.max, 0.0);
        prop_assert_eq!(metrics.psnr(), f64::INFINITY);
    }

    #[test]
    fn symmetric_and_never_nan((a, b) in (any_picture(), any_picture())) {
        let levels = Levels { fail: 0.5, warn: 0.25, fail_depth: 0.5, warn_depth: 0.25 };
        let there = measure(&a, &b, &levels, None).unwrap();
        let back = measure(&b, &a, &levels, None).unwrap();
        prop_assert_eq!(there.max, back.max);
        prop_assert_eq!(there.mean_square, back.mean_square);
        prop_assert!(there.mean_square.is_finite() && !there.max.is_nan());
        prop_assert_eq!(
            (there.unequal, there.differing, there.above_warn, there.not_finite),
            (back.unequal, back.differing, back.above_warn, back.not_finite)
        );
        prop_assert!(there.not_finite <= there.differing && there.differing <= there.above_warn);
        let (there, back) = (there.depth.unwrap(), back.depth.unwrap());
        prop_assert_eq!(there.max_absolute, back.max_absolute);
        prop_assert_eq!(there.surface_in_one, back.surface_in_one);
    }

    #[test]
    fn the_same_with_one_thread_and_with_many((a, b) in (any_picture(), any_picture())) {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            // As text, because NaN is not equal to itself.
            format!("{:?}", pool.install(|| strict(&a, &b)))
        };
        prop_assert_eq!(with(1), with(4));
    }
}
