//! Warnings about causes that may change a solution by more than 2 %: codes for scripts, and their meaning. The oracle
//! issues them; `result.json` and the pages show them.

use serde::{Serialize, Serializer};

/// Cause of a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "`Code::ALL` has the meaning of each")]
pub enum WarningCode {
    Visibility,
    Patches,
    Texels,
    Closure,
    Unshot,
    Overlap,
    Unlit,
    Precision,
    Energy,
}

impl WarningCode {
    /// Every code, its text in `result.json` and its meaning, in the order of the variants.
    pub const ALL_CODES: [(Self, &'static str, &'static str); 9] = [
        (Self::Visibility, "visibility", "the item buffer is too coarse"),
        (Self::Patches, "cells", "light or shadow varies within patches"),
        (Self::Texels, "texels", "light or shadow varies within texels"),
        (Self::Closure, "closure", "form-factor error: light was lost or created"),
        (Self::Unshot, "unshot", "the solve was stopped early"),
        (
            Self::Overlap,
            "overlap",
            "fronts overlap: only one is lit, a lamp or else the first in the file",
        ),
        (
            Self::Unlit,
            "unlit",
            "no light was found on any face that reflects: samples see no lamp, or miss the opening that it shines through",
        ),
        (
            Self::Precision,
            "precision",
            "rounding of coordinates, in the file or to f32, has changed the shape of faces that carry light",
        ),
        (Self::Energy, "energy", "relighting by Table 2 creates or loses power"),
    ];

    /// Returns the code's text in `result.json`.
    pub fn as_str(self) -> &'static str {
        Self::ALL_CODES[self as usize].1
    }
}

impl Serialize for WarningCode {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

/// Warning about a cause that may change the solution by more than 2 %.
#[derive(Clone, Debug, Serialize)]
pub struct Warning {
    /// Cause.
    pub code: WarningCode,
    /// Faces concerned.
    pub faces: Vec<u32>,
    /// The cause in words, and the option that removes it.
    pub message: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readme_lists_every_code_with_its_meaning() {
        let readme = include_str!("../../../README.md");
        let (_, table) = readme.split_once("| Warning | What happened |\n").unwrap();
        let rows: Vec<&str> = table.lines().skip(1).take(WarningCode::ALL_CODES.len() + 1).collect();
        for (k, (code, text, meaning)) in WarningCode::ALL_CODES.into_iter().enumerate() {
            assert_eq!(code as usize, k);
            assert_eq!(rows[k], format!("| `{text}` | {meaning} |"));
        }
        assert_eq!(rows[WarningCode::ALL_CODES.len()], "");
    }
}
