//! Error estimate of an adaptive solve: the difference of its last two steps, unshot light, missing closure of the
//! links, and rounding. The solve ends when it is small enough, and reports it.

use super::regather::estimate::{MAX_NAMED_FACES, descending_order, largest_faces};
use super::regather::{ErrorCause, ErrorEstimate, ErrorPart, EstimateBasis, FaceError};
use super::resolution::{RequestedTexels, coarser_texels, resample_face};
use super::step::SolveStep;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::precision::UNIT_ROUNDOFF;
use common::scene::{Face, Scene};
use common::shooting::SolveRun;
use common::texel::{first_texels, texel_count};
use cpu::hierarchy::shot_log::escape_deviation;
use glam::DVec3;
use std::f64::consts::SQRT_2;

/// Ratio of the errors of successive steps: each is solved to half the error of the step before.
const STEP_ERROR_RATIO: f64 = 0.5;
/// Largest ratio of successive changes used for extrapolation.
const MAX_CHANGE_RATIO: f64 = 0.75;
/// Estimated error of interpolation, over the requested error, above which a note names it. Texels are halved from 1.25 on, and
/// the estimate changes with the noise.
const NOTED_INTERPOLATION: f64 = 1.5;
/// A face is reported if its relative error is this many times that of the whole scene.
const REPORTED_ERROR_RATIO: f64 = 10.0;
/// Standard deviations of the escaped power that a closure defect has to exceed.
const CLOSURE_DEVIATIONS: f64 = 3.0;
/// Standard deviations that a face's change by rays has to exceed for the face to be reported.
const CHANGE_DEVIATIONS: f64 = 3.0;
/// Smallest absorbed share of the area; it bounds the light between white walls.
const MIN_ABSORBED_SHARE: f64 = 1e-9;

/// Changes from step to step of an adaptive solve.
#[derive(Default)]
pub struct ErrorHistory {
    /// Change of each step, relative to the RMS of B − E.
    pub changes: Vec<f64>,
    /// Details of the last change.
    pub last_change: Option<StepChange>,
    /// Number of links of the last step.
    pub links: u64,
    /// Error of light that is interpolated between the last step's texels, relative to the RMS of B − E; 0 if texels are
    /// requested.
    pub interpolation: f64,
    /// Reason for an end before the requested error was reached.
    pub stop_reason: Option<String>,
    /// The changes are those of texels that are merged within a step, which are not extrapolated.
    pub of_merged_texels: bool,
}

impl ErrorHistory {
    /// Returns the number of steps.
    pub fn steps(&self) -> u32 {
        1 + self.changes.len() as u32
    }

    /// Upper bound of the remaining error, with the noise of rays. `None` after a single step.
    pub fn remaining_bound(&self) -> Option<f64> {
        let change = self.changes.last()? * self.remaining_share().bound;
        let noise = self.last_change.as_ref().map_or(0.0, |change| change.noise);
        Some(change.hypot(noise))
    }

    /// Copies the changes, so that foretold ones can be added.
    pub fn copy_changes(&self) -> Self {
        Self {
            changes: self.changes.clone(),
            ..Self::default()
        }
    }

    /// Returns whether the remaining error is known to be at most `error`.
    pub fn meets_target(&self, error: f64) -> bool {
        self.remaining_bound().is_some_and(|remaining| remaining <= error)
    }

    /// Remaining error as a multiple of the last change. If a step leaves the share q of the error e of the step before, the
    /// change is e − qe where the errors are alike and e·√(1 + q²) where they are independent. The one bounds the remaining
    /// error, qe; the root mean square of both is expected. q is ½, or the ratio of the last two changes if that is more.
    fn remaining_share(&self) -> RemainingShare {
        if self.of_merged_texels {
            return RemainingShare {
                expected: 1.0,
                bound: 1.0,
            };
        }
        let mut last = self.changes.iter().rev();
        let fall = match (last.next(), last.next()) {
            (Some(last), Some(before)) => (last / before).min(MAX_CHANGE_RATIO),
            _ => 0.0,
        };
        let fall = fall.max(STEP_ERROR_RATIO);
        let [alike, independent] = [fall / (1.0 - fall), fall / fall.hypot(1.0)];
        RemainingShare {
            expected: alike.hypot(independent) / SQRT_2,
            bound: alike,
        }
    }

