//! One submission: many shots recorded in a row, without a look at what any of them did.

use crate::buffers::{Buffers, LOG_BYTES};
use crate::dispatches::Counted;
use crate::linker::{Linker, Shots, bind, single};
use crate::pipelines::Pipelines;
use crate::slots::Slots;
use common::mesh::Mesh;

/// What a batch records its commands against.
pub struct Recorder<'a> {
    pub buffers: &'a Buffers,
    pub slots: &'a Slots,
    pub pipelines: &'a Pipelines,
    pub mesh: &'a Mesh,
}

impl Recorder<'_> {
    /// The sums of all cells, workgroups given by the host.
    pub fn power(&self, encoder: &mut wgpu::CommandEncoder, groups: [u32; 4]) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        bind(&mut pass, &self.pipelines.power);
        pass.dispatch_workgroups(groups[0], groups[1], 1);
    }

    /// The first shooter of a run.
    pub fn first(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        single(&mut pass, &self.pipelines.first);
    }

    /// One shot, and the choice of the next shooter. Once the order has ended it does nothing.
    pub fn shot(&self, encoder: &mut wgpu::CommandEncoder) {
        let (b, p) = (self.buffers, self.pipelines);
        let linker = Linker {
            mesh: self.mesh,
            buffers: b,
            slots: self.slots,
            stages: &p.link,
            shots: Shots::Chosen,
        };
        for step in linker.steps() {
            linker.record(encoder, step);
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (stage, counted) in [(&p.deposit, Counted::Deposit), (&p.power, Counted::Power)] {
            bind(&mut pass, stage);
            pass.dispatch_workgroups_indirect(&b.dispatches, counted.offset());
        }
        single(&mut pass, &p.next);
    }

    /// Forgets the previous batch's log.
    pub fn clear_log(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.buffers.log, 0, Some(4));
    }

    /// Hands the log to the host.
    pub fn copy_log(&self, encoder: &mut wgpu::CommandEncoder, staging: &wgpu::Buffer) {
        encoder.copy_buffer_to_buffer(&self.buffers.log, 0, staging, 0, LOG_BYTES);
    }
}
