//! `radiosity relight`.

mod finish;
mod load;

use super::Outcome;
use super::objects::{Objects, camera, triple};
use super::options::Common;
use super::progress::{Progress, listen};
use super::solve::{error, to_error, visibility};
use super::solver::{SolverOption, choose, open};
use crate::cli::tell::say;
use crate::relight::stage::Stage;
use crate::relight::work::Relighting;
use crate::show::tone::Curve;
use crate::solve::solver::{Asked, Solver};
use crate::solve::watch::Watch;
use crate::solve::{Question, answer};
use clap::{Args, ValueEnum};
use common::form_factor::FormFactor;
use common::relight::{Mended, Method};
use common::settings::{Iteration, Quality, Settings};
use common::solution::prepare;
use common::{Error, Result};
use glam::DVec3;
use std::path::PathBuf;

/// Cells a side of a panorama's six walls at normal quality: lights are smaller than a quarter of
/// a wall.
const PANORAMA_CELLS: u32 = 8;
/// `--method`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodOption {
    /// Shoots what the objects take and give, of either sign: ends where solving everything again would
    Signed,
    /// Table 2 of the paper
    Paper,
    /// Everything solved again, from what the room reflects and emits
    Full,
}

/// `--mend`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Flaw {
    /// Texels that were already hidden in the empty room are darkened again
    EmptyRoom,
    /// Objects take away light that they never gave
    ObjectShadows,
    /// Objects give no light to the room
    Bleeding,
    /// Shadows are not shot on
    Shadows,
}

/// `--map`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MapOption {
    /// Longitude across, latitude down
    Latlong,
    /// Six square sides one below the other: +x −x +y −y +z −z
    Cube,
    /// Debevec's disc: the angle from the centre grows evenly to the rim
    Angular,
}

/// `--curve`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CurveOption {
    /// As it is; what is brighter than white is white
    Linear,
    /// Reinhard's photographic operator: all is dimmed, the brighter the more
    Reinhard,
    /// As it is up to half of white, then Uchimura's shoulder: nothing burns out
    Filmic,
}

impl From<CurveOption> for Curve {
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
pub struct Arguments {
    /// A scene (solved empty first), a directory of solve, a folder of its --maps, or a panorama
    #[arg(long, value_name = "ROOM")]
    room: PathBuf,
    #[command(flatten)]
    objects: Objects,
    /// How the room takes the objects
    #[arg(long, value_enum, default_value = "signed")]
    method: MethodOption,
    /// A flaw of Table 2 to mend (with --method paper); may be repeated
    #[arg(long, value_enum)]
    mend: Vec<Flaw>,
    /// Who solves [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// A panorama's room: x ∈ ±X/2, y from 0 to Y (up), z ∈ ±Z/2; the map's centre is +z
    #[arg(long, value_name = "X,Y,Z", value_parser = triple)]
    room_size: Option<DVec3>,
    /// Where the panorama was captured [default: the room's middle]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// How a panorama's pixels map to directions [default: as the file says]
    #[arg(long, value_enum)]
    map: Option<MapOption>,
    /// Texels per side of an object's face [default: 1 above 1000 faces, else as --texels]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    object_texels: Option<u32>,
    /// Eye, target and vertical field of view in degrees [default: one that shows the objects]
    #[arg(long, value_name = "EX,EY,EZ,TX,TY,TZ,FOV", value_parser = camera, allow_hyphen_values = true)]
    camera: Option<[f64; 7]>,
    /// Opens composite.png by so many stops; at 0 the 90th percentile of what is seen is at 80 % of white
    #[arg(long, value_name = "EV", default_value = "0", value_parser = stops, allow_negative_numbers = true)]
    exposure: f64,
    /// How light becomes a colour of composite.png and report.html; the EXRs hold radiance all the same
    #[arg(long, value_enum, default_value = "filmic")]
    curve: CurveOption,
    /// Relight until the answer is P per cent off at most, 0.2 to 10 [default: 1, unless an option below asks for shooting]
    #[arg(long, value_name = "P%", value_parser = error, allow_negative_numbers = true)]
    error: Option<f64>,
    /// Where the results go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Warnings are errors: exit code 1, after writing
    #[arg(long)]
    strict: bool,
    /// What result.json has but for its faces, as one line on stdout
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    common: Common,
}

/// An exposure's stops.
fn stops(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(stops) if stops.abs() <= 64.0 => Ok(stops),
        _ => Err(format!("{text} is not between −64 and 64")),
    }
}

