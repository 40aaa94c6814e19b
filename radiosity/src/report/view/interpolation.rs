//! Interpolates irradiance between texels, continuous and piecewise linear.
//!
//! ```text
//! H(centroid) = H_texel     H(node) = Σ w H / Σ w over the texels around it, w = 1/distance
//! B(p) = E + ρ H(p)
//! ```
//! Inside a texel H is linear on the triangles (centroid, node, next node) of its ring. A node between
//! equal texels takes their mean; the weights preserve a linear H where texels of different size meet.
//! H rather than B is interpolated because ρ and E may differ between faces.

use crate::report::view::face_grid::FaceGrid;
use crate::report::view::weld::{MIN_COPLANAR_COSINE, WeldedNodes, find_neighbours, weld_borders};
use common::mesh::Mesh;
use common::scene::Scene;
use glam::{DVec3, Vec3, Vec4};

/// Interpolation nodes of a scene's faces.
pub struct InterpolationSurface<'a> {
    /// Texels.
    pub mesh: &'a Mesh,
    /// Node grids of the faces.
    pub face_grids: Vec<FaceGrid>,
    /// Faces that may share a border.
    pub pairs: Vec<(u32, u32)>,
    welded: WeldedNodes,
    /// Mesh texel for each (face, index within the face).
    texels: Vec<u32>,
}

impl<'a> InterpolationSurface<'a> {
    /// Places the nodes and welds the borders of coplanar neighbours.
    pub fn new(scene: &Scene, mesh: &'a Mesh) -> Self {
        Self::with_welding(scene, mesh, |_, _| MIN_COPLANAR_COSINE)
    }

    /// Places the nodes and welds the borders of neighbours whose normals' cosine is at least `least(a, b)`: below 1
    /// for faces that approximate a curved surface, above 1 for faces that must not be welded.
    pub fn with_welding(scene: &Scene, mesh: &'a Mesh, least: impl Fn(u32, u32) -> f64) -> Self {
        let (grids, nodes) = FaceGrid::for_all_faces(&scene.faces, mesh);
        let pairs = find_neighbours(&grids, least);
        let welded = weld_borders(&grids, nodes, &pairs);
        let mut texels = vec![0; mesh.texels.len()];
        for (k, texel) in mesh.texels.iter().enumerate() {
            texels[grids[texel.face as usize].first_texel + texel.index as usize] = k as u32;
        }
        Self {
            mesh,
            face_grids: grids,
            pairs,
            welded,
            texels,
        }
    }

    /// Returns the mesh texel at a point of a face.
    pub fn texel_at(&self, face: u32, point: DVec3) -> u32 {
        let grid = &self.face_grids[face as usize];
        self.texels[grid.first_texel + grid.texel_at(point) as usize]
    }

    /// Collects the knots around a texel, counter-clockwise: position and value slot.
    pub fn collect_knots(&self, texel: u32, knots: &mut Vec<(DVec3, u32)>) {
        let texel = &self.mesh.texels[texel as usize];
        let grid = &self.face_grids[texel.face as usize];
        let (ring, count) = grid.texel_ring(texel.index);
        knots.clear();
        for k in 0..count {
            let (node, next) = (ring[k], ring[(k + 1) % count]);
            knots.push((grid.node_position(node), self.welded.slots[grid.node_index(node)]));
            let Some((edge, [from, to])) = grid.edge_between(node, next) else {
                continue;
            };
            let hanging = &self.welded.hanging[4 * texel.face as usize + edge];
            let first = hanging.partition_point(|knot| knot.s <= from);
            let [a, b] = grid.edge_ends(edge);
            let within = hanging[first..].iter().take_while(|knot| knot.s < to);
            knots.extend(within.map(|knot| (a.lerp(b, knot.s), knot.slot)));
        }
    }

    /// Returns the interpolation weights at a point of a texel (or just outside).
    pub fn stencil_at(&self, texel: u32, point: DVec3) -> InterpolationStencil {
        self.stencil_within(&mut KnotCache::default(), texel, point)
    }

    /// Returns [`Self::stencil_at`], reusing `ring` if it is this texel's.
    pub fn stencil_within(&self, ring: &mut KnotCache, texel: u32, point: DVec3) -> InterpolationStencil {
        if ring.texel.replace(texel) != Some(texel) {
            self.collect_knots(texel, &mut ring.knots);
        }
        let knots = &ring.knots;
        let (own, grid) = (&self.mesh.texels[texel as usize], &self.face_grids);
        let (centre, normal) = (own.position.as_dvec3(), grid[own.face as usize].normal);
        let (mut slots, mut shares) = ([0, 0], DVec3::X);
        let mut inside = f64::NEG_INFINITY;
        for k in 0..knots.len() {
            let (from, to) = (knots[k], knots[(k + 1) % knots.len()]);
            let own = barycentric_coordinates(from.0 - centre, to.0 - centre, point - centre, normal);
            // False for NaN. Outside all triangles by rounding, the nearest one is used.
            if own.min_element() > inside {
                (inside, slots, shares) = (own.min_element(), [from.1, to.1], own);
            }
        }
        shares = shares.max(DVec3::ZERO);
        shares /= shares.element_sum();
        InterpolationStencil { texel, slots, shares }
    }

