//! Frames that show the same because all that the clock says in them is the same:
//! pauses, and motion in steps.
//!
//! The clock and the number of the frame come into a scene through expressions. Where
//! each of them stands within brackets that hold nothing else but numbers and them
//! (`floor(clock * 4)`, `min(clock, 0.5)`, `(clock > 0.3)`), the scene depends on
//! the values of these expressions alone: two frames in which all of them are equal
//! are one scene, and one picture. A single clock outside of such brackets, and no two
//! frames are called equal. Names stand for their values ([`aliases`](super::aliases)).
//!
//! Here expressions are found, and reckoned, to know whether it is worth while to
//! ask. Whether values are equal POV-Ray itself says, in one call: its arithmetic
//! need not be ours to the last digit.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write as _;

use decor_api::process::ProcessCall;
use decor_api::{AdapterError, RunContext};

use super::aliases::Aliases;
use super::expression::{Expression, read};
use super::lex::{Kind, Token};
use super::outline::{Outline, Tokens};
use crate::number::number;
use crate::plain::PlainScene;
use crate::{PovRay, patiently};

/// More values are not asked for.
const MOST_VALUES: usize = 20_000;

/// Of so many frames one is a repetition, or it is not worth while to ask.
const WORTH: usize = 20;

/// What the clock says: expressions of which a scene is a function.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Steps {
    /// In POV-Ray's language; the clock is `C_`, the number of the frame `F_`.
    expressions: Vec<(String, Expression)>,
}

/// The bracket around a token.
fn around(tokens: &Tokens<'_>, mut at: usize) -> Option<usize> {
    while at > 0 {
        at -= 1;
        let token = &tokens.list[at];
        let partner = tokens.partner[at];
        if token.kind == Kind::Mark && partner > at {
            return Some(at);
        }
        at = partner.min(at);
    }
    None
}

/// Is a token within a function's body? It is not read as other expressions are.
fn is_in_function(tokens: &Tokens<'_>, at: usize) -> bool {
    let is_function = |at: usize| tokens.list[at].text == "function";
    let mut at = at;
    while let Some(open) = around(tokens, at) {
        let before = open.checked_sub(1);
        let before = before.map(|b| tokens.partner[b].min(b));
        let begins = before.is_some_and(|b| is_function(b) || b > 0 && is_function(b - 1));
        if begins {
            return true;
        }
        at = open;
    }
    false
}

/// The largest expression in brackets around a token that is made of numbers and
/// the clock alone.
fn expression<'t, 'a>(
    tokens: &'t Tokens<'a>,
    at: usize,
    aliases: &Aliases<'a>,
) -> Option<(&'t [Token<'a>], Expression)> {
    let read = |list| read(list, &aliases.values);
    let mut found = None;
    let mut inner = at;
    while let Some(open) = around(tokens, inner) {
        if !tokens.list[open].is_mark("(") {
            break;
        }
        let end = tokens.partner[open] + 1;
        let called = open
            .checked_sub(1)
            .filter(|before| tokens.list[*before].kind == Kind::Word);
        let with_name = called.and_then(|name| Some((name, read(&tokens.list[name..end])?)));
        let read = with_name.or_else(|| Some((open, read(&tokens.list[open..end])?)));
        let Some((start, expression)) = read else {
            break;
        };
        found = Some((&tokens.list[start..end], expression));
        inner = start;
    }
    found
}

/// The text of an expression.
pub(super) fn text<'a>(list: &[Token<'a>], aliases: &Aliases<'a>) -> String {
    let mut text = String::new();
    let mut end = None;
    for token in list {
        if end.is_some_and(|end| end != token.start) {
            text.push(' ');
        }
        end = Some(token.end);
        let alias = aliases.texts.get(token.text);
        text.push_str(match (token.kind, token.text, alias) {
            (Kind::Word, "clock", _) => "C_",
            (Kind::Word, "frame_number", _) => "F_",
            (Kind::Word, _, Some(alias)) => alias,
            (_, other, _) => other,
        });
    }
    text
}

impl Steps {
    /// The expressions of a scene; `None` where the clock stands elsewhere too.
    pub(super) fn of(outline: &Outline<'_>) -> Option<Self> {
        let declared = outline.assignments.iter().map(|a| a.name);
        let params = outline
            .units
            .iter()
            .flat_map(|unit| unit.params.iter().copied());
        if declared.chain(params).any(|name| name == "frame_number") {
            return None;
        }
        let aliases = Aliases::of(outline);
        let mut expressions = BTreeMap::new();
        for (file, tokens) in outline.tokens.iter().enumerate() {
            for (at, token) in tokens.list.iter().enumerate() {
                let differs = token.kind == Kind::Word && aliases.moves(token.text);
                if !differs || aliases.declares(file, at) {
                    continue;
                }
                if is_in_function(tokens, at) {
                    return None;
                }
                let (list, expression) = expression(tokens, at, &aliases)?;
                expressions.insert(text(list, &aliases), expression);
            }
        }
        Some(Self {
            expressions: expressions.into_iter().collect(),
        })
    }

