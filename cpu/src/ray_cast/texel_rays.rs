//! The rays of all texels: where they start, what they meet, and the light of lamps that they bring.
//!
//! Ray n of a texel is a pair: one ray in a direction drawn by the cosine, and one to a point of a lamp that is drawn by
//! [`LampTree`] and [`SeenLamp`], or where light enters from outside ([`SkyLight`]). What either brings of a light is
//! weighted by the power heuristic (Veach & Guibas 1995), so that near and large lamps cause as little noise as far and small
//! ones.

use super::lamp_tree::{LampChoice, LampCut, LampTree, MAX_CUT_NODES, Receiver};
use super::seen_lamp::SeenLamp;
use super::sky_light::{SkyLight, offset_to_sun};
use super::smooth_light::{LightSmoother, PART_COUNT};
use super::{Halves, KeptRays, sample_variance};
use crate::dense::open_points::{OpenParts, draw_point};
use crate::space_curve::sort_along_curve;
use common::escape::concentric_direction;
use common::mesh::Mesh;
use common::rays::{RayEnd, Rays};
use common::sampling::pcg_hash;
use common::texel_point::TexelLookup;
use common::{Error, Result};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use sobol_burley::sample_4d;
use std::f32::consts::PI;
use std::ops::ControlFlow;

/// Texels that choose among the same lamps.
const TEXELS_PER_GROUP: usize = 64;
/// Groups between two calls of the progress callback.
const GROUPS_PER_TASK: usize = 64;
/// Index of no texel.
pub const NO_TEXEL: u32 = u32::MAX;

/// The hits of one texel's rays and the light that they brought.
#[derive(Clone, Default)]
struct RayRecord {
    /// The texels that the rays meet, or [`NO_TEXEL`]; the two halves alternate.
    hits: Vec<u32>,
    /// Sums of the light from lamps and from outside: the halves alternate, and so do the parts of each.
    lamp_light: [Halves; PART_COUNT],
    /// Sum of the light from outside over both halves.
    sky_light: Vec3A,
    /// Sum of its squares over both halves.
    lamp_squares: Vec3A,
}

/// A kind of light to whose points rays go.
#[derive(Clone, Copy, PartialEq)]
enum LightKind {
    Lamps,
    Sky,
    /// A sun of this number.
    Sun(usize),
}

/// The light that a ray to a point of a light brings.
struct DrawnLight {
    /// The entry of the lamp in the cut; none of light from outside.
    lamp: Option<usize>,
    light: Vec3A,
}

/// The rays of all texels.
pub struct TexelRays<'a> {
    mesh: &'a Mesh,
    rays: &'a Rays,
    open: &'a OpenParts,
    lookup: TexelLookup<'a>,
    lamps: LampTree,
    sky: Option<SkyLight>,
    /// Kinds of light to whose points rays go.
    kinds: Vec<LightKind>,
    /// The texels along a curve through space, on which neighbours are near each other.
    along_curve: Vec<u32>,
    /// The rays of the texels along the curve.
    records: Vec<RayRecord>,
    /// The lamps of each group of texels along the curve.
    cuts: Vec<LampCut>,
    /// Number of the sequence of random numbers; another one after rays were discarded.
    sequence: u32,
    smoother: Option<LightSmoother<'a>>,
    /// Whether there are rays in directions drawn by the cosine.
    traces_by_cosine: bool,
}

impl<'a> TexelRays<'a> {
    /// Makes the texels of `mesh` with their `open` parts below a `sky`, without rays.
    pub fn new(mesh: &'a Mesh, rays: &'a Rays, open: &'a OpenParts, sky: Option<SkyLight>) -> Self {
        let lamps = LampTree::new(mesh);
        let places: Vec<Vec3> = mesh.texels.iter().map(|texel| texel.position).collect();
        let along_curve = sort_along_curve(&places);
        let choose_cut = |texels: &[u32]| {
            let places = texels.iter().map(|k| mesh.texels[*k as usize].position);
            lamps.choose_cut(places, MAX_CUT_NODES)
        };
        let (sky_shines, suns) = sky
            .as_ref()
            .map_or((false, 0), |sky| (sky.has_ways_out(), sky.suns.len()));
        let kinds = [(!lamps.is_empty(), LightKind::Lamps), (sky_shines, LightKind::Sky)];
        let kinds = kinds.into_iter().filter(|(present, _)| *present).map(|(_, kind)| kind);
        Self {
            mesh,
            rays,
            open,
            lookup: TexelLookup::new(mesh),
            kinds: kinds.chain((0..suns).map(LightKind::Sun)).collect(),
            cuts: along_curve.par_chunks(TEXELS_PER_GROUP).map(choose_cut).collect(),
            lamps,
            along_curve,
            sky,
            records: vec![RayRecord::default(); mesh.texels.len()],
            sequence: 0,
            smoother: None,
            traces_by_cosine: true,
        }
    }

