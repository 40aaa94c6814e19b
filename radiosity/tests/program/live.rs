//! The live page of `web/live`: what it solves in a browser is what the same code solves natively.

use super::browser::browser_for;
use super::command::TestFolder;
use crate::baked::BakedScene;
use common::file::keep_in_memory;
use common::settings::Settings;
use common::shooting::{Shoot, shoot_until_converged};
use glam::{Vec3, Vec4};
use gpu::{Gpu, GpuSolver};
use live::browser_gpu::{LiveShader, list_shaders};
use live::case::{ExactComparison, list_cases};
use live::change::{GroupChange, change_scene};
use live::fault::{LIVE_FAULTS, LiveFault};
use live::gpu_comparison::{check_origins, compare_with_gpu};
use live::request::{LiveRequest, LiveSolver};
use live::slice::{RecordedGpu, shoot_in_slices};
use live::solve::{LiveScene, LiveSolve};
use oracle::solve::progress::without_progress;
use oracle::trace::recorder::{ShotRecord, ShotRecorder};
use pollster::block_on;
use radiosity::report::trace::TRACE_LIMITS;
use radiosity::studies::stress::Verdict;
use radiosity::studies::stress::cases::ALL_CASES;
use radiosity::studies::stress::methods::{DISC, POLYGON, STEREOGRAPHIC};
use radiosity::studies::stress::run::AtlasRun;
use radiosity::studies::stress::trial::TruthCache;
use radiosity_tests::served_pages::work_pages;
use serde_json::{Value, json};
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;
use web::live_page::{LIVE_SCENES, write_live_page};

/// Works the live page in frames.
const SCRIPT: &str = include_str!("live.js");
/// Time after which a page that hands nothing over is given up.
const OUTCOME_LIMIT: Duration = Duration::from_secs(420);
/// Maximum bytes of the program, compressed by deflate as servers do.
const MAX_PROGRAM_BYTES: usize = 2_000_000;

fn repository_root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Returns the program of the page; without one prints that the test is skipped.
fn module_for(test: &str) -> Option<PathBuf> {
    let module = std::env::var_os("RADIOSITY_WASM").map(PathBuf::from);
    if module.is_none() {
        eprintln!("SKIPPED {test}: RADIOSITY_WASM names no program of the live page");
    }
    module
}

/// Opens a bundled scene as the page does: its files are in memory.
fn open_bundled(scene: &str) -> LiveScene {
    for extension in ["obj", "mtl"] {
        let name = format!("{scene}.{extension}");
        let content = fs::read(repository_root().join("scenes").join(&name)).unwrap();
        keep_in_memory(Path::new(&name), Some(content));
    }
    LiveScene::open(&format!("{scene}.obj"), None).unwrap()
}

/// Solves a bundled scene natively with the page's first settings; the automatic view uses sines, which a browser rounds
/// otherwise.
fn solve_natively(scene: &str, changes: Value, view: Value) -> LiveSolve {
    let mut live = open_bundled(scene);
    let request = LiveRequest::parse(&first_request(changes, view)).unwrap();
    solve_whole(&mut live, &request)
}

fn solve_whole(live: &mut LiveScene, request: &LiveRequest) -> LiveSolve {
    block_on(live.solve(request, &without_progress(), async |_| ControlFlow::Continue(()))).unwrap()
}

/// Returns the page's first request of a scene of few faces.
fn first_request(changes: Value, view: Value) -> String {
    let request = json!({
        "texels": 8, "patches": 2, "samples": 1, "visibility": "rays", "pixels": 128, "form_factor": "polygon",
        "epsilon": 0.001, "changes": changes, "view": view,
    });
    request.to_string()
}

