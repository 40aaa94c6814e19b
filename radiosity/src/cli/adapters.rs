//! `radiosity adapters`: lists the GPU adapters.

use super::Outcome;
use super::console::{message, output};
use common::Result;

/// Prints one line per adapter on stdout.
pub fn run() -> Result<Outcome> {
    let adapters = gpu::list_adapters();
    for line in &adapters {
        let software = if line.software { " (software)" } else { "" };
        output!("{} · {} · {}{software}", line.name, line.backend, line.driver)?;
    }
    if adapters.is_empty() {
        message!("note: no GPU adapter found");
    }
    Ok(Outcome::Done)
}
