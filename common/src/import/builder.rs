//! Builds a scene from input polygons: splits them where necessary, applies materials and notes irregular faces. The
//! readers of OBJ and glTF files feed it.

use super::material::{ImportedMaterial, InputVertex};
use super::polygon::{self, ConvexPiece};
use super::scene_file::SceneFile;
use super::surface::{DEFAULT_REFLECTANCE, diffuse_surface};
use crate::error::{Error, Result};
use crate::scene::{Face, Scene};
use crate::sky::{Sky, Sun};
use crate::text::escape_control;
use glam::{DVec3, Vec2, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

/// Largest number of faces of a scene: a small glTF can name one mesh a million times.
pub const MAX_FACES: usize = 1 << 22;

/// Largest number of faces that a note names.
const MAX_NAMED_FACES: usize = 6;

/// Notes about materials: the words before and after their names. White is [`crate::paint::MAX_WHITE_REFLECTANCE`].
const WHITE_MATERIALS: [&str; 2] = ["materials ", " reflect all light: taken as 0.95"];
const PARTLY_WHITE_MATERIALS: [&str; 2] = ["materials ", " reflect all light in places: taken as 0.95 there"];
const NO_COORDINATES: [&str; 2] = [
    "textures on faces without coordinates are taken as their mean: materials ",
    "",
];

/// Builder of a scene.
pub struct Builder<'a> {
    path: &'a Path,
    /// Reflectance of all faces in place of the file's.
    pub reflectance: Option<Vec3>,
    /// First piece of each input face.
    pub faces: Vec<Face>,
    /// Further pieces of split faces.
    pub pieces: Vec<Face>,
    /// Suns of the file.
    pub suns: Vec<Sun>,
    /// The file as a glTF document, if it is kept.
    pub file: Option<SceneFile>,
    remarks: BTreeMap<&'static str, FaceTally>,
    /// Names of materials, by the words before and after them in a note.
    materials: BTreeMap<[&'static str; 2], BTreeSet<String>>,
    notes: Vec<String>,
}

impl<'a> Builder<'a> {
    /// Creates a builder without faces; `reflectance` replaces that of the file.
    pub fn new(path: &'a Path, reflectance: Option<Vec3>) -> Self {
        Self {
            path,
            reflectance,
            faces: Vec::new(),
            pieces: Vec::new(),
            suns: Vec::new(),
            file: None,
            remarks: BTreeMap::new(),
            materials: BTreeMap::new(),
            notes: Vec::new(),
        }
    }

    /// Adds a note for the user.
    pub fn add_note(&mut self, note: impl Into<String>) {
        self.notes.push(escape_control(&note.into()));
    }

    /// Adds an input face with these corners, counter-clockwise as seen from the front; `odd` if it was joined from two
    /// triangles over the diagonal from corner 1 to corner 3. `place` is its position in the file, for messages.
    ///
    /// Errors: a corner is not finite, the polygon or the scene is too large, or the material is invalid.
    pub fn add_face(
        &mut self,
        name: &str,
        corners: &[InputVertex],
        odd: bool,
        material: Option<&ImportedMaterial>,
        place: impl Fn() -> String,
    ) -> Result<()> {
        let k = self.faces.len();
        let count = corners.len();
        let message = if count == 0 || !corners.iter().all(|v| v.position.is_finite()) {
            Some("a corner is not a finite number".into())
        } else if count > polygon::MAX_CORNERS {
            let most = polygon::MAX_CORNERS;
            Some(format!(
                "has {count} corners, and {most} is the most: split it into triangles"
            ))
        } else if k + self.pieces.len() >= MAX_FACES {
            Some(format!(
                "more than {MAX_FACES} faces cannot be solved: simplify the mesh"
            ))
        } else {
            None
        };
        if let Some(message) = message {
            let place = format!("face {} ({})", k + 1, place());
            return Err(Error::bad_input(self.path, place, message));
        }
        let name = &escape_control(name);
        let positions: Vec<DVec3> = corners.iter().map(|v| v.position).collect();
        let (pieces, remarks) = polygon::split_polygon(&positions);
        let bare = match self.reflectance {
            None => "without material: reflectance 0.7, no emission",
            Some(_) => "without material: no emission",
        };
        for remark in remarks.into_iter().chain(material.is_none().then_some(bare)) {
            self.remarks.entry(remark).or_default().count_face(k);
        }
        let split = pieces.len() > 1;
        let lightmap_corners: Option<Vec<Vec2>> = corners.iter().map(|v| v.lightmap_coordinates).collect();
        let lightmap_corners = lightmap_corners.and_then(|corners| corners.try_into().ok());
        for (n, piece) in pieces.into_iter().enumerate() {
            let mut face = match piece {
                ConvexPiece::Quad(c) => Face::quad(name, c, Vec3::ZERO, Vec3::ZERO),
                ConvexPiece::Triangle(c) => Face::triangle(name, c, Vec3::ZERO, Vec3::ZERO),
            };
            let vertex = |c: &DVec3| *corners.iter().find(|v| v.position == *c).unwrap_or(&corners[0]);
            let own = face.corners.each_ref().map(vertex);
            self.apply_material(&mut face, &own, odd, material)?;
            face.input_face = split.then_some(k as u32);
            face.rounding = corners.iter().map(|v| v.rounding).fold(0.0, f64::max);
            let normals = own.iter().map(|v| v.normal?.try_normalize());
            face.corner_normals = normals.collect::<Option<Vec<_>>>().and_then(|all| all.try_into().ok());
            face.lightmap_corners = lightmap_corners;
            let list = if n == 0 { &mut self.faces } else { &mut self.pieces };
            list.push(face);
        }
        Ok(())
    }

    /// Sets reflectance, emission and paint of a face with these corners by its material.
    fn apply_material(
        &mut self,
        face: &mut Face,
        corners: &[InputVertex; 4],
        odd: bool,
        material: Option<&ImportedMaterial>,
    ) -> Result<()> {
        let given = self.reflectance;
        let Some(material) = material else {
            face.reflectance = given.unwrap_or(Vec3::splat(DEFAULT_REFLECTANCE));
            return Ok(());
        };
        let count = face.outline().len();
        let look = material.appearance_on(&corners[..count], odd, given.is_some());
        let mut means = look.factors;
        if let Some(paint) = &look.paint {
            let over = paint.mean_over(face.outline(), face.outline());
            let whole = paint.overall_mean(count);
            let mean = |k: usize| over[k].or(whole[k]).unwrap_or(look.factors[k]);
            means = [mean(0), mean(1)];
        }
        // No texel of the face emits more than the factor of its texture.
        let brightest = (look.paint.as_ref()).and_then(|paint| Some(paint.coats[1].as_ref()?.factor));
        let rho = given.map_or(means[0], |_| DVec3::ZERO);
        let surface = diffuse_surface(DVec3::ZERO, brightest.unwrap_or(DVec3::ZERO), material.names)
            .and_then(|_| diffuse_surface(rho, means[1], material.names));
        let [reflectance, emission] = surface.map_err(|message| {
            let place = format!("material {}", material.name);
            Error::bad_input(&material.file, place, message)
        })?;
        let is_white = means[0].as_vec3().max_element() == 1.0;
        let is_partly_white = !is_white && look.was_white;
        let remarks = [
            (NO_COORDINATES, look.lacks_coordinates),
            (WHITE_MATERIALS, given.is_none() && is_white),
            (PARTLY_WHITE_MATERIALS, given.is_none() && is_partly_white),
        ];
        for (remark, _) in remarks.into_iter().filter(|(_, applies)| *applies) {
            self.materials.entry(remark).or_default().insert(material.name.clone());
        }
        face.reflectance = given.unwrap_or(reflectance);
        face.emission = emission;
        face.paint = look.paint.and_then(|mut paint| {
            if face.emission == Vec3::ZERO {
                paint.coats[1] = None;
            }
            let varies = paint.coats.iter().any(Option::is_some);
            varies.then(|| Arc::new(paint))
        });
        Ok(())
    }

    /// Returns the scene with its notes.
    ///
    /// Errors: it has no faces, or none with an area.
    pub fn into_scene(mut self) -> Result<Scene> {
        let count = self.faces.len();
        let fail = |message: String| Err(Error::bad_input(self.path, "", message));
        if count == 0 {
            return fail("has no faces".into());
        }
        let flat = self.remarks.get(polygon::NO_AREA);
        if flat.is_some_and(|faces| faces.count == count) {
            return fail(format!("none of its {count} faces has an area"));
        }
        for (remark, faces) in &self.remarks {
            self.notes.push(faces.describe_faces(remark));
        }
        for ([before, after], names) in std::mem::take(&mut self.materials) {
            let names = names.into_iter().collect::<Vec<_>>().join(", ");
            self.add_note(format!("{before}{names}{after}"));
        }
        self.faces.append(&mut self.pieces);
        Ok(Scene {
            name: escape_control(&self.path.display().to_string()),
            faces: self.faces,
            notes: self.notes,
            sky: (!self.suns.is_empty()).then(|| {
                Arc::new(Sky {
                    suns: self.suns,
                    ..Sky::default()
                })
            }),
        })
    }
}

/// Number of input faces with a property, and the first of them.
#[derive(Default)]
struct FaceTally {
    count: usize,
    first: Vec<usize>,
}

impl FaceTally {
    fn count_face(&mut self, k: usize) {
        self.count += 1;
        if self.first.len() < MAX_NAMED_FACES {
            self.first.push(k);
        }
    }

    fn describe_faces(&self, what: &str) -> String {
        let names: Vec<String> = self.first.iter().map(|k| (k + 1).to_string()).collect();
        let is_longer = self.count > MAX_NAMED_FACES;
        let more = if is_longer { ", …" } else { "" };
        let s = if self.count == 1 { "" } else { "s" };
        format!("{} face{s} {what} ({}{more})", self.count, names.join(", "))
    }
}
