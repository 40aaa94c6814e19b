//! A path tracer: a Monte Carlo estimate of the radiosity of every texel, from the scene's faces alone.
//!
//! ```text
//! B − E = ρH,  H(x) = ∫ (E + ρH)(y) G(x, y) dy,  G = cosθx cosθy V / (π |x − y|²)
//! ```
//! It shares neither form factors nor rays with the solvers, and does not take radiosity as constant
//! over a texel: its only error is noise, and it says how much. At each vertex of a path a point y of the
//! lamps, drawn by power (density p), and one by the cosine (density G) are both asked; each counts
//! with its share p/(p + G) or G/(p + G) of the densities (Veach & Guibas 1995), so that nothing
//! counts more than E, however near a lamp is. Backs are black and opaque.
//!
//! The paths of a texel are so many independent sets, each drawn from Sobol's sequence scrambled as
//! Owen does (Burley 2020); the standard error is that of the sets' mean.

mod geometry;
mod tree;

use crate::judge::diff::pair::Pair;
use crate::judge::diff::reflected::Reflected;
use common::mesh::Mesh;
use common::scene::Scene;
use common::texel::{count, outline};
use geometry::{Hit, Lamps, Solid, Triangle};
use glam::{DVec2, DVec3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Independent sets of paths.
pub const SETS: u32 = 16;
/// One path of so many tells where the others are needed.
const PILOT: u32 = 8;
/// Numbers of a path that are drawn evenly: the point, two bounces' lamps and directions. What follows
/// is too little light to matter.
const EVEN: u32 = 16;
/// Directions that tell whether a point lies within a body; one is enough for most that do not.
const AROUND: u32 = 32;

/// What was found.
pub struct Traced<'a> {
    /// B − E, means over the texels.
    pub reflected: Reflected<'a>,
    /// Their standard errors.
    pub error: Vec<DVec3>,
}

/// Traces `paths` paths a texel in the mean; the same bits from the same `seed`. An eighth tells where
/// they are needed and is not used again, so that the mean stays fair.
pub fn trace<'a>(scene: &'a Scene, mesh: &Mesh, paths: u32, seed: u64) -> Traced<'a> {
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
    let texels: Vec<Texel> = resolutions
        .iter()
        .enumerate()
        .flat_map(|(face, resolution)| (0..count(*resolution)).map(move |k| (face, k)))
        .map(|(face, k)| Texel::new(scene, resolutions[face], face, k))
        .collect();
    let tracer = Tracer {
        scene,
        solid: Solid::new(scene),
        lamps: Lamps::new(scene),
        around: around(),
    };
    let least = paths.div_ceil(PILOT * SETS).max(1);
    // Seeds are spread by SplitMix64.
    let seeds = |k: usize| Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add(k as u64));
    let tried = texels.par_iter().enumerate().map(|(k, texel)| {
        let (_, error) = tracer.texel(&mut seeds(k), texel, least);
        // What is left of Σ A²s⁴, s² = v/n, is least by n as (A v)^⅔.
        (texel.area() * error.length_squared()).powf(2.0 / 3.0)
    });
    let weights: Vec<f64> = tried.collect();
    let all = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let more = f64::from(paths / SETS) * (1.0 - 2.0 / f64::from(PILOT)) * texels.len() as f64;
    let (values, error) = (texels.par_iter().zip(&weights).enumerate())
        .map(|(k, (texel, weight))| {
            let paths = least + (weight / all * more) as u32;
            tracer.texel(&mut seeds(texels.len() + k), texel, paths)
        })
        .unzip();
    Traced {
        reflected: Reflected {
            scene,
            resolutions,
            values,
        },
        error,
    }
}

/// Relative RMS of `pair.a` against a traced `pair.b`, its noise taken off, and how much of it may
/// still be noise (one standard error); the worst channel.
///
/// ```text
/// q = ΣA(d² − s²) / ΣA(b² − s²),  var ΣA (d² − s²) = ΣA²(4(d² − s²)s² + 2(1 + 1/(n − 1))s⁴),  rms = √q
/// ```
/// d = a − b, s: the standard error of b by n sets, normal for many paths.
pub fn rms(pair: &Pair) -> [f64; 2] {
    let none = Vec::new();
    let error = pair.error.as_ref().unwrap_or(&none);
    debiased(&pair.areas, &pair.a, &pair.b, error)
}

/// The same of means a against traced b, texel by texel.
pub fn debiased(areas: &[f64], a: &[DVec3], b: &[DVec3], error: &[DVec3]) -> [f64; 2] {
    // The variance of an s² of so few sets.
    let known = 2.0 * (1.0 + 1.0 / f64::from(SETS - 1));
    let channel = |c: usize| {
        let (mut square, mut variance, mut truth) = (0.0, 0.0, 0.0);
        for (k, error) in error.iter().enumerate() {
            let (area, noise) = (areas[k], error[c] * error[c]);
            let signal = (a[k][c] - b[k][c]).powi(2) - noise;
            square += area * signal;
            variance += area * area * (4.0 * signal.max(0.0) + known * noise) * noise;
            truth += area * (b[k][c].powi(2) - noise);
        }
        let rms = (square.max(0.0) / truth).sqrt();
        // Where it is all noise the root has no slope: then what one standard error of q makes of it.
        let off = variance.sqrt() / truth;
        [rms, off / (2.0 * rms).max(off.sqrt())]
    };
    (0..3).map(channel).fold([0.0; 2], |worst, next| {
        if next[0] + next[1] > worst[0] + worst[1] {
            next
        } else {
            worst
        }
    })
}

