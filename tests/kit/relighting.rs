//! Rooms and reference solutions for tests of relighting.

use crate::engines::{hemicube, item_buffer, settings_of, shoot_on_cpu};
use crate::{box_faces, lit_room};
use common::cover;
use common::mesh::Mesh;
use common::passes::Engine;
use common::relight::{RelightMethod, RelitRoom, RoomRadiosity, relight_room};
use common::scene::{Face, Scene};
use common::settings::{ItemBufferProjection, Schedule, Settings, Visibility};
use common::shooting::RadiosityField;
use glam::{DVec3, Vec3, Vec4};
use oracle::diff::difference::compare_fields;
use std::ops::ControlFlow;

/// All kinds of visibility.
pub const VISIBILITIES: [Visibility; 5] = [
    Visibility::Rays,
    PAPER_BUFFER,
    Visibility::with_item_buffer(ItemBufferProjection::Hemisphere, 256),
    ITEM_BUFFER,
    hemicube(256),
];

/// Table 3 as printed.
pub const PAPER_BUFFER: Visibility = Visibility::with_item_buffer(ItemBufferProjection::Paper, 256);

/// The default item buffer, but small.
pub const ITEM_BUFFER: Visibility = item_buffer(256);

/// Returns small settings with several samples, and patches that an object cuts.
pub fn relight_settings(visibility: Visibility) -> Settings {
    settings_of([4, 2, 2], visibility, 1e-4)
}

/// Makes a box without a bottom that stands on the floor of the lit room and covers half of a patch.
pub fn bottomless_box(emission: Vec3, reflectance: Vec3) -> Vec<Face> {
    let (low, high) = (DVec3::new(1.7, 0.0, 1.6), DVec3::new(2.3, 0.8, 2.7));
    let mut faces = box_faces(low, high, false, emission, reflectance);
    faces.remove(0);
    faces
}

/// A room with objects, meshed, and its captured light.
pub struct FurnishedRoom {
    /// Settings of room and relight.
    pub settings: Settings,
    /// Texels of the room, then those of the objects.
    pub mesh: Mesh,
    /// The empty room's light.
    pub room: RoomRadiosity,
}

impl FurnishedRoom {
    /// Puts `objects` into the lit room, whose light is captured until ε.
    pub fn furnish(settings: Settings, objects: Vec<Face>, epsilon: f64) -> Self {
        let mut scene = lit_room();
        let count = scene.faces.len();
        scene.faces.extend(objects);
        Self::capture(settings, &scene, count, epsilon)
    }

    /// Captures the light of the first `count` faces of `scene` until ε.
    pub fn capture(settings: Settings, scene: &Scene, count: usize, epsilon: f64) -> Self {
        let mesh = furnished_mesh(scene, count, &settings);
        let mut empty = scene.clone();
        empty.faces.truncate(count);
        let mut exact = settings;
        exact.schedule.epsilon = epsilon;
        let field = shoot_on_cpu(&furnished_mesh(&empty, count, &settings), &exact).field;
        let room = captured_room(&field, &mesh);
        Self { settings, mesh, room }
    }

    /// Relights until the schedule ends.
    pub fn relight(&self, engine: &mut dyn Engine, method: RelightMethod) -> RelitRoom {
        self.relight_shots(engine, method, u32::MAX)
    }

    /// Relights with so many shots at most.
    pub fn relight_shots(&self, engine: &mut dyn Engine, method: RelightMethod, max_shots: u32) -> RelitRoom {
        let schedule = Schedule {
            max_shots,
            ..self.settings.schedule
        };
        relight_room(engine, &self.mesh, &self.room, method, &schedule, &mut |_, _| {
            ControlFlow::Continue(())
        })
        .unwrap()
    }

    /// Solves room and objects together on the CPU until ε.
    pub fn full_solution(&self, epsilon: f64) -> RadiosityField {
        let mut mesh = self.mesh.clone();
        mesh.room_faces = mesh.faces.len() as u32;
        let mut settings = self.settings;
        settings.schedule.epsilon = epsilon;
        shoot_on_cpu(&mesh, &settings).field
    }
}

/// Makes the captured room of a solution, extended to a mesh with objects.
pub fn captured_room(field: &RadiosityField, mesh: &Mesh) -> RoomRadiosity {
    let fill = |values: &[Vec4]| {
        let mut all = values.to_vec();
        all.resize(mesh.texels.len(), Vec4::ZERO);
        all
    };
    RoomRadiosity {
        radiosity: fill(&field.radiosity),
        residual: fill(&field.residual),
        reflectance: Some(mesh.texels.iter().map(|t| t.reflectance).collect()),
    }
}

/// Meshes a scene whose first `count` faces are the room.
pub fn furnished_mesh(scene: &Scene, count: usize, settings: &Settings) -> Mesh {
    let meshing = settings.meshing;
    let resolutions = vec![[meshing.texels; 2]; scene.faces.len()];
    cover::furnished_mesh(scene, count, &resolutions, [meshing.patches, meshing.samples], &|| {
        false
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
