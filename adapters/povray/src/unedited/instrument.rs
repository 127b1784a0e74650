//! Edits of a scene: by some, every object, light and camera says where it is; by
//! others, what moves goes.
//!
//! A statement's text stays where it is and is executed once: it becomes the
//! value of a name. Macros that make objects of the scene and parts of others
//! count how deep they are. All added names begin as nothing in the scene does.

use std::fmt::Write as _;

use super::analysis::{Kind, Statement};
use super::lex::{Kind as TokenKind, Token};
use super::outline::Raw;
use super::parts::{MOST_IN_A_FRAME, Part, Parts};
use super::refuse::Scene;
use super::solid::is_round;
use super::source::Edit;

/// The radius of the sphere that a light is made to look like: its chords tell
/// its centre. POV-Ray traces no further than 1e7.
const LIGHT_RADIUS: &str = "4e6";

/// Words of a camera that take a vector.
const CAMERA_VECTORS: &[&str] = &[
    "location",
    "look_at",
    "direction",
    "right",
    "up",
    "sky",
    "translate",
    "rotate",
    "scale",
];

/// Words of cameras that are not plain.
const CAMERA_OTHERS: &[&str] = &[
    "orthographic",
    "fisheye",
    "ultra_wide_angle",
    "omnimax",
    "panoramic",
    "spherical",
    "cylinder",
    "mesh_camera",
    "normal",
    "aperture",
    "focal_point",
    "blur_samples",
    "confidence",
    "variance",
    "bokeh",
];

/// Edits of one kind, each with whether it ends something: where one statement
/// ends and another begins, the end comes first.
#[derive(Default)]
struct List(Vec<(bool, Edit)>);

impl List {
    fn before(&mut self, file: usize, at: usize, text: String) {
        self.push(false, file, at..at, text);
    }

    fn behind(&mut self, file: usize, at: usize, text: String) {
        self.push(true, file, at..at, text);
    }

    fn push(&mut self, ends: bool, file: usize, range: std::ops::Range<usize>, text: String) {
        self.0.push((ends, Edit { file, range, text }));
    }

    fn sorted(mut self) -> Vec<Edit> {
        self.0
            .sort_by_key(|(ends, edit)| (edit.file, edit.range.start, !ends));
        self.0.into_iter().map(|(_, edit)| edit).collect()
    }
}

/// All edits.
pub struct Edits {
    /// What moves goes.
    pub hiding: Vec<Edit>,
    /// What is there says where.
    pub measuring: Vec<Edit>,
    /// Where definitions can stand before everything else: the file, the byte.
    pub start: (usize, usize),
}

/// The definitions of an instrumented copy, which writes to `file` (in POV-Ray's
/// quotes): a line a frame, a statement, a light, a camera.
pub fn definitions(prefix: &str, file: &str) -> String {
    // @ begins added names. @D: objects, and by small letters their parts. @P: planes, whose extents have no end,
    // by three rays. @L: lights, by the middles of chords, and again from there.
    const TEXT: &str = r#"
#fopen @F "" append
#write(@F,"F ",str(frame_number,0,0),"\n")
#macro @V(@a) #write(@F," ",vstr(3,@a," ",0,12)) #end
#macro @D(@r,@k,@o) #write(@F,@r," ",@k) @V(min_extent(@o)) @V(max_extent(@o)) #write(@F,"\n") #end
#macro @T(@o,@d) #local @s=<17.3,23.7,31.1>-@d*5e5; #local @m=<0,0,0>; #local @h=trace(@o,@s,@d,@m); @V(@h) @V(@m) #end
#macro @P(@k,@o) #write(@F,"P ",@k) @V(min_extent(@o)) @V(max_extent(@o)) @T(@o,x) @T(@o,y) @T(@o,z) #write(@F,"\n") #end
#macro @M(@o,@s,@d) ((trace(@o,@s,@d)+trace(@o,@s,-@d))/2) #end
#macro @C(@o,@s) <vdot(@M(@o,@s,x),x),vdot(@M(@o,@s,y),y),vdot(@M(@o,@s,z),z)> #end
#macro @L(@k,@o) #local @a=@C(@o,<0,0,0>); #local @b=@C(@o,@a); #write(@F,"L ",@k) @V(@a) @V(@b) #write(@F,"\n") #end
#declare @n=0;
#declare @c=0;
"#;
    let text = TEXT.replace('@', prefix);
    let text = text.replace("\"\" append", &format!("\"{file}\" append"));
    format!("\n{}", modern(prefix, &text))
}

/// Ends the record of a frame.
pub fn ending(prefix: &str) -> String {
    let text = format!("#write({prefix}F,\"E\\n\") #fclose {prefix}F");
    modern(prefix, &text)
}

