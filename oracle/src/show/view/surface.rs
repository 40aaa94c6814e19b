//! Irradiance between the texels: continuous and piecewise linear.
//!
//! ```text
//! H(centroid) = H_texel     H(node) = Σ w H / Σ w over the texels around it, w = 1/distance
//! B(p) = E + ρ H(p)
//! ```
//! Inside a texel H is linear on the triangles (centroid, node, next node) of its ring. Between
//! equal texels a node takes their plain mean; the weights keep a linear H linear where texels
//! of different size meet. H and not B is interpolated: ρ and E may jump from face to face.

use crate::show::view::patch::Patch;
use crate::show::view::weld::{COSINE, Joints, neighbours, weld};
use common::mesh::Mesh;
use common::scene::Scene;
use glam::{DVec3, Vec3, Vec4};

/// The nodes of a scene's faces, whatever the values.
pub struct Surface<'a> {
    /// The faces' texels.
    pub mesh: &'a Mesh,
    /// The faces.
    pub patches: Vec<Patch>,
    /// Faces that may share a border.
    pub pairs: Vec<(u32, u32)>,
    joints: Joints,
    /// The mesh's texel for each (face, place in the face).
    texels: Vec<u32>,
}

impl<'a> Surface<'a> {
    /// With the borders of coplanar neighbours joined.
    pub fn new(scene: &Scene, mesh: &'a Mesh) -> Self {
        Self::build(scene, mesh, true, |_, _| COSINE)
    }

    /// Each face on its own: shows what joining is good for.
    pub fn unwelded(scene: &Scene, mesh: &'a Mesh) -> Self {
        Self::build(scene, mesh, false, |_, _| COSINE)
    }

    /// With the borders of those neighbours joined whose normals' cosine is at least what `least`
    /// asks of the two faces: below 1 for faces that approximate a curved surface, above it for
    /// faces that must stay apart.
    pub fn joined(scene: &Scene, mesh: &'a Mesh, least: impl Fn(u32, u32) -> f64) -> Self {
        Self::build(scene, mesh, true, least)
    }

    fn build(scene: &Scene, mesh: &'a Mesh, joined: bool, least: impl Fn(u32, u32) -> f64) -> Self {
        let (patches, nodes) = Patch::all(&scene.faces, mesh);
        let pairs = neighbours(&patches, least);
        let joints = weld(&patches, nodes, if joined { &pairs } else { &[] });
        let mut texels = vec![0; mesh.texels.len()];
        for (k, texel) in mesh.texels.iter().enumerate() {
            texels[patches[texel.face as usize].first_texel + texel.index as usize] = k as u32;
        }
        Self {
            mesh,
            patches,
            pairs,
            joints,
            texels,
        }
    }

    /// The mesh's texel at a point of a face.
    pub fn texel(&self, face: u32, point: DVec3) -> u32 {
        let patch = &self.patches[face as usize];
        self.texels[patch.first_texel + patch.texel(point) as usize]
    }

    /// The mesh's texel in a place of a face, row-major in its rectangle.
    pub fn texel_in(&self, face: u32, index: u32) -> u32 {
        let patch = &self.patches[face as usize];
        self.texels[patch.first_texel + index as usize]
    }

    /// The knots around a texel, counter-clockwise: where they lie and which value they take.
    pub fn ring(&self, texel: u32, knots: &mut Vec<(DVec3, u32)>) {
        let texel = &self.mesh.texels[texel as usize];
        let patch = &self.patches[texel.face as usize];
        let (ring, count) = patch.ring(texel.index);
        knots.clear();
        for k in 0..count {
            let (node, next) = (ring[k], ring[(k + 1) % count]);
            knots.push((patch.position(node), self.joints.slots[patch.index(node)]));
            let Some((edge, [from, to])) = patch.edge_between(node, next) else {
                continue;
            };
            let hanging = &self.joints.hanging[4 * texel.face as usize + edge];
            let first = hanging.partition_point(|knot| knot.s <= from);
            let [a, b] = patch.edge(edge);
            let within = hanging[first..].iter().take_while(|knot| knot.s < to);
            knots.extend(within.map(|knot| (a.lerp(b, knot.s), knot.slot)));
        }
    }

    /// What counts how much at a point of a texel (or just outside).
    pub fn stencil(&self, texel: u32, point: DVec3) -> Stencil {
        self.stencil_within(&mut Ring::default(), texel, point)
    }

    /// The same with the ring of the point before, which may be this one's.
    pub fn stencil_within(&self, ring: &mut Ring, texel: u32, point: DVec3) -> Stencil {
        if ring.texel.replace(texel) != Some(texel) {
            self.ring(texel, &mut ring.knots);
        }
        let knots = &ring.knots;
        let (centre, normal) = self.geometry(texel);
        let mut best = Stencil {
            texel,
            slots: [0, 0],
            shares: DVec3::X,
        };
        let mut inside = f64::NEG_INFINITY;
        for k in 0..knots.len() {
            let (from, to) = (knots[k], knots[(k + 1) % knots.len()]);
            let shares = barycentric(from.0 - centre, to.0 - centre, point - centre, normal);
            // Not NaN; outside all triangles, by rounding, the least far outside counts.
            if shares.min_element() > inside {
                inside = shares.min_element();
                best = Stencil {
                    texel,
                    slots: [from.1, to.1],
                    shares,
                };
            }
        }
        best.shares = best.shares.max(DVec3::ZERO);
        best.shares /= best.shares.element_sum();
        best
    }

