//! The hierarchical solver, in four steps:
//!
//! ```text
//! direct    H_d = K E + H_sky          each lamp, at every texel; light from outside
//! coarse    x = K_c ρ(H_d + x)         over stored links between coarse nodes, iterated to convergence
//! fine      H_f = K ρ(H_d + x)         final gather at every texel
//! correct   δ = H_f − x;  y = K_c ρ(δ + y);  H = H_d + H_f + y, and again K ρ(δ + y) until y is small
//! ```

use crate::dense::open_area::{Element, covered_elements};
use crate::hierarchy::block::ReceiverBlocks;
use crate::hierarchy::coarse::{CoarseNodes, StoredLink, add_fields, gather_over_links, source_area};
use crate::hierarchy::cpu_linker::CpuLinker;
use crate::hierarchy::final_gather::{CoveredTexels, FinalGather, ReceiverSelection};
use crate::hierarchy::iterate::BounceIteration;
use crate::hierarchy::linear_radiosity::{LinearRadiosity, pull_radiosity};
use crate::hierarchy::linker::{
    BlockIrradiance, LinkMethod, LinkRequest, LinkThresholds, Linker, LinkerScene, RequestedLight,
};
use crate::hierarchy::tree::{TexelTree, TreeLeaf};
use crate::occlusion::occluders::Occluders;
use crate::rows::lane_points::LaneValues;
use common::mesh::{Mesh, Texel};
use common::passes::ProgressCallback;
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use glam::{DVec3, Vec3};
use pulp::Arch;
use std::ops::{ControlFlow, Range};

/// The coarse iteration ends when this share of the first reflected power is unshot.
const COARSE_TOLERANCE: f64 = 1e-4;
/// The same of the correction, whose power is about a hundredth.
pub(super) const CORRECTION_TOLERANCE: f64 = 1e-2;
/// Share of the source threshold that is allowed for a spot's size: at the nodes of an adjacent face this error
/// has one sign and accumulates.
const NEAR_ERROR_SHARE: f32 = 0.1;

/// Largest radius of a coarse node (the mesh is two units wide at most).
const MAX_COARSE_RADIUS: f32 = 0.09;
/// Coarse nodes are smaller where their earlier error exceeds this share of the requested error.
const MAX_COARSE_ERROR: f32 = 0.5;
/// Smallest radius to which that applies: the final gather corrects the rest.
const MIN_COARSE_RADIUS: f32 = MAX_COARSE_RADIUS / 8.0;
/// Least reflectance in error estimates: the irradiance of darker faces counts as well.
pub(super) const MIN_REFLECTANCE: f32 = 0.1;

/// Approximate progress of each step.
const ESTIMATE_PROGRESS: Range<f64> = 0.0..0.05;
/// See [`ESTIMATE_PROGRESS`].
const DIRECT_PROGRESS: Range<f64> = 0.05..0.2;
/// See [`ESTIMATE_PROGRESS`].
const LINK_PROGRESS: Range<f64> = 0.2..0.45;
/// See [`ESTIMATE_PROGRESS`].
const ITERATE_PROGRESS: f64 = 0.5;
/// See [`ESTIMATE_PROGRESS`].
pub(super) const FINE_PROGRESS: Range<f64> = 0.55..1.0;

/// Thresholds of the first estimate.
const ESTIMATE_THRESHOLDS: LinkThresholds = LinkThresholds {
    source: 2e-2,
    visibility: 2e-2,
    near: 2e-2,
    edge: 2e-2,
};

/// The thresholds of each step, for an error relative to the RMS of the reflected light.
#[derive(Clone, Copy, Debug)]
pub struct ErrorBudget {
    pub(super) direct: LinkThresholds,
    pub(super) coarse: LinkThresholds,
    pub(super) fine: LinkThresholds,
    pub(super) error: f32,
}

impl ErrorBudget {
    /// Divides a relative error among the steps.
    pub fn for_error(error: f32) -> Self {
        let at = |source: f32, visibility: f32| LinkThresholds {
            source: source * error,
            visibility: visibility * error,
            near: NEAR_ERROR_SHARE * source * error,
            edge: source * error,
        };
        Self {
            direct: at(0.3, 0.1),
            coarse: at(0.5, 0.5),
            // Of surfaces: light from all sides.
            fine: at(0.25, 0.1).with_soft_edges(),
            error,
        }
    }
}

