//! Composes `report.html`: verdict, pictures, overview, a section per comparison, and the explanation.

use super::figures::{ComparisonView, convergence_figure, mismatch_figure};
use super::json::settings_in_force;
use crate::report::document::{
    Blocks, Cell, Document, Row, Section, Table, Text, VerdictTone, bold_text, code_text, link_text, pass_mark,
    plain_text, styled_text,
};
use crate::report::energy::add_energy_balances;
use crate::report::format::{count_noun, file_name, format_count, format_duration, format_number, format_percent};
use crate::report::viewer;
use oracle::compare::comparison::{Comparison, Preset, SceneComparison};
use serde_json::Value;

/// Renders the report; `notes` name the omitted scenes with reasons.
pub fn render_report(judged: &[SceneComparison], notes: &[String]) -> String {
    let mut opening = Blocks::default();
    add_headline(&mut opening, judged);
    opening.add_notes(notes);
    let mut sections = Vec::new();
    for (k, scene) in judged.iter().enumerate() {
        let mut figures = Vec::new();
        let mut viewer = None;
        for c in scene.iter_comparisons() {
            let view = ComparisonView::new(c);
            figures.push(view.opening_figure(preset_heading(c.preset), &format_errors(c.truth_error)));
            viewer.get_or_insert_with(|| view.render_viewer());
            let id = section_id(k, c.preset == scene.first.preset);
            sections.push(comparison_section(id, c, &view));
        }
        opening
            .add_heading(file_name(&scene.first.scene.name))
            .add_figures(&figures);
        viewer.map(|viewer| opening.add_element(viewer));
    }
    opening.add_table(overview_table(judged));
    let mut method = Blocks::default();
    add_explanation(&mut method);
    method.add_element(viewer::page_assets());
    sections.push(method.into_section("how", "Method of comparison"));
    let page = Document {
        title: "Radiosity: CPU against GPU",
        opening,
        sections,
        style: "",
    };
    page.to_html()
}

/// Returns the anchor of scene `k`'s first or second comparison.
fn section_id(k: usize, is_first: bool) -> String {
    format!("scene-{}{}", k + 1, if is_first { "" } else { "-solve" })
}

fn preset_heading(preset: Preset) -> &'static str {
    match preset {
        Preset::SolveDefault => "The default of solve: adaptive, to an error",
        Preset::Paper => "The paper's method: whole faces, discs, one sample, an item buffer",
        Preset::Requested => "The given options",
    }
}

/// Formats a share of each solver; – where it is not known.
fn format_errors(errors: [Option<f64>; 2]) -> [String; 2] {
    errors.map(|error| error.map_or("–".into(), format_percent))
}

fn add_headline(opening: &mut Blocks, judged: &[SceneComparison]) {
    let agree = judged.iter().filter(|scene| scene.all_agree()).count();
    let all = judged.len();
    let scenes = if all == 1 { "scene" } else { "scenes" };
    match (all, agree) {
        (0, _) => opening.add_verdict(VerdictTone::Bad, "Nothing compared", "no scene was solved by both"),
        (1, 1) => opening.add_verdict(VerdictTone::Good, "Agree", "CPU and GPU, on the scene"),
        _ if agree == all => opening.add_verdict(
            VerdictTone::Good,
            "Agree",
            format!("CPU and GPU, on all {all} {scenes}"),
        ),
        _ => opening.add_verdict(
            VerdictTone::Bad,
            "Disagree",
            format!("on {} of {all} {scenes}", all - agree),
        ),
    };
}

