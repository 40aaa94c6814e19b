//! The rays of relighting: what each meets with the objects, and what it would meet without them.
//!
//! Ray n of a block of texels is up to three: one in a direction drawn by the cosine, one to a texel of the room that is
//! drawn by its captured light, and one to a texel of an object. Each is weighted by the balance heuristic (Veach & Guibas
//! 1995) over the three densities of its direction:
//!
//! ```text
//! K  B  = Σ w B(texel that the ray meets)
//! T     = Σ w B₀(texel of the room behind an object)      on the room; exactly 0 where no ray meets an object
//! w     = by cosine/(n Σ densities)
//! ```
//! Rays of the room to other parts of it matter only where an object is between: those that pass the objects by are not
//! traced. Rays start on the open parts of texels.

use super::lamp_tree::{Lamp, LampChoice, LampCut, LampTree, MAX_CUT_NODES, Receiver};
use super::texel_blocks::TexelBlocks;
use super::texel_rays::NO_TEXEL;
use super::{Halves, KeptRays, sample_variance};
use crate::dense::open_points::{OpenParts, draw_point};
use crate::hierarchy::relight::RoomLight;
use common::constants::OUTLINE_MARGIN;
use common::escape::concentric_direction;
use common::mesh::Mesh;
use common::rays::Rays;
use common::sampling::pcg_hash;
use common::texel_point::{SampledOutline, TexelLookup, texel_corners};
use common::{Error, Result};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use sobol_burley::sample_4d;
use std::f32::consts::PI;
use std::ops::ControlFlow;

/// Blocks between two calls of the progress callback.
const BLOCKS_PER_TASK: usize = 1 << 12;
/// Blocks that choose among the same groups of texels.
const BLOCKS_PER_GROUP: usize = 64;

/// Largest ρ times the sum of a texel's form factors.
const MAX_GAIN: f32 = 0.999;

/// Radiosity, or its change, of a texel of the room over the mean of all from which on rays are drawn to it.
const MIN_BRIGHTNESS: f32 = 2.0;

/// Width by which the box around the objects is enlarged: more than a ray's rounding.
const BOX_MARGIN: f32 = 16.0 * OUTLINE_MARGIN;

/// A texel that a ray meets.
#[derive(Clone, Copy)]
struct TexelHit {
    texel: u32,
    face: u32,
    point: Vec3,
}

/// The rays of one block of texels.
#[derive(Clone, Default)]
struct PairRecord {
    /// The texels that each ray's three parts meet, or [`NO_TEXEL`], and their weights; the two halves alternate.
    met: Vec<[(u32, f32); 3]>,
    /// Sum of the light that objects hide, of each half.
    hidden: Halves,
    /// Sum of its squares over both halves.
    hidden_squares: Vec3A,
    /// Factor of each half's form factors by which no bounce gains.
    limit: [f32; 2],
}

/// Texels to which rays are drawn, by their power.
struct TargetTexels {
    tree: LampTree,
    /// The nodes among which each group of blocks chooses.
    cuts: Vec<LampCut>,
}

/// The rays of all blocks of texels.
pub struct PairRays<'a> {
    mesh: &'a Mesh,
    blocks: &'a TexelBlocks,
    rays: &'a Rays,
    /// The room without the objects.
    room_rays: Rays,
    /// Radiosity that the system does not solve for, as the room receives it: E on the objects.
    emitted: Vec<Vec3A>,
    /// The same as the objects receive it: B₀ on the room, too.
    given: Vec<Vec3A>,
    open: &'a OpenParts,
    lookup: TexelLookup<'a>,
    /// Bright texels of the room.
    room: TargetTexels,
    /// Texels of the objects by what they hide and emit, and those of the room that changed much.
    changed: TargetTexels,
    /// Texels of the objects by what they emit.
    emitters: TargetTexels,
    /// The box around the objects.
    bounds: [Vec3; 2],
    records: Vec<PairRecord>,
    /// Number of the sequence of random numbers; another one after rays were discarded.
    sequence: u32,
}

