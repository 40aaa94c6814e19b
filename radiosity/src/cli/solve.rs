//! `radiosity solve` and `radiosity shoot`: solve a scene to an error, or by progressive refinement.

use super::bake::{BakeOptions, BakedScene};
use super::console::{message, output};
use super::lights::LightOptions;
use super::options::{CommonOptions, PassOptions, ShootingOptions, choice_parser, parse_error};
use super::progress::{Progress, handle_interrupts};
use super::solver::{SHOOTING_SOLVERS, SOLVERS, choose_solver, open_gpu};
use super::trace::{Recorder, TRACE_FILE};
use super::{Outcome, plan};
use crate::plan::coarser_defaults::coarsen_meshing;
use crate::plan::memory::{check_memory, memory_limit, require_address_space};
use crate::report::solution_view::RenderedView;
use clap::Args;
use common::capture::maps;
use common::energy::EnergyBalance;
use common::scene::Scene;
use common::settings::{Iteration, Meshing, Settings};
use common::solution::pending::{NamedBytes, PendingFiles};
use common::solution::{PhaseSeconds, Solution, prepare_outputs};
use common::{Error, Result};
use glam::Vec3;
use gpu::Gpu;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::DenseReport;
use oracle::solve::solver::{ErrorTarget, SolverChoice, SolverKind};
use oracle::solve::task::SolveTask;
use oracle::solve::{SolveAnswer, SolveRequest, dense, solve_request};
use std::path::PathBuf;
use std::time::Instant;

/// Files of every solve.
pub const SOLUTION_FILES: [&str; 5] = ["lightmap.exr", "error.exr", "preview.png", "view.html", "result.json"];

/// Arguments of `solve`.
#[derive(Args)]
pub struct SolveArguments {
    /// Solver [default: gpu where there is a hardware adapter, else cpu; cpu with --error]
    #[arg(long, value_parser = choice_parser(&SOLVERS))]
    solver: Option<SolverKind>,
    /// Refine until the estimated error is at most P per cent, 0.2 to 10 [default: 1]
    #[arg(long, value_name = "P%", value_parser = parse_error, conflicts_with = "quality")]
    error: Option<f64>,
    /// Also write trace.html: each step with its nodes, and the links of a texel that you point at
    #[arg(long)]
    trace: bool,
    #[command(flatten)]
    job: SceneJob,
}

/// Arguments of `shoot`.
#[derive(Args)]
pub struct ShootArguments {
    /// Solver [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_parser = choice_parser(&SHOOTING_SOLVERS))]
    solver: Option<SolverKind>,
    #[command(flatten)]
    shooting: ShootingOptions,
    #[command(flatten)]
    passes: PassOptions,
    /// Also write trace.html, the solve shot by shot: one patch shoots at a time (--iteration southwell)
    #[arg(long)]
    trace: bool,
    #[command(flatten)]
    job: SceneJob,
}

/// A scene to solve, and what is written.
#[derive(Args, Default)]
pub struct SceneJob {
    /// An .obj (with its .mtl), a .gltf or a .glb
    pub scene: PathBuf,
    /// Folder for preview.png, view.html, lightmap.exr and result.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Estimate texels, memory and time, and solve nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Also write each face's light as an HDR map into DIR/maps: a room for relight
    #[arg(long)]
    pub maps: bool,
    #[command(flatten)]
    pub lights: LightOptions,
    #[command(flatten)]
    pub bake: BakeOptions,
    /// Also print result.json without its faces (or the estimates) as one line on stdout
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub common: CommonOptions,
}

/// A way to solve a scene.
#[derive(Clone, Copy)]
pub enum JobMethod<'a> {
    /// To an error, or by the dense system.
    ToError(f64),
    /// To an error, with the links recorded for `trace.html`.
    TracingLinks(f64),
    /// By progressive refinement with these options.
    Shooting(&'a ShootingOptions, &'a PassOptions),
    /// By progressive refinement with these options, one patch at a time, each shot recorded for `trace.html`.
    Tracing(&'a ShootingOptions, &'a PassOptions),
}

/// Solves a scene to an error, or exactly by the dense system, and writes the result.
pub fn run_solve(arguments: &SolveArguments) -> Result<Outcome> {
    let SolveArguments {
        error,
        job,
        solver,
        trace,
    } = arguments;
    let solver = choose_solver(solver.or(error.map(|_| SolverKind::Cpu)), &job.common)?;
    let quality = job.common.quality.map(|_| "--quality");
    match error.map(|_| "--error").or(quality) {
        Some(option) if solver == SolverKind::Dense => Err(Error::Usage(format!(
            "{option} does not go with --solver dense, which solves all texels exactly on the CPU: leave it out"
        ))),
        _ => {
            let error = error.unwrap_or(job.common.quality_error());
            let method = match (trace, solver) {
                (true, SolverKind::Dense) => {
                    return Err(Error::Usage(
                        "--trace shows links, and --solver dense has none: leave one of them out".into(),
                    ));
                }
                (true, _) => JobMethod::TracingLinks(error),
                (false, _) => JobMethod::ToError(error),
            };
            solve_scene(job, solver, method)
        }
    }
}

