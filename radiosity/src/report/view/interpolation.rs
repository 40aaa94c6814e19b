//! Interpolates light between texels: continuous over every smooth surface, linear on triangles, with the texels' means.
//!
//! ```text
//! H(node) = Σ w H / Σ w over the texels around it, w = open share / distance
//! H(node) += Σ w r / Σ w, r = H_texel − mean of H(p) over the texel, within the range of the texels around
//! ```
//! Inside a texel H is linear on the triangles (middle, knot, next knot) of its ring; the middle takes the mean of the
//! texel's corners, so that it shows no fan. A linear H is reproduced. At a border there are no texels beyond, so H
//! continues with the slope inside. A texel's H is the mean over its whole area; where a body covers a part of it, H of
//! the open part is interpolated.

use crate::report::view::face_grid::FaceGrid;
use crate::report::view::weld::{WeldedNodes, find_neighbours, weld_borders};
use common::mesh::{Mesh, Texel};
use common::scene::Scene;
use common::shooting::RadiosityField;
use cpu::hierarchy::solver::open_shares;
use glam::{DVec3, Vec3, Vec4};

/// First corrections, of the nodes at borders: an error at the corner of a triangle shrinks by a third in each.
const BORDER_STEPS: u32 = 32;
/// Corrections of all nodes towards the texels' means: more would restore the noise of single texels.
const MEAN_STEPS: u32 = 2;
/// Open share below which a texel counts as partly covered.
const WHOLLY_OPEN_SHARE: f32 = 0.999;

/// Light that is interpolated between texels; radiosity follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CarriedLight {
    /// H, B = E + ρH: ρ and E may differ between faces.
    Irradiance,
    /// B − E, where B = E + ρH need not hold.
    Reflected,
    /// B, where E and ρ of each texel were recovered from B.
    Radiosity,
}

impl CarriedLight {
    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Irradiance => "irradiance",
            Self::Reflected => "reflected",
            Self::Radiosity => "radiosity",
        }
    }

    /// Returns the light of each texel.
    pub fn texel_values(self, mesh: &Mesh, field: &RadiosityField) -> Vec<Vec4> {
        match self {
            Self::Irradiance => field.irradiance.clone(),
            Self::Radiosity => field.radiosity.clone(),
            Self::Reflected => {
                let texels = mesh.texels.iter().zip(&field.radiosity);
                texels.map(|(texel, b)| b - texel.emission.extend(0.0)).collect()
            }
        }
    }

    /// Returns radiosity for the light at a point of a texel.
    fn convert_to_radiosity(self, texel: &Texel, light: Vec3) -> Vec3 {
        match self {
            Self::Irradiance => texel.emission + texel.reflectance * light,
            Self::Reflected => texel.emission + light,
            Self::Radiosity => light,
        }
    }
}

/// Interpolation nodes of a scene's faces.
pub struct InterpolationSurface<'a> {
    /// Texels.
    pub mesh: &'a Mesh,
    /// Node grids of the faces.
    pub face_grids: Vec<FaceGrid>,
    /// Neighbours that form one surface.
    pub pairs: Vec<(u32, u32)>,
    /// Share of each texel that no body covers.
    pub open: Vec<f32>,
    welded: WeldedNodes,
    /// Mesh texel for each (face, index within the face).
    texels: Vec<u32>,
    /// Nodes around each texel, and the first of each.
    ring_nodes: Vec<RingNode>,
    first_ring_nodes: Vec<u32>,
    /// Nodes beyond which there are no open texels.
    on_border: Vec<bool>,
}

/// Node around a texel.
#[derive(Clone, Copy)]
struct RingNode {
    /// Value slot.
    slot: u32,
    /// Weight of the texel at the node.
    weight: f32,
    /// Share of the node in the texel's mean.
    share: f32,
}

/// Knot of a texel's ring.
#[derive(Clone, Copy, Debug)]
pub struct RingKnot {
    /// Position in the mesh's unit.
    pub position: DVec3,
    /// Value slot.
    pub slot: u32,
    /// True for a corner of the texel, false for a neighbour's node on its edge.
    pub is_corner: bool,
    /// True if the way to the next knot lies on the face's outline.
    is_outline: bool,
}