impl<'a> PairRays<'a> {
    /// Makes the `blocks` of the texels of `mesh` with their `open` parts, without rays.
    pub fn new(
        (mesh, blocks): (&'a Mesh, &'a TexelBlocks),
        rays: &'a Rays,
        open: &'a OpenParts,
        known: &RoomLight,
    ) -> Self {
        let is_object = |k: usize| mesh.is_object(mesh.texels[k].face);
        let texels = || 0..mesh.texels.len();
        let emitted = |k: usize| match is_object(k) {
            true => mesh.texels[k].emission.into(),
            false => Vec3A::ZERO,
        };
        let emitted: Vec<Vec3A> = texels().map(emitted).collect();
        let given = |k: usize| match is_object(k) {
            true => emitted[k],
            false => known.radiosity[k].into(),
        };
        let given: Vec<Vec3A> = texels().map(given).collect();
        let mean = mean_brightness(mesh, &given);
        let bright = |k: usize| match is_object(k) {
            true => 0.0,
            false => sum_channels(given[k], MIN_BRIGHTNESS * mean),
        };
        let corners = mesh.faces.iter().skip(mesh.room_faces as usize).flat_map(|f| f.corners);
        let empty = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let around = |[low, high]: [Vec3; 2], c: Vec3| [low.min(c - BOX_MARGIN), high.max(c + BOX_MARGIN)];
        let targets = (mesh, blocks, &open.shares[..]);
        Self {
            room: TargetTexels::new(targets, bright),
            changed: Self::changed_texels(targets, mean, &emitted),
            emitters: TargetTexels::new(targets, |k| sum_channels(emitted[k], 0.0)),
            bounds: corners.fold(empty, around),
            emitted,
            given,
            mesh,
            blocks,
            rays,
            room_rays: Rays::of_room(mesh),
            open,
            lookup: TexelLookup::new(mesh),
            records: vec![PairRecord::default(); blocks.len()],
            sequence: 0,
        }
    }

    /// Returns the texels of the objects, which hide the `mean` brightness and have this `radiosity`, and those of the room
    /// where it is large.
    fn changed_texels(
        (mesh, blocks, open): (&Mesh, &TexelBlocks, &[f32]),
        mean: f32,
        radiosity: &[Vec3A],
    ) -> TargetTexels {
        let least = MIN_BRIGHTNESS * mean_brightness(mesh, radiosity);
        TargetTexels::new((mesh, blocks, open), |k| match mesh.is_object(mesh.texels[k].face) {
            true => mean + sum_channels(radiosity[k], 0.0),
            false => sum_channels(radiosity[k], least),
        })
    }

    /// Traces rays of block `b` until there are `count` of both halves.
    fn extend_record(&self, b: usize, count: u32, record: &mut PairRecord) {
        let members = self.blocks.members(b);
        let texel = &self.mesh.texels[members[0] as usize];
        let outlines = members
            .iter()
            .flat_map(|k| self.open.outlines_of(self.mesh, *k as usize));
        let outlines: Vec<SampledOutline> = outlines.collect();
        let known = record.met.len() as u32;
        record.met.reserve_exact(count.saturating_sub(known) as usize);
        let of_room = !self.mesh.is_object(texel.face);
        let normal = self.mesh.faces[texel.face as usize].normal;
        let centre = outlines.iter().map(|part| part.corners.iter().sum::<Vec3>() / 4.0);
        let centre = centre.sum::<Vec3>() / outlines.len().max(1) as f32;
        let at = Receiver::around_outlines(centre, &outlines, normal);
        let changed = if of_room { &self.changed } else { &self.emitters };
        let (to_room, to_changed) = (self.room.weigh_for(b, at), changed.weigh_for(b, at));
        for n in known..count {
            let seed = pcg_hash((2 * members[0] + (n & 1)) ^ pcg_hash(self.sequence));
            let [u, v, x, y] = sample_4d(n >> 1, 0, seed);
            let Some(origin) = draw_point(&outlines, [u, v]) else {
                break;
            };
            let from = RayStart {
                pairs: self,
                face: texel.face,
                of_room,
                origin,
                normal,
                to_room: &to_room,
                to_changed: &to_changed,
            };
            let parts = [
                Some(from.trace_by_cosine([x, y])),
                from.trace_to_room(sample_4d(n >> 1, 1, seed)),
                from.trace_to_changed(sample_4d(n >> 1, 2, seed)),
            ];
            let mut hidden = Vec3A::ZERO;
            for (_, back, weight) in parts.iter().flatten().filter(|_| from.of_room) {
                hidden += back.map_or(Vec3A::ZERO, |met| self.given[met.texel as usize] * *weight);
            }
            record.met.push(parts.map(|part| match part {
                Some((Some(front), _, weight)) => (front.texel, weight),
                _ => (NO_TEXEL, 0.0),
            }));
            record.hidden[(n & 1) as usize] += hidden;
            record.hidden_squares += hidden * hidden;
        }
        let reflectances = members
            .iter()
            .map(|k| self.mesh.texels[*k as usize].reflectance.max_element());
        let reflectance = reflectances.fold(0.0, f32::max);
        record.limit = record
            .sum_met(|_, _| Vec3A::ONE)
            .map(|sum| MAX_GAIN / (sum.x * reflectance).max(MAX_GAIN));
    }

