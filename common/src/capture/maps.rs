//! Writes a room's lighting as one HDR radiance map per face, and reads it back. A solve writes such a folder on
//! request, and a relight takes one as its room.
//!
//! A folder holds `000-name.exr`, `001-name.exr`, … and `room.json`. That file describes each face as `result.json`
//! does, and names its map. R, G, B are radiance L = B/π, W/m²/sr, for paint programs and viewers; `radiosity.R/G/B`
//! hold B itself, since π·(B/π) does not give back B's last bit. Both are 32-bit float. On a quad the image's first
//! row is the last row of texels, at the edge from corner 3 to corner 2, so that a wall whose corner 0 is its lower
//! left is upright. A triangle's N² texels are read as one line in an N×N image, as in `lightmap.exr`.
//!
//! A pixel whose R, G, B differ from B/π in any bit, or that has no `radiosity.*`, was painted on in an
//! image editor: its radiosity is B = πL.

use crate::error::{Error, Result};
use crate::scene::{Scene, Shape};
use crate::solution::faces::{Description, FaceEntry, build_scene, face_label, is_in_range};
use crate::solution::pending::{NamedBytes, locate_file, write_files};
use crate::solution::pixels::ImagePlanes;
use crate::solution::write::encode_exr;
use crate::texel;
use glam::Vec3;
use serde_json::json;
use std::f32::consts::PI;
use std::path::{Component, Path};

/// A room with its lighting.
#[derive(Clone, Debug)]
pub struct MappedRoom {
    /// The faces; the notes list the maps that were painted on.
    pub scene: Scene,
    /// Texels W×H of each face (N×N on a triangle).
    pub resolutions: Vec<[u32; 2]>,
    /// B, W/m²: face after face, within a face row-major in its rectangle.
    pub radiosity: Vec<Vec3>,
}

/// Writes `scene` with its lighting into the folder `dir`, and creates the folder if needed: see [`encode_room`].
///
/// Errors: [`Error::Write`] with the file; those of [`encode_room`].
pub fn write(dir: &Path, scene: &Scene, resolutions: &[[u32; 2]], radiosity: &[Vec3]) -> Result<()> {
    write_files(dir, encode_room(scene, resolutions, radiosity)?)
}

/// Returns the names of the maps of a scene's faces, in the order of the faces, and `room.json`.
pub fn map_names(scene: &Scene) -> Vec<String> {
    let faces = scene.faces.iter().enumerate();
    let maps = faces.map(|(k, face)| format!("{k:03}-{}.exr", safe_file_name(&face.name)));
    maps.chain(["room.json".into()]).collect()
}

/// Encodes `scene` with its lighting as files: those of [`map_names`].
///
/// `radiosity` (W/m²) lists all texels face after face, each face of `resolutions` W×H texels.
///
/// Errors: [`Error::Usage`] if the lengths do not match.
pub fn encode_room(scene: &Scene, resolutions: &[[u32; 2]], radiosity: &[Vec3]) -> Result<Vec<NamedBytes>> {
    let first = texel::first_texels(resolutions);
    if resolutions.len() != scene.faces.len() || radiosity.len() != first[resolutions.len()] {
        return Err(Error::Usage(
            "a map needs a radiosity for every texel of every face".into(),
        ));
    }
    let mut files = Vec::new();
    let mut entries = Vec::new();
    for (k, (name, face)) in map_names(scene).into_iter().zip(&scene.faces).enumerate() {
        let resolution = &resolutions[k];
        let rows = pixel_order(face.shape, *resolution);
        let image = encode_map(*resolution, &rows, &radiosity[first[k]..first[k + 1]])?;
        entries.push(FaceEntry {
            file: Some(name.clone()),
            ..FaceEntry::new(face, *resolution)
        });
        files.push((name, image));
    }
    let text = format!("{:#}\n", json!({ "scene": scene.name, "faces": entries }));
    files.push(("room.json".into(), text.into_bytes()));
    Ok(files)
}

