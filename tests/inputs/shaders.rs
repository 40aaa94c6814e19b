//! Readers of WGSL: shaders that take the place of the program's, their mutants, and the watching of what they do.

use crate::requirements::require_one_line;
use gpu::shaders::check_shader_files;
use gpu::{ShaderFile, ShaderStage};
use stage_check::loops::MAX_SOFTWARE_TURNS;
use stage_check::mutants::list_mutations;
use stage_check::watch::{LogPlace, watch_shader};
use stage_check::wgsl::compile;
use std::path::Path;

/// Largest number of mutants that are compiled.
const MAX_MUTANTS: usize = 4;
/// Bytes of workgroup memory that a watched text may have.
const MAX_WORKGROUP_BYTES: u32 = 1 << 14;
/// Place of the log of a watched text, which no input should use.
const LOG: LogPlace = LogPlace {
    group: 3,
    binding: 77,
    first: 0,
};

/// Checks the readers of a shader: the first line is the name of the stage whose place the other lines take.
pub fn check_shader(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let (stage, text) = text.split_once('\n').unwrap_or(("", text));
    let stage = ShaderStage::find(stage).map_or("deposit", |stage| stage.name);
    let file = ShaderFile::new(stage, Path::new("a.wgsl"), text.to_owned());
    if let Err(error) = check_shader_files(&[file]) {
        require_one_line(&error);
    }
    require_sound_mutants(text);
}

/// Requires of a valid shader that its mutants differ from it.
fn require_sound_mutants(text: &str) {
    let Ok((module, info)) = compile(text, "a.wgsl") else {
        return;
    };
    for (k, mutation) in list_mutations(text, 0..text.len(), &module, &info).iter().enumerate() {
        let mutant = mutation.apply(text);
        assert_ne!(mutant, text, "{mutation:?}");
        if k < MAX_MUTANTS {
            let _ = compile(&mutant, "mutant.wgsl");
        }
    }
    // A text whose names hide others becomes an invalid one, which is not used.
    if let Some(watched) = watch_shader(text, &module, LOG, MAX_WORKGROUP_BYTES, Some(MAX_SOFTWARE_TURNS)) {
        let _ = compile(&watched.text, "watched.wgsl");
    }
}