/// A texel, as two triangles.
struct Texel {
    face: usize,
    halves: [Triangle; 2],
}

impl Texel {
    fn new(scene: &Scene, resolution: [u32; 2], face: usize, k: u32) -> Self {
        let [a, b, c, d] = outline(&scene.faces[face], resolution, k).padded();
        let halves = [[a, b, c], [a, c, d]].map(|corners| Triangle::new(face, corners));
        Self { face, halves }
    }

    fn area(&self) -> f64 {
        self.halves.iter().map(Triangle::area).sum()
    }
}

struct Tracer<'a> {
    scene: &'a Scene,
    solid: Solid,
    lamps: Lamps,
    around: Vec<DVec3>,
}

impl Tracer<'_> {
    /// Mean and standard error of the sets, `paths` in each.
    fn texel(
        &self,
        seeds: &mut Xoshiro256PlusPlus,
        Texel { face, halves }: &Texel,
        paths: u32,
    ) -> (DVec3, DVec3) {
        let face = *face;
        let areas = halves.map(|half| half.area());
        let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for _ in 0..SETS {
            let seed = seeds.random();
            let mut set = DVec3::ZERO;
            for k in 0..paths {
                let mut source = Source::new(k, seed, seeds);
                let first = source.next() * (areas[0] + areas[1]) < areas[0];
                let at = halves[usize::from(!first)].point(source.square());
                let at = Hit { face, at };
                if !self.solid.is_within(&at, &self.around) {
                    set += self.path(&mut source, at);
                }
            }
            set /= f64::from(paths);
            sum += set;
            squares += set * set;
        }
        let n = f64::from(SETS);
        let mean = sum / n;
        let variance = (squares / n - mean * mean).max(DVec3::ZERO) / (n - 1.0);
        (mean, variance.map(f64::sqrt))
    }

    /// What one path from a point says of ρH there.
    fn path(&self, source: &mut Source<'_>, mut at: Hit) -> DVec3 {
        let mut found = DVec3::ZERO;
        let [mut weight, _] = self.light(&at);
        loop {
            found += weight * self.lamplight(source, &at);
            let along = self.cosine(source, at.face);
            let Some(next) = self.solid.hit(&at, along) else {
                return found;
            };
            let [reflectance, emission] = self.light(&next);
            let g = self.solid.kernel(&at, &next);
            found += weight * emission * share(g, self.density(next.face));
            // Goes on as often as the face reflects.
            let survival = reflectance.max_element();
            if source.next() >= survival {
                return found;
            }
            weight *= reflectance / survival;
            at = next;
        }
    }

    /// Light straight from a point of a lamp.
    fn lamplight(&self, source: &mut Source<'_>, at: &Hit) -> DVec3 {
        let Some(lamp) = self.lamps.draw(source.next(), source.square()) else {
            return DVec3::ZERO;
        };
        let g = self.solid.kernel(at, &lamp);
        if g <= 0.0 || self.solid.hides(at, &lamp) {
            return DVec3::ZERO;
        }
        let [_, emission] = self.light(&lamp);
        let density = self.density(lamp.face);
        emission * g / density * share(density, g)
    }

    /// A direction from a face, as likely as its cosine (Malley).
    fn cosine(&self, source: &mut Source<'_>, face: usize) -> DVec3 {
        let [u, v] = source.square().to_array();
        let normal = self.solid.normals[face];
        let (x, y) = normal.any_orthonormal_pair();
        let along = by_cosine(u, v);
        x * along.x + y * along.y + normal * along.z
    }

    /// ρ and E there.
    fn light(&self, hit: &Hit) -> [DVec3; 2] {
        self.scene.faces[hit.face].at(hit.at).map(|v| v.as_dvec3())
    }

    /// How likely a point of a face is drawn as one of a lamp, per area: by the face's mean.
    fn density(&self, face: usize) -> f64 {
        let mean = self.scene.faces[face].emission.as_dvec3();
        self.lamps.density(mean)
    }
}

/// A direction about z, by two numbers within 0…1.
fn by_cosine(u: f64, v: f64) -> DVec3 {
    let (r, angle) = (u.sqrt(), TAU * v);
    DVec3::new(r * angle.cos(), r * angle.sin(), (1.0 - u).sqrt())
}

/// Directions about z, as many wherever the cosine is the same.
fn around() -> Vec<DVec3> {
    let golden = 5.0_f64.sqrt() / 2.0 - 0.5;
    let at = |k: u32| {
        by_cosine(
            (f64::from(k) + 0.5) / f64::from(AROUND),
            (f64::from(k) * golden).fract(),
        )
    };
    (0..AROUND).map(at).collect()
}

/// The balance heuristic.
fn share(own: f64, other: f64) -> f64 {
    if own > 0.0 { own / (own + other) } else { 0.0 }
}

/// The numbers of one path, 0 ≤ x < 1.
struct Source<'a> {
    path: u32,
    seed: u32,
    taken: u32,
    more: &'a mut Xoshiro256PlusPlus,
}

impl<'a> Source<'a> {
    fn new(path: u32, seed: u32, more: &'a mut Xoshiro256PlusPlus) -> Self {
        Self {
            path,
            seed,
            taken: 0,
            more,
        }
    }

    fn next(&mut self) -> f64 {
        if self.taken >= EVEN {
            return self.more.random();
        }
        self.taken += 1;
        f64::from(sobol_burley::sample(self.path, self.taken - 1, self.seed))
    }

    fn square(&mut self) -> DVec2 {
        DVec2::new(self.next(), self.next())
    }
}
