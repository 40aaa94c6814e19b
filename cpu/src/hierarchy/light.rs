//! What the nodes shine: mean, slope, and what a slope leaves.

use crate::hierarchy::tree::Tree;
use glam::Vec3;

/// Radiosity over a node.
#[derive(Clone, Copy, Debug, Default)]
pub struct Glow {
    /// Mean over its open part.
    pub mean: Vec3,
    /// Slope along the face's tangent and bitangent, per unit of length.
    pub slope: [Vec3; 2],
    /// RMS of what mean and slope leave.
    pub rest: Vec3,
}

impl Glow {
    /// A texel's light slopes as that of the node of which it is a part, but not to below nothing, and
    /// varies as that does.
    fn slope_as(&mut self, above: &Self, radius: f32) {
        for c in 0..3 {
            let [x, y] = above.slope.map(|slope| slope[c]);
            let fall = (x * x + y * y).sqrt() * radius;
            let most = self.mean[c].abs();
            let share = if fall > most { most / fall } else { 1.0 };
            (self.slope[0][c], self.slope[1][c]) = (share * x, share * y);
            self.rest[c] = if most > 0.0 { above.rest[c] } else { 0.0 };
        }
    }
}

/// Sums over a node's leaves, about its centre.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Open area.
    area: f64,
    /// Its first and second moments.
    first: [f64; 2],
    second: [f64; 3],
    /// Of the radiosity, and of its products with place and itself.
    light: [f64; 3],
    along: [[f64; 3]; 2],
    square: [f64; 3],
}

impl Sums {
    fn leaf(open: f32, value: Vec3) -> Self {
        let open = f64::from(open);
        let value = value.as_dvec3();
        Self {
            area: open,
            light: (value * open).into(),
            square: (value * value * open).into(),
            ..Self::default()
        }
    }

    /// Adds `part`, whose centre lies (x, y) from this one's.
    fn add(&mut self, part: &Self, x: f64, y: f64) {
        self.area += part.area;
        let [fx, fy] = part.first;
        self.first[0] += fx + x * part.area;
        self.first[1] += fy + y * part.area;
        self.second[0] += part.second[0] + 2.0 * x * fx + x * x * part.area;
        self.second[1] += part.second[1] + 2.0 * y * fy + y * y * part.area;
        self.second[2] += part.second[2] + x * fy + y * fx + x * y * part.area;
        for c in 0..3 {
            self.light[c] += part.light[c];
            self.along[0][c] += part.along[0][c] + x * part.light[c];
            self.along[1][c] += part.along[1][c] + y * part.light[c];
            self.square[c] += part.square[c];
        }
    }

    /// The least-squares fit of mean and slope.
    fn glow(&self) -> Glow {
        let mut glow = Glow::default();
        if self.area <= 0.0 {
            return glow;
        }
        let (mx, my) = (self.first[0] / self.area, self.first[1] / self.area);
        let xx = self.second[0] / self.area - mx * mx;
        let yy = self.second[1] / self.area - my * my;
        let xy = self.second[2] / self.area - mx * my;
        let determinant = xx * yy - xy * xy;
        let flat = determinant <= 1e-9 * (xx + yy) * (xx + yy);
        for c in 0..3 {
            let mean = self.light[c] / self.area;
            let (px, py) = (
                self.along[0][c] / self.area - mx * mean,
                self.along[1][c] / self.area - my * mean,
            );
            let (sx, sy) = if flat {
                (0.0, 0.0)
            } else {
                (
                    (px * yy - py * xy) / determinant,
                    (py * xx - px * xy) / determinant,
                )
            };
            let rest = self.square[c] / self.area - mean * mean - sx * px - sy * py;
            // At the node's centre, not at that of its open part.
            glow.mean[c] = (mean - sx * mx - sy * my) as f32;
            glow.slope[0][c] = sx as f32;
            glow.slope[1][c] = sy as f32;
            glow.rest[c] = rest.max(0.0).sqrt() as f32;
        }
        glow
    }
}

/// The fit through `values` at `nodes`, about the centre of node `k`.
pub fn fit(tree: &Tree, k: u32, nodes: &[u32], values: impl Fn(u32) -> Vec3) -> Glow {
    let mut sums = Sums::default();
    for part in nodes {
        let node = &tree.nodes[*part as usize];
        let offset = (node.place - tree.nodes[k as usize].place).as_dvec2();
        sums.add(
            &Sums::leaf(node.shooter.area, values(*part)),
            offset.x,
            offset.y,
        );
    }
    sums.glow()
}

/// The glow of every node, from `value` of the texels' open parts, which have these `open` areas.
pub fn pull(tree: &Tree, open: &[f32], value: &[Vec3]) -> Vec<Glow> {
    let mut glows = vec![Glow::default(); tree.nodes.len()];
    // Children follow their parents.
    let nodes: Vec<u32> = (0..tree.nodes.len() as u32).rev().collect();
    let part = |k: u32| {
        let leaf = tree.nodes[k as usize].children.is_empty();
        leaf.then(|| tree.leaves(k)[0].texel as usize)
            .map(|texel| (open[texel], value[texel]))
    };
    pull_up(tree, &nodes, |k| k as usize, part, &mut glows);
    for (k, node) in tree.nodes.iter().enumerate() {
        if node.children.is_empty() {
            let above = glows[node.parent as usize];
            glows[k].slope_as(&above, node.shooter.radius);
        }
    }
    glows
}

/// The glow of `nodes`, each of which comes before the one of which it is a part; those that have an open
/// area and a value of their own are not asked for their parts. `slot` numbers them, below as many as
/// there are.
pub fn pull_up(
    tree: &Tree,
    nodes: &[u32],
    slot: impl Fn(u32) -> usize,
    part: impl Fn(u32) -> Option<(f32, Vec3)>,
    glows: &mut [Glow],
) {
    let mut sums = vec![Sums::default(); nodes.len()];
    for k in nodes {
        let node = &tree.nodes[*k as usize];
        let mut own = Sums::default();
        if let Some((open, value)) = part(*k) {
            own = Sums::leaf(open, value);
        } else {
            for child in node.children.clone() {
                let offset = (tree.nodes[child as usize].place - node.place).as_dvec2();
                own.add(&sums[slot(child)], offset.x, offset.y);
            }
        }
        glows[*k as usize] = own.glow();
        sums[slot(*k)] = own;
    }
}
