//! `radiosity chart`: measures all methods, or one option, on each scene, and writes the chart.

use super::Outcome;
use super::bundled::bundled_scene;
use super::console::message;
use super::options::{Choice, choice_parser, load_lit_scene};
use super::progress::{Progress, handle_interrupts, is_interrupted};
use crate::report::plot::svg_file;
use crate::studies::chart::bench::ChartBench;
use crate::studies::chart::methods::truth_texels;
use crate::studies::chart::page::{render_page, titled_plots};
use crate::studies::chart::peers::{Peer, read_peers};
use crate::studies::chart::points::{SceneChart, chart_json};
use crate::studies::chart::store::MeasurementStore;
use crate::studies::chart::sweeps::{MethodSet, SWEEPS, Sweep};
use crate::studies::hashes::hash_program;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use common::import::ImportOptions;
use common::scene::Scene;
use common::settings::SolveQuality;
use common::solution::{prepare_folder, write_files};
use common::{Error, Result};
use gpu::Gpu;
use oracle::solve::solver::SolverKind;
use std::path::{Path, PathBuf};

/// The bundled scenes charted by default; the last without `--vary` only: the truths have 64×64 texels on each of its
/// 168 faces.
const CHARTED_SCENES: [&str; 3] = ["cornell_box.obj", "furnace.obj", "paper_room_objects.obj"];

/// Values of `--quality` of a chart.
const CHART_QUALITIES: [Choice<SolveQuality>; 2] = [
    ("draft", "Fewer points around a coarse base", SolveQuality::Draft),
    ("normal", "About 60 points per scene", SolveQuality::Normal),
];
/// Values of `--solver` of a chart.
const CHART_SOLVERS: [Choice<SolverKind>; 2] = [
    ("cpu", "Only the CPU and the dense solver", SolverKind::Cpu),
    ("gpu", "Only the GPU", SolverKind::Gpu),
];

/// The files that are written, beside the measurements.
const CHART_FILES: [&str; 3] = ["chart.json", "chart.svg", "chart.html"];

/// Solves of each method, of which the fastest counts; a draft has one.
const RUNS_PER_METHOD: u32 = 3;
/// Seconds after which a solve is given up.
const MAX_SOLVE_SECONDS: f64 = 60.0;

/// Arguments of `chart`.
#[derive(Args)]
pub struct ChartArguments {
    /// .obj, .gltf or .glb files [default: the bundled Cornell box, furnace and, without --vary, paper's room]
    scenes: Vec<PathBuf>,
    /// Folder for chart.html, chart.svg and chart.json; measurements already there are reused, and its peers.json is drawn
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Chart the error against this option, all others at their defaults; not with --quality, --texels or --solver
    #[arg(long, value_name = "OPTION", value_parser = sweeps_parser(),
        conflicts_with_all = ["quality", "texels", "solver"])]
    vary: Option<&'static [Sweep]>,
    /// Number of points and of their runs, and fineness of their base [default: normal]
    #[arg(long, value_parser = choice_parser(&CHART_QUALITIES))]
    quality: Option<SolveQuality>,
    /// Texels per side of a face [default: 16, fewer where the dense solver can then be the truth; draft 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    texels: Option<u32>,
    /// Only these methods; not with --vary [default: all]
    #[arg(long, value_parser = choice_parser(&CHART_SOLVERS))]
    solver: Option<SolverKind>,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Returns the parser of `--vary`: the name of an option, or all.
fn sweeps_parser() -> impl TypedValueParser<Value = &'static [Sweep]> {
    let names = SWEEPS
        .iter()
        .map(|sweep| sweep.option.trim_start_matches('-'))
        .chain(["all"]);
    let values = names.map(|name| match name {
        "patches" => PossibleValue::new(name).alias("cells"),
        _ => PossibleValue::new(name),
    });
    PossibleValuesParser::new(values).map(|name| {
        let is_named = |sweep: &Sweep| sweep.option[2..] == name || sweep.option == "--patches" && name == "cells";
        match SWEEPS.iter().position(is_named) {
            Some(k) => &SWEEPS[k..=k],
            None => &SWEEPS[..],
        }
    })
}

/// Measures the scenes one by one and writes the chart.
pub fn run(arguments: &ChartArguments) -> Result<Outcome> {
    let path = arguments.out.join("peers.json");
    let peers = match path.exists() && arguments.vary.is_none() {
        true => read_peers(&path)?,
        false => Vec::new(),
    };
    let gpu = open_gpu(arguments)?;
    let scenes = load_scenes(arguments)?;
    prepare_folder(&arguments.out, &CHART_FILES)?;
    let mut store = MeasurementStore::open(&arguments.out)?;
    handle_interrupts();
    let mut charts: Vec<SceneChart> = Vec::new();
    for scene in scenes.iter().take_while(|_| !is_interrupted()) {
        charts.push(measure_scene(arguments, scene, gpu.as_ref(), &peers, &mut store)?);
    }
    if charts.iter().all(|chart| chart.iterate_points().next().is_none()) && is_interrupted() {
        return Err(Error::Interrupted);
    }
    let json = format!("{:#}\n", chart_json(&charts));
    let svg = svg_file(&titled_plots(&charts));
    let files = CHART_FILES.into_iter().zip([json, svg, render_page(&charts)]);
    write_files(&arguments.out, files)?;
    if is_interrupted() {
        message!("interrupted: the chart holds what was measured by then; the same command continues it");
    }
    charts.iter().for_each(print_summary);
    message!(
        "wrote {0}/chart.html, {0}/chart.svg and {0}/chart.json",
        arguments.out.display()
    );
    Ok(Outcome::Done)
}

