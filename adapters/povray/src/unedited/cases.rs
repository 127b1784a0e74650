//! Small texts, and what of them moves: a table. One letter a statement, in the
//! order of the text of each unit: `m` moves, `.` does not.

mod macros;
mod refused;
mod values;

use super::*;

/// What an analysis says.
enum Says {
    /// Nothing is refused, and these statements move.
    Moves(&'static str),
    /// Frames are rendered whole, for a reason with these words.
    Whole(&'static str),
}
use Says::{Moves, Whole};

struct Case {
    what: &'static str,
    scene: &'static str,
    /// `u.inc`.
    include: &'static str,
    says: Says,
}

const fn case(what: &'static str, scene: &'static str, says: Says) -> Case {
    with(what, scene, "", says)
}

const fn with(what: &'static str, scene: &'static str, include: &'static str, says: Says) -> Case {
    Case {
        what,
        scene,
        include,
        says,
    }
}

fn cases() -> impl Iterator<Item = &'static Case> {
    [values::CASES, macros::CASES, refused::CASES]
        .into_iter()
        .flatten()
}

fn analysed(case: &Case) -> (Sources, Analysis) {
    let scene = format!("#version 3.7;\n{}\n", case.scene);
    let sources = Sources::of_texts(&[("a.pov", &scene), ("u.inc", case.include)]);
    let analysis = analyse(&sources, &Options::default());
    (sources, analysis)
}

fn letters(analysis: &Analysis) -> String {
    let objects = analysis
        .statements
        .iter()
        .filter(|s| matches!(s.kind, Kind::Object(_)));
    objects.map(|s| if s.moves { 'm' } else { '.' }).collect()
}

#[test]
fn what_moves_and_what_is_refused() {
    let mut wrong = Vec::new();
    for case in cases() {
        let (_, analysis) = analysed(case);
        let whole: Vec<String> = analysis.whole.iter().map(ToString::to_string).collect();
        let found = letters(&analysis);
        let right = match case.says {
            Moves(expected) => whole.is_empty() && found == expected,
            Whole(reason) => whole.iter().any(|refusal| refusal.contains(reason)),
        };
        if !right {
            wrong.push(format!("{}: {found:?}, refused: {whole:?}", case.what));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        cases().count(),
        wrong.join("\n")
    );
}

#[test]
fn reasons_are_told_with_their_places() {
    let scene = "#declare V = clock*2;\n#declare P =\n  V*x;\nsphere { P, 1 }\n";
    let sources = Sources::of_texts(&[("a.pov", scene)]);
    let analysis = analyse(&sources, &Options::default());
    let (_, statement) = analysis.moving().next().expect("it moves");
    assert_eq!(statement.line, 4);
    assert_eq!(&scene[statement.range.clone()], "sphere { P, 1 }");
    assert_eq!(
        statement.why,
        "it is made with `P` (a.pov:2, with `V` (a.pov:1, with `clock`))"
    );
}

#[test]
fn mirrors_and_glass_are_known() {
    let scene = "#declare F=finish{reflection .3} #macro G(N) interior{ior N} #end \
                 sphere{0,1 finish{F}} sphere{0,1 G(1.5)} sphere{0,1} \
                 #while(0) sphere{0,1} #end";
    let sources = Sources::of_texts(&[("a.pov", scene)]);
    let analysis = analyse(&sources, &Options::default());
    let bends: Vec<bool> = analysis.statements.iter().map(|s| s.bends).collect();
    assert_eq!(bends, [true, true, false, false]);
    assert!(analysis.statements[3].repeated && !analysis.statements[2].repeated);
    let sources = Sources::of_texts(&[("a.pov", "#default{finish{reflection 1}} sphere{0,1}")]);
    assert!(analyse(&sources, &Options::default()).statements[0].bends);
}

#[test]
fn options_refuse() {
    let sources = Sources::of_texts(&[("a.pov", "sphere{clock,1}")]);
    let options = Options {
        refused: vec!["frames read each other".into()],
    };
    let analysis = analyse(&sources, &options);
    assert_eq!(analysis.whole[0].to_string(), "frames read each other");
}

#[test]
fn added_names_are_nobodys() {
    let scene = "#declare decor0_F=1; sphere{clock,1} // decor1_";
    let sources = Sources::of_texts(&[("a.pov", scene)]);
    assert_eq!(sources.prefix, "decor2_");
}
