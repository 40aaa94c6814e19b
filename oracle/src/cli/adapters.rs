//! `radiosity adapters`.

use super::Outcome;
use super::tell::{self, result, say};
use clap::Args;
use common::Result;
use serde_json::json;

/// Arguments of `adapters`.
#[derive(Args)]
pub struct Arguments {
    /// A list of name, backend, driver and whether it is software
    #[arg(long)]
    json: bool,
}

/// One line an adapter on stdout.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let found = gpu::adapters();
    if arguments.json {
        let lines = found.iter().map(|line| {
            json!({
                "name": line.name,
                "backend": line.backend,
                "driver": line.driver,
                "software": line.software,
            })
        });
        tell::json(&lines.collect())?;
        return Ok(Outcome::Done);
    }
    for line in &found {
        let software = if line.software { " (software)" } else { "" };
        result!(
            "{} · {} · {}{software}",
            line.name,
            line.backend,
            line.driver
        )?;
    }
    if found.is_empty() {
        say!("note: no GPU adapter found");
    }
    Ok(Outcome::Done)
}
