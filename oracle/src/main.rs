//! The `radiosity` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    oracle::cli::main()
}
