//! A relight as a task of the pipeline: capture where the room is a scene, then one of the methods.

use super::climb::climb;
use super::room::Values;
use super::stage::Stage;
use super::warnings;
use crate::solve::check::Estimate;
use crate::solve::climb::advised;
use crate::solve::finder::OnGpu;
use crate::solve::interrupt::interrupted;
use crate::solve::solved::{Recovered, Solved};
use crate::solve::solver::Solver;
use crate::solve::task::Task;
use crate::solve::watch::Watch;
use common::cover::furnished_until;
use common::mesh::{Mesh, Texel};
use common::passes;
use common::relight::surface::Surface;
use common::relight::{Method, Room, relight};
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::{Run, Shot, progress, solve};
use common::solution::Warning;
use common::{Error, Result, relight as loops};
use cpu::hierarchy::find::Way;
use glam::{Vec3, Vec4};

/// A stage and the method; none: everything is solved again.
pub struct Relighting<'a> {
    /// What is relit.
    pub stage: &'a Stage,
    /// How.
    pub method: Option<Method>,
}

impl Task for Relighting<'_> {
    fn scene(&self) -> &Scene {
        &self.stage.scene
    }

    fn once(&self, settings: &Settings, solver: Solver, watch: &Watch) -> Result<Solved> {
        if let Some(asked) = solver.asked() {
            let again = match self.method {
                None => true,
                Some(Method::Signed) => false,
                Some(Method::Paper(_)) => {
                    return Err(Error::Usage(
                        "--method paper shoots: it is not solved to an error".into(),
                    ));
                }
            };
            let by = |way| climb(self.stage, again, settings, asked, way, watch);
            return match solver.gpu() {
                Some(gpu) => by(Way::By(&OnGpu::maker(gpu, &[]))),
                None => by(Way::Shafts),
            };
        }
        let work = Work {
            stage: self.stage,
            settings,
            solver,
            watch,
        };
        work.relight(self.method)
    }

    fn estimate(&self, solved: &Solved) -> Result<Option<Estimate>> {
        if let Some(moved) = &solved.moved {
            // What was captured need not close.
            return Ok(moved.estimate(&solved.mesh, &solved.run, 0.0));
        }
        warnings::estimate(self.stage, solved)
    }

    fn warnings(&self, solved: &Solved, estimate: Option<&Estimate>) -> Vec<Warning> {
        let paper = matches!(self.method, Some(Method::Paper(_)));
        let warnings = warnings::of(self.stage, solved, paper, estimate);
        match solved.moved {
            Some(_) => advised(warnings),
            None => warnings,
        }
    }

    /// Not asked: a captured wall may be lit by what the capture does not show.
    fn dark(&self, _: &Solved) -> Option<String> {
        None
    }
}

/// The empty room solved: what is captured of a scene.
pub fn capture(
    stage: &Stage,
    settings: &Settings,
    solver: Solver,
    watch: &Watch,
) -> Result<Values> {
    let scene = &stage.captured.scene;
    let (resolutions, meshing) = (&stage.captured.resolutions, settings.meshing);
    let mesh = furnished_until(
        scene,
        stage.room,
        resolutions,
        [meshing.cells, meshing.samples],
        &interrupted,
    )?;
    let mut engine = solver.engine(&mesh, &settings.transport)?;
    let run = passes::solve(engine.as_mut(), &mesh, &settings.schedule, &mut |done| {
        watch.tell("capture", done)
    })?;
    if watch.stopped() {
        return Err(Error::Interrupted);
    }
    let order = mesh.in_face_order();
    let ordered = |values: &[Vec4]| order.iter().map(|k| values[*k].truncate()).collect();
    let of = |value: fn(&Texel) -> Vec3| -> Vec<Vec3> {
        order.iter().map(|k| value(&mesh.texels[*k])).collect()
    };
    Ok(Values {
        radiosity: ordered(&run.field.radiosity),
        residual: Some(ordered(&run.field.residual)),
        reflectance: Some(of(|t| t.reflectance)),
        emission: Some(of(|t| t.emission)),
    })
}

/// Who relights, and how.
struct Work<'a> {
    stage: &'a Stage,
    settings: &'a Settings,
    solver: Solver<'a>,
    watch: &'a Watch<'a>,
}

