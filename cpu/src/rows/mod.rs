//! A cell's links to all texels, with rays only where they can matter. The texels outside the
//! shadows of what lies between two faces need none, and far from the cell only one form factor.
//! The links are those of [`crate::twin::link::sample`], bit for bit.

pub mod candidates;
pub(crate) mod lanes;
pub mod receivers;
pub(crate) mod shadow;

use crate::occlusion::occluders::Occluders;
use crate::rows::candidates::{Between, MOST};
use crate::rows::lanes::{Lane, Points, are_far, below, form_factors, stop, weights};
use crate::rows::receivers::{Block, LANES, Receivers};
use crate::rows::shadow::{Shadow, shadow};
use crate::twin::link::{Sums, factor, sample};
use common::constants::{CONTACT, LOW, MISS, NEAR};
use common::form_factor::{FormFactor, Shooter};
use common::intersect::touches;
use common::mesh::{Cell, Cover, Mesh, MeshFace, reach};
use common::rays::{Rays, Sight};
use glam::Vec3;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use std::ops::Range;

/// Texels per task: long enough to hide the task, short enough to share.
const TASK: usize = 4096;
/// Fewer texels than this do not pay for a block's registers.
const FEW: usize = 6;

/// A cell whose corners are higher than this above a receiver's plane is clipped to no point's
/// horizon (half of CONTACT is for the rounding).
const ABOVE: f32 = -CONTACT / 2.0;
/// Nor does it only touch that of any point, if one of them is higher than this.
const CLEAR: f32 = 1.5 * CONTACT;

/// What makes rows.
pub struct Rows<'a> {
    /// The scene.
    pub mesh: &'a Mesh,
    /// Form factor.
    pub kind: FormFactor,
    /// All faces, for rays.
    pub rays: &'a Rays,
    /// All faces, for shadows.
    pub occluders: &'a Occluders,
    /// All texels.
    pub receivers: &'a Receivers,
    /// The widest registers.
    pub arch: Arch,
}

/// A cell and one of the faces that it shines on.
struct Pair<'a> {
    number: u32,
    cell: &'a Cell,
    face: u32,
    target: &'a MeshFace,
    above: bool,
    /// Some texel may see the cell low above its horizon.
    low: bool,
    /// The face reaches behind the cell, where a texel's points see nothing of it.
    behind: bool,
    reach: f32,
}

/// What may stop a ray: these faces, or whatever the hierarchy finds.
struct Stops<'a> {
    faces: &'a [u32],
    rays: bool,
    /// Texels of the block.
    count: usize,
}

/// A face that may come between, and where.
type Occluder = (u32, Shadow);

/// The links of one cell to one face: not a closure, whose call would lose the registers on its way.
struct Target<'a> {
    rows: &'a Rows<'a>,
    pair: &'a Pair<'a>,
    shadows: &'a [Occluder],
    rays: bool,
    links: &'a mut [f32],
}

impl NullaryFnOnce for Target<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.rows
            .face(self.pair, self.shadows, self.rays, self.links);
    }
}