    /// Estimates the error of `run` with all its causes; `made_up` is the error from the links' closure.
    pub fn estimate_error(&self, mesh: &Mesh, run: &SolveRun, made_up: f64) -> Option<ErrorEstimate> {
        let (last, remaining) = (self.changes.last()?, self.remaining_share());
        let [refinement, bound] = [remaining.expected, remaining.bound].map(|share| share * last);
        let change = self.last_change.as_ref();
        let faces = change.map_or(Vec::new(), |change| largest_faces(&change.by_face));
        let part = |cause: ErrorCause, error: f64, faces: Vec<u32>| ErrorPart { cause, error, faces };
        let parts = vec![
            part(ErrorCause::Refinement, refinement, faces),
            part(ErrorCause::Noise, change.map_or(0.0, |change| change.noise), Vec::new()),
            part(ErrorCause::Iteration, unshot_error(mesh, run), Vec::new()),
            part(ErrorCause::Closure, made_up, Vec::new()),
            part(ErrorCause::Rounding, rounding_error(mesh, run), Vec::new()),
        ];
        let square: f64 = parts.iter().map(|part| part.error.powi(2)).sum();
        let error = square.sqrt();
        Some(ErrorEstimate {
            error,
            upper: (square - refinement * refinement + bound * bound).max(square).sqrt(),
            evidence: EstimateBasis::SuccessiveSteps {
                changes: self.changes.clone(),
                worse: self.worst_faces(error),
            },
            parts,
        })
    }

    /// Returns the faces with a relative error above [`REPORTED_ERROR_RATIO`] times `error`, each relative to its own light, in
    /// the order of their share in the change.
    fn worst_faces(&self, error: f64) -> Vec<FaceError> {
        let Some(change) = &self.last_change else {
            return Vec::new();
        };
        let of = |face: u32| FaceError {
            face,
            error: self.remaining_share().expected * change.relative_change(face),
        };
        let faces = descending_order(&change.by_face).into_iter().map(of);
        let worse = faces.filter(|own| own.error > REPORTED_ERROR_RATIO * error && change.is_certain(own.face));
        worse.take(MAX_NAMED_FACES).collect()
    }

    /// Estimated refinement error of each texel of `mesh`, W/m²; `None` after a single step.
    pub fn error_map(&self, faces: &[Face], mesh: &Mesh) -> Option<Vec<f32>> {
        let change = self.last_change.as_ref()?;
        let share = self.remaining_share().expected;
        let mut map = vec![0.0; mesh.texels.len()];
        let mut order = mesh.texels_in_face_order().into_iter();
        let mut first = 0;
        for ((face, from), to) in faces.iter().zip(&change.resolutions).zip(&mesh.faces) {
            let end = first + texel_count(*from) as usize;
            let own = resample_face(&change.texel_squares[first..end], face, *from, to.resolution);
            for (d, k) in own.iter().zip(&mut order) {
                map[k] = (share * d.max_element().sqrt()) as f32;
            }
            first = end;
        }
        Some(map)
    }

    /// Returns a note if interpolation between texels errs by more than the `target`: smaller ones would have been too many.
    pub fn describe_interpolation(&self, target: f64) -> Option<String> {
        let off = self.interpolation;
        (off > NOTED_INTERPOLATION * target).then(|| {
            format!(
                "light interpolated between texels, as in pictures, is about {:.1} % off: --texels asks for smaller ones",
                100.0 * off
            )
        })
    }

