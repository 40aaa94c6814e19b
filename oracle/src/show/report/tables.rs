//! The tables of one scene's comparison.

use super::json::in_force;
use crate::judge::comparison::{Comparison, Gate, Pairs, Stage};
use crate::show::number::{count, duration, number, percent};
use crate::show::page::{self, table};
use crate::solve::check::{Cause, Estimate};
use common::energy::Energy;
use maud::{Markup, html};
use serde_json::Value;

/// The row that must be 0.
const UNEXPLAINED: &str = "– unexplained";

/// ✓ or ✗, told apart without colour too.
pub fn mark(pass: bool) -> Markup {
    page::mark(pass, ["holds", "does not hold"], "✗")
}

/// The conditions of the verdict.
pub fn gates(gates: &[Gate]) -> Markup {
    html! {
        (table("", &["", "Gate", "#Measured", "#At most", "Where the bound comes from"], html! {
            @for gate in gates {
                tr.bad[!gate.pass] {
                    td { (mark(gate.pass)) }
                    td { (gate.name) }
                    td.n { (number(gate.value)) }
                    td.n { (number(gate.bound)) }
                    td.reason { (gate.reason) }
                }
            }
        }))
    }
}

/// What each side says of its error, by cause.
pub fn causes(estimates: &[Option<Estimate>; 2]) -> Markup {
    let all: Vec<Cause> = (estimates.iter().flatten())
        .flat_map(|estimate| estimate.parts.iter().map(|part| part.cause))
        .fold(Vec::new(), |mut all, cause| {
            if !all.contains(&cause) {
                all.push(cause);
            }
            all
        });
    let part = |side: usize, cause: Cause| -> String {
        let mut parts = estimates[side].iter().flat_map(|estimate| &estimate.parts);
        let own = parts.find(|part| part.cause == cause);
        own.map_or("–".into(), |part| percent(part.error))
    };
    let whole = |side: usize| -> String {
        let own = estimates[side].as_ref().map(|estimate| estimate.error);
        own.map_or("–".into(), percent)
    };
    html! {
        (table("", &["Cause", "#CPU", "#GPU", "What it is"], html! {
            @for cause in all {
                tr {
                    td { (cause.name()) }
                    td.n { (part(0, cause)) }
                    td.n { (part(1, cause)) }
                    td.reason { (cause.meaning()) }
                }
            }
            tr {
                td { "all" }
                td.n { (whole(0)) }
                td.n { (whole(1)) }
                td {}
            }
        }))
    }
}

/// Shaders against their twins.
pub fn stages(stages: &[Stage]) -> Markup {
    html! {
        (table("", &["", "Shader", "#Values", "#Differing", "#Largest", "#At most", "What may differ, and why"], html! {
            @for stage in stages {
                tr.bad[!stage.agree] {
                    td { (mark(stage.agree)) }
                    td { code { (stage.name) } }
                    td.n { (count(stage.values)) }
                    td.n { (count(stage.differing)) }
                    td.n { (number(stage.worst)) }
                    td.n { (number(stage.bound)) }
                    td.reason { (stage.reason) }
                }
            }
        }))
    }
}

