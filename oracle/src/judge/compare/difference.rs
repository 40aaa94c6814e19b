//! How far two fields are apart, and whether they are two fields at all.

use crate::judge::comparison::Difference;
use common::mesh::Mesh;
use common::shooting::Field;

/// Every figure NaN: fails every gate.
pub const NOT_COMPARABLE: Difference = Difference {
    relative_rms: f64::NAN,
    max_relative: f64::NAN,
    bias: f64::NAN,
};

/// `a` against `b` (the truth): reflected part B − E, area-weighted, the worst channel of each
/// figure. NaN unless both are complete, finite fields of different origin.
pub fn difference(mesh: &Mesh, a: &Field, b: &Field) -> Difference {
    let count = mesh.texels.len();
    let complete =
        |f: &Field| f.radiosity.len() == count && f.radiosity.iter().all(|v| v.is_finite());
    if count == 0 || a.origin == b.origin || !complete(a) || !complete(b) {
        return NOT_COMPARABLE;
    }
    let mut worst = Difference {
        relative_rms: 0.0,
        max_relative: 0.0,
        bias: 0.0,
    };
    for channel in 0..3 {
        let next = channel_difference(mesh, a, b, channel);
        worst.relative_rms = worst.relative_rms.max(next.relative_rms);
        worst.max_relative = worst.max_relative.max(next.max_relative);
        if next.bias.abs() > worst.bias.abs() {
            worst.bias = next.bias;
        }
    }
    worst
}

fn channel_difference(mesh: &Mesh, a: &Field, b: &Field, channel: usize) -> Difference {
    figures(mesh.texels.iter().enumerate().map(|(k, texel)| {
        let reflected =
            |f: &Field| f64::from(f.radiosity[k][channel]) - f64::from(texel.emission[channel]);
        (f64::from(texel.area), reflected(a), reflected(b))
    }))
}

/// The figures of one channel from (area, a, b) of every texel; 0/0 is agreement: no light.
pub fn figures(texels: impl Iterator<Item = (f64, f64, f64)>) -> Difference {
    let (mut square, mut signed, mut truth_square, mut truth, mut area, mut largest) =
        (0.0, 0.0, 0.0, 0.0, 0.0, 0f64);
    for (weight, x, y) in texels {
        square += weight * (x - y) * (x - y);
        signed += weight * (x - y);
        truth_square += weight * y * y;
        truth += weight * y;
        area += weight;
        largest = largest.max((x - y).abs());
    }
    let ratio = |x: f64, y: f64| if x == 0.0 { 0.0 } else { x / y };
    Difference {
        relative_rms: ratio(square, truth_square).sqrt(),
        max_relative: ratio(largest, (truth_square / area).sqrt()),
        bias: ratio(signed, truth),
    }
}
