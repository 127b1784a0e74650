use std::fs;
use std::sync::Mutex;
use std::sync::atomic::Ordering;

use decor_api::{
    Abilities, Baseline, DepthKind, Health, Layer, LayerRequest, SceneText, Surroundings,
};
use glam::DVec3;

use super::super::error::with_causes;
use super::*;

/// Says of a fragment what its text says: `radius N`, `glass`, `clock`, `bad`.
struct Fake {
    abilities: Abilities,
    /// The texts of every call.
    calls: Mutex<Vec<Vec<String>>>,
}

impl Fake {
    fn new() -> Self {
        Self {
            abilities: Abilities {
                version: "1".into(),
                csg: true,
                fragments: &["inc", "pov"],
                depth_with_colour: true,
                depth: DepthKind::AlongRay,
                sample_position: (0.5, 0.5),
                crop_grid: None,
                block_mask: false,
                finest_block: decor_api::BLOCK,
                masks_in_crops: false,
                hidden_casters: false,
                ray_list: false,
                coverage: false,
                shadows: false,
                optics: false,
                jobs: 1,
                call_overhead_s: 0.0,
                picture_cpu_s: 0.0,
                units: "none",
            },
            calls: Mutex::default(),
        }
    }

    fn calls(&self) -> usize {
        self.calls.lock().unwrap().len()
    }
}

impl Adapter for Fake {
    fn name(&self) -> &'static str {
        "fake"
    }

    fn abilities(&self) -> &Abilities {
        &self.abilities
    }

    fn scene_text(&self, _: &LayerRequest<'_>) -> Result<SceneText, AdapterError> {
        unimplemented!()
    }

    fn render(&self, _: &LayerRequest<'_>, _: &RunContext) -> Result<Vec<Layer>, AdapterError> {
        unimplemented!()
    }

    fn inspect(
        &self,
        fragments: &[&Fragment],
        _: &[NativeFile],
        run: &RunContext,
    ) -> Result<Vec<Said>, AdapterError> {
        let text = |f: &Fragment| String::from_utf8_lossy(&f.file.text).into_owned();
        let texts: Vec<String> = fragments.iter().map(|f| text(f)).collect();
        self.calls.lock().unwrap().push(texts.clone());
        if run.is_cancelled() {
            return Err(AdapterError::Cancelled);
        }
        if texts.iter().any(|text| text.contains("bad")) {
            return Err(AdapterError::Failed {
                program: "fake".into(),
                status: "exit status: 1".into(),
                doing: "a look".into(),
                stderr: "parse error".into(),
            });
        }
        let said = |text: &String| {
            let radius = text.split("radius ").nth(1).and_then(|n| {
                let number = n.split_whitespace().next()?;
                number.parse().ok()
            });
            Said {
                extents: Vec::new(),
                bounds: radius.map_or(Bounds::Unbounded, |r| Bounds::sphere(DVec3::X, r)),
                optics: if text.contains("glass") {
                    Optics::Optical("glass".into())
                } else {
                    Optics::Opaque
                },
                unlayerable: text.contains("clock").then(|| "it uses clock".into()),
            }
        };
        Ok(texts.iter().map(said).collect())
    }

    fn surroundings(
        &self,
        _: &[NativeFile],
        _: Option<&NativeFile>,
    ) -> Result<Surroundings, AdapterError> {
        unimplemented!()
    }

    fn baseline(
        &self,
        _: &Baseline<'_>,
        _: &RunContext,
    ) -> Result<Vec<(u32, PathBuf)>, AdapterError> {
        unimplemented!()
    }

    fn encode(&self, _: f32, _: u32) -> u32 {
        unimplemented!()
    }

    fn health(&self, _: &RunContext) -> Health {
        unimplemented!()
    }
}

/// A film's folder, a cache and a renderer.
struct Film {
    folder: tempfile::TempDir,
    cache: Cache,
    run: RunContext,
    adapter: Fake,
    includes: Vec<NativeFile>,
    allow_outside: bool,
}

