//! A relight as a task of the pipeline: captures the room if it is a scene, then relights by one of the methods.

use super::adaptive::relight_adaptively;
use super::captured_room::CapturedValues;
use super::stage::RelightStage;
use crate::solve::adaptive::adapt_advice;
use crate::solve::gpu_linker::LinkerOnGpu;
use crate::solve::interrupt::is_interrupted;
use crate::solve::progress::ProgressMonitor;
use crate::solve::regather::{ErrorEstimate, estimate_by_regathering};
use crate::solve::solved::{RelightReport, Solved};
use crate::solve::solver::SolverChoice;
use crate::solve::task::SolveTask;
use crate::solve::warnings;
use crate::trace::recorder::ShotRecorder;
use crate::trace::task::TraceSlot;
use common::cover::furnished_mesh;
use common::energy::EnergyBalance;
use common::mesh::{Mesh, Texel};
use common::passes;
use common::relight::surface::TexelSurfaces;
use common::relight::{RelightMethod, RoomRadiosity, relight_room};
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::{Shot, SolveRun, shoot_until_converged, solve_progress};
use common::solution::{Warning, WarningCode};
use common::{Error, Result, relight as loops};
use cpu::hierarchy::linker::LinkMethod;
use glam::{Vec3, Vec4};

/// Share of the emitted power above which a broken energy balance causes a warning.
const MAX_IMBALANCE: f64 = 0.02;

/// A stage with the method of relighting.
pub struct RelightTask<'a> {
    /// The room and its objects.
    pub stage: &'a RelightStage,
    /// The method; `None`: everything is solved again.
    pub method: Option<RelightMethod>,
    /// Receives the record of a relight that shoots.
    pub trace: Option<&'a TraceSlot>,
}

impl SolveTask for RelightTask<'_> {
    fn scene(&self) -> &Scene {
        &self.stage.scene
    }

    fn solve_once(&self, settings: &Settings, solver: SolverChoice, progress: &ProgressMonitor) -> Result<Solved> {
        if let Some(target) = solver.error_target() {
            let solve_everything = match self.method {
                None => true,
                Some(RelightMethod::Signed) => false,
                Some(RelightMethod::Paper(_)) => {
                    return Err(Error::Usage(
                        "--method paper shoots: it cannot be solved to an error".into(),
                    ));
                }
            };
            let relight = |method| relight_adaptively(self.stage, solve_everything, settings, target, method, progress);
            return match solver.gpu() {
                Some(gpu) => relight(LinkMethod::Custom(&LinkerOnGpu::factory_on(gpu, &[]))),
                None => relight(LinkMethod::Shafts),
            };
        }
        let stage = self.stage;
        ShootingRelight {
            stage,
            settings,
            solver,
            progress,
            trace: self.trace,
        }
        .relight_by_shooting(self.method)
    }

    fn estimate_error(&self, solved: &Solved) -> Result<Option<ErrorEstimate>> {
        if let Some(history) = &solved.history {
            // A captured room need not be closed.
            return Ok(history.estimate_error(&solved.mesh, &solved.run, 0.0));
        }
        let values = self.stage.captured.values.as_ref();
        // An E recovered from a picture compensates any error of the links, and re-gathering would report that.
        if values.is_some_and(|values| values.emission.is_none()) || self.stage.reflectance.is_some() {
            return Ok(None);
        }
        let scene = &self.stage.scene;
        estimate_by_regathering(scene, &solved.settings, &solved.mesh, &solved.run.field).map(Some)
    }

    fn collect_warnings(&self, solved: &Solved, estimate: Option<&ErrorEstimate>) -> Vec<Warning> {
        let (mesh, run) = (&solved.mesh, &solved.run);
        let mut warnings = warnings::collect_warnings(&self.stage.scene, mesh, run, estimate);
        let imbalance = EnergyBalance::new(mesh, &run.field, &run.shots).imbalance;
        if imbalance > MAX_IMBALANCE && matches!(self.method, Some(RelightMethod::Paper(_))) {
            warnings.push(Warning {
                code: WarningCode::Energy,
                faces: Vec::new(),
                message: format!(
                    "Table 2 adds or loses {:.1} % of the emitted power: use --method signed",
                    100.0 * imbalance
                ),
            });
        }
        match solved.history {
            Some(_) => adapt_advice(warnings),
            None => warnings,
        }
    }

    /// Never reported: light that the capture does not show may fall on a captured wall.
    fn explain_darkness(&self, _: &Solved) -> Option<String> {
        None
    }
}

