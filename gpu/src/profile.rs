//! Where the time of a solve by passes goes: each stage in submissions of its own.

use crate::adapter::Gpu;
use crate::buffers::empty;
use crate::clock::Clock;
use crate::host::Host;
use crate::linker::Step;
use crate::passes::dispatch;
use crate::shaders::ROUNDS;
use crate::solver::GpuSolver;
use crate::stage::PipelineMaker;
use crate::stage::Slot::{Read, Write};
use common::Result;
use common::constants::LANES;
use common::settings::Transport;
use common::shooting::Shoot;
use glam::Vec3;
use std::time::Instant;

/// Lanes that measure the machine: copies of 128 MiB in all, what every adapter binds.
const COPIED: u64 = 1 << 22;

/// A stage and its seconds.
pub type Timed = (&'static str, f64);

/// Seconds of each stage of a solve in which every cell shoots, with so many passes.
pub fn profile(solver: &mut GpuSolver, passes: u32) -> Result<Vec<Timed>> {
    let count = solver.mesh().cells.len();
    let cells: Vec<u32> = (0..count as u32).collect();
    let colours = vec![Vec3::ONE; count];
    let mut steps = [0.0; 4];
    let (context, kept) = solver.passes()?;
    let clock = Clock::new(&context.host.gpu);
    kept.tell(context, [0, 0]);
    let (most, places) = (kept.slots.count as usize, context.buffers.places as usize);
    for batch in cells.chunks(most.min(places)) {
        kept.prepare(context, batch);
        let all: Vec<Step> = kept.linker(context, batch).steps().collect();
        for step in all {
            // The clock needs the host while the step is recorded.
            let mut host = Host::new(&context.host.gpu);
            let linker = kept.linker(context, batch);
            steps[step as usize] +=
                clock.seconds(&mut host, |encoder| linker.record(encoder, step))?;
        }
    }
    let groups = context.host.groups(count.div_ceil(LANES));
    context.host.write(&kept.shot, &vec![1.0f32; 4 * count]);
    let mut exchange = 0.0;
    for _ in 0..passes {
        exchange += clock.seconds(&mut context.host, |encoder| {
            kept.record_exchange(encoder, groups);
        })?;
    }
    let start = Instant::now();
    kept.gather(context, &colours, &colours)?;
    let gather = start.elapsed().as_secs_f64();
    let start = Instant::now();
    solver.field()?;
    let names = ["draw", "links", "escape", "sums"];
    let mut timed: Vec<Timed> = names.into_iter().zip(steps).collect();
    timed.extend([
        ("exchange", exchange),
        ("gather", gather),
        ("read-back", start.elapsed().as_secs_f64()),
    ]);
    Ok(timed)
}

/// Bytes a second that a copy moves (read and written), and multiplications and additions a second;
/// the best of five.
pub fn machine(gpu: &Gpu) -> Result<[f64; 2]> {
    let maker = PipelineMaker::new(gpu, &Transport::default(), &[]);
    let storage = wgpu::BufferUsages::STORAGE;
    let [source, sink] = ["source", "sink"].map(|n| empty(&gpu.device, n, 16 * COPIED, storage));
    let slots = [Read(&source), Write(&sink)];
    let mut host = Host::new(gpu);
    let clock = Clock::new(gpu);
    let groups = host.groups(COPIED as usize / LANES);
    let work = [
        ("copy", 32.0 * COPIED as f64),
        ("multiply", 32.0 * f64::from(ROUNDS) * COPIED as f64),
    ];
    let mut rates = [0.0f64; 2];
    for (rate, (entry, amount)) in rates.iter_mut().zip(work) {
        let stage = maker.stage("measure", entry, &slots)?;
        for _ in 0..5 {
            let seconds = clock.seconds(&mut host, |encoder| dispatch(encoder, &stage, groups))?;
            *rate = rate.max(amount / seconds);
        }
    }
    Ok(rates)
}

/// Whether the device's own clock is read.
pub fn by_device(gpu: &Gpu) -> bool {
    matches!(Clock::new(gpu), Clock::Device(_))
}
