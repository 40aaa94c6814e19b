//! How far two fields are apart, and whether they are two fields at all.

use crate::judge::comparison::Difference;
use common::mesh::Mesh;
use common::shooting::Field;
use glam::DVec3;

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
    let texels = (0..count).map(|k| {
        let area = f64::from(mesh.texels[k].area);
        (area, reflected(mesh, a, k), reflected(mesh, b, k))
    });
    worst(channels(texels))
}

/// B − E of texel `k`.
pub fn reflected(mesh: &Mesh, field: &Field, k: usize) -> DVec3 {
    field.radiosity[k].truncate().as_dvec3() - mesh.texels[k].emission.as_dvec3()
}

/// The figures of each channel from (area, a, b) of every texel; 0/0 is agreement: no light.
pub fn channels(texels: impl Iterator<Item = (f64, DVec3, DVec3)>) -> [Difference; 3] {
    let mut sums = [Sums::default(); 3];
    for (area, a, b) in texels {
        for (c, sums) in sums.iter_mut().enumerate() {
            sums.add(area, a[c], b[c]);
        }
    }
    sums.map(|sums| sums.figures())
}

/// The worst channel of each figure.
pub fn worst(channels: [Difference; 3]) -> Difference {
    let larger = |x: f64, y: f64| if y.abs() > x.abs() { y } else { x };
    Difference {
        relative_rms: channels.iter().map(|d| d.relative_rms).fold(0.0, f64::max),
        max_relative: channels.iter().map(|d| d.max_relative).fold(0.0, f64::max),
        bias: channels.iter().map(|d| d.bias).fold(0.0, larger),
    }
}

/// Σ over the texels of one channel.
#[derive(Clone, Copy, Default)]
struct Sums {
    square: f64,
    signed: f64,
    truth_square: f64,
    truth: f64,
    area: f64,
    largest: f64,
}

impl Sums {
    fn add(&mut self, area: f64, a: f64, b: f64) {
        self.square += area * (a - b) * (a - b);
        self.signed += area * (a - b);
        self.truth_square += area * b * b;
        self.truth += area * b;
        self.area += area;
        self.largest = self.largest.max((a - b).abs());
    }

    fn figures(&self) -> Difference {
        let ratio = |x: f64, y: f64| if x == 0.0 { 0.0 } else { x / y };
        Difference {
            relative_rms: ratio(self.square, self.truth_square).sqrt(),
            max_relative: ratio(self.largest, (self.truth_square / self.area).sqrt()),
            bias: ratio(self.signed, self.truth),
        }
    }
}
