//! The radiosity of sources as a mean and a slope (linear radiosity: Zatz 1993), with the RMS deviation from both.

use crate::hierarchy::tree::TexelTree;
use glam::Vec3;

/// Least variance of the parts' places across a node for which a slope is fitted: 10⁻⁶ squared, where the mesh is two units
/// wide and f32 rounds places to 10⁻⁷.
const MIN_SECOND_MOMENT: f64 = 1e-12;

/// Radiosity over a node, about its centre.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinearRadiosity {
    /// Value of the linear fit at the node's centre; the fit is over the open part, and over what lies under preceding
    /// fronts, which is dark.
    pub mean: Vec3,
    /// Slope along the face's tangent and bitangent, per unit of length.
    pub slope: [Vec3; 2],
    /// RMS deviation from mean and slope.
    pub deviation: Vec3,
}

impl LinearRadiosity {
    /// Gives a texel the slope and the deviation of its parent; the slope is limited so that no value changes its sign.
    fn inherit_slope(&mut self, above: &Self, radius: f32) {
        for c in 0..3 {
            let [x, y] = above.slope.map(|slope| slope[c]);
            let fall = (x * x + y * y).sqrt() * radius;
            let most = self.mean[c].abs();
            let share = if fall > most { most / fall } else { 1.0 };
            (self.slope[0][c], self.slope[1][c]) = (share * x, share * y);
            self.deviation[c] = if most > 0.0 { above.deviation[c] } else { 0.0 };
        }
    }
}

/// Moments over a node's leaves, about its centre.
#[derive(Clone, Copy, Default)]
struct MomentSums {
    /// Open area.
    area: f64,
    /// First moments of the area.
    first: [f64; 2],
    /// Second moments of the area: xx, yy, xy.
    second: [f64; 3],
    /// Integral of the radiosity.
    light: [f64; 3],
    /// Integrals of the radiosity times x and times y.
    along: [[f64; 3]; 2],
    /// Integral of the squared radiosity.
    square: [f64; 3],
}

impl MomentSums {
    fn from_leaf(open: f32, value: Vec3) -> Self {
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
    fn add_part(&mut self, part: &Self, x: f64, y: f64) {
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

    /// Returns the least-squares fit of mean and slope.
    fn fit_radiosity(&self) -> LinearRadiosity {
        let mut fitted = LinearRadiosity::default();
        if self.area <= 0.0 {
            return fitted;
        }
        let (mx, my) = (self.first[0] / self.area, self.first[1] / self.area);
        let xx = self.second[0] / self.area - mx * mx;
        let yy = self.second[1] / self.area - my * my;
        let xy = self.second[2] / self.area - mx * my;
        let determinant = xx * yy - xy * xy;
        // Across a sliver or a row the places of parts are rounding errors, which would give any slope: it lies along them.
        let spread = (xx + yy).abs();
        let in_row = determinant <= (1e-9 * spread).max(MIN_SECOND_MOMENT) * spread;
        for c in 0..3 {
            let mean = self.light[c] / self.area;
            let (px, py) = (
                self.along[0][c] / self.area - mx * mean,
                self.along[1][c] / self.area - my * mean,
            );
            let (sx, sy) = if spread <= MIN_SECOND_MOMENT {
                (0.0, 0.0)
            } else if in_row {
                (px / spread, py / spread)
            } else {
                ((px * yy - py * xy) / determinant, (py * xx - px * xy) / determinant)
            };
            let rest = self.square[c] / self.area - mean * mean - sx * px - sy * py;
            // The fit's value at the node's centre, not at the centroid of its open part.
            fitted.mean[c] = (mean - sx * mx - sy * my) as f32;
            fitted.slope[0][c] = sx as f32;
            fitted.slope[1][c] = sy as f32;
            fitted.deviation[c] = rest.max(0.0).sqrt() as f32;
        }
        fitted
    }
}

/// Fits mean and slope to `values` at `nodes`, about the centre of node `k`.
pub fn fit_linear(tree: &TexelTree, k: u32, nodes: &[u32], values: impl Fn(u32) -> Vec3) -> LinearRadiosity {
    let mut sums = MomentSums::default();
    for part in nodes {
        let node = &tree.nodes[*part as usize];
        let offset = (node.face_position - tree.nodes[k as usize].face_position).as_dvec2();
        sums.add_part(
            &MomentSums::from_leaf(node.shooter.area, values(*part)),
            offset.x,
            offset.y,
        );
    }
    sums.fit_radiosity()
}

/// Fits the radiosity of every node to `value` of the texels' open parts, whose areas are `open` (the pull of
/// push–pull).
pub fn pull_radiosity(tree: &TexelTree, open: &[f32], value: &[Vec3]) -> Vec<LinearRadiosity> {
    let mut radiosity = vec![LinearRadiosity::default(); tree.nodes.len()];
    // Children have higher numbers than their parents.
    let nodes: Vec<u32> = (0..tree.nodes.len() as u32).rev().collect();
    let part = |k: u32| {
        let leaf = tree.nodes[k as usize].children.is_empty();
        leaf.then(|| tree.leaves_of(k)[0].texel as usize)
            .map(|texel| (open[texel], value[texel]))
    };
    pull_nodes(tree, &nodes, |k| k as usize, part, &mut radiosity);
    for (k, node) in tree.nodes.iter().enumerate() {
        if node.children.is_empty() {
            let above = radiosity[node.parent as usize];
            radiosity[k].inherit_slope(&above, node.shooter.radius);
        }
    }
    radiosity
}

/// Fits the radiosity of `nodes`, each of which precedes its parent. `part` returns the open area and the value of a
/// node whose children are not visited; `slot` maps a node to its index in `nodes`.
pub fn pull_nodes(
    tree: &TexelTree,
    nodes: &[u32],
    slot: impl Fn(u32) -> usize,
    part: impl Fn(u32) -> Option<(f32, Vec3)>,
    radiosity: &mut [LinearRadiosity],
) {
    let mut sums = vec![MomentSums::default(); nodes.len()];
    for k in nodes {
        let node = &tree.nodes[*k as usize];
        let mut own = MomentSums::default();
        if let Some((open, value)) = part(*k) {
            own = MomentSums::from_leaf(open, value);
        } else {
            for child in node.children.clone() {
                let offset = (tree.nodes[child as usize].face_position - node.face_position).as_dvec2();
                own.add_part(&sums[slot(child)], offset.x, offset.y);
            }
        }
        radiosity[*k as usize] = own.fit_radiosity();
        sums[slot(*k)] = own;
    }
}