/// Reads a folder written by [`write()`], including maps edited since.
///
/// Errors ([`Error::Input`], with file and face): a file that is missing, damaged or of another
/// size, a missing channel, a radiance that is not finite, or painted and negative.
pub fn read(dir: &Path) -> Result<MappedRoom> {
    let path = locate_file(dir, "room.json");
    let description = Description::read(&path, "room", "a folder of maps is needed")?;
    let entries = &description.faces;
    for (k, entry) in entries.iter().enumerate() {
        let refuse = |message| Error::bad_input(&path, face_label(k), message);
        entry.check_emission().map_err(refuse)?;
    }
    let mut room = MappedRoom {
        scene: build_scene(&path, description.scene.as_deref().unwrap_or_default(), entries)?,
        resolutions: entries.iter().map(|e| e.texels).collect(),
        radiosity: Vec::new(),
    };
    for (k, entry) in entries.iter().enumerate() {
        let file = map_file_name(entry).map_err(|message| Error::bad_input(&path, face_label(k), message))?;
        let shape = room.scene.faces[k].shape;
        let (values, painted) = read_radiosity(&locate_file(dir, file), k, shape, entry.texels)?;
        room.radiosity.extend(values);
        if painted > 0 {
            let texels = texel::texel_count(entry.texels);
            room.scene.notes.push(format!(
                "{file}: {painted} of {texels} texels have no radiosity.R/G/B that belongs to R, G, B: π × radiance was taken"
            ));
        }
    }
    Ok(room)
}

/// Returns the name of the face's map, which must lie in the folder itself.
fn map_file_name(entry: &FaceEntry) -> std::result::Result<&str, String> {
    let name = entry.file.as_deref().ok_or("names no file")?;
    let mut parts = Path::new(name).components();
    match (parts.next(), parts.next()) {
        (Some(Component::Normal(_)), None) => Ok(name),
        _ => Err(format!("its file `{name}` is not a name in this folder")),
    }
}

/// Makes a file name of 1 to 40 characters: ASCII letters, digits and `-` are kept, others become `_`.
fn safe_file_name(name: &str) -> String {
    let keep = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }
    };
    let name: String = name.chars().take(40).map(keep).collect();
    if name.is_empty() { "face".into() } else { name }
}

/// Returns the texels' indices in the order of the image's pixels.
fn pixel_order(shape: Shape, [w, h]: [u32; 2]) -> Vec<usize> {
    let [w, h] = [w as usize, h as usize];
    match shape {
        Shape::Quad => (0..h).rev().flat_map(|j| j * w..(j + 1) * w).collect(),
        Shape::Triangle => (0..w * h).collect(),
    }
}

fn encode_map(size: [u32; 2], rows: &[usize], radiosity: &[Vec3]) -> Result<Vec<u8>> {
    let mut planes = Vec::new();
    for (c, letter) in ["R", "G", "B"].into_iter().enumerate() {
        let exact: Vec<f32> = rows.iter().map(|at| radiosity[*at][c]).collect();
        planes.push((letter.into(), exact.iter().map(|b| b / PI).collect()));
        planes.push((format!("radiosity.{letter}"), exact));
    }
    encode_exr(size, planes)
}

/// Reads a face's radiosity in the order of its texels. Also returns the number of texels whose value is
/// π × radiance, because they were painted on.
fn read_radiosity(path: &Path, k: usize, shape: Shape, size: [u32; 2]) -> Result<(Vec<Vec3>, usize)> {
    let refuse = |message: String| Error::bad_input(path, face_label(k), message);
    let [w, h] = size.map(|n| n as usize);
    // A little more than its own size, so that the message below can state another size.
    let planes = ImagePlanes::read(path, 4 * (w * h) as u64 + (1 << 16))?;
    if [planes.width, planes.height] != [w, h] {
        return Err(refuse(format!(
            "has {}×{} pixels instead of {w}×{h}: keep a map's size",
            planes.width, planes.height
        )));
    }
    let Some(radiance) = planes.colour_planes("") else {
        return Err(refuse("lacks a channel of R, G and B (radiance)".into()));
    };
    let exact = planes.colour_planes("radiosity.");
    let mut values = vec![Vec3::ZERO; w * h];
    let mut painted = 0;
    for (pixel, at) in pixel_order(shape, size).into_iter().enumerate() {
        let colour = |planes: [&[f32]; 3]| Vec3::from(planes.map(|plane| plane[pixel]));
        let radiance = colour(radiance);
        let bits = |value: Vec3| value.to_array().map(f32::to_bits);
        let kept = exact.map(colour).filter(|b| bits(*b / PI) == bits(radiance));
        painted += usize::from(kept.is_none());
        let value = kept.unwrap_or(radiance * PI);
        // A solver's own −1e-9 is kept; a painted value below black is an error.
        if !is_in_range(value) || (kept.is_none() && value.min_element() < 0.0) {
            return Err(refuse(format!(
                "its radiance at pixel {}, {} is negative, not finite or too large",
                pixel % w,
                pixel / w
            )));
        }
        values[at] = value;
    }
    Ok((values, painted))
}
