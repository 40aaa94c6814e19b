//! The input of a relight: a room and the objects in it.

use super::captured_room::InputRoom;
use common::scene::Scene;
use glam::Vec3;

/// A room with objects, read and assembled.
pub struct RelightStage {
    /// The room.
    pub captured: InputRoom,
    /// The room's faces first, then the objects'.
    pub scene: Scene,
    /// Number of the room's faces.
    pub room_faces: usize,
    /// Texels W×H of every face.
    pub resolutions: Vec<[u32; 2]>,
    /// Given ρ of a captured room.
    pub reflectance: Option<Vec3>,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

impl RelightStage {
    /// Makes a stage from a scene whose first `room` faces are a room, still to be captured, and whose others are
    /// objects in it; N×N texels on every face.
    pub fn new(scene: &Scene, room: usize, texels: u32) -> Self {
        let empty = Scene {
            faces: scene.faces[..room].to_vec(),
            ..scene.clone()
        };
        let resolutions = vec![[texels; 2]; scene.faces.len()];
        Self {
            captured: InputRoom::new(empty, resolutions[..room].to_vec(), None),
            scene: scene.clone(),
            room_faces: room,
            resolutions,
            reflectance: None,
            notes: Vec::new(),
        }
    }
}
