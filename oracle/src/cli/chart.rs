//! `radiosity chart`.

use super::Outcome;
use super::bundled::{bundled, found};
use super::progress::{Progress, interrupted, listen};
use super::scene::Materials;
use super::tell::say;
use crate::show::number::{number, percent};
use crate::solve::watch::Watch;
use crate::study::chart::measure::Bench;
use crate::study::chart::methods::{self, Method};
use crate::study::chart::page::{LEVELS, winner};
use crate::study::chart::peers::{self, Peer};
use crate::study::chart::store::{Context, Store, content, program};
use crate::study::chart::study::{Kept, Study, points, round};
use crate::study::chart::truth::Truth;
use crate::study::chart::{Solver, json, page, plot};
use clap::{Args, ValueEnum};
use common::import::{ImportOptions, load};
use common::scene::Scene;
use common::settings::Quality;
use common::solution::{prepare, write_file};
use common::text::plain;
use common::{Error, Result};
use gpu::Gpu;
use std::path::{Path, PathBuf};

/// The bundled scenes that are charted.
const SCENES: [&str; 3] = ["cornell_box.obj", "paper_room_objects.obj", "furnace.obj"];

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
pub struct Arguments {
    /// .obj, .gltf or .glb files [default: the bundled Cornell box, paper's room and furnace]
    scenes: Vec<PathBuf>,
    /// Where chart.html, chart.svg and chart.json go; measurements already there are reused
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// How many points, and how fine their base is [default: normal]
    #[arg(long, value_enum)]
    quality: Option<QualityOption>,
    /// Texels per side of a face that are asked for [default: 16, fewer where the matrix can then be the truth; draft 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    texels: Option<u32>,
    /// A result of the scene taken as the truth [default: the matrix solver's, or else the CPU's to 0.2 %]
    #[arg(long, value_name = "DIR")]
    truth: Option<PathBuf>,
    /// Only these methods [default: all]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// Runs of each point, in turns
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: u32,
    /// Seconds after which a solve is given up
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    limit: f64,
    /// Other programs' solves [default: DIR/peers.json, if it is there]
    #[arg(long, value_name = "FILE")]
    peers: Option<PathBuf>,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Fail with exit code 3 when there is no GPU
    #[arg(long)]
    require_gpu: bool,
    #[command(flatten)]
    materials: Materials,
    /// Make a front of each back
    #[arg(long)]
    two_sided: bool,
    /// Join two triangles of a glTF mesh that form a planar convex quad
    #[arg(long)]
    join_quads: bool,
    /// No progress, no summary
    #[arg(long)]
    quiet: bool,
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("{text} is not a time in seconds above 0")),
    }
}

impl Arguments {
    fn quality(&self) -> Quality {
        match self.quality {
            Some(QualityOption::Draft) => Quality::Draft,
            Some(QualityOption::Normal) | None => Quality::Normal,
        }
    }
}

/// Measures scene after scene, and writes after each round.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let others = others(arguments)?;
    let gpu = open(arguments)?;
    let scenes = scenes(arguments)?;
    let given = given_truth(arguments, &scenes)?;
    prepare(&arguments.out)?;
    let mut store = Store::open(&arguments.out.join("chart.partial.jsonl"))?;
    if store.damaged > 0 {
        say!(
            "note: {} damaged lines of chart.partial.jsonl are skipped",
            store.damaged
        );
    }
    listen();
    let paper = found(SCENES[1], &arguments.out);
    let paper = paper.and_then(|path| load(&path, &ImportOptions::default()).ok());
    let paper = paper.map(|scene| content(&scene));
    let mut studies = Vec::new();
    for scene in &scenes {
        let program = Program {
            arguments,
            gpu: gpu.as_ref(),
            others: &others,
            given: given.as_ref(),
            paper: paper == Some(content(scene)),
        };
        let study = match program.chart(scene, &mut store, &studies) {
            // Nothing of this scene, but the others are there.
            Err(Error::Interrupted) if !studies.is_empty() => break,
            other => other?,
        };
        studies.push(study);
        if interrupted() {
            break;
        }
    }
    write(&arguments.out, &studies)?;
    if interrupted() {
        say!(
            "interrupted: the chart holds what was measured by then; the same command continues it"
        );
    }
    if !arguments.quiet {
        studies.iter().for_each(summary);
        say!(
            "wrote {0}/chart.html, {0}/chart.svg and {0}/chart.json",
            arguments.out.display()
        );
    }
    Ok(Outcome::Done)
}