    /// Returns the texel at the `distance` of the ray on face `f`.
    fn texel_met(&self, origin: Vec3, direction: Vec3, (f, distance): (u32, f32)) -> TexelHit {
        let point = origin + direction * distance;
        TexelHit {
            texel: self.lookup.texel_at(f, point) as u32,
            face: f,
            point,
        }
    }

    /// Returns the means over the texels' areas of the light on the open part of each block.
    fn spread_over_open(&self, light: Vec<Halves>) -> Vec<Halves> {
        let texels = self.blocks.spread_blocks(&light).into_iter().zip(&self.open.shares);
        texels.map(|(halves, open)| halves.map(|h| h * *open)).collect()
    }

    /// Returns the radiosity that the system does not solve for, as block `b` receives it.
    fn given_to(&self, b: usize) -> &[Vec3A] {
        match self
            .mesh
            .is_object(self.mesh.texels[self.blocks.members(b)[0] as usize].face)
        {
            true => &self.given,
            false => &self.emitted,
        }
    }
}

/// Extends all `records` by `extend`, in parallel.
///
/// Errors: [`Error::Interrupted`].
fn trace_in_tasks<T: Send>(
    records: &mut [T],
    watch: &mut dyn FnMut(f64) -> ControlFlow<()>,
    extend: impl Fn(usize, &mut T) + Sync,
) -> Result<()> {
    let all = records.len() as f64;
    for (task, part) in records.chunks_mut(BLOCKS_PER_TASK).enumerate() {
        let begin = task * BLOCKS_PER_TASK;
        if watch(begin as f64 / all).is_break() {
            return Err(Error::Interrupted);
        }
        let texels = part.par_iter_mut().enumerate();
        texels.for_each(|(k, record)| extend(begin + k, record));
    }
    Ok(())
}

impl PairRecord {
    /// Returns 1 over the number of rays of a half.
    fn half_share(&self) -> f32 {
        2.0 / self.met.len().max(1) as f32
    }

    /// Returns the mean of w·`light` over the rays of each half.
    fn sum_met(&self, light: impl Fn(usize, u32) -> Vec3A) -> Halves {
        let mut sums = [Vec3A::ZERO; 2];
        for (n, parts) in self.met.iter().enumerate() {
            for (k, w) in parts.iter().filter(|(k, _)| *k != NO_TEXEL) {
                sums[n & 1] += light(n & 1, *k) * *w;
            }
        }
        sums.map(|sum| sum * self.half_share())
    }
}

/// The start of a ray.
struct RayStart<'a> {
    pairs: &'a PairRays<'a>,
    face: u32,
    of_room: bool,
    origin: Vec3,
    normal: Vec3,
    /// The choice among bright texels of the room.
    to_room: &'a LampChoice<'a>,
    /// The choice among texels that send light that is not known.
    to_changed: &'a LampChoice<'a>,
}

/// The texel that a ray meets first, that of the room for which rays are drawn, and the ray's weight.
type WeightedRay = (Option<TexelHit>, Option<TexelHit>, f32);

