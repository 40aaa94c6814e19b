//! The error of light that is interpolated between texels, as a viewer or a lightmap's filter does, and texels on which it
//! is about as small as requested.
//!
//! ```text
//! e² = 3/2 q d²    q = d²/D²    d², D²: squared deviation of 4×4 and of 8×8 texels from their mean and slope
//! ```
//! Linear interpolation reproduces a mean and a slope. If the texels are halved, e² falls to about q e²: to 1/2 at a hard
//! edge of a shadow, where e² is 3/4 d², and to 1/16 where light is smooth, where it is a tenth of d².

use super::resolution::{TexelError, halve_by_cost};
use super::step::SolveStep;
use common::mesh::Texel;
use common::scene::{Face, Scene};
use cpu::hierarchy::linear_radiosity::{LinearRadiosity, pull_radiosity};
use cpu::hierarchy::tree::TexelTree;
use glam::Vec3;

/// Squared error of interpolation over q d².
const ERROR_PER_DEVIATION: f64 = 1.5;
/// q where light is smooth, and beside a hard edge.
const RATIO_RANGE: [f64; 2] = [1.0 / 16.0, 0.5];
/// An estimated error up to this multiple of the requested one is left: the estimate is no more accurate.
const ESTIMATE_TOLERANCE: f64 = 1.25;
/// Largest number of texels that follow from the light.
const MAX_TEXELS_BY_LIGHT: u64 = 1 << 17;

/// Squared deviations of the light of a face from mean and slope, integrals over the face.
#[derive(Clone, Copy, Default)]
struct FitDeviations {
    /// Over 4×4 texels.
    fine: f64,
    /// Over 8×8 texels; 0 on fewer.
    coarse: f64,
}

impl FitDeviations {
    /// Returns q, or `otherwise` without 8×8 texels.
    fn ratio_or(self, otherwise: f64) -> f64 {
        match self.coarse > 0.0 {
            true => (self.fine / self.coarse).clamp(RATIO_RANGE[0], RATIO_RANGE[1]),
            false => otherwise,
        }
    }
}

/// Returns the error of interpolation between the texels of `step`, if they receive this `irradiance`, on each face in
/// `channel`, its square times `scale`.
pub(super) fn interpolation_errors(
    scene: &Scene,
    step: &SolveStep,
    irradiance: &[Vec3],
    (channel, scale): (usize, f64),
) -> Vec<TexelError> {
    let by_face = measure_deviations(scene, step, irradiance, channel);
    let mut sum = FitDeviations::default();
    for own in by_face.iter().filter(|own| own.coarse > 0.0) {
        sum.fine += own.fine;
        sum.coarse += own.coarse;
    }
    let mean_ratio = sum.ratio_or(RATIO_RANGE[1]);
    let error = |own: &FitDeviations| {
        let ratio = own.ratio_or(mean_ratio);
        TexelError {
            square: ERROR_PER_DEVIATION * ratio * own.fine * scale,
            ratio,
        }
    };
    by_face.iter().map(error).collect()
}

/// Returns the sum of the squares of all `errors`.
pub(super) fn sum_errors(errors: &[TexelError]) -> f64 {
    errors.iter().map(|own| own.square).sum()
}

/// Halves `texels` until interpolation errs by about `error` at most, where it errs by `errors` on each face.
pub(super) fn reduce_interpolation_error(
    faces: &[Face],
    texels: &[[u32; 2]],
    errors: &[TexelError],
    error: f64,
) -> Vec<[u32; 2]> {
    let all = sum_errors(errors);
    if all <= (ESTIMATE_TOLERANCE * error).powi(2) {
        return texels.to_vec();
    }
    halve_by_cost(faces, texels, errors, (error * error / all, MAX_TEXELS_BY_LIGHT))
}