/// Solves a scene by progressive refinement with the settings given, and writes the result.
pub fn run_shoot(arguments: &ShootArguments) -> Result<Outcome> {
    let ShootArguments {
        shooting, passes, job, ..
    } = arguments;
    let solver = choose_solver(arguments.solver, &job.common)?;
    shooting.check_item_buffer(solver == SolverKind::Gpu)?;
    if !arguments.trace {
        return solve_scene(job, solver, JobMethod::Shooting(shooting, passes));
    }
    check_traced_passes(passes)?;
    solve_scene(job, solver, JobMethod::Tracing(shooting, passes))
}

/// Refuses options with which no single shots are made, or their form factors are scaled.
///
/// Errors: [`Error::Usage`].
fn check_traced_passes(passes: &PassOptions) -> Result<()> {
    let refuse = |text: &str| Err(Error::Usage(text.into()));
    match passes.iteration {
        Some(Iteration::Cg | Iteration::Chebyshev) => refuse(
            "--trace shows one shot after the other, but --iteration cg and chebyshev shoot from all patches at once: give --iteration southwell, or leave it out",
        ),
        _ if passes.conserve => refuse(
            "--trace does not go with --conserve, which scales the form factors that it shows: leave one of them out",
        ),
        _ => Ok(()),
    }
}

/// Solves a scene and writes the result.
///
/// Errors: those of the scene, the solver and the files; no adapter, after the CPU has solved.
pub fn solve_scene(job: &SceneJob, solver: SolverKind, method: JobMethod) -> Result<Outcome> {
    let SceneJob { out, bake, common, .. } = job;
    let start = Instant::now();
    let import = bake.import_options(common)?;
    require_address_space()?;
    let progress = Progress::new(&job.scene.file_name().unwrap_or_default().to_string_lossy());
    // Large files take seconds to read. The Ctrl-C handler is not installed yet.
    let _ = progress.show_phase("reading", 0.0);
    let BakedScene { scene, charts, file } = bake.load_scene(&job.scene, &import, &job.lights)?;
    progress.remove_bar();
    let (device, missing) = open_gpu(solver, common)?;
    let (settings, solver, changed) = choose_settings((solver, method), &scene, common, device.as_ref());
    let recorder = match method {
        JobMethod::Shooting(..) | JobMethod::ToError(_) => Recorder::Nothing,
        JobMethod::Tracing(..) => Recorder::of_shots(),
        JobMethod::TracingLinks(_) => Recorder::of_links(),
    };
    let traced = recorder.record_scene(&scene, &settings, solver)?;
    let mut notes: Vec<String> = scene.notes.iter().cloned().chain(changed).collect();
    if !job.dry_run {
        handle_interrupts();
    }
    for note in &notes {
        message!("note: {}: {note}", scene.name);
    }
    if job.dry_run {
        plan::print_plan(&scene, &settings, solver, job.json)?;
        return missing.map_or(Ok(Outcome::Done), Err);
    }
    check_memory(&scene, &settings, solver, memory_limit(solver))?;
    let load = start.elapsed().as_secs_f64();
    let baked = bake.output_files().into_iter();
    let baked = baked.flat_map(|(folder, names)| names.map(|name| (folder, name)));
    let maps = job.maps.then(|| maps::map_names(&scene)).into_iter().flatten();
    let own = SOLUTION_FILES.map(String::from).into_iter().chain(maps.map(name_map));
    let own = own.chain(traced.iter().map(|_| TRACE_FILE.into()));
    prepare_outputs(own.map(|name| (out.as_path(), name)).chain(baked))?;
    let question = SolveRequest {
        task: traced.as_ref().map_or(&scene, |traced| traced as &dyn SolveTask),
        settings: &settings,
        solver,
    };
    // The first step of a large scene takes seconds before it reports progress.
    let _ = progress.show_phase("prepare", 0.0);
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let watch = ProgressMonitor::new(&show);
    let answered = solve_request(&question, &watch)?;
    progress.remove_bar();
    let fewer = fewer_patches_note(&settings).filter(|_| solver.is_shooting());
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
    let seen = RenderedView::new(&solution, None)?;
    let page = recorder.render_page(&solution, &seen)?;
    let mut files = PendingFiles::default();
    bake.add_files(&mut files, (&solution, charts.as_ref(), file), &seen)?;
    let traced = page.as_ref().map_or("", |_| "trace.html, ");
    let others = || {
        let mut others = encode_view(seen);
        others.extend(page.map(|page| (TRACE_FILE.into(), page.into_bytes())));
        if job.maps {
            others.extend(encode_maps(&solution)?);
        }
        Ok(others)
    };
    solution.add_files(out, others, &mut files)?;
    files.write()?;
    print_summary(&solution, &answered);
    message!(
        "wrote {traced}preview.png, view.html, lightmap.exr and result.json in {}",
        out.display()
    );
    if job.json {
        output!("{}", solution.summarise_run())?;
    }
    missing.map_or(Ok(Outcome::Done), Err)
}

