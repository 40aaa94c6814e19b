//! Rooms, engines and reference solutions for tests of relighting.

use crate::engines::{item_buffer, shoot_freely};
use crate::{box_faces, lit_room};
use common::cover;
use common::mesh::Mesh;
use common::passes::Engine;
use common::relight::{RelightMethod, RelitRoom, RoomRadiosity, relight_room};
use common::scene::{Face, Scene};
use common::settings::{ItemBufferProjection, Meshing, Raster, Schedule, Settings, Transport, Visibility};
use common::shooting::RadiosityField;
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use gpu::{Gpu, GpuSolver};
use oracle::diff::difference::compare_fields;
use std::ops::ControlFlow;

/// All kinds of visibility.
pub const VISIBILITIES: [Visibility; 5] = [
    Visibility::Rays,
    Visibility::with_item_buffer(ItemBufferProjection::Paper, 256),
    Visibility::with_item_buffer(ItemBufferProjection::Hemisphere(Raster::Pixel), 256),
    ITEM_BUFFER,
    Visibility::with_item_buffer(ItemBufferProjection::Hemicube, 256),
];

/// The default item buffer, but small.
pub const ITEM_BUFFER: Visibility = item_buffer(256);

/// Returns small settings with several samples, and patches that an object cuts.
pub fn relight_settings(visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 4,
            patches: 2,
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

/// Makes the lit room with `objects`; returns the number of faces of the room, its box included.
pub fn furnished_room(objects: Vec<Face>) -> (Scene, usize) {
    let mut scene = lit_room();
    let count = scene.faces.len();
    scene.faces.extend(objects);
    (scene, count)
}

/// Makes a box without a bottom that stands on the floor and covers half of a patch.
pub fn bottomless_box(emission: Vec3, reflectance: Vec3) -> Vec<Face> {
    let (low, high) = (DVec3::new(1.7, 0.0, 1.6), DVec3::new(2.3, 0.8, 2.7));
    let mut faces = box_faces(low, high, false, emission, reflectance);
    faces.remove(0);
    faces
}

/// Meshes a scene whose first `count` faces are the room.
pub fn furnished_mesh(scene: &Scene, count: usize, settings: &Settings) -> Mesh {
    let Meshing {
        texels,
        patches,
        samples,
    } = settings.meshing;
    let resolutions = vec![[texels; 2]; scene.faces.len()];
    cover::furnished_mesh(scene, count, &resolutions, [patches, samples]).unwrap()
}

/// A function that makes an engine.
pub type EngineMaker<'m> = dyn Fn(&'m Mesh, &Transport) -> Box<dyn Engine + 'm>;

/// Makes the CPU's engine.
pub fn cpu_engine<'m>(mesh: &'m Mesh, transport: &Transport) -> Box<dyn Engine + 'm> {
    Box::new(CpuSolver::new(mesh, transport))
}

/// Returns a function that makes the GPU's engine.
pub fn gpu_engine<'m>(gpu: &Gpu) -> impl Fn(&'m Mesh, &Transport) -> Box<dyn Engine + 'm> {
    let gpu = gpu.clone();
    move |mesh, transport| Box::new(GpuSolver::new(&gpu, mesh, transport).unwrap())
}

/// Solves the empty room on the texels that `mesh` has of it.
pub fn capture_room(scene: &Scene, mesh: &Mesh, settings: &Settings, epsilon: f64) -> RoomRadiosity {
    let empty = Scene {
        faces: scene.faces[..mesh.room_faces as usize].to_vec(),
        ..scene.clone()
    };
    let room = furnished_mesh(&empty, empty.faces.len(), settings);
    let schedule = Schedule {
        epsilon,
        ..settings.schedule
    };
    let field = shoot_freely(&mut CpuSolver::new(&room, &settings.transport), &schedule).field;
    let fill = |values: &[Vec4]| -> Vec<Vec4> {
        let mut all = vec![Vec4::ZERO; mesh.texels.len()];
        all[..values.len()].copy_from_slice(values);
        all
    };
    RoomRadiosity {
        radiosity: fill(&field.radiosity),
        residual: fill(&field.residual),
        reflectance: Some(mesh.texels.iter().map(|t| t.reflectance).collect()),
    }
}

/// Relights until the schedule ends.
pub fn run_relight(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    room: &RoomRadiosity,
    method: RelightMethod,
    schedule: &Schedule,
) -> RelitRoom {
    relight_room(engine, mesh, room, method, schedule, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// Returns the relative RMS difference of B − E, the worst channel; NaN if a field is incomplete or not finite.
pub fn relative_error(mesh: &Mesh, a: &RadiosityField, b: &RadiosityField) -> f64 {
    // Runs of one solver have the same origin and would be refused as the same result.
    let [a, b] = [(a, "a"), (b, "b")].map(|(field, name)| RadiosityField {
        origin: name.to_owned(),
        ..field.clone()
    });
    compare_fields(mesh, &a, &b).relative_rms
}

/// Returns the mesh with the recovered reflectance and emission.
pub fn with_surface(mesh: &Mesh, relit: &RelitRoom) -> Mesh {
    let mut mesh = mesh.clone();
    for (k, texel) in mesh.texels.iter_mut().enumerate() {
        texel.reflectance = relit.surface.reflectance[k];
        texel.emission = relit.surface.emission[k];
    }
    mesh
}

/// Solves room and objects together on the CPU.
pub fn full_solution(mesh: &Mesh, transport: &Transport, schedule: &Schedule) -> RadiosityField {
    let mut mesh = mesh.clone();
    mesh.room_faces = mesh.faces.len() as u32;
    shoot_freely(&mut CpuSolver::new(&mesh, transport), schedule).field
}
