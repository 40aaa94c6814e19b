//! The last steps of a solve by links whose texels follow from the light: between them light is interpolated to the requested
//! error.
//!
//! Nothing is solved anew: light is gathered once from the solution that is known. Light that surfaces reflect is smooth, and
//! edges are those of the lamps' shadows. So texels are halved where their light errs most, and as soon as reflected light is
//! smooth enough, only the lamps' light is gathered; reflected light is interpolated with the slopes of the step before.

use super::error_estimate::StepChange;
use super::interpolation_error::{
    REFLECTED_SHARE, ReceivedLight, interpolation_errors, reduce_interpolation_error, sum_errors,
};
use super::progress::{ProgressMonitor, step_progress};
use super::resolution::TexelError;
use super::step::{SolveStep, narrow_to_f32, resample_step};
use common::mesh::Mesh;
use common::scene::Scene;
use common::{Error, Result};
use cpu::hierarchy::linear_radiosity::pull_radiosity;
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::sky::receive_sky;
use cpu::hierarchy::solver::{ErrorBudget, LightParts, TexelSolution, gather_known_light};
use cpu::hierarchy::tree::TexelTree;
use glam::{DVec3, Vec3};

/// A solve whose last steps are to be made.
pub(super) struct ShadowSteps<'a> {
    pub scene: &'a Scene,
    /// Requested error.
    pub error: f64,
    /// Method that finds links.
    pub method: LinkMethod<'a>,
    /// Error to which light is gathered.
    pub goal: f64,
    /// Largest number of steps.
    pub most: u32,
    pub progress: &'a ProgressMonitor<'a>,
}

impl ShadowSteps<'_> {
    /// Makes the steps that follow `last`, which changed the light by `change`.
    ///
    /// Errors: those of a step; after [`Error::Interrupted`] the last complete step is returned.
    pub fn resolve_light(&self, mut last: SolveStep, change: &StepChange) -> Result<SolveStep> {
        let errors_of = |step: &SolveStep, light: Vec<Vec3>| {
            let light = ReceivedLight::without_noise(light);
            interpolation_errors(self.scene, step, &light, (change.channel, change.scale))
        };
        let mut reflected = errors_of(&last, reflected_light(&last));
        for _ in 0..self.most {
            let direct = errors_of(&last, last.outcome.direct.clone());
            let of_reflected = sum_errors(&reflected);
            let (light, errors, error) = match of_reflected <= (REFLECTED_SHARE * self.error).powi(2) {
                true => (LightParts::Direct, direct, (self.error.powi(2) - of_reflected).sqrt()),
                false => (LightParts::All, add_errors(&direct, &reflected), self.error),
            };
            let finer = reduce_interpolation_error(&self.scene.faces, &last.resolutions, &errors, error);
            if finer == last.resolutions {
                break;
            }
            last = match self.gather_light(light, finer, &last) {
                Err(Error::Interrupted) => return Ok(last),
                step => step?,
            };
            if light == LightParts::All {
                reflected = errors_of(&last, reflected_light(&last));
            }
        }
        Ok(last)
    }

    /// Gathers `light` on `texels` of each face; other light is interpolated from the `last` step.
    fn gather_light(&self, light: LightParts, texels: Vec<[u32; 2]>, last: &SolveStep) -> Result<SolveStep> {
        let (scene, progress) = (self.scene, self.progress);
        let mut mesh = progress.time_phase("prepare", || Mesh::new(scene, &texels, 1))?;
        let phase = format!("gathering at {} texels", mesh.texels.len());
        let mut callback = step_progress(progress, &phase);
        let outcome = progress.time_phase("solve", || {
            receive_sky(scene, &mut mesh, self.goal as f32, &mut callback)?;
            let known = (light, &*interpolate_reflected(scene, last, &mesh, &texels));
            let budget = ErrorBudget::for_error(self.goal as f32);
            gather_known_light(scene, &mesh, known, budget, self.method, &mut callback)
        })?;
        let residual = resample_step(&scene.faces, last, &texels, &|k| last.outcome.residual[k].as_dvec3());
        let outcome = TexelSolution {
            noise: vec![Vec3::ZERO; mesh.texels.len()],
            residual: narrow_to_f32(residual),
            links: last.outcome.links,
            passes: last.outcome.passes,
            converged: last.outcome.converged,
            ..outcome
        };
        Ok(SolveStep::new(texels, mesh, outcome))
    }
}

/// Returns the errors of the sum of two lights.
fn add_errors(a: &[TexelError], b: &[TexelError]) -> Vec<TexelError> {
    let add = |(a, b): (&TexelError, &TexelError)| {
        let squares = [a, b].map(|own| own.square.max(0.0));
        let square = squares[0] + squares[1];
        TexelError {
            square,
            ratio: (squares[0] * a.ratio + squares[1] * b.ratio) / square.max(f64::MIN_POSITIVE),
        }
    };
    a.iter().zip(b).map(add).collect()
}

/// Returns the irradiance of each texel that surfaces cause, the mean over its area.
fn reflected_light(step: &SolveStep) -> Vec<Vec3> {
    let outcome = &step.outcome;
    let texels = outcome.irradiance.iter().zip(&outcome.direct);
    texels.map(|(all, direct)| *all - *direct).collect()
}

