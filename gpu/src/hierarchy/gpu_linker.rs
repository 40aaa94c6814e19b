//! The linker on the GPU: batches of blocks, each with all levels in one submission.

use crate::adapter::Gpu;
use crate::compute_stage::PipelineMaker;
use crate::device_queue::DeviceQueue;
use crate::hierarchy::level_stages::LevelStages;
use crate::hierarchy::link_buffers::{LinkBuffers, MAX_BATCH_BLOCKS, MAX_BATCH_LINKS, MAX_LEVEL_PAIRS};
use crate::link_records::{
    BLOCK_SPOTS, BlockReceiver, BlockRecord, DeviceLink, PairRecord, RadiosityRecord, RequestRecord, SpotIrradiance,
    SpotRecord,
};
use crate::records::ShotRecord;
use crate::shaders::ShaderFault;
use bytemuck::{Zeroable, pod_collect_to_vec};
use common::constants::{PATCH_SUM_LANES, ROOTS_PER_BATCH};
use common::mesh::Mesh;
use common::settings::Transport;
use common::{Error, Result};
use glam::Vec3;
use std::ops::ControlFlow;

/// Progress callback, called with the number of blocks done; may break.
pub type BlockProgress<'a> = &'a mut dyn FnMut(usize) -> ControlFlow<()>;

/// Bytes of the totals of a batch.
const TOTALS_BYTES: u64 = 16;

/// Links the nodes of a tree to blocks of receivers.
pub struct GpuLinker {
    host: DeviceQueue,
    buffers: LinkBuffers,
    /// Stages of even levels and of odd ones.
    stages: [LevelStages; 2],
    roots: Vec<u32>,
    nodes: usize,
    levels: u32,
    /// Thresholds of refinement.
    request: RequestRecord,
    /// Blocks of the next batch.
    batch_blocks: usize,
}

/// Result of a batch.
struct BatchResult {
    links: u32,
    /// Most pairs of a level; none where they did not fit.
    pairs: Option<u32>,
    bytes: Vec<u8>,
}

impl GpuLinker {
    /// Creates a linker for the `nodes` over the faces of `mesh`, the tree of each face from its root; `faults`
    /// are planted in its shaders.
    ///
    /// Errors: [`Error::Device`] where the nodes do not fit.
    pub fn new(gpu: &Gpu, mesh: &Mesh, nodes: &[ShotRecord], roots: &[u32], faults: &[ShaderFault]) -> Result<Self> {
        let buffers = LinkBuffers::new(gpu, mesh, nodes)?;
        let maker = PipelineMaker::new(gpu, &Transport::default(), faults);
        let stages = [
            LevelStages::new(&maker, &buffers, 0)?,
            LevelStages::new(&maker, &buffers, 1)?,
        ];
        gpu.check_errors()?;
        Ok(Self {
            host: DeviceQueue::new(gpu),
            buffers,
            stages,
            roots: roots.to_vec(),
            nodes: nodes.len(),
            levels: count_levels(nodes),
            request: RequestRecord::zeroed(),
            batch_blocks: 64,
        })
    }

    /// Sets the radiosity of the nodes, and the largest errors of links over the RMS of the reflected light: from the
    /// variation of a node's radiosity, from partial visibility, and from the size of a spot; and the change at a shadow's
    /// edge that is followed.
    pub fn set_light(&mut self, radiosity: &[RadiosityRecord], [source, visibility, near, edge]: [f32; 4]) {
        self.host.write(&self.buffers.table["radiosity"], radiosity);
        self.request = RequestRecord {
            source,
            visibility,
            near,
            edge,
            ..RequestRecord::zeroed()
        };
    }

    /// Returns the irradiance at each block's spots.
    ///
    /// Errors: [`Error::Interrupted`], [`Error::Device`].
    pub fn gather_light(&mut self, blocks: &[BlockReceiver], watch: BlockProgress) -> Result<Vec<SpotIrradiance>> {
        let mut found = Vec::with_capacity(blocks.len());
        self.process_blocks(blocks, false, watch, &mut |_, _, bytes| {
            let sums: Vec<[f32; 4]> = pod_collect_to_vec(bytes);
            let (own, _) = sums.as_chunks::<{ BLOCK_SPOTS as usize }>();
            found.extend(own.iter().map(|sums| SpotIrradiance {
                sums: sums.map(|[x, y, z, _]| Vec3::new(x, y, z)),
                edge: sums.iter().any(|sum| sum[3] > 0.0),
            }));
        })?;
        Ok(found)
    }

