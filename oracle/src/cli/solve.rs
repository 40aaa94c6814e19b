//! `radiosity solve`.

use super::Outcome;
use super::bake::Bake;
use super::options::{Common, percentage};
use super::progress::{Progress, listen, reading};
use super::scene::{Dark, Materials};
use super::solver::{SolverOption, choose, open};
use super::tell::{self, say};
use crate::plan::ahead::warning;
use crate::plan::defaults::{Chosen, adapted};
use crate::plan::fits::{Limit, check, check_matrix, check_texels};
use crate::show::around::{Around, Seen};
use crate::show::bake::charts::Charts;
use crate::show::view::camera::Camera;
use crate::solve::moved::Moved;
use crate::solve::solved::Dense;
use crate::solve::solver::{Asked, LEAST, MOST, Solver};
use crate::solve::watch::Watch;
use crate::solve::{Question, answer, dense};
use clap::Args;
use common::capture::maps;
use common::energy::Energy;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Drawing, Meshing, Settings, Visibility};
use common::shooting::Field;
use common::solution::pending::Pending;
use common::solution::{Seconds, Solution, prepare};
use common::{Error, Result};
use glam::Vec3;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What a solve writes.
const FILES: &str = "preview.png, view.html, lightmap.exr and result.json";

/// Arguments of `solve`.
#[derive(Args)]
pub struct Arguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    pub scene: PathBuf,
    /// Who solves [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// Where preview.png, view.html, lightmap.exr and result.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Solve until the answer is P per cent off at most, 0.2 to 10 [default: 1, unless an option below asks for shooting]
    #[arg(long, value_name = "P%", value_parser = error, allow_negative_numbers = true)]
    pub error: Option<f64>,
    /// Write each face's light as an HDR map as well, into DIR/maps: a room for relight
    #[arg(long)]
    pub maps: bool,
    #[command(flatten)]
    bake: Bake,
    /// Warnings are errors: exit code 1, after writing
    #[arg(long)]
    pub strict: bool,
    /// What result.json has but for its faces, as one line on stdout
    #[arg(long)]
    json: bool,
    /// Solver and settings of an earlier result.json; options given beside it override
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    #[command(flatten)]
    pub materials: Materials,
    #[command(flatten)]
    pub dark: Dark,
    #[command(flatten)]
    pub common: Common,
}

/// The solve that a comparison without an adapter still does.
pub fn on_cpu(
    (scene, materials): (&Path, &Materials),
    out: &Path,
    error: Option<f64>,
    common: &Common,
) -> Result<Outcome> {
    // Without one given, the CPU asks rays, which have no use for these.
    let twin = common.visibility.is_some();
    let arguments = Arguments {
        scene: scene.to_path_buf(),
        solver: Some(SolverOption::Cpu),
        out: out.to_path_buf(),
        maps: false,
        bake: Bake::default(),
        strict: false,
        json: false,
        settings: None,
        error,
        materials: materials.clone(),
        dark: Dark::default(),
        common: Common {
            require_gpu: false,
            adapter: None,
            item_buffer: common.item_buffer.filter(|_| twin),
            raster: common.raster.filter(|_| twin),
            lookup: common.lookup.filter(|_| twin),
            ..common.clone()
        },
    };
    let error = error.or(arguments.common.error());
    solve(&arguments, SolverOption::Cpu, error)
}

/// Solves and writes: to an error, unless shooting is asked for.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    if arguments.error.is_some() {
        let chosen = to_error(arguments.solver, &arguments.common)?;
        common.not_for_error()?;
        return solve(arguments, chosen, arguments.error);
    }
    let chosen = choose(arguments.solver, common)?;
    let error = common.error().filter(|_| chosen != SolverOption::Matrix);
    solve(arguments, chosen, error)
}

