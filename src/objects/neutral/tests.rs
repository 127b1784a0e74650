use decor_api::{Highlight, Material, Rgb};
use glam::{DVec3, dvec3};
use proptest::prelude::*;

use super::*;

fn csg(text: &str) -> Csg {
    let node = parse(Path::new("test.ron"), text.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    node.into_csg(&mut |path| panic!("mesh {path}"))
}

fn error(text: &str) -> String {
    let error = parse(Path::new("test.ron"), text.as_bytes()).unwrap_err();
    error.to_string()
}

#[test]
fn every_node_is_read() {
    assert_eq!(
        csg("sphere(radius: 2)"),
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 2.0
        }
    );
    assert_eq!(
        csg("box(min: (-1, -1, -1), max: (1, 2, 3.5))"),
        Csg::Box {
            min: DVec3::NEG_ONE,
            max: dvec3(1.0, 2.0, 3.5)
        }
    );
    assert_eq!(
        csg("cylinder(cap: (0, 2, 0), radius: 0.5)"),
        Csg::Cylinder {
            base: DVec3::ZERO,
            cap: dvec3(0.0, 2.0, 0.0),
            radius: 0.5
        }
    );
    assert_eq!(
        csg("cone(base: (0, 1, 0), base_radius: 1, cap: (0, 2, 0))"),
        Csg::Cone {
            base: DVec3::Y,
            base_radius: 1.0,
            cap: dvec3(0.0, 2.0, 0.0),
            cap_radius: 0.0
        }
    );
    assert_eq!(
        csg("torus(major: 2, minor: 0.5)"),
        Csg::Torus {
            major: 2.0,
            minor: 0.5
        }
    );
    assert_eq!(
        csg("plane(normal: (0, 1, 0), distance: -1)"),
        Csg::Plane {
            normal: DVec3::Y,
            distance: -1.0
        }
    );
    let ball = || csg("sphere(radius: 1)");
    assert_eq!(
        csg("union([sphere(radius: 1), sphere(radius: 1)])"),
        Csg::Union(vec![ball(), ball()])
    );
    assert_eq!(
        csg("intersection([sphere(radius: 1),])"),
        Csg::Intersection(vec![ball()])
    );
    assert_eq!(
        csg("difference(sphere(radius: 1), [sphere(radius: 1)])"),
        Csg::Difference(Box::new(ball()), vec![ball()])
    );
    assert_eq!(
        csg("translate((1, 0, 0), sphere(radius: 1))"),
        Csg::Translate(DVec3::X, Box::new(ball()))
    );
    assert_eq!(
        csg("rotate((0, 90, 0), sphere(radius: 1))"),
        Csg::Rotate(dvec3(0.0, 90.0, 0.0), Box::new(ball()))
    );
    assert_eq!(
        csg("scale((1, 2, -3), sphere(radius: 1))"),
        Csg::Scale(dvec3(1.0, 2.0, -3.0), Box::new(ball()))
    );
    for factor in ["2", "2.0", "+2"] {
        assert_eq!(
            csg(&format!("scale({factor}, sphere(radius: 1))")),
            Csg::Scale(DVec3::splat(2.0), Box::new(ball()))
        );
    }
}

