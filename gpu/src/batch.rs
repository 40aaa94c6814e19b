//! One submission: many shots recorded in a row, without a look at what any of them did.

use crate::buffers::{Buffers, LOG_BYTES, level_bytes};
use crate::pipelines::{ItemBufferStages, Pipelines, Stage};
use common::constants::LEVELS;
use common::mesh::Mesh;
use common::settings::Raster;

/// Byte offsets of each stage's workgroup counts in `dispatches`, as in `select.wgsl`.
const DEPOSIT: u64 = 0;
const ESCAPE: u64 = 12;
const POWER: u64 = 24;
const GATHER: u64 = 36;
const RECEIVED: u64 = 48;
/// Bytes of `dispatches`.
pub const DISPATCH_BYTES: u64 = 60;

/// What a batch records its commands against.
pub struct Recorder<'a> {
    pub buffers: &'a Buffers,
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
        for _ in 0..self.mesh.samples.div_ceil(self.buffers.step) {
            self.gather(encoder);
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (stage, offset) in [(&p.escape, ESCAPE), (&p.received, RECEIVED)] {
            bind(&mut pass, stage);
            pass.dispatch_workgroups_indirect(&b.dispatches, offset);
        }
        single(&mut pass, &p.closure);
        for (stage, offset) in [(&p.deposit, DEPOSIT), (&p.power, POWER)] {
            bind(&mut pass, stage);
            pass.dispatch_workgroups_indirect(&b.dispatches, offset);
        }
        single(&mut pass, &p.next);
    }

    /// The next samples of a shot's links; nothing where they are kept from an earlier shot.
    fn gather(&self, encoder: &mut wgpu::CommandEncoder) {
        let (b, p) = (self.buffers, self.pipelines);
        if let Some(stages) = &p.item_buffer {
            let view = b.item_buffer.create_view(&Default::default());
            match &b.room_buffer {
                None => self.draw(encoder, stages, &p.aim, &view),
                Some(room) => {
                    self.draw(encoder, stages, &p.aim, room);
                    self.draw(encoder, stages, &p.whole, &view);
                }
            }
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        if p.item_buffer.is_none() {
            single(&mut pass, &p.aim);
        }
        bind(&mut pass, &p.gather);
        pass.dispatch_workgroups_indirect(&b.dispatches, GATHER);
    }

    /// Draws into `target` what `aim` says.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stages: &ItemBufferStages,
        aim: &Stage,
        target: &wgpu::TextureView,
    ) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        single(&mut pass, aim);
        if stages.kind == Raster::Tessellated {
            single(&mut pass, &stages.tessellate);
        }
        drop(pass);
        self.raster(encoder, stages, target);
    }

    fn raster(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stages: &ItemBufferStages,
        target: &wgpu::TextureView,
    ) {
        let b = self.buffers;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &b.depth.create_view(&Default::default()),
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&stages.raster);
        pass.set_bind_group(0, &stages.raster_group, &[]);
        if stages.kind == Raster::Pixel {
            // Two triangles for each side of each face; none where no links are made.
            pass.draw_indirect(&b.rectangles, 0);
            return;
        }
        pass.set_index_buffer(b.indices.slice(..), wgpu::IndexFormat::Uint32);
        let bytes = level_bytes(self.mesh);
        for level in 0..u64::from(LEVELS) {
            pass.set_vertex_buffer(0, b.instances.slice(level * bytes..(level + 1) * bytes));
            pass.draw_indexed_indirect(&b.draws, level * 20);
        }
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

fn bind(pass: &mut wgpu::ComputePass, stage: &Stage) {
    pass.set_pipeline(&stage.pipeline);
    pass.set_bind_group(0, &stage.group, &[]);
}

fn single(pass: &mut wgpu::ComputePass, stage: &Stage) {
    bind(pass, stage);
    pass.dispatch_workgroups(1, 1, 1);
}
