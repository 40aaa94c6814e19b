//! `shader`, and `compare` with files in the place of shaders.

use super::command::{ProgramEnd, TestFolder};
use gpu::SHADER_STAGES;
use std::time::Duration;

/// The paper's way on a small scene: seconds on a software adapter.
const SMALL: &str = "compare scenes/occluded_plates.obj --texels 4 --patches 1 --samples 1 --form-factor disc \
    --iteration southwell --item-buffer 64";
/// To an error.
const TO_ERROR: &str = "compare scenes/occluded_plates.obj --texels 4 --error 5% --quiet";

/// Returns the program's shader, in which the one place that reads `from` reads `to`.
fn changed_shader(stage: &str, from: &str, to: &str) -> String {
    let text = SHADER_STAGES.iter().find(|found| found.name == stage).unwrap().text;
    assert_eq!(text.matches(from).count(), 1, "{stage}: {from}");
    text.replace(from, to)
}

/// Runs a comparison with a changed shader in mine.wgsl.
fn compare_with_change(comparison: &str, stage: &str, from: &str, to: &str) -> ProgramEnd {
    let folder = TestFolder::new();
    folder.write("mine.wgsl", changed_shader(stage, from, to));
    folder.run(&format!("{comparison} --shader {stage}=mine.wgsl"))
}

#[track_caller]
fn assert_end(end: &ProgramEnd, code: i32, said: &[&str]) {
    assert_eq!(end.code, Some(code), "{}", end.stderr);
    for text in said {
        assert!(end.stderr.contains(text), "no {text:?} in {}", end.stderr);
    }
}

#[test]
fn printed_shaders_take_the_place_of_the_programs_and_agree() {
    let folder = TestFolder::new();
    for stage in SHADER_STAGES {
        let printed = folder.run(&format!("shader {}", stage.name));
        assert_eq!((printed.code, printed.stdout.as_str()), (Some(0), stage.text));
        if stage.name != "item_buffer_paper" {
            folder.write(&format!("all/{}.wgsl", stage.name), printed.stdout);
        }
    }
    let line = "compare scenes/occluded_plates.obj --texels 4 --item-buffer 64 --quiet --shaders all";
    assert_end(&folder.run(line), 0, &[]);
    let report = folder.read_json("out/report.json").to_string();
    assert!(
        report.contains("all/deposit.wgsl takes the place of deposit.wgsl"),
        "{report}"
    );
}

#[test]
fn shaders_are_listed_with_their_twins() {
    let end = TestFolder::new().run("shader");
    assert_eq!(end.stdout.lines().count(), SHADER_STAGES.len());
    let line = "deposit            Deposits the shot on one texel · cpu/src/shader_twins/deposit.rs: deposit \
        · in the verdict: deposit; deposit, relit";
    assert!(end.stdout.lines().any(|found| found == line), "{}", end.stdout);
}

#[test]
fn dropped_cosine_is_a_fault_of_form_factor() {
    let call = "return disc_factor(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);";
    let folder = TestFolder::new();
    folder.write(
        "mine.wgsl",
        changed_shader("form_factor", call, &call.replace("cos_j", "1.0")),
    );
    let end = folder.run(&format!("{SMALL} --shader form_factor=mine.wgsl"));
    assert_end(&end, 1, &["beyond its bound: WGSL = twin: form factor"]);
    let mut lines = end
        .stderr
        .lines()
        .skip_while(|line| !line.contains("WGSL = twin: form factor"));
    let shown = [lines.next().unwrap(), lines.next().unwrap()].join("\n");
    let page = include_str!("../../../docs/your-shader.md");
    assert!(page.contains(&shown), "docs/your-shader.md should have:\n{shown}");
    // The report says the same, for people and for scripts.
    let difference = shown.lines().last().unwrap().trim();
    assert!(folder.read_text("out/report.html").contains(difference), "{difference}");
    let report = folder.read_json("out/report.json");
    let first = &report["scenes"][0]["stages"]["form factor"]["difference"]["first"];
    let element = first["element"].as_str().unwrap();
    assert!(difference.starts_with(element), "{first}");
}

