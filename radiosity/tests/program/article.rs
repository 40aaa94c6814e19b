//! The article of `web/`: its site is built from the sources and from results of the program.

use super::browser::{browser_for, page_outcome, with_script};
use super::command::TestFolder;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;
use web::excerpt::find_item;
use web::placeholder::PlaceholderFiller;
use web::runs::FinishedRuns;
use web::site::{ARTICLE_SECTIONS, write_site};

/// A script that opens all figures of the article and measures what they show.
const MEASURING_SCRIPT: &str = include_str!("article.js");
/// Maximum bytes of the site.
const MAX_SITE_BYTES: usize = 15_000_000;
/// Widths of a phone and of a desktop in pixels.
const PAGE_WIDTHS_PIXELS: [u64; 2] = [390, 1280];
/// Anchors of the sections.
const SECTION_ANCHORS: [&str; 8] = [
    "watt",
    "form-factor",
    "item-buffer",
    "shooting",
    "substructuring",
    "error",
    "failures",
    "relighting",
];

fn repository_root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// The site, built once for all tests, and its runs.
struct BuiltSite {
    folder: TestFolder,
    runs: FinishedRuns,
    bytes: usize,
}

fn built_site() -> &'static BuiltSite {
    static SITE: OnceLock<BuiltSite> = OnceLock::new();
    SITE.get_or_init(|| {
        let folder = TestFolder::new();
        let program = Path::new(env!("CARGO_BIN_EXE_radiosity"));
        let runs = FinishedRuns::run_all(repository_root(), program, &folder.path("results")).unwrap();
        let site = write_site(repository_root(), &runs, &folder.path("site")).unwrap();
        BuiltSite {
            folder,
            runs,
            bytes: site.bytes,
        }
    })
}

impl BuiltSite {
    fn read_page(&self, name: &str) -> String {
        self.folder.read_text(&format!("site/{name}"))
    }

    /// Fills a text as a section of the article.
    fn fill(&self, text: &str) -> Result<String, String> {
        let mut filler = PlaceholderFiller {
            repository: repository_root(),
            runs: &self.runs,
            shown_files: BTreeSet::new(),
        };
        filler.fill_text("web/sections/some.html", text)
    }
}

/// Returns the values of an attribute on a page.
fn attribute_values<'p>(page: &'p str, name: &str) -> Vec<&'p str> {
    let begin = format!(" {name}=\"");
    page.split(&begin[..])
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
        .collect()
}

/// Returns what keeps a section from being complete.
fn missing_parts(section: &str) -> Vec<&'static str> {
    let parts = [
        ("a live figure", "<figure class=\"live\"><iframe loading=\"lazy\""),
        ("an equation", "<math display=\"block\">"),
        ("Rust", "data-language=\"Rust\""),
        ("WGSL", "data-language=\"WGSL\""),
        ("a question", "<details class=\"question\"><summary>Question"),
    ];
    let lacks = |(_, sign): &(&str, &str)| !section.contains(sign);
    parts.into_iter().filter(lacks).map(|(name, _)| name).collect()
}

#[test]
fn article_has_eight_complete_sections() {
    let site = built_site();
    let article = site.read_page("index.html");
    let sections: Vec<&str> = article.split("<section id=\"").skip(1).collect();
    let anchors = sections.iter().map(|section| section.split('"').next().unwrap());
    assert_eq!(anchors.take(8).collect::<Vec<_>>(), SECTION_ANCHORS);
    for section in &sections[..8] {
        assert_eq!(missing_parts(section), [""; 0], "{}", &section[..40]);
        assert_eq!(section.matches("<iframe").count(), 1, "{}", &section[..40]);
        // The answer stands below the question.
        let question = section.split_once("</summary>").unwrap().1;
        assert!(question.split("</details>").next().unwrap().len() > 100);
    }
    assert_eq!(
        missing_parts("<math display=\"block\">"),
        ["a live figure", "Rust", "WGSL", "a question"]
    );
    assert!(site.bytes < MAX_SITE_BYTES, "{} bytes", site.bytes);
}