    /// Frames that show the same as an earlier one: that one, and them.
    ///
    /// # Errors
    /// [`AdapterError::Cancelled`], [`AdapterError::Io`], [`AdapterError::Start`].
    pub fn repeated(
        &self,
        povray: &PovRay,
        scene: &PlainScene,
        frames: &BTreeSet<u32>,
        run: &RunContext,
    ) -> Result<BTreeMap<u32, Vec<u32>>, AdapterError> {
        // What is drawn at random may not begin anew in each frame.
        if scene.is_on("Dither") {
            return Ok(BTreeMap::new());
        }
        let clocks: BTreeMap<u32, f32> = frames
            .iter()
            .filter_map(|frame| Some((*frame, clock(scene, *frame)?)))
            .collect();
        let reckoned = clocks.iter().map(|(frame, clock)| {
            let values = self.expressions.iter().map(|(_, expression)| {
                let value = expression.value(f64::from(*clock), f64::from(*frame));
                value.to_bits()
            });
            (*frame, Some(values.collect::<Vec<u64>>()))
        });
        let repeated = groups(reckoned);
        let count: usize = repeated.values().map(Vec::len).sum();
        let values = clocks.len() * self.expressions.len();
        let worth = count >= frames.len().div_ceil(WORTH).max(1);
        if !worth || values > MOST_VALUES {
            return Ok(BTreeMap::new());
        }
        let Some(said) = self.ask(povray, &clocks, run)? else {
            return Ok(BTreeMap::new());
        };
        let lines: Vec<&str> = said.lines().collect();
        if lines.len() != clocks.len() {
            return Ok(BTreeMap::new());
        }
        let values = lines.into_iter().map(|line| {
            let is_plain = |c: char| c.is_ascii_digit() || matches!(c, '-' | '.' | ' ');
            let count = line.split_whitespace().count();
            let known = count == self.expressions.len() && line.chars().all(is_plain);
            known.then(|| line.to_owned())
        });
        Ok(groups(clocks.keys().copied().zip(values)))
    }

    /// The values of all expressions, a frame a line; `None` where POV-Ray does not
    /// say.
    fn ask(
        &self,
        povray: &PovRay,
        clocks: &BTreeMap<u32, f32>,
        run: &RunContext,
    ) -> Result<Option<String>, AdapterError> {
        let folder = tempfile::Builder::new()
            .prefix("steps-")
            .tempdir_in(&run.work)
            .map_err(AdapterError::io(&run.work))?;
        let file = folder.path().join("steps.pov");
        std::fs::write(&file, self.question(clocks)).map_err(AdapterError::io(&file))?;
        run.tally.add_call(0);
        let call = ProcessCall {
            program: povray.program(),
            args: ["+Isteps.pov", "+W1", "+H1", "+Q0", "+WT1", "-F", "-D", "-V"]
                .map(str::to_owned)
                .to_vec(),
            folder: folder.path(),
            doing: "what the clock says".into(),
            log: run.keep.then(|| run.work.join("steps.log")),
        };
        match patiently(|| call.run_well(run)) {
            Ok(_) => {}
            Err(AdapterError::Failed { .. } | AdapterError::TimedOut { .. }) => return Ok(None),
            Err(other) => return Err(other),
        }
        Ok(std::fs::read_to_string(folder.path().join("steps.txt")).ok())
    }

    /// Thirty digits behind the point tell doubles from each other, but for very
    /// small ones: these are said to be so.
    fn question(&self, clocks: &BTreeMap<u32, f32>) -> String {
        let mut question = String::from(
            "\
#version 3.7;
#fopen Out_ \"steps.txt\" write
#macro Tell_(V_)
  #write(Out_, str(V_, 0, 30), \" \")
  #if (((V_ < 0) | (V_ > 0)) & (abs(V_) < 1e-9)) #write(Out_, \"small \") #end
#end
#macro Frame_(C_, F_)
",
        );
        for (text, _) in &self.expressions {
            let _ = writeln!(question, "  Tell_({text})");
        }
        question.push_str("  #write(Out_, \"\\n\")\n#end\n");
        for (frame, clock) in clocks {
            let _ = writeln!(question, "Frame_({}, {frame})", number(f64::from(*clock)));
        }
        question.push_str("#fclose Out_\n");
        question
    }
}

