//! Content of `chart.json`.

use super::points::{ChartPoint, SceneChart};
use super::store::Measurement;
use serde_json::{Value, json};

/// Returns all points of all scenes. A failed point has a null error and its reason.
pub fn chart_json(charts: &[SceneChart]) -> Value {
    let points = charts
        .iter()
        .flat_map(|chart| chart.points.iter().map(|point| point_json(chart, point)));
    json!({
        "points": points.collect::<Vec<_>>(),
        "scenes": charts.iter().map(scene_json).collect::<Vec<_>>(),
    })
}

fn scene_json(chart: &SceneChart) -> Value {
    json!({
        "scene": chart.scene,
        "faces": chart.faces,
        "texels": chart.texels,
        "truth": chart.truth,
        "adapter": chart.adapter,
        "not_measured": chart.missing,
        "curves": chart.curves,
        "peers": chart.peers,
    })
}

fn point_json(chart: &SceneChart, point: &ChartPoint) -> Value {
    let [seconds, min, max] = point.median_and_range(Measurement::total_seconds);
    let figures = point.first_result().ok();
    let method = &point.method;
    json!({
        "scene": chart.scene,
        "solver": method.solver,
        "options": method.options,
        "settings": method.settings,
        "target_error": method.target_error,
        "curve": method.varied.map(|(curve, _)| &chart.curves[curve].label),
        "value": method.varied.map(|(_, value)| value),
        "seconds": seconds,
        "spread": { "min": min, "max": max },
        "runs": point.runs.len(),
        "prepare_seconds": point.median_and_range(|run| run.prepare)[0],
        "solve_seconds": point.median_and_range(|run| run.solve)[0],
        "error": figures.map(|f| f.error),
        "bias": figures.map(|f| f.bias),
        "imbalance": figures.map(|f| f.imbalance),
        "shots": figures.map(|f| f.shots),
        "passes": figures.map(|f| f.passes),
        "on_front": point.on_front,
        "failure": point.first_result().err(),
    })
}
