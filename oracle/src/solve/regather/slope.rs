//! Linear reconstruction of light within a texel from its neighbours. A texel that is lit at one end sends most
//! light from that end, so a near receiver gets more or less than the mean suggests.
//!
//! ```text
//! u(x) = u_k + g·(x − c_k)
//! ```
//! in units of the face's lattice. g is the least-squares slope over the texels that share an edge, limited so
//! that no corner is lighter or darker than all of them (Barth & Jespersen 1989).

use common::mesh::{Texel, TexelKind};
use common::texel::triangle_index;
use glam::{Vec2, Vec3};

/// Slope of u along both directions of the lattice.
#[derive(Clone, Copy, Debug, Default)]
pub struct TexelSlope {
    along: Vec3,
    across: Vec3,
}

impl TexelSlope {
    /// Fits the slope of a texel with light `own` on a face of W×H texels. `light` returns the light of a texel by
    /// its index, `None` for texels to ignore.
    pub fn new(texel: &Texel, resolution: [u32; 2], own: Vec3, light: impl Fn(u32) -> Option<Vec3>) -> Self {
        let (mut low, mut high) = (own, own);
        let (mut moment, mut sides) = ([Vec3::ZERO; 2], [0.0f32; 3]);
        for (index, offset) in edge_neighbours(texel, resolution) {
            let Some(other) = light(index) else {
                continue;
            };
            (low, high) = (low.min(other), high.max(other));
            moment[0] += (other - own) * offset.x;
            moment[1] += (other - own) * offset.y;
            sides[0] += offset.x * offset.x;
            sides[1] += offset.x * offset.y;
            sides[2] += offset.y * offset.y;
        }
        let scale = sides[0] * sides[2] - sides[1] * sides[1];
        if scale <= 1e-6 {
            return Self::default();
        }
        let slope = Self {
            along: (moment[0] * sides[2] - moment[1] * sides[1]) / scale,
            across: (moment[1] * sides[0] - moment[0] * sides[1]) / scale,
        };
        slope.limit_to_range(texel.kind, low - own, high - own)
    }

    /// Difference from the mean at a point of the texel; `place` is relative to its lower corner on the lattice.
    pub fn offset_at(&self, kind: TexelKind, place: Vec2) -> Vec3 {
        let off = place - lattice_centroid(kind);
        self.along * off.x + self.across * off.y
    }

    fn limit_to_range(self, kind: TexelKind, low: Vec3, high: Vec3) -> Self {
        let mut part = Vec3::ONE;
        for corner in lattice_corners(kind) {
            let off = self.offset_at(kind, *corner);
            for c in 0..3 {
                let most = if off[c] > 0.0 { high[c] } else { low[c] };
                if off[c] != 0.0 {
                    part[c] = part[c].min(most / off[c]);
                }
            }
        }
        Self {
            along: self.along * part,
            across: self.across * part,
        }
    }
}

/// Centroid of a texel, relative to its lower corner on the lattice.
fn lattice_centroid(kind: TexelKind) -> Vec2 {
    Vec2::splat(match kind {
        TexelKind::Quad => 0.5,
        TexelKind::Upright => 1.0 / 3.0,
        TexelKind::Inverted => 2.0 / 3.0,
    })
}

fn lattice_corners(kind: TexelKind) -> &'static [Vec2] {
    const LOW_CORNER: Vec2 = Vec2::ZERO;
    const HIGH_CORNER: Vec2 = Vec2::ONE;
    match kind {
        TexelKind::Quad => &[LOW_CORNER, Vec2::X, HIGH_CORNER, Vec2::Y],
        TexelKind::Upright => &[LOW_CORNER, Vec2::X, Vec2::Y],
        TexelKind::Inverted => &[HIGH_CORNER, Vec2::X, Vec2::Y],
    }
}

/// Returns the texels that share an edge, with the vectors to their centroids.
fn edge_neighbours(texel: &Texel, [w, h]: [u32; 2]) -> Vec<(u32, Vec2)> {
    let [i, j] = texel.lattice_corner;
    let mut neighbours = Vec::with_capacity(4);
    let mut add = |inside: bool, index: &dyn Fn() -> u32, x: f32, y: f32| {
        if inside {
            neighbours.push((index(), Vec2::new(x, y)));
        }
    };
    const THIRD_OF_STEP: f32 = 1.0 / 3.0;
    match texel.kind {
        TexelKind::Quad => {
            add(i > 0, &|| j * w + i - 1, -1.0, 0.0);
            add(i + 1 < w, &|| j * w + i + 1, 1.0, 0.0);
            add(j > 0, &|| (j - 1) * w + i, 0.0, -1.0);
            add(j + 1 < h, &|| (j + 1) * w + i, 0.0, 1.0);
        }
        TexelKind::Upright => {
            let inverted = |i, j| triangle_index(h, i, j, false);
            add(i + j + 1 < h, &|| inverted(i, j), THIRD_OF_STEP, THIRD_OF_STEP);
            add(i > 0, &|| inverted(i - 1, j), -2.0 * THIRD_OF_STEP, THIRD_OF_STEP);
            add(j > 0, &|| inverted(i, j - 1), THIRD_OF_STEP, -2.0 * THIRD_OF_STEP);
        }
        TexelKind::Inverted => {
            let upright = |i, j| triangle_index(h, i, j, true);
            add(true, &|| upright(i, j), -THIRD_OF_STEP, -THIRD_OF_STEP);
            add(true, &|| upright(i + 1, j), 2.0 * THIRD_OF_STEP, -THIRD_OF_STEP);
            add(true, &|| upright(i, j + 1), -THIRD_OF_STEP, 2.0 * THIRD_OF_STEP);
        }
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::mesh::Mesh;
    use common::scene::{Face, Scene};
    use glam::DVec3;

    /// A texel needs neighbours at all edges.
    #[test]
    fn slope_of_a_linear_field_is_recovered() {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let faces = vec![
            Face::quad("quad", c, Vec3::ZERO, Vec3::ONE),
            Face::triangle("triangle", [c[0], c[1], c[3]], Vec3::ZERO, Vec3::ONE),
        ];
        let scene = Scene {
            name: "linear".into(),
            faces,
            notes: Vec::new(),
        };
        let mesh = Mesh::uniform(&scene, 6, 1).unwrap();
        for texel in &mesh.texels {
            let value = |t: &Texel| {
                let at = lattice_centroid(t.kind) + Vec2::new(t.lattice_corner[0] as f32, t.lattice_corner[1] as f32);
                Vec3::splat(5.0 + 0.5 * at.x - 0.25 * at.y)
            };
            let mut of_face = mesh.texels.iter().filter(|t| t.face == texel.face);
            let light = |index| of_face.clone().find(|t| t.index == index).map(value);
            let around = edge_neighbours(texel, [6, 6]).len();
            let slope = TexelSlope::new(texel, [6, 6], value(texel), light);
            assert!(of_face.next().is_some());
            if around == if texel.kind == TexelKind::Quad { 4 } else { 3 } {
                // Limited by the neighbours' means: a quad's corner lies farther out than their centroids.
                let share = slope.along.x / 0.5;
                assert!((slope.across.x / -0.25 - share).abs() < 1e-5);
                assert!(share > 0.6 && share < 1.0 + 1e-5, "{texel:?} {slope:?}");
            }
        }
    }
}