/// The solution on the texels of a mesh.
#[derive(Default)]
pub struct TexelSolution {
    /// H of each texel, the mean over its area, W/m².
    pub irradiance: Vec<Vec3>,
    /// Unshot radiosity of each texel's open part.
    pub residual: Vec<Vec3>,
    /// Open share of each texel's area.
    pub open: Vec<f32>,
    /// Part of each texel's H that lamps and the surroundings cause; empty where it is not kept.
    pub direct: Vec<Vec3>,
    /// Half of the difference between each texel's H of either half of its rays; its square is the variance of H.
    pub noise: Vec<Vec3>,
    /// What smoothing removed from each texel's H of either half: the product is the squared error of that in the mean. Empty
    /// without smoothing.
    pub removed: Vec<[Vec3; 2]>,
    /// Error of the coarse light at each texel, relative to the RMS of the reflected light.
    pub coarse_error: Vec<f32>,
    /// Links from nodes to texels or coarse nodes, over all steps.
    pub links: u64,
    /// Bounces.
    pub passes: u32,
    /// The iterations converged.
    pub converged: bool,
}

/// Solves `scene` on the texels of `mesh`. `coarse_error` is the error of the coarse light at each texel in an earlier
/// solve, over the requested error; it is empty if there was none.
///
/// Errors: [`common::Error::Interrupted`].
pub fn solve_scene(
    scene: &Scene,
    mesh: &Mesh,
    coarse_error: &[f32],
    budget: ErrorBudget,
    watch: ProgressCallback,
) -> Result<TexelSolution> {
    solve_with_links(scene, mesh, coarse_error, budget, LinkMethod::Shafts, watch)
}

/// Solves `scene` with links found by `method`.
///
/// Errors: those of [`solve_scene`]; of a device.
pub fn solve_with_links(
    scene: &Scene,
    mesh: &Mesh,
    coarse_error: &[f32],
    budget: ErrorBudget,
    method: LinkMethod,
    watch: ProgressCallback,
) -> Result<TexelSolution> {
    let emission: Vec<Vec3> = mesh.texels.iter().map(|t| t.emission).collect();
    with_solver(scene, mesh, coarse_error, method, |solver| {
        solver.solve_emission(&emission, budget, watch)
    })
}

/// Parts of the light that are gathered on new texels from a known solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightParts {
    /// Light of lamps and from outside.
    Direct,
    /// Light that surfaces reflect, too.
    All,
}

/// Gathers `light` on the texels of `mesh`, where `reflected` is the known irradiance of each texel's open part that other
/// surfaces cause.
///
/// Errors: those of [`solve_with_links`].
pub fn gather_known_light(
    scene: &Scene,
    mesh: &Mesh,
    (light, reflected): (LightParts, &[Vec3]),
    budget: ErrorBudget,
    method: LinkMethod,
    watch: ProgressCallback,
) -> Result<TexelSolution> {
    let emission: Vec<Vec3> = mesh.texels.iter().map(|t| t.emission).collect();
    with_solver(scene, mesh, &[], method, |solver| {
        solver.gather_light(&emission, (light, reflected), budget, watch)
    })
}

/// Returns the open share of each texel of `mesh`.
pub fn open_shares(scene: &Scene, mesh: &Mesh) -> Vec<f32> {
    let rays = Rays::new(mesh);
    let mut open = vec![1.0; mesh.texels.len()];
    for (k, element) in covered_elements(scene, mesh, &Occluders::new(scene, mesh), &rays) {
        open[k as usize] = element.open as f32;
    }
    open
}

/// Runs `task` with a solver for `mesh`; `coarse_error` as in [`solve_scene`].
pub(super) fn with_solver<T>(
    scene: &Scene,
    mesh: &Mesh,
    coarse_error: &[f32],
    method: LinkMethod,
    task: impl FnOnce(HierarchicalSolver) -> Result<T>,
) -> Result<T> {
    let tree = TexelTree::new(scene, mesh);
    let rays = Rays::new(mesh);
    let occluders = Occluders::from_mesh(mesh);
    let covered = covered_elements(scene, mesh, &Occluders::new(scene, mesh), &rays);
    let scene = LinkerScene {
        mesh,
        tree: &tree,
        rays: &rays,
        occluders: &occluders,
        arch: Arch::new(),
    };
    let shafts = CpuLinker {
        scene,
        rays_only: false,
    };
    let rays = CpuLinker { scene, rays_only: true };
    let custom = match method {
        LinkMethod::Custom(factory) => Some(factory(&scene)?),
        _ => None,
    };
    let arriving = custom.as_deref().unwrap_or(match method {
        LinkMethod::Rays => &rays,
        _ => &shafts,
    });
    task(HierarchicalSolver::new(
        scene,
        [arriving, &shafts],
        coarse_error,
        &covered,
    ))
}

