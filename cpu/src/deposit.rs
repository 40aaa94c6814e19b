//! One texel under one shot: ΔH = w·B_shooter, ΔB = Δr = ρ·ΔH. Twin of
//! `gpu/src/shaders/deposit.wgsl`.

use common::mesh::{Cell, Mesh};
use glam::{Vec3, Vec4};

/// A shot in flight.
#[derive(Clone, Copy, Debug)]
pub struct Flash<'a> {
    /// The scene.
    pub mesh: &'a Mesh,
    /// The shooter.
    pub cell: &'a Cell,
    /// Mean residual radiosity of the cell, W/m².
    pub radiosity: Vec3,
    /// What every link is multiplied by: 1, or what closes the shot exactly.
    pub scale: f32,
}

/// Radiosity, residual and irradiance of one texel.
pub type State<'a> = (&'a mut Vec4, &'a mut Vec4, &'a mut Vec4);

/// Adds what texel `k` takes by its link `w` to the shooter; w of the irradiance keeps the link.
pub fn deposit(flash: &Flash, k: u32, w: f32, (radiosity, residual, irradiance): State) {
    let cell = flash.cell;
    let texel = &flash.mesh.texels[k as usize];
    let f = w * flash.scale;
    irradiance.w = f;
    if k >= cell.first && k < cell.first + cell.count {
        *residual = Vec4::ZERO;
        return;
    }
    if f <= 0.0 {
        return;
    }
    let received = flash.radiosity * f;
    let reflected = texel.reflectance * received;
    *irradiance = (irradiance.truncate() + received).extend(f);
    *radiosity += reflected.extend(0.0);
    *residual += reflected.extend(0.0);
}
