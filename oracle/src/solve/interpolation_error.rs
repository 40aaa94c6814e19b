//! The error of light that is interpolated between texels, as a viewer or a lightmap's filter does, and texels on which it
//! is about as small as requested.
//!
//! ```text
//! e² = 3/2 q d²    q = d²/D²    d², D²: squared deviation of 4×4 and of 8×8 texels from their mean and slope
//! ```
//! Linear interpolation reproduces a mean and a slope. If the texels are halved, e² falls to about q e²: to 1/2 at a hard
//! edge of a shadow, where e² is 3/4 d², and to 1/16 where light is smooth, where it is a tenth of d².

use super::resolution::{TexelError, halve_by_cost};
use super::step::{SolveStep, open_areas};
use common::mesh::Texel;
use common::scene::{Face, Scene};
use cpu::hierarchy::linear_radiosity::{LinearRadiosity, pull_radiosity};
use cpu::hierarchy::tree::TexelTree;
use cpu::ray_cast::{Halves, measure_fit_residuals};
use glam::{Vec3, Vec3A};

/// Squared error of interpolation over q d².
const ERROR_PER_DEVIATION: f64 = 1.5;
/// Levels of the tree of a face's texels between a texel and 4×4 of them.
const FINE_LEVELS: u32 = 2;
/// q where light is smooth, and beside a hard edge.
const RATIO_RANGE: [f64; 2] = [1.0 / 16.0, 0.5];
/// An estimated error up to this multiple of the requested one is left: the estimate is no more accurate.
const ESTIMATE_TOLERANCE: f64 = 1.25;
/// Error of interpolated reflected light up to which it is not gathered anew, as a share of the requested error.
pub(super) const REFLECTED_SHARE: f64 = 0.5;
/// Largest number of texels that follow from the light.
pub(super) const MAX_TEXELS_BY_LIGHT: u64 = 1 << 17;

/// Light that the texels of a step receive: the irradiance of each, the mean over its area, and its noise, half of the
/// difference between the halves of the rays.
pub(super) struct ReceivedLight {
    irradiance: Vec<Vec3>,
    noise: Vec<Vec3>,
}

impl ReceivedLight {
    /// Makes light without noise.
    pub fn without_noise(irradiance: Vec<Vec3>) -> Self {
        let noise = vec![Vec3::ZERO; irradiance.len()];
        Self { irradiance, noise }
    }

    /// Makes light from that of each half of the rays.
    pub fn from_halves(halves: &[Halves]) -> Self {
        let (irradiance, noise) = halves
            .iter()
            .map(|[a, b]| (Vec3::from(0.5 * (*a + *b)), Vec3::from(0.5 * (*a - *b))))
            .unzip();
        Self { irradiance, noise }
    }
}

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

    fn add(self, other: Self) -> Self {
        Self {
            fine: self.fine + other.fine,
            coarse: self.coarse + other.coarse,
        }
    }

    fn to_error(self, ratio: f64, scale: f64) -> TexelError {
        TexelError {
            square: ERROR_PER_DEVIATION * ratio * self.fine * scale,
            ratio,
        }
    }
}

/// Returns the error of interpolation of `light` between the texels of `step` on each face in `channel`, its square times
/// `scale`. Where many faces of fewer than 4×4 texels lie on one surface, they are judged together.
pub(super) fn interpolation_errors(
    scene: &Scene,
    step: &SolveStep,
    light: &ReceivedLight,
    (channel, scale): (usize, f64),
) -> Vec<TexelError> {
    let by_face = measure_deviations(scene, step, light, channel);
    let is_known = |own: &&FitDeviations| own.coarse > 0.0;
    let sum = by_face.iter().filter(is_known).copied();
    let mean_ratio = sum
        .fold(FitDeviations::default(), FitDeviations::add)
        .ratio_or(RATIO_RANGE[1]);
    let across = measure_across_faces(scene, step, light, channel);
    // The ratio of few texels is mostly noise.
    let sum = across
        .iter()
        .copied()
        .fold(FitDeviations::default(), FitDeviations::add);
    let ratio_across = sum.ratio_or(mean_ratio);
    let error = |(own, across): (&FitDeviations, &FitDeviations)| match across.fine != 0.0 {
        true => across.to_error(ratio_across, scale),
        false => own.to_error(own.ratio_or(mean_ratio), scale),
    };
    by_face.iter().zip(&across).map(error).collect()
}

