//! `converge.json`: every point of every curve, and what was made of them.

use super::{MeasuredCurve, MeasuredSweep, Study};
use serde_json::{Value, json};

/// All scenes, in the order given. NaN becomes null.
pub fn json(studies: &[Study], seconds: f64) -> Value {
    json!({
        "seconds": seconds,
        "scenes": studies.iter().map(|study| json!({
            "scene": study.scene,
            "faces": study.faces,
            "adapter": study.adapter,
            "sweeps": study.sweeps.iter().map(sweep).collect::<Vec<_>>(),
            "item_buffers": study.item_buffers,
        })).collect::<Vec<_>>(),
    })
}

fn sweep(sweep: &MeasuredSweep) -> Value {
    json!({
        "name": sweep.name,
        "option": sweep.option,
        "truth": sweep.truth,
        "base": sweep.base,
        "curves": sweep.curves.iter().map(curve).collect::<Vec<_>>(),
    })
}

fn curve(curve: &MeasuredCurve) -> Value {
    json!({
        "label": curve.label,
        "order": curve.order,
        "order_beside_truth": curve.order_beside,
        "converges": curve.converges,
        "finding": curve.finding,
        "points": curve.points.iter().map(|p| json!({
            "value": p.value,
            "error": p.error,
            "bias": p.bias,
            "seconds": p.seconds,
            "shots": p.shots,
        })).collect::<Vec<_>>(),
    })
}
