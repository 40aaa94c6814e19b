//! OBJ by tobj: faces in file order, with their groups and materials.
//!
//! tobj sees only what matters here: vertices of which all have a colour or none, corners without normals and
//! texture coordinates, and all materials at once.

mod digits;
mod mtl;
mod text;
mod texture;

use super::builder::Builder;
use super::input::Polygon;
use super::material::{Colour, Material, of_vertex};
use super::pictures;
use crate::error::{Error, Result};
use crate::file::MAX_BYTES;
use crate::paint::from_srgb;
use digits::Digits;
use glam::{DVec2, DVec3, Vec3};
use std::path::Path;
use text::Lines;
use texture::Pictures;

/// Adds the faces of an OBJ file.
pub fn read(builder: &mut Builder, path: &Path, bytes: &[u8]) -> Result<()> {
    let source = Source::scan(path, text::utf8(path, bytes)?)?;
    let models = source.models(path)?;
    let mut pictures = Pictures(pictures::Pictures::new());
    let mut used = vec![None; source.materials.len()];
    let bare = Material {
        file: path.to_owned(),
        name: "of its vertices".into(),
        colours: [DVec3::ONE, DVec3::ZERO].map(Colour::plain),
        names: ["colour", ""],
    };
    let mut lines = source.faces.iter();
    for model in &models {
        let material = match model.mesh.material_id {
            Some(id) => {
                if used[id].is_none() {
                    let replaced = builder.replaces_reflectance();
                    used[id] = Some(source.materials[id].read(&mut pictures, replaced)?);
                }
                used[id].as_ref()
            }
            None => None,
        };
        for corners in polygons(&model.mesh) {
            let Corners { corners, colours } = corners;
            let line = lines.next();
            let number = line.map_or(0, |line| line.number);
            let places = line.map(|line| line.places.as_slice());
            let places = places.filter(|places| places.len() == corners.len());
            let material = material.or(colours.is_some().then_some(&bare));
            let coordinates = corners.iter().flat_map(DVec3::to_array);
            let rounding = coordinates.map(|x| source.digits.rounding(x));
            let polygon = Polygon {
                corners: &corners,
                normals: line.map_or(&[], |line| &line.normals),
                rounding: rounding.fold(0.0, f64::max),
                places: [places; 2],
                colours: colours.as_deref(),
                odd: false,
                chart: None,
            };
            builder.add(&model.name, &polygon, material, || format!("line {number}"))?;
        }
    }
    let used: Vec<bool> = used.iter().map(Option::is_some).collect();
    let notes = source.notes(&used);
    let notes = notes.into_iter().chain(pictures.0.note());
    notes.for_each(|note| builder.note(note));
    Ok(())
}

/// A place on a texture; one that is none is nowhere.
fn place(words: &[&str]) -> DVec2 {
    let number = |k: usize, default: f64| {
        let word = words.get(k);
        word.map_or(default, |word| word.parse().unwrap_or(f64::NAN))
    };
    DVec2::new(number(0, f64::NAN), number(1, 0.0))
}

/// A normal; one that is none says nothing.
fn normal(words: &[&str]) -> Vec3 {
    match words {
        [x, y, z, ..] => Vec3::from([x, y, z].map(|word| word.parse().unwrap_or(f32::NAN))),
        _ => Vec3::NAN,
    }
}

/// A face's corners, and their colours if the file has any.
struct Corners {
    corners: Vec<DVec3>,
    colours: Option<Vec<DVec3>>,
}

fn polygons(mesh: &tobj::Mesh) -> impl Iterator<Item = Corners> {
    let three = |all: &[f64], k: u32| {
        let at = 3 * k as usize;
        all.get(at..at + 3).map_or(DVec3::NAN, DVec3::from_slice)
    };
    // As Blender and MeshLab write them: sRGB.
    let colour = move |k: &u32| {
        let written = three(&mesh.vertex_color, *k).as_vec3();
        DVec3::from(written.to_array().map(|x| from_srgb(of_vertex(x))))
    };
    // No arities at all: triangles only.
    let faces = if mesh.face_arities.is_empty() {
        mesh.indices.len() / 3
    } else {
        mesh.face_arities.len()
    };
    let mut rest = mesh.indices.as_slice();
    (0..faces).map(move |f| {
        let arity = mesh.face_arities.get(f).map_or(3, |n| *n as usize);
        let (face, after) = rest.split_at(arity.min(rest.len()));
        rest = after;
        let coloured = !mesh.vertex_color.is_empty();
        Corners {
            corners: face.iter().map(|k| three(&mesh.positions, *k)).collect(),
            colours: coloured.then(|| face.iter().map(colour).collect()),
        }
    })
}

/// What a face's line says beyond its corners.
struct FaceLine {
    number: usize,
    /// At its corners, if there is one at each.
    normals: Vec<Vec3>,
    /// The texture coordinates there, if there are any at each.
    places: Vec<DVec2>,
}

/// An OBJ file, its materials read.
#[derive(Default)]
struct Source {
    lines: Lines,
    materials: Vec<mtl::Material>,
    faces: Vec<FaceLine>,
    /// All normals.
    normals: Vec<Vec3>,
    /// All texture coordinates.
    places: Vec<DVec2>,
    /// Of all vertices.
    digits: Digits,
    /// Lines and points: `l`, `p`, and `f` with fewer than three corners.
    left_out: usize,
    /// Whether some vertex has a colour.
    coloured: bool,
}

