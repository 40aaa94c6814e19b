//! A relight from what was read to the answer: capture where the room is a scene, then one of the
//! methods on one of the solvers.

use super::room::{Captured, Values};
use crate::solve::interrupt::interrupted;
use common::mesh::Mesh;
use common::passes;
use common::passes::Engine;
use common::relight::surface::Surface;
use common::relight::{Method, Relit, Room, relight};
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::{Run, Shot, progress, solve};
use common::{Error, Result};
use cpu::CpuSolver;
use cpu::occlusion::cover::furnished_until;
use glam::{Vec3, Vec4};
use gpu::{Gpu, GpuSolver};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::time::Instant;

/// What is relit, read and put together.
pub struct Stage {
    /// The room.
    pub captured: Captured,
    /// The room's faces first, then the objects'.
    pub scene: Scene,
    /// Faces of the room.
    pub room: usize,
    /// Texels of every face.
    pub resolutions: Vec<[u32; 2]>,
    /// ρ of a captured room, if it was given.
    pub reflectance: Option<Vec3>,
    /// What is worth saying.
    pub notes: Vec<String>,
}

impl Stage {
    /// Its texels, with the cells and samples of `settings`.
    pub fn mesh(&self, settings: &Settings) -> Result<Mesh> {
        furnished_until(
            &self.scene,
            self.room,
            &self.resolutions,
            settings,
            &interrupted,
        )
    }
}