/// Frames of equal values: the first, and the others. Without values a frame is
/// like no other.
fn groups<V: std::hash::Hash + Eq>(
    frames: impl Iterator<Item = (u32, Option<V>)>,
) -> BTreeMap<u32, Vec<u32>> {
    let mut first: HashMap<V, u32> = HashMap::new();
    let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (frame, values) in frames {
        let Some(values) = values else { continue };
        let leader = *first.entry(values).or_insert(frame);
        if leader != frame {
            groups.entry(leader).or_default().push(frame);
        }
    }
    groups
}

/// The clock of a frame, by POV-Ray's own arithmetic: single precision in the end.
/// A compiler may have divided otherwise, or may add and multiply at once; where that
/// tells, nothing is known. Nor is it where numbers are wider than they say (x87).
fn clock(scene: &PlainScene, frame: u32) -> Option<f32> {
    let settings = scene.settings();
    let initial = settings.whole("Initial_Frame").unwrap_or(1).max(0);
    let last = settings.whole("Final_Frame").unwrap_or(1).max(initial);
    let last = last.saturating_add(i32::from(settings.is_on("Cyclic_Animation")));
    let from = settings.real("Initial_Clock").unwrap_or(0.0);
    let to = settings.real("Final_Clock").unwrap_or(1.0);
    let steps = f64::from(last) - f64::from(initial);
    if steps <= 0.0 || cfg!(target_arch = "x86") {
        return None;
    }
    let number = f64::from(frame) - f64::from(initial);
    let range = f64::from(to - from);
    let from = f64::from(from);
    let ways = [range / steps, range * (1.0 / steps)];
    let ways = ways.into_iter().flat_map(|delta| {
        let apart = delta * number + from;
        [apart as f32, delta.mul_add(number, from) as f32]
    });
    let mut ways = ways.map(f32::to_bits);
    let first = ways.next()?;
    ways.all(|other| other == first)
        .then(|| f32::from_bits(first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plain::Part;
    use crate::unedited::Sources;

    fn povray() -> PovRay {
        PovRay::find().expect("POV-Ray is installed")
    }

    fn scene(folder: &std::path::Path, text: &str, switches: &[&str]) -> PlainScene {
        let file = folder.join("s.pov");
        std::fs::write(&file, text).unwrap();
        let switches: Vec<String> = switches.iter().map(|s| (*s).to_owned()).collect();
        povray().plain(&file, &switches, None).unwrap()
    }

    fn steps(text: &str) -> Option<Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        let scene = scene(folder.path(), text, &["+KFF9"]);
        let sources = Sources::read(&povray(), &scene).unwrap();
        let found = Steps::of(&Outline::of(&sources))?;
        Some(
            found
                .expressions
                .into_iter()
                .map(|(text, _)| text)
                .collect(),
        )
    }

    #[test]
    fn expressions_of_the_clock_alone() {
        for (text, expected) in [
            ("sphere { x * floor(clock*4), 1 }", "floor(C_*4)"),
            (
                "#declare A = sin(floor(frame_number / 3) * 2) * 90 * x;",
                "sin(floor(F_ / 3) * 2)",
            ),
            ("#if (clock > 0.5) sphere { 0, 1 } #end", "(C_ > 0.5)"),
            (
                "#if ((clock <= 0.5) & (clock >= .1)) #end",
                "((C_ <= 0.5) & (C_ >= .1))",
            ),
            ("box { 0, 1 rotate y*min(clock, 0.5)*360 }", "min(C_, 0.5)"),
            // What is around it has other things in it.
            ("#declare A = max(B, int(clock*9));", "int(C_*9)"),
            ("#declare A = F(div(clock, .1));", "(div(C_, .1))"),
            // By name.
            (
                "#declare T = clock * 4; sphere { x * floor(T), 1 }",
                "floor((C_ * 4))",
            ),
            (
                "#declare N = 8; #declare T = N * clock; #local U = floor(T) + 1;
                 sphere { x * mod(U, 2), 1 } box { 0, N }",
                "mod((floor(((8) * C_)) + 1), 2)",
            ),
        ] {
            assert_eq!(steps(text), Some(vec![expected.to_owned()]), "{text}");
        }
        assert_eq!(steps("sphere { 0, 1 }"), Some(Vec::new()));
    }

    #[test]
    fn a_clock_elsewhere_tells_all_frames_apart() {
        for text in [
            "sphere { x * clock, 1 } sphere { x * floor(clock*4), 1 }",
            "#declare A = <clock, 0, 0>;",
            "#declare A = floor(clock*B);",
            "#if (clock > B) #end",
            "#declare A = (clock > .5 ? 1 : 0);",
            "text { ttf \"a.ttf\" str(clock, 0, 1) 1, 0 }",
            "isosurface { function { x - floor(clock*4) } }",
            "#declare F = function(u) { floor(clock*4) * u };",
            "#local frame_number = 3; sphere { x * floor(frame_number / 2), 1 }",
            "#declare A = rand(clock);  #declare B = Table[clock];",
            // Names that are used otherwise, or that have several values.
            "#declare T = clock * 4; sphere { x * T, 1 } sphere { y * floor(T), 1 }",
            "#declare T = clock * 4; #declare T = T + 1; sphere { x * floor(T), 1 }",
            "#macro M(T) sphere { x * floor(T), 1 } #end #declare T = clock; M(3)",
            "#declare T = clock * x; sphere { floor(T), 1 }",
            "#declare T = clock; #for (I, 1, T) sphere { x * floor(I + T), 1 } #end",
            "#declare T = clock; isosurface { function { x - floor(T) } }",
            "#macro Set(P) #declare P = floor(clock * 4); #end
             #declare N = 4; Set(N) sphere { x * floor(N * clock), 1 }",
            "#declare T = clock * 4; #undef T sphere { x * floor(T), 1 }",
            "#declare T = clock * 4 #if (1) + 1 #end; sphere { x * floor(T), 1 }",
        ] {
            let found = steps(text);
            // One value of many, or nothing at all.
            let distinct = found.is_none() || found.as_ref().is_some_and(|list| list[0] == "(C_)");
            assert!(distinct, "{text}: {found:?}");
        }
    }

    #[test]
    fn clocks_are_povrays() {
        for switches in [
            &["+KFF12"][..],
            &["+KFI3", "+KFF50", "+KI0.1", "+KF0.7"],
            &["+KFF7", "+KI-3", "+KF11.3", "+KC"],
            &["+KFF40", "+SF5", "+EF38", "Frame_Step=3", "+KF0.3"],
        ] {
            let folder = tempfile::tempdir().unwrap();
            let text = "\
#version 3.7; global_settings { assumed_gamma 1 }
#fopen F concat(\"c\", str(frame_number, 0, 0), \".txt\") write
#write(F, str(clock, 0, 30)) #fclose F";
            let scene = scene(folder.path(), text, &[switches, &["+W1", "+H1"]].concat());
            let (first, last) = (scene.frames.first, scene.frames.last);
            let part = Part {
                first,
                last,
                threads: None,
            };
            let work = tempfile::tempdir().unwrap();
            let run = RunContext::new(work.path());
            scene.render(part, &run).unwrap();
            for frame in scene.frames.numbers() {
                let file = folder.path().join(format!("c{frame}.txt"));
                let its: f64 = std::fs::read_to_string(file).unwrap().parse().unwrap();
                let ours = clock(&scene, frame).map(f64::from);
                assert_eq!(ours, Some(its), "{switches:?}, frame {frame}");
            }
        }
    }

    fn repeated(text: &str, switches: &[&str]) -> BTreeMap<u32, Vec<u32>> {
        let folder = tempfile::tempdir().unwrap();
        let scene = scene(folder.path(), text, switches);
        let sources = Sources::read(&povray(), &scene).unwrap();
        let steps = Steps::of(&Outline::of(&sources)).unwrap();
        let run = RunContext::new(folder.path());
        let frames = scene.frames.numbers().collect();
        steps.repeated(&povray(), &scene, &frames, &run).unwrap()
    }

    #[test]
    fn frames_of_equal_values() {
        let all = repeated("sphere { x * floor(clock*4), 1 }", &["+KFF12"]);
        let expected = [
            (1, vec![2, 3]),
            (4, vec![5, 6]),
            (7, vec![8, 9]),
            (10, vec![11]),
        ];
        assert_eq!(all, BTreeMap::from(expected));
        // Two steps together are finer than each.
        let text = "sphere { x * floor(clock*4) + y * (frame_number > 5), 1 }";
        let all = repeated(text, &["+KFF12"]);
        assert_eq!((&all[&4], all.get(&6)), (&vec![5], None));
        // The same by name.
        let text = "#declare T = clock*4; sphere { x * floor(T), 1 }";
        assert_eq!(repeated(text, &["+KFF12"])[&4], [5, 6]);
        // A pause, and small values that differ.
        let all = repeated("sphere { x * min(clock, 0.5), 1 }", &["+KFF9"]);
        assert_eq!(all, BTreeMap::from([(5, vec![6, 7, 8, 9])]));
        let text = "sphere { x * (max(0, clock - 0.5) * 1e-40), 1 }";
        let all = repeated(text, &["+KFF9"]);
        assert_eq!(all, BTreeMap::from([(1, vec![2, 3, 4, 5])]));
        let text = "sphere { x * floor(clock*4), 1 }";
        assert!(repeated(text, &["+KFF12", "Dither=on"]).is_empty());
    }
}
