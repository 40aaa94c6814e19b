//! Compute and raster stages of a shot, each bound to the buffers that it reads and writes.

use crate::compute_stage::BindingSlot::{Read, Texture, Uniform, Write};
use crate::compute_stage::{ComputeStage, PipelineMaker};
use crate::shot_slots::ShotSlots;
use crate::solver_buffers::SolverBuffers;
use common::Result;
use common::settings::{ItemBufferSettings, Raster, Transport, Visibility};

/// Stages of a shot that the device selects itself.
pub struct ShotStages {
    pub first: ComputeStage,
    pub next: ComputeStage,
    pub link: LinkStages,
    pub deposit: ComputeStage,
    pub power: ComputeStage,
}

/// Stages that make links, bound to one set of slots.
pub struct LinkStages {
    pub aim: ComputeStage,
    pub whole: ComputeStage,
    pub links: ComputeStage,
    pub escape: ComputeStage,
    pub received: ComputeStage,
    pub closure: ComputeStage,
    /// None with visibility by rays.
    pub item_buffer: Option<ItemBufferStages>,
}

/// Stages that draw item buffers.
pub struct ItemBufferStages {
    pub kind: Raster,
    pub tessellate: ComputeStage,
    pub raster: wgpu::RenderPipeline,
    pub raster_group: wgpu::BindGroup,
}

impl ShotStages {
    pub fn new(maker: &PipelineMaker, transport: &Transport, b: &SolverBuffers, s: &ShotSlots) -> Result<Self> {
        let choice = [
            Uniform(&s.params),
            Read(&b.patches),
            Read(&b.sums),
            Read(&b.script),
            Read(&b.rows),
            Write(&s.shots),
            Write(&b.log),
            Write(&b.dispatches),
            Read(&b.lost),
        ];
        let deposit = [
            Read(&s.shots),
            Uniform(&s.params),
            Read(&b.texels),
            Read(&b.links),
            Write(&b.radiosity),
            Write(&b.residual),
            Write(&b.irradiance),
            Read(&s.samples),
        ];
        let power = [
            Uniform(&s.params),
            Read(&b.patches),
            Read(&b.texels),
            Read(&b.residual),
            Write(&b.sums),
        ];
        Ok(Self {
            first: maker.make_stage("select", "select_first", &choice)?,
            next: maker.make_stage("select", "select_next", &choice)?,
            link: LinkStages::new(maker, transport, b, s)?,
            deposit: maker.make_stage("deposit", "deposit", &deposit)?,
            power: maker.make_stage("unshot_power", "unshot_power", &power)?,
        })
    }
}

impl LinkStages {
    pub fn new(maker: &PipelineMaker, transport: &Transport, b: &SolverBuffers, s: &ShotSlots) -> Result<Self> {
        let rays = transport.visibility == Visibility::Rays;
        let item_buffer = match transport.visibility {
            Visibility::Rays => None,
            Visibility::ItemBuffer(drawing) => Some(ItemBufferStages::new(maker, &drawing, b, s)?),
        };
        let aimed = [
            Uniform(&s.params),
            Read(&b.faces),
            Read(&b.points),
            Write(&s.shots),
            Write(&s.rectangles),
        ];
        let [escape, received, closure] = closing_stages(maker, b, s)?;
        Ok(Self {
            aim: maker.make_stage("view", "view_sample", &aimed)?,
            whole: maker.make_stage("view", "view_all_faces", &aimed)?,
            links: link_stage(maker, rays, b, s)?,
            escape,
            received,
            closure,
            item_buffer,
        })
    }
}

fn link_stage(maker: &PipelineMaker, rays: bool, b: &SolverBuffers, s: &ShotSlots) -> Result<ComputeStage> {
    let mut slots = vec![
        Read(&b.faces),
        Read(&s.shots),
        Uniform(&s.params),
        Read(&b.texels),
        Read(&b.points),
        Write(&s.samples),
        Write(&b.links),
    ];
    if rays {
        slots.extend([Read(&b.nodes), Read(&b.primitives)]);
    } else {
        // Without objects both bindings are the same texture.
        let room = s.room_buffer.as_ref().unwrap_or(&s.view);
        slots.extend([Texture(&s.view), Texture(room)]);
    }
    maker.make_stage("link", "link_texel", &slots)
}

fn closing_stages(maker: &PipelineMaker, b: &SolverBuffers, s: &ShotSlots) -> Result<[ComputeStage; 3]> {
    let escape = [
        Read(&b.faces),
        Read(&s.shots),
        Uniform(&s.params),
        Read(&b.directions),
        Write(&b.lost),
        Read(&b.points),
        Read(&b.nodes),
        Read(&b.primitives),
    ];
    let received = [
        Uniform(&s.params),
        Read(&b.patches),
        Read(&b.texels),
        Read(&b.links),
        Read(&s.shots),
        Write(&s.transfers),
    ];
    let closure = [
        Uniform(&s.params),
        Read(&s.transfers),
        Write(&b.lost),
        Write(&b.rows),
        Write(&s.shots),
    ];
    Ok([
        maker.make_stage("escape", "escaped_share", &escape)?,
        maker.make_stage("patch_transfer", "patch_transfer", &received)?,
        maker.make_stage("closure", "sum_form_factors", &closure)?,
    ])
}

impl ItemBufferStages {
    fn new(maker: &PipelineMaker, drawing: &ItemBufferSettings, b: &SolverBuffers, s: &ShotSlots) -> Result<Self> {
        let kind = drawing.projection.raster_method();
        let seen = [Read(&b.faces), Read(&s.shots), Uniform(&s.params)];
        let (raster, raster_group) = maker.make_raster(kind, &seen)?;
        let lists = [
            Read(&b.faces),
            Read(&s.shots),
            Uniform(&s.params),
            Write(&s.instances),
            Write(&s.draws),
        ];
        Ok(Self {
            kind,
            tessellate: maker.make_stage("tessellate", "tessellate", &lists)?,
            raster,
            raster_group,
        })
    }
}
