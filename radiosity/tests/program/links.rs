//! `solve --trace` and its page.

use super::browser::{browser_for, page_outcome, with_script};
use super::command::TestFolder;
use common::settings::Settings;
use common::solution::StoredSolution;
use glam::Vec3;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveRequest, solve_request};
use oracle::trace::links::LinkRecord;
use oracle::trace::task::{SolveRecord, TracedScene};
use radiosity::report::trace::MAX_PAGE_BYTES;
use radiosity::report::trace::links::{LinkPage, METHOD_STEPS};
use radiosity_tests::bundled_scene;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use std::rc::Rc;

/// A script that moves through the steps and points at texels.
const POINT_SCRIPT: &str = include_str!("links.js");
const SOLVE_COMMAND: &str = "solve scenes/cornell_box.obj --solver cpu --error 5% --trace";
/// Relative error of the numbers on a page: five digits, of weights that are half floats.
const PAGE_ERROR: f32 = 1.0 / 2048.0 + 1e-4;

#[test]
fn links_are_written_beside_the_other_files_and_change_none() {
    let folder = TestFolder::new();
    let end = folder.succeed(&format!("{SOLVE_COMMAND} --out traced"));
    assert!(end.stderr.contains("wrote trace.html"), "{end}");
    folder.succeed(&SOLVE_COMMAND.replace("--trace", "--out plain"));
    assert!(!folder.has("plain/trace.html"));
    for file in ["lightmap.exr", "error.exr", "view.html"] {
        assert_eq!(
            folder.read(&format!("traced/{file}")),
            folder.read(&format!("plain/{file}")),
            "{file}"
        );
    }
    let page = folder.read_text("traced/trace.html");
    assert!(
        page.len() < MAX_PAGE_BYTES && page.contains("\"goal\":0.05"),
        "{}",
        page.len()
    );
    assert!(!page.contains("src=") && !page.contains("https:") && !page.contains("fetch("));
    folder.succeed(&format!("{SOLVE_COMMAND} --out again"));
    assert_eq!(page, folder.read_text("again/trace.html"));
}

#[test]
fn solves_without_links_are_refused() {
    let folder = TestFolder::new();
    let mut floor = "mtllib floor.mtl\nusemtl floor\n".to_owned();
    for k in 0..15 * 15 {
        let (x, z) = (k % 15, k / 15);
        for [dx, dz] in [[0, 0], [0, 1], [1, 1], [1, 0]] {
            writeln!(floor, "v {} 0 {}", x + dx, z + dz).unwrap();
        }
        floor += "f -4 -3 -2 -1\n";
    }
    folder.write("floor.obj", floor);
    folder.write("floor.mtl", "newmtl floor\nKd 0.5 0.5 0.5\nKe 1 1 1\n");
    folder.fail_with(
        2,
        "solve floor.obj --solver cpu --error 5% --trace",
        "rays solve a scene of 225 faces",
    );
    assert!(!folder.has("out"));
}

#[test]
fn note_counts_the_steps_of_the_page() {
    let note = |steps| {
        let page = LinkPage {
            html: String::new(),
            steps,
            step_count: 3,
        };
        page.describe_missing_steps().unwrap_or_default()
    };
    assert_eq!(note(3), "");
    assert!(
        note(1).starts_with("trace.html has the first 1 step of 3"),
        "{}",
        note(1)
    );
    assert!(note(0).starts_with("no trace.html is written"), "{}", note(0));
}

#[test]
fn steps_of_the_method_name_existing_functions() {
    let places = METHOD_STEPS.iter().flat_map(|step| [step.rust, step.wgsl]).flatten();
    assert_eq!(places.clone().count(), 8);
    for place in places {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(place.file);
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.contains(&format!("fn {}(", place.function)), "{place:?}");
    }
}

