//! The CPU's [`Linker`]: refines tasks of blocks in parallel, by shafts or by rays alone.

use crate::hierarchy::block::ReceiverBlock;
use crate::hierarchy::coarse::StoredLink;
use crate::hierarchy::linker::{BlockIrradiance, LinkRequest, Linker, LinkerScene};
use crate::hierarchy::refine::{CreatedLink, Refiner};
use crate::rows::receivers::LANE_COUNT;
use common::passes::ProgressCallback;
use common::{Error, Result};
use rayon::prelude::*;

/// Tasks between two calls of the progress callback.
const TASKS_PER_CHECK: usize = 256;

/// Links on the CPU.
pub struct CpuLinker<'a> {
    /// The scene.
    pub scene: LinkerScene<'a>,
    /// Uses rays alone, without shafts.
    pub rays_only: bool,
}

impl Linker for CpuLinker<'_> {
    fn gather_irradiance(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<BlockIrradiance>> {
        self.run_tasks(request, watch, |blocks| {
            let dark = BlockIrradiance {
                sums: [[0.0; LANE_COUNT]; 3],
                crosses_shadow_edge: false,
            };
            let mut lit = vec![dark; blocks.len()];
            self.link_blocks(request, blocks, |created| {
                let own = &mut lit[created.block];
                let radiosity = &request.radiosity[created.node as usize];
                created.link.add_irradiance(radiosity, &mut own.sums);
                own.crosses_shadow_edge |= created.crosses_shadow_edge;
            });
            lit
        })
    }

    fn create_links(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<Vec<StoredLink>>> {
        self.run_tasks(request, watch, |blocks| {
            let mut links: Vec<Vec<StoredLink>> = blocks.iter().map(|_| Vec::new()).collect();
            self.link_blocks(request, blocks, |created| {
                links[created.block].push(StoredLink {
                    node: created.node,
                    link: created.link.clone(),
                });
            });
            links
        })
    }
}

impl CpuLinker<'_> {
    fn link_blocks(&self, request: &LinkRequest, blocks: &[ReceiverBlock], take: impl FnMut(CreatedLink)) {
        let refiner = Refiner::new(&self.scene, request, blocks);
        match self.rays_only {
            true => refiner.link_by_rays(take),
            false => refiner.link_by_shafts(take),
        }
    }

    /// Runs `task` on all blocks and returns its results in order.
    fn run_tasks<T: Send>(
        &self,
        request: &LinkRequest,
        watch: ProgressCallback,
        task: impl Fn(&[ReceiverBlock]) -> Vec<T> + Sync,
    ) -> Result<Vec<T>> {
        let receivers = request.receivers;
        let mut all = Vec::with_capacity(receivers.blocks.len());
        for tasks in receivers.tasks.chunks(TASKS_PER_CHECK) {
            if watch(request.progress_of(all.len())).is_break() {
                return Err(Error::Interrupted);
            }
            let parts = tasks.par_iter().map(|blocks| task(&receivers.blocks[blocks.clone()]));
            all.extend(parts.collect::<Vec<_>>().into_iter().flatten());
        }
        Ok(all)
    }
}
