//! Gathers the irradiance of a texel by rays from points all over it, with multiple importance sampling.
//!
//! ```text
//! H = ∫ u cosθ/π dω ≈ ū·m/n + 1/n Σ (u − ū) p/(p + q) + 1/n Σ (u − ū) p/(p + q)
//! ```
//! Half of the rays leave the texel with density p = cosθ/π per solid angle. The other half end at points
//! drawn in proportion to their radiosity, with density q. The balance heuristic combines both (Veach & Guibas
//! 1995). ū is the mean light, a control variate: m of the first n rays met a front, which gives its part
//! without further noise. The method uses no form factors, patches or open shares of the receiver; rays meet
//! whatever stands on the texel.

use super::claimed_light::ClaimedLight;
use common::mesh::Mesh;
use common::rays::Rays;
use common::sampling::{RECURRENCE_STEPS, pcg_hash};
use glam::{DVec3, Vec3};
use std::f32::consts::{PI, TAU};

/// Random numbers per sample: two for the point on the texel, two for the direction or the point on a source.
const SAMPLE_DIMENSIONS: usize = 4;

/// Largest number of bounces followed in narrow gaps.
const MAX_GAP_BOUNCES: u32 = 8;

/// Gathers the light of a solution by rays.
pub struct RayGatherer<'a> {
    /// The texels.
    pub mesh: &'a Mesh,
    /// The solution's light.
    pub light: &'a ClaimedLight<'a>,
    /// Ray tracer over all faces.
    pub rays: &'a Rays,
}

/// Gathered light of a texel.
pub struct GatheredLight {
    /// H, twice, by independent rays.
    pub irradiance: [DVec3; 2],
    /// The part of H from variation of light within texels.
    pub within_texels: [DVec3; 2],
    /// The part of `within` whose mean over the source texel is 0, so that it causes no error of later bounces;
    /// texels that are partly covered by a body are left out.
    pub zero_mean: [DVec3; 2],
    /// Variance of one sample of H, sum of channels.
    pub variance: f64,
    /// Texels met by the rays of density cosθ/π, one entry per ray.
    pub hit_texels: Vec<usize>,
}

/// A point of a face.
#[derive(Clone, Copy)]
struct SurfacePoint {
    face: u32,
    position: Vec3,
}

/// A point met by a ray, with its weight.
struct RayHit {
    texel: usize,
    point: SurfacePoint,
    /// Weight p/(p + q) of u − ū.
    weight: f32,
    /// True if the texel is wider than its distance.
    is_near: bool,
}