/// Returns settings and solver, and a note if the scene's many faces changed the settings.
fn choose_settings<'g>(
    (solver, method): (SolverKind, JobMethod),
    scene: &Scene,
    common: &CommonOptions,
    gpu: Option<&'g Gpu>,
) -> (Settings, SolverChoice<'g>, Option<String>) {
    match method {
        JobMethod::Shooting(shooting, passes) | JobMethod::Tracing(shooting, passes) => {
            let (mut settings, changed) = scene_settings(scene, common, shooting, passes, gpu.is_some());
            if matches!(method, JobMethod::Tracing(..)) {
                settings.schedule = settings.schedule.with_southwell();
            }
            (settings, SolverChoice::shooting_on(gpu), changed)
        }
        JobMethod::ToError(error) | JobMethod::TracingLinks(error) => {
            let mut settings = common.shooting_settings(&ShootingOptions::default(), &PassOptions::default(), false);
            settings.schedule = settings.schedule.with_southwell();
            let texels = common.texels;
            match solver {
                SolverKind::Dense => {
                    let settings = dense::dense_settings(settings.meshing.texels);
                    (settings, SolverChoice::Dense, None)
                }
                _ => {
                    // Texels that follow from the light are one a face or more.
                    settings.meshing.texels = texels.unwrap_or(1);
                    (
                        settings,
                        SolverChoice::to_error(gpu, ErrorTarget { error, texels }),
                        None,
                    )
                }
            }
        }
    }
}

/// Returns the settings of a solve by shooting, and a note if the scene's many faces make the defaults coarser.
pub fn scene_settings(
    scene: &Scene,
    common: &CommonOptions,
    shooting: &ShootingOptions,
    passes: &PassOptions,
    on_gpu: bool,
) -> (Settings, Option<String>) {
    let mut settings = common.shooting_settings(shooting, passes, on_gpu);
    let given = [common.texels, shooting.patches, shooting.samples];
    let given = given.map(|option| option.is_some() || common.quality.is_some());
    let changed;
    (settings.meshing, changed) = coarsen_meshing(scene, &settings.meshing, given);
    (settings, changed)
}

/// Returns a note if fewer patches shoot than were set: a patch is a block of whole texels.
fn fewer_patches_note(settings: &Settings) -> Option<String> {
    let Meshing { patches, texels, .. } = settings.meshing;
    (patches > texels).then(|| {
        format!("{texels}×{texels} patches a face instead of {patches}×{patches}: a patch has at least one texel")
    })
}

fn estimated_error(solution: &Solution) -> Option<f64> {
    solution.certificate.as_ref().and_then(|parts| parts["error"].as_f64())
}

/// Encodes preview.png and view.html.
pub fn encode_view(seen: RenderedView) -> Vec<NamedBytes> {
    let preview = seen.preview.picture.encode_png();
    vec![
        ("preview.png".into(), preview),
        ("view.html".into(), seen.page.into_bytes()),
    ]
}

/// Encodes the radiance map of every face.
fn encode_maps(solution: &Solution) -> Result<Vec<NamedBytes>> {
    let (mesh, field) = (solution.mesh, &solution.run.field);
    let texels = mesh.texels_in_face_order().into_iter();
    let radiosity: Vec<Vec3> = texels.map(|k| field.radiosity[k].truncate()).collect();
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
    let files = maps::encode_room(solution.scene, &resolutions, &radiosity)?;
    Ok(files.into_iter().map(|(name, bytes)| (name_map(name), bytes)).collect())
}

/// Returns the name of a map within the folder of the result.
fn name_map(name: String) -> String {
    format!("maps/{name}")
}

/// Prints what was solved, how, and how well, and the warnings.
pub fn print_summary(solution: &Solution, answered: &SolveAnswer) {
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
    for warning in solution.warnings {
        message!("warning: {}", warning.message);
    }
}

fn describe_dense(dense: &DenseReport, solution: &Solution) -> String {
    let quality = &dense.quality;
    format!(
        "dense system of {:.0} MB in {:.2} s, solved in {:.2} s to {:.1e}; rows' closure ≤ {:.1e}",
        quality.bytes as f64 / 1e6,
        solution.seconds.prepare,
        solution.seconds.solve,
        dense.solution.residual,
        quality.closure.max,
    )
}
