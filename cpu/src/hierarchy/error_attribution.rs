//! Attributes the remaining error of a solution to its causes: gathers a sample of texels again with one
//! refinement threshold lowered at a time.

use crate::hierarchy::block::{ReceiverBlocks, Spot};
use crate::hierarchy::linear_radiosity::LinearRadiosity;
use crate::hierarchy::linker::{LinkMethod, LinkThresholds, RequestedLight};
use crate::hierarchy::solver::{ErrorBudget, HierarchicalSolver, with_solver};
use crate::rows::receivers::LANE_COUNT;
use common::Result;
use common::mesh::Mesh;
use common::passes::ProgressCallback;
use common::scene::Scene;
use glam::{DVec3, Vec3};

/// Runs of adjacent texels in the sample.
const RUN_COUNT: usize = 32;
/// Factor by which a threshold is lowered: the error that remains is small against the one that vanishes.
const THRESHOLD_FACTOR: f32 = 0.25;
/// Share of all weight that is spread evenly when runs are drawn.
const UNIFORM_SHARE: f64 = 0.1;

/// Squared errors by cause, each an estimate of ∫ (ρΔH)² dA over ∫ (ρH)² dA, by channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorAttribution {
    /// From the variation of radiosity over sources.
    pub sources: DVec3,
    /// From sampled visibility.
    pub visibility: DVec3,
    /// From interpolation between receivers.
    pub receivers: DVec3,
    /// From errors of earlier bounces, which are correlated between texels.
    pub propagation: DVec3,
    /// From the size of texels.
    pub texels: DVec3,
}

/// Attributes the error of `irradiance`, the mean over each texel's area. Texels are drawn with probabilities in
/// proportion to their `weight` (Horvitz & Thompson 1952).
///
/// Errors: those of [`crate::hierarchy::solver::solve_scene`].
pub fn attribute_error(
    scene: &Scene,
    mesh: &Mesh,
    irradiance: &[Vec3],
    weight: &[f32],
    budget: ErrorBudget,
    watch: ProgressCallback,
) -> Result<ErrorAttribution> {
    with_solver(scene, mesh, &[], LinkMethod::Shafts, |solver| {
        lower_thresholds(solver, irradiance, weight, budget.fine, watch)
    })
}

/// Adjacent texels of a face in the sample.
struct TexelRun {
    /// Leaves of the tree.
    leaves: Vec<u32>,
    /// Number of runs that this one represents.
    stands_for: f64,
}

fn lower_thresholds(
    mut solver: HierarchicalSolver,
    irradiance: &[Vec3],
    weight: &[f32],
    fine: LinkThresholds,
    watch: ProgressCallback,
) -> Result<ErrorAttribution> {
    let texels = &solver.scene.mesh.texels;
    let received = solver.open_part_mean(irradiance);
    let reflected = solver.reflected_radiosity(&received);
    let radiosity: Vec<Vec3> = (reflected.iter().zip(texels)).map(|(r, t)| *r + t.emission).collect();
    let sources = solver.fit_sources(&radiosity);
    solver.scale = solver.inverse_rms(&received);
    let runs = draw_runs(&solver, weight);
    let receivers = run_spots(&solver, &runs);
    let mut gather = |thresholds| gather_sample(&solver, &sources, thresholds, &receivers, watch);
    let same = gather(fine)?;
    let finer_sources = gather(LinkThresholds {
        source: THRESHOLD_FACTOR * fine.source,
        ..fine
    })?;
    let finer_visibility = gather(LinkThresholds {
        visibility: THRESHOLD_FACTOR * fine.visibility,
        ..fine
    })?;
    let finer_texels = gather(LinkThresholds {
        near: THRESHOLD_FACTOR * fine.near,
        ..fine
    })?;
    let reflected = |k: usize| (texels[k].reflectance * irradiance[k]).as_dvec3();
    let light = |k: usize| reflected(k).powf(2.0) * f64::from(texels[k].area);
    let light: DVec3 = (0..texels.len()).map(light).sum();
    let share = light.map(|light| if light > 0.0 { 1.0 / light } else { 0.0 });
    let mut attribution = ErrorAttribution::default();
    for run in &runs {
        let texel = |leaf: &u32| solver.scene.tree.leaves[*leaf as usize].texel as usize;
        let all: Vec<usize> = run.leaves.iter().map(texel).collect();
        let reflectance = |k: usize| texels[k].reflectance.as_dvec3();
        let square = |off: &dyn Fn(usize) -> DVec3| -> DVec3 {
            let of_texel = |k: &usize| (reflectance(*k) * off(*k)).powf(2.0) * f64::from(texels[*k].area);
            share * run.stands_for * all.iter().map(of_texel).sum::<DVec3>()
        };
        let off = |k: usize| (irradiance[k] - same[k]).as_dvec3();
        let mean: DVec3 = all.iter().map(|k| off(*k)).sum::<DVec3>() / all.len() as f64;
        attribution.sources += square(&|k| (finer_sources[k] - same[k]).as_dvec3());
        attribution.visibility += square(&|k| (finer_visibility[k] - same[k]).as_dvec3());
        attribution.texels += square(&|k| (finer_texels[k] - same[k]).as_dvec3());
        attribution.propagation += square(&|_| mean);
        attribution.receivers += square(&|k| off(k) - mean);
    }
    Ok(attribution)
}

