//! Content of `chart.json`.

use super::Measurement;
use super::page::{ERROR_LEVELS, fastest_point};
use super::points::{ChartPoint, SceneChart};
use serde_json::{Value, json};

/// Returns all points of all scenes. A failed point has a null error and its reason.
pub fn chart_json(studies: &[SceneChart]) -> Value {
    let points = studies.iter().flat_map(|study| {
        let point = |p| point_json(&study.scene, p);
        study.points.iter().map(point)
    });
    json!({
        "scenes": studies.iter().map(scene_json).collect::<Vec<_>>(),
        "points": points.collect::<Vec<_>>(),
    })
}

fn scene_json(study: &SceneChart) -> Value {
    json!({
        "scene": study.scene,
        "faces": study.faces,
        "texels": study.texels,
        "truth": study.truth,
        "adapter": study.adapter,
        "software": study.software,
        "not_measured": study.missing,
        "peers": study.peers,
        "fastest": study.measured_solvers().into_iter().map(|solver| json!({
            "solver": solver,
            "to": ERROR_LEVELS.map(|level| json!({
                "error": level,
                "options": fastest_point(study, solver, level).map(|p| &p.method.options),
                "seconds": fastest_point(study, solver, level).map(ChartPoint::median_seconds),
            })),
        })).collect::<Vec<_>>(),
    })
}

fn point_json(scene: &str, point: &ChartPoint) -> Value {
    let [seconds, min, max] = point.median_and_range(Measurement::total_seconds);
    let figures = point.first_figures();
    let median = |what: fn(&Measurement) -> f64| point.median_and_range(what)[0];
    json!({
        "scene": scene,
        "solver": point.method.solver,
        "sweep": point.method.sweep,
        "options": point.method.options,
        "settings": point.method.settings,
        "seconds": seconds,
        "spread": { "min": min, "max": max },
        "runs": point.runs.len(),
        "prepare_seconds": median(|m| m.prepare),
        "solve_seconds": median(|m| m.solve),
        "error": figures.map(|f| f.error),
        "error_own_texels": figures.map(|f| f.own_error),
        "bias": figures.map(|f| f.bias),
        "imbalance": figures.map(|f| f.imbalance),
        "unshot_fraction": figures.map(|f| f.unshot),
        "shots": figures.map(|f| f.shots),
        "passes": figures.map(|f| f.passes),
        "cells_linked": figures.map(|f| f.linked),
        "one_by_one": figures.map(|f| f.one_by_one),
        "rays_at_most": point.rays_at_most,
        "item_buffer_pixels": point.pixels,
        "bytes_by_arithmetic": point.bytes,
        "on_front": point.on_front,
        "on_solver_front": point.on_solver_front,
        "failure": point.first_failure(),
    })
}
