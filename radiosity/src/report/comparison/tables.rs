//! Renders the tables of one scene's comparison.

use super::json::settings_in_force;
use crate::report::format::{format_count, format_duration, format_number, format_percent};
use crate::report::page;
use crate::report::table::{TableCell, TableRow, number_cell, render_table, text_cell};
use common::energy::EnergyBalance;
use maud::{Markup, html};
use oracle::compare::comparison::{Comparison, Criterion, StageCheck, VisibilityStatistics};
use oracle::solve::regather::{ErrorCause, ErrorEstimate};
use serde_json::Value;

/// Row that must be 0.
const UNEXPLAINED_ROW: &str = "– unexplained";

/// Renders ✓ or ✗.
pub fn render_gate_mark(pass: bool) -> Markup {
    page::render_mark(pass, ["holds", "does not hold"], "✗")
}

/// Renders the conditions of the verdict.
pub fn gate_table(gates: &[Criterion]) -> Markup {
    let row = |gate: &Criterion| {
        let cells = [
            text_cell(render_gate_mark(gate.pass)),
            text_cell(&gate.name),
            number_cell(format_number(gate.value)),
            number_cell(format_number(gate.bound)),
            text_cell(&gate.reason).with_class("reason"),
        ];
        TableRow::new(cells).with_class_if(!gate.pass, "bad")
    };
    render_table(
        "",
        &["", "Gate", "#Measured", "#At most", "Reason for the bound"],
        gates.iter().map(row),
    )
}

/// Renders each solver's error estimate by cause.
pub fn cause_table(estimates: &[Option<ErrorEstimate>; 2]) -> Markup {
    let all: Vec<ErrorCause> = (estimates.iter().flatten())
        .flat_map(|estimate| estimate.parts.iter().map(|part| part.cause))
        .fold(Vec::new(), |mut all, cause| {
            if !all.contains(&cause) {
                all.push(cause);
            }
            all
        });
    let part = |side: usize, cause: ErrorCause| -> String {
        let mut parts = estimates[side].iter().flat_map(|estimate| &estimate.parts);
        let own = parts.find(|part| part.cause == cause);
        own.map_or("–".into(), |part| format_percent(part.error))
    };
    let whole = |side: usize| -> String {
        let own = estimates[side].as_ref().map(|estimate| estimate.error);
        own.map_or("–".into(), format_percent)
    };
    let row = |name: &str, parts: [String; 2], meaning: TableCell| {
        let [cpu, gpu] = parts.map(number_cell);
        TableRow::new([text_cell(name), cpu, gpu, meaning])
    };
    let causes = all.into_iter().map(|cause| {
        let meaning = text_cell(cause.describe_cause()).with_class("reason");
        row(cause.name(), [0, 1].map(|side| part(side, cause)), meaning)
    });
    let total = row("all", [0, 1].map(whole), text_cell(""));
    render_table("", &["Cause", "#CPU", "#GPU", "Meaning"], causes.chain([total]))
}

/// Renders the comparison of shaders with their Rust twins.
pub fn stage_table(stages: &[StageCheck]) -> Markup {
    let row = |stage: &StageCheck| {
        let cells = [
            text_cell(render_gate_mark(stage.agree)),
            text_cell(html! { code { (stage.name) } }),
            number_cell(format_count(stage.values)),
            number_cell(format_count(stage.differing)),
            number_cell(format_number(stage.worst)),
            number_cell(format_number(stage.bound)),
            text_cell(&stage.reason).with_class("reason"),
        ];
        TableRow::new(cells).with_class_if(!stage.agree, "bad")
    };
    let heads = [
        "",
        "Shader",
        "#Values",
        "#Differing",
        "#Largest",
        "#At most",
        "Reason for the bound",
    ];
    render_table("", &heads, stages.iter().map(row))
}

