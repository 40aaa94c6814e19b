//! The `radiosity` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    silence_driver();
    radiosity::cli::main()
}

/// Sets `XDG_RUNTIME_DIR` if it is missing. Without it Mesa's Vulkan driver, which looks for a Wayland
/// display, prints an `error:` line that scripts would take for one of this program.
#[allow(unsafe_code, reason = "the environment is changed before any thread starts")]
fn silence_driver() {
    const DISPLAY_FOLDER: &str = "XDG_RUNTIME_DIR";
    if cfg!(target_os = "linux") && std::env::var_os(DISPLAY_FOLDER).is_none() {
        // SAFETY: the first statement of the program; no other thread reads the environment.
        unsafe { std::env::set_var(DISPLAY_FOLDER, std::env::temp_dir()) };
    }
}