/// The printed divergence is that of the page as far as its bounds, which depend on the adapter; the report has it with both
/// numbers.
#[test]
fn first_divergence_of_a_dropped_cosine_is_shown_as_the_page_does() {
    let call = "return disc_factor(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);";
    let folder = TestFolder::new();
    let changed = changed_shader("form_factor", call, &call.replace("cos_j", "1.0"));
    folder.write("mine.wgsl", changed);
    let end = folder.run(&format!("{SMALL} --shader form_factor=mine.wgsl --first-divergence"));
    assert_end(&end, 1, &["first divergence: shot 1 by patch 1 of face 1 (upper)"]);
    let lines = end
        .stderr
        .lines()
        .skip_while(|line| !line.contains("first divergence: "));
    let shown: Vec<&str> = lines.take_while(|line| !line.contains("largest difference")).collect();
    assert!(shown.len() > 10, "{}", end.stderr);
    let page = include_str!("../../../docs/your-shader.md");
    for line in &shown {
        assert!(
            page.contains(line),
            "docs/your-shader.md should have:\n{}",
            shown.join("\n")
        );
    }
    let html = folder.read_text("out/report.html");
    assert!(
        html.contains(shown[0].trim()) && html.contains("First divergence"),
        "{}",
        shown[0]
    );
    let report = folder.read_json("out/report.json");
    let found = &report["scenes"][0]["first_divergence"];
    assert_eq!(found["parting"]["factor"], "cosine", "{found}");
    assert!(found["parting"]["texel"]["number"].is_u64(), "{found}");
    let differing = found["parting"]["steps"].as_array().unwrap();
    let factor = differing.iter().find(|step| step["differs"] == true).unwrap();
    assert!(factor["gpu"].as_f64() > factor["cpu"].as_f64(), "{factor}");
    assert!(found["shares"]["relative_rms"].as_f64() > Some(0.01), "{found}");
}

#[test]
fn first_divergence_of_agreeing_solvers_and_of_links_is_named() {
    let agreed = TestFolder::new().run(&format!("{SMALL} --first-divergence"));
    assert_end(&agreed, 0, &["shots parts the solvers beyond its bound"]);
    let told = format!("{} --first-divergence", TO_ERROR.replace(" --quiet", ""));
    let links = compare_with_change(&told, "add_links", "received.w = 1.0;", "");
    assert_end(
        &links,
        1,
        &["first divergence: stage: the check of the stage add_links fails"],
    );
}

#[test]
fn uncleared_residual_ends_in_a_verdict() {
    let end = compare_with_change(SMALL, "deposit", "residual[k] = vec4f(0.0);", "");
    let said = [
        "beyond its bound: free: shots of the GPU",
        "beyond its bound: WGSL = twin: deposit",
    ];
    assert_end(&end, 1, &said);
}

#[test]
fn removed_barrier_is_shown_as_the_page_does() {
    let end = compare_with_change(SMALL, "closure", "workgroupBarrier();", "");
    let mut lines = end.stderr.lines().skip_while(|line| !line.contains("closure, races"));
    let shown = [lines.next().unwrap(), lines.next().unwrap()].join("\n");
    let page = include_str!("../../../docs/your-shader.md");
    assert!(page.contains(&shown), "docs/your-shader.md should have:\n{shown}");
}

#[test]
fn missing_results_fail_their_stage() {
    let by_passes = "compare scenes/occluded_plates.obj --texels 4 --patches 1 --samples 1 --visibility rays";
    let faults = [
        (
            SMALL,
            ["select", "patch_index < params.patches", "patch_index > params.patches"],
            "a shot left no record",
        ),
        (
            by_passes,
            ["closure", "slot = group.z;", ""],
            "the links of a patch were not made",
        ),
        (
            by_passes,
            ["exchange", "vec4f(sum, 1.0)", "vec4f(sum, 0.0)"],
            "the exchange between patches was not made",
        ),
    ];
    for (comparison, [stage, from, to], reason) in faults {
        let end = compare_with_change(comparison, stage, from, to);
        let failing = format!("beyond its bound: WGSL = twin: {stage} = ");
        assert_end(
            &end,
            1,
            &[&failing, "results of the GPU that are refused", "mine.wgsl: ", reason],
        );
    }
}

#[test]
fn all_comparisons_run_every_shader() {
    let folder = TestFolder::new();
    for stage in SHADER_STAGES {
        folder.write(&format!("mine/{}.wgsl", stage.name), stage.text);
    }
    // A file that is not run would be an error.
    assert_end(&folder.run("compare --all --quiet --shaders mine"), 0, &[]);
    let report = folder.read_json("out/report.json").to_string();
    assert!(report.contains("\"slivers.obj --texels 12 "), "{report}");
    folder.assert_refused(
        "compare --all scenes/furnace.obj => cannot be used with
         compare --all --error 2% => cannot be used with
         compare --all --samples 2 => cannot be used with
         compare => required",
    );
}

