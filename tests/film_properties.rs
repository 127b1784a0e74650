//! Films that nobody wrote by hand: conversion loses nothing, and no text makes
//! a reader panic.

use std::path::Path;

use decor::film::{self, Film, FilmStream, Form};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use serde_json::{Value, json};

/// Any film may name `objects/ball.inc` there.
const FOLDER: &str = "fixtures/broken";

fn parse(form: Form, text: &[u8]) -> Result<Film, film::FilmErrors> {
    let folder = Path::new(FOLDER);
    match form {
        Form::Anim => film::anim::parse("f.anim", text, folder, false),
        Form::JsonLines => film::jsonl::parse("f.jsonl", text, folder, false),
    }
}

/// Any finite number that some frames of motion leave finite.
fn number() -> impl Strategy<Value = f64> {
    use proptest::num::f64 as any;
    let all = any::NORMAL | any::SUBNORMAL | any::ZERO;
    prop_oneof![
        2 => all.prop_filter("finite later", |x| x.abs() < 1e300),
        1 => (-1000_i32..1000).prop_map(|x| f64::from(x) / 8.0),
    ]
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    [number(), number(), number()]
}

/// Coordinates that a camera survives.
fn tame(range: std::ops::Range<f64>) -> impl Strategy<Value = [f64; 3]> {
    [range.clone(), range.clone(), range]
}

fn point(z: std::ops::Range<f64>) -> impl Strategy<Value = Value> {
    let velocity = option::of(tame(-1e-3..1e-3));
    (tame(-1.0..1.0), z, velocity).prop_map(|([x, y, _], z, velocity)| {
        let mut value = json!({"position": [x, y, z]});
        if let Some(velocity) = velocity {
            value["velocity"] = json!(velocity);
        }
        value
    })
}

fn light() -> impl Strategy<Value = Value> {
    let shape = prop_oneof![
        Just(json!({"type": "point"})),
        Just(json!({"type": "sun"})),
        vector().prop_map(|towards| json!({"type": "sun", "towards": towards})),
        (vector(), 0.0..30.0, 30.0..90.0, 0.0..100.0).prop_map(|(towards, r, f, t)| {
            json!({"type": "spot", "towards": towards, "radius": r, "falloff": f, "tightness": t})
        }),
        (1_u32..65535, 1_u32..65535).prop_map(|(nu, nv)| {
            json!({"type": "area", "u": [1e-3, 0, 0], "v": [0, -0.0, 1e9], "nu": nu, "nv": nv})
        }),
    ];
    let fade = option::of((1e-9..1e9, 0.0..5.0));
    (shape, vector(), tame(0.0..2.0), fade).prop_map(|(mut light, position, colour, fade)| {
        light["position"] = json!(position);
        light["colour"] = json!(colour);
        if let Some((distance, power)) = fade {
            light["fade"] = json!({"distance": distance, "power": power});
        }
        light
    })
}

fn object() -> impl Strategy<Value = Value> {
    let path = prop_oneof![
        Just("objects/ball.inc"),
        Just("objects/ball"),
        Just("./objects/../objects/ball.inc")
    ];
    let name = option::of("[a-zé#= ]{1,6}");
    let motion = option::of([vector(), vector()]);
    (path, name, vector(), vector(), motion).prop_map(|(path, name, position, angles, motion)| {
        let mut object = json!({"path": path, "position": position, "angles": angles});
        if let Some(name) = name {
            object["name"] = json!(name);
        }
        if let Some([velocity, angles_velocity]) = motion {
            object["velocity"] = json!(velocity);
            object["angles_velocity"] = json!(angles_velocity);
        }
        object
    })
}

