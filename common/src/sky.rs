//! Light from outside the scene, from infinite distance: the radiosity of a box around it, and suns.

use glam::{DVec3, Vec3};

/// Light from outside a scene.
#[derive(Clone, Debug, Default)]
pub struct Sky {
    /// Name of its radiance for `result.json`: a number or a file; empty without a box.
    pub source: String,
    /// Texels per side of each face of the box; 0 without one.
    pub texels: u32,
    /// Radiosity of the box's texels, W/m²: face after face of [`crate::capture::room::box_room`], as seen from its middle.
    pub radiosity: Vec<Vec3>,
    /// Suns.
    pub suns: Vec<Sun>,
}

/// A sun.
#[derive(Clone, Copy, Debug)]
pub struct Sun {
    /// Unit vector towards it.
    pub direction: DVec3,
    /// Irradiance of a plane that faces it, W/m².
    pub irradiance: Vec3,
}
