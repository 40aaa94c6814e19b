//! The GPU engine of the shooting loop: batches of shots, each chosen on the device.

use crate::adapter::Gpu;
use crate::batch::Recorder;
use crate::buffers::{BATCH, Buffers, LOG_BYTES};
use crate::context::Context;
use crate::host::{Counts, Host, Pending};
use crate::pace::{IN_FLIGHT, Pace};
use crate::passes::{Passes, has_room};
use crate::pipelines::Pipelines;
use crate::probe::Probe;
use crate::records::{LOG_COUNT_BYTES, LogRecord, Params, TexelRecord};
use crate::shaders::Fault;
use crate::slots::Slots;
use crate::stage::PipelineMaker;
use bytemuck::pod_collect_to_vec;
use common::Result;
use common::constants::{LEVELS, LINK_BYTES};
use common::mesh::{Mesh, Texel};
use common::passes::{Closure, Exchange};
use common::settings::{Transport, Visibility};
use common::shooting::{Field, Order, Restart, Rule, Shoot, Shot};
use glam::{Vec3, Vec4};
use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::time::Instant;

/// Submissions of fewer shots than this pay only where a shot is slow.
const FEWEST: u32 = 64;

/// Progressive refinement on a GPU.
pub struct GpuSolver<'a> {
    pub(crate) context: Context<'a>,
    pub(crate) maker: PipelineMaker,
    /// Those of the one shot that is chosen on the device.
    slots: Slots,
    pipelines: Pipelines,
    rule: Rule,
    pace: Pace,
    /// What solves by passes need beside.
    pub(crate) passes: Option<Passes>,
    /// What checks of single stages need.
    pub(crate) probe: Option<Probe>,
}

/// A batch that runs.
struct Flight {
    pending: Pending,
    shots: u32,
    start: Instant,
}

impl<'a> GpuSolver<'a> {
    /// A solver in its initial state: B = r = E.
    pub fn new(gpu: &Gpu, mesh: &'a Mesh, transport: &Transport) -> Result<Self> {
        Self::with_faults(gpu, mesh, transport, &[])
    }

    /// A solver whose shaders are wrong in stated places.
    pub fn with_faults(
        gpu: &Gpu,
        mesh: &'a Mesh,
        transport: &Transport,
        faults: &[Fault],
    ) -> Result<Self> {
        Self::with_budget(gpu, mesh, transport, faults, LINK_BYTES)
    }

    /// A solver that keeps so many bytes of links, and of what cells exchange.
    pub fn with_budget(
        gpu: &Gpu,
        mesh: &'a Mesh,
        transport: &Transport,
        faults: &[Fault],
        bytes: u64,
    ) -> Result<Self> {
        let buffers = Buffers::new(gpu, mesh, transport, bytes)?;
        let slots = Slots::new(gpu, mesh, transport, 1, 1);
        let maker = PipelineMaker::new(gpu, transport, faults);
        let pipelines = Pipelines::new(&maker, transport, &buffers, &slots)?;
        gpu.check()?;
        let solver = Self {
            context: Context {
                host: Host::new(gpu),
                mesh,
                transport: *transport,
                buffers,
            },
            maker,
            slots,
            pipelines,
            rule: Rule::PLAIN,
            pace: Pace::new(FEWEST, BATCH, gpu.line.software),
            passes: None,
            probe: None,
        };
        solver.write_params(0.0, false);
        Ok(solver)
    }

