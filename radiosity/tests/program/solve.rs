//! `solve`, `shoot` and `compare` run as a program: exit codes, one `error:` line, files, no partial file.

use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use approx::abs_diff_eq;
use serde_json::Value;
use std::fs;
use std::path::Path;

const QUAD: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl m\nf 1 2 3 4\n";

fn write_scene(folder: &Path, obj: &str, mtl: &str) -> String {
    fs::write(folder.join("m.mtl"), mtl).unwrap();
    let path = folder.join("scene.obj");
    fs::write(&path, obj).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn bad_input_is_one_error_line_and_code_2() {
    let folder = empty_folder("bad");
    let out = folder.join("out");
    let good = "newmtl m\nKd .5 .5 .5\nKe 1 1 1\n";
    let cases = [
        ("empty", String::new(), good, "empty"),
        ("NaN", QUAD.replace("v 1 1 0", "v nan 1 0"), good, ""),
        ("negative reflectance", QUAD.into(), "newmtl m\nKd -.5 .5 .5\n", "m"),
        ("reflectance 1.1", QUAD.into(), "newmtl m\nKd 1.1 .5 .5\n", "m"),
        ("missing vertex", QUAD.replace("f 1 2 3 4", "f 1 2 3 9"), good, ""),
        (
            "all faces without area",
            QUAD.replace("v 1 0 0\nv 1 1 0\nv 0 1 0", "v 0 0 0\nv 0 0 0\nv 0 0 0"),
            good,
            "",
        ),
    ];
    for (name, obj, mtl, says) in cases {
        let path = write_scene(&folder, &obj, mtl);
        let (code, line) = exit_code_and_error(&["solve", &path, "--solver", "cpu", "--out", out.to_str().unwrap()]);
        assert_eq!(code, 2, "{name}: {line}");
        assert!(line.contains("scene.obj") || line.contains("m.mtl"), "{name}: {line}");
        assert!(line.contains(says), "{name}: {line}");
        assert!(!out.exists(), "{name} wrote something");
    }
    assert_eq!(exit_code_and_error(&["solve", "/nowhere/at/all.obj"]).0, 2);
}

#[test]
fn bad_usage_is_one_error_line_and_code_2() {
    let folder = empty_folder("usage");
    let path = write_scene(&folder, QUAD, "newmtl m\nKd .5 .5 .5\nKe 1 1 1\n");
    for arguments in [
        vec!["solve", &path, "--texels", "0"],
        vec!["shoot", &path, "--epsilon", "0"],
        vec!["shoot", &path, "--epsilon", "nan"],
        vec!["solve", &path, "--quality", "best"],
        vec!["solve", &path, "--solver", "cpu", "--require-gpu"],
        vec!["shoot", &path, "--visibility", "hemicube", "--raster", "tessellated"],
        vec!["shoot", &path, "--visibility", "paper", "--raster", "pixel"],
        vec!["solve", &path, "--texels", "8192", "--solver", "cpu", "--nonsense"],
        vec!["solve"],
        vec!["shoot"],
        vec!["diff", "only-one"],
        vec!["converge", "--truth", "somewhere"],
        vec!["converge", &path, &path, "--truth", "somewhere"],
        vec!["converge", &path, "--truth", "/nowhere"],
        vec!["nonsense"],
    ] {
        let (code, line) = exit_code_and_error(&arguments);
        assert_eq!(code, 2, "{arguments:?}: {line}");
    }
}

#[test]
fn dense_solver_refuses_options_it_does_not_use() {
    let folder = empty_folder("dense-usage");
    let path = write_scene(&folder, QUAD, "newmtl m\nKd .5 .5 .5\nKe 1 1 1\n");
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let solve = ["solve", &path, "--solver", "dense", "--out", out];
    for option in [
        &["--patches", "1"][..],
        &["--max-shots", "9"],
        &["--item-buffer", "1024"],
        &["--lookup", "3x3"],
        &["--visibility", "stereographic"],
        &["--form-factor", "disc"],
        &["--adapter", "any"],
        &["--require-gpu"],
    ] {
        let (code, line) = exit_code_and_error(&[&solve[..], option].concat());
        assert_eq!(code, 2, "{option:?}: {line}");
        assert!(line.contains(option[0]), "{option:?}: {line}");
    }
    // 1 face × 200² texels take 25.6 GB; 11 585 texels are allowed, so that 107² fit.
    let (code, line) = exit_code_and_error(&[&solve[..], &["--texels", "200"]].concat());
    assert_eq!(code, 2, "{line}");
    for part in ["scene.obj", "40000 texels", "25.6 GB", "--texels 107"] {
        assert!(line.contains(part), "{part}: {line}");
    }
    assert!(!Path::new(out).exists(), "a refused solve wrote something");
}

#[test]
fn dense_solver_writes_files_of_contract() {
    let folder = empty_folder("dense");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
    let out = folder.join("out");
    let arguments = ["solve", path, "--solver", "dense", "--texels", "4"];
    let chosen = ["--visibility", "rays", "--form-factor", "polygon", "--out"];
    let output = run_radiosity(&[&arguments[..], &chosen, &[out.to_str().unwrap()]].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("dense system of"), "{text}");
    let result: Value = serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap();
    assert_eq!(result["solver"], "dense");
    assert_eq!(result["shots"], 0);
    assert_eq!(result["converged"], true);
    assert_eq!(result["unshot_fraction"], 0.0);
    let settings = serde_json::json!({"texels": 4, "visibility": "rays", "form-factor": "polygon"});
    assert_eq!(result["settings"], settings);
    let matrix = &result["matrix"];
    assert!(matrix["residual"].as_f64().unwrap() < 1e-12);
    assert!(matrix["reciprocity"].as_f64().unwrap() < 1e-7);
    // The matrix and its LU factors in f64, 4 × 4 texels a face.
    let texels = result["faces"].as_array().unwrap().len() * 16;
    assert_eq!(matrix["bytes"], texels * texels * 16);
    for key in ["exact_pairs", "sampled_pairs"] {
        assert!(matrix[key].as_u64().unwrap() > 0, "{key}");
    }
    assert!(matrix["closure"]["mean"].as_f64().unwrap() < 0.01);
    assert!(matrix["closure"]["max"].as_f64().unwrap() < 0.1);
    let energy = &result["energy"];
    assert!(energy["imbalance"].as_f64().unwrap() < 1e-6);
    for c in 0..3 {
        let part = |name: &str| energy[name][c].as_f64().unwrap();
        assert_eq!(part("unshot"), 0.0);
        // The box is open in front; nearly all of the missing share escapes there.
        let missing = part("emitted") - part("absorbed");
        assert!(part("escaped") > 0.0);
        assert!(abs_diff_eq!(part("escaped") / missing, 1.0, epsilon = 0.02), "{energy}");
    }
    assert!(fs::metadata(out.join("lightmap.exr")).unwrap().len() > 0);
}

#[test]
fn unwritable_folder_is_code_4() {
    let folder = empty_folder("unwritable");
    let path = write_scene(&folder, QUAD, "newmtl m\nKd .5 .5 .5\nKe 1 1 1\n");
    let file = folder.join("file");
    fs::write(&file, "").unwrap();
    let below = file.join("out");
    let (code, line) = exit_code_and_error(&["solve", &path, "--solver", "cpu", "--out", below.to_str().unwrap()]);
    assert_eq!(code, 4, "{line}");
}

#[test]
fn shoot_writes_files_of_contract() {
    let folder = empty_folder("files");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
    let out = folder.join("out");
    let output = run_radiosity(&[
        "shoot",
        path,
        "--solver",
        "cpu",
        "--texels",
        "4",
        "--max-shots",
        "7",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(0));
    let result: Value = serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap();
    assert_eq!(result["shots"], 7);
    assert_eq!(result["converged"], false);
    assert_eq!(result["solver"], "cpu");
    assert!(result["adapter"].is_null());
    assert_eq!(result["settings"]["texels"], 4);
    assert!(result["energy"]["imbalance"].as_f64().unwrap() < 1e-5);
    let faces = result["faces"].as_array().unwrap();
    let face = &faces[0];
    assert_eq!(face["kind"], "quad");
    assert_eq!(face["texels"], serde_json::json!([4, 4]));
    assert_eq!(face["corners"].as_array().unwrap().len(), 4);
    for key in ["name", "area", "rect", "emission", "reflectance"] {
        assert!(!face[key].is_null(), "{key}");
    }
    assert!(
        faces.iter().any(|face| face["from"] == 5),
        "the non-planar left wall is split"
    );
    assert!(fs::metadata(out.join("lightmap.exr")).unwrap().len() > 0);
    let mut left: Vec<_> = fs::read_dir(&out).unwrap().map(|f| f.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["lightmap.exr", "preview.png", "result.json", "view.html"]);
}

/// A scene in the open, lit by one lamp.
#[test]
fn white_material_is_noted_unless_reflectance_is_given() {
    let folder = empty_folder("white");
    let path = write_scene(&folder, QUAD, "newmtl m\nKd 1 1 1\nKe 1 1 1\n");
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let solve = ["solve", &path, "--solver", "cpu", "--out", out];
    let given = ["--reflectance", "0.2,0.3,0.98"];
    for (more, white, taken) in [(&[][..], true, [0.95; 3]), (&given[..], false, [0.2, 0.3, 0.98])] {
        let output = run_radiosity(&[&solve[..], more].concat());
        assert_eq!(output.status.code(), Some(0));
        let told = String::from_utf8_lossy(&output.stderr);
        let note = "materials m reflect all light: taken as 0.95";
        assert_eq!(told.matches(note).count(), usize::from(white), "{told}");
        let text = fs::read(Path::new(out).join("result.json")).unwrap();
        let result: Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(result["notes"].to_string().contains(note), white);
        let found = &result["faces"][0]["reflectance"];
        let close = |k: usize| (found[k].as_f64().unwrap() - taken[k]).abs() < 1e-6;
        assert!((0..3).all(close), "{found}");
    }
}

#[test]
fn strict_warning_is_code_1_after_writing() {
    let folder = empty_folder("strict");
    let obj = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
    let out = folder.to_str().unwrap();
    let shoot = ["shoot", obj, "--solver", "cpu", "--patches", "1", "--out", out];
    assert!(run_radiosity(&shoot).status.success());
    fs::remove_file(folder.join("result.json")).unwrap();
    let (code, line) = exit_code_and_error(&[&shoot[..], &["--strict"]].concat());
    assert_eq!(code, 1, "{line}");
    assert!(line.contains("cornell_box.obj") && line.contains("--patches"), "{line}");
    let result = fs::read_to_string(folder.join("result.json")).unwrap();
    assert!(result.contains("\"estimated_error\""));
    let answered = ["solve", obj, "--solver", "cpu", "--out", out, "--strict"];
    assert!(run_radiosity(&answered).status.success());
    fs::remove_dir_all(folder).unwrap();
}

/// Runs `compare` on the two plates with these options; returns exit code, report.json and messages.
fn run_compare(name: &str, asked: &[&str]) -> (Option<i32>, Value, String) {
    let out = empty_folder(name);
    let plates = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/facing_plates.obj");
    let fixed = ["compare", plates, "--texels", "8", "--out", out.to_str().unwrap()];
    // Rays have no item buffer.
    let by_rays = asked
        .iter()
        .any(|option| ["rays", "--quality", "--error"].contains(option));
    let pixels: &[&str] = if by_rays { &[] } else { &["--item-buffer", "128"] };
    let output = run_radiosity(&[&fixed, pixels, asked].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    let text = fs::read_to_string(out.join("report.json")).unwrap_or_else(|e| panic!("{e}: {said}"));
    let report: Value = serde_json::from_str(&text).unwrap();
    (output.status.code(), report["scenes"][0].clone(), said)
}

#[test]
fn compare_judges_default_and_paper_preset_with_their_errors() {
    let (code, scene, said) = run_compare("compare", &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(scene["agree"] == true && scene["as_solved"]["agree"] == true);
    assert_eq!(scene["settings"]["gpu"]["iteration"], "southwell");
    assert_eq!(scene["settings"]["gpu"]["cells"], 1);
    let solved = &scene["as_solved"];
    assert_eq!(solved["settings"]["gpu"]["error"], 0.01);
    for side in ["cpu", "gpu"] {
        let estimate = solved["estimated_error"][side].as_f64().unwrap();
        assert!(estimate > 0.0 && estimate < 0.01, "{estimate}");
    }
    // All blocks are linked by both solvers, and by rays both agree.
    assert!(solved["visibility"]["facing"].as_u64() > Some(10), "{solved}");
    assert_eq!(solved["visibility"]["unexplained"], 0);
    for (preset, stages) in [
        (&scene, &["lookup", "link", "select", "deposit", "power"][..]),
        (solved, &["gathered", "kept"]),
    ] {
        for side in ["cpu", "gpu"] {
            assert!(preset["error"][side].is_f64(), "{}", preset["error"]);
        }
        for stage in stages {
            let told = &preset["stages"][*stage];
            assert!(
                told["worst"].is_number() && told["bound"].is_number(),
                "{stage}: {told}"
            );
            assert_eq!(told["agree"], true, "{stage}: {told}");
        }
    }
    // Whole faces are inaccurate on plates as near as these, and the error must be printed.
    let error = scene["error"]["gpu"].as_f64().unwrap();
    assert!(error > 0.01, "{error}");
    assert!(said.contains(&format!("{:.1} % on the GPU", 100.0 * error)), "{said}");
    assert!(said.find("the defaults of solve").unwrap() < said.find("the paper's settings").unwrap());
}

#[test]
fn compare_accepts_options_of_solve_and_shoot() {
    for asked in [
        vec!["--conserve"],
        vec!["--samples", "2", "--patches", "2"],
        vec!["--iteration", "chebyshev", "--patches", "2"],
        vec!["--visibility", "rays", "--patches", "2"],
        vec!["--visibility", "hemicube", "--lookup", "exact", "--samples", "1"],
        vec!["--visibility", "paper", "--patches", "1", "--samples", "1"],
        vec!["--raster", "tessellated", "--patches", "1"],
        vec!["--quality", "draft"],
        vec!["--error", "2%"],
    ] {
        let (code, scene, said) = run_compare("compare-asked", &asked);
        assert_eq!(code, Some(0), "{asked:?}: {said}");
        assert!(scene["agree"] == true && scene["as_solved"].is_null(), "{asked:?}");
        assert_eq!(scene["way"], "asked");
    }
}
