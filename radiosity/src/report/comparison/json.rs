//! Builds `report.json`: the contract's fields and further ones for scripts.

use common::settings::Settings;
use gpu::ShaderStage;
use oracle::compare::comparison::{Comparison, SceneComparison, StageCheck};
use oracle::solve::solver::ErrorTarget;
use serde_json::{Value, json};

/// Converts all scenes, in the given order; NaN becomes null.
pub fn report_json(judged: &[SceneComparison]) -> Value {
    json!({ "scenes": judged.iter().map(scene_json).collect::<Vec<_>>() })
}

/// Converts a scene: the fields of its first comparison, the verdict on all, and the comparison of `solve`'s default.
fn scene_json(judged: &SceneComparison) -> Value {
    let mut value = comparison_json(&judged.first);
    value["agree"] = json!(judged.all_agree());
    if let Some(as_solved) = &judged.solve_default {
        value["as_solved"] = comparison_json(as_solved);
    }
    value
}

fn comparison_json(c: &Comparison) -> Value {
    json!({
        "scene": c.scene.name,
        "way": c.preset,
        "agree": c.solvers_agree(),
        "shots": { "cpu": c.cpu.shooters, "gpu": c.gpu.shooters },
        "passes": { "cpu": c.cpu.passes, "gpu": c.gpu.passes },
        "converged": { "cpu": c.cpu.converged, "gpu": c.gpu.converged },
        "unshot_fraction": { "cpu": c.cpu.unshot_fraction(), "gpu": c.gpu.unshot_fraction() },
        "radiosity": c.lockstep_difference,
        "free": c.free_difference,
        "error": { "cpu": c.truth_error[0], "gpu": c.truth_error[1] },
        "truth": c.truth,
        "visibility": c.pairs,
        "energy": { "cpu": c.cpu_energy, "gpu": c.gpu_energy },
        "bounds": c.criteria.iter().map(|criterion| (&criterion.name, json!(criterion))).collect::<Value>(),
        "gates": c.criteria,
        "findings": c.findings,
        "stages": c.stages.iter().map(|stage| (&stage.name, stage_json(stage))).collect::<Value>(),
        "first_divergence": c.first_divergence,
        "estimated_error": { "cpu": c.estimated_error(0), "gpu": c.estimated_error(1) },
        "certificate": { "cpu": c.estimates[0], "gpu": c.estimates[1] },
        "settings": { "cpu": settings_in_force(c, &c.settings), "gpu": settings_in_force(c, &c.gpu_settings) },
        "adapter": c.adapter,
        "seconds": { "cpu": c.seconds[0], "gpu": c.seconds[1] },
        "faces": c.mesh.faces.len(),
        "cells": c.mesh.patches.len(),
        "texels": c.mesh.texels.len(),
        "notes": c.scene.notes.iter().chain(&c.notes).collect::<Vec<_>>(),
    })
}

/// Returns the check of a stage, with the shader files whose faults it shows.
fn stage_json(stage: &StageCheck) -> Value {
    let mut value = json!(stage);
    value["files"] = json!(ShaderStage::files_judged_by(&stage.name));
    value
}

/// Returns the options in force.
fn settings_in_force(c: &Comparison, shooting: &Settings) -> Value {
    match c.error_target {
        Some(ErrorTarget { error, texels }) => json!({ "error": error, "texels": texels }),
        None => json!(shooting),
    }
}
