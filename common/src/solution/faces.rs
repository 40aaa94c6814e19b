//! Faces in the description files `result.json` and `room.json`. The reader and the writer of a solution share them
//! with the maps of a captured room.

use crate::error::{Error, Result};
use crate::file;
use crate::import::{is_convex_quad, is_solvable_emission};
use crate::mesh::{MAX_TEXELS, scene_bounds};
use crate::scene::{Face, Scene, Shape};
use crate::text::escape_control;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::Path;

/// Largest value of a stored texel, W/m².
const MAX_STORED_VALUE: f32 = 1e18;

/// A description file.
#[derive(Deserialize)]
pub(crate) struct Description {
    pub scene: Option<String>,
    /// Checksum of the lightmap; results of other programs have none.
    pub lightmap_crc32: Option<String>,
    pub faces: Vec<FaceEntry>,
}

impl Description {
    /// Reads the description of a `subject` at `path`; `wanted` is the folder that is needed instead.
    ///
    /// Errors: the file is missing or damaged, has no faces or too many texels, or a face is out of range.
    pub(crate) fn read(path: &Path, subject: &str, wanted: &str) -> Result<Self> {
        let refuse = |place: String, message: String| Err(Error::bad_input(path, place, message));
        let text = file::read_input(path, wanted)?;
        let description: Self = match serde_json::from_slice(&text) {
            Ok(description) => description,
            Err(e) => return refuse(String::new(), format!("does not describe a {subject}: {e}")),
        };
        if description.faces.is_empty() {
            return refuse(String::new(), "has no faces".into());
        }
        let mut texels = 0;
        for (k, entry) in description.faces.iter().enumerate() {
            if let Err(message) = entry.check_entry() {
                return refuse(face_label(k), message);
            }
            if entry.from.is_some_and(|face| face as usize >= description.faces.len()) {
                return refuse(face_label(k), "its `from` is not the number of a face".into());
            }
            texels += u64::from(entry.texels[0]) * u64::from(entry.texels[1]);
            if texels > MAX_TEXELS {
                return refuse(face_label(k), "too many texels in all faces".into());
            }
        }
        Ok(description)
    }
}

/// Entry of a face: its geometry and the place of its texels.
#[derive(Serialize, Deserialize)]
pub(crate) struct FaceEntry {
    #[serde(default)]
    pub name: String,
    pub kind: Shape,
    pub corners: Vec<[f64; 3]>,
    #[serde(skip_deserializing)]
    pub area: f64,
    pub texels: [u32; 2],
    /// In `result.json`: its rectangle x, y, w, h in the atlas.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rect: Option<[u32; 4]>,
    /// In `room.json`: its image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    #[serde(default)]
    pub emission: [f32; 3],
    #[serde(default)]
    pub reflectance: [f32; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<u32>,
}

impl FaceEntry {
    /// Describes a face, without the place of its texels.
    pub(crate) fn new(face: &Face, texels: [u32; 2]) -> Self {
        Self {
            name: face.name.clone(),
            kind: face.shape,
            corners: face.outline().iter().map(DVec3::to_array).collect(),
            area: face.area(),
            texels,
            rect: None,
            file: None,
            emission: face.emission.to_array(),
            reflectance: face.reflectance.to_array(),
            from: face.input_face,
        }
    }

    /// Checks that the face's corners and texels fit its kind, and that its values are in range.
    ///
    /// Errors: a message that follows the face's label.
    fn check_entry(&self) -> std::result::Result<(), String> {
        let expected = if self.kind == Shape::Quad { 4 } else { 3 };
        if self.corners.len() != expected {
            let count = self.corners.len();
            return Err(format!("has {count} corners instead of {expected}"));
        }
        if let Ok(corners) = <[[f64; 3]; 4]>::try_from(self.corners.as_slice())
            && !is_convex_quad(&corners.map(DVec3::from))
        {
            return Err("its corners are not those of a planar, convex quad".into());
        }
        if !is_in_range(self.emission.into()) {
            return Err("its emission is out of range".into());
        }
        if !is_reflectance(self.reflectance.into()) {
            return Err(format!(
                "its reflectance {:?} is not at least 0 and below 1 in every channel",
                self.reflectance
            ));
        }
        let [w, h] = self.texels;
        if w == 0 || h == 0 || (self.kind == Shape::Triangle && w != h) {
            return Err(format!("{w}×{h} texels do not fit its kind"));
        }
        Ok(())
    }

