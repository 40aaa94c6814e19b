//! Commands of the stages that make links: for the shot that the device selects, or for many side by side. The solver
//! records them for shots and passes, and the probe for checks.

use crate::compute_stage::ComputeStage;
use crate::dispatch_arguments::CountedStage;
use crate::shot_slots::ShotSlots;
use crate::shot_stages::LinkStages;
use crate::solver_buffers::SolverBuffers;
use common::dispatch::tile_index;
use common::mesh::Mesh;

/// A step of making links.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LinkStep {
    /// Moves on to the next sample and draws item buffers from it.
    Draw,
    /// Computes visibility and form factors of the next samples.
    Links,
    /// Counts directions that meet no front.
    Escape,
    /// Sums the transfer to each patch, and ΣF.
    Sums,
}

/// The shots whose links are made.
#[derive(Clone, Copy)]
pub enum ShotSelection<'a> {
    /// The shot in flight, if its links are not kept.
    Chosen,
    /// Shots of these patches, one a slot; workgroups over texels, directions and patches.
    These(&'a [u32], [[u32; 3]; 3]),
}

/// Recorder of the steps that make links.
pub struct LinkRecorder<'a> {
    pub mesh: &'a Mesh,
    pub buffers: &'a SolverBuffers,
    pub slots: &'a ShotSlots,
    pub stages: &'a LinkStages,
    pub shots: ShotSelection<'a>,
}

impl LinkRecorder<'_> {
    /// Returns the steps in their order.
    pub fn link_steps(&self) -> impl Iterator<Item = LinkStep> {
        let rounds = self.mesh.samples.div_ceil(self.slots.step) as usize;
        std::iter::repeat_n([LinkStep::Draw, LinkStep::Links], rounds)
            .flatten()
            .chain([LinkStep::Escape, LinkStep::Sums])
    }

    pub fn record_step(&self, encoder: &mut wgpu::CommandEncoder, step: LinkStep) {
        let stages = self.stages;
        match step {
            LinkStep::Draw => self.draw_item_buffers(encoder),
            LinkStep::Links => self.dispatch_stage(encoder, &stages.links, 0, CountedStage::Links),
            LinkStep::Escape => self.dispatch_stage(encoder, &stages.escape, 1, CountedStage::Escape),
            LinkStep::Sums => {
                self.dispatch_stage(encoder, &stages.received, 2, CountedStage::Transfer);
                self.dispatch_per_shot(encoder, &stages.closure);
            }
        }
    }

    /// Dispatches workgroups over texels (0), directions (1) or patches (2).
    fn dispatch_stage(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &ComputeStage,
        over: usize,
        counted: CountedStage,
    ) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        match self.shots {
            ShotSelection::Chosen => {
                stage.dispatch_counted(&mut pass, &self.buffers.table["dispatches"], counted.byte_offset());
            }
            ShotSelection::These(patches, counts) => {
                let [x, y, _] = counts[over];
                stage.dispatch_groups(&mut pass, [x, y, patches.len() as u32]);
            }
        }
    }

    /// Dispatches one workgroup a shot.
    fn dispatch_per_shot(&self, encoder: &mut wgpu::CommandEncoder, stage: &ComputeStage) {
        let slots = match self.shots {
            ShotSelection::Chosen => 1,
            ShotSelection::These(patches, _) => patches.len() as u32,
        };
        stage.dispatch_groups(&mut encoder.begin_compute_pass(&Default::default()), [1, 1, slots]);
    }

    fn draw_item_buffers(&self, encoder: &mut wgpu::CommandEncoder) {
        let (s, all) = (self.slots, self.mesh.faces.len() as u32);
        let Some(raster) = &self.stages.item_buffer else {
            return self.dispatch_per_shot(encoder, &self.stages.aim);
        };
        match &s.room_buffer {
            None => self.draw_item_buffer(encoder, raster, &self.stages.aim, &s.view, all),
            Some(room) => {
                self.draw_item_buffer(encoder, raster, &self.stages.aim, room, self.mesh.room_faces);
                self.draw_item_buffer(encoder, raster, &self.stages.whole, &s.view, all);
            }
        }
    }

    /// Draws the first `faces` faces into `target`, after stage `aim` has set the view.
    fn draw_item_buffer(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (pipeline, group): &(wgpu::RenderPipeline, wgpu::BindGroup),
        aim: &ComputeStage,
        target: &wgpu::TextureView,
        faces: u32,
    ) {
        self.dispatch_per_shot(encoder, aim);
        let mut pass = begin_raster_pass(encoder, target, &self.slots.depth);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        match self.shots {
            // Two triangles for each side of each face; none where links are kept.
            ShotSelection::Chosen => pass.draw_indirect(&self.slots.table["rectangles"], 0),
            ShotSelection::These(patches, _) => self.draw_tiles(&mut pass, patches, faces),
        }
    }

    /// Draws an item buffer a shot, side by side.
    fn draw_tiles(&self, pass: &mut wgpu::RenderPass, patches: &[u32], faces: u32) {
        let size = self.slots.size;
        for (slot, patch) in (0..).zip(patches) {
            let [x, y] = tile_index(slot, self.slots.tiles).map(|n| n * size);
            pass.set_viewport(x as f32, y as f32, size as f32, size as f32, 0.0, 1.0);
            pass.set_scissor_rect(x, y, size, size);
            let object = self.mesh.is_object(self.mesh.patches[*patch as usize].face);
            // An object needs no item buffer of the room without objects.
            if !object || faces > self.mesh.room_faces {
                pass.draw(0..6 * self.slots.sides * faces, slot..slot + 1);
            }
        }
    }
}

fn begin_raster_pass<'e>(
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