#[test]
fn ends_of_links_are_checked_before_they_are_indices() {
    let told = TO_ERROR.replace(" --quiet", "");
    let ends = "ends[link] = vec2u(pairs[pair].block, pairs[pair].node);";
    for wrong in [
        "vec2u(pairs[pair].block, 4000000000u)",
        "vec2u(4000000000u, pairs[pair].node)",
    ] {
        let end = compare_with_change(&told, "store_links", ends, &format!("ends[link] = {wrong};"));
        let stage = "beyond its bound: WGSL = twin: store_links";
        assert_end(&end, 1, &[stage, "mine.wgsl: ", "there is no such block or node"]);
    }
    let count = compare_with_change(
        &told,
        "prefix_sum",
        "totals[0] = before.y;",
        "totals[0] = select(before.y, 40000u, children == 0u);",
    );
    let stage = "beyond its bound: WGSL = twin: prefix_sum";
    assert_end(&count, 1, &[stage, "mine.wgsl: ", "40000 links are counted"]);
}

#[test]
fn wrong_workgroups_end_in_a_verdict() {
    let told = TO_ERROR.replace(" --quiet", "");
    let end = compare_with_change(
        &told,
        "clear_work_lists",
        "source_dispatches[3u * lane + k]",
        "source_dispatches[lane + k]",
    );
    let stage = "beyond its bound: WGSL = twin: clear_work_lists";
    assert_end(&end, 1, &[stage, "clear_work_lists makes wrong numbers of workgroups"]);
}

#[test]
fn unknown_ids_in_an_item_buffer_are_a_fault_of_its_stage() {
    let id = compare_with_change(SMALL, "item_buffer", "vertex.face.x + 1u", "vertex.face.x + 1000u");
    assert_end(&id, 1, &["beyond its bound: WGSL = twin: item buffer"]);
}

#[test]
fn wgsl_errors_are_shown_in_the_users_file() {
    let assignment = "    residual[k] = vec4f(0.0);";
    let missing = assignment.replace(';', "");
    let deposit = changed_shader(
        "deposit",
        "        residual[k] = vec4f(0.0);",
        &format!("    {missing}"),
    );
    let line = deposit.lines().position(|found| found.ends_with("vec4f(0.0)")).unwrap() + 2;
    let folder = TestFolder::new();
    folder.write("mine.wgsl", &deposit);
    let end = folder.run(&format!("{SMALL} --shader deposit=mine.wgsl"));
    let place = format!("mine.wgsl:{line}:9");
    assert_end(
        &end,
        2,
        &[
            &format!("error: {place}: expected"),
            &format!("┌─ {place}"),
            "│         ^^^^^^ expected",
        ],
    );

    let page = include_str!("../../../docs/your-shader.md");
    assert!(
        page.contains(&end.stderr),
        "docs/your-shader.md should have:\n{}",
        end.stderr
    );

    let open = deposit.replace(&missing, assignment);
    let (open, _) = open.rsplit_once('}').unwrap();
    folder.write("open.wgsl", format!("{open}// ä\n"));
    let end = folder.run(&format!("{SMALL} --shader deposit=open.wgsl"));
    let place = format!("open.wgsl:{}:1", open.lines().count() + 2);
    assert_end(&end, 2, &[&format!("error: {place}: expected"), &format!("┌─ {place}")]);

    // Of two files of one module the second, and an error of types.
    let (link, factor) = (
        "sum += form_factor(middle, p.xyz, normal, texels[k].area) * p.w;",
        "fn is_far(",
    );
    folder.write(
        "link.wgsl",
        changed_shader("link", link, "sum += form_factor(middle, p.xyz, normal, 1u) * p.w;"),
    );
    folder.write(
        "ff.wgsl",
        changed_shader("form_factor", factor, "// A comment.\nfn is_far("),
    );
    let end = folder.run(&format!("{SMALL} --shader form_factor=ff.wgsl --shader link=link.wgsl"));
    assert_end(&end, 2, &["error: link.wgsl:", "┌─ link.wgsl:"]);

    // Its own function has the name of one of the program's.
    let twice = changed_shader("deposit", "@compute", "fn flat_index() {}\n\n@compute");
    let line = twice.lines().position(|found| found.starts_with("fn flat")).unwrap() + 1;
    folder.write("twice.wgsl", &twice);
    let end = folder.run(&format!("{SMALL} --shader deposit=twice.wgsl"));
    let place = format!("twice.wgsl:{line}:4");
    let said = [
        format!("error: {place}: redefinition"),
        format!("┌─ {place}"),
        "of types.wgsl of the program".into(),
    ];
    assert_end(&end, 2, &said.each_ref().map(String::as_str));

    // The program's file uses what this one no longer has.
    folder.write("ff.wgsl", changed_shader("form_factor", factor, "fn is_distant("));
    let end = folder.run(&format!("{SMALL} --shader form_factor=ff.wgsl"));
    assert_end(&end, 2, &["does not fit ff.wgsl", "is_far"]);
}

