//! Reads OBJ files with tobj: faces in file order, with their groups and materials.
//!
//! tobj receives a simplified text: vertices of which all or none have a colour, and one library with all
//! materials. Normals and texture coordinates are read here, since tobj gives a corner without one that of the
//! corner before, and refuses a file with an invalid one.

mod mtl;
mod number_precision;
mod text;
mod texture;

use super::builder::Builder;
use super::material::{ImportedMaterial, InputPolygon, clamp_vertex_colour};
use super::picture_cache::PictureCache;
use crate::error::{Error, Result};
use crate::file::MAX_FILE_BYTES;
use crate::paint::from_srgb;
use glam::{DVec2, DVec3, Vec3};
use number_precision::NumberPrecision;
use std::path::Path;
use std::str::FromStr;
use text::NumberedLines;

/// Adds the faces of an OBJ file to `builder`.
///
/// Errors: the text is invalid, or a material file or a texture cannot be read.
pub fn read(builder: &mut Builder, path: &Path, bytes: &[u8]) -> Result<()> {
    let source = ObjSource::from_text(path, text::decode_text(path, bytes)?)?;
    let models = source.parse_models(path)?;
    let mut pictures = PictureCache::new();
    let mut used = vec![None; source.materials.len()];
    let (white, names) = ([DVec3::ONE, DVec3::ZERO], ["colour", ""]);
    let bare = ImportedMaterial::from_factors(path, "of its vertices", white, names);
    let mut lines = source.faces.iter();
    for model in &models {
        let mesh = &model.mesh;
        if let Some(id) = mesh.material_id.filter(|id| used[*id].is_none()) {
            let replaced = builder.replaces_reflectance();
            used[id] = Some(source.materials[id].read_textures(&mut pictures, replaced)?);
        }
        let material = mesh.material_id.and_then(|id| used[id].as_ref());
        let coloured = !mesh.vertex_color.is_empty();
        let material = material.or(coloured.then_some(&bare));
        let mut indices = mesh.indices.as_slice();
        // tobj keeps the faces in file order and does not triangulate them.
        while !indices.is_empty()
            && let Some(line) = lines.next()
        {
            let (face, rest) = indices.split_at(line.corner_count.min(indices.len()));
            indices = rest;
            let corners: Vec<DVec3> = face.iter().map(|k| vector(&mesh.positions, *k)).collect();
            // Blender and MeshLab write sRGB.
            let colour = |k: &u32| {
                let written = vector(&mesh.vertex_color, *k).as_vec3().to_array();
                DVec3::from(written.map(|x| from_srgb(clamp_vertex_colour(x))))
            };
            let colours: Option<Vec<DVec3>> = coloured.then(|| face.iter().map(colour).collect());
            let coordinates = corners.iter().flat_map(DVec3::to_array);
            let rounding = coordinates.map(|x| source.precision.rounding_error(x));
            let places = (line.places.len() == corners.len()).then_some(line.places.as_slice());
            let polygon = InputPolygon {
                corners: &corners,
                normals: &line.normals,
                rounding: rounding.fold(0.0, f64::max),
                texture_coordinates: [places; 2],
                colours: colours.as_deref(),
                ..InputPolygon::default()
            };
            let place = || format!("line {}", line.number);
            builder.add_face(&model.name, &polygon, material, place)?;
        }
    }
    let used: Vec<bool> = used.iter().map(Option::is_some).collect();
    let notes = source.collect_notes(&used);
    let notes = notes.into_iter().chain(pictures.resolution_note());
    notes.for_each(|note| builder.add_note(note));
    Ok(())
}

/// Parses numbers: an absent one is that of `absent`, an invalid one is `invalid`.
fn parse_numbers<T: Copy + FromStr, const N: usize>(words: &[&str], absent: [T; N], invalid: T) -> [T; N] {
    let number = |word: &&str| word.parse().unwrap_or(invalid);
    std::array::from_fn(|k| words.get(k).map_or(absent[k], number))
}

/// Returns vector k of a list of tobj.
fn vector(all: &[f64], k: u32) -> DVec3 {
    let values = all.get(3 * k as usize..).filter(|rest| rest.len() >= 3);
    values.map_or(DVec3::NAN, DVec3::from_slice)
}

/// Attributes of a face's line beside its positions.
struct FaceLine {
    number: usize,
    corner_count: usize,
    /// Normals of the corners; empty unless each has one.
    normals: Vec<Vec3>,
    /// Texture coordinates of the corners; empty unless each has some.
    places: Vec<DVec2>,
}

/// An OBJ file after its first pass, with its materials.
#[derive(Default)]
struct ObjSource {
    lines: NumberedLines,
    materials: Vec<mtl::MtlMaterial>,
    faces: Vec<FaceLine>,
    /// Normals of the file.
    normals: Vec<Vec3>,
    /// Texture coordinates of the file.
    places: Vec<DVec2>,
    /// Precision of all vertices.
    precision: NumberPrecision,
    /// Number of lines and points: `l`, `p`, and `f` with fewer than three corners.
    left_out: usize,
    /// True if any vertex has a colour.
    coloured: bool,
}

impl ObjSource {
    fn from_text(path: &Path, text: &str) -> Result<Self> {
        let mut source = Self::default();
        source.lines.push(0, "mtllib all");
        source.coloured = text::logical_lines(text).any(|(_, line)| is_coloured(&line));
        let mut lines = text::logical_lines(text).peekable();
        while let Some((number, line)) = lines.next() {
            let cut_off = lines.peek().is_none() && !text.ends_with('\n');
            source.parse_line(path, number, &line, cut_off)?;
        }
        Ok(source)
    }

