//! Finds links: in batches of blocks, each with all levels in one submission.

use crate::adapter::Gpu;
use crate::hierarchy::buffers::{BLOCKS, Buffers, LINKS, PAIRS};
use crate::hierarchy::stages::Stages;
use crate::host::Host;
use crate::linked::{
    AskedRecord, BlockRecord, GlowRecord, Link, Node, PairRecord, Received, Receiver, SPOTS,
    SpotRecord, Thresholds,
};
use crate::shaders::Fault;
use crate::stage::PipelineMaker;
use bytemuck::pod_collect_to_vec;
use common::constants::{LANES, ROOTS};
use common::mesh::Mesh;
use common::settings::Transport;
use common::{Error, Result};
use glam::Vec3;
use std::ops::ControlFlow;

/// Told after how many blocks it is.
pub type Watch<'a> = &'a mut dyn FnMut(usize) -> ControlFlow<()>;

/// Bytes of the sums over a batch.
const TOTALS: u64 = 16;

/// Finds the links from a tree's nodes.
pub struct Finder {
    host: Host,
    buffers: Buffers,
    /// Of even levels and of odd ones.
    stages: [Stages; 2],
    roots: Vec<u32>,
    levels: u32,
    thresholds: Thresholds,
    /// Blocks that are tried at once.
    some: usize,
}

/// What a batch came to.
struct Batch {
    links: u32,
    /// Most pairs of a level; none: there was no room for them.
    pairs: Option<u32>,
    bytes: Vec<u8>,
}

impl Finder {
    /// From the `nodes` over the faces of `mesh`, each face's from its root; shaders are wrong where
    /// `faults` say so.
    ///
    /// Errors: a device that has no room.
    pub fn new(
        gpu: &Gpu,
        mesh: &Mesh,
        nodes: &[Node],
        roots: &[u32],
        faults: &[Fault],
    ) -> Result<Self> {
        let buffers = Buffers::new(gpu, mesh, nodes)?;
        let maker = PipelineMaker::new(gpu, &Transport::default(), faults);
        let stages = [
            Stages::new(&maker, &buffers, 0)?,
            Stages::new(&maker, &buffers, 1)?,
        ];
        gpu.check()?;
        Ok(Self {
            host: Host::new(gpu),
            buffers,
            stages,
            roots: roots.to_vec(),
            levels: levels(nodes),
            thresholds: Thresholds {
                source: 0.0,
                visibility: 0.0,
                near: 0.0,
            },
            some: 64,
        })
    }

    /// What the nodes shine, and what may be left out of it, from now on.
    pub fn tell(&mut self, glows: &[GlowRecord], thresholds: Thresholds) {
        self.host.write(&self.buffers.glows, glows);
        self.thresholds = thresholds;
    }

    /// What arrives at each block's spots.
    ///
    /// Errors: [`Error::Interrupted`], [`Error::Device`].
    pub fn gathered(&mut self, blocks: &[Receiver], watch: Watch) -> Result<Vec<Received>> {
        let mut found = Vec::with_capacity(blocks.len());
        self.batches(blocks, false, watch, &mut |_, bytes| {
            let sums: Vec<[f32; 4]> = pod_collect_to_vec(bytes);
            let (own, _) = sums.as_chunks::<{ SPOTS as usize }>();
            found.extend(own.iter().map(|sums| Received {
                sums: sums.map(|[x, y, z, _]| Vec3::new(x, y, z)),
                edge: sums.iter().any(|sum| sum[3] > 0.0),
            }));
        })?;
        Ok(found)
    }

    /// Each block's links.
    ///
    /// Errors: [`Error::Interrupted`], [`Error::Device`].
    pub fn kept(&mut self, blocks: &[Receiver], watch: Watch) -> Result<Vec<Vec<Link>>> {
        let mut found: Vec<Vec<Link>> = blocks.iter().map(|_| Vec::new()).collect();
        self.batches(blocks, true, watch, &mut |first, bytes| {
            let count = bytes.len() / (8 + 16 * SPOTS as usize);
            let (ends, links) = bytes.split_at(8 * count);
            let ends: Vec<[u32; 2]> = pod_collect_to_vec(ends);
            let links: Vec<[f32; 4]> = pod_collect_to_vec(links);
            let (links, _) = links.as_chunks::<{ SPOTS as usize }>();
            for ([block, node], link) in ends.into_iter().zip(links) {
                found[first + block as usize].push(Link {
                    node,
                    spots: link.map(|[w, x, y, _]| [w, x, y]),
                });
            }
        })?;
        Ok(found)
    }

    /// All blocks, as many at once as there is room for their pairs; `take` sees from which block on, and
    /// what is read back: sums, or some of the links.
    fn batches(
        &mut self,
        blocks: &[Receiver],
        keep: bool,
        watch: Watch,
        take: &mut dyn FnMut(usize, &[u8]),
    ) -> Result<()> {
        let mut done = 0;
        while done < blocks.len() {
            if watch(done).is_break() {
                return Err(Error::Interrupted);
            }
            let fit = PAIRS as usize / self.roots.len().clamp(1, ROOTS);
            let most = self.some.min(fit).clamp(1, BLOCKS as usize);
            let some = &blocks[done..blocks.len().min(done + most)];
            let Some(found) = self.batch(some, keep)? else {
                if some.len() == 1 {
                    let text =
                        "more pairs at one block than there is room for: let the CPU solve it";
                    return Err(self.host.gpu.fail(text));
                }
                self.some = (some.len() / 2).max(1);
                continue;
            };
            for bytes in &found {
                take(done, bytes);
            }
            done += some.len();
        }
        Ok(())
    }