    /// Returns a note if the error may be above the requested one, with the reason.
    pub fn describe_unmet_target(&self, target: f64, estimate: Option<&ErrorEstimate>) -> Option<String> {
        let reached = match estimate {
            Some(estimate) if estimate.upper <= target => return None,
            Some(ErrorEstimate { error, upper, .. }) if upper > error => {
                format!("about {:.2} %, at most {:.2} %,", 100.0 * error, 100.0 * upper)
            }
            Some(estimate) => format!("about {:.2} %", 100.0 * estimate.error),
            None => "an unknown error".into(),
        };
        let reason = self.stop_reason.as_deref().unwrap_or(match self.remaining_bound() {
            Some(remaining) if remaining <= target => "the rest is unshot light, missing closure of links, or rounding",
            _ => "the largest number of steps was done",
        });
        Some(format!(
            "an error of {:.2} % was requested, and {reached} was reached: {reason}",
            100.0 * target
        ))
    }
}

/// Remaining error as a multiple of the last change.
struct RemainingShare {
    expected: f64,
    bound: f64,
}

/// Change of B in a step, without the noise of rays, relative to the RMS of B − E, in the worst channel.
pub struct StepChange {
    /// Change of the whole scene.
    pub total: f64,
    /// Noise of the step's B, with the error of its smoothing, relative to the RMS of B − E, in its worst channel.
    pub noise: f64,
    /// Squared change of each face; they sum to the square of the whole, but for the noise.
    pub by_face: Vec<f64>,
    /// The worst channel.
    pub channel: usize,
    /// 1/∫ (B − E)² dA in that channel.
    pub scale: f64,
    /// Standard deviation of each face's squared change from the scatter of its texels: all of it on a face of one texel.
    deviations: Vec<f64>,
    /// ∫ (B − E)² dA of each face in that channel.
    pub reflected_squares: Vec<f64>,
    /// Texels of each face on which the two steps were compared.
    pub resolutions: Vec<[u32; 2]>,
    /// Squared change of B on each such texel, by channel.
    pub texel_squares: Vec<DVec3>,
}

/// Change of one face.
struct FaceChange {
    /// Texels on which it was measured.
    resolution: [u32; 2],
    /// Squared change of B on each of them.
    squares: Vec<DVec3>,
    /// Noise variance that is in the squares, by area.
    noise: DVec3,
}

impl StepChange {
    /// Compares `before` with `after`. Differences within requested texels do not count.
    pub fn compare_steps(scene: &Scene, before: &SolveStep, after: &SolveStep, requested: RequestedTexels) -> Self {
        let firsts = [before, after].map(|step| first_texels(&step.resolutions));
        Self::sum_faces(scene, after, requested, |f, face| {
            let both = coarser_texels(before.resolutions[f], after.resolutions[f]);
            let both = requested(f).map_or(both, |texels| coarser_texels(both, texels));
            let [a, b] = [(before, &firsts[0]), (after, &firsts[1])].map(|(step, first)| {
                let own = &step.radiosity[first[f]..first[f + 1]];
                resample_face(own, face, step.resolutions[f], both)
            });
            FaceChange {
                resolution: both,
                squares: a.iter().zip(&b).map(|(a, b)| (b - a) * (b - a)).collect(),
                noise: [before, after]
                    .map(|step| step.noise_of_face(face, f, both))
                    .into_iter()
                    .sum(),
            }
        })
    }

    /// Measures the change of ρH in `step`, given for each face on texels of `resolutions` and for each half of the rays.
    /// The product of the halves has no noise in the mean.
    pub fn from_halves(
        scene: &Scene,
        step: &SolveStep,
        (changes, resolutions): (&[[Vec<DVec3>; 2]], &[[u32; 2]]),
        requested: RequestedTexels,
    ) -> Self {
        Self::sum_faces(scene, step, requested, |f, _| {
            let [a, b] = &changes[f];
            FaceChange {
                resolution: resolutions[f],
                squares: a.iter().zip(b).map(|(a, b)| a * b).collect(),
                noise: DVec3::ZERO,
            }
        })
    }