/// Returns the error of interpolation of all light between the texels of `step` in `channel`, its square times `scale`.
pub(super) fn measure_interpolation(scene: &Scene, step: &SolveStep, (channel, scale): (usize, f64)) -> f64 {
    let light = ReceivedLight {
        irradiance: step.outcome.irradiance.clone(),
        noise: step.outcome.noise.clone(),
    };
    let errors = interpolation_errors(scene, step, &light, (channel, scale));
    sum_errors(&errors).max(0.0).sqrt()
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
    // Noise adds to some faces and takes from others; those that it adds to are not to be halved until they make up for it.
    let positive: f64 = errors.iter().map(|own| own.square.max(0.0)).sum();
    let remaining = 1.0 - (all - error * error) / positive;
    halve_by_cost(faces, texels, errors, (remaining, MAX_TEXELS_BY_LIGHT))
}

/// Returns the deviations of the light of the open parts in `channel` on each face by itself.
fn measure_deviations(scene: &Scene, step: &SolveStep, light: &ReceivedLight, channel: usize) -> Vec<FitDeviations> {
    let (mesh, open) = (&step.mesh, &step.outcome.open);
    let tree = TexelTree::new(scene, mesh);
    let areas = open_areas(step);
    let fit = |irradiance: &[Vec3]| {
        let reflected = |((texel, open), irradiance): ((&Texel, &f32), &Vec3)| match *open > 0.0 {
            true => even_reflectance(scene, texel) * irradiance / *open,
            false => Vec3::ZERO,
        };
        let light: Vec<Vec3> = mesh.texels.iter().zip(open).zip(irradiance).map(reflected).collect();
        pull_radiosity(&tree, &areas, &light)
    };
    // The noise of rays deviates, too, by the square of half the difference of their halves in the mean.
    let [light, noise] = [&light.irradiance, &light.noise].map(|light| fit(light));
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
            fine: over(FINE_LEVELS),
            coarse: if levels > FINE_LEVELS {
                over(FINE_LEVELS + 1)
            } else {
                0.0
            },
        }
    };
    scene.faces.iter().enumerate().map(of_face).collect()
}

/// Returns the deviations in `channel` on faces that have fewer than 4×4 texels, over groups of 16 and of 64 texels of such
/// faces.
fn measure_across_faces(scene: &Scene, step: &SolveStep, light: &ReceivedLight, channel: usize) -> Vec<FitDeviations> {
    let (mesh, open) = (&step.mesh, &step.outcome.open);
    let is_small = |k: &u32| {
        let [along, across] = step.resolutions[mesh.texels[*k as usize].face as usize];
        open[*k as usize] > 0.0 && along.max(across) < 1 << FINE_LEVELS
    };
    let small: Vec<u32> = (0..mesh.texels.len() as u32).filter(is_small).collect();
    // Irradiance goes on across faces of different reflectance.
    let on_open = |k: usize| {
        let (h, noise) = (light.irradiance[k], light.noise[k]);
        [h + noise, h - noise].map(|half| Vec3A::from(half / open[k].max(f32::MIN_POSITIVE)))
    };
    let light: Vec<Halves> = (0..open.len()).map(on_open).collect();
    let mut by_face = vec![FitDeviations::default(); scene.faces.len()];
    for (k, [fine, coarse]) in measure_fit_residuals(mesh, &open_areas(step), (light, channel), small) {
        let texel = &mesh.texels[k as usize];
        let reflected = f64::from(even_reflectance(scene, texel)[channel]) * mesh.unit;
        let own = &mut by_face[texel.face as usize];
        *own = own.add(FitDeviations {
            fine: fine * reflected.powi(2),
            coarse: coarse * reflected.powi(2),
        });
    }
    by_face
}

/// Returns the reflectance of a texel; on a painted face that of the face, since the irradiance counts, not the paint.
fn even_reflectance(scene: &Scene, texel: &Texel) -> Vec3 {
    let face = &scene.faces[texel.face as usize];
    face.paint.as_ref().map_or(texel.reflectance, |_| face.reflectance)
}

#[cfg(test)]
mod tests {
    use super::{ReceivedLight, interpolation_errors, reduce_interpolation_error};
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

    /// Estimates the error on a unit square of so many faces per side.
    fn estimate_error(faces_per_side: u32, irradiance: &[Vec3], noise: &[Vec3]) -> f64 {
        estimate_with_reflectance((faces_per_side, &|_| 1.0), irradiance, noise)
    }

