//! `radiosity relight`.

mod inputs;
mod results;

use super::Outcome;
use super::objects::{ObjectOptions, parse_camera, parse_point};
use super::options::CommonOptions;
use super::options::{parse_error, visibility_in_force};
use super::progress::{Progress, handle_interrupts};
use super::solver::choose_solver_for_error;
use super::solver::{SolverOption, choose_solver, open_gpu};
use crate::cli::console::message;
use crate::report::tone_mapping::ToneCurve;
use clap::{Args, ValueEnum};
use common::form_factor::FormFactor;
use common::relight::{MendedFlaws, RelightMethod};
use common::settings::{Iteration, Settings, SolveQuality};
use common::solution::prepare_directory;
use common::{Error, Result};
use glam::DVec3;
use oracle::relight::stage::RelightStage;
use oracle::relight::task::RelightTask;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveRequest, solve_request};
use std::path::PathBuf;

/// Patches per side of a panorama's six walls at normal quality: lights are smaller than a quarter of
/// a wall.
const PANORAMA_PATCHES: u32 = 8;

/// `--method`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodOption {
    /// Shoot the change that the objects make, of either sign; converges to a full solution
    Signed,
    /// Table 2 of the paper
    Paper,
    /// Solve everything again with the room's recovered reflectance and emission
    Full,
}

/// `--mend`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MendOption {
    /// Texels hidden in the empty room are darkened a second time
    EmptyRoom,
    /// Objects shadow light that does not reach them
    ObjectShadows,
    /// Objects reflect no light into the room
    Bleeding,
    /// Shadows are not propagated by later shots
    Shadows,
}

/// `--map`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MapOption {
    /// Longitude across, latitude down
    Latlong,
    /// Six square sides one below the other: +x −x +y −y +z −z
    Cube,
    /// Debevec's disc: the angle from the centre grows linearly to the rim
    Angular,
}

/// `--curve`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CurveOption {
    /// Linear, clipped at white
    Linear,
    /// Reinhard's photographic operator: compresses bright parts more
    Reinhard,
    /// Linear up to half of white, then Uchimura's shoulder: nothing is clipped
    Filmic,
}

impl From<CurveOption> for ToneCurve {
    fn from(option: CurveOption) -> Self {
        match option {
            CurveOption::Linear => Self::Linear,
            CurveOption::Reinhard => Self::Reinhard,
            CurveOption::Filmic => Self::Filmic,
        }
    }
}

/// Arguments of `relight`.
#[derive(Args)]
pub struct RelightArguments {
    /// A scene (solved empty first), a directory of solve, a folder of its --maps, or a panorama
    #[arg(long, value_name = "ROOM")]
    room: PathBuf,
    #[command(flatten)]
    objects: ObjectOptions,
    /// Method of relighting
    #[arg(long, value_enum, default_value = "signed")]
    method: MethodOption,
    /// A flaw of Table 2 to mend (with --method paper); may be repeated
    #[arg(long, value_enum)]
    mend: Vec<MendOption>,
    /// Solver [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// A panorama's room: x ∈ ±X/2, y from 0 to Y (up), z ∈ ±Z/2; the map's centre is +z
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point)]
    room_size: Option<DVec3>,
    /// Point from which the panorama was captured [default: the room's centre]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// Projection of the panorama [default: as the file says]
    #[arg(long, value_enum)]
    map: Option<MapOption>,
    /// Texels per side of an object's face [default: 1 above 1000 faces, else as --texels]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    object_texels: Option<u32>,
    /// Eye, target and vertical field of view in degrees [default: one that shows the objects]
    #[arg(long, value_name = "EX,EY,EZ,TX,TY,TZ,FOV", value_parser = parse_camera, allow_hyphen_values = true)]
    camera: Option<[f64; 7]>,
    /// Exposure of composite.png in stops; at 0 the picture's 90th percentile is at 80 % of white
    #[arg(long, value_name = "EV", default_value = "0", value_parser = parse_stops, allow_negative_numbers = true)]
    exposure: f64,
    /// Tone curve of composite.png and report.html; the EXR files hold radiance in any case
    #[arg(long, value_enum, default_value = "filmic")]
    curve: CurveOption,
    /// Refine until the estimated error is at most P per cent, 0.2 to 10 [default: 1, unless an option of shooting is given]
    #[arg(long, value_name = "P%", value_parser = parse_error, allow_negative_numbers = true)]
    error: Option<f64>,
    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Treat warnings as errors: exit code 1, after writing
    #[arg(long)]
    strict: bool,
    /// Also print result.json without its faces as one line on stdout
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    common: CommonOptions,
}