/// Solves the empty room of a scene and returns its values as the capture.
pub fn capture_empty_room(
    stage: &RelightStage,
    settings: &Settings,
    solver: SolverChoice,
    progress: &ProgressMonitor,
) -> Result<CapturedValues> {
    let scene = &stage.captured.scene;
    let (resolutions, meshing) = (&stage.captured.resolutions, settings.meshing);
    let mesh = furnished_mesh(
        scene,
        stage.room_faces,
        resolutions,
        [meshing.patches, meshing.samples],
        &is_interrupted,
    )?;
    let mut engine = solver.create_engine(&mesh, &settings.transport)?;
    let run = passes::solve_by_schedule(engine.as_mut(), &mesh, &settings.schedule, &mut |done| {
        progress.report_share("capture", done)
    })?;
    if progress.is_stopped() {
        return Err(Error::Interrupted);
    }
    let order = mesh.texels_in_face_order();
    let ordered = |values: &[Vec4]| order.iter().map(|k| values[*k].truncate()).collect();
    let of = |value: fn(&Texel) -> Vec3| -> Vec<Vec3> { order.iter().map(|k| value(&mesh.texels[*k])).collect() };
    Ok(CapturedValues {
        radiosity: ordered(&run.field.radiosity),
        residual: Some(ordered(&run.field.residual)),
        reflectance: Some(of(|t| t.reflectance)),
        emission: Some(of(|t| t.emission)),
    })
}

/// A relight by shooting.
struct ShootingRelight<'a> {
    stage: &'a RelightStage,
    settings: &'a Settings,
    solver: SolverChoice<'a>,
    progress: &'a ProgressMonitor<'a>,
    trace: Option<&'a TraceSlot>,
}

