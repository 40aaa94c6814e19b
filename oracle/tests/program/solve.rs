//! The program as scripts use it: exit codes, one `error:` line, the files of `solve`, nothing
//! half-written.

use super::command::{failure, folder, radiosity};
use approx::abs_diff_eq;
use serde_json::Value;
use std::fs;
use std::path::Path;

const QUAD: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl m\nf 1 2 3 4\n";

fn scene(folder: &Path, obj: &str, mtl: &str) -> String {
    fs::write(folder.join("m.mtl"), mtl).unwrap();
    let path = folder.join("scene.obj");
    fs::write(&path, obj).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn bad_input_is_one_line_and_code_2() {
    let folder = folder("bad");
    let out = folder.join("out");
    let good = "newmtl m\nKd .5 .5 .5\nKe 1 1 1\n";
    let cases = [
        ("empty", String::new(), good, "empty"),
        ("NaN", QUAD.replace("v 1 1 0", "v nan 1 0"), good, ""),
        (
            "negative reflectance",
            QUAD.into(),
            "newmtl m\nKd -.5 .5 .5\n",
            "m",
        ),
        (
            "reflectance 1.1",
            QUAD.into(),
            "newmtl m\nKd 1.1 .5 .5\n",
            "m",
        ),
        (
            "missing vertex",
            QUAD.replace("f 1 2 3 4", "f 1 2 3 9"),
            good,
            "",
        ),
        (
            "all faces without area",
            QUAD.replace("v 1 0 0\nv 1 1 0\nv 0 1 0", "v 0 0 0\nv 0 0 0\nv 0 0 0"),
            good,
            "",
        ),
    ];
    for (name, obj, mtl, says) in cases {
        let path = scene(&folder, &obj, mtl);
        let (code, line) = failure(&[
            "solve",
            &path,
            "--solver",
            "cpu",
            "--out",
            out.to_str().unwrap(),
        ]);
        assert_eq!(code, 2, "{name}: {line}");
        assert!(
            line.contains("scene.obj") || line.contains("m.mtl"),
            "{name}: {line}"
        );
        assert!(line.contains(says), "{name}: {line}");
        assert!(!out.exists(), "{name} wrote something");
    }
    assert_eq!(failure(&["solve", "/nowhere/at/all.obj"]).0, 2);
}

#[test]
fn bad_usage_is_one_line_and_code_2() {
    let folder = folder("usage");
    let path = scene(&folder, QUAD, "newmtl m\nKd .5 .5 .5\nKe 1 1 1\n");
    for arguments in [
        vec!["solve", &path, "--texels", "0"],
        vec!["solve", &path, "--epsilon", "0"],
        vec!["solve", &path, "--epsilon", "nan"],
        vec!["solve", &path, "--quality", "best"],
        vec!["solve", &path, "--solver", "cpu", "--require-gpu"],
        vec![
            "solve",
            &path,
            "--visibility",
            "hemicube",
            "--raster",
            "tessellated",
        ],
        vec!["solve", &path, "--visibility", "paper", "--raster", "pixel"],
        vec![
            "solve",
            &path,
            "--texels",
            "8192",
            "--solver",
            "cpu",
            "--nonsense",
        ],
        vec!["solve"],
        vec!["diff", "only-one"],
        vec!["converge", "--truth", "somewhere"],
        vec!["converge", &path, &path, "--truth", "somewhere"],
        vec!["converge", &path, "--truth", "/nowhere"],
        vec!["nonsense"],
    ] {
        let (code, line) = failure(&arguments);
        assert_eq!(code, 2, "{arguments:?}: {line}");
    }
}

#[test]
fn the_matrix_refuses_what_it_has_no_use_for() {
    let folder = folder("matrix-usage");
    let path = scene(&folder, QUAD, "newmtl m\nKd .5 .5 .5\nKe 1 1 1\n");
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let solve = ["solve", &path, "--solver", "matrix", "--out", out];
    for option in [
        &["--cells", "1"][..],
        &["--max-shots", "9"],
        &["--item-buffer", "1024"],
        &["--lookup", "3x3"],
        &["--visibility", "stereographic"],
        &["--form-factor", "disc"],
        &["--adapter", "any"],
        &["--require-gpu"],
    ] {
        let (code, line) = failure(&[&solve[..], option].concat());
        assert_eq!(code, 2, "{option:?}: {line}");
        assert!(line.contains(option[0]), "{option:?}: {line}");
    }
    // 1 face × 200² texels: 25.6 GB, 11 585 texels are allowed, 107² fit.
    let (code, line) = failure(&[&solve[..], &["--texels", "200"]].concat());
    assert_eq!(code, 2, "{line}");
    for part in ["scene.obj", "40000 texels", "25.6 GB", "--texels 107"] {
        assert!(line.contains(part), "{part}: {line}");
    }
    assert!(!Path::new(out).exists(), "a refused solve wrote something");
}

#[test]
fn the_matrix_solver_writes_what_the_contract_says() {
    let folder = folder("matrix");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
    let out = folder.join("out");
    let arguments = ["solve", path, "--solver", "matrix", "--texels", "4"];
    let chosen = ["--visibility", "rays", "--form-factor", "polygon", "--out"];
    let output = radiosity(&[&arguments[..], &chosen, &[out.to_str().unwrap()]].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("matrix of"), "{text}");
    let result: Value =
        serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap();
    assert_eq!(result["solver"], "matrix");
    assert_eq!(result["shots"], 0);
    assert_eq!(result["converged"], true);
    assert_eq!(result["unshot_fraction"], 0.0);
    let settings = serde_json::json!({"texels": 4, "visibility": "rays", "form-factor": "polygon"});
    assert_eq!(result["settings"], settings);
    let matrix = &result["matrix"];
    assert!(matrix["residual"].as_f64().unwrap() < 1e-12);
    assert!(matrix["reciprocity"].as_f64().unwrap() < 1e-7);
    // The matrix and its factors in f64, 4 × 4 texels a face.
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
        // The measured box is open in front; what visibility finds there is nearly all that is missing.
        let missing = part("emitted") - part("absorbed");
        assert!(part("escaped") > 0.0);
        assert!(
            abs_diff_eq!(part("escaped") / missing, 1.0, epsilon = 0.02),
            "{energy}"
        );
    }
    assert!(fs::metadata(out.join("lightmap.exr")).unwrap().len() > 0);
}

