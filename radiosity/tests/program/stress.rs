//! `stress` run as a program: rows, bad usage, machines without an adapter.

use super::command::TestFolder;

#[test]
fn stress_case_writes_rows_of_both_solvers() {
    let folder = TestFolder::new();
    let end = folder.succeed("stress power");
    assert!(
        end.stderr.contains("stress.html") && end.stderr.contains("caught"),
        "{end}"
    );
    let told = folder.read_json("out/stress.json");
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
    let page = folder.read_text("out/stress.html");
    assert!(page.contains("power") && !page.contains("http://") && !page.contains("src=\"http"));
}

#[test]
fn unknown_case_is_refused_with_all_cases_and_without_adapter_rows_of_cpu_are_written() {
    let folder = TestFolder::new();
    folder.assert_refused(
        "stress nonsense => nonsense
         stress nonsense => closeness
         stress nonsense => object-at-window",
    );
    folder.fail_with(3, "stress power --adapter NOSUCH", "NOSUCH");
    let told = folder.read_json("out/stress.json");
    let rows = told["rows"].as_array().unwrap();
    assert!(rows.iter().all(|r| r["gpu"].is_null() && r["cpu"]["error"].is_f64()));
    assert!(told["adapter"].is_null());
}