impl Film {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let film = Self {
            cache: Cache::in_folder(folder.path().join("cache")),
            run: RunContext::new(folder.path()),
            adapter: Fake::new(),
            includes: Vec::new(),
            allow_outside: false,
            folder,
        };
        for (name, text) in files {
            film.write(name, text);
        }
        film
    }

    fn root(&self) -> PathBuf {
        self.folder.path().join("film")
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.root().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    fn load(&self, paths: &[&str]) -> Result<Library, ObjectError> {
        let paths: Vec<PathBuf> = paths.iter().map(PathBuf::from).collect();
        Library::load(
            &self.root(),
            &paths,
            &self.includes,
            self.allow_outside,
            &self.adapter,
            &self.cache,
            &self.run,
        )
    }
}

fn prototype<'a>(library: &'a Library, path: &str) -> &'a Prototype {
    library.table.get(library.by_path[Path::new(path)])
}

const TRIANGLE: &str = "v 0 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n";

#[test]
fn each_kind_is_read() {
    let film = Film::new(&[
        ("a.inc", "radius 2"),
        ("b.ron", "sphere(radius: 3)"),
        ("meshes/c.obj", TRIANGLE),
        ("d.ron", "scale(2, mesh(\"meshes/c.obj\"))"),
    ]);
    let library = film
        .load(&["a.inc", "b.ron", "meshes/c.obj", "d.ron"])
        .unwrap();
    assert_eq!(library.table.len(), 4);
    let order: Vec<&Path> = library.table.iter().map(|(_, p)| &*p.path).collect();
    assert_eq!(
        order,
        ["a.inc", "b.ron", "meshes/c.obj", "d.ron"].map(Path::new)
    );

    let a = prototype(&library, "a.inc");
    let Geometry::Fragment(fragment) = &a.geometry else {
        panic!("{a:?}");
    };
    assert_eq!(fragment.language, "inc");
    assert_eq!(fragment.file.text, b"radius 2");
    assert!(fragment.file.path.is_absolute());
    assert_eq!(a.bounds, Bounds::sphere(DVec3::X, 2.0));

    let radius = |path| prototype(&library, path).bounds.as_sphere().unwrap().radius;
    assert!((radius("b.ron") - 3.0).abs() < 1e-9);
    assert!((radius("meshes/c.obj") - 2.0_f64.sqrt()).abs() < 1e-9);
    assert!((radius("d.ron") - 8.0_f64.sqrt()).abs() < 1e-9);
    let c = prototype(&library, "meshes/c.obj");
    assert!(matches!(&c.geometry, Geometry::Neutral(Csg::Look(m, _)) if *m == Material::default()));
}

#[test]
fn without_an_ending_three_are_tried_in_order() {
    let film = Film::new(&[
        ("x.ron", "sphere(radius: 1)"),
        ("x.pov", "radius 1"),
        ("x.inc", "radius 2"),
        ("y.ron", "sphere(radius: 1)"),
        ("y.pov", "radius 1"),
        ("v1.2.ron", "sphere(radius: 1)"),
    ]);
    let library = film.load(&["x", "y", "v1.2"]).unwrap();
    let language = |path| match &prototype(&library, path).geometry {
        Geometry::Fragment(fragment) => fragment.language.clone(),
        Geometry::Neutral(_) => "ron".into(),
    };
    assert_eq!(["x", "y", "v1.2"].map(language), ["inc", "pov", "ron"]);
}

