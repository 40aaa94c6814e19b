//! Dispatches of one level of refinement.

use crate::compute_stage::BindingSlot::{self, Read, Uniform, Write};
use crate::compute_stage::{ComputeStage, PipelineMaker};
use crate::hierarchy::link_buffers::LinkBuffers;
use crate::link_recorder::bind_stage;
use common::Result;

/// Byte offset of a level's dispatch arguments for a thread per spot.
const SPOT_ARGUMENTS_OFFSET: u64 = 0;
/// Byte offset of those for a thread per pair.
const PAIR_ARGUMENTS_OFFSET: u64 = 12;

/// Stages of the levels of one parity.
pub struct LevelStages {
    clear_lists: ComputeStage,
    bounds: ComputeStage,
    /// The four steps of refinement, each with the stages that its work lists run.
    steps: [RefinementStep; 4],
    prefix_sum: ComputeStage,
    subdivide: ComputeStage,
    add_links: ComputeStage,
    store_links: ComputeStage,
    dispatches: wgpu::Buffer,
}

/// A step of refinement, and the stages over the spots of its work lists: front, then end.
struct RefinementStep {
    refine: ComputeStage,
    spot_stages: Vec<ComputeStage>,
    dispatches: wgpu::Buffer,
}

/// Entry points of the steps, in their order.
const REFINEMENT_ENTRIES: [&str; 4] = [
    "refine_by_source",
    "start_sampling",
    "request_samples",
    "refine_by_visibility",
];

impl LevelStages {
    /// Creates the stages of even levels, or of odd ones.
    pub fn new(maker: &PipelineMaker, b: &LinkBuffers, parity: usize) -> Result<Self> {
        let next = 1 - parity;
        let (pairs, counts) = (&b.pairs[parity], &b.counts[parity]);
        let mut lists: Vec<BindingSlot> = b.work.iter().map(Write).collect();
        lists.extend(b.work_dispatches.iter().map(Write));
        let bounds = [
            Read(&b.shots),
            Read(&b.spots),
            Read(&b.blocks),
            Read(pairs),
            Write(&b.lanes),
            Read(counts),
        ];
        let [source, start, request, visibility] = [0, 1, 2, 3].map(|n| refinement_step(maker, b, parity, n));
        let prefix_sum = [
            Read(&b.shots),
            Uniform(&b.request),
            Read(pairs),
            Read(counts),
            Write(&b.counts[next]),
            Write(&b.offsets),
            Write(&b.totals),
            Write(&b.dispatches[next]),
        ];
        let subdivide = [
            Read(&b.shots),
            Read(pairs),
            Read(counts),
            Read(&b.offsets),
            Read(&b.totals),
            Write(&b.pairs[next]),
        ];
        let add_links = [
            Uniform(&b.request),
            Read(&b.radiosity),
            Read(pairs),
            Read(&b.lanes),
            Read(&b.offsets),
            Read(&b.ranges[parity]),
            Write(&b.ranges[next]),
            Write(&b.sums),
            Read(&b.totals),
        ];
        let store_links = [
            Read(pairs),
            Read(&b.lanes),
            Read(counts),
            Read(&b.offsets),
            Read(&b.totals),
            Write(&b.ends),
            Write(&b.links),
        ];
        Ok(Self {
            clear_lists: maker.make_stage("clear_work_lists", "clear_work_lists", &lists)?,
            bounds: maker.make_stage("link_bounds", "bound_links", &bounds)?,
            steps: [source?, start?, request?, visibility?],
            prefix_sum: maker.make_stage("prefix_sum", "prefix_sum", &prefix_sum)?,
            subdivide: maker.make_stage("subdivide_nodes", "subdivide_nodes", &subdivide)?,
            add_links: maker.make_stage("add_links", "add_irradiance", &add_links)?,
            store_links: maker.make_stage("store_links", "store_links", &store_links)?,
            dispatches: b.dispatches[parity].clone(),
        })
    }

    /// Records one level: its links, and the next one's pairs. `spots` are workgroups over all spots where
    /// irradiance is summed, none where links are kept.
    pub fn record_level(&self, pass: &mut wgpu::ComputePass, spots: Option<[u32; 4]>) {
        bind_stage(pass, &self.clear_lists);
        pass.dispatch_workgroups(1, 1, 1);
        dispatch_indirect(pass, &self.bounds, &self.dispatches, SPOT_ARGUMENTS_OFFSET);
        for step in &self.steps {
            dispatch_indirect(pass, &step.refine, &self.dispatches, PAIR_ARGUMENTS_OFFSET);
            for (stage, at) in step.spot_stages.iter().zip([0, 12]) {
                dispatch_indirect(pass, stage, &step.dispatches, at);
            }
        }
        bind_stage(pass, &self.prefix_sum);
        pass.dispatch_workgroups(1, 1, 1);
        dispatch_indirect(pass, &self.subdivide, &self.dispatches, PAIR_ARGUMENTS_OFFSET);
        match spots {
            Some([x, y, z, _]) => {
                bind_stage(pass, &self.add_links);
                pass.dispatch_workgroups(x, y, z);
            }
            None => dispatch_indirect(pass, &self.store_links, &self.dispatches, SPOT_ARGUMENTS_OFFSET),
        }
    }
}

/// Returns step `number` of refinement, for levels of that parity.
fn refinement_step(maker: &PipelineMaker, b: &LinkBuffers, parity: usize, number: usize) -> Result<RefinementStep> {
    let (pairs, work) = (&b.pairs[parity], &b.work[number]);
    let dispatches = &b.work_dispatches[number];
    let refine = [
        Read(&b.shots),
        Uniform(&b.request),
        Read(&b.radiosity),
        Read(&b.blocks),
        Read(&b.lanes),
        Write(pairs),
        Read(&b.counts[parity]),
        Write(work),
        Write(dispatches),
    ];
    let factors = [
        Read(&b.shots),
        Read(&b.spots),
        Read(&b.blocks),
        Read(pairs),
        Write(&b.lanes),
        Read(work),
    ];
    let sampled = [
        Read(&b.faces),
        Read(&b.shots),
        Uniform(&b.params),
        Read(&b.spots),
        Read(pairs),
        Write(&b.lanes),
        Read(work),
        Read(&b.nodes),
        Read(&b.primitives),
    ];
    let spot_stages = match number {
        0 => vec![
            maker.make_stage("link_factors", "unclipped_factors", &factors)?,
            maker.make_stage("link_factors", "clipped_factors", &factors)?,
        ],
        _ => vec![maker.make_stage("sample_links", "sample_links", &sampled)?],
    };
    Ok(RefinementStep {
        refine: maker.make_stage("refine", REFINEMENT_ENTRIES[number], &refine)?,
        spot_stages,
        dispatches: dispatches.clone(),
    })
}

fn dispatch_indirect(pass: &mut wgpu::ComputePass, stage: &ComputeStage, dispatches: &wgpu::Buffer, at: u64) {
    bind_stage(pass, stage);
    pass.dispatch_workgroups_indirect(dispatches, at);
}