    fn parse_line(&mut self, path: &Path, number: usize, line: &str, last: bool) -> Result<()> {
        let fail = |message: String| Err(Error::bad_input(path, format!("line {number}"), message));
        let (key, rest) = line.split_once(' ').unwrap_or((line, ""));
        let words: Vec<&str> = rest.split(' ').filter(|w| !w.is_empty()).collect();
        if key == "v" {
            let numbers = words.iter().take(3);
            numbers.for_each(|word| self.precision.record_number(word));
        }
        match key {
            // In a file with vertex colours, a vertex without one is white.
            "v" if self.coloured && words.len() == 3 => {
                self.lines.push(number, &format!("{line} 1 1 1"));
            }
            "v" if self.coloured && words.len() == 4 => {
                let message = "has a weight, and other vertices have colours: remove one of them";
                return fail(message.into());
            }
            "v" | "o" | "g" => self.lines.push(number, line),
            "f" if words.len() < 3 && last => {
                return fail("the last face has too few corners: is the file cut off?".into());
            }
            "f" if words.len() < 3 => self.left_out += 1,
            "f" => {
                self.faces.push(FaceLine {
                    number,
                    corner_count: words.len(),
                    normals: values_at_corners(&words, 2, &self.normals),
                    places: values_at_corners(&words, 1, &self.places),
                });
                self.lines.push(number, line);
            }
            "vt" => {
                let place = parse_numbers(&words, [f64::NAN, 0.0], f64::NAN);
                self.places.push(place.into());
            }
            "vn" => {
                let normal = parse_numbers(&words, [f32::NAN; 3], f32::NAN);
                self.normals.push(normal.into());
            }
            "l" | "p" => self.left_out += 1,
            "mtllib" if rest.is_empty() => return fail("mtllib names no file".into()),
            "mtllib" => self.read_libraries(path, number, rest)?,
            "usemtl" if rest.is_empty() => return fail("usemtl names no material".into()),
            "usemtl" if !self.materials.iter().any(|m| m.name == rest) => {
                return fail(format!(
                    "material {rest} is not defined before this line: give its .mtl with mtllib, or remove usemtl"
                ));
            }
            "usemtl" => self.lines.push(number, line),
            _ => {}
        }
        Ok(())
    }

    /// Reads a material library, or several separated by spaces if no file has the whole name.
    fn read_libraries(&mut self, path: &Path, number: usize, names: &str) -> Result<()> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let is_one = folder.join(names).is_file();
        for name in names.splitn(if is_one { 1 } else { usize::MAX }, ' ') {
            let file = folder.join(name);
            let bytes = crate::file::read(&file, MAX_FILE_BYTES).map_err(|reason| {
                let message = format!(
                    "the material file {name} cannot be read: {reason}; put it beside the scene, or remove the mtllib and usemtl lines"
                );
                Error::bad_input(path, format!("line {number}"), message)
            })?;
            self.materials.extend(mtl::read_materials(&file, &bytes)?);
        }
        Ok(())
    }

    fn parse_models(&self, path: &Path) -> Result<Vec<tobj::Model>> {
        // The later of two materials with the same name counts.
        let indices = || (0..).zip(&self.materials).map(|(k, m)| (m.name.clone(), k));
        let options = tobj::LoadOptions::default();
        let (models, _) = self.lines.parse(path, |text| {
            tobj::load_obj_buf(text, &options, |_| Ok((Vec::new(), indices().collect())))
        })?;
        Ok(models)
    }

    fn collect_notes(&self, used: &[bool]) -> Vec<String> {
        let named = |wanted: fn(&mtl::MtlMaterial) -> bool| {
            let used = self.materials.iter().zip(used).filter(|(_, used)| **used);
            let wanted = used.filter(|(material, _)| wanted(material));
            let names: Vec<&str> = wanted.map(|(material, _)| material.name.as_str()).collect();
            names.join(", ")
        };
        let blank = named(mtl::MtlMaterial::is_blank);
        let glossy = named(mtl::MtlMaterial::is_more_than_diffuse);
        let mut notes = Vec::new();
        if !blank.is_empty() {
            notes.push(format!("materials without Kd and Ke are black: {blank}"));
        }
        if !glossy.is_empty() {
            notes.push(format!(
                "materials of which only Kd and Ke are used, not Ks, illum or d: {glossy}"
            ));
        }
        if self.left_out > 0 {
            notes.push(format!("{} points and lines left out", self.left_out));
        }
        if self.coloured {
            notes.push("colours of vertices are taken as sRGB, and multiply Kd".into());
        }
        notes
    }
}

/// True for a vertex of six numbers: a position and a colour.
fn is_coloured(line: &str) -> bool {
    let mut words = line.split(' ');
    words.next() == Some("v") && words.count() == 6
}

/// Looks up an attribute at the corners of a face by their `part`-th index (1-based; negative: from the end).
/// Returns an empty list unless every corner has one.
fn values_at_corners<T: Copy>(corners: &[&str], part: usize, all: &[T]) -> Vec<T> {
    let value = |corner: &&str| {
        let number: i64 = corner.split('/').nth(part)?.parse().ok()?;
        let from_end = number.checked_add(all.len() as i64)?;
        let k = if number < 0 { from_end } else { number - 1 };
        all.get(usize::try_from(k).ok()?).copied()
    };
    let values: Option<Vec<T>> = corners.iter().map(value).collect();
    values.unwrap_or_default()
}
