//! `radiosity completions`: prints a shell's completion script.

use super::Outcome;
use super::console::check_stdout;
use clap::{Args, Command};
use clap_complete::{Shell, generate};
use common::Result;
use std::io::Write;

/// Arguments of `completions`.
#[derive(Args)]
pub struct CompletionsArguments {
    /// The shell to complete for
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the completion script.
pub fn run(arguments: &CompletionsArguments, mut program: Command) -> Result<Outcome> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut program, "radiosity", &mut script);
    check_stdout(std::io::stdout().lock().write_all(&script))?;
    Ok(Outcome::Done)
}