fn solve(arguments: &Arguments, chosen: SolverOption, error: Option<f64>) -> Result<Outcome> {
    let common = &arguments.common;
    match chosen {
        SolverOption::Matrix => common.not_for_matrix()?,
        _ => common.not_for_rays(visibility(common, chosen == SolverOption::Gpu))?,
    }
    let start = Instant::now();
    let (materials, path) = (&arguments.materials, &arguments.scene);
    let import = arguments.bake.import(common)?;
    let scene = reading(path, common.quiet, || {
        materials.lit_unless(&arguments.dark, path, import)
    })?;
    let charts = arguments.bake.charts(&scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    for note in &scene.notes {
        say!("note: {}: {note}", scene.name);
    }
    let (device, missing) = open(chosen, common)?;
    let solver = match (error, chosen) {
        (Some(error), _) => {
            let asked = Asked {
                error,
                texels: common.texels,
            };
            Solver::to_error(device.as_ref(), asked)
        }
        (None, SolverOption::Matrix) => Solver::Matrix,
        (None, _) => Solver::on(device.as_ref()),
    };
    let (settings, changed) = fitting(common, &scene, solver)?;
    prepare(&arguments.out)?;
    arguments.bake.check()?;
    if let Some(changed) = &changed {
        say!("note: {changed}");
    }
    if !common.quiet
        && solver.shoots()
        && let Some(warning) = warning(&scene, &settings, solver)?
    {
        say!("note: {warning}");
    }
    listen();

    let question = Question {
        task: &scene,
        settings: &settings,
        solver,
    };
    let progress = Progress::new(&scene.name, common.quiet);
    // Of a large scene the first step takes seconds before it tells how far it is.
    let _ = progress.show("prepare", 0.0);
    let show = |phase: &str, done| progress.show(phase, done);
    let watch = Watch::new(&show);
    let answered = answer(&question, &watch)?;
    progress.clear();
    let mut notes = scene.notes.clone();
    notes.extend(changed);
    let fewer = fewer_cells(&settings).filter(|_| solver.shoots());
    for note in answered.notes.iter().chain(&fewer) {
        say!("note: {note}");
        notes.push(note.clone());
    }
    let seconds = Seconds {
        load: load_seconds,
        prepare: watch.seconds(&["prepare"]),
        solve: watch.seconds(&["solve"]),
    };
    let solution = answered.solution(&question, &notes, seconds);
    solution.write(&arguments.out)?;
    show_all(&solution, arguments, charts.as_ref())?;
    if arguments.maps {
        write_maps(&scene, solution.mesh, &solution.run.field, &arguments.out)?;
    }
    if !common.quiet {
        match &answered.solved.matrix {
            Some(dense) => of_matrix(&solution, dense),
            None => of_shots(&solution, answered.solved.moved.as_ref()),
        }
        wrote(&solution, FILES, &arguments.out);
    }
    if arguments.json {
        tell::json(&solution.summary())?;
    }
    missing.map_or(Ok(judged(&solution, arguments.strict)), Err)
}

/// The solver to an error.
pub fn to_error(asked: Option<SolverOption>, common: &Common) -> Result<SolverOption> {
    match asked {
        None | Some(SolverOption::Cpu) => {
            common.not_for_cpu()?;
            Ok(SolverOption::Cpu)
        }
        Some(SolverOption::Gpu) => Ok(SolverOption::Gpu),
        Some(SolverOption::Matrix) => Err(Error::Usage(
            "--solver matrix is solved as exactly as its texels allow: leave --error out".into(),
        )),
    }
}

/// A share that can be asked for.
pub fn error(text: &str) -> std::result::Result<f64, String> {
    let error = percentage(text)?;
    if (LEAST..=MOST).contains(&error) {
        Ok(error)
    } else {
        Err(format!("{text} is not within 0.2 % to 10 %"))
    }
}

/// The settings in force, if there is memory for them; and what was changed in them.
fn fitting(common: &Common, scene: &Scene, solver: Solver) -> Result<(Settings, Option<String>)> {
    if let Some(asked) = solver.asked() {
        let settings = common.settings(Visibility::Rays, FormFactor::Polygon)?;
        check_texels(scene, asked.texels.unwrap_or(1), Limit::of_this_machine())?;
        return Ok((settings, None));
    }
    if let Solver::Matrix = solver {
        let shooting = common.settings(Visibility::Rays, FormFactor::Polygon)?;
        let settings = dense::settings(shooting.meshing.texels);
        check_matrix(scene, settings.meshing.texels)?;
        return Ok((settings, None));
    }
    let (settings, changed) = settings_for(common, scene, solver.gpu().is_some())?;
    check(scene, &settings, solver.gpu(), Limit::of_this_machine())?;
    Ok((settings, changed))
}

/// Cells are blocks of whole texels.
fn fewer_cells(settings: &Settings) -> Option<String> {
    let Meshing { cells, texels, .. } = settings.meshing;
    (cells > texels).then(|| {
        format!(
            "{texels}×{texels} cells a face instead of {cells}×{cells}: each has a texel at least"
        )
    })
}

/// What is seen of a solution.
pub fn around<'a>(solution: &'a Solution, camera: Option<Camera>) -> Around<'a> {
    let certificate = solution.certificate.as_ref();
    Around {
        scene: solution.scene,
        mesh: solution.mesh,
        field: &solution.run.field,
        off: solution.off.as_deref(),
        solver: solution.solver,
        adapter: solution.adapter,
        error: certificate.and_then(|parts| parts["error"].as_f64()),
        camera,
    }
}