impl<'a> InterpolationSurface<'a> {
    /// Places the nodes and welds the borders of neighbours that form one surface.
    pub fn new(scene: &Scene, mesh: &'a Mesh) -> Self {
        Self::with_welding(scene, mesh, None, |_, _| true)
    }

    /// Places the nodes and welds the borders of those neighbours `(a, b)` that form one surface and that `welds`; the
    /// share of each texel that no body covers is found if it is not known to be `open`.
    pub fn with_welding(scene: &Scene, mesh: &'a Mesh, open: Option<&[f32]>, welds: impl Fn(u32, u32) -> bool) -> Self {
        let (grids, nodes) = FaceGrid::for_all_faces(&scene.faces, mesh);
        let pairs = find_neighbours(&scene.faces, &grids, welds);
        let welded = weld_borders(&grids, nodes, &pairs);
        let mut texels = vec![0; mesh.texels.len()];
        for (k, texel) in mesh.texels.iter().enumerate() {
            texels[grids[texel.face as usize].first_texel + texel.index as usize] = k as u32;
        }
        let mut surface = Self {
            mesh,
            face_grids: grids,
            pairs,
            open: open.map_or_else(|| open_shares(scene, mesh), <[f32]>::to_vec),
            welded,
            texels,
            ring_nodes: Vec::with_capacity(4 * mesh.texels.len()),
            first_ring_nodes: vec![0],
            on_border: vec![false; nodes],
        };
        surface.link_nodes();
        surface
    }

    /// Collects the nodes around each texel and marks those on borders.
    fn link_nodes(&mut self) {
        let (mut knots, mut outline) = (Vec::new(), Vec::new());
        for (k, texel) in self.mesh.texels.iter().enumerate() {
            self.collect_knots(k as u32, &mut knots);
            let (middle, open) = (middle_of(&knots), self.open[k]);
            let corners = knots.iter().filter(|knot| knot.is_corner).count() as f64;
            let next = |i: usize| (i + 1) % knots.len();
            let area = |i: usize| {
                let [a, b] = [i, next(i)].map(|i| knots[i].position - middle);
                a.cross(b).length()
            };
            let areas: Vec<f64> = (0..knots.len()).map(area).collect();
            let all = areas.iter().sum::<f64>();
            for (i, knot) in knots.iter().enumerate() {
                let beside = areas[i] + areas[(i + knots.len() - 1) % knots.len()];
                let own = if knot.is_corner { 1.0 / corners } else { 0.0 };
                let share = if all > 0.0 { (beside / all + own) / 3.0 } else { own };
                let distance = texel.position.as_dvec3().distance(knot.position);
                let weight = f64::from(open) * distance_weight(texel.area, distance);
                self.ring_nodes.push(RingNode {
                    slot: knot.slot,
                    weight: weight.max(1e-30) as f32,
                    share: share as f32,
                });
                self.on_border[knot.slot as usize] |= open < WHOLLY_OPEN_SHARE;
                if knot.is_outline {
                    let [a, b] = [knot.slot, knots[next(i)].slot];
                    outline.push([a.min(b), a.max(b)]);
                }
            }
            self.first_ring_nodes.push(self.ring_nodes.len() as u32);
        }
        outline.sort_unstable();
        for same in outline.chunk_by(|a, b| a == b).filter(|same| same.len() == 1) {
            for slot in same[0] {
                self.on_border[slot as usize] = true;
            }
        }
    }

    /// Returns the nodes around texel `k`.
    fn nodes_around(&self, k: usize) -> &[RingNode] {
        let [from, to] = [k, k + 1].map(|k| self.first_ring_nodes[k] as usize);
        &self.ring_nodes[from..to]
    }

    /// Returns the mesh texel at a point of a face.
    pub fn texel_at(&self, face: u32, point: DVec3) -> u32 {
        let grid = &self.face_grids[face as usize];
        self.texels[grid.first_texel + grid.texel_at(point) as usize]
    }

    /// Returns the value slot of each node, in the order of the faces.
    pub fn node_slots(&self) -> &[u32] {
        &self.welded.slots
    }

