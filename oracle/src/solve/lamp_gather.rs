//! The last step of a solve by rays whose texels follow from the light: between them light is interpolated to the requested
//! error.
//!
//! Edges of light are those of the lamps' shadows, and light that surfaces reflect is smooth. So only the lamps' light is
//! gathered on smaller texels, first by few rays, which show whether the texels suffice. Reflected light is that of the solve,
//! with slopes.

use super::adaptive::AdaptiveSolve;
use super::error_estimate::StepChange;
use super::interpolation_error::{
    MAX_TEXELS_BY_LIGHT, REFLECTED_SHARE, ReceivedLight, interpolation_errors, reduce_interpolation_error, sum_errors,
};
use super::progress::step_progress;
use super::refinement::AdaptiveProblem;
use super::step::{SolveStep, narrow_to_f32, open_areas, resample_step};
use common::Result;
use common::mesh::{Mesh, Texel};
use common::rays::Rays;
use cpu::dense::open_points::OpenParts;
use cpu::hierarchy::solver::TexelSolution;
use cpu::ray_cast::{DividedLight, Halves, RaySolve, fit_slopes};
use glam::{DVec3, Vec3, Vec3A};

/// Largest number of gathers by few rays.
const MAX_ROUGH_GATHERS: u32 = 4;
/// Least noise of the lamps' light that is aimed at, as a share of the requested error.
const MIN_DIRECT_NOISE_SHARE: f64 = 0.25;
/// Least growth that their largest number has to allow for texels to be replaced.
const MIN_TEXEL_GROWTH: f64 = 1.1;
/// Share of a gather's progress in which few rays are traced.
const ROUGH_PROGRESS: f64 = 0.3;

/// A solve whose lamps' light is to be gathered on smaller texels.
pub(super) struct LampGather<'a> {
    pub problem: &'a AdaptiveSolve<'a>,
    /// The last step of the solve.
    pub solved: &'a SolveStep,
    /// Its light.
    pub light: &'a DividedLight,
    /// Its change of the light.
    pub change: &'a StepChange,
    /// Requested error.
    pub error: f64,
}

/// Light that was gathered.
pub(super) struct GatheredStep {
    pub step: SolveStep,
    /// Light from outside at each texel.
    pub outside: Vec<Vec3>,
}

/// Light that is not gathered, on the texels of a gather: that which the solve reflects, and all light on faces whose texels
/// are those of the solve.
struct KnownLight {
    /// Whether each texel is one of the solve.
    is_solved: Vec<bool>,
    /// H of each texel, the mean over its area.
    irradiance: Vec<Vec3A>,
    /// Its noise.
    noise: Vec<Vec3A>,
    /// What smoothing removed from either half of it.
    removed: Vec<Halves>,
    /// The part of either half of H that lamps and the surroundings cause.
    direct: Vec<Halves>,
}

