//! SSIM, FLIP, flicker and movement: their properties, and numbers by hand. That
//! SSIM and FLIP are the published ones is tested with the program.

use proptest::prelude::*;

use super::super::flicker::flicker;
use super::super::flip::{self, PIXELS_PER_DEGREE};
use super::super::mask::Mask;
use super::super::moved::moved;
use super::super::perceived::{Perceived, perceive};
use super::super::picture::{Form, Picture};
use super::super::seen::Seen;
use super::picture;

fn perceived(a: &Picture, b: &Picture) -> Perceived {
    perceive(a, b, None, PIXELS_PER_DEGREE).unwrap()
}

/// A picture without repetition, 90 by 80.
fn texture(form: Form) -> Picture {
    let value = |k: u32| (k.wrapping_mul(2_654_435_761) >> 24) as f32 / 255.0;
    let values: Vec<[f32; 3]> = (0..90 * 80)
        .map(|k| [value(k), value(k + 10_000), value(k / 7)])
        .collect();
    picture(90, form, &values)
}

/// A mask of the columns that `white` says.
fn columns(white: impl Fn(usize) -> bool) -> Mask {
    let value = |k: usize| if white(k % 90) { [1.0; 3] } else { [0.0; 3] };
    let values: Vec<[f32; 3]> = (0..90 * 80).map(value).collect();
    Mask::of(&picture(90, Form::Png8, &values))
}

#[test]
fn equal_pictures_look_equal() {
    let a = texture(Form::Png8);
    let same = perceived(&a, &a);
    assert_eq!(same.ssim.unwrap().mean, 1.0);
    assert_eq!(same.ssim.unwrap().windows, 80 * 70);
    assert_eq!((same.flip.mean, same.flip.max), (0.0, 0.0));
}

#[test]
fn a_wrong_pixel_is_seen_around_it_and_nowhere_else() {
    let a = texture(Form::Png8);
    let mut b = a.clone();
    b.values[40 * 90 + 60] = [1.0, 0.0, 1.0, 1.0];
    let seen = Seen::new(&a, &b, None).unwrap();
    let map = flip::map(&seen, PIXELS_PER_DEGREE);
    for (k, &error) in map.iter().enumerate() {
        let (x, y) = ((k % 90) as i64, (k / 90) as i64);
        let near = (x - 60).abs().max((y - 40).abs());
        // The filters reach 10 pixels; beyond, tiles that were filtered and tiles
        // that were not are both exactly right.
        assert!(near <= 10 || error == 0.0, "({x}, {y}) {error}");
    }
    assert!(map[40 * 90 + 60] > 0.1);
    // 121 windows see the pixel.
    assert!(perceived(&a, &b).ssim.unwrap().mean > 1.0 - 121.0 / 5600.0);
}

#[test]
fn nothing_masked_is_seen_not_even_by_a_neighbour() {
    let a = texture(Form::Png8);
    let mut b = a.clone();
    for y in 0..80 {
        b.values[y * 90 + 50] = [0.5; 4];
    }
    let left = columns(|x| x < 50);
    let masked = perceive(&a, &b, Some(&left), PIXELS_PER_DEGREE).unwrap();
    assert_eq!((masked.flip.mean, masked.ssim.unwrap().mean), (0.0, 1.0));
    let right = columns(|x| x >= 50);
    let masked = perceive(&a, &b, Some(&right), PIXELS_PER_DEGREE).unwrap();
    assert!(masked.flip.mean > perceived(&a, &b).flip.mean);
    assert_eq!(masked.ssim.unwrap().windows, 35 * 70);
}

#[test]
fn a_picture_smaller_than_a_window_has_no_ssim() {
    let small = picture(10, Form::Png8, &[[0.5; 3]; 200]);
    let mut other = small.clone();
    other.values[7][0] = 1.0;
    let seen = perceived(&small, &other);
    assert!(seen.ssim.is_none());
    assert!(seen.flip.mean > 0.0);
    let none = picture(1, Form::Png8, &[]);
    assert!(perceived(&none, &none).ssim.is_none());
    assert_eq!(perceived(&none, &none).flip.mean, 0.0);
}

#[test]
fn what_is_no_number_is_seen() {
    let a = texture(Form::Exr);
    let mut b = a.clone();
    b.values[30 * 90 + 30][1] = f32::NAN;
    for (a, b) in [(&a, &b), (&b, &a), (&b, &b)] {
        let seen = perceived(a, b);
        assert!(seen.flip.max > 0.1 && seen.flip.max <= 1.0, "{seen:?}");
        assert!(seen.ssim.unwrap().mean < 1.0);
    }
    // Brighter than white is white, on a display.
    let (mut a, mut b) = (a.clone(), a);
    (a.values[99][0], b.values[99][0]) = (3.0, f32::INFINITY);
    assert_eq!(perceived(&a, &b).flip.mean, 0.0);
}

