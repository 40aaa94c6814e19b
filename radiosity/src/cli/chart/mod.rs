//! `radiosity chart`.

pub mod vary;

use super::Outcome;
use super::bundled::{bundled_scene, find_bundled};
use super::console::message;
use super::progress::{Progress, handle_interrupts, is_interrupted};
use super::scene::MaterialOptions;
use crate::report::format::{format_number, format_percent};
use crate::studies::chart::measure::MeasurementSetup;
use crate::studies::chart::methods::{self, SolveMethod};
use crate::studies::chart::page::{ERROR_LEVELS, fastest_point};
use crate::studies::chart::peers::{self, Peer};
use crate::studies::chart::points::{KeyedStore, SceneChart, collect_points, run_round};
use crate::studies::chart::store::{MeasurementContext, MeasurementStore, hash_program, hash_scene, hash_value};
use crate::studies::chart::truth::ChartTruth;
use crate::studies::chart::{SolverKind, json, page, plot};
use clap::{Args, ValueEnum};
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use common::settings::SolveQuality;
use common::solution::{prepare_directory, write_file};
use common::text::escape_control;
use common::{Error, Result};
use gpu::Gpu;
use oracle::solve::progress::ProgressMonitor;
use std::path::{Path, PathBuf};
use vary::VariedOption;

/// The bundled scenes charted by default.
pub const CHARTED_SCENES: [&str; 3] = ["cornell_box.obj", PAPER_ROOM, "furnace.obj"];
/// Scene without `--vary` only: the truths have 64×64 texels on each of its 168 faces.
pub const PAPER_ROOM: &str = "paper_room_objects.obj";

/// `--quality` of a chart.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum QualityOption {
    /// Fewer points around a coarse base
    Draft,
    /// About 70 points per scene
    Normal,
}

/// `--solver` of a chart.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SolverOption {
    /// Only the CPU and the matrix
    Cpu,
    /// Only the GPU
    Gpu,
}

/// Arguments of `chart`.
#[derive(Args)]
pub struct ChartArguments {
    #[command(flatten)]
    inputs: ChartInputs,
    /// Chart the error against this option, all others at their defaults
    #[arg(long, value_enum, value_name = "OPTION",
        conflicts_with_all = ["quality", "texels", "solver", "repeats", "limit", "peers"])]
    vary: Option<VariedOption>,
    /// Number of points and fineness of their base [default: normal]
    #[arg(long, value_enum)]
    quality: Option<QualityOption>,
    /// Texels per side of a face [default: 16, fewer where the matrix can then be the truth; draft 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    texels: Option<u32>,
    /// Only these methods [default: all]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// Runs of each point, interleaved
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: u32,
    /// Seconds after which a solve is given up
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = parse_seconds)]
    limit: f64,
    /// Other programs' solves [default: DIR/peers.json if it exists]
    #[arg(long, value_name = "FILE")]
    peers: Option<PathBuf>,
}

/// Scenes, truth, GPU and folder of a chart.
#[derive(Args)]
pub struct ChartInputs {
    /// .obj, .gltf or .glb files [default: the bundled Cornell box, furnace and, without --vary, paper's room]
    scenes: Vec<PathBuf>,
    /// Folder for chart.html, chart.svg and chart.json; measurements already there are reused
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// A result of the scene taken as the truth [default: the matrix solver's, or else the CPU's to 0.2 %;
    /// with --vary one step finer than the last point]
    #[arg(long, value_name = "DIR")]
    truth: Option<PathBuf>,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Fail with exit code 3 when there is no GPU
    #[arg(long)]
    pub require_gpu: bool,
    #[command(flatten)]
    materials: MaterialOptions,
    /// Give each face a front on its back, too
    #[arg(long)]
    two_sided: bool,
    /// Join two triangles of a glTF mesh that form a planar convex quad
    #[arg(long)]
    join_quads: bool,
    /// No progress, no summary
    #[arg(long)]
    pub quiet: bool,
}

impl ChartInputs {
    /// Reads the scenes, by default the bundled ones named. Errors: one cannot be read or is dark, or
    /// `--truth` has several scenes.
    pub fn load_scenes(&self, bundled: &[&str]) -> Result<Vec<Scene>> {
        if self.truth.is_some() && self.scenes.len() != 1 {
            return Err(Error::Usage("--truth belongs to one SCENE: name it".into()));
        }
        let ours = |name: &&str| bundled_scene(name, &self.out);
        let paths = match self.scenes.as_slice() {
            [] => bundled.iter().map(ours).collect::<Result<_>>()?,
            given => given.to_vec(),
        };
        let options = ImportOptions {
            join_quads: self.join_quads,
            two_sided: self.two_sided,
            ..ImportOptions::default()
        };
        let lit = |path: &PathBuf| self.materials.load_lit_scene(path, options);
        paths.iter().map(lit).collect()
    }

