//! A tree of nodes over each face's texels (the quadtree of Hanrahan, Salzman & Aupperle 1991): any node may be a
//! source. A triangle's nodes are its sub-triangles, four per node. A long node is divided along its longer side only.

use common::form_factor::Shooter;
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use common::texel::{self, GridOutline, triangle_index, triangle_position};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::ops::Range;

/// A part of a face: the whole face, a part of another node, or a texel.
#[derive(Clone, Debug)]
pub struct TreeNode {
    /// Geometry.
    pub shooter: Shooter,
    /// Number of the face.
    pub face: u32,
    /// Level; roots have 0.
    pub level: u32,
    /// Number of the parent; a root is its own parent.
    pub parent: u32,
    /// Numbers of the children; empty for a leaf.
    pub children: Range<u32>,
    /// The children divide both sides, or the only one that the texels divide.
    pub divides_both_sides: bool,
    /// The node's texels in [`TexelTree::leaves`].
    pub leaves: Range<u32>,
    /// Mean of x², y² and xy over the area, in the face's frame, about the centre.
    pub second_moments: [f32; 3],
    /// Centre in the face's frame.
    pub face_position: Vec2,
}

/// The trees of all faces.
pub struct TexelTree {
    /// All nodes; siblings are contiguous and follow their parent.
    pub nodes: Vec<TreeNode>,
    /// Root of each face.
    pub roots: Vec<u32>,
    /// The mesh's texels in the order of the nodes: the texels of a node are contiguous.
    pub leaves: Vec<TreeLeaf>,
}

/// A texel in the tree.
#[derive(Clone, Copy, Debug)]
pub struct TreeLeaf {
    /// Number of the texel in the mesh.
    pub texel: u32,
    /// Number of its node.
    pub node: u32,
}

impl TexelTree {
    /// Builds the trees over the texels of `mesh`.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Self {
        let texels = texels_by_face(mesh);
        let mut tree = Self {
            nodes: Vec::new(),
            roots: Vec::with_capacity(mesh.faces.len()),
            leaves: Vec::with_capacity(mesh.texels.len()),
        };
        for (f, texels) in texels.iter().enumerate() {
            let builder = FaceTreeBuilder {
                scene,
                mesh,
                face: f,
                grids: grids_by_level(&scene.faces[f], mesh.faces[f].resolution),
                texels,
            };
            let root = tree.nodes.len() as u32;
            tree.roots.push(root);
            tree.nodes.push(builder.build_node(root, 0, 0));
            tree.grow_node(root, &builder, 0);
        }
        tree
    }

    /// Appends all descendants of node `k`, which has this `index` in its level.
    fn grow_node(&mut self, k: u32, builder: &FaceTreeBuilder, index: u32) {
        let level = self.nodes[k as usize].level as usize;
        let before = self.leaves.len() as u32;
        if level + 1 == builder.grids.len() {
            let texel = builder.texels[index as usize];
            self.leaves.push(TreeLeaf { texel, node: k });
        } else {
            let parts = builder.child_indices(level, index);
            let first = self.nodes.len() as u32;
            self.nodes[k as usize].children = first..first + parts.len() as u32;
            for part in &parts {
                self.nodes.push(builder.build_node(k, level + 1, *part));
            }
            for (child, part) in (first..).zip(parts) {
                self.grow_node(child, builder, part);
            }
        }
        self.nodes[k as usize].leaves = before..self.leaves.len() as u32;
    }

    /// Returns the texels of node `k`.
    pub fn leaves_of(&self, k: u32) -> &[TreeLeaf] {
        let range = &self.nodes[k as usize].leaves;
        &self.leaves[range.start as usize..range.end as usize]
    }

    /// Returns the mean ρ of node `k`.
    pub fn mean_reflectance(&self, mesh: &Mesh, k: u32) -> Vec3 {
        let leaves = self.leaves_of(k).iter();
        let rhos = leaves.map(|leaf| mesh.texels[leaf.texel as usize].reflectance);
        let first = mesh.texels[self.leaves_of(k)[0].texel as usize].reflectance;
        // Exact where all texels have one reflectance, as on most faces. A node's texels have one size.
        let off: Vec3 = rhos.map(|rho| rho - first).sum();
        first + off / self.leaves_of(k).len() as f32
    }

    /// Returns the largest nodes of face `f` that fulfil `accepts`, or leaves; neighbours are contiguous.
    pub fn largest_nodes(&self, f: usize, accepts: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut found = Vec::new();
        let mut stack = vec![self.roots[f]];
        while let Some(k) = stack.pop() {
            let node = &self.nodes[k as usize];
            if node.children.is_empty() || accepts(k) {
                found.push(k);
            } else {
                stack.extend(node.children.clone().rev());
            }
        }
        found
    }
}

/// Returns the texels of each face, in the face's order.
fn texels_by_face(mesh: &Mesh) -> Vec<Vec<u32>> {
    let mut texels: Vec<Vec<u32>> = mesh
        .faces
        .iter()
        .map(|face| vec![0; texel::texel_count(face.resolution) as usize])
        .collect();
    for (k, texel) in (0..).zip(&mesh.texels) {
        texels[texel.face as usize][texel.index as usize] = k;
    }
    texels
}

