//! `radiosity solve` and `radiosity shoot`.

use super::bake::BakeOptions;
use super::console::{self, message};
use super::options::{CommonOptions, PassOptions, ShootingOptions, choice_parser, load_lit_scene, parse_error};
use super::progress::{Progress, handle_interrupts, read_with_progress};
use super::solver::{SHOOTING_SOLVERS, SOLVERS, SolverOption, choose_solver, open_gpu};
use super::{Outcome, plan};
use crate::plan::coarser_defaults::coarsen_meshing;
use crate::plan::memory::{MemoryLimit, check_memory};
use crate::report::gltf_export::uv_charts::UvCharts;
use crate::report::solution_view::{RenderedView, SolutionView};
use crate::report::view::camera::Camera;
use clap::Args;
use common::capture::maps;
use common::energy::EnergyBalance;
use common::scene::Scene;
use common::settings::{Meshing, Settings};
use common::solution::pending::PendingFiles;
use common::solution::{PhaseSeconds, Solution, prepare_directory};
use common::{Error, Result};
use glam::Vec3;
use gpu::Gpu;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::DenseReport;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveAnswer, SolveRequest, dense, solve_request};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Names of the files that a solve writes.
const OUTPUT_FILES: &str = "preview.png, view.html, lightmap.exr and result.json";

/// Arguments of `solve`.
#[derive(Args)]
pub struct SolveArguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    scene: PathBuf,
    /// Solver [default: gpu where there is a hardware adapter, else cpu; cpu with --error]
    #[arg(long, value_parser = choice_parser(&SOLVERS))]
    solver: Option<SolverOption>,
    /// Refine until the estimated error is at most P per cent, 0.2 to 10 [default: 1]
    #[arg(long, value_name = "P%", value_parser = parse_error, conflicts_with = "quality")]
    error: Option<f64>,
    #[command(flatten)]
    output: OutputOptions,
    #[command(flatten)]
    common: CommonOptions,
}

/// Arguments of `shoot`.
#[derive(Args)]
pub struct ShootArguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    scene: PathBuf,
    /// Solver [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_parser = choice_parser(&SHOOTING_SOLVERS))]
    solver: Option<SolverOption>,
    #[command(flatten)]
    shooting: ShootingOptions,
    #[command(flatten)]
    passes: PassOptions,
    #[command(flatten)]
    output: OutputOptions,
    #[command(flatten)]
    common: CommonOptions,
}

/// Options of `solve` and `shoot` about what is written.
#[derive(Args, Default)]
struct OutputOptions {
    /// Folder for preview.png, view.html, lightmap.exr and result.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Estimate texels, memory and time, and solve nothing
    #[arg(long)]
    dry_run: bool,
    /// Also write each face's light as an HDR map into DIR/maps: a room for relight
    #[arg(long)]
    maps: bool,
    #[command(flatten)]
    bake: BakeOptions,
    /// Also print result.json without its faces (or the estimates) as one line on stdout
    #[arg(long)]
    json: bool,
}

/// A scene to solve: by shooting, to an error, or by the dense system.
struct SceneJob<'a> {
    scene: &'a Path,
    solver: SolverOption,
    error: f64,
    shooting: Option<(&'a ShootingOptions, &'a PassOptions)>,
    output: &'a OutputOptions,
    common: &'a CommonOptions,
}

/// Solves a scene to an error, or exactly by the dense system, and writes the result.
pub fn run_solve(arguments: &SolveArguments) -> Result<Outcome> {
    let SolveArguments { error, common, .. } = arguments;
    if arguments.solver == Some(SolverOption::Dense) {
        let quality = common.quality.map(|_| "--quality");
        let unused = error.map(|_| "--error").or(quality).or(common.gpu_option());
        if let Some(option) = unused {
            return Err(Error::Usage(format!(
                "{option} does not go with --solver dense, which solves all texels exactly on the CPU: leave it out"
            )));
        }
    }
    let asked = arguments.solver.or(error.map(|_| SolverOption::Cpu));
    solve_scene(&SceneJob {
        scene: &arguments.scene,
        solver: choose_solver(asked, common)?,
        error: error.unwrap_or(common.quality_error()),
        shooting: None,
        output: &arguments.output,
        common,
    })
}

/// Solves a scene by progressive refinement with the settings given, and writes the result.
pub fn run_shoot(arguments: &ShootArguments) -> Result<Outcome> {
    let common = &arguments.common;
    let solver = choose_solver(arguments.solver, common)?;
    arguments.shooting.visibility_in_force(solver == SolverOption::Gpu)?;
    solve_scene(&SceneJob {
        scene: &arguments.scene,
        solver,
        error: 0.0,
        shooting: Some((&arguments.shooting, &arguments.passes)),
        output: &arguments.output,
        common,
    })
}

