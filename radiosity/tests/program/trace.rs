//! `shoot --trace` and its page.

use super::browser::{browser_for, page_outcome, with_script};
use super::command::TestFolder;
use super::room::{ROOM, folder_with_room};
use common::mesh::Mesh;
use common::settings::{ItemBufferProjection, Schedule, Transport, Visibility};
use common::shooting::{Shot, SolveRun};
use common::solution::StoredSolution;
use cpu::shader_twins::item_buffer::ItemBuffer;
use cpu::shader_twins::view::{ShooterView, view_all_faces};
use glam::Vec3;
use oracle::trace::TraceLimit;
use oracle::trace::hemisphere::hemisphere_settings;
use radiosity::report::trace::algorithm::algorithm_steps;
use radiosity::report::trace::{MAX_PAGE_BYTES, TracePage, describe_end};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// A script that moves through the shots, and hands the outcome over.
const MOVE: &str = include_str!("trace.js");
/// A script that points at the picture of a browser without WebGL.
const NO_PICTURE: &str = "
(async () => {
  const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  const element = document.querySelector('.trace');
  for (let tries = 0; element.dataset.ready === undefined && tries < 100; tries++) await wait(50);
  const { viewer } = element.querySelector('.viewer');
  const first = viewer.told.textContent;
  element.page.go(3);
  viewer.canvas.dispatchEvent(new PointerEvent('pointermove', { pointerId: 7, clientX: 90, clientY: 90, bubbles: true }));
  hand_over({ first, moved: viewer.told.textContent, position: element.querySelector('.position').textContent });
})();
";
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
    assert!(page.contains("the solve was ended by --max-shots 400, before ε = "));
}

#[test]
fn note_names_the_limit_of_the_page() {
    let note = |shots, reached_limit| {
        let page = TracePage {
            html: String::new(),
            shots,
            shot_count: 10,
            reached_limit,
        };
        page.describe_missing_shots().unwrap_or_default()
    };
    let bytes = note(3, Some(TraceLimit::Bytes));
    assert!(
        bytes.starts_with("trace.html has the first 3 shots of 10: more do not fit into 5 MB"),
        "{bytes}"
    );
    let links = note(3, Some(TraceLimit::Links));
    assert!(links.contains("33 million links") && !links.contains("5 MB"), "{links}");
    assert!(note(0, Some(TraceLimit::Bytes)).contains("no trace.html is written"));
    assert_eq!(note(10, None), "");
}

#[test]
fn page_says_what_ended_the_solve() {
    let schedule = Schedule {
        epsilon: 0.05,
        max_shots: 4,
        ..Schedule::default()
    };
    let shot = Shot {
        patch: 0,
        power: [1.0; 3],
        form_factor_sum: 1.0,
        escaped: 0.0,
        unshot: 1.0,
    };
    let end = |count, converged| {
        let run = SolveRun {
            shots: vec![shot; count],
            converged,
            ..SolveRun::default()
        };
        describe_end(&run, &schedule)
    };
    assert_eq!(end(4, true), "the solve ended at ε = 5 % (dashed)");
    assert_eq!(
        end(4, false),
        "the solve was ended by --max-shots 4, before ε = 5 % (dashed)"
    );
    assert_eq!(
        end(3, false),
        "the solve was interrupted after 3 shots, before ε = 5 % (dashed)"
    );
}

#[test]
fn algorithm_names_existing_functions() {
    for visibility in [
        Visibility::Rays,
        Visibility::with_item_buffer(ItemBufferProjection::Hemisphere, 64),
    ] {
        let transport = Transport {
            visibility,
            ..Transport::default()
        };
        let steps = algorithm_steps(&transport, false, None);
        let places = steps.iter().flat_map(|step| [step.rust, step.wgsl]).flatten();
        assert_eq!(places.clone().count(), 14);
        for place in places {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(place.file);
            let text = std::fs::read_to_string(path).unwrap();
            assert!(text.contains(&format!("fn {}(", place.function)), "{place:?}");
        }
    }
}

