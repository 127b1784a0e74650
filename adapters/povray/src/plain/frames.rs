//! Which frames an animation has, and what their files are called: POV-Ray's own
//! arithmetic.
//!
//! - There is an animation unless the first and the last frame are both 0 (or
//!   not stated) or both 1. Then the first one is 1 where it is not stated.
//! - `Subset_Start_Frame` and `Subset_End_Frame` below 1 are shares of the number
//!   of frames, in single precision and cut off: of 10 frames, `0.25` is frame 2.
//! - A cyclic animation counts one frame more for the clock, for shares, and for
//!   the digits of its names (9 frames are `01` to `09`), but does not render it.
//! - Numbers have as many digits as the last frame's.
//! - A picture is called after `Output_File_Name` without folder and ending, or
//!   after the scene.

use super::settings::Settings;

/// The frames of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// The number of the first one; 0 in a single picture.
    pub first: u32,
    /// None has a greater number.
    pub last: u32,
    /// From one to the next.
    pub step: u32,
    /// Digits of the number in a file's name; a single picture has none.
    pub digits: Option<usize>,
}

impl Frames {
    /// The frames that the settings ask for.
    pub fn of(settings: &Settings) -> Self {
        let stated = |name| settings.whole(name);
        let ends = (
            stated("Initial_Frame").unwrap_or(0),
            stated("Final_Frame").unwrap_or(0),
        );
        if ends == (0, 0) || ends == (1, 1) {
            return Self {
                first: 0,
                last: 0,
                step: 1,
                digits: None,
            };
        }
        let initial = stated("Initial_Frame").unwrap_or(1).max(0);
        let last = stated("Final_Frame").unwrap_or(1).max(initial);
        let cyclic = settings.is_on("Cyclic_Animation");
        let counted = last.saturating_add(i32::from(cyclic));
        let subset = |name: &str| {
            let share = settings.real(name)?.max(0.0);
            Some(if share == 0.0 || share >= 1.0 {
                share as i32
            } else {
                ((counted - initial).saturating_add(1) as f32 * share) as i32
            })
        };
        let first = subset("Subset_Start_Frame").unwrap_or(initial).max(initial);
        let end = subset("Subset_End_Frame").map_or(last, |end| end.max(first));
        // Nothing here is negative.
        let positive = |n: i32| u32::try_from(n).unwrap_or(0);
        Self {
            first: positive(first),
            // A first frame behind the last one is rendered all the same.
            last: positive(end.max(first)),
            step: positive(stated("Frame_Step").unwrap_or(1).max(1)),
            digits: Some(counted.to_string().len()),
        }
    }

    /// Their numbers, in order.
    pub fn numbers(&self) -> impl Iterator<Item = u32> + use<> {
        (self.first..=self.last).step_by(self.step as usize)
    }

    /// What POV-Ray puts behind a file's name for a frame.
    pub fn suffix(&self, frame: u32) -> String {
        self.digits.map_or_else(String::new, |digits| {
            // Digits that do not fit are not written.
            let text = format!("{frame:0digits$}");
            text[text.len() - digits..].to_owned()
        })
    }
}

/// The ending of a file of that type.
pub fn ending(file_type: Option<&str>) -> &'static str {
    match file_type {
        Some("T" | "C") => "tga",
        Some("J") => "jpg",
        Some("P") => "ppm",
        Some("B") => "bmp",
        Some("E") => "exr",
        Some("H") => "hdr",
        // N, the system's own, and what POV-Ray takes where nothing is stated.
        _ => "png",
    }
}

/// The name of pictures, without folder, number and ending.
pub fn stem(settings: &Settings, ending: &str) -> String {
    let file_of = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
    let stated = settings.text("Output_File_Name").unwrap_or_default();
    let to_a_pipe = matches!(stated, "-" | "stdout" | "stderr");
    let mut name = if to_a_pipe {
        String::new()
    } else {
        file_of(stated)
    };
    if name.is_empty() || name == format!(".{ending}") {
        name = file_of(settings.text("Input_File_Name").unwrap_or("object.pov"));
        name.truncate(name.rfind('.').unwrap_or(name.len()));
        return name;
    }
    if let Some(at) = name.rfind('.')
        && (at + 1 == name.len() || &name[at + 1..] == ending)
    {
        name.truncate(at);
    }
    name
}