impl RayStart<'_> {
    fn trace_by_cosine(&self, [x, y]: [f32; 2]) -> WeightedRay {
        let along = concentric_direction(f64::from(2.0 * x - 1.0), f64::from(2.0 * y - 1.0));
        let direction = self.pairs.mesh.faces[self.face as usize].direction_in_frame(along);
        let (front, back) = self.find_ends(direction);
        self.weigh_ray(direction, front, back)
    }

    /// Traces a ray to a texel of the room.
    fn trace_to_room(&self, numbers: [f32; 4]) -> Option<WeightedRay> {
        let target = self.draw_target(self.to_room, numbers)?;
        if self.of_room && !crosses_box(self.origin, target.point, self.pairs.bounds) {
            return None;
        }
        let direction = (target.point - self.origin).normalize();
        let (front, back) = self.find_ends(direction);
        let back = back.filter(|met| met.face == target.face).map(|_| target);
        back?;
        let front = if self.of_room { front } else { back };
        Some(self.weigh_ray(direction, front, back))
    }

    /// Traces a ray to a texel of an object, or one of the room that changed much.
    fn trace_to_changed(&self, numbers: [f32; 4]) -> Option<WeightedRay> {
        let target = self.draw_target(self.to_changed, numbers)?;
        let direction = (target.point - self.origin).normalize();
        let (front, back) = self.find_ends(direction);
        let front = front.filter(|met| met.face == target.face).map(|_| target);
        front?;
        Some(self.weigh_ray(direction, front, back))
    }

    /// Draws a point of a texel above the horizon and before whose front the start is.
    fn draw_target(&self, choice: &LampChoice, [number, u, v, _]: [f32; 4]) -> Option<TexelHit> {
        let texel = choice.draw_lamp(number)?.lamp;
        let mesh = self.pairs.mesh;
        let face = mesh.texels[texel as usize].face;
        let point = SampledOutline::new(texel_corners(mesh, &mesh.texels[texel as usize])).point_at([u, v]);
        let ray = point - self.origin;
        let faces = self.normal.dot(ray) > 0.0 && mesh.faces[face as usize].normal.dot(ray) < 0.0;
        faces.then_some(TexelHit { texel, face, point })
    }

    /// Returns what a ray meets first, and the texel of the room for which rays are drawn: from the room the one
    /// behind an object, from objects the one that is met.
    fn find_ends(&self, direction: Vec3) -> (Option<TexelHit>, Option<TexelHit>) {
        let (of, sheet) = (self.pairs, self.pairs.mesh.faces[self.face as usize].sheet);
        let texel_met = |hit| of.texel_met(self.origin, direction, hit);
        let front = of.rays.nearest_face(self.origin, direction, sheet).map(texel_met);
        let on_room = front.is_some_and(|met| !of.mesh.is_object(met.face));
        let back = match (self.of_room, on_room) {
            (true, false) => of.room_rays.nearest_face(self.origin, direction, sheet).map(texel_met),
            (false, true) => front,
            _ => None,
        };
        (front, back)
    }

    /// Weighs a ray by the balance heuristic.
    fn weigh_ray(&self, direction: Vec3, front: Option<TexelHit>, back: Option<TexelHit>) -> WeightedRay {
        let by_cosine = self.normal.dot(direction).max(0.0) / PI;
        let drawn = |met: Option<TexelHit>, choice| met.map_or(0.0, |met| self.direction_density(choice, met));
        let all = by_cosine + drawn(front, self.to_changed) + drawn(back, self.to_room);
        (front, back, if by_cosine > 0.0 { by_cosine / all } else { 0.0 })
    }

    /// Returns the density of the direction to `met` among rays to points drawn by `choice`.
    fn direction_density(&self, choice: &LampChoice, met: TexelHit) -> f32 {
        let drawn = choice.lamp_probability(met.texel);
        if drawn <= 0.0 {
            return 0.0;
        }
        let mesh = self.pairs.mesh;
        let ray = met.point - self.origin;
        let square = ray.length_squared().max(f32::MIN_POSITIVE);
        let sent = -mesh.faces[met.face as usize].normal.dot(ray) / square.sqrt();
        drawn * square / (sent * mesh.texels[met.texel as usize].area).max(f32::MIN_POSITIVE)
    }
}

impl TargetTexels {
    /// Makes the tree of the texels that are `open`, by their power over area, and the nodes for each group of blocks.
    fn new((mesh, blocks, open): (&Mesh, &TexelBlocks, &[f32]), power: impl Fn(usize) -> f32) -> Self {
        let lamp = |k: usize| Lamp {
            number: k as u32,
            corners: texel_corners(mesh, &mesh.texels[k]),
            normal: mesh.faces[mesh.texels[k].face as usize].normal,
            power: power(k) * mesh.texels[k].area,
        };
        let texels = (0..open.len()).filter(|k| open[*k] > 0.0);
        let tree = LampTree::from_lamps(texels.map(lamp), open.len());
        let choose_cut = |group: usize| {
            let members = (group * BLOCKS_PER_GROUP..blocks.len()).take(BLOCKS_PER_GROUP);
            let texels = members.flat_map(|b| blocks.members(b));
            tree.choose_cut(texels.map(|k| mesh.texels[*k as usize].position), MAX_CUT_NODES)
        };
        let groups = (0..blocks.len().div_ceil(BLOCKS_PER_GROUP)).into_par_iter();
        let cuts = groups.map(choose_cut).collect();
        Self { tree, cuts }
    }

