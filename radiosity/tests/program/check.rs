//! `check`: the error of a stored result.

use super::command::TestFolder;

#[test]
fn check_estimates_error_of_crude_and_good_result() {
    let folder = TestFolder::new();
    let scene = "scenes/cornell_box.obj --solver cpu --texels 8";
    folder.succeed(&format!("shoot {scene} --patches 1 --samples 1 --out crude"));
    folder.succeed(&format!("solve {scene} --error 0.5% --out good"));
    folder.succeed("diff crude good");
    let shares = folder.read_json("out/diff.json");
    let shares = shares["relative_rms"].as_array().unwrap().iter();
    let known = shares.map(|x| x.as_f64().unwrap()).fold(0.0, f64::max);

    assert_eq!(folder.run("check crude --tolerance 5%").code, Some(1));
    assert!(folder.read("out/check.html").len() > 10_000);
    let found = folder.read_json("out/check.json");
    let error = found["estimated_error"].as_f64().unwrap();
    // The two estimates are from different methods, each accurate to half a per cent.
    assert!(known > 0.1 && (error - known).abs() <= 0.01, "{error} {known}");
    assert!(found["one_bounce"].as_f64().unwrap() > 0.05);
    let worst = found["faces"].as_array().unwrap().iter();
    assert!(worst.map(|face| face["share"].as_f64().unwrap()).sum::<f64>() > 0.999);

    folder.succeed("check good scenes/cornell_box.obj --tolerance 1%");
    let found = folder.read_json("out/check.json");
    let error = found["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.01, "{error}");
    assert!(found["energy"]["imbalance"].as_f64().unwrap() < 1e-5, "{found}");
}

#[test]
fn results_that_cannot_be_judged_are_refused() {
    let folder = TestFolder::new();
    folder.fail_with(2, "check result", "result");
    folder.succeed("solve scenes/cornell_box.obj --solver cpu --texels 8 --quality draft --out result");
    folder.fail_with(2, "check result scenes/paper_room.obj", "156 faces");
    folder.change_json("result/result.json", |result| {
        for face in result["faces"].as_array_mut().unwrap() {
            face.as_object_mut().unwrap().remove("reflectance");
        }
    });
    folder.fail_with(2, "check result", "give the scene");
    folder.succeed("check result scenes/cornell_box.obj");
}
