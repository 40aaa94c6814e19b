//! A virtual object in a captured room: the picture of it, and the report of a relight.
//!
//! ```text
//! composite = mask · B/π + (1 − mask) · background · B/B₀        (after Debevec 1998)
//! ```
//! Where B₀ is too little to divide by, or B is more than twice as much, or without a photograph, (B − B₀)/π is
//! added instead.
//! The background is what was captured: the panorama, or the room's own render B₀/π. Only the
//! difference that the objects make is computed light, so whatever the room's model leaves out
//! (its furniture, its fine texture) stays as it was photographed.
//!
//! [`surfaces`] interpolates both renders, [`composite`] looks through the camera that [`camera`]
//! chooses, [`files`] writes the pictures, [`pictures`], [`thumbnail`] and [`page`] make the report.

pub mod camera;
pub mod climb;
pub mod composite;
pub mod files;
pub mod page;
pub mod pictures;
pub mod room;
pub mod stage;
pub mod surfaces;
pub mod thumbnail;
pub mod warnings;
pub mod work;

use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::Field;
use glam::{DVec3, Vec3, Vec4};

/// Pixels of a composite, unless told otherwise: width, height.
pub const SIZE: [u32; 2] = [960, 640];

/// A room with objects in it, relit.
#[derive(Clone, Copy)]
pub struct Relit<'a> {
    /// The room's faces first, then the objects'.
    pub scene: &'a Scene,
    /// Their texels, each with its own reflectance and emission.
    pub mesh: &'a Mesh,
    /// How many faces are the room's.
    pub room: usize,
    /// Captured radiosity B₀ of each texel in the mesh's order, W/m²; 0 on objects.
    pub before: &'a [Vec4],
    /// B, r and H with the objects, in the mesh's order.
    pub after: &'a Field,
    /// Where the panorama was taken from, in scene coordinates; none without a panorama.
    pub eye: Option<DVec3>,
}

/// The radiance (W/m²/sr) that comes to the capture's eye from a unit direction.
pub type Backdrop<'a> = &'a (dyn Fn(DVec3) -> Vec3 + Sync);

impl Relit<'_> {
    /// Whether a face belongs to an object.
    pub fn is_object(&self, face: u32) -> bool {
        face as usize >= self.room
    }

    /// B₀ of a texel; 0 where the list is too short.
    pub fn captured(&self, texel: usize) -> Vec3 {
        self.before.get(texel).map_or(Vec3::ZERO, |b| b.truncate())
    }

    /// B of a texel; 0 where the list is too short.
    pub fn relit(&self, texel: usize) -> Vec3 {
        let radiosity = self.after.radiosity.get(texel);
        radiosity.map_or(Vec3::ZERO, |b| b.truncate())
    }

    /// B − B₀ of a texel of the room; 0 on objects.
    pub fn delta(&self, texel: usize) -> Vec3 {
        match self.mesh.texels.get(texel) {
            Some(t) if !self.is_object(t.face) => self.relit(texel) - self.captured(texel),
            _ => Vec3::ZERO,
        }
    }

    /// Whether a texel is a light: at least half of what leaves it is its own. (Where a capture is
    /// dark, reflectance and emission cannot be told apart, and a trace of emission makes no lamp.)
    pub fn is_light(&self, texel: usize) -> bool {
        self.mesh.texels.get(texel).is_some_and(|t| {
            let own = t.emission.max_element();
            let leaving = if self.is_object(t.face) {
                self.relit(texel)
            } else {
                self.captured(texel)
            };
            own > 0.0 && own >= 0.5 * leaving.max_element()
        })
    }
}
