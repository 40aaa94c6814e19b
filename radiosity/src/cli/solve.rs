//! `radiosity solve` and `radiosity shoot`.

use super::bake::BakeOptions;
use super::console::{self, message};
use super::options::{CommonOptions, ShootingOptions, parse_error, scene_settings, visibility_in_force};
use super::progress::{Progress, handle_interrupts, read_with_progress};
use super::scene::{DarkOption, MaterialOptions};
use super::solver::{SolverOption, choose_solver, choose_solver_for_error, open_gpu};
use super::{Outcome, plan};
use crate::plan::forecast::announce_long_solve;
use crate::plan::memory_limit::{MemoryLimit, check_dense_memory, check_memory, check_texels};
use crate::report::gltf_export::uv_charts::UvCharts;
use crate::report::solution_view::{RenderedView, SolutionView};
use crate::report::view::camera::Camera;
use clap::{Args, ValueEnum};
use common::Result;
use common::capture::maps;
use common::energy::EnergyBalance;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Meshing, Settings, Visibility};
use common::shooting::RadiosityField;
use common::solution::pending::PendingFiles;
use common::solution::{PhaseSeconds, Solution, prepare_directory};
use glam::Vec3;
use oracle::solve::error_estimate::ErrorHistory;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::DenseReport;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveRequest, dense, solve_request};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Names of the files that a solve writes.
const OUTPUT_FILES: &str = "preview.png, view.html, lightmap.exr and result.json";

/// Arguments of `solve`. The options of shooting are hidden in it: `shoot` has them, and `solve` still accepts them.
#[derive(Args)]
pub struct SolveArguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    pub scene: PathBuf,
    /// Solver [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// Refine until the estimated error is at most P per cent, 0.2 to 10 [default: 1]
    #[arg(long, value_name = "P%", value_parser = parse_error, allow_negative_numbers = true)]
    pub error: Option<f64>,
    #[command(flatten)]
    run: RunOptions,
    #[command(flatten)]
    pub common: CommonOptions,
}

/// Arguments of `shoot`.
#[derive(Args)]
pub struct ShootArguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    pub scene: PathBuf,
    /// Solver [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_enum)]
    solver: Option<ShootingSolver>,
    #[command(flatten)]
    run: RunOptions,
    #[command(flatten)]
    pub common: CommonOptions,
}

/// `--solver` of `shoot`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ShootingSolver {
    /// Rays, or the scalar twin of the item buffer
    Cpu,
    /// Item buffer, or rays
    Gpu,
}

impl From<ShootingSolver> for SolverOption {
    fn from(option: ShootingSolver) -> Self {
        match option {
            ShootingSolver::Cpu => Self::Cpu,
            ShootingSolver::Gpu => Self::Gpu,
        }
    }
}

/// Options of `solve` and `shoot` about what is read and written.
#[derive(Args, Default)]
struct RunOptions {
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
    /// Treat warnings as errors: exit code 1, after writing
    #[arg(long)]
    strict: bool,
    /// Also print result.json without its faces (or the estimates) as one line on stdout
    #[arg(long)]
    json: bool,
    /// Use solver and settings of an earlier result.json; options given override them
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    #[command(flatten)]
    materials: MaterialOptions,
    #[command(flatten)]
    dark: DarkOption,
}

impl SolveArguments {
    /// Returns the `--settings` file.
    pub fn settings_file(&self) -> Option<&Path> {
        self.run.settings.as_deref()
    }
}

impl ShootArguments {
    /// Returns the `--settings` file.
    pub fn settings_file(&self) -> Option<&Path> {
        self.run.settings.as_deref()
    }
}

/// A scene to solve, by a solver and to an error; without an error it shoots, or solves the dense system.
struct SceneJob<'a> {
    scene: &'a Path,
    solver: SolverOption,
    error: Option<f64>,
    run: &'a RunOptions,
    common: &'a CommonOptions,
}

/// Solves a scene on the CPU, for a comparison without an adapter.
pub fn solve_on_cpu(
    (scene, materials): (&Path, &MaterialOptions),
    out: &Path,
    error: Option<f64>,
    common: &CommonOptions,
) -> Result<Outcome> {
    // Without --visibility the CPU uses rays, to which these do not apply.
    let twin = common.shooting.visibility.is_some();
    let common = CommonOptions {
        require_gpu: false,
        adapter: None,
        shooting: ShootingOptions {
            item_buffer: common.shooting.item_buffer.filter(|_| twin),
            raster: common.shooting.raster.filter(|_| twin),
            lookup: common.shooting.lookup.filter(|_| twin),
            ..common.shooting.clone()
        },
        ..common.clone()
    };
    let run = RunOptions {
        out: out.to_path_buf(),
        materials: materials.clone(),
        ..RunOptions::default()
    };
    solve_scene(&SceneJob {
        scene,
        solver: SolverOption::Cpu,
        error: error.or(common.quality_error()),
        run: &run,
        common: &common,
    })
}

