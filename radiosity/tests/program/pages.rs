//! Every page of every command fits on a phone.

use super::browser::{browser_for, page_outcome};
use super::command::{empty_folder, run_radiosity};
use image::RgbImage;
use radiosity::report::picture::RgbaPicture;
use radiosity::studies::chart::vary::{self, ConvergenceStudy, MeasuredCurve, MeasuredSweep};
use radiosity::studies::table4::{self, RowPicture, Table4, Table4Row, TableImage};
use serde_json::json;
use std::fs;
use std::path::Path;

/// A script that measures the frames.
const MEASURE: &str = include_str!("pages.js");
/// Width of a phone in pixels.
const PHONE: u64 = 390;
/// A long folder name, which must not stretch a page.
const LONG: &str = "a_folder_whose_name_is_as_long_as_those_are_in_which_people_keep_what_they_download";

/// Returns quick commands that write the pages, each into a folder of its own. Exit codes are ignored: gates may fail on
/// so few texels, and an adapter that does not exist still gives a page.
fn page_commands(scene: &str, photographs: [&str; 2]) -> Vec<(&'static str, Vec<String>)> {
    let [first, second] = photographs;
    let few = "--texels 3 --patches 1 --samples 1";
    let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");
    [
        ("view.html", format!("solve {scene} --solver cpu --error 10% --out a")),
        ("", format!("shoot {scene} --solver cpu {few} --out b")),
        ("diff.html", "diff b a --out diff".into()),
        ("check.html", "check b --out check".into()),
        ("report.html", format!("compare {scene} {few} --item-buffer 64 --out compare")),
        ("report.html", format!("relight --room {scenes}/furnace.obj --object {scenes}/paper_objects.obj --solver cpu {few} --out relight")),
        ("merge.html", format!("merge {first} {second} --seconds 1,4 --out merge")),
        ("chart.html", format!("chart {scenes}/furnace.obj --solver cpu --quality draft --texels 2 --repeats 1 --out chart")),
        ("stress.html", "stress power --adapter nobody --out stress".into()),
        ("stress.html", "stress random --count 1 --seed 7 --cpu --texels 2 --out random".into()),
    ]
    .map(|(page, line)| (page, line.split(' ').map(str::to_owned).collect()))
    .into()
}

/// Makes the page of `chart --vary`, which takes a minute to measure: eight curves, as many as there are colours.
fn varied_page() -> String {
    let point = |value: f64| vary::SweepPoint {
        value,
        error: 0.012345 / value,
        bias: -0.001,
        seconds: 0.5 * value,
        shots: 100,
    };
    let curve = |k: u32| MeasuredCurve {
        label: format!("stereographic, tessellated, 3x3, {k}"),
        points: [1.0, 2.0, 4.0, 8.0, 16.0, 32.0]
            .map(|x| point(x + f64::from(k) / 10.0))
            .into(),
        order: Some(-0.9),
        order_beside: Some(-1.1),
        finding: "falls to the end: half the step divides the error by 1.6".into(),
        converges: k.is_multiple_of(2),
    };
    let sweep = MeasuredSweep {
        name: "Item buffer",
        option: "--item-buffer",
        truth: "rays".into(),
        base: json!({ "cells": 4, "form-factor": "polygon", "visibility": "stereographic" }),
        curves: (0..8).map(curve).collect(),
    };
    let study = ConvergenceStudy {
        scene: format!("/{LONG}/{LONG}/scene.obj"),
        faces: 6,
        adapter: "llvmpipe (LLVM 15.0.6, 256 bits)".into(),
        sweeps: vec![sweep],
        item_buffers: Vec::new(),
    };
    vary::page::render_page(&[study])
}

/// Makes the page of `table4`, which takes minutes to measure.
fn table4_page() -> String {
    let mut table = Table4::default();
    for (image, item_buffer) in TableImage::ALL
        .into_iter()
        .flat_map(|image| [(image, 512), (image, 1024)])
    {
        table.shown.push(RowPicture {
            row: table.rows.len(),
            picture: RgbaPicture::from_pixels(400, 400, |_, _| Some([90; 3])),
        });
        table.rows.push(Table4Row {
            image,
            texels: 32,
            item_buffer,
            seconds: 123.4,
            shots: 12_345,
            map_shots: 12_000,
            object_shots: 345,
            error: 0.123_45,
            error_rays: 0.234_56,
            imbalance: 1.5e-7,
            negative_texels: 7,
            paper: table4::printed_figures(image, 32, item_buffer),
        });
    }
    table4::page::render_page(&table)
}

#[test]
fn every_page_fits_on_a_phone() {
    let Some(browser) = browser_for("every_page_fits_on_a_phone") else {
        return;
    };
    let out = empty_folder("phone");
    let scene = out.join(LONG).join(LONG);
    fs::create_dir_all(&scene).unwrap();
    for file in ["cornell_box.obj", "cornell_box.mtl"] {
        let from = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes")).join(file);
        fs::copy(from, scene.join(file)).unwrap();
    }
    let scene = scene.join("cornell_box.obj");
    let photographs = [60, 120].map(|code| {
        let file = out.join(format!("{code}.png"));
        let shade = |x: u32, _: u32| image::Rgb([(code + x % 100) as u8; 3]);
        RgbImage::from_fn(64, 64, shade).save(&file).unwrap();
        file
    });
    let [first, second] = photographs.each_ref().map(|file| file.to_str().unwrap());
    let mut pages = vec![];
    for (page, mut line) in page_commands(scene.to_str().unwrap(), [first, second]) {
        let target = line.pop().unwrap();
        let here = out.join(&target);
        line.push(here.to_str().unwrap().to_owned());
        for argument in &mut line {
            if ["a", "b"].contains(&argument.as_str()) {
                *argument = out.join(&*argument).to_str().unwrap().to_owned();
            }
        }
        let words: Vec<&str> = line.iter().map(String::as_str).collect();
        let output = run_radiosity(&words);
        if !page.is_empty() {
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(here.join(page).is_file(), "{words:?}: {said}");
            pages.push(format!("{target}/{page}"));
        }
    }
    for (name, page) in [("varied.html", varied_page()), ("table4.html", table4_page())] {
        fs::write(out.join(name), page).unwrap();
        pages.push(name.into());
    }
    let frame = |page: &String| {
        format!("<iframe title=\"{page}\" src=\"{page}\" width={PHONE} height=800 scrolling=no></iframe>")
    };
    let frames: String = pages.iter().map(frame).collect();
    let file = out.join("phone.html");
    fs::write(&file, format!("<body>{frames}<script>{MEASURE}</script></body>")).unwrap();
    let seen = page_outcome(&browser, &file);
    let seen = seen.as_array().unwrap();
    assert_eq!(seen.len(), pages.len());
    for page in seen {
        assert_eq!(page["frame"], PHONE, "{page}");
        let of = |name: &str| page[name].as_u64().unwrap();
        // An empty page would be narrow, too.
        assert!(of("tall") > 700, "{page}");
        assert!(of("wide") <= PHONE, "wider than a phone: {page}");
    }
    fs::remove_dir_all(out).unwrap();
}
