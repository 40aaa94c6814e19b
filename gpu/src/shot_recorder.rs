//! Commands of one submission: many shots in a row, without a read-back between them.

use crate::dispatch_arguments::CountedStage;
use crate::link_recorder::{LinkRecorder, ShotSelection, bind_stage, dispatch_once};
use crate::shot_slots::ShotSlots;
use crate::shot_stages::ShotStages;
use crate::solver_buffers::{LOG_BYTES, SolverBuffers};
use common::mesh::Mesh;

/// Recorder of shots that the device selects.
pub struct ShotRecorder<'a> {
    pub buffers: &'a SolverBuffers,
    pub slots: &'a ShotSlots,
    pub pipelines: &'a ShotStages,
    pub mesh: &'a Mesh,
}

impl ShotRecorder<'_> {
    /// Records the unshot power of all patches, with workgroups from the host.
    pub fn record_power(&self, encoder: &mut wgpu::CommandEncoder, groups: [u32; 4]) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        bind_stage(&mut pass, &self.pipelines.power);
        pass.dispatch_workgroups(groups[0], groups[1], 1);
    }

    /// Records the selection of a run's first shooter.
    pub fn record_first_choice(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        dispatch_once(&mut pass, &self.pipelines.first);
    }

    /// Records one shot, and the selection of the next shooter. Once the order has ended it does nothing.
    pub fn record_shot(&self, encoder: &mut wgpu::CommandEncoder) {
        let (b, p) = (self.buffers, self.pipelines);
        let linker = LinkRecorder {
            mesh: self.mesh,
            buffers: b,
            slots: self.slots,
            stages: &p.link,
            shots: ShotSelection::Chosen,
        };
        for step in linker.link_steps() {
            linker.record_step(encoder, step);
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (stage, counted) in [(&p.deposit, CountedStage::Deposit), (&p.power, CountedStage::Power)] {
            bind_stage(&mut pass, stage);
            pass.dispatch_workgroups_indirect(&b.dispatches, counted.byte_offset());
        }
        dispatch_once(&mut pass, &p.next);
    }

    /// Clears the log of the previous submission.
    pub fn clear_log(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.buffers.log, 0, Some(4));
    }

    /// Copies the log to `staging`.
    pub fn copy_log(&self, encoder: &mut wgpu::CommandEncoder, staging: &wgpu::Buffer) {
        encoder.copy_buffer_to_buffer(&self.buffers.log, 0, staging, 0, LOG_BYTES);
    }
}
