//! Path tracer: a Monte Carlo estimate of the radiosity of every texel from the scene's faces alone. It is the truth of
//! the random scenes of the failure atlas.
//!
//! ```text
//! B − E = ρH,  H(x) = ∫ (E + ρH)(y) G(x, y) dy,  G = cosθx cosθy V / (π |x − y|²)
//! ```
//! It shares neither form factors nor rays with the solvers, and does not assume constant radiosity over a texel:
//! its only error is noise, which it estimates. At each vertex of a path it draws n points y of the lamps by power
//! (density p) and a direction by the cosine (density G), and combines both by multiple importance sampling with
//! the balance heuristic np/(np + G), G/(np + G) (Veach & Guibas 1995), so that no point contributes more than E,
//! however near a lamp is. One of the n points, drawn by what it would contribute if it were seen, decides for all of
//! them whether they are seen (Talbot 2005): of many lamps those that matter are asked. Backs are black and opaque.
//!
//! The paths of a texel form [`PATH_SETS`] independent sets, each drawn from an Owen-scrambled Sobol sequence (Burley
//! 2020); the standard error is that of the mean of the sets.

mod geometry;
mod tree;

use crate::diff::pair::GridPair;
use crate::diff::reflected::ReflectedField;
use common::mesh::Mesh;
use common::scene::Scene;
use common::texel::{texel_count, texel_outline};
use geometry::{LampSampler, RayTriangle, SceneGeometry, SurfacePoint, face_triangles};
use glam::{DVec2, DVec3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Number of independent sets of paths per texel.
pub const PATH_SETS: u32 = 16;
/// Variance of d² − s² over s⁴ where d is all noise and s² comes from [`PATH_SETS`] sets.
const VARIANCE_FACTOR: f64 = 2.0 * (1.0 + 1.0 / (PATH_SETS - 1) as f64);
/// Inverse share of the pilot paths, from which the distribution of the other paths follows.
const PILOT_FRACTION: u32 = 8;
/// Largest number of paths that find what irradiance to expect at a face.
const MAX_FACE_PATHS: u32 = 256;
/// Dimensions of a path that use the Sobol sequence: the point, and lamps and directions of two bounces. Later bounces
/// carry too little light to matter.
const SOBOL_DIMENSIONS: u32 = 17;
/// Number of points of lamps of which each vertex of a path draws one.
const LAMP_CANDIDATES: u32 = 16;
/// Step of the points of the candidates on their lamps: the R2 sequence (Roberts 2018).
const R2_STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
/// Number of directions that decide whether a point lies inside a body; most points outside need one.
const PROBE_DIRECTIONS: u32 = 32;

/// Result of the path tracer.
pub struct TracedRadiosity<'a> {
    /// Mean of B − E over each texel.
    pub reflected: ReflectedField<'a>,
    /// Standard error of each texel.
    pub error: Vec<DVec3>,
}

/// Traces `paths` paths per texel on average; equal seeds give equal bits. An eighth of them find what irradiance to expect,
/// another eighth determine the distribution of the others; neither enters the result, so that it stays unbiased.
pub fn trace_radiosity<'a>(scene: &'a Scene, mesh: &Mesh, paths: u32, seed: u64) -> TracedRadiosity<'a> {
    trace_weighted_texels(scene, mesh, |_, texel| texel.area(), paths, seed)
}

/// Traces only the texels that stand for an area above 0, in face order; light and error of the others are 0.
pub fn trace_sample<'a>(scene: &'a Scene, mesh: &Mesh, areas: &[f64], paths: u32, seed: u64) -> TracedRadiosity<'a> {
    trace_weighted_texels(scene, mesh, |rank, _| areas[rank], paths, seed)
}