impl Work<'_> {
    fn relight(&self, method: Option<Method>) -> Result<Solved> {
        let (stage, watch) = (self.stage, self.watch);
        let solved;
        let values = match &stage.captured.values {
            Some(values) => values,
            None => {
                solved = watch.of("capture", || {
                    capture(stage, self.settings, self.solver, watch)
                })?;
                &solved
            }
        };
        let mut mesh = watch.of("prepare", || self.mesh())?;
        let room = values.on(&mut mesh, stage.reflectance);
        // What the room emits is known of a scene, and of a solve.
        let known = stage.reflectance.is_none() && values.emission.is_some();
        let Some(method) = method else {
            let surface = match known {
                true => None,
                false => Some(watch.of("recover", || self.surface(&mesh, &room))?),
            };
            return watch.of("relight", || self.full(mesh, room, surface));
        };
        let relit = watch.of("relight", || {
            self.signed(&mesh, &room, method, self.settings)
        })?;
        set_surface(&mut mesh, &relit.surface);
        let told = Recovered {
            before: room.radiosity,
            emitters: relit.surface.emitters.len(),
            complete: relit.complete,
            map_shots: relit.map_shots,
            object_shots: relit.object_shots,
        };
        Ok(self.solved(mesh, relit.run, told))
    }

    fn mesh(&self) -> Result<Mesh> {
        let Stage {
            scene,
            room,
            resolutions,
            ..
        } = self.stage;
        let meshing = self.settings.meshing;
        furnished_until(
            scene,
            *room,
            resolutions,
            [meshing.cells, meshing.samples],
            &interrupted,
        )
    }

    fn signed(
        &self,
        mesh: &Mesh,
        room: &Room,
        method: Method,
        settings: &Settings,
    ) -> Result<loops::Relit> {
        let mut engine = self.solver.engine(mesh, &settings.transport)?;
        // Captured shots first, then what follows from them.
        let schedule = settings.schedule.one_by_one();
        let mut told = |shot: &Shot, emitted| {
            let done = progress(shot, emitted, settings.schedule.epsilon);
            self.watch.tell("relight", done)
        };
        let relit = relight(engine.as_mut(), mesh, room, method, &schedule, &mut told)?;
        if self.watch.stopped() && !relit.complete {
            return Err(Error::Interrupted);
        }
        Ok(relit)
    }

    /// ρ and E of a captured room, gathered on its own.
    fn surface(&self, mesh: &Mesh, room: &Room) -> Result<Surface> {
        let mut settings = *self.settings;
        settings.schedule.epsilon = 1.0;
        let relit = self.signed(mesh, room, Method::Signed, &settings)?;
        if self.watch.stopped() {
            return Err(Error::Interrupted);
        }
        Ok(relit.surface)
    }

    /// Everything solved again: neither B₀ nor a link of the empty room is used.
    fn full(&self, mut mesh: Mesh, room: Room, surface: Option<Surface>) -> Result<Solved> {
        if let Some(surface) = &surface {
            set_surface(&mut mesh, surface);
        }
        let count = mesh.room;
        mesh.room = mesh.faces.len() as u32;
        let mut engine = self.solver.engine(&mesh, &self.settings.transport)?;
        // As relighting shoots, so that the two can be compared.
        let schedule = self.settings.schedule.one_by_one();
        let run = solve(engine.as_mut(), &schedule, &mut |shot, emitted| {
            let done = progress(shot, emitted, self.settings.schedule.epsilon);
            self.watch.tell("full", done)
        })?;
        drop(engine);
        mesh.room = count;
        let of_objects = |cell: u32| mesh.is_object(mesh.cells[cell as usize].face);
        let object_shots = run.shots.iter().filter(|s| of_objects(s.cell)).count();
        let told = Recovered {
            before: room.radiosity,
            emitters: surface.map_or(0, |s| s.emitters.len()),
            complete: true,
            map_shots: run.shots.len() - object_shots,
            object_shots,
        };
        Ok(self.solved(mesh, run, told))
    }

    fn solved(&self, mesh: Mesh, run: Run, relit: Recovered) -> Solved {
        Solved {
            settings: *self.settings,
            mesh,
            run,
            one_by_one: false,
            matrix: None,
            moved: None,
            relit: Some(relit),
        }
    }
}

fn set_surface(mesh: &mut Mesh, surface: &Surface) {
    for (k, texel) in mesh.texels.iter_mut().enumerate() {
        texel.reflectance = surface.reflectance[k];
        texel.emission = surface.emission[k];
    }
}
