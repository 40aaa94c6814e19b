//! The GPU engine of the shooting loop: batches of shots that the device selects itself.

use crate::adapter::Gpu;
use crate::compute_stage::PipelineMaker;
use crate::device_queue::{DeviceQueue, PendingRead, QueueCounts};
use crate::dispatch_arguments::CountedStage;
use crate::link_recorder::{LinkRecorder, ShotSelection};
use crate::pass_stages::{PassStages, transfer_fits};
use crate::probe::LinkProbe;
use crate::records::{LOG_COUNT_BYTES, LogRecord, ShaderParams, TexelRecord};
use crate::shaders::ShaderFault;
use crate::shot_slots::ShotSlots;
use crate::shot_stages::ShotStages;
use crate::solver_buffers::{LOG_BYTES, MAX_BATCH_SHOTS, SolverBuffers};
use crate::solver_context::SolverContext;
use crate::submission_pace::{IN_FLIGHT, SubmissionPace};
use bytemuck::pod_collect_to_vec;
use common::Result;
use common::constants::MAX_LINK_BYTES;
use common::mesh::{Mesh, Texel};
use common::passes::{Exchange, PatchClosure};
use common::settings::{Schedule, Transport, Visibility};
use common::shooting::{DepositRule, RadiosityField, Restart, Shoot, Shot, ShotOrder, ShotSeries, SolveRun};
use glam::{Vec3, Vec4};
use std::collections::VecDeque;
use std::ops::ControlFlow;
use web_time::Instant;

/// Fewest shots of a submission, unless a shot is slow.
const MIN_BATCH_SHOTS: u32 = 64;
/// Buffers of the texels' state.
const FIELD_BUFFERS: [&str; 3] = ["radiosity", "residual", "irradiance"];

/// Progressive refinement on a GPU.
pub struct GpuSolver<'a> {
    pub(crate) context: SolverContext<'a>,
    pub(crate) maker: PipelineMaker,
    /// Slots of the one shot that the device selects.
    pub(crate) slots: ShotSlots,
    pipelines: ShotStages,
    pub(crate) rule: DepositRule,
    pace: SubmissionPace,
    /// Stages of a solve by passes, made when the first one begins.
    pub(crate) passes: Option<PassStages>,
    /// Stages for checks, made when the first one begins.
    pub(crate) probe: Option<LinkProbe>,
}

/// A shot with its outcome.
pub struct ObservedShot {
    /// The shot.
    pub shot: Shot,
    /// Σ|r|A over the texels and channels of each patch, after it.
    pub power: Vec<f32>,
    /// The texels after it.
    pub field: RadiosityField,
}

/// A batch that runs.
struct BatchInFlight {
    pending: PendingRead,
    shots: u32,
    start: Instant,
}

impl<'a> GpuSolver<'a> {
    /// A solver in its initial state: B = r = E.
    pub fn new(gpu: &Gpu, mesh: &'a Mesh, transport: &Transport) -> Result<Self> {
        Self::with_faults(gpu, mesh, transport, &[])
    }

    /// A solver with `faults` planted in its shaders.
    pub fn with_faults(gpu: &Gpu, mesh: &'a Mesh, transport: &Transport, faults: &[ShaderFault]) -> Result<Self> {
        Self::with_budget(gpu, mesh, transport, faults, MAX_LINK_BYTES)
    }

    /// A solver that keeps at most `bytes` of links, and of transfers between patches.
    pub fn with_budget(
        gpu: &Gpu,
        mesh: &'a Mesh,
        transport: &Transport,
        faults: &[ShaderFault],
        bytes: u64,
    ) -> Result<Self> {
        pollster::block_on(Self::request_with(gpu, mesh, transport, faults, bytes))
    }

    /// Awaits a solver of [`Self::with_faults`], and what the device says of its buffers and shaders.
    pub async fn request(gpu: &Gpu, mesh: &'a Mesh, transport: &Transport, faults: &[ShaderFault]) -> Result<Self> {
        Self::request_with(gpu, mesh, transport, faults, MAX_LINK_BYTES).await
    }

    async fn request_with(
        gpu: &Gpu,
        mesh: &'a Mesh,
        transport: &Transport,
        faults: &[ShaderFault],
        bytes: u64,
    ) -> Result<Self> {
        let buffers = SolverBuffers::new(gpu, mesh, transport, bytes)?;
        let slots = ShotSlots::new(gpu, mesh, transport, 1, 1);
        let maker = PipelineMaker::new(gpu, transport, faults);
        let pipelines = ShotStages::new(&maker, &buffers, &slots)?;
        gpu.request_errors().await?;
        let solver = Self {
            context: SolverContext {
                host: DeviceQueue::new(gpu),
                mesh,
                transport: *transport,
                buffers,
            },
            maker,
            slots,
            pipelines,
            rule: DepositRule::FULL_DEPOSIT,
            pace: SubmissionPace::new(MIN_BATCH_SHOTS, MAX_BATCH_SHOTS, gpu.line.software),
            passes: None,
            probe: None,
        };
        solver.write_params(0.0, false);
        Ok(solver)
    }