    fn geometry(&self, texel: u32) -> (DVec3, DVec3) {
        let texel = &self.mesh.texels[texel as usize];
        (
            texel.position.as_dvec3(),
            self.patches[texel.face as usize].normal,
        )
    }

    /// The interpolation of one value per texel (missing ones are NaN).
    pub fn interpolate(&self, values: &[Vec4]) -> Interpolant<'_> {
        let value = |k: usize| {
            values
                .get(k)
                .map_or(DVec3::NAN, |v| v.truncate().as_dvec3())
        };
        let own: Vec<DVec3> = (0..self.mesh.texels.len()).map(value).collect();
        let mut sums = vec![(DVec3::ZERO, 0.0); self.joints.count];
        let mut knots = Vec::new();
        for (k, texel) in self.mesh.texels.iter().enumerate() {
            self.ring(k as u32, &mut knots);
            for (position, slot) in &knots {
                let weight = weight(texel.area, texel.position.as_dvec3().distance(*position));
                let sum = &mut sums[*slot as usize];
                sum.0 += own[k] * weight;
                sum.1 += weight;
            }
        }
        let nodes = sums.into_iter().map(|(sum, weight)| sum / weight).collect();
        Interpolant {
            surface: self,
            own,
            nodes,
        }
    }
}

/// A texel's knots: most points that follow each other lie in one texel.
#[derive(Default)]
pub struct Ring {
    texel: Option<u32>,
    knots: Vec<(DVec3, u32)>,
}

/// A point's place among a texel's centroid and two neighbouring nodes of its ring.
#[derive(Clone, Copy, Debug)]
pub struct Stencil {
    /// The texel.
    pub texel: u32,
    /// The nodes' values.
    pub slots: [u32; 2],
    /// Shares of the centroid and the nodes; none is negative, their sum is 1.
    pub shares: DVec3,
}

/// A texel without area counts only where there is no other.
fn weight(area: f32, distance: f64) -> f64 {
    if area > 0.0 {
        1.0 / distance.max(1e-12)
    } else {
        1e-30
    }
}

/// One value per texel, interpolated.
pub struct Interpolant<'a> {
    /// Where.
    pub surface: &'a Surface<'a>,
    own: Vec<DVec3>,
    nodes: Vec<DVec3>,
}

impl Interpolant<'_> {
    /// The texel's own value.
    pub fn own(&self, texel: u32) -> DVec3 {
        self.own[texel as usize]
    }

    /// Lets those of the given `faces` that have only one texel vary linearly between their
    /// corners: a mesh of many small facets then looks as smooth as its corners' means are, and
    /// the texels' own values are no longer met.
    pub fn smooth_single(&mut self, faces: impl Fn(u32) -> bool) {
        for (k, texel) in self.surface.mesh.texels.iter().enumerate() {
            let patch = &self.surface.patches[texel.face as usize];
            if patch.size != [1, 1] || !faces(texel.face) {
                continue;
            }
            let (ring, count) = patch.ring(texel.index);
            let slot = |i: usize| self.surface.joints.slots[patch.index(ring[i % count])] as usize;
            let mut sum = DVec3::ZERO;
            for i in (0..count).step_by(2) {
                let [from, to] = [slot(i), slot(i + 2)].map(|slot| self.nodes[slot]);
                self.nodes[slot(i + 1)] = (from + to) / 2.0;
                sum += from;
            }
            self.own[k] = sum / (count / 2) as f64;
        }
    }

    /// The value at a point of a face.
    pub fn at(&self, face: u32, point: DVec3) -> DVec3 {
        self.value(&self.surface.stencil(self.surface.texel(face, point), point))
    }

    /// The value at a stencil's point.
    pub fn value(&self, stencil: &Stencil) -> DVec3 {
        let (
            Stencil {
                texel,
                slots: [a, b],
                shares,
            },
            node,
        ) = (stencil, |k: &u32| self.nodes[*k as usize]);
        // A share of 0 must not let a NaN in: the texel without triangles has no nodes.
        let part = |share: f64, value: DVec3| {
            if share > 0.0 {
                value * share
            } else {
                DVec3::ZERO
            }
        };
        part(shares.x, self.own(*texel)) + part(shares.y, node(a)) + part(shares.z, node(b))
    }

    /// B = E + ρH at a stencil's point.
    pub fn radiosity(&self, stencil: &Stencil) -> Vec3 {
        let texel = &self.surface.mesh.texels[stencil.texel as usize];
        texel.emission + texel.reflectance * self.value(stencil).as_vec3()
    }

    /// The mean over a texel's area.
    pub fn mean(&self, texel: u32) -> DVec3 {
        let mut knots = Vec::with_capacity(8);
        self.surface.ring(texel, &mut knots);
        let (centre, normal) = self.surface.geometry(texel);
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for k in 0..knots.len() {
            let (a, b) = (knots[k], knots[(k + 1) % knots.len()]);
            let area = normal.dot((a.0 - centre).cross(b.0 - centre));
            let values = self.own(texel) + self.nodes[a.1 as usize] + self.nodes[b.1 as usize];
            sum += values / 3.0 * area;
            total += area;
        }
        if total > 0.0 {
            sum / total
        } else {
            self.own(texel)
        }
    }
}

/// The shares of (0, a, b) in p; NaN in a triangle without area.
fn barycentric(a: DVec3, b: DVec3, p: DVec3, normal: DVec3) -> DVec3 {
    let cross = |x: DVec3, y: DVec3| normal.dot(x.cross(y));
    let area = cross(a, b);
    let (s, t) = (cross(p, b) / area, cross(a, p) / area);
    DVec3::new(1.0 - s - t, s, t)
}
