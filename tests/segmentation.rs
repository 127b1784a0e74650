//! The four answers, and their reasons.

use std::path::Path;
use std::sync::Arc;

use decor::film::{self, DescriptionId, FrameState, Motion, ObjectId, ObjectState};
use decor::objects::Cache;
use decor::plan::{Mode, Wishes, plan};
use decor::segmentation::{Class, Measure, Reason, Rule, Segmented, segment};
use decor::stage::Stage;
use decor_api::{Bounds, Camera, Light, LightKind, Pose, Rgb, RunContext, Size};
use glam::DVec3;

const SIZE: Size = Size {
    width: 320,
    height: 240,
};

fn camera_at(eye: DVec3) -> Camera {
    Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, (60.0, 45.0)).unwrap()
}

fn object(id: u32, position: DVec3, angles_deg: DVec3) -> ObjectState<'static> {
    ObjectState {
        id: ObjectId(id),
        name: "object",
        description: DescriptionId(0),
        path: Path::new("ball"),
        pose: Pose {
            position,
            angles_deg,
        },
        motion: Motion::default(),
    }
}

fn frame(number: u32, camera: Camera, objects: Vec<ObjectState<'static>>) -> FrameState<'static> {
    FrameState {
        number,
        camera,
        eye_velocity: DVec3::ZERO,
        aim: camera.eye + camera.forward,
        aim_velocity: DVec3::ZERO,
        lights: &[],
        shadows: false,
        background: Rgb::default(),
        antialias: None,
        sky: None,
        objects,
    }
}

/// A film of one object that goes from frame to frame, before an observer at
/// the origin who looks along z.
fn one(places: &[DVec3]) -> Vec<FrameState<'static>> {
    (10..)
        .zip(places)
        .map(|(n, &place)| {
            frame(
                n,
                camera_at(DVec3::ZERO),
                vec![object(0, place, DVec3::ZERO)],
            )
        })
        .collect()
}

fn rule(threshold_px: f64) -> Rule {
    Rule {
        threshold_px,
        measure: Measure::Bound,
        size: SIZE,
    }
}

