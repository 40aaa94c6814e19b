//! The report of `compare`: complete, offline, with the fields of the contract, for any data.

use super::scenes::patchwork_floor;
use common::scene::Scene;
use glam::Vec4;
use oracle::compare::comparison::{
    Comparison, Criterion, MethodFinding, Preset, SceneComparison, TruthInfo, VisibilityStatistics,
};
use radiosity::report::comparison::{render_report, report_json};
use radiosity_tests::bundled_scene;
use radiosity_tests::engines::item_buffer;
use radiosity_tests::shader_faults::{compare_with_faults, paper_settings};

/// Compares the solvers; adapter, truth and findings are made up.
fn made_comparison(scene: &Scene, texels: u32, pixels: u32) -> Comparison {
    let settings = paper_settings(item_buffer(pixels), texels, 0.05, u32::MAX);
    Comparison {
        adapter: "a driver (stands in for <a GPU>)".into(),
        truth_error: [Some(0.32), Some(0.33)],
        truth: Some(TruthInfo {
            name: "the matrix on <few> texels".into(),
            texels: 8,
            own_error: 0.004,
        }),
        findings: vec![MethodFinding {
            name: "item buffer".into(),
            value: 0.02,
            message: "silhouettes; --visibility rays has none of it".into(),
        }],
        notes: vec!["CPU: solved as often as is done".into()],
        ..compare_with_faults(scene, settings, &[]).unwrap()
    }
}

fn without_second_preset(first: Comparison) -> SceneComparison {
    SceneComparison {
        first,
        solve_default: None,
    }
}

/// Returns the texts between each pair of marks.
fn texts_between<'a>(text: &'a str, open: &str, close: &str) -> Vec<&'a str> {
    text.split(open)
        .skip(1)
        .filter_map(|rest| rest.split(close).next())
        .collect()
}

