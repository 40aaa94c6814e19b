//! Lists the mutants of shaders, and draws an even sample.

use super::Mutant;
use crate::studies::hashes::hash_value;
use common::Result;
use gpu::ShaderFile;
use gpu::shader_mutants::{Mutation, MutationOperator, list_file_mutations};
use std::collections::BTreeMap;

/// Lists the mutants of files; `context` names all else that verdicts depend on.
///
/// Errors: a file does not compile.
pub fn list_mutants(files: &[ShaderFile], context: &str) -> Result<Vec<Mutant>> {
    let mut mutants = Vec::new();
    for file in files {
        let found = list_file_mutations(file)?;
        mutants.extend(found.into_iter().map(|mutation| make_mutant(file, mutation, context)));
    }
    Ok(mutants)
}

fn make_mutant(file: &ShaderFile, mutation: Mutation, context: &str) -> Mutant {
    let (before, after) = file.text.split_at(mutation.range.start);
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    let end = mutation.range.start + after.find('\n').unwrap_or(after.len());
    let place = format!("{:?} {}", mutation.range, mutation.replacement);
    Mutant {
        shader: file.stage,
        file: file.path.display().to_string(),
        line: before.matches('\n').count() + 1,
        line_text: file.text[start..end].trim().to_owned(),
        original: file.text[mutation.range.clone()].to_owned(),
        key: format!("{:016x}", hash_value(&[context, file.stage, &file.text, &place])),
        mutation,
    }
}

/// Draws `count` mutants: the shaders take turns, and the operators of each shader. A larger sample holds a smaller one
/// of the same seed.
pub fn draw_sample(mutants: Vec<Mutant>, count: usize, seed: u64) -> Vec<Mutant> {
    let mut groups: BTreeMap<(&str, MutationOperator), Vec<Mutant>> = BTreeMap::new();
    for mutant in mutants {
        let group = groups.entry((mutant.shader, mutant.mutation.operator)).or_default();
        group.push(mutant);
    }
    let drawn = |mutant: &Mutant| {
        let place = format!("{:?} {}", mutant.mutation.range, mutant.mutation.replacement);
        hash_value(&(seed, mutant.shader, &place))
    };
    // Turns of the operators of each shader.
    let mut turns: BTreeMap<&str, Vec<(usize, u64, Mutant)>> = BTreeMap::new();
    for ((shader, _), mut group) in groups {
        group.sort_by_key(drawn);
        let turn = |(turn, mutant): (usize, Mutant)| (turn, drawn(&mutant), mutant);
        turns
            .entry(shader)
            .or_default()
            .extend(group.into_iter().enumerate().map(turn));
    }
    // Turns of the shaders.
    let mut all: Vec<(usize, &str, Mutant)> = Vec::new();
    for (shader, mut own) in turns {
        own.sort_by_key(|(turn, place, _)| (*turn, *place));
        let own = own.into_iter().enumerate();
        all.extend(own.map(|(turn, (.., mutant))| (turn, shader, mutant)));
    }
    all.sort_by_key(|(turn, shader, _)| (*turn, *shader));
    all.into_iter().take(count).map(|(.., mutant)| mutant).collect()
}

#[cfg(test)]
mod tests {
    use super::{draw_sample, list_mutants};
    use gpu::{ShaderFile, ShaderStage};
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn sample_is_even_and_grows() {
        let files = ["exchange", "deposit", "prefix_sum"].map(|name| {
            let stage = ShaderStage::find(name).unwrap();
            ShaderFile::new(stage.name, Path::new(name), stage.text.to_owned())
        });
        let all = list_mutants(&files, "").unwrap();
        let keys: BTreeSet<&String> = all.iter().map(|mutant| &mutant.key).collect();
        assert_eq!(keys.len(), all.len());
        let [small, large] = [30, 60].map(|count| draw_sample(all.clone(), count, 7));
        for (a, b) in small.iter().zip(&large) {
            assert_eq!(a.key, b.key);
        }
        for file in &files {
            let of_file = |sample: &[_]| {
                let own = sample
                    .iter()
                    .filter(|mutant: &&super::Mutant| mutant.shader == file.stage);
                own.map(|mutant| mutant.mutation.operator).collect::<Vec<_>>()
            };
            assert_eq!(of_file(&small).len(), 10);
            let operators: BTreeSet<_> = of_file(&small).into_iter().collect();
            let existing: BTreeSet<_> = of_file(&all).into_iter().collect();
            assert_eq!(operators.len(), existing.len().min(10));
        }
        let other = draw_sample(all.clone(), 30, 8);
        assert!(other.iter().zip(&small).any(|(a, b)| a.key != b.key));
    }
}
