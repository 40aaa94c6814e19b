//! The report: complete, offline, as the contract has it, whatever the data.

use super::scenes::{cornell, paper_room, patchwork, run};
use common::energy::Energy;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Drawing, Meshing, Schedule, Settings, Visibility};
use common::shooting::replay;
use cpu::CpuSolver;
use cpu::twin::item_buffer::ItemBuffer;
use cpu::twin::view::View;
use glam::Vec4;
use oracle::judge::comparison::Told;
use oracle::judge::comparison::{
    Comparison, Difference, Finding, Gate, ItemBufferPicture, Judged, Pairs, Stage, Way,
};
use oracle::show::report::{html, json};

/// Rays against the twin, which stands in for the GPU.
fn compared(scene: Scene, texels: u32, item_buffer: u32) -> Comparison {
    let settings = Settings {
        meshing: Meshing {
            texels,
            cells: 1,
            ..Meshing::default()
        },
        schedule: Schedule {
            epsilon: 0.05,
            ..Schedule::default()
        },
        ..Settings::default()
    };
    let drawing = Drawing {
        size: item_buffer,
        ..Drawing::DEFAULT
    };
    let gpu_settings = settings.by(Visibility::Drawn(drawing));
    let mesh = Mesh::uniform(&scene, texels, 1).unwrap();
    let cpu = run(&mesh, &settings);
    let gpu = run(&mesh, &gpu_settings);
    let lockstep = replay(
        &mut CpuSolver::new(&mesh, &gpu_settings.transport),
        &cpu.cells(),
    )
    .unwrap();
    let difference = Difference {
        relative_rms: 0.0123,
        max_relative: 0.4,
        bias: -0.001,
    };
    let cell = cpu.shots[0].cell;
    let view = View::new(&mesh, cell, 0, &drawing);
    Comparison {
        cpu_energy: Energy::new(&mesh, &cpu.field, &cpu.shots),
        gpu_energy: Energy::new(&mesh, &gpu.field, &gpu.shots),
        item_buffer: Some(ItemBufferPicture {
            cell,
            size: item_buffer,
            ids: ItemBuffer::draw(&mesh, &view, mesh.room).ids,
        }),
        asked: None,
        estimates: [None, None],
        off: None,
        settings,
        gpu_settings,
        adapter: "twin (stands in for <a GPU>)".into(),
        seconds: [1.234, 0.5],
        stages: vec![
            stage("item_buffer.wgsl", 3.0, 0.0),
            stage("deposit.wgsl", 1.0, 4.0),
        ],
        pairs: Pairs {
            pairs: 1_234_567,
            facing: 800_000,
            mismatched: 1200,
            explained: 1199,
            vanished: 17,
            unexplained: 1,
            explainable: 30_000,
            weighted_mismatch: 0.0014,
            weighted_explainable: 0.03,
            histogram: vec![900, 250, 40, 0, 9, 0, 0, 1],
            examples: vec![(0, 5)],
        },
        lockstep_difference: difference,
        free_difference: difference,
        gates: vec![
            Gate::at_most(
                "lockstep RMS",
                0.0123,
                0.02,
                "one pixel of silhouette per texel",
            ),
            Gate::at_most(
                "energy imbalance, CPU",
                3e-7,
                1e-5,
                "f32 sums over the shots",
            ),
        ],
        way: Way::Paper,
        error: [Some(0.32), Some(0.33)],
        truth: Some(Told {
            name: "the matrix on <few> texels".into(),
            texels: 8,
            own_error: 0.004,
        }),
        findings: vec![Finding {
            name: "item buffer".into(),
            value: 0.02,
            message: "silhouettes; --visibility rays has none of it".into(),
        }],
        notes: vec!["CPU: solved as often as is done".into()],
        scene,
        mesh,
        cpu,
        gpu,
        lockstep,
    }
}

fn alone(first: Comparison) -> Judged {
    Judged {
        first,
        as_solved: None,
    }
}

fn stage(name: &str, worst: f64, bound: f64) -> Stage {
    Stage {
        name: name.into(),
        values: 516_096,
        differing: 12,
        worst,
        bound,
        reason: "products are added left to right in both".into(),
        agree: worst <= bound,
    }
}

/// The text between two marks, for each pair of marks.
fn between<'a>(text: &'a str, open: &str, close: &str) -> Vec<&'a str> {
    text.split(open)
        .skip(1)
        .filter_map(|rest| rest.split(close).next())
        .collect()
}

