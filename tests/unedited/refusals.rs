//! Scenes that break each refusal: rendered whole, identical, with the reason.

use crate::trial::{ALWAYS, both};

const SCENE: &str = "\
#declare Where = <clock * 2 - 1, 0, 0>;
plane { y, -1 pigment { checker rgb 1, rgb .3 } }
sphere { Where, .5 pigment { rgb <1, .4, .2> } }
";
const CAMERA: &str = "camera { location <0, 1, -6> look_at 0 }\n";
const LIGHT: &str = "light_source { <4, 8, -6>, 1 }\n";

/// What a scene has instead of a still camera or light, or more; and a word of the
/// reason.
const CASES: &[(&str, &str, &str)] = &[
    (
        "camera",
        "camera { location <clock, 1, -6> look_at 0 }",
        "camera",
    ),
    (
        "camera",
        "camera { location <0, 1, -6> look_at 0 aperture .2 blur_samples 4 bokeh { pigment { rgb 1 } } }",
        "bokeh",
    ),
    ("light", "light_source { <4, 8 - clock, -6>, 1 }", "light"),
    (
        "light",
        "light_source { <4, 8, -6>, 1 area_light x, y, 2, 2 jitter }",
        "jitter",
    ),
    // Where POV-Ray's own `diffract` has it: its area lights are switched off.
    ("light", "light_source { <4, 8, -6>, 1 jitter }", "jitter"),
    ("", "sky_sphere { pigment { rgb clock } }", "sky_sphere"),
    ("", "background { rgb clock }", "background"),
    ("", "fog { distance 9 + clock rgb .5 }", "fog"),
    ("", "#default { pigment { rgb clock } }", "default"),
    ("", "plane { z, 9 + clock pigment { rgb .5 } }", "end"),
    ("", "global_settings { radiosity { count 4 } }", "radiosity"),
    ("", "global_settings { photons { count 50 } }", "photons"),
    ("", "global_settings { subsurface { } }", "subsurface"),
    (
        "",
        "global_settings { ambient_light clock }",
        "global_settings",
    ),
    (
        "",
        "sphere { <2, 0, 0>, .3 finish { crand .3 } pigment { rgb 1 } }",
        "crand",
    ),
    (
        "",
        "sphere { <2, 0, 0>, .6 hollow pigment { rgbt 1 } interior { media { method 1 emission 1 } } }",
        "media",
    ),
    (
        "",
        "#fopen F \"numbers.txt\" read #read(F, Number) sphere { <Number, 1, 0>, .1 }",
        "read",
    ),
    (
        "",
        "sphere { <mod(now, 1) * 1e-9, 2, 0>, .1 pigment { rgb 1 } }",
        "now",
    ),
    (
        "",
        "#declare Name = concat(\"pa\", \"rt.inc\"); #include Name",
        "computed",
    ),
    (
        "",
        "#include \"strings.inc\" Parse_String(\"sphere { <2, 1, 0>, .2 }\")",
        "Parse_String",
    ),
    (
        "",
        "union { light_source { <clock, 3, 0>, .3 } sphere { <clock, 2, 0>, .1 } }",
        "light",
    ),
    (
        "",
        "difference { box { -.3, .3 pigment { rgbf .8 } } sphere { <0, .3, 0>, .25 pigment { rgb x } } \
         texture { pigment { rgb 1 } } translate 2 * x }",
        "part of glass",
    ),
    (
        "",
        "julia_fractal { <-.083, 0, -.83, -.025> pigment { rgb 1 } scale .3 translate 2 * x }",
        "julia_fractal",
    ),
];

/// `None`: as it should be.
fn wrong(case: &(&str, &str, &str)) -> Option<String> {
    let (instead, text, reason) = *case;
    let mut scene = SCENE.to_owned();
    for (name, usual) in [("camera", CAMERA), ("light", LIGHT)] {
        if instead != name {
            scene.push_str(usual);
        }
    }
    scene.push_str(text);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.pov"), scene).unwrap();
    std::fs::write(folder.path().join("numbers.txt"), "1.5,\n").unwrap();
    std::fs::write(folder.path().join("part.inc"), "sphere { <2, 2, 0>, .2 }\n").unwrap();
    let switches = ["+W64", "+H48", "+KFF3", "-A", "+WT1"];
    let tried = both(
        folder.path(),
        "s.pov",
        &switches,
        ALWAYS,
        &folder.path().join("out"),
    );
    let whole = tried.whole();
    let in_order = tried.summary["in_order"].as_str().unwrap_or_default();
    if !tried.differing.is_empty() {
        return Some(format!("{text}: {:?} differ", tried.differing));
    }
    let said = whole.contains(reason) || in_order.contains(reason);
    (!said || tried.summary["mode"] != "full")
        .then(|| format!("{text}: no `{reason}` in `{whole}`, `{in_order}`"))
}