impl Source {
    fn scan(path: &Path, text: &str) -> Result<Self> {
        let mut source = Self::default();
        source.lines.push(0, "mtllib all");
        let lines = text::lines(text);
        source.coloured = lines.iter().any(|(_, line)| is_coloured(line));
        let count = lines.len();
        for (k, (number, line)) in lines.into_iter().enumerate() {
            let cut_off = k + 1 == count && !text.ends_with('\n');
            source.line(path, number, &line, cut_off)?;
        }
        Ok(source)
    }

    fn line(&mut self, path: &Path, number: usize, line: &str, last: bool) -> Result<()> {
        let fail = |message: String| Err(Error::input(path, format!("line {number}"), message));
        let (key, rest) = line.split_once(' ').unwrap_or((line, ""));
        let words: Vec<&str> = rest.split(' ').filter(|w| !w.is_empty()).collect();
        if key == "v" {
            words.iter().take(3).for_each(|word| self.digits.see(word));
        }
        match key {
            // Among vertices with a colour one without is white.
            "v" if self.coloured && words.len() == 3 => {
                self.lines.push(number, &format!("{line} 1 1 1"));
            }
            "v" if self.coloured && words.len() == 4 => {
                return fail(
                    "has a weight, and other vertices have colours: remove one of them".into(),
                );
            }
            "v" | "o" | "g" => self.lines.push(number, line),
            "f" if words.len() < 3 && last => {
                return fail("the last face has too few corners: is the file cut off?".into());
            }
            "f" if words.len() < 3 => self.left_out += 1,
            "f" => {
                self.faces.push(FaceLine {
                    number,
                    normals: at_corners(&words, 2, &self.normals),
                    places: at_corners(&words, 1, &self.places),
                });
                self.lines
                    .push(number, &format!("f {}", positions(&words).join(" ")));
            }
            "vt" => self.places.push(place(&words)),
            "vn" => self.normals.push(normal(&words)),
            "l" | "p" => self.left_out += 1,
            "mtllib" if rest.is_empty() => return fail("mtllib names no file".into()),
            "mtllib" => self.library(path, number, rest)?,
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

    /// A library, or several parted by spaces if there is none of the whole name.
    fn library(&mut self, path: &Path, number: usize, names: &str) -> Result<()> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let whole = folder.join(names).is_file() || !names.contains(' ');
        let names: Vec<&str> = if whole {
            vec![names]
        } else {
            names.split(' ').collect()
        };
        for name in names {
            let file = folder.join(name);
            let bytes = crate::file::read(&file, MAX_BYTES).map_err(|reason| {
                let message = format!(
                    "the material file {name} cannot be read: {reason}; put it beside the scene, or remove the mtllib and usemtl lines"
                );
                Error::input(path, format!("line {number}"), message)
            })?;
            self.materials.extend(mtl::read(&file, &bytes)?);
        }
        Ok(())
    }

    fn models(&self, path: &Path) -> Result<Vec<tobj::Model>> {
        // Of two materials of one name the later counts.
        let names = || {
            self.materials
                .iter()
                .enumerate()
                .map(|(k, m)| (m.name.clone(), k))
                .collect()
        };
        let options = tobj::LoadOptions {
            ignore_points: true,
            ignore_lines: true,
            ..Default::default()
        };
        let (models, _) = self.lines.parse(path, |text| {
            tobj::load_obj_buf(text, &options, |_| Ok((Vec::new(), names())))
        })?;
        Ok(models)
    }

    fn notes(&self, used: &[bool]) -> Vec<String> {
        let named = |wanted: fn(&mtl::Material) -> bool| {
            let used = self
                .materials
                .iter()
                .zip(used)
                .filter(|(m, used)| **used && wanted(m));
            used.map(|(m, _)| m.name.as_str())
                .collect::<Vec<_>>()
                .join(", ")
        };
        let (blank, glossy) = (
            named(mtl::Material::is_blank),
            named(mtl::Material::is_more_than_diffuse),
        );
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

/// Whether it is a vertex of six numbers: a position and a colour.
fn is_coloured(line: &str) -> bool {
    let mut words = line.split(' ');
    words.next() == Some("v") && words.count() == 6
}

/// What the corners of a face have by their `part`-th number; nothing where not all have one.
fn at_corners<T: Copy>(corners: &[&str], part: usize, all: &[T]) -> Vec<T> {
    let value = |corner: &&str| {
        let number: i64 = corner.split('/').nth(part)?.parse().ok()?;
        let from_end = number.checked_add(all.len() as i64)?;
        let k = if number < 0 { from_end } else { number - 1 };
        all.get(usize::try_from(k).ok()?).copied()
    };
    let values: Option<Vec<T>> = corners.iter().map(value).collect();
    values.unwrap_or_default()
}

/// Corners without texture coordinates and normals, unless there is nothing else.
fn positions<'a>(words: &[&'a str]) -> Vec<&'a str> {
    words
        .iter()
        .map(|word| {
            word.split('/')
                .next()
                .filter(|v| !v.is_empty())
                .unwrap_or(word)
        })
        .collect()
}