/// A solve in progress.
pub(super) struct HierarchicalSolver<'a> {
    pub(super) scene: LinkerScene<'a>,
    /// Linker of light that arrives.
    arriving: &'a dyn Linker,
    /// Linker of occluded light: objects affect few receivers, and shafts find which.
    occluded: &'a dyn Linker,
    /// ρ of each face.
    pub(super) albedo: Vec<Vec3>,
    /// Known H of each texel's open part, which the solve adds to; empty if there is none.
    pub(super) known: Vec<Vec3>,
    /// 1/RMS of the reflected light.
    pub(super) scale: Vec3,
    /// Open share of each texel.
    pub(super) open: Vec<f32>,
    /// Open area of each texel.
    pub(super) area: Vec<f32>,
    /// Area of each texel under fronts that precede its face.
    under_fronts: Vec<f32>,
    pub(super) coarse: CoarseNodes,
    pub(super) covered: CoveredTexels,
    pub(super) links: u64,
    pub(super) passes: u32,
}

/// Coarse light on each texel.
pub(super) struct CoarseLight {
    /// H.
    pub(super) received: Vec<Vec3>,
    /// Unshot radiosity.
    pub(super) unshot: Vec<Vec3>,
    /// The iteration converged.
    pub(super) converged: bool,
}

