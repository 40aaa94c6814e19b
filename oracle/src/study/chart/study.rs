//! All points of a scene: measured in rounds, each round all of them once, so that what else the
//! machine does falls on all alike; and summed up.

use super::front::front;
use super::measure::Bench;
use super::methods::Method;
use super::peers::Peer;
use super::store::{Context, Store};
use super::{Figures, Measurement, Solver};
use crate::plan::Counts;
use crate::plan::memory::Memory;
use crate::solve::watch::Watch;
use common::Result;
use cpu::matrix::memory;
use std::ops::ControlFlow;

/// A point that took longer (seconds) is not repeated.
pub const LONG: f64 = 20.0;

/// One method, measured.
#[derive(Clone, Debug)]
pub struct Point {
    /// How it was solved.
    pub method: Method,
    /// As often as it was.
    pub runs: Vec<Measurement>,
    /// Rays asked at most: one a sample of each link.
    pub rays_at_most: u64,
    /// Pixels of item buffers drawn.
    pub pixels: u64,
    /// Memory by the sizes of the records.
    pub bytes: u64,
    /// Not dominated by any other.
    pub on_front: bool,
    /// Not dominated by another of its solver.
    pub on_solver_front: bool,
}

impl Point {
    /// Why it has no figures: the first failure of its runs.
    pub fn failure(&self) -> Option<&str> {
        let failed = |m: &'_ Measurement| m.result.is_err();
        let run = self.runs.iter().find(|m| failed(m))?;
        run.result.as_ref().err().map(String::as_str)
    }

    /// Those of its first run, if none failed: all runs have the same.
    pub fn figures(&self) -> Option<&Figures> {
        if self.failure().is_some() {
            return None;
        }
        self.runs.first()?.result.as_ref().ok()
    }

    /// Of the runs' `what`: median, least, most.
    pub fn spread(&self, what: impl Fn(&Measurement) -> f64) -> [f64; 3] {
        let mut all: Vec<f64> = self.runs.iter().map(what).collect();
        all.sort_by(f64::total_cmp);
        let n = all.len();
        if n == 0 {
            return [f64::NAN; 3];
        }
        let median = (all[(n - 1) / 2] + all[n / 2]) / 2.0;
        [median, all[0], all[n - 1]]
    }

    /// The median.
    pub fn seconds(&self) -> f64 {
        self.spread(Measurement::seconds)[0]
    }

    /// Seconds and error; NaN where it failed.
    pub fn place(&self) -> (f64, f64) {
        let error = self.figures().map_or(f64::NAN, |figures| figures.error);
        (self.seconds(), error)
    }
}

/// A scene's points.
#[derive(Clone, Debug)]
pub struct Study {
    /// The scene.
    pub scene: String,
    /// Its faces.
    pub faces: usize,
    /// Texels a side asked for.
    pub texels: u32,
    /// What the points are judged by.
    pub truth: String,
    /// The GPU.
    pub adapter: Option<String>,
    /// Whether that is the CPU.
    pub software: bool,
    /// Whether it is the paper's room with its objects.
    pub paper: bool,
    /// Those measured.
    pub points: Vec<Point>,
    /// How many were not, because it was interrupted.
    pub missing: usize,
    /// Other programs.
    pub peers: Vec<Peer>,
}

/// Where measurements are kept, and under what names.
pub struct Kept<'a> {
    /// The file.
    pub store: &'a mut Store,
    /// What the names are made of.
    pub context: &'a Context,
}

/// Round number `round`: every method that has not been measured so often yet and is worth it.
pub fn round(
    bench: &Bench,
    methods: &[Method],
    kept: &mut Kept,
    round: usize,
    watch: &Watch,
) -> Result<ControlFlow<()>> {
    let all = methods.len() as f64;
    for (k, method) in methods.iter().enumerate() {
        let key = kept.context.key(method);
        if !wanted(kept.store.runs(&key), round) {
            continue;
        }
        let name = format!("round {}, {}", round + 1, method.solver.name());
        let done =
            |_: &str, share: f64| watch.tell(&name, (k as f64 + share.clamp(0.0, 1.0)) / all);
        let Some(measurement) = bench.measure(method, &Watch::new(&done)) else {
            return Ok(ControlFlow::Break(()));
        };
        let about = format!(
            "{} {} {}",
            bench.scene.name,
            method.solver.name(),
            method.options
        );
        kept.store.add(&key, &about, measurement)?;
    }
    Ok(ControlFlow::Continue(()))
}

/// Whether another run is, after these; neither a long one nor a failure is repeated.
fn wanted(runs: &[Measurement], round: usize) -> bool {
    let settled = |m: &Measurement| m.result.is_err() || m.seconds() > LONG;
    runs.len() <= round && !runs.iter().any(settled)
}

/// Everything of `methods` that has been measured, with its fronts.
pub fn points(bench: &Bench, methods: &[Method], kept: &Kept, most: usize) -> Vec<Point> {
    let measured = methods.iter().filter_map(|method| {
        let runs = kept.store.runs(&kept.context.key(method));
        let runs = runs[..runs.len().min(most)].to_vec();
        (!runs.is_empty()).then(|| point(bench, method, runs))
    });
    let mut points: Vec<Point> = measured.collect();
    mark_fronts(&mut points);
    points
}

/// Sets `on_front` and `on_solver_front`.
pub fn mark_fronts(points: &mut [Point]) {
    let places: Vec<(f64, f64)> = points.iter().map(Point::place).collect();
    for (point, on) in points.iter_mut().zip(front(&places)) {
        point.on_front = on;
    }
    for solver in [Solver::Cpu, Solver::Gpu, Solver::Matrix] {
        let of = |k: &usize| points[*k].method.solver == solver;
        let mine: Vec<usize> = (0..points.len()).filter(of).collect();
        let places: Vec<(f64, f64)> = mine.iter().map(|k| places[*k]).collect();
        for (k, on) in mine.into_iter().zip(front(&places)) {
            points[k].on_solver_front = on;
        }
    }
}

fn point(bench: &Bench, method: &Method, runs: Vec<Measurement>) -> Point {
    let settings = &method.settings;
    let counts = Counts::new(bench.scene, &settings.meshing);
    let first = runs.first().and_then(|m| m.result.as_ref().ok());
    let linked = first.map_or(0, |figures| figures.linked);
    let shoots = method.solver != Solver::Matrix && method.asked.is_none();
    Point {
        rays_at_most: if shoots {
            counts.rays_at_most(linked, settings.transport.visibility)
        } else {
            0
        },
        pixels: if shoots {
            counts.pixels(linked, settings.transport.visibility)
        } else {
            0
        },
        bytes: match (method.solver, bench.gpu) {
            _ if method.asked.is_some() => 0,
            (Solver::Matrix, _) => memory::bytes(counts.texels),
            (Solver::Gpu, Some(gpu)) => Memory::gpu(gpu, &counts, settings).bytes(),
            _ => Memory::cpu(&counts, settings).bytes(),
        },
        method: method.clone(),
        runs,
        on_front: false,
        on_solver_front: false,
    }
}