    /// Reads the result that `--truth` names. Errors: it cannot be read or is of another scene.
    pub fn read_given_truth(&self, scenes: &[Scene]) -> Result<Option<ChartTruth>> {
        let Some(dir) = &self.truth else {
            return Ok(None);
        };
        let truth = ChartTruth::read_result(dir, escape_control(&dir.display().to_string()))?;
        scenes.iter().try_for_each(|scene| truth.check_scene(scene))?;
        Ok(Some(truth))
    }

    /// Makes the output folder and opens the measurements in it. Errors: they cannot be written.
    pub fn open_store(&self) -> Result<MeasurementStore> {
        prepare_directory(&self.out)?;
        let store = MeasurementStore::open(&self.out.join("chart.partial.jsonl"))?;
        if store.damaged > 0 {
            message!(
                "note: {} damaged lines of chart.partial.jsonl are skipped",
                store.damaged
            );
        }
        Ok(store)
    }
}

fn parse_seconds(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("{text} is not a time in seconds above 0")),
    }
}

impl ChartArguments {
    fn quality_or_default(&self) -> SolveQuality {
        match self.quality {
            Some(QualityOption::Draft) => SolveQuality::Draft,
            Some(QualityOption::Normal) | None => SolveQuality::Normal,
        }
    }
}

/// Measures the scenes one by one and writes the chart after each round.
pub fn run(arguments: &ChartArguments) -> Result<Outcome> {
    let inputs = &arguments.inputs;
    if let Some(option) = arguments.vary {
        return vary::run(inputs, option, "chart");
    }
    let others = read_peers(arguments)?;
    let gpu = open_gpu(arguments)?;
    let scenes = inputs.load_scenes(&CHARTED_SCENES)?;
    let given = inputs.read_given_truth(&scenes)?;
    let mut store = inputs.open_store()?;
    handle_interrupts();
    let paper = find_bundled(PAPER_ROOM, &inputs.out);
    let paper = paper.and_then(|path| load_scene(&path, &ImportOptions::default()).ok());
    let paper = paper.map(|scene| hash_scene(&scene));
    let mut studies = Vec::new();
    for scene in &scenes {
        let program = ChartRun {
            arguments,
            gpu: gpu.as_ref(),
            peers: &others,
            given_truth: given.as_ref(),
            paper: paper == Some(hash_scene(scene)),
        };
        let study = match program.measure_scene(scene, &mut store, &studies) {
            // Nothing of this scene is measured, but earlier scenes are.
            Err(Error::Interrupted) if !studies.is_empty() => break,
            other => other?,
        };
        studies.push(study);
        if is_interrupted() {
            break;
        }
    }
    write_chart(&inputs.out, &studies)?;
    if is_interrupted() {
        message!("interrupted: the chart holds what was measured by then; the same command continues it");
    }
    studies.iter().for_each(print_summary);
    message!(
        "wrote {0}/chart.html, {0}/chart.svg and {0}/chart.json",
        inputs.out.display()
    );
    Ok(Outcome::Done)
}

/// Inputs common to all scenes.
struct ChartRun<'a> {
    arguments: &'a ChartArguments,
    gpu: Option<&'a Gpu>,
    peers: &'a [Peer],
    given_truth: Option<&'a ChartTruth>,
    paper: bool,
}

