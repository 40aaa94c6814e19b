//! The live page: its controls, the worker's program in WebAssembly, and the scenes to choose from.

use crate::Result;
use crate::written_page::{WrittenSite, read_source, render_page};
use maud::{PreEscaped, html};
use radiosity::report::trace::trace_assets;
use std::fs;
use std::path::Path;
use wasm_bindgen_cli_support::Bindgen;

/// Style sheets: that of the program's pages, and the controls'.
const STYLE_SHEETS: [&str; 2] = ["radiosity/src/report/style.css", "web/live/page/live.css"];
/// Name of the program's files in the page.
const PROGRAM_NAME: &str = "program";
/// Scenes that the page offers: the values of its list.
pub const LIVE_SCENES: [&str; 6] = [
    "cornell_box",
    "paper_room",
    "paper_room_objects",
    "occluded_plates",
    "facing_plates",
    "furnace",
];

/// Writes the page into `out` with its program, the file `module` of WebAssembly.
///
/// Errors: the module is none, or a file cannot be read or written.
pub fn write_live_page(repository: &Path, module: &Path, out: &Path) -> Result<WrittenSite> {
    fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let mut files = vec![
        ("live.html".to_owned(), render_live_page(repository)?.into_bytes()),
        (
            "worker.js".to_owned(),
            read_source(repository, "web/live/page/worker.js")?.into_bytes(),
        ),
    ];
    for scene in LIVE_SCENES {
        for extension in ["obj", "mtl"] {
            let name = format!("scenes/{scene}.{extension}");
            files.push((name.clone(), read_source(repository, &name)?.into_bytes()));
        }
    }
    let mut written = WrittenSite::write(out, &files)?;
    for size in bind_module(module, out)? {
        written.files += 1;
        written.bytes += size;
    }
    Ok(written)
}

fn render_live_page(repository: &Path) -> Result<String> {
    let stage_test = read_source(repository, "web/live/page/stage_test.js")?;
    let script = read_source(repository, "web/live/page/live.js")?;
    let content = html! {
        (PreEscaped(read_source(repository, "web/live/page/live.html")?))
        (trace_assets(&[&stage_test, &script]))
    };
    render_page(repository, "Radiosity, live", &STYLE_SHEETS, &content.into_string())
}

/// Writes the program and the script that loads it; returns their bytes.
fn bind_module(module: &Path, out: &Path) -> Result<Vec<usize>> {
    let name = module.display();
    let mut bindgen = Bindgen::new();
    bindgen
        .input_path(module)
        .out_name(PROGRAM_NAME)
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true);
    let bound = bindgen.web(true).and_then(|bindgen| bindgen.generate(out));
    bound.map_err(|error| format!("{name}: {error:#}"))?;
    let sizes = ["js", "wasm"].map(|extension| {
        let file = match extension {
            "js" => out.join(format!("{PROGRAM_NAME}.js")),
            _ => out.join(format!("{PROGRAM_NAME}_bg.{extension}")),
        };
        let size = fs::metadata(&file).map(|data| data.len() as usize);
        size.map_err(|error| format!("{}: {error}", file.display()))
    });
    sizes.into_iter().collect()
}
