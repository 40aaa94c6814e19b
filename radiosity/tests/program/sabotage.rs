//! `sabotage`: mutants of a file, their verdicts, and a run that goes on.

use super::command::TestFolder;
use gpu::ShaderStage;

#[test]
fn mutants_of_a_file_are_judged_once() {
    let folder = TestFolder::new();
    // A barrier that orders nothing: no check can find it missing.
    let text = ShaderStage::find("exchange").unwrap().text;
    let start = "    let c = flat_index";
    assert_eq!(text.matches(start).count(), 1);
    folder.write(
        "mine.wgsl",
        text.replace(start, &format!("    workgroupBarrier();\n{start}")),
    );
    let line = "sabotage --shader exchange=mine.wgsl --count 10";
    let end = folder.run(line);
    assert_eq!(end.code, Some(1), "{}", end.stderr);
    let survivor = "survived: mine.wgsl:14: workgroupBarrier() → nothing in: workgroupBarrier();";
    assert!(end.stderr.contains(survivor), "{}", end.stderr);
    assert!(
        end.stderr.contains("10 are drawn, 0 of them judged before"),
        "{}",
        end.stderr
    );
    let json = folder.read_json("out/sabotage.json");
    let count = |name: &str| json[name].as_u64().unwrap();
    assert_eq!(count("mutants"), 10);
    let ends = ["killed", "survived", "equivalent", "invalid"].map(count);
    assert_eq!(ends.iter().sum::<u64>(), 10, "{json}");
    assert!(count("killed") >= 5 && count("stage_named") >= 5, "{json}");
    let score = ends[0] as f64 / (10 - ends[2] - ends[3]) as f64;
    assert_eq!(json["score"].as_f64(), Some(score));
    assert!(folder.read_text("out/sabotage.html").contains("mine.wgsl:14"));

    let verdicts = folder.read_text("out/mutants.jsonl");
    let again = folder.run(line);
    assert!(
        again.stderr.contains("10 are drawn, 10 of them judged before"),
        "{}",
        again.stderr
    );
    assert_eq!(again.code, Some(1));
    assert_eq!(folder.read_text("out/mutants.jsonl"), verdicts);
    assert_eq!(folder.read_json("out/sabotage.json"), json);
}

#[test]
fn file_that_differs_without_mutants_is_refused() {
    let folder = TestFolder::new();
    let text = ShaderStage::find("exchange").unwrap().text;
    folder.write("mine.wgsl", text.replace("sum += x *", "sum -= x *"));
    let end = folder.run("sabotage --shader exchange=mine.wgsl --count 1");
    assert_eq!(end.code, Some(2), "{}", end.stderr);
    let said = "mine.wgsl: without a mutant, compare occluded_plates.obj";
    assert!(
        end.stderr.contains(said) && end.stderr.contains("exchange does not hold"),
        "{}",
        end.stderr
    );
}

#[test]
fn given_comparison_judges_in_place_of_the_bundled_ones() {
    let folder = TestFolder::new();
    let judge = |shader: &str, comparison: &str| {
        folder.write("mine.wgsl", ShaderStage::find(shader).unwrap().text);
        let file = format!("{shader}=mine.wgsl");
        let words = [
            "sabotage",
            "--shader",
            &file,
            "--count",
            "2",
            "--comparison",
            comparison,
        ];
        folder.run_words(&words)
    };
    let by_rays = "occluded_plates.obj --texels 3 --patches 1 --samples 1 --visibility rays";
    let end = judge("hemicube", by_rays);
    assert_eq!(end.code, Some(1), "{end}");
    // One of the two may be equivalent.
    let found = folder.read_json("out/sabotage.json");
    assert!(found["not_run"].as_u64() >= Some(1) && found["killed"] == 0, "{found}");
    judge("deposit", by_rays);
    let found = folder.read_json("out/sabotage.json");
    assert_eq!((&found["not_run"], &found["mutants"]), (&0.into(), &2.into()));
    for (comparison, said) in [
        ("occluded_plates.obj --texles 3", "--texles"),
        ("no_such_scene.obj", "no_such_scene.obj"),
    ] {
        let end = judge("deposit", comparison);
        assert_eq!(end.code, Some(2), "{end}");
        assert!(end.stderr.contains(said), "{end}");
    }
}
