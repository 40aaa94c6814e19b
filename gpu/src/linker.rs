//! The stages that make links, recorded for one shot chosen on the device or for many side by side.

use crate::buffers::Buffers;
use crate::dispatches::Counted;
use crate::grids::{DRAW_WORDS, level_bytes};
use crate::pipelines::{ItemBufferStages, LinkStages};
use crate::slots::Slots;
use crate::stage::Stage;
use common::constants::LEVELS;
use common::mesh::Mesh;
use common::settings::Raster;

/// A part of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// The next sample's point, and item buffers drawn from it.
    Draw,
    /// Visibility and form factors of the next samples.
    Links,
    /// Directions that meet no front.
    Escape,
    /// What each cell takes, and all of them.
    Sums,
}

/// Whose links are made.
#[derive(Clone, Copy)]
pub enum Shots<'a> {
    /// Those of the shot in flight, if it has none.
    Chosen,
    /// Those of these cells, one a slot; workgroups over texels, directions and cells.
    These(&'a [u32], [[u32; 4]; 3]),
}

/// What the steps are recorded against.
pub struct Linker<'a> {
    pub mesh: &'a Mesh,
    pub buffers: &'a Buffers,
    pub slots: &'a Slots,
    pub stages: &'a LinkStages,
    pub shots: Shots<'a>,
}

impl Linker<'_> {
    /// The steps in their order.
    pub fn steps(&self) -> impl Iterator<Item = Step> {
        let rounds = self.mesh.samples.div_ceil(self.slots.step) as usize;
        std::iter::repeat_n([Step::Draw, Step::Links], rounds)
            .flatten()
            .chain([Step::Escape, Step::Sums])
    }

    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, step: Step) {
        match step {
            Step::Draw => self.draws(encoder),
            Step::Links => self.compute(encoder, &[(&self.stages.links, 0, Counted::Links)]),
            Step::Escape => self.compute(encoder, &[(&self.stages.escape, 1, Counted::Escape)]),
            Step::Sums => {
                self.compute(encoder, &[(&self.stages.received, 2, Counted::Received)]);
                self.single(encoder, &self.stages.closure);
            }
        }
    }

    /// Stages with workgroups over texels, directions or cells.
    fn compute(&self, encoder: &mut wgpu::CommandEncoder, stages: &[(&Stage, usize, Counted)]) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (stage, groups, counted) in stages {
            bind(&mut pass, stage);
            match self.shots {
                Shots::Chosen => {
                    pass.dispatch_workgroups_indirect(&self.buffers.dispatches, counted.offset());
                }
                Shots::These(cells, counts) => {
                    let [x, y, ..] = counts[*groups];
                    pass.dispatch_workgroups(x, y, cells.len() as u32);
                }
            }
        }
    }

    /// One workgroup a shot.
    fn single(&self, encoder: &mut wgpu::CommandEncoder, stage: &Stage) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        bind(&mut pass, stage);
        let slots = match self.shots {
            Shots::Chosen => 1,
            Shots::These(cells, _) => cells.len() as u32,
        };
        pass.dispatch_workgroups(1, 1, slots);
    }

    fn draws(&self, encoder: &mut wgpu::CommandEncoder) {
        let (s, all) = (self.slots, self.mesh.faces.len() as u32);
        let Some(stages) = &self.stages.item_buffer else {
            return self.single(encoder, &self.stages.aim);
        };
        match &s.room_buffer {
            None => self.draw(encoder, stages, &self.stages.aim, &s.view, all),
            Some(room) => {
                self.draw(encoder, stages, &self.stages.aim, room, self.mesh.room);
                self.draw(encoder, stages, &self.stages.whole, &s.view, all);
            }
        }
    }

    /// Draws the first so many faces into `target`, as `aim` says.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stages: &ItemBufferStages,
        aim: &Stage,
        target: &wgpu::TextureView,
        faces: u32,
    ) {
        self.single(encoder, aim);
        if stages.kind == Raster::Tessellated {
            self.single(encoder, &stages.tessellate);
        }
        let mut pass = begin(encoder, target, &self.slots.depth);
        pass.set_pipeline(&stages.raster);
        pass.set_bind_group(0, &stages.raster_group, &[]);
        match (stages.kind, self.shots) {
            (Raster::Tessellated, _) => self.tessellated(&mut pass),
            // Two triangles for each side of each face; none where no links are made.
            (Raster::Pixel, Shots::Chosen) => pass.draw_indirect(&self.slots.rectangles, 0),
            (Raster::Pixel, Shots::These(cells, _)) => self.tiles(&mut pass, cells, faces),
        }
    }

    /// An item buffer a shot, side by side.
    fn tiles(&self, pass: &mut wgpu::RenderPass, cells: &[u32], faces: u32) {
        let size = self.slots.size;
        for (slot, cell) in (0..).zip(cells) {
            let (x, y) = (
                slot % self.slots.tiles * size,
                slot / self.slots.tiles * size,
            );
            pass.set_viewport(x as f32, y as f32, size as f32, size as f32, 0.0, 1.0);
            pass.set_scissor_rect(x, y, size, size);
            let object = self.mesh.is_object(self.mesh.cells[*cell as usize].face);
            // What an object saw before it came is not asked.
            if !object || faces > self.mesh.room {
                pass.draw(0..6 * self.slots.sides * faces, slot..slot + 1);
            }
        }
    }

    fn tessellated(&self, pass: &mut wgpu::RenderPass) {
        pass.set_index_buffer(self.buffers.indices.slice(..), wgpu::IndexFormat::Uint32);
        let (bytes, s) = (level_bytes(self.mesh), self.slots);
        // With tiles there is one: the viewport is the whole texture.
        for level in 0..u64::from(LEVELS) {
            pass.set_vertex_buffer(0, s.instances.slice(level * bytes..(level + 1) * bytes));
            pass.draw_indexed_indirect(&s.draws, 4 * u64::from(DRAW_WORDS) * level);
        }
    }
}

fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
    depth: &wgpu::TextureView,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
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
            view: depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(1.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

/// The stage is what the next dispatches run.
pub fn bind(pass: &mut wgpu::ComputePass, stage: &Stage) {
    pass.set_pipeline(&stage.pipeline);
    pass.set_bind_group(0, &stage.group, &[]);
}

/// One workgroup.
pub fn single(pass: &mut wgpu::ComputePass, stage: &Stage) {
    bind(pass, stage);
    pass.dispatch_workgroups(1, 1, 1);
}