/// Some of a scene's fields; objects of one name are one too many.
fn scene() -> impl Strategy<Value = Value> {
    let environment = (
        option::of(point(-90.0..-10.0)),
        option::of(point(10.0..90.0)),
        option::of(Just(json!([0.1, 1, -0.0]))),
        option::of([1e-3..179.9, 1e-3..179.9]),
        option::of(any::<bool>()),
        option::of(tame(0.0..1.0)),
        option::of(prop_oneof![
            Just(json!("off")),
            (0.0..3.0, 1..=9).prop_map(|(t, d)| json!({"threshold": t, "depth": d})),
        ]),
        option::of(Just(json!("objects/ball.inc"))),
    );
    let lists = (
        vec(light(), 0..3),
        vec(object(), 0..4),
        vec(Just("objects/ball.inc"), 0..3),
        any::<bool>(),
    );
    (environment, lists).prop_map(|(environment, (lights, objects, includes, size))| {
        let (eye, aim, up, angles, shadows, background, antialias, sky) = environment;
        let mut scene = json!({});
        let mut set = |key: &str, value: Option<Value>| {
            if let Some(value) = value {
                scene[key] = value;
            }
        };
        set("eye", eye);
        set("aim", aim);
        set("up", up);
        set("angles", angles.map(|a| json!(a)));
        set("shadows", shadows.map(|s| json!(s)));
        set("background", background.map(|b| json!(b)));
        set("antialias", antialias);
        set("sky", sky);
        set("size", size.then(|| json!([320, 200])));
        let list = |list: Vec<Value>| (!list.is_empty()).then_some(Value::Array(list));
        set("lights", list(lights));
        let mut names = std::collections::HashSet::new();
        let mut objects = objects;
        objects.retain(|o| o["name"].is_null() || names.insert(o["name"].to_string()));
        set("objects", list(objects));
        set(
            "include",
            list(includes.into_iter().map(|i| json!(i)).collect()),
        );
        scene
    })
}

/// A film that is right, as JSON lines.
fn film_text() -> impl Strategy<Value = String> {
    let images = option::of(50_u32..60);
    (vec((1_u32..5, scene()), 1..8), images).prop_map(|(scenes, images)| {
        let mut number = 0;
        let mut text = String::new();
        for (i, (step, mut scene)) in scenes.into_iter().enumerate() {
            number += step;
            scene["scene"] = json!(number);
            if i == 0 {
                let first = json!({
                    "eye": {"position": [0, 0, -20]},
                    "aim": {"position": [0, 0, 20]},
                    "angles": [60, 45.5],
                    "size": [320, 200],
                });
                for (key, value) in first.as_object().into_iter().flatten() {
                    if scene[key].is_null() {
                        scene[key] = value.clone();
                    }
                }
                if let Some(images) = images {
                    scene["frames"] = json!(images);
                }
            }
            text += &format!("{scene}\n");
        }
        text
    })
}

/// Words that a reader knows, in no order.
fn soup() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        prop::sample::select(vec![
            "@",
            "@0",
            "@1",
            "@2",
            "*",
            "*eye",
            "*aim",
            "*up",
            "*angles",
            "*ombres",
            "*size",
            "*source",
            "*fond",
            "*antialias",
            "*images",
            "*include",
            "*sky",
            "!",
            "!objects/ball",
            "name=b",
            "\"",
            "#",
            "\n",
            "\n",
            "\n",
            "\r",
            " ",
            "0",
            "1",
            "-1",
            "0.5",
            "1e308",
            "fade",
            "spot",
            "sun",
            "area",
            "point",
            "off",
            "é",
            "{",
            "}",
            "[",
            "]",
            ",",
            ":",
            "\"scene\"",
            "\"eye\"",
            "\"position\"",
            "\"objects\"",
            "null",
            "\\",
        ])
        .prop_map(str::to_owned),
        number().prop_map(|x| x.to_string()),
    ];
    vec(word, 0..60).prop_map(|words| words.join(" "))
}

#[derive(Clone, Debug)]
enum Mutation {
    Remove(usize, usize),
    Insert(usize, Vec<u8>),
    Copy(usize, usize, usize),
    SwapLines(usize, usize),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    let place = || any::<prop::sample::Index>().prop_map(|i| i.index(1 << 20));
    let text = prop_oneof![
        vec(any::<u8>(), 1..4),
        prop::sample::select(vec![
            "\"", "\n", "-", "0", "1e999", " ", "@0\n", "}", "null", "#"
        ])
        .prop_map(|text| text.as_bytes().to_vec()),
    ];
    prop_oneof![
        (place(), 1_usize..20).prop_map(|(at, n)| Mutation::Remove(at, n)),
        (place(), text).prop_map(|(at, text)| Mutation::Insert(at, text)),
        (place(), place(), 1_usize..50).prop_map(|(a, b, n)| Mutation::Copy(a, b, n)),
        (place(), place()).prop_map(|(a, b)| Mutation::SwapLines(a, b)),
    ]
}

