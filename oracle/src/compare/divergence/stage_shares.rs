//! Shares of the stages in the difference of radiosity: the same shots with one stage of the GPU and the others of the
//! CPU.

use super::MAX_FOLLOWED_SHOTS;
use super::search::Search;
use super::shooter_links::ShooterLinks;
use crate::compare::parting::{StageShare, StageShares};
use crate::diff::difference::{channel_differences, reflected_radiosity, worst_channel};
use common::Result;
use common::mesh::Mesh;
use common::passes::PatchClosure;
use common::shooting::{DepositRule, RadiosityField, Restart, Shoot, ShotOrder, initial_field};
use cpu::shader_twins::closure::sum_form_factors;
use cpu::shader_twins::patch_transfer::patch_transfer;
use glam::Vec3;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// Stage of the GPU in a chain of the CPU.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SwappedStage {
    Visibility,
    FormFactor,
    /// w of the GPU beyond its F × visible part.
    Weight,
    /// All links of the GPU.
    Links,
}

impl Search<'_> {
    /// Returns the shares after the shots that the CPU chooses first.
    ///
    /// Errors: the device fails.
    pub fn measure_shares(&mut self) -> Result<StageShares> {
        let order = ShotOrder::Greedy {
            threshold: self.threshold,
        };
        restart(&mut self.cpu, self.mesh)?;
        let (mut log, mut shooters) = (Vec::new(), BTreeSet::new());
        self.cpu.run(order, MAX_FOLLOWED_SHOTS, &mut |shot| {
            log.push(shot.patch);
            shooters.insert(shot.patch);
            match shooters.len() < super::MAX_FOLLOWED_SHOOTERS {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            }
        })?;
        let cpu = self.cpu.read_field()?;
        for patch in &shooters {
            self.make_shooter_links(*patch)?;
        }
        let shots = log.len() as u32;
        restart(&mut self.gpu, self.mesh)?;
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        self.gpu.run(ShotOrder::Replay(&log), shots, go_on)?;
        let gpu = self.gpu.read_field()?;
        restart(&mut self.gpu, self.mesh)?;
        self.gpu.run(order, shots, go_on)?;
        let by_choice = self.gpu.read_field()?;
        let mesh = self.mesh;
        let measure = |a: &RadiosityField, b: &RadiosityField| relative_rms(mesh, [a, b], &cpu);
        let swaps = [
            ("visibility", SwappedStage::Visibility),
            ("form factor", SwappedStage::FormFactor),
            ("link", SwappedStage::Weight),
        ];
        let mut stages = Vec::new();
        for (stage, swapped) in swaps {
            stages.push(StageShare {
                stage,
                relative_rms: measure(&self.replay_swapped(&log, swapped)?, &cpu),
            });
        }
        let on_links = self.replay_swapped(&log, SwappedStage::Links)?;
        stages.push(StageShare {
            stage: "deposit",
            relative_rms: measure(&gpu, &on_links),
        });
        stages.push(StageShare {
            stage: "choice",
            relative_rms: measure(&by_choice, &gpu),
        });
        Ok(StageShares {
            shots,
            relative_rms: measure(&gpu, &cpu),
            stages,
        })
    }

    /// Shoots the patches of `log` on the CPU with links of a swapped stage.
    fn replay_swapped(&mut self, log: &[u32], stage: SwappedStage) -> Result<RadiosityField> {
        restart(&mut self.cpu, self.mesh)?;
        for patch in log {
            let links = &self.shooters[patch];
            let (row, closure) = swapped_row(self.mesh, *patch, links, stage);
            self.cpu.replace_row(*patch, &row, closure);
            self.cpu.shoot(*patch)?;
        }
        self.cpu.read_field()
    }
}

/// Returns the links of a shooter with a stage of the GPU, and their closure.
fn swapped_row(mesh: &Mesh, patch: u32, links: &ShooterLinks, stage: SwappedStage) -> (Vec<f32>, PatchClosure) {
    let gpu = &links.gpu.row;
    if stage == SwappedStage::Links {
        let closure = PatchClosure {
            form_factor_sum: gpu.sum,
            escaped: gpu.escaped,
        };
        return (gpu.links.clone(), closure);
    }
    let open = mesh.patches[patch as usize].open_share;
    let link_of = |k: usize| {
        let factor = links.form_factors[k];
        let visible = [links.gpu_visible_part(k), links.cpu_visible_part(k)];
        match stage {
            SwappedStage::Visibility => factor * visible[0] / open,
            SwappedStage::FormFactor => links.gpu.sums[k].x * visible[1] / open,
            _ => links.links[k] + gpu.links[k] - links.gpu.sums[k].x * visible[0] / open,
        }
    };
    let row: Vec<f32> = (0..mesh.texels.len()).map(link_of).collect();
    let transfers: Vec<f32> = mesh
        .patches
        .iter()
        .map(|taker| patch_transfer(mesh, &row, taker))
        .collect();
    let closure = PatchClosure {
        form_factor_sum: sum_form_factors(&transfers, mesh.patches[patch as usize].shooter.area),
        escaped: links.closure.escaped,
    };
    (row, closure)
}

/// Sets an engine to the state before the first shot.
fn restart(engine: &mut dyn Restart, mesh: &Mesh) -> Result<()> {
    let reflectance: Vec<Vec3> = mesh.texels.iter().map(|texel| texel.reflectance).collect();
    engine.restart_from(DepositRule::FULL_DEPOSIT, &reflectance, &initial_field(mesh, ""))
}

/// Returns the RMS of a − b over that of `whole`, by area in the worst channel.
fn relative_rms(mesh: &Mesh, [a, b]: [&RadiosityField; 2], whole: &RadiosityField) -> f64 {
    let texels = (0..mesh.texels.len()).map(|k| {
        let of = |field| reflected_radiosity(mesh, field, k);
        (f64::from(mesh.texels[k].area), of(whole) + of(a) - of(b), of(whole))
    });
    worst_channel(channel_differences(texels)).relative_rms
}