/// Opens the adapter. Without one the chart has no points of the GPU, and the CPU's twin draws item buffers.
///
/// Errors: there is no adapter and the GPU is required, or an option contradicts `--solver cpu`.
fn open_gpu(arguments: &ChartArguments) -> Result<Option<Gpu>> {
    let adapter = arguments.adapter.as_deref();
    if arguments.solver == Some(SolverKind::Cpu) {
        return match adapter {
            Some(_) => Err(Error::Usage(
                "--adapter contradicts --solver cpu: leave one of them out".into(),
            )),
            None => Ok(None),
        };
    }
    match Gpu::open(adapter) {
        Err(error @ Error::NoAdapter(_)) if adapter.is_none() && arguments.solver.is_none() => {
            message!("note: {error}; the chart has no GPU");
            Ok(None)
        }
        opened => opened.map(Some),
    }
}

/// Reads the scenes, by default the bundled ones. Errors: one cannot be read or is dark.
fn load_scenes(arguments: &ChartArguments) -> Result<Vec<Scene>> {
    let bundled = &CHARTED_SCENES[..if arguments.vary.is_some() { 2 } else { 3 }];
    let paths = match arguments.scenes.as_slice() {
        [] => bundled
            .iter()
            .map(|name| bundled_scene(name, &arguments.out))
            .collect::<Result<_>>()?,
        given => given.to_vec(),
    };
    let lit = |path: &PathBuf| load_lit_scene(path, &ImportOptions::default());
    paths.iter().map(lit).collect()
}

/// Measures the methods of a draft on both solvers, each once.
///
/// Errors: the truth cannot be solved, or a file cannot be written.
pub fn measure_draft(scene: &Scene, gpu: &Gpu, out: &Path) -> Result<SceneChart> {
    let arguments = ChartArguments {
        scenes: Vec::new(),
        out: out.to_path_buf(),
        vary: None,
        quality: Some(SolveQuality::Draft),
        texels: None,
        solver: None,
        adapter: None,
    };
    let mut store = MeasurementStore::open(out)?;
    measure_scene(&arguments, scene, Some(gpu), &[], &mut store)
}

/// Measures a scene, until Ctrl-C.
fn measure_scene(
    arguments: &ChartArguments,
    scene: &Scene,
    gpu: Option<&Gpu>,
    peers: &[Peer],
    store: &mut MeasurementStore,
) -> Result<SceneChart> {
    let quality = arguments.quality.unwrap_or_default();
    let texels = arguments.texels.unwrap_or_else(|| truth_texels(scene, quality));
    let solvers: &[SolverKind] = match (arguments.solver, gpu) {
        (Some(SolverKind::Gpu), _) => &[SolverKind::Gpu],
        (None, Some(_)) => &[SolverKind::Cpu, SolverKind::Dense, SolverKind::Gpu],
        _ => &[SolverKind::Cpu, SolverKind::Dense],
    };
    let (sets, texels, time_limit, repeats) = match arguments.vary {
        None => {
            let all = MethodSet::of_solvers(scene, solvers, quality, texels);
            let repeats = if quality == SolveQuality::Draft {
                1
            } else {
                RUNS_PER_METHOD
            };
            (vec![all], Some(texels), MAX_SOLVE_SECONDS, repeats)
        }
        Some(sweeps) => {
            let sets = sweeps.iter().map(|sweep| sweep.method_set(gpu.is_some()));
            (sets.collect(), None, f64::INFINITY, 1)
        }
    };
    let bench = ChartBench {
        scene,
        gpu,
        dir: &arguments.out,
        program: hash_program(),
        texels,
        time_limit,
        repeats,
    };
    let name = &scene.name;
    let stored: usize = sets.iter().map(|set| bench.count_stored(set, store)).sum();
    if stored > 0 {
        message!("note: {name}: continues after {stored} measurements in chart.partial.json");
    }
    let progress = Progress::new(name);
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let measured = sets.iter().map(|set| bench.measure_set(set, store, &show));
    Ok(SceneChart {
        scene: name.clone(),
        faces: scene.faces.len(),
        texels,
        adapter: gpu.map(|gpu| match gpu.line.software {
            true => format!("{} (software: its times say nothing about a GPU)", gpu.line.name),
            false => gpu.line.name.clone(),
        }),
        sets: measured.collect::<Result<_>>()?,
        peers: peers.iter().filter(|peer| peer.solved_scene(name)).cloned().collect(),
    })
}

fn print_summary(chart: &SceneChart) {
    let (scene, missing) = (&chart.scene, chart.count_missing());
    let points = chart.iterate_points().count();
    let failed = chart
        .iterate_points()
        .filter(|point| point.solve_figures().is_none())
        .count();
    message!("{scene}: {points} points, {failed} failed, {missing} not measured");
    for set in &chart.sets {
        message!("{scene}: truth: {}", set.truth);
        for (name, points) in set.split_by_curve() {
            let order = set
                .curve_order(points)
                .map_or("–".into(), |order| format!("{order:.2}"));
            message!("{scene}: {name}: order {order}");
        }
    }
}
