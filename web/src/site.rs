//! The pages of the site: the article and the lesson, with the figures that they show.

use crate::Result;
use crate::placeholder::{PlaceholderFiller, RECORD_PAGE, site_address};
use crate::runs::FinishedRuns;
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

/// The written site.
pub struct WrittenSite {
    /// Number of files.
    pub files: usize,
    /// Their bytes.
    pub bytes: usize,
}

/// FinishedRuns the program and writes the site into `out`, where it replaces an earlier one.
///
/// Errors: a command of `web/runs.txt` fails, a placeholder cannot be filled, or a file cannot be written.
pub fn build_site(repository: &Path, program: &Path, out: &Path) -> Result<WrittenSite> {
    let results = out.join("results");
    remove_folder(&results)?;
    remove_folder(&out.join("figures"))?;
    let runs = FinishedRuns::run_all(repository, program, &results)?;
    let site = write_site(repository, &runs, out);
    remove_folder(&results)?;
    site
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
    let figures = out.join("figures");
    fs::create_dir_all(&figures).map_err(|error| format!("{}: {error}", figures.display()))?;
    for (name, content) in &files {
        fs::write(out.join(name), content).map_err(|error| format!("{name}: {error}"))?;
    }
    Ok(WrittenSite {
        files: files.len(),
        bytes: files.iter().map(|(_, content)| content.len()).sum(),
    })
}

fn render_article(filler: &mut PlaceholderFiller) -> Result<String> {
    let mut content = fill_file(filler, "web/introduction.html")?;
    for section in ARTICLE_SECTIONS {
        content += &fill_file(filler, &format!("web/sections/{section}.html"))?;
    }
    content += &fill_file(filler, "web/references.html")?;
    render_page(filler.repository, "Radiosity, step by step", &content)
}

fn render_lesson(filler: &mut PlaceholderFiller) -> Result<String> {
    let content = fill_file(filler, "web/lesson.html")?;
    render_page(filler.repository, "Radiosity: a lesson of 45 minutes", &content)
}

fn fill_file(filler: &mut PlaceholderFiller, file: &str) -> Result<String> {
    let text = read_source(filler.repository, file)?;
    filler.fill_text(file, &text)
}

/// Renders a page of the frame `web/page.html`.
fn render_page(repository: &Path, title: &str, content: &str) -> Result<String> {
    let frame = read_source(repository, "web/page.html")?;
    let mut style = String::new();
    for file in STYLE_SHEETS {
        style += &read_source(repository, file)?;
    }
    Ok(frame
        .replace("{{title}}", title)
        .replace("{{style}}", &style)
        .replace("{{content}}", content))
}

fn read_source(repository: &Path, file: &str) -> Result<String> {
    fs::read_to_string(repository.join(file)).map_err(|error| format!("{file}: {error}"))
}

fn remove_folder(folder: &Path) -> Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(format!("{}: {error}", folder.display())),
        _ => Ok(()),
    }
}
