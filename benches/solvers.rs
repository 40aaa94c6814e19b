//! One shot, and one solve to an error of 10 %: CPU rays, CPU twin and GPU side by side. Criterion's
//! figures first, then the ratio to the CPU's rays, taken in rounds so that all three meet the same
//! load, and the error that each reached.

use criterion::{BenchmarkGroup, Criterion, SamplingMode, measurement::WallTime};
use gpu::Gpu;
use radiosity_benches::{Room, Solver, rooms, shots, whole};
use std::time::{Duration, Instant};

/// Shots in a run: a single one would time the way to the device and back.
const SHOTS: u32 = 4;
/// Rounds of the ratios.
const ROUNDS: usize = 3;

/// What would take longer than this is left to the rounds.
const LONGEST: Duration = Duration::from_secs(10);

/// What is timed on a fresh engine.
type Time = fn(&Room, Solver, &Gpu) -> Duration;

const TIMES: [(&str, Time); 2] = [
    ("one shot", |room, solver, gpu| {
        shots(room, solver, gpu, SHOTS) / SHOTS
    }),
    ("one solve", |room, solver, gpu| whole(room, solver, gpu).0),
];

fn main() {
    let gpu = Gpu::open(None).expect("the bench compares with a GPU, a software one at least");
    let rooms = rooms();
    let mut criterion = Criterion::default().without_plots().configure_from_args();
    for room in &rooms {
        for (name, time) in TIMES {
            measure(
                &mut criterion.benchmark_group(format!("{}, {name}", room.name)),
                room,
                &gpu,
                time,
            );
        }
    }
    criterion.final_summary();
    println!(
        "\nTime over that of CPU rays, median of {ROUNDS} rounds (least, largest); GPU: {}",
        gpu.line.name
    );
    for room in &rooms {
        rounds(room, &gpu);
    }
}

fn measure(group: &mut BenchmarkGroup<WallTime>, room: &Room, gpu: &Gpu, time: Time) {
    // Engines differ by a factor of a hundred, and a sample may take a second: the fewest samples,
    // and one iteration in each where it is slow.
    const SAMPLES: u32 = 10;
    group
        .sample_size(SAMPLES as usize)
        .sampling_mode(SamplingMode::Flat)
        .warm_up_time(Duration::from_millis(100));
    for solver in Solver::ALL {
        let start = Instant::now();
        time(room, solver, gpu);
        let samples = start.elapsed() * SAMPLES;
        if samples > LONGEST {
            continue;
        }
        group.measurement_time(Duration::from_millis(500).max(samples * 3 / 2));
        group.bench_function(solver.name(), |bencher| {
            bencher.iter_custom(|count| (0..count).map(|_| time(room, solver, gpu)).sum());
        });
    }
}

fn rounds(room: &Room, gpu: &Gpu) {
    let rounds = [(); ROUNDS].map(|()| {
        Solver::ALL.map(|solver| {
            let shot = shots(room, solver, gpu, SHOTS);
            let (solve, run) = whole(room, solver, gpu);
            ([shot, solve].map(|time| time.as_secs_f64()), run)
        })
    });
    for (what, name) in ["one shot", "one solve"].iter().enumerate() {
        let ratio = |k: usize| {
            let mut ratios = rounds.each_ref().map(|r| r[k].0[what] / r[0].0[what]);
            ratios.sort_by(f64::total_cmp);
            let [least, median, largest] = [ratios[0], ratios[ROUNDS / 2], ratios[ROUNDS - 1]];
            let solver = Solver::ALL[k].name();
            format!("{solver} {median:8.2} ({least:.2}, {largest:.2})")
        };
        println!("{:<16} {name:<10} {}   {}", room.name, ratio(1), ratio(2));
    }
    let errors = [0, 1, 2].map(|k| {
        let run = &rounds[0][k].1;
        let error = room.target.error(&run.field) * 100.0;
        let solver = Solver::ALL[k].name();
        format!("{solver} {error:.2} % ({} shots)", run.shots.len())
    });
    println!("{:<16} error      {}", room.name, errors.join("   "));
}
