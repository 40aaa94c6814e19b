//! `radiosity relight`: puts objects into a captured room and solves the change of its light.

mod inputs;
mod results;

use super::Outcome;
use super::console::message;
use super::objects::{ObjectOptions, parse_camera, parse_point};
use super::options::{Choice, CommonOptions, PassOptions, ShootingOptions, choice_parser, parse_error};
use super::progress::{Progress, handle_interrupts};
use super::solve::SOLUTION_FILES;
use super::solver::{SHOOTING_SOLVERS, choose_solver, open_gpu};
use super::trace::TRACE_FILE;
use crate::plan::memory::{check_relight_memory, require_address_space};
use crate::report::trace::{TRACE_LIMITS, check_trace_limits};
use clap::Args;
use common::capture::MapProjection;
use common::relight::{MendedFlaws, RelightMethod};
use common::settings::{Settings, SolveQuality};
use common::solution::prepare_folder;
use common::texel::texel_count;
use common::{Error, Result};
use glam::DVec3;
use oracle::relight::stage::RelightStage;
use oracle::relight::task::RelightTask;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solver::{ErrorTarget, SolverChoice, SolverKind};
use oracle::solve::{SolveRequest, solve_request};
use oracle::trace::task::TraceSlot;
use std::path::PathBuf;

/// Patches per side of a panorama's six walls at normal quality: lights are smaller than a quarter of
/// a wall.
const PANORAMA_PATCHES: u32 = 8;

const MAP_PROJECTIONS: [Choice<MapProjection>; 3] = [
    ("latlong", "Longitude across, latitude down", MapProjection::LatLong),
    (
        "cube",
        "Six square sides one below the other: +x −x +y −y +z −z",
        MapProjection::Cube,
    ),
    (
        "angular",
        "Debevec's disc: the angle from the centre grows linearly to the rim",
        MapProjection::Angular,
    ),
];

/// Arguments of `relight`.
#[derive(Args)]
pub struct RelightArguments {
    /// A scene (solved empty first), a directory of solve, a folder of its --maps, or a panorama
    #[arg(long, value_name = "ROOM")]
    room: PathBuf,
    #[command(flatten)]
    objects: ObjectOptions,
    /// Method: shoot the change that the objects make, of either sign; Table 2 of the paper; or everything again
    #[arg(long, value_parser = ["signed", "paper", "full"], default_value = "signed")]
    method: String,
    /// Solver [default: gpu where there is a hardware adapter, else cpu; cpu with --error]
    #[arg(long, value_parser = choice_parser(&SHOOTING_SOLVERS))]
    solver: Option<SolverKind>,
    /// A panorama's room: x ∈ ±X/2, y from 0 to Y (up), z ∈ ±Z/2; the map's centre is +z
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point)]
    room_size: Option<DVec3>,
    /// Point from which the panorama was captured [default: the room's centre]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// Projection of the panorama [default: as the file says]
    #[arg(long, value_parser = choice_parser(&MAP_PROJECTIONS))]
    map: Option<MapProjection>,
    /// Texels per side of an object's face [default: 1 above 1000 faces, else as --texels]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    object_texels: Option<u32>,
    /// Eye, target and vertical field of view in degrees [default: one that shows the objects]
    #[arg(long, value_name = "EX,EY,EZ,TX,TY,TZ,FOV", value_parser = parse_camera, allow_hyphen_values = true)]
    camera: Option<[f64; 7]>,
    /// Refine until the estimated error is at most P per cent, 0.2 to 10 [default: 1, unless an option of shooting is given]
    #[arg(long, value_name = "P%", value_parser = parse_error, conflicts_with_all = ["quality", "ShootingOptions"])]
    error: Option<f64>,
    /// Also write trace.html, the relight shot by shot
    #[arg(long, conflicts_with = "error")]
    trace: bool,
    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    shooting: ShootingOptions,
    #[command(flatten)]
    common: CommonOptions,
}

/// Relights a room with the objects and writes the results.
pub fn run(arguments: &RelightArguments) -> Result<Outcome> {
    let RelightArguments { common, shooting, .. } = arguments;
    let method = match arguments.method.as_str() {
        "signed" => Some(RelightMethod::Signed),
        "paper" => Some(RelightMethod::Paper(MendedFlaws::default())),
        _ => None,
    };
    let asked = arguments.solver.or(arguments.error.map(|_| SolverKind::Cpu));
    let solver = choose_solver(asked, common)?;
    let shoots = matches!(method, Some(RelightMethod::Paper(_)));
    if shoots && arguments.error.is_some() {
        return Err(Error::Usage(
            "--error: --method paper shoots; leave one of them out".into(),
        ));
    }
    shooting.check_item_buffer(solver == SolverKind::Gpu)?;
    require_address_space()?;
    let default =
        Some(common.quality_error()).filter(|_| !shoots && !arguments.trace && *shooting == ShootingOptions::default());
    let error = arguments.error.or(default);
    let progress = Progress::new("relight");
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let watch = ProgressMonitor::new(&show);
    let stage = watch.time_phase("load", || inputs::load_stage(arguments, error.is_some()))?;
    check_relight_memory(&stage.resolutions, error.is_some())?;
    for note in &stage.notes {
        message!("note: {note}");
    }
    let slot = arguments.trace.then(|| TraceSlot::new(TRACE_LIMITS));
    if slot.is_some() {
        let texels = stage.resolutions.iter().map(|own| u64::from(texel_count(*own))).sum();
        check_trace_limits(&stage.scene.name, stage.scene.faces.len() as u64, texels)?;
    }
    let traced: &[&str] = if arguments.trace { &[TRACE_FILE] } else { &[] };
    prepare_folder(
        &arguments.out,
        &[&SOLUTION_FILES[..], &results::PICTURE_FILES, traced].concat(),
    )?;
    handle_interrupts();
    let (device, missing) = open_gpu(solver, common)?;
    let settings = relight_settings(arguments, &stage, device.is_some());
    let task = RelightTask {
        stage: &stage,
        method,
        trace: slot.as_ref(),
    };
    let question = SolveRequest {
        task: &task,
        settings: &settings,
        solver: match error {
            Some(error) => {
                let texels = common.texels.or(arguments.object_texels);
                SolverChoice::to_error(device.as_ref(), ErrorTarget { error, texels })
            }
            None => SolverChoice::shooting_on(device.as_ref()),
        },
    };
    let answered = solve_request(&question, &watch)?;
    progress.remove_bar();
    results::write_results(arguments, &task, &question, &answered, &watch)?;
    missing.map_or(Ok(Outcome::Done), Err)
}

/// Returns the settings in force for room and objects.
fn relight_settings(arguments: &RelightArguments, stage: &RelightStage, on_gpu: bool) -> Settings {
    let RelightArguments { common, shooting, .. } = arguments;
    let mut settings = common.shooting_settings(shooting, &PassOptions::default(), on_gpu);
    let meshing = &mut settings.meshing;
    meshing.texels = stage.resolutions.first().map_or(meshing.texels, |r| r[0]);
    let panorama = stage.captured.panorama.is_some();
    if shooting.patches.is_none() {
        meshing.patches = match settings.quality {
            // A panorama has six walls, few enough for every texel to shoot.
            SolveQuality::Reference if panorama => meshing.texels,
            SolveQuality::Normal if panorama => PANORAMA_PATCHES,
            SolveQuality::Reference => 2 * meshing.patches,
            _ => meshing.patches,
        };
    }
    settings
}
