//! Compute and raster stages of a shot.

use crate::bindings::BindingTable;
use crate::compute_stage::{ComputeStage, PipelineMaker};
use crate::shot_slots::ShotSlots;
use crate::solver_buffers::SolverBuffers;
use common::Result;
use common::settings::Raster;

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
    pub fn new(maker: &PipelineMaker, buffers: &SolverBuffers, slots: &ShotSlots) -> Result<Self> {
        // `sums` are the unshot power of patches here, and those over a texel's samples in the deposit.
        let table = slots
            .table
            .joined_with(&buffers.table)
            .with("shot", &slots.table["shots"]);
        let deposit = table.with("sums", &slots.table["sums"]);
        Ok(Self {
            first: maker.make_stage("select", "select_first", &table)?,
            next: maker.make_stage("select", "select_next", &table)?,
            link: LinkStages::new(maker, buffers, slots)?,
            deposit: maker.make_stage("deposit", "deposit", &deposit)?,
            power: maker.make_stage("unshot_power", "unshot_power", &table)?,
        })
    }
}

impl LinkStages {
    pub fn new(maker: &PipelineMaker, buffers: &SolverBuffers, slots: &ShotSlots) -> Result<Self> {
        let table = buffers.table.joined_with(&slots.table);
        let drawing = maker.transport.visibility.item_buffer();
        let item_buffer =
            drawing.map(|drawing| ItemBufferStages::new(maker, drawing.projection.raster_method(), &table));
        Ok(Self {
            aim: maker.make_stage("view", "view_sample", &table)?,
            whole: maker.make_stage("view", "view_all_faces", &table)?,
            links: maker.make_stage("link", "link_texel", &table)?,
            escape: maker.make_stage("escape", "escaped_share", &table)?,
            received: maker.make_stage("patch_transfer", "patch_transfer", &table)?,
            closure: maker.make_stage("closure", "sum_form_factors", &table)?,
            item_buffer: item_buffer.transpose()?,
        })
    }
}

impl ItemBufferStages {
    fn new(maker: &PipelineMaker, kind: Raster, table: &BindingTable) -> Result<Self> {
        let (raster, raster_group) = maker.make_raster(kind, table)?;
        Ok(Self {
            kind,
            tessellate: maker.make_stage("tessellate", "tessellate", table)?,
            raster,
            raster_group,
        })
    }
}