/// Moves through the shots of `out/trace.html` in the browser; returns what the script has read.
fn move_through_shots(folder: &TestFolder, browser: &str) -> Value {
    folder.write("move.html", with_script(&folder.read_text("out/trace.html"), MOVE));
    let did = page_outcome(browser, &folder.path("move.html"));
    assert_eq!(did["failed"], Value::Null, "{did}");
    did
}

/// Checks the numbers of a page against the solver's; `open` is the open share of the first shooters.
fn check_numbers(folder: &TestFolder, did: &Value, open: f32) {
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
    // A texel's numbers: the product is what the page adds. The first shot is the lamp's.
    for shot in ["read_first", "read"] {
        let read = did[shot].as_array().unwrap();
        let mut linked = 0;
        for own in read.iter().filter(|own| own["factors"].is_array()) {
            let [rho, radiosity, change] = [0, 3, 5].map(|k| vector(&own["factors"][k]));
            let [form_factor, share, divisor] = [1, 2, 4].map(|k| own["factors"][k].as_f64().unwrap() as f32);
            let product = rho * form_factor * share * radiosity / divisor;
            assert!(
                (product - change).abs().cmple(product.abs() * 2e-4 + 1e-9).all(),
                "{own}"
            );
            let open = if shot == "read_first" { open } else { 1.0 };
            assert!(divisor == open && (0.0..=1.0).contains(&share), "{own}");
            linked += u32::from(change.x > 0.0);
        }
        assert!(linked > 5, "{linked} of {}", read.len());
    }
    assert!(did["shares"]["least"].as_f64() >= Some(0.0) && did["shares"]["most"].as_f64() <= Some(1.0));
}

/// Checks what the first shooter sees: the item buffer, the pixels of texels, and the faces of pixels.
fn check_hemisphere(folder: &TestFolder, did: &Value) {
    let stored = StoredSolution::read(&folder.path("out")).unwrap();
    let mesh = Mesh::new(&stored.scene, &stored.resolutions, 1).unwrap();
    let drawing = hemisphere_settings(Visibility::Rays);
    let view = ShooterView::new(&mesh, did["shooter"].as_u64().unwrap() as u32, 0, &drawing);
    let ids = ItemBuffer::draw_faces(&mesh, &view, view_all_faces(&mesh)).ids;
    assert_eq!(did["ids"], json!(ids));
    let id_at = |[x, y]: [usize; 2]| ids[y * drawing.size as usize + x];
    let pixel_of = |own: &Value| [0, 1].map(|k| own["pixel"][k].as_u64().unwrap() as usize);
    // A texel that sees the whole shooter has its face in its pixel or one beside it.
    let mut seen = 0;
    for own in did["pixels"].as_array().unwrap() {
        if own["factors"][2] == 1.0 {
            let [x, y] = pixel_of(own);
            let around = (x.saturating_sub(1)..=(x + 1).min(63))
                .flat_map(|x| (y.saturating_sub(1)..=(y + 1).min(63)).map(move |y| [x, y]));
            let face = own["face"].as_u64().unwrap() as u32;
            assert!(around.into_iter().any(|pixel| id_at(pixel) == face + 1), "{own}");
            seen += 1;
        }
    }
    assert!(seen > 10, "{seen}");
    let mut pointed = 0;
    for own in did["pointed"].as_array().unwrap() {
        let says = own["says"].as_str().unwrap();
        match id_at(pixel_of(own)) {
            0 => assert!(
                own["face"].is_null() && says.ends_with("This pixel has no face."),
                "{own}"
            ),
            id => {
                assert_eq!(own["face"], id - 1, "{own}");
                assert!(says.contains(&format!("This pixel has face {} “", id - 1)), "{own}");
                // The outlines of shooter, texel and face, and the line between the first two.
                assert!(own["lines"].as_u64() >= Some(12), "{own}");
                pointed += 1;
            }
        }
    }
    assert!(pointed > 30, "{pointed}");
}