    /// Checks that the face's emission can be solved; only that by texel, which a capture writes, may be negative.
    ///
    /// Errors: a message that follows the face's label.
    pub(crate) fn check_emission(&self) -> std::result::Result<(), String> {
        match is_solvable_emission(self.emission.into()) {
            true => Ok(()),
            false => Err(format!(
                "its emission {:?} is negative in a channel or cannot be solved: use another unit",
                self.emission
            )),
        }
    }

    /// Converts the entry to a face; its corners must have been checked.
    fn to_face(&self) -> Face {
        // A triangle repeats its third corner.
        let corners = [0, 1, 2, 3].map(|k| DVec3::from(self.corners[k.min(self.corners.len() - 1)]));
        let (emission, reflectance) = (self.emission.into(), self.reflectance.into());
        Face {
            shape: self.kind,
            input_face: self.from,
            ..Face::quad(&escape_control(&self.name), corners, emission, reflectance)
        }
    }
}

/// Converts entries to faces, with the two sides of each sheet joined.
fn build_faces(entries: &[FaceEntry]) -> Vec<Face> {
    let mut faces: Vec<Face> = entries.iter().map(FaceEntry::to_face).collect();
    join_sheets(&mut faces);
    faces
}

/// Returns whether a reflectance is at least 0 and below 1 in every channel.
pub(crate) fn is_reflectance(reflectance: Vec3) -> bool {
    (reflectance.cmpge(Vec3::ZERO) & reflectance.cmplt(Vec3::ONE)).all()
}

/// Returns whether all values of a texel are small enough for 32-bit floats to hold the squares of their sums.
pub(crate) fn is_in_range(value: Vec3) -> bool {
    value.abs().cmple(Vec3::splat(MAX_STORED_VALUE)).all()
}

/// Returns the scene of a description at `path`, with its name.
///
/// Errors: its extent cannot be solved, no face has an area, or its lamps are lost in it.
pub(crate) fn build_scene(path: &Path, name: &str, entries: &[FaceEntry]) -> Result<Scene> {
    let scene = Scene {
        name: escape_control(name),
        faces: build_faces(entries),
        ..Scene::default()
    };
    let refuse = |message: String| Err(Error::bad_input(path, "", message));
    match scene_bounds(&scene) {
        Err(Error::Input { message, .. }) => refuse(message),
        Err(other) => Err(other),
        Ok(_) if scene.faces.iter().all(|face| face.area() == 0.0) => refuse("none of its faces has an area".into()),
        Ok(_) => scene.explain_lost_lamps().map_or(Ok(scene), refuse),
    }
}

/// Returns the label of face `k` in messages.
pub(crate) fn face_label(k: usize) -> String {
    format!("face {k}")
}

/// Joins each face with a `from` entry to the face whose corners it has in reverse: it is the back of this face.
fn join_sheets(faces: &mut [Face]) {
    let key = |face: &Face| face.corners.map(|c| c.to_array().map(f64::to_bits));
    let fronts: HashMap<_, usize> = faces.iter().enumerate().map(|(k, f)| (key(f), k)).collect();
    for back in 0..faces.len() {
        if faces[back].input_face.is_none() || faces[back].partner.is_some() {
            continue;
        }
        let Some(&front) = fronts.get(&key(&faces[back].reversed())) else {
            continue;
        };
        if front < back && faces[front].partner.is_none() {
            faces[back].partner = Some(front as u32);
            faces[front].partner = Some(back as u32);
        }
    }
}