/// Solves a scene on the CPU into `out`, for a comparison without an adapter.
pub fn solve_on_cpu(
    scene: &Path,
    out: &Path,
    error: f64,
    shooting: Option<(&ShootingOptions, &PassOptions)>,
    common: &CommonOptions,
) -> Result<Outcome> {
    let output = OutputOptions {
        out: out.to_path_buf(),
        ..OutputOptions::default()
    };
    solve_scene(&SceneJob {
        scene,
        solver: SolverOption::Cpu,
        error,
        shooting,
        output: &output,
        common,
    })
}

fn solve_scene(job: &SceneJob) -> Result<Outcome> {
    let SceneJob { output, common, .. } = *job;
    let (out, quiet) = (&output.out, common.quiet);
    let start = Instant::now();
    let import = output.bake.import_options(common)?;
    let scene = read_with_progress(job.scene, quiet, || load_lit_scene(job.scene, &import))?;
    let (device, missing) = open_gpu(job.solver, common)?;
    let (settings, solver, changed) = job.choose_settings(&scene, device.as_ref())?;
    if output.dry_run {
        plan::print_plan(&scene, &settings, solver, changed.as_deref(), [output.json, quiet])?;
        return missing.map_or(Ok(Outcome::Done), Err);
    }
    check_memory(&scene, &settings, solver, MemoryLimit::of_this_machine())?;
    let charts = import.charts.then(|| UvCharts::new(&scene)).transpose()?;
    let load = start.elapsed().as_secs_f64();
    prepare_directory(out)?;
    if let Some(folder) = output.bake.gltf.as_ref().and_then(|path| path.parent()) {
        prepare_directory(&Path::new(".").join(folder))?;
    }
    handle_interrupts();
    let early: Vec<String> = scene.notes.iter().cloned().chain(changed).collect();
    for note in &early {
        message!("note: {}: {note}", scene.name);
    }
    let question = SolveRequest {
        task: &scene,
        settings: &settings,
        solver,
    };
    let progress = Progress::new(&scene.name, quiet);
    // The first step of a large scene takes seconds before it reports progress.
    let _ = progress.show_phase("prepare", 0.0);
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let watch = ProgressMonitor::new(&show);
    let answered = solve_request(&question, &watch)?;
    progress.clear();
    let fewer = fewer_patches_note(&settings).filter(|_| solver.is_shooting());
    let mut notes = early;
    for note in answered.notes.iter().cloned().chain(fewer) {
        message!("note: {note}");
        notes.push(note);
    }
    let seconds = PhaseSeconds {
        load,
        prepare: watch.phase_seconds(&["prepare"]),
        solve: watch.phase_seconds(&["solve"]),
    };
    let solution = answered.to_solution(&question, &notes, seconds);
    solution.write(out)?;
    let seen = view_inputs(&solution, None).render_view()?;
    let mut files = PendingFiles::default();
    add_view_files(&seen, out, &mut files)?;
    output.bake.add_files(&mut files, (&solution, charts.as_ref()), &seen)?;
    files.rename_files()?;
    if output.maps {
        write_maps(&solution, out)?;
    }
    if !quiet {
        print_summary(&solution, &answered);
        print_warnings_and_files(&solution, OUTPUT_FILES, out);
    }
    if output.json {
        console::print_json(&solution.summarise_run())?;
    }
    missing.map_or(Ok(Outcome::Done), Err)
}

impl SceneJob<'_> {
    /// Returns settings and solver, and a note if the scene's many faces changed the settings.
    fn choose_settings<'g>(
        &self,
        scene: &Scene,
        gpu: Option<&'g Gpu>,
    ) -> Result<(Settings, SolverChoice<'g>, Option<String>)> {
        let common = self.common;
        let Some((shooting, passes)) = self.shooting else {
            let (shooting, passes) = (ShootingOptions::default(), PassOptions::default());
            let mut settings = common.shooting_settings(&shooting, &passes, false)?;
            settings.schedule = settings.schedule.with_southwell();
            if self.solver == SolverOption::Dense {
                let settings = dense::dense_settings(settings.meshing.texels);
                return Ok((settings, SolverChoice::Dense, None));
            }
            let target = ErrorTarget {
                error: self.error,
                texels: common.texels,
            };
            return Ok((settings, SolverChoice::to_error(gpu, target), None));
        };
        let without = shooting.without_gpu();
        let shooting = if gpu.is_some() { shooting } else { &without };
        let (settings, changed) = scene_settings(scene, common, shooting, passes, gpu.is_some())?;
        Ok((settings, SolverChoice::shooting_on(gpu), changed))
    }
}

