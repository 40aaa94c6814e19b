//! Reads OBJ files: faces in file order, with their groups and materials.

mod conversion;
mod mtl;
mod number_precision;
mod text;

use super::builder::Builder;
use super::material::{ImportedMaterial, InputVertex, clamp_vertex_colour};
use super::picture_cache::PictureCache;
use crate::error::{Error, Result};
use crate::file::{self, MAX_FILE_BYTES};
use crate::paint::from_srgb;
use glam::{DVec2, DVec3, Vec3};
use mtl::MtlMaterial;
use number_precision::NumberPrecision;
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

/// Adds the faces of an OBJ file to `builder`.
///
/// Errors: the text is invalid, or a material file or a texture cannot be read.
pub fn read(builder: &mut Builder, path: &Path, bytes: &[u8]) -> Result<()> {
    let text = text::decode_text(path, bytes)?;
    let mut document = ObjDocument {
        group: "unnamed_object".into(),
        ..ObjDocument::default()
    };
    let mut lines = text::logical_lines(text).peekable();
    while let Some((number, line)) = lines.next() {
        let is_cut_off = lines.peek().is_none() && !text.ends_with('\n');
        document.read_line(path, number, &line, is_cut_off)?;
    }
    document.add_faces(builder, path)
}

/// A face; its vertices may follow it in the file.
struct ObjFace {
    line: usize,
    group: Rc<str>,
    material: Option<usize>,
    /// Vertices of the corners, from 0; out of range for an index that is missing or 0. The corners have normals and
    /// texture coordinates if each of them has some.
    corners: Vec<(usize, InputVertex)>,
}

/// Content of an OBJ file so far.
#[derive(Default)]
struct ObjDocument {
    vertices: Vec<DVec3>,
    /// Colours of the vertices, linear; white where a line has none.
    colours: Vec<DVec3>,
    /// True if any vertex has a colour.
    coloured: bool,
    /// First line that gives a vertex a weight.
    weight_line: Option<usize>,
    normals: Vec<Vec3>,
    texture_coordinates: Vec<DVec2>,
    precision: NumberPrecision,
    faces: Vec<ObjFace>,
    /// Group and material of the next face.
    group: Rc<str>,
    material: Option<usize>,
    materials: Vec<MtlMaterial>,
    /// Number of lines and points: `l`, `p`, and `f` with fewer than three corners.
    left_out: usize,
}