/// Relights and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    let method = method(arguments)?;
    let (solver, error) = who(arguments)?;
    common.not_for_rays(visibility(common, solver == SolverOption::Gpu))?;
    let progress = Progress::new("relight", common.quiet);
    let show = |phase: &str, done| progress.show(phase, done);
    let watch = Watch::new(&show);
    let stage = watch.of("load", || load::stage(arguments, error.is_some()))?;
    for note in &stage.notes {
        say!("note: {note}");
    }
    prepare(&arguments.out)?;
    listen();
    let (device, missing) = open(solver, common)?;
    let settings = settings(arguments, &stage, device.is_some())?;
    let task = Relighting {
        stage: &stage,
        method,
    };
    let question = Question {
        task: &task,
        settings: &settings,
        solver: match error {
            Some(error) => {
                let texels = common.texels.or(arguments.object_texels);
                Solver::to_error(device.as_ref(), Asked { error, texels })
            }
            None => Solver::on(device.as_ref()),
        },
    };
    let answered = answer(&question, &watch)?;
    progress.clear();
    let outcome = finish::write(arguments, &stage, &question, &answered, &watch)?;
    missing.map_or(Ok(outcome), Err)
}

/// Who relights, and the error that is asked for; none: it shoots.
fn who(arguments: &Arguments) -> Result<(SolverOption, Option<f64>)> {
    let common = &arguments.common;
    if let Some(error) = arguments.error {
        if arguments.method == MethodOption::Paper {
            return Err(Error::Usage(
                "--error: --method paper shoots; leave one of them out".into(),
            ));
        }
        common.not_for_error()?;
        return Ok((to_error(arguments.solver, common)?, Some(error)));
    }
    let solver = choose(arguments.solver, common)?;
    if solver == SolverOption::Matrix {
        return Err(Error::Usage("relight shoots: --solver cpu or gpu".into()));
    }
    let may = arguments.method != MethodOption::Paper;
    Ok((solver, common.error().filter(|_| may)))
}

/// The method; none is `full`.
fn method(arguments: &Arguments) -> Result<Option<Method>> {
    let has = |flaw| arguments.mend.contains(&flaw);
    if arguments.common.conserve {
        return Err(Error::Usage(
            "--conserve: relight compares links with and without the objects; leave it out".into(),
        ));
    }
    if !arguments.mend.is_empty() && arguments.method != MethodOption::Paper {
        return Err(Error::Usage("--mend goes with --method paper only".into()));
    }
    Ok(match arguments.method {
        MethodOption::Signed => Some(Method::Signed),
        MethodOption::Paper => Some(Method::Paper(Mended {
            empty_room: has(Flaw::EmptyRoom),
            object_shadows: has(Flaw::ObjectShadows),
            bleeding: has(Flaw::Bleeding),
            shadows: has(Flaw::Shadows),
        })),
        MethodOption::Full => None,
    })
}

fn settings(arguments: &Arguments, stage: &Stage, on_gpu: bool) -> Result<Settings> {
    let common = &arguments.common;
    let visibility = visibility(common, on_gpu);
    let mut settings = common.settings(visibility, FormFactor::Polygon)?;
    // Of the room's own solve, as `solve` does it.
    settings.schedule.iteration = Iteration::Cg;
    settings.meshing.texels = stage
        .resolutions
        .first()
        .map_or(settings.meshing.texels, |r| r[0]);
    let panorama = stage.captured.panorama.is_some();
    if common.cells.is_none() {
        settings.meshing.cells = match settings.quality {
            // There is no ladder here. Of a panorama's six walls every texel can shoot.
            Quality::Reference if panorama => settings.meshing.texels,
            Quality::Normal if panorama => PANORAMA_CELLS,
            Quality::Reference => 2 * settings.meshing.cells,
            _ => settings.meshing.cells,
        };
    }
    Ok(settings)
}