/// Returns the irradiance that surfaces cause on the open part of each texel of `mesh`, which has these `texels` on each face:
/// that of the texel around it in the `last` step, sloped.
fn interpolate_reflected(scene: &Scene, last: &SolveStep, mesh: &Mesh, texels: &[[u32; 2]]) -> Vec<Vec3> {
    let open = &last.outcome.open;
    let on_open = |(light, open): (Vec3, &f32)| if *open > 0.0 { light / *open } else { Vec3::ZERO };
    let light: Vec<Vec3> = reflected_light(last).into_iter().zip(open).map(on_open).collect();
    let areas: Vec<f32> = last.mesh.texels.iter().zip(open).map(|(t, o)| t.area * o).collect();
    let coarse = TexelTree::new(scene, &last.mesh);
    let fits = pull_radiosity(&coarse, &areas, &light);
    // Of each texel: its light at the origin of the face's frame, and its change along both axes.
    let mut planes = vec![[DVec3::ZERO; 3]; light.len()];
    for leaf in &coarse.leaves {
        let (fit, place) = (
            &fits[leaf.node as usize],
            coarse.nodes[leaf.node as usize].face_position,
        );
        let slope = fit.slope.map(|slope| slope.as_dvec3());
        let at_origin = fit.mean.as_dvec3() - slope[0] * f64::from(place.x) - slope[1] * f64::from(place.y);
        planes[leaf.texel as usize] = [at_origin, slope[0], slope[1]];
    }
    // A mesh has its texels in face order because each face is one patch.
    let [origin, along_x, along_y] = [0, 1, 2].map(|n| resample_step(&scene.faces, last, texels, &|k| planes[k][n]));
    let fine = TexelTree::new(scene, mesh);
    let mut found = vec![Vec3::ZERO; mesh.texels.len()];
    for leaf in &fine.leaves {
        let (k, place) = (
            leaf.texel as usize,
            fine.nodes[leaf.node as usize].face_position.as_dvec2(),
        );
        let value = origin[k] + along_x[k] * place.x + along_y[k] * place.y;
        found[k] = value.as_vec3().max(Vec3::ZERO);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{add_errors, interpolate_reflected};
    use crate::solve::resolution::TexelError;
    use crate::solve::step::SolveStep;
    use common::mesh::{Mesh, Texel};
    use common::scene::{Face, Scene};
    use cpu::hierarchy::solver::TexelSolution;
    use glam::{DVec3, Vec3};

    /// Returns light that is linear over the plane z = 0.
    fn linear_light(place: Vec3) -> Vec3 {
        Vec3::new(
            3.0 + place.x,
            2.0 - 0.5 * place.y,
            1.0 + 0.25 * place.x + 0.125 * place.y,
        )
    }

    /// On a quad and on a triangle light that is linear stays so on smaller texels, at open parts of any share; the direct part
    /// is left out.
    #[test]
    fn linear_light_is_interpolated_exactly() {
        let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let quad = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        let triangle = [corner(1.2, 0.0), corner(2.0, 0.1), corner(1.3, 0.9), corner(1.3, 0.9)];
        let faces = [quad, triangle].map(|corners| Face::quad("face", corners, Vec3::ZERO, Vec3::ONE));
        let scene = Scene {
            faces: faces.to_vec(),
            ..Scene::default()
        };
        let mesh = Mesh::new(&scene, &[[4; 2]; 2], 1).expect("a mesh");
        let light = |texel: &Texel| linear_light(texel.position);
        let open: Vec<f32> = (0..mesh.texels.len()).map(|k| [1.0, 0.25][k % 2]).collect();
        let direct = vec![Vec3::splat(5.0); mesh.texels.len()];
        let reflected = mesh.texels.iter().zip(&open).map(|(texel, open)| light(texel) * *open);
        let outcome = TexelSolution {
            irradiance: reflected.map(|h| h + Vec3::splat(5.0)).collect(),
            direct,
            noise: vec![Vec3::ZERO; open.len()],
            open,
            ..TexelSolution::default()
        };
        let step = SolveStep::new(vec![[4; 2]; 2], mesh, outcome);
        let finer = vec![[16, 8], [8, 8]];
        let mesh = Mesh::new(&scene, &finer, 1).expect("a mesh");
        let found = interpolate_reflected(&scene, &step, &mesh, &finer);
        assert_eq!(found.len(), 16 * 8 + 8 * 8);
        for (texel, found) in mesh.texels.iter().zip(&found) {
            // Of f32, at values below 10.
            assert!(
                (*found - light(texel)).abs().max_element() < 1e-4,
                "{found} at {}",
                texel.position
            );
        }
    }

    #[test]
    fn errors_of_two_lights_add() {
        let error = |square: f64, ratio: f64| TexelError { square, ratio };
        let sum = add_errors(
            &[error(3.0, 0.5), error(-1.0, 0.5)],
            &[error(1.0, 0.25), error(0.0, 0.5)],
        );
        assert_eq!([sum[0].square, sum[0].ratio], [4.0, 0.4375]);
        assert_eq!([sum[1].square, sum[1].ratio], [0.0, 0.0]);
    }
}
