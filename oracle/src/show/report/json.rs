//! `report.json`, as the contract has it, and everything else that scripts may want.

use crate::judge::comparison::{Comparison, Gate, Judged, Stage};
use crate::show::view::quality::Quality;
use crate::show::view::surface::Surface;
use crate::solve::solver::Asked;
use common::settings::Settings;
use serde_json::{Map, Value, json};

/// All scenes, in the order given. NaN becomes null.
pub fn json(judged: &[Judged]) -> Value {
    json!({ "scenes": judged.iter().map(scene).collect::<Vec<_>>() })
}

/// The first way's fields, the verdict on all ways, and what `solve` does in the same fields.
fn scene(judged: &Judged) -> Value {
    let mut value = way(&judged.first);
    value["agree"] = json!(judged.agree());
    if let Some(as_solved) = &judged.as_solved {
        value["as_solved"] = way(as_solved);
    }
    value
}

fn way(c: &Comparison) -> Value {
    let surface = Surface::new(&c.scene, &c.mesh);
    json!({
        "scene": c.scene.name,
        "way": c.way,
        "agree": c.agree(),
        "shots": { "cpu": c.cpu.shooters, "gpu": c.gpu.shooters },
        "passes": { "cpu": c.cpu.passes, "gpu": c.gpu.passes },
        "converged": { "cpu": c.cpu.converged, "gpu": c.gpu.converged },
        "unshot_fraction": { "cpu": c.cpu.unshot_fraction(), "gpu": c.gpu.unshot_fraction() },
        "radiosity": c.lockstep_difference,
        "free": c.free_difference,
        "error": { "cpu": c.error[0], "gpu": c.error[1] },
        "truth": c.truth,
        "visibility": c.pairs,
        "energy": { "cpu": c.cpu_energy, "gpu": c.gpu_energy },
        "bounds": bounds(&c.gates),
        "gates": c.gates,
        "findings": c.findings,
        "stages": stages(&c.stages),
        "interpolation": Quality::new(&surface.interpolate(&c.cpu.field.irradiance)),
        "estimated_error": { "cpu": c.estimated(0), "gpu": c.estimated(1) },
        "certificate": { "cpu": c.estimates[0], "gpu": c.estimates[1] },
        "settings": { "cpu": in_force(c, &c.settings), "gpu": in_force(c, &c.gpu_settings) },
        "adapter": c.adapter,
        "seconds": { "cpu": c.seconds[0], "gpu": c.seconds[1] },
        "faces": c.mesh.faces.len(),
        "cells": c.mesh.cells.len(),
        "texels": c.mesh.texels.len(),
        "notes": c.scene.notes.iter().chain(&c.notes).collect::<Vec<_>>(),
    })
}

/// The options that decide.
pub fn in_force(c: &Comparison, shooting: &Settings) -> Value {
    match c.asked {
        Some(Asked { error, texels }) => json!({ "error": error, "texels": texels }),
        None => json!(shooting),
    }
}

/// The stages by name.
fn stages(stages: &[Stage]) -> Map<String, Value> {
    stages
        .iter()
        .map(|stage| (stage.name.clone(), json!(stage)))
        .collect()
}

/// The gates by name; `gates` keeps their order.
fn bounds(gates: &[Gate]) -> Map<String, Value> {
    gates
        .iter()
        .map(|gate| (gate.name.clone(), json!(gate)))
        .collect()
}
