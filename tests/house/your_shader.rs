//! docs/your-shader.md has a row for each shader, as the program lists it, and names each buffer once.

use super::source::read_file;
use gpu::{SHADER_STAGES, ShaderStage};
use std::collections::BTreeSet;

/// Returns the row of a stage: name, purpose, what it reads and writes, its twin, and its names in the verdict.
fn stage_row(stage: &ShaderStage) -> String {
    let names = |written| stage.bindings(written).join(", ");
    let cells = [
        stage.name,
        &stage.summary(),
        &names(false),
        &names(true),
        &stage.twin(),
        &stage.verdict_names(),
    ]
    .map(|cell| format!(" {cell} "));
    format!("|{}|", cells.join("|").replace("  ", " "))
}

#[test]
fn page_lists_the_shaders_as_the_program_does() {
    let page = read_file("docs/your-shader.md").unwrap();
    let table = [
        "| Stage | What it does | Reads | Writes | Twin | In the verdict |",
        "|---|---|---|---|---|---|",
    ]
    .map(str::to_owned);
    let table: Vec<String> = table.into_iter().chain(SHADER_STAGES.iter().map(stage_row)).collect();
    let table = table.join("\n");
    assert!(page.contains(&table), "docs/your-shader.md should have:\n{table}");
}

#[test]
fn page_explains_each_buffer_once() {
    let page = read_file("docs/your-shader.md").unwrap();
    let (_, buffers) = page.split_once("| Buffer |").unwrap();
    let named = buffers.lines().skip(2).filter_map(|row| row.split('|').nth(1));
    let mut named: Vec<&str> = named
        .flat_map(|cell| cell.split(", "))
        .map(|name| name.trim().trim_matches('`'))
        .collect();
    named.sort_unstable();
    let declared = SHADER_STAGES
        .iter()
        .flat_map(|stage| [stage.bindings(false), stage.bindings(true)].concat());
    let declared: BTreeSet<&str> = declared.collect();
    assert_eq!(named, Vec::from_iter(declared));
}
