//! `chart` and `converge` run as a program.

use super::command::TestFolder;
use serde_json::{Value, json};
use std::process::{Command, Stdio};
use std::time::Duration;

/// A lamp over a floor.
const PLATES: &str = "mtllib m.mtl\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n\
    usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n";

fn folder_with_plates() -> TestFolder {
    let folder = TestFolder::new();
    folder.write("plates.obj", PLATES);
    let materials = "newmtl floor\nKd .5 .6 .7\nnewmtl lamp\nKd .3 .3 .3\nKe 1 1 1\n";
    folder.write("m.mtl", materials);
    folder
}

/// Charts the plates with these options; returns the JSON, the messages and the number of stored measurements.
fn run_chart(folder: &TestFolder, options: &str) -> (Value, String, usize) {
    let end = folder.succeed(&format!("chart plates.obj {options}"));
    (folder.read_json("out/chart.json"), end.stderr, count_stored(folder))
}

/// Returns the number of stored measurements.
fn count_stored(folder: &TestFolder) -> usize {
    let name = "out/chart.partial.json";
    let stored = folder.has(name).then(|| folder.read_json(name));
    stored.map_or(0, |stored| stored.as_object().unwrap().len())
}

fn as_array(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

#[test]
fn chart_has_fields_of_contract_and_resumes() {
    let folder = folder_with_plates();
    let (told, text, all) = run_chart(&folder, "--quality draft");
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
    assert_pictures_are_well_formed(&folder, points.len());

    // A second run measures nothing but what is missing in the file.
    folder.change_json("out/chart.partial.json", |stored| {
        let stored = stored.as_object_mut().unwrap();
        stored.remove(&stored.keys().next().unwrap().clone());
    });
    let (again, text, stored) = run_chart(&folder, "--quality draft");
    assert!(text.contains("continues after"), "{text}");
    let same = |k: &usize| as_array(&again["points"])[*k]["seconds"] == points[*k]["seconds"];
    assert!((0..points.len()).filter(same).count() + 1 >= points.len());
    assert_eq!(stored, all);
    folder.write("out/chart.partial.json", "no JSON");
    folder.fail_with(2, "chart plates.obj", "chart.partial.json");
}

/// Asserts that the pictures are well-formed and load nothing from the network.
fn assert_pictures_are_well_formed(folder: &TestFolder, points: usize) {
    let [html, svg] = ["out/chart.html", "out/chart.svg"].map(|name| folder.read_text(name));
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
    let folder = folder_with_plates();
    let peer = |scene: &str| {
        json!({ "peer": "other & co", "variant": "v", "sampler": null, "scene": scene, "texels": 8,
            "samples": 64, "seconds": 1.5, "setup_seconds": 0.5, "error": 0.25, "threads": 2 })
    };
    let list = json!({ "points": [peer("plates"), peer("another.obj")], "more": 1 });
    folder.write("out/peers.json", list.to_string());
    let (told, ..) = run_chart(&folder, "--quality draft --solver cpu");
    assert_eq!(as_array(&told["scenes"][0]["peers"]).len(), 1);
    assert!(as_array(&told["points"]).iter().all(|p| p["solver"] != "gpu"));
    let html = folder.read_text("out/chart.html");
    assert!(html.contains("other &amp; co v, 64 samples, 2 threads\n2 s, error 25"));
    folder.write("out/peers.json", "{\"points\": [{\"peer\": 1}]}");
    folder.fail_with(2, "chart plates.obj", "peers.json");
}

/// Runs the program until `count` measurements are stored, then sends Ctrl-C; returns its messages.
fn interrupt_after(folder: &TestFolder, count: usize, words: &[&str]) -> String {
    let mut child = folder.command(words).stderr(Stdio::piped()).spawn().unwrap();
    while count_stored(folder) < count {
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
    let folder = folder_with_plates();
    interrupt_after(
        &folder,
        3,
        &["chart", "plates.obj", "--solver", "cpu", "--texels", "32"],
    );
    let told = folder.read_json("out/chart.json");
    assert!(as_array(&told["points"]).len() >= 3);
    let missing = told["scenes"][0]["not_measured"].as_u64().unwrap();
    assert!(missing > 0, "it went on to the end");
    let note = format!("{missing} points were not measured");
    assert!(folder.read_text("out/chart.html").contains(&note), "{note}");
}

#[test]
fn chart_against_one_option_has_one_sweep_and_resumes() {
    let folder = folder_with_plates();
    let vary = |option: &str| {
        let (told, _, stored) = run_chart(&folder, &format!("--vary {option}"));
        (told, stored)
    };
    let (told, stored) = vary("epsilon");
    let [curve] = &as_array(&told["scenes"][0]["curves"])[..] else {
        panic!("{told}");
    };
    assert_eq!(
        (&curve["option"], &curve["truth"]),
        (&json!("--epsilon"), &json!("--epsilon 0.0001"))
    );
    let points = as_array(&told["points"]);
    let values: Vec<f64> = points.iter().map(|p| p["value"].as_f64().unwrap()).collect();
    assert_eq!(values, [0.3, 0.1, 0.03, 0.01, 0.003, 0.001]);
    let error = |k: usize| points[k]["error"].as_f64().unwrap();
    assert!(error(5) < 0.1 * error(0), "{points:?}");
    assert!(points.iter().any(|p| p["on_front"] == true));
    let [html, svg] = ["out/chart.html", "out/chart.svg"].map(|name| folder.read_text(name));
    assert!(html.contains("Unshot power") && html.contains("<svg") && !html.contains("http"));
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
    let folder = folder_with_plates();
    // Two curves of four points each; all options take a minute.
    let text = interrupt_after(&folder, 8, &["converge", "plates.obj"]);
    let note = "note: `radiosity converge` is `radiosity chart --vary";
    assert_eq!(text.matches(note).count(), 1, "{text}");
    let told = folder.read_json("out/chart.json");
    let of_texels = |p: &&Value| p["options"].as_str().unwrap().starts_with("--texels");
    assert_eq!(as_array(&told["points"]).iter().filter(of_texels).count(), 8);
    assert!(as_array(&told["scenes"][0]["curves"])[0]["order"].is_f64());
    assert!(folder.has("out/chart.html"));
    let help = folder.succeed("--help").stdout;
    assert!(help.contains("  chart ") && !help.contains("  converge "));
}
