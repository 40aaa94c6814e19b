//! MTL: `Kd` is reflectance, `Ke` emitted radiance L.

use super::text::{self, Lines};
use crate::error::{Error, Result};
use crate::import::builder::Builder;
use crate::import::surface::Surface;
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
    /// Reflectance and emission.
    pub fn surface(&self, builder: &mut Builder) -> Result<Surface> {
        let fail =
            |message: String| Error::input(&self.file, format!("material {}", self.name), message);
        let emission_map = self.values.unknown_param.get("map_Ke");
        for (key, map) in [
            ("map_Kd", &self.values.diffuse_texture),
            ("map_Ke", &emission_map.cloned()),
        ] {
            if let Some(map) = map {
                return Err(fail(format!(
                    "the texture {key} {map} is not supported: remove it and set a colour"
                )));
            }
        }
        let colour = |value: Option<[f64; 3]>| value.map_or(DVec3::ZERO, DVec3::from);
        let colours = [self.values.diffuse, self.values.emissive].map(colour);
        let surface = builder.surface(&self.name, colours, ["Kd", "Ke"]);
        surface.map_err(fail)
    }

    /// Whether it says neither what it reflects nor what it emits.
    pub fn is_blank(&self) -> bool {
        self.values.diffuse.is_none() && self.values.emissive.is_none()
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
