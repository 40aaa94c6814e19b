//! A check of an adapter: all stages of the GPU's solvers against their twins in the bundled comparisons, the time of each
//! stage, the paper's shots, and the GPU's points of the chart.

pub mod page;

use crate::studies::table4::{PAPER_EPSILON, paper_settings};
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::{Shoot, ShotOrder};
use common::{Error, Result};
use gpu::adapter::AdapterLine;
use gpu::{Gpu, GpuSolver};
use oracle::compare::comparison::{Comparison, SceneComparison};
use oracle::solve::progress::{PhaseCallback, ProgressMonitor};
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::SolveTask;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

/// Texels per side and item-buffer pixels of the paper's largest solve, of 334 shots.
const PAPER_SIZE: (u32, u32) = (32, 1024);
/// Shots that are timed with links that are kept.
const KEPT_SHOTS: usize = 64;

/// What was found of an adapter.
#[derive(Serialize)]
pub struct HardwareReport {
    /// Version of the program.
    pub program: &'static str,
    /// Name of the adapter.
    pub adapter: String,
    /// Vulkan, Metal, DX12, …
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
    /// True for an adapter that runs on the CPU.
    pub software: bool,
    /// Comparisons of the solvers.
    pub comparisons: Vec<ComparedScene>,
    /// Seconds of each stage, in the paper's scene.
    pub stage_seconds: Vec<StageSeconds>,
    /// The paper's shots.
    pub paper: Option<PaperShots>,
    /// Content of `chart.json`.
    pub chart: serde_json::Value,
}

/// A comparison.
#[derive(Serialize)]
pub struct ComparedScene {
    /// Scene and options.
    pub options: String,
    /// True if all criteria hold.
    pub agrees: bool,
    /// Criteria that do not hold.
    pub failing: Vec<String>,
    /// Checks of the stages that were reached.
    pub stages: Vec<StageVerdict>,
}

/// A check of a stage.
#[derive(Clone, Serialize)]
pub struct StageVerdict {
    /// Name of the stage.
    pub name: String,
    /// True if the values are within the bound.
    pub agrees: bool,
    /// Number of compared values.
    pub values: u64,
    /// Largest difference.
    pub worst: f64,
    /// Largest difference allowed.
    pub bound: f64,
}

/// Time of a stage.
#[derive(Serialize)]
pub struct StageSeconds {
    /// The stage.
    pub stage: &'static str,
    /// Seconds for a shot.
    pub seconds: f64,
}

/// The paper's scene, solved on both sides with its settings.
#[derive(Serialize)]
pub struct PaperShots {
    /// Number of texels.
    pub texels: usize,
    /// Shots on the GPU.
    pub shots: usize,
    /// Seconds on the GPU, by item buffers.
    pub gpu_seconds: f64,
    /// Shots on the CPU.
    pub cpu_shots: usize,
    /// Seconds on the CPU, by rays.
    pub cpu_seconds: f64,
}

/// What the checks of a stage found in all comparisons.
#[derive(Clone, Copy, Default)]
pub struct StageCounts {
    /// Comparisons in which it is right.
    pub right: usize,
    /// Comparisons in which it is wrong.
    pub wrong: usize,
    /// Number of compared values.
    pub values: u64,
    /// Largest difference over its bound, of bounds above 0.
    pub nearest: f64,
}

impl HardwareReport {
    /// Starts the report of an adapter.
    pub fn new(adapter: &AdapterLine) -> Self {
        Self {
            program: env!("CARGO_PKG_VERSION"),
            adapter: adapter.name.clone(),
            backend: adapter.backend.clone(),
            driver: adapter.driver.clone(),
            software: adapter.software,
            comparisons: Vec::new(),
            stage_seconds: Vec::new(),
            paper: None,
            chart: serde_json::Value::Null,
        }
    }

    /// Adds a comparison.
    pub fn add_comparison(&mut self, judged: &SceneComparison) {
        self.comparisons
            .extend(judged.iter_comparisons().map(ComparedScene::new));
    }

    /// Returns whether something was compared, and all agrees.
    pub fn agrees(&self) -> bool {
        !self.comparisons.is_empty() && self.comparisons.iter().all(|compared| compared.agrees)
    }

    /// Returns what was found of each stage, by name.
    pub fn count_stages(&self) -> BTreeMap<&str, StageCounts> {
        let mut counts: BTreeMap<&str, StageCounts> = BTreeMap::new();
        for stage in self.comparisons.iter().flat_map(|compared| &compared.stages) {
            let count = counts.entry(&stage.name).or_default();
            *if stage.agrees {
                &mut count.right
            } else {
                &mut count.wrong
            } += 1;
            count.values += stage.values;
            if stage.bound > 0.0 {
                count.nearest = count.nearest.max(stage.worst / stage.bound);
            }
        }
        counts
    }

