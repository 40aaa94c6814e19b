//! `radiosity adapters`.

use super::Outcome;
use super::console::{self, message, output};
use clap::Args;
use common::Result;
use serde_json::json;

/// Arguments of `adapters`.
#[derive(Args)]
pub struct AdaptersArguments {
    /// One line of JSON: a list of objects with name, backend, driver, software
    #[arg(long)]
    json: bool,
}

/// Prints one line per adapter on stdout.
pub fn run(arguments: &AdaptersArguments) -> Result<Outcome> {
    let adapters = gpu::list_adapters();
    if arguments.json {
        let lines = adapters.iter().map(|line| {
            json!({
                "name": line.name,
                "backend": line.backend,
                "driver": line.driver,
                "software": line.software,
            })
        });
        console::print_json(&lines.collect())?;
        return Ok(Outcome::Done);
    }
    for line in &adapters {
        let software = if line.software { " (software)" } else { "" };
        output!("{} · {} · {}{software}", line.name, line.backend, line.driver)?;
    }
    if adapters.is_empty() {
        message!("note: no GPU adapter found");
    }
    Ok(Outcome::Done)
}