    /// Sums the changes of all faces in the last step, `after`.
    fn sum_faces(
        scene: &Scene,
        after: &SolveStep,
        requested: RequestedTexels,
        change_of: impl Fn(usize, &Face) -> FaceChange,
    ) -> Self {
        let first = first_texels(&after.resolutions);
        let (mut systematic, mut deviations, mut lights) = (Vec::new(), Vec::new(), Vec::new());
        let (mut noise, mut removed) = (DVec3::ZERO, DVec3::ZERO);
        let (mut resolutions, mut texel_squares) = (Vec::new(), Vec::new());
        let mut all = DVec3::ZERO;
        for (f, face) in scene.faces.iter().enumerate() {
            let own = change_of(f, face);
            let shown = requested(f).map_or(after.resolutions[f], |texels| {
                coarser_texels(after.resolutions[f], texels)
            });
            noise += after.noise_of_face(face, f, shown);
            removed += after.removed_from_face(face, f, shown);
            let light = &after.reflected[first[f]..first[f + 1]];
            let light = resample_face(light, face, after.resolutions[f], own.resolution);
            let area = face.area() / f64::from(texel_count(own.resolution));
            let square = area * own.squares.iter().sum::<DVec3>();
            all += square;
            systematic.push(square - own.noise);
            deviations.push(
                area * own
                    .squares
                    .iter()
                    .map(|square| square * square)
                    .sum::<DVec3>()
                    .map(f64::sqrt),
            );
            lights.push(area * light.iter().map(|b| *b * *b).sum::<DVec3>());
            resolutions.push(own.resolution);
            texel_squares.extend(own.squares.into_iter().map(|square| square.max(DVec3::ZERO)));
        }
        noise += removed.max(DVec3::ZERO);
        let light: DVec3 = lights.iter().sum();
        let share = |c: usize| share_of(all[c], light[c]);
        let worst = (0..3).max_by(|a, b| share(*a).total_cmp(&share(*b))).unwrap_or(0);
        let scale = if light[worst] > 0.0 { 1.0 / light[worst] } else { 0.0 };
        let systematic: Vec<f64> = systematic.iter().map(|own| own[worst]).collect();
        Self {
            total: (systematic.iter().sum::<f64>().max(0.0) * scale).sqrt(),
            noise: (0..3).map(|c| share_of(noise[c], light[c])).fold(0.0, f64::max).sqrt(),
            by_face: systematic.iter().map(|own| own.max(0.0) * scale).collect(),
            channel: worst,
            scale,
            deviations: deviations.iter().map(|own| own[worst] * scale).collect(),
            reflected_squares: lights.iter().map(|own: &DVec3| own[worst]).collect(),
            resolutions,
            texel_squares,
        }
    }

    /// Returns the change with the noise of another `step` of the same light, without requested texels.
    pub fn with_noise_of(self, scene: &Scene, step: &SolveStep) -> Self {
        let first = first_texels(&step.resolutions);
        let (mut noise, mut removed, mut light) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for (f, face) in scene.faces.iter().enumerate() {
            let own = &step.reflected[first[f]..first[f + 1]];
            light += own.iter().map(|b| *b * *b).sum::<DVec3>() * face.area() / own.len() as f64;
            noise += step.noise_of_face(face, f, step.resolutions[f]);
            removed += step.removed_from_face(face, f, step.resolutions[f]);
        }
        noise += removed.max(DVec3::ZERO);
        Self {
            noise: (0..3).map(|c| share_of(noise[c], light[c])).fold(0.0, f64::max).sqrt(),
            ..self
        }
    }

    /// Returns whether the change of face `f` is more than the noise of rays.
    fn is_certain(&self, f: u32) -> bool {
        self.noise == 0.0 || self.by_face[f as usize] > CHANGE_DEVIATIONS * self.deviations[f as usize]
    }

    /// Change of face `f`, relative to the RMS of its own light.
    pub fn relative_change(&self, f: u32) -> f64 {
        let all = self.reflected_squares[f as usize] * self.scale;
        let own = self.by_face[f as usize];
        if all > 0.0 { (own / all).sqrt() } else { 0.0 }
    }
}