#[test]
fn materials_take_what_is_left_out_from_the_default() {
    let material = |text: &str| match csg(&format!("material({text}, sphere(radius: 1))")) {
        Csg::Look(material, _) => material,
        other => panic!("{other:?}"),
    };
    let usual = Material::default();
    assert_eq!(material("()"), usual);
    let red = Rgb([1.0, 0.0, 0.0]);
    assert_eq!(
        material("(colour: (1, 0, 0), phong: (amount: 0.8))"),
        Material {
            colour: red,
            highlight: Highlight::Phong {
                amount: 0.8,
                size: 40.0
            },
            ..usual
        }
    );
    assert_eq!(
        material(
            "(color: (1, 0, 0), ambient: 0, diffuse: 0.5, \
             specular: (amount: 1, roughness: 0.01), \
             reflection: 0.2, transmission: 0.9, ior: 1.5)"
        ),
        Material {
            colour: red,
            ambient: 0.0,
            diffuse: 0.5,
            highlight: Highlight::Specular {
                amount: 1.0,
                roughness: 0.01
            },
            reflection: 0.2,
            transmission: 0.9,
            ior: 1.5,
        }
    );
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let wrong = [
        "spere(radius: 1)",
        "sphere(radius: 0)",
        "sphere(radius: -1)",
        "sphere(radius: inf)",
        "sphere(radius: NaN)",
        "sphere(radius: 1e999)",
        "sphere()",
        "sphere(radius: 1, colour: 3)",
        "sphere(radius: 1) sphere(radius: 1)",
        "sphere(centre: (0, 0), radius: 1)",
        "sphere(centre: (0, 0, 0, 0), radius: 1)",
        "box(min: (0, 0, 0), max: (1, 0, 1))",
        "box(min: (0, 0, 0), max: (1, 1, 1), extra: 0)",
        "cylinder(cap: (0, 0, 0), radius: 1)",
        "cone(cap: (0, 1, 0))",
        "cone(cap: (0, 1, 0), base_radius: -1, cap_radius: 2)",
        "torus(major: 1, minor: 2)",
        "plane(normal: (0, 0, 0))",
        "plane(normal: (1e-200, 0, 0))",
        "union([])",
        "union()",
        "difference(sphere(radius: 1), [])",
        "scale(0, sphere(radius: 1))",
        "scale((1, 0, 1), sphere(radius: 1))",
        "scale((1, 1), sphere(radius: 1))",
        "scale((1, 1, 1, 1), sphere(radius: 1))",
        "rotate((0, 0, inf), sphere(radius: 1))",
        "material((colour: (-1, 0, 0)), sphere(radius: 1))",
        "material((reflection: 1.5), sphere(radius: 1))",
        "material((ior: 0), sphere(radius: 1))",
        "material((phong: (amount: 1), specular: (amount: 1)), sphere(radius: 1))",
        "material((phong: (amount: 1, size: 0)), sphere(radius: 1))",
        "material((specular: (amount: 1, roughness: 2)), sphere(radius: 1))",
        "material((shiny: 1), sphere(radius: 1))",
        "",
        "union([sphere(radius: 1)",
        "mesh(3)",
    ];
    let said: Vec<String> = wrong
        .iter()
        .map(|text| format!("{text}\n    {}\n", error(text)))
        .collect();
    insta::assert_snapshot!(said.join(""));
}

#[test]
fn the_place_is_in_the_right_line() {
    let text = "// é\nunion([\n    sphere(radius: 1),\n    sphere(radius: 0),\n])\n";
    let found = parse(Path::new("a.ron"), text.as_bytes()).unwrap_err();
    assert_eq!(found.line, 4, "{found}");
    let shown = format!("{:?}", miette::Report::new(*found));
    assert!(shown.contains("sphere(radius: 0)"), "{shown}");
}

#[test]
fn deep_nesting_is_an_error_and_not_a_crash() {
    let nest = |depth: usize| {
        let open = "translate((0, 0, 0), ".repeat(depth);
        format!("{open}sphere(radius: 1){}", ")".repeat(depth))
    };
    let nest_unions = |depth: usize| {
        let (open, close) = ("union([".repeat(depth), "])".repeat(depth));
        format!("{open}sphere(radius: 1){close}")
    };
    // Less stack than any thread has.
    let small = std::thread::Builder::new().stack_size(1 << 20);
    let test = move || {
        for deep in [nest(98), nest_unions(98)] {
            let deep = csg(&deep);
            assert_eq!(
                deep.bounds().as_sphere().map(|s| s.radius.round()),
                Some(1.0)
            );
            assert!(!deep.is_optical());
        }
        assert!(error(&nest(100_000)).contains("too deeply"));
        assert!(error(&nest_unions(100_000)).contains("too deeply"));
        for hostile in ["(", "[", "union([", "/*", "Some(", "#![enable(", "\"", "r#"] {
            error(&hostile.repeat(100_000));
        }
    };
    small.spawn(test).unwrap().join().unwrap();
}

#[test]
fn the_example_of_the_documentation_is_read() {
    let source = include_str!("../neutral.rs");
    let lines = source.lines().filter_map(|l| l.strip_prefix("//!"));
    let mut example = lines.skip_while(|l| !l.contains("```ron")).skip(1);
    let text: Vec<&str> = example
        .by_ref()
        .take_while(|l| !l.contains("```"))
        .collect();
    let snowman = csg(&text.join("\n"));
    assert!(matches!(snowman.bounds(), decor_api::Bounds::Sphere(_)));
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = check(Path::new("x.ron"), &bytes);
    }

    #[test]
    fn any_mutation_is_read_without_a_panic(
        at in 0.0..1.0_f64,
        cut in 0_usize..20,
        with in "[a-z(){}\\[\\],:\"0-9.e/*#é-]{0,12}",
    ) {
        let text = include_str!("../../../fixtures/objects/snowman.ron");
        // The text is ASCII: every byte is a character.
        let start = (at * text.len() as f64) as usize;
        let end = (start + cut).min(text.len());
        let mutated = format!("{}{with}{}", &text[..start], &text[end..]);
        if let Err(error) = check(Path::new("x.ron"), mutated.as_bytes()) {
            prop_assert!(error.line <= mutated.lines().count() + 1);
        }
    }
}
