//! Faces as files have them.

use glam::{DVec2, DVec3, Vec2, Vec3};

/// A face as a file has it.
pub struct Polygon<'p> {
    /// Its corners.
    pub corners: &'p [DVec3],
    /// And the surface's normals there; none: the file says nothing.
    pub normals: &'p [Vec3],
    /// What each coordinate is off by at most.
    pub rounding: f64,
    /// The corners' places on the textures of reflectance and of radiance; none: the file says nothing.
    pub places: [Option<&'p [DVec2]>; 2],
    /// The corners' colours, by which reflectance is multiplied.
    pub colours: Option<&'p [DVec3]>,
    /// Whether a quad was joined over the diagonal from corner 1 to corner 3.
    pub odd: bool,
    /// A triangle's place on the file's own lightmap.
    pub chart: Option<[Vec2; 3]>,
}

impl Polygon<'_> {
    /// The normals at a piece's corners, each of which is one of the whole; one without a direction says
    /// nothing.
    pub fn normals_of(&self, piece: &[DVec3; 4]) -> Option<[Vec3; 4]> {
        let mut normals = [Vec3::ZERO; 4];
        for (own, corner) in normals.iter_mut().zip(piece) {
            let k = self.corners.iter().position(|c| c == corner)?;
            *own = self.normals.get(k)?.try_normalize()?;
        }
        Some(normals)
    }
}
