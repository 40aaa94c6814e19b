//! Spellings of earlier versions, which work for one version more: they are replaced before the command line is parsed.

use super::solve::{ShootArguments, SolveArguments};
use clap::error::ErrorKind;
use clap::{Args, Command};
use std::ffi::OsString;

/// Replaces earlier spellings in a command line; returns a note on each.
///
/// Errors: an option of `shoot` in a solve to an error, or by the dense system.
pub fn replace_earlier_spellings(given: &mut Vec<OsString>) -> Result<Vec<String>, clap::Error> {
    let mut notes = Vec::new();
    let texts = |given: &[OsString]| -> Vec<String> {
        let texts = given.iter().map(|word| word.to_string_lossy().into_owned());
        texts.collect()
    };
    let command = texts(given).get(1).cloned().unwrap_or_default();
    let solves = ["solve", "plan"].contains(&command.as_str());
    for k in 2..given.len() {
        let words = texts(&given[k - 1..=k]);
        let after_solver = solves && words[0] == "--solver";
        let (old, new) = match words[1].split_once('=').unwrap_or((&words[1], "")) {
            ("--cells", _) => ("--cells", "--patches"),
            ("--solver", "matrix") if solves => ("matrix", "dense"),
            ("matrix", "") if after_solver => ("matrix", "dense"),
            _ => continue,
        };
        notes.push(format!("{old} is {new} now"));
        given[k] = words[1].replacen(old, new, 1).into();
    }
    if command == "converge" {
        notes.push("`radiosity converge` is `radiosity chart --vary all` now, or one option of it".into());
        given.splice(1..2, ["chart", "--vary", "all"].map(OsString::from));
    }
    if !solves {
        return Ok(notes);
    }
    let words = texts(given);
    let mut options = words
        .iter()
        .filter_map(|word| word.strip_prefix("--")?.split('=').next());
    let shooting = options.find(|option| is_option_of_shooting(option));
    let to_error = words.iter().any(|word| {
        let option = word.split('=').next();
        option == Some("--error") || ["dense", "--solver=dense"].contains(&word.as_str())
    });
    if command == "plan" {
        notes.push("`radiosity plan` is `radiosity solve --dry-run` now, or `radiosity shoot --dry-run`".into());
        given.push("--dry-run".into());
    }
    match shooting {
        Some(option) if to_error => {
            let message =
                format!("--{option} is an option of `radiosity shoot`, which has no --error and no dense solver");
            return Err(clap::Error::raw(ErrorKind::ArgumentConflict, message));
        }
        Some(option) if command == "solve" => notes.push(format!(
            "--{option} is an option of `radiosity shoot` now; this run shoots, as `shoot` does"
        )),
        _ => {}
    }
    given[1] = if shooting.is_some() { "shoot" } else { "solve" }.into();
    Ok(notes)
}

/// Returns true for an option that `shoot` has and `solve` has not.
fn is_option_of_shooting(option: &str) -> bool {
    let has = |command: Command| command.get_arguments().any(|arg| arg.get_long() == Some(option));
    has(ShootArguments::augment_args(Command::new(""))) && !has(SolveArguments::augment_args(Command::new("")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Command line, its replacement (none: refused) and the number of notes.
    const SPELLINGS: &[(&str, Option<&str>, usize)] = &[
        ("solve a.obj", Some("solve a.obj"), 0),
        ("solve a.obj --patches 2", Some("shoot a.obj --patches 2"), 1),
        ("solve a.obj --cells=2", Some("shoot a.obj --patches=2"), 2),
        ("solve a.obj --error 2% --patches 2", None, 0),
        ("solve a.obj --solver=dense --conserve", None, 0),
        ("solve a.obj --solver matrix", Some("solve a.obj --solver dense"), 1),
        ("solve a.obj --solver=matrix", Some("solve a.obj --solver=dense"), 1),
        ("solve a.obj --out matrix", Some("solve a.obj --out matrix"), 0),
        ("shoot a.obj --cells 2", Some("shoot a.obj --patches 2"), 1),
        ("shoot a.obj --solver matrix", Some("shoot a.obj --solver matrix"), 0),
        ("plan a.obj --texels 2", Some("solve a.obj --texels 2 --dry-run"), 1),
        ("plan a.obj --samples 1", Some("shoot a.obj --samples 1 --dry-run"), 1),
        ("converge a.obj --out b", Some("chart --vary all a.obj --out b"), 1),
        ("", Some(""), 0),
    ];

    #[test]
    fn earlier_spelling_is_replaced_by_the_new_one() {
        for (given, replaced, notes) in SPELLINGS {
            let mut words: Vec<OsString> = format!("radiosity {given}")
                .split_whitespace()
                .map(Into::into)
                .collect();
            let told = replace_earlier_spellings(&mut words);
            assert_eq!(told.is_ok(), replaced.is_some(), "{given}: {told:?}");
            if let (Ok(told), Some(replaced)) = (told, replaced) {
                assert_eq!(words[1..].join(" ".as_ref()).to_str(), Some(*replaced));
                assert_eq!(told.len(), *notes, "{given}: {told:?}");
            }
        }
    }
}