#[test]
fn flicker_by_hand() {
    let frames = |levels: [u32; 4]| -> Picture {
        let values = levels.map(|level| [level as f32 / 255.0; 3]);
        picture(2, Form::Png8, &values)
    };
    // Pixel 0 moves in both, 1 in B only, 2 in A only, 3 in neither.
    let (a0, a1) = (frames([10, 20, 30, 40]), frames([15, 20, 35, 40]));
    let (b0, b1) = (frames([10, 20, 30, 41]), frames([15, 22, 30, 41]));
    let at =
        |level: f64, mask: Option<&Mask>| flicker((&a0, &b0), (&a1, &b1), level, mask).unwrap();
    let all = at(0.0, None);
    assert_eq!(
        (all.changed_a, all.changed_b, all.added, all.lost),
        (2, 2, 1, 1)
    );
    assert_eq!(
        (all.pixels, all.difference(), all.share_added()),
        (4, 0, 0.25)
    );
    let large = at(2.0 / 255.0, None);
    assert_eq!(
        (large.changed_a, large.changed_b, large.added, large.lost),
        (2, 1, 0, 1)
    );
    assert_eq!(large.difference(), -1);
    let mask = Mask::of(&frames([255, 255, 0, 255]));
    let masked = at(0.0, Some(&mask));
    assert_eq!((masked.pixels, masked.added, masked.lost), (3, 1, 0));
    // Nothing is said where a sequence changes what it means.
    let linear = picture(2, Form::Exr, &[[0.0; 3]; 4]);
    assert!(flicker((&a0, &b0), (&linear, &b1), 0.0, None).is_none());
    let smaller = picture(1, Form::Png8, &[[0.0; 3]; 2]);
    assert!(flicker((&smaller, &smaller), (&a1, &b1), 0.0, None).is_none());
}

#[test]
fn a_wrong_pixel_is_no_movement() {
    let a = texture(Form::Png8);
    assert_eq!(moved(&a, &a, 0.0), None);
    let flat = picture(90, Form::Png8, &[[0.5; 3]; 90 * 80]);
    for place in [0, 89, 40 * 90, 40 * 90 + 40] {
        let mut b = flat.clone();
        b.values[place] = [0.0; 4];
        assert_eq!(moved(&flat, &b, 0.0), None, "at {place}");
    }
}

/// `a`, moved; what comes in from outside is black.
fn shifted(a: &Picture, (dx, dy): (i64, i64)) -> Picture {
    let mut b = a.clone();
    for (k, value) in b.values.iter_mut().enumerate() {
        let (x, y) = (k as i64 % 90 - dx, k as i64 / 90 - dy);
        let inside = (0..90).contains(&x) && (0..80).contains(&y);
        *value = if inside {
            a.values[(y * 90 + x) as usize]
        } else {
            [0.0, 0.0, 0.0, 1.0]
        };
    }
    b
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn movements_are_told(dx in -2_i64..=2, dy in -2_i64..=2) {
        let a = texture(Form::Png16);
        let found = moved(&a, &shifted(&a, (dx, dy)), 0.0);
        prop_assert_eq!(found, (dx != 0 || dy != 0).then_some((dx, dy)));
    }

    #[test]
    fn looks_do_not_depend_on_the_order(place in 0_usize..90 * 80, value in 0_u8..=255, wide in 1_usize..40) {
        let a = texture(Form::Png8);
        let mut b = a.clone();
        for pixel in b.values.iter_mut().skip(place).take(wide) {
            *pixel = [f32::from(value) / 255.0; 4];
        }
        let (there, back) = (perceived(&a, &b), perceived(&b, &a));
        prop_assert!((there.flip.mean - back.flip.mean).abs() < 1e-9);
        prop_assert!((there.ssim.unwrap().mean - back.ssim.unwrap().mean).abs() < 1e-12);
        prop_assert!((0.0..=1.0).contains(&there.flip.max));
        prop_assert!(there.ssim.unwrap().mean <= 1.0);
    }

    /// A picture that is wrong by more looks more wrong.
    #[test]
    fn more_noise_is_seen_more(low in 1_u8..20, more in 4_u8..60) {
        let a = texture(Form::Png8);
        let noisy = |amount: u8| {
            let mut b = a.clone();
            for (k, pixel) in b.values.iter_mut().enumerate().filter(|(k, _)| k % 3 == 0) {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                pixel[1] = (pixel[1] + sign * f32::from(amount) / 255.0).clamp(0.0, 1.0);
            }
            perceived(&a, &b)
        };
        let (less, more) = (noisy(low), noisy(low + more));
        prop_assert!(less.flip.mean < more.flip.mean);
        prop_assert!(less.ssim.unwrap().mean > more.ssim.unwrap().mean);
    }
}
