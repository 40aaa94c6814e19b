//! A path tracer: the radiosity of every texel by chance, from the scene's faces alone.
//!
//! ```text
//! B − E = ρH,  H(x) = ∫ (E + ρH)(y) G(x, y) dy,  G = cosθx cosθy V / (π |x − y|²)
//! ```
//! It shares neither form factors nor rays with the solvers, and knows no radiosity constant over a
//! texel: what it is off by is noise, and it says how much. At each vertex of a path a point y of the
//! lamps, drawn by power (density p), and one by the cosine (density G) are both asked; each counts
//! with its share p/(p + G) or G/(p + G) of the densities (Veach & Guibas 1995), so that nothing
//! counts more than E, however near a lamp is. Backs are black and opaque.

mod geometry;

use crate::diff::pair::Pair;
use crate::diff::reflected::{Reflected, offsets};
use common::mesh::Mesh;
use common::scene::Scene;
use common::texel::{count, outline};
use geometry::{Hit, Lamps, Solid, Triangle};
use glam::{DVec2, DVec3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::f64::consts::TAU;

type Source = Xoshiro256PlusPlus;

/// What was found.
pub struct Traced<'a> {
    /// B − E, means over the texels.
    pub reflected: Reflected<'a>,
    /// Their standard errors.
    pub error: Vec<DVec3>,
}

/// Traces `paths` paths from each texel of `mesh`; the same bits from the same `seed`.
pub fn trace<'a>(scene: &'a Scene, mesh: &Mesh, paths: u32, seed: u64) -> Traced<'a> {
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
    let first = offsets(&resolutions);
    let solid = Solid::new(scene);
    let lamps = Lamps::new(scene);
    let texels: Vec<(usize, u32)> = resolutions
        .iter()
        .enumerate()
        .flat_map(|(face, resolution)| (0..count(*resolution)).map(move |k| (face, k)))
        .collect();
    debug_assert_eq!(texels.len(), first[resolutions.len()]);
    let tracer = Tracer {
        scene,
        solid,
        lamps,
    };
    let (values, error) = texels
        .par_iter()
        .enumerate()
        .map(|(k, (face, index))| {
            // Seeds are spread by SplitMix64.
            let mut source = Source::seed_from_u64(seed.wrapping_add(k as u64));
            let corners = outline(&scene.faces[*face], resolutions[*face], *index).padded();
            tracer.texel(&mut source, *face, corners, paths)
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
/// q = ΣA(d² − s²) / ΣA(b² − s²),  var ΣA d² = ΣA²(4(d² − s²)s² + 2s⁴),  rms = √q
/// ```
/// d = a − b, s: the standard error of b, normal for many paths.
pub fn rms(pair: &Pair) -> [f64; 2] {
    let none = Vec::new();
    let error = pair.error.as_ref().unwrap_or(&none);
    let channel = |c: usize| {
        let (mut square, mut variance, mut truth) = (0.0, 0.0, 0.0);
        for (k, error) in error.iter().enumerate() {
            let (area, noise) = (pair.areas[k], error[c] * error[c]);
            let signal = (pair.a[k][c] - pair.b[k][c]).powi(2) - noise;
            square += area * signal;
            variance += area * area * (4.0 * signal.max(0.0) + 2.0 * noise) * noise;
            truth += area * (pair.b[k][c].powi(2) - noise);
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

struct Tracer<'a> {
    scene: &'a Scene,
    solid: Solid,
    lamps: Lamps,
}

impl Tracer<'_> {
    /// Mean and standard error.
    fn texel(
        &self,
        source: &mut Source,
        face: usize,
        [a, b, c, d]: [DVec3; 4],
        paths: u32,
    ) -> (DVec3, DVec3) {
        let halves = [[a, b, c], [a, c, d]].map(|corners| Triangle::new(face, corners));
        let areas = halves.map(|half| half.area());
        let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for _ in 0..paths {
            let first = source.random::<f64>() * (areas[0] + areas[1]) < areas[0];
            let at = halves[usize::from(!first)].point(unit_square(source));
            let found = self.path(source, Hit { face, at });
            sum += found;
            squares += found * found;
        }
        let n = f64::from(paths);
        let mean = sum / n;
        let variance = (squares / n - mean * mean).max(DVec3::ZERO) / (n - 1.0);
        (mean, variance.map(f64::sqrt))
    }

    /// What one path from a point says of ρH there.
    fn path(&self, source: &mut Source, mut at: Hit) -> DVec3 {
        let mut found = DVec3::ZERO;
        let mut weight = self.reflectance(at.face);
        loop {
            found += weight * self.lamplight(source, &at);
            let along = self.cosine(source, at.face);
            let Some(next) = self.solid.hit(&at, along) else {
                return found;
            };
            let emission = self.scene.faces[next.face].emission.as_dvec3();
            let g = self.solid.kernel(&at, &next);
            found += weight * emission * share(g, self.lamps.density(emission));
            // Goes on as often as the face reflects.
            let reflectance = self.reflectance(next.face);
            let survival = reflectance.max_element();
            if source.random::<f64>() >= survival {
                return found;
            }
            weight *= reflectance / survival;
            at = next;
        }
    }

    /// Light straight from a point of a lamp.
    fn lamplight(&self, source: &mut Source, at: &Hit) -> DVec3 {
        let Some(lamp) = self.lamps.draw(source.random(), unit_square(source)) else {
            return DVec3::ZERO;
        };
        let g = self.solid.kernel(at, &lamp);
        if g <= 0.0 || self.solid.hides(at, &lamp) {
            return DVec3::ZERO;
        }
        let emission = self.scene.faces[lamp.face].emission.as_dvec3();
        let density = self.lamps.density(emission);
        emission * g / density * share(density, g)
    }

    /// A direction from a face, as likely as its cosine (Malley).
    fn cosine(&self, source: &mut Source, face: usize) -> DVec3 {
        let [u, v] = unit_square(source).to_array();
        let (r, angle) = (u.sqrt(), TAU * v);
        let normal = self.solid.normals[face];
        let (x, y) = normal.any_orthonormal_pair();
        x * (r * angle.cos()) + y * (r * angle.sin()) + normal * (1.0 - u).sqrt()
    }

    fn reflectance(&self, face: usize) -> DVec3 {
        self.scene.faces[face].reflectance.as_dvec3()
    }
}

/// The balance heuristic.
fn share(own: f64, other: f64) -> f64 {
    if own > 0.0 { own / (own + other) } else { 0.0 }
}

fn unit_square(source: &mut Source) -> DVec2 {
    DVec2::new(source.random(), source.random())
}