    /// What is solved.
    pub fn mesh(&self) -> &'a Mesh {
        self.context.mesh
    }

    /// Submissions and mappings so far.
    pub fn counts(&self) -> Counts {
        self.context.host.counts
    }

    /// The item buffer of the latest shot: face IDs + 1, row-major, 0 where nothing was drawn; empty
    /// where rays are asked.
    pub fn item_buffer(&mut self) -> Result<Vec<u32>> {
        match self.context.transport.visibility {
            Visibility::Rays => Ok(Vec::new()),
            Visibility::Drawn(drawing) => {
                let size = drawing.size;
                self.context.host.ids(&self.slots.item_buffer, size)
            }
        }
    }

    /// The irradiance of every texel; w is the form factor of the latest shot where it was seen.
    pub fn irradiance(&mut self) -> Result<Vec<Vec4>> {
        let size = self.context.buffers.irradiance.size();
        let staging = self.context.host.staging(size);
        let mut encoder = self.context.host.encoder();
        encoder.copy_buffer_to_buffer(&self.context.buffers.irradiance, 0, &staging, 0, size);
        Ok(pod_collect_to_vec(
            &self.context.host.finish(encoder, staging)?,
        ))
    }

    fn write_params(&self, threshold: f32, replay: bool) {
        let params = Params {
            threshold,
            replay: replay.into(),
            ..self.context.params(&self.slots, self.rule)
        };
        self.context.host.write(&self.slots.params, &[params]);
    }

    /// What solves by passes need, made when the first one begins.
    pub(crate) fn passes(&mut self) -> Result<(&mut Context<'a>, &mut Passes)> {
        let (context, maker) = (&mut self.context, &self.maker);
        let passes = match self.passes.take() {
            Some(passes) => passes,
            None => Passes::new(context, maker)?,
        };
        Ok((context, self.passes.insert(passes)))
    }

    fn recorder(&self) -> Recorder<'_> {
        Recorder {
            buffers: &self.context.buffers,
            slots: &self.slots,
            pipelines: &self.pipelines,
            mesh: self.context.mesh,
        }
    }

    /// Records and submits `shots` shots; the first batch of a run chooses its shooter itself.
    fn launch(&mut self, order: Order, done: u32, shots: u32) -> Flight {
        if let Order::Replay(log) = order {
            let from = (done as usize).min(log.len());
            let mut script = log[from..log.len().min(from + shots as usize + 1)].to_vec();
            script.resize(shots as usize + 1, u32::MAX);
            self.context
                .host
                .write(&self.context.buffers.script, &script);
        }
        let staging = self.context.host.staging(LOG_BYTES);
        let mut encoder = self.context.host.encoder();
        let recorder = self.recorder();
        recorder.clear_log(&mut encoder);
        if done == 0 {
            recorder.power(&mut encoder, self.context.groups()[2]);
            recorder.first(&mut encoder);
        }
        for _ in 0..shots {
            recorder.shot(&mut encoder);
        }
        recorder.copy_log(&mut encoder, &staging);
        let start = Instant::now();
        Flight {
            pending: self.context.host.submit(encoder, staging),
            shots,
            start,
        }
    }

    fn land(&mut self, flight: Flight) -> Result<Vec<Shot>> {
        let bytes = self.context.host.wait(flight.pending)?;
        self.pace.landed(flight.start, flight.shots);
        let count = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        if count > flight.shots {
            return Err(self
                .context
                .host
                .gpu
                .fail("the log of the shots is damaged"));
        }
        let records: Vec<LogRecord> = pod_collect_to_vec(&bytes[LOG_COUNT_BYTES as usize..]);
        Ok(records[..count as usize].iter().map(Shot::from).collect())
    }
}

