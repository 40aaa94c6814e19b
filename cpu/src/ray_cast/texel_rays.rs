//! The rays of all texels: where they start, what they meet, and the light of lamps that they bring.
//!
//! Ray n of a texel is a pair: one ray in a direction drawn by the cosine, and one to a point of a lamp that is drawn by
//! [`LampTree`]. What either brings from a lamp is weighted by the balance heuristic (Veach & Guibas 1995), so that near
//! and large lamps cause as little noise as far and small ones.

use super::lamp_tree::LampTree;
use common::escape::concentric_direction;
use common::mesh::{Mesh, MeshFace, TexelKind};
use common::rays::Rays;
use common::sampling::{fold_triangle, pcg_hash};
use common::texel::first_texels;
use common::texel_point::{point_on_texel, texel_at};
use common::{Error, Result};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use sobol_burley::sample_4d;
use std::f32::consts::PI;
use std::ops::ControlFlow;

/// A value for each half of the rays.
pub type Halves = [Vec3A; 2];

/// Texels between two calls of the progress callback.
const TEXELS_PER_TASK: usize = 1 << 12;
/// Index of no texel.
const NO_TEXEL: u32 = u32::MAX;

/// The hits of one texel's rays and the light that they brought.
#[derive(Clone, Default)]
struct RayRecord {
    /// The texels that the rays meet, or [`NO_TEXEL`]; the two halves alternate.
    hits: Vec<u32>,
    /// Sum of the light from lamps, of each half.
    lamp_light: Halves,
    /// Sum of its squares over both halves.
    lamp_squares: Vec3A,
}

/// The rays of all texels.
pub struct TexelRays<'a> {
    mesh: &'a Mesh,
    rays: &'a Rays,
    lamps: LampTree,
    /// First texel of each face, in face order.
    first: Vec<usize>,
    /// The texel of each rank in face order.
    order: Vec<usize>,
    records: Vec<RayRecord>,
    /// Number of times that rays were discarded: a part of their seeds.
    discards: u32,
}

impl<'a> TexelRays<'a> {
    /// Makes the texels of `mesh`, without rays.
    pub fn new(mesh: &'a Mesh, rays: &'a Rays) -> Self {
        let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|face| face.resolution).collect();
        Self {
            mesh,
            rays,
            lamps: LampTree::new(mesh),
            first: first_texels(&resolutions),
            order: mesh.texels_in_face_order(),
            records: vec![RayRecord::default(); mesh.texels.len()],
            discards: 0,
        }
    }

    /// Discards all rays, so that their numbers may follow from what they brought: kept, they would be many where they
    /// happened to bring much, and the light would come out too dark.
    pub fn discard_rays(&mut self) {
        self.records.fill(RayRecord::default());
        self.discards += 1;
    }

    /// Traces until texel k has `counts[k]` rays of each half.
    ///
    /// Errors: [`Error::Interrupted`].
    pub fn trace_rays(&mut self, counts: &[u32], watch: &mut dyn FnMut(f64) -> ControlFlow<()>) -> Result<()> {
        let mut records = std::mem::take(&mut self.records);
        let all = records.len() as f64;
        for (task, part) in records.chunks_mut(TEXELS_PER_TASK).enumerate() {
            let begin = task * TEXELS_PER_TASK;
            if watch(begin as f64 / all).is_break() {
                return Err(Error::Interrupted);
            }
            let texels = part.par_iter_mut().enumerate();
            texels.for_each(|(k, record)| self.extend_record(begin + k, 2 * counts[begin + k], record));
        }
        self.records = records;
        Ok(())
    }

    /// Traces rays of texel `k` until there are `count` of both halves.
    fn extend_record(&self, k: usize, count: u32, record: &mut RayRecord) {
        let texel = &self.mesh.texels[k];
        let face = &self.mesh.faces[texel.face as usize];
        let uv = match texel.kind {
            TexelKind::Quad => [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            _ => [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]],
        };
        let corner = |uv| point_on_texel(face, texel.kind, texel.lattice_corner, texel.area, uv).truncate();
        let area = EvenArea::new(uv.map(corner));
        let known = record.hits.len() as u32;
        record.hits.reserve_exact(count.saturating_sub(known) as usize);
        for n in known..count {
            let seed = pcg_hash((2 * k as u32 + (n & 1)) ^ pcg_hash(self.discards));
            let [u, v, x, y] = sample_4d(n >> 1, 0, seed);
            let origin = area.point_at([u, v]);
            let (hit, mut light) = self.trace_by_cosine(texel.face, origin, [x, y]);
            record.hits.push(hit);
            light += self.trace_to_lamp(texel.face, origin, sample_4d(n >> 1, 1, seed));
            record.lamp_light[(n & 1) as usize] += light;
            record.lamp_squares += light * light;
        }
    }

    /// Traces a ray from `origin` on face `f`; returns the texel that it meets and that texel's weighted lamp light.
    fn trace_by_cosine(&self, f: u32, origin: Vec3, [x, y]: [f32; 2]) -> (u32, Vec3A) {
        let face = &self.mesh.faces[f as usize];
        let along = concentric_direction(f64::from(2.0 * x - 1.0), f64::from(2.0 * y - 1.0));
        let bitangent = face.normal.cross(face.tangent);
        let direction = face.tangent * along.x + bitangent * along.y + face.normal * along.z;
        let Some((met, distance)) = self.rays.nearest_face(origin, direction, face.sheet) else {
            return (NO_TEXEL, Vec3A::ZERO);
        };
        let point = origin + direction * distance;
        let hit = self.texel_of(met, point);
        let emission = self.mesh.texels[hit as usize].emission;
        if emission == Vec3::ZERO {
            return (hit, Vec3A::ZERO);
        }
        let drawn = self.lamps.probability(met, origin, face.normal);
        let weight = balanced_weight(&self.mesh.faces[met as usize], face.normal, point - origin, drawn);
        (hit, Vec3A::from(emission) * weight)
    }

    /// Traces a ray from `origin` on face `f` to a lamp; returns its weighted light.
    fn trace_to_lamp(&self, f: u32, origin: Vec3, [choice, u, v, _]: [f32; 4]) -> Vec3A {
        let normal = self.mesh.faces[f as usize].normal;
        let Some((lamp, drawn)) = self.lamps.draw_lamp(origin, normal, choice) else {
            return Vec3A::ZERO;
        };
        let face = &self.mesh.faces[lamp as usize];
        let point = EvenArea::new(face.corners).point_at([u, v]);
        let weight = balanced_weight(face, normal, point - origin, drawn);
        if weight <= 0.0 || !self.rays.is_visible(origin, point, [f, lamp]) {
            return Vec3A::ZERO;
        }
        let emission = self.mesh.texels[self.texel_of(lamp, point) as usize].emission;
        Vec3A::from(emission) * weight
    }

    /// Returns the texel at `point` of face `f`.
    fn texel_of(&self, f: u32, point: Vec3) -> u32 {
        let at = texel_at(&self.mesh.faces[f as usize], point) as usize;
        self.order[self.first[f as usize] + at] as u32
    }

    /// Returns the light of lamps at each texel, of each half.
    pub fn direct_light(&self) -> Vec<Halves> {
        let records = self.records.iter();
        records
            .map(|own| own.lamp_light.map(|sum| sum * own.half_share()))
            .collect()
    }

    /// Returns F times a radiosity, for each half.
    pub fn gather(&self, radiosity: &[Halves]) -> Vec<Halves> {
        let gather = |own: &RayRecord| {
            let mut sums = [Vec3A::ZERO; 2];
            for pair in own.hits.chunks_exact(2) {
                for (half, k) in pair.iter().enumerate() {
                    if let Some(radiosity) = radiosity.get(*k as usize) {
                        sums[half] += radiosity[half];
                    }
                }
            }
            sums.map(|sum| sum * own.half_share())
        };
        self.records.par_iter().map(gather).collect()
    }

    /// Returns the variance of what the rays of texel `k` bring, by channel.
    pub fn ray_variance(&self, k: usize, radiosity: &[Vec3A]) -> Vec3A {
        let own = &self.records[k];
        let met = |k: &u32| radiosity.get(*k as usize).copied().unwrap_or(Vec3A::ZERO);
        let (mut sum, mut squares) = (Vec3A::ZERO, Vec3A::ZERO);
        for light in own.hits.iter().map(met) {
            sum += light;
            squares += light * light;
        }
        let share = 0.5 * own.half_share();
        let variance = |sum: Vec3A, squares: Vec3A| (squares * share - (sum * share) * (sum * share)).max(Vec3A::ZERO);
        variance(sum, squares) + variance(own.lamp_light[0] + own.lamp_light[1], own.lamp_squares)
    }
}

