//! Per face a quadtree of its texels: what shoots is a node, as large as the light allows (Hanrahan,
//! Salzman & Aupperle 1991). A triangle's nodes are its sub-triangles, four a node.

use common::form_factor::Shooter;
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use common::texel::{self, Outline, triangle_index, triangle_position};
use common::{Error, Result};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::ops::Range;

/// A part of a face: all of it, a quarter of another node, or a texel.
#[derive(Clone, Debug)]
pub struct Node {
    /// Geometry.
    pub shooter: Shooter,
    /// Its face.
    pub face: u32,
    /// Its level's number, 0 of a root.
    pub level: u32,
    /// The node that it is a part of; its own number of a root.
    pub parent: u32,
    /// The nodes that it consists of; none of a leaf.
    pub children: Range<u32>,
    /// Its texels in [`Tree::leaves`].
    pub leaves: Range<u32>,
    /// Mean of x², y² and xy over its area, in the face's frame, about its centre.
    pub spread: [f32; 3],
    /// Its centre in the face's frame.
    pub place: Vec2,
}

/// All nodes.
pub struct Tree {
    /// A node's children follow each other; children follow their parent.
    pub nodes: Vec<Node>,
    /// By face.
    pub roots: Vec<u32>,
    /// The mesh's texels as the nodes hold them: neighbours follow each other.
    pub leaves: Vec<Leaf>,
}

/// A texel of a node.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    /// In the mesh.
    pub texel: u32,
    /// Its node.
    pub node: u32,
}

impl Tree {
    /// Over the texels of `mesh`, whose faces have N×N each, no two alike perhaps.
    ///
    /// Errors: a face of W×H.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Self> {
        let texels = by_face(mesh);
        let mut tree = Self {
            nodes: Vec::new(),
            roots: Vec::with_capacity(mesh.faces.len()),
            leaves: Vec::with_capacity(mesh.texels.len()),
        };
        for (f, texels) in texels.iter().enumerate() {
            let [w, h] = mesh.faces[f].resolution;
            if w != h {
                let name = &scene.faces[f].name;
                return Err(Error::Usage(format!(
                    "face {name} has {w}×{h} texels, not N×N"
                )));
            }
            let sides = sides(w);
            let branch = Branch {
                scene,
                mesh,
                face: f,
                sides: &sides,
                texels,
            };
            let root = tree.nodes.len() as u32;
            tree.roots.push(root);
            tree.nodes.push(branch.node(root, 0, 0));
            tree.grow(root, &branch, 0);
        }
        Ok(tree)
    }

    /// Grows node `k`, which is part `index` of its level.
    fn grow(&mut self, k: u32, branch: &Branch, index: u32) {
        let level = self.nodes[k as usize].level as usize;
        let before = self.leaves.len() as u32;
        if level + 1 == branch.sides.len() {
            let texel = branch.texels[index as usize];
            self.leaves.push(Leaf { texel, node: k });
        } else {
            let parts = branch.parts(level, index);
            let first = self.nodes.len() as u32;
            self.nodes[k as usize].children = first..first + parts.len() as u32;
            for part in &parts {
                self.nodes.push(branch.node(k, level + 1, *part));
            }
            for (child, part) in (first..).zip(parts) {
                self.grow(child, branch, part);
            }
        }
        self.nodes[k as usize].leaves = before..self.leaves.len() as u32;
    }

    /// The texels of node `k`.
    pub fn leaves(&self, k: u32) -> &[Leaf] {
        let range = &self.nodes[k as usize].leaves;
        &self.leaves[range.start as usize..range.end as usize]
    }

    /// The mean ρ of node `k`.
    pub fn reflectance(&self, mesh: &Mesh, k: u32) -> Vec3 {
        let leaves = self.leaves(k).iter();
        let rhos = leaves.map(|leaf| mesh.texels[leaf.texel as usize].reflectance);
        let first = mesh.texels[self.leaves(k)[0].texel as usize].reflectance;
        // Most faces have one: then it is exactly that. A node's texels are of one size.
        let off: Vec3 = rhos.map(|rho| rho - first).sum();
        first + off / self.leaves(k).len() as f32
    }

    /// The largest nodes of face `f` that are no larger than `radius` or have no parts; neighbours
    /// follow each other.
    pub fn within(&self, f: usize, radius: f32) -> Vec<u32> {
        self.whole(f, |k| self.nodes[k as usize].shooter.radius <= radius)
    }

    /// The largest nodes of face `f` that are `whole` or have no parts; neighbours follow each other.
    pub fn whole(&self, f: usize, whole: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut found = Vec::new();
        let mut stack = vec![self.roots[f]];
        while let Some(k) = stack.pop() {
            let node = &self.nodes[k as usize];
            if node.children.is_empty() || whole(k) {
                found.push(k);
            } else {
                stack.extend(node.children.clone().rev());
            }
        }
        found
    }
}

