//! What may put an answer more than 2 % off: the codes that scripts know, each with what happened.

use serde::{Serialize, Serializer};

/// What kind of thing went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "`Code::ALL` says what each means")]
pub enum Code {
    Visibility,
    FormFactor,
    Cells,
    Texels,
    Closure,
    Unshot,
    Overlap,
    Gap,
    Unlit,
    Covered,
    Precision,
    Energy,
}

impl Code {
    /// Every code as `result.json` has it, and what happened; in the order of the variants.
    pub const ALL: [(Self, &'static str, &'static str); 12] = [
        (
            Self::Visibility,
            "visibility",
            "the item buffer is too coarse",
        ),
        (
            Self::FormFactor,
            "form-factor",
            "the disc form factor is too crude",
        ),
        (Self::Cells, "cells", "light or shadow varies within cells"),
        (
            Self::Texels,
            "texels",
            "light or shadow varies within texels",
        ),
        (
            Self::Closure,
            "closure",
            "form-factor error: light was lost or made up",
        ),
        (Self::Unshot, "unshot", "the solve was stopped early"),
        (
            Self::Overlap,
            "overlap",
            "fronts lie on each other: only the first in the file is lit",
        ),
        (
            Self::Gap,
            "gap",
            "light is shot into gaps narrower than a tenth of a texel",
        ),
        (
            Self::Unlit,
            "unlit",
            "no light was found on any face that reflects: it may come through a chink that no sample meets",
        ),
        (
            Self::Covered,
            "covered",
            "every lamp lies under other faces at all of its samples: nothing is shot",
        ),
        (
            Self::Precision,
            "precision",
            "rounding of coordinates, in the file or to f32, has bent faces that carry light",
        ),
        (
            Self::Energy,
            "energy",
            "relighting by Table 2 makes up or loses power",
        ),
    ];

    /// Its name for scripts.
    pub fn text(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.text())
    }
}

/// Something that may put the answer more than 2 % off.
#[derive(Clone, Debug, Serialize)]
pub struct Warning {
    /// A short name for scripts.
    pub code: Code,
    /// The faces concerned.
    pub faces: Vec<u32>,
    /// What happened and which option mends it.
    pub message: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_readme_lists_every_code_with_what_it_means() {
        let readme = include_str!("../../../README.md");
        let (_, table) = readme.split_once("| Warning | What happened |\n").unwrap();
        let rows: Vec<&str> = table.lines().skip(1).take(Code::ALL.len() + 1).collect();
        for (k, (code, text, meaning)) in Code::ALL.into_iter().enumerate() {
            assert_eq!(code as usize, k);
            assert_eq!(rows[k], format!("| `{text}` | {meaning} |"));
        }
        assert_eq!(rows[Code::ALL.len()], "");
    }
}
