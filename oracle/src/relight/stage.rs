//! What is relit: a room and the objects in it.

use super::room::Captured;
use common::scene::Scene;
use glam::Vec3;

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
    /// The first `room` faces of a scene are a room, not captured yet, the others objects in it; N×N
    /// texels on every face.
    pub fn new(scene: &Scene, room: usize, texels: u32) -> Self {
        let resolutions = vec![[texels; 2]; scene.faces.len()];
        Self {
            captured: Captured {
                scene: Scene {
                    faces: scene.faces[..room].to_vec(),
                    ..scene.clone()
                },
                resolutions: resolutions[..room].to_vec(),
                values: None,
                panorama: None,
                notes: Vec::new(),
            },
            scene: scene.clone(),
            room,
            resolutions,
            reflectance: None,
            notes: Vec::new(),
        }
    }
}