#[test]
fn the_same_content_is_one_prototype() {
    let film = Film::new(&[
        ("a/x.inc", "radius 2"),
        ("b/x.inc", "radius 2"),
        ("a/ball.ron", "sphere(radius: 1)"),
        ("b/ball.ron", "sphere(radius: 1)"),
        ("a/m.ron", "mesh(\"t.obj\")"),
        ("b/m.ron", "mesh(\"t.obj\")"),
        ("a/t.obj", TRIANGLE),
        ("b/t.obj", "v 0 0 0\nv 3 0 0\nv 0 3 0\nf 1 2 3\n"),
        // What these include is beside each of them.
        ("a/i.inc", "#include \"part.inc\" radius 1"),
        ("b/i.inc", "#include \"part.inc\" radius 1"),
        ("a/part.inc", "1"),
        ("b/part.inc", "2"),
    ]);
    let paths = [
        "a/x", "b/x", "a/x.inc", "a/ball", "b/ball", "a/m", "b/m", "a/i", "b/i",
    ];
    let library = film.load(&paths).unwrap();
    let id = |path: &str| library.by_path[Path::new(path)];
    assert_eq!(id("a/x"), id("b/x"));
    assert_eq!(id("a/x"), id("a/x.inc"));
    assert_eq!(id("a/ball"), id("b/ball"));
    assert_ne!(id("a/m"), id("b/m"));
    assert_ne!(id("a/i"), id("b/i"));
    assert_eq!(library.table.len(), 6);
}

#[test]
fn the_first_line_replaces_the_bounds_alone() {
    let film = Film::new(&[("a.inc", "// bounds: 1 2 3 4.5\r\nglass clock radius 9")]);
    let library = film.load(&["a"]).unwrap();
    let a = prototype(&library, "a");
    assert_eq!(a.bounds, Bounds::sphere(DVec3::new(1.0, 2.0, 3.0), 4.5));
    assert!(a.optics.is_optical());
    assert_eq!(a.unlayerable.as_deref(), Some("it uses clock"));
}

#[test]
fn optics_of_neutral_objects_come_from_their_materials() {
    let film = Film::new(&[
        ("dull.ron", "sphere(radius: 1)"),
        (
            "glass.ron",
            "material((transmission: 0.9), sphere(radius: 1))",
        ),
    ]);
    let library = film.load(&["dull", "glass"]).unwrap();
    assert!(!prototype(&library, "dull").optics.is_optical());
    assert!(prototype(&library, "glass").optics.is_optical());
}

#[test]
fn the_renderer_is_asked_once_for_all_and_then_the_cache() {
    let film = Film::new(&[
        ("a.inc", "radius 2"),
        ("b.inc", "glass"),
        ("c.inc", "clock #include \"c2.inc\""),
        ("c2.inc", "#fopen F \"data.txt\" read"),
        ("data.txt", "1"),
    ]);
    let first = film.load(&["a", "b", "c"]).unwrap();
    assert_eq!(film.adapter.calls(), 1);
    let again = film.load(&["a", "b", "c"]).unwrap();
    assert_eq!(film.adapter.calls(), 1);
    for ((_, a), (_, b)) in first.table.iter().zip(again.table.iter()) {
        assert_eq!(a, b);
    }

    // Whatever it depends on counts, however far away.
    film.write("data.txt", "2");
    film.load(&["a", "b", "c"]).unwrap();
    let asked = film.adapter.calls.lock().unwrap().last().unwrap().clone();
    assert_eq!(asked, ["clock #include \"c2.inc\""]);
}

#[test]
fn includes_and_the_version_are_part_of_the_key() {
    let mut film = Film::new(&[("a.inc", "radius 2")]);
    film.load(&["a"]).unwrap();
    film.includes.push(NativeFile {
        path: film.root().join("colours.inc"),
        root: film.root(),
        text: b"#declare X = 1;".to_vec(),
    });
    film.load(&["a"]).unwrap();
    assert_eq!(film.adapter.calls(), 2);
    film.adapter.abilities.version = "2".into();
    film.load(&["a"]).unwrap();
    assert_eq!(film.adapter.calls(), 3);
    film.load(&["a"]).unwrap();
    assert_eq!(film.adapter.calls(), 3);
}