impl<'a> HierarchicalSolver<'a> {
    fn new(
        scene: LinkerScene<'a>,
        [arriving, occluded]: [&'a dyn Linker; 2],
        coarse_error: &[f32],
        covered: &[(u32, Element)],
    ) -> Self {
        let mesh = scene.mesh;
        let (mut open, mut under_fronts) = (vec![1.0; mesh.texels.len()], vec![0.0; mesh.texels.len()]);
        for (k, element) in covered {
            open[*k as usize] = element.open as f32;
            under_fronts[*k as usize] = element.under_fronts as f32;
        }
        for leaf in &scene.tree.leaves {
            under_fronts[leaf.texel as usize] *= scene.tree.nodes[leaf.node as usize].shooter.area;
        }
        let area: Vec<f32> = mesh.texels.iter().zip(&open).map(|(t, o)| t.area * o).collect();
        let is_coarse = |k: u32| {
            let radius = scene.tree.nodes[k as usize].shooter.radius;
            let is_accurate = || {
                let leaves = scene.tree.leaves_of(k);
                let error = |leaf: &TreeLeaf| coarse_error.get(leaf.texel as usize).copied().unwrap_or(0.0);
                let squares: f32 = leaves.iter().map(|leaf| error(leaf).powi(2)).sum();
                squares <= MAX_COARSE_ERROR * MAX_COARSE_ERROR * leaves.len() as f32
            };
            radius <= MAX_COARSE_RADIUS && (radius <= MIN_COARSE_RADIUS || is_accurate())
        };
        Self {
            coarse: CoarseNodes::new(mesh, scene.tree, is_coarse, [&area, &under_fronts]),
            covered: CoveredTexels::new(scene.tree, covered),
            albedo: {
                let roots = scene.tree.roots.iter();
                roots.map(|k| scene.tree.mean_reflectance(mesh, *k)).collect()
            },
            known: Vec::new(),
            scene,
            arriving,
            occluded,
            scale: Vec3::ONE,
            open,
            area,
            under_fronts,
            links: 0,
            passes: 0,
        }
    }

    /// Solves for `emission` of the texels' open parts.
    fn solve_emission(
        mut self,
        emission: &[Vec3],
        budget: ErrorBudget,
        watch: ProgressCallback,
    ) -> Result<TexelSolution> {
        let (lamps, estimate) = self.estimate_open_parts(emission, watch)?;
        let ambient = self.ambient_irradiance(&self.reflected_radiosity(&estimate));
        let light: Vec<Vec3> = estimate.iter().map(|h| *h + ambient).collect();
        self.scale = self.inverse_rms(&light);
        let direct = self.gather_direct(&lamps, budget, DIRECT_PROGRESS, watch)?;
        let direct_open = self.open_part_mean(&direct);
        let reflected = self.reflected_radiosity(&direct_open);
        let solution = self.solve_indirect(&reflected, &direct_open, ambient, budget, watch)?;
        Ok(TexelSolution {
            irradiance: add_fields(&direct, &solution.irradiance),
            direct,
            ..solution
        })
    }

    /// Gathers `light` once: of `emission`, from outside, and by surfaces of which `reflected` is the known irradiance.
    fn gather_light(
        mut self,
        emission: &[Vec3],
        (light, reflected): (LightParts, &[Vec3]),
        budget: ErrorBudget,
        watch: ProgressCallback,
    ) -> Result<TexelSolution> {
        let (lamps, estimate) = self.estimate_open_parts(emission, watch)?;
        self.scale = self.inverse_rms(&add_fields(&estimate, reflected));
        let end = match light {
            LightParts::Direct => 1.0,
            LightParts::All => DIRECT_PROGRESS.end,
        };
        let direct = self.gather_direct(&lamps, budget, DIRECT_PROGRESS.start..end, watch)?;
        let reflected = match light {
            LightParts::Direct => reflected.iter().zip(&self.open).map(|(h, open)| *h * *open).collect(),
            LightParts::All => {
                let known = add_fields(&self.open_part_mean(&direct), reflected);
                let sources = self.fit_sources(&self.reflected_radiosity(&known));
                self.gather_arriving(&sources, budget.fine, end..1.0, watch)?
            }
        };
        Ok(TexelSolution {
            irradiance: add_fields(&direct, &reflected),
            direct,
            open: self.open,
            ..TexelSolution::default()
        })
    }

    /// Fits the radiosity of lamps, and estimates the irradiance of the texels' open parts by it and from outside.
    fn estimate_open_parts(
        &mut self,
        emission: &[Vec3],
        watch: ProgressCallback,
    ) -> Result<(Vec<LinearRadiosity>, Vec<Vec3>)> {
        let lamps = self.fit_sources(emission);
        let estimate = self.estimate_direct(emission, &lamps, watch)?;
        let estimate = self.add_outside(estimate, |h, open| h / open);
        Ok((lamps, estimate))
    }

    /// Gathers the light of `lamps` and from outside at all texels: the mean over each one's area.
    fn gather_direct(
        &self,
        lamps: &[LinearRadiosity],
        budget: ErrorBudget,
        progress: Range<f64>,
        watch: ProgressCallback,
    ) -> Result<Vec<Vec3>> {
        let direct = self.gather_arriving(lamps, budget.direct, progress, watch)?;
        Ok(self.add_outside(direct, |h, _| h))
    }

    /// Adds the light from outside, as a share that depends on the texel's open share, where a part is open.
    fn add_outside(&self, mut received: Vec<Vec3>, part: impl Fn(Vec3, f32) -> Vec3) -> Vec<Vec3> {
        let texels = self.scene.mesh.texels.iter().zip(&self.open).zip(&mut received);
        for ((texel, open), h) in texels.filter(|((t, open), _)| t.sky != Vec3::ZERO && **open > 0.0) {
            *h += part(texel.sky, *open);
        }
        received
    }

    /// Solves for the irradiance from `reflected`, a radiosity that is shot, and all its bounces. `light` is the
    /// irradiance that is present already, for the scale; `ambient` estimates the further bounces.
    pub(super) fn solve_indirect(
        mut self,
        reflected: &[Vec3],
        light: &[Vec3],
        ambient: Vec3,
        budget: ErrorBudget,
        watch: ProgressCallback,
    ) -> Result<TexelSolution> {
        let even = self.reflected_radiosity(&vec![ambient; reflected.len()]);
        let sources = self.fit_sources(&add_fields(reflected, &even));
        let links = self.link_coarse_nodes(&sources, budget.coarse, watch)?;
        let coarse = self.iterate_coarse(&links, reflected, COARSE_TOLERANCE, watch)?;
        let radiosity = add_fields(reflected, &self.reflected_radiosity(&coarse.received));
        self.scale = self.inverse_rms(&add_fields(light, &coarse.received));
        self.correct_defects(&links, radiosity, coarse, budget, watch)
    }

    /// Estimates the irradiance from further bounces of a radiosity as if they spread evenly (the ambient term of
    /// Cohen et al. 1988).
    pub(super) fn ambient_irradiance(&self, reflected: &[Vec3]) -> Vec3 {
        let texels = self.scene.mesh.texels.iter();
        let grey = self.area_mean(&texels.map(|t| t.reflectance).collect::<Vec<_>>());
        (self.area_mean(reflected) / (DVec3::ONE - grey).max(DVec3::splat(1e-2))).as_vec3()
    }

    /// Estimates the irradiance from `lamps` at the texels and sets the scale by it.
    pub(super) fn estimate_direct(
        &mut self,
        emission: &[Vec3],
        lamps: &[LinearRadiosity],
        watch: ProgressCallback,
    ) -> Result<Vec<Vec3>> {
        let even = self.area_mean(emission).as_vec3();
        self.scale = self.inverse_rms(&vec![even; emission.len()]);
        let sums = self.gather_at_blocks(
            RequestedLight::Arriving,
            lamps,
            ESTIMATE_THRESHOLDS,
            &self.coarse.receivers,
            ESTIMATE_PROGRESS,
            watch,
        )?;
        let sums: Vec<[LaneValues; 3]> = sums.into_iter().map(|lit| lit.sums).collect();
        let direct = self.coarse.received_irradiance(&sums);
        let direct = self.coarse.spread_to_texels(self.scene.tree, &direct, emission.len());
        self.scale = self.inverse_rms(&direct);
        Ok(direct)
    }

    /// Fits the radiosity of all nodes to the values of the texels' open parts.
    pub(super) fn fit_sources(&self, values: &[Vec3]) -> Vec<LinearRadiosity> {
        self.fit_open_parts(&self.area, values)
    }

    /// Fits the radiosity of all nodes to `values` of open parts of the texels, whose areas are `open`. What lies under
    /// preceding fronts is hidden from no one and shines nothing: such an area counts as dark.
    pub(super) fn fit_open_parts(&self, open: &[f32], values: &[Vec3]) -> Vec<LinearRadiosity> {
        let areas = open.iter().zip(&self.under_fronts);
        let (areas, shares): (Vec<f32>, Vec<f32>) = areas.map(|(open, dark)| source_area(*open, *dark)).unzip();
        let values: Vec<Vec3> = values
            .iter()
            .zip(&shares)
            .map(|(value, share)| *value * *share)
            .collect();
        pull_radiosity(self.scene.tree, &areas, &values)
    }

    /// Gathers the light that arrives from the sources of this `radiosity` at all texels: the mean over each one's area.
    pub(super) fn gather_arriving(
        &self,
        radiosity: &[LinearRadiosity],
        thresholds: LinkThresholds,
        progress: Range<f64>,
        watch: ProgressCallback,
    ) -> Result<Vec<Vec3>> {
        let all = ReceiverSelection::on_faces(0..self.scene.mesh.faces.len());
        self.gather_at_texels(RequestedLight::Arriving, radiosity, &all, thresholds, progress, watch)
    }

    /// Gathers `light` from the sources of this `radiosity` at the selected texels: the mean over each one's area.
    pub(super) fn gather_at_texels(
        &self,
        light: RequestedLight,
        radiosity: &[LinearRadiosity],
        selection: &ReceiverSelection,
        thresholds: LinkThresholds,
        progress: Range<f64>,
        watch: ProgressCallback,
    ) -> Result<Vec<Vec3>> {
        let scale = |face: u32| self.scale * threshold_reflectance(&self.albedo, face);
        let mut gather = FinalGather::new(
            self.scene.tree,
            &self.covered,
            &scale,
            thresholds.source,
            selection,
            self.area.len(),
        );
        let mut progress = progress;
        while let Some(spots) = gather.next_spots() {
            let receivers = ReceiverBlocks::new(self.scene.mesh, |f| spots[f].clone());
            // The number of levels is unknown: each takes half of the rest.
            let half = (progress.start + progress.end) / 2.0;
            let lit = self.gather_at_blocks(light, radiosity, thresholds, &receivers, progress.start..half, watch)?;
            gather.take_irradiance(&receivers.blocks, &lit);
            progress.start = half;
        }
        Ok(gather.into_texels())
    }

    /// Gathers `light` from the sources of this `radiosity` at each block.
    pub(super) fn gather_at_blocks(
        &self,
        light: RequestedLight,
        radiosity: &[LinearRadiosity],
        thresholds: LinkThresholds,
        receivers: &ReceiverBlocks,
        progress: Range<f64>,
        watch: ProgressCallback,
    ) -> Result<Vec<BlockIrradiance>> {
        let (scale, albedo) = (self.scale, &self.albedo);
        let request = LinkRequest {
            light,
            radiosity,
            thresholds,
            receivers,
            scale: &|face| scale * threshold_reflectance(albedo, face),
            progress,
        };
        let linker = match light {
            RequestedLight::Arriving => self.arriving,
            RequestedLight::OccludedBy(_) => self.occluded,
        };
        linker.gather_irradiance(&request, watch)
    }

    /// Links the sources of this `radiosity` to the coarse nodes.
    pub(super) fn link_coarse_nodes(
        &mut self,
        radiosity: &[LinearRadiosity],
        thresholds: LinkThresholds,
        watch: ProgressCallback,
    ) -> Result<Vec<Vec<StoredLink>>> {
        let (scale, albedo) = (self.scale, &self.albedo);
        let request = LinkRequest {
            light: RequestedLight::Arriving,
            radiosity,
            thresholds,
            receivers: &self.coarse.receivers,
            scale: &|face| scale * threshold_reflectance(albedo, face),
            progress: LINK_PROGRESS,
        };
        let links = self.arriving.create_links(&request, watch)?;
        self.coarse.prepare_sources(&links);
        let ones = self.fit_sources(&vec![Vec3::ONE; self.area.len()]);
        self.coarse.limit_gain(&gather_over_links(&links, &ones));
        self.links += links.iter().map(|links| links.len() as u64).sum::<u64>();
        Ok(links)
    }

    /// Iterates x = K(source + ρx) over the stored links until the share `tolerance` is unshot.
    pub(super) fn iterate_coarse(
        &mut self,
        links: &[Vec<StoredLink>],
        source: &[Vec3],
        tolerance: f64,
        watch: ProgressCallback,
    ) -> Result<CoarseLight> {
        let tree = self.scene.tree;
        let radiosity = self.fit_sources(source);
        let mut iteration = BounceIteration {
            tree,
            coarse: &mut self.coarse,
            links,
            radiosity,
            passes: 0,
        };
        let mut go_on = || match watch(ITERATE_PROGRESS) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted),
        };
        let result = iteration.iterate_until(tolerance, &mut go_on)?;
        self.passes += iteration.passes;
        let texels = source.len();
        Ok(CoarseLight {
            received: self.coarse.spread_to_texels(tree, &result.received, texels),
            unshot: self.coarse.spread_to_texels(tree, &result.unshot, texels),
            converged: result.converged,
        })
    }

    /// Returns ρH of each texel.
    pub(super) fn reflected_radiosity(&self, received: &[Vec3]) -> Vec<Vec3> {
        let texels = self.scene.mesh.texels.iter();
        received.iter().zip(texels).map(|(h, t)| *h * t.reflectance).collect()
    }

    /// Converts means over texels to means over their open parts.
    pub(super) fn open_part_mean(&self, received: &[Vec3]) -> Vec<Vec3> {
        let share = |(h, open): (&Vec3, &f32)| if *open > 0.0 { *h / *open } else { Vec3::ZERO };
        received.iter().zip(&self.open).map(share).collect()
    }

    /// Returns the mean over all open area.
    pub(super) fn area_mean(&self, value: &[Vec3]) -> DVec3 {
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for (v, a) in value.iter().zip(&self.area) {
            sum += v.as_dvec3() * f64::from(*a);
            area += f64::from(*a);
        }
        sum / area.max(f64::MIN_POSITIVE)
    }

    /// Returns 1/RMS of the light that texels reflect of `light` and the known irradiance; 0 if there is none.
    pub(super) fn inverse_rms(&self, light: &[Vec3]) -> Vec3 {
        let texels = self.scene.mesh.texels.iter();
        let square = |(k, texel): (usize, &Texel)| {
            let known = self.known.get(k).copied().unwrap_or_default();
            ((light[k] + known) * texel.reflectance.max(Vec3::splat(MIN_REFLECTANCE))).powf(2.0)
        };
        let squares = texels.enumerate().map(square);
        let rms = self.area_mean(&squares.collect::<Vec<_>>()).map(f64::sqrt);
        rms.map(|rms| if rms > 0.0 { 1.0 / rms } else { 0.0 }).as_vec3()
    }
}

/// Returns a face's reflectance as error estimates use it.
fn threshold_reflectance(albedo: &[Vec3], face: u32) -> Vec3 {
    albedo[face as usize].max(Vec3::splat(MIN_REFLECTANCE))
}