/// Returns the deviations of the light of the open parts in `channel`.
fn measure_deviations(scene: &Scene, step: &SolveStep, irradiance: &[Vec3], channel: usize) -> Vec<FitDeviations> {
    let (mesh, open) = (&step.mesh, &step.outcome.open);
    let tree = TexelTree::new(scene, mesh);
    let areas: Vec<f32> = mesh
        .texels
        .iter()
        .zip(open)
        .map(|(texel, open)| texel.area * open)
        .collect();
    let fit = |irradiance: &[Vec3]| {
        // On a painted face the irradiance counts, not the paint.
        let reflected = |((texel, open), irradiance): ((&Texel, &f32), &Vec3)| {
            let face = &scene.faces[texel.face as usize];
            let even = face.paint.as_ref().map_or(texel.reflectance, |_| face.reflectance);
            match *open > 0.0 {
                true => even * irradiance / *open,
                false => Vec3::ZERO,
            }
        };
        let light: Vec<Vec3> = mesh.texels.iter().zip(open).zip(irradiance).map(reflected).collect();
        pull_radiosity(&tree, &areas, &light)
    };
    // The noise of rays deviates, too, by the square of half the difference of their halves in the mean.
    let [light, noise] = [irradiance, &step.outcome.noise].map(fit);
    let of_face = |(f, face): (usize, &Face)| {
        let level_of = |k: u32| tree.nodes[k as usize].level;
        let levels = level_of(tree.leaves_of(tree.roots[f])[0].node);
        let over = |levels_above: u32| {
            let nodes = tree.largest_nodes(f, |k| level_of(k) + levels_above >= levels);
            let square = |fits: &[LinearRadiosity], k: u32| f64::from(fits[k as usize].deviation[channel]).powi(2);
            let sum: f64 = nodes.iter().map(|k| square(&light, *k) - square(&noise, *k)).sum();
            sum.max(0.0) / nodes.len() as f64 * face.area()
        };
        FitDeviations {
            fine: over(2),
            coarse: if levels >= 3 { over(3) } else { 0.0 },
        }
    };
    scene.faces.iter().enumerate().map(of_face).collect()
}

#[cfg(test)]
mod tests {
    use super::{interpolation_errors, reduce_interpolation_error};
    use crate::solve::resolution::TexelError;
    use crate::solve::step::SolveStep;
    use common::mesh::Mesh;
    use common::sampling::pcg_hash;
    use common::scene::{Face, Scene};
    use cpu::hierarchy::solver::TexelSolution;
    use glam::{DVec2, DVec3, Vec3};

    /// Texels per side of a unit square.
    const TEXELS_PER_SIDE: u32 = 64;
    /// Points per side of a texel on which light is averaged.
    const POINTS_PER_TEXEL_SIDE: u32 = 8;

    /// Returns the means over the texels of a unit square of `light` at (x, y), one row after the other.
    fn texel_means(light: &dyn Fn(DVec2) -> f64) -> Vec<f64> {
        let mean = |k: u32| {
            let point = |p: u32| {
                let within = DVec2::new(
                    f64::from(p % POINTS_PER_TEXEL_SIDE),
                    f64::from(p / POINTS_PER_TEXEL_SIDE),
                ) + 0.5;
                let texel = DVec2::new(f64::from(k % TEXELS_PER_SIDE), f64::from(k / TEXELS_PER_SIDE));
                light((texel + within / f64::from(POINTS_PER_TEXEL_SIDE)) / f64::from(TEXELS_PER_SIDE))
            };
            (0..POINTS_PER_TEXEL_SIDE * POINTS_PER_TEXEL_SIDE)
                .map(point)
                .sum::<f64>()
                / f64::from(POINTS_PER_TEXEL_SIDE * POINTS_PER_TEXEL_SIDE)
        };
        (0..TEXELS_PER_SIDE * TEXELS_PER_SIDE).map(mean).collect()
    }

    /// Returns ∫ (interpolated − light)² dA, bilinear between the texels' centres.
    fn measure_error(light: &dyn Fn(DVec2) -> f64, means: &[f64]) -> f64 {
        let points = TEXELS_PER_SIDE * POINTS_PER_TEXEL_SIDE;
        let at = |x: u32, y: u32| {
            means[(y.min(TEXELS_PER_SIDE - 1) * TEXELS_PER_SIDE + x.min(TEXELS_PER_SIDE - 1)) as usize]
        };
        let square = |p: u32| {
            let place = (DVec2::new(f64::from(p % points), f64::from(p / points)) + 0.5) / f64::from(points);
            let grid = (place * f64::from(TEXELS_PER_SIDE) - 0.5)
                .clamp(DVec2::ZERO, DVec2::splat(f64::from(TEXELS_PER_SIDE - 1)));
            let (x, y) = (grid.x as u32, grid.y as u32);
            let row = |y: u32| at(x, y) + grid.x.fract() * (at(x + 1, y) - at(x, y));
            (row(y) + grid.y.fract() * (row(y + 1) - row(y)) - light(place)).powi(2)
        };
        (0..points * points).map(square).sum::<f64>() / f64::from(points * points)
    }

