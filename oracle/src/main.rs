//! The `radiosity` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    quiet_driver();
    oracle::cli::main()
}

/// Mesa's Vulkan driver looks for a Wayland display and prints an `error:` line of its own where
/// this variable is missing; ours must be the only one that scripts find.
#[allow(
    unsafe_code,
    reason = "the environment is changed before any thread starts"
)]
fn quiet_driver() {
    const DISPLAY_FOLDER: &str = "XDG_RUNTIME_DIR";
    if cfg!(target_os = "linux") && std::env::var_os(DISPLAY_FOLDER).is_none() {
        // SAFETY: the first statement of the program; no other thread reads the environment.
        unsafe { std::env::set_var(DISPLAY_FOLDER, std::env::temp_dir()) };
    }
}
