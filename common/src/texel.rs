//! Texels of a face: position and outline of element (i, j) of a face's texture.
//!
//! A quad's W×H texels are bilinear: planar quads with exact areas and true centroids. A
//! triangle of side N has N² equal sub-triangles; row j (from the edge 0–1 towards corner 2)
//! holds 2(N−j)−1 of them, upright and inverted alternating. A patch is a block of whole texels.

use crate::scene::{Face, Shape};
use glam::{DVec3, Vec3};

/// A texel, which receives (an element of the radiosity literature).
#[derive(Clone, Copy, Debug)]
pub struct Texel {
    /// Centroid.
    pub position: Vec3,
    /// Area in the mesh's unit squared.
    pub area: f32,
    /// Its face.
    pub face: u32,
    /// Index in the face, row-major in the face's rectangle.
    pub index: u32,
    /// Its pixel in the atlas, row-major.
    pub pixel: u32,
    /// Lower corner (i, j) on the face's lattice.
    pub lattice_corner: [u32; 2],
    /// Kind of its outline.
    pub kind: TexelKind,
    /// Diffuse reflectance ρ.
    pub reflectance: Vec3,
    /// Emitted radiosity E, W/m².
    pub emission: Vec3,
    /// Irradiance from outside the scene, W/m²: the mean over the texel's area.
    pub sky: Vec3,
}

impl Texel {
    /// Returns the radiosity of the texel's open share before any exchange between faces: E, and what it reflects of the
    /// light from outside.
    pub fn source_radiosity(&self, open: f32) -> Vec3 {
        match self.sky == Vec3::ZERO || open <= 0.0 {
            true => self.emission,
            false => self.emission + self.reflectance * self.sky / open,
        }
    }
}

/// Kind of a texel's outline, by corners on the face's lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelKind {
    /// From (i, j) to (i + 1, j + 1).
    Quad,
    /// (i, j), (i + 1, j), (i, j + 1).
    Upright,
    /// (i + 1, j + 1), (i, j + 1), (i + 1, j).
    Inverted,
}

/// Outline of a texel or a patch on its face, counter-clockwise from the front; a triangle repeats its third corner.
#[derive(Clone, Copy, Debug)]
pub struct GridOutline {
    corners: [DVec3; 4],
}

impl GridOutline {
    /// Returns the 4 or 3 corners.
    pub fn corners(&self) -> &[DVec3] {
        let is_triangle = self.corners[2] == self.corners[3];
        &self.corners[..if is_triangle { 3 } else { 4 }]
    }

    /// Returns four corners; a triangle repeats its third.
    pub fn padded_corners(&self) -> [DVec3; 4] {
        self.corners
    }

    /// Returns the area, scene units squared.
    pub fn area(&self) -> f64 {
        let [a, b, c, d] = self.corners;
        (c - a).cross(d - b).length() * 0.5
    }

    /// Returns the centroid of the area: the area-weighted mean of the two triangles' centroids.
    pub fn centroid(&self) -> DVec3 {
        let [a, b, c, d] = self.corners;
        let (s, t) = ((b - a).cross(c - a).length(), (c - a).cross(d - a).length());
        if s + t == 0.0 {
            return (a + b + c + d) / 4.0;
        }
        ((a + b + c) * s + (a + c + d) * t) / (3.0 * (s + t))
    }
}

/// Returns the number of texels of a face: W×H, or N² on a triangle.
pub fn texel_count(resolution: [u32; 2]) -> u32 {
    resolution[0] * resolution[1]
}

/// Returns the outline of texel `index` (row-major in the face's rectangle).
pub fn texel_outline(face: &Face, resolution: [u32; 2], index: u32) -> GridOutline {
    let [w, h] = resolution;
    match face.shape {
        Shape::Quad => block_outline(face, resolution, [index % w, index / w], [1, 1]),
        Shape::Triangle => {
            let (i, j, upright) = triangle_position(h, index);
            let [a, b, c, d] = block_outline(face, resolution, [i, j], [1, 1]).corners;
            let corners = if upright { [a, b, d, d] } else { [b, c, d, d] };
            GridOutline { corners }
        }
    }
}

/// Returns the outline of `size` texels of a quad, or of a triangle's lattice, from texel `first` on.
fn block_outline(face: &Face, [w, h]: [u32; 2], first: [u32; 2], size: [u32; 2]) -> GridOutline {
    let at = |i: u32, j: u32| face.point_at(f64::from(i) / f64::from(w), f64::from(j) / f64::from(h));
    let ([i, j], [m, n]) = (first, size);
    GridOutline {
        corners: [at(i, j), at(i + m, j), at(i + m, j + n), at(i, j + n)],
    }
}

/// Returns the lattice corner (i, j) of a sub-triangle, and whether it is upright.
pub fn triangle_position(side: u32, index: u32) -> (u32, u32, bool) {
    // The rows before j hold j(2N − j) sub-triangles.
    let mut j = (f64::from(side) - (f64::from(side).powi(2) - f64::from(index)).max(0.0).sqrt()) as u32;
    while j * (2 * side - j) > index {
        j -= 1;
    }
    while (j + 1) * (2 * side - j - 1) <= index {
        j += 1;
    }
    let m = index - j * (2 * side - j);
    (m / 2, j, m.is_multiple_of(2))
}

/// Returns the index of a sub-triangle: the inverse of [`triangle_position`].
pub fn triangle_index(side: u32, i: u32, j: u32, upright: bool) -> u32 {
    j * (2 * side - j) + 2 * i + u32::from(!upright)
}