impl Rows<'_> {
    /// The links of cell `number`; `between` its face and every other one.
    pub fn fill(&self, number: u32, between: &[Between], links: &mut [f32]) {
        let mut parts = Vec::new();
        let (mut faces, mut rest) = (0..between.len(), links);
        while !faces.is_empty() {
            let first = faces.start;
            let mut count = 0;
            while count < TASK && !faces.is_empty() {
                count += self.receivers.faces[faces.start].texels.len();
                faces.start += 1;
            }
            let (part, after) = rest.split_at_mut(count);
            parts.push((first..faces.start, part));
            rest = after;
        }
        parts
            .into_par_iter()
            .for_each(|(faces, links)| self.part(number, between, faces, links));
    }

    /// Those to some of the faces.
    fn part(&self, number: u32, between: &[Between], faces: Range<usize>, mut links: &mut [f32]) {
        let cell = &self.mesh.cells[number as usize];
        let mut shadows = Vec::new();
        for face in faces {
            let between = &between[face];
            let texels = self.receivers.faces[face].texels.clone();
            let (own, after) = std::mem::take(&mut links).split_at_mut(texels.len());
            links = after;
            let links = own;
            if *between == Between::Unseen {
                links.fill(0.0);
                continue;
            }
            if *between == Between::All && texels.len() < FEW {
                self.one_by_one(number, texels, links);
                continue;
            }
            let face = face as u32;
            let pair = self.pair(number, cell, face);
            let rays = *between == Between::All;
            shadows.clear();
            if let Between::Faces(faces) = between {
                self.shadows(&pair, faces, &mut shadows);
            }
            self.arch.dispatch(Target {
                rows: self,
                pair: &pair,
                shadows: &shadows,
                rays,
                links,
            });
        }
    }

    /// Too few texels for a block.
    fn one_by_one(&self, number: u32, texels: Range<usize>, links: &mut [f32]) {
        let shooter = &self.mesh.cells[number as usize];
        for (link, k) in links.iter_mut().zip(texels) {
            let ends = [shooter.face, self.mesh.texels[k].face];
            let mut sums = Sums {
                form_factor: factor(self.mesh, self.kind, number, k as u32),
                ..Sums::default()
            };
            for s in 0..self.mesh.samples {
                sample(self.mesh, number, k as u32, s, &mut sums, |q, p| {
                    self.rays.sight(q, p, ends, false)
                });
            }
            *link = sums.link(shooter.open);
        }
    }

    fn pair<'a>(&'a self, number: u32, cell: &'a Cell, face: u32) -> Pair<'a> {
        let target = &self.mesh.faces[face as usize];
        let normal = target.plane.truncate();
        let heights = cell.shooter.corners.map(|c| normal.dot(c) - target.plane.w);
        let highest = heights.into_iter().fold(-MISS, f32::max);
        let distances = target.corners.map(|c| c.distance(cell.shooter.centre));
        let farthest = distances.into_iter().fold(0.0, f32::max);
        Pair {
            number,
            cell,
            face,
            target,
            above: heights.into_iter().all(|h| h > ABOVE) && heights.into_iter().any(|h| h > CLEAR),
            // A hundredth and CONTACT are for the rounding.
            low: highest - CONTACT <= 1.01 * LOW * farthest,
            behind: target.corners.into_iter().any(|corner| {
                let shooter = &cell.shooter;
                shooter.normal.dot(corner - shooter.centre) < -CONTACT
            }),
            reach: reach(cell, target),
        }
    }

    fn shadows(&self, pair: &Pair, faces: &[u32], found: &mut Vec<Occluder>) {
        let plane = &self.occluders.faces[pair.face as usize].plane;
        let receiver = &self.receivers.faces[pair.face as usize];
        for k in faces {
            let polygon = &self.occluders.faces[*k as usize].polygon;
            let shadow = shadow(&pair.cell.shooter.corners, polygon, plane, receiver);
            if shadow != Shadow::Nowhere {
                found.push((*k, shadow));
            }
        }
    }

    #[inline(always)]
    fn face(&self, pair: &Pair, shadows: &[Occluder], rays: bool, links: &mut [f32]) {
        let covered = pair.cell.open < 1.0;
        let receiver = &self.receivers.faces[pair.face as usize];
        for (block, links) in receiver.blocks.iter().zip(links.chunks_mut(LANES)) {
            let mut over = [0u32; MOST];
            let mut count = 0;
            for (k, shadow) in shadows {
                if shadow.falls(block.low, block.high) {
                    over[count] = *k;
                    count += 1;
                }
            }
            let occluders = &over[..count];
            let mut far = [true; LANES];
            if self.mesh.samples > 1 {
                let centre = pair.cell.shooter.centre;
                far = are_far(self.receivers, block.first, centre, pair.reach);
            }
            // What follows the block is not the cell's to judge.
            far[block.count..].fill(true);
            let near = far.contains(&false);
            let mut form_factor = self.centre(pair, block);
            if near {
                let mean = self.near(pair, block);
                for l in 0..LANES {
                    form_factor[l] = if far[l] { form_factor[l] } else { mean[l] };
                }
            }
            let whole = pair.above || self.mesh.samples == 1;
            if rays || covered || pair.behind || !whole || !occluders.is_empty() {
                let stops = Stops {
                    faces: occluders,
                    rays,
                    count: block.count,
                };
                self.sampled(pair, block, &form_factor, &stops, links);
            } else {
                links.copy_from_slice(&form_factor[..links.len()]);
            }
        }
    }

    #[inline(always)]
    fn centre(&self, pair: &Pair, block: &Block) -> [f32; LANES] {
        let points = Points::centres(self.receivers, block.first);
        self.form_factors(pair, &pair.cell.shooter, &points, block)
    }

    /// The mean over places of each texel.
    #[inline(always)]
    fn near(&self, pair: &Pair, block: &Block) -> Lane {
        let mut sum = [0.0; LANES];
        for place in 0..NEAR * NEAR {
            let points = Points::placed(self.receivers, pair.target, block, place);
            let f = self.form_factors(pair, &pair.cell.shooter, &points, block);
            for l in 0..LANES {
                sum[l] += f[l] * points.weight[l];
            }
        }
        sum.map(|sum| sum / (NEAR * NEAR) as f32)
    }

    #[inline(always)]
    fn form_factors(
        &self,
        pair: &Pair,
        shooter: &Shooter,
        points: &Points,
        block: &Block,
    ) -> [f32; LANES] {
        let area = &self.receivers.area[block.first..block.first + LANES];
        let normal = |_| pair.target.normal;
        form_factors(
            self.kind,
            shooter,
            pair.above && !pair.low,
            points,
            normal,
            area,
        )
    }

    /// Σ over the samples, where one of them may be hidden or the texels are near.
    #[inline(always)]
    fn sampled(&self, pair: &Pair, block: &Block, f: &Lane, stops: &Stops, links: &mut [f32]) {
        let samples = self.mesh.samples;
        let normal = |_| pair.target.normal;
        let part = pair.cell.shooter.area / samples as f32;
        let (mut seen, mut all) = ([0.0; LANES], [0.0; LANES]);
        for s in 0..samples {
            let q = &self.mesh.points[(pair.number * samples + s) as usize];
            let shooter = Shooter {
                centre: q.position,
                ..pair.cell.shooter
            };
            let points = if samples == 1 {
                Points::centres(self.receivers, block.first)
            } else {
                Points::sampled(self.receivers, pair.target, block, pair.number, s)
            };
            let g = weights(&shooter, &points, normal, (part, q.weight), f);
            for l in 0..LANES {
                all[l] += g[l];
            }
            if q.cover != Cover::Open {
                continue;
            }
            let mut stopped = self.stopped(pair, q.position, &points, &g, stops);
            if samples > 1 {
                below(&points, normal, q.position, &mut stopped);
            }
            for l in 0..LANES {
                seen[l] += if stopped[l] { 0.0 } else { g[l] };
            }
        }
        for (l, link) in links.iter_mut().enumerate() {
            let share = seen[l] / (all[l] * pair.cell.open);
            *link = if seen[l] <= 0.0 { 0.0 } else { f[l] * share };
        }
    }

    /// Which of the points do not see `q`.
    #[inline(always)]
    fn stopped(
        &self,
        pair: &Pair,
        q: Vec3,
        points: &Points,
        g: &Lane,
        stops: &Stops,
    ) -> [bool; LANES] {
        let mut stopped = [false; LANES];
        for k in stops.faces {
            let face = &self.mesh.faces[*k as usize];
            if !touches(face, q) {
                stop(face, q, points, &mut stopped);
            }
        }
        if stops.rays {
            let ends = [pair.cell.face, pair.face];
            // What follows the block is nobody's.
            for l in 0..stops.count {
                stopped[l] =
                    g[l] > 0.0 && self.rays.sight(q, points.at(l), ends, false) != Sight::Clear;
            }
        }
        stopped
    }
}