/// Solves a scene to an error, or exactly by the dense system, and writes the result.
///
/// With an option of shooting it does what `shoot` does, and says so.
pub fn run_solve(arguments: &SolveArguments) -> Result<Outcome> {
    let common = &arguments.common;
    let (solver, error) = if arguments.error.is_some() {
        let solver = choose_solver_for_error(arguments.solver, common)?;
        common.refuse_shooting_options()?;
        (solver, arguments.error)
    } else {
        let solver = choose_solver(arguments.solver, common)?;
        let error = common.quality_error();
        if let (Some(option), true) = (common.shooting.first_given(), solver != SolverOption::Dense) {
            message!("note: {option} is an option of `radiosity shoot` now; this run shoots, as `shoot` does");
        }
        (solver, error.filter(|_| solver != SolverOption::Dense))
    };
    solve_scene(&SceneJob {
        scene: &arguments.scene,
        solver,
        error,
        run: &arguments.run,
        common,
    })
}

/// Solves a scene by progressive refinement with the settings given, and writes the result.
pub fn run_shoot(arguments: &ShootArguments) -> Result<Outcome> {
    let common = &arguments.common;
    solve_scene(&SceneJob {
        scene: &arguments.scene,
        solver: choose_solver(arguments.solver.map(Into::into), common)?,
        error: None,
        run: &arguments.run,
        common,
    })
}