/// What is the same for all scenes.
struct Program<'a> {
    arguments: &'a Arguments,
    gpu: Option<&'a Gpu>,
    others: &'a [Peer],
    given: Option<&'a Truth>,
    paper: bool,
}

impl Program<'_> {
    fn chart(&self, scene: &Scene, store: &mut Store, before: &[Study]) -> Result<Study> {
        let arguments = self.arguments;
        let quality = arguments.quality();
        let texels = arguments
            .texels
            .unwrap_or_else(|| methods::texels(scene, quality));
        let context = |truth: u64| Context {
            scene: content(scene),
            truth,
            program: program(),
            asked: (texels, arguments.limit),
            adapter: self.gpu.map_or(String::new(), |gpu| gpu.line.name.clone()),
        };
        let progress = Progress::new(&scene.name, arguments.quiet);
        let show = |phase: &str, done| progress.show(phase, done);
        let watch = Watch::new(&show);
        let own;
        let truth = match self.given {
            Some(given) => given,
            None => {
                let name = format!("truth-{:016x}", self.digest(scene, texels));
                let dir = arguments.out.join(name);
                own = Truth::own(scene, texels, &dir, &watch)?;
                own.check(scene)?;
                &own
            }
        };
        let bench = Bench {
            scene,
            gpu: self.gpu,
            truth,
            texels,
            longest: arguments.limit,
        };
        let methods = self.methods(scene, quality, texels);
        let context = context(truth.id);
        let mut kept = Kept {
            store,
            context: &context,
        };
        let there = methods
            .iter()
            .map(|m| kept.store.runs(&context.key(m)).len())
            .sum::<usize>();
        if there > 0 {
            say!(
                "note: {}: continues after {there} measurements in chart.partial.jsonl",
                scene.name
            );
        }
        let study = |kept: &Kept| {
            let points = points(&bench, &methods, kept, arguments.repeats as usize);
            self.study(scene, texels, truth, methods.len() - points.len(), points)
        };
        for number in 0..arguments.repeats as usize {
            let flow = round(&bench, &methods, &mut kept, number, &watch)?;
            let so_far: Vec<Study> = before.iter().cloned().chain([study(&kept)]).collect();
            write(&arguments.out, &so_far)?;
            if flow.is_break() {
                break;
            }
        }
        Ok(study(&kept))
    }

    /// What our own truth hangs on.
    fn digest(&self, scene: &Scene, texels: u32) -> u64 {
        crate::study::chart::store::digest(&(content(scene), texels, program()))
    }

    fn methods(&self, scene: &Scene, quality: Quality, texels: u32) -> Vec<Method> {
        let only = self.arguments.solver;
        let of = |solver| methods::methods(scene, solver, quality, texels);
        let mut all = Vec::new();
        if only != Some(SolverOption::Gpu) {
            all.extend(of(Solver::Cpu));
            // On the texels of a truth of its own it would be the truth.
            let truth =
                |m: &Method| self.arguments.truth.is_none() && m.settings.meshing.texels == texels;
            all.extend(of(Solver::Matrix).into_iter().filter(|m| !truth(m)));
        }
        if only != Some(SolverOption::Cpu) && self.gpu.is_some() {
            all.extend(of(Solver::Gpu));
        }
        all
    }

    fn study(
        &self,
        scene: &Scene,
        texels: u32,
        truth: &Truth,
        missing: usize,
        points: Vec<crate::study::chart::study::Point>,
    ) -> Study {
        let solved = |peer: &&Peer| peer.solved(&scene.name);
        Study {
            scene: scene.name.clone(),
            faces: scene.faces.len(),
            texels,
            truth: truth.name.clone(),
            adapter: self.gpu.map(|gpu| gpu.line.name.clone()),
            software: self.gpu.is_some_and(|gpu| gpu.line.software),
            paper: self.paper,
            points,
            missing,
            peers: self.others.iter().filter(solved).cloned().collect(),
        }
    }
}

