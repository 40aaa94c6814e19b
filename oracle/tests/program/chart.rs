//! `chart` and `plan` as scripts use them.

use super::command::{failure, folder, radiosity};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// A lamp over a floor.
const PLATES: &str = "mtllib m.mtl\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n\
    usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n";

fn plates(folder: &Path) -> String {
    let mtl = "newmtl floor\nKd .5 .6 .7\nnewmtl lamp\nKd .3 .3 .3\nKe 1 1 1\n";
    fs::write(folder.join("m.mtl"), mtl).unwrap();
    let path = folder.join("plates.obj");
    fs::write(&path, PLATES).unwrap();
    path.to_str().unwrap().to_owned()
}

/// The chart's JSON, and what it said.
fn chart(arguments: &[&str], out: &Path) -> (Value, String) {
    let first = ["chart", "--quality", "draft", "--out"];
    let all = [&first[..], &[out.to_str().unwrap()], arguments].concat();
    let output = radiosity(&all);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    let json = fs::read(out.join("chart.json")).unwrap();
    (serde_json::from_slice(&json).unwrap(), text)
}

fn array(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

#[test]
fn a_chart_has_the_fields_of_the_contract_and_goes_on() {
    let folder = folder("chart");
    let (scene, out) = (plates(&folder), folder.join("out"));
    let (told, text) = chart(&[&scene, "--repeats", "2"], &out);
    assert!(text.contains("chart.svg"), "{text}");
    let points = array(&told["points"]);
    for solver in ["cpu", "gpu", "matrix"] {
        assert!(points.iter().any(|p| p["solver"] == solver), "{solver}");
    }
    assert!(points.iter().any(|p| p["on_front"] == true));
    for p in points {
        let options = &p["options"];
        assert!(p["settings"]["texels"].is_u64() && p["spread"]["min"].is_f64());
        assert!(p["seconds"].as_f64().unwrap() > 0.0);
        assert!(p["device_seconds"].is_null());
        // What a solve to an error holds follows from the light.
        let arithmetic = p["bytes_by_arithmetic"].as_u64() > Some(0);
        assert!(arithmetic != (p["sweep"] == "error"), "{options}");
        let Some(error) = p["error"].as_f64() else {
            assert!(
                p["failure"].is_string() && p["on_front"] == false,
                "{options}"
            );
            continue;
        };
        assert_eq!(p["runs"], 2, "{options}");
        assert!(p["failure"].is_null());
        // On the front is what no other beats in both.
        let place = |p: &Value| Some((p["seconds"].as_f64()?, p["error"].as_f64()?));
        let mine = (p["seconds"].as_f64().unwrap(), error);
        let mut others = points.iter().filter_map(place);
        let beaten = others.any(|q| q.0 <= mine.0 && q.1 <= mine.1 && q != mine);
        assert_eq!(p["on_front"], !beaten, "{options}");
    }
    // Rays and pixels are of those who ask them.
    let of = |p: &&Value| p["solver"] == "gpu" && p["options"] == "base";
    let gpu = points.iter().find(of).unwrap();
    assert!(gpu["item_buffer_pixels"].as_u64() > Some(0) && gpu["rays_at_most"] == 0);
    assert_eq!(array(&told["scenes"])[0]["not_measured"], 0);
    pictures(&out, points.len());

    // Once more: nothing is left to measure, and a line that was cut is passed over.
    let kept = out.join("chart.partial.jsonl");
    let mut lines = fs::read_to_string(&kept).unwrap();
    let all = lines.lines().count();
    lines.truncate(lines.len() - 20);
    fs::write(&kept, lines).unwrap();
    let (again, text) = chart(&[&scene, "--repeats", "2"], &out);
    assert!(
        text.contains("continues after") && text.contains("1 damaged"),
        "{text}"
    );
    let same = |k: &usize| array(&again["points"])[*k]["spread"] == points[*k]["spread"];
    assert!((0..points.len()).filter(same).count() + 1 >= points.len());
    assert_eq!(fs::read_to_string(&kept).unwrap().lines().count(), all + 1);
}

/// Well-formed, and without a word to the network.
fn pictures(out: &Path, points: usize) {
    let html = fs::read_to_string(out.join("chart.html")).unwrap();
    let svg = fs::read_to_string(out.join("chart.svg")).unwrap();
    for text in [&html, &svg] {
        let text = text.replace("http://www.w3.org/2000/svg", "");
        for word in ["http:", "https:", "src=", "@import", "url(", "<script"] {
            assert!(!text.contains(word), "{word}");
        }
        assert_eq!(
            text.matches("<title>").count() - usize::from(text.contains("<html")),
            points
        );
    }
    let mut open = Vec::new();
    for tag in svg
        .split('<')
        .skip(1)
        .map(|part| part.split_once('>').unwrap().0)
    {
        let name = tag
            .split([' ', '\n', '/'])
            .find(|word| !word.is_empty())
            .unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
            open.push(name);
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn other_programs_are_drawn_beside() {
    let folder = folder("peers");
    let (scene, out) = (plates(&folder), folder.join("out"));
    let peer = |scene: &str| {
        json!({ "peer": "other & co", "variant": "v", "sampler": null, "scene": scene, "texels": 8,
            "samples": 64, "seconds": 1.5, "setup_seconds": 0.5, "error": 0.25, "threads": 2 })
    };
    let file = folder.join("others.json");
    let list = json!({ "points": [peer("plates"), peer("another.obj")], "more": 1 });
    fs::write(&file, list.to_string()).unwrap();
    let others = ["--peers", file.to_str().unwrap()];
    let rest = ["--solver", "cpu", "--repeats", "1"];
    let (told, _) = chart(&[&[scene.as_str()], &others[..], &rest[..]].concat(), &out);
    let peers = array(&told["scenes"][0]["peers"]);
    assert_eq!(peers.len(), 1);
    assert!(array(&told["points"]).iter().all(|p| p["solver"] != "gpu"));
    let html = fs::read_to_string(out.join("chart.html")).unwrap();
    assert!(html.contains("other &amp; co v, 64 samples, 2 threads\n2 s, error 25"));
    fs::write(&file, "{\"points\": [{\"peer\": 1}]}").unwrap();
    let (code, line) = failure(&["chart", &scene, "--peers", others[1]]);
    assert!(code == 2 && line.contains("others.json"), "{line}");
}

#[test]
fn an_interrupted_chart_holds_what_there_is() {
    let folder = folder("stopped");
    let (scene, out) = (plates(&folder), folder.join("out"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args([
            "chart",
            &scene,
            "--quality",
            "draft",
            "--solver",
            "cpu",
            "--repeats",
            "100",
        ])
        .args(["--texels", "32", "--out", out.to_str().unwrap()])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let kept = out.join("chart.partial.jsonl");
    while fs::read_to_string(&kept).map_or(0, |text| text.lines().count()) < 3 {
        assert!(child.try_wait().unwrap().is_none(), "ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let told: Value = serde_json::from_slice(&fs::read(out.join("chart.json")).unwrap()).unwrap();
    assert!(array(&told["points"]).len() >= 3);
    let lines = fs::read_to_string(&kept).unwrap().lines().count();
    assert!(lines < 1000, "it went on to the end");
}

#[test]
fn bad_usage_is_one_line_and_code_2() {
    let folder = folder("chart-usage");
    let scene = plates(&folder);
    let out = folder.join("out");
    let truth = folder.join("truth");
    let truth = truth.to_str().unwrap().to_owned();
    let box_scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/furnace.obj");
    let solve = [
        "solve",
        box_scene,
        "--solver",
        "cpu",
        "--quality",
        "draft",
        "--out",
        &truth,
    ];
    assert!(radiosity(&solve).status.success());
    for arguments in [
        vec!["chart", &scene, "--repeats", "0"],
        vec!["chart", &scene, "--limit", "-1"],
        vec!["chart", &scene, "--limit", "nan"],
        vec!["chart", &scene, "--quality", "reference"],
        vec!["chart", &scene, "--solver", "matrix"],
        vec!["chart", &scene, "--texels", "0"],
        vec!["chart", &scene, &scene, "--truth", &truth],
        vec!["chart", &scene, "--truth", &truth],
        vec!["chart", &scene, "--truth", "/nowhere/at/all"],
        vec!["chart", &scene, "--solver", "cpu", "--require-gpu"],
        vec!["chart", "/nowhere/at/all.obj"],
        vec!["plan", "/nowhere/at/all.obj"],
        vec!["plan", &scene, "--solver", "matrix", "--cells", "2"],
        vec!["plan", &scene, "--texels", "0"],
    ] {
        let arguments = if arguments[0] == "chart" {
            [arguments, vec!["--out", out.to_str().unwrap()]].concat()
        } else {
            arguments
        };
        assert_eq!(failure(&arguments).0, 2, "{arguments:?}");
        assert!(!out.join("chart.json").exists(), "{arguments:?}");
    }
    let nobody = [
        "chart",
        &scene,
        "--adapter",
        "no such adapter",
        "--out",
        out.to_str().unwrap(),
    ];
    assert_eq!(failure(&nobody).0, 3);
}

#[test]
fn a_plan_tells_sizes_and_what_solve_refuses() {
    let folder = folder("plan");
    let (scene, out) = (plates(&folder), folder.join("out"));
    let output = radiosity(&["plan", &scene, "--texels", "10", "--cells", "2"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    let cpu = text.split("GPU").next().unwrap();
    for word in [
        "2 faces, 200 texels, 8 cells",
        "1\u{202f}600 links",
        "passes",
        "about",
        "memory",
    ] {
        assert!(cpu.contains(word), "{word}: {text}");
    }
    assert!(
        text.contains("southwell") || text.matches("cg").count() == 2,
        "{text}"
    );
    let output = radiosity(&["plan", &scene, "--error", "2%"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("to 2 %") && text.contains("about"), "{text}");
    // 134 million texels: refused by solve before anything is written, and told by plan.
    let huge = ["--texels", "8192", "--solver", "cpu"];
    let solve = ["solve", &scene, "--out", out.to_str().unwrap()];
    let (code, line) = failure(&[&solve[..], &huge[..]].concat());
    assert_eq!(code, 2);
    assert!(line.contains("would fit") && !out.exists(), "{line}");
    let output = radiosity(&[&["plan", &scene], &huge[..]].concat());
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("refused") && text.contains("would fit"),
        "{text}"
    );
    let matrix = ["plan", &scene, "--solver", "matrix", "--texels", "100"];
    let text = String::from_utf8(radiosity(&matrix).stdout).unwrap();
    assert!(
        text.contains("6.4 GB") && text.contains("--texels 76 fits"),
        "{text}"
    );
}

#[test]
fn a_plan_for_programs_says_what_the_one_for_people_does() {
    let folder = folder("plan-json");
    let scene = plates(&folder);
    let told = |options: &[&str]| -> Value {
        let output = radiosity(&[&["plan", &scene, "--json"], options].concat());
        assert_eq!(output.status.code(), Some(0));
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.lines().count(), 1, "{text}");
        serde_json::from_str(&text).unwrap()
    };
    let spans = |plan: &Value| {
        let of = |name: &str| plan["seconds"][name].as_f64().unwrap();
        assert!(0.0 < of("least") && of("least") <= of("expected") && of("expected") <= of("most"));
    };
    let shot = told(&["--texels", "10", "--cells", "2"]);
    assert_eq!(shot["faces"], 2);
    let solvers = shot["plans"].as_array().unwrap().iter();
    let solvers: Vec<&Value> = solvers.map(|plan| &plan["solver"]).collect();
    assert_eq!(solvers, ["cpu", "gpu"]);
    let plan = &shot["plans"][0];
    for (name, number) in [("texels", 200), ("cells", 8), ("links", 1600)] {
        assert_eq!(plan[name], number, "{plan}");
    }
    assert!(plan["bytes"].as_u64().unwrap() > 1 << 20 && plan["refused"].is_null());
    spans(plan);
    let asked = told(&["--error", "2%", "--solver", "cpu"]);
    assert_eq!(asked["plans"][0]["error"], 0.02);
    spans(&asked["plans"][0]);
    let huge = told(&["--texels", "8192", "--solver", "cpu"]);
    let why = huge["plans"][0]["refused"].as_str().unwrap();
    assert!(why.contains("would fit") && huge["plans"][0]["seconds"].is_null());
}