/// Without WebGL the reason stays when the pointer moves, and the shots can still be read.
#[test]
fn trace_page_without_webgl_keeps_the_reason() {
    let Some(browser) = browser_for("trace_page_without_webgl_keeps_the_reason") else {
        return;
    };
    let folder = TestFolder::new();
    folder.succeed(SHOOT);
    let page = folder.read_text("out/trace.html");
    let none = "<script>HTMLCanvasElement.prototype.getContext = () => null;</script>";
    folder.write(
        "none.html",
        with_script(&page.replacen("<body>", &format!("<body>{none}"), 1), NO_PICTURE),
    );
    let did = page_outcome(&browser, &folder.path("none.html"));
    let reason = "This browser has no WebGL 2: preview.png shows the same scene.";
    assert_eq!(
        did,
        json!({ "first": reason, "moved": reason, "position": "shot 3 of 48" })
    );
}

/// A box covers a quarter of the lamp: all its light leaves from the rest.
#[test]
fn trace_page_shows_the_open_share_of_a_covered_lamp() {
    let Some(browser) = browser_for("trace_page_shows_the_open_share_of_a_covered_lamp") else {
        return;
    };
    let folder = folder_with_room();
    let mut block = "usemtl wall\n".to_owned();
    for z in [0.5, 1.0] {
        for [x, y] in [[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]] {
            writeln!(block, "v {x} {y} {z}").unwrap();
        }
    }
    block += "f -5 -6 -7 -8\nf -4 -3 -2 -1\nf -7 -3 -4 -8\nf -1 -2 -6 -5\nf -4 -1 -5 -8\nf -6 -2 -3 -7\n";
    folder.write("covered.obj", ROOM.obj_text() + &block);
    folder.succeed("shoot covered.obj --solver cpu --texels 4 --patches 1 --samples 16 --trace");
    let did = move_through_shots(&folder, &browser);
    assert_eq!(did["open"], 0.75);
    assert_eq!(did["change_line"], "ΔB ← ρ · F · V · Bᵢ / oᵢ");
    check_numbers(&folder, &did, 0.75);
}

#[test]
fn trace_page_shows_the_recorded_shots() {
    let Some(browser) = browser_for("trace_page_shows_the_recorded_shots") else {
        return;
    };
    let folder = TestFolder::new();
    folder.succeed(SHOOT);
    let did = move_through_shots(&folder, &browser);
    assert!(
        did["curve"]
            .as_str()
            .unwrap()
            .ends_with("; the solve ended at ε = 0.1 % (dashed)."),
        "{did}"
    );
    assert_eq!(did["change_line"], "ΔB ← ρ · F · V · Bᵢ");
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

    check_numbers(&folder, &did, 1.0);
    check_hemisphere(&folder, &did);
    let energy: f64 = did["energy"]
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .sum();
    let emitted = did["emitted"].as_f64().unwrap();
    assert!((energy / emitted - 1.0).abs() < 1e-5, "{energy} {emitted}");
}

/// A script that compares the error of B with shots whose shares are those of rays.
const ERROR_SCRIPT: &str = "
(async () => {
  const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  const element = document.querySelector('.trace');
  for (let tries = 0; element.dataset.ready === undefined && tries < 100; tries++) await wait(50);
  const { viewer } = element.querySelector('.viewer');
  const { trace, state } = viewer;
  element.page.go(trace.shots.length);
  const right = new Float64Array(state.radiosity.length).map((_, c) => trace.initial_radiosity[c]);
  trace.shots.forEach(({ patch, radiosity }, at) => {
    for (let k = 0; k < trace.scene.texels; k++) {
      if (trace.patch_of[k] === patch) continue;
      const { form_factor, share, share_error } = trace.link(at + 1, k);
      for (let c = 0; c < 3; c++) right[3 * k + c] += state.reflectance[3 * k + c] * form_factor * (share - share_error) * radiosity[c];
    }
  });
  const off = Math.max(...right.map((b, c) => Math.abs(state.radiosity[c] - state.error[c] - b)));
  const error = Math.max(...state.error.map(Math.abs));
  const n = trace.shots.findIndex((_, at) => trace.wrong_texels(at + 1).length > 0) + 1;
  element.page.go(n);
  const wrong = trace.wrong_texels(n);
  viewer.seen = wrong[0];
  viewer.tell();
  viewer.mark();
  const row = [...viewer.told.children].find((line) => line.querySelector('b').textContent === 'by rays')?.textContent;
  const lines = viewer.lines.segments.length;
  element.querySelector('[data-what=error]').click();
  hand_over({ off, error, most: Math.max(...state.radiosity), shots: trace.shots.length, wrong: wrong.length, row, mode: viewer.mode(), full: viewer.full, lines });
})();
";