#[test]
fn live_page_solves_as_the_native_program() {
    let test = "live_page_solves_as_the_native_program";
    let (Some(module), Some(browser)) = (module_for(test), browser_for(test)) else {
        return;
    };
    let folder = TestFolder::new();
    write_live_page(repository_root(), &module, &folder.path("page")).unwrap();
    let program = fs::read(folder.path("page/program_bg.wasm")).unwrap();
    let compressed = miniz_oxide::deflate::compress_to_vec(&program, 9).len();
    assert!(compressed < MAX_PROGRAM_BYTES, "{compressed} bytes");
    let outcome = work_pages(&browser, &folder.path(""), SCRIPT, OUTCOME_LIMIT);
    assert_eq!(outcome["failed"], Value::Null);
    for scene in LIVE_SCENES {
        let native = solve_natively(scene, json!([]), Value::Null);
        let live = &outcome["scenes"][scene];
        assert_eq!(live["solver"], "cpu", "{scene}");
        assert_eq!(live["shots"], native.shots, "{scene}");
        assert_eq!(live["checksum"], native.checksum, "{scene}");
    }
    let native = solve_natively("cornell_box", json!([]), outcome["view"].clone());
    let record = outcome["record"].as_str().unwrap();
    assert_eq!(without_arrays(record), without_arrays(&native.html));
    assert_eq!(outcome["records"], 1);
    let moved = &outcome["moved"];
    assert_eq!(moved["shots"], native.shots);
    assert_eq!(moved["stepped"], native.shots - 1);
    assert_eq!(moved["scrubbed"], 3);
    assert_eq!(moved["played"], true);
    assert!(outcome["colours"].as_u64().unwrap() > 100, "{}", outcome["colours"]);
    check_pointed_texel(&outcome["pointed"]);
    check_changes(&outcome, &native);
    check_gpu(&outcome["gpu"], native.shots);
    check_gpu_solve(&outcome, &native);
    check_cases(&outcome["cases"]);
    assert_eq!(outcome["item_buffer"]["what"], "error");
    assert!(outcome["item_buffer"]["wrong"].as_f64().unwrap() > 0.01);
    check_stop(&outcome);
    check_panoramas(&outcome["lit"]);
    check_saved_scenes(&outcome["saved"]);
    assert_eq!(outcome["resumed"]["checksum"], native.checksum);
    check_stage_test(&outcome);
    check_files(&outcome);
    assert_eq!(outcome["phone"]["state"], "estimated");
    assert!(outcome["phone"]["wide"].as_u64().unwrap() <= 390);
    assert!(outcome["desktop"].as_u64().unwrap() <= 1280);
    assert_eq!(outcome["elsewhere"], json!([]));
}

/// Returns a record's element without its packed arrays: they hold pictures of the hemisphere, in which single pixels on edges
/// are rounded otherwise.
fn without_arrays(html: &str) -> String {
    let mut parts = html.split("<script class=\"trace-arrays\"");
    let text = parts.next().unwrap().to_owned();
    assert!(parts.next().unwrap().len() > 10_000);
    text
}

/// The numbers that are told are those of the state that is shown.
fn check_pointed_texel(pointed: &Value) {
    let told = pointed["told"].as_str().unwrap();
    let last = told.split('→').next_back().unwrap().trim_end_matches("W/m²");
    let told: Vec<f64> = last.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let state: Vec<f64> = serde_json::from_value(pointed["state"].clone()).unwrap();
    assert_eq!(told.len(), 3);
    for (told, state) in told.iter().zip(&state) {
        // Five significant digits are told.
        assert!(*state > 0.0 && (told / state - 1.0).abs() < 1e-4, "{pointed}");
    }
}

/// A lamp that moves keeps its power, one that is dimmed halves it, and what is undone comes back to the bit.
fn check_changes(outcome: &Value, native: &LiveSolve) {
    let emitted = |name: &str| outcome[name]["power"]["emitted"].as_f64().unwrap();
    let absorbed = |name: &str| outcome[name]["power"]["absorbed"].as_f64().unwrap();
    let shift = outcome["lamp_moved"]["shift"].as_f64().unwrap();
    let moved = solve_natively(
        "cornell_box",
        json!([{ "name": "light", "shift": [shift, 0, 0] }]),
        Value::Null,
    );
    assert!(shift < 0.0);
    assert_eq!(outcome["lamp_moved"]["checksum"], moved.checksum);
    assert_ne!(moved.checksum, native.checksum);
    assert!((emitted("lamp_moved") / emitted("first") - 1.0).abs() < 1e-6);
    assert!((emitted("lamp_dimmed") / emitted("first") - 0.5).abs() < 1e-6);
    assert!(absorbed("wall_painted") > 1.01 * absorbed("lamp_dimmed"));
    assert_eq!(outcome["undone"], outcome["first"]);
    assert_eq!(outcome["first"]["checksum"], native.checksum);
}

