//! Objects as the program meets them: the files of `fixtures/objects`, and
//! fragments that a real renderer is asked about.

use std::path::{Path, PathBuf};

use decor::objects::{Cache, Library, ObjectProblem};
use decor_api::{Adapter, Bounds, RunContext};
use glam::{DVec3, dvec3};

fn load(
    folder: &Path,
    paths: &[&str],
    adapter: &dyn Adapter,
    cache: &Cache,
) -> Result<Library, decor::objects::ObjectError> {
    let work = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = paths.iter().map(PathBuf::from).collect();
    let run = RunContext::new(work.path());
    Library::load(folder, &paths, &[], false, adapter, cache, &run)
}

#[test]
fn the_fixtures_are_read_without_any_renderer() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/objects");
    let adapter = decor_reference::Reference::new();
    let paths = [
        "snowman",
        "cube.obj",
        "cube.ply",
        "tetrahedron.stl",
        "tetrahedron.gltf",
    ];
    let library = load(&folder, &paths, &adapter, &Cache::disabled()).unwrap();
    let spheres = [
        ("snowman", dvec3(-0.1621, 0.9193, 0.0), 1.9335),
        ("cube.obj", DVec3::ZERO, 3.0_f64.sqrt()),
        ("cube.ply", DVec3::ZERO, 3.0_f64.sqrt()),
        (
            "tetrahedron.stl",
            DVec3::splat(1.0 / 3.0),
            (2.0 / 3.0_f64).sqrt(),
        ),
        ("tetrahedron.gltf", dvec3(12.7551, 1.6327, 0.2653), 3.6422),
    ];
    assert_eq!(library.table.len(), spheres.len());
    for (path, centre, radius) in spheres {
        let prototype = library.table.get(library.by_path[Path::new(path)]);
        let sphere = prototype.bounds.as_sphere().expect("bounded");
        assert!(
            (sphere.centre - centre).length() < 1e-3,
            "{path}: {sphere:?}"
        );
        assert!((sphere.radius - radius).abs() < 1e-3, "{path}: {sphere:?}");
    }
}

#[test]
fn a_renderer_measures_fragments_once() {
    let Ok(povray) = decor_povray::PovRay::find() else {
        // Without POV-Ray there is nobody to ask.
        return;
    };
    let film = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(film.path().join("cache"));
    let write = |name: &str, text: &str| std::fs::write(film.path().join(name), text).unwrap();
    write("ball.inc", "sphere { <1, 2, 3>, 4 pigment { rgb 1 } }");
    write(
        "stated.inc",
        "// bounds: 0 0 0 9\nbox { -1, 1 pigment { rgbt 0.5 } }",
    );
    write("broken.inc", "sphere { <1, 2, 3>, }");

    let library = load(film.path(), &["ball", "stated"], &povray, &cache).unwrap();
    let bounds = |path: &str| library.table.get(library.by_path[Path::new(path)]).bounds;
    let ball = *bounds("ball").as_sphere().expect("bounded");
    let reach = (ball.centre - dvec3(1.0, 2.0, 3.0)).length() + 4.0;
    assert!(reach <= ball.radius, "{ball:?}");
    assert!(ball.radius < 4.0 * 3.0_f64.sqrt() * 1.01, "{ball:?}");
    assert_eq!(bounds("stated"), Bounds::sphere(DVec3::ZERO, 9.0));

    // A renderer that is not there cannot have been asked.
    let version = povray.abilities().version.clone();
    let absent = decor_povray::PovRay::new("/no/such/program".into(), &version);
    load(film.path(), &["ball", "stated"], &absent, &cache).unwrap();

    // Every good fragment is known after a bad one was met.
    write("late.inc", "sphere { 0, 1 pigment { rgb 1 } }");
    let error = load(film.path(), &["late", "broken", "ball"], &povray, &cache).unwrap_err();
    let [ObjectProblem::Inspection { paths, .. }] = &error.problems[..] else {
        panic!("{error:?}");
    };
    assert_eq!(paths, &[PathBuf::from("broken")]);
    load(film.path(), &["late"], &absent, &cache).unwrap();
}
