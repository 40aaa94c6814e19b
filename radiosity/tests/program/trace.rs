//! `shoot --trace` and its page.

use super::browser::{browser_for, page_outcome};
use super::command::TestFolder;
use common::settings::{ItemBufferProjection, Transport, Visibility};
use common::solution::StoredSolution;
use glam::Vec3;
use radiosity::report::trace::MAX_PAGE_BYTES;
use radiosity::report::trace::algorithm::algorithm_steps;
use serde_json::{Value, json};
use std::path::Path;

/// A script that moves through the shots, and writes the outcome into the page.
const MOVE: &str = include_str!("trace.js");
/// Relative error of a page's B − E, whose two factors are half floats, and of the five digits that it prints.
const PAGE_ERROR: f32 = 2.0 / 2048.0 + 1e-4;

const SHOOT: &str = "shoot scenes/cornell_box.obj --solver cpu --texels 6 --patches 1 --samples 1 --trace";

#[test]
fn trace_is_written_beside_the_other_files_and_changes_none() {
    let folder = TestFolder::new();
    let end = folder.succeed(&format!("{SHOOT} --out traced"));
    assert!(end.stderr.contains("wrote trace.html"), "{end}");
    let plain = SHOOT.replace("--trace", "--iteration southwell");
    folder.succeed(&format!("{plain} --out plain"));
    assert!(!folder.has("plain/trace.html"));
    assert_eq!(folder.read("traced/lightmap.exr"), folder.read("plain/lightmap.exr"));
    assert_eq!(folder.read("traced/view.html"), folder.read("plain/view.html"));
    let page = folder.read_text("traced/trace.html");
    let result = folder.read_json("traced/result.json");
    assert_eq!(result["settings"]["iteration"], "southwell");
    assert!(page.contains(&format!("\"shot_count\":{}", result["shots"])));
    assert!(!page.contains("src=") && !page.contains("https:") && !page.contains("fetch("));
    // The same input gives the same bits.
    folder.succeed(&format!("{SHOOT} --out again"));
    assert_eq!(page, folder.read_text("again/trace.html"));
    // The next result without a page removes this one.
    folder.succeed(&format!("{plain} --out traced"));
    assert!(!folder.has("traced/trace.html"));
}

#[test]
fn long_solve_has_its_first_shots_on_the_page() {
    let folder = TestFolder::new();
    let end = folder.succeed("shoot scenes/paper_room.obj --solver cpu --trace --max-shots 400 --samples 1");
    assert!(end.stderr.contains("trace.html has the first "), "{end}");
    let page = folder.read_text("out/trace.html");
    assert!(
        page.len() <= MAX_PAGE_BYTES && page.len() > MAX_PAGE_BYTES * 9 / 10,
        "{}",
        page.len()
    );
    assert!(page.contains(" of 400 shots: more do not fit into 5 MB"));
}

#[test]
fn algorithm_names_existing_functions() {
    for visibility in [
        Visibility::Rays,
        Visibility::with_item_buffer(ItemBufferProjection::Hemisphere, 64),
    ] {
        let steps = algorithm_steps(&Transport {
            visibility,
            ..Transport::default()
        });
        let places = steps.iter().flat_map(|step| [step.rust, step.wgsl]).flatten();
        assert_eq!(places.clone().count(), 14);
        for place in places {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(place.file);
            let text = std::fs::read_to_string(path).unwrap();
            assert!(text.contains(&format!("fn {}(", place.function)), "{place:?}");
        }
    }
}

#[test]
fn trace_page_shows_the_recorded_shots() {
    let Some(browser) = browser_for("trace_page_shows_the_recorded_shots") else {
        return;
    };
    let folder = TestFolder::new();
    folder.succeed(SHOOT);
    let page = folder.read_text("out/trace.html");
    let script = format!("<script>{MOVE}</script></body>");
    folder.write("move.html", page.replace("</body>", &script));
    let did = page_outcome(&browser, &folder.path("move.html"));
    assert_eq!(did["failed"], Value::Null, "{did}");
    let shots = folder.read_json("out/result.json")["shots"].as_u64().unwrap();
    assert_eq!(did["requests"], 0);
    let moves = json!({ "start": 0, "right": 1, "right again": 2, "left": 1, "end": shots, "home": 0, "slider": 7, "back": 6, "forward": 7, "address": 9 });
    assert_eq!(did["moves"], moves);
    assert_eq!(did["hash"], "#shot=9");
    assert!(did["played"].as_u64().unwrap() > 9, "{did}");
    let lines = json!([
        "before",
        "visibility",
        "form_factor",
        "change",
        "radiosity",
        "residual",
        "before"
    ]);
    assert_eq!(did["lines"], lines);
    assert_eq!(did["lit"], json!(["i ←", "V ←", "F ←", "ΔB ←", "B ←", "r ←", "i ←"]));

    let stored = StoredSolution::read(&folder.path("out")).unwrap();
    let vector = |value: &Value| {
        let numbers = value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap() as f32);
        Vec3::from_slice(&numbers.collect::<Vec<_>>())
    };
    // The state after the last shot is the solver's.
    let last = did["last"].as_array().unwrap();
    assert_eq!(last.len(), stored.radiosity.len());
    for (k, (shown, known)) in last.iter().zip(&stored.radiosity).enumerate() {
        let bound = (*known - stored.emission[k]) * PAGE_ERROR + *known * 1e-5;
        let off = (vector(shown) - *known).abs();
        assert!(off.cmple(bound + 1e-6).all(), "texel {k}: {shown} {known}");
    }
    // A texel's numbers: the product is what the page adds.
    let read = did["read"].as_array().unwrap();
    let mut linked = 0;
    for own in read.iter().filter(|own| own["factors"].is_array()) {
        let [rho, radiosity, change] = [0, 3, 4].map(|k| vector(&own["factors"][k]));
        let [form_factor, share] = [1, 2].map(|k| own["factors"][k].as_f64().unwrap() as f32);
        let product = rho * form_factor * share * radiosity;
        assert!(
            (product - change).abs().cmple(product.abs() * 2e-4 + 1e-9).all(),
            "{own}"
        );
        linked += u32::from(change.x > 0.0);
    }
    assert!(linked > 5, "{linked} of {}", read.len());
    let energy: f64 = did["energy"]
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .sum();
    let emitted = did["emitted"].as_f64().unwrap();
    assert!((energy / emitted - 1.0).abs() < 1e-5, "{energy} {emitted}");
}
