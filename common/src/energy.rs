//! Where the emitted power went, after any shot.
//!
//! ```text
//! ΣA·E = ΣA(1−ρ)H + ΣA·r + escaped + closure
//! ```
//! Absorbed and unshot are summed from the textures; escaped = Σ shot power × the share of the
//! shooter's hemisphere that meets no front, and what bodies bury; closure = Σ shot power ×
//! (1 − ΣF − that share) is the form-factor error. Nothing is a remainder, so a lost or invented watt
//! shows as `imbalance`.

use crate::mesh::Mesh;
use crate::shooting::{Field, Shot};
use glam::DVec3;
use serde::Serialize;

/// What emitters shine into the bodies that stand on them.
fn buried(mesh: &Mesh) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for cell in mesh.cells.iter().filter(|cell| cell.open < 1.0) {
        for k in cell.texels() {
            let texel = &mesh.texels[k];
            let share = f64::from(1.0 - cell.open) * f64::from(texel.area);
            sum += texel.emission.as_dvec3() * share;
        }
    }
    sum
}

/// The energy balance, W per channel in scene units.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Energy {
    /// ΣA·E.
    pub emitted: [f64; 3],
    /// ΣA(1−ρ)H.
    pub absorbed: [f64; 3],
    /// ΣA·r.
    pub unshot: [f64; 3],
    /// Left through openings, into black backs or into bodies that stand on emitters.
    pub escaped: [f64; 3],
    /// Lost (or made up, if negative) by the form factors.
    pub closure: [f64; 3],
    /// |emitted − absorbed − unshot − escaped − closure| / emitted over the channel sum.
    pub imbalance: f64,
}

impl Energy {
    /// The balance of `field` after `shots`.
    pub fn new(mesh: &Mesh, field: &Field, shots: &[Shot]) -> Self {
        let mut emitted = DVec3::ZERO;
        let mut absorbed = DVec3::ZERO;
        let mut unshot = DVec3::ZERO;
        for (k, texel) in mesh.texels.iter().enumerate() {
            let area = f64::from(texel.area);
            let irradiance = field.irradiance[k].truncate().as_dvec3();
            emitted += texel.emission.as_dvec3() * area;
            absorbed += (DVec3::ONE - texel.reflectance.as_dvec3()) * irradiance * area;
            unshot += field.residual[k].truncate().as_dvec3() * area;
        }
        let mut escaped = buried(mesh);
        let mut closure = DVec3::ZERO;
        for shot in shots {
            let power = DVec3::from(shot.power.map(f64::from));
            let share = f64::from(shot.escaped);
            escaped += power * share;
            closure += power * (1.0 - f64::from(shot.form_factor_sum) - share);
        }
        let rest = (emitted - absorbed - unshot - escaped - closure)
            .element_sum()
            .abs();
        let total = emitted.element_sum();
        let scale = mesh.area_unit();
        Self {
            emitted: (emitted * scale).into(),
            absorbed: (absorbed * scale).into(),
            unshot: (unshot * scale).into(),
            escaped: (escaped * scale).into(),
            closure: (closure * scale).into(),
            imbalance: if rest == 0.0 { 0.0 } else { rest / total },
        }
    }

    /// A part's channel sum over the emitted one; 0 when nothing is emitted.
    pub fn share(&self, part: [f64; 3]) -> f64 {
        let total: f64 = self.emitted.iter().sum();
        if total > 0.0 {
            part.iter().sum::<f64>() / total
        } else {
            0.0
        }
    }
}
