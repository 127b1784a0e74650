//! The text that asks POV-Ray how large fragments are.

use decor_api::{NativeFile, SceneText};

use crate::inlined::inlined;
use crate::isolate::isolate;
use crate::scene_text::{MAIN, with_newline};
use crate::sources::Library;
use crate::statements::rewritten;

/// Writes a box, behind the number of its fragment.
const WRITE_A_BOX: &str = r##"#macro Decor_Box(Decor_K, Decor_O) #write (Decor_Out, Decor_K, " ", vstr(3, min_extent(Decor_O), " ", 0, 30), " ", vstr(3, max_extent(Decor_O), " ", 0, 30), "\n") #end
"##;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The box of each fragment.
    Whole,
    /// The boxes of the objects that it places, as far as its text can be told
    /// apart, and that of the rest: without a rest, what POV-Ray says of an empty
    /// union.
    Objects,
}

/// The text that asks for the extents of fragments: it writes them to `out` and
/// stops before it renders anything. A line has the fragment's number, and the two
/// corners; the last line of each fragment's begins with `all`, and is the box of
/// all that the lines before do not hold.
pub fn extents(
    fragments: &[&NativeFile],
    includes: &[NativeFile],
    library: &Library,
    question: Question,
    out: &str,
) -> SceneText {
    let mut main = format!(
        "#version 3.7;\nglobal_settings {{ assumed_gamma 1 }}\n#fopen Decor_Out \"{out}\" write\n{WRITE_A_BOX}"
    );
    let mut parts = Vec::new();
    for (k, include) in includes.iter().enumerate() {
        main.push_str(&format!("#include \"decor_include_{k}.inc\"\n"));
        parts.push((
            format!("decor_include_{k}.inc"),
            with_newline(&include.text),
        ));
    }
    for (k, fragment) in fragments.iter().enumerate() {
        let stem = format!("P{k}");
        main.push_str(&format!(
            "#declare Decor_P{k} = union {{\n#include \"decor_{stem}.inc\"\n}}\n"
        ));
        let mut files = isolate(fragment, includes, library, &stem);
        if let (Question::Objects, Some((_, text))) = (question, files.first_mut()) {
            let after = format!(" Decor_Box(\"{k}\", Decor_Object)");
            let before = "#declare Decor_Object = ";
            if let Some(told_apart) = rewritten(&inlined(text), before, &after) {
                *text = told_apart;
            }
        }
        parts.extend(files);
    }
    for k in 0..fragments.len() {
        main.push_str(&format!("Decor_Box(\"all {k}\", Decor_P{k})\n"));
    }
    main.push_str("#fclose Decor_Out\n#error \"extents are written\"\n");
    let mut files = vec![(MAIN.to_owned(), main.into_bytes())];
    files.extend(parts);
    SceneText { files }
}
