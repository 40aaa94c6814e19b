//! All points of a scene, measured in rounds. Each round runs every method once, so that other load
//! on the machine affects all methods alike.

use super::measure::MeasurementSetup;
use super::methods::SolveMethod;
use super::pareto::pareto_front;
use super::peers::Peer;
use super::store::{MeasurementContext, MeasurementStore};
use super::{Measurement, SolveFigures, SolverKind};
use crate::plan::SceneCounts;
use crate::plan::memory::SolveMemory;
use common::Result;
use cpu::dense::memory;
use oracle::solve::progress::ProgressMonitor;
use std::ops::ControlFlow;

/// A method that took longer is not repeated, seconds.
pub const MAX_REPEATED_SECONDS: f64 = 20.0;

/// One method with its measurements.
#[derive(Clone, Debug)]
pub struct ChartPoint {
    /// The method.
    pub method: SolveMethod,
    /// Its runs.
    pub runs: Vec<Measurement>,
    /// Upper bound of the rays traced: one per sample of each link.
    pub rays_at_most: u64,
    /// Item-buffer pixels drawn.
    pub pixels: u64,
    /// Memory computed from the sizes of the records, bytes.
    pub bytes: u64,
    /// True if no other point dominates it.
    pub on_front: bool,
    /// True if no other point of its solver dominates it.
    pub on_solver_front: bool,
}

impl ChartPoint {
    /// Returns the first failure of its runs, if any.
    pub fn first_failure(&self) -> Option<&str> {
        let failed = |m: &'_ Measurement| m.result.is_err();
        let run = self.runs.iter().find(|m| failed(m))?;
        run.result.as_ref().err().map(String::as_str)
    }

    /// Returns the figures of its first run, if no run failed; all runs have the same.
    pub fn first_figures(&self) -> Option<&SolveFigures> {
        if self.first_failure().is_some() {
            return None;
        }
        self.runs.first()?.result.as_ref().ok()
    }

    /// Returns median, minimum and maximum of `what` over the runs.
    pub fn median_and_range(&self, what: impl Fn(&Measurement) -> f64) -> [f64; 3] {
        let mut all: Vec<f64> = self.runs.iter().map(what).collect();
        all.sort_by(f64::total_cmp);
        let n = all.len();
        if n == 0 {
            return [f64::NAN; 3];
        }
        let median = (all[(n - 1) / 2] + all[n / 2]) / 2.0;
        [median, all[0], all[n - 1]]
    }

    /// Returns the median of the total seconds.
    pub fn median_seconds(&self) -> f64 {
        self.median_and_range(Measurement::total_seconds)[0]
    }

    /// Returns (seconds, error); the error of a failed point is NaN.
    pub fn time_and_error(&self) -> (f64, f64) {
        let error = self.first_figures().map_or(f64::NAN, |figures| figures.error);
        (self.median_seconds(), error)
    }
}

/// All points of one scene.
#[derive(Clone, Debug)]
pub struct SceneChart {
    /// Name of the scene.
    pub scene: String,
    /// Number of faces.
    pub faces: usize,
    /// Requested texels per side.
    pub texels: u32,
    /// Description of the truth.
    pub truth: String,
    /// Name of the GPU.
    pub adapter: Option<String>,
    /// True if the GPU is a software adapter.
    pub software: bool,
    /// True if the scene is the paper's room with its objects.
    pub is_paper_room: bool,
    /// The measured points.
    pub points: Vec<ChartPoint>,
    /// Number of points missing after an interruption.
    pub missing: usize,
    /// Measurements of other programs.
    pub peers: Vec<Peer>,
}

/// A store of measurements and the context of their keys.
pub struct KeyedStore<'a> {
    /// The store.
    pub store: &'a mut MeasurementStore,
    /// The context of the keys.
    pub context: &'a MeasurementContext,
}

impl KeyedStore<'_> {
    fn key_of(&self, method: &SolveMethod) -> String {
        (self.context).measurement_key(method.solver, &method.settings, method.target_error)
    }

    /// Returns the measurements of `method` in chronological order.
    pub fn runs_of(&self, method: &SolveMethod) -> &[Measurement] {
        self.store.runs_of(&self.key_of(method))
    }
}

