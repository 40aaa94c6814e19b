//! Writes the site: `web PROGRAM OUT MODULE`, in the root of the repository.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [program, out, module] = &arguments[..] else {
        eprintln!(
            "usage: web PROGRAM OUT MODULE, where PROGRAM is the built `radiosity` and MODULE the live page's .wasm"
        );
        return ExitCode::from(2);
    };
    match web::site::build_site(Path::new("."), Path::new(program), Path::new(out), Path::new(module)) {
        Ok(site) => {
            println!(
                "{out}/index.html: {} files, {:.1} MB",
                site.files,
                site.bytes as f64 / 1e6
            );
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
