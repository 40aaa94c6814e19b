//! Description of a scene for the page's controls.

use crate::solve::LiveScene;
use common::scene::Face;
use glam::{DVec3, Vec3};
use serde::Serialize;

/// A scene as the page's controls show it.
#[derive(Debug, Serialize)]
pub struct SceneDescription {
    /// Name of the file.
    pub name: String,
    /// Number of faces.
    pub faces: usize,
    /// Texels per side of a face in the failure atlas; none if the scene is no case of it.
    pub texels: Option<u32>,
    /// Lowest and highest corner of its box.
    pub bounds: [[f64; 3]; 2],
    /// Faces by name, in file order.
    pub groups: Vec<FaceGroup>,
    /// Notes of the import.
    pub notes: Vec<String>,
}

/// Faces of one name.
#[derive(Debug, Serialize)]
pub struct FaceGroup {
    /// Their name.
    pub name: String,
    /// Number of faces.
    pub faces: usize,
    /// Power that they emit, summed over the channels, W in the scene's unit.
    pub power: f64,
    /// Mean reflectance.
    pub reflectance: [f32; 3],
    /// Lowest and highest corner of their box.
    pub bounds: [[f64; 3]; 2],
}

/// Describes a scene.
pub fn describe_scene(live: &LiveScene) -> SceneDescription {
    let scene = live.scene();
    let mut names: Vec<&str> = Vec::new();
    for face in &scene.faces {
        if !names.contains(&face.name.as_str()) {
            names.push(&face.name);
        }
    }
    let groups = names.iter().map(|name| {
        let faces: Vec<&Face> = scene.faces.iter().filter(|face| face.name == *name).collect();
        describe_group(name, &faces)
    });
    SceneDescription {
        name: scene.name.clone(),
        faces: scene.faces.len(),
        texels: live.case().map(|case| case.texels),
        bounds: face_bounds(scene.faces.iter()),
        groups: groups.collect(),
        notes: scene.notes.clone(),
    }
}

fn describe_group(name: &str, faces: &[&Face]) -> FaceGroup {
    let power = |face: &&Face| f64::from(face.emission.element_sum()) * face.area();
    let reflectance: Vec3 = faces.iter().map(|face| face.reflectance).sum();
    FaceGroup {
        name: name.to_owned(),
        faces: faces.len(),
        power: faces.iter().map(power).sum(),
        reflectance: (reflectance / faces.len() as f32).to_array(),
        bounds: face_bounds(faces.iter().copied()),
    }
}

/// Returns the box of the faces' corners.
fn face_bounds<'a>(faces: impl Iterator<Item = &'a Face>) -> [[f64; 3]; 2] {
    let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let corners = faces.flat_map(|face| face.corners);
    let [low, high] = corners.fold(start, |[low, high], corner| [low.min(corner), high.max(corner)]);
    [low.to_array(), high.to_array()]
}
