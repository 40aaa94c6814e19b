//! The pages of the site: the article and the lesson, with the figures that they show, and the live page.

use crate::Result;
use crate::live_page::write_live_page;
use crate::placeholder::{PlaceholderFiller, RECORD_PAGE, site_address};
use crate::runs::FinishedRuns;
use crate::written_page::{WrittenSite, read_source, render_page};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Sections of the article, in order: files of `web/sections`.
pub const ARTICLE_SECTIONS: [&str; 8] = [
    "1_watt",
    "2_form_factor",
    "3_item_buffer",
    "4_shooting",
    "5_substructuring",
    "6_error_and_links",
    "7_failures",
    "8_relighting",
];
/// Style sheets: that of the program's pages, and the article's.
const STYLE_SHEETS: [&str; 2] = ["radiosity/src/report/style.css", "web/article.css"];
/// Hides the heading of a page in a frame, whose caption names it. Nothing else of a page is changed.
const FRAME_STYLE: &str = "<style>nav, main > header { display: none; } main { padding-top: 1rem; }</style>";

/// Runs the program and writes the site into `out`, where it replaces an earlier one; with the live page, whose program
/// compiled to WebAssembly is the file `module`.
///
/// Errors: a command of `web/runs.txt` fails, a placeholder cannot be filled, or a file cannot be written.
pub fn build_site(repository: &Path, program: &Path, out: &Path, module: &Path) -> Result<WrittenSite> {
    let results = out.join("results");
    remove_folder(&results)?;
    remove_folder(&out.join("figures"))?;
    let runs = FinishedRuns::run_all(repository, program, &results)?;
    let article = write_site(repository, &runs, out);
    remove_folder(&results)?;
    let article = article?;
    let live = write_live_page(repository, module, out)?;
    Ok(WrittenSite {
        files: article.files + live.files,
        bytes: article.bytes + live.bytes,
    })
}

/// Writes the site of finished runs into `out`.
///
/// Errors: a placeholder cannot be filled, or a file cannot be written.
pub fn write_site(repository: &Path, runs: &FinishedRuns, out: &Path) -> Result<WrittenSite> {
    let mut filler = PlaceholderFiller {
        repository,
        runs,
        shown_files: BTreeSet::new(),
    };
    let mut files = vec![
        ("index.html".to_owned(), render_article(&mut filler)?.into_bytes()),
        ("lesson.html".to_owned(), render_lesson(&mut filler)?.into_bytes()),
    ];
    for (run, file) in &filler.shown_files {
        let mut content = runs.read_file(run, file)?;
        if file == RECORD_PAGE {
            let page = String::from_utf8(content).map_err(|error| format!("{file} of {run}: {error}"))?;
            content = page
                .replacen("</head>", &format!("{FRAME_STYLE}</head>"), 1)
                .into_bytes();
        }
        files.push((site_address(run, file), content));
    }
    WrittenSite::write(out, &files)
}

fn render_article(filler: &mut PlaceholderFiller) -> Result<String> {
    let mut content = fill_file(filler, "web/introduction.html")?;
    for section in ARTICLE_SECTIONS {
        content += &fill_file(filler, &format!("web/sections/{section}.html"))?;
    }
    content += &fill_file(filler, "web/references.html")?;
    render_page(filler.repository, "Radiosity, step by step", &STYLE_SHEETS, &content)
}

fn render_lesson(filler: &mut PlaceholderFiller) -> Result<String> {
    let content = fill_file(filler, "web/lesson.html")?;
    render_page(
        filler.repository,
        "Radiosity: a lesson of 45 minutes",
        &STYLE_SHEETS,
        &content,
    )
}

fn fill_file(filler: &mut PlaceholderFiller, file: &str) -> Result<String> {
    let text = read_source(filler.repository, file)?;
    filler.fill_text(file, &text)
}

fn remove_folder(folder: &Path) -> Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(format!("{}: {error}", folder.display())),
        _ => Ok(()),
    }
}