    /// Collects the knots around a texel, counter-clockwise.
    pub fn collect_knots(&self, texel: u32, knots: &mut Vec<RingKnot>) {
        let texel = &self.mesh.texels[texel as usize];
        let grid = &self.face_grids[texel.face as usize];
        let (ring, count) = grid.texel_ring(texel.index);
        knots.clear();
        for k in 0..count {
            let (node, next) = (ring[k], ring[(k + 1) % count]);
            let edge = grid.edge_between(node, next);
            knots.push(RingKnot {
                position: grid.node_position(node),
                slot: self.welded.slots[grid.node_index(node)],
                is_corner: true,
                is_outline: edge.is_some(),
            });
            let Some((edge, [from, to])) = edge else {
                continue;
            };
            let hanging = &self.welded.hanging[4 * texel.face as usize + edge];
            let first = hanging.partition_point(|knot| knot.s <= from);
            let [a, b] = grid.edge_ends(edge);
            let within = hanging[first..].iter().take_while(|knot| knot.s < to);
            knots.extend(within.map(|knot| RingKnot {
                position: a.lerp(b, knot.s),
                slot: knot.slot,
                is_corner: false,
                is_outline: true,
            }));
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
            ring.middle = middle_of(&ring.knots);
        }
        let (knots, middle) = (&ring.knots, ring.middle);
        let normal = self.face_grids[self.mesh.texels[texel as usize].face as usize].normal;
        let (mut slots, mut shares) = ([0, 0], DVec3::X);
        let mut inside = f64::NEG_INFINITY;
        for (k, from) in knots.iter().enumerate() {
            let to = &knots[(k + 1) % knots.len()];
            let own = barycentric_coordinates(from.position - middle, to.position - middle, point - middle, normal);
            // False for NaN. Outside all triangles by rounding, the nearest one is used.
            if own.min_element() > inside {
                (inside, slots, shares) = (own.min_element(), [from.slot, to.slot], own);
            }
        }
        shares = shares.max(DVec3::ZERO);
        shares /= shares.element_sum();
        InterpolationStencil { texel, slots, shares }
    }

