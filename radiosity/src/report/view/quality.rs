//! Measures the interpolation of irradiance H: how far its mean over each texel is from the texel's value, and its
//! largest step across the borders of coplanar faces.

use crate::report::view::interpolation::InterpolatedField;
use crate::report::view::weld::position_on_edge;
use glam::DVec3;
use serde::Serialize;

/// Samples per texel along a common border.
const SAMPLES_PER_TEXEL: u32 = 8;

/// Errors of interpolated irradiance.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct InterpolationQuality {
    /// √(ΣA(mean of the interpolation − H)² / ΣA H²), maximum over channels.
    pub relative_rms: f64,
    /// Largest step across a border of coplanar faces, any channel, over rms(H) of all channels.
    pub max_step: f64,
    /// Number of border points sampled.
    pub border_samples: u64,
}

impl InterpolationQuality {
    /// Measures interpolated irradiance.
    pub fn new(field: &InterpolatedField) -> Self {
        let (step, border_samples) = largest_step(field);
        let rms = irradiance_rms(field);
        Self {
            relative_rms: relative_rms(field),
            max_step: if step == 0.0 { 0.0 } else { step / rms },
            border_samples,
        }
    }
}

/// Returns the relative RMS of the interpolation's texel means, maximum over channels.
fn relative_rms(field: &InterpolatedField) -> f64 {
    let (mut error, mut square) = (DVec3::ZERO, DVec3::ZERO);
    for (k, texel) in field.surface.mesh.texels.iter().enumerate() {
        let (area, own) = (f64::from(texel.area), field.texel_value(k as u32));
        error += (field.texel_mean(k as u32) - own).powf(2.0) * area;
        square += own * own * area;
    }
    let ratio = |c: usize| {
        if error[c] == 0.0 {
            0.0
        } else {
            (error[c] / square[c]).sqrt()
        }
    };
    nan_max((0..3).map(ratio))
}

/// Returns √(ΣA H² / ΣA) over all channels.
fn irradiance_rms(field: &InterpolatedField) -> f64 {
    let (mut square, mut total) = (0.0, 0.0);
    for (k, texel) in field.surface.mesh.texels.iter().enumerate() {
        let area = f64::from(texel.area);
        square += field.texel_value(k as u32).length_squared() * area;
        total += 3.0 * area;
    }
    (square / total).sqrt()
}

/// Returns the largest step across common borders and the number of samples. Both faces are evaluated at points
/// on the edges of either, whether or not their edges were joined.
fn largest_step(field: &InterpolatedField) -> (f64, u64) {
    let mut largest = 0.0;
    let mut samples = 0;
    for &(a, b) in &field.surface.pairs {
        for (a, b) in [(a, b), (b, a)] {
            for point in shared_points(field, a, b) {
                let step = (field.value_at(a, point) - field.value_at(b, point)).abs();
                largest = nan_max([largest].into_iter().chain(step.to_array()));
                samples += 1;
            }
        }
    }
    (largest, samples)
}

/// Returns sample points on the edges of face `a` that lie on edges of face `b`.
fn shared_points(field: &InterpolatedField, a: u32, b: u32) -> Vec<DVec3> {
    let grids = &field.surface.face_grids;
    let (from, to) = (&grids[a as usize], &grids[b as usize]);
    let mut points = Vec::new();
    for k in 0..from.edge_count() {
        let [start, end] = from.edge_ends(k);
        let count = SAMPLES_PER_TEXEL * from.size[k % 2];
        for i in 0..count {
            let point = start.lerp(end, (f64::from(i) + 0.5) / f64::from(count));
            if (0..to.edge_count()).any(|k| position_on_edge(to, k, point).is_some()) {
                points.push(point);
            }
        }
    }
    points
}

/// Returns the maximum; NaN if any value is NaN.
fn nan_max(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) })
}
