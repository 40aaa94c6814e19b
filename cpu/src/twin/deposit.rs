//! One texel under one shot: ΔH = (w − subtracted)·B_shooter, ΔB = Δr = ρ·ΔH. Twin of
//! `gpu/src/shaders/deposit.wgsl`.

use crate::twin::link::Baseline;
use common::mesh::{Cell, Mesh};
use common::shooting::Rule;
use glam::{Vec3, Vec4};

/// A shot in flight.
#[derive(Clone, Copy, Debug)]
pub struct ShotInFlight<'a> {
    /// The scene.
    pub mesh: &'a Mesh,
    /// The shooter.
    pub cell: &'a Cell,
    /// Mean residual radiosity of the cell, W/m².
    pub radiosity: Vec3,
    /// What every link is multiplied by: 1, or what closes the shot exactly.
    pub scale: f32,
    /// How the room takes it.
    pub rule: Rule,
    /// Reflectance of every texel.
    pub reflectance: &'a [Vec3],
}

/// Radiosity, residual and irradiance of one texel.
pub type State<'a> = (&'a mut Vec4, &'a mut Vec4, &'a mut Vec4);

/// Adds what texel `k` takes by its link `w` to the shooter; w of the irradiance keeps the link.
pub fn deposit(
    in_flight: &ShotInFlight,
    k: u32,
    w: f32,
    baseline: Baseline,
    (radiosity, residual, irradiance): State,
) {
    let cell = in_flight.cell;
    let texel = &in_flight.mesh.texels[k as usize];
    let f = w * in_flight.scale - baseline.subtracted;
    irradiance.w = f;
    if k >= cell.first && k < cell.first + cell.count {
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
    if in_flight.rule.keep || in_flight.mesh.is_object(texel.face) {
        *residual += reflected.extend(0.0);
    }
}