    /// Traces no rays by the cosine unless light enters from a whole sky: those to points of lamps find all of the lamps'
    /// light.
    pub fn for_lamps_alone(self) -> Self {
        Self {
            traces_by_cosine: self.kinds.contains(&LightKind::Sky),
            ..self
        }
    }

    /// Has light smoothed from now on.
    pub fn smooth_later_light(&mut self) {
        self.smoother = Some(LightSmoother::new(self.mesh, &self.open.shares));
    }

    /// Draws the rays from the sequence of random numbers of this number.
    pub fn with_sequence(self, sequence: u32) -> Self {
        Self { sequence, ..self }
    }

    /// Traces rays of texel `k` until there are `count` of both halves.
    fn extend_record(&self, k: usize, count: u32, cut: &mut LampCut, record: &mut RayRecord) {
        let texel = &self.mesh.texels[k];
        let face = &self.mesh.faces[texel.face as usize];
        let outlines = self.open.outlines_of(self.mesh, k);
        let known = record.hits.len() as u32;
        record.hits.reserve_exact(count.saturating_sub(known) as usize);
        let at = Receiver::around_outlines(texel.position, &outlines, face.normal);
        let choice = self.lamps.weigh_lamps(cut, at);
        let mut lamp_rays = [[0; 2]; MAX_CUT_NODES];
        for n in known..count {
            let seed = pcg_hash((2 * k as u32 + (n & 1)) ^ pcg_hash(self.sequence));
            let [u, v, x, y] = sample_4d(n >> 1, 0, seed);
            let Some(point) = draw_point(&outlines, [u, v]) else {
                break;
            };
            let origin = (texel.face, point);
            let (hit, met) = match self.traces_by_cosine {
                true => self.trace_by_cosine(origin, &choice, [x, y]),
                false => (NO_TEXEL, Vec3A::ZERO),
            };
            let drawn = self.trace_to_light(origin, &choice, sample_4d(n >> 1, 1, seed));
            record.hits.push(hit);
            if hit == NO_TEXEL {
                record.sky_light += met;
            }
            match drawn.lamp {
                Some(entry) => {
                    lamp_rays[entry][0] += 1;
                    lamp_rays[entry][1] += u32::from(drawn.light != Vec3A::ZERO);
                }
                None => record.sky_light += drawn.light,
            }
            let light = met + drawn.light;
            record.lamp_light[(n >> 1) as usize % PART_COUNT][(n & 1) as usize] += light;
            record.lamp_squares += light * light;
        }
        cut.count_rays(&lamp_rays);
    }

    /// Traces a ray from a point of face `f`; returns the texel that it meets and that texel's weighted lamp light.
    fn trace_by_cosine(&self, (f, origin): (u32, Vec3), choice: &LampChoice, [x, y]: [f32; 2]) -> (u32, Vec3A) {
        let face = &self.mesh.faces[f as usize];
        let direction =
            face.direction_in_frame(concentric_direction(f64::from(2.0 * x - 1.0), f64::from(2.0 * y - 1.0)));
        let (met, distance) = match self.rays.trace_ray(origin, direction, face.sheet) {
            RayEnd::Front(met, distance) => (met, distance),
            RayEnd::Back => return (NO_TEXEL, Vec3A::ZERO),
            RayEnd::Outside => {
                let [by_cosine, to_sky] = self.sky_densities(origin, direction, face.normal);
                let weight = weigh_by_power(by_cosine, by_cosine, to_sky);
                return (NO_TEXEL, self.sky_along(direction) * weight);
            }
        };
        let point = origin + direction * distance;
        let hit = self.lookup.texel_at(met, point);
        let emission = self.mesh.texels[hit].emission;
        if emission == Vec3::ZERO {
            return (hit as u32, Vec3A::ZERO);
        }
        let drawn = choice.lamp_probability(met) / self.kinds.len() as f32;
        let lamp = SeenLamp::new(&self.mesh.faces[met as usize], origin);
        let [by_cosine, to_lamp] = ray_densities(&lamp, face.normal, point - origin, drawn);
        (
            hit as u32,
            Vec3A::from(emission) * weigh_by_power(by_cosine, by_cosine, to_lamp),
        )
    }