#[test]
fn the_page_has_every_figure_and_loads_nothing() {
    let mut failing = compared(paper_room(), 4, 128);
    failing.gates.push(Gate::at_most(
        "unexplained pairs",
        1.0,
        0.0,
        "each would be a bug",
    ));
    let both = Judged {
        first: compared(cornell(), 16, 256),
        as_solved: Some(Comparison {
            way: Way::Solve,
            ..compared(cornell(), 8, 64)
        }),
    };
    // Which answers are the same but for rounding depends on the adapter.
    let mut alike = compared(patchwork(), 8, 128);
    for difference in [&mut alike.free_difference, &mut alike.lockstep_difference] {
        difference.max_relative = 1e-7;
    }
    let scenes = [both, alone(failing), alone(alike)];
    let ways = scenes.iter().flat_map(Judged::ways).count();
    let page = html(&scenes, &["No GPU for <b>: left out".to_owned()]);
    std::fs::write(concat!(env!("CARGO_TARGET_TMPDIR"), "/report.html"), &page).unwrap();

    assert!(!page.contains("http:") && !page.contains("https:"));
    // A viewer a scene has two elements of data; one program serves all.
    assert_eq!(page.matches("<script").count(), 2 * scenes.len() + 1);
    assert!(!page.contains("url(") && !page.contains("@import") && !page.contains("<link"));
    let sources = between(&page, "src=\"", "\"");
    // Answers that are the same but for rounding have no picture of it, the others two.
    let same = |c: &&Comparison| {
        let both = [&c.free_difference, &c.lockstep_difference];
        both.iter()
            .all(|difference| difference.max_relative <= 1e-6)
    };
    let same = scenes.iter().flat_map(Judged::ways).filter(same).count();
    assert!((1..ways).contains(&same));
    assert_eq!(page.matches("no difference to draw").count(), same);
    // What is seen first; two views, two differences, two atlases, item buffer and its colours: 9 a way.
    assert_eq!(sources.len(), 9 * ways - 2 * same);
    assert!(
        sources
            .iter()
            .all(|source| source.starts_with("data:image/png;base64,iVBOR"))
    );
    assert_eq!(page.matches("<svg").count(), 2 * ways);
    assert_eq!(page.matches("<figcaption>").count(), 11 * ways - 2 * same);
    assert!(
        between(&page, "<figcaption>", "</figcaption>")
            .iter()
            .all(|text| text.len() > 20)
    );
    for text in [
        "No GPU for &lt;b&gt;: left out",
        "Agree",
        "Disagree",
        "conditions fail: unexplained pairs",
        "off on the CPU and",
        "--visibility rays has none of it",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert!(page.contains("stands in for &lt;a GPU&gt;"));
    for tag in [
        "table", "tr", "td", "figure", "section", "div", "svg", "details",
    ] {
        let open =
            page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert_eq!(open, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}

#[test]
fn the_description_is_the_contracts() {
    let scenes = [Judged {
        first: compared(cornell(), 4, 64),
        as_solved: Some(compared(cornell(), 4, 64)),
    }];
    let value = json(&scenes);
    let scene = &value["scenes"][0];
    assert_eq!(scene["scene"], "cornell-like");
    assert_eq!(scene["agree"], true);
    for (object, keys) in [
        ("shots", &["cpu", "gpu"][..]),
        ("radiosity", &["relative_rms", "max_relative", "bias"]),
        ("free", &["relative_rms", "max_relative", "bias"]),
        (
            "visibility",
            &[
                "pairs",
                "mismatched",
                "explained",
                "unexplained",
                "facing",
                "explainable",
                "weighted_mismatch",
                "histogram",
            ],
        ),
        ("energy", &["cpu", "gpu"]),
        ("bounds", &["lockstep RMS"]),
        ("error", &["cpu", "gpu"]),
        ("stages", &["deposit.wgsl"]),
        ("settings", &["cpu", "gpu"]),
        ("interpolation", &["relative_rms", "max_step"]),
    ] {
        for key in keys {
            assert!(!scene[object][key].is_null(), "{object}.{key}");
        }
    }
    for part in ["emitted", "absorbed", "unshot", "escaped", "closure"] {
        assert_eq!(
            scene["energy"]["gpu"][part].as_array().map(Vec::len),
            Some(3)
        );
    }
    assert_eq!(scene["bounds"]["lockstep RMS"]["bound"], 0.02);
    assert!(
        scene["gates"].is_array() && scene["findings"].is_array() && scene["adapter"].is_string()
    );
}

#[test]
fn data_that_is_not_nice_still_gives_a_page() {
    let mut c = compared(patchwork(), 2, 16);
    c.gpu.field.irradiance[3] = Vec4::NAN;
    c.gpu.field.radiosity[3] = Vec4::INFINITY;
    c.lockstep.field.irradiance.clear();
    c.cpu.shots.clear();
    c.gpu.shots[0].unshot = f32::NAN;
    c.gpu.emitted = 0.0;
    c.settings.schedule.epsilon = f64::NAN;
    let shot = c.item_buffer.as_mut().unwrap();
    shot.ids.truncate(7);
    shot.cell = u32::MAX;
    c.pairs = Pairs {
        examples: vec![(u32::MAX, u32::MAX)],
        ..Pairs::default()
    };
    c.gates = vec![Gate::at_most("nothing", f64::NAN, 1.0, "")];
    c.stages.clear();
    c.free_difference.bias = f64::INFINITY;
    c.truth = None;
    c.error = [None, Some(f64::NAN)];
    assert!(!c.agree());
    let judged = [alone(c)];
    let page = html(&judged, &[]);
    assert!(
        page.contains("not a number")
            && page.contains("Nothing was shot.")
            && page.contains("No mismatch at all.")
    );
    assert!(json(&judged)["scenes"][0]["bounds"]["nothing"]["value"].is_null());
    assert!(html(&[], &[]).contains("Nothing compared"));
}
