//! Fragments are seen within the boxes of their objects, as POV-Ray draws them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use decor::influence::parts;
use decor::silhouette::silhouette;
use decor_api::{
    Adapter, Camera, Extent, Fragment, Geometry, Instance, LayerRequest, LayerShot, NativeFile,
    Output, Pose, Prototype, PrototypeTable, Region, Rgb, RunContext, Scene, Size, Window,
};
use decor_povray::PovRay;
use glam::DVec3;

const SIZE: Size = Size {
    width: 200,
    height: 150,
};

/// Text that is told apart in part, or not at all, and what it includes.
const ODD: &[(&str, &str)] = &[
    (
        "turned",
        "sphere { 4*x, 1 } box { -1, <1,3,1> } rotate 40*z",
    ),
    (
        "by_a_macro",
        "#macro M(A) sphere { A, 1 } #end box { -1, 0 } M(5*y) cone { 0,1, -4*x,0 }",
    ),
    (
        "by_an_include",
        "#include \"placed.txt\" sphere { -6*x, 1 }",
    ),
    (
        "guarded",
        "#ifndef (Seen) #declare Seen = 1; sphere { 3*z, 1 } #end box { 3, 4 }",
    ),
    (
        "in_a_loop",
        "#for (I, 0, 9) sphere { <I-5, sin(I), 0>, 0.3 } #end",
    ),
    (
        "random",
        "#declare S = seed(3); #while (rand(S) < 0.8) sphere { <9*rand(S)-4,0,0>, .4 } #end",
    ),
    (
        "nested",
        "union { sphere { 0, 1 } torus { 3, .2 scale 2 rotate 30 } translate <1,2,3> } disc { 0, y, 2 }",
    ),
    (
        "cut",
        "difference { box { -2, 2 } sphere { 0, 2.4 } } intersection { sphere { 3*x, 2 } box { 2, 9 } }",
    ),
    (
        "a_sweep",
        "sphere_sweep { b_spline 4, <-5,-5,0>,1, <-5,5,0>,1, <5,-5,0>,1, <5,5,0>,1 } sphere { 9*x, .1 }",
    ),
    (
        "named",
        "#declare Ball = sphere { 0, 1 } object { Ball scale <1,4,1> } object { Ball translate -4*x }",
    ),
    (
        "clipped",
        "sphere { 0, 4 clipped_by { box { 0, 5 } } } box { -5, -4 bounded_by { sphere { -4.5, 2 } } }",
    ),
];

fn file(path: PathBuf, text: Vec<u8>) -> Fragment {
    let root = path.parent().unwrap().to_owned();
    Fragment {
        file: NativeFile { path, root, text },
        language: "inc".into(),
    }
}

fn fragments(folder: &Path) -> Vec<(String, Fragment)> {
    std::fs::write(folder.join("placed.txt"), "sphere { 6*x, 2 }").unwrap();
    let odd = ODD.iter().map(|(name, text)| {
        let path = folder.join(format!("{name}.inc"));
        ((*name).to_owned(), file(path, text.as_bytes().to_vec()))
    });
    let films = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let bundled = [
        "plane/plane",
        "plane/truck",
        "plane/tower",
        "plane/fence",
        "plane/windsock",
    ];
    let bundled = bundled.iter().map(|name| {
        let path = films.join(format!("{name}.inc"));
        let text = std::fs::read(&path).unwrap();
        ((*name).to_owned(), file(path, text))
    });
    odd.chain(bundled).collect()
}

fn scene(camera: Camera, instance: Instance) -> Scene {
    Scene {
        camera,
        lights: Vec::new(),
        shadows: false,
        background: Rgb::default(),
        includes: Vec::new(),
        sky: None,
        instances: vec![instance],
        hidden: Vec::new(),
    }
}

fn area(windows: &[Window]) -> usize {
    let inside = |x, y| windows.iter().any(|w| w.contains(x, y));
    let pixels = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
    pixels.filter(|&(x, y)| inside(x, y)).count()
}