impl ChartRun<'_> {
    fn measure_scene(&self, scene: &Scene, store: &mut MeasurementStore, before: &[SceneChart]) -> Result<SceneChart> {
        let arguments = self.arguments;
        let quality = arguments.quality_or_default();
        let texels = arguments
            .texels
            .unwrap_or_else(|| methods::truth_texels(scene, quality));
        let progress = Progress::new(&scene.name, arguments.inputs.quiet);
        let show = |phase: &str, done| progress.show_phase(phase, done);
        let watch = ProgressMonitor::new(&show);
        let own;
        let truth = match self.given_truth {
            Some(given) => given,
            None => {
                let name = format!("truth-{:016x}", self.digest_truth_inputs(scene, texels));
                let dir = arguments.inputs.out.join(name);
                own = ChartTruth::solve_truth(scene, texels, &dir, &watch)?;
                own.check_scene(scene)?;
                &own
            }
        };
        let bench = MeasurementSetup {
            scene,
            gpu: self.gpu,
            truth,
            texels,
            time_limit: arguments.limit,
        };
        let methods = self.select_methods(scene, quality, texels);
        let context = MeasurementContext {
            truth: truth.id,
            ..MeasurementContext::new(scene, self.gpu, (texels, arguments.limit))
        };
        let mut kept = KeyedStore {
            store,
            context: &context,
        };
        let stored: usize = methods.iter().map(|m| kept.runs_of(m).len()).sum();
        if stored > 0 {
            message!(
                "note: {}: continues after {stored} measurements in chart.partial.jsonl",
                scene.name
            );
        }
        let study = |kept: &KeyedStore| {
            let points = collect_points(&bench, &methods, kept, arguments.repeats as usize);
            self.assemble_study(scene, texels, truth, methods.len() - points.len(), points)
        };
        for number in 0..arguments.repeats as usize {
            let flow = run_round(&bench, &methods, &mut kept, number, &watch)?;
            let so_far: Vec<SceneChart> = before.iter().cloned().chain([study(&kept)]).collect();
            write_chart(&arguments.inputs.out, &so_far)?;
            if flow.is_break() {
                break;
            }
        }
        Ok(study(&kept))
    }

    /// Hashes the inputs of the truth that this program computes itself.
    fn digest_truth_inputs(&self, scene: &Scene, texels: u32) -> u64 {
        hash_value(&(hash_scene(scene), texels, hash_program()))
    }

    fn select_methods(&self, scene: &Scene, quality: SolveQuality, texels: u32) -> Vec<SolveMethod> {
        let only = self.arguments.solver;
        let of = |solver| methods::list_methods(scene, solver, quality, texels);
        let mut all = Vec::new();
        if only != Some(SolverOption::Gpu) {
            all.extend(of(SolverKind::Cpu));
            // The dense solver on the texels of its own truth would be that truth.
            let truth = |m: &SolveMethod| self.arguments.inputs.truth.is_none() && m.settings.meshing.texels == texels;
            all.extend(of(SolverKind::Matrix).into_iter().filter(|m| !truth(m)));
        }
        if only != Some(SolverOption::Cpu) && self.gpu.is_some() {
            all.extend(of(SolverKind::Gpu));
        }
        all
    }

    fn assemble_study(
        &self,
        scene: &Scene,
        texels: u32,
        truth: &ChartTruth,
        missing: usize,
        points: Vec<crate::studies::chart::points::ChartPoint>,
    ) -> SceneChart {
        let solved = |peer: &&Peer| peer.solved_scene(&scene.name);
        SceneChart {
            scene: scene.name.clone(),
            faces: scene.faces.len(),
            texels,
            truth: truth.name.clone(),
            adapter: self.gpu.map(|gpu| gpu.line.name.clone()),
            software: self.gpu.is_some_and(|gpu| gpu.line.software),
            is_paper_room: self.paper,
            points,
            missing,
            peers: self.peers.iter().filter(solved).cloned().collect(),
        }
    }
}

fn read_peers(arguments: &ChartArguments) -> Result<Vec<Peer>> {
    let default_path = arguments.inputs.out.join("peers.json");
    match &arguments.peers {
        Some(path) => peers::read_peers(path),
        None if default_path.exists() => peers::read_peers(&default_path),
        None => Ok(Vec::new()),
    }
}

/// Opens the adapter. Without one the chart has only the CPU's points.
///
/// Errors: there is no adapter and the GPU is required, or an option contradicts `--solver cpu`.
fn open_gpu(arguments: &ChartArguments) -> Result<Option<Gpu>> {
    let inputs = &arguments.inputs;
    let needed = inputs.require_gpu || arguments.solver == Some(SolverOption::Gpu);
    if arguments.solver == Some(SolverOption::Cpu) {
        let given = [
            ("--require-gpu", inputs.require_gpu),
            ("--adapter", inputs.adapter.is_some()),
        ];
        if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
            return Err(Error::Usage(format!(
                "{option} contradicts --solver cpu: leave one of them out"
            )));
        }
        return Ok(None);
    }
    match Gpu::open(inputs.adapter.as_deref()) {
        Ok(gpu) => Ok(Some(gpu)),
        Err(error @ Error::NoAdapter(_)) if !needed && inputs.adapter.is_none() => {
            message!("note: {error}; the chart has no GPU");
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

fn write_chart(out: &Path, studies: &[SceneChart]) -> Result<()> {
    let text = format!("{:#}\n", json::chart_json(studies));
    write_file(&out.join("chart.json"), text.as_bytes())?;
    let charts: Vec<(String, String)> = studies
        .iter()
        .filter_map(|study| Some((study.scene.clone(), plot::draw_scene(study)?)))
        .collect();
    write_file(&out.join("chart.svg"), plot::svg_file(&charts).as_bytes())?;
    write_file(&out.join("chart.html"), page::render_page(studies).as_bytes())
}

fn print_summary(study: &SceneChart) {
    let failed = study.points.iter().filter(|p| p.first_failure().is_some());
    message!(
        "{}: {} points, {} failed, {} not measured; truth: {}",
        study.scene,
        study.points.len(),
        failed.count(),
        study.missing,
        study.truth
    );
    for solver in study.measured_solvers() {
        let texts = ERROR_LEVELS.map(|level| match fastest_point(study, solver, level) {
            Some(point) => format!(
                "{} in {} s ({})",
                format_percent(level),
                format_number(point.median_seconds()),
                point.method.options
            ),
            None => format!("{} never", format_percent(level)),
        });
        message!("{}: {}: {}", study.scene, solver.name(), texts.join(", "));
    }
}