    /// Awaits a fresh solver of another mesh with the same shaders, which keeps the links of one patch.
    pub async fn request_for<'m>(&self, mesh: &'m Mesh) -> Result<GpuSolver<'m>> {
        let SolverContext { host, transport, .. } = &self.context;
        GpuSolver::request_with(&host.gpu, mesh, transport, &self.maker.faults, 0).await
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &'a Mesh {
        self.context.mesh
    }

    /// Returns the submissions and mappings so far.
    pub fn queue_counts(&self) -> QueueCounts {
        self.context.host.counts
    }

    /// Reads the item buffer of the latest shot: face IDs + 1, row-major, 0 where no face was drawn; empty with
    /// visibility by rays.
    pub fn read_item_buffer(&mut self) -> Result<Vec<u32>> {
        match self.context.transport.visibility {
            Visibility::Rays => Ok(Vec::new()),
            Visibility::ItemBuffer(drawing) => {
                let host = &mut self.context.host;
                pollster::block_on(host.request_item_buffer(&self.slots.item_buffer, drawing.size))
            }
        }
    }

    /// Reads the irradiance of every texel; w is its link to the latest shot.
    pub fn read_irradiance(&mut self) -> Result<Vec<Vec4>> {
        let irradiance = &self.context.buffers.table["irradiance"];
        let bytes = 16 * self.context.mesh.texels.len() as u64;
        let host = &mut self.context.host;
        host.read_back(host.command_encoder(), &[(irradiance, 0, bytes)])
    }

    fn write_params(&self, threshold: f32, replay: bool) {
        let params = ShaderParams {
            threshold,
            replay: replay.into(),
            ..self.context.shader_params(&self.slots, self.rule)
        };
        self.context.host.write(&self.slots.table["params"], &[params]);
    }

    /// Returns the context and the stages of solves by passes; makes them when the first one begins.
    pub(crate) fn prepare_passes(&mut self) -> Result<(&mut SolverContext<'a>, &mut PassStages)> {
        let (context, maker) = (&mut self.context, &self.maker);
        let passes = match self.passes.take() {
            Some(passes) => passes,
            None => PassStages::new(context, maker)?,
        };
        Ok((context, self.passes.insert(passes)))
    }

    /// Records the unshot power of all patches, with workgroups from the host.
    fn record_power(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        let groups = self.context.workgroup_counts()[2];
        self.pipelines.power.dispatch_groups(&mut pass, groups);
    }

    /// Records one shot, and the selection of the next shooter. Once the order has ended it does nothing.
    fn record_shot(&self, encoder: &mut wgpu::CommandEncoder) {
        let stages = &self.pipelines;
        let linker = LinkRecorder {
            mesh: self.context.mesh,
            buffers: &self.context.buffers,
            slots: &self.slots,
            stages: &stages.link,
            shots: ShotSelection::Chosen,
        };
        for step in linker.link_steps() {
            linker.record_step(encoder, step);
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        let counts = &self.context.buffers.table["dispatches"];
        for (stage, counted) in [
            (&stages.deposit, CountedStage::Deposit),
            (&stages.power, CountedStage::Power),
        ] {
            stage.dispatch_counted(&mut pass, counts, counted.byte_offset());
        }
        stages.next.dispatch_groups(&mut pass, [1, 1, 1]);
    }

    /// Prepares shots in an order.
    fn begin_series(&mut self, order: ShotOrder) {
        match order {
            ShotOrder::Greedy { threshold } => self.write_params(threshold, false),
            ShotOrder::Replay(_) => self.write_params(0.0, true),
        }
        if let Some(passes) = &mut self.passes {
            passes.forget_rows();
        }
    }

    /// Records `shots` shots; the first batch of a run selects its first shooter as well.
    fn record_batch(&mut self, order: ShotOrder, done: u32, shots: u32) -> wgpu::CommandEncoder {
        let table = &self.context.buffers.table;
        if let ShotOrder::Replay(log) = order {
            let from = (done as usize).min(log.len());
            let mut script = log[from..log.len().min(from + shots as usize + 1)].to_vec();
            script.resize(shots as usize + 1, u32::MAX);
            self.context.host.write(&table["script"], &script);
        }
        let mut encoder = self.context.host.command_encoder();
        // The number of records in the log of the previous submission.
        encoder.clear_buffer(&table["log"], 0, Some(4));
        if done == 0 {
            self.record_power(&mut encoder);
            let mut pass = encoder.begin_compute_pass(&Default::default());
            self.pipelines.first.dispatch_groups(&mut pass, [1, 1, 1]);
        }
        for _ in 0..shots {
            self.record_shot(&mut encoder);
        }
        encoder
    }

    /// Records and submits `shots` shots.
    fn launch_batch(&mut self, order: ShotOrder, done: u32, shots: u32) -> BatchInFlight {
        let encoder = self.record_batch(order, done, shots);
        let log = &self.context.buffers.table["log"];
        let start = Instant::now();
        BatchInFlight {
            pending: self.context.host.submit_read(encoder, &[(log, 0, LOG_BYTES)]),
            shots,
            start,
        }
    }

    async fn land_batch(&mut self, flight: BatchInFlight) -> Result<Vec<Shot>> {
        let bytes = self.context.host.request_bytes(flight.pending).await?;
        self.pace.record_landing(flight.start, flight.shots);
        self.decode_log(&bytes, flight.shots)
    }

    /// Decodes the log of a submission of at most `most` shots.
    fn decode_log(&self, bytes: &[u8], most: u32) -> Result<Vec<Shot>> {
        let count = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        if count > most {
            return Err(self
                .context
                .host
                .gpu
                .stage_error("select", "the log of the shots is damaged"));
        }
        let records: Vec<LogRecord> = pod_collect_to_vec(&bytes[LOG_COUNT_BYTES as usize..]);
        Ok(records[..count as usize].iter().map(Shot::from).collect())
    }

    /// Makes the texels' state of the values in these buffers.
    fn field_of(&self, values: &[Vec4]) -> RadiosityField {
        let texels = self.context.mesh.texels.len();
        let part = |k: usize| values[k * texels..(k + 1) * texels].to_vec();
        RadiosityField {
            origin: format!("gpu: {}", self.context.host.gpu.line.name),
            radiosity: part(0),
            residual: part(1),
            irradiance: part(2),
        }
    }
}

