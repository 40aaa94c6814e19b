//! Deposit of a shot on one texel: ΔH = (w − subtracted)·B_shooter, ΔB = Δr = ρ·ΔH.

use crate::shader_twins::link::Baseline;
use common::mesh::{Mesh, Patch};
use common::shooting::DepositRule;
use glam::{Vec3, Vec4};

/// A shot in flight.
#[derive(Clone, Copy, Debug)]
pub struct ShotInFlight<'a> {
    /// The scene.
    pub mesh: &'a Mesh,
    /// The shooter.
    pub patch: &'a Patch,
    /// Mean residual radiosity of the patch, W/m².
    pub radiosity: Vec3,
    /// Factor that scales every link: 1, or the one that closes the shot exactly.
    pub scale: f32,
    /// Rule by which the room receives it.
    pub rule: DepositRule,
    /// Reflectance of every texel.
    pub reflectance: &'a [Vec3],
}

/// Radiosity, residual and irradiance of one texel.
pub type TexelState<'a> = (&'a mut Vec4, &'a mut Vec4, &'a mut Vec4);

/// Adds the light that texel `k` receives over its link `w`; w of the irradiance stores the link.
pub fn deposit(
    in_flight: &ShotInFlight,
    k: u32,
    w: f32,
    baseline: Baseline,
    (radiosity, residual, irradiance): TexelState,
) {
    let patch = in_flight.patch;
    let texel = &in_flight.mesh.texels[k as usize];
    let f = w * in_flight.scale - baseline.subtracted;
    irradiance.w = f;
    if k >= patch.first && k < patch.first + patch.count {
        // Table 1, line 15; Table 2, line 22.
        *residual = Vec4::ZERO;
        return;
    }
    if in_flight.rule.captured {
        *radiosity += (in_flight.radiosity * baseline.before).extend(0.0);
    }
    if f == 0.0 {
        return;
    }
    let received = in_flight.radiosity * f;
    *irradiance = (irradiance.truncate() + received).extend(f);
    if in_flight.rule.captured {
        return;
    }
    // Table 1, lines 8 to 10; Table 2, lines 8 and 9 (f < 0) and 15 to 17.
    let reflected = in_flight.reflectance[k as usize] * received;
    *radiosity += reflected.extend(0.0);
    if in_flight.rule.reshoot || in_flight.mesh.is_object(texel.face) {
        *residual += reflected.extend(0.0);
    }
}