    /// Does so with faces of different reflectance.
    fn estimate_with_reflectance(
        (faces_per_side, reflectance): (u32, &dyn Fn(u32) -> f32),
        irradiance: &[Vec3],
        noise: &[Vec3],
    ) -> f64 {
        let side = 1.0 / f64::from(faces_per_side);
        let face = |f: u32| {
            let corner = DVec3::new(f64::from(f % faces_per_side), f64::from(f / faces_per_side), 0.0) * side;
            let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|to| corner + side * to);
            Face::quad("square", corners, Vec3::ZERO, Vec3::splat(reflectance(f)))
        };
        let scene = Scene {
            faces: (0..faces_per_side * faces_per_side).map(face).collect(),
            ..Scene::default()
        };
        let texels = TEXELS_PER_SIDE / faces_per_side;
        let mesh = Mesh::uniform(&scene, texels, 1).expect("a mesh");
        let mut outcome = TexelSolution {
            open: vec![1.0; mesh.texels.len()],
            ..TexelSolution::default()
        };
        let index = |k: usize| {
            let texel = &mesh.texels[k];
            let [x, y] = [texel.face % faces_per_side, texel.face / faces_per_side].map(|at| at * texels);
            ((y + texel.index / texels) * TEXELS_PER_SIDE + x + texel.index % texels) as usize
        };
        outcome.irradiance = (0..mesh.texels.len()).map(|k| irradiance[index(k)]).collect();
        outcome.noise = (0..mesh.texels.len()).map(|k| noise[index(k)]).collect();
        let step = SolveStep::new(vec![[texels; 2]; scene.faces.len()], mesh, outcome);
        let light = ReceivedLight {
            irradiance: step.outcome.irradiance.clone(),
            noise: step.outcome.noise.clone(),
        };
        let errors = interpolation_errors(&scene, &step, &light, (0, 1.0));
        errors.iter().map(|error| error.square).sum()
    }

    fn without_noise(faces_per_side: u32, means: &[f64]) -> f64 {
        let irradiance: Vec<Vec3> = means.iter().map(|h| Vec3::splat(*h as f32)).collect();
        estimate_error(faces_per_side, &irradiance, &vec![Vec3::ZERO; means.len()])
    }

    /// Edges of several widths in texels and directions, each at eight places of a block of 8×8 texels, on one face and across
    /// many: the estimate is two thirds of the error of hard edges along texels, and up to twice that of edges of two texels.
    #[test]
    fn error_at_edges_is_estimated() {
        // Clusters of 16 texels are not all squares.
        for (faces_per_side, most) in [(1, 2.1), (32, 2.3)] {
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
                        estimated += without_noise(faces_per_side, &means);
                        measured += measure_error(&light, &means);
                    }
                    let ratio = (estimated / measured).sqrt();
                    assert!(
                        (0.65..most).contains(&ratio),
                        "{faces_per_side} faces, {width} at {degrees}: {ratio}"
                    );
                }
            }
        }
    }

    #[test]
    fn linear_light_has_no_error() {
        let means = texel_means(&|place| 0.2 + 0.5 * place.x + 0.3 * place.y);
        // Of f32, squared.
        for faces_per_side in [1, 32] {
            assert!(without_noise(faces_per_side, &means) < 1e-10);
        }
    }

    /// Small faces of two reflectances that lie in turn err by as much of light at an edge as those of one whose square is the
    /// mean of theirs, and by none of even light.
    #[test]
    fn reflectance_of_small_faces_is_no_edge() {
        let estimate = |light: &dyn Fn(DVec2) -> f64, reflectance: &dyn Fn(u32) -> f32| {
            let irradiance: Vec<Vec3> = texel_means(light).iter().map(|h| Vec3::splat(*h as f32)).collect();
            estimate_with_reflectance((32, reflectance), &irradiance, &vec![Vec3::ZERO; irradiance.len()])
        };
        let in_turn = |f: u32| [0.1, 0.7][((f % 32 + f / 32) % 2) as usize];
        // Of f32, squared.
        assert!(estimate(&|_| 1.0, &in_turn) < 1e-10);
        let edge = |place: DVec2| f64::from(u8::from(place.x > 0.47));
        let ratio = estimate(&edge, &in_turn) / estimate(&edge, &|_| 0.5);
        assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
    }

    #[test]
    fn noise_is_no_error() {
        let random = |seed: u32| {
            let value = |k| Vec3::splat(pcg_hash(2 * k + seed) as f32 / u32::MAX as f32 - 0.5);
            (0..TEXELS_PER_SIDE * TEXELS_PER_SIDE).map(value).collect::<Vec<Vec3>>()
        };
        let noise = random(0);
        let irradiance: Vec<Vec3> = random(1).into_iter().map(|noise| Vec3::ONE + noise).collect();
        // Of the variance of 1/12 a fit leaves 13/16, and q is 1/2. The mean over 4096 texels scatters by 2 %.
        for faces_per_side in [1, 32] {
            assert!(estimate_error(faces_per_side, &irradiance, &noise) < 0.1 * 0.75 * 13.0 / 16.0 / 12.0);
        }
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
