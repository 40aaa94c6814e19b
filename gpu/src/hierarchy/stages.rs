//! The dispatches of one level.

use crate::hierarchy::buffers::Buffers;
use crate::stage::Slot::{self, Read, Uniform, Write};
use crate::stage::{PipelineMaker, Stage};
use common::Result;

/// Where a level's arguments for a thread per spot lie, and for one per pair.
const LANES: u64 = 0;
/// See [`LANES`].
const PAIRS: u64 = 12;

/// Of levels of one parity.
pub struct Stages {
    reset: Stage,
    bounds: Stage,
    /// The four choices, and what the spots are asked after each.
    choices: [Choice; 4],
    scan: Stage,
    parts: Stage,
    add: Stage,
    pack: Stage,
    dispatches: wgpu::Buffer,
}

/// A choice, and what is asked then of spots: of those at the front of its list, and at the end.
struct Choice {
    choose: Stage,
    asked: Vec<Stage>,
    dispatches: wgpu::Buffer,
}

/// In their order.
const CHOICES: [&str; 4] = ["weigh", "first", "again", "enough"];

impl Stages {
    /// Of even levels, or of odd ones.
    pub fn new(maker: &PipelineMaker, b: &Buffers, parity: usize) -> Result<Self> {
        let next = 1 - parity;
        let (pairs, counts) = (&b.pairs[parity], &b.counts[parity]);
        let mut lists: Vec<Slot> = b.work.iter().map(Write).collect();
        lists.extend(b.work_dispatches.iter().map(Write));
        let bounds = [
            Read(&b.shots),
            Read(&b.spots),
            Read(&b.blocks),
            Read(pairs),
            Write(&b.lanes),
            Read(counts),
        ];
        let [weigh, first, again, enough] = [0, 1, 2, 3].map(|n| choice(maker, b, parity, n));
        let scan = [
            Read(&b.shots),
            Uniform(&b.asked),
            Read(pairs),
            Read(counts),
            Write(&b.counts[next]),
            Write(&b.offsets),
            Write(&b.totals),
            Write(&b.dispatches[next]),
        ];
        let parts = [
            Read(&b.shots),
            Read(pairs),
            Read(counts),
            Read(&b.offsets),
            Read(&b.totals),
            Write(&b.pairs[next]),
        ];
        let add = [
            Uniform(&b.asked),
            Read(&b.glows),
            Read(pairs),
            Read(&b.lanes),
            Read(&b.offsets),
            Read(&b.ranges[parity]),
            Write(&b.ranges[next]),
            Write(&b.sums),
            Read(&b.totals),
        ];
        let pack = [
            Read(pairs),
            Read(&b.lanes),
            Read(counts),
            Read(&b.offsets),
            Read(&b.totals),
            Write(&b.ends),
            Write(&b.links),
        ];
        Ok(Self {
            reset: maker.stage("reset", "reset", &lists)?,
            bounds: maker.stage("bounds", "bounds", &bounds)?,
            choices: [weigh?, first?, again?, enough?],
            scan: maker.stage("scan", "scan", &scan)?,
            parts: maker.stage("parts", "parts", &parts)?,
            add: maker.stage("add", "add", &add)?,
            pack: maker.stage("pack", "pack", &pack)?,
            dispatches: b.dispatches[parity].clone(),
        })
    }

    /// Links of one level, and the next one's pairs; `spots` are workgroups over all spots where what they
    /// receive is added up, none where the links are kept.
    pub fn record(&self, pass: &mut wgpu::ComputePass, spots: Option<[u32; 4]>) {
        bind(pass, &self.reset);
        pass.dispatch_workgroups(1, 1, 1);
        run(pass, &self.bounds, &self.dispatches, LANES);
        for choice in &self.choices {
            run(pass, &choice.choose, &self.dispatches, PAIRS);
            for (stage, at) in choice.asked.iter().zip([0, 12]) {
                run(pass, stage, &choice.dispatches, at);
            }
        }
        bind(pass, &self.scan);
        pass.dispatch_workgroups(1, 1, 1);
        run(pass, &self.parts, &self.dispatches, PAIRS);
        match spots {
            Some([x, y, z, _]) => {
                bind(pass, &self.add);
                pass.dispatch_workgroups(x, y, z);
            }
            None => run(pass, &self.pack, &self.dispatches, LANES),
        }
    }
}

/// One of the four, of levels of that parity.
fn choice(maker: &PipelineMaker, b: &Buffers, parity: usize, number: usize) -> Result<Choice> {
    let (pairs, work) = (&b.pairs[parity], &b.work[number]);
    let dispatches = &b.work_dispatches[number];
    let choose = [
        Read(&b.shots),
        Uniform(&b.asked),
        Read(&b.glows),
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
    let asked = match number {
        0 => vec![
            maker.stage("factors", "plain", &factors)?,
            maker.stage("factors", "clipped", &factors)?,
        ],
        _ => vec![maker.stage("sampled", "sampled", &sampled)?],
    };
    Ok(Choice {
        choose: maker.stage("choose", CHOICES[number], &choose)?,
        asked,
        dispatches: dispatches.clone(),
    })
}

fn run(pass: &mut wgpu::ComputePass, stage: &Stage, dispatches: &wgpu::Buffer, at: u64) {
    bind(pass, stage);
    pass.dispatch_workgroups_indirect(dispatches, at);
}

fn bind(pass: &mut wgpu::ComputePass, stage: &Stage) {
    pass.set_pipeline(&stage.pipeline);
    pass.set_bind_group(0, &stage.group, &[]);
}