impl Edits {
    /// The edits of a scene.
    pub fn of(scene: &Scene<'_, '_>) -> Self {
        let mut making = Making {
            scene,
            prefix: &scene.sources.prefix,
            hiding: List::default(),
            measuring: List::default(),
        };
        for (file, range) in scene.placing.values_reaching_mixed(scene.outline) {
            making.count(file, &range);
        }
        let mut parts = Parts::of(scene);
        for (index, (statement, raw)) in scene.parts().enumerate() {
            match &statement.kind {
                Kind::Object(word) => {
                    let told = statement.moves.then(|| parts.parts(raw)).flatten();
                    making.object(index, statement, raw, word == "plane", told);
                }
                Kind::Light => making.light(index, statement, raw),
                Kind::Camera => making.camera(statement, raw),
            }
        }
        making.measuring.0.extend(parts.edits);
        if !keeps_bounds(scene) {
            making.unbind();
        }
        let start = start(scene);
        let mut hiding = making.hiding.sorted();
        if (0..scene.outline.units.len()).any(|unit| scene.placing.is_mixed(unit)) {
            let text = format!("\n#declare {}n=0;\n", scene.sources.prefix);
            let (file, at) = start;
            hiding.insert(
                0,
                Edit {
                    file,
                    range: at..at,
                    text,
                },
            );
        }
        Self {
            hiding,
            measuring: making.measuring.sorted(),
            start,
        }
    }
}

struct Making<'m, 's, 'a> {
    scene: &'m Scene<'s, 'a>,
    prefix: &'a str,
    hiding: List,
    measuring: List,
}

impl Making<'_, '_, '_> {
    /// Within these bytes, macros are executed within something else.
    fn count(&mut self, file: usize, range: &std::ops::Range<usize>) {
        for list in [&mut self.hiding, &mut self.measuring] {
            list.before(file, range.start, deeper(self.prefix));
            list.behind(file, range.end, shallower(self.prefix));
        }
    }

    fn object(
        &mut self,
        index: usize,
        statement: &Statement,
        raw: &Raw<'_>,
        plane: bool,
        told: Option<(Vec<Part>, String)>,
    ) {
        let (prefix, file) = (self.prefix, statement.file);
        let (start, end) = (statement.range.start, statement.range.end);
        let mixed = self.scene.placing.is_mixed(raw.unit);
        let counts = self.scene.placing.reach_mixed(&raw.words);
        let name = format!("{prefix}v{index}");
        let log = |kind: &str, name: &str| format!("{prefix}D(\"{kind}\",\"{index}\",{name})");
        let whole = match () {
            () if plane => format!("{prefix}P(\"{index}\",{name})"),
            () if is_round(self.scene.outline, file, &raw.tokens) => log("R", &name),
            () => log("O", &name),
        };
        let told = told.map(|(parts, moving)| {
            let kind = |part: &Part| if part.round { "r" } else { "o" };
            let logs = parts.iter().map(|part| log(kind(part), &part.name));
            let logs = modern(prefix, &logs.collect::<Vec<_>>().join(" "));
            let (count, most) = (parts.len(), MOST_IN_A_FRAME - parts.len());
            let counted = format!("#declare {prefix}c={prefix}c+{count};");
            format!(" #if({prefix}c<={most}) {counted} {moving} {logs} #end")
        });
        let log = modern(prefix, &whole) + &told.unwrap_or_default();

        let (mut before, mut after) = (format!(" #declare {name}="), String::from(" "));
        if counts {
            before.insert_str(0, &deeper(prefix));
            after.push_str(&shallower(prefix));
        }
        self.measuring.before(file, start, before.clone());
        let shown = if mixed {
            format!("{after}#if({prefix}n=0) {log} #else object{{{name}}} #end ")
        } else {
            format!("{after}{log}")
        };
        self.measuring.behind(file, end, shown);

        if statement.moves {
            self.hiding.before(file, start, before);
            if mixed {
                after.push_str(&format!("#if({prefix}n!=0) object{{{name}}} #end "));
            }
            self.hiding.behind(file, end, after);
        } else if counts {
            self.hiding.before(file, start, deeper(prefix));
            self.hiding.behind(file, end, shallower(prefix));
        }
    }

    fn light(&mut self, index: usize, statement: &Statement, raw: &Raw<'_>) {
        let (prefix, file) = (self.prefix, statement.file);
        let (start, end) = (statement.range.start, statement.range.end);
        let shaped = self.scene.carrying(SHAPED);
        let tokens = &self.scene.outline.tokens[file].list[raw.tokens.clone()];
        let plain = tokens
            .iter()
            .all(|token| token.kind != TokenKind::Directive);
        let shadowless = plain && raw.words.contains(&"shadowless");
        if self.scene.placing.reach_mixed(&raw.words) {
            self.count(file, &statement.range);
        }
        if shadowless || shaped.concerns(raw) || self.scene.placing.is_mixed(raw.unit) {
            return;
        }
        let name = format!("{prefix}v{index}");
        self.measuring
            .before(file, start, format!(" #declare {name}="));
        let shape = format!(" looks_like{{sphere{{0,{LIGHT_RADIUS}}}}} ");
        self.measuring.behind(file, end - 1, shape);
        let log = modern(prefix, &format!("{prefix}L(\"{index}\",{name})"));
        self.measuring.behind(file, end, format!(" {log}"));
    }

    /// A camera's values are written out before it.
    fn camera(&mut self, statement: &Statement, raw: &Raw<'_>) {
        let prefix = self.prefix;
        if self.scene.placing.reach_mixed(&raw.words) {
            self.count(statement.file, &statement.range);
        }
        let mut text = format!("#write({prefix}F,\"C\") ");
        match camera_words(self.scene, statement.file, raw) {
            Some(words) => {
                for (word, value) in words {
                    let _ = write!(
                        text,
                        "#write({prefix}F,\" {word}\") {prefix}V(<0,0,0>+({value})) "
                    );
                }
            }
            None => {
                let _ = write!(text, "#write({prefix}F,\" ?\") ");
            }
        }
        let _ = write!(text, "#write({prefix}F,\"\\n\")");
        let text = modern(prefix, &text);
        self.measuring
            .before(statement.file, statement.range.start, text);
    }

    /// Stated bounds may be too small, and POV-Ray may not keep to them: measured
    /// is without.
    fn unbind(&mut self) {
        let outline = self.scene.outline;
        for (file, tokens) in outline.tokens.iter().enumerate() {
            for (at, token) in tokens.list.iter().enumerate() {
                let brace = tokens
                    .list
                    .get(at + 1)
                    .is_some_and(|next| next.is_mark("{"));
                if token.kind != TokenKind::Word || token.text != "bounded_by" || !brace {
                    continue;
                }
                let close = tokens.partner[at + 1];
                let plain = tokens.list[at + 2..close]
                    .iter()
                    .all(|token| is_plain(self.scene, token));
                if plain {
                    let range = token.start..tokens.list[close].end;
                    self.measuring.push(true, file, range, String::new());
                }
            }
        }
    }
}