impl RayGatherer<'_> {
    /// Gathers the light of texel `k` with `samples` rays of each kind in each half.
    pub fn gather_texel(&self, k: usize, samples: u32, seed: u32) -> GatheredLight {
        let (mut met, mut squares) = (Vec::new(), 0.0);
        let halves = [0, 1].map(|half| {
            let seed = pcg_hash(k as u32 ^ pcg_hash(2 * seed + half));
            let [around, towards] = [0, 1].map(|kind| Sequence::new(samples, pcg_hash(seed ^ kind)));
            let mut draws = RandomNumbers(pcg_hash(seed ^ 2));
            let (mut sum, mut within, mut even) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
            for s in 0..samples {
                let (mut one, mut varies) = (Vec3::ZERO, Vec3::ZERO);
                let from = self.start_point(k, &around, s);
                let seen = self.trace_by_cosine(&from, [2, 3].map(|axis| around.value_at(s, axis)));
                if let Some(seen) = &seen {
                    one += self.light.mean_reflected;
                    met.push(seen.texel);
                }
                let from = self.start_point(k, &towards, s);
                // Stratified over the cumulative power: samples on one texel are consecutive in the
                // sequence, and any part of the sequence is as uniform as the whole.
                let which = (s as f32 + towards.offset) / towards.length;
                let drawn = self.trace_to_light(&from, [which, towards.value_at(s, 2), towards.value_at(s, 3)]);
                for seen in seen.iter().chain(&drawn) {
                    one += self.hit_radiance(seen);
                    let off = seen.weight * self.variation_at_hit(seen, &mut draws);
                    varies += off;
                    if !self.light.is_partly_covered(seen.texel) {
                        even += off.as_dvec3();
                    }
                }
                one += varies;
                squares += one.as_dvec3().length_squared();
                sum += one.as_dvec3();
                within += varies.as_dvec3();
            }
            [sum, within, even].map(|sum| sum / f64::from(samples))
        });
        let outside = self.mesh.texels[k].sky.as_dvec3();
        let irradiance = halves.map(|[sum, ..]| sum + outside);
        let mean = 0.5 * (irradiance[0] + irradiance[1]) - outside;
        let square = squares / f64::from(2 * samples);
        GatheredLight {
            irradiance,
            within_texels: halves.map(|[_, within, _]| within),
            zero_mean: halves.map(|[_, _, even]| even),
            variance: (square - mean.length_squared()).max(0.0),
            hit_texels: met,
        }
    }

    fn start_point(&self, k: usize, sequence: &Sequence, s: u32) -> SurfacePoint {
        SurfacePoint {
            face: self.mesh.texels[k].face,
            position: self
                .light
                .point_of_texel(k, [0, 1].map(|axis| sequence.value_at(s, axis))),
        }
    }

    /// Traces a ray with density cosθ/π.
    fn trace_by_cosine(&self, from: &SurfacePoint, [c, d]: [f32; 2]) -> Option<RayHit> {
        let face = &self.mesh.faces[from.face as usize];
        let ((sin, cos), sine) = ((TAU * d).sin_cos(), c.sqrt());
        let cosine = (1.0 - c).sqrt();
        let direction = face.direction_in_frame(Vec3::new(sine * cos, sine * sin, cosine));
        let (other, t) = self.rays.nearest_face(from.position, direction, face.sheet)?;
        let at = SurfacePoint {
            face: other,
            position: from.position + direction * t,
        };
        let facing = -self.mesh.faces[other as usize].normal.dot(direction);
        Some(self.weigh_hit(at, cosine, facing, t * t))
    }

    /// Traces a ray to a point drawn in proportion to its radiosity.
    fn trace_to_light(&self, from: &SurfacePoint, drawn: [f32; 3]) -> Option<RayHit> {
        let drawn = self.light.sample_point(drawn);
        let ends = [from.face, self.mesh.texels[drawn.texel].face];
        let [own, other] = ends.map(|face| &self.mesh.faces[face as usize]);
        let offset = drawn.position - from.position;
        let square = offset.length_squared();
        let (cosine, facing) = (own.normal.dot(offset), -other.normal.dot(offset));
        let apart = own.sheet != other.sheet && cosine > 0.0 && facing > 0.0;
        let [near, far] = [from.position, drawn.position];
        if !apart || !self.rays.is_visible(far, near, [ends[1], ends[0]]) {
            return None;
        }
        let at = SurfacePoint {
            face: ends[1],
            position: far,
        };
        let distance = square.sqrt();
        Some(self.weigh_hit(at, cosine / distance, facing / distance, square))
    }

    /// Makes a hit with its weight p/(p + q).
    fn weigh_hit(&self, at: SurfacePoint, cosine: f32, facing: f32, square: f32) -> RayHit {
        let texel = self.light.lookup.texel_at(at.face, at.position);
        let p = cosine / PI * facing;
        let all = p + self.light.sampling_density(texel) * square;
        let position = self.light.inset_point(texel, at.position);
        RayHit {
            texel,
            point: SurfacePoint { position, ..at },
            weight: if all > 0.0 { p / all } else { 0.0 },
            is_near: square < self.mesh.texels[texel].area,
        }
    }

    /// Contribution (u − ū)·p/(p + q) of a hit.
    fn hit_radiance(&self, seen: &RayHit) -> Vec3 {
        (self.light.mean_radiosity(seen.texel) - self.light.mean_reflected) * seen.weight
    }

    /// Estimates the deviation of u at a hit from the texel's mean:
    ///
    /// ```text
    /// δ = ρ(h(y) − h(y'))
    /// ```
    /// h is gathered with one ray of each kind, y' is a random point of the texel. The rays of y and y' use the
    /// same random numbers, so their noise cancels where both see the same. A texel that is partly covered by a
    /// body, or wider than its distance, is seen only in part, and that part may be lit differently: there the
    /// whole value is gathered again, δ = E + ρh(y) − u.
    fn variation_at_hit(&self, seen: &RayHit, draws: &mut RandomNumbers) -> Vec3 {
        let other = SurfacePoint {
            face: seen.point.face,
            position: self.light.point_of_texel(seen.texel, [draws.next(), draws.next()]),
        };
        let reflected = |place| {
            self.mesh.texels[seen.texel].reflectance * self.gather_once(place, RandomNumbers(draws.0), MAX_GAP_BOUNCES)
        };
        let here = reflected(seen.point);
        let off = if seen.is_near || self.light.is_partly_covered(seen.texel) {
            let source = self.mesh.texels[seen.texel].source_radiosity(1.0);
            source + here - self.light.mean_radiosity(seen.texel)
        } else {
            here - reflected(other)
        };
        *draws = RandomNumbers(pcg_hash(draws.0));
        off
    }

    /// Gathers h with one ray of each kind. In narrow gaps, where light changes at every bounce, it follows
    /// further bounces out of the gap.
    fn gather_once(&self, place: SurfacePoint, mut draws: RandomNumbers, depth: u32) -> Vec3 {
        let around = self.trace_by_cosine(&place, [draws.next(), draws.next()]);
        let towards = [draws.next(), draws.next(), draws.next()];
        let drawn = self.trace_to_light(&place, towards);
        let mut sum = around.iter().map(|_| self.light.mean_reflected).sum();
        for (kind, seen) in (1..).zip(around.iter().chain(&drawn)) {
            sum += self.hit_radiance(seen);
            if seen.is_near && depth > 0 {
                let texel = &self.mesh.texels[seen.texel];
                let gathered = self.gather_once(seen.point, RandomNumbers(pcg_hash(draws.0 ^ kind)), depth - 1);
                let off = texel.source_radiosity(1.0) + texel.reflectance * gathered;
                sum += seen.weight * (off - self.light.mean_radiosity(seen.texel));
            }
        }
        sum
    }
}

