//! Mutants that do the same as the original: a table with a reason for each, by hand.

use super::Mutant;

/// Rows of shader, line, text that changes, its new text, and the reason.
const TABLE: &str = include_str!("equivalent.tsv");

/// A mutant of the table.
struct EquivalentMutant {
    /// Shader, line, text that changes, and its new text.
    names: [String; 4],
    reason: &'static str,
}

impl EquivalentMutant {
    /// Returns true if the row speaks of a mutant.
    fn names_mutant(&self, mutant: &Mutant) -> bool {
        self.names.each_ref().map(String::as_str)
            == [
                mutant.shader,
                &mutant.line_text,
                &mutant.original,
                &mutant.mutation.replacement,
            ]
    }
}

/// Returns the rows.
fn rows() -> impl Iterator<Item = EquivalentMutant> {
    let lines = TABLE.lines().filter(|line| !line.starts_with('#'));
    lines.filter_map(|line| {
        let fields: [&'static str; 5] = line.split('\t').collect::<Vec<_>>().try_into().ok()?;
        let [names @ .., reason] = fields;
        let names = names.map(|name| name.replace("\\n", "\n"));
        Some(EquivalentMutant { names, reason })
    })
}

/// Returns the reason for which a mutant does the same as the original, if the table has one.
pub fn find_reason(mutant: &Mutant) -> Option<&'static str> {
    rows().find(|row| row.names_mutant(mutant)).map(|row| row.reason)
}

#[cfg(test)]
mod tests {
    use super::{TABLE, rows};
    use crate::studies::sabotage::selection::list_mutants;
    use gpu::{ShaderFile, ShaderStage};
    use std::path::Path;

    #[test]
    fn each_row_is_a_mutant_of_the_program() {
        let lines = TABLE.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
        assert_eq!(lines.count(), rows().count());
        for row in rows() {
            let stage = ShaderStage::find(&row.names[0]).unwrap();
            let file = ShaderFile::new(stage.name, Path::new(stage.name), stage.text.to_owned());
            let mutants = list_mutants(&[file], "").unwrap();
            assert!(mutants.iter().any(|mutant| row.names_mutant(mutant)), "{:?}", row.names);
            assert!(!row.reason.is_empty(), "{:?}", row.names);
        }
    }
}