/// Texels that a coarse item buffer hides or shows wrongly are marked, and what comes of it is displayed.
#[test]
fn trace_page_shows_the_errors_of_an_item_buffer() {
    let Some(browser) = browser_for("trace_page_shows_the_errors_of_an_item_buffer") else {
        return;
    };
    let folder = TestFolder::new();
    folder.succeed(SHOOT);
    assert!(!folder.read_text("out/trace.html").contains("data-what=\"error\""));
    folder.succeed(&format!("{SHOOT} --visibility hemicube --item-buffer 16"));
    folder.write(
        "error.html",
        with_script(&folder.read_text("out/trace.html"), ERROR_SCRIPT),
    );
    let did = page_outcome(&browser, &folder.path("error.html"));
    let number = |name: &str| did[name].as_f64().unwrap();
    // B is a sum of f32, rounded with each shot, and so is its error.
    let rounding = 2.0 * number("shots") * f64::from(f32::EPSILON) * number("most");
    assert!(number("off") <= rounding && number("error") > 100.0 * rounding, "{did}");
    assert_eq!(did["full"], did["error"]);
    assert!(
        number("wrong") >= 1.0 && number("lines") >= 4.0 * number("wrong"),
        "{did}"
    );
    let row = did["row"].as_str().unwrap_or_default();
    assert!(
        row.contains("the item buffer shows what is hidden") || row.contains("the item buffer hides what is seen"),
        "{did}"
    );
    assert_eq!(did["mode"], 2);
}

const RELIGHT_COMMAND: &str = "relight --room scenes/paper_room.obj --object scenes/paper_objects.obj --place 0,-0.01,0 --solver cpu --texels 4 --patches 1 --samples 4 --max-shots 300";

/// A script that goes to the last shot of a relight, and to one that takes captured light from a texel of the room.
const RELIT_SCRIPT: &str = "
(async () => {
  const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  const element = document.querySelector('.trace');
  for (let tries = 0; element.dataset.ready === undefined && tries < 100; tries++) await wait(50);
  const { viewer } = element.querySelector('.viewer');
  const { trace } = viewer;
  const vectors = () => Array.from({ length: trace.scene.texels }, (_, k) => Array.from(viewer.state.radiosity.subarray(3 * k, 3 * k + 3)));
  const before = vectors();
  element.page.go(trace.shots.length);
  const after = vectors();
  const parts = [...element.querySelectorAll('[data-part]')].map((row) => row.dataset.part);
  const captured = trace.shots.filter((shot) => shot.is_captured).length;
  const lost = (n) => trace.patch_of.findIndex((_, k) => trace.is_of_room(k) && trace.link(n, k).share < 0);
  const n = trace.shots.findIndex((_, at) => lost(at + 1) >= 0) + 1;
  element.page.go(n);
  viewer.seen = lost(n);
  viewer.tell();
  const rows = Object.fromEntries([...viewer.told.children].map((line) => ['b', 'span'].map((tag) => line.querySelector(tag)?.textContent)));
  viewer.select('change');
  const colours = viewer.mode();
  element.page.go(captured + 1);
  const choice = element.querySelector('[data-panel=choice] p').textContent;
  hand_over({ before, after, parts, captured, rows, choice, colours, title: element.querySelector('[data-panel=algorithm] h2').textContent });
})();
";