#[test]
fn what_depends_on_unknown_files_is_not_kept() {
    let film = Film::new(&[("a.inc", "#include concat(\"a\", \"b\") radius 1")]);
    film.load(&["a"]).unwrap();
    film.load(&["a"]).unwrap();
    assert_eq!(film.adapter.calls(), 2);
}

#[test]
fn everything_that_is_wrong_is_said_at_once() {
    let film = Film::new(&[
        ("good.inc", "radius 1"),
        ("bad.inc", "bad"),
        ("worse.inc", "also bad"),
        ("line.inc", "// bounds: 1 2 three 4\n"),
        ("short.inc", "// bounds: 1 2 3"),
        ("negative.inc", "// bounds: 1 2 3 -4"),
        ("text.ron", "union([\n  sphere(radius: 0),\n])"),
        (
            "meshes.ron",
            "union([mesh(\"none.obj\"), mesh(\"../up.obj\"), mesh(\"text.ron\")])",
        ),
        ("empty.obj", ""),
        (
            "lost.gltf",
            include_str!("../../../fixtures/objects/tetrahedron.gltf"),
        ),
        ("notes.txt", "notes"),
    ]);
    fs::create_dir(film.root().join("folder.obj")).unwrap();
    let error = film
        .load(&[
            "good",
            "bad",
            "worse",
            "line",
            "short",
            "negative",
            "text",
            "meshes",
            "empty.obj",
            "lost.gltf",
            "notes.txt",
            "nowhere",
            "nowhere.obj",
            "../out",
            "/abs",
            "folder.obj",
        ])
        .unwrap_err();
    let root = std::path::absolute(film.root()).unwrap();
    let said: Vec<String> = error
        .problems
        .iter()
        .map(|problem| with_causes(problem).replace(&*root.to_string_lossy(), "FILM"))
        .collect();
    insta::assert_snapshot!(said.join("\n"));
    assert!(!error.is_renderer());
    let shown = format!("{:?}", miette::Report::new(error));
    assert!(shown.contains("sphere(radius: 0)"), "{shown}");

    // The good one was found out about on the way.
    let calls = film.adapter.calls();
    film.load(&["good"]).unwrap();
    assert_eq!(film.adapter.calls(), calls);
}

#[test]
fn a_renderer_that_fails_is_not_asked_again() {
    let film = Film::new(&[("a.inc", "radius 1"), ("b.inc", "radius 2")]);
    film.run.cancel.store(true, Ordering::Relaxed);
    let error = film.load(&["a", "b"]).unwrap_err();
    assert!(error.is_cancelled());
    assert!(error.is_renderer());
    assert_eq!(film.adapter.calls(), 1);
}

#[test]
fn other_renderers_fragments_are_refused() {
    let mut film = Film::new(&[("a.inc", "radius 1"), ("b.ron", "sphere(radius: 1)")]);
    film.adapter.abilities.fragments = &[];
    film.load(&["b"]).unwrap();
    let error = film.load(&["a", "b"]).unwrap_err();
    let said = error.problems[0].to_string();
    assert!(said.contains("fake does not read .inc"), "{error}");
    assert_eq!(film.adapter.calls(), 0);
}

#[test]
fn outside_is_allowed_where_it_is_asked_for() {
    let mut film = Film::new(&[("a.ron", "mesh(\"../t.obj\")"), ("../t.obj", TRIANGLE)]);
    let absolute = film.folder.path().join("t.obj");
    let absolute = absolute.to_str().unwrap();
    assert!(film.load(&["a"]).is_err());
    assert!(film.load(&["../t.obj"]).is_err());
    assert!(film.load(&[absolute]).is_err());
    film.allow_outside = true;
    let library = film.load(&["a", "../t.obj", absolute]).unwrap();
    assert_eq!(library.table.len(), 2);
}

#[test]
fn no_objects_are_no_error() {
    let library = Film::new(&[]).load(&[]).unwrap();
    assert!(library.table.is_empty());
}