impl RayRecord {
    /// Returns 1 over the number of rays of a half.
    fn half_share(&self) -> f32 {
        2.0 / self.hits.len().max(1) as f32
    }
}

/// Returns the irradiance that a `ray` to a point of `lamp` brings for an emission of 1 on a surface of this `normal`:
/// the integrand over the sum of both rays' densities. `drawn` is the probability of the lamp, whose points are drawn
/// evenly.
fn balanced_weight(lamp: &MeshFace, normal: Vec3, ray: Vec3, drawn: f32) -> f32 {
    let square = ray.length_squared().max(f32::MIN_POSITIVE);
    let direction = ray / square.sqrt();
    let [received, sent] = [normal.dot(direction), -lamp.normal.dot(direction)];
    if received <= 0.0 || sent <= 0.0 {
        return 0.0;
    }
    let [a, b, c, d] = lamp.corners;
    let area = 0.5 * (c - a).cross(d - b).length();
    let by_cosine = received / PI;
    let by_lamp = drawn * square / (sent * area);
    by_cosine / (by_cosine + by_lamp)
}

/// A convex quad, or a triangle that repeats its third corner, from which points are drawn evenly.
struct EvenArea {
    corners: [Vec3; 4],
    /// Share of the triangle of the first three corners; none of a parallelogram.
    first_share: Option<f32>,
}

impl EvenArea {
    fn new(corners: [Vec3; 4]) -> Self {
        let [a, b, c, d] = corners;
        let skewed = (a - b + c - d).length_squared() > 1e-8 * (c - a).length_squared();
        let [first, second] = [(b - a).cross(c - a).length(), (c - a).cross(d - a).length()];
        let first_share = first / (first + second).max(f32::MIN_POSITIVE);
        Self {
            corners,
            first_share: skewed.then_some(first_share),
        }
    }

    /// Returns the point of the area for (u, v) in the unit square.
    fn point_at(&self, [u, v]: [f32; 2]) -> Vec3 {
        let [a, b, c, d] = self.corners;
        let in_triangle = |[a, b, c]: [Vec3; 3], u: f32| {
            let (u, v) = fold_triangle(u, v);
            a + (b - a) * u + (c - a) * v
        };
        match self.first_share {
            None => a + (b - a) * u + (d - a) * v,
            Some(share) if u < share => in_triangle([a, b, c], u / share),
            Some(share) => in_triangle([a, c, d], (u - share) / (1.0 - share)),
        }
    }
}