/// Renders the comparison of item buffer with ray visibility.
pub fn visibility_table(pairs: &VisibilityStatistics) -> Markup {
    let share = |part: u64, whole: u64| {
        if whole > 0 {
            format_percent(part as f64 / whole as f64)
        } else {
            "–".into()
        }
    };
    let [all, facing, these] = [
        (pairs.pairs, "of all"),
        (pairs.facing, "of facing"),
        (pairs.mismatched, "of these"),
    ];
    let rows = [
        ("Pairs (shooter, texel)", pairs.pairs, all),
        ("Pairs of points facing each other", pairs.facing, all),
        ("Near a silhouette: pixels may be wrong", pairs.explainable, facing),
        ("Rays and item buffer disagree", pairs.mismatched, facing),
        ("– explained: near an ID boundary", pairs.explained, these),
        ("\u{2003}of these, texels narrower than a pixel", pairs.vanished, these),
        (UNEXPLAINED_ROW, pairs.unexplained, these),
    ];
    let weighted = [
        ("Disagreement weighted by form factor × area", pairs.weighted_mismatch),
        (
            "Upper bound of the disagreement by silhouettes, weighted likewise",
            pairs.weighted_explainable,
        ),
    ];
    let rows = rows.map(|(name, n, (whole, of))| {
        let share = html! { (share(n, whole)) " " (of) };
        let cells = [text_cell(name), number_cell(format_count(n)), number_cell(share)];
        TableRow::new(cells).with_class_if(name == UNEXPLAINED_ROW && n > 0, "bad")
    });
    let weighted = weighted.map(|(name, share)| {
        TableRow::new([
            text_cell(name),
            number_cell(format_percent(share)),
            number_cell("of facing"),
        ])
    });
    render_table("", &[], rows.into_iter().chain(weighted))
}

/// Renders the comparison of CPU with GPU links by block.
pub fn link_table(pairs: &VisibilityStatistics) -> Markup {
    let rows = [
        ("Links, and irradiance of a texel or node", pairs.pairs, false),
        ("In blocks of 16 texels or nodes", pairs.facing, false),
        ("Blocks that differ by more than rounding", pairs.mismatched, false),
        ("– explained: comparisons decided by rounding", pairs.explained, false),
        (UNEXPLAINED_ROW, pairs.unexplained, pairs.unexplained > 0),
    ];
    let rows = rows
        .map(|(name, n, bad)| TableRow::new([text_cell(name), number_cell(format_count(n))]).with_class_if(bad, "bad"));
    render_table("", &[], rows)
}

/// Renders up to a dozen unexplained pairs.
pub fn list_examples(c: &Comparison) -> Markup {
    let face = |face: u32| {
        let name = c.scene.faces.get(face as usize).map_or("?", |face| &face.name);
        format!("face {face} “{name}”")
    };
    html! {
        @if !c.pairs.examples.is_empty() {
            details open {
                summary { "Unexplained pairs" }
                ul { @for &(patch, texel) in &c.pairs.examples {
                    @let shooter = c.mesh.patches.get(patch as usize).map(|patch| patch.face);
                    @let receiver = c.mesh.texels.get(texel as usize);
                    li {
                        "patch " (patch) " on " (shooter.map_or("?".into(), face)) " → texel " (texel)
                        @if let Some(receiver) = receiver {
                            " (" (receiver.index) " of " (face(receiver.face)) ")"
                        }
                    }
                } }
            }
        }
    }
}

/// Renders lockstep and free differences.
pub fn difference_table(c: &Comparison) -> Markup {
    let same = match c.error_target {
        Some(_) => "Same decisions (lockstep)",
        None => "Same shooters (lockstep)",
    };
    let rows = [
        (same, &c.lockstep_difference),
        ("Each on its own (free)", &c.free_difference),
    ];
    let rows = rows.map(|(name, d)| {
        let values = [d.relative_rms, d.max_relative, d.bias];
        let values = values.map(|value| number_cell(format_percent(value)));
        TableRow::new([text_cell(name)].into_iter().chain(values))
    });
    render_table(
        "",
        &["GPU against CPU", "#Relative RMS", "#Largest ÷ rms", "#Bias"],
        rows,
    )
}