/// Seconds of each phase, in the order of their first use.
#[derive(Default)]
pub struct Phases(pub Vec<(&'static str, f64)>);

impl Phases {
    /// Does the work and notes how long it took.
    pub fn of<T>(&mut self, phase: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.0.push((phase, start.elapsed().as_secs_f64()));
        result
    }

    /// The sum of some phases.
    pub fn get(&self, phases: &[&str]) -> f64 {
        let asked = self.0.iter().filter(|(name, _)| phases.contains(name));
        asked.fold(0.0, |sum, (_, seconds)| sum + seconds)
    }
}

/// Who works, and how.
pub struct Work<'a> {
    /// The options in force.
    pub settings: &'a Settings,
    /// The GPU; none: the CPU.
    pub device: Option<&'a Gpu>,
    /// Shows how far it is: phase, and the share of it that is done; breaks to stop.
    pub watch: &'a dyn Fn(&str, f64) -> ControlFlow<()>,
    /// Whether it was stopped.
    pub stopped: Cell<bool>,
}

/// A room relit, with the mesh as the answer has it.
pub struct Done {
    /// Texels with the ρ and E of the answer.
    pub mesh: Mesh,
    /// B₀.
    pub before: Vec<Vec4>,
    /// The solve.
    pub run: Run,
    /// Texels of the room that were found to emit.
    pub emitters: usize,
    /// Whether all that was captured was shot.
    pub complete: bool,
    /// Shots of the room's cells.
    pub map_shots: usize,
    /// Shots of the objects'.
    pub object_shots: usize,
}

impl Work<'_> {
    fn engine<'m>(&self, mesh: &'m Mesh) -> Result<Box<dyn Engine + 'm>> {
        Ok(match self.device {
            Some(gpu) => Box::new(GpuSolver::new(gpu, mesh, self.settings)?),
            None => Box::new(CpuSolver::new(mesh, self.settings)),
        })
    }

    /// Relights by `method`; none: everything solved again.
    pub fn relight(
        &self,
        stage: &Stage,
        method: Option<Method>,
        seconds: &mut Phases,
    ) -> Result<Done> {
        let solved;
        let values = match &stage.captured.values {
            Some(values) => values,
            None => {
                solved = seconds.of("capture", || self.capture(stage))?;
                &solved
            }
        };
        let mut mesh = seconds.of("prepare", || stage.mesh(self.settings))?;
        let room = values.on(&mut mesh, stage.reflectance);
        // What the room emits is known of a scene, and of a solve.
        let known = stage.reflectance.is_none() && values.emission.is_some();
        if let Some(method) = method {
            let relit = seconds.of("relight", || self.signed(&mesh, &room, method))?;
            return Ok(Done::new(mesh, room, relit));
        }
        let surface = if known {
            None
        } else {
            Some(seconds.of("recover", || self.surface(&mesh, &room))?)
        };
        seconds.of("relight", || self.full(mesh, room, surface))
    }

    /// The empty room solved: what is captured of a scene.
    pub fn capture(&self, stage: &Stage) -> Result<Values> {
        let scene = &stage.captured.scene;
        let mesh = furnished_until(
            scene,
            stage.room,
            &stage.captured.resolutions,
            self.settings,
            &interrupted,
        )?;
        let mut engine = self.engine(&mesh)?;
        let run = passes::solve(engine.as_mut(), &mesh, self.settings, &mut |done| {
            self.seen("capture", done)
        })?;
        if self.stopped.get() {
            return Err(Error::Interrupted);
        }
        let order = mesh.in_face_order();
        let ordered = |values: &[Vec4]| order.iter().map(|k| values[*k].truncate()).collect();
        let of = |value: fn(&common::mesh::Texel) -> Vec3| -> Vec<Vec3> {
            order.iter().map(|k| value(&mesh.texels[*k])).collect()
        };
        Ok(Values {
            radiosity: ordered(&run.field.radiosity),
            residual: Some(ordered(&run.field.residual)),
            reflectance: Some(of(|t| t.reflectance)),
            emission: Some(of(|t| t.emission)),
        })
    }

    fn signed(&self, mesh: &Mesh, room: &Room, method: Method) -> Result<Relit> {
        let mut engine = self.engine(mesh)?;
        let relit = relight(
            engine.as_mut(),
            mesh,
            room,
            method,
            self.settings,
            &mut |shot, emitted| self.seen_shot("relight", shot, emitted),
        )?;
        if self.stopped.get() && !relit.complete {
            return Err(Error::Interrupted);
        }
        Ok(relit)
    }

    fn solve(&self, engine: &mut dyn Engine, phase: &str) -> Result<Run> {
        solve(engine, self.settings, &mut |shot, emitted| {
            self.seen_shot(phase, shot, emitted)
        })
    }

    fn seen_shot(&self, phase: &str, shot: &Shot, emitted: f32) -> ControlFlow<()> {
        self.seen(phase, progress(shot, emitted, self.settings.epsilon))
    }

    fn seen(&self, phase: &str, done: f64) -> ControlFlow<()> {
        let flow = (self.watch)(phase, done);
        if flow.is_break() {
            self.stopped.set(true);
        }
        flow
    }

    /// ρ and E of a captured room, gathered on its own.
    fn surface(&self, mesh: &Mesh, room: &Room) -> Result<Surface> {
        let settings = Settings {
            epsilon: 1.0,
            ..self.settings.clone()
        };
        let gather = Work {
            settings: &settings,
            stopped: Cell::new(false),
            ..*self
        };
        let surface = gather.signed(mesh, room, Method::Signed)?.surface;
        if gather.stopped.get() {
            return Err(Error::Interrupted);
        }
        Ok(surface)
    }

    /// Everything solved again: neither B₀ nor a link of the empty room is used.
    fn full(&self, mut mesh: Mesh, room: Room, surface: Option<Surface>) -> Result<Done> {
        if let Some(surface) = &surface {
            set_surface(&mut mesh, surface);
        }
        let count = mesh.room;
        mesh.room = mesh.faces.len() as u32;
        let mut engine = self.engine(&mesh)?;
        let run = self.solve(engine.as_mut(), "full")?;
        drop(engine);
        mesh.room = count;
        let of_objects = |cell: u32| mesh.is_object(mesh.cells[cell as usize].face);
        let object_shots = run.shots.iter().filter(|s| of_objects(s.cell)).count();
        Ok(Done {
            before: room.radiosity,
            emitters: surface.map_or(0, |s| s.emitters.len()),
            complete: true,
            map_shots: run.shots.len() - object_shots,
            object_shots,
            run,
            mesh,
        })
    }
}

fn set_surface(mesh: &mut Mesh, surface: &Surface) {
    for (k, texel) in mesh.texels.iter_mut().enumerate() {
        texel.reflectance = surface.reflectance[k];
        texel.emission = surface.emission[k];
    }
}

impl Done {
    fn new(mut mesh: Mesh, room: Room, relit: Relit) -> Self {
        set_surface(&mut mesh, &relit.surface);
        Self {
            mesh,
            before: room.radiosity,
            emitters: relit.surface.emitters.len(),
            complete: relit.complete,
            map_shots: relit.map_shots,
            object_shots: relit.object_shots,
            run: relit.run,
        }
    }

    /// Texels with B below 0 in some channel, by more than the rounding of B₀ + δ: half an ulp of
    /// what the texel had a shot.
    pub fn negative_texels(&self) -> usize {
        let roundings = self.run.shots.len() as f32 * f32::EPSILON;
        let negative = |(b, before): &(&Vec4, &Vec4)| {
            let bound = before.truncate() * roundings;
            b.truncate().cmplt(-bound).any()
        };
        let values = self.run.field.radiosity.iter().zip(&self.before);
        values.filter(negative).count()
    }
}