#[test]
fn each_refusal_renders_whole_and_says_why() {
    let found = std::sync::Mutex::new(Vec::new());
    let next = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..6 {
            scope.spawn(|| {
                while let Some(case) =
                    CASES.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed))
                {
                    found.lock().unwrap().extend(wrong(case));
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A film that needs no coherence says nothing of it.
#[test]
fn what_is_asked_for_whole_gives_no_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{SCENE}{CAMERA}{LIGHT}");
    std::fs::write(folder.path().join("s.pov"), scene).unwrap();
    let switches = ["+W64", "+H48", "+KFF3", "-A"];
    let out = folder.path().join("out");
    let tried = both(folder.path(), "s.pov", &switches, &["--mode", "full"], &out);
    tried.assert_identical("mode full");
    assert_eq!(
        (tried.whole(), &tried.summary["mode"]),
        (String::new(), &"full".into())
    );
    assert!(!tried.stderr.contains("rendered whole"), "{}", tried.stderr);
}

/// Focal blur, and media by method 3: their samples depend on their place alone.
#[test]
fn what_only_looks_random_is_divided() {
    let blurred = "camera { location <0, 1, -6> look_at 0 aperture .3 blur_samples 7 \
                   focal_point <1, 0, 1> variance 1 / 1000 }\n";
    let dust = "sphere { <1.2, .2, .5>, 1.3 hollow pigment { rgbt 1 } interior { media { \
                scattering { 1, .2 } emission .05 density { bozo scale .4 } } } }\n\
                media { scattering { 2, .02 } samples 4 }\n";
    std::thread::scope(|scope| {
        for (camera, more) in [(blurred, ""), (CAMERA, dust), (blurred, dust)] {
            scope.spawn(move || {
                let scene = format!("{SCENE}{camera}{LIGHT}{more}");
                let folder = tempfile::tempdir().unwrap();
                std::fs::write(folder.path().join("s.pov"), scene).unwrap();
                let switches = ["+W128", "+H64", "+KFF3", "+A0.3", "+R2"];
                let out = folder.path().join("out");
                let tried = both(folder.path(), "s.pov", &switches, ALWAYS, &out);
                tried.assert_identical(camera);
                assert_eq!(tried.whole(), "", "{camera}{more}");
                let dirty = tried.summary["dirty_blocks"].as_f64().unwrap();
                assert!(dirty < 0.95, "{camera}{more}: {dirty}");
            });
        }
    });
}

/// Boxes with faces in one plane: which of them is seen hangs on the tree of all
/// objects, and so on where the ball is, though no ray of theirs meets it. Two whole
/// frames tell, as soon as it is known what the ball touches: nothing is traced for
/// frames that cannot come out right.
#[test]
fn what_hangs_on_the_tree_of_objects_is_refused_before_anything_is_traced_for_it() {
    const BOXES: &str = "\
box { <.5, -1, 0>, <1, -.5, 1> pigment { rgb <.5, .3, .2> } }
box { <-.5, -1, 0>, <1, .5, .5> pigment { rgb <.3, .4, .5> } }
box { <0, -.5, 0>, <.5, 0, .5> pigment { rgb <.3, .5, .4> } }
box { <.5, .5, 0>, <1.5, 1.5, 1> pigment { rgb <.8, .2, .2> } }
box { <-1.5, -1.5, 0>, <-1, -1, .5> pigment { rgb <.5, .8, .6> } }
sphere { <-3 + 6 * clock, 1.9, -1>, .2 pigment { rgb y } }
";
    const MIRROR: &str = "plane { z, 9 pigment { rgb .2 } finish { reflection .4 } }\n";
    // What geometry knows without tracing, and what one pass of proxies shows.
    for (more, at_most) in [("", 0), (MIRROR, 160 * 128)] {
        let folder = tempfile::tempdir().unwrap();
        let scene = format!("{CAMERA}{LIGHT}{BOXES}{more}");
        std::fs::write(folder.path().join("s.pov"), scene).unwrap();
        let switches = ["+W160", "+H128", "+KFF9", "-A", "+WT1"];
        let out = folder.path().join("out");
        let tried = both(folder.path(), "s.pov", &switches, ALWAYS, &out);
        tried.assert_identical("coinciding faces");
        let whole = tried.whole();
        assert!(whole.contains("the same in two frames"), "{more}: {whole}");
        let traced = &tried.summary["pixels_traced"];
        assert_eq!(traced["whole"], 9 * 160 * 128, "{traced}");
        assert!(traced["blocks"].as_u64().unwrap() <= at_most, "{traced}");
    }
}
