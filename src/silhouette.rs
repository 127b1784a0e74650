//! Where an object is seen: tighter than by the sphere that its motion is
//! measured on.
//!
//! An airliner fills a small part of the ball around it. Where boxes around an
//! object are known, a box's outline in the picture is that of its eight
//! corners, which is taken row of blocks by row of blocks; where a neutral
//! solid is made of parts, each has a ball of its own. What is not certain is as
//! large as the sphere.

use decor_api::{Camera, Extent, Pose, Prototype, Size, Sphere, Window};
use glam::DVec3;

use crate::motion::screen_box;

/// The rows of an outline are taken so many at once: the renderers' blocks.
const BAND: u32 = 32;

/// The rectangles of the picture that an object can be seen in, and nowhere
/// else; none where it cannot be seen. `parts` are spheres that enclose the
/// prototype together, in its own coordinates; none: only its bounds are known.
/// Conservative, and a pixel wider on each side.
pub fn silhouette(
    prototype: &Prototype,
    parts: &[Sphere],
    pose: &Pose,
    camera: &Camera,
    size: Size,
) -> Vec<Window> {
    let whole = screen_box(&prototype.bounds.posed(pose), camera, size).window();
    if whole.is_empty() {
        return Vec::new();
    }
    let outlines: Option<Vec<Outline>> = prototype
        .extents
        .iter()
        .map(|extent| Outline::of(extent, pose, camera, size))
        .collect();
    let windows: Vec<Window> = if let Some(outlines) = outlines.filter(|all| !all.is_empty()) {
        outlines.iter().flat_map(|o| o.bands(whole)).collect()
    } else if parts.is_empty() {
        vec![whole]
    } else {
        let part = |sphere: &Sphere| {
            let bounds = decor_api::Bounds::Sphere(*sphere).posed(pose);
            screen_box(&bounds, camera, size).window()
        };
        parts.iter().map(part).collect()
    };
    let cut = windows.into_iter().map(|window| window.intersection(whole));
    cut.filter(|window| !window.is_empty()).collect()
}

/// The corners of a box in the picture, in pixels. What is seen of the box lies
/// in their convex hull.
struct Outline {
    corners: [(f64, f64); 8],
}

impl Outline {
    /// `None` where a corner is not surely before the observer, or so near to
    /// him that rounding is worth a pixel.
    fn of(extent: &Extent, pose: &Pose, camera: &Camera, size: Size) -> Option<Self> {
        const ROUNDING_PX: f64 = 0.25;
        let transform = pose.transform();
        let (fx, fy) = camera.focal(size);
        let (half_w, half_h) = (f64::from(size.width) * 0.5, f64::from(size.height) * 0.5);
        let mut corners = [(0.0, 0.0); 8];
        for (corner, place) in corners.iter_mut().zip(extent.corners()) {
            let world = transform.transform_point3(place);
            let seen: DVec3 = camera.to_camera(world);
            let scale = world.abs().max_element()
                + place.abs().max_element()
                + camera.eye.abs().max_element();
            let (x, y) = (seen.x / seen.z, seen.y / seen.z);
            // What rounding of the coordinates is worth: a share of what was
            // subtracted, as large as the view is narrow.
            let error = 1e-14 * scale / seen.z * fx.max(fy) * (1.0 + x.abs().max(y.abs()));
            let (x, y) = (half_w + fx * x, half_h - fy * y);
            // What is not a number is not certain.
            if !(seen.z > 0.0 && error < ROUNDING_PX && x.is_finite() && y.is_finite()) {
                return None;
            }
            *corner = (x, y);
        }
        Some(Self { corners })
    }

    /// Its rectangles within `whole`, one a row of blocks.
    fn bands(&self, whole: Window) -> impl Iterator<Item = Window> + '_ {
        let first = whole.y / BAND;
        let last = whole.bottom().div_ceil(BAND);
        (first..last).filter_map(move |band| {
            // Wider by a pixel than the rows, for what is seen at their borders.
            let (top, bottom) = (band * BAND, (band + 1) * BAND);
            let ((left, right), (high, low)) =
                self.within(f64::from(top) - 1.0, f64::from(bottom) + 1.0)?;
            let x = pixels(left, right, whole.x, whole.right())?;
            let y = pixels(high, low, whole.y.max(top), whole.bottom().min(bottom))?;
            Some(Window {
                x: x.0,
                y: y.0,
                width: x.1 - x.0,
                height: y.1 - y.0,
            })
        })
    }

    /// The ranges in x and y of the hull between two rows. Its edges are among
    /// the lines that join two corners, and no such line leaves it.
    fn within(&self, top: f64, bottom: f64) -> Option<((f64, f64), (f64, f64))> {
        let (mut xs, mut ys) = (EMPTY, EMPTY);
        for (k, &a) in self.corners.iter().enumerate() {
            for &b in &self.corners[k..] {
                let (high, low) = if a.1 <= b.1 { (a, b) } else { (b, a) };
                if low.1 < top || high.1 > bottom {
                    continue;
                }
                for y in [high.1.max(top), low.1.min(bottom)] {
                    let way = low.1 - high.1;
                    let share = if way > 0.0 { (y - high.1) / way } else { 0.0 };
                    grow(&mut xs, high.0 + share * (low.0 - high.0));
                    if way <= 0.0 {
                        grow(&mut xs, low.0);
                    }
                    grow(&mut ys, y);
                }
            }
        }
        (xs.0 <= xs.1).then_some((xs, ys))
    }
}