#[test]
fn what_povray_draws_lies_within() {
    let folder = tempfile::tempdir().unwrap();
    let run = RunContext::new(folder.path());
    let povray = PovRay::find().expect("POV-Ray is installed");
    let fragments = fragments(folder.path());
    let asked: Vec<&Fragment> = fragments.iter().map(|(_, fragment)| fragment).collect();
    let said = povray.inspect(&asked, &[], &run).unwrap();

    let mut table = PrototypeTable::default();
    let mut shots = Vec::new();
    for ((name, fragment), said) in fragments.iter().zip(&said) {
        let ball = said.bounds.as_sphere().copied();
        let ball = ball.unwrap_or_else(|| panic!("{name} has an end"));
        let prototype = table.insert(Prototype {
            path: name.into(),
            hash: name.clone(),
            geometry: Geometry::Fragment(fragment.clone()),
            bounds: said.bounds,
            extents: said.extents.clone(),
            optics: said.optics.clone(),
            unlayerable: None,
        });
        for angles_deg in [DVec3::ZERO, DVec3::new(50.0, 30.0, -20.0)] {
            let pose = Pose {
                position: DVec3::new(3.0, -2.0, 5.0),
                angles_deg,
            };
            let aim = pose.transform().transform_point3(ball.centre);
            let eye = aim + DVec3::new(0.4, 0.5, -1.0).normalize() * ball.radius * 3.0;
            let camera = Camera::look_at(eye, aim, DVec3::Y, (40.0, 30.0)).unwrap();
            shots.push((name, camera, Instance { prototype, pose }));
        }
    }
    let request = LayerRequest {
        prototypes: &table,
        size: SIZE,
        output: Output::Depth,
        antialias: None,
        shots: (0..)
            .zip(&shots)
            .map(|(frame, (_, camera, instance))| LayerShot {
                frame,
                scene: Arc::new(scene(*camera, *instance)),
                region: Region::Window(SIZE.window()),
            })
            .collect(),
        film: None,
        label: "silhouettes".into(),
    };
    let layers = povray.render(&request, &run).unwrap();
    for ((name, camera, instance), layer) in shots.iter().zip(layers) {
        let prototype = table.get(instance.prototype);
        let balls = parts(prototype);
        let by_boxes = silhouette(prototype, &balls, &instance.pose, camera, SIZE);
        let by_balls = Prototype {
            extents: Vec::new(),
            ..prototype.clone()
        };
        let by_balls = silhouette(&by_balls, &balls, &instance.pose, camera, SIZE);
        let depths = layer.depth.unwrap();
        assert!(depths.iter().any(|d| d.is_finite()), "{name} is to be seen");
        for (pixel, _) in (0_u32..).zip(&depths).filter(|(_, d)| d.is_finite()) {
            let (x, y) = (pixel % SIZE.width, pixel / SIZE.width);
            for windows in [&by_boxes, &by_balls] {
                let inside = windows.iter().any(|w| w.contains(x, y));
                assert!(inside, "{name}: ({x}, {y}) of {windows:?}");
            }
        }
    }

    let boxes = |wanted: &str| {
        let found = fragments
            .iter()
            .zip(&said)
            .find(|((name, _), _)| name == wanted);
        found.unwrap().1.extents.len()
    };
    assert_eq!(
        (boxes("turned"), boxes("by_a_macro"), boxes("cut")),
        (1, 1, 2)
    );
    assert_eq!(
        (boxes("in_a_loop"), boxes("named"), boxes("guarded")),
        (10, 2, 2)
    );

    // An airliner fills little of its box.
    let (_, camera, instance) = shots
        .iter()
        .find(|(name, ..)| *name == "plane/plane")
        .unwrap();
    let told_apart = table.get(instance.prototype);
    let around = |a: Extent, b: &Extent| a.union(b);
    let whole = told_apart
        .extents
        .iter()
        .fold(told_apart.extents[0], around);
    let in_one_piece = Prototype {
        extents: vec![whole],
        ..told_apart.clone()
    };
    let of = |prototype: &Prototype| {
        area(&silhouette(
            prototype,
            &parts(prototype),
            &instance.pose,
            camera,
            SIZE,
        ))
    };
    let (few, all) = (of(told_apart), of(&in_one_piece));
    assert!(few * 10 < all * 6, "{few} of {all} pixels");
}
