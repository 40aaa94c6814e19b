//! Profile of a solve by passes: each stage in submissions of its own.

use crate::adapter::Gpu;
use crate::adapter::TIMESTAMP_FEATURES;
use crate::compute_stage::BindingSlot::{Read, Write};
use crate::compute_stage::PipelineMaker;
use crate::device_queue::DeviceQueue;
use crate::link_recorder::LinkStep;
use crate::pass_stages::dispatch_stage;
use crate::solver::GpuSolver;
use crate::solver_buffers::zeroed_buffer;
use common::Result;
use common::constants::{MULTIPLY_ROUNDS, PATCH_SUM_LANES};
use common::settings::Transport;
use common::shooting::Shoot;
use glam::Vec3;
use std::time::Instant;

/// Lanes that measure the machine: copies of 128 MiB in all, which every adapter binds.
const COPY_LANES: u64 = 1 << 22;

/// A stage and its seconds.
pub type TimedStage = (&'static str, f64);

/// Measures the seconds of each stage of a solve of `passes` passes in which every patch shoots.
pub fn profile_stages(solver: &mut GpuSolver, passes: u32) -> Result<Vec<TimedStage>> {
    let count = solver.mesh().patches.len();
    let patches: Vec<u32> = (0..count as u32).collect();
    let colours = vec![Vec3::ONE; count];
    let mut steps = [0.0; 4];
    let (context, kept) = solver.prepare_passes()?;
    let clock = SubmissionClock::new(&context.host.gpu);
    kept.write_params(context, [0, 0]);
    let (most, places) = (kept.slots.count as usize, context.buffers.places as usize);
    for batch in patches.chunks(most.min(places)) {
        kept.write_shots(context, batch);
        let all: Vec<LinkStep> = kept.link_recorder(context, batch).link_steps().collect();
        for step in all {
            // The clock needs the host while the step is recorded.
            let mut host = DeviceQueue::new(&context.host.gpu);
            let linker = kept.link_recorder(context, batch);
            steps[step as usize] += clock.measure_seconds(&mut host, |encoder| linker.record_step(encoder, step))?;
        }
    }
    let groups = context.host.split_workgroups(count.div_ceil(PATCH_SUM_LANES));
    context.host.write(&kept.shot, &vec![1.0f32; 4 * count]);
    let mut exchange = 0.0;
    for _ in 0..passes {
        exchange += clock.measure_seconds(&mut context.host, |encoder| {
            kept.record_exchange(encoder, groups);
        })?;
    }
    let start = Instant::now();
    kept.gather_light(context, &colours, &colours)?;
    let gather = start.elapsed().as_secs_f64();
    let start = Instant::now();
    solver.read_field()?;
    let names = ["draw", "links", "escape", "sums"];
    let mut timed: Vec<TimedStage> = names.into_iter().zip(steps).collect();
    timed.extend([
        ("exchange", exchange),
        ("gather", gather),
        ("read-back", start.elapsed().as_secs_f64()),
    ]);
    Ok(timed)
}

/// Measures the bytes a second that a copy reads and writes, and the multiplications and additions a second;
/// the best of five.
pub fn measure_machine(gpu: &Gpu) -> Result<[f64; 2]> {
    let maker = PipelineMaker::new(gpu, &Transport::default(), &[]);
    let storage = wgpu::BufferUsages::STORAGE;
    let [source, sink] = ["source", "sink"].map(|n| zeroed_buffer(&gpu.device, n, 16 * COPY_LANES, storage));
    let slots = [Read(&source), Write(&sink)];
    let mut host = DeviceQueue::new(gpu);
    let clock = SubmissionClock::new(gpu);
    let groups = host.split_workgroups(COPY_LANES as usize / PATCH_SUM_LANES);
    let work = [
        ("copy_values", 32.0 * COPY_LANES as f64),
        ("multiply_values", 32.0 * f64::from(MULTIPLY_ROUNDS) * COPY_LANES as f64),
    ];
    let mut rates = [0.0f64; 2];
    for (rate, (entry, amount)) in rates.iter_mut().zip(work) {
        let stage = maker.make_stage("benchmark", entry, &slots)?;
        for _ in 0..5 {
            let seconds = clock.measure_seconds(&mut host, |encoder| dispatch_stage(encoder, &stage, groups))?;
            *rate = rate.max(amount / seconds);
        }
    }
    Ok(rates)
}

/// Returns true where the device's own clock measures.
pub fn has_device_clock(gpu: &Gpu) -> bool {
    matches!(SubmissionClock::new(gpu), SubmissionClock::Device(_))
}

/// Measures one submission at a time.
pub(crate) enum SubmissionClock {
    Host,
    Device(wgpu::QuerySet),
}

impl SubmissionClock {
    /// Creates a clock: the device's where [`Gpu::open_timed`] got timestamps.
    pub fn new(gpu: &Gpu) -> Self {
        if !gpu.device.features().contains(TIMESTAMP_FEATURES) {
            return Self::Host;
        }
        let descriptor = wgpu::QuerySetDescriptor {
            label: Some("clock"),
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        };
        Self::Device(gpu.device.create_query_set(&descriptor))
    }

    /// Measures the seconds of the commands of `record`.
    pub fn measure_seconds(
        &self,
        host: &mut DeviceQueue,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<f64> {
        let mut encoder = host.command_encoder();
        let Self::Device(queries) = self else {
            record(&mut encoder);
            let start = Instant::now();
            let submission = host.submit_work(encoder);
            host.wait_for_submission(submission)?;
            return Ok(start.elapsed().as_secs_f64());
        };
        let resolved = host.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("timestamps"),
            size: 16,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        encoder.write_timestamp(queries, 0);
        record(&mut encoder);
        encoder.write_timestamp(queries, 1);
        encoder.resolve_query_set(queries, 0..2, &resolved, 0);
        let staging = host.staging_buffer(16);
        encoder.copy_buffer_to_buffer(&resolved, 0, &staging, 0, 16);
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&host.read_back(encoder, staging)?);
        let period = f64::from(host.gpu.queue.get_timestamp_period());
        Ok(ticks[1].saturating_sub(ticks[0]) as f64 * period * 1e-9)
    }
}
