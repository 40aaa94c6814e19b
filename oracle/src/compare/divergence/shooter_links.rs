//! Links of one shooter on both sides, split into form factor and visible part.

use crate::compare::visibility::{ProbedShooter, probe_shooter};
use common::Result;
use common::mesh::Mesh;
use common::passes::PatchClosure;
use common::rays::Rays;
use common::settings::Transport;
use cpu::CpuSolver;
use cpu::shader_twins::link::{Sums, add_sample, texel_form_factor};
use gpu::GpuSolver;
use rayon::prelude::*;

/// Links of a shooter; each list has a value of every texel.
pub struct ShooterLinks {
    /// The GPU's.
    pub gpu: ProbedShooter,
    /// Form factors F of the CPU.
    pub form_factors: Vec<f32>,
    /// Sums over the samples by rays, of the GPU's F where it is positive, else of the CPU's.
    pub by_rays: Vec<Sums>,
    /// Links w of the CPU.
    pub links: Vec<f32>,
    /// Closure of the CPU's links.
    pub closure: PatchClosure,
}

impl ShooterLinks {
    /// Makes the links of `patch` on both sides.
    ///
    /// Errors: the device fails, or a result of the GPU is incomplete.
    pub fn new(
        mesh: &Mesh,
        transport: &Transport,
        patch: u32,
        cpu: &mut CpuSolver,
        gpu: &mut GpuSolver,
    ) -> Result<Self> {
        let probed = probe_shooter(mesh, transport, patch, cpu.rays(), gpu)?;
        let texels = 0..mesh.texels.len() as u32;
        let kind = transport.form_factor;
        let factors: Vec<f32> = texels
            .into_par_iter()
            .map(|k| texel_form_factor(mesh, kind, patch, k))
            .collect();
        let rays = cpu.rays();
        let pairs = probed.sums.par_iter().zip(&factors).enumerate();
        let by_rays = pairs.map(|(k, (gpu, factor))| {
            let form_factor = if gpu.x > 0.0 { gpu.x } else { *factor };
            sum_by_rays(mesh, rays, [patch, k as u32], form_factor)
        });
        let by_rays = by_rays.collect();
        let row = cpu.link_row(patch)?;
        Ok(Self {
            links: row.links.to_vec(),
            closure: row.closure,
            gpu: probed,
            form_factors: factors,
            by_rays,
        })
    }

    /// Returns the change of the link of texel `k` if all its samples near silhouettes had the opposite visibility.
    pub fn silhouette_bound(&self, k: usize) -> f32 {
        self.gpu.link_bounds.get(k).copied().unwrap_or(0.0)
    }

    /// Returns the GPU's visible part Σ g·V / Σ g of the shooter at texel `k`, the CPU's where there are no samples.
    pub fn gpu_visible_part(&self, k: usize) -> f32 {
        let sums = self.gpu.sums[k];
        if sums.x > 0.0 && sums.z > 0.0 {
            sums.y / sums.z
        } else {
            self.cpu_visible_part(k)
        }
    }

    /// Returns the CPU's visible part at texel `k`; 0 without samples.
    pub fn cpu_visible_part(&self, k: usize) -> f32 {
        let sums = self.by_rays[k];
        if sums.all > 0.0 { sums.seen / sums.all } else { 0.0 }
    }
}

/// Returns the sums of a texel over the samples of a patch by rays.
fn sum_by_rays(mesh: &Mesh, rays: &Rays, [patch, k]: [u32; 2], form_factor: f32) -> Sums {
    let mut sums = Sums {
        form_factor,
        ..Sums::default()
    };
    let ends = [mesh.patches[patch as usize].face, mesh.texels[k as usize].face];
    for s in 0..mesh.samples {
        add_sample(mesh, patch, k, s, &mut sums, |q, p| rays.find_sight(q, p, ends, false));
    }
    sums
}
