//! Reads MTL files: `Kd` × `map_Kd` is reflectance, `Ke` × `map_Ke` emitted radiance L.

use super::text::{self, NumberedLines};
use super::texture::read_texture;
use crate::error::{Error, Result};
use crate::import::material::{ImportedMaterial, TexturedColour};
use crate::import::picture_cache::PictureCache;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// A material of an MTL file, its textures not yet read.
pub struct MtlMaterial {
    /// Name after `newmtl`.
    pub name: String,
    file: PathBuf,
    values: tobj::Material,
}

/// Reads all materials of a file.
///
/// Errors: a colour is not given as one or three RGB numbers, or tobj refuses a line.
pub fn read_materials(path: &Path, bytes: &[u8]) -> Result<Vec<MtlMaterial>> {
    let mut lines = NumberedLines::default();
    for (number, line) in text::logical_lines(text::decode_text(path, bytes)?) {
        let (key, values) = line.split_once(' ').unwrap_or((&line, ""));
        let colour: Vec<&str> = values.split(' ').filter(|w| !w.is_empty()).collect();
        let fail = |message| Err(Error::bad_input(path, format!("line {number}"), message));
        match (key, colour.as_slice()) {
            // One number stands for all three channels; tobj requires all three.
            ("Kd" | "Ke", [grey]) => lines.push(number, &format!("{key} {grey} {grey} {grey}")),
            ("Kd" | "Ke", [] | [_, _]) => return fail(format!("{key} needs three numbers")),
            ("Kd" | "Ke", ["spectral" | "xyz", ..]) => {
                return fail(format!("{key} can only be given as RGB"));
            }
            ("Kd" | "Ke" | "newmtl" | "map_Kd" | "map_Ke", _) => lines.push(number, &line),
            // These values only lead to notes: invalid ones are skipped.
            ("Ks", [r, g, b]) if [r, g, b].iter().all(|w| w.parse::<f64>().is_ok()) => lines.push(number, &line),
            ("illum", [model]) if model.parse::<u8>().is_ok() => lines.push(number, &line),
            ("d", [opacity]) if opacity.parse::<f64>().is_ok() => lines.push(number, &line),
            _ => {}
        }
    }
    let (materials, _) = lines.parse(path, |text| tobj::load_mtl_buf(text))?;
    let with_file = |values: tobj::Material| MtlMaterial {
        name: values.name.clone(),
        file: path.to_owned(),
        values,
    };
    Ok(materials.into_iter().map(with_file).collect())
}

impl MtlMaterial {
    /// Reads the textures of the material. A `replaced` reflectance needs no texture.
    ///
    /// Errors: a texture cannot be read.
    pub fn read_textures(&self, pictures: &mut PictureCache<PathBuf>, replaced: bool) -> Result<ImportedMaterial> {
        let values = &self.values;
        let map = values.diffuse_texture.as_deref().filter(|_| !replaced);
        let reflectance = self.read_colour(values.diffuse, ("map_Kd", map), true, pictures)?;
        let map = values.unknown_param.get("map_Ke").map(String::as_str);
        let radiance = self.read_colour(values.emissive, ("map_Ke", map), false, pictures)?;
        Ok(ImportedMaterial {
            file: self.file.clone(),
            name: self.name.clone(),
            colours: [reflectance, radiance],
            names: ["Kd", "Ke"],
        })
    }

    /// Combines a colour with its texture. A missing colour counts as 1 beside a texture and as 0 without one;
    /// a colour of 0 needs no texture. Pixels of a `reflected` colour stay below 1.
    fn read_colour(
        &self,
        factor: Option<[f64; 3]>,
        (key, map): (&str, Option<&str>),
        reflected: bool,
        pictures: &mut PictureCache<PathBuf>,
    ) -> Result<TexturedColour> {
        let alone = if map.is_some() { DVec3::ONE } else { DVec3::ZERO };
        let factor = factor.map_or(alone, DVec3::from);
        let Some(map) = map.filter(|_| factor != DVec3::ZERO) else {
            return Ok(TexturedColour::from_factor(factor));
        };
        let white = if reflected { factor } else { DVec3::ZERO };
        let texture = read_texture(pictures, &self.file, map, white).map_err(|message| {
            let place = format!("material {}", self.name);
            Error::bad_input(&self.file, place, format!("{key} {message}"))
        })?;
        Ok(TexturedColour {
            factor,
            texture: Some(texture),
        })
    }

    /// True if the material has neither `Kd` nor `Ke`, nor a texture for one of them.
    pub fn is_blank(&self) -> bool {
        let values = &self.values;
        let maps = values.diffuse_texture.is_some() || values.unknown_param.contains_key("map_Ke");
        values.diffuse.is_none() && values.emissive.is_none() && !maps
    }

    /// True if the material is glossy, transparent or mirroring.
    pub fn is_more_than_diffuse(&self) -> bool {
        let values = &self.values;
        values.specular.is_some_and(|ks| ks != [0.0; 3])
            || values.illumination_model.is_some_and(|model| model > 2)
            || values.dissolve.is_some_and(|d| d < 1.0)
    }
}