impl ShootingRelight<'_> {
    fn relight_by_shooting(&self, method: Option<RelightMethod>) -> Result<Solved> {
        let (stage, progress) = (self.stage, self.progress);
        let solved;
        let values = match &stage.captured.values {
            Some(values) => values,
            None => {
                solved = progress.time_phase("capture", || {
                    capture_empty_room(stage, self.settings, self.solver, progress)
                })?;
                &solved
            }
        };
        let mut mesh = progress.time_phase("prepare", || self.build_mesh())?;
        let room = values.apply_to_mesh(&mut mesh, stage.reflectance);
        // Emission is known if the room is a scene or a solve.
        let known = stage.reflectance.is_none() && values.emission.is_some();
        let Some(method) = method else {
            let surface = match known {
                true => None,
                false => Some(progress.time_phase("recover", || self.recover_surface(&mesh, &room))?),
            };
            return progress.time_phase("relight", || self.solve_everything(mesh, room, surface));
        };
        let relit = progress.time_phase("relight", || {
            self.run_method(&mesh, &room, method, self.settings, self.trace)
        })?;
        set_surface(&mut mesh, &relit.surface);
        let report = RelightReport {
            before: room.radiosity,
            emitters: relit.surface.emitters.len(),
            complete: relit.complete,
            map_shots: relit.map_shots,
            object_shots: relit.object_shots,
        };
        Ok(self.wrap_result(mesh, relit.run, report))
    }

    fn build_mesh(&self) -> Result<Mesh> {
        let RelightStage {
            scene,
            room_faces: room,
            resolutions,
            ..
        } = self.stage;
        let meshing = self.settings.meshing;
        furnished_mesh(
            scene,
            *room,
            resolutions,
            [meshing.patches, meshing.samples],
            &is_interrupted,
        )
    }

    fn run_method(
        &self,
        mesh: &Mesh,
        room: &RoomRadiosity,
        method: RelightMethod,
        settings: &Settings,
        trace: Option<&TraceSlot>,
    ) -> Result<loops::RelitRoom> {
        let mut engine = self.solver.create_engine(mesh, &settings.transport)?;
        // Captured shots come first, then their consequences.
        let schedule = settings.schedule.with_southwell();
        let mut callback = |shot: &Shot, emitted| {
            let done = solve_progress(shot, emitted, settings.schedule.epsilon);
            self.progress.report_share("relight", done)
        };
        let relit = match trace {
            Some(slot) => {
                let mut recorder = ShotRecorder::new(engine.as_mut(), mesh, &settings.transport, slot.limits)?;
                let relit = relight_room(&mut recorder, mesh, room, method, &schedule, &mut callback)?;
                let mut recorded = recorder.into_trace();
                recorded.add_captured_light(mesh, room);
                slot.put_trace(recorded);
                relit
            }
            None => relight_room(engine.as_mut(), mesh, room, method, &schedule, &mut callback)?,
        };
        if self.progress.is_stopped() && !relit.complete {
            return Err(Error::Interrupted);
        }
        Ok(relit)
    }

    /// Recovers ρ and E of a captured room from its own light.
    fn recover_surface(&self, mesh: &Mesh, room: &RoomRadiosity) -> Result<TexelSurfaces> {
        let mut settings = *self.settings;
        settings.schedule.epsilon = 1.0;
        let relit = self.run_method(mesh, room, RelightMethod::Signed, &settings, None)?;
        if self.progress.is_stopped() {
            return Err(Error::Interrupted);
        }
        Ok(relit.surface)
    }

    /// Solves everything again, without B₀ and links of the empty room.
    fn solve_everything(&self, mut mesh: Mesh, room: RoomRadiosity, surface: Option<TexelSurfaces>) -> Result<Solved> {
        if let Some(surface) = &surface {
            set_surface(&mut mesh, surface);
        }
        let count = mesh.room_faces;
        mesh.room_faces = mesh.faces.len() as u32;
        let mut engine = self.solver.create_engine(&mesh, &self.settings.transport)?;
        // The same schedule as relighting, so that the two can be compared.
        let schedule = self.settings.schedule.with_southwell();
        let mut callback = |shot: &Shot, emitted| {
            let done = solve_progress(shot, emitted, self.settings.schedule.epsilon);
            self.progress.report_share("full", done)
        };
        let run = match self.trace {
            Some(slot) => {
                let mut recorder = ShotRecorder::new(engine.as_mut(), &mesh, &self.settings.transport, slot.limits)?;
                let run = shoot_until_converged(&mut recorder, &schedule, &mut callback)?;
                slot.put_trace(recorder.into_trace());
                run
            }
            None => shoot_until_converged(engine.as_mut(), &schedule, &mut callback)?,
        };
        drop(engine);
        mesh.room_faces = count;
        let emitters = surface.map_or(0, |s| s.emitters.len());
        let report = RelightReport::new(room.radiosity, emitters, &mesh, &run);
        Ok(self.wrap_result(mesh, run, report))
    }

    fn wrap_result(&self, mesh: Mesh, run: SolveRun, relit: RelightReport) -> Solved {
        Solved {
            relight: Some(relit),
            ..Solved::new(self.settings, mesh, run)
        }
    }
}

fn set_surface(mesh: &mut Mesh, surface: &TexelSurfaces) {
    for (k, texel) in mesh.texels.iter_mut().enumerate() {
        texel.reflectance = surface.reflectance[k];
        texel.emission = surface.emission[k];
    }
}
