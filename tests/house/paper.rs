//! docs/paper.md has a row for each equation, table line and figure of the paper, and every file and
//! function that it names exists.

use super::source::read_file;
use std::collections::BTreeSet;

/// Equations, figures and tables of the paper.
const NUMBERED: [(&str, u32); 3] = [("Equation", 2), ("Figure", 10), ("Table", 4)];
/// Tables that are programs, with their number of lines.
const PROGRAMS: [(&str, u32); 3] = [("Table 1", 15), ("Table 2", 22), ("Table 3", 7)];
/// Items without a number: sections, and methods of other papers.
const UNNUMBERED: [&str; 12] = [
    "Section 3",
    "Section 3.1",
    "Section 3.3",
    "Section 5",
    "Abstract",
    "Cohen 1988: gathering",
    "Cohen 1988: shooting",
    "Cohen 1988: reciprocity",
    "Cohen 1988: order",
    "Cohen 1988: substructuring",
    "Coombe 2004: textures",
    "Coombe 2004: next shooter",
];

fn paper_items() -> BTreeSet<String> {
    let numbered = NUMBERED
        .iter()
        .flat_map(|(kind, last)| (1..=*last).map(move |k| format!("{kind} {k}")))
        .filter(|item| PROGRAMS.iter().all(|(program, _)| item != program));
    let lines = PROGRAMS
        .iter()
        .flat_map(|(program, last)| (1..=*last).map(move |k| format!("{program}, line {k}")));
    let unnumbered = UNNUMBERED.iter().map(|item| (*item).to_owned());
    numbered.chain(lines).chain(unnumbered).collect()
}

/// Returns the items of a row: "Table 1, lines 4–5, 11–13" is five.
fn row_items(cell: &str) -> Vec<String> {
    let Some((program, lines)) = cell.split_once(", line") else {
        return vec![cell.to_owned()];
    };
    let range = |text: &str| {
        let (first, last) = text.split_once('–').unwrap_or((text, text));
        let number = |text: &str| text.trim().parse().unwrap_or(0);
        number(first)..=number(last)
    };
    let lines = lines.trim_start_matches('s').split(',').flat_map(range);
    lines.map(|k: u32| format!("{program}, line {k}")).collect()
}

/// Returns the pairs of file and name in `file` `name` `name`; `file` `name`.
fn file_links(cell: &str) -> Vec<(String, String)> {
    let mut links = Vec::new();
    let mut file = String::new();
    for word in cell.split('`').skip(1).step_by(2) {
        if word.ends_with(".wgsl") {
            file = format!("gpu/src/shaders/{word}");
        } else if word.ends_with(".rs") {
            file = word.to_owned();
        } else {
            links.push((file.clone(), word.to_owned()));
        }
    }
    links
}

/// Returns true if `text` defines `name`; as a test, right below `#[test]`.
fn defines_name(text: &str, name: &str, test: bool) -> bool {
    let mut before = "";
    text.lines().map(str::trim).any(|line| {
        let below = std::mem::replace(&mut before, line) == "#[test]";
        let mut words = line.split(|c: char| !c.is_alphanumeric() && c != '_');
        let defines = words.any(|word| ["fn", "struct", "enum", "trait"].contains(&word)) && words.next() == Some(name);
        defines && !line.starts_with("//") && (below || !test)
    })
}

/// Returns the faults in a column of a row.
fn column_faults(row: &str, column: &str, cell: &str) -> Vec<String> {
    let links = file_links(cell);
    let mut faults = Vec::new();
    if links.is_empty() && !(column == "WGSL" && cell == "—") {
        faults.push(format!("{row}: nothing under {column}"));
    }
    for (file, name) in links {
        let ending = if column == "WGSL" { ".wgsl" } else { ".rs" };
        let text = read_file(&file).unwrap_or_default();
        if !file.ends_with(ending) || text.is_empty() {
            faults.push(format!("{row}: no file {file} of {column}"));
        } else if !defines_name(&text, &name, column == "Test") {
            faults.push(format!("{row}: {file} has no {name} of {column}"));
        }
    }
    faults
}

#[test]
fn every_item_of_the_paper_names_existing_code_and_test() {
    let page = read_file("docs/paper.md").unwrap();
    let mut missing = paper_items();
    let mut faults = Vec::new();
    for line in page.lines().filter(|line| line.starts_with('|')) {
        let line = line.replace("\\|", "");
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, row, _, rust, wgsl, test, _] = cells[..] else {
            faults.push(format!("not five columns: {line}"));
            continue;
        };
        if row == "Item" || row.starts_with('-') {
            continue;
        }
        for item in row_items(row) {
            if !missing.remove(&item) {
                faults.push(format!("unknown, or there twice: {item}"));
            }
        }
        for (column, cell) in [("Rust", rust), ("WGSL", wgsl), ("Test", test)] {
            faults.extend(column_faults(row, column, cell));
        }
    }
    faults.extend(missing.iter().map(|item| format!("no row: {item}")));
    assert!(faults.is_empty(), "docs/paper.md:\n{}", faults.join("\n"));
}