/// Returns the grid of each level: sides divide by their largest prime factor first, by 2 last, and much longer ones
/// before shorter ones.
fn grids_by_level(face: &Face, resolution: [u32; 2]) -> Vec<[u32; 2]> {
    let mut factors = resolution.map(prime_factors);
    let mut grids = vec![[1, 1]];
    let mut grid = [1, 1];
    while grid != resolution {
        let longer = face.longer_sides(grid);
        // One side alone only as long as it has more divisions left: N×N texels keep nodes of N×N children.
        let alone = (0..2).find(|k| !longer[1 - *k] && factors[*k].len() > factors[1 - *k].len());
        for k in 0..2 {
            if alone.is_none_or(|side| side == k) {
                grid[k] *= factors[k].pop().unwrap_or(1);
            }
        }
        grids.push(grid);
    }
    grids
}

/// Returns the prime factors of `n`, the largest last.
fn prime_factors(n: u32) -> Vec<u32> {
    let (mut rest, mut factors) = (n, Vec::new());
    let mut factor = 2;
    while rest > 1 {
        if rest.is_multiple_of(factor) {
            rest /= factor;
            factors.push(factor);
        } else if factor * factor > rest {
            factor = rest;
        } else {
            factor += 1;
        }
    }
    factors
}

/// Builds the nodes of one face.
struct FaceTreeBuilder<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    face: usize,
    grids: Vec<[u32; 2]>,
    texels: &'a [u32],
}

impl FaceTreeBuilder<'_> {
    fn build_node(&self, parent: u32, level: usize, index: u32) -> TreeNode {
        let face: &Face = &self.scene.faces[self.face];
        let small = &self.mesh.faces[self.face];
        let outline = texel::texel_outline(face, self.grids[level], index);
        let local = |p: DVec3| self.mesh.local_point(p).as_vec3();
        let (centre, corners) = (local(outline.centroid()), outline.padded_corners().map(local));
        let bitangent = small.normal.cross(small.tangent);
        let flat = |p: Vec3| Vec2::new(small.tangent.dot(p), bitangent.dot(p));
        let buried = small.is_buried();
        let area = outline.area() / self.mesh.area_unit();
        let (grid, texels) = (self.grids[level], small.resolution);
        let finer = self.grids.get(level + 1).unwrap_or(&texels);
        TreeNode {
            shooter: Shooter {
                centre,
                normal: small.normal,
                area: if buried { 0.0 } else { area as f32 },
                radius: corners.map(|c| c.distance(centre)).into_iter().fold(0.0, f32::max),
                corners,
            },
            face: self.face as u32,
            level: level as u32,
            parent,
            children: 0..0,
            divides_both_sides: (0..2).all(|k| finer[k] > grid[k] || texels[k] == grid[k]),
            leaves: 0..0,
            second_moments: second_moments(&outline, |p| flat(local(p) - centre).as_dvec2()),
            face_position: flat(centre - small.corners[0]),
        }
    }

    /// Returns the indices of the children of node `index` of `level`.
    fn child_indices(&self, level: usize, index: u32) -> Vec<u32> {
        let ([side, rows], [finer, finer_rows]) = (self.grids[level], self.grids[level + 1]);
        let [n, m] = [finer / side, finer_rows / rows];
        let within = (0..n * m).map(|k| [k % n, k / n]);
        if self.scene.faces[self.face].shape == Shape::Quad {
            let [i, j] = [index % side, index / side];
            return within.map(|[a, b]| (j * m + b) * finer + i * n + a).collect();
        }
        let (i, j, upright) = triangle_position(side, index);
        let at = |a: u32, b: u32, up: bool| triangle_index(finer, i * n + a, j * n + b, up);
        let both = within.flat_map(|[a, b]| [(a, b, true), (a, b, false)]);
        // Below and above the diagonal of the grid square.
        both.filter(|(a, b, up)| upright == (a + b + u32::from(!up) < n))
            .map(|(a, b, up)| at(a, b, up))
            .collect()
    }
}

/// Returns the mean of x², y² and xy over the area, about the origin of `flat`; a triangle has (Σ v² + (Σ v)²)/12.
fn second_moments(outline: &GridOutline, flat: impl Fn(DVec3) -> DVec2) -> [f32; 3] {
    let [a, b, c, d] = outline.padded_corners().map(flat);
    let (mut sum, mut area) = ([0.0; 3], 0.0);
    for [p, q, r] in [[a, b, c], [a, c, d]] {
        let own = (q - p).perp_dot(r - p);
        let s = p + q + r;
        let square =
            |u: [f64; 3], v: [f64; 3], su: f64, sv: f64| u.iter().zip(v).map(|(u, v)| u * v).sum::<f64>() + su * sv;
        let (x, y) = ([p.x, q.x, r.x], [p.y, q.y, r.y]);
        sum[0] += own * square(x, x, s.x, s.x);
        sum[1] += own * square(y, y, s.y, s.y);
        sum[2] += own * square(x, y, s.x, s.y);
        area += own;
    }
    // The area of a sliver may be a rounding error.
    let corners = [a, b, c, d].map(DVec2::length_squared);
    let most = corners.into_iter().fold(0.0, f64::max);
    let moment = |m: f64| (m / (12.0 * area)).clamp(-most, most) as f32;
    sum.map(|m| if area == 0.0 { 0.0 } else { moment(m) })
}