/// Renders the energy balances (name, balance) as shares of emitted power, which are independent of the file's unit
/// of length. A single balance may have an empty name.
pub fn energy_table(whose: &[(&str, &EnergyBalance)]) -> Markup {
    let parts = |e: &EnergyBalance| [e.absorbed, e.unshot, e.escaped, e.closure];
    let names = ["Absorbed", "Unshot", "Escaped", "Closure error"];
    let channels = ["R", "G", "B", "all"];
    let of_whom = whose.iter().flat_map(|(name, _)| {
        channels.map(|channel| match name.is_empty() {
            true => format!("#{channel}"),
            false => format!("#{name}|{channel}"),
        })
    });
    let heads: Vec<String> = ["Of what was emitted".to_owned()].into_iter().chain(of_whom).collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let share = |part: f64, whole: f64| match whole == 0.0 {
        true => "–".into(),
        false => format_percent(part / whole),
    };
    let part_row = |(k, name): (usize, &str)| {
        let values = whose.iter().flat_map(|(_, e)| {
            let channels = (0..3).map(|c| share(parts(e)[k][c], e.emitted[c]));
            channels
                .chain([format_percent(e.share_of_emitted(parts(e)[k]))])
                .collect::<Vec<String>>()
        });
        TableRow::new([text_cell(name)].into_iter().chain(values.map(number_cell)))
    };
    let imbalances = whose
        .iter()
        .map(|(_, e)| number_cell(format_percent(e.imbalance)).with_column_span(4));
    let imbalance_row = TableRow::new([text_cell("Imbalance")].into_iter().chain(imbalances));
    let rows = names.into_iter().enumerate().map(part_row).chain([imbalance_row]);
    html! {
        @if let Some((_, e)) = whose.first() { (render_emitted_power(e)) }
        (render_table("", &heads, rows))
        p.small {
            b { "Absorbed" } " by surfaces; " b { "unshot" } " at the end of the solve; " b { "escaped" }
            " from the scene or behind a face; " b { "closure error" } " of the form factors, whose sums are not 1; "
            b { "imbalance" } ": the unexplained rest."
        }
    }
}

/// Emitted power in W above which the scene's unit is unlikely to be the metre.
const MAX_METRE_POWER: f64 = 1e4;

/// Renders the emitted power under the likely unit of length, which files do not state.
fn render_emitted_power(e: &EnergyBalance) -> Markup {
    let watts = |unit: f64| {
        let [r, g, b] = e.emitted.map(|power| format_number(power * unit * unit));
        format!("R {r}, G {g}, B {b} W")
    };
    html! {
        p {
            @if e.emitted.iter().sum::<f64>() > MAX_METRE_POWER {
                "Emitted: " b { (watts(1e-3)) } " if the file’s unit of length is the millimetre; " (watts(1.0))
                " if it is the metre."
            } @else { "Emitted: " b { (watts(1.0)) } " if the file’s unit of length is the metre." }
        }
    }
}

/// Destinations of emitted power.
const ENERGY_PARTS: [&str; 4] = ["absorbed", "unshot", "escaped", "closure"];

/// Renders both energy balances as bars; negative parts are omitted.
pub fn energy_bars(cpu: &EnergyBalance, gpu: &EnergyBalance) -> Markup {
    html! {
        @for (name, e) in [("CPU", cpu), ("GPU", gpu)] {
            @let parts = ENERGY_PARTS.into_iter().zip([e.absorbed, e.unshot, e.escaped, e.closure]);
            div.energy {
                span.who { (name) }
                div.bar { @for (part, power) in parts {
                    @let share = e.share_of_emitted(power);
                    @if share > 0.0 {
                        @let text = format!("{part} {}", format_percent(share));
                        span class=(part) style=(format!("flex-grow:{share:.5}")) title=(text) {
                            @if share > 0.12 { (text) }
                        }
                    }
                } }
            }
        }
        p.energy.small {
            @for part in ENERGY_PARTS { span.key { span class=(part) {} (part) } }
        }
    }
}

/// Renders the options in force and the run statistics.
pub fn settings_table(c: &Comparison) -> Markup {
    let [cpu, gpu] = [&c.settings, &c.gpu_settings].map(|s| settings_in_force(c, s));
    let names: Vec<String> = cpu.as_object().map(|o| o.keys().cloned().collect()).unwrap_or_default();
    let runs = [&c.cpu, &c.gpu];
    let text = |value: &Value| match value {
        Value::String(text) => text.clone(),
        Value::Null => "–".into(),
        other => other.to_string(),
    };
    html! {
        div.scroll { table {
            thead { tr { th { "Option" } th.cpu { "CPU" } th.gpu { "GPU" } } }
            tbody {
                @for name in &names {
                    tr { td { (name) } td { (text(&cpu[name])) } td { (text(&gpu[name])) } }
                }
                tr { td { "adapter" } td { "–" } td { (c.adapter) } }
                tr { td { "time, free run" } @for s in c.seconds { td { (format_duration(s)) } } }
                @if c.error_target.is_none() { tr { td { "shots, free run" } @for run in runs {
                    td { (format_count(run.shots.len() as u64)) @if !run.converged { " (stopped)" } }
                } } }
                tr { td { "unshot ÷ emitted" } @for run in runs {
                    td { (format_percent(run.unshot_fraction())) }
                } }
            }
        } }
    }
}
