//! Times one shot, and one solve to an error of 10 %, by CPU rays, CPU twin and GPU. Prints
//! Criterion's figures, then the ratio to CPU rays, measured in rounds so that other load affects all
//! three alike, and the error of each.

use criterion::{BenchmarkGroup, Criterion, SamplingMode, measurement::WallTime};
use gpu::Gpu;
use radiosity_benches::{BenchRoom, BenchSolver, bench_rooms, time_shots, time_solve};
use std::time::{Duration, Instant};

/// Shots per run; a single one would mostly time the transfer to the device.
const TIMED_SHOTS: u32 = 4;
/// Rounds in which the ratios are measured.
const RATIO_ROUNDS: usize = 3;

/// Solvers that take longer are measured in the rounds only.
const MAX_SAMPLING_TIME: Duration = Duration::from_secs(10);

/// A measurement on a fresh engine.
type TimeFunction = fn(&BenchRoom, BenchSolver, &Gpu) -> Duration;

const TIMED_RUNS: [(&str, TimeFunction); 2] = [
    ("one shot", |room, solver, gpu| {
        time_shots(room, solver, gpu, TIMED_SHOTS) / TIMED_SHOTS
    }),
    ("one solve", |room, solver, gpu| time_solve(room, solver, gpu).0),
];

fn main() {
    let gpu = Gpu::open(None).expect("the bench compares with a GPU, a software one at least");
    let rooms = bench_rooms();
    let mut criterion = Criterion::default().without_plots().configure_from_args();
    for room in &rooms {
        for (name, time) in TIMED_RUNS {
            measure_solvers(
                &mut criterion.benchmark_group(format!("{}, {name}", room.name)),
                room,
                &gpu,
                time,
            );
        }
    }
    criterion.final_summary();
    println!(
        "\nTime over that of CPU rays, median of {RATIO_ROUNDS} rounds (least, largest); GPU: {}",
        gpu.line.name
    );
    for room in &rooms {
        print_ratios(room, &gpu);
    }
}

fn measure_solvers(group: &mut BenchmarkGroup<WallTime>, room: &BenchRoom, gpu: &Gpu, time: TimeFunction) {
    // Engines differ by a factor of a hundred, and a sample may take a second: use the fewest
    // samples that Criterion allows, and one iteration in each of a slow engine.
    const SAMPLES: u32 = 10;
    group
        .sample_size(SAMPLES as usize)
        .sampling_mode(SamplingMode::Flat)
        .warm_up_time(Duration::from_millis(100));
    for solver in BenchSolver::ALL {
        let start = Instant::now();
        time(room, solver, gpu);
        let samples = start.elapsed() * SAMPLES;
        if samples > MAX_SAMPLING_TIME {
            continue;
        }
        group.measurement_time(Duration::from_millis(500).max(samples * 3 / 2));
        group.bench_function(solver.name(), |bencher| {
            bencher.iter_custom(|count| (0..count).map(|_| time(room, solver, gpu)).sum());
        });
    }
}

fn print_ratios(room: &BenchRoom, gpu: &Gpu) {
    let rounds = [(); RATIO_ROUNDS].map(|()| {
        BenchSolver::ALL.map(|solver| {
            let shot = time_shots(room, solver, gpu, TIMED_SHOTS);
            let (solve, run) = time_solve(room, solver, gpu);
            ([shot, solve].map(|time| time.as_secs_f64()), run)
        })
    });
    for (what, name) in ["one shot", "one solve"].iter().enumerate() {
        let ratio = |k: usize| {
            let mut ratios = rounds.each_ref().map(|r| r[k].0[what] / r[0].0[what]);
            ratios.sort_by(f64::total_cmp);
            let [least, median, largest] = [ratios[0], ratios[RATIO_ROUNDS / 2], ratios[RATIO_ROUNDS - 1]];
            let solver = BenchSolver::ALL[k].name();
            format!("{solver} {median:8.2} ({least:.2}, {largest:.2})")
        };
        println!("{:<16} {name:<10} {}   {}", room.name, ratio(1), ratio(2));
    }
    let errors = [0, 1, 2].map(|k| {
        let run = &rounds[0][k].1;
        let error = room.target.relative_rms(&run.field) * 100.0;
        let solver = BenchSolver::ALL[k].name();
        format!("{solver} {error:.2} % ({} shots)", run.shots.len())
    });
    println!("{:<16} error      {}", room.name, errors.join("   "));
}