/// Runs round number `round`: measures every method that has at most `round` runs and should be
/// repeated. Returns `Break` if `watch` asked to stop. Errors: the store cannot be written.
pub fn run_round(
    setup: &MeasurementSetup,
    methods: &[SolveMethod],
    keyed: &mut KeyedStore,
    round: usize,
    watch: &ProgressMonitor,
) -> Result<ControlFlow<()>> {
    let all = methods.len() as f64;
    for (k, method) in methods.iter().enumerate() {
        if !needs_run(keyed.runs_of(method), round) {
            continue;
        }
        let name = format!("round {}, {}", round + 1, method.solver.name());
        let progress = |_: &str, share: f64| watch.report_share(&name, (k as f64 + share.clamp(0.0, 1.0)) / all);
        let Some(measurement) = setup.measure_method(method, &ProgressMonitor::new(&progress)) else {
            return Ok(ControlFlow::Break(()));
        };
        let description = format!("{} {} {}", setup.scene.name, method.solver.name(), method.options);
        let key = keyed.key_of(method);
        keyed.store.append_run(&key, &description, measurement)?;
    }
    Ok(ControlFlow::Continue(()))
}

/// Returns whether another run is needed. Long and failed runs are not repeated.
fn needs_run(runs: &[Measurement], round: usize) -> bool {
    let settled = |m: &Measurement| m.result.is_err() || m.total_seconds() > MAX_REPEATED_SECONDS;
    runs.len() <= round && !runs.iter().any(settled)
}

/// Returns the measured points of `methods` with at most `max_runs` runs each and marks the fronts.
pub fn collect_points(
    setup: &MeasurementSetup,
    methods: &[SolveMethod],
    keyed: &KeyedStore,
    max_runs: usize,
) -> Vec<ChartPoint> {
    let measured = methods.iter().filter_map(|method| {
        let runs = keyed.runs_of(method);
        let runs = runs[..runs.len().min(max_runs)].to_vec();
        (!runs.is_empty()).then(|| make_point(setup, method, runs))
    });
    let mut points: Vec<ChartPoint> = measured.collect();
    mark_fronts(&mut points);
    points
}

/// Sets `on_front` and `on_solver_front`.
pub fn mark_fronts(points: &mut [ChartPoint]) {
    let places: Vec<(f64, f64)> = points.iter().map(ChartPoint::time_and_error).collect();
    for (point, on) in points.iter_mut().zip(pareto_front(&places)) {
        point.on_front = on;
    }
    for solver in [SolverKind::Cpu, SolverKind::Gpu, SolverKind::Matrix] {
        let has_solver = |k: &usize| points[*k].method.solver == solver;
        let indices: Vec<usize> = (0..points.len()).filter(has_solver).collect();
        let places: Vec<(f64, f64)> = indices.iter().map(|k| places[*k]).collect();
        for (k, on) in indices.into_iter().zip(pareto_front(&places)) {
            points[k].on_solver_front = on;
        }
    }
}

fn make_point(setup: &MeasurementSetup, method: &SolveMethod, runs: Vec<Measurement>) -> ChartPoint {
    let settings = &method.settings;
    let counts = SceneCounts::new(setup.scene, &settings.meshing);
    let first = runs.first().and_then(|m| m.result.as_ref().ok());
    let linked = first.map_or(0, |figures| figures.linked);
    let shoots = method.solver != SolverKind::Matrix && method.target_error.is_none();
    ChartPoint {
        rays_at_most: if shoots {
            counts.max_rays(linked, settings.transport.visibility)
        } else {
            0
        },
        pixels: if shoots {
            counts.item_buffer_pixels(linked, settings.transport.visibility)
        } else {
            0
        },
        bytes: match (method.solver, setup.gpu) {
            _ if method.target_error.is_some() => 0,
            (SolverKind::Matrix, _) => memory::matrix_bytes(counts.texels),
            (SolverKind::Gpu, Some(gpu)) => SolveMemory::on_gpu(gpu, &counts, settings).peak_bytes(),
            _ => SolveMemory::on_cpu(&counts, settings).peak_bytes(),
        },
        method: method.clone(),
        runs,
        on_front: false,
        on_solver_front: false,
    }
}