fn overview_table(judged: &[SceneComparison]) -> Table {
    let both = |values: [String; 2]| values.join(" · ").into();
    let row = &|k: usize, c: &Comparison, is_first: bool| {
        let shots = match c.error_target {
            Some(_) => "–".into(),
            None => both([&c.cpu, &c.gpu].map(|run| format_count(run.shooters))),
        };
        let differences = [&c.lockstep_difference, &c.free_difference];
        let cells: [Cell; 10] = [
            pass_mark(c.solvers_agree()).into(),
            link_text(section_id(k, is_first), file_name(&c.scene.name)).into(),
            c.preset.name().into(),
            both(format_errors(c.truth_error)),
            both([c.mesh.faces.len(), c.mesh.texels.len()].map(|n| format_count(n as u64))),
            shots,
            both(differences.map(|difference| format_percent(difference.relative_rms))),
            both([c.pairs.mismatched, c.pairs.unexplained].map(format_count)),
            both([&c.cpu_energy, &c.gpu_energy].map(|energy| format_percent(energy.imbalance))),
            both(c.seconds.map(format_duration)),
        ];
        Row::new(cells).with_class_if(!c.solvers_agree(), "bad")
    };
    let rows = judged.iter().enumerate().flat_map(|(k, scene)| {
        let comparisons = scene.iter_comparisons();
        comparisons.map(move |c| row(k, c, c.preset == scene.first.preset))
    });
    let heads = [
        "",
        "Scene",
        "Preset",
        "#Error of the solution|CPU · GPU",
        "#Faces · texels",
        "#Shots|CPU · GPU",
        "#GPU − CPU, RMS|lockstep · free",
        "#Pairs mismatched|· unexplained",
        "#Energy imbalance|CPU · GPU",
        "#Time|CPU · GPU",
    ];
    Table {
        class: "overview",
        ..Table::new(&heads, rows)
    }
}

fn comparison_section(id: String, c: &Comparison, view: &ComparisonView) -> Section {
    let mut body = Blocks::default();
    body.add_paragraph(bold_text(preset_heading(c.preset)) + ", " + code_text(&c.scene.name));
    add_verdict(&mut body, c);
    add_accuracy(&mut body, c);
    let shooters = match c.error_target {
        Some(_) => String::new(),
        None => format!("{} · ", count_noun(c.mesh.patches.len(), "shooter", "shooters")),
    };
    body.add_remark(format!(
        "{} · {shooters}{} · {}",
        count_noun(c.mesh.faces.len(), "face", "faces"),
        count_noun(c.mesh.texels.len(), "texel", "texels"),
        c.adapter
    ));
    let notes: Vec<&String> = c.scene.notes.iter().chain(&c.notes).collect();
    if !notes.is_empty() {
        let mut list = Blocks::default();
        let count = count_noun(notes.len(), "note", "notes");
        body.add_details(count, false, std::mem::take(list.add_list(notes)));
    }
    body.add_heading("Views").add_figures(&view.view_figures());
    if view.is_alike() {
        body.add_paragraph("The two solutions differ at most by rounding: there is no difference to draw.");
    }
    body.add_remark(view.describe_views());
    body.add_heading("Conditions of the verdict")
        .add_table(condition_table(c));
    body.add_heading("Differences")
        .add_paragraph("Reflected radiosity B − E per texel, area-weighted; the worst channel counts.")
        .add_table(difference_table(c));
    add_visibility(&mut body, c, view);
    if c.error_target.is_some() {
        add_links_and_causes(&mut body, c, view);
    }
    body.add_heading("Shaders against their twins");
    body.add_paragraph(
        "Each shader and its counterpart in plain Rust get the same input. One ulp is a unit in the last place of a \
         32-bit float.",
    );
    body.add_table(shader_table(c));
    body.add_heading("Energy balance");
    add_energy_balances(&mut body, &[("CPU", &c.cpu_energy), ("GPU", &c.gpu_energy)]);
    if c.error_target.is_none() {
        body.add_heading("Convergence").add_figure(&convergence_figure(c));
    }
    body.add_heading("All textures").add_figures(&view.atlas_figures());
    body.add_heading("Settings in force").add_table(settings_table(c));
    let title = pass_mark(c.solvers_agree()) + " " + file_name(&c.scene.name);
    let title = match c.preset {
        Preset::Requested => title,
        preset => title + ", " + preset.name(),
    };
    body.into_section(id, title)
}

/// Adds the verdict with the failed conditions.
fn add_verdict(body: &mut Blocks, c: &Comparison) {
    let failed: Vec<&str> = c.criteria.iter().filter(|g| !g.pass).map(|g| g.name.as_str()).collect();
    let all = c.criteria.len();
    if c.solvers_agree() {
        body.add_verdict(VerdictTone::Good, "Agree", format!("all {all} conditions hold"));
    } else if all == 0 {
        body.add_verdict(VerdictTone::Bad, "Not compared", "there are no conditions");
    } else {
        let fail = format!("{} of {all} conditions fail: {}", failed.len(), failed.join(", "));
        body.add_verdict(VerdictTone::Bad, "Disagree", fail);
    }
}