fn trace_weighted_texels<'a>(
    scene: &'a Scene,
    mesh: &Mesh,
    area_of: impl Fn(usize, &TracedTexel) -> f64 + Sync,
    paths: u32,
    seed: u64,
) -> TracedRadiosity<'a> {
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
    let all = resolutions.iter().enumerate();
    let all = all.flat_map(|(face, resolution)| (0..texel_count(*resolution)).map(move |k| (face, k)));
    let (chosen, texels): (Vec<usize>, Vec<TracedTexel>) = (all.enumerate())
        .map(|(rank, (face, k))| (rank, TracedTexel::new(scene, resolutions[face], face, k)))
        .filter(|(rank, texel)| area_of(*rank, texel) > 0.0)
        .unzip();
    let mut tracer = Tracer {
        scene,
        geometry: SceneGeometry::new(scene, mesh),
        lamps: LampSampler::new(scene),
        probe_directions: probe_directions(),
        expected: vec![DVec3::ZERO; scene.faces.len()],
    };
    // Seeds are spread by SplitMix64.
    let seeds = |k: usize| Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add(k as u64));
    let face_paths = f64::from(paths) * texels.len() as f64 / (f64::from(PILOT_FRACTION) * scene.faces.len() as f64);
    let face_seeds = |face: usize| seeds(2 * texels.len() + face);
    let expect = |face| tracer.expect_irradiance(&mut face_seeds(face), face, face_paths as u32);
    tracer.expected = (0..scene.faces.len()).into_par_iter().map(expect).collect();
    let pilot_paths = paths.div_ceil(PILOT_FRACTION * PATH_SETS).max(1);
    let needs = texels.par_iter().enumerate().map(|(k, texel)| {
        let (_, error) = tracer.estimate_texel(&mut seeds(k), texel, pilot_paths);
        // Σ A²s⁴ with s² = v/n is minimal for n proportional to (A v)^⅔.
        (area_of(chosen[k], texel) * error.length_squared()).powf(2.0 / 3.0)
    });
    let weights: Vec<f64> = needs.collect();
    let total_weight = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let remaining_paths = f64::from(paths / PATH_SETS) * (1.0 - 2.0 / f64::from(PILOT_FRACTION)) * texels.len() as f64;
    let traced: Vec<(DVec3, DVec3)> = (texels.par_iter().zip(&weights).enumerate())
        .map(|(k, (texel, weight))| {
            let paths = pilot_paths + (weight / total_weight * remaining_paths) as u32;
            tracer.estimate_texel(&mut seeds(texels.len() + k), texel, paths)
        })
        .collect();
    let mut values = vec![DVec3::ZERO; mesh.texels.len()];
    let mut error = values.clone();
    for (rank, found) in chosen.into_iter().zip(traced) {
        (values[rank], error[rank]) = found;
    }
    TracedRadiosity {
        reflected: ReflectedField {
            scene,
            resolutions,
            values,
        },
        error,
    }
}

/// Returns the relative RMS of `pair.a` against a traced `pair.b` without the noise of b, and its standard error; the
/// worst channel.
///
/// ```text
/// q = ΣA(d² − s²) / ΣA(b² − s²),  var ΣA (d² − s²) = ΣA²(4(d² − s²)s² + 2(1 + 1/(n − 1))s⁴),  rms = √q
/// ```
/// d = a − b; s is the standard error of b from n sets, normally distributed for many paths.
pub fn debiased_pair_rms(pair: &GridPair) -> [f64; 2] {
    let none = Vec::new();
    let error = pair.error.as_ref().unwrap_or(&none);
    let drawn = vec![1.0; pair.areas.len()];
    debiased_rms((&pair.areas, &drawn), &pair.a, &pair.b, error)
}

