//! The light that reaches a texel, by rays from all over it to whatever they meet.
//!
//! ```text
//! H = ∫ u cosθ/π dω ≈ ū·m/n + 1/n Σ (u − ū) p/(p + q) + 1/n Σ (u − ū) p/(p + q)
//! ```
//! One half of the rays leaves the texel as dense as p = cosθ/π, the other ends at points as dense
//! as they shine, which is q per solid angle; the two are weighed by the balance heuristic (Veach &
//! Guibas 1995). m of the first n met a front: of the mean light ū that is all that needs to be known.
//! No form factor, no cell, no open share of the receiver: what stands on a point is
//! met by its rays.

use super::light::{Light, spread};
use common::mesh::Mesh;
use common::sampling::{STEPS, hash};
use cpu::rays::Rays;
use glam::{DVec3, Vec3};
use std::f32::consts::{PI, TAU};

/// Numbers that a sample takes: two on the texel, and two of the direction or on what shines.
const TAKEN: usize = 4;

/// What rays are asked of.
pub struct Gather<'a> {
    /// The texels.
    pub mesh: &'a Mesh,
    /// The answer's light.
    pub light: &'a Light<'a>,
    /// All faces.
    pub rays: &'a Rays,
}

/// What was found.
pub struct Found {
    /// H, twice, by independent rays.
    pub irradiance: [DVec3; 2],
    /// The variance of a sample of it, channels added up.
    pub variance: f64,
    /// The texels that rays of density cosθ/π met, one entry for each ray.
    pub met: Vec<usize>,
}

impl Gather<'_> {
    /// The light on a texel, by so many rays of each kind in each half.
    pub fn at(&self, k: usize, samples: u32, seed: u32) -> Found {
        let outline = self.light.outline(k);
        let (mut met, mut squares) = (Vec::new(), 0.0);
        let irradiance = [0, 1].map(|half| {
            let seed = hash(k as u32 ^ hash(2 * seed + half));
            let [around, towards] = [0, 1].map(|kind| Sequence::new(samples, hash(seed ^ kind)));
            let mut sum = DVec3::ZERO;
            for s in 0..samples {
                let one = self.around(k, &outline, &around, s, &mut met).as_dvec3();
                let one = one + self.towards(k, &outline, &towards, s).as_dvec3();
                squares += one.length_squared();
                sum += one;
            }
            sum / f64::from(samples)
        });
        let mean = 0.5 * (irradiance[0] + irradiance[1]);
        let square = squares / f64::from(2 * samples);
        Found {
            irradiance,
            variance: (square - mean.length_squared()).max(0.0),
            met,
        }
    }

    fn around(
        &self,
        k: usize,
        outline: &[Vec3; 4],
        sequence: &Sequence,
        s: u32,
        met: &mut Vec<usize>,
    ) -> Vec3 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|axis| sequence.at(s, axis));
        let face = &self.mesh.faces[self.mesh.texels[k].face as usize];
        let origin = spread(outline, [a, b]);
        let ((sin, cos), sine) = ((TAU * d).sin_cos(), c.sqrt());
        let cosine = (1.0 - c).sqrt();
        let bitangent = face.normal.cross(face.tangent);
        let direction =
            face.tangent * (sine * cos) + bitangent * (sine * sin) + face.normal * cosine;
        let Some((other, t)) = self.rays.nearest(origin, direction, face.sheet) else {
            return Vec3::ZERO;
        };
        let (texel, light) = self.light.at(other, origin + direction * t);
        met.push(texel);
        let facing = -self.mesh.faces[other as usize].normal.dot(direction);
        self.light.flat + self.weighed(texel, light, cosine, facing, t * t)
    }

    fn towards(&self, k: usize, outline: &[Vec3; 4], sequence: &Sequence, s: u32) -> Vec3 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|axis| sequence.at(s, axis));
        // In the order of what shines: those that end on one texel follow each other in the sequence,
        // and any part of it is as even as the whole.
        let which = (s as f32 + sequence.first) / sequence.length;
        let drawn = self.light.draw([which, c, d]);
        let ends = [self.mesh.texels[k].face, self.mesh.texels[drawn.texel].face];
        let [own, other] = ends.map(|face| &self.mesh.faces[face as usize]);
        let origin = spread(outline, [a, b]);
        let way = drawn.position - origin;
        let square = way.length_squared();
        let (cosine, facing) = (own.normal.dot(way), -other.normal.dot(way));
        let apart = own.sheet != other.sheet && cosine > 0.0 && facing > 0.0;
        if !apart
            || !self
                .rays
                .visible(drawn.position, origin, [ends[1], ends[0]])
        {
            return Vec3::ZERO;
        }
        let distance = square.sqrt();
        let (texel, light) = self.light.at(ends[1], drawn.position);
        self.weighed(texel, light, cosine / distance, facing / distance, square)
    }

    /// (u − ū)·p/(p + q).
    fn weighed(&self, texel: usize, light: Vec3, cosine: f32, facing: f32, square: f32) -> Vec3 {
        let dense = self.light.of(texel).abs().element_sum() / self.light.power() as f32;
        let p = cosine / PI * facing;
        let all = p + dense * square;
        if all > 0.0 {
            (light - self.light.flat) * (p / all)
        } else {
            Vec3::ZERO
        }
    }
}

/// The additive recurrence of [`STEPS`], moved by a hash.
struct Sequence {
    shifts: [u32; TAKEN],
    /// One more number, 0 ≤ x < 1, the same for all points.
    first: f32,
    /// How many points there are.
    length: f32,
}

impl Sequence {
    fn new(samples: u32, seed: u32) -> Self {
        let mut shift = seed;
        let mut next = || {
            shift = hash(shift);
            shift
        };
        Self {
            shifts: std::array::from_fn(|_| next()),
            first: unit(next()),
            length: samples as f32,
        }
    }

    /// Number `axis` of point `s`, 0 ≤ x < 1.
    fn at(&self, s: u32, axis: usize) -> f32 {
        unit(s.wrapping_mul(STEPS[axis]).wrapping_add(self.shifts[axis]))
    }
}

/// 24 bits of it, 0 ≤ x < 1.
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 / (1u32 << 24) as f32
}
