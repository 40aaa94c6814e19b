//! What [`common::passes`] asks of the GPU: links of many cells side by side, what cells exchange,
//! and what the texels have received in the end. Only a few numbers a cell cross the bus.

use crate::buffers::empty;
use crate::context::Context;
use crate::host::Pending;
use crate::linker::{Linker, Shots, bind};
use crate::pace::{IN_FLIGHT, Pace};
use crate::pipelines::LinkStages;
use crate::records::{Params, SHOT_BYTES, ShotRecord};
use crate::slots::{Slots, most_slots};
use crate::stage::Slot::{Read, Uniform, Write};
use crate::stage::{PipelineMaker, Stage};
use bytemuck::pod_collect_to_vec;
use common::Result;
use common::constants::LANES;
use common::passes::Closure;
use common::shooting::Rule;
use glam::{Vec3, Vec4};
use std::collections::{HashSet, VecDeque};
use std::ops::{ControlFlow, Range};
use std::time::Instant;
use wgpu::BufferUsages as Usage;

/// Links that one submission adds up: a gigabyte of them, some milliseconds on hardware.
const COLLECTED: u64 = 1 << 28;

/// What a solve by passes keeps beside the rest.
pub struct Passes {
    pub slots: Slots,
    pub stages: LinkStages,
    /// What each cell shoots, or has left.
    pub shot: wgpu::Buffer,
    flux: wgpu::Buffer,
    exchange: Stage,
    collect: Stage,
    settle: Stage,
    /// The cell + 1 whose links each place keeps.
    held: Vec<u32>,
    pace: Pace,
}

/// Links under way.
struct Flight {
    pending: Pending,
    cells: Vec<u32>,
    start: Instant,
}

/// Whether what cells exchange fits.
pub fn has_room(context: &Context) -> bool {
    let cells = context.mesh.cells.len() as u64;
    4 * cells * cells <= context.buffers.budget
}

impl Passes {
    pub fn new(context: &Context, maker: &PipelineMaker) -> Result<Self> {
        let (gpu, b) = (&context.host.gpu, &context.buffers);
        if !has_room(context) {
            return Err(gpu.fail("no room for what cells exchange"));
        }
        let (mesh, transport) = (context.mesh, &context.transport);
        let cells = mesh.cells.len() as u32;
        let count = most_slots(gpu, mesh, transport, b);
        let slots = Slots::new(gpu, mesh, transport, count, cells);
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let per_cell = |label| empty(&gpu.device, label, 16 * u64::from(cells), storage);
        let (shot, flux) = (per_cell("shot"), per_cell("flux"));
        let exchanged = [
            Uniform(&slots.params),
            Read(&shot),
            Read(&slots.taken),
            Write(&flux),
        ];
        let collected = [
            Uniform(&slots.params),
            Read(&b.cells),
            Read(&b.texels),
            Read(&shot),
            Read(&b.links),
            Write(&b.irradiance),
            Write(&b.radiosity),
            Write(&b.residual),
        ];
        let passes = Self {
            stages: LinkStages::new(maker, transport, b, &slots)?,
            exchange: maker.stage("exchange", "exchange", &exchanged)?,
            collect: maker.stage("collect", "collect", &collected)?,
            settle: maker.stage("collect", "settle", &collected)?,
            shot,
            flux,
            held: vec![0; b.places as usize],
            pace: Pace::new(1, slots.count, gpu.line.software),
            slots,
        };
        gpu.check()?;
        Ok(passes)
    }

    /// Single shots may have taken the places of links.
    pub fn forget(&mut self) {
        self.held.fill(0);
    }