/// Item buffer against rays.
pub fn pairs(pairs: &Pairs) -> Markup {
    let share = |part: u64, whole: u64| {
        if whole > 0 {
            percent(part as f64 / whole as f64)
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
        (
            "Near a silhouette: pixels may err",
            pairs.explainable,
            facing,
        ),
        ("Rays and item buffer disagree", pairs.mismatched, facing),
        ("– explained: near an ID boundary", pairs.explained, these),
        (
            "\u{2003}of which texels too thin for a pixel",
            pairs.vanished,
            these,
        ),
        (UNEXPLAINED, pairs.unexplained, these),
    ];
    let weighted = [
        (
            "Disagreement weighted by form factor × area",
            pairs.weighted_mismatch,
        ),
        (
            "What silhouettes could amount to, weighted likewise",
            pairs.weighted_explainable,
        ),
    ];
    table(
        "",
        &[],
        html! {
            @for (name, n, (whole, of)) in rows {
                tr.bad[name == UNEXPLAINED && n > 0] {
                    td { (name) } td.n { (count(n)) } td.n { (share(n, whole)) " " (of) }
                }
            }
            @for (name, share) in weighted { tr { td { (name) } td.n { (percent(share)) } td.n { "of facing" } } }
        },
    )
}

/// Links of the CPU against the GPU's, block by block.
pub fn blocks(pairs: &Pairs) -> Markup {
    let rows = [
        (
            "Links, and light that arrives at a texel or node",
            pairs.pairs,
            false,
        ),
        ("In blocks of 16 texels or nodes", pairs.facing, false),
        (
            "Blocks that differ by more than rounding",
            pairs.mismatched,
            false,
        ),
        (
            "– as many as comparisons may turn that rounding decides",
            pairs.explained,
            false,
        ),
        (UNEXPLAINED, pairs.unexplained, pairs.unexplained > 0),
    ];
    table(
        "",
        &[],
        html! { @for (name, n, bad) in rows { tr.bad[bad] { td { (name) } td.n { (count(n)) } } } },
    )
}

/// Up to a dozen pairs that nothing explains.
pub fn examples(c: &Comparison) -> Markup {
    let face = |face: u32| {
        let name = c
            .scene
            .faces
            .get(face as usize)
            .map_or("?", |face| &face.name);
        format!("face {face} “{name}”")
    };
    html! {
        @if !c.pairs.examples.is_empty() {
            details open {
                summary { "Unexplained pairs" }
                ul { @for &(cell, texel) in &c.pairs.examples {
                    @let shooter = c.mesh.cells.get(cell as usize).map(|cell| cell.face);
                    @let receiver = c.mesh.texels.get(texel as usize);
                    li {
                        "cell " (cell) " on " (shooter.map_or("?".into(), face)) " → texel " (texel)
                        @if let Some(receiver) = receiver {
                            " (" (receiver.index) " of " (face(receiver.face)) ")"
                        }
                    }
                } }
            }
        }
    }
}

/// Lockstep and free differences.
pub fn differences(c: &Comparison) -> Markup {
    let same = match c.asked {
        Some(_) => "Same decisions (lockstep)",
        None => "Same shooters (lockstep)",
    };
    let rows = [
        (same, &c.lockstep_difference),
        ("Each on its own (free)", &c.free_difference),
    ];
    html! {
        (table("", &["GPU against CPU", "#Relative RMS", "#Largest ÷ rms", "#Bias"], html! {
            @for (name, d) in rows {
                tr {
                    td { (name) }
                    td.n { (percent(d.relative_rms)) }
                    td.n { (percent(d.max_relative)) }
                    td.n { (percent(d.bias)) }
                }
            }
        }))
    }
}

/// Where the emitted power went, by whom, in shares: they do not depend on the file's unit of length. One
/// alone needs no name.
pub fn energy(whose: &[(&str, &Energy)]) -> Markup {
    let parts = |e: &Energy| [e.absorbed, e.unshot, e.escaped, e.closure];
    let names = ["Absorbed", "Unshot", "Escaped", "Lost or made up"];
    let channels = ["R", "G", "B", "all"];
    let of_whom = whose.iter().flat_map(|(name, _)| {
        channels.map(|channel| match name.is_empty() {
            true => format!("#{channel}"),
            false => format!("#{name}|{channel}"),
        })
    });
    let heads: Vec<String> = ["Of what was emitted".to_owned()]
        .into_iter()
        .chain(of_whom)
        .collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let share = |part: f64, whole: f64| match whole == 0.0 {
        true => "–".into(),
        false => percent(part / whole),
    };
    html! {
        @if let Some((_, e)) = whose.first() { (emitted(e)) }
        (table("", &heads, html! {
            @for (k, name) in names.into_iter().enumerate() { tr {
                td { (name) }
                @for (_, e) in whose {
                    @for c in 0..3 { td.n { (share(parts(e)[k][c], e.emitted[c])) } }
                    td.n { (percent(e.share(parts(e)[k]))) }
                }
            } }
            tr { td { "Imbalance" } @for (_, e) in whose { td.n colspan="4" { (percent(e.imbalance)) } } }
        }))
        p.small {
            b { "Absorbed" } " by what it met; " b { "unshot" } ": still on its way when the solve ended; " b { "escaped" }
            " into the open or behind a face; " b { "lost or made up" } " by the form factors; " b { "imbalance" }
            ": what these leave unexplained."
        }
    }
}

/// More than this in a scene of metres, and its unit is hardly the metre.
const HARDLY: f64 = 1e4;

/// The emitted power. A file does not say what its unit of length is.
fn emitted(e: &Energy) -> Markup {
    let watts = |unit: f64| {
        let [r, g, b] = e.emitted.map(|power| number(power * unit * unit));
        format!("R {r}, G {g}, B {b} W")
    };
    html! {
        p {
            @if e.emitted.iter().sum::<f64>() > HARDLY {
                "Emitted: " b { (watts(1e-3)) } " if the file’s unit of length is the millimetre; " (watts(1.0))
                " if it is the metre."
            } @else { "Emitted: " b { (watts(1.0)) } " if the file’s unit of length is the metre." }
        }
    }
}

/// Where emitted power can go.
const PARTS: [&str; 4] = ["absorbed", "unshot", "escaped", "closure"];

/// The same as a bar; a part below 0 has no length.
pub fn energy_bars(cpu: &Energy, gpu: &Energy) -> Markup {
    html! {
        @for (name, e) in [("CPU", cpu), ("GPU", gpu)] {
            @let parts = PARTS.into_iter().zip([e.absorbed, e.unshot, e.escaped, e.closure]);
            div.energy {
                span.who { (name) }
                div.bar { @for (part, power) in parts {
                    @let share = e.share(power);
                    @if share > 0.0 {
                        @let text = format!("{part} {}", percent(share));
                        span class=(part) style=(format!("flex-grow:{share:.5}")) title=(text) {
                            @if share > 0.12 { (text) }
                        }
                    }
                } }
            }
        }
        p.energy.small {
            @for part in PARTS { span.key { span class=(part) {} (part) } }
        }
    }
}

/// Every option in force.
pub fn settings(c: &Comparison) -> Markup {
    let [cpu, gpu] = [&c.settings, &c.gpu_settings].map(|s| in_force(c, s));
    let names: Vec<String> = cpu
        .as_object()
        .map(|o| o.keys().cloned().collect())
        .unwrap_or_default();
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
                tr { td { "time, free run" } @for s in c.seconds { td { (duration(s)) } } }
                @if c.asked.is_none() { tr { td { "shots, free run" } @for run in runs {
                    td { (count(run.shots.len() as u64)) @if !run.converged { " (stopped)" } }
                } } }
                tr { td { "unshot ÷ emitted" } @for run in runs {
                    td { (percent(run.unshot_fraction())) }
                } }
            }
        } }
    }
}