/// The GPU agrees, a changed shader differs and its stage is named, and one that cannot be compiled is refused with its place.
fn check_gpu(gpu: &Value, shots: usize) {
    assert_eq!(gpu["has"], true);
    let own = &gpu["as_it_is"];
    assert_eq!(own["tone"], "verdict agree", "{own}");
    assert_eq!(own["shots"], shots);
    assert_eq!(own["first_other_shooter"], Value::Null);
    assert!(own["difference"].as_f64().unwrap() < 1e-5, "{own}");
    assert_eq!(own["viewers"], 1);
    assert_eq!(gpu["changed"]["tone"], "verdict disagree");
    let said = gpu["changed"]["said"].as_str().unwrap();
    assert!(said.contains("differs from its twin: link: "), "{said}");
    let chosen = gpu["chosen"]["said"].as_str().unwrap();
    assert!(
        chosen.contains("differs from its twin: select: shooter of shot 0: "),
        "{chosen}"
    );
    let refused = gpu["refused"]["said"].as_str().unwrap();
    assert!(refused.contains("deposit.wgsl:13:1: expected"), "{refused}");
    assert_eq!(gpu["refused"]["viewers"], 0);
}

/// The GPU solves the scene as the CPU does, is judged beside it, and is replaced by it where it fails.
fn check_gpu_solve(outcome: &Value, native: &LiveSolve) {
    let solve = &outcome["gpu_solve"];
    assert_eq!(solve["solver"], "gpu");
    assert_eq!(solve["shots"], native.shots);
    assert_eq!(solve["shown"], native.shots);
    let told = solve["told"].as_str().unwrap();
    assert!(told.starts_with("GPU (google swiftshader), by WebGPU: "), "{told}");
    let absorbed = solve["power"]["absorbed"].as_f64().unwrap();
    assert!((absorbed / native.power.absorbed - 1.0).abs() < 1e-5, "{absorbed}");
    assert_eq!(solve["verdict"]["tone"], "verdict agree", "{solve}");
    let fallen = &outcome["gpu_failed"];
    assert_eq!(fallen["solver"], "cpu");
    assert_eq!(fallen["checksum"], native.checksum);
    let told = fallen["told"].as_str().unwrap();
    assert!(told.starts_with("The GPU failed: the device is lost. CPU, "), "{told}");
}

