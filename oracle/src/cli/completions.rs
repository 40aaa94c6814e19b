//! `radiosity completions`.

use super::{Outcome, tell};
use clap::{Args, Command};
use clap_complete::{Shell, generate};
use common::Result;

/// Arguments of `completions`.
#[derive(Args)]
pub struct Arguments {
    /// Whose words are completed
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints what the shell has to read.
pub fn run(arguments: &Arguments, mut program: Command) -> Result<Outcome> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut program, "radiosity", &mut script);
    tell::verbatim(&script)?;
    Ok(Outcome::Done)
}
