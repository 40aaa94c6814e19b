//! MTL: `Kd` × `map_Kd` is reflectance, `Ke` × `map_Ke` emitted radiance L.

use super::text::{self, Lines};
use super::texture::Pictures;
use crate::error::{Error, Result};
use crate::import::material::{self as import, Colour};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// A material and the file that defines it.
pub struct Material {
    /// After `newmtl`.
    pub name: String,
    file: PathBuf,
    values: tobj::Material,
}

/// All materials of a file.
pub fn read(path: &Path, bytes: &[u8]) -> Result<Vec<Material>> {
    let mut lines = Lines::default();
    for (number, line) in text::lines(text::utf8(path, bytes)?) {
        let (key, values) = line.split_once(' ').unwrap_or((&line, ""));
        let colour: Vec<&str> = values.split(' ').filter(|w| !w.is_empty()).collect();
        match (key, colour.as_slice()) {
            // One number stands for all three channels; tobj wants all three.
            ("Kd" | "Ke", [grey]) => lines.push(number, &format!("{key} {grey} {grey} {grey}")),
            ("Kd" | "Ke", [] | [_, _]) => {
                return Err(Error::input(
                    path,
                    format!("line {number}"),
                    format!("{key} needs three numbers"),
                ));
            }
            ("Kd" | "Ke", ["spectral" | "xyz", ..]) => {
                return Err(Error::input(
                    path,
                    format!("line {number}"),
                    format!("{key} can only be given as RGB"),
                ));
            }
            ("Kd" | "Ke" | "newmtl" | "map_Kd" | "map_Ke", _) => lines.push(number, &line),
            // What is only remarked upon must not stop anyone.
            ("Ks", [r, g, b]) if [r, g, b].iter().all(|w| w.parse::<f64>().is_ok()) => {
                lines.push(number, &line)
            }
            ("illum", [model]) if model.parse::<u8>().is_ok() => lines.push(number, &line),
            ("d", [opacity]) if opacity.parse::<f64>().is_ok() => lines.push(number, &line),
            _ => {}
        }
    }
    let (materials, _) = lines.parse(path, |text| tobj::load_mtl_buf(text))?;
    let with_file = |values: tobj::Material| Material {
        name: values.name.clone(),
        file: path.to_owned(),
        values,
    };
    Ok(materials.into_iter().map(with_file).collect())
}

impl Material {
    /// What it gives to faces; the textures' pictures are read. Where the reflectance is replaced, its
    /// texture is not.
    pub fn read(&self, pictures: &mut Pictures, replaced: bool) -> Result<import::Material> {
        let values = &self.values;
        let map = values.diffuse_texture.as_deref().filter(|_| !replaced);
        let reflectance = self.colour(values.diffuse, ("map_Kd", map), true, pictures)?;
        let map = values.unknown_param.get("map_Ke").map(String::as_str);
        let radiance = self.colour(values.emissive, ("map_Ke", map), false, pictures)?;
        Ok(import::Material {
            file: self.file.clone(),
            name: self.name.clone(),
            colours: [reflectance, radiance],
            names: ["Kd", "Ke"],
        })
    }

    /// Without a colour a texture stands for itself; of a colour of 0 it leaves nothing. What is `reflected`
    /// is not all light.
    fn colour(
        &self,
        factor: Option<[f64; 3]>,
        (key, map): (&str, Option<&str>),
        reflected: bool,
        pictures: &mut Pictures,
    ) -> Result<Colour> {
        let alone = if map.is_some() {
            DVec3::ONE
        } else {
            DVec3::ZERO
        };
        let factor = factor.map_or(alone, DVec3::from);
        let Some(map) = map.filter(|_| factor != DVec3::ZERO) else {
            return Ok(Colour::plain(factor));
        };
        let white = if reflected { factor } else { DVec3::ZERO };
        let texture = pictures.texture(&self.file, map, white);
        let texture = texture.map_err(|message| self.fail(format!("{key} {message}")))?;
        Ok(Colour {
            factor,
            texture: Some(texture),
        })
    }

    /// What is wrong with it.
    fn fail(&self, message: String) -> Error {
        Error::input(&self.file, format!("material {}", self.name), message)
    }

    /// Whether it says neither what it reflects nor what it emits.
    pub fn is_blank(&self) -> bool {
        let values = &self.values;
        let maps = values.diffuse_texture.is_some() || values.unknown_param.contains_key("map_Ke");
        values.diffuse.is_none() && values.emissive.is_none() && !maps
    }

    /// Whether it is more than diffuse: glossy, transparent or mirroring.
    pub fn is_more_than_diffuse(&self) -> bool {
        self.values
            .specular
            .is_some_and(|ks| ks.iter().any(|v| *v != 0.0))
            || self
                .values
                .illumination_model
                .is_some_and(|model| model > 2)
            || self.values.dissolve.is_some_and(|d| d < 1.0)
    }
}