/// Draws runs of at most sixteen adjacent texels by systematic sampling: at even steps of the sum of weights.
fn draw_runs(solver: &HierarchicalSolver, weight: &[f32]) -> Vec<TexelRun> {
    let tree = solver.scene.tree;
    let of_face = |root: &u32| tree.nodes[*root as usize].leaves.clone();
    let runs: Vec<Vec<u32>> = tree
        .roots
        .iter()
        .flat_map(|root| {
            let leaves: Vec<u32> = of_face(root).collect();
            leaves.chunks(LANE_COUNT).map(<[u32]>::to_vec).collect::<Vec<_>>()
        })
        .collect();
    let weight_of_run = |run: &Vec<u32>| -> f64 {
        let texels = run.iter().map(|leaf| tree.leaves[*leaf as usize].texel);
        texels.map(|k| f64::from(weight[k as usize])).sum()
    };
    let weights: Vec<f64> = runs.iter().map(weight_of_run).collect();
    let all: f64 = weights.iter().sum();
    let even = UNIFORM_SHARE * all / runs.len() as f64;
    let step = (1.0 + UNIFORM_SHARE) * all / RUN_COUNT as f64;
    let (mut sum, mut next) = (0.0, 0.5 * step);
    let mut drawn = Vec::new();
    for (leaves, weight) in runs.into_iter().zip(weights) {
        let weight = weight + even;
        sum += weight;
        let mut times = 0;
        while step > 0.0 && next < sum {
            next += step;
            times += 1;
        }
        if times > 0 {
            drawn.push(TexelRun {
                leaves,
                stands_for: f64::from(times) * step / weight,
            });
        }
    }
    drawn
}

fn run_spots(solver: &HierarchicalSolver, runs: &[TexelRun]) -> ReceiverBlocks {
    let scene = &solver.scene;
    let mut by_face: Vec<Vec<Spot>> = vec![Vec::new(); scene.mesh.faces.len()];
    for leaf in runs.iter().flat_map(|run| &run.leaves) {
        let node = scene.tree.leaves[*leaf as usize].node;
        let face = scene.tree.nodes[node as usize].face;
        by_face[face as usize].extend(solver.covered.spots_of_node(scene.tree, node));
    }
    ReceiverBlocks::new(scene.mesh, &scene.clusters.order, |f| by_face[f].clone())
}

/// Gathers H of the sampled texels, the mean over each one's area; 0 at the others.
fn gather_sample(
    solver: &HierarchicalSolver,
    sources: &[LinearRadiosity],
    thresholds: LinkThresholds,
    receivers: &ReceiverBlocks,
    watch: ProgressCallback,
) -> Result<Vec<Vec3>> {
    let light = RequestedLight::Arriving;
    let lit = solver.gather_at_blocks(light, sources, thresholds, receivers, 0.0..1.0, watch)?;
    let mut gathered = vec![Vec3::ZERO; solver.area.len()];
    for (block, lit) in receivers.blocks.iter().zip(&lit) {
        for l in 0..block.count {
            let texel = solver.scene.tree.leaves_of(block.target[l])[0].texel as usize;
            let [r, g, b] = lit.sums;
            gathered[texel] += Vec3::new(r[l], g[l], b[l]) * block.share[l];
        }
    }
    Ok(gathered)
}