impl Shoot for GpuSolver<'_> {
    fn cell_power(&mut self) -> Result<Vec<f32>> {
        let size = self.context.buffers.sums.size();
        let staging = self.context.host.staging(size);
        let mut encoder = self.context.host.encoder();
        self.recorder()
            .power(&mut encoder, self.context.groups()[2]);
        encoder.copy_buffer_to_buffer(&self.context.buffers.sums, 0, &staging, 0, size);
        let sums: Vec<Vec4> = pod_collect_to_vec(&self.context.host.finish(encoder, staging)?);
        Ok(sums.iter().map(|sum| sum.w).collect())
    }

    fn shoot(&mut self, cell: u32) -> Result<Shot> {
        let mut done = None;
        self.run(Order::Replay(&[cell]), 1, &mut |shot| {
            done = Some(*shot);
            ControlFlow::Continue(())
        })?;
        done.ok_or_else(|| self.context.host.gpu.fail("a shot left no record"))
    }

    fn field(&mut self) -> Result<Field> {
        let size = self.context.buffers.radiosity.size();
        let staging = self.context.host.staging(3 * size);
        let mut encoder = self.context.host.encoder();
        let b = &self.context.buffers;
        for (k, buffer) in (0..).zip([&b.radiosity, &b.residual, &b.irradiance]) {
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, k * size, size);
        }
        let values: Vec<Vec4> = pod_collect_to_vec(&self.context.host.finish(encoder, staging)?);
        let part = |k: usize| {
            values[k * self.context.mesh.texels.len()..(k + 1) * self.context.mesh.texels.len()]
                .to_vec()
        };
        Ok(Field {
            origin: format!("gpu: {}", self.context.host.gpu.line.name),
            radiosity: part(0),
            residual: part(1),
            irradiance: part(2),
        })
    }

    /// Two batches are always under way; the log of one is read while the next one runs.
    fn run(
        &mut self,
        order: Order,
        max_shots: u32,
        watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>,
    ) -> Result<()> {
        let (threshold, max_shots) = match order {
            Order::Greedy { threshold } => (threshold, max_shots),
            Order::Replay(log) => (0.0, max_shots.min(log.len() as u32)),
        };
        self.write_params(threshold, matches!(order, Order::Replay(_)));
        let mut flights = VecDeque::new();
        let mut launched = 0;
        let mut ended = false;
        self.pace.start();
        if let Some(passes) = &mut self.passes {
            passes.forget();
        }
        loop {
            while !ended && flights.len() < IN_FLIGHT && launched < max_shots {
                let shots = self.pace.shots(launched, max_shots - launched);
                flights.push_back(self.launch(order, launched, shots));
                launched += shots;
            }
            let Some(flight) = flights.pop_front() else {
                return Ok(());
            };
            let asked = flight.shots;
            let shots = self.land(flight)?;
            ended |= (shots.len() as u32) < asked;
            for shot in &shots {
                ended |= watch(shot).is_break();
            }
        }
    }
}

impl Restart for GpuSolver<'_> {
    fn restart(&mut self, rule: Rule, reflectance: &[Vec3], field: &Field) -> Result<()> {
        self.rule = rule.with(self.context.transport.conserve)?;
        let texels: Vec<TexelRecord> = self
            .context
            .mesh
            .texels
            .iter()
            .zip(reflectance)
            .map(|(texel, reflectance)| {
                TexelRecord::from(&Texel {
                    reflectance: *reflectance,
                    ..*texel
                })
            })
            .collect();
        let (host, b) = (&self.context.host, &self.context.buffers);
        host.write(&b.texels, &texels);
        host.write(&b.radiosity, &field.radiosity);
        host.write(&b.residual, &field.residual);
        host.write(&b.irradiance, &field.irradiance);
        self.context.host.gpu.check()
    }
}

impl Exchange for GpuSolver<'_> {
    fn has_room(&self) -> bool {
        has_room(&self.context)
    }

    fn conserves(&self) -> bool {
        self.context.transport.conserve
    }

    fn link(
        &mut self,
        cells: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<Closure>> {
        let (context, passes) = self.passes()?;
        passes.link(context, cells, watch)
    }

    fn exchange(&mut self, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        let (context, passes) = self.passes()?;
        passes.exchange(context, radiosity)
    }

    fn gather(&mut self, shot: &[Vec3], unshot: &[Vec3]) -> Result<Field> {
        let (context, passes) = self.passes()?;
        passes.gather(context, shot, unshot)?;
        self.field()
    }
}

// The draw arguments and the lists of instances are laid out for this many levels.
const _: () = assert!(LEVELS == 8);
