//! Renders virtual objects in a captured room by differential rendering, and the report of a relight.
//!
//! ```text
//! composite = mask · B/π + (1 − mask) · background · B/B₀        (after Debevec 1998)
//! ```
//! Where B₀ is too small to divide by, or B exceeds 2 B₀, or without a photograph, (B − B₀)/π is added instead.
//! The background is the panorama, or without one the room's own render B₀/π. Only the objects' change is computed,
//! so details that the room's model lacks (furniture, fine texture) stay as photographed.
//!
//! [`radiance`] interpolates radiance, [`camera`] chooses the camera, [`composite`] renders, [`files`] writes the
//! pictures; [`pictures`] and [`page`] make the report.

pub mod camera;
pub mod composite;
pub mod files;
pub mod page;
pub mod pictures;
pub mod radiance;

use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::RadiosityField;
use glam::{DVec3, Vec3, Vec4};

/// Default width and height of a composite in pixels.
pub const COMPOSITE_SIZE: [u32; 2] = [960, 640];

/// Relit room with objects: geometry and radiosity before and after.
#[derive(Clone, Copy)]
pub struct RelitScene<'a> {
    /// Faces: first those of the room, then those of the objects.
    pub scene: &'a Scene,
    /// Texels with reflectance and emission.
    pub mesh: &'a Mesh,
    /// Number of the room's faces.
    pub room: usize,
    /// Captured radiosity B₀ per texel in mesh order, W/m²; 0 on objects.
    pub before: &'a [Vec4],
    /// Radiosity, residual and irradiance with the objects, in mesh order.
    pub after: &'a RadiosityField,
    /// Share of each texel that no body covers; none if not known.
    pub open: Option<&'a [f32]>,
    /// Eye of the panorama in scene coordinates; none without a panorama.
    pub eye: Option<DVec3>,
}

/// Returns the radiance at the capture's eye from a unit direction, W/m²/sr.
pub type Backdrop<'a> = &'a (dyn Fn(DVec3) -> Vec3 + Sync);

impl RelitScene<'_> {
    /// Returns whether a face belongs to an object.
    pub fn is_object(&self, face: u32) -> bool {
        face as usize >= self.room
    }

    /// Returns B₀ of a texel; 0 beyond the list.
    pub fn captured_radiosity(&self, texel: usize) -> Vec3 {
        self.before.get(texel).map_or(Vec3::ZERO, |b| b.truncate())
    }

    /// Returns B of a texel; 0 beyond the list.
    pub fn relit_radiosity(&self, texel: usize) -> Vec3 {
        let radiosity = self.after.radiosity.get(texel);
        radiosity.map_or(Vec3::ZERO, |b| b.truncate())
    }

    /// Returns B₀ of a texel of the room, B of one of an object.
    pub fn shown_radiosity(&self, texel: usize) -> Vec3 {
        match self.is_object(self.mesh.texels[texel].face) {
            true => self.relit_radiosity(texel),
            false => self.captured_radiosity(texel),
        }
    }

    /// Returns B − B₀ of a texel of the room; 0 on objects.
    pub fn radiosity_change(&self, texel: usize) -> Vec3 {
        match self.mesh.texels.get(texel) {
            Some(t) if !self.is_object(t.face) => self.relit_radiosity(texel) - self.captured_radiosity(texel),
            _ => Vec3::ZERO,
        }
    }

    /// Returns whether a texel is a light: emission is at least half of its radiosity. (In dark parts of a capture
    /// reflectance and emission are indistinguishable, so a small share of emission does not count.)
    pub fn is_light(&self, texel: usize) -> bool {
        self.mesh.texels.get(texel).is_some_and(|t| {
            let own = t.emission.max_element();
            own > 0.0 && own >= 0.5 * self.shown_radiosity(texel).max_element()
        })
    }
}