    /// Interpolates one value per texel (missing ones are NaN).
    pub fn interpolate(&self, values: &[Vec4]) -> InterpolatedField<'_> {
        let value = |k: usize| values.get(k).map_or(DVec3::NAN, |v| v.truncate().as_dvec3());
        let own: Vec<DVec3> = (0..self.mesh.texels.len()).map(value).collect();
        let mut sums = vec![(DVec3::ZERO, 0.0); self.welded.slots.len()];
        let mut knots = Vec::new();
        for (k, texel) in self.mesh.texels.iter().enumerate() {
            self.collect_knots(k as u32, &mut knots);
            for (position, slot) in &knots {
                let weight = distance_weight(texel.area, texel.position.as_dvec3().distance(*position));
                let sum = &mut sums[*slot as usize];
                sum.0 += own[k] * weight;
                sum.1 += weight;
            }
        }
        let nodes = sums.into_iter().map(|(sum, weight)| sum / weight).collect();
        InterpolatedField {
            surface: self,
            own,
            nodes,
        }
    }
}

/// Cached knots of one texel: successive points mostly lie in one texel.
#[derive(Default)]
pub struct KnotCache {
    texel: Option<u32>,
    knots: Vec<(DVec3, u32)>,
}

/// Interpolation weights of a point: a texel's centroid and two successive nodes of its ring.
#[derive(Clone, Copy, Debug)]
pub struct InterpolationStencil {
    /// Texel.
    pub texel: u32,
    /// Value slots of the two nodes.
    pub slots: [u32; 2],
    /// Weights of centroid and nodes, not negative, with sum 1.
    pub shares: DVec3,
}

/// Returns a texel's weight at a node; a texel without area matters only where there is no other.
fn distance_weight(area: f32, distance: f64) -> f64 {
    if area > 0.0 { 1.0 / distance.max(1e-12) } else { 1e-30 }
}

/// Interpolated texel values.
pub struct InterpolatedField<'a> {
    /// Nodes.
    pub surface: &'a InterpolationSurface<'a>,
    own: Vec<DVec3>,
    nodes: Vec<DVec3>,
}

impl InterpolatedField<'_> {
    /// Interpolates the given `faces` of one texel linearly between their corners: a mesh of small facets then looks
    /// smooth, but no longer attains the texels' own values.
    pub fn smooth_single(&mut self, faces: impl Fn(u32) -> bool) {
        for (k, texel) in self.surface.mesh.texels.iter().enumerate() {
            let grid = &self.surface.face_grids[texel.face as usize];
            if grid.size != [1, 1] || !faces(texel.face) {
                continue;
            }
            let (ring, count) = grid.texel_ring(texel.index);
            let slot = |i: usize| self.surface.welded.slots[grid.node_index(ring[i % count])] as usize;
            let mut sum = DVec3::ZERO;
            for i in (0..count).step_by(2) {
                let [from, to] = [slot(i), slot(i + 2)].map(|slot| self.nodes[slot]);
                self.nodes[slot(i + 1)] = (from + to) / 2.0;
                sum += from;
            }
            self.own[k] = sum / (count / 2) as f64;
        }
    }

    /// Returns the value at a point of a face.
    pub fn value_at(&self, face: u32, point: DVec3) -> DVec3 {
        self.stencil_value(&self.surface.stencil_at(self.surface.texel_at(face, point), point))
    }

    /// Returns B = E + ρH and H at a point of a face.
    pub fn light_at(&self, face: u32, point: DVec3) -> [Vec3; 2] {
        let stencil = self.surface.stencil_at(self.surface.texel_at(face, point), point);
        [self.radiosity_at(&stencil), self.stencil_value(&stencil).as_vec3()]
    }

    /// Returns the value at a stencil's point.
    pub fn stencil_value(&self, stencil: &InterpolationStencil) -> DVec3 {
        let InterpolationStencil { texel, slots, shares } = stencil;
        let [a, b] = slots.map(|slot| self.nodes[slot as usize]);
        // A share of 0 must not propagate NaN: a texel without triangles has no nodes.
        let part = |share: f64, value: DVec3| {
            if share > 0.0 { value * share } else { DVec3::ZERO }
        };
        part(shares.x, self.own[*texel as usize]) + part(shares.y, a) + part(shares.z, b)
    }

    /// Returns B = E + ρH at a stencil's point.
    pub fn radiosity_at(&self, stencil: &InterpolationStencil) -> Vec3 {
        let texel = &self.surface.mesh.texels[stencil.texel as usize];
        texel.emission + texel.reflectance * self.stencil_value(stencil).as_vec3()
    }
}

/// Returns the barycentric coordinates of p in the triangle (0, a, b); NaN without area.
fn barycentric_coordinates(a: DVec3, b: DVec3, p: DVec3, normal: DVec3) -> DVec3 {
    let cross = |x: DVec3, y: DVec3| normal.dot(x.cross(y));
    let area = cross(a, b);
    let (s, t) = (cross(p, b) / area, cross(a, p) / area);
    DVec3::new(1.0 - s - t, s, t)
}