/// Returns the same for means a against traced b, texel by texel. Of a random sample of texels each stands for its area
/// over the probability p with which it was drawn; their choice adds ΣA²(1 − p)(d² − s² − q(b² − s²))² to the variance.
pub fn debiased_rms((areas, probabilities): (&[f64], &[f64]), a: &[DVec3], b: &[DVec3], error: &[DVec3]) -> [f64; 2] {
    let channel = |c: usize| {
        let squares = |k: usize, error: &DVec3| {
            let noise = error[c] * error[c];
            [(a[k][c] - b[k][c]).powi(2) - noise, b[k][c].powi(2) - noise, noise]
        };
        let (mut square, mut truth) = (0.0, 0.0);
        for (k, error) in error.iter().enumerate() {
            let [signal, light, _] = squares(k, error);
            square += areas[k] * signal;
            truth += areas[k] * light;
        }
        let ratio = square.max(0.0) / truth;
        let mut variance = 0.0;
        for (k, error) in error.iter().enumerate() {
            let [signal, light, noise] = squares(k, error);
            let of_paths = (4.0 * signal.max(0.0) + VARIANCE_FACTOR * noise) * noise;
            let of_choice = (1.0 - probabilities[k]) * (signal - ratio * light).powi(2);
            variance += areas[k] * areas[k] * (of_paths + of_choice);
        }
        let rms = ratio.sqrt();
        // At q = 0 the root has no finite slope: the error is then √ of the standard error of q.
        let error = variance.sqrt() / truth;
        [rms, error / (2.0 * rms).max(error.sqrt())]
    };
    (0..3).map(channel).fold([0.0; 2], |worst, next| {
        if next[0] + next[1] > worst[0] + worst[1] {
            next
        } else {
            worst
        }
    })
}

/// Returns how many times as many paths as left these standard errors leave a standard error of `noise` in [`debiased_rms`]
/// of an answer that is off by `rms` of the truth everywhere.
///
/// ```text
/// (2 rms noise ΣA b²)² = ΣA²(4 rms² b² s²/f + 2(1 + 1/(n − 1)) s⁴/f²)
/// ```
pub fn path_growth_for_noise(areas: &[f64], b: &[DVec3], error: &[DVec3], rms: f64, noise: f64) -> f64 {
    let channel = |c: usize| {
        let (mut light, mut linear, mut square) = (0.0, 0.0, 0.0);
        for ((area, b), error) in areas.iter().zip(b).zip(error) {
            let [truth, noise] = [b[c] * b[c], error[c] * error[c]];
            light += area * (truth - noise).max(0.0);
            linear += area * area * 4.0 * rms * rms * truth * noise;
            square += area * area * VARIANCE_FACTOR * noise * noise;
        }
        let wanted = (2.0 * rms * noise * light).powi(2).max(f64::MIN_POSITIVE);
        (linear + (linear * linear + 4.0 * square * wanted).sqrt()) / (2.0 * wanted)
    };
    (0..3).map(channel).fold(0.0, f64::max)
}

/// A texel, as two triangles.
struct TracedTexel {
    face: usize,
    halves: [RayTriangle; 2],
}

impl TracedTexel {
    fn new(scene: &Scene, resolution: [u32; 2], face: usize, k: u32) -> Self {
        let [a, b, c, d] = texel_outline(&scene.faces[face], resolution, k).padded_corners();
        let halves = [[a, b, c], [a, c, d]].map(|corners| RayTriangle::new(face, corners));
        Self { face, halves }
    }

    fn area(&self) -> f64 {
        self.halves.iter().map(RayTriangle::area).sum()
    }
}

struct Tracer<'a> {
    scene: &'a Scene,
    geometry: SceneGeometry,
    lamps: LampSampler,
    probe_directions: Vec<DVec3>,
    /// Irradiance that paths which end are taken to have missed, by face.
    expected: Vec<DVec3>,
}