/// A sequence of random numbers, 0 ≤ x < 1.
struct RandomNumbers(u32);

impl RandomNumbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(RECURRENCE_STEPS[0]);
        unit_float(pcg_hash(self.0))
    }
}

/// The additive recurrence of [`RECURRENCE_STEPS`], shifted by a hash.
struct Sequence {
    shifts: [u32; SAMPLE_DIMENSIONS],
    /// Offset within a stratum, 0 ≤ x < 1, the same for all points.
    offset: f32,
    /// Number of points.
    length: f32,
}

impl Sequence {
    fn new(samples: u32, seed: u32) -> Self {
        let mut shift = seed;
        let mut next = || {
            shift = pcg_hash(shift);
            shift
        };
        Self {
            shifts: std::array::from_fn(|_| next()),
            offset: unit_float(next()),
            length: samples as f32,
        }
    }

    /// Coordinate `axis` of point `s`, 0 ≤ x < 1.
    fn value_at(&self, s: u32, axis: usize) -> f32 {
        unit_float(s.wrapping_mul(RECURRENCE_STEPS[axis]).wrapping_add(self.shifts[axis]))
    }
}

/// Converts the upper 24 bits to 0 ≤ x < 1.
fn unit_float(x: u32) -> f32 {
    (x >> 8) as f32 / (1u32 << 24) as f32
}