/// What a caller awaits. A page may not wait: there these functions take the place of [`Shoot`] and [`Exchange`].
impl GpuSolver<'_> {
    /// Awaits the outcome of shots from the largest unshot power first until the schedule is met; `watch` receives every
    /// shot and the emitted power.
    ///
    /// Errors: those of [`common::shooting::shoot_until_converged`].
    pub async fn request_run(
        &mut self,
        schedule: &Schedule,
        watch: &mut dyn FnMut(&Shot, f32) -> ControlFlow<()>,
    ) -> Result<SolveRun> {
        let mut series = ShotSeries::until_converged(schedule, &self.request_power().await?)?;
        let (order, max_shots) = (series.order, series.max_shots);
        self.request_shots(order, max_shots, &mut |shot| series.record_shot(shot, watch))
            .await?;
        Ok(series.into_run(self.request_field().await?))
    }

    /// Awaits Σ|r|A over the texels and channels of each patch.
    pub async fn request_power(&mut self) -> Result<Vec<f32>> {
        let sums = &self.context.buffers.table["sums"];
        let mut encoder = self.context.host.command_encoder();
        self.record_power(&mut encoder);
        let bytes = 16 * self.context.mesh.patches.len() as u64;
        let sums: Vec<Vec4> = self.context.host.request_values(encoder, &[(sums, 0, bytes)]).await?;
        Ok(sums.iter().map(|sum| sum.w).collect())
    }

    /// Awaits the texels' state.
    pub async fn request_field(&mut self) -> Result<RadiosityField> {
        let encoder = self.context.host.command_encoder();
        let table = &self.context.buffers.table;
        let bytes = 16 * self.context.mesh.texels.len() as u64;
        let ranges = FIELD_BUFFERS.map(|name| (&table[name], 0, bytes));
        let values: Vec<Vec4> = self.context.host.request_values(encoder, &ranges).await?;
        Ok(self.field_of(&values))
    }

    /// Awaits the first shot of `order`, with the patches' unshot power and the texels after it; none if there is none.
    pub async fn request_observed_shot(&mut self, order: ShotOrder<'_>) -> Result<Option<ObservedShot>> {
        self.begin_series(order);
        let encoder = self.record_batch(order, 0, 1);
        let (mesh, table) = (self.context.mesh, &self.context.buffers.table);
        let (texel_bytes, patch_bytes) = (16 * mesh.texels.len() as u64, 16 * mesh.patches.len() as u64);
        let [radiosity, residual, irradiance] = FIELD_BUFFERS.map(|name| (&table[name], 0, texel_bytes));
        let ranges = [
            (&table["log"], 0, LOG_BYTES),
            (&table["sums"], 0, patch_bytes),
            radiosity,
            residual,
            irradiance,
        ];
        let pending = self.context.host.submit_read(encoder, &ranges);
        let bytes = self.context.host.request_bytes(pending).await?;
        let (log, rest) = bytes.split_at(LOG_BYTES as usize);
        let (sums, field) = rest.split_at(patch_bytes as usize);
        let sums: Vec<Vec4> = pod_collect_to_vec(sums);
        let shots = self.decode_log(log, 1)?;
        Ok(shots.first().map(|shot| ObservedShot {
            shot: *shot,
            power: sums.iter().map(|sum| sum.w).collect(),
            field: self.field_of(&pod_collect_to_vec(field)),
        }))
    }

    /// Awaits the shot of one patch.
    pub async fn request_shot(&mut self, patch: u32) -> Result<Shot> {
        let mut done = None;
        let mut watch = |shot: &Shot| {
            done = Some(*shot);
            ControlFlow::Continue(())
        };
        self.request_shots(ShotOrder::Replay(&[patch]), 1, &mut watch).await?;
        done.ok_or_else(|| self.context.host.gpu.stage_error("select", "a shot left no record"))
    }

    /// Awaits the shots of [`Shoot::run`]. Two batches are under way: the host reads the log of one while the next one
    /// runs.
    pub async fn request_shots(
        &mut self,
        order: ShotOrder<'_>,
        max_shots: u32,
        watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>,
    ) -> Result<()> {
        let max_shots = match order {
            ShotOrder::Greedy { .. } => max_shots,
            ShotOrder::Replay(log) => max_shots.min(log.len() as u32),
        };
        self.begin_series(order);
        let mut flights = VecDeque::new();
        let mut launched = 0;
        let mut ended = false;
        self.pace.start_series();
        loop {
            while !ended && flights.len() < IN_FLIGHT && launched < max_shots {
                let shots = self.pace.next_shots(launched, max_shots - launched);
                flights.push_back(self.launch_batch(order, launched, shots));
                launched += shots;
            }
            let Some(flight) = flights.pop_front() else {
                return Ok(());
            };
            let submitted = flight.shots;
            let shots = self.land_batch(flight).await?;
            ended |= (shots.len() as u32) < submitted;
            for shot in &shots {
                ended |= watch(shot).is_break();
            }
        }
    }
}

