//! Mutants that do the same as the original: a table with a reason for each, by hand.

use super::Mutant;

/// Rows of shader, line, text that changes, its new text, and the reason.
const TABLE: &str = include_str!("equivalent.tsv");

/// Returns the fields of each row.
fn rows() -> impl Iterator<Item = [&'static str; 5]> {
    let lines = TABLE.lines().filter(|line| !line.starts_with('#'));
    lines.filter_map(|line| line.split('\t').collect::<Vec<_>>().try_into().ok())
}

/// Returns the reason for which a mutant does the same as the original, if the table has one.
pub fn find_reason(mutant: &Mutant) -> Option<&'static str> {
    let names = [
        mutant.shader,
        &mutant.line_text,
        &mutant.original,
        &mutant.mutation.replacement,
    ];
    rows().find(|row| row[..4] == names).map(|row| row[4])
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
            let stage = ShaderStage::find(row[0]).unwrap();
            let file = ShaderFile::new(stage.name, Path::new(row[0]), stage.text.to_owned());
            let mutants = list_mutants(&[file], "").unwrap();
            assert!(
                mutants.iter().any(|mutant| {
                    [&mutant.line_text, &mutant.original, &mutant.mutation.replacement] == [row[1], row[2], row[3]]
                }),
                "{row:?}"
            );
            assert!(!row[4].is_empty(), "{row:?}");
        }
    }
}