#[test]
fn an_unwritable_folder_is_code_4() {
    let folder = folder("unwritable");
    let path = scene(&folder, QUAD, "newmtl m\nKd .5 .5 .5\nKe 1 1 1\n");
    let file = folder.join("file");
    fs::write(&file, "").unwrap();
    let below = file.join("out");
    let (code, line) = failure(&[
        "solve",
        &path,
        "--solver",
        "cpu",
        "--out",
        below.to_str().unwrap(),
    ]);
    assert_eq!(code, 4, "{line}");
}

#[test]
fn solve_writes_what_the_contract_says() {
    let folder = folder("files");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
    let out = folder.join("out");
    let output = radiosity(&[
        "solve",
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
    let result: Value =
        serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap();
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
    let mut left: Vec<_> = fs::read_dir(&out)
        .unwrap()
        .map(|f| f.unwrap().file_name())
        .collect();
    left.sort();
    assert_eq!(
        left,
        ["lightmap.exr", "preview.png", "result.json", "view.html"]
    );
}

/// Of an object in the open, which sees only its own lamp.
#[test]
fn white_is_told_unless_a_reflectance_is_given() {
    let folder = folder("white");
    let path = scene(&folder, QUAD, "newmtl m\nKd 1 1 1\nKe 1 1 1\n");
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let solve = ["solve", &path, "--solver", "cpu", "--out", out];
    let given = ["--reflectance", "0.2,0.3,0.98"];
    for (more, white, taken) in [
        (&[][..], true, [0.95; 3]),
        (&given[..], false, [0.2, 0.3, 0.98]),
    ] {
        let output = radiosity(&[&solve[..], more].concat());
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
fn strict_makes_a_warning_an_error_after_writing() {
    let folder = folder("strict");
    let obj = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
    let out = folder.to_str().unwrap();
    let solve = [
        "solve", obj, "--solver", "cpu", "--cells", "1", "--out", out,
    ];
    assert!(radiosity(&solve).status.success());
    fs::remove_file(folder.join("result.json")).unwrap();
    let (code, line) = failure(&[&solve[..], &["--strict"]].concat());
    assert_eq!(code, 1, "{line}");
    assert!(
        line.contains("cornell_box.obj") && line.contains("--cells"),
        "{line}"
    );
    let result = fs::read_to_string(folder.join("result.json")).unwrap();
    assert!(result.contains("\"estimated_error\""));
    let answered = ["solve", obj, "--solver", "cpu", "--out", out, "--strict"];
    assert!(radiosity(&answered).status.success());
    fs::remove_dir_all(folder).unwrap();
}

/// `compare` on the two plates, with what is asked besides: exit code, report.json, what was said.
fn compared(name: &str, asked: &[&str]) -> (Option<i32>, Value, String) {
    let out = folder(name);
    let plates = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/facing_plates.obj");
    let fixed = [
        "compare",
        plates,
        "--texels",
        "8",
        "--out",
        out.to_str().unwrap(),
    ];
    // Rays have no pixels.
    let by_rays = asked
        .iter()
        .any(|option| ["rays", "--quality", "--error"].contains(option));
    let pixels: &[&str] = if by_rays {
        &[]
    } else {
        &["--item-buffer", "128"]
    };
    let output = radiosity(&[&fixed, pixels, asked].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    let text =
        fs::read_to_string(out.join("report.json")).unwrap_or_else(|e| panic!("{e}: {said}"));
    let report: Value = serde_json::from_str(&text).unwrap();
    (output.status.code(), report["scenes"][0].clone(), said)
}

#[test]
fn compare_judges_what_solve_does_and_the_papers_way_with_the_error_beside() {
    let (code, scene, said) = compared("compare", &[]);
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
    // All blocks were asked of both, and by rays both answer alike.
    assert!(
        solved["visibility"]["facing"].as_u64() > Some(10),
        "{solved}"
    );
    assert_eq!(solved["visibility"]["unexplained"], 0);
    for (way, stages) in [
        (
            &scene,
            &["lookup", "link", "select", "deposit", "power"][..],
        ),
        (solved, &["gathered", "kept"]),
    ] {
        for side in ["cpu", "gpu"] {
            assert!(way["error"][side].is_f64(), "{}", way["error"]);
        }
        for stage in stages {
            let told = &way["stages"][*stage];
            assert!(
                told["worst"].is_number() && told["bound"].is_number(),
                "{stage}: {told}"
            );
            assert_eq!(told["agree"], true, "{stage}: {told}");
        }
    }
    // Whole faces are far off on plates as near as these, and it must be said.
    let error = scene["error"]["gpu"].as_f64().unwrap();
    assert!(error > 0.01, "{error}");
    assert!(
        said.contains(&format!("{:.1} % on the GPU", 100.0 * error)),
        "{said}"
    );
    assert!(said.find("as solve does").unwrap() < said.find("the paper's way").unwrap());
}

#[test]
fn compare_judges_whatever_solve_takes() {
    for asked in [
        vec!["--conserve"],
        vec!["--samples", "2", "--cells", "2"],
        vec!["--iteration", "chebyshev", "--cells", "2"],
        vec!["--visibility", "rays", "--cells", "2"],
        vec![
            "--visibility",
            "hemicube",
            "--lookup",
            "exact",
            "--samples",
            "1",
        ],
        vec!["--visibility", "paper", "--cells", "1", "--samples", "1"],
        vec!["--raster", "tessellated", "--cells", "1"],
        vec!["--quality", "draft"],
        vec!["--error", "2%"],
    ] {
        let (code, scene, said) = compared("compare-asked", &asked);
        assert_eq!(code, Some(0), "{asked:?}: {said}");
        assert!(
            scene["agree"] == true && scene["as_solved"].is_null(),
            "{asked:?}"
        );
        assert_eq!(scene["way"], "asked");
    }
}