    /// Returns each block's links.
    ///
    /// Errors: [`Error::Interrupted`], [`Error::Device`].
    pub fn make_links(&mut self, blocks: &[BlockReceiver], watch: BlockProgress) -> Result<Vec<Vec<DeviceLink>>> {
        let mut found: Vec<Vec<DeviceLink>> = blocks.iter().map(|_| Vec::new()).collect();
        let nodes = self.nodes;
        let mut wrong_end = None;
        self.process_blocks(blocks, true, watch, &mut |first, batch, bytes| {
            let count = bytes.len() / (8 + 16 * BLOCK_SPOTS as usize);
            let (ends, links) = bytes.split_at(8 * count);
            let ends: Vec<[u32; 2]> = pod_collect_to_vec(ends);
            let links: Vec<[f32; 4]> = pod_collect_to_vec(links);
            let (links, _) = links.as_chunks::<{ BLOCK_SPOTS as usize }>();
            for ([block, node], link) in ends.into_iter().zip(links) {
                if block as usize >= batch || node as usize >= nodes {
                    wrong_end = Some([block, node]);
                    continue;
                }
                found[first + block as usize].push(DeviceLink {
                    node,
                    spots: link.map(|[w, x, y, _]| [w, x, y]),
                });
            }
        })?;
        match wrong_end {
            Some([block, node]) => {
                let text = format!("a link joins block {block} and node {node}: there is no such block or node");
                Err(self.host.gpu.stage_error("store_links", &text))
            }
            None => Ok(found),
        }
    }

    /// Processes all blocks, in batches whose pairs fit. `take` receives the first block of a batch, the number
    /// of its blocks, and the bytes read back: irradiance, or links.
    fn process_blocks(
        &mut self,
        blocks: &[BlockReceiver],
        keep: bool,
        watch: BlockProgress,
        take: &mut dyn FnMut(usize, usize, &[u8]),
    ) -> Result<()> {
        let mut done = 0;
        while done < blocks.len() {
            if watch(done).is_break() {
                return Err(Error::Interrupted);
            }
            let fit = MAX_LEVEL_PAIRS as usize / self.roots.len().clamp(1, ROOTS_PER_BATCH);
            let most = self.batch_blocks.min(fit).clamp(1, MAX_BATCH_BLOCKS as usize);
            let batch = &blocks[done..blocks.len().min(done + most)];
            let Some(found) = self.process_batch(batch, keep)? else {
                if batch.len() == 1 {
                    let text = "more pairs at one block than fit: let the CPU solve it";
                    return Err(self.host.gpu.device_error(text));
                }
                self.batch_blocks = (batch.len() / 2).max(1);
                continue;
            };
            for bytes in &found {
                take(done, batch.len(), bytes);
            }
            done += batch.len();
        }
        Ok(())
    }

    /// Returns the blocks' irradiance, or their links, a vector for each part of the faces; none where pairs did
    /// not fit.
    fn process_batch(&mut self, blocks: &[BlockReceiver], keep: bool) -> Result<Option<Vec<Vec<u8>>>> {
        self.write_blocks(blocks);
        let mut found = Vec::new();
        let mut most = 1;
        let roots = self.roots.clone();
        for roots in roots.chunks(ROOTS_PER_BATCH) {
            let own = self.process_roots(blocks.len(), roots, keep)?;
            let Some(pairs) = own.pairs else {
                return Ok(None);
            };
            most = most.max(pairs).max(own.links * u32::from(keep));
            match keep {
                true => found.push(self.read_links(own.links)?),
                false => found = vec![own.bytes],
            }
        }
        // Three quarters of what fits: the next blocks may need more.
        let room = u64::from(MAX_LEVEL_PAIRS.min(MAX_BATCH_LINKS)) * 3 / 4;
        self.batch_blocks = (blocks.len() as u64 * room / u64::from(most)).max(1) as usize;
        Ok(Some(found))
    }

