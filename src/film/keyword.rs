//! The keywords of a film, in the thesis's spelling and in English, and the
//! nearest one to a misspelt word.

/// What a `*` line states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Keyword {
    Eye,
    Aim,
    Up,
    Angles,
    Shadows,
    Size,
    Light,
    Background,
    Antialias,
    Images,
    Include,
    Sky,
}

/// Every spelling; the first of a keyword is the one that is written.
const SPELLINGS: [(&str, Keyword); 17] = [
    ("eye", Keyword::Eye),
    ("aim", Keyword::Aim),
    ("up", Keyword::Up),
    ("angles", Keyword::Angles),
    ("ombres", Keyword::Shadows),
    ("shadows", Keyword::Shadows),
    ("taille", Keyword::Size),
    ("size", Keyword::Size),
    ("source", Keyword::Light),
    ("light", Keyword::Light),
    ("fond", Keyword::Background),
    ("background", Keyword::Background),
    ("antialias", Keyword::Antialias),
    ("images", Keyword::Images),
    ("frames", Keyword::Images),
    ("include", Keyword::Include),
    ("sky", Keyword::Sky),
];

impl Keyword {
    /// The keyword of that spelling.
    pub(super) fn of(word: &str) -> Option<Self> {
        let found = SPELLINGS.iter().find(|(spelling, _)| *spelling == word)?;
        Some(found.1)
    }

    /// How messages call it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Eye => "the eye",
            Self::Aim => "the aim",
            Self::Up => "the up direction",
            Self::Angles => "the opening angles",
            Self::Shadows => "whether there are shadows",
            Self::Size => "the size",
            Self::Light => "a light",
            Self::Background => "the background",
            Self::Antialias => "the antialiasing",
            Self::Images => "the number of frames",
            Self::Include => "an include",
            Self::Sky => "the sky",
        }
    }
}

/// All spellings, for a message.
pub(super) fn all() -> String {
    let words: Vec<String> = SPELLINGS
        .iter()
        .map(|(word, _)| format!("*{word}"))
        .collect();
    words.join(", ")
}

/// The spelling of a keyword that is nearest to `word`.
pub(super) fn near_keyword(word: &str) -> Option<&'static str> {
    nearest(word, SPELLINGS.iter().map(|(word, _)| *word))
}

/// The candidate nearest to `word`, where one is near enough to be meant.
pub(super) fn nearest<'a>(
    word: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<&'a str> {
    // A word much longer than any keyword is near to none, and dear to compare.
    if word.len() > 64 {
        return None;
    }
    let word: Vec<char> = word.to_lowercase().chars().collect();
    candidates
        .map(|candidate| (edits(&word, candidate), candidate))
        .filter(|(edits, candidate)| *edits <= (candidate.len() / 3).max(1))
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
}

/// Levenshtein's distance, an exchange of two neighbours counted once.
fn edits(a: &[char], b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut before_last: Vec<usize> = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for (i, &x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, &y) in b.iter().enumerate() {
            let mut best = (last[j] + usize::from(x != y))
                .min(last[j + 1] + 1)
                .min(row[j] + 1);
            if i > 0 && j > 0 && x == b[j - 1] && a[i - 1] == y {
                best = best.min(before_last[j - 1] + 1);
            }
            row.push(best);
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_keyword_finds_the_one_meant() {
        for (word, meant) in [
            ("eie", Some("eye")),
            ("EYE", Some("eye")),
            ("siez", Some("size")),
            ("ombre", Some("ombres")),
            ("shadow", Some("shadows")),
            ("backgruond", Some("background")),
            ("lights", Some("light")),
            ("camera", None),
            ("", None),
        ] {
            assert_eq!(near_keyword(word), meant, "{word}");
        }
    }

    #[test]
    fn every_spelling_is_a_keyword() {
        for (word, keyword) in SPELLINGS {
            assert_eq!(Keyword::of(word), Some(keyword));
        }
        assert_eq!(Keyword::of("Eye"), None);
    }
}
