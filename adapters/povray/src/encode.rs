//! POV-Ray's encoding of linear colour into a picture's integers.
//!
//! Since 3.7 the default of a picture is the sRGB transfer function, in single
//! precision; no dithering. `linear_to_srgb` follows IEC 61966-2-1.

use std::sync::LazyLock;

use decor_api::Transfer;

/// One channel in `max` steps, as POV-Ray writes it with its default
/// `File_Gamma` (sRGB) from a scene of `assumed_gamma 1`.
pub fn srgb(linear: f32, max: u32) -> u32 {
    quantise(linear_to_srgb(linear), max)
}

/// [`srgb`] in 255 steps, by table.
pub fn srgb_8(linear: f32) -> u8 {
    static TABLE: LazyLock<Transfer> = LazyLock::new(|| Transfer::of(|linear| srgb(linear, 255)));
    TABLE.encode(linear, |linear| srgb(linear, 255))
}

/// The linear value that a picture's integer stands for. `srgb` gives the
/// integer back, for every one of 8 and of 16 bits.
pub fn linear(value: u32, max: u32) -> f32 {
    let encoded = value as f32 / max as f32;
    if encoded < 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// One channel in `max` steps, without a transfer function: alpha, depth.
pub fn quantise(value: f32, max: u32) -> u32 {
    // A value that is not a number is black, as in POV-Ray's own clipping.
    let clipped = if value > 0.0 { value.min(1.0) } else { 0.0 };
    f64::from(clipped * max as f32 + 0.5).floor() as u32
}

fn linear_to_srgb(x: f32) -> f32 {
    if x <= 0.003_130_8 {
        x * 12.92
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_integer_survives_the_way_through_linear() {
        for max in [255, 65535] {
            for value in 0..=max {
                assert_eq!(srgb(linear(value, max), max), value);
            }
        }
    }

    #[test]
    fn the_table_says_what_the_function_says() {
        let all = (0..1 << 20).map(|k: u32| k << 12 | k & 0xfff);
        let near = (0..255_u32).flat_map(|value| {
            // The step is half way, as the transfer function sees it.
            let step = linear(2 * value + 1, 510).to_bits();
            step - 300..step + 300
        });
        for bits in all.chain(near) {
            let linear = f32::from_bits(bits);
            assert_eq!(u32::from(srgb_8(linear)), srgb(linear, 255), "{linear:e}");
        }
    }

    #[test]
    fn what_is_out_of_range_is_clipped() {
        assert_eq!(srgb(-1.0, 255), 0);
        assert_eq!(srgb(7.0, 255), 255);
        assert_eq!(srgb(f32::NAN, 255), 0);
        assert_eq!(srgb(f32::INFINITY, 65535), 65535);
    }
}