/// A picture of the scene, the scene to look around in, and, if asked for, to take elsewhere.
fn show_all(solution: &Solution, arguments: &Arguments, charts: Option<&Charts>) -> Result<()> {
    let seen = around(solution, None).seen()?;
    let mut files = Pending::default();
    pending(&seen, &arguments.out, &mut files)?;
    arguments.bake.add(&mut files, (solution, charts), &seen)?;
    files.finish()
}

/// The two files of what is seen.
pub fn pending(seen: &Seen, out: &Path, files: &mut Pending) -> Result<()> {
    files.add(&out.join("preview.png"), &seen.preview.picture.png())?;
    files.add(&out.join("view.html"), seen.page.as_bytes())
}

/// The radiance map of every face.
pub fn write_maps(scene: &Scene, mesh: &Mesh, field: &Field, out: &Path) -> Result<()> {
    let radiosity: Vec<Vec3> = mesh
        .in_face_order()
        .into_iter()
        .map(|k| field.radiosity[k].truncate())
        .collect();
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
    maps::write(&out.join("maps"), scene, &resolutions, &radiosity)
}

/// The settings in force. The most accurate visibility of a solver is its default.
pub fn settings(common: &Common, on_gpu: bool) -> Result<Settings> {
    common.of_passes(visibility(common, on_gpu), FormFactor::Polygon)
}

/// The visibility in force.
pub fn visibility(common: &Common, on_gpu: bool) -> Visibility {
    match common.visibility {
        Some(given) => given.into(),
        None if on_gpu => Visibility::Drawn(Drawing::DEFAULT),
        None => Visibility::Rays,
    }
}

/// The same for `scene`: of many faces the defaults are coarser, and the note says so.
pub fn settings_for(
    common: &Common,
    scene: &Scene,
    on_gpu: bool,
) -> Result<(Settings, Option<String>)> {
    let chosen = Chosen {
        quality: common.quality.is_some(),
        texels: common.texels.is_some(),
        cells: common.cells.is_some(),
        samples: common.samples.is_some(),
    };
    let mut settings = settings(common, on_gpu)?;
    let (meshing, changed) = adapted(scene, &settings.meshing, chosen);
    settings.meshing = meshing;
    Ok((settings, changed))
}

fn of_shots(solution: &Solution, moved: Option<&Moved>) {
    let energy = Energy::new(solution.mesh, &solution.run.field, &solution.run.shots);
    let certificate = solution.certificate.as_ref();
    let off = certificate.and_then(|parts| parts["error"].as_f64());
    say!(
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
        100.0 * energy.share(energy.escaped),
        100.0 * energy.share(energy.closure),
        off.map_or(String::new(), |error| format!(
            ", about {:.1} % off",
            100.0 * error
        )),
    );
}

fn of_matrix(solution: &Solution, Dense { quality, answer }: &Dense) {
    let energy = Energy::new(solution.mesh, &solution.run.field, &solution.run.shots);
    say!(
        "{}: {} faces, {} texels, matrix of {:.0} MB in {:.2} s, solved in {:.2} s to {:.1e}; {} pairs exact, {} sampled, reciprocity {:.1e}, rows' closure ≤ {:.1e} (mean {:.1e}); imbalance {:.1e}, escaped {:.2} %, closure {:.2} %",
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
        100.0 * energy.share(energy.escaped),
        100.0 * energy.share(energy.closure),
    );
}

/// With `--strict` no warning is only a warning.
pub fn judged(solution: &Solution, strict: bool) -> Outcome {
    match solution.warnings {
        [first, rest @ ..] if strict => {
            let more = match rest.len() {
                0 => String::new(),
                n => format!(" (and {n} more)"),
            };
            tell::error(&format!("{}: {}{more}", solution.scene.name, first.message));
            Outcome::Disagree
        }
        _ => Outcome::Done,
    }
}

/// The warnings, and where the files are.
pub fn wrote(solution: &Solution, files: &str, out: &Path) {
    for warning in solution.warnings {
        say!("warning: {}", warning.message);
    }
    say!("wrote {files} in {}", out.display());
}
