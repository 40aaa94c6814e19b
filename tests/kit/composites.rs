//! Relit rooms for tests of the composite.

use crate::engines::{mesh_scene, settings_of, shoot_on_cpu};
use crate::factor_cases::rectangle;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Visibility;
use common::shooting::{RadiosityField, initial_field};
use glam::{DVec3, Vec3, Vec4};
use radiosity::relight::RelitScene;
use radiosity::relight::camera::camera_at;
use radiosity::relight::composite::Composite;
use radiosity::report::view::camera::Camera;

/// A room solved without and with objects: start and expected end of a relight.
pub struct SolvedRoom {
    /// The room's faces, then the objects'.
    pub scene: Scene,
    /// Their texels.
    pub mesh: Mesh,
    /// Faces of the room.
    pub room: usize,
    /// B₀ of each texel.
    pub before: Vec<Vec4>,
    /// B, r, H.
    pub after: RadiosityField,
}

impl SolvedRoom {
    /// Solves `scene`, whose first faces are the room's, with and without the others.
    pub fn new(scene: Scene, room: usize) -> Self {
        let settings = settings_of([8, 2, 1], Visibility::Rays, 1e-3);
        let field = |scene: &Scene| {
            let mesh = mesh_scene(scene, &settings);
            let field = shoot_on_cpu(&mesh, &settings).field;
            (mesh, field)
        };
        let mut empty = scene.clone();
        empty.faces.truncate(room);
        let mut before = field(&empty).1.radiosity;
        let (mesh, after) = field(&scene);
        before.resize(mesh.texels.len(), Vec4::ZERO);
        Self {
            scene,
            mesh,
            room,
            before,
            after,
        }
    }

    /// Returns the input of the composite, without a panorama.
    pub fn as_relit(&self) -> RelitScene<'_> {
        RelitScene {
            scene: &self.scene,
            mesh: &self.mesh,
            room: self.room,
            before: &self.before,
            after: &self.after,
            open: None,
            eye: None,
        }
    }
}

/// Makes a room with given radiosities: `before` and `after` of (face, centre in the scene).
pub fn room_by_hand(
    scene: Scene,
    room: usize,
    texels: u32,
    before: impl Fn(u32, DVec3) -> Vec3,
    after: impl Fn(u32, DVec3) -> Vec3,
) -> SolvedRoom {
    let mesh = Mesh::uniform(&scene, texels, 1).unwrap();
    let at = |of: &dyn Fn(u32, DVec3) -> Vec3, object: bool| -> Vec<Vec4> {
        let texels = mesh.texels.iter();
        let value = texels.map(|t| {
            let place = t.position.as_dvec3() * mesh.unit + mesh.origin;
            let none = !object && t.face as usize >= room;
            let value = if none { Vec3::ZERO } else { of(t.face, place) };
            value.extend(0.0)
        });
        value.collect()
    };
    let mut field = initial_field(&mesh, "by hand");
    field.radiosity = at(&after, true);
    SolvedRoom {
        before: at(&before, false),
        after: field,
        scene,
        room,
        mesh,
    }
}

/// Makes a floor of 2×2 in the plane y = 0, its front up.
pub fn square_floor() -> Face {
    let corners = rectangle([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0]);
    Face::quad("floor", corners, Vec3::ZERO, Vec3::splat(0.5))
}

/// Makes a camera that looks down from y = `height`, +z up in the picture, +x to its left.
pub fn camera_from_above(mesh: &Mesh, height: f64, fov: f64) -> Camera {
    let eye = DVec3::new(0.0, height, 0.0);
    Camera {
        up: Vec3::Z,
        ..camera_at(mesh, eye, DVec3::ZERO, fov)
    }
}

/// Returns the bits of pixels, for comparison without a tolerance.
pub fn pixel_bits(pixels: &[Vec3]) -> Vec<[u32; 3]> {
    let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
    pixels.iter().map(bits).collect()
}

/// Returns true if all pictures are finite and the mask is within 0…1.
pub fn is_finite(c: &Composite) -> bool {
    let all = [&c.background, &c.composite, &c.change, &c.objects];
    let pictures = all.iter().flat_map(|pixels| pixels.iter());
    pictures.into_iter().all(|v| v.is_finite()) && c.mask.iter().all(|m| (0.0..=1.0).contains(m))
}