fn judged(frames: &[FrameState<'_>], bounds: Bounds, threshold_px: f64) -> Segmented {
    let mut all = segment(frames, |_| bounds, &rule(threshold_px));
    assert_eq!(all.len(), 1);
    all.remove(0)
}

fn ball(radius: f64) -> Bounds {
    Bounds::sphere(DVec3::ZERO, radius)
}

#[test]
fn what_stays_is_immobile() {
    let there = DVec3::new(1.0, 0.0, 10.0);
    for bounds in [ball(1.0), Bounds::Unbounded, ball(100.0)] {
        let found = judged(&one(&[there; 5]), bounds, 0.0);
        assert_eq!(
            (found.class, &found.reason),
            (Class::Immobile, &Reason::Still)
        );
        assert_eq!(found.motion_px, 0.0);
    }
}

#[test]
fn what_flies_with_its_pilot_is_not_immobile() {
    // A cockpit keeps its place before the observer, but the lights and the
    // world do not.
    let frames: Vec<_> = (0..3)
        .map(|n| {
            let eye = DVec3::X * f64::from(n);
            frame(
                n,
                camera_at(eye),
                vec![object(0, eye + DVec3::Z * 5.0, DVec3::ZERO)],
            )
        })
        .collect();
    let found = judged(&frames, ball(1.0), 1.0);
    assert_eq!(found.class, Class::Slow, "{}", found.reason);
}

#[test]
fn little_and_far_motion_are_told_apart_by_the_threshold() {
    // At 277 pixels of focal length, 0.03 at a distance of 10 is 0.8 pixels.
    let frames = one(&[DVec3::Z * 10.0, DVec3::new(0.03, 0.0, 10.0)]);
    let slow = judged(&frames, ball(1.0), 1.2);
    assert_eq!(slow.class, Class::Slow);
    assert!((0.83..1.2).contains(&slow.motion_px), "{}", slow.motion_px);
    assert!(
        slow.reason.to_string().starts_with("moved "),
        "{}",
        slow.reason
    );
    let fast = judged(&frames, ball(1.0), 0.5);
    assert_eq!(fast.class, Class::Fast);
    assert!(
        fast.reason
            .to_string()
            .contains("px > 0.5 px until frame 11"),
        "{}",
        fast.reason
    );
    // Nothing that moves is slow at a threshold of 0.
    assert_eq!(judged(&frames, ball(1.0), 0.0).class, Class::Fast);
}

#[test]
fn every_frame_is_looked_at_and_not_the_end_alone() {
    // There and back again: the end is where the start was.
    let frames = one(&[DVec3::Z * 10.0, DVec3::new(3.0, 0.0, 10.0), DVec3::Z * 10.0]);
    let found = judged(&frames, ball(1.0), 5.0);
    assert_eq!(found.class, Class::Fast);
    assert!(
        found.reason.to_string().contains("until frame 11"),
        "{}",
        found.reason
    );
    // The same for a full turn on the way to nothing.
    let turned: Vec<_> = [0.0, 180.0, 360.0]
        .iter()
        .zip(0..)
        .map(|(&angle, n)| {
            frame(
                n,
                camera_at(DVec3::ZERO),
                vec![object(0, DVec3::Z * 10.0, DVec3::Y * angle)],
            )
        })
        .collect();
    assert_eq!(judged(&turned, ball(1.0), 5.0).class, Class::Fast);
}

#[test]
fn out_of_view_all_the_time_is_clipped() {
    let far_left = DVec3::new(-100.0, 0.0, 10.0);
    let found = judged(
        &one(&[far_left, far_left - DVec3::X * 50.0]),
        ball(1.0),
        1.0,
    );
    assert_eq!(
        (found.class, &found.reason),
        (Class::Clipped, &Reason::OutOfView)
    );
    let behind = judged(&one(&[DVec3::Z * -5.0, DVec3::Z * -9.0]), ball(1.0), 1.0);
    assert_eq!(behind.class, Class::Clipped);
}

#[test]
fn crossing_the_view_between_two_ends_that_are_outside_is_not_clipped() {
    let (left, right) = (DVec3::new(-100.0, 0.0, 10.0), DVec3::new(100.0, 0.0, 10.0));
    let found = judged(&one(&[left, right]), ball(1.0), 1.0);
    assert_eq!(found.class, Class::Fast);
}

#[test]
fn filling_the_view_is_not_clipped() {
    let found = judged(&one(&[DVec3::Z * 10.0, DVec3::Z * 10.5]), ball(9.4), 1.0);
    assert_eq!(found.class, Class::Fast);
}

#[test]
fn entering_the_view_names_the_frame() {
    let places: Vec<DVec3> = (0..12)
        .map(|k| DVec3::new(-40.0 + 4.0 * f64::from(k), 0.0, 10.0))
        .collect();
    let found = judged(&one(&places), ball(1.0), 1.0);
    assert_eq!(found.class, Class::Fast);
    let Reason::EntersView { frame } = found.reason else {
        panic!("{}", found.reason)
    };
    // At z = 10 the view ends at −5.77; the ball of radius 1 is seen from −6.9
    // on: after −8, on the way to −4, in the tenth frame.
    assert_eq!(frame, 19);
}

#[test]
fn an_observer_inside_and_an_ellipse_without_end() {
    let inside = judged(&one(&[DVec3::Z, DVec3::Z * 1.1]), ball(5.0), 1.0);
    assert_eq!(inside.class, Class::Fast);
    assert_eq!(inside.reason.to_string(), "observer inside in frame 10");
    let beside = DVec3::new(2.0, 0.0, 1.0);
    let unbounded = judged(&one(&[beside, beside * 1.01]), ball(2.0), 1.0);
    assert_eq!(unbounded.class, Class::Fast);
    assert_eq!(
        unbounded.reason.to_string(),
        "unbounded ellipse in frame 10"
    );
    assert_eq!(unbounded.motion_px, f64::INFINITY);
}

#[test]
fn endless_and_empty_objects() {
    let frames = one(&[DVec3::ZERO, DVec3::Y]);
    let plane = judged(&frames, Bounds::Unbounded, 1e9);
    assert_eq!(
        (plane.class, &plane.reason),
        (Class::Fast, &Reason::Endless)
    );
    let nothing = judged(&frames, Bounds::Empty, 0.0);
    assert_eq!(
        (nothing.class, &nothing.reason),
        (Class::Clipped, &Reason::Empty)
    );
}

#[test]
fn who_comes_goes_or_changes_is_fast() {
    let here = DVec3::Z * 10.0;
    let still = |n: u32, ids: &[u32]| {
        let objects = ids
            .iter()
            .map(|&id| object(id, here, DVec3::ZERO))
            .collect();
        frame(n, camera_at(DVec3::ZERO), objects)
    };
    // 0 stays, 1 goes, 2 comes, 3 is away for a while; the order changes too.
    let frames = [
        still(0, &[0, 1, 3]),
        still(1, &[2, 0]),
        still(2, &[3, 2, 0]),
    ];
    let all = segment(&frames, |_| ball(1.0), &rule(1.0));
    let classes: Vec<(u32, Class)> = all.iter().map(|s| (s.object.0, s.class)).collect();
    assert_eq!(
        classes,
        [
            (0, Class::Immobile),
            (1, Class::Fast),
            (2, Class::Fast),
            (3, Class::Fast)
        ]
    );
    assert_eq!(all[1].reason.to_string(), "is not there in frame 1");
    assert_eq!(all[2].reason.to_string(), "is not there in frame 0");

    let mut changed = [still(0, &[0]), still(1, &[0])];
    changed[1].objects[0].description = DescriptionId(7);
    let found = judged(&changed, ball(1.0), 1.0);
    assert_eq!(found.reason, Reason::Changes { frame: 1 });
}

#[test]
fn a_light_that_changes_keeps_nothing() {
    let lights = [Light {
        position: DVec3::ZERO,
        colour: Rgb([1.0; 3]),
        kind: LightKind::Point,
        fade: None,
    }];
    let mut frames = one(&[DVec3::Z * 10.0; 2]);
    frames[1].lights = &lights;
    let found = judged(&frames, ball(1.0), 1.0);
    assert_eq!(
        (found.class, &found.reason),
        (Class::Fast, &Reason::SurroundingsChange)
    );
}

#[test]
fn numbers_out_of_the_world_are_fast_and_never_nan() {
    let wild = [f64::MAX, f64::MIN_POSITIVE, 1e300, 1e-300, 1e8, -1e8, 0.0];
    for &a in &wild {
        for &b in &wild {
            for bounds in [
                ball(0.0),
                ball(1e-12),
                ball(1.0),
                ball(1e300),
                Bounds::Unbounded,
            ] {
                let frames = one(&[DVec3::new(a, b, 1.0), DVec3::new(b, a, 1.0 + 1e-6)]);
                for threshold in [0.0, 1e-9, 1e9] {
                    let found = judged(&frames, bounds, threshold);
                    assert!(!found.motion_px.is_nan());
                    let unbounded = found.motion_px == f64::INFINITY;
                    assert!(!unbounded || found.class == Class::Fast, "{found:?}");
                }
            }
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let frames: Vec<_> = (0..4)
        .map(|n| {
            let objects = (0..5_000)
                .map(|k| {
                    let at = |m: u32| f64::from(k * m % 997) / 50.0 - 10.0;
                    let place = DVec3::new(at(7), at(13), at(29) + 12.0);
                    object(k, place, DVec3::Y * f64::from(n * (k % 3)))
                })
                .collect();
            frame(n, camera_at(DVec3::Z * 0.02 * f64::from(n)), objects)
        })
        .collect();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| segment(&frames, |_| ball(0.3), &rule(1.0)))
    };
    let one_thread = with(1);
    assert!(
        Class::ALL[1..]
            .iter()
            .all(|class| one_thread.iter().any(|s| s.class == *class))
    );
    assert_eq!(one_thread, with(4));
}

/// The bundled cloud of ladybirds, with the in-process renderer.
fn ladybirds() -> Stage {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/ladybirds/ladybirds.anim");
    let film = film::read(&path, false).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let run = RunContext::new(folder.path());
    let adapter = Arc::new(decor_reference::Reference::new());
    Stage::set(film, adapter, false, &Cache::disabled(), &run).unwrap()
}

#[test]
fn no_point_of_a_slow_ladybird_moves_farther_than_the_threshold() {
    let stage = ladybirds();
    for (threshold_px, measure) in [
        (1.0, Measure::Bound),
        (4.0, Measure::Bound),
        (4.0, Measure::Thesis),
    ] {
        let wishes = Wishes {
            mode: Mode::Equivalent,
            threshold_px,
            measure,
            period: Some(3),
            budget: None,
            shadow_way: decor::plan::ShadowWay::Auto,
            frames: (0, 24),
            with_depth: false,
            fallback: false,
        };
        let plan = plan(&stage, wishes, &decor::plan::Costs::default()).unwrap();
        let (mut slow, mut largest, mut dissolves) = (0, 0.0_f64, 0);
        for period in plan.periods.iter().filter(|p| p.whole.is_none()) {
            let first = stage.film.frame(period.start);
            for number in period.numbers() {
                let now = stage.film.frame(number);
                // A pixel may show what the object was in the first frame, or what
                // it will be in the one that the décor dissolves towards.
                let until = period.dissolve_until.map(|n| stage.film.frame(n));
                dissolves += usize::from(until.is_some());
                for s in period.objects.iter().filter(|s| s.class == Class::Slow) {
                    slow += 1;
                    let find = |state: &FrameState<'_>| {
                        let object = state.objects.iter().find(|o| o.id == s.object).unwrap();
                        (object.pose, stage.prototype(object).bounds)
                    };
                    let (pose, bounds) = find(&now);
                    let sphere = *bounds.as_sphere().unwrap();
                    for end in std::iter::once(&first).chain(&until) {
                        let shown = find(end).0;
                        largest = largest.max(farthest(&stage, end, shown, &now, pose, sphere));
                    }
                }
            }
        }
        println!(
            "{measure:?}, threshold {threshold_px}: {slow} slow, largest motion {largest:.3} px"
        );
        assert!(slow > 0, "nothing is slow: the test shows nothing");
        assert!(dissolves > 0, "no décor dissolves: the test shows less");
        if measure == Measure::Bound {
            assert!(largest <= threshold_px, "{largest} px");
        }
    }
}

/// The largest motion in the picture of points on and in a sphere.
fn farthest(
    stage: &Stage,
    first: &FrameState<'_>,
    before: Pose,
    now: &FrameState<'_>,
    after: Pose,
    sphere: decor_api::Sphere,
) -> f64 {
    let mut largest = 0.0_f64;
    for k in 0..200 {
        // Points evenly over the sphere, on a spiral.
        let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / 200.0;
        let turn = f64::from(k) * 2.399_963;
        let flat = (1.0 - z * z).sqrt();
        let unit = DVec3::new(flat * turn.cos(), flat * turn.sin(), z);
        let point = sphere.centre + unit * sphere.radius;
        let see = |state: &FrameState<'_>, pose: Pose| {
            state
                .camera
                .project(stage.size(), pose.transform().transform_point3(point))
        };
        if let (Some(a), Some(b)) = (see(first, before), see(now, after)) {
            largest = largest.max((b.0 - a.0).hypot(b.1 - a.1));
        }
    }
    largest
}