impl ObjDocument {
    fn read_line(&mut self, path: &Path, number: usize, line: &str, is_cut_off: bool) -> Result<()> {
        let fail = |message: String| Error::bad_input(path, format!("line {number}"), message);
        let (key, rest) = line.split_once(' ').unwrap_or((line, ""));
        let words: Vec<&str> = rest.split(' ').filter(|w| !w.is_empty()).collect();
        match key {
            "v" => self
                .read_vertex(number, &words)
                .map_err(|message| fail(message.into()))?,
            "vt" => {
                let place = [
                    parse_or_nan(words.first()),
                    words.get(1).map_or(0.0, |w| parse_or_nan(Some(w))),
                ];
                self.texture_coordinates.push(place.into());
            }
            "vn" => {
                let normal = [0, 1, 2].map(|k| parse_or_nan(words.get(k)) as f32);
                self.normals.push(normal.into());
            }
            "f" if words.len() < 3 && is_cut_off => {
                return Err(fail("the last face has too few corners: is the file cut off?".into()));
            }
            "f" if words.len() >= 3 => {
                let face = self.parse_face(number, &words);
                let message = "a corner of this face is not the number of a vertex";
                self.faces.push(face.ok_or_else(|| fail(message.into()))?);
            }
            "f" | "l" | "p" => self.left_out += 1,
            "o" | "g" => self.group = if rest.is_empty() { "unnamed_object" } else { rest }.into(),
            "mtllib" if rest.is_empty() => return Err(fail("mtllib names no file".into())),
            "mtllib" => self.read_libraries(path, number, rest)?,
            "usemtl" if rest.is_empty() => return Err(fail("usemtl names no material".into())),
            "usemtl" => {
                // The later of two materials with the same name counts.
                self.material = self.materials.iter().rposition(|m| m.name == rest);
                self.material.ok_or_else(|| {
                    fail(format!(
                        "material {rest} is not defined before this line: give its .mtl with mtllib, or remove usemtl"
                    ))
                })?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Reads a vertex of three numbers, which a weight or a colour may follow.
    fn read_vertex(&mut self, line: usize, words: &[&str]) -> std::result::Result<(), &'static str> {
        const CUT_OFF: &str = "a vertex needs three numbers: is the file cut off?";
        let number = |word: &&str| word.parse::<f64>().map_err(|_| CUT_OFF);
        let [x, y, z, rest @ ..] = words else {
            return Err(CUT_OFF);
        };
        [x, y, z].iter().for_each(|word| self.precision.record_number(word));
        let mut vertex = DVec3::new(number(x)?, number(y)?, number(z)?);
        let mut colour = DVec3::ONE;
        match rest {
            [] => {}
            [weight] => {
                let weight = number(weight)?;
                if weight == 0.0 {
                    return Err("a vertex has the weight 0");
                }
                vertex /= weight;
                self.weight_line.get_or_insert(line);
            }
            [r, g, b] => {
                // Blender and MeshLab write sRGB.
                let channel = |word: &&str| from_srgb(clamp_vertex_colour(parse_or_nan(Some(word)) as f32));
                colour = [r, g, b].map(channel).into();
                self.coloured = true;
            }
            _ => return Err("a vertex has too many numbers"),
        }
        self.vertices.push(vertex);
        self.colours.push(colour);
        Ok(())
    }

    /// Parses the corners of a face, `vertex/place/normal`; none if a part is not a number.
    fn parse_face(&self, line: usize, words: &[&str]) -> Option<ObjFace> {
        let counts = [self.vertices.len(), self.texture_coordinates.len(), self.normals.len()];
        let mut indices = Vec::with_capacity(words.len());
        for word in words {
            let mut corner = [usize::MAX; 3];
            for (k, part) in word.split('/').enumerate().filter(|(_, part)| !part.is_empty()) {
                let number: i64 = part.parse().ok()?;
                // A negative index counts from the latest value.
                let first = if number < 0 { *counts.get(k)? as i64 } else { -1 };
                *corner.get_mut(k)? = usize::try_from(first.checked_add(number)?).unwrap_or(usize::MAX);
            }
            indices.push(corner);
        }
        let coordinates_of = |corner: &[usize; 3]| self.texture_coordinates.get(corner[1]).copied();
        let normal_of = |corner: &[usize; 3]| self.normals.get(corner[2]).copied();
        let has_coordinates = indices.iter().all(|corner| coordinates_of(corner).is_some());
        let has_normals = indices.iter().all(|corner| normal_of(corner).is_some());
        let corner = |corner: &[usize; 3]| InputVertex {
            normal: normal_of(corner).filter(|_| has_normals),
            texture_coordinates: [coordinates_of(corner).filter(|_| has_coordinates); 2],
            ..InputVertex::default()
        };
        Some(ObjFace {
            line,
            group: self.group.clone(),
            material: self.material,
            corners: indices.iter().map(|indices| (indices[0], corner(indices))).collect(),
        })
    }

    /// Reads a material library, or several separated by spaces if no file has the whole name.
    fn read_libraries(&mut self, path: &Path, number: usize, names: &str) -> Result<()> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let is_one = file::path_below(folder, folder, names).is_ok_and(|library| library.is_file());
        for name in names.splitn(if is_one { 1 } else { usize::MAX }, ' ') {
            let library = file::path_below(folder, folder, name);
            let bytes = library.and_then(|library| Ok((file::read(&library, MAX_FILE_BYTES)?, library)));
            let (bytes, library) = bytes.map_err(|reason| {
                let message = format!(
                    "the material file {name} cannot be read: {reason}; put it beside the scene, or remove the mtllib and usemtl lines"
                );
                Error::bad_input(path, format!("line {number}"), message)
            })?;
            self.materials.extend(mtl::read_materials(folder, &library, &bytes)?);
        }
        Ok(())
    }

    fn add_faces(&self, builder: &mut Builder, path: &Path) -> Result<()> {
        if let Some(line) = self.weight_line.filter(|_| self.coloured) {
            let message = "has a weight, and other vertices have colours: remove one of them";
            return Err(Error::bad_input(path, format!("line {line}"), message));
        }
        let mut pictures = PictureCache::new();
        let mut used: BTreeMap<usize, ImportedMaterial> = BTreeMap::new();
        let (white, names) = ([DVec3::ONE, DVec3::ZERO], ["colour", ""]);
        let bare = ImportedMaterial::from_factors(path, "of its vertices", white, names);
        for face in &self.faces {
            let place = || format!("line {}", face.line);
            let vertex = |(k, corner): &(usize, InputVertex)| {
                let position = *self.vertices.get(*k)?;
                let rounding = position.to_array().map(|x| self.precision.rounding_error(x));
                Some(InputVertex {
                    position,
                    colour: self.coloured.then(|| self.colours[*k]),
                    rounding: rounding.into_iter().fold(0.0, f64::max),
                    ..*corner
                })
            };
            let corners: Option<Vec<InputVertex>> = face.corners.iter().map(vertex).collect();
            let missing = || Error::bad_input(path, place(), "a corner of this face is a vertex that does not exist");
            let corners = corners.ok_or_else(missing)?;
            if let Some(id) = face.material.filter(|id| !used.contains_key(id)) {
                let replaced = builder.reflectance.is_some();
                used.insert(id, self.materials[id].read_textures(&mut pictures, replaced)?);
            }
            let material = face.material.and_then(|id| used.get(&id));
            let material = material.or(self.coloured.then_some(&bare));
            builder.add_face(&face.group, &corners, false, material, place)?;
        }
        conversion::convert_document(self, &used, builder);
        let names_of = |wanted: fn(&MtlMaterial) -> bool| {
            let materials = used.keys().map(|id| &self.materials[*id]);
            let names = materials.filter(|m| wanted(m)).map(|m| m.name.as_str());
            names.collect::<Vec<_>>().join(", ")
        };
        let (blank, glossy) = (names_of(MtlMaterial::is_blank), names_of(|m| m.is_more_than_diffuse));
        let notes = [
            (!blank.is_empty()).then(|| format!("materials without Kd and Ke are black: {blank}")),
            (!glossy.is_empty())
                .then(|| format!("materials of which only Kd and Ke are used, not Ks, illum or d: {glossy}")),
            (self.left_out > 0).then(|| format!("{} points and lines left out", self.left_out)),
            self.coloured
                .then(|| "colours of vertices are taken as sRGB, and multiply Kd".into()),
            pictures.resolution_note(),
        ];
        notes.into_iter().flatten().for_each(|note| builder.add_note(note));
        Ok(())
    }
}

/// Parses a number; NaN if it is missing or invalid.
fn parse_or_nan(word: Option<&&str>) -> f64 {
    word.and_then(|word| word.parse().ok()).unwrap_or(f64::NAN)
}
