//! `radiosity adapters`.

use super::Outcome;
use super::tell::{result, say};
use common::Result;

/// One line an adapter on stdout.
pub fn run() -> Result<Outcome> {
    let found = gpu::adapters();
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