#[test]
fn files_that_cannot_be_used_are_refused() {
    let folder = TestFolder::new();
    folder.write("empty.wgsl", " \n");
    folder.write("other.wgsl", changed_shader("deposit", "fn deposit(", "fn deposits("));
    folder.write(
        "unknown.wgsl",
        changed_shader("deposit", "> links: array<f32>;", "> lynx: array<f32>;").replace("links[", "lynx["),
    );
    let wide = "> links: array<array<f32, 100000>>;";
    let wide = changed_shader("deposit", "> links: array<f32>;", wide);
    folder.write("wide.wgsl", wide.replace("links[", "links[0]["));
    folder.write("none/readme.txt", "");
    folder.write("stray/stray.wgsl", "fn f() {}");
    folder.write("deposit.wgsl", changed_shader("deposit", "fn deposit(", "fn deposit("));
    let refused = [
        (
            "--shader nonsense=deposit.wgsl",
            "no shader stage is called \"nonsense\"; there are: types, form_factor",
        ),
        ("--shader deposit", "STAGE=FILE.wgsl is needed"),
        (
            "--shader deposit=nowhere.wgsl",
            "nowhere.wgsl: cannot be read: there is no such file",
        ),
        ("--shader deposit=empty.wgsl", "empty.wgsl: is empty"),
        (
            "--shader deposit=other.wgsl",
            "other.wgsl: has no entry point `fn deposit`",
        ),
        (
            "--shader deposit=unknown.wgsl",
            "unknown.wgsl: declares an unknown `lynx`; there are: ",
        ),
        ("--shader deposit=wide.wgsl", "wide.wgsl: "),
        (
            "--shader deposit=deposit.wgsl --shader deposit=deposit.wgsl",
            "two files are given for the shader deposit",
        ),
        ("--shaders none", "none: has no .wgsl file"),
        ("--shaders nowhere", "nowhere: cannot be read"),
        ("--shaders stray", "no shader stage is called \"stray\""),
        (
            "--shader item_buffer_paper=paper.wgsl",
            "with `compare --all` in place of a scene every stage runs",
        ),
    ];
    let paper = SHADER_STAGES
        .iter()
        .find(|stage| stage.name == "item_buffer_paper")
        .unwrap();
    folder.write("paper.wgsl", paper.text);
    for (options, reason) in refused {
        let end = folder.run(&format!("{SMALL} --quiet {options}"));
        assert_end(&end, 2, &[reason]);
        assert_eq!(end.stderr.lines().count(), 1, "{}", end.stderr);
    }
    assert_eq!(folder.run("shader nonsense").code, Some(2));
}

#[test]
fn watch_compares_again_after_a_change() {
    let folder = TestFolder::new();
    let shader = |text: &str| folder.write("mine.wgsl", text);
    let log = std::fs::File::create(folder.path("log")).unwrap();
    shader("fn");
    let line = format!("{SMALL} --watch --shader deposit=mine.wgsl");
    let words: Vec<&str> = line.split_whitespace().collect();
    let mut running = folder.command(&words).stderr(log).spawn().unwrap();
    let says = |text: &str| {
        let mut looks = 0..6000;
        looks.any(|_| {
            std::thread::sleep(Duration::from_millis(100));
            folder.read_text("log").contains(text)
        })
    };
    let refused = says("waiting for a change of 2 files");
    shader(changed_shader("deposit", "fn deposit(", "fn deposit(").as_str());
    let agreed = refused && says("the solvers agree");
    running.kill().unwrap();
    running.wait().unwrap();
    assert!(agreed, "{}", folder.read_text("log"));
    assert!(folder.read_text("log").starts_with("error: mine.wgsl:"));
}
