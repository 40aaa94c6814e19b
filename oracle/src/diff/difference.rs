//! Measures the difference between two radiosity fields. Comparisons, diffs and the failure atlas measure by it.

use common::mesh::Mesh;
use common::shooting::RadiosityField;
use glam::DVec3;
use serde::Serialize;

/// Difference of field a from field b: reflected radiosity B − E, area-weighted; each figure is that of its worst
/// channel.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Difference {
    /// √(ΣA(a−b)² / ΣA b²).
    pub relative_rms: f64,
    /// max|a−b| / rms(b).
    pub max_relative: f64,
    /// ΣA(a−b) / ΣA b, the channel with the largest magnitude.
    pub bias: f64,
}

/// Difference with all figures NaN, which fails every criterion.
pub const NOT_COMPARABLE: Difference = Difference {
    relative_rms: f64::NAN,
    max_relative: f64::NAN,
    bias: f64::NAN,
};

/// Returns the difference of `a` from `b` (the truth); [`NOT_COMPARABLE`] unless both are complete and finite, have
/// texels, and come from two different solves.
pub fn compare_fields(mesh: &Mesh, a: &RadiosityField, b: &RadiosityField) -> Difference {
    let count = mesh.texels.len();
    let complete = |f: &RadiosityField| f.radiosity.len() == count && f.radiosity.iter().all(|v| v.is_finite());
    if count == 0 || a.origin == b.origin || !complete(a) || !complete(b) {
        return NOT_COMPARABLE;
    }
    let texels = (0..count).map(|k| {
        let area = f64::from(mesh.texels[k].area);
        (area, reflected_radiosity(mesh, a, k), reflected_radiosity(mesh, b, k))
    });
    worst_channel(channel_differences(texels))
}

/// B − E of texel `k`.
pub fn reflected_radiosity(mesh: &Mesh, field: &RadiosityField, k: usize) -> DVec3 {
    field.radiosity[k].truncate().as_dvec3() - mesh.texels[k].emission.as_dvec3()
}

/// Returns the figures of each channel from (area, a, b) of every texel; 0 where both are black.
pub fn channel_differences(texels: impl Iterator<Item = (f64, DVec3, DVec3)>) -> [Difference; 3] {
    let [mut squared, mut signed, mut truth_square, mut truth, mut largest] = [DVec3::ZERO; 5];
    let mut all = 0.0;
    for (area, a, b) in texels {
        let difference = a - b;
        squared += area * difference * difference;
        signed += area * difference;
        truth_square += area * b * b;
        truth += area * b;
        all += area;
        largest = largest.max(difference.abs());
    }
    let ratio = |x: f64, y: f64| if x == 0.0 { 0.0 } else { x / y };
    [0, 1, 2].map(|c| Difference {
        relative_rms: ratio(squared[c], truth_square[c]).sqrt(),
        max_relative: ratio(largest[c], (truth_square[c] / all).sqrt()),
        bias: ratio(signed[c], truth[c]),
    })
}

/// Returns the worst channel of each figure; NaN where a channel is NaN.
pub fn worst_channel(channels: [Difference; 3]) -> Difference {
    // Unlike `f64::max`, it keeps NaN.
    let larger = |x: f64, y: f64| if y.is_nan() || y.abs() > x.abs() { y } else { x };
    Difference {
        relative_rms: channels.iter().map(|d| d.relative_rms).fold(0.0, larger),
        max_relative: channels.iter().map(|d| d.max_relative).fold(0.0, larger),
        bias: channels.iter().map(|d| d.bias).fold(0.0, larger),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worst_channel_keeps_nan_and_the_largest_magnitude() {
        let figures = |value| Difference {
            relative_rms: f64::abs(value),
            max_relative: f64::abs(value),
            bias: value,
        };
        let worst = worst_channel([0.1, -0.3, 0.2].map(figures));
        assert_eq!((worst.relative_rms, worst.bias), (0.3, -0.3));
        for channels in [[f64::NAN, 0.1, 0.2], [0.1, 0.2, f64::NAN]] {
            let worst = worst_channel(channels.map(figures));
            assert!(worst.relative_rms.is_nan() && worst.max_relative.is_nan() && worst.bias.is_nan());
        }
    }

    /// Two texels of areas 1 and 3 differ by 1 and −1/2; a channel is black.
    #[test]
    fn differences_are_weighted_by_area() {
        let grey = |value: f64| DVec3::new(value, value, 0.0);
        let texels = [(1.0, grey(2.0), grey(1.0)), (3.0, grey(1.5), grey(2.0))];
        let [found, _, black] = channel_differences(texels.into_iter());
        let expected = [(1.75f64 / 13.0).sqrt(), 1.0 / (13.0f64 / 4.0).sqrt(), -0.5 / 7.0];
        let found = [found.relative_rms, found.max_relative, found.bias];
        assert!(
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15),
            "{found:?}"
        );
        assert_eq!((black.relative_rms, black.max_relative, black.bias), (0.0, 0.0, 0.0));
    }
}