    fn estimate_error(irradiance: Vec<Vec3>, noise: Vec<Vec3>) -> f64 {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let scene = Scene {
            faces: vec![Face::quad("square", corners, Vec3::ZERO, Vec3::ONE)],
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, TEXELS_PER_SIDE, 1).expect("a mesh");
        let mut outcome = TexelSolution {
            open: vec![1.0; mesh.texels.len()],
            ..TexelSolution::default()
        };
        let index = |k: usize| mesh.texels[k].index as usize;
        outcome.irradiance = (0..mesh.texels.len()).map(|k| irradiance[index(k)]).collect();
        outcome.noise = (0..mesh.texels.len()).map(|k| noise[index(k)]).collect();
        let step = SolveStep::new(vec![[TEXELS_PER_SIDE; 2]], mesh, outcome);
        interpolation_errors(&scene, &step, &step.outcome.irradiance, (0, 1.0))[0].square
    }

    fn without_noise(means: &[f64]) -> f64 {
        let irradiance: Vec<Vec3> = means.iter().map(|h| Vec3::splat(*h as f32)).collect();
        estimate_error(irradiance, vec![Vec3::ZERO; means.len()])
    }

    /// Edges of several widths in texels and directions, each at eight places of a block of 8×8 texels: the estimate is
    /// two thirds of the error of hard edges along texels, and up to twice that of edges of two texels.
    #[test]
    fn error_at_edges_is_estimated() {
        for width in [1e-9, 1.0, 2.0, 4.0, 20.0] {
            for degrees in [0.0, 10.0, 25.0, 45.0, 80.0_f64] {
                let across = DVec2::from_angle(degrees.to_radians());
                let (mut estimated, mut measured) = (0.0, 0.0);
                for place in 0..8 {
                    let middle = 0.45 + 8.0 / f64::from(TEXELS_PER_SIDE) * (f64::from(place) / 8.0 + 0.05);
                    let light = |place: DVec2| {
                        let texels = (place - middle).dot(across) * f64::from(TEXELS_PER_SIDE);
                        (texels / width + 0.5).clamp(0.0, 1.0)
                    };
                    let means = texel_means(&light);
                    estimated += without_noise(&means);
                    measured += measure_error(&light, &means);
                }
                let ratio = (estimated / measured).sqrt();
                assert!((0.65..2.1).contains(&ratio), "{width} at {degrees}: {ratio}");
            }
        }
    }

    #[test]
    fn linear_light_has_no_error() {
        let means = texel_means(&|place| 0.2 + 0.5 * place.x + 0.3 * place.y);
        // Of f32, squared.
        assert!(without_noise(&means) < 1e-10);
    }

    #[test]
    fn noise_is_no_error() {
        let random = |seed: u32| {
            let value = |k| Vec3::splat(pcg_hash(2 * k + seed) as f32 / u32::MAX as f32 - 0.5);
            (0..TEXELS_PER_SIDE * TEXELS_PER_SIDE).map(value).collect::<Vec<Vec3>>()
        };
        let noise = random(0);
        let irradiance = random(1).into_iter().map(|noise| Vec3::ONE + noise).collect();
        // Of the variance of 1/12 a fit leaves 13/16, and q is 1/2. The mean over 4096 texels scatters by 2 %.
        assert!(estimate_error(irradiance, noise) < 0.1 * 0.75 * 13.0 / 16.0 / 12.0);
    }

    #[test]
    fn texels_are_halved_until_error_is_small_enough() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let faces = vec![Face::quad("square", corners, Vec3::ZERO, Vec3::ONE); 2];
        let reduce = |squares: [f64; 2]| {
            let errors = squares.map(|square| TexelError { square, ratio: 0.5 });
            reduce_interpolation_error(&faces, &[[8; 2]; 2], &errors, 0.1)
        };
        // Within a quarter of the request nothing is halved.
        assert_eq!(reduce([0.015, 0.0]), [[8; 2]; 2]);
        assert_eq!(reduce([0.019, 0.0]), [[16, 16], [8, 8]]);
        assert_eq!(reduce([0.039, 0.0]), [[32, 32], [8, 8]]);
        assert_eq!(reduce([0.019, 0.004]), [[32, 32], [16, 16]]);
        // The first would still err by 0.1 on the most texels.
        assert_eq!(reduce([0.05, 0.005]), [[32, 32], [8, 8]]);
    }
}