#[test]
fn relight_trace_is_written_beside_the_other_files_and_changes_none() {
    let folder = TestFolder::new();
    let end = folder.succeed(&format!("{RELIGHT_COMMAND} --trace --out traced"));
    assert!(end.stderr.contains("wrote trace.html"), "{end}");
    folder.succeed(&format!("{RELIGHT_COMMAND} --out plain"));
    assert_eq!(folder.read("traced/lightmap.exr"), folder.read("plain/lightmap.exr"));
    assert!(!folder.has("plain/trace.html"));
    let page = folder.read_text("traced/trace.html");
    assert!(page.contains("\"relight\":{\"reshoot\":true,\"room_faces\":156}"));
    assert!(page.contains("Table 2, corrected") && !page.contains("https:"));
    let paper = folder.succeed(&format!("{RELIGHT_COMMAND} --trace --method paper --out paper"));
    assert!(paper.stderr.contains("wrote trace.html"), "{paper}");
    assert!(folder.read_text("paper/trace.html").contains("\"reshoot\":false"));
    // All light again is a solve.
    folder.succeed(&format!("{RELIGHT_COMMAND} --trace --method full --out full"));
    assert!(folder.read_text("full/trace.html").contains("\"relight\":null"));
    folder.fail_with(2, &format!("{RELIGHT_COMMAND} --trace --error 2%"), "--error");
}

#[test]
fn relight_trace_page_shows_what_the_objects_change() {
    let Some(browser) = browser_for("relight_trace_page_shows_what_the_objects_change") else {
        return;
    };
    let folder = TestFolder::new();
    folder.succeed(&format!("{RELIGHT_COMMAND} --trace"));
    folder.write(
        "relit.html",
        with_script(&folder.read_text("out/trace.html"), RELIT_SCRIPT),
    );
    let did = page_outcome(&browser, &folder.path("relit.html"));
    let result = folder.read_json("out/result.json");
    assert_eq!(did["captured"].as_u64(), Some(156));
    assert_eq!(did["parts"], json!(["gained", "lost"]));
    assert_eq!(did["title"], "The algorithm (Table 2, corrected)");
    assert!(result["map_shots"].as_u64() >= Some(156), "{result}");
    let stored = StoredSolution::read(&folder.path("out")).unwrap();
    let [before, after] = ["before", "after"].map(|name| {
        let texels = did[name].as_array().unwrap().iter();
        let vectors = texels.map(|own| Vec3::from_array([0, 1, 2].map(|c| own[c].as_f64().unwrap() as f32)));
        vectors.collect::<Vec<_>>()
    });
    assert_eq!(after.len(), stored.radiosity.len());
    let mut darker = 0;
    for (k, known) in stored.radiosity.iter().enumerate() {
        // What is lost is no more than there was: gains and losses are at most 2 B₀ + B.
        let bound = (2.0 * before[k].abs() + known.abs()) * PAGE_ERROR + 1e-6;
        assert!(
            (after[k] - *known).abs().cmple(bound).all(),
            "texel {k}: {} {known}",
            after[k]
        );
        darker += usize::from(known.y < 0.5 * before[k].y);
    }
    assert!(darker > 10, "{darker}");
    let rows = &did["rows"];
    let share = rows["V − V₀"].as_str().unwrap_or_default();
    assert!(
        share.starts_with('-') && share.contains("is now hidden by face 1"),
        "{rows}"
    );
    let change = rows["ΔB = Δr"].as_str().unwrap_or_default();
    assert!(
        change.starts_with("ρ · F · (V − V₀) · Bᵢ = (") && change.contains("= (-"),
        "{rows}"
    );
    assert!(
        did["choice"].as_str().unwrap().contains("the most unshot change"),
        "{did}"
    );
    // Those of differences, which show either sign.
    assert_eq!(did["colours"], 2);
}