/// Parses an exposure in stops.
fn parse_stops(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(stops) if stops.abs() <= 64.0 => Ok(stops),
        _ => Err(format!("{text} is not between −64 and 64")),
    }
}

/// Relights a room with the objects and writes the results.
pub fn run(arguments: &RelightArguments) -> Result<Outcome> {
    let common = &arguments.common;
    let method = relight_method(arguments)?;
    let (solver, error) = choose_solver_and_error(arguments)?;
    common.refuse_item_buffer_options(visibility_in_force(common, solver == SolverOption::Gpu))?;
    let progress = Progress::new("relight", common.quiet);
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let watch = ProgressMonitor::new(&show);
    let stage = watch.time_phase("load", || inputs::load_stage(arguments, error.is_some()))?;
    for note in &stage.notes {
        message!("note: {note}");
    }
    prepare_directory(&arguments.out)?;
    handle_interrupts();
    let (device, missing) = open_gpu(solver, common)?;
    let settings = relight_settings(arguments, &stage, device.is_some())?;
    let task = RelightTask { stage: &stage, method };
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
    progress.clear();
    let outcome = results::write_results(arguments, &stage, &question, &answered, &watch)?;
    missing.map_or(Ok(outcome), Err)
}

/// Returns the solver and the error to reach; no error: it shoots.
///
/// Errors: options contradict each other.
fn choose_solver_and_error(arguments: &RelightArguments) -> Result<(SolverOption, Option<f64>)> {
    let common = &arguments.common;
    if let Some(error) = arguments.error {
        if arguments.method == MethodOption::Paper {
            return Err(Error::Usage(
                "--error: --method paper shoots; leave one of them out".into(),
            ));
        }
        common.refuse_shooting_options()?;
        return Ok((choose_solver_for_error(arguments.solver, common)?, Some(error)));
    }
    let solver = choose_solver(arguments.solver, common)?;
    if solver == SolverOption::Dense {
        return Err(Error::Usage("relight shoots: --solver cpu or gpu".into()));
    }
    let may = arguments.method != MethodOption::Paper;
    Ok((solver, common.quality_error().filter(|_| may)))
}

/// Returns the method of relighting; none is `full`.
///
/// Errors: options contradict each other.
fn relight_method(arguments: &RelightArguments) -> Result<Option<RelightMethod>> {
    let has = |flaw| arguments.mend.contains(&flaw);
    if arguments.common.shooting.conserve {
        return Err(Error::Usage(
            "--conserve: relight compares links with and without the objects; leave it out".into(),
        ));
    }
    if !arguments.mend.is_empty() && arguments.method != MethodOption::Paper {
        return Err(Error::Usage("--mend goes with --method paper only".into()));
    }
    Ok(match arguments.method {
        MethodOption::Signed => Some(RelightMethod::Signed),
        MethodOption::Paper => Some(RelightMethod::Paper(MendedFlaws {
            empty_room: has(MendOption::EmptyRoom),
            object_shadows: has(MendOption::ObjectShadows),
            bleeding: has(MendOption::Bleeding),
            shadows: has(MendOption::Shadows),
        })),
        MethodOption::Full => None,
    })
}

/// Returns the settings in force for room and objects.
fn relight_settings(arguments: &RelightArguments, stage: &RelightStage, on_gpu: bool) -> Result<Settings> {
    let common = &arguments.common;
    let visibility = visibility_in_force(common, on_gpu);
    let mut settings = common.shot_settings(visibility, FormFactor::Polygon)?;
    // The room is solved empty first, by the iteration of `solve`.
    settings.schedule.iteration = Iteration::Cg;
    settings.meshing.texels = stage.resolutions.first().map_or(settings.meshing.texels, |r| r[0]);
    let panorama = stage.captured.panorama.is_some();
    if common.shooting.patches.is_none() {
        settings.meshing.patches = match settings.quality {
            // A panorama has six walls, few enough for every texel to shoot.
            SolveQuality::Reference if panorama => settings.meshing.texels,
            SolveQuality::Normal if panorama => PANORAMA_PATCHES,
            SolveQuality::Reference => 2 * settings.meshing.patches,
            _ => settings.meshing.patches,
        };
    }
    Ok(settings)
}