    /// Returns the radiosity of the sky in a direction.
    fn sky_along(&self, direction: Vec3) -> Vec3A {
        let sky = self.sky.as_ref();
        sky.map_or(Vec3A::ZERO, |sky| Vec3A::from(sky.radiosity_along(direction)))
    }

    /// Returns the densities of a direction out of the scene, 1/sr, among rays by the cosine and among those to the sky.
    fn sky_densities(&self, origin: Vec3, direction: Vec3, normal: Vec3) -> [f32; 2] {
        let sky = self.sky.as_ref();
        let density = sky.map_or(0.0, |sky| sky.direction_density(origin, direction));
        [
            normal.dot(direction).max(0.0) / PI,
            density / self.kinds.len().max(1) as f32,
        ]
    }

    /// Traces a ray from a point of face `f` to a point of a light.
    fn trace_to_light(&self, (f, origin): (u32, Vec3), choice: &LampChoice, [number, u, v, _]: [f32; 4]) -> DrawnLight {
        let count = self.kinds.len() as f32;
        let number = number * count;
        let kind = self.kinds.get(number as usize).or(self.kinds.last());
        let normal = self.mesh.faces[f as usize].normal;
        let from_outside = |light| DrawnLight { lamp: None, light };
        match (kind, &self.sky) {
            (Some(LightKind::Lamps), _) => self.trace_to_lamp((f, origin), choice, [number.fract(), u, v]),
            (Some(LightKind::Sky), Some(sky)) => {
                let offset = sky.draw_point(number.fract(), [u, v]) - origin;
                let direction = offset.normalize_or_zero();
                let [by_cosine, to_sky] = self.sky_densities(origin, direction, normal);
                match by_cosine > 0.0 && self.rays.is_visible(origin, origin + offset, [f; 2]) {
                    true => from_outside(self.sky_along(direction) * weigh_by_power(by_cosine, to_sky, by_cosine)),
                    false => from_outside(Vec3A::ZERO),
                }
            }
            (Some(LightKind::Sun(k)), Some(sky)) => {
                let offset = offset_to_sun(&sky.suns[*k], [u, v]);
                let cosine = normal.dot(offset.normalize_or_zero());
                match cosine > 0.0 && self.rays.is_visible(origin, origin + offset, [f; 2]) {
                    true => from_outside(Vec3A::from(sky.suns[*k].irradiance) * (cosine * count)),
                    false => from_outside(Vec3A::ZERO),
                }
            }
            _ => from_outside(Vec3A::ZERO),
        }
    }

    /// Traces a ray from a point of face `f` to a lamp.
    fn trace_to_lamp(&self, (f, origin): (u32, Vec3), choice: &LampChoice, [number, u, v]: [f32; 3]) -> DrawnLight {
        let Some(lamp) = choice.draw_lamp(number) else {
            return DrawnLight {
                lamp: None,
                light: Vec3A::ZERO,
            };
        };
        let (normal, face) = (self.mesh.faces[f as usize].normal, &self.mesh.faces[lamp.lamp as usize]);
        let seen = SeenLamp::new(face, origin);
        let ray = seen.draw_ray([u, v]);
        let point = origin + ray;
        let [by_cosine, to_lamp] = ray_densities(&seen, normal, ray, lamp.probability / self.kinds.len() as f32);
        let others = if self.traces_by_cosine { by_cosine } else { 0.0 };
        let weight = weigh_by_power(by_cosine, to_lamp, others);
        let mut light = Vec3A::ZERO;
        if weight > 0.0 && self.rays.is_visible(origin, point, [f, lamp.lamp]) {
            let emission = self.mesh.texels[self.lookup.texel_at(lamp.lamp, point)].emission;
            light = Vec3A::from(emission) * weight;
        }
        DrawnLight {
            lamp: Some(lamp.entry),
            light,
        }
    }

