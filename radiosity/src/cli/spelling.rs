//! Spellings of earlier versions, which work for one version more: they are replaced before the command line is parsed.

use super::solve::{ShootArguments, SolveArguments};
use clap::{Args, Command};
use std::ffi::OsString;

/// Replaces earlier spellings in a command line; returns a note on each.
pub fn replace_earlier_spellings(given: &mut Vec<OsString>) -> Vec<String> {
    let mut notes = Vec::new();
    let mut note = |text: &str| notes.push(text.to_owned());
    let command = given.get(1).and_then(|word| word.to_str()).unwrap_or("").to_owned();
    if command == "converge" {
        note("`radiosity converge` is `radiosity chart --vary all` now, or one option of it");
        given.splice(1..2, ["chart", "--vary", "all"].map(OsString::from));
    }
    for word in given.iter_mut() {
        if let Some(rest) = word.to_str().and_then(|text| text.strip_prefix("--cells"))
            && (rest.is_empty() || rest.starts_with('='))
        {
            note("--cells is --patches now");
            *word = format!("--patches{rest}").into();
        }
    }
    if command == "stress" {
        for k in (2..given.len()).rev() {
            match given[k].to_str() {
                Some("--cpu") => {
                    note("--cpu is --solver cpu now");
                    given.splice(k..=k, ["--solver", "cpu"].map(OsString::from));
                }
                Some("--faces" | "--kind") => {
                    note("stress random takes its faces and kind without --faces and --kind now");
                    given.remove(k);
                }
                _ => {}
            }
        }
    }
    if !["solve", "plan"].contains(&command.as_str()) {
        return notes;
    }
    for k in 2..given.len() {
        let dense = given[k] == "--solver=matrix" || (given[k] == "matrix" && given[k - 1] == "--solver");
        if dense {
            note("--solver matrix is --solver dense now");
            given[k] = given[k].to_string_lossy().replace("matrix", "dense").into();
        }
    }
    let words = || given.iter().filter_map(|word| word.to_str());
    let options = || words().filter_map(|word| word.strip_prefix("--")?.split('=').next());
    let solves =
        options().any(|option| option == "error") || words().any(|word| ["dense", "--solver=dense"].contains(&word));
    let shooting = options().find(|option| !solves && is_option_of_shooting(option));
    let shooting = shooting.map(ToOwned::to_owned);
    if command == "plan" {
        note("`radiosity plan` is `radiosity solve --dry-run` now, or `radiosity shoot --dry-run`");
        given.push("--dry-run".into());
    } else if let Some(option) = &shooting {
        note(&format!(
            "--{option} is an option of `radiosity shoot` now; this run shoots, as `shoot` does"
        ));
    }
    given[1] = if shooting.is_some() { "shoot" } else { "solve" }.into();
    notes
}

/// Returns true for an option that `shoot` has and `solve` has not.
fn is_option_of_shooting(option: &str) -> bool {
    let has = |command: Command| command.get_arguments().any(|arg| arg.get_long() == Some(option));
    has(ShootArguments::augment_args(Command::new(""))) && !has(SolveArguments::augment_args(Command::new("")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earlier_spelling_is_replaced_by_the_new_one() {
        for (given, replaced, notes) in [
            ("solve a.obj", "solve a.obj", 0),
            ("solve a.obj --patches 2", "shoot a.obj --patches 2", 1),
            ("solve a.obj --cells=2", "shoot a.obj --patches=2", 2),
            (
                "solve a.obj --error 2% --patches 2",
                "solve a.obj --error 2% --patches 2",
                0,
            ),
            ("solve a.obj --solver matrix", "solve a.obj --solver dense", 1),
            (
                "solve a.obj --solver=dense --conserve",
                "solve a.obj --solver=dense --conserve",
                0,
            ),
            ("shoot a.obj --cells 2", "shoot a.obj --patches 2", 1),
            ("shoot a.obj --solver matrix", "shoot a.obj --solver matrix", 0),
            ("plan a.obj --texels 2", "solve a.obj --texels 2 --dry-run", 1),
            ("plan a.obj --samples 1", "shoot a.obj --samples 1 --dry-run", 1),
            ("converge a.obj --out b", "chart --vary all a.obj --out b", 1),
            (
                "stress random --faces mixed --cpu --seed 3",
                "stress random mixed --solver cpu --seed 3",
                2,
            ),
            ("", "", 0),
        ] {
            let mut words: Vec<OsString> = format!("radiosity {given}")
                .split_whitespace()
                .map(Into::into)
                .collect();
            let told = replace_earlier_spellings(&mut words);
            assert_eq!(words[1..].join(" ".as_ref()).to_str(), Some(replaced));
            assert_eq!(told.len(), notes, "{given}: {told:?}");
        }
    }
}
