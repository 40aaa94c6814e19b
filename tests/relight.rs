//! Relighting held to the full solution, and to what can be worked out by hand.

use common::energy::Energy;
use common::mesh::Mesh;
use common::relight::{Mended, Method, Relit, Room, relight};
use common::scene::{Face, Scene};
use common::settings::{Settings, Visibility};
use common::shooting::{Engine, Field};
use cpu::CpuSolver;
use cpu::cover::furnished;
use glam::{DVec3, Vec3, Vec4};
use gpu::{Gpu, GpuSolver};
use radiosity_tests::engines::{free, gpu};
use radiosity_tests::{lit_room, room, scene};
use std::ops::ControlFlow;

const ALL: [Visibility; 5] = [
    Visibility::Rays,
    Visibility::Paper,
    Visibility::Hemisphere,
    Visibility::Stereographic,
    Visibility::Hemicube,
];

fn settings(visibility: Visibility) -> Settings {
    Settings {
        texels: 4,
        cells: 2,
        samples: 2,
        epsilon: 1e-4,
        item_buffer: 256,
        visibility,
        ..Settings::default()
    }
}

/// The lit room with its box as part of the room, and a second one as the object: it stands on the
/// floor, half on a cell.
fn furnished_room(objects: Vec<Face>) -> (Scene, usize) {
    let mut scene = lit_room();
    let count = scene.faces.len();
    scene.faces.extend(objects);
    (scene, count)
}

fn cube(emission: Vec3, reflectance: Vec3) -> Vec<Face> {
    let (low, high) = (DVec3::new(1.7, 0.0, 1.6), DVec3::new(2.3, 0.8, 2.7));
    let mut faces = room(low, high, false, emission, reflectance);
    // A body without a bottom stands on the floor.
    faces.remove(0);
    faces
}

fn mesh_of(scene: &Scene, count: usize, settings: &Settings) -> Mesh {
    let resolutions = vec![[settings.texels; 2]; scene.faces.len()];
    furnished(scene, count, &resolutions, settings).unwrap()
}

type Maker<'m> = dyn Fn(&'m Mesh, &Settings) -> Box<dyn Engine + 'm>;

fn on_cpu<'m>(mesh: &'m Mesh, settings: &Settings) -> Box<dyn Engine + 'm> {
    Box::new(CpuSolver::new(mesh, settings))
}

fn on_gpu<'m>(gpu: &Gpu) -> impl Fn(&'m Mesh, &Settings) -> Box<dyn Engine + 'm> {
    let gpu = gpu.clone();
    move |mesh, settings| Box::new(GpuSolver::new(&gpu, mesh, settings).unwrap())
}

/// The empty room solved on the texels that `mesh` has of it.
fn capture(scene: &Scene, mesh: &Mesh, settings: &Settings, epsilon: f64) -> Room {
    let empty = Scene {
        faces: scene.faces[..mesh.room as usize].to_vec(),
        ..scene.clone()
    };
    let room = mesh_of(&empty, empty.faces.len(), settings);
    let settings = Settings {
        epsilon,
        ..settings.clone()
    };
    let field = free(&mut CpuSolver::new(&room, &settings), &settings).field;
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

fn run(
    engine: &mut dyn Engine,
    mesh: &Mesh,
    room: &Room,
    method: Method,
    settings: &Settings,
) -> Relit {
    relight(engine, mesh, room, method, settings, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// √(ΣA(a − b)²/ΣA b²) of B − E, the worst channel.
fn error(mesh: &Mesh, a: &Field, b: &Field) -> f64 {
    let (mut square, mut scale) = (DVec3::ZERO, DVec3::ZERO);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let area = f64::from(texel.area);
        let reflected = |f: &Field| (f.radiosity[k].truncate() - texel.emission).as_dvec3();
        square += (reflected(a) - reflected(b)).powf(2.0) * area;
        scale += reflected(b).powf(2.0) * area;
    }
    (square / scale).max_element().sqrt()
}

/// The mesh as the relit room has it.
fn with_surface(mesh: &Mesh, relit: &Relit) -> Mesh {
    let mut mesh = mesh.clone();
    for (k, texel) in mesh.texels.iter_mut().enumerate() {
        texel.reflectance = relit.surface.reflectance[k];
        texel.emission = relit.surface.emission[k];
    }
    mesh
}

fn full(mesh: &Mesh, settings: &Settings) -> Field {
    let mut mesh = mesh.clone();
    mesh.room = mesh.faces.len() as u32;
    free(&mut CpuSolver::new(&mesh, settings), settings).field
}

#[test]
fn nothing_inserted_changes_nothing() {
    let gpu = gpu();
    for visibility in ALL {
        let settings = settings(visibility);
        let (scene, count) = furnished_room(Vec::new());
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-2);
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            for method in [Method::Signed, Method::Paper(Mended { empty_room: true, ..Mended::default() })] {
                let mut engine = make(&mesh, &settings);
                let relit = run(engine.as_mut(), &mesh, &room, method, &settings);
                let worst = relit.change.radiosity.iter().position(|d| *d != Vec4::ZERO);
                assert!(worst.is_none(), "{visibility:?} {} {worst:?} {:?}", relit.run.field.origin, relit.change.radiosity[worst.unwrap()]);
                assert_eq!(relit.run.field.radiosity, room.radiosity);
                assert!(relit.run.converged && relit.object_shots == 0 && relit.map_shots > 0);
            }
        }
    }
}

#[test]
fn signed_is_the_full_solution() {
    let gpu = gpu();
    for visibility in [Visibility::Rays, Visibility::Stereographic] {
        let settings = settings(visibility);
        let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::new(0.2, 0.5, 0.8)));
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-2);
        let truth = full(&mesh, &Settings { epsilon: 1e-6, ..settings.clone() });
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            let mut engine = make(&mesh, &settings);
            let relit = run(engine.as_mut(), &mesh, &room, Method::Signed, &settings);
            let error = error(&mesh, &relit.run.field, &truth);
            let energy = Energy::new(&with_surface(&mesh, &relit), &relit.run.field, &relit.run.shots);
            println!("{visibility:?}: {error:.2e}, imbalance {:.1e}, {} + {} shots", energy.imbalance, relit.map_shots, relit.object_shots);
            assert!(error < 1e-3, "{visibility:?}: {error}");
            assert!(energy.imbalance < 1e-4, "{energy:?}");
        }
    }
}
