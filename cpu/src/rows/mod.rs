//! A row: the links of a patch to all texels, with rays only where they can matter. Texels outside all shadow regions
//! need no rays, and texels far from the patch need one form factor only.
//! The links are those of [`crate::rows::texel_link::add_sample`], bit for bit.

pub mod candidates;
mod clipped_lanes;
pub(crate) mod lane_points;
pub(crate) mod lanes;
pub mod receivers;
pub(crate) mod shadow;
pub mod texel_link;

use crate::occlusion::occluders::Occluders;
use crate::rows::candidates::{MAX_CANDIDATES, OccluderCandidates};
use crate::rows::lane_points::{LanePoints, LaneValues};
use crate::rows::lanes::{are_far, lane_form_factors, mark_below_horizon, mark_blocked, pair_weights};
use crate::rows::receivers::{LANE_COUNT, TexelArrays, TexelBlock};
use crate::rows::shadow::{ShadowRegion, penumbra_region};
use crate::rows::texel_link::link_texel;
use common::constants::{CONTACT_DISTANCE, MAX_GRAZING_HEIGHT_RATIO, MISS_DISTANCE, NEAR_POINTS_PER_SIDE};
use common::form_factor::{FormFactor, Shooter};
use common::intersect::touches_plane;
use common::mesh::{Cover, Mesh, MeshFace, Patch, far_distance};
use common::rays::{LineOfSight, Rays};
use glam::Vec3;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use std::ops::Range;

/// Texels per task: enough to hide the overhead, few enough to balance threads.
const TEXELS_PER_TASK: usize = 4096;
/// Fewest texels for which vector registers pay.
const MIN_BLOCK_TEXELS: usize = 6;

/// A patch whose corners are all higher than this above a receiver's plane is clipped at no horizon (half of the
/// contact distance allows for rounding).
const MIN_UNCLIPPED_HEIGHT: f32 = -CONTACT_DISTANCE / 2.0;
/// Such a patch does not merely touch the plane if one corner is higher than this.
const MIN_CLEAR_HEIGHT: f32 = 1.5 * CONTACT_DISTANCE;

/// Computes rows.
pub struct RowBuilder<'a> {
    /// Patches and texels.
    pub mesh: &'a Mesh,
    /// Kind of form factor.
    pub kind: FormFactor,
    /// All faces, for rays.
    pub rays: &'a Rays,
    /// All faces, for shadows.
    pub occluders: &'a Occluders,
    /// All texels.
    pub receivers: &'a TexelArrays,
    /// The widest registers.
    pub arch: Arch,
}

/// A patch and a receiving face.
struct PatchFacePair<'a> {
    number: u32,
    patch: &'a Patch,
    face: u32,
    target: &'a MeshFace,
    above: bool,
    /// A texel may see the patch low above its horizon.
    low: bool,
    /// A part of the face lies behind the patch.
    behind: bool,
    reach: f32,
}

/// Possible occluders of a block.
struct RowOccluders<'a> {
    faces: &'a [u32],
    rays: bool,
    /// Number of texels of the block.
    count: usize,
}

/// A possible occluder and its shadow region.
type Occluder = (u32, ShadowRegion);

/// Computes the links of one patch to one face. Not a closure: its call would not be vectorised.
struct FaceLinksTask<'a> {
    rows: &'a RowBuilder<'a>,
    pair: &'a PatchFacePair<'a>,
    shadows: &'a [Occluder],
    rays: bool,
    links: &'a mut [f32],
}

impl NullaryFnOnce for FaceLinksTask<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.rows.fill_face(self.pair, self.shadows, self.rays, self.links);
    }
}