#[test]
fn pages_have_no_placeholder_and_request_nothing_from_elsewhere() {
    let site = built_site();
    for page in ["index.html", "lesson.html"] {
        let text = site.read_page(page);
        assert!(!text.contains("{{") && !text.contains("}}"), "{page}");
        assert!(
            !text.contains("<script") && !text.contains("@import") && !text.contains("url("),
            "{page}"
        );
        let addresses = [attribute_values(&text, "src"), attribute_values(&text, "href")].concat();
        assert!(addresses.len() > 8, "{page}");
        for address in addresses {
            let (file, anchor) = address.split_once('#').unwrap_or((address, ""));
            let file = if file.is_empty() { page } else { file };
            // The live page is written with its program, which is compiled for browsers.
            let is_there = file == "live.html" || site.folder.has(&format!("site/{file}"));
            assert!(is_there, "{page} refers to {address}");
            if file.ends_with("index.html") || file.ends_with("lesson.html") {
                let target = site.read_page(file);
                assert!(
                    anchor.is_empty() || target.contains(&format!("id=\"{anchor}\"")),
                    "{address}"
                );
            }
        }
    }
    for figure in fs::read_dir(site.folder.path("site/figures")).unwrap() {
        let path = figure.unwrap().path();
        let text = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
        assert!(
            !text.contains("src=\"http") && !text.contains("href=\"http"),
            "{}",
            path.display()
        );
        // Nor does a figure name folders of the machine on which it was made.
        assert!(
            !text.contains(repository_root().to_str().unwrap()),
            "{}",
            path.display()
        );
    }
}

#[test]
fn code_of_the_article_is_that_of_the_sources() {
    let article = built_site().read_page("index.html");
    let mut quoted = 0;
    for section in ARTICLE_SECTIONS {
        let text = fs::read_to_string(repository_root().join(format!("web/sections/{section}.html"))).unwrap();
        for placeholder in text.split("{{").skip(1).map(|rest| rest.split("}}").next().unwrap()) {
            let [kind @ ("rust" | "wgsl"), file, item] = placeholder.split(' ').collect::<Vec<_>>()[..] else {
                continue;
            };
            let source = fs::read_to_string(repository_root().join(file)).unwrap();
            let code = find_item(&source, item).unwrap();
            let ending = if kind == "rust" { ".rs" } else { ".wgsl" };
            assert!(
                file.ends_with(ending) && code.contains(&format!("fn {item}(")),
                "{placeholder}"
            );
            // Every line of the excerpt is a line of the file.
            let lines: BTreeSet<&str> = source.lines().map(str::trim).collect();
            assert!(code.lines().all(|line| lines.contains(line.trim())), "{placeholder}");
            let shown = maud::html! { (code) }.into_string();
            assert!(article.contains(&shown), "{placeholder}");
            quoted += 1;
        }
    }
    assert!(quoted >= 24, "{quoted}");
}

#[test]
fn placeholder_that_cannot_be_filled_names_what_is_missing() {
    let site = built_site();
    let errors = [
        (
            "{{rust common/src/energy.rs add_shots}}",
            "common/src/energy.rs has no item add_shots",
        ),
        (
            "{{wgsl gpu/src/shaders/closure.wgsl scale}}",
            "gpu/src/shaders/closure.wgsl has no item scale",
        ),
        (
            "{{rust common/src/no.rs run}}",
            "common/src/no.rs: No such file or directory (os error 2)",
        ),
        ("{{number nobody /shots}}", "web/runs.txt has no run nobody"),
        ("{{number furnace /shot}}", "furnace has no number /shot"),
        (
            "{{number furnace share of lost}}",
            "furnace has no number share of lost",
        ),
        (
            "{{number furnace irradiance of roof}}",
            "furnace has no number irradiance of roof",
        ),
        ("{{shot furnace_6 7}}", "furnace_6 has 6 shots, and no shot 7"),
        (
            "{{figure furnace shot=99999 Caption}}",
            "furnace has 34 shots, and no shot 99999",
        ),
        (
            "{{hand 0.19 parallel_rectangles 1 1 1}}",
            "0.19 is not parallel_rectangles of [1.0, 1.0, 1.0], which is 0.1998248956983",
        ),
        (
            "{{picture furnace no.png Caption}}",
            "no.png of furnace: No such file or directory (os error 2)",
        ),
        ("{{code x}}", "no placeholder is {{code x}}"),
        ("text {{rust", "{{ without }}"),
    ];
    for (text, error) in errors {
        let found = site.fill(text).unwrap_err();
        assert!(
            found.starts_with(&format!("web/sections/some.html: {error}")),
            "{found}"
        );
        assert_eq!(found.lines().count(), 1);
    }
    assert_eq!(site.fill("{{number furnace_1 share of unshot}}").unwrap(), "91.7 %");
    assert_eq!(site.fill("{{number furnace /energy/emitted/0}}").unwrap(), "6");
}