impl Tracer<'_> {
    /// Returns the mean irradiance of a face from a few paths, reduced by its noise.
    fn expect_irradiance(&self, seeds: &mut Xoshiro256PlusPlus, face: usize, paths: u32) -> DVec3 {
        let (mut sum, mut squares) = (DVec3::ZERO, 0.0);
        let triangles: Vec<RayTriangle> = face_triangles((face, &self.scene.faces[face])).collect();
        let seed = seeds.random();
        for path in 0..paths.min(MAX_FACE_PATHS) {
            let mut source = PathSampler::new(path, seed, seeds);
            let at = sample_triangles(&triangles, face, &mut source);
            let found = self.trace_path(&mut source, at);
            sum += found;
            squares += found.length_squared();
        }
        let n = f64::from(paths.clamp(1, MAX_FACE_PATHS));
        let mean = sum / n;
        let variance = (squares / n - mean.length_squared()).max(0.0) / (n - 1.0).max(f64::MIN_POSITIVE);
        let light = mean.length_squared();
        if light > 0.0 {
            mean * (light / (light + variance))
        } else {
            DVec3::ZERO
        }
    }

    /// Returns mean and standard error of the sets, with `paths` paths in each.
    fn estimate_texel(
        &self,
        seeds: &mut Xoshiro256PlusPlus,
        TracedTexel { face, halves }: &TracedTexel,
        paths: u32,
    ) -> (DVec3, DVec3) {
        let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for _ in 0..PATH_SETS {
            let seed = seeds.random();
            let mut set = DVec3::ZERO;
            for k in 0..paths {
                let mut source = PathSampler::new(k, seed, seeds);
                let at = sample_triangles(halves, *face, &mut source);
                let hidden = self.geometry.is_under_front(&at) || self.geometry.is_within(&at, &self.probe_directions);
                if !hidden {
                    let [reflectance, _] = self.reflectance_and_emission(&at);
                    set += reflectance * self.trace_path(&mut source, at);
                }
            }
            set /= f64::from(paths);
            sum += set;
            squares += set * set;
        }
        let n = f64::from(PATH_SETS);
        let mean = sum / n;
        let variance = (squares / n - mean * mean).max(DVec3::ZERO) / (n - 1.0);
        (mean, variance.map(f64::sqrt))
    }

    /// Returns the estimate of H at a point from one path.
    fn trace_path(&self, source: &mut PathSampler<'_>, mut at: SurfacePoint) -> DVec3 {
        let (mut irradiance, mut weight) = (DVec3::ZERO, DVec3::ONE);
        loop {
            irradiance += weight * self.sample_lamps(source, &at);
            let along = self.sample_direction(source, at.face);
            let (Some(next), _) = self.geometry.trace_ray(&at, along) else {
                return irradiance;
            };
            let [reflectance, emission] = self.reflectance_and_emission(&next);
            let g = self.geometry.geometry_kernel(&at, &next);
            irradiance += weight * emission * balance_heuristic(g, self.candidate_density(next.face));
            let expected = self.expected[next.face];
            irradiance += weight * reflectance * expected;
            // Russian roulette: the path survives with the probability of the reflectance, and then finds by how much the
            // irradiance differs from what was expected.
            let survival = reflectance.max_element();
            if source.next_number() >= survival {
                return irradiance;
            }
            weight *= reflectance / survival;
            irradiance -= weight * expected;
            at = next;
        }
    }

    /// Returns the direct light of one of several points of lamps, drawn by what they would contribute if they were seen.
    fn sample_lamps(&self, source: &mut PathSampler<'_>, at: &SurfacePoint) -> DVec3 {
        let (which, shift) = (source.next_number(), source.next_pair());
        let mut chosen = source.next_number();
        let candidate = |k: u32| {
            let which = (f64::from(k) + which) / f64::from(LAMP_CANDIDATES);
            let point = (shift + R2_STEP * f64::from(k)).fract();
            let lamp = self.lamps.sample_point(which, point)?;
            let g = self.geometry.geometry_kernel(at, &lamp);
            let [_, emission] = self.reflectance_and_emission(&lamp);
            Some((emission * g / (g + self.candidate_density(lamp.face)), lamp))
        };
        let candidates: [_; LAMP_CANDIDATES as usize] = std::array::from_fn(|k| candidate(k as u32));
        let sum: f64 = candidates.iter().flatten().map(|(light, _)| light.element_sum()).sum();
        chosen *= sum;
        for (light, lamp) in candidates.into_iter().flatten() {
            let share = light.element_sum();
            if chosen >= share {
                chosen -= share;
            } else if !self.geometry.is_under_front(&lamp) && !self.geometry.is_occluded(at, &lamp) {
                return light * (sum / share);
            } else {
                return DVec3::ZERO;
            }
        }
        DVec3::ZERO
    }

    /// Samples a direction from a face with a density proportional to the cosine (Malley's method).
    fn sample_direction(&self, source: &mut PathSampler<'_>, face: usize) -> DVec3 {
        let [u, v] = source.next_pair().to_array();
        let normal = self.geometry.normals[face];
        let (x, y) = normal.any_orthonormal_pair();
        let along = cosine_direction(u, v);
        x * along.x + y * along.y + normal * along.z
    }

    /// Returns ρ and E at a point.
    fn reflectance_and_emission(&self, hit: &SurfacePoint) -> [DVec3; 2] {
        self.scene.faces[hit.face]
            .surface_at(hit.position)
            .map(|v| v.as_dvec3())
    }

    /// Returns the number of candidates per area at a point of a face, by the face's mean emission.
    fn candidate_density(&self, face: usize) -> f64 {
        let mean = self.scene.faces[face].emission.as_dvec3();
        f64::from(LAMP_CANDIDATES) * self.lamps.area_density(mean)
    }
}

