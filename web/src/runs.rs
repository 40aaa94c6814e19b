//! The commands whose results the article shows, of `web/runs.txt`: a line each, `NAME: COMMAND …`.
//!
//! A word `@NAME` of a command is the folder of an earlier run. Commands run in the root of the repository, and each writes into a
//! folder of its own.

use crate::Result;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// File with the commands.
pub const RUNS_FILE: &str = "web/runs.txt";

/// Finished runs.
pub struct FinishedRuns {
    commands: BTreeMap<String, String>,
    folder: PathBuf,
}

impl FinishedRuns {
    /// Runs all commands; the results lie in folders of `folder`, named as the runs.
    ///
    /// Errors: a line is not a command, or a command fails.
    pub fn run_all(repository: &Path, program: &Path, folder: &Path) -> Result<Self> {
        let repository = absolute_path(repository)?;
        let folder = absolute_path(folder)?;
        let program = absolute_path(program)?;
        let text = fs::read_to_string(repository.join(RUNS_FILE)).map_err(|error| format!("{RUNS_FILE}: {error}"))?;
        let commands = parse_commands(&text)?;
        let mut done = Self {
            commands: BTreeMap::new(),
            folder,
        };
        for (name, command) in commands {
            let mut words: Vec<PathBuf> = Vec::new();
            for word in command.split_whitespace() {
                words.push(match word.strip_prefix('@') {
                    Some(run) => done.folder_of(run)?,
                    None => word.into(),
                });
            }
            let out = done.folder.join(&name);
            let ran = Command::new(&program)
                .args(&words)
                .args(["--quiet", "--out"])
                .arg(&out)
                .current_dir(&repository)
                .stdin(Stdio::null())
                .output()
                .map_err(|error| format!("{}: {error}", program.display()))?;
            if !ran.status.success() {
                let said = String::from_utf8_lossy(&ran.stderr);
                let said = said.lines().find(|line| line.starts_with("error:"));
                return Err(format!("{RUNS_FILE}: {name}: {}", said.unwrap_or("the program failed")));
            }
            done.commands.insert(name, command);
        }
        Ok(done)
    }

    /// Returns the command of a run as a person types it.
    pub fn command_of(&self, run: &str) -> Result<String> {
        let command = self.commands.get(run).ok_or_else(|| unknown_run(run))?;
        Ok(format!("radiosity {}", command.replace('@', "out/")))
    }

    /// Returns the folder with the results of a run.
    pub fn folder_of(&self, run: &str) -> Result<PathBuf> {
        match self.commands.contains_key(run) {
            true => Ok(self.folder.join(run)),
            false => Err(unknown_run(run)),
        }
    }

    /// Reads a file of a run's results.
    pub fn read_file(&self, run: &str, file: &str) -> Result<Vec<u8>> {
        fs::read(self.folder_of(run)?.join(file)).map_err(|error| format!("{file} of {run}: {error}"))
    }
}

fn unknown_run(run: &str) -> String {
    format!("{RUNS_FILE} has no run {run}")
}

fn absolute_path(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// Returns names and commands, in order; lines with # are comments.
fn parse_commands(text: &str) -> Result<Vec<(String, String)>> {
    let lines = text.lines().map(str::trim);
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines
        .map(|line| match line.split_once(": ") {
            Some((name, command)) => Ok((name.to_owned(), command.trim().to_owned())),
            None => Err(format!("{RUNS_FILE}: not NAME: COMMAND: {line}")),
        })
        .collect()
}