    /// Interpolates the light of a solution.
    pub fn interpolate_light(&self, field: &RadiosityField, carried: CarriedLight) -> InterpolatedField<'_> {
        InterpolatedField {
            carried,
            ..self.interpolate_irradiance(&carried.texel_values(self.mesh, field))
        }
    }

    /// Interpolates one irradiance per texel (missing ones are NaN).
    pub fn interpolate_irradiance(&self, values: &[Vec4]) -> InterpolatedField<'_> {
        let own = self.open_values(values);
        let mut nodes = vec![DVec3::ZERO; self.welded.slots.len()];
        let mut weights = vec![0.0; nodes.len()];
        let mut ranges = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; nodes.len()];
        for (k, value) in own.iter().enumerate() {
            for node in self.nodes_around(k) {
                let slot = node.slot as usize;
                nodes[slot] += value * f64::from(node.weight);
                weights[slot] += f64::from(node.weight);
                if self.open[k] > 0.0 {
                    widen_range(&mut ranges[slot], *value, *value);
                }
            }
        }
        for (node, weight) in nodes.iter_mut().zip(&weights).filter(|(_, weight)| **weight > 0.0) {
            *node /= *weight;
        }
        self.extend_at_borders(&own, &nodes, &mut ranges);
        let all: Vec<u32> = (0..own.len() as u32)
            .filter(|k| self.open[*k as usize] >= WHOLLY_OPEN_SHARE)
            .collect();
        let at_border = |k: &&u32| {
            self.nodes_around(**k as usize)
                .iter()
                .any(|node| self.on_border[node.slot as usize])
        };
        let border: Vec<u32> = all.iter().filter(at_border).copied().collect();
        let slots: Vec<u32> = (0..nodes.len() as u32).collect();
        let is_border_slot = |slot: &u32| self.on_border[*slot as usize];
        let border_slots: Vec<u32> = slots.iter().filter(|slot| is_border_slot(slot)).copied().collect();
        self.mirror_at_borders(&border, &own, &mut nodes, &ranges);
        let mut changes = vec![DVec3::ZERO; nodes.len()];
        for step in 0..BORDER_STEPS + MEAN_STEPS {
            let is_last = step >= BORDER_STEPS;
            let (texels, slots) = if is_last {
                (&all, &slots)
            } else {
                (&border, &border_slots)
            };
            slots.iter().for_each(|slot| changes[*slot as usize] = DVec3::ZERO);
            for k in texels {
                let ring = self.nodes_around(*k as usize);
                let mean = ring
                    .iter()
                    .map(|node| nodes[node.slot as usize] * f64::from(node.share));
                let rest = own[*k as usize] - mean.sum::<DVec3>();
                for node in ring.iter().filter(|_| !rest.is_nan()) {
                    changes[node.slot as usize] += rest * f64::from(node.weight);
                }
            }
            for slot in slots.iter().map(|slot| *slot as usize) {
                let (change, [low, high]) = (changes[slot], ranges[slot]);
                if change != DVec3::ZERO && low.cmple(high).all() {
                    nodes[slot] = (nodes[slot] + change / weights[slot]).clamp(low, high);
                }
            }
        }
        let mut knots = Vec::new();
        let middle = |k: usize| {
            self.collect_knots(k as u32, &mut knots);
            let corners = knots.iter().filter(|knot| knot.is_corner);
            corners.clone().map(|knot| nodes[knot.slot as usize]).sum::<DVec3>() / corners.count() as f64
        };
        InterpolatedField {
            surface: self,
            carried: CarriedLight::Irradiance,
            middles: (0..own.len()).map(middle).collect(),
            nodes,
        }
    }

    /// Returns the value of each texel's open part, at most that of the open texels beside it.
    fn open_values(&self, values: &[Vec4]) -> Vec<DVec3> {
        let value = |k: usize| values.get(k).map_or(DVec3::NAN, |v| v.truncate().as_dvec3());
        let open_part = |k: usize| value(k) / f64::from(self.open[k]);
        let mut most = vec![DVec3::NEG_INFINITY; self.welded.slots.len()];
        for k in (0..self.open.len()).filter(|k| self.open[*k] >= WHOLLY_OPEN_SHARE) {
            for node in self.nodes_around(k) {
                most[node.slot as usize] = most[node.slot as usize].max(open_part(k));
            }
        }
        let open_value = |(k, open): (usize, &f32)| match *open {
            open if open <= 0.0 => value(k),
            open if open >= WHOLLY_OPEN_SHARE => open_part(k),
            _ => {
                let beside = self.nodes_around(k).iter().map(|node| most[node.slot as usize]);
                let most = beside.reduce(DVec3::max).filter(|most| most.is_finite());
                most.map_or(open_part(k), |most| open_part(k).min(most.max(value(k))))
            }
        };
        self.open.iter().enumerate().map(open_value).collect()
    }

    /// Sets the nodes on borders of quads to what mirrors the node across the texel's middle, so that a linear light is
    /// exact there.
    fn mirror_at_borders(&self, texels: &[u32], own: &[DVec3], nodes: &mut [DVec3], ranges: &[[DVec3; 2]]) {
        let mut sums = vec![(DVec3::ZERO, 0.0); nodes.len()];
        for k in texels
            .iter()
            .map(|k| *k as usize)
            .filter(|k| self.nodes_around(*k).len() == 4)
        {
            let ring = self.nodes_around(k);
            for (node, across) in ring.iter().zip(ring.iter().cycle().skip(2)) {
                if self.on_border[node.slot as usize] && !self.on_border[across.slot as usize] {
                    let weight = f64::from(node.weight);
                    let (sum, all) = &mut sums[node.slot as usize];
                    *sum += weight * (2.0 * own[k] - nodes[across.slot as usize]);
                    *all += weight;
                }
            }
        }
        for (slot, (sum, all)) in sums.into_iter().enumerate().filter(|(_, (_, all))| *all > 0.0) {
            let [low, high] = ranges[slot];
            nodes[slot] = (sum / all).clamp(low, high);
        }
    }

    /// Widens the ranges of nodes on borders by what continues the slope of the texels inside, without a change of sign.
    fn extend_at_borders(&self, own: &[DVec3], nodes: &[DVec3], ranges: &mut [[DVec3; 2]]) {
        for (k, value) in own.iter().enumerate().filter(|(k, _)| self.open[*k] > 0.0) {
            let ring = self.nodes_around(k);
            let mut around = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            for node in ring {
                widen_range(&mut around, nodes[node.slot as usize], nodes[node.slot as usize]);
            }
            let [low, high] = [1, 0].map(|end| 2.0 * value - around[end]);
            let low = DVec3::select(value.cmpge(DVec3::ZERO), low.max(DVec3::ZERO), low);
            let high = DVec3::select(value.cmple(DVec3::ZERO), high.min(DVec3::ZERO), high);
            for node in ring.iter().filter(|node| self.on_border[node.slot as usize]) {
                widen_range(&mut ranges[node.slot as usize], low, high);
            }
        }
    }
}

