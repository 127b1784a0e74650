//! The names of POV-Ray 3.7's options: keywords of INI files, and switches.
//! Which names there are decides how a line is split, so all of them are here,
//! also those whose values are of no interest.

/// What the value of an option is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// On or off.
    Switch,
    /// A whole number.
    Whole,
    /// A number of single precision.
    Real,
    /// A text.
    Text,
    /// A command of the shell.
    Command,
    /// What follows from a command's exit status.
    Return,
    /// `Declare=name=value`.
    Declare,
    /// A folder, added to those before.
    Library,
    /// Another INI file, read at once.
    Ini,
    /// A letter for the format of the pictures.
    FileType,
    /// Read over: nothing here depends on it.
    Other,
}

use Kind::{Command, Declare, FileType, Ini, Library, Other, Real, Return, Switch, Text, Whole};

/// A keyword as it is written here, and the kind of its value.
pub type Keyword = (&'static str, Kind);

/// Keywords of INI files.
const KEYWORDS: &[(Kind, &[&str])] = &[
    (
        Switch,
        &[
            "All_Console",
            "Antialias",
            "Append_File",
            "Bounding",
            "Clockless_Animation",
            "Continue_Trace",
            "Cyclic_Animation",
            "Debug_Console",
            "Display",
            "Dither",
            "Draw_Vistas",
            "Fatal_Console",
            "Field_Render",
            "Grayscale_Output",
            "High_Reproducibility",
            "Jitter",
            "Light_Buffer",
            "Odd_Field",
            "Output_Alpha",
            "Output_To_File",
            "Pause_When_Done",
            "Radiosity_From_File",
            "Radiosity_To_File",
            "Radiosity_Vain_Pretrace",
            "Real_Time_Raytracing",
            "Remove_Bounds",
            "Render_Console",
            "Split_Unions",
            "Statistic_Console",
            "Test_Abort",
            "Verbose",
            "Vista_Buffer",
            "Warning_Console",
        ],
    ),
    (
        Whole,
        &[
            "Antialias_Depth",
            "Bits_Per_Color",
            "Bits_Per_Colour",
            "Bounding_Method",
            "Bounding_Threshold",
            "BSP_MaxDepth",
            "Compression",
            "Final_Frame",
            "Frame_Step",
            "Height",
            "Initial_Frame",
            "Max_Image_Buffer_Memory",
            "Preview_End_Size",
            "Preview_Start_Size",
            "Quality",
            "Render_Block_Size",
            "Render_Block_Step",
            "Render_Pattern",
            "Sampling_Method",
            "Test_Abort_Count",
            "Warning_Level",
            "Width",
            "Work_Threads",
        ],
    ),
    (
        Real,
        &[
            "Antialias_Gamma",
            "Antialias_Threshold",
            "BSP_BaseAccessCost",
            "BSP_ChildAccessCost",
            "BSP_ISectCost",
            "BSP_MissChance",
            "Clock",
            "End_Column",
            "End_Row",
            "Final_Clock",
            "Initial_Clock",
            "Jitter_Amount",
            "Start_Column",
            "Start_Row",
            "Subset_End_Frame",
            "Subset_Start_Frame",
            "Version",
        ],
    ),
    (
        Text,
        &[
            "All_File",
            "Create_Ini",
            "Debug_File",
            "Fatal_File",
            "Include_Header",
            "Input_File_Name",
            "Output_File_Name",
            "Radiosity_File_Name",
            "Render_File",
            "Statistic_File",
            "Warning_File",
        ],
    ),
    (
        Command,
        &[
            "Fatal_Error_Command",
            "Post_Frame_Command",
            "Post_Scene_Command",
            "Pre_Frame_Command",
            "Pre_Scene_Command",
            "User_Abort_Command",
        ],
    ),
    (
        Return,
        &[
            "Fatal_Error_Return",
            "Post_Frame_Return",
            "Post_Scene_Return",
            "Pre_Frame_Return",
            "Pre_Scene_Return",
            "User_Abort_Return",
        ],
    ),
    (Declare, &["Declare"]),
    (Library, &["Library_Path"]),
    (Ini, &["Include_Ini"]),
    (FileType, &["Output_File_Type"]),
    (
        Other,
        &[
            "Buffer_Output",
            "Buffer_Size",
            "Create_Histogram",
            "Display_Gamma",
            "Dither_Method",
            "File_Gamma",
            "Histogram_Grid_Size",
            "Histogram_Name",
            "Histogram_Type",
            "Palette",
            "Video_Mode",
        ],
    ),
];

/// The keyword of that name; capitals do not matter.
pub fn keyword(name: &[u8]) -> Option<Keyword> {
    let all = KEYWORDS
        .iter()
        .flat_map(|(kind, names)| names.iter().map(|name| (*name, *kind)));
    let (found, kind) = all
        .into_iter()
        .find(|(known, _)| known.as_bytes().eq_ignore_ascii_case(name))?;
    // Two spellings of one option.
    let one = if found == "Bits_Per_Colour" {
        "Bits_Per_Color"
    } else {
        found
    };
    Some((one, kind))
}

/// A switch: its letters, the option that its parameter sets, and the option
/// that its sign turns on or off.
pub struct SwitchRule {
    /// The letters behind the sign.
    pub letters: &'static str,
    /// What the parameter sets; without one, none may follow.
    pub parameter: Option<Keyword>,
    /// What `+` turns on and `-` off.
    pub sign: Option<&'static str>,
}

const fn takes(letters: &'static str, keyword: &'static str, kind: Kind) -> SwitchRule {
    SwitchRule {
        letters,
        parameter: Some((keyword, kind)),
        sign: None,
    }
}

const fn signed(letters: &'static str, keyword: &'static str) -> SwitchRule {
    SwitchRule {
        letters,
        parameter: None,
        sign: Some(keyword),
    }
}

const fn both(
    letters: &'static str,
    keyword: &'static str,
    kind: Kind,
    sign: &'static str,
) -> SwitchRule {
    SwitchRule {
        letters,
        parameter: Some((keyword, kind)),
        sign: Some(sign),
    }
}

/// The switches, in the order in which POV-Ray tries them: the first whose
/// letters begin the word, and that takes a parameter where one follows, is it.
/// Where `+EF0.5` and `+EF5` differ, so do the rules.
pub const SWITCHES: &[SwitchRule] = &[
    takes("AG", "Antialias_Gamma", Real),
    takes("AM", "Sampling_Method", Whole),
    both("A0", "Antialias_Threshold", Real, "Antialias"),
    signed("A", "Antialias"),
    takes("BM", "Bounding_Method", Whole),
    takes("BS", "Render_Block_Size", Whole),
    signed("B", "Bounding"),
    signed("C", "Continue_Trace"),
    both("D", "Video_Mode", Other, "Display"),
    signed("D", "Display"),
    takes("EC", "End_Column", Real),
    takes("EF0", "Subset_End_Frame", Real),
    takes("EF", "Subset_End_Frame", Whole),
    takes("EP", "Preview_End_Size", Whole),
    takes("ER", "End_Row", Real),
    both("F", "Output_File_Type", FileType, "Output_To_File"),
    signed("F", "Output_To_File"),
    both("GA", "All_File", Text, "All_Console"),
    signed("GA", "All_Console"),
    both("GD", "Debug_File", Text, "Debug_Console"),
    signed("GD", "Debug_Console"),
    both("GF", "Fatal_File", Text, "Fatal_Console"),
    signed("GF", "Fatal_Console"),
    takes("GI", "Create_Ini", Text),
    signed("GP", "Append_File"),
    both("GR", "Render_File", Text, "Render_Console"),
    signed("GR", "Render_Console"),
    both("GS", "Statistic_File", Text, "Statistic_Console"),
    signed("GS", "Statistic_Console"),
    both("GW", "Warning_File", Text, "Warning_Console"),
    signed("GW", "Warning_Console"),
    takes("HI", "Include_Header", Text),
    signed("HR", "High_Reproducibility"),
    takes("H", "Height", Whole),
    takes("I", "Input_File_Name", Text),
    both("J", "Jitter_Amount", Real, "Jitter"),
    signed("J", "Jitter"),
    signed("KC", "Cyclic_Animation"),
    takes("KI", "Initial_Clock", Real),
    takes("KFF", "Final_Frame", Whole),
    takes("KFI", "Initial_Frame", Whole),
    takes("KF", "Final_Clock", Real),
    signed("KLA", "Clockless_Animation"),
    takes("K", "Clock", Real),
    takes("L", "Library_Path", Library),
    both("MB", "Bounding_Threshold", Whole, "Bounding"),
    signed("MB", "Bounding"),
    takes("MI", "Max_Image_Buffer_Memory", Whole),
    takes("MV", "Version", Real),
    takes("O", "Output_File_Name", Text),
    signed("P", "Pause_When_Done"),
    takes("Q", "Quality", Whole),
    signed("RFI", "Radiosity_From_File"),
    signed("RFO", "Radiosity_To_File"),
    takes("RF", "Radiosity_File_Name", Text),
    takes("RS", "Render_Block_Step", Whole),
    takes("RP", "Render_Pattern", Whole),
    signed("RTR", "Real_Time_Raytracing"),
    signed("RVP", "Radiosity_Vain_Pretrace"),
    takes("R", "Antialias_Depth", Whole),
    takes("SC", "Start_Column", Real),
    takes("SF0", "Subset_Start_Frame", Real),
    takes("SF", "Subset_Start_Frame", Whole),
    takes("SP", "Preview_Start_Size", Whole),
    takes("SR", "Start_Row", Real),
    takes("STP", "Frame_Step", Whole),
    signed("SU", "Split_Unions"),
    both("TH", "Dither_Method", Other, "Dither"),
    signed("TH", "Dither"),
    signed("UA", "Output_Alpha"),
    signed("UD", "Draw_Vistas"),
    signed("UF", "Field_Render"),
    signed("UL", "Light_Buffer"),
    signed("UO", "Odd_Field"),
    signed("UR", "Remove_Bounds"),
    signed("UV", "Vista_Buffer"),
    signed("V", "Verbose"),
    takes("WL", "Warning_Level", Whole),
    takes("WT", "Work_Threads", Whole),
    takes("W", "Width", Whole),
    both("X", "Test_Abort_Count", Whole, "Test_Abort"),
    signed("X", "Test_Abort"),
];