/// Adds the errors of both solutions and the findings about the method.
fn add_accuracy(body: &mut Blocks, c: &Comparison) {
    if let Some(asked) = c.error_target {
        let [cpu, gpu] = format_errors([0, 1].map(|side| c.estimated_error(side)));
        let requested = format!(
            "Requested error: at most {}. Estimated error: ",
            format_percent(asked.error)
        );
        body.add_paragraph(
            plain_text(requested)
                + styled_text("cpu", cpu)
                + " on the CPU, "
                + styled_text("gpu", gpu)
                + " on the GPU.",
        );
    }
    let [cpu, gpu] = format_errors(c.truth_error);
    body.add_paragraph(match &c.truth {
        Some(truth) => {
            let against = format!(
                " off on the GPU (relative RMS of reflected radiosity, against {}, itself off by less than {}).",
                truth.name,
                format_percent(truth.own_error)
            );
            plain_text("The solutions are ")
                + styled_text("cpu", cpu)
                + " off on the CPU and "
                + styled_text("gpu", gpu)
                + against
        }
        None => {
            plain_text("The error of the solutions is not known: the scene has too many faces for a reference ")
                + "solution in a few seconds. "
                + code_text("chart")
                + " computes one."
        }
    });
    body.add_notes(c.findings.iter().map(|finding| {
        let size = format_percent(finding.value);
        bold_text(format!("{}: {size}. ", finding.name)) + format!("{}.", finding.message)
    }));
}

fn condition_table(c: &Comparison) -> Table {
    let rows = c.criteria.iter().map(|gate| {
        let cells = [
            pass_mark(gate.pass),
            plain_text(&gate.name),
            plain_text(format_number(gate.value)),
            plain_text(format_number(gate.bound)),
            plain_text(&gate.reason),
        ];
        Row::new(cells).with_class_if(!gate.pass, "bad")
    });
    Table::new(&["", "Gate", "#Measured", "#At most", "~Reason for the bound"], rows)
}

fn difference_table(c: &Comparison) -> Table {
    let same = match c.error_target {
        Some(_) => "Same decisions (lockstep)",
        None => "Same shooters (lockstep)",
    };
    let rows = [
        (same, &c.lockstep_difference),
        ("Each on its own (free)", &c.free_difference),
    ];
    let rows = rows.map(|(name, d)| {
        let values = [d.relative_rms, d.max_relative, d.bias].map(format_percent);
        Row::new([name.to_owned()].into_iter().chain(values))
    });
    Table::new(&["GPU against CPU", "#Relative RMS", "#Largest ÷ rms", "#Bias"], rows)
}

/// Adds the comparison of item buffer with ray visibility; nothing without shots.
fn add_visibility(body: &mut Blocks, c: &Comparison, view: &ComparisonView) {
    let Some(figures) = view.item_buffer_figures() else {
        return;
    };
    body.add_heading("Visibility: item buffer against rays").add_paragraph(
        "The visibility of every pair of shooter and texel is computed by both. Where they differ, the texel's \
         projection must lie next to a boundary between two faces in the item buffer; a mismatch elsewhere is a bug.",
    );
    let pairs = &c.pairs;
    let [all, facing, these] = [
        (pairs.pairs, "of all"),
        (pairs.facing, "of facing"),
        (pairs.mismatched, "of these"),
    ];
    let counts = [
        ("Pairs (shooter, texel)", pairs.pairs, all),
        ("Pairs of points facing each other", pairs.facing, all),
        ("Near a silhouette: pixels may be wrong", pairs.explainable, facing),
        ("Rays and item buffer disagree", pairs.mismatched, facing),
        ("– explained: near an ID boundary", pairs.explained, these),
        ("\u{2003}of these, texels narrower than a pixel", pairs.vanished, these),
        ("– unexplained", pairs.unexplained, these),
    ];
    let counts = counts.map(|(name, n, (whole, of))| {
        let share = match whole {
            0 => "–".to_owned(),
            whole => format_percent(n as f64 / whole as f64),
        };
        let is_bad = name == "– unexplained" && n > 0;
        Row::new([name.to_owned(), format_count(n), format!("{share} {of}")]).with_class_if(is_bad, "bad")
    });
    let weighted = [
        ("Disagreement weighted by form factor × area", pairs.weighted_mismatch),
        (
            "Upper bound of the disagreement by silhouettes, weighted likewise",
            pairs.weighted_explainable,
        ),
    ];
    let weighted = weighted.map(|(name, share)| Row::new([name, &format_percent(share), "of facing"]));
    body.add_table(Table::new(
        &["", "#Count", "#Share"],
        counts.into_iter().chain(weighted),
    ));
    if !pairs.examples.is_empty() {
        let mut list = Blocks::default();
        list.add_list(
            pairs
                .examples
                .iter()
                .map(|(patch, texel)| describe_pair(c, *patch, *texel)),
        );
        body.add_details("Unexplained pairs", true, list);
    }
    body.add_figures(&figures)
        .add_figure(&mismatch_figure(&pairs.histogram));
}