    /// Links of `cells`, in batches of as many as lie side by side; two are always under way.
    pub fn link(
        &mut self,
        context: &mut Context,
        cells: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<Closure>> {
        self.tell(context, [0, 0]);
        self.pace.start();
        let mut flights = VecDeque::new();
        let mut closures = Vec::with_capacity(cells.len());
        let mut launched = 0;
        let mut ended = false;
        loop {
            while !ended && flights.len() < IN_FLIGHT && launched < cells.len() {
                let left = &cells[launched..];
                let most = self.pace.shots(launched as u32, left.len() as u32);
                let batch = apart(&left[..most as usize], context.buffers.places);
                flights.push_back(self.launch(context, batch));
                launched += batch.len();
            }
            let Some(flight) = flights.pop_front() else {
                return Ok(closures);
            };
            for closure in self.land(context, flight)? {
                closures.push(closure);
                ended |= watch(closures.len()).is_break();
            }
        }
    }

    /// Writes what the next submissions are told: of which cells they collect the shots.
    pub fn tell(&self, context: &Context, [first, end]: [u32; 2]) {
        let params = Params {
            first,
            end,
            ..context.params(&self.slots, Rule::PLAIN)
        };
        context.host.write(&self.slots.params, &[params]);
    }

    /// Writes the shots whose links are to be made, one a slot.
    pub fn prepare(&mut self, context: &Context, cells: &[u32]) {
        let places = context.buffers.places;
        let records: Vec<ShotRecord> = cells
            .iter()
            .map(|k| ShotRecord::linking(context.mesh, *k, places))
            .collect();
        for cell in cells {
            self.held[(cell % places) as usize] = cell + 1;
        }
        context.host.write(&self.slots.shots, &records);
    }

    fn launch(&mut self, context: &mut Context, cells: &[u32]) -> Flight {
        self.prepare(context, cells);
        let mut encoder = context.host.encoder();
        let linker = self.linker(context, cells);
        for step in linker.steps() {
            linker.record(&mut encoder, step);
        }
        let bytes = SHOT_BYTES * cells.len() as u64;
        let staging = context.host.staging(bytes);
        encoder.copy_buffer_to_buffer(&self.slots.shots, 0, &staging, 0, bytes);
        Flight {
            start: Instant::now(),
            pending: context.host.submit(encoder, staging),
            cells: cells.to_vec(),
        }
    }

    pub fn linker<'l>(&'l self, context: &'l Context, cells: &'l [u32]) -> Linker<'l> {
        Linker {
            mesh: context.mesh,
            buffers: &context.buffers,
            slots: &self.slots,
            stages: &self.stages,
            shots: Shots::These(cells, context.groups()),
        }
    }

    fn land(&mut self, context: &Context, flight: Flight) -> Result<Vec<Closure>> {
        let bytes = context.host.wait(flight.pending)?;
        self.pace.landed(flight.start, flight.cells.len() as u32);
        let records: Vec<ShotRecord> = pod_collect_to_vec(&bytes);
        let closures = flight.cells.iter().zip(&records).map(|(cell, record)| {
            // The host writes both as NaN, the device makes them.
            if record.cell != *cell || record.sum.is_nan() || record.escaped.is_nan() {
                return Err(context.host.gpu.fail("the links of a cell were not made"));
            }
            Ok(Closure {
                form_factor_sum: record.sum,
                escaped: record.escaped,
            })
        });
        closures.collect()
    }

    /// One dispatch over the receiving cells, one read-back.
    pub fn exchange(&mut self, context: &mut Context, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        let host = &mut context.host;
        host.write(&self.shot, &per_cell(radiosity));
        let bytes = self.flux.size();
        let staging = host.staging(bytes);
        let mut encoder = host.encoder();
        self.record_exchange(&mut encoder, host.groups(radiosity.len().div_ceil(LANES)));
        encoder.copy_buffer_to_buffer(&self.flux, 0, &staging, 0, bytes);
        let flux: Vec<Vec4> = pod_collect_to_vec(&host.finish(encoder, staging)?);
        if flux.iter().any(|flux| flux.w != 1.0) {
            return Err(host.gpu.fail("what cells exchange was not made"));
        }
        Ok(flux.iter().map(|flux| flux.truncate()).collect())
    }

    pub fn record_exchange(&self, encoder: &mut wgpu::CommandEncoder, groups: [u32; 4]) {
        encoder.clear_buffer(&self.flux, 0, None);
        dispatch(encoder, &self.exchange, groups);
    }

    /// The texels take all shots, a range of cells after the other; links that are not kept any
    /// more are made again.
    pub fn gather(&mut self, context: &mut Context, shot: &[Vec3], unshot: &[Vec3]) -> Result<()> {
        let (b, texels) = (&context.buffers, &context.mesh.texels);
        let emission: Vec<Vec4> = texels.iter().map(|t| t.emission.extend(0.0)).collect();
        context.host.write(&b.radiosity, &emission);
        let mut encoder = context.host.encoder();
        encoder.clear_buffer(&b.irradiance, 0, None);
        context.host.send(encoder);
        let step = (COLLECTED / texels.len().max(1) as u64).clamp(1, u64::from(b.places));
        let groups = context.groups();
        for first in (0..shot.len()).step_by(step as usize) {
            let end = (first + step as usize).min(shot.len());
            self.remake(context, first..end, shot)?;
            self.tell(context, [first as u32, end as u32]);
            self.over(context, shot, &self.collect, groups[0]);
        }
        let last = self.over(context, unshot, &self.settle, groups[2]);
        context.host.until(last)
    }

    /// The links of those that shoot, where another cell's are kept in their place.
    fn remake(&mut self, context: &mut Context, cells: Range<usize>, shot: &[Vec3]) -> Result<()> {
        let shooters: Vec<u32> = cells
            .filter(|k| shot[*k] != Vec3::ZERO)
            .map(|k| k as u32)
            .collect();
        self.keep(context, &shooters)
    }

    /// Makes the links of `cells` that are not kept.
    pub fn keep(&mut self, context: &mut Context, cells: &[u32]) -> Result<()> {
        let places = self.held.len() as u32;
        let missing: Vec<u32> = (cells.iter().copied())
            .filter(|k| self.held[(k % places) as usize] != k + 1)
            .collect();
        if !missing.is_empty() {
            self.link(context, &missing, &mut |_| ControlFlow::Continue(()))?;
        }
        Ok(())
    }

    /// Submits a stage that reads a colour of each cell.
    fn over(
        &self,
        context: &mut Context,
        colours: &[Vec3],
        stage: &Stage,
        groups: [u32; 4],
    ) -> wgpu::SubmissionIndex {
        context.host.write(&self.shot, &per_cell(colours));
        let mut encoder = context.host.encoder();
        dispatch(&mut encoder, stage, groups);
        context.host.send(encoder)
    }
}

/// The first of `cells` whose places differ.
fn apart(cells: &[u32], places: u32) -> &[u32] {
    let mut taken = HashSet::new();
    let clash = cells.iter().position(|cell| !taken.insert(cell % places));
    &cells[..clash.unwrap_or(cells.len())]
}

fn per_cell(colours: &[Vec3]) -> Vec<Vec4> {
    colours.iter().map(|colour| colour.extend(0.0)).collect()
}

/// One dispatch of a stage.
pub fn dispatch(encoder: &mut wgpu::CommandEncoder, stage: &Stage, groups: [u32; 4]) {
    let mut pass = encoder.begin_compute_pass(&Default::default());
    bind(&mut pass, stage);
    pass.dispatch_workgroups(groups[0], groups[1], 1);
}