/// Extends a range to contain two values.
fn widen_range(range: &mut [DVec3; 2], low: DVec3, high: DVec3) {
    *range = [range[0].min(low), range[1].max(high)];
}

/// Returns the mean of a ring's corners.
fn middle_of(knots: &[RingKnot]) -> DVec3 {
    let corners = knots.iter().filter(|knot| knot.is_corner);
    corners.clone().map(|knot| knot.position).sum::<DVec3>() / corners.count() as f64
}

/// Cached knots of one texel: successive points mostly lie in one texel.
#[derive(Default)]
pub struct KnotCache {
    texel: Option<u32>,
    middle: DVec3,
    knots: Vec<RingKnot>,
}

/// Interpolation weights of a point: a texel's middle and two successive knots of its ring.
#[derive(Clone, Copy, Debug)]
pub struct InterpolationStencil {
    /// Texel.
    pub texel: u32,
    /// Value slots of the two knots.
    pub slots: [u32; 2],
    /// Weights of middle and knots, not negative, with sum 1.
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
    carried: CarriedLight,
    /// Values of the texels' middles and of the slots.
    middles: Vec<DVec3>,
    nodes: Vec<DVec3>,
}

impl InterpolatedField<'_> {
    /// Returns the value at a point of a face.
    pub fn value_at(&self, face: u32, point: DVec3) -> DVec3 {
        self.stencil_value(&self.surface.stencil_at(self.surface.texel_at(face, point), point))
    }

    /// Returns B and the interpolated light at a point of a face.
    pub fn light_at(&self, face: u32, point: DVec3) -> [Vec3; 2] {
        let stencil = self.surface.stencil_at(self.surface.texel_at(face, point), point);
        [self.radiosity_at(&stencil), self.stencil_value(&stencil).as_vec3()]
    }

    /// Returns the value of a slot.
    pub fn slot_value(&self, slot: u32) -> DVec3 {
        self.nodes[slot as usize]
    }

    /// Returns the value at a stencil's point.
    pub fn stencil_value(&self, stencil: &InterpolationStencil) -> DVec3 {
        let InterpolationStencil { texel, slots, shares } = stencil;
        let [a, b] = slots.map(|slot| self.nodes[slot as usize]);
        // A share of 0 must not propagate NaN: a texel without triangles has no nodes.
        let part = |share: f64, value: DVec3| {
            if share > 0.0 { value * share } else { DVec3::ZERO }
        };
        part(shares.x, self.middles[*texel as usize]) + part(shares.y, a) + part(shares.z, b)
    }

    /// Returns radiosity at a stencil's point.
    pub fn radiosity_at(&self, stencil: &InterpolationStencil) -> Vec3 {
        let texel = &self.surface.mesh.texels[stencil.texel as usize];
        self.carried
            .convert_to_radiosity(texel, self.stencil_value(stencil).as_vec3())
    }
}

/// Returns the barycentric coordinates of p in the triangle (0, a, b); NaN without area.
fn barycentric_coordinates(a: DVec3, b: DVec3, p: DVec3, normal: DVec3) -> DVec3 {
    let cross = |x: DVec3, y: DVec3| normal.dot(x.cross(y));
    let area = cross(a, b);
    let (s, t) = (cross(p, b) / area, cross(a, p) / area);
    DVec3::new(1.0 - s - t, s, t)
}
