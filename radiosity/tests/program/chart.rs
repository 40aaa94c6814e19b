//! `chart` and `plan` run as a program.

use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Writes a lamp over a floor.
const PLATES: &str = "mtllib m.mtl\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n\
    usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n";

fn write_lamp_over_floor(folder: &Path) -> String {
    let mtl = "newmtl floor\nKd .5 .6 .7\nnewmtl lamp\nKd .3 .3 .3\nKe 1 1 1\n";
    fs::write(folder.join("m.mtl"), mtl).unwrap();
    let path = folder.join("plates.obj");
    fs::write(&path, PLATES).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Runs `chart`; returns its JSON, its messages and the number of stored measurements.
fn run_chart(arguments: &[&str], out: &Path) -> (Value, String, usize) {
    let all = [&["chart", "--out", out.to_str().unwrap()], arguments].concat();
    let output = run_radiosity(&all);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    (read_json(&out.join("chart.json")), text, count_stored(out))
}

/// Returns the number of stored measurements.
fn count_stored(out: &Path) -> usize {
    let path = out.join("chart.partial.json");
    let stored = path.exists().then(|| read_json(&path));
    stored.map_or(0, |stored| stored.as_object().unwrap().len())
}

fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn as_array(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

#[test]
fn chart_has_fields_of_contract_and_resumes() {
    let folder = empty_folder("chart");
    let (scene, out) = (write_lamp_over_floor(&folder), folder.join("out"));
    let arguments = [&scene, "--quality", "draft"];
    let (told, text, all) = run_chart(&arguments, &out);
    assert!(text.contains("chart.svg"), "{text}");
    let points = as_array(&told["points"]);
    for solver in ["cpu", "gpu", "dense"] {
        assert!(points.iter().any(|p| p["solver"] == solver), "{solver}");
    }
    assert!(points.iter().any(|p| p["on_front"] == true));
    for p in points {
        let options = &p["options"];
        assert!(p["settings"]["texels"].is_u64());
        assert!(p["seconds"].as_f64().unwrap() > 0.0);
        let Some(error) = p["error"].as_f64() else {
            assert!(p["failure"].is_string() && p["on_front"] == false, "{options}");
            continue;
        };
        assert!(p["failure"].is_null());
        // A point is on the front if no other point is better in both error and time.
        let place = |p: &Value| Some((p["seconds"].as_f64()?, p["error"].as_f64()?));
        let mine = (p["seconds"].as_f64().unwrap(), error);
        let mut others = points.iter().filter_map(place);
        let beaten = others.any(|q| q.0 <= mine.0 && q.1 <= mine.1 && q != mine);
        assert_eq!(p["on_front"], !beaten, "{options}");
    }
    assert_eq!(as_array(&told["scenes"])[0]["not_measured"], 0);
    assert_pictures_are_well_formed(&out, points.len());

    // A second run measures nothing but what is missing in the file.
    let kept = out.join("chart.partial.json");
    let mut stored = read_json(&kept);
    let stored = stored.as_object_mut().unwrap();
    stored.remove(&stored.keys().next().unwrap().clone());
    fs::write(&kept, serde_json::to_vec(stored).unwrap()).unwrap();
    let (again, text, stored) = run_chart(&arguments, &out);
    assert!(text.contains("continues after"), "{text}");
    let same = |k: &usize| as_array(&again["points"])[*k]["seconds"] == points[*k]["seconds"];
    assert!((0..points.len()).filter(same).count() + 1 >= points.len());
    assert_eq!(stored, all);
    fs::write(&kept, "no JSON").unwrap();
    let (code, line) = exit_code_and_error(&["chart", &scene, "--out", out.to_str().unwrap()]);
    assert!(code == 2 && line.contains("chart.partial.json"), "{line}");
}

/// Asserts that the pictures are well-formed and load nothing from the network.
fn assert_pictures_are_well_formed(out: &Path, points: usize) {
    let html = fs::read_to_string(out.join("chart.html")).unwrap();
    let svg = fs::read_to_string(out.join("chart.svg")).unwrap();
    for text in [&html, &svg] {
        let text = text.replace("http://www.w3.org/2000/svg", "");
        for word in ["http:", "https:", "src=", "@import", "url(", "<script"] {
            assert!(!text.contains(word), "{word}");
        }
        let titles = text.matches("<title>").count() - usize::from(text.contains("<html"));
        assert_eq!(titles, points);
        assert!(!text.contains("matrix"));
    }
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1).map(|part| part.split_once('>').unwrap().0) {
        let name = tag.split([' ', '\n', '/']).find(|word| !word.is_empty()).unwrap();
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
fn chart_draws_results_of_other_programs() {
    let folder = empty_folder("peers");
    let (scene, out) = (write_lamp_over_floor(&folder), folder.join("out"));
    let peer = |scene: &str| {
        json!({ "peer": "other & co", "variant": "v", "sampler": null, "scene": scene, "texels": 8,
            "samples": 64, "seconds": 1.5, "setup_seconds": 0.5, "error": 0.25, "threads": 2 })
    };
    fs::create_dir(&out).unwrap();
    let file = out.join("peers.json");
    let list = json!({ "points": [peer("plates"), peer("another.obj")], "more": 1 });
    fs::write(&file, list.to_string()).unwrap();
    let (told, ..) = run_chart(&[&scene, "--quality", "draft", "--solver", "cpu"], &out);
    assert_eq!(as_array(&told["scenes"][0]["peers"]).len(), 1);
    assert!(as_array(&told["points"]).iter().all(|p| p["solver"] != "gpu"));
    let html = fs::read_to_string(out.join("chart.html")).unwrap();
    assert!(html.contains("other &amp; co v, 64 samples, 2 threads\n2 s, error 25"));
    fs::write(&file, "{\"points\": [{\"peer\": 1}]}").unwrap();
    let (code, line) = exit_code_and_error(&["chart", &scene, "--out", out.to_str().unwrap()]);
    assert!(code == 2 && line.contains("peers.json"), "{line}");
}

/// Runs the program into `out` until `lines` measurements are stored, then sends Ctrl-C; returns its messages.
fn interrupt_after(lines: usize, arguments: &[&str], out: &Path) -> String {
    let mut child = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(arguments)
        .args(["--out", out.to_str().unwrap()])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while count_stored(out) < lines {
        assert!(child.try_wait().unwrap().is_none(), "ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    text
}

#[test]
fn interrupted_chart_has_points_measured_so_far() {
    let folder = empty_folder("stopped");
    let (scene, out) = (write_lamp_over_floor(&folder), folder.join("out"));
    interrupt_after(3, &["chart", &scene, "--solver", "cpu", "--texels", "32"], &out);
    let told = read_json(&out.join("chart.json"));
    assert!(as_array(&told["points"]).len() >= 3);
    assert!(
        told["scenes"][0]["not_measured"].as_u64() > Some(0),
        "it went on to the end"
    );
}

#[test]
fn chart_against_one_option_has_one_sweep_and_resumes() {
    let folder = empty_folder("vary");
    let (scene, out) = (write_lamp_over_floor(&folder), folder.join("out"));
    let vary = |option: &str| {
        let (told, _, stored) = run_chart(&[&scene, "--vary", option], &out);
        (told, stored)
    };
    let (told, stored) = vary("epsilon");
    let curves = as_array(&told["scenes"][0]["curves"]);
    assert_eq!(curves.len(), 1);
    assert_eq!(
        (&curves[0]["option"], &curves[0]["truth"]),
        (&json!("--epsilon"), &json!("--epsilon 0.0001"))
    );
    let points = as_array(&told["points"]);
    let values: Vec<f64> = points.iter().map(|p| p["value"].as_f64().unwrap()).collect();
    assert_eq!(values, [0.3, 0.1, 0.03, 0.01, 0.003, 0.001]);
    let error = |k: usize| points[k]["error"].as_f64().unwrap();
    assert!(error(5) < 0.1 * error(0), "{points:?}");
    assert!(points.iter().any(|p| p["on_front"] == true));
    let html = fs::read_to_string(out.join("chart.html")).unwrap();
    assert!(html.contains("Unshot power") && html.contains("<svg") && !html.contains("http"));
    let svg = fs::read_to_string(out.join("chart.svg")).unwrap();
    assert!(svg.contains("Unshot power") && svg.contains(">rays</text>"), "{svg}");
    // A second run measures nothing.
    assert_eq!(vary("epsilon"), (told, stored));
    // Both names of an option are one option.
    let (patches, stored) = vary("patches");
    assert_eq!(patches["scenes"][0]["curves"][0]["name"], "Patches");
    assert_eq!(vary("cells"), (patches, stored));
}

#[test]
fn converge_names_the_new_command_and_is_chart_of_all_options() {
    let folder = empty_folder("converge");
    let (scene, out) = (write_lamp_over_floor(&folder), folder.join("out"));
    // Two curves of four points each; all options take a minute.
    let text = interrupt_after(8, &["converge", &scene], &out);
    let note = "note: `radiosity converge` is `radiosity chart --vary";
    assert_eq!(text.matches(note).count(), 1, "{text}");
    let told = read_json(&out.join("chart.json"));
    let of_texels = |p: &&Value| p["options"].as_str().unwrap().starts_with("--texels");
    assert_eq!(as_array(&told["points"]).iter().filter(of_texels).count(), 8);
    assert!(as_array(&told["scenes"][0]["curves"])[0]["order"].is_f64());
    assert!(out.join("chart.html").exists());
    let help = String::from_utf8(run_radiosity(&["--help"]).stdout).unwrap();
    assert!(help.contains("  chart ") && !help.contains("  converge "));
}

#[test]
fn bad_usage_is_one_error_line_and_code_2() {
    let folder = empty_folder("chart-usage");
    let scene = write_lamp_over_floor(&folder);
    let out = folder.join("out");
    for arguments in [
        vec!["chart", &scene, "--quality", "reference"],
        vec!["chart", &scene, "--solver", "dense"],
        vec!["chart", &scene, "--texels", "0"],
        vec!["chart", &scene, "--solver", "cpu", "--adapter", "any"],
        vec!["chart", "/nowhere/at/all.obj"],
        vec!["chart", &scene, "--vary", "nonsense"],
        vec!["chart", &scene, "--vary", "patches", "--texels", "8"],
    ] {
        let arguments = if arguments[0] == "chart" {
            [arguments, vec!["--out", out.to_str().unwrap()]].concat()
        } else {
            arguments
        };
        assert_eq!(exit_code_and_error(&arguments).0, 2, "{arguments:?}");
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
    assert_eq!(exit_code_and_error(&nobody).0, 3);
}