fn mutate(text: &mut Vec<u8>, mutation: &Mutation) {
    let within = |place: usize, length: usize| if length == 0 { 0 } else { place % length };
    match mutation {
        Mutation::Remove(at, n) => {
            let at = within(*at, text.len());
            let end = (at + n).min(text.len());
            text.drain(at..end);
        }
        Mutation::Insert(at, bytes) => {
            let at = within(*at, text.len());
            text.splice(at..at, bytes.iter().copied());
        }
        Mutation::Copy(from, to, n) => {
            let (from, to) = (within(*from, text.len()), within(*to, text.len()));
            let piece = text[from..(from + n).min(text.len())].to_vec();
            text.splice(to..to, piece);
        }
        Mutation::SwapLines(a, b) => {
            let mut lines: Vec<&[u8]> = text.split(|b| *b == b'\n').collect();
            let (a, b) = (within(*a, lines.len()), within(*b, lines.len()));
            lines.swap(a, b);
            *text = lines.join(&b'\n');
        }
    }
}

/// Reads the text in both forms and as a stream. What is accepted must hold.
fn read_all_ways(text: &[u8]) {
    for form in [Form::Anim, Form::JsonLines] {
        match parse(form, text) {
            Ok(film) => check(&film),
            Err(errors) => {
                assert!(!errors.errors().is_empty());
                // Messages must not panic either.
                let _ = format!("{:?}", miette::Report::new(errors));
            }
        }
    }
    let mut stream = FilmStream::new("stdin", Path::new(FOLDER), false);
    for line in text.split_inclusive(|b| *b == b'\n') {
        if let Ok(Some(frames)) = stream.push_line(line) {
            for n in frames.take(10) {
                assert!(stream.frame(n).is_some());
            }
        }
    }
    let _ = stream.finish();
}

/// What every film promises.
fn check(film: &Film) {
    let (first, last) = film.frames().into_inner();
    for number in [first, first.midpoint(last), last] {
        let frame = film.frame(number);
        assert!(frame.camera.eye.is_finite() && frame.camera.forward.is_finite());
        for object in &frame.objects {
            assert!(object.pose.position.is_finite() && object.pose.angles_deg.is_finite());
            assert_eq!(film.identity(object.id).name(), object.name);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn conversion_loses_nothing(text in film_text()) {
        let film = match parse(Form::JsonLines, text.as_bytes()) {
            Ok(film) => film,
            // A name such as `a#0` or a sun at its own aim can be drawn.
            Err(_) => return Err(TestCaseError::reject("not a film")),
        };
        check(&film);
        let anim = film::write_anim(&film);
        let through = parse(Form::Anim, anim.as_bytes()).unwrap();
        prop_assert_eq!(&film, &through);
        // Equal texts are equal bits: −0 is not 0 there.
        let json = film::write_jsonl(&film);
        prop_assert_eq!(&json, &film::write_jsonl(&through));
        let again = parse(Form::JsonLines, json.as_bytes()).unwrap();
        prop_assert_eq!(&film, &again);
        prop_assert_eq!(anim, film::write_anim(&again));
        for n in film.frames() {
            prop_assert_eq!(film.frame(n), through.frame(n));
        }
    }

    #[test]
    fn every_number_survives_bit_for_bit(x in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO) {
        let text = format!("*eye 0 0 -9\n*aim 0 0 0\n*angles 9 9\n*size 9 9\n!objects/ball {x:e} 0 0 0 0 {x}\n");
        let film = parse(Form::Anim, text.as_bytes()).unwrap();
        let anim = parse(Form::Anim, film::write_anim(&film).as_bytes()).unwrap();
        let json = parse(Form::JsonLines, film::write_jsonl(&film).as_bytes()).unwrap();
        for film in [film, anim, json] {
            let pose = film.frame(0).objects[0].pose;
            prop_assert_eq!(pose.position.x.to_bits(), x.to_bits());
            prop_assert_eq!(pose.angles_deg.z.to_bits(), x.to_bits());
        }
    }

    #[test]
    fn no_bytes_make_a_reader_panic(text in vec(any::<u8>(), 0..200)) {
        read_all_ways(&text);
    }

    #[test]
    fn no_soup_makes_a_reader_panic(text in soup()) {
        read_all_ways(text.as_bytes());
        let head = "*eye 0 2 -10\n*aim 0 0 0\n*angles 60 45\n*size 320 240\n";
        read_all_ways(format!("{head}{text}").as_bytes());
    }

    #[test]
    fn no_mutation_makes_a_reader_panic(
        text in film_text(),
        anim in any::<bool>(),
        mutations in vec(mutation(), 1..4),
    ) {
        let mut text = text.into_bytes();
        if anim && let Ok(film) = parse(Form::JsonLines, &text) {
            text = film::write_anim(&film).into_bytes();
        }
        for mutation in &mutations {
            mutate(&mut text, mutation);
        }
        read_all_ways(&text);
    }
}