/// Samples a point of the one or two triangles of a face or texel.
fn sample_triangles(triangles: &[RayTriangle], face: usize, source: &mut PathSampler<'_>) -> SurfacePoint {
    let areas: f64 = triangles.iter().map(RayTriangle::area).sum();
    let first = source.next_number() * areas < triangles[0].area();
    let triangle = if first {
        &triangles[0]
    } else {
        &triangles[triangles.len() - 1]
    };
    SurfacePoint {
        face,
        position: triangle.point_at(source.next_pair()),
    }
}

/// Maps two numbers within 0…1 to a cosine-distributed direction about z.
fn cosine_direction(u: f64, v: f64) -> DVec3 {
    let (r, angle) = (u.sqrt(), TAU * v);
    DVec3::new(r * angle.cos(), r * angle.sin(), (1.0 - u).sqrt())
}

/// Returns cosine-distributed directions about z.
fn probe_directions() -> Vec<DVec3> {
    let golden = 5.0_f64.sqrt() / 2.0 - 0.5;
    let at = |k: u32| {
        cosine_direction(
            (f64::from(k) + 0.5) / f64::from(PROBE_DIRECTIONS),
            (f64::from(k) * golden).fract(),
        )
    };
    (0..PROBE_DIRECTIONS).map(at).collect()
}

/// Returns the weight of the balance heuristic.
fn balance_heuristic(own: f64, other: f64) -> f64 {
    if own > 0.0 { own / (own + other) } else { 0.0 }
}

/// Source of the numbers of one path, 0 ≤ x < 1: Sobol dimensions first, then a pseudo-random generator.
struct PathSampler<'a> {
    path: u32,
    seed: u32,
    used: u32,
    generator: &'a mut Xoshiro256PlusPlus,
}

impl<'a> PathSampler<'a> {
    fn new(path: u32, seed: u32, generator: &'a mut Xoshiro256PlusPlus) -> Self {
        Self {
            path,
            seed,
            used: 0,
            generator,
        }
    }

    fn next_number(&mut self) -> f64 {
        if self.used >= SOBOL_DIMENSIONS {
            return self.generator.random();
        }
        self.used += 1;
        f64::from(sobol_burley::sample(self.path, self.used - 1, self.seed))
    }

    fn next_pair(&mut self) -> DVec2 {
        DVec2::new(self.next_number(), self.next_number())
    }
}