    /// What the blocks' links send, or the links of one part of the faces after the other; none where
    /// there was no room.
    fn batch(&mut self, blocks: &[Receiver], keep: bool) -> Result<Option<Vec<Vec<u8>>>> {
        self.prepare(blocks);
        let mut found = Vec::new();
        let mut most = 1;
        let roots = self.roots.clone();
        for roots in roots.chunks(ROOTS) {
            let own = self.levels(blocks.len(), roots, keep)?;
            let Some(pairs) = own.pairs else {
                return Ok(None);
            };
            most = most.max(pairs).max(own.links * u32::from(keep));
            match keep {
                true => found.push(self.links(own.links)?),
                false => found = vec![own.bytes],
            }
        }
        // Three quarters of the room: the next blocks may need more.
        let room = u64::from(PAIRS.min(LINKS)) * 3 / 4;
        self.some = (blocks.len() as u64 * room / u64::from(most)).max(1) as usize;
        Ok(Some(found))
    }

    fn prepare(&self, blocks: &[Receiver]) {
        let (host, b) = (&self.host, &self.buffers);
        let spots: Vec<SpotRecord> = blocks.iter().flat_map(|block| block.spots).collect();
        let records: Vec<BlockRecord> = blocks.iter().map(|block| block.block).collect();
        host.write(&b.spots, &spots);
        host.write(&b.blocks, &records);
        host.write(&b.sums, &vec![[0.0f32; 4]; spots.len()]);
        let asked = AskedRecord {
            source: self.thresholds.source,
            visibility: self.thresholds.visibility,
            near: self.thresholds.near,
            blocks: blocks.len() as u32,
            pairs: PAIRS,
            links: 0,
            pad: [0; 2],
        };
        host.write(&b.asked, &[asked]);
    }

    /// All levels below `roots`.
    fn levels(&mut self, blocks: usize, roots: &[u32], keep: bool) -> Result<Batch> {
        let b = &self.buffers;
        let pairs: Vec<PairRecord> = (0..blocks as u32)
            .flat_map(|block| roots.iter().map(move |node| PairRecord::new(block, *node)))
            .collect();
        let count = pairs.len() as u32;
        let of = roots.len() as u32;
        let ranges: Vec<[u32; 2]> = (0..blocks as u32).map(|k| [k * of, (k + 1) * of]).collect();
        let groups = |threads: u32| threads.div_ceil(LANES as u32);
        let links = if keep { LINKS } else { u32::MAX };
        self.host.write(&b.pairs[0], &pairs);
        self.host.write(&b.ranges[0], &ranges);
        self.host.write(&b.counts[0], &[count, 0, 0, 0]);
        self.host.write(&b.totals, &[0, 0, count, 0]);
        let arguments = [groups(count * SPOTS), 1, 1, groups(count), 1, 1, 0, 0];
        self.host.write(&b.dispatches[0], &arguments);
        self.host.write_at(&b.asked, 20, &[links]);
        let spots = (!keep).then(|| self.host.groups(groups(blocks as u32 * SPOTS) as usize));
        let mut encoder = self.host.encoder();
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for level in 0..self.levels {
            self.stages[level as usize % 2].record(&mut pass, spots);
        }
        drop(pass);
        let sums = if keep {
            0
        } else {
            16 * u64::from(SPOTS) * blocks as u64
        };
        let staging = self.host.staging(TOTALS + sums);
        encoder.copy_buffer_to_buffer(&b.totals, 0, &staging, 0, TOTALS);
        if sums > 0 {
            encoder.copy_buffer_to_buffer(&b.sums, 0, &staging, TOTALS, sums);
        }
        let mut bytes = self.host.finish(encoder, staging)?;
        let rest = bytes.split_off(TOTALS as usize);
        let totals: Vec<u32> = pod_collect_to_vec(&bytes);
        Ok(Batch {
            links: totals[0],
            pairs: (totals[1] == 0).then_some(totals[2]),
            bytes: rest,
        })
    }

    /// Ends and spots of the first so many links.
    fn links(&mut self, count: u32) -> Result<Vec<u8>> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let (ends, links) = (8 * u64::from(count), 16 * u64::from(SPOTS * count));
        let staging = self.host.staging(ends + links);
        let mut encoder = self.host.encoder();
        encoder.copy_buffer_to_buffer(&self.buffers.ends, 0, &staging, 0, ends);
        encoder.copy_buffer_to_buffer(&self.buffers.links, 0, &staging, ends, links);
        self.host.finish(encoder, staging)
    }
}

/// From a root to the farthest leaf.
fn levels(nodes: &[Node]) -> u32 {
    let mut level = vec![1; nodes.len()];
    for (k, node) in nodes.iter().enumerate() {
        for child in node.children.clone() {
            level[child as usize] = level[k] + 1;
        }
    }
    level.into_iter().max().unwrap_or(0)
}