    /// Returns a value of each texel from its rays and its open share.
    fn map_records<V: Copy + Default + Send>(&self, map: impl Fn(&RayRecord, f32) -> V + Send + Sync) -> Vec<V> {
        let records = self.records.par_iter().zip(&self.along_curve);
        let along_curve: Vec<V> = records
            .map(|(own, k)| map(own, self.open.shares[*k as usize]))
            .collect();
        let mut values = vec![V::default(); along_curve.len()];
        for (value, k) in along_curve.into_iter().zip(&self.along_curve) {
            values[*k as usize] = value;
        }
        values
    }

    /// Calls `visit` with each texel, a half, a texel that one of its rays of that half meets, and the form factor that the
    /// ray counts for.
    pub fn visit_hits(&self, mut visit: impl FnMut(usize, usize, usize, f32)) {
        for (own, k) in self.records.iter().zip(&self.along_curve) {
            let share = own.half_share() * self.open.shares[*k as usize];
            for (n, hit) in own.hits.iter().enumerate().filter(|(_, hit)| **hit != NO_TEXEL) {
                visit(*k as usize, n & 1, *hit as usize, share);
            }
        }
    }

    /// Returns the light from outside at each texel.
    pub fn outside_light(&self) -> Vec<Vec3> {
        self.map_records(|own, open| Vec3::from(own.sky_light * (0.5 * own.half_share() * open)))
    }
}

impl KeptRays for TexelRays<'_> {
    const BYTES_PER_RAY: u64 = 4;
    const FIRST_RAY_COUNT: f32 = 8.0;
    const LEARNS: bool = false;

    fn discard_rays(&mut self, _: &[Vec3A]) {
        self.records.fill(RayRecord::default());
        self.cuts.iter_mut().for_each(LampCut::learn_visibility);
        self.sequence += 1;
    }

    fn trace_rays(&mut self, counts: &[u32], watch: &mut dyn FnMut(f64) -> ControlFlow<()>) -> Result<()> {
        let (mut records, mut cuts) = (std::mem::take(&mut self.records), std::mem::take(&mut self.cuts));
        let groups = cuts.len().max(1) as f64;
        let tasks = records.chunks_mut(GROUPS_PER_TASK * TEXELS_PER_GROUP);
        let tasks = tasks.zip(cuts.chunks_mut(GROUPS_PER_TASK)).enumerate();
        for (task, (records, cuts)) in tasks {
            if watch((task * GROUPS_PER_TASK) as f64 / groups).is_break() {
                return Err(Error::Interrupted);
            }
            let of_groups = records.par_chunks_mut(TEXELS_PER_GROUP).zip(cuts).enumerate();
            of_groups.for_each(|(group, (records, cut))| {
                let begin = (task * GROUPS_PER_TASK + group) * TEXELS_PER_GROUP;
                for (record, k) in records.iter_mut().zip(&self.along_curve[begin..]) {
                    self.extend_record(*k as usize, 2 * counts[*k as usize], cut, record);
                }
            });
        }
        (self.records, self.cuts) = (records, cuts);
        Ok(())
    }

    fn direct_light(&self) -> Vec<Halves> {
        self.map_records(|own, open| {
            let sum = |half: usize| own.lamp_light.iter().map(|part| part[half]).sum::<Vec3A>();
            [sum(0), sum(1)].map(|sum| sum * (own.half_share() * open))
        })
    }

    fn gather_radiosity(&self, radiosity: &[Halves]) -> Vec<Halves> {
        self.map_records(|own, open| {
            let mut sums = [Vec3A::ZERO; 2];
            for pair in own.hits.chunks_exact(2) {
                for (half, k) in pair.iter().enumerate() {
                    if let Some(radiosity) = radiosity.get(*k as usize) {
                        sums[half] += radiosity[half];
                    }
                }
            }
            sums.map(|sum| sum * (own.half_share() * open))
        })
    }

    fn smooth_light(&self, radiosity: &[Halves], weight: &[Vec3A]) -> Option<[Vec<Halves>; 2]> {
        let smoother = self.smoother.as_ref()?;
        let smooth_parts = |sums: &(dyn Fn(&RayRecord, usize) -> Halves + Sync)| {
            let of_part = |part: usize| {
                let share = |own: &RayRecord| own.half_share() * PART_COUNT as f32;
                self.map_records(|own, open| sums(own, part).map(|sum| sum * (share(own) * open)))
            };
            smoother.smooth_light(&std::array::from_fn(of_part), weight)
        };
        let direct = smooth_parts(&|own, part| own.lamp_light[part]);
        if radiosity.is_empty() {
            return Some([direct, Vec::new()]);
        }
        let reflected = smooth_parts(&|own, part| {
            let mut sums = [Vec3A::ZERO; 2];
            for pair in own.hits.chunks_exact(2).skip(part).step_by(PART_COUNT) {
                for (half, k) in pair.iter().enumerate() {
                    sums[half] += radiosity
                        .get(*k as usize)
                        .map_or(Vec3A::ZERO, |radiosity| radiosity[half]);
                }
            }
            sums
        });
        Some([direct, reflected])
    }

    fn ray_variances(&self, radiosity: &[Vec3A]) -> Vec<Vec3A> {
        self.map_records(|own, open| {
            let met = |k: &u32| radiosity.get(*k as usize).copied().unwrap_or(Vec3A::ZERO);
            let (mut sum, mut squares) = (Vec3A::ZERO, Vec3A::ZERO);
            for light in own.hits.iter().map(met) {
                sum += light;
                squares += light * light;
            }
            let reflected = sample_variance(sum, squares, own.hits.len());
            let direct = sample_variance(own.lamp_light.iter().flatten().sum(), own.lamp_squares, own.hits.len());
            (reflected + direct) * (open * open)
        })
    }
}