/// Texels by face, in the face's order.
fn by_face(mesh: &Mesh) -> Vec<Vec<u32>> {
    let mut texels: Vec<Vec<u32>> = mesh
        .faces
        .iter()
        .map(|face| vec![0; texel::count(face.resolution) as usize])
        .collect();
    for (k, texel) in (0..).zip(&mesh.texels) {
        texels[texel.face as usize][texel.index as usize] = k;
    }
    texels
}

/// Texels a side of each level: the largest prime factor of N first, halves last.
fn sides(n: u32) -> Vec<u32> {
    let (mut rest, mut sides) = (n, vec![n]);
    let mut factor = 2;
    while rest > 1 {
        if rest.is_multiple_of(factor) {
            rest /= factor;
            sides.push(rest);
        } else if factor * factor > rest {
            factor = rest;
        } else {
            factor += 1;
        }
    }
    sides.reverse();
    sides
}

/// A face's tree under way.
struct Branch<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    face: usize,
    sides: &'a [u32],
    texels: &'a [u32],
}

impl Branch<'_> {
    fn node(&self, parent: u32, level: usize, index: u32) -> Node {
        let face: &Face = &self.scene.faces[self.face];
        let small = &self.mesh.faces[self.face];
        let outline = texel::outline(face, [self.sides[level]; 2], index);
        let local = |p: DVec3| self.mesh.local(p).as_vec3();
        let (centre, corners) = (local(outline.centroid()), outline.padded().map(local));
        let bitangent = small.normal.cross(small.tangent);
        let flat = |p: Vec3| Vec2::new(small.tangent.dot(p), bitangent.dot(p));
        let buried = small.is_buried();
        let area = outline.area() / self.mesh.area_unit();
        Node {
            shooter: Shooter {
                centre,
                normal: small.normal,
                area: if buried { 0.0 } else { area as f32 },
                radius: corners
                    .map(|c| c.distance(centre))
                    .into_iter()
                    .fold(0.0, f32::max),
                corners,
            },
            face: self.face as u32,
            level: level as u32,
            parent,
            children: 0..0,
            leaves: 0..0,
            spread: spread(&outline, |p| flat(local(p) - centre).as_dvec2()),
            place: flat(centre - small.corners[0]),
        }
    }

    /// What part `index` of `level` consists of.
    fn parts(&self, level: usize, index: u32) -> Vec<u32> {
        let (side, finer) = (self.sides[level], self.sides[level + 1]);
        let n = finer / side;
        let within = (0..n * n).map(|k| [k % n, k / n]);
        if self.scene.faces[self.face].shape == Shape::Quad {
            let [i, j] = [index % side, index / side];
            return within
                .map(|[a, b]| (j * n + b) * finer + i * n + a)
                .collect();
        }
        let (i, j, upright) = triangle_position(side, index);
        let at = |a: u32, b: u32, up: bool| triangle_index(finer, i * n + a, j * n + b, up);
        let both = within.flat_map(|[a, b]| [(a, b, true), (a, b, false)]);
        // Below and above the diagonal of the lattice's place.
        both.filter(|(a, b, up)| upright == (a + b + u32::from(!up) < n))
            .map(|(a, b, up)| at(a, b, up))
            .collect()
    }
}

/// ∫ x², y², xy over the area, about the origin of `flat`: of a triangle (Σ v² + (Σ v)²)/12 of its area.
fn spread(outline: &Outline, flat: impl Fn(DVec3) -> DVec2) -> [f32; 3] {
    let [a, b, c, d] = outline.padded().map(flat);
    let (mut sum, mut area) = ([0.0; 3], 0.0);
    for [p, q, r] in [[a, b, c], [a, c, d]] {
        let own = (q - p).perp_dot(r - p);
        let s = p + q + r;
        let square = |u: [f64; 3], v: [f64; 3], su: f64, sv: f64| {
            u.iter().zip(v).map(|(u, v)| u * v).sum::<f64>() + su * sv
        };
        let (x, y) = ([p.x, q.x, r.x], [p.y, q.y, r.y]);
        sum[0] += own * square(x, x, s.x, s.x);
        sum[1] += own * square(y, y, s.y, s.y);
        sum[2] += own * square(x, y, s.x, s.y);
        area += own;
    }
    sum.map(|m| {
        if area == 0.0 {
            0.0
        } else {
            (m / (12.0 * area)) as f32
        }
    })
}