/// Describes a pair of patch and texel.
fn describe_pair(c: &Comparison, patch: u32, texel: u32) -> String {
    let face = |face: u32| {
        let name = c.scene.faces.get(face as usize).map_or("?", |face| &face.name);
        format!("face {face} “{name}”")
    };
    let shooter = c
        .mesh
        .patches
        .get(patch as usize)
        .map_or("?".into(), |patch| face(patch.face));
    let receiver = c.mesh.texels.get(texel as usize);
    let receiver = receiver.map_or(String::new(), |texel| {
        format!(" ({} of {})", texel.index, face(texel.face))
    });
    format!("patch {patch} on {shooter} → texel {texel}{receiver}")
}

/// Adds the comparison of links and the attribution of the remaining error, for adaptive solves.
fn add_links_and_causes(body: &mut Blocks, c: &Comparison, view: &ComparisonView) {
    body.add_heading("Links: the GPU's against the CPU's").add_paragraph(
        "Both compute the same links, block by block: the irradiance over them, and stored links themselves. Where \
         rounding decides whether a node is subdivided or a ray passes an edge, the two may differ, and the solutions \
         then differ by at most the requested error.",
    );
    let pairs = &c.pairs;
    let rows = [
        ("Links, and irradiance of a texel or node", pairs.pairs),
        ("In blocks of 16 texels or nodes", pairs.facing),
        ("Blocks that differ by more than rounding", pairs.mismatched),
        ("– explained: comparisons decided by rounding", pairs.explained),
        ("– unexplained", pairs.unexplained),
    ];
    let rows = rows.map(|(name, n)| {
        let is_bad = name == "– unexplained" && n > 0;
        Row::new([name, &format_count(n)]).with_class_if(is_bad, "bad")
    });
    body.add_table(Table::new(&["", "#Count"], rows));
    body.add_heading("Remaining error by cause").add_paragraph(
        "The difference between the last two of successive solves. A sample of texels is gathered again, each time \
         with one threshold lowered, to attribute the error to its causes. Squares add up.",
    );
    body.add_table(cause_table(c))
        .add_figures(view.error_figure().as_slice());
}

/// Returns each solver's error estimate by cause.
fn cause_table(c: &Comparison) -> Table {
    let mut causes = Vec::new();
    for part in c.estimates.iter().flatten().flat_map(|estimate| &estimate.parts) {
        if !causes.contains(&part.cause) {
            causes.push(part.cause);
        }
    }
    let rows = causes.into_iter().map(|cause| {
        let errors = c.estimates.each_ref().map(|estimate| {
            let mut parts = estimate.iter().flat_map(|estimate| &estimate.parts);
            parts.find(|part| part.cause == cause).map(|part| part.error)
        });
        let [cpu, gpu] = format_errors(errors);
        Row::new([cause.name(), &cpu, &gpu, cause.describe_cause()])
    });
    let [cpu, gpu] = format_errors(
        c.estimates
            .each_ref()
            .map(|estimate| estimate.as_ref().map(|whole| whole.error)),
    );
    let total = Row::new(["all", &cpu, &gpu, ""]);
    Table::new(&["Cause", "#CPU", "#GPU", "~Meaning"], rows.chain([total]))
}

/// Returns the comparison of shaders with their Rust twins.
fn shader_table(c: &Comparison) -> Table {
    let rows = c.stages.iter().map(|stage| {
        let cells = [
            pass_mark(stage.agree),
            code_text(&stage.name),
            plain_text(format_count(stage.values)),
            plain_text(format_count(stage.differing)),
            plain_text(format_number(stage.worst)),
            plain_text(format_number(stage.bound)),
            plain_text(&stage.reason),
        ];
        Row::new(cells).with_class_if(!stage.agree, "bad")
    });
    let heads = [
        "",
        "Shader",
        "#Values",
        "#Differing",
        "#Largest",
        "#At most",
        "~Reason for the bound",
    ];
    Table::new(&heads, rows)
}

