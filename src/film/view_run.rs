//! The first frame in which a moving camera stops being one.
//!
//! A film may hold its last scene for four thousand million frames, so the
//! frames are not tried one by one. Between two of them the view `d = aim − eye`
//! runs along a straight segment, and with it `c = û × d`. A camera exists
//! wherever `|c| > 1e-12·|d|`. Where the segment of `c`, widened by the rounding
//! of the positions, stays clear of that by a factor of ten, all frames between
//! are good; elsewhere the run is halved.

use std::ops::RangeInclusive;

use decor_api::CameraError;
use glam::DVec3;

use super::frame::View;

/// Ten times what `Camera::look_at` asks for.
const CLEAR_SINE: f64 = 1e-11;

/// So many frames are tried, then the run counts as bad: not certain is not
/// good. Only a view that stays within 1e-11 of the up direction gets here.
const MOST_TRIES: u32 = 1 << 20;

/// The first frame of the run without a camera, and why. Where a run has
/// several such stretches, a frame of the first one.
pub(super) fn first_without_camera(
    view: &View,
    frames: RangeInclusive<u32>,
) -> Option<(u32, CameraError)> {
    let (first, last) = frames.into_inner();
    let mut search = Search { view, tries: 0 };
    if let Some(bad) = search.attempt(first) {
        return Some(bad);
    }
    let still = view.eye.value.velocity == DVec3::ZERO && view.aim.value.velocity == DVec3::ZERO;
    if still || first == last {
        return None;
    }
    search.between(first, last).or_else(|| search.attempt(last))
}

struct Search<'a> {
    view: &'a View,
    tries: u32,
}

impl Search<'_> {
    fn attempt(&mut self, frame: u32) -> Option<(u32, CameraError)> {
        self.tries += 1;
        if self.tries > MOST_TRIES {
            return Some((frame, CameraError::UpAlongView));
        }
        let error = self.view.camera(frame).err()?;
        Some((frame, error))
    }

    /// Strictly between `a` and `b`.
    fn between(&mut self, a: u32, b: u32) -> Option<(u32, CameraError)> {
        if b - a < 2 || self.is_clear(a, b) {
            return None;
        }
        let middle = a + (b - a) / 2;
        self.between(a, middle)
            .or_else(|| self.attempt(middle))
            .or_else(|| self.between(middle, b))
    }

    fn is_clear(&self, a: u32, b: u32) -> bool {
        let View { eye, aim, up, .. } = self.view;
        let ends = [a, b].map(|n| (eye.at(n), aim.at(n)));
        let views = ends.map(|(eye, aim)| aim - eye);
        let largest = |v: DVec3| v.abs().max_element();
        let scale = largest(views[0]).max(largest(views[1]));
        // Non-finite values fail here too, and what rounding could make so.
        if !(scale > 0.0 && scale < f64::MAX * (1.0 - 1e-12)) {
            return false;
        }
        // Coordinates between the ends are bounded by the ends; n·v by both.
        let reach = [eye, aim]
            .iter()
            .map(|point| largest(point.value.position))
            .chain(
                ends.iter()
                    .map(|(eye, aim)| largest(*eye).max(largest(*aim))),
            )
            .fold(0.0, f64::max);
        // Each position is off by the rounding of a product (at most 2·reach)
        // and of a sum, the view by two positions, the cross product by the
        // vectors' lengths: 32 covers all of them.
        let slack = 32.0 * (f64::EPSILON * (reach / scale) + f64::MIN_POSITIVE / scale);
        let up = *up / largest(*up);
        let up = up.normalize();
        let [c0, c1] = views.map(|d| up.cross(d / scale));
        let length = 1.8; // |d| / scale is √3 at most.
        nearest_to_origin(c0, c1) > CLEAR_SINE * length + slack
    }
}

/// The least distance of a segment's points from the origin.
fn nearest_to_origin(a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let square = along.length_squared();
    let t = if square > 0.0 {
        (-a.dot(along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    // Rounding of t moves the point along the segment only; the ends are exact.
    (a + along * t).length().min(a.length()).min(b.length())
}

#[cfg(test)]
mod tests {
    use super::super::frame::Since;
    use super::super::model::Moving;
    use super::*;

    fn point(position: [f64; 3], velocity: [f64; 3]) -> Since<Moving> {
        let (position, velocity) = (position.into(), velocity.into());
        let value = Moving { position, velocity };
        Since { frame: 0, value }
    }

    fn view(eye: Since<Moving>, aim: Since<Moving>) -> View {
        View {
            eye,
            aim,
            up: DVec3::Y,
            angles_deg: (60.0, 45.0),
        }
    }

    const STILL: [f64; 3] = [0.0; 3];

    #[test]
    fn an_eye_that_reaches_the_aim_is_found_in_a_long_film() {
        let eye = point([0.0, 0.0, -3e9], [0.0, 0.0, 1.0]);
        let view = view(eye, point([0.0; 3], STILL));
        let bad = first_without_camera(&view, 0..=u32::MAX);
        assert_eq!(bad, Some((3_000_000_000, CameraError::EyeIsAim)));
        assert_eq!(first_without_camera(&view, 0..=2_999_999_999), None);
        assert_eq!(first_without_camera(&view, 3_000_000_001..=u32::MAX), None);
    }

    #[test]
    fn an_eye_that_jumps_over_the_aim_is_fine() {
        let eye = point([0.0, 0.0, -10.5], [0.0, 0.0, 1.0]);
        let view = view(eye, point([0.0; 3], STILL));
        assert_eq!(first_without_camera(&view, 0..=1000), None);
    }

    #[test]
    fn a_view_that_swings_upright_is_found() {
        let aim = point([0.0, 1.0, 1000.0], [0.0, 0.0, -1.0]);
        let view = view(point([0.0; 3], STILL), aim);
        let bad = first_without_camera(&view, 0..=u32::MAX);
        assert_eq!(bad, Some((1000, CameraError::UpAlongView)));
    }

    #[test]
    fn leaving_the_numbers_is_found() {
        let eye = point([0.0, 0.0, -1.0], [1e300, 0.0, 0.0]);
        let view = view(eye, point([0.0; 3], STILL));
        let (frame, error) = first_without_camera(&view, 0..=u32::MAX).unwrap();
        assert_eq!(error, CameraError::NotFinite);
        assert!(frame > 100_000_000);
    }

    #[test]
    fn eye_and_aim_that_travel_together_stay_apart() {
        let v = [1e3, -2.0, 0.1];
        let view = view(point([1e6, 2.0, 3.0], v), point([1e6, 2.0, 4.0], v));
        assert_eq!(first_without_camera(&view, 0..=u32::MAX), None);
    }

    #[test]
    fn the_search_agrees_with_trying_every_frame() {
        // Small whole numbers, so that meetings happen.
        let mut state = 12345_u64;
        let mut small = move || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            ((state >> 33) % 9) as f64 - 4.0
        };
        let mut found = 0;
        for _ in 0..4000 {
            let mut vector = || [small(), small(), small()];
            let view = view(point(vector(), vector()), point(vector(), vector()));
            let plain = (0..=40).find(|n| view.camera(*n).is_err());
            let searched = first_without_camera(&view, 0..=40).map(|(n, _)| n);
            assert_eq!(plain, searched, "{view:?}");
            found += usize::from(plain.is_some());
        }
        assert!(found > 20, "{found}");
    }
}
