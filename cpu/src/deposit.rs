//! One texel under one shot: ΔH = F·V·B_shooter, ΔB = Δr = ρ·ΔH. Twin of
//! `gpu/src/shaders/deposit.wgsl`.

use common::form_factor::{FormFactor, form_factor};
use common::mesh::{Cell, Mesh, Texel};
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
    /// Form factor.
    pub form_factor: FormFactor,
}

/// Radiosity, residual and irradiance of one texel.
pub type State<'a> = (&'a mut Vec4, &'a mut Vec4, &'a mut Vec4);

/// Adds what texel `k` receives; `visible` is asked only where light could arrive.
pub fn deposit(
    flash: &Flash,
    k: u32,
    (radiosity, residual, irradiance): State,
    visible: impl Fn(&Texel) -> bool,
) {
    let cell = flash.cell;
    let texel = &flash.mesh.texels[k as usize];
    irradiance.w = 0.0;
    if k >= cell.first && k < cell.first + cell.count {
        *residual = Vec4::ZERO;
        return;
    }
    if texel.face == cell.face {
        return;
    }
    let normal = flash.mesh.faces[texel.face as usize].normal;
    let f = form_factor(
        flash.form_factor,
        &cell.shooter,
        texel.position,
        normal,
        texel.area,
    );
    if f <= 0.0 || !visible(texel) {
        return;
    }
    let received = flash.radiosity * f;
    let reflected = texel.reflectance * received;
    *irradiance = (irradiance.truncate() + received).extend(f);
    *radiosity += reflected.extend(0.0);
    *residual += reflected.extend(0.0);
}
