//! Moving unions that are mostly empty: their parts are where they are.

mod common;

use common::unedited::Film;
use decor_povray::unedited::Extent;
use glam::DVec3;

/// What is far apart: a union, and the same objects by themselves, or in a union that
/// stays whole because it is an object of an `object`.
const APART: &[(&str, &str)] = &[
    (
        "union { sphere { <-9, clock, 0>, 1 } box { 8, 9 } pigment { rgb 1 } rotate 20*y }",
        "sphere { <-9, clock, 0>, 1 rotate 20*y } box { 8, 9 rotate 20*y }",
    ),
    (
        "union { union { box { 0, 1 } torus { 1, .2 translate 9*x } scale <1, 2, 1> }\n\
         merge { cone { 20*y, 1, 22*y, 0 // to the end\n } } texture { pigment { rgb x scale 3 } }\n\
         no_shadow scale 1 + clock // of the line\n translate <1, 2, 3>*clock }",
        "box { 0, 1 scale <1, 2, 1> scale 1 + clock translate <1, 2, 3>*clock }\n\
         torus { 1, .2 translate 9*x scale <1, 2, 1> scale 1 + clock translate <1, 2, 3>*clock }\n\
         cone { 20*y, 1, 22*y, 0 scale 1 + clock translate <1, 2, 3>*clock }",
    ),
    (
        "#declare K = 2; #declare A = union { sphere { -9*x, 1 } sphere { 9*x, 1 translate K*y } rotate z*K };\n\
         #declare B = union { object { A translate 30*y } cylinder { 0, y, 1 matrix <1,0,0, .2,1,0, 0,0,1, 0,5,0> } }\n\
         #declare K = 50;\n\
         #for (I, 0, 1) object { B rotate 90*I*x translate clock*x } #end",
        "#for (I, 0, 1)\n\
         sphere { -9*x, 1 rotate z*2 translate 30*y rotate 90*I*x translate clock*x }\n\
         sphere { 9*x, 1 translate 2*y rotate z*2 translate 30*y rotate 90*I*x translate clock*x }\n\
         cylinder { 0, y, 1 matrix <1,0,0, .2,1,0, 0,0,1, 0,5,0> rotate 90*I*x translate clock*x }\n\
         #end",
    ),
    (
        "#macro Size(A) A * 2 #end #macro Two(P) union { box { P, P + Size(1) } #if (P.x > 0) sphere #else box #end { 30, 31 } } #end\n\
         #macro Pair(P) union { box { P, P + Size(1) } sphere { P + 30, 1 } bounded_by { box { -99, 99 } } } #end\n\
         Pair(clock*x) Pair(clock*z) Two(clock)",
        "box { clock*x, clock*x + 2 } sphere { clock*x + 30, 1 }\n\
         box { clock*z, clock*z + 2 } sphere { clock*z + 30, 1 }\n\
         object { union { box { clock, clock + 2 } sphere { 30, 31 } } }",
    ),
    // Its own parts would be those of the last call.
    (
        "#macro Tree(N) union { sphere { <N, clock, 0>, .1 } #if (N) Tree(N - 1) #else sphere { 9, .1 } #end } #end Tree(2)",
        "object { union { sphere { <2, clock, 0>, .1 } sphere { <1, clock, 0>, .1 } sphere { <0, clock, 0>, .1 } sphere { 9, .1 } } }",
    ),
    // What has two values, or may have.
    (
        "#declare A = union { sphere { -9*x, 1 } sphere { 9*x, 1 } }\n\
         object { A translate clock } #declare A = union { box { 0, 1 } box { 8, 9 } } object { A translate clock }",
        "object { union { sphere { -9*x, 1 } sphere { 9*x, 1 } translate clock } }\n\
         object { union { box { 0, 1 } box { 8, 9 } translate clock } }",
    ),
    (
        "#macro M(X) #declare X = sphere { 0, 5 } #end\n\
         #declare A = union { sphere { -9*x, 1 } sphere { 9*x, 1 } } M(A) object { A translate clock }",
        "sphere { 0, 5 translate clock }",
    ),
    // Spheres of a negative radius are seen.
    (
        "union { sphere { 5*clock*x, -1 } sphere { -20*x, 2 } sphere { 20*x, 2 } translate y }",
        "sphere { 5*clock*x + y, 1 } sphere { -20*x + y, 2 } sphere { 20*x + y, 2 }",
    ),
    // More in a frame than are asked for.
    (
        "#declare A = union { sphere { -9*x, 1 } sphere { 9*x, 1 } }\n\
         #for (I, 1, 2049) object { A translate <0, I, clock> } #end",
        "#for (I, 1, 2048) sphere { <-9, I, clock>, 1 } sphere { <9, I, clock>, 1 } #end\n\
         object { union { sphere { <-9, 2049, clock>, 1 } sphere { <9, 2049, clock>, 1 } } }",
    ),
    // What may not be read twice.
    (
        "#declare R = seed(7); union { sphere { -9*x, 1 } sphere { 9*x, 1 } translate rand(R)*clock }",
        "#declare R = seed(7); object { union { sphere { -9*x, 1 } sphere { 9*x, 1 } } translate rand(R)*clock }",
    ),
];

#[test]
fn parts_of_unions_are_where_they_are() {
    for (whole, apart) in APART {
        let [found, parts] = [whole, apart].map(|text| {
            let head = "#version 3.7;\nglobal_settings { assumed_gamma 1 }\n";
            let film = Film::new(&[("a.pov", &format!("{head}{text}"))], &[]);
            assert_eq!(film.analysis.whole, [], "{text}");
            let found = film.boxes();
            assert_eq!(found.whole, [], "{text}");
            let boxes = found.frames.iter().flat_map(|frame| &frame.objects);
            let boxes = boxes.map(|placed| match placed.extent {
                Extent::Box { min, max } => (min, max, placed.round),
                other => panic!("{other:?}"),
            });
            boxes.collect::<Vec<_>>()
        });
        assert_eq!(found.len(), parts.len(), "{whole}");
        for (a, b) in found.iter().zip(&parts) {
            let near = |a: DVec3, b: DVec3| (a - b).abs().max_element() < 1e-3;
            assert!(near(a.0, b.0) && near(a.1, b.1), "{a:?} {b:?} {whole}");
        }
    }
}

/// `#local` makes a name each time that the file is executed; its parts would be those of
/// the last time.
#[test]
fn unions_of_files_that_include_themselves_stay_whole() {
    let scene = "#version 3.7;\n#declare N = 1;\n#include \"t.inc\"\n";
    let file = "#local A = union { sphere { 40*N*x, 1 } sphere { 40*N*x + 9*y, 1 } };\n\
                #if (N > 0) #declare N = N - 1; #include \"t.inc\" #end\n\
                object { A translate clock*y }\n";
    let film = Film::new(&[("a.pov", scene), ("t.inc", file)], &[]);
    assert_eq!(film.analysis.whole, []);
    for frame in &film.boxes().frames {
        let boxes = frame.objects.iter().map(|placed| match placed.extent {
            Extent::Box { min, max } => (min.x.round(), max.x.round(), (max.y - min.y).round()),
            other => panic!("{other:?}"),
        });
        let boxes: Vec<_> = boxes.collect();
        assert_eq!(boxes, [(-1.0, 1.0, 11.0), (39.0, 41.0, 11.0)]);
    }
}
