//! The residual of a given solution: gathers its radiosity at every texel and adds the further bounces of the
//! difference.

use crate::hierarchy::coarse::add_fields;
use crate::hierarchy::linker::LinkMethod;
use crate::hierarchy::solver::{CORRECTION_TOLERANCE, ErrorBudget, FINE_PROGRESS, HierarchicalSolver, with_solver};
use common::Result;
use common::mesh::Mesh;
use common::passes::ProgressCallback;
use common::scene::Scene;
use glam::Vec3;

/// Irradiance that follows from a given radiosity.
pub struct GatheredResidual {
    /// H of each texel from the given radiosity, the mean over its area, W/m².
    pub irradiance: Vec<Vec3>,
    /// H from all further bounces of the difference from the given H.
    pub later: Vec<Vec3>,
    /// Variances of `irradiance`, and of its sum with `later`, of rays.
    pub variance: [Vec<Vec3>; 2],
    /// Open share of each texel's area.
    pub open: Vec<f32>,
}

/// Gathers the radiosity E + `reflected` at each texel of `mesh`; `reflected` is ρH.
///
/// Errors: those of [`crate::hierarchy::solver::solve_scene`].
pub fn gather_residual(
    scene: &Scene,
    mesh: &Mesh,
    reflected: &[Vec3],
    budget: ErrorBudget,
    watch: ProgressCallback,
) -> Result<GatheredResidual> {
    with_solver(scene, mesh, &[], LinkMethod::Shafts, |solver| {
        solve_residual(solver, reflected, budget, watch)
    })
}

fn solve_residual(
    mut solver: HierarchicalSolver,
    reflected: &[Vec3],
    budget: ErrorBudget,
    watch: ProgressCallback,
) -> Result<GatheredResidual> {
    let texels = &solver.scene.mesh.texels;
    let share = |a: Vec3, b: Vec3| Vec3::select(b.cmpgt(Vec3::ZERO), a / b, Vec3::ZERO);
    let received: Vec<Vec3> = reflected
        .iter()
        .zip(texels)
        .map(|(r, t)| share(*r, t.reflectance))
        .collect();
    let received = solver.open_part_mean(&received);
    let reflected = solver.reflected_radiosity(&received);
    let emission: Vec<Vec3> = texels.iter().map(|t| t.emission).collect();
    let radiosity = add_fields(&reflected, &emission);
    let sources = solver.fit_sources(&radiosity);
    solver.estimate_direct(&radiosity, &sources, watch)?;
    let gathered = solver.gather_arriving(&sources, budget.fine, FINE_PROGRESS, watch)?;
    let outside: Vec<Vec3> = texels.iter().map(|t| t.sky).collect();
    let gathered = add_fields(&gathered, &outside);
    let new = solver.open_part_mean(&gathered);
    let delta: Vec<Vec3> = new.iter().zip(&received).map(|(n, h)| *n - *h).collect();
    // The links are those of the final light: a given solution may be dark where it should not.
    let ambient = solver
        .ambient_irradiance(&solver.reflected_radiosity(&delta))
        .max(Vec3::ZERO);
    let light: Vec<Vec3> = new.iter().map(|h| *h + ambient).collect();
    solver.scale = solver.inverse_rms(&light);
    let sources = solver.fit_sources(&add_fields(&emission, &solver.reflected_radiosity(&light)));
    let links = solver.link_coarse_nodes(&sources, budget.coarse, watch)?;
    let source = solver.reflected_radiosity(&delta);
    let later = solver.iterate_coarse(&links, &source, CORRECTION_TOLERANCE, watch)?;
    let open = later.received.iter().zip(&solver.open);
    Ok(GatheredResidual {
        variance: [0, 1].map(|_| vec![Vec3::ZERO; gathered.len()]),
        irradiance: gathered,
        later: open.map(|(h, open)| *h * *open).collect(),
        open: solver.open,
    })
}