/// Words of lights that are no points, or that look like something already.
pub const SHAPED: &[&str] = &["area_light", "parallel", "projected_through", "looks_like"];

/// May the token be read twice, or not at all?
pub(super) fn is_plain(scene: &Scene<'_, '_>, token: &Token<'_>) -> bool {
    match token.kind {
        TokenKind::Directive => false,
        TokenKind::Word => token.text != "rand" && !scene.outline.called.contains_key(token.text),
        _ => true,
    }
}

/// Where no bounds are stated, or where the scene may ask for them, they stay.
fn keeps_bounds(scene: &Scene<'_, '_>) -> bool {
    !scene.uses("bounded_by") || scene.asks()
}

fn deeper(prefix: &str) -> String {
    format!(" #declare {prefix}n={prefix}n+1; ")
}

fn shallower(prefix: &str) -> String {
    format!(" #declare {prefix}n={prefix}n-1; ")
}

/// Macros are not known to scenes of versions before 3.1.
fn modern(prefix: &str, text: &str) -> String {
    format!(
        "#declare {prefix}w=version; #if({prefix}w<3.5) #version 3.7; #end {text} \
         #if({prefix}w<3.5) #version {prefix}w; #end "
    )
}

/// The words of a camera and the text of their values; `None` where it has others
/// or where they may not be said twice.
fn camera_words(
    scene: &Scene<'_, '_>,
    file: usize,
    raw: &Raw<'_>,
) -> Option<Vec<(String, String)>> {
    let tokens = &scene.outline.tokens[file];
    let twice = |at: usize| is_plain(scene, &tokens.list[at]);
    if !raw.tokens.clone().all(twice) || scene.placing.is_mixed(raw.unit) {
        return None;
    }
    let mut words: Vec<(String, std::ops::Range<usize>)> = Vec::new();
    let mut at = raw.tokens.start + 2;
    let end = raw.tokens.end - 1;
    while at < end {
        let token = tokens.list[at];
        match token.text {
            "perspective" => {}
            word if token.kind == TokenKind::Word && CAMERA_OTHERS.contains(&word) => return None,
            word if token.kind == TokenKind::Word
                && (CAMERA_VECTORS.contains(&word) || word == "angle") =>
            {
                words.push((word.to_owned(), at + 1..at + 1));
            }
            _ => {
                let (_, range) = words.last_mut()?;
                at = tokens.partner[at].max(at);
                range.end = at + 1;
            }
        }
        at += 1;
    }
    let text = &scene.sources.files[file].text;
    let values = words.into_iter().map(|(word, range)| {
        let bytes = tokens.list[range.start].start..tokens.list[range.end.checked_sub(1)?].end;
        let value = String::from_utf8_lossy(text.get(bytes)?)
            .trim_end_matches(',')
            .to_owned();
        // A comment to the end of its line would hide the bracket.
        (!range.is_empty()).then(|| (word, value + "\n"))
    });
    values.collect()
}

/// Behind a `#version` that begins the scene (a later one means something else),
/// or at the very start.
fn start(scene: &Scene<'_, '_>) -> (usize, usize) {
    let file = scene.sources.header.unwrap_or(0);
    let tokens = &scene.outline.tokens[file].list;
    let versions = scene.outline.settings.iter();
    let mut versions = versions.filter(|raw| raw.keyword == "version" && raw.tokens.start == 0);
    let first = versions.find(|raw| scene.outline.units[raw.unit].file == file);
    let end = first.and_then(|raw| tokens.get(raw.tokens.end.checked_sub(1)?));
    (file, end.map_or(0, |token| token.end))
}