/// Returns the settings of a solve by shooting, and a note if the scene's many faces make the defaults coarser.
///
/// Errors: options contradict each other.
pub fn scene_settings(
    scene: &Scene,
    common: &CommonOptions,
    shooting: &ShootingOptions,
    passes: &PassOptions,
    on_gpu: bool,
) -> Result<(Settings, Option<String>)> {
    let mut settings = common.shooting_settings(shooting, passes, on_gpu)?;
    let given = [common.texels, shooting.patches, shooting.samples];
    let given = given.map(|option| option.is_some() || common.quality.is_some());
    let (meshing, changed) = coarsen_meshing(scene, &settings.meshing, given);
    settings.meshing = meshing;
    Ok((settings, changed))
}

/// Returns a note if fewer patches shoot than were set: a patch is a block of whole texels.
fn fewer_patches_note(settings: &Settings) -> Option<String> {
    let Meshing { patches, texels, .. } = settings.meshing;
    (patches > texels).then(|| {
        format!("{texels}×{texels} patches a face instead of {patches}×{patches}: a patch has at least one texel")
    })
}

/// Returns what picture and view need of a solution.
pub fn view_inputs<'a>(solution: &'a Solution, camera: Option<Camera>) -> SolutionView<'a> {
    SolutionView {
        scene: solution.scene,
        mesh: solution.mesh,
        field: &solution.run.field,
        texel_errors: solution.texel_error.as_deref(),
        solver: solution.solver,
        adapter: solution.adapter,
        error: estimated_error(solution),
        camera,
    }
}

fn estimated_error(solution: &Solution) -> Option<f64> {
    solution.certificate.as_ref().and_then(|parts| parts["error"].as_f64())
}

/// Adds preview.png and view.html to `files`.
///
/// Errors: they cannot be written.
pub fn add_view_files(seen: &RenderedView, out: &Path, files: &mut PendingFiles) -> Result<()> {
    files.add(&out.join("preview.png"), &seen.preview.picture.encode_png())?;
    files.add(&out.join("view.html"), seen.page.as_bytes())
}

/// Writes the radiance map of every face.
fn write_maps(solution: &Solution, out: &Path) -> Result<()> {
    let (mesh, field) = (solution.mesh, &solution.run.field);
    let texels = mesh.texels_in_face_order().into_iter();
    let radiosity: Vec<Vec3> = texels.map(|k| field.radiosity[k].truncate()).collect();
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
    maps::write(&out.join("maps"), solution.scene, &resolutions, &radiosity)
}

/// Prints what was solved, how, and how well.
fn print_summary(solution: &Solution, answered: &SolveAnswer) {
    let energy = EnergyBalance::new(solution.mesh, &solution.run.field, &solution.run.shots);
    let share = |power| 100.0 * energy.share_of_emitted(power);
    let run = solution.run;
    let work = match (&answered.solved.dense, &answered.solved.history) {
        (Some(dense), _) => describe_dense(dense, solution),
        (None, history) => format!(
            "{} in {} passes on {} in {:.2} s, {:.3} % unshot",
            match history {
                Some(history) => format!("{} links", history.links),
                None => format!("{} shots", run.shooters),
            },
            run.passes,
            solution.adapter.unwrap_or("the CPU"),
            solution.seconds.solve,
            100.0 * run.unshot_fraction(),
        ),
    };
    let error = estimated_error(solution);
    message!(
        "{}: {} faces, {} texels, {work}, imbalance {:.1e}, escaped {:.2} %, form-factor error {:.2} %{}",
        solution.scene.name,
        solution.mesh.faces.len(),
        solution.mesh.texels.len(),
        energy.imbalance,
        share(energy.escaped),
        share(energy.closure),
        error.map_or(String::new(), |error| format!(", about {:.1} % off", 100.0 * error)),
    );
}

fn describe_dense(dense: &DenseReport, solution: &Solution) -> String {
    let quality = &dense.quality;
    format!(
        "dense system of {:.0} MB in {:.2} s, solved in {:.2} s to {:.1e}; {} pairs exact, {} sampled, reciprocity {:.1e}, rows' closure ≤ {:.1e} (mean {:.1e})",
        quality.bytes as f64 / 1e6,
        solution.seconds.prepare,
        solution.seconds.solve,
        dense.solution.residual,
        quality.exact_pairs,
        quality.sampled_pairs,
        quality.reciprocity,
        quality.closure_max,
        quality.closure_mean,
    )
}

/// Prints the warnings and the folder of the files.
pub fn print_warnings_and_files(solution: &Solution, files: &str, out: &Path) {
    for warning in solution.warnings {
        message!("warning: {}", warning.message);
    }
    message!("wrote {files} in {}", out.display());
}
