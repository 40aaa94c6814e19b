//! `stress` run as a program: rows, bad usage, machines without an adapter.

use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use serde_json::Value;
use std::fs;

#[test]
fn stress_case_writes_rows_of_both_solvers() {
    let folder = empty_folder("atlas");
    let out = folder.to_str().unwrap();
    let output = run_radiosity(&["stress", "power", "--out", out]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("stress.html") && said.contains("caught"), "{said}");
    let told: Value = serde_json::from_slice(&fs::read(folder.join("stress.json")).unwrap()).unwrap();
    let rows = told["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 5 * 9);
    for row in rows {
        assert_eq!(row["case"], "power");
        assert!(row["parameter"].is_string() && row["value"].is_f64() && row["method"].is_string());
        assert!(row["error"].is_f64() && row["warned"].is_boolean() && row["verdict"].is_string());
        assert!(row["cpu"]["error"].is_f64() && row["cpu"]["warnings"].is_array());
        assert_eq!(row["gpu"].is_null(), row["method"] == "dense");
        // The unit of power is arbitrary and must not change any answer.
        let default = row["method"] == "default";
        let error = row["error"].as_f64().unwrap();
        assert!(!default || (error < 0.02 && row["verdict"] == "safe"), "{row}");
    }
    assert_eq!(told["cases"][0]["name"], "power");
    let breaks = &told["cases"][0]["breaks"][0];
    assert_eq!(
        (breaks["method"].as_str(), breaks["solver"].as_str()),
        (Some("default"), Some("cpu"))
    );
    assert!(breaks["degrades_at"].is_null() && breaks["fails_at"].is_null());
    assert_eq!(told["score"]["default"]["quiet"], 10);
    assert!(told["seconds"].as_f64().unwrap() > 0.0 && told["adapter"].is_string());
    let page = fs::read_to_string(folder.join("stress.html")).unwrap();
    assert!(page.contains("power") && !page.contains("http://") && !page.contains("src=\"http"));
    let parts = fs::read_dir(&folder).unwrap().flatten();
    assert!(
        parts
            .into_iter()
            .all(|f| !f.file_name().to_string_lossy().ends_with(".part"))
    );
}

#[test]
fn unknown_case_is_usage_error_that_lists_cases() {
    let out = empty_folder("atlas-unknown");
    let (code, line) = exit_code_and_error(&["stress", "nonsense", "--out", out.to_str().unwrap()]);
    assert_eq!(code, 2);
    assert!(
        line.contains("nonsense") && line.contains("closeness") && line.contains("object-at-window"),
        "{line}"
    );
    assert!(!out.join("stress.json").exists());
}

#[test]
fn without_adapter_rows_of_cpu_are_written() {
    let folder = empty_folder("atlas-alone");
    let out = folder.to_str().unwrap();
    let (code, line) = exit_code_and_error(&["stress", "power", "--out", out, "--adapter", "no such adapter"]);
    assert_eq!(code, 3, "{line}");
    let told: Value = serde_json::from_slice(&fs::read(folder.join("stress.json")).unwrap()).unwrap();
    let rows = told["rows"].as_array().unwrap();
    assert!(rows.iter().all(|r| r["gpu"].is_null() && r["cpu"]["error"].is_f64()));
    assert!(told["adapter"].is_null());
}
