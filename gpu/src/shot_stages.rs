//! Compute and raster stages of a shot. The solver records them shot by shot.

use crate::compute_stage::{ComputeStage, PipelineMaker};
use crate::shot_slots::ShotSlots;
use crate::solver_buffers::SolverBuffers;
use common::Result;

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
    /// Pipeline that draws item buffers, and its bind group; none with visibility by rays.
    pub item_buffer: Option<(wgpu::RenderPipeline, wgpu::BindGroup)>,
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
        let item_buffer = drawing.map(|drawing| maker.make_raster(drawing.projection, &table));
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
