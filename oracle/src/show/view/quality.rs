//! What the interpolation costs: how far its mean is from each texel's value, and the step that
//! is left where coplanar faces meet.

use crate::show::view::surface::Interpolant;
use crate::show::view::weld::on_edge;
use glam::DVec3;
use serde::Serialize;

/// Samples per texel along a shared border.
const SAMPLES: u32 = 8;

/// Errors of an interpolated field.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Quality {
    /// √(ΣA(mean of the interpolation − H)² / ΣA H²), the worst channel.
    pub relative_rms: f64,
    /// Largest step across a border of coplanar faces, any channel, over rms(H).
    pub max_step: f64,
    /// Border points at which a step was looked for.
    pub border_samples: u64,
}

impl Quality {
    /// Measures an interpolation.
    pub fn new(field: &Interpolant) -> Self {
        let (step, border_samples) = step(field);
        let rms = rms(field);
        Self {
            relative_rms: relative_rms(field),
            max_step: if step == 0.0 { 0.0 } else { step / rms },
            border_samples,
        }
    }
}

fn relative_rms(field: &Interpolant) -> f64 {
    let (mut error, mut square) = (DVec3::ZERO, DVec3::ZERO);
    for (k, texel) in field.surface.mesh.texels.iter().enumerate() {
        let (area, own) = (f64::from(texel.area), field.own(k as u32));
        error += (field.mean(k as u32) - own).powf(2.0) * area;
        square += own * own * area;
    }
    let ratio = |c: usize| {
        if error[c] == 0.0 {
            0.0
        } else {
            (error[c] / square[c]).sqrt()
        }
    };
    worst((0..3).map(ratio))
}

/// √(ΣA H² / ΣA) over all channels.
fn rms(field: &Interpolant) -> f64 {
    let (mut square, mut total) = (0.0, 0.0);
    for (k, texel) in field.surface.mesh.texels.iter().enumerate() {
        let area = f64::from(texel.area);
        square += field.own(k as u32).length_squared() * area;
        total += 3.0 * area;
    }
    (square / total).sqrt()
}

/// Independent of how the borders were joined: both faces are asked at points of both.
fn step(field: &Interpolant) -> (f64, u64) {
    let mut largest = 0.0;
    let mut samples = 0;
    for &(a, b) in &field.surface.pairs {
        for (a, b) in [(a, b), (b, a)] {
            for point in shared_points(field, a, b) {
                let step = (field.at(a, point) - field.at(b, point)).abs();
                largest = worst([largest].into_iter().chain(step.to_array()));
                samples += 1;
            }
        }
    }
    (largest, samples)
}

/// Points on the edges of face `a` that lie on edges of face `b`.
fn shared_points(field: &Interpolant, a: u32, b: u32) -> Vec<DVec3> {
    let patches = &field.surface.patches;
    let (from, to) = (&patches[a as usize], &patches[b as usize]);
    let mut points = Vec::new();
    for k in 0..from.edges() {
        let [start, end] = from.edge(k);
        let count = SAMPLES * from.size[k % 2];
        for i in 0..count {
            let point = start.lerp(end, (f64::from(i) + 0.5) / f64::from(count));
            if (0..to.edges()).any(|k| on_edge(to, k, point).is_some()) {
                points.push(point);
            }
        }
    }
    points
}

/// The largest; NaN if one is.
fn worst(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a, b| {
        if a.is_nan() || b.is_nan() {
            f64::NAN
        } else {
            a.max(b)
        }
    })
}