/// Records the solve of [`SOLVE_COMMAND`] again and checks the sum of the weights of each receiver on the page.
fn check_weights(sums: &[Value]) {
    let scene = bundled_scene("cornell_box.obj");
    let record = LinkRecord::new(usize::MAX);
    let request = SolveRequest {
        task: &TracedScene {
            scene: &scene,
            record: SolveRecord::Links(Rc::clone(&record)),
        },
        settings: &Settings::default(),
        solver: SolverChoice::Hierarchy(ErrorTarget {
            error: 0.05,
            texels: None,
        }),
    };
    solve_request(&request, &without_progress()).unwrap();
    let trace = record.take_trace();
    assert_eq!(sums.len(), trace.steps.len());
    let mut compared = 0;
    for (page, step) in sums.iter().zip(&trace.steps) {
        for (page, gather) in [&step.links.direct, &step.links.coarse, &step.links.fine]
            .into_iter()
            .enumerate()
            .map(|(k, gather)| (&page[k], gather))
        {
            let blocks = gather.blocks.iter();
            let spots = blocks.flat_map(|block| (0..block.spots.len()).map(move |l| (block, l)));
            let page = page.as_array().unwrap();
            assert_eq!(page.len(), spots.clone().count());
            for (own, (block, l)) in page.iter().zip(spots) {
                let node = step.links.nodes[block.spots[l].node as usize];
                assert_eq!(own[0].as_u64(), node.texel.map(u64::from));
                let sum: f32 = block.links.iter().map(|stored| stored.link.weight[l]).sum();
                let shown = own[1].as_f64().unwrap() as f32;
                assert!((shown - sum).abs() <= PAGE_ERROR * sum, "{own} {sum}");
                compared += 1;
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn links_page_shows_the_light_of_the_file() {
    let Some(browser) = browser_for("links_page_shows_the_light_of_the_file") else {
        return;
    };
    let folder = TestFolder::new();
    folder.succeed(SOLVE_COMMAND);
    folder.write(
        "point.html",
        with_script(&folder.read_text("out/trace.html"), POINT_SCRIPT),
    );
    let did = page_outcome(&browser, &folder.path("point.html"));
    assert_eq!(did["failed"], Value::Null, "{did}");
    let last = did["moves"][6][1].as_u64().unwrap();
    let moves = json!([
        ["start", 1, "1", "direct", "direct"],
        ["ArrowRight", 2, "2", "direct", "direct"],
        ["n", 2, "2", "coarse", "coarse"],
        ["n", 2, "2", "final", "final"],
        ["ArrowLeft", 1, "1", "final", "final"],
        ["n", 1, "1", "direct", "direct"],
        ["last step", last, last.to_string(), "direct", "direct"],
        ["final", last, last.to_string(), "final", "final"],
    ]);
    assert_eq!(did["moves"], moves);
    assert_eq!(did["address"], json!([format!("step={last}"), "part=final"]));
    assert_eq!((&did["requests"], &did["outlined"]), (&json!(0), &json!(4)));

    check_weights(did["sums"].as_array().unwrap());
    let stored = StoredSolution::read(&folder.path("out")).unwrap();
    let vector =
        |value: &Value, first: usize| Vec3::from_array([0, 1, 2].map(|c| value[first + c].as_f64().unwrap() as f32));
    let read = did["read"].as_array().unwrap();
    let [mut linked, mut whole] = [0, 0];
    for own in read {
        let sum = vector(&own["sum"], 0);
        let parts = vector(&own["mean"], 0) + vector(&own["slopes"], 0);
        let bound = Vec3::splat(2.0 * PAGE_ERROR * sum.max_element() + 1e-6);
        assert!((sum - parts).abs().cmple(bound).all(), "{own}");
        let [weight, weighed] = ["weight", "weighed"].map(|name| own[name].as_f64().unwrap() as f32);
        assert!(
            (weight - weighed).abs() <= PAGE_ERROR * weight && weight <= 1.01,
            "{own}"
        );
        let links = own["links"].as_u64().unwrap();
        assert_eq!(own["bars"].as_u64(), Some(links.min(12)), "{own}");
        assert!(own["lines"].as_u64() > Some(4 * links), "{own}");
        linked += links;
        // H of the last step is that of the file.
        if own["whole"].as_array().unwrap().len() == 12 {
            let texel = own["texel"].as_u64().unwrap() as usize;
            let [all, direct, gathered, rest] = [0, 3, 6, 9].map(|first| vector(&own["whole"], first));
            let known = stored.others["irradiance"][texel];
            assert!(
                (all - known).abs().max_element() <= 1e-4 * known.max_element(),
                "{own} {known}"
            );
            let bound = 4.0 * PAGE_ERROR * all.max_element();
            assert!((direct + gathered + rest - all).abs().max_element() <= bound, "{own}");
            let part = if own["part"] == "direct" { direct } else { gathered };
            assert!((part - sum).abs().max_element() <= bound, "{own}");
            assert_eq!(own["is_leaf"], true);
            whole += 1;
        }
    }
    assert!(
        read.len() > 40 && linked > 1000 && whole > 10,
        "{} {linked} {whole}",
        read.len()
    );
}
