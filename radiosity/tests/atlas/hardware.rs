//! `hardware`: all stages of the adapter, and its times.

use gpu::SHADER_STAGES;
use serde_json::Value;
use std::process::Command;
use std::{env, fs, process};

#[test]
fn hardware_finds_each_stage_right_and_times_the_paper() {
    let folder = env::temp_dir().join(format!("radiosity-hardware-test-{}", process::id()));
    fs::create_dir_all(&folder).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_radiosity"));
    let output = program.args(["hardware", "--out"]).arg(&folder).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
    let files: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name != "scenes")
        .collect();
    assert_eq!(files.len(), 2, "{files:?}");
    let json: Value = serde_json::from_slice(&fs::read(folder.join("hardware.json")).unwrap()).unwrap();
    let page = fs::read_to_string(folder.join("hardware.html")).unwrap();
    fs::remove_dir_all(&folder).unwrap();

    let comparisons = json["comparisons"].as_array().unwrap();
    assert_eq!(comparisons.len(), 11);
    let stages: Vec<&Value> = comparisons
        .iter()
        .flat_map(|compared| compared["stages"].as_array().unwrap())
        .collect();
    assert!(
        stages
            .iter()
            .all(|stage| stage["agrees"] == true && stage["values"].as_u64() > Some(0))
    );
    // Some check of each shader ran.
    for shader in SHADER_STAGES.iter().filter(|shader| !shader.verdict.is_empty()) {
        let is_judged = |stage: &&Value| shader.verdict.contains(&stage["name"].as_str().unwrap());
        assert!(stages.iter().any(is_judged), "{}", shader.name);
    }
    let is_positive = |seconds: &Value| seconds.as_f64().is_some_and(|seconds| seconds > 0.0);
    let times = json["stage_seconds"].as_array().unwrap();
    assert_eq!(times.len(), 5);
    assert!(times.iter().all(|time| is_positive(&time["seconds"])));
    let paper = &json["paper"];
    assert!(is_positive(&paper["gpu_seconds"]) && is_positive(&paper["cpu_seconds"]));
    // Visibility by pixels and by rays differs little.
    let [on_gpu, on_cpu] = ["shots", "cpu_shots"].map(|name| paper[name].as_f64().unwrap());
    assert!((on_gpu / on_cpu - 1.0).abs() < 0.02, "{paper}");
    let points = json["chart"]["points"].as_array().unwrap();
    let is_measured = |point: &&Value| point["solver"] == "gpu" && is_positive(&point["error"]);
    assert!(points.iter().filter(is_measured).count() >= 5, "{points:?}");
    assert!(page.contains("11 of 11 comparisons agree") && page.contains("<svg") && !page.contains("src=\"http"));
}