fn share_of(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

/// Error from unshot light, relative to the RMS of B − E, if it spread evenly: H = Σ|r|A/ΣA(1 − ρ̄), the
/// ambient term of Cohen et al. 1988. Escaping light makes it less.
pub fn unshot_error(mesh: &Mesh, run: &SolveRun) -> f64 {
    let (mut area, mut unshot, mut grey, mut light, mut square) =
        (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let (own, reflectance) = (f64::from(texel.area), texel.reflectance.as_dvec3());
        let reflected = (run.field.radiosity[k].truncate() - texel.emission).as_dvec3();
        area += own;
        unshot += own * run.field.residual[k].truncate().as_dvec3().abs();
        grey += own * reflectance;
        square += own * reflectance * reflectance;
        light += own * reflected * reflected;
    }
    let even = unshot / (area - grey).max(DVec3::splat(MIN_ABSORBED_SHARE * area.max(f64::MIN_POSITIVE)));
    let off = even * (square / light).map(f64::sqrt);
    // A channel without light has no relative error.
    DVec3::select(light.cmpgt(DVec3::ZERO), off, DVec3::ZERO).max_element()
}

/// Error from the links' closure defect, relative to the light that arrives: what is lost at each bounce would have been
/// absorbed, or have escaped after a reflection.
pub fn closure_error(mesh: &Mesh, run: &SolveRun) -> f64 {
    let energy = EnergyBalance::new(mesh, &run.field, &run.shots);
    let off = certain_closure(&energy, mesh, run).abs();
    let kept = energy.share_of_emitted(energy.absorbed).abs();
    if off > 0.0 { off / kept.min(1.0) } else { 0.0 }
}

/// Returns the links' closure defect over the emitted power, less the noise of the rays that measure the escaped power.
pub fn certain_closure(energy: &EnergyBalance, mesh: &Mesh, run: &SolveRun) -> f64 {
    let closure = energy.share_of_emitted(energy.closure);
    let deviation = escape_deviation(&run.shots) * mesh.area_unit();
    let noise = CLOSURE_DEVIATIONS * energy.share_of_emitted([deviation, 0.0, 0.0]);
    (closure.abs() - noise).max(0.0).copysign(closure)
}

/// Mean number of reflections before light is absorbed: G = ΣAB/ΣAE.
pub fn mean_reflections(mesh: &Mesh, run: &SolveRun) -> f64 {
    let (mut all, mut emitted) = (0.0f64, 0.0f64);
    for (texel, b) in mesh.texels.iter().zip(&run.field.radiosity) {
        all += f64::from(texel.area * b.truncate().abs().element_sum());
        emitted += f64::from(texel.area * texel.emission.element_sum());
    }
    if emitted > 0.0 { all / emitted } else { 0.0 }
}

/// Rounding error accumulated over reflections: links in f32 gain or lose u = 6e−8 at each reflection; the
/// deposit and the sum over the patches as much again.
pub fn rounding_error(mesh: &Mesh, run: &SolveRun) -> f64 {
    2.0 * UNIT_ROUNDOFF * mean_reflections(mesh, run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cpu::hierarchy::solver::TexelSolution;
    use glam::Vec3;

    /// Of two faces of the same large change that with rays is reported which many texels share; without their noise both
    /// are.
    #[test]
    fn noise_of_rays_is_not_reported_as_a_face_of_large_error() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let scene = Scene {
            faces: vec![Face::quad("face", corners, Vec3::ZERO, Vec3::ONE); 2],
            ..Scene::default()
        };
        let texels = [[4, 4], [1, 1]];
        for (noise, reported) in [(0.05, vec![0]), (0.0, vec![0, 1])] {
            let mesh = Mesh::new(&scene, &texels, 1).unwrap();
            let outcome = TexelSolution {
                irradiance: vec![Vec3::ONE; 17],
                noise: vec![Vec3::splat(noise); 17],
                ..TexelSolution::default()
            };
            let step = SolveStep::new(texels.to_vec(), mesh, outcome);
            let changes = [16, 1].map(|count| [vec![DVec3::splat(0.5); count], vec![DVec3::splat(0.5); count]]);
            let history = ErrorHistory {
                last_change: Some(StepChange::from_halves(&scene, &step, (&changes, &texels), &|_| None)),
                ..ErrorHistory::default()
            };
            let worse: Vec<u32> = history.worst_faces(0.01).iter().map(|own| own.face).collect();
            assert_eq!(worse, reported, "{noise}");
        }
    }

    #[test]
    fn interpolation_above_the_request_is_noted() {
        let note = |interpolation: f64| {
            let history = ErrorHistory {
                interpolation,
                ..ErrorHistory::default()
            };
            history.describe_interpolation(0.01)
        };
        assert_eq!(note(0.014), None);
        assert!(note(0.032).unwrap().contains("about 3.2 % off"));
    }

    /// Where the errors of the last two steps are alike the bound is the remaining error, which is under-, else overestimated.
    #[test]
    fn remaining_error_is_told_between_equal_and_independent_errors() {
        for fall in [0.5, 0.7] {
            let told = |changes: Vec<f64>| {
                let history = ErrorHistory {
                    changes,
                    ..ErrorHistory::default()
                };
                (
                    history.changes[1] * history.remaining_share().expected,
                    history.remaining_bound().unwrap(),
                )
            };
            // The error of the last step is 1.
            let before = 1.0 / fall;
            let (alike, bound) = told(vec![before / fall - before, before - 1.0]);
            let (independent, wide) = told(vec![before.hypot(before / fall), before.hypot(1.0)]);
            assert!((bound - 1.0).abs() < 1e-12 && wide > 1.0, "{fall}: {bound}, {wide}");
            assert!(
                alike > 0.7 && alike < 0.9 && independent > 1.4 && independent < 3.0,
                "{fall}: {alike}, {independent}"
            );
        }
    }

    /// A change is relative to the face's own light, noise the mean of its squares times the face's area.
    #[test]
    fn change_and_noise_of_a_face_are_by_its_area_and_light() {
        let quad = |width: f64| {
            let corners = [DVec3::ZERO, width * DVec3::X, width * DVec3::X + DVec3::Y, DVec3::Y];
            Face::quad("face", corners, Vec3::ZERO, Vec3::ONE)
        };
        let scene = Scene {
            faces: vec![quad(6.0), quad(1.0)],
            ..Scene::default()
        };
        let texels = [[2, 2], [1, 1]];
        // Noise of alternating sign is none in the mean of four texels.
        let noise = [0.25, -0.25, -0.25, 0.25, 0.5].map(Vec3::splat);
        let outcome = TexelSolution {
            irradiance: [0.5, 0.5, 0.5, 0.5, 2.0].map(Vec3::splat).to_vec(),
            noise: noise.to_vec(),
            ..TexelSolution::default()
        };
        let step = SolveStep::new(texels.to_vec(), Mesh::new(&scene, &texels, 1).unwrap(), outcome);
        let noise_of = |f: usize, texels| step.noise_of_face(&scene.faces[f], f, texels).x;
        assert_eq!(noise_of(0, [2, 2]), 6.0 * 0.0625);
        assert_eq!(noise_of(0, [1, 1]), 0.0);
        assert_eq!(noise_of(1, [1, 1]), 0.25);
        let changes = [(4, [0.25, 0.0625]), (1, [0.5, 0.5])];
        let changes = changes.map(|(count, halves)| halves.map(|change| vec![DVec3::splat(change); count]));
        let change = StepChange::from_halves(&scene, &step, (&changes, &texels), &|_| None);
        // 0.25 · 0.0625 of 0.5², and 0.5² of 2².
        for (f, expected) in [(0, 0.25), (1, 0.25)] {
            let found = change.relative_change(f);
            assert!((found - expected).abs() < 1e-12, "{f}: {found}");
        }
    }
}
