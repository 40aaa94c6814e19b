//! Energy balance of the emitted power after any shot.
//!
//! ```text
//! ΣA·(E + H_sky) = ΣA(1−ρ)H + ΣA·r + escaped + closure
//! ```
//! Absorbed and unshot are summed from the textures; escaped = Σ shot power × the share of the shooter's hemisphere
//! that meets no front, plus the emission under bodies; closure = Σ shot power × (1 − ΣF − this share) is the
//! form-factor error. No term is computed as a remainder, so lost or created power appears in `imbalance`.

use crate::mesh::Mesh;
use crate::shooting::{RadiosityField, Shot};
use glam::DVec3;
use serde::Serialize;

/// The energy balance, W per channel in scene units.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EnergyBalance {
    /// ΣA·E, and the power that arrives from outside.
    pub emitted: [f64; 3],
    /// ΣA(1−ρ)H.
    pub absorbed: [f64; 3],
    /// ΣA·r.
    pub unshot: [f64; 3],
    /// Power that left through openings, into black backs or into bodies on emitters.
    pub escaped: [f64; 3],
    /// Power lost (or created, if negative) by the form factors.
    pub closure: [f64; 3],
    /// |emitted − absorbed − unshot − escaped − closure| / emitted over the channel sum.
    pub imbalance: f64,
}

/// Power that reaches no texel, W per channel in the mesh's unit: a sum over the shots, to which each new one is added.
#[derive(Clone, Copy, Debug)]
pub struct LostPower {
    escaped: DVec3,
    closure: DVec3,
}

impl LostPower {
    /// Returns the loss before the first shot: the power that emitters shine into the bodies that cover them.
    pub fn before_shots(mesh: &Mesh) -> Self {
        let mut escaped = DVec3::ZERO;
        for patch in mesh.patches.iter().filter(|patch| patch.open_share < 1.0) {
            for texel in &mesh.texels[patch.texels()] {
                let share = f64::from(1.0 - patch.open_share) * f64::from(texel.area);
                escaped += texel.emission.as_dvec3() * share;
            }
        }
        Self {
            escaped,
            closure: DVec3::ZERO,
        }
    }

    /// Adds the loss of a shot.
    pub fn add_shot(&mut self, shot: &Shot) {
        let power = DVec3::from(shot.power.map(f64::from));
        let share = f64::from(shot.escaped);
        self.escaped += power * share;
        self.closure += power * (1.0 - f64::from(shot.form_factor_sum) - share);
    }
}

impl EnergyBalance {
    /// Computes the balance of `field` after `shots`.
    pub fn new(mesh: &Mesh, field: &RadiosityField, shots: &[Shot]) -> Self {
        let mut lost = LostPower::before_shots(mesh);
        shots.iter().for_each(|shot| lost.add_shot(shot));
        Self::with_lost_power(mesh, field, lost)
    }

    /// Computes the balance of `field` after shots that have lost so much.
    pub fn with_lost_power(mesh: &Mesh, field: &RadiosityField, lost: LostPower) -> Self {
        let [mut emitted, mut absorbed, mut unshot] = [DVec3::ZERO; 3];
        for (k, texel) in mesh.texels.iter().enumerate() {
            let area = f64::from(texel.area);
            let irradiance = field.irradiance[k].truncate().as_dvec3();
            emitted += (texel.emission + texel.sky).as_dvec3() * area;
            absorbed += (DVec3::ONE - texel.reflectance.as_dvec3()) * irradiance * area;
            unshot += field.residual[k].truncate().as_dvec3() * area;
        }
        let LostPower { escaped, closure } = lost;
        let rest = (emitted - absorbed - unshot - escaped - closure).element_sum().abs();
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

    /// Returns a part's channel sum over the emitted one; 0 if nothing is emitted.
    pub fn share_of_emitted(&self, part: [f64; 3]) -> f64 {
        let total: f64 = self.emitted.iter().sum();
        if total > 0.0 {
            part.iter().sum::<f64>() / total
        } else {
            0.0
        }
    }
}