    fn write_blocks(&self, blocks: &[BlockReceiver]) {
        let (host, table) = (&self.host, &self.buffers.table);
        let spots: Vec<SpotRecord> = blocks.iter().flat_map(|block| block.spots).collect();
        let records: Vec<BlockRecord> = blocks.iter().map(|block| block.block).collect();
        host.write(&table["spots"], &spots);
        host.write(&table["blocks"], &records);
        host.write(&table["sums"], &vec![[0.0f32; 4]; spots.len()]);
    }

    /// Refines all levels below `roots`.
    fn process_roots(&mut self, blocks: usize, roots: &[u32], keep: bool) -> Result<BatchResult> {
        let (table, first) = (&self.buffers.table, &self.buffers.levels[0]);
        let pairs: Vec<PairRecord> = (0..blocks as u32)
            .flat_map(|block| roots.iter().map(move |node| PairRecord::new(block, *node)))
            .collect();
        let count = pairs.len() as u32;
        let of = roots.len() as u32;
        let ranges: Vec<[u32; 2]> = (0..blocks as u32).map(|k| [k * of, (k + 1) * of]).collect();
        let groups = |threads: u32| threads.div_ceil(PATCH_SUM_LANES as u32);
        let request = RequestRecord {
            blocks: blocks as u32,
            pairs: MAX_LEVEL_PAIRS,
            links: if keep { MAX_BATCH_LINKS } else { u32::MAX },
            ..self.request
        };
        self.host.write(&table["request"], &[request]);
        self.host.write(&table["totals"], &[0, 0, count, 0]);
        self.host.write(&first["pairs"], &pairs);
        self.host.write(&first["ranges"], &ranges);
        self.host.write(&first["counts"], &[count, 0, 0, 0]);
        let arguments = [groups(count * BLOCK_SPOTS), 1, 1, groups(count), 1, 1, 0, 0];
        self.host.write(&first["dispatches"], &arguments);
        let spots = (!keep).then(|| self.host.split_workgroups(groups(blocks as u32 * BLOCK_SPOTS) as usize));
        let mut encoder = self.host.command_encoder();
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for level in 0..self.levels {
            self.stages[level as usize % 2].record_level(&mut pass, spots);
        }
        drop(pass);
        let mut ranges = vec![(&table["totals"], 0, TOTALS_BYTES)];
        if !keep {
            ranges.push((&table["sums"], 0, 16 * u64::from(BLOCK_SPOTS) * blocks as u64));
        }
        let mut bytes = self.host.read_back(encoder, &ranges)?;
        let rest = bytes.split_off(TOTALS_BYTES as usize);
        let totals: Vec<u32> = pod_collect_to_vec(&bytes);
        if keep && totals[1] == 0 && totals[0] > MAX_BATCH_LINKS {
            let text = format!("{} links are counted where {MAX_BATCH_LINKS} fit", totals[0]);
            return Err(self.host.gpu.stage_error("prefix_sum", &text));
        }
        Ok(BatchResult {
            links: totals[0],
            pairs: (totals[1] == 0).then_some(totals[2]),
            bytes: rest,
        })
    }

    /// Reads ends and spots of the first `count` links.
    fn read_links(&mut self, count: u32) -> Result<Vec<u8>> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let table = &self.buffers.table;
        let ends = (&table["ends"], 0, 8 * u64::from(count));
        let links = (&table["links"], 0, 16 * u64::from(BLOCK_SPOTS * count));
        self.host.read_back(self.host.command_encoder(), &[ends, links])
    }
}

/// Returns the number of levels from a root to the deepest leaf.
fn count_levels(nodes: &[ShotRecord]) -> u32 {
    let mut level = vec![1; nodes.len()];
    for (k, node) in nodes.iter().enumerate() {
        for child in node.first..node.first + node.count {
            level[child as usize] = level[k] + 1;
        }
    }
    level.into_iter().max().unwrap_or(0)
}