    /// Weighs the texels for a block, which receives at `at`.
    fn weigh_for(&self, block: usize, at: Receiver) -> LampChoice<'_> {
        self.tree.weigh_lamps(&self.cuts[block / BLOCKS_PER_GROUP], at)
    }
}

/// Returns the sum of the channels of a radiosity of either sign; 0 below `least`.
fn sum_channels(radiosity: Vec3A, least: f32) -> f32 {
    let sum = radiosity.abs().element_sum();
    if sum >= least { sum } else { 0.0 }
}

/// Returns the mean brightness of the room.
fn mean_brightness(mesh: &Mesh, radiosity: &[Vec3A]) -> f32 {
    let (mut sum, mut area) = (0.0, 0.0);
    let texels = mesh.texels.iter().zip(radiosity);
    for (texel, radiosity) in texels.filter(|(texel, _)| !mesh.is_object(texel.face)) {
        sum += f64::from(sum_channels(*radiosity, 0.0) * texel.area);
        area += f64::from(texel.area);
    }
    if area > 0.0 { (sum / area) as f32 } else { 0.0 }
}

/// Returns whether the line between two points may cross a box.
fn crosses_box(from: Vec3, to: Vec3, [low, high]: [Vec3; 2]) -> bool {
    let inverse = (to - from).recip();
    let (a, b) = ((low - from) * inverse, (high - from) * inverse);
    let enters = a.min(b).max_element().max(0.0);
    let leaves = a.max(b).min_element().min(1.0);
    enters <= leaves
}

impl KeptRays for PairRays<'_> {
    const BYTES_PER_RAY: u64 = 24;
    const FIRST_RAY_COUNT: f32 = 3.0;
    const LEARNS: bool = true;

    fn discard_rays(&mut self, radiosity: &[Vec3A]) {
        self.records.fill(PairRecord::default());
        self.sequence += 1;
        let mean = mean_brightness(self.mesh, &self.given);
        let sent: Vec<Vec3A> = radiosity.iter().zip(&self.emitted).map(|(b, e)| *b + *e).collect();
        self.changed = Self::changed_texels((self.mesh, self.blocks, &self.open.shares), mean, &sent);
    }

    fn trace_rays(&mut self, counts: &[u32], watch: &mut dyn FnMut(f64) -> ControlFlow<()>) -> Result<()> {
        let mut records = std::mem::take(&mut self.records);
        trace_in_tasks(&mut records, watch, |k, record| {
            self.extend_record(k, 2 * counts[k], record)
        })?;
        self.records = records;
        Ok(())
    }

    fn direct_light(&self) -> Vec<Halves> {
        let direct = |(b, own): (usize, &PairRecord)| {
            let given = self.given_to(b);
            let received = own.sum_met(|_, j| given[j as usize]);
            [0, 1].map(|half| received[half] - own.hidden[half] * own.half_share())
        };
        self.spread_over_open(self.records.par_iter().enumerate().map(direct).collect())
    }

    fn gather_radiosity(&self, radiosity: &[Halves]) -> Vec<Halves> {
        let gather = |own: &PairRecord| {
            let received = own.sum_met(|half, j| radiosity[j as usize][half]);
            [0, 1].map(|half| received[half] * own.limit[half])
        };
        self.spread_over_open(self.records.par_iter().map(gather).collect())
    }

    fn smooth_light(&self, _: &[Halves], _: &[Vec3A]) -> Option<[Vec<Halves>; 2]> {
        None
    }

    fn ray_variances(&self, radiosity: &[Vec3A]) -> Vec<Vec3A> {
        let variance = |(b, own): (usize, &PairRecord)| {
            let given = self.given_to(b);
            let (mut sum, mut squares) = (Vec3A::ZERO, Vec3A::ZERO);
            for parts in &own.met {
                let met = parts.iter().filter(|(j, _)| *j != NO_TEXEL);
                let light: Vec3A = met
                    .map(|(j, w)| (radiosity[*j as usize] + given[*j as usize]) * *w)
                    .sum();
                sum += light;
                squares += light * light;
            }
            let received = sample_variance(sum, squares, own.met.len());
            received + sample_variance(own.hidden[0] + own.hidden[1], own.hidden_squares, own.met.len())
        };
        let variances: Vec<Vec3A> = self.records.par_iter().enumerate().map(variance).collect();
        let texels = self.blocks.spread_blocks(&variances).into_iter().zip(&self.open.shares);
        texels.map(|(variance, open)| variance * open.powi(2)).collect()
    }
}
