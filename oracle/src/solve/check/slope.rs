//! How light changes within a texel, told from its neighbours: a texel that is light at one end and
//! dark at the other shines from its light end, and what stands there gets more than its mean.
//!
//! ```text
//! u(x) = u_k + g·(x − c_k)
//! ```
//! in units of the face's lattice; g by least squares from the texels that share an edge, held so that
//! no corner is lighter or darker than all of them (Barth & Jespersen 1989).

use common::mesh::{Texel, TexelKind};
use common::texel::triangle_index;
use glam::{Vec2, Vec3};

/// The change of u along both directions of the lattice.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slope {
    along: Vec3,
    across: Vec3,
}

impl Slope {
    /// Of a texel with `own` light on a face of W×H; `light` is that of a texel by its index, none
    /// where it tells nothing.
    pub fn new(
        texel: &Texel,
        resolution: [u32; 2],
        own: Vec3,
        light: impl Fn(u32) -> Option<Vec3>,
    ) -> Self {
        let (mut low, mut high) = (own, own);
        let (mut moment, mut sides) = ([Vec3::ZERO; 2], [0.0f32; 3]);
        for (index, way) in beside(texel, resolution) {
            let Some(other) = light(index) else {
                continue;
            };
            (low, high) = (low.min(other), high.max(other));
            moment[0] += (other - own) * way.x;
            moment[1] += (other - own) * way.y;
            sides[0] += way.x * way.x;
            sides[1] += way.x * way.y;
            sides[2] += way.y * way.y;
        }
        let scale = sides[0] * sides[2] - sides[1] * sides[1];
        if scale <= 1e-6 {
            return Self::default();
        }
        let slope = Self {
            along: (moment[0] * sides[2] - moment[1] * sides[1]) / scale,
            across: (moment[1] * sides[0] - moment[0] * sides[1]) / scale,
        };
        slope.held(texel.kind, low - own, high - own)
    }

    /// What is added to the mean at a place of the texel, from its lower corner on the lattice.
    pub fn at(&self, kind: TexelKind, place: Vec2) -> Vec3 {
        let off = place - middle(kind);
        self.along * off.x + self.across * off.y
    }

    fn held(self, kind: TexelKind, low: Vec3, high: Vec3) -> Self {
        let mut part = Vec3::ONE;
        for corner in corners(kind) {
            let off = self.at(kind, *corner);
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

/// The centroid, from the lower corner on the lattice.
fn middle(kind: TexelKind) -> Vec2 {
    Vec2::splat(match kind {
        TexelKind::Quad => 0.5,
        TexelKind::Upright => 1.0 / 3.0,
        TexelKind::Inverted => 2.0 / 3.0,
    })
}

fn corners(kind: TexelKind) -> &'static [Vec2] {
    const O: Vec2 = Vec2::ZERO;
    const I: Vec2 = Vec2::ONE;
    match kind {
        TexelKind::Quad => &[O, Vec2::X, I, Vec2::Y],
        TexelKind::Upright => &[O, Vec2::X, Vec2::Y],
        TexelKind::Inverted => &[I, Vec2::X, Vec2::Y],
    }
}

/// The texels that share an edge, and the way to their middles.
fn beside(texel: &Texel, [w, h]: [u32; 2]) -> Vec<(u32, Vec2)> {
    let [i, j] = texel.place;
    let mut found = Vec::with_capacity(4);
    let mut add = |inside: bool, index: &dyn Fn() -> u32, x: f32, y: f32| {
        if inside {
            found.push((index(), Vec2::new(x, y)));
        }
    };
    const NEAR: f32 = 1.0 / 3.0;
    match texel.kind {
        TexelKind::Quad => {
            add(i > 0, &|| j * w + i - 1, -1.0, 0.0);
            add(i + 1 < w, &|| j * w + i + 1, 1.0, 0.0);
            add(j > 0, &|| (j - 1) * w + i, 0.0, -1.0);
            add(j + 1 < h, &|| (j + 1) * w + i, 0.0, 1.0);
        }
        TexelKind::Upright => {
            let inverted = |i, j| triangle_index(h, i, j, false);
            add(i + j + 1 < h, &|| inverted(i, j), NEAR, NEAR);
            add(i > 0, &|| inverted(i - 1, j), -2.0 * NEAR, NEAR);
            add(j > 0, &|| inverted(i, j - 1), NEAR, -2.0 * NEAR);
        }
        TexelKind::Inverted => {
            let upright = |i, j| triangle_index(h, i, j, true);
            add(true, &|| upright(i, j), -NEAR, -NEAR);
            add(true, &|| upright(i + 1, j), 2.0 * NEAR, -NEAR);
            add(true, &|| upright(i, j + 1), -NEAR, 2.0 * NEAR);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::mesh::Mesh;
    use common::scene::{Face, Scene};
    use glam::DVec3;

    /// A field that is linear along both sides of a face is found as it is, where a texel has
    /// neighbours all round.
    #[test]
    fn a_linear_field_is_found() {
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
                let at = middle(t.kind) + Vec2::new(t.place[0] as f32, t.place[1] as f32);
                Vec3::splat(5.0 + 0.5 * at.x - 0.25 * at.y)
            };
            let mut of_face = mesh.texels.iter().filter(|t| t.face == texel.face);
            let light = |index| of_face.clone().find(|t| t.index == index).map(value);
            let around = beside(texel, [6, 6]).len();
            let slope = Slope::new(texel, [6, 6], value(texel), light);
            assert!(of_face.next().is_some());
            if around == if texel.kind == TexelKind::Quad { 4 } else { 3 } {
                // Held by the neighbours' means: a quad's corner lies farther out than those.
                let share = slope.along.x / 0.5;
                assert!((slope.across.x / -0.25 - share).abs() < 1e-5);
                assert!(share > 0.6 && share < 1.0 + 1e-5, "{texel:?} {slope:?}");
            }
        }
    }
}