const EMPTY: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

fn grow(range: &mut (f64, f64), by: f64) {
    *range = (range.0.min(by), range.1.max(by));
}

/// The pixels between two edges, and one more on each side, cut to a range.
fn pixels(from: f64, to: f64, first: u32, end: u32) -> Option<(u32, u32)> {
    let (first, end) = (f64::from(first), f64::from(end));
    let (from, to) = ((from.floor() - 1.0).max(first), (to.ceil() + 1.0).min(end));
    (from < to).then_some((from as u32, to as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::{Bounds, Fragment, Geometry, NativeFile, Optics};
    use proptest::prelude::*;

    const SIZE: Size = Size {
        width: 200,
        height: 170,
    };

    fn boxed(extent: Extent) -> Prototype {
        Prototype {
            path: "test".into(),
            hash: String::new(),
            geometry: Geometry::Fragment(Fragment {
                file: NativeFile {
                    path: "test".into(),
                    root: "".into(),
                    text: Vec::new(),
                },
                language: "inc".into(),
            }),
            bounds: Bounds::around_box(extent.min, extent.max),
            extents: vec![extent],
            optics: Optics::Opaque,
            unlayerable: None,
        }
    }

    fn vec3(size: f64) -> impl Strategy<Value = DVec3> {
        (-size..size, -size..size, -size..size).prop_map(DVec3::from)
    }

    fn area(windows: &[Window]) -> usize {
        windows.iter().map(|window| window.pixels()).sum()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn no_point_of_the_box_is_seen_outside(
            a in vec3(6.0),
            b in vec3(6.0),
            place in vec3(25.0),
            turn in vec3(180.0),
            share in (0.0..1.0, 0.0..1.0, 0.0..1.0),
            angle in 1.0..160.0_f64,
        ) {
            let extent = Extent { min: a.min(b), max: a.max(b) };
            let pose = Pose { position: place, angles_deg: turn };
            let camera = Camera::look_at(
                DVec3::new(1.0, 2.0, -30.0),
                DVec3::new(0.5, 0.0, 4.0),
                DVec3::Y,
                (angle, angle * 0.85),
            ).unwrap();
            let prototype = boxed(extent);
            for parts in [Vec::new(), crate::influence::parts(&prototype)] {
                for prototype in [prototype.clone(), Prototype { extents: Vec::new(), ..prototype.clone() }] {
                    let windows = silhouette(&prototype, &parts, &pose, &camera, SIZE);
                    let point = extent.min + (extent.max - extent.min) * DVec3::from(share);
                    let point = pose.transform().transform_point3(point);
                    let Some((x, y)) = camera.project(SIZE, point) else { continue };
                    if (0.0..200.0).contains(&x) && (0.0..170.0).contains(&y) {
                        prop_assert!(
                            windows.iter().any(|w| w.contains(x as u32, y as u32)),
                            "({x}, {y}) of {windows:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_long_thing_is_seen_in_little_of_its_sphere() {
        let camera =
            Camera::look_at(DVec3::Z * -30.0, DVec3::ZERO, DVec3::Y, (60.0, 51.0)).unwrap();
        let plank = boxed(Extent {
            min: DVec3::new(-9.0, -0.5, -0.5),
            max: DVec3::new(9.0, 0.5, 0.5),
        });
        for turn in [DVec3::ZERO, DVec3::Z * 40.0] {
            let pose = Pose {
                position: DVec3::ZERO,
                angles_deg: turn,
            };
            let own = area(&silhouette(&plank, &[], &pose, &camera, SIZE));
            let parts = crate::influence::parts(&plank);
            let unboxed = Prototype {
                extents: Vec::new(),
                ..plank.clone()
            };
            let by_parts = silhouette(&unboxed, &parts, &pose, &camera, SIZE);
            let by_sphere = area(&silhouette(&unboxed, &[], &pose, &camera, SIZE));
            assert!(own * 4 < by_sphere, "{own} of {by_sphere}");
            assert!(by_parts.len() > 3 && area(&by_parts) * 2 < by_sphere);
        }
    }

    #[test]
    fn what_is_around_the_observer_or_behind_him_is_as_the_sphere_says() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 51.0)).unwrap();
        let cube = boxed(Extent {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        });
        let at = |z: f64| {
            let pose = Pose {
                position: DVec3::Z * z,
                angles_deg: DVec3::ZERO,
            };
            silhouette(&cube, &[], &pose, &camera, SIZE)
        };
        assert_eq!(at(0.5), [SIZE.window()]);
        assert!(at(-5.0).is_empty());
    }
}