/// Patches of a face: at most K per side, each a block of whole texels; the blocks' sides differ by at most
/// one texel. A triangle has K rows of parallelograms, each of which ends in a triangle at the edge 1–2:
/// K(K+1)/2 in all, so that two triangles have about as many patches as the quad of both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchGrid {
    shape: Shape,
    resolution: [u32; 2],
    /// Patches along each side.
    pub size: [u32; 2],
}

impl PatchGrid {
    /// Makes a grid of K×K patches, or of one patch per texel where there are fewer texels.
    pub fn new(shape: Shape, resolution: [u32; 2], k: u32) -> Self {
        let [w, h] = resolution;
        Self {
            shape,
            resolution,
            size: [k.clamp(1, w), k.clamp(1, h)],
        }
    }

    /// Returns the number of patches.
    pub fn patch_count(&self) -> u32 {
        match self.shape {
            Shape::Quad => texel_count(self.size),
            Shape::Triangle => patches_before_row(self.size[0], self.size[0]),
        }
    }

    /// Returns the patch that holds texel `index`.
    pub fn patch_of_texel(&self, index: u32) -> u32 {
        let ([w, h], [kx, ky]) = (self.resolution, self.size);
        // The inverse of the block's first texel ⌊aW/K⌋: the last a with aW/K ≤ i + 1 − ε.
        let along = |i: u32, n: u32, k: u32| ((i + 1) * k - 1) / n;
        match self.shape {
            Shape::Quad => along(index / w, h, ky) * kx + along(index % w, w, kx),
            Shape::Triangle => {
                // Upright or inverted, a texel lies in the block of its lower corner.
                let (i, j, _) = triangle_position(h, index);
                patches_before_row(ky, j * ky / h) + along(i, w, kx)
            }
        }
    }

    /// Returns the outline of a patch on `face`.
    pub fn patch_outline(&self, face: &Face, patch: u32) -> GridOutline {
        let ([w, h], [kx, ky]) = (self.resolution, self.size);
        let along = |a: u32| a * w / kx;
        match self.shape {
            Shape::Quad => {
                let across = |b: u32| b * h / ky;
                let (a, b) = (patch % kx, patch / kx);
                let first = [along(a), across(b)];
                let size = [along(a + 1) - first[0], across(b + 1) - first[1]];
                block_outline(face, self.resolution, first, size)
            }
            Shape::Triangle => {
                let b = (1..ky).rfind(|b| patches_before_row(ky, *b) <= patch).unwrap_or(0);
                let a = patch - patches_before_row(ky, b);
                // The divisions across mirror those along, so that both meet on the edge 1–2.
                let across = |b: u32| h - along(ky - b);
                let first = [along(a), across(b)];
                let size = [along(a + 1) - first[0], across(b + 1) - first[1]];
                let mut outline = block_outline(face, self.resolution, first, size);
                if a + b + 1 == kx {
                    outline.corners[2] = outline.corners[3];
                }
                outline
            }
        }
    }
}

/// Returns the number of patches in the first `rows` rows of a triangle of `k` patches per side: its rows
/// have k, k − 1, … patches.
fn patches_before_row(k: u32, rows: u32) -> u32 {
    rows * (2 * k - rows + 1) / 2
}

/// Returns the first texel of each face, and the number of all texels.
pub fn first_texels(resolutions: &[[u32; 2]]) -> Vec<usize> {
    let mut first = vec![0];
    for (k, resolution) in resolutions.iter().enumerate() {
        first.push(first[k] + texel_count(*resolution) as usize);
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    fn faces() -> [Face; 2] {
        let p = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        [
            Face::quad(
                "q",
                [p(0.0, 0.0), p(4.0, 0.0), p(3.0, 2.0), p(0.5, 1.0)],
                Vec3::ZERO,
                Vec3::ZERO,
            ),
            Face::triangle("t", [p(0.0, 0.0), p(4.0, 0.0), p(1.0, 3.0)], Vec3::ZERO, Vec3::ZERO),
        ]
    }

    #[test]
    fn patches_are_unions_of_texels_that_tile_the_face() {
        for face in faces() {
            for n in [1, 2, 3, 5, 8, 12] {
                for k in [1, 2, 3, 4, 20] {
                    let patches = PatchGrid::new(face.shape, [n, n], k);
                    let mut area = vec![0.0; patches.patch_count() as usize];
                    let mut moment = vec![DVec3::ZERO; patches.patch_count() as usize];
                    for index in 0..n * n {
                        let texel = texel_outline(&face, [n, n], index);
                        let patch = patches.patch_of_texel(index) as usize;
                        area[patch] += texel.area();
                        moment[patch] += texel.centroid() * texel.area();
                    }
                    // Rounding only: n² additions in f64.
                    let total: f64 = area.iter().sum();
                    assert!(abs_diff_eq!(total / face.area(), 1.0, epsilon = 1e-13));
                    for (patch, area) in area.iter().enumerate() {
                        let outline = patches.patch_outline(&face, patch as u32);
                        assert!(
                            abs_diff_eq!(area / outline.area(), 1.0, epsilon = 1e-12),
                            "{n} {k} {patch}"
                        );
                        assert!((moment[patch] / *area - outline.centroid()).length() < 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn triangle_index_inverts_triangle_position() {
        for side in 1..40 {
            for index in 0..side * side {
                let (i, j, upright) = triangle_position(side, index);
                assert!(i + j + u32::from(!upright) < side);
                assert_eq!(triangle_index(side, i, j, upright), index);
            }
        }
    }
}
