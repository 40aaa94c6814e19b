//! Every page of every command fits on a phone.

use super::browser::{browser_for, page_outcome, with_script};
use super::command::TestFolder;
use crate::table4::made_up_row;
use image::RgbImage;
use radiosity::studies::table4::page::render_page;
use radiosity::studies::table4::{Table4, TableImage};
use std::fs;

/// A script that measures the frames.
const MEASURE: &str = include_str!("pages.js");
/// Width of a phone in pixels.
const PHONE: u64 = 390;
/// A long folder name, which must not stretch a page.
const LONG: &str = "a_folder_whose_name_is_as_long_as_those_are_in_which_people_keep_what_they_download";

/// Quick commands that write the pages, each into a folder of its own. Exit codes are ignored: gates may fail on so few
/// texels, and an adapter that does not exist still gives a page.
const COMMANDS: [(&str, &str); 13] = [
    ("a/view.html", "solve LONG --solver cpu --error 10%"),
    ("", "shoot LONG --solver cpu FEW --out b"),
    ("trace/trace.html", "shoot LONG --solver cpu FEW --trace"),
    ("links/trace.html", "solve LONG --solver cpu --error 10% --trace"),
    ("diff/diff.html", "diff b a"),
    ("check/check.html", "check b"),
    ("compare/report.html", "compare LONG FEW --item-buffer 64"),
    (
        "relight/report.html",
        "relight --room scenes/furnace.obj --object scenes/paper_objects.obj --solver cpu FEW",
    ),
    ("merge/merge.html", "merge short.png long.png --seconds 1,4"),
    (
        "chart/chart.html",
        "chart scenes/furnace.obj --solver cpu --quality draft --texels 2",
    ),
    ("varied/chart.html", "chart LONG --vary epsilon"),
    ("stress/stress.html", "stress power --adapter nobody"),
    ("random/stress.html", "stress random --solver cpu --count 1 --seed 7"),
];

/// Makes the page of `table4`, which takes minutes to measure.
fn table4_page() -> String {
    let rows = TableImage::ALL
        .into_iter()
        .flat_map(|image| [512, 1024].map(|size| made_up_row(image, 32, size)));
    render_page(&Table4 {
        rows: rows.collect(),
        ..Table4::default()
    })
}

#[test]
fn every_page_fits_on_a_phone() {
    let Some(browser) = browser_for("every_page_fits_on_a_phone") else {
        return;
    };
    let folder = TestFolder::new();
    let scene = format!("{LONG}/{LONG}/cornell_box.obj");
    for file in ["cornell_box.obj", "cornell_box.mtl"] {
        let from = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/").to_owned() + file;
        folder.write(&format!("{LONG}/{LONG}/{file}"), fs::read(from).unwrap());
    }
    for (name, code) in [("short.png", 60), ("long.png", 120)] {
        let shade = |x: u32, _: u32| image::Rgb([(code + x % 100) as u8; 3]);
        RgbImage::from_fn(64, 64, shade).save(folder.path(name)).unwrap();
    }
    let mut pages = vec![];
    for (page, line) in COMMANDS {
        let line = line
            .replace("LONG", &scene)
            .replace("FEW", "--texels 3 --patches 1 --samples 1");
        match page.split_once('/') {
            Some((out, _)) => {
                let end = folder.run(&format!("{line} --out {out}"));
                assert!(folder.has(page), "{end}");
                pages.push(page);
            }
            None => drop(folder.run(&line)),
        }
    }
    folder.write("table4.html", table4_page());
    pages.push("table4.html");
    let frame = |page: &&str| {
        format!("<iframe title=\"{page}\" src=\"{page}\" width={PHONE} height=800 scrolling=no></iframe>")
    };
    let frames: String = pages.iter().map(frame).collect();
    folder.write("phone.html", with_script(&format!("<body>{frames}</body>"), MEASURE));
    let seen = page_outcome(&browser, &folder.path("phone.html"));
    let seen = seen.as_array().unwrap();
    assert_eq!(seen.len(), pages.len());
    for page in seen {
        assert_eq!(page["frame"], PHONE, "{page}");
        let of = |name: &str| page[name].as_u64().unwrap();
        // An empty page would be narrow, too.
        assert!(of("tall") > 700, "{page}");
        assert!(of("wide") <= PHONE, "wider than a phone: {page}");
    }
}