/// Returns the options in force and the run statistics.
fn settings_table(c: &Comparison) -> Table {
    let [cpu, gpu] = [&c.settings, &c.gpu_settings].map(|s| settings_in_force(c, s));
    let text = |value: &Value| match value {
        Value::String(text) => text.clone(),
        Value::Null => "–".into(),
        other => other.to_string(),
    };
    let options = cpu.as_object().into_iter().flatten();
    let options = options.map(|(name, value)| [name.clone(), text(value), text(&gpu[name])]);
    let of_runs = |name: &str, values: [String; 2]| {
        let [cpu, gpu] = values;
        [name.to_owned(), cpu, gpu]
    };
    let shots = c.error_target.is_none().then(|| {
        let shots = [&c.cpu, &c.gpu].map(|run| {
            let stopped = if run.converged { "" } else { " (stopped)" };
            format!("{}{stopped}", format_count(run.shots.len() as u64))
        });
        of_runs("shots, free run", shots)
    });
    let unshot = [&c.cpu, &c.gpu].map(|run| format_percent(run.unshot_fraction()));
    let runs = [
        of_runs("adapter", ["–".into(), c.adapter.clone()]),
        of_runs("time, free run", c.seconds.map(format_duration)),
        of_runs("unshot ÷ emitted", unshot),
    ];
    Table::new(
        &["Option", "CPU", "GPU"],
        options.chain(runs).chain(shots).map(Row::new),
    )
}

/// Adds the explanation of the comparison.
fn add_explanation(body: &mut Blocks) {
    let step = |name: &str, says: &str| -> Text { bold_text(format!("{name}: ")) + says };
    body.add_paragraph(
        plain_text("Each scene is solved twice. On the ")
            + styled_text("cpu", "CPU")
            + " rays determine the visibility between shooter and texel. On the "
            + styled_text("gpu", "GPU")
            + " the scene is drawn from the shooter, each face in its own colour (the item buffer), and a texel is \
               visible if the pixel that it falls on has its face's colour. All other steps are the same.",
    );
    body.add_paragraph(
        plain_text(
            "A comparison of these two alone could not distinguish a bug from the item buffer's finite pixels. ",
        ) + "A third solver is therefore compared with both: the "
            + bold_text("twin")
            + ", the shaders' algorithm in plain Rust.",
    );
    body.add_list([
        step(
            "Shaders ↔ twin",
            "the same steps on the same input. Only rounding may differ; it is measured in units in the last place.",
        ),
        step(
            "Twin ↔ rays",
            "the same except for visibility. Only sampling may differ: a mismatch away from a boundary between two \
             faces in the item buffer is a bug.",
        ),
        step(
            "Lockstep",
            "the CPU's sequence of shooters is repeated on the GPU, so that rounding cannot change the sequence.",
        ),
        step("Free", "each solver chooses its own shooters, as in normal use."),
    ]);
    body.add_paragraph(
        "Solves to an error use hierarchical radiosity instead of shooting: texels and nodes of a tree are linked by \
         the same criteria on both processors. The GPU's links are compared with those that the CPU finds by rays, for \
         each block of sixteen texels. The GPU's solution is compared twice: with a CPU solve that repeats its \
         decisions (lockstep), and with an independent CPU solve by shafts and clusters (free), from which it may \
         differ by the estimated errors.",
    );
    body.add_paragraph(
        "The solvers agree on a scene if every condition in its table holds; each bound is given with its reason. A \
         broken condition means a fault in the code. Limits of the method, such as details smaller than a pixel, are \
         reported separately as findings, with their size and what to change.",
    );
    body.add_paragraph(
        bold_text("Agreement is not accuracy: ")
            + "two solvers of one method agree, however crude it is. The error of each solution is therefore given \
               beside the verdict, against the dense matrix of all texels with independent form factors and \
               visibility. By default two presets are compared: the default of "
            + code_text("solve")
            + ", and the paper's method (each face one shooter, disc form factors, one sample, an item buffer), which \
               is fast and has errors of tens of per cent.",
    );
}