/// All stages are right by every visibility; a changed shader makes its own wrong by each.
fn check_stage_test(outcome: &Value) {
    let visibilities = |report: &Value| report["visibilities"].as_array().unwrap().clone();
    let wrong = |checked: &Value| {
        let checks = checked["checks"].as_array().unwrap().iter();
        let wrong = checks.filter(|check| check["agree"] != true);
        wrong
            .map(|check| check["name"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    let [own, changed] = ["as_it_is", "changed"].map(|which| outcome["stages"][which].clone());
    assert_eq!(visibilities(&own["report"]).len(), 5);
    for checked in visibilities(&own["report"]) {
        assert!(checked["checks"].as_array().unwrap().len() > 20, "{checked}");
        assert!(wrong(&checked).is_empty(), "{checked}");
    }
    assert!(own["said"].as_str().unwrap().ends_with(" checks are right, 0 wrong."));
    for checked in visibilities(&changed["report"]) {
        let names = wrong(&checked);
        assert!(
            !names.is_empty() && names.iter().all(|name| name.contains("link")),
            "{names:?}"
        );
    }
    assert!(changed["said"].as_str().unwrap().contains(", link.wgsl changed: "));
    assert!(changed["cells"]["wrong"].as_u64().unwrap() >= 5);
    assert!(own["cells"]["wrong"] == 0 && own["cells"]["right"].as_u64().unwrap() > 100);
}

/// A panorama lights an open scene, and a closed one says that it is closed.
fn check_panoramas(lit: &Value) {
    let panorama: Vec<u8> = [0x80, 0x80, 0x80, 0x81].repeat(128);
    let head: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n";
    keep_in_memory(Path::new("sky.hdr"), Some([head, &panorama].concat()));
    let solve = |scene: &str| {
        open_bundled(scene);
        let mut live = LiveScene::open(&format!("{scene}.obj"), Some("sky.hdr")).unwrap();
        let request = first_request(json!([]), Value::Null);
        solve_whole(&mut live, &LiveRequest::parse(&request).unwrap())
    };
    let (open, closed) = (solve("facing_plates").outside.unwrap(), solve("furnace").outside);
    assert_eq!(closed, Some(0.0));
    let found = lit["facing_plates"]["outside"].as_f64().unwrap();
    assert!(open > 0.1 && (found / open - 1.0).abs() < 1e-4, "{found} {open}");
    assert_eq!(lit["furnace"]["outside"], 0.0);
    assert_eq!(lit["reset"], Value::Null);
    let said = |scene: &str, part: &str| lit[scene][part].as_str().unwrap().to_owned();
    assert!(said("facing_plates", "note").contains("The light of sky.hdr comes from outside."));
    assert!(said("facing_plates", "told").contains(" From outside come "), "{lit}");
    assert!(said("furnace", "told").contains("No light comes in from outside: the scene is closed."));
    let damaged = lit["damaged"].as_str().unwrap();
    assert!(
        damaged.starts_with("sky.hdr: is neither a Radiance picture"),
        "{damaged}"
    );
}

/// A scene is saved with its groups and its light.
fn check_saved_scenes(saved: &Value) {
    for (name, nodes) in [("whole", 8), ("moved", 8)] {
        let document = &saved[name]["json"];
        assert_eq!(saved[name]["name"], "radiosity.glb");
        let names = document["nodes"]
            .as_array()
            .unwrap()
            .iter()
            .map(|node| node["name"].as_str().unwrap());
        assert_eq!(names.clone().count(), nodes, "{name}");
        assert!(names.clone().any(|own| own == "light"), "{name}");
        let lit = document["materials"].as_array().unwrap();
        assert!(
            lit.iter()
                .all(|own| own["extensions"]["MOZ_lightmap"]["intensity"].as_f64() > Some(0.0))
        );
        assert_eq!(document["images"][0]["mimeType"], "image/png");
        let bytes = document["buffers"][0]["byteLength"].as_u64().unwrap();
        assert!(
            bytes > 10_000 && saved[name]["length"].as_u64().unwrap() > bytes,
            "{name}"
        );
    }
}

/// Saves the scene of the latest solve and reads it again; its lightmap is lit.
fn save_scene(live: &LiveScene) -> BakedScene {
    let baked = BakedScene::new(&live.encode_glb().unwrap());
    let lightmap = &baked.json["materials"][0]["extensions"]["MOZ_lightmap"];
    assert!(lightmap["intensity"].as_f64().unwrap() > 0.0);
    baked
}

#[test]
fn scene_is_saved_with_its_light_as_it_was_solved() {
    let mut live = open_bundled("cornell_box");
    assert!(
        live.encode_glb()
            .is_err_and(|error| error.to_string().contains("nothing is solved"))
    );
    let solve = |live: &mut LiveScene, changes: Value| {
        solve_whole(live, &LiveRequest::parse(&first_request(changes, Value::Null)).unwrap());
        save_scene(live)
    };
    let whole = solve(&mut live, json!([]));
    let moved = solve(
        &mut live,
        json!([{ "name": "light", "shift": [-0.25, 0, 0], "emission_factor": 2.0 }]),
    );
    assert_eq!(whole.triangles.len(), moved.triangles.len());
    let corners =
        |baked: &BakedScene| -> Vec<Vec3> { baked.triangles.iter().flatten().map(|(place, _)| *place).collect() };
    let [before, after] = [&whole, &moved].map(corners);
    let shifted = after
        .iter()
        .filter(|place| before.iter().all(|own| own.distance(**place) > 0.01))
        .count();
    // The two triangles of the lamp.
    assert_eq!(shifted, 6);
    let strength = |baked: &BakedScene| -> f64 {
        let materials = baked.json["materials"].as_array().unwrap().iter();
        let own =
            |material: &Value| material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"].as_f64();
        materials.filter_map(own).sum()
    };
    assert!((strength(&moved) / strength(&whole) - 2.0).abs() < 1e-5);
    let mut case = LiveScene::open_case("slit", 0.1, None).unwrap();
    assert_eq!(solve(&mut case, json!([])).triangles.len(), 8);
}

/// A solve that is stopped shows its first shots, and the GPU makes the same.
fn check_stop(outcome: &Value) {
    let stopped = &outcome["stopped"];
    let shots = stopped["shots"].as_u64().unwrap();
    assert_eq!(stopped["last_words"], "Stopping after this shot …");
    assert!(stopped["frames"].as_u64().unwrap() > 1, "{stopped}");
    assert_eq!(stopped["stopped"], true);
    assert_eq!(stopped["shown"], shots);
    let power = |part: &str| stopped["power"][part].as_f64().unwrap();
    let unshot = power("unshot") / power("emitted");
    assert!((0.001..1.0).contains(&unshot), "{unshot}");
    let told = stopped["told"].as_str().unwrap();
    assert!(told.starts_with(&format!("Stopped after {shots} shot")), "{told}");
    assert!(told.contains(" % unshot. CPU"), "{told}");
    assert!(stopped["energy"].as_str().unwrap().contains("unshot"), "{stopped}");
    assert!(stopped["lightmap"].as_u64().unwrap() > 1000, "{stopped}");
    assert_eq!(stopped["gpu"]["tone"], "verdict agree", "{stopped}");
    assert_eq!(stopped["gpu"]["shots"], shots);
    assert_eq!(
        outcome["ended"]["told"],
        "Ended: the record is that of the solve before."
    );
    assert_eq!(outcome["ended"]["lightmap"], true);
}

/// The GPU that is awaited makes the shots and the record of single shots that wait.
#[test]
fn gpu_records_the_shots_of_the_native_program() {
    let mut live = open_bundled("cornell_box");
    let mut request = LiveRequest::parse(&first_request(json!([]), Value::Null)).unwrap();
    (request.solver, request.visibility, request.pixels) = (LiveSolver::Gpu, "stereographic".to_owned(), 16);
    let told = solve_whole(&mut live, &request);
    let latest = live.latest().unwrap();
    let (
        mesh,
        Settings {
            transport, schedule, ..
        },
    ) = (&latest.solved.mesh, &latest.solved.settings);
    let gpu = Gpu::open(None).unwrap();
    assert_eq!(
        (told.solver.as_str(), told.adapter.as_deref()),
        ("gpu", Some(&*gpu.line.name))
    );
    let mut engine = GpuSolver::new(&gpu, mesh, transport).unwrap();
    let mut recorder = ShotRecorder::new(&mut engine, mesh, transport, TRACE_LIMITS).unwrap();
    let native = shoot_until_converged(&mut recorder, schedule, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let waited = recorder.into_trace();
    assert!(native.shots.len() > 50 && native.field.radiosity.iter().any(|b| *b != Vec4::ZERO));
    assert_eq!(latest.solved.run.shots, native.shots);
    assert_eq!(latest.solved.run.field, native.field);
    let mut solver = GpuSolver::new(&gpu, mesh, transport).unwrap();
    let initial = solver.read_field().unwrap();
    let mut recorded = RecordedGpu {
        power: solver.patch_power().unwrap(),
        record: ShotRecord::new(mesh, transport, TRACE_LIMITS, initial).unwrap(),
        solver,
    };
    let mut pause = async |_| ControlFlow::Continue(());
    let awaited = block_on(shoot_in_slices(&mut recorded, schedule, &mut pause)).unwrap();
    assert_eq!(awaited.shots, native.shots);
    let awaited = recorded.record.into_trace();
    assert_eq!(awaited.links.len(), waited.links.len());
    assert_eq!(format!("{:?}", awaited.shots), format!("{:?}", waited.shots));
    // It is judged beside the CPU, which is then made to solve.
    let compared = block_on(compare_with_gpu(&live, &[])).unwrap();
    assert!(compared.agrees, "{}", compared.difference);
}

#[test]
fn stopped_solve_has_the_first_shots_of_the_whole() {
    let mut request: Value = serde_json::from_str(&first_request(json!([]), Value::Null)).unwrap();
    // It takes many slices.
    (request["texels"], request["samples"]) = (24.into(), 16.into());
    let request = LiveRequest::parse(&request.to_string()).unwrap();
    let solve = |most: usize| {
        let mut live = open_bundled("cornell_box");
        let mut slices = 0;
        let pause = async |share: f64| {
            assert!((0.0..=1.0).contains(&share));
            slices += 1;
            match slices < most {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        };
        let solve = block_on(live.solve(&request, &without_progress(), pause)).unwrap();
        let shots = live.latest().unwrap().solved.run.shots.clone();
        let schedule = live.latest().unwrap().solved.settings.schedule;
        (solve, shots, schedule)
    };
    let (whole, all, _) = solve(usize::MAX);
    let (part, first, schedule) = solve(1);
    assert!(!whole.stopped && part.stopped);
    assert!(
        !first.is_empty() && first.len() < all.len(),
        "{} of {}",
        first.len(),
        all.len()
    );
    assert_eq!(first, all[..first.len()]);
    assert_eq!(schedule.max_shots as usize, first.len());
    assert!(part.power.unshot > whole.power.unshot);
    assert!(part.html.contains("was interrupted after"));
}

/// A case opens with a method that fails; exact form factors are safe, the paper's fail, and a fine method
/// is safe at an easy value. What has no exact answer says so.
fn check_cases(cases: &Value) {
    assert_eq!(cases["count"], list_cases().len());
    let values: Vec<f64> = serde_json::from_value(cases["values"].clone()).unwrap();
    assert_eq!(values, [1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5]);
    let methods = [
        "fine",
        "polygon",
        "disc",
        "stereographic",
        "hemicube",
        "hemisphere",
        "paper",
    ];
    assert_eq!(cases["methods"], json!(methods));
    assert_eq!(cases["first"], "disc");
    let said = |name: &str, part: &str| cases[name][part].as_str().unwrap().to_owned();
    let note = "closeness, gap / size = 0.001: 2 faces. Built to break: one point that stands for an area.";
    assert_eq!(said("opened", "note"), note);
    let solved = [
        ("opened", 1e-3, "disc", "fails"),
        ("hemisphere", 1e-3, "hemisphere", "safe"),
        ("paper", 1e-3, "paper", "fails"),
        ("fine", 1.0, "fine", "safe"),
    ];
    for (name, value, method, verdict) in solved {
        let native = solve_case("closeness", value, method);
        assert_eq!(cases[name]["checksum"], native.0.checksum, "{name}");
        assert_eq!(cases[name]["exact"]["verdict"], verdict, "{name}");
        assert_eq!(cases[name]["exact"]["error"], native.1.unwrap().error, "{name}");
        let told = said(name, "told");
        let expected = format!("the atlas’s verdict: {verdict}.");
        assert!(
            told.contains("Exact answer (Lambert") && told.contains(&expected),
            "{told}"
        );
    }
    assert!(said("changed", "told").contains("Of a changed scene no exact answer is known."));
    let told = said("dense", "told");
    assert!(told.contains("the atlas compares with the dense solver"), "{told}");
    assert!(cases["left"]["note"].as_str().unwrap().starts_with("cornell_box.obj"));
    assert_eq!(cases["left"]["hidden"], true);
}

/// Solves a case natively as the page does when a method is chosen.
fn solve_case(name: &str, value: f64, method: &str) -> (LiveSolve, Option<ExactComparison>) {
    let mut live = LiveScene::open_case(name, value, None).unwrap();
    let case = list_cases().into_iter().find(|case| case.name == name).unwrap();
    let method = case.methods.iter().find(|own| own.name == method).unwrap();
    let mut request: Value = serde_json::from_str(&first_request(json!([]), Value::Null)).unwrap();
    request["texels"] = live.case().unwrap().texels.into();
    for (name, value) in method.settings.as_object().unwrap() {
        if !value.is_null() {
            request[name] = value.clone();
        }
    }
    let request = LiveRequest::parse(&request.to_string()).unwrap();
    let solve = solve_whole(&mut live, &request);
    (solve, live.compare_with_exact().unwrap())
}

#[test]
fn cases_have_the_errors_of_the_failure_atlas() {
    let cases = list_cases();
    assert!(cases.len() > 30);
    for case in &cases {
        assert!(!case.methods.is_empty(), "{}", case.name);
        let texels = |value| {
            LiveScene::open_case(case.name, value, None)
                .unwrap()
                .case()
                .unwrap()
                .texels
        };
        assert!(case.values.iter().all(|listed| texels(listed.value) > 0));
    }
    assert!(cases.iter().all(|case| case.name != "object-sunk"));
    assert!(LiveScene::open_case("object", 1.0, None).is_err_and(|error| error.to_string().contains("no case")));
    for (name, value, method) in [
        ("closeness", 0.01, &POLYGON),
        ("wall", 0.01, &STEREOGRAPHIC),
        ("ties", 2.0, &DISC),
    ] {
        let (_, exact) = solve_case(name, value, method.name);
        let case = ALL_CASES.iter().find(|case| case.name == name).unwrap();
        let trial = (case.build)(value).unwrap();
        let truth = TruthCache::default().truth_of(&trial).unwrap();
        let (atlas, _) = AtlasRun::default().run_method(&trial, method, None, &truth).unwrap();
        let exact = exact.unwrap();
        assert_eq!(exact.verdict, case.measure.verdict_on(atlas.error), "{name}: {exact:?}");
        assert!(
            (exact.found - exact.exact).is_finite() && exact.exact >= 0.0,
            "{exact:?}"
        );
    }
    assert!(solve_case("open", 2.0, "polygon").1.is_none());
}

/// Cases that every method solves in the page.
const SOLVED_CASES: [&str; 4] = ["wall", "cracks", "many-shots", "lights"];

#[test]
fn cases_open_where_a_method_fails() {
    let mut judged = 0;
    for case in list_cases() {
        let value = case.values[case.values.len() / 2].value;
        if let (_, Some(exact)) = solve_case(case.name, value, case.failing_method) {
            let is_safe = exact.verdict == Verdict::Safe;
            assert_eq!(is_safe, SOLVED_CASES.contains(&case.name), "{}: {exact:?}", case.name);
            judged += 1;
        }
    }
    assert!(judged > 25, "{judged}");
}

/// Files that are dropped: a scene without light gets a lamp, and others are refused in one line.
fn check_files(outcome: &Value) {
    let note = outcome["dropped"]["note"].as_str().unwrap();
    assert!(
        note.starts_with("tent.obj: 25 faces.") && note.contains("no light"),
        "{note}"
    );
    assert_eq!(outcome["dropped"]["lamps"], json!(["lamp"]));
    let damaged = "damaged.obj: line 2: a vertex needs three numbers: is the file cut off?";
    assert_eq!(outcome["damaged"], damaged);
    let unknown = "None of these files is a scene or a panorama: give an .obj, a .glb or a .gltf, an .hdr or an .exr.";
    assert_eq!(outcome["unknown"], unknown);
}

#[test]
fn changes_out_of_range_are_refused_in_one_line() {
    let scene = open_bundled("cornell_box");
    let refused = [
        (json!({ "name": "nobody" }), "no face is called \"nobody\""),
        (
            json!({ "name": "light", "emission_factor": -1.0 }),
            "cannot emit -1 times",
        ),
        (
            json!({ "name": "floor", "reflectance": [0.5, 1.5, 0.5] }),
            "cannot reflect",
        ),
        (
            json!({ "name": "floor", "reflectance": [0.5, -0.1, 0.5] }),
            "cannot reflect",
        ),
    ];
    for (change, expected) in refused {
        let change: GroupChange = serde_json::from_value(change).unwrap();
        let error = change_scene(scene.scene(), &[change]).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
    for (text, expected) in [("{", "cannot be read"), ("{\"texels\": 8}", "missing field")] {
        let error = LiveRequest::parse(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn gpu_agrees_and_a_changed_shader_is_named_by_its_stage() {
    let mut scene = open_bundled("cornell_box");
    assert!(
        block_on(compare_with_gpu(&scene, &[])).is_err_and(|error| error.to_string().contains("nothing is solved"))
    );
    let mut request = LiveRequest::parse(&first_request(json!([]), Value::Null)).unwrap();
    solve_whole(&mut scene, &request);
    let own = block_on(compare_with_gpu(&scene, &[])).unwrap();
    assert!(own.agrees && own.wrong_stage.is_none(), "{}", own.difference);
    let field = &scene.latest().unwrap().solved.run.field;
    assert!(check_origins(field, field).is_err());
    for LiveFault {
        file,
        from,
        to,
        stage,
        visibility,
        ..
    } in LIVE_FAULTS
    {
        let LiveShader { name, text } = list_shaders().into_iter().find(|shader| shader.name == file).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{name}.wgsl: {from}");
        let changed = LiveShader {
            name,
            text: text.replace(from, to),
        };
        request.visibility = visibility.unwrap_or("rays").to_owned();
        solve_whole(&mut scene, &request);
        let compared = block_on(compare_with_gpu(&scene, &[changed])).unwrap();
        assert!(!compared.agrees, "{file}: {}", compared.difference);
        let named = compared.wrong_stage.unwrap_or_default();
        assert!(named.starts_with(&format!("{stage}: ")), "{file}: {named:?}");
    }
}