fn scenes(arguments: &Arguments) -> Result<Vec<Scene>> {
    if arguments.truth.is_some() && arguments.scenes.len() != 1 {
        return Err(Error::Usage("--truth belongs to one SCENE: name it".into()));
    }
    let ours = |name| bundled(name, &arguments.out);
    let paths = match arguments.scenes.as_slice() {
        [] => SCENES.into_iter().map(ours).collect::<Result<_>>()?,
        given => given.to_vec(),
    };
    let options = ImportOptions {
        join_quads: arguments.join_quads,
        two_sided: arguments.two_sided,
        ..ImportOptions::default()
    };
    let lit = |path: &PathBuf| arguments.materials.lit(path, options);
    paths.iter().map(lit).collect()
}

/// The result that `--truth` names, of the one scene.
fn given_truth(arguments: &Arguments, scenes: &[Scene]) -> Result<Option<Truth>> {
    let Some(dir) = &arguments.truth else {
        return Ok(None);
    };
    let truth = Truth::read(dir, plain(&dir.display().to_string()))?;
    scenes.iter().try_for_each(|scene| truth.check(scene))?;
    Ok(Some(truth))
}

fn others(arguments: &Arguments) -> Result<Vec<Peer>> {
    let there = arguments.out.join("peers.json");
    match &arguments.peers {
        Some(path) => peers::read(path),
        None if there.exists() => peers::read(&there),
        None => Ok(Vec::new()),
    }
}

/// Without an adapter the chart is the CPU's, unless the GPU was asked for.
fn open(arguments: &Arguments) -> Result<Option<Gpu>> {
    let needed = arguments.require_gpu || arguments.solver == Some(SolverOption::Gpu);
    if arguments.solver == Some(SolverOption::Cpu) {
        let given = [
            ("--require-gpu", arguments.require_gpu),
            ("--adapter", arguments.adapter.is_some()),
        ];
        if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
            return Err(Error::Usage(format!(
                "{option} contradicts --solver cpu: leave one of them out"
            )));
        }
        return Ok(None);
    }
    match Gpu::open(arguments.adapter.as_deref()) {
        Ok(gpu) => Ok(Some(gpu)),
        Err(error @ Error::NoAdapter(_)) if !needed && arguments.adapter.is_none() => {
            say!("note: {error}; the chart has no GPU");
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

fn write(out: &Path, studies: &[Study]) -> Result<()> {
    let text = format!("{:#}\n", json::json(studies));
    write_file(&out.join("chart.json"), text.as_bytes())?;
    let charts: Vec<(String, String)> = studies
        .iter()
        .filter_map(|study| Some((study.scene.clone(), plot::svg(study)?)))
        .collect();
    write_file(&out.join("chart.svg"), plot::file(&charts).as_bytes())?;
    write_file(&out.join("chart.html"), page::html(studies).as_bytes())
}

fn summary(study: &Study) {
    let failed = study.points.iter().filter(|p| p.failure().is_some());
    say!(
        "{}: {} points, {} failed, {} not measured; truth: {}",
        study.scene,
        study.points.len(),
        failed.count(),
        study.missing,
        study.truth
    );
    for solver in study.solvers() {
        let texts = LEVELS.map(|level| match winner(study, solver, level) {
            Some(point) => format!(
                "{} in {} s ({})",
                percent(level),
                number(point.seconds()),
                point.method.options
            ),
            None => format!("{} never", percent(level)),
        });
        say!("{}: {}: {}", study.scene, solver.name(), texts.join(", "));
    }
}
