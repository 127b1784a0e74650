//! Numbers as POV-Ray text that reads back as the very same double.

use std::fmt::Write as _;

use decor_api::Rgb;
use glam::DVec3;

/// `value` in the shortest form that reads back the same. Very large and very
/// small numbers get an exponent: POV-Ray's scanner limits a number's length.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        // POV-Ray has no use for the sign of zero.
        "0".to_owned()
    } else if (1e-5..1e15).contains(&magnitude) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// `<x,y,z>`.
pub fn vector(v: DVec3) -> String {
    format!("<{},{},{}>", number(v.x), number(v.y), number(v.z))
}

/// `<r,g,b>`.
pub fn colour(c: Rgb) -> String {
    vector(DVec3::from_array(c.0))
}

/// `<x,y,z>` in single precision, appended to `text`: what meshes are stored
/// in, and a third of the length.
pub fn push_single(text: &mut String, v: DVec3) {
    let (x, y, z) = (v.x as f32, v.y as f32, v.z as f32);
    // Writing to a string cannot fail.
    let _ = write!(text, "<{},{},{}>", single(x), single(y), single(z));
}

fn single(value: f32) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-5..1e15).contains(&magnitude) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn text_reads_back_the_same(value in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL) {
            let text = number(value);
            prop_assert_eq!(text.parse::<f64>().unwrap().to_bits(), value.to_bits());
            prop_assert!(text.len() < 30, "{}", text);
        }
    }

    #[test]
    fn short_where_it_can_be() {
        assert_eq!(vector(DVec3::new(-0.0, 1.0, 0.1)), "<0,1,0.1>");
        assert_eq!(number(1e-7), "1e-7");
    }
}
