//! Rooms and engines that the tests of relighting share.

use crate::engines::{drawn, free};
use crate::{lit_room, room};
use common::cover::furnished;
use common::mesh::Mesh;
use common::passes::Engine;
use common::relight::{Method, Relit, Room, relight};
use common::scene::{Face, Scene};
use common::settings::{Meshing, Projection, Raster, Schedule, Settings, Transport, Visibility};
use common::shooting::Field;
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use gpu::{Gpu, GpuSolver};
use oracle::judge::compare::difference::difference;
use std::ops::ControlFlow;

/// Every way to decide visibility.
pub const ALL: [Visibility; 5] = [
    Visibility::Rays,
    Visibility::drawn(Projection::Paper, 256),
    Visibility::drawn(Projection::Hemisphere(Raster::Pixel), 256),
    DRAWN,
    Visibility::drawn(Projection::Hemicube, 256),
];

/// By the item buffer of the default, but small.
pub const DRAWN: Visibility = drawn(256);

/// Small and quick; the samples and the cells that a body cuts are there.
pub fn settings(visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 4,
            cells: 2,
            samples: 2,
        },
        transport: Transport {
            visibility,
            ..Transport::default()
        },
        schedule: Schedule {
            epsilon: 1e-4,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// The lit room with its box as part of the room, and a second one as the object: it stands on the
/// floor, half on a cell.
pub fn furnished_room(objects: Vec<Face>) -> (Scene, usize) {
    let mut scene = lit_room();
    let count = scene.faces.len();
    scene.faces.extend(objects);
    (scene, count)
}

/// A body without a bottom that stands on the floor.
pub fn cube(emission: Vec3, reflectance: Vec3) -> Vec<Face> {
    let (low, high) = (DVec3::new(1.7, 0.0, 1.6), DVec3::new(2.3, 0.8, 2.7));
    let mut faces = room(low, high, false, emission, reflectance);
    // A body without a bottom stands on the floor.
    faces.remove(0);
    faces
}

/// The scene, of which the first `count` faces are the room.
pub fn mesh_of(scene: &Scene, count: usize, settings: &Settings) -> Mesh {
    let Meshing {
        texels,
        cells,
        samples,
    } = settings.meshing;
    let resolutions = vec![[texels; 2]; scene.faces.len()];
    furnished(scene, count, &resolutions, [cells, samples]).unwrap()
}

/// Makes an engine.
pub type Maker<'m> = dyn Fn(&'m Mesh, &Transport) -> Box<dyn Engine + 'm>;

/// The CPU's.
pub fn on_cpu<'m>(mesh: &'m Mesh, transport: &Transport) -> Box<dyn Engine + 'm> {
    Box::new(CpuSolver::new(mesh, transport))
}

/// The GPU's.
pub fn on_gpu<'m>(gpu: &Gpu) -> impl Fn(&'m Mesh, &Transport) -> Box<dyn Engine + 'm> {
    let gpu = gpu.clone();
    move |mesh, transport| Box::new(GpuSolver::new(&gpu, mesh, transport).unwrap())
}

/// The empty room solved on the texels that `mesh` has of it.
pub fn capture(scene: &Scene, mesh: &Mesh, settings: &Settings, epsilon: f64) -> Room {
    let empty = Scene {
        faces: scene.faces[..mesh.room as usize].to_vec(),
        ..scene.clone()
    };
    let room = mesh_of(&empty, empty.faces.len(), settings);
    let schedule = Schedule {
        epsilon,
        ..settings.schedule
    };
    let field = free(&mut CpuSolver::new(&room, &settings.transport), &schedule).field;
    let fill = |values: &[Vec4]| -> Vec<Vec4> {
        let mut all = vec![Vec4::ZERO; mesh.texels.len()];
        all[..values.len()].copy_from_slice(values);
        all
    };
    Room {
        radiosity: fill(&field.radiosity),
        residual: fill(&field.residual),
        reflectance: Some(mesh.texels.iter().map(|t| t.reflectance).collect()),
    }
}

/// A relight to its end.
pub fn run(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    room: &Room,
    method: Method,
    schedule: &Schedule,
) -> Relit {
    relight(engine, mesh, room, method, schedule, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// Relative RMS of B − E, the worst channel; NaN where a field is not complete and finite.
pub fn error(mesh: &Mesh, a: &Field, b: &Field) -> f64 {
    // Two runs of one solver are two results.
    let [a, b] = [(a, "a"), (b, "b")].map(|(field, name)| Field {
        origin: name.to_owned(),
        ..field.clone()
    });
    difference(mesh, &a, &b).relative_rms
}

/// The mesh as the relit room has it.
pub fn with_surface(mesh: &Mesh, relit: &Relit) -> Mesh {
    let mut mesh = mesh.clone();
    for (k, texel) in mesh.texels.iter_mut().enumerate() {
        texel.reflectance = relit.surface.reflectance[k];
        texel.emission = relit.surface.emission[k];
    }
    mesh
}

/// Everything solved, by the CPU.
pub fn full(mesh: &Mesh, transport: &Transport, schedule: &Schedule) -> Field {
    let mut mesh = mesh.clone();
    mesh.room = mesh.faces.len() as u32;
    free(&mut CpuSolver::new(&mesh, transport), schedule).field
}
