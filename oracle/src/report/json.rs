//! `report.json`, as the contract has it, and everything else that scripts may want.

use crate::comparison::{Comparison, Gate};
use crate::view::quality::Quality;
use crate::view::surface::Surface;
use serde_json::{Map, Value, json};

/// All scenes, in the order given. NaN becomes null.
pub fn json(comparisons: &[Comparison]) -> Value {
    json!({ "scenes": comparisons.iter().map(scene).collect::<Vec<_>>() })
}

fn scene(c: &Comparison) -> Value {
    let surface = Surface::new(&c.scene, &c.mesh);
    json!({
        "scene": c.scene.name,
        "agree": c.agree(),
        "shots": { "cpu": c.cpu.shots.len(), "gpu": c.gpu.shots.len() },
        "converged": { "cpu": c.cpu.converged, "gpu": c.gpu.converged },
        "unshot_fraction": { "cpu": c.cpu.unshot_fraction(), "gpu": c.gpu.unshot_fraction() },
        "radiosity": c.lockstep_difference,
        "free": c.free_difference,
        "visibility": c.pairs,
        "energy": { "cpu": c.cpu_energy, "gpu": c.gpu_energy },
        "bounds": bounds(&c.gates),
        "gates": c.gates,
        "stages": c.stages,
        "interpolation": Quality::new(&surface.interpolate(&c.cpu.field.irradiance)),
        "settings": { "cpu": c.settings, "gpu": c.gpu_settings },
        "adapter": c.adapter,
        "seconds": { "cpu": c.seconds[0], "gpu": c.seconds[1] },
        "faces": c.mesh.faces.len(),
        "cells": c.mesh.cells.len(),
        "texels": c.mesh.texels.len(),
        "notes": c.scene.notes,
    })
}

/// The gates by name; `gates` keeps their order.
fn bounds(gates: &[Gate]) -> Map<String, Value> {
    gates
        .iter()
        .map(|gate| (gate.name.clone(), json!(gate)))
        .collect()
}