/// Shoots as the lesson's exercise does on the board.
#[test]
fn exercise_of_the_lesson_is_right() {
    let lesson = built_site().read_page("lesson.html");
    let list = |values: [f64; 3]| values.map(|value| value.to_string()).join(", ");
    let (mut b, mut r) = ([8.0, 0.0, 0.0], [8.0, 0.0, 0.0]);
    for shot in 0..4 {
        let sum: f64 = r.iter().sum();
        let row = format!("<td>{}</td><td>{}</td><td>{sum}</td></tr>", list(b), list(r));
        assert!(lesson.contains(&row), "shot {shot}: {row}");
        let i = (0..3).rev().max_by(|i, k| f64::total_cmp(&r[*i], &r[*k])).unwrap();
        let shooting = std::mem::take(&mut r[i]);
        for k in (0..3).filter(|k| *k != i) {
            let change = 0.5 * 0.5 * shooting;
            b[k] += change;
            r[k] += change;
        }
    }
    let exact = [9.6, 3.2, 3.2];
    assert!(lesson.contains("B = (9.6, 3.2, 3.2)"));
    for (k, emission) in [8.0, 0.0, 0.0].into_iter().enumerate() {
        let others: f64 = (0..3).filter(|i| *i != k).map(|i| exact[i]).sum();
        assert!((emission + 0.25 * others - exact[k]).abs() < 1e-12);
    }
}

#[test]
fn article_shows_every_figure_on_phone_and_desktop() {
    let Some(browser) = browser_for("article_shows_every_figure_on_phone_and_desktop") else {
        return;
    };
    let site = built_site();
    for width in PAGE_WIDTHS_PIXELS {
        let frame = |page: &str| format!("<iframe src=\"{page}\" width={width} height=800></iframe>");
        let frames = frame("index.html") + &frame("lesson.html");
        let page = with_script(&format!("<body>{frames}</body>"), MEASURING_SCRIPT);
        site.folder.write(&format!("site/{width}.html"), page);
        let did = page_outcome(&browser, &site.folder.path(&format!("site/{width}.html")));
        assert!(did["failed"].is_null(), "{did}");
        for page in did["pages"].as_array().unwrap() {
            assert!(page["wide"].as_u64().unwrap() <= width, "wider than {width}: {page}");
            assert!(page["tall"].as_u64().unwrap() > 2000, "{page}");
        }
        let figures = did["figures"].as_array().unwrap();
        assert_eq!(figures.len(), 8, "{did}");
        for figure in figures {
            assert_eq!(figure["ready"], true, "{figure}");
            assert!(figure["colours"].as_u64().unwrap() > 5, "empty at {width}: {figure}");
            assert!(figure["panels"].as_u64().unwrap() > 60, "{figure}");
            assert!(figure["wide"].as_u64() <= figure["frame"].as_u64(), "{figure}");
            assert_eq!(figure["address"], figure["opened"], "{figure}");
        }
        assert_eq!(did["followed"], serde_json::json!([6, "coarse"]), "{did}");
        let elsewhere: Vec<_> = did["requests"].as_array().unwrap().iter().collect();
        assert!(elsewhere.is_empty(), "{elsewhere:?}");
    }
}