#[test]
fn report_has_every_figure_and_loads_nothing() {
    let mut failing = made_comparison(&bundled_scene("paper_room_objects.obj"), 4, 128);
    let failed = Criterion::at_most("unexplained pairs", 1.0, 0.0, "each would be a bug");
    failing.criteria.push(failed);
    let both = SceneComparison {
        first: made_comparison(&bundled_scene("cornell_box.obj"), 8, 64),
        solve_default: Some(Comparison {
            preset: Preset::SolveDefault,
            ..made_comparison(&bundled_scene("cornell_box.obj"), 8, 64)
        }),
    };
    // A comparison whose solutions are equal up to rounding.
    let mut alike = made_comparison(&patchwork_floor(), 8, 128);
    for difference in [&mut alike.free_difference, &mut alike.lockstep_difference] {
        difference.max_relative = 1e-7;
    }
    let scenes = [both, without_second_preset(failing), without_second_preset(alike)];
    let ways = scenes.iter().flat_map(SceneComparison::iter_comparisons).count();
    let page = render_report(&scenes, &["No GPU for <b>: left out".to_owned()]);
    std::fs::write(concat!(env!("CARGO_TARGET_TMPDIR"), "/report.html"), &page).unwrap();

    assert!(!page.contains("http:") && !page.contains("https:"));
    // Each scene's viewer has two elements of data, and one script serves all.
    assert_eq!(page.matches("<script").count(), 2 * scenes.len() + 1);
    assert!(!page.contains("url(") && !page.contains("@import") && !page.contains("<link"));
    let sources = texts_between(&page, "src=\"", "\"");
    // Solutions that are equal up to rounding have no picture of their difference.
    let equal = |c: &&Comparison| {
        let both = [&c.free_difference, &c.lockstep_difference];
        both.iter().all(|difference| difference.max_relative <= 1e-6)
    };
    let all = scenes.iter().flat_map(SceneComparison::iter_comparisons);
    let same = all.filter(equal).count();
    assert!((1..ways).contains(&same));
    assert_eq!(page.matches("no difference to draw").count(), same);
    // Two views, their difference, item buffer and its colours: 5 per comparison.
    assert_eq!(sources.len(), 5 * ways - same);
    let embedded = |source: &&str| source.starts_with("data:image/png;base64,iVBOR");
    assert!(sources.iter().all(embedded));
    assert_eq!(page.matches("<figcaption>").count(), 5 * ways - same);
    let captions = texts_between(&page, "<figcaption>", "</figcaption>");
    assert!(captions.iter().all(|text| text.len() > 20));
    for text in [
        "No GPU for &lt;b&gt;: left out",
        "Agree",
        "Disagree",
        "criteria fail: unexplained pairs",
        "on the CPU, <span",
        "--visibility rays has none of it",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert!(page.contains("stands in for &lt;a GPU&gt;"));
    for tag in ["table", "tr", "td", "figure", "section", "div", "svg", "details"] {
        let open = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert_eq!(open, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}

#[test]
fn report_json_has_fields_of_contract() {
    let scenes = [SceneComparison {
        first: made_comparison(&bundled_scene("cornell_box.obj"), 4, 64),
        solve_default: Some(made_comparison(&bundled_scene("cornell_box.obj"), 4, 64)),
    }];
    let value = report_json(&scenes);
    let scene = &value["scenes"][0];
    assert!(scene["scene"].as_str().unwrap().ends_with("cornell_box.obj"));
    assert_eq!(scene["agree"], true);
    for (object, keys) in [
        ("shots", &["cpu", "gpu"][..]),
        ("radiosity", &["relative_rms", "max_relative", "bias"]),
        ("free", &["relative_rms", "max_relative", "bias"]),
        (
            "visibility",
            &["pairs", "mismatched", "explained", "unexplained", "facing"],
        ),
        ("visibility", &["explainable", "weighted_mismatch", "histogram"]),
        ("energy", &["cpu", "gpu"]),
        ("bounds", &["lockstep: relative RMS"]),
        ("error", &["cpu", "gpu"]),
        ("stages", &["deposit"]),
        ("settings", &["cpu", "gpu"]),
    ] {
        for key in keys {
            assert!(!scene[object][key].is_null(), "{object}.{key}");
        }
    }
    for part in ["emitted", "absorbed", "unshot", "escaped", "closure"] {
        assert_eq!(scene["energy"]["gpu"][part].as_array().map(Vec::len), Some(3));
    }
    assert!(scene["bounds"]["lockstep: relative RMS"]["bound"].as_f64() > Some(0.0));
    assert!(scene["gates"].is_array() && scene["findings"].is_array() && scene["adapter"].is_string());
}

#[test]
fn nan_and_missing_data_still_give_a_report() {
    let mut c = made_comparison(&patchwork_floor(), 2, 16);
    c.gpu.field.irradiance[3] = Vec4::NAN;
    c.gpu.field.radiosity[3] = Vec4::INFINITY;
    c.lockstep.field.irradiance.clear();
    c.cpu.shots.clear();
    c.gpu.shots[0].unshot = f32::NAN;
    c.gpu.emitted = 0.0;
    c.settings.schedule.epsilon = f64::NAN;
    let shot = c.item_buffer.as_mut().unwrap();
    shot.ids.truncate(7);
    shot.patch = u32::MAX;
    c.pairs = VisibilityStatistics {
        examples: vec![(u32::MAX, u32::MAX)],
        ..VisibilityStatistics::default()
    };
    c.criteria = vec![Criterion::at_most("nothing", f64::NAN, 1.0, "")];
    c.stages.clear();
    c.free_difference.bias = f64::INFINITY;
    c.truth = None;
    c.truth_error = [None, Some(f64::NAN)];
    assert!(!c.solvers_agree());
    let judged = [without_second_preset(c)];
    let page = render_report(&judged, &[]);
    for text in ["not a number", "not known"] {
        assert!(page.contains(text), "{text}");
    }
    assert!(report_json(&judged)["scenes"][0]["bounds"]["nothing"]["value"].is_null());
    assert!(render_report(&[], &[]).contains("Nothing compared"));
}