/// What a caller of passes awaits.
impl GpuSolver<'_> {
    /// Awaits the links of [`Exchange::make_links`].
    pub async fn request_links(
        &mut self,
        patches: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<PatchClosure>> {
        let (context, passes) = self.prepare_passes()?;
        passes.request_links(context, patches, watch).await
    }

    /// Awaits the flux of [`Exchange::exchange_flux`].
    pub async fn request_flux(&mut self, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        let (context, passes) = self.prepare_passes()?;
        passes.request_flux(context, radiosity).await
    }

    /// Awaits the field of [`Exchange::gather_field`].
    pub async fn request_gather(&mut self, shot: &[Vec3], unshot: &[Vec3]) -> Result<RadiosityField> {
        let (context, passes) = self.prepare_passes()?;
        passes.request_gather(context, shot, unshot).await?;
        self.request_field().await
    }
}

impl Shoot for GpuSolver<'_> {
    fn patch_power(&mut self) -> Result<Vec<f32>> {
        pollster::block_on(self.request_power())
    }

    fn shoot(&mut self, patch: u32) -> Result<Shot> {
        pollster::block_on(self.request_shot(patch))
    }

    fn read_field(&mut self) -> Result<RadiosityField> {
        pollster::block_on(self.request_field())
    }

    fn run(&mut self, order: ShotOrder, max_shots: u32, watch: &mut dyn FnMut(&Shot) -> ControlFlow<()>) -> Result<()> {
        pollster::block_on(self.request_shots(order, max_shots, watch))
    }
}

impl Restart for GpuSolver<'_> {
    fn restart_from(&mut self, rule: DepositRule, reflectance: &[Vec3], field: &RadiosityField) -> Result<()> {
        self.rule = rule.check_conserve(self.context.transport.conserve)?;
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
        host.write(&b.table["texels"], &texels);
        host.write(&b.table["radiosity"], &field.radiosity);
        host.write(&b.table["residual"], &field.residual);
        host.write(&b.table["irradiance"], &field.irradiance);
        self.context.host.gpu.check_errors()
    }
}

impl Exchange for GpuSolver<'_> {
    fn transfer_fits(&self) -> bool {
        transfer_fits(&self.context)
    }

    fn conserves_energy(&self) -> bool {
        self.context.transport.conserve
    }

    fn make_links(
        &mut self,
        patches: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<PatchClosure>> {
        pollster::block_on(self.request_links(patches, watch))
    }

    fn exchange_flux(&mut self, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        pollster::block_on(self.request_flux(radiosity))
    }

    fn gather_field(&mut self, shot: &[Vec3], unshot: &[Vec3]) -> Result<RadiosityField> {
        pollster::block_on(self.request_gather(shot, unshot))
    }
}