impl LampGather<'_> {
    /// Returns whether the lamps' light is interpolated with more than the requested error between the texels of the solve.
    pub fn finds_error(&self) -> bool {
        self.resolve_texels(self.solved, &self.light.direct) != self.solved.resolutions
    }

    /// Gathers the lamps' light on texels between which it is interpolated to the requested error, to a `noise` of all light;
    /// none if the texels of the solve suffice. The noise by which texels are chosen is a function of their number. `outside`
    /// is the light from outside at the texels of the solve.
    ///
    /// Errors: [`common::Error::Interrupted`]; those of the sky.
    pub fn gather_light(
        &self,
        rough_noise: &dyn Fn(u64) -> f64,
        noise: f64,
        outside: &[Vec3],
    ) -> Result<Option<GatheredStep>> {
        let mut texels = self.resolve_texels(self.solved, &self.light.direct);
        if texels == self.solved.resolutions {
            return Ok(None);
        }
        let (scene, progress) = (self.problem.scene(), self.problem.progress);
        let mut rough_gathers = 0;
        loop {
            let mesh = progress.time_phase("prepare", || Mesh::new(scene, &texels, 1))?;
            let name = format!("gathering at {} texels", mesh.texels.len());
            let mut watch = step_progress(progress, &name);
            let found = progress.time_phase("solve", || {
                let rays = Rays::new(&mesh);
                let open = OpenParts::new(scene, &mesh, &rays);
                let known = self.resample_known_light(&mesh, &texels, &open.shares);
                let gathered = open.keep_texels(|k| !known.is_solved[k]);
                let solve = RaySolve::new(scene, &mesh, &rays, &gathered)?;
                let mut solve = solve.beside_light(known.irradiance.clone());
                let rough = rough_noise(mesh.texels.len() as u64) as f32;
                let mut begin = |done| watch(ROUGH_PROGRESS * done);
                solve.solve_to_noise(rough, &mut begin)?;
                solve.smooth_light();
                let outcome = solve.solve_to_noise(f32::INFINITY, &mut begin)?;
                rough_gathers += 1;
                let complete = |outcome| self.complete_outcome(&texels, outcome, &known, &open.shares);
                let step = SolveStep::new(texels.clone(), mesh.clone(), complete(outcome));
                let finer = self.resolve_texels(&step, &known.add_direct(&solve.divided_light().direct));
                let may_grow = MIN_TEXEL_GROWTH * mesh.texels.len() as f64 <= MAX_TEXELS_BY_LIGHT as f64;
                if finer != texels && may_grow && rough_gathers < MAX_ROUGH_GATHERS {
                    texels = finer;
                    return Ok(None);
                }
                let mut go_on = |done| watch(ROUGH_PROGRESS + (1.0 - ROUGH_PROGRESS) * done);
                let of_known = f64::from(solve.relate_noise(&known.noise, &known.removed));
                let rest = (noise.powi(2) - of_known.powi(2)).max(0.0).sqrt();
                let aimed = rest.max(MIN_DIRECT_NOISE_SHARE * self.error) as f32;
                let outcome = solve.solve_to_noise(aimed, &mut go_on)?;
                let solved = self.resample_values(&texels, &|k| outside[k]);
                let sum = |((own, solved), known): ((Vec3, Vec3), &bool)| if *known { solved } else { own };
                let all = solve.outside_light().into_iter().zip(solved).zip(&known.is_solved);
                Ok(Some(GatheredStep {
                    outside: all.map(sum).collect(),
                    step: SolveStep::new(texels.clone(), mesh.clone(), complete(outcome)),
                }))
            })?;
            if found.is_some() {
                return Ok(found);
            }
        }
    }

    /// Returns texels between which the `direct` light of `step` is interpolated to what that of reflected light leaves of the
    /// requested error.
    fn resolve_texels(&self, step: &SolveStep, direct: &[Halves]) -> Vec<[u32; 2]> {
        let scene = self.problem.scene();
        let errors_of = |step: &SolveStep, light: &[Halves]| {
            let scale = (self.change.channel, self.change.scale);
            interpolation_errors(scene, step, &ReceivedLight::from_halves(light), scale)
        };
        let of_reflected = sum_errors(&errors_of(self.solved, &self.light.reflected));
        let most = (REFLECTED_SHARE * self.error).powi(2);
        let left = self.error.powi(2) - of_reflected.clamp(0.0, most);
        let errors = errors_of(step, direct);
        reduce_interpolation_error(&scene.faces, &step.resolutions, &errors, left.sqrt())
    }

    /// Returns a value of each texel of the solve on these `texels` of each face.
    fn resample_values(&self, texels: &[[u32; 2]], value: &dyn Fn(usize) -> Vec3) -> Vec<Vec3> {
        let faces = &self.problem.scene().faces;
        narrow_to_f32(resample_step(faces, self.solved, texels, &|k| value(k).as_dvec3()))
    }

    /// Does so with both halves of a light.
    fn resample_halves(&self, texels: &[[u32; 2]], light: &[Halves]) -> Vec<Halves> {
        let [a, b] = [0, 1].map(|half| self.resample_values(texels, &|k| Vec3::from(light[k][half])));
        a.into_iter().zip(b).map(|(a, b)| [a, b].map(Vec3A::from)).collect()
    }

    /// Returns the known light on the texels of `mesh`, with these `texels` on each face and `open` shares.
    fn resample_known_light(&self, mesh: &Mesh, texels: &[[u32; 2]], open: &[f32]) -> KnownLight {
        let light = self.light;
        let is_solved = |texel: &Texel| texels[texel.face as usize] == self.solved.resolutions[texel.face as usize];
        let mut known = KnownLight {
            is_solved: mesh.texels.iter().map(is_solved).collect(),
            irradiance: self.interpolate_reflected(mesh, texels, open),
            noise: Vec::new(),
            removed: self.resample_halves(texels, &light.removed_reflected),
            direct: self.resample_halves(texels, &light.direct),
        };
        let reflected = self.resample_halves(texels, &light.reflected);
        let removed_direct = self.resample_halves(texels, &light.removed_direct);
        let mut noise: Vec<Vec3A> = reflected.iter().map(|[a, b]| 0.5 * (*a - *b)).collect();
        for k in (0..noise.len()).filter(|k| known.is_solved[*k]) {
            let ([a, b], [c, d]) = (known.direct[k], reflected[k]);
            known.irradiance[k] = 0.5 * (a + b + c + d);
            noise[k] += 0.5 * (a - b);
            known.removed[k] = [0, 1].map(|half| known.removed[k][half] + removed_direct[k][half]);
        }
        KnownLight { noise, ..known }
    }

    /// Returns the reflected light that each texel of `mesh` receives, with these `texels` on each face and `open` shares: on
    /// its open part that of the texel around it in the solve, sloped.
    fn interpolate_reflected(&self, mesh: &Mesh, texels: &[[u32; 2]], open: &[f32]) -> Vec<Vec3A> {
        let solved = self.solved;
        let on_open = |(light, open): (&Halves, &f32)| match *open > 0.0 {
            true => light.map(|half| half / *open),
            false => [Vec3A::ZERO; 2],
        };
        let light = self.light.reflected.iter().zip(&solved.outcome.open).map(on_open);
        let light: Vec<Halves> = light.collect();
        let means: Vec<DVec3> = light.iter().map(|[a, b]| (0.5 * (*a + *b)).as_dvec3()).collect();
        let slopes = fit_slopes(&solved.mesh, &open_areas(solved), light);
        let at_origin = |k: usize| means[k] - slopes[k] * solved.mesh.texels[k].position.as_dvec3();
        let resample =
            |values: &dyn Fn(usize) -> DVec3| resample_step(&self.problem.scene().faces, solved, texels, values);
        let origin = resample(&at_origin);
        let [x, y, z] = [0, 1, 2].map(|axis| resample(&|k| slopes[k].col(axis)));
        let at_texel = |k: usize| {
            let place = mesh.texels[k].position.as_dvec3();
            let value = origin[k] + x[k] * place.x + y[k] * place.y + z[k] * place.z;
            Vec3A::from(value.max(DVec3::ZERO).as_vec3()) * open[k]
        };
        (0..mesh.texels.len()).map(at_texel).collect()
    }

    /// Returns the `outcome` of a gather on `texels` of each face, of these `open` shares, with the noise of `known` light, and
    /// what the solve shows of its bounces.
    fn complete_outcome(
        &self,
        texels: &[[u32; 2]],
        outcome: TexelSolution,
        known: &KnownLight,
        open: &[f32],
    ) -> TexelSolution {
        let solved = &self.solved.outcome;
        let add_removed = |(k, known): (usize, &Halves)| {
            let own = outcome.removed.get(k).copied().unwrap_or_default();
            [0, 1].map(|half| own[half] + Vec3::from(known[half]))
        };
        let noise = outcome.noise.iter().zip(&known.noise);
        TexelSolution {
            removed: known.removed.iter().enumerate().map(add_removed).collect(),
            noise: noise.map(|(own, known)| *own + Vec3::from(*known)).collect(),
            residual: self.resample_values(texels, &|k| solved.residual[k]),
            open: open.to_vec(),
            links: solved.links + outcome.links,
            passes: solved.passes,
            converged: solved.converged,
            ..outcome
        }
    }
}

impl KnownLight {
    /// Returns either half of the lamps' light, where it is `gathered` and where it is known.
    fn add_direct(&self, gathered: &[Halves]) -> Vec<Halves> {
        let known = self.is_solved.iter().zip(&self.direct);
        let choose = |(own, (is_solved, known)): (&Halves, (&bool, &Halves))| if *is_solved { *known } else { *own };
        gathered.iter().zip(known).map(choose).collect()
    }
}