    /// Describes the verdict in a line.
    pub fn describe(&self) -> String {
        let counts = self.count_stages();
        let wrong = counts.values().filter(|count| count.wrong > 0).count();
        let compared = self.comparisons.len();
        let agree = self.comparisons.iter().filter(|compared| compared.agrees).count();
        format!(
            "{} stages right, {wrong} wrong; {agree} of {compared} comparisons agree",
            counts.len() - wrong
        )
    }
}

impl ComparedScene {
    fn new(comparison: &Comparison) -> Self {
        let failing = comparison.criteria.iter().filter(|criterion| !criterion.pass);
        let verdict = |stage: &oracle::compare::comparison::StageCheck| StageVerdict {
            name: stage.name.clone(),
            agrees: stage.agree,
            values: stage.values,
            worst: stage.worst,
            bound: stage.bound,
        };
        Self {
            options: comparison.scene.name.clone(),
            agrees: comparison.solvers_agree(),
            failing: failing.map(|criterion| criterion.name.clone()).collect(),
            stages: comparison.stages.iter().map(verdict).collect(),
        }
    }
}

/// Times the stages of a shot of the paper's scene.
///
/// Errors: the device fails.
pub fn time_stages(scene: &Scene, gpu: &Gpu) -> Result<Vec<StageSeconds>> {
    let (texels, pixels) = PAPER_SIZE;
    let settings = paper_settings(texels, Some(pixels), PAPER_EPSILON);
    let mesh = Mesh::uniform(scene, texels, 1)?;
    let mut solver = GpuSolver::new(gpu, &mesh, &settings.transport)?;
    let steps = solver.time_link_steps(0)?;
    let mut times: Vec<StageSeconds> = (steps.into_iter())
        .map(|(stage, seconds)| StageSeconds { stage, seconds })
        .collect();
    // The first run makes the links, the second one keeps them.
    let mut seconds = 0.0;
    for _ in 0..2 {
        let script = [0; KEPT_SHOTS];
        let start = Instant::now();
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        solver.run(ShotOrder::Replay(&script), KEPT_SHOTS as u32, go_on)?;
        seconds = start.elapsed().as_secs_f64() / KEPT_SHOTS as f64;
    }
    times.push(StageSeconds {
        stage: "deposit, unshot power and selection, with kept links",
        seconds,
    });
    Ok(times)
}

/// Solves the paper's scene on both sides.
///
/// Errors: a solve fails, or `show` asks to stop.
pub fn time_paper(scene: &Scene, gpu: &Gpu, show: PhaseCallback) -> Result<PaperShots> {
    let (texels, pixels) = PAPER_SIZE;
    let solve = |pixels: Option<u32>| {
        let settings = paper_settings(texels, pixels, PAPER_EPSILON);
        let solver = SolverChoice::for_transport(pixels.map(|_| gpu), &settings.transport);
        let monitor = ProgressMonitor::new(show);
        let start = Instant::now();
        let solved = scene.solve_once(&settings, solver, &monitor)?;
        match monitor.is_stopped() {
            true => Err(Error::Interrupted),
            false => Ok((solved, start.elapsed().as_secs_f64())),
        }
    };
    let (on_gpu, gpu_seconds) = solve(Some(pixels))?;
    let (on_cpu, cpu_seconds) = solve(None)?;
    Ok(PaperShots {
        texels: on_gpu.mesh.texels.len(),
        shots: on_gpu.run.shots.len(),
        gpu_seconds,
        cpu_shots: on_cpu.run.shots.len(),
        cpu_seconds,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared_scene(agrees: bool, worst: f64) -> ComparedScene {
        let stage = StageVerdict {
            name: "link".into(),
            agrees,
            values: 10,
            worst,
            bound: 8.0,
        };
        ComparedScene {
            options: "scene.obj".into(),
            agrees,
            failing: Vec::new(),
            stages: vec![stage],
        }
    }

    #[test]
    fn report_is_right_where_all_comparisons_are_and_wrong_where_none_was_made() {
        let line = AdapterLine {
            name: "a GPU".into(),
            backend: "vulkan".into(),
            driver: "1".into(),
            software: false,
        };
        let mut report = HardwareReport::new(&line);
        assert!(!report.agrees());
        report.comparisons.push(compared_scene(true, 2.0));
        assert!(report.agrees());
        report.comparisons.push(compared_scene(false, 12.0));
        assert!(!report.agrees());
        assert_eq!(report.describe(), "0 stages right, 1 wrong; 1 of 2 comparisons agree");
        let count = report.count_stages()["link"];
        assert_eq!((count.right, count.wrong, count.values, count.nearest), (1, 1, 20, 1.5));
        let page = page::render_page(&report, &[]);
        assert!(page.contains("Wrong") && page.contains("1 · 1 · 0") && page.contains("150"));
    }
}