impl RayRecord {
    /// Returns 1 over the number of rays of a half.
    fn half_share(&self) -> f32 {
        2.0 / self.hits.len().max(1) as f32
    }
}

/// Returns what a ray counts for: an `integrand` over the density `own` of the rays that are drawn as it is, weighted by the
/// power heuristic against the density of the `other` rays (Veach & Guibas 1995).
fn weigh_by_power(integrand: f32, own: f32, other: f32) -> f32 {
    if integrand <= 0.0 || own <= 0.0 {
        return 0.0;
    }
    let ratio = other / own;
    integrand / own / (1.0 + ratio * ratio)
}

/// Returns the densities of a `ray` to a point of `lamp` from a surface of this `normal`, 1/sr: that of rays by the cosine,
/// which for an emission of 1 is the irradiance by solid angle, too, and that of rays to the lamp, which is `drawn` with this
/// probability. They are 0 where no light goes along the ray.
fn ray_densities(lamp: &SeenLamp, normal: Vec3, ray: Vec3, drawn: f32) -> [f32; 2] {
    let [received, sent] = [normal.dot(ray), -lamp.normal.dot(ray)];
    if received > 0.0 && sent > 0.0 {
        [received / (PI * ray.length()), drawn * lamp.direction_density(ray)]
    } else {
        [0.0; 2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};
    use glam::{DMat3, DVec3, EulerRot};

    /// However rays are drawn, they bring the whole integrand together.
    #[test]
    fn weighted_rays_bring_the_integrand_once() {
        for [a, b] in [[1.0, 2.0], [1e-6, 1e6], [0.0, 0.3]] {
            let sum = a * weigh_by_power(0.7, a, b) + b * weigh_by_power(0.7, b, a);
            assert!((sum - 0.7).abs() < 1e-6, "{a} {b}: {sum}");
        }
        // A ray that the others draw at once brings nothing; nor does one that none draws.
        assert_eq!(weigh_by_power(0.7, 0.1, f32::INFINITY), 0.0);
        assert_eq!(weigh_by_power(0.0, 0.0, 0.0), 0.0);
    }

    /// The six sides of a box, with their fronts inside or outside.
    fn box_sides([low, high]: [DVec3; 2], inside: bool) -> impl Iterator<Item = Face> {
        (0..6).map(move |side| {
            let (axis, end) = (side / 2, [low, high][side % 2]);
            let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|at: [usize; 2]| {
                let mut corner = end;
                for (k, far) in at.into_iter().enumerate() {
                    let across = (axis + 1 + k) % 3;
                    corner[across] = [low, high][far][across];
                }
                corner
            });
            let face = Face::quad("side", corners, Vec3::ONE, Vec3::splat(0.9));
            match (side % 2 == 0) == inside {
                true => face,
                false => face.reversed(),
            }
        })
    }

    /// Where all sides of a closed room are lamps of radiosity 1, each texel receives its open share, without rays by the cosine,
    /// too.
    #[test]
    fn rays_to_lamps_alone_bring_all_their_light() {
        let room = box_sides([DVec3::ZERO, DVec3::ONE], true);
        let body = box_sides([DVec3::new(0.2, 0.0, 0.3), DVec3::new(0.7, 0.5, 0.7)], false);
        let scene = Scene {
            faces: room.chain(body).collect(),
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 4, 1).unwrap();
        let rays = Rays::new(&mesh);
        let open = OpenParts::new(&scene, &mesh, &rays);
        let mut traced = TexelRays::new(&mesh, &rays, &open, None).for_lamps_alone();
        let mut go_on = |_| ControlFlow::Continue(());
        traced.trace_rays(&vec![64; mesh.texels.len()], &mut go_on).unwrap();
        let (mut off, mut variance) = (0.0, 0.0);
        for (k, [a, b]) in traced.direct_light().into_iter().enumerate() {
            let [mean, noise] = [0.5 * (a + b), 0.5 * (a - b)].map(|light| light.x * mesh.texels[k].area);
            off += mean - open.shares[k] * mesh.texels[k].area;
            variance += noise * noise;
        }
        assert!(variance > 0.0 && off.abs() < 4.0 * variance.sqrt(), "{off}, {variance}");
        let hits = traced.records.iter().flat_map(|record| &record.hits);
        assert!(hits.clone().count() > 0 && hits.clone().all(|hit| *hit == NO_TEXEL));
    }

    /// All rays of a closed room meet fronts: a partly covered texel receives its open share of a radiosity of 1, whether
    /// the body reaches the ceiling, stands against a wall, or neither, and however the room is turned.
    #[test]
    fn partly_covered_texels_receive_their_open_share() {
        let turned = DMat3::from_euler(EulerRot::XYZ, 0.5, -1.1, 0.3);
        let bodies = [([0.21, 0.0], 0.4), ([0.21, 0.0], 1.0), ([0.0, 0.0], 1.0)];
        let cases = [DMat3::IDENTITY, turned].map(|turn| bodies.map(|body| (turn, body)));
        for (turn, ([x, y], height)) in cases.into_iter().flatten() {
            let room = box_sides([DVec3::ZERO, DVec3::ONE], true);
            let body = box_sides([DVec3::new(x, y, 0.27), DVec3::new(0.73, height, 0.69)], false);
            let turn_face = |face: Face| Face {
                corners: face.corners.map(|corner| turn * corner),
                ..face
            };
            let scene = Scene {
                faces: room.chain(body).map(turn_face).collect(),
                ..Scene::default()
            };
            let mesh = Mesh::uniform(&scene, 4, 1).unwrap();
            let rays = Rays::new(&mesh);
            let open = OpenParts::new(&scene, &mesh, &rays);
            let mut traced = TexelRays::new(&mesh, &rays, &open, None);
            let mut go_on = |_| ControlFlow::Continue(());
            traced.trace_rays(&vec![12; mesh.texels.len()], &mut go_on).unwrap();
            let received = traced.gather_radiosity(&vec![[Vec3A::ONE; 2]; mesh.texels.len()]);
            for (halves, open) in received.iter().zip(&open.shares) {
                assert!(
                    halves.iter().all(|half| (half.x - open).abs() < 1e-6),
                    "{halves:?} of {open}"
                );
            }
            let partly = open.shares.iter().filter(|open| **open > 0.0 && **open < 1.0).count();
            assert!(partly > 4, "{partly}");
        }
    }
}
