//! Dispatches of one level of refinement.

use crate::compute_stage::{ComputeStage, PipelineMaker};
use crate::hierarchy::link_buffers::{LinkBuffers, WORK_LISTS};
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
    steps: Vec<RefinementStep>,
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

/// Declaration of a step: its work list and the workgroups over its spots, its entry point, and shader and entry
/// points of its stages over spots.
struct StepEntries {
    lists: [&'static str; 2],
    refine: &'static str,
    shader: &'static str,
    spot_stages: &'static [&'static str],
}

const REFINEMENT_STEPS: [StepEntries; 4] = [
    StepEntries {
        lists: WORK_LISTS[0],
        refine: "refine_by_source",
        shader: "link_factors",
        spot_stages: &["unclipped_factors", "clipped_factors"],
    },
    StepEntries {
        lists: WORK_LISTS[1],
        refine: "start_sampling",
        shader: "sample_links",
        spot_stages: &["sample_links"],
    },
    StepEntries {
        lists: WORK_LISTS[2],
        refine: "request_samples",
        shader: "sample_links",
        spot_stages: &["sample_links"],
    },
    StepEntries {
        lists: WORK_LISTS[3],
        refine: "refine_by_visibility",
        shader: "sample_links",
        spot_stages: &["sample_links"],
    },
];

impl LevelStages {
    /// Creates the stages of even levels, or of odd ones.
    pub fn new(maker: &PipelineMaker, buffers: &LinkBuffers, parity: usize) -> Result<Self> {
        let (own, next) = (&buffers.levels[parity], &buffers.levels[1 - parity]);
        let table = buffers.table.joined_with(own);
        let counted = table
            .with("next", &next["counts"])
            .with("dispatches", &next["dispatches"]);
        let subdivided = table.with("next", &next["pairs"]);
        let added = table.with("next", &next["ranges"]);
        let step = |step: &StepEntries| -> Result<RefinementStep> {
            let [work, dispatches] = step.lists.map(|name| &table[name]);
            let table = table.with("work", work).with("dispatches", dispatches);
            let over_spots = |entry: &&'static str| maker.make_stage(step.shader, entry, &table);
            Ok(RefinementStep {
                refine: maker.make_stage("refine", step.refine, &table)?,
                spot_stages: step.spot_stages.iter().map(over_spots).collect::<Result<_>>()?,
                dispatches: dispatches.clone(),
            })
        };
        Ok(Self {
            clear_lists: maker.make_stage("clear_work_lists", "clear_work_lists", &table)?,
            bounds: maker.make_stage("link_bounds", "bound_links", &table)?,
            steps: REFINEMENT_STEPS.iter().map(step).collect::<Result<_>>()?,
            prefix_sum: maker.make_stage("prefix_sum", "prefix_sum", &counted)?,
            subdivide: maker.make_stage("subdivide_nodes", "subdivide_nodes", &subdivided)?,
            add_links: maker.make_stage("add_links", "add_irradiance", &added)?,
            store_links: maker.make_stage("store_links", "store_links", &table)?,
            dispatches: own["dispatches"].clone(),
        })
    }

    /// Records one level: its links, and the next one's pairs. `spots` are workgroups over all spots where
    /// irradiance is summed, none where links are kept.
    pub fn record_level(&self, pass: &mut wgpu::ComputePass, spots: Option<[u32; 3]>) {
        let counts = &self.dispatches;
        self.clear_lists.dispatch_groups(pass, [1, 1, 1]);
        self.bounds.dispatch_counted(pass, counts, SPOT_ARGUMENTS_OFFSET);
        for step in &self.steps {
            step.refine.dispatch_counted(pass, counts, PAIR_ARGUMENTS_OFFSET);
            for (stage, at) in step.spot_stages.iter().zip([0, 12]) {
                stage.dispatch_counted(pass, &step.dispatches, at);
            }
        }
        self.prefix_sum.dispatch_groups(pass, [1, 1, 1]);
        self.subdivide.dispatch_counted(pass, counts, PAIR_ARGUMENTS_OFFSET);
        match spots {
            Some(groups) => self.add_links.dispatch_groups(pass, groups),
            None => self.store_links.dispatch_counted(pass, counts, SPOT_ARGUMENTS_OFFSET),
        }
    }
}