impl RowBuilder<'_> {
    /// Fills the links of patch `number`; `between` holds the candidates between its face and each other face.
    pub fn fill_row(&self, number: u32, between: &[OccluderCandidates], links: &mut [f32]) {
        let mut parts = Vec::new();
        let (mut faces, mut rest) = (0..between.len(), links);
        while !faces.is_empty() {
            let first = faces.start;
            let mut count = 0;
            while count < TEXELS_PER_TASK && !faces.is_empty() {
                count += self.receivers.faces[faces.start].texels.len();
                faces.start += 1;
            }
            let (part, after) = rest.split_at_mut(count);
            parts.push((first..faces.start, part));
            rest = after;
        }
        parts
            .into_par_iter()
            .for_each(|(faces, links)| self.fill_faces(number, between, faces, links));
    }

    /// Fills the links to some of the faces.
    fn fill_faces(&self, number: u32, between: &[OccluderCandidates], faces: Range<usize>, mut links: &mut [f32]) {
        let patch = &self.mesh.patches[number as usize];
        let mut shadows = Vec::new();
        for face in faces {
            let between = &between[face];
            let texels = self.receivers.faces[face].texels.clone();
            let (own, after) = std::mem::take(&mut links).split_at_mut(texels.len());
            links = after;
            let links = own;
            if *between == OccluderCandidates::Unseen {
                links.fill(0.0);
                continue;
            }
            if *between == OccluderCandidates::All && texels.len() < MIN_BLOCK_TEXELS {
                self.fill_one_by_one(number, texels, links);
                continue;
            }
            let face = face as u32;
            let pair = self.patch_face_pair(number, patch, face);
            let rays = *between == OccluderCandidates::All;
            shadows.clear();
            if let OccluderCandidates::Faces(faces) = between {
                self.find_shadows(&pair, faces, &mut shadows);
            }
            self.arch.dispatch(FaceLinksTask {
                rows: self,
                pair: &pair,
                shadows: &shadows,
                rays,
                links,
            });
        }
    }

    /// Fills the links of too few texels for a block.
    fn fill_one_by_one(&self, number: u32, texels: Range<usize>, links: &mut [f32]) {
        let shooter = &self.mesh.patches[number as usize];
        for (link, k) in links.iter_mut().zip(texels) {
            let ends = [shooter.face, self.mesh.texels[k].face];
            let sums = link_texel(self.mesh, self.kind, number, k as u32, |q, p| {
                self.rays.find_sight(q, p, ends, false)
            });
            *link = sums.link_weight(shooter.open_share);
        }
    }

    fn patch_face_pair<'a>(&'a self, number: u32, patch: &'a Patch, face: u32) -> PatchFacePair<'a> {
        let target = &self.mesh.faces[face as usize];
        let normal = target.plane.truncate();
        let heights = patch.shooter.corners.map(|c| normal.dot(c) - target.plane.w);
        let highest = heights.into_iter().fold(-MISS_DISTANCE, f32::max);
        let distances = target.corners.map(|c| c.distance(patch.shooter.centre));
        let farthest = distances.into_iter().fold(0.0, f32::max);
        PatchFacePair {
            number,
            patch,
            face,
            target,
            above: heights.into_iter().all(|h| h > MIN_UNCLIPPED_HEIGHT)
                && heights.into_iter().any(|h| h > MIN_CLEAR_HEIGHT),
            // The hundredth and the contact distance allow for rounding.
            low: highest - CONTACT_DISTANCE <= 1.01 * MAX_GRAZING_HEIGHT_RATIO * farthest,
            behind: target.corners.into_iter().any(|corner| {
                let shooter = &patch.shooter;
                shooter.normal.dot(corner - shooter.centre) < -CONTACT_DISTANCE
            }),
            reach: far_distance(patch, target),
        }
    }

    fn find_shadows(&self, pair: &PatchFacePair, faces: &[u32], found: &mut Vec<Occluder>) {
        let plane = &self.occluders.faces[pair.face as usize].plane;
        let receiver = &self.receivers.faces[pair.face as usize];
        for k in faces {
            let polygon = &self.occluders.faces[*k as usize].polygon;
            let shadow = penumbra_region(&pair.patch.shooter.corners, polygon, plane, receiver);
            if shadow != ShadowRegion::Nowhere {
                found.push((*k, shadow));
            }
        }
    }

    #[inline(always)]
    fn fill_face(&self, pair: &PatchFacePair, shadows: &[Occluder], rays: bool, links: &mut [f32]) {
        let covered = pair.patch.open_share < 1.0;
        let receiver = &self.receivers.faces[pair.face as usize];
        for (block, links) in receiver.blocks.iter().zip(links.chunks_mut(LANE_COUNT)) {
            let mut over = [0u32; MAX_CANDIDATES];
            let mut count = 0;
            for (k, shadow) in shadows {
                if shadow.may_overlap(block.low, block.high) {
                    over[count] = *k;
                    count += 1;
                }
            }
            let occluders = &over[..count];
            let mut far = [true; LANE_COUNT];
            if self.mesh.samples > 1 {
                let centre = pair.patch.shooter.centre;
                far = are_far(self.receivers, block.first, centre, pair.reach);
            }
            // The lanes after the block's texels are not used.
            far[block.count..].fill(true);
            let near = far.contains(&false);
            let mut form_factor = self.centre_factors(pair, block);
            if near {
                let mean = self.mean_factors(pair, block);
                for l in 0..LANE_COUNT {
                    form_factor[l] = if far[l] { form_factor[l] } else { mean[l] };
                }
            }
            let whole = pair.above || self.mesh.samples == 1;
            if rays || covered || pair.behind || !whole || !occluders.is_empty() {
                let stops = RowOccluders {
                    faces: occluders,
                    rays,
                    count: block.count,
                };
                self.sample_links(pair, block, &form_factor, &stops, links);
            } else {
                links.copy_from_slice(&form_factor[..links.len()]);
            }
        }
    }

    #[inline(always)]
    fn centre_factors(&self, pair: &PatchFacePair, block: &TexelBlock) -> [f32; LANE_COUNT] {
        let points = LanePoints::texel_centres(self.receivers, block.first);
        self.form_factors(pair, &pair.patch.shooter, &points, block)
    }

    /// Returns the mean of F over a grid of points on each texel.
    #[inline(always)]
    fn mean_factors(&self, pair: &PatchFacePair, block: &TexelBlock) -> LaneValues {
        let mut sum = [0.0; LANE_COUNT];
        for place in 0..NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE {
            let points = LanePoints::grid_points(self.receivers, pair.target, block, place);
            let f = self.form_factors(pair, &pair.patch.shooter, &points, block);
            for l in 0..LANE_COUNT {
                sum[l] += f[l] * points.weight[l];
            }
        }
        sum.map(|sum| sum / (NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE) as f32)
    }

    #[inline(always)]
    fn form_factors(
        &self,
        pair: &PatchFacePair,
        shooter: &Shooter,
        points: &LanePoints,
        block: &TexelBlock,
    ) -> [f32; LANE_COUNT] {
        let area = &self.receivers.area[block.first..block.first + LANE_COUNT];
        let normal = |_| pair.target.normal;
        lane_form_factors(self.kind, shooter, pair.above && !pair.low, points, normal, area)
    }

    /// Fills links by samples, where one may be occluded or texels are near.
    #[inline(always)]
    fn sample_links(
        &self,
        pair: &PatchFacePair,
        block: &TexelBlock,
        f: &LaneValues,
        stops: &RowOccluders,
        links: &mut [f32],
    ) {
        let samples = self.mesh.samples;
        let normal = |_| pair.target.normal;
        let part = pair.patch.shooter.area / samples as f32;
        let (mut seen, mut all) = ([0.0; LANE_COUNT], [0.0; LANE_COUNT]);
        for s in 0..samples {
            let q = &self.mesh.patch_points[(pair.number * samples + s) as usize];
            let shooter = Shooter {
                centre: q.position,
                ..pair.patch.shooter
            };
            let points = if samples == 1 {
                LanePoints::texel_centres(self.receivers, block.first)
            } else {
                LanePoints::texel_samples(self.receivers, pair.target, block, pair.number, s)
            };
            let g = pair_weights(&shooter, &points, normal, (part, q.weight), f);
            for l in 0..LANE_COUNT {
                all[l] += g[l];
            }
            if q.cover != Cover::Open {
                continue;
            }
            let mut blocked = self.blocked_lanes(pair, q.position, &points, &g, stops);
            if samples > 1 {
                mark_below_horizon(&points, normal, q.position, &mut blocked);
            }
            for l in 0..LANE_COUNT {
                seen[l] += if blocked[l] { 0.0 } else { g[l] };
            }
        }
        for (l, link) in links.iter_mut().enumerate() {
            let share = seen[l] / (all[l] * pair.patch.open_share);
            *link = if seen[l] <= 0.0 { 0.0 } else { f[l] * share };
        }
    }

    /// Returns the lanes whose points do not see `q`.
    #[inline(always)]
    fn blocked_lanes(
        &self,
        pair: &PatchFacePair,
        q: Vec3,
        points: &LanePoints,
        g: &LaneValues,
        stops: &RowOccluders,
    ) -> [bool; LANE_COUNT] {
        let mut blocked = [false; LANE_COUNT];
        for k in stops.faces {
            let face = &self.mesh.faces[*k as usize];
            if !touches_plane(face, q) {
                mark_blocked(face, q, points, &mut blocked);
            }
        }
        if stops.rays {
            let ends = [pair.patch.face, pair.face];
            // The lanes after the block's texels are not used.
            for l in 0..stops.count {
                blocked[l] = g[l] > 0.0 && self.rays.find_sight(q, points.at(l), ends, false) != LineOfSight::Clear;
            }
        }
        blocked
    }
}
