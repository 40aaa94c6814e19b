//! `chart.json`.

use super::Measurement;
use super::page::{LEVELS, winner};
use super::study::{Point, Study};
use serde_json::{Value, json};

/// All points of all scenes; what failed has null for its error, and its reason.
pub fn json(studies: &[Study]) -> Value {
    let points = studies.iter().flat_map(|study| {
        let point = |p| point(&study.scene, p);
        study.points.iter().map(point)
    });
    json!({
        "scenes": studies.iter().map(scene).collect::<Vec<_>>(),
        "points": points.collect::<Vec<_>>(),
    })
}

fn scene(study: &Study) -> Value {
    json!({
        "scene": study.scene,
        "faces": study.faces,
        "texels": study.texels,
        "truth": study.truth,
        "adapter": study.adapter,
        "software": study.software,
        "not_measured": study.missing,
        "peers": study.peers,
        "fastest": study.solvers().into_iter().map(|solver| json!({
            "solver": solver,
            "to": LEVELS.map(|level| json!({
                "error": level,
                "options": winner(study, solver, level).map(|p| &p.method.options),
                "seconds": winner(study, solver, level).map(Point::seconds),
            })),
        })).collect::<Vec<_>>(),
    })
}

fn point(scene: &str, point: &Point) -> Value {
    let [seconds, least, most] = point.spread(Measurement::seconds);
    let figures = point.figures();
    let median = |what: fn(&Measurement) -> f64| point.spread(what)[0];
    json!({
        "scene": scene,
        "solver": point.method.solver,
        "sweep": point.method.sweep,
        "options": point.method.options,
        "settings": point.method.settings,
        "seconds": seconds,
        "spread": { "min": least, "max": most },
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
        "failure": point.failure(),
    })
}
