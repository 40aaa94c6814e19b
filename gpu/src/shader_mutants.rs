//! Mutants of the program's shaders and of files in their place: a mistake in a file is in each module that includes it.

use crate::shader_files::{SHADER_STAGES, ShaderFile};
use crate::shaders::assemble_module;
use common::settings::{ItemBufferProjection, Transport, Visibility};
use common::{Error, Result};
use stage_check::mutants::{are_same_modules, list_mutations};
use std::slice;
use wgpu::naga::Module;
use wgpu::naga::valid::ModuleInfo;

pub use stage_check::mutants::{Mutation, MutationOperator};

/// Pixels of the item buffers of the modules, of no effect on their mutants.
const IMAGE_SIZE: u32 = 64;

/// Returns the mutations of a file, of all modules that include it, in the order of the text.
///
/// Errors: the file does not compile.
pub fn list_file_mutations(file: &ShaderFile) -> Result<Vec<Mutation>> {
    let mut found: Vec<Mutation> = Vec::new();
    for (text, module, info) in compile_modules(file)? {
        // A given file is the first part.
        found.extend(list_mutations(&text, 0..file.text.len(), &module, &info));
    }
    let key = |mutation: &Mutation| (mutation.range.start, mutation.range.end, mutation.replacement.clone());
    found.sort_by_cached_key(key);
    found.dedup_by_key(|mutation| key(mutation));
    Ok(found)
}

/// Returns whether two files of one stage give equal modules.
///
/// Errors: one of them does not compile.
pub fn give_same_modules(a: &ShaderFile, b: &ShaderFile) -> Result<bool> {
    let (a, b) = (compile_modules(a)?, compile_modules(b)?);
    let mut pairs = a.iter().zip(&b);
    Ok(a.len() == b.len() && pairs.all(|((_, a, _), (_, b, _))| are_same_modules(a, b)))
}

/// Compiles the modules that include a file: of each stage with an entry point, by rays and by each kind of item
/// buffer. Returns them with their texts.
///
/// Errors: the file compiles in none.
fn compile_modules(file: &ShaderFile) -> Result<Vec<(String, Module, ModuleInfo)>> {
    let kinds = [
        Visibility::Rays,
        Visibility::with_item_buffer(ItemBufferProjection::Stereographic, IMAGE_SIZE),
        Visibility::with_item_buffer(ItemBufferProjection::Hemicube, IMAGE_SIZE),
    ];
    let mut modules = Vec::new();
    let mut failure = Error::bad_input(&file.path, "", "is in no module");
    for stage in SHADER_STAGES {
        for visibility in kinds {
            let transport = Transport {
                visibility,
                ..Transport::default()
            };
            let is_entry = stage.entry_points().next().is_some();
            // Rays draw no image.
            let Ok(module) = assemble_module(stage.name, &transport, &[], slice::from_ref(file)) else {
                continue;
            };
            if is_entry && module.given_file().is_some() {
                match module.compile() {
                    Ok((parsed, info)) => modules.push((module.text(), parsed, info)),
                    Err(error) => failure = error,
                }
            }
        }
    }
    if modules.is_empty() { Err(failure) } else { Ok(modules) }
}

#[cfg(test)]
mod tests {
    use super::{ShaderFile, give_same_modules, list_file_mutations};
    use crate::shader_files::SHADER_STAGES;
    use crate::shaders::check_shader_files;
    use std::path::Path;

    #[test]
    fn nearly_all_mutants_of_the_shaders_compile() {
        let (mut all, mut refused) = (0, 0);
        for stage in SHADER_STAGES {
            let path = Path::new(stage.name);
            let own = ShaderFile::new(stage.name, path, stage.text.to_owned());
            assert!(give_same_modules(&own, &own).unwrap());
            let found = list_file_mutations(&own).unwrap();
            let step = (found.len() / 3).max(1);
            println!("{}: {} mutants", stage.name, found.len());
            for mutation in found.iter().step_by(step) {
                let mutant = ShaderFile::new(stage.name, path, mutation.apply(stage.text));
                all += 1;
                if let Err(error) = check_shader_files(&[mutant]) {
                    refused += 1;
                    println!("{mutation:?}: {error}");
                }
            }
        }
        assert!(20 * refused < all, "{refused} of {all} do not compile");
    }
}
