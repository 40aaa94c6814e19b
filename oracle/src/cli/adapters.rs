//! `radiosity adapters`.

use super::Outcome;
use common::{Error, Result};

/// One line an adapter on stdout; none is exit code 3.
pub fn run() -> Result<Outcome> {
    let found = gpu::adapters();
    for line in &found {
        let software = if line.software { " (software)" } else { "" };
        println!(
            "{} · {} · {}{software}",
            line.name, line.backend, line.driver
        );
    }
    if found.is_empty() {
        return Err(Error::NoAdapter("no GPU adapter found".into()));
    }
    Ok(Outcome::Done)
}