fn solve_scene(job: &SceneJob) -> Result<Outcome> {
    let SceneJob {
        solver: chosen,
        error,
        run,
        common,
        ..
    } = *job;
    match chosen {
        SolverOption::Dense => common.refuse_dense_conflicts()?,
        _ => common.refuse_item_buffer_options(visibility_in_force(common, chosen == SolverOption::Gpu))?,
    }
    let start = Instant::now();
    let import = run.bake.import_options(common)?;
    let scene = read_with_progress(job.scene, common.quiet, || {
        run.materials.load_scene_unless_dark(&run.dark, job.scene, import)
    })?;
    if run.dry_run {
        return plan::print_plan(&scene, Some(chosen), error, common, run.json);
    }
    let charts = run.bake.kept_charts(&scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    for note in &scene.notes {
        message!("note: {}: {note}", scene.name);
    }
    let (device, missing) = open_gpu(chosen, common)?;
    let solver = match (error, chosen) {
        (Some(error), _) => {
            let asked = ErrorTarget {
                error,
                texels: common.texels,
            };
            SolverChoice::to_error(device.as_ref(), asked)
        }
        (None, SolverOption::Dense) => SolverChoice::Dense,
        (None, _) => SolverChoice::shooting_on(device.as_ref()),
    };
    let (settings, changed) = fitting_settings(common, &scene, solver)?;
    prepare_directory(&run.out)?;
    run.bake.check_output_path()?;
    if let Some(changed) = &changed {
        message!("note: {changed}");
    }
    if !common.quiet
        && solver.is_shooting()
        && let Some(warning) = announce_long_solve(&scene, &settings, solver)?
    {
        message!("note: {warning}");
    }
    handle_interrupts();

    let question = SolveRequest {
        task: &scene,
        settings: &settings,
        solver,
    };
    let progress = Progress::new(&scene.name, common.quiet);
    // The first step of a large scene takes seconds before it reports progress.
    let _ = progress.show_phase("prepare", 0.0);
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let watch = ProgressMonitor::new(&show);
    let answered = solve_request(&question, &watch)?;
    progress.clear();
    let mut notes = scene.notes.clone();
    notes.extend(changed);
    let fewer = fewer_patches_note(&settings).filter(|_| solver.is_shooting());
    for note in answered.notes.iter().chain(&fewer) {
        message!("note: {note}");
        notes.push(note.clone());
    }
    let seconds = PhaseSeconds {
        load: load_seconds,
        prepare: watch.phase_seconds(&["prepare"]),
        solve: watch.phase_seconds(&["solve"]),
    };
    let solution = answered.to_solution(&question, &notes, seconds);
    solution.write(&run.out)?;
    write_views(&solution, run, charts.as_ref())?;
    if run.maps {
        write_maps(&scene, solution.mesh, &solution.run.field, &run.out)?;
    }
    if !common.quiet {
        match &answered.solved.dense {
            Some(dense) => print_dense_summary(&solution, dense),
            None => print_summary(&solution, answered.solved.history.as_ref()),
        }
        print_warnings_and_files(&solution, OUTPUT_FILES, &run.out);
    }
    if run.json {
        console::print_json(&solution.summarise_run())?;
    }
    missing.map_or(Ok(strict_outcome(&solution, run.strict)), Err)
}

/// Returns the settings in force and a note if the scene's size changed them.
///
/// Errors: there is not enough memory.
fn fitting_settings(common: &CommonOptions, scene: &Scene, solver: SolverChoice) -> Result<(Settings, Option<String>)> {
    if let Some(asked) = solver.error_target() {
        let settings = common.shot_settings(Visibility::Rays, FormFactor::Polygon)?;
        check_texels(scene, asked.texels.unwrap_or(1), MemoryLimit::of_this_machine())?;
        return Ok((settings, None));
    }
    if let SolverChoice::Dense = solver {
        let shooting = common.shot_settings(Visibility::Rays, FormFactor::Polygon)?;
        let settings = dense::dense_settings(shooting.meshing.texels);
        check_dense_memory(scene, settings.meshing.texels)?;
        return Ok((settings, None));
    }
    let (settings, changed) = scene_settings(common, scene, solver.gpu().is_some())?;
    check_memory(scene, &settings, solver.gpu(), MemoryLimit::of_this_machine())?;
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
    let certificate = solution.certificate.as_ref();
    SolutionView {
        scene: solution.scene,
        mesh: solution.mesh,
        field: &solution.run.field,
        texel_errors: solution.texel_error.as_deref(),
        solver: solution.solver,
        adapter: solution.adapter,
        error: certificate.and_then(|parts| parts["error"].as_f64()),
        camera,
    }
}

/// Writes the preview, the view and, under `--gltf`, the baked scene.
fn write_views(solution: &Solution, run: &RunOptions, charts: Option<&UvCharts>) -> Result<()> {
    let seen = view_inputs(solution, None).render_view()?;
    let mut files = PendingFiles::default();
    add_view_files(&seen, &run.out, &mut files)?;
    run.bake.add_files(&mut files, (solution, charts), &seen)?;
    files.rename_files()
}

/// Adds preview.png and view.html to `files`.
pub fn add_view_files(seen: &RenderedView, out: &Path, files: &mut PendingFiles) -> Result<()> {
    files.add(&out.join("preview.png"), &seen.preview.picture.encode_png())?;
    files.add(&out.join("view.html"), seen.page.as_bytes())
}

/// Writes the radiance map of every face.
pub fn write_maps(scene: &Scene, mesh: &Mesh, field: &RadiosityField, out: &Path) -> Result<()> {
    let radiosity: Vec<Vec3> = mesh
        .texels_in_face_order()
        .into_iter()
        .map(|k| field.radiosity[k].truncate())
        .collect();
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
    maps::write(&out.join("maps"), scene, &resolutions, &radiosity)
}

fn print_summary(solution: &Solution, moved: Option<&ErrorHistory>) {
    let energy = EnergyBalance::new(solution.mesh, &solution.run.field, &solution.run.shots);
    let certificate = solution.certificate.as_ref();
    let off = certificate.and_then(|parts| parts["error"].as_f64());
    message!(
        "{}: {} faces, {} texels, {} in {} passes on {} in {:.2} s, {:.3} % unshot, imbalance {:.1e}, escaped {:.2} %, form-factor error {:.2} %{}",
        solution.scene.name,
        solution.mesh.faces.len(),
        solution.mesh.texels.len(),
        moved.map_or_else(
            || format!("{} shots", solution.run.shooters),
            |moved| format!("{} links", moved.links)
        ),
        solution.run.passes,
        solution.adapter.unwrap_or("the CPU"),
        solution.seconds.solve,
        100.0 * solution.run.unshot_fraction(),
        energy.imbalance,
        100.0 * energy.share_of_emitted(energy.escaped),
        100.0 * energy.share_of_emitted(energy.closure),
        off.map_or(String::new(), |error| format!(", about {:.1} % off", 100.0 * error)),
    );
}

fn print_dense_summary(
    solution: &Solution,
    DenseReport {
        quality,
        solution: answer,
    }: &DenseReport,
) {
    let energy = EnergyBalance::new(solution.mesh, &solution.run.field, &solution.run.shots);
    message!(
        "{}: {} faces, {} texels, dense system of {:.0} MB in {:.2} s, solved in {:.2} s to {:.1e}; {} pairs exact, {} sampled, reciprocity {:.1e}, rows' closure ≤ {:.1e} (mean {:.1e}); imbalance {:.1e}, escaped {:.2} %, closure {:.2} %",
        solution.scene.name,
        solution.mesh.faces.len(),
        solution.mesh.texels.len(),
        quality.bytes as f64 / 1e6,
        solution.seconds.prepare,
        solution.seconds.solve,
        answer.residual,
        quality.exact_pairs,
        quality.sampled_pairs,
        quality.reciprocity,
        quality.closure_max,
        quality.closure_mean,
        energy.imbalance,
        100.0 * energy.share_of_emitted(energy.escaped),
        100.0 * energy.share_of_emitted(energy.closure),
    );
}

/// Returns the outcome of a solution: under `--strict` a warning is an error.
pub fn strict_outcome(solution: &Solution, strict: bool) -> Outcome {
    match solution.warnings {
        [first, rest @ ..] if strict => {
            let more = match rest.len() {
                0 => String::new(),
                n => format!(" (and {n} more)"),
            };
            console::print_error(&format!("{}: {}{more}", solution.scene.name, first.message));
            Outcome::Disagree
        }
        _ => Outcome::Done,
    }
}

/// Prints the warnings and the folder of the files.
pub fn print_warnings_and_files(solution: &Solution, files: &str, out: &Path) {
    for warning in solution.warnings {
        message!("warning: {}", warning.message);
    }
    message!("wrote {files} in {}", out.display());
}
