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

use super::light::Light;
use common::mesh::Mesh;
use common::rays::Rays;
use common::sampling::{STEPS, hash};
use glam::{DVec3, Vec3};
use std::f32::consts::{PI, TAU};

/// Numbers that a sample takes: two on the texel, and two of the direction or on what shines.
const TAKEN: usize = 4;

/// Bounces in narrow gaps that are followed, at most.
const DEPTH: u32 = 8;

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
    /// What of it comes of light that varies within texels.
    pub within: [DVec3; 2],
    /// Of that, what is 0 over all that a texel shines, and so no error of later bounces: not that of
    /// texels on which a body stands.
    pub even: [DVec3; 2],
    /// The variance of a sample of it, channels added up.
    pub variance: f64,
    /// The texels that rays of density cosθ/π met, one entry for each ray.
    pub met: Vec<usize>,
}

/// A point of a face.
#[derive(Clone, Copy)]
struct Place {
    face: u32,
    position: Vec3,
}

/// What shines at a point that is seen from another.
struct Seen {
    texel: usize,
    at: Place,
    /// Its slope's part of u.
    slope: Vec3,
    /// What u − ū counts there.
    weight: f32,
    /// Whether its texel is wider than it is far.
    near: bool,
}

impl Gather<'_> {
    /// The light on a texel, by so many rays of each kind in each half.
    pub fn at(&self, k: usize, samples: u32, seed: u32) -> Found {
        let (mut met, mut squares) = (Vec::new(), 0.0);
        let halves = [0, 1].map(|half| {
            let seed = hash(k as u32 ^ hash(2 * seed + half));
            let [around, towards] = [0, 1].map(|kind| Sequence::new(samples, hash(seed ^ kind)));
            let mut draws = Draws(hash(seed ^ 2));
            let (mut sum, mut within, mut even) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
            for s in 0..samples {
                let (mut one, mut varies) = (Vec3::ZERO, Vec3::ZERO);
                let from = self.start(k, &around, s);
                let seen = self.around(&from, [2, 3].map(|axis| around.at(s, axis)));
                if let Some(seen) = &seen {
                    one += self.light.flat;
                    met.push(seen.texel);
                }
                let from = self.start(k, &towards, s);
                // In the order of what shines: those that end on one texel follow each other in the
                // sequence, and any part of it is as even as the whole.
                let which = (s as f32 + towards.first) / towards.length;
                let drawn = self.towards(&from, [which, towards.at(s, 2), towards.at(s, 3)]);
                for seen in seen.iter().chain(&drawn) {
                    one += self.brings(seen);
                    let off = seen.weight * self.within(seen, &mut draws);
                    varies += off;
                    if !self.light.cut(seen.texel) {
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
        let irradiance = halves.map(|[sum, ..]| sum);
        let mean = 0.5 * (irradiance[0] + irradiance[1]);
        let square = squares / f64::from(2 * samples);
        Found {
            irradiance,
            within: halves.map(|[_, within, _]| within),
            even: halves.map(|[_, _, even]| even),
            variance: (square - mean.length_squared()).max(0.0),
            met,
        }
    }

    fn start(&self, k: usize, sequence: &Sequence, s: u32) -> Place {
        Place {
            face: self.mesh.texels[k].face,
            position: self
                .light
                .spread(k, [0, 1].map(|axis| sequence.at(s, axis))),
        }
    }

    /// Seen by a ray that leaves as dense as cosθ/π.
    fn around(&self, from: &Place, [c, d]: [f32; 2]) -> Option<Seen> {
        let face = &self.mesh.faces[from.face as usize];
        let ((sin, cos), sine) = ((TAU * d).sin_cos(), c.sqrt());
        let cosine = (1.0 - c).sqrt();
        let bitangent = face.normal.cross(face.tangent);
        let direction =
            face.tangent * (sine * cos) + bitangent * (sine * sin) + face.normal * cosine;
        let (other, t) = self.rays.nearest(from.position, direction, face.sheet)?;
        let at = Place {
            face: other,
            position: from.position + direction * t,
        };
        let facing = -self.mesh.faces[other as usize].normal.dot(direction);
        Some(self.seen(at, cosine, facing, t * t))
    }

    /// Seen by a ray to a point drawn as dense as it shines.
    fn towards(&self, from: &Place, drawn: [f32; 3]) -> Option<Seen> {
        let drawn = self.light.draw(drawn);
        let ends = [from.face, self.mesh.texels[drawn.texel].face];
        let [own, other] = ends.map(|face| &self.mesh.faces[face as usize]);
        let way = drawn.position - from.position;
        let square = way.length_squared();
        let (cosine, facing) = (own.normal.dot(way), -other.normal.dot(way));
        let apart = own.sheet != other.sheet && cosine > 0.0 && facing > 0.0;
        let [near, far] = [from.position, drawn.position];
        if !apart || !self.rays.visible(far, near, [ends[1], ends[0]]) {
            return None;
        }
        let at = Place {
            face: ends[1],
            position: far,
        };
        let distance = square.sqrt();
        Some(self.seen(at, cosine / distance, facing / distance, square))
    }

    /// With the weight p/(p + q).
    fn seen(&self, at: Place, cosine: f32, facing: f32, square: f32) -> Seen {
        let (texel, slope) = self.light.at(at.face, at.position);
        let p = cosine / PI * facing;
        let all = p + self.light.density(texel) * square;
        let position = self.light.inside(texel, at.position);
        Seen {
            texel,
            at: Place { position, ..at },
            slope,
            weight: if all > 0.0 { p / all } else { 0.0 },
            near: square < self.mesh.texels[texel].area,
        }
    }

    /// (u − ū)·p/(p + q).
    fn brings(&self, seen: &Seen) -> Vec3 {
        (self.light.of(seen.texel) + seen.slope - self.light.flat) * seen.weight
    }

    /// What u is off at a point because light changes within its texel otherwise than its slope says:
    ///
    /// ```text
    /// δ = ρ(h(y) − h(y')) − g·(y − c)
    /// ```
    /// h by one ray each way, y' any point of the texel. The rays of y and y' are alike: where both
    /// see the same, no noise is left. Of a texel on which a body stands, and of one that is wider
    /// than it is far, only parts are seen, and those need not be lit as the whole is: all that is
    /// claimed of it is asked again, δ = E + ρh(y) − u.
    fn within(&self, seen: &Seen, draws: &mut Draws) -> Vec3 {
        let other = Place {
            face: seen.at.face,
            position: self.light.spread(seen.texel, [draws.next(), draws.next()]),
        };
        let reflected = |place| {
            self.mesh.texels[seen.texel].reflectance * self.once(place, Draws(draws.0), DEPTH)
        };
        let here = reflected(seen.at);
        let off = if seen.near || self.light.cut(seen.texel) {
            let emission = self.mesh.texels[seen.texel].emission;
            emission + here - self.light.of(seen.texel)
        } else {
            here - reflected(other)
        };
        *draws = Draws(hash(draws.0));
        off - seen.slope
    }

    /// h by one ray each way; in narrow gaps, where light changes at every bounce, by as many as it
    /// takes to get out of them.
    fn once(&self, place: Place, mut draws: Draws, depth: u32) -> Vec3 {
        let around = self.around(&place, [draws.next(), draws.next()]);
        let towards = [draws.next(), draws.next(), draws.next()];
        let drawn = self.towards(&place, towards);
        let mut sum = around.iter().map(|_| self.light.flat).sum();
        for (kind, seen) in (1..).zip(around.iter().chain(&drawn)) {
            sum += self.brings(seen);
            if seen.near && depth > 0 {
                let texel = &self.mesh.texels[seen.texel];
                let again = self.once(seen.at, Draws(hash(draws.0 ^ kind)), depth - 1);
                let off = texel.emission + texel.reflectance * again;
                sum += seen.weight * (off - self.light.of(seen.texel) - seen.slope);
            }
        }
        sum
    }
}

/// Numbers one after the other, 0 ≤ x < 1.
struct Draws(u32);

impl Draws {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(STEPS[0]);
        unit(hash(self.0))
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
