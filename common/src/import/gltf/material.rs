//! glTF materials: baseColorFactor × baseColorTexture is reflectance, emissiveFactor × strength ×
//! emissiveTexture emitted radiance.

use super::accessor::Result;
use super::texture::Pictures;
use crate::import::material::{Colour, Material};
use glam::DVec3;
use gltf::json;
use gltf::json::material::AlphaMode;
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use std::path::Path;

/// What it gives to faces, and the sets of coordinates of its textures; or what is wrong with it. Where the
/// reflectance is replaced, its texture is not read.
pub fn read(
    material: &json::Material,
    (file, name): (&Path, String),
    pictures: &mut Pictures,
    replaced: bool,
) -> Result<(Material, [Option<u32>; 2])> {
    let pbr = &material.pbr_metallic_roughness;
    let [r, g, b, _] = pbr.base_color_factor.0.map(f64::from);
    let extensions = material.extensions.as_ref();
    let strength = extensions
        .and_then(|e| e.emissive_strength.as_ref())
        .map_or(1.0, |s| s.emissive_strength.0);
    let emissive = DVec3::from(material.emissive_factor.0.map(f64::from));
    let base = pbr.base_color_texture.as_ref().filter(|_| !replaced);
    let base_factor = DVec3::new(r, g, b);
    let (reflectance, first) = colour(base_factor, (base, base_factor), pictures)?;
    let (radiance, second) = colour(
        emissive * f64::from(strength),
        (material.emissive_texture.as_ref(), DVec3::ZERO),
        pictures,
    )?;
    let material = Material {
        file: file.to_owned(),
        name,
        colours: [reflectance, radiance],
        names: ["baseColorFactor", "emissiveFactor"],
    };
    Ok((material, [first, second]))
}

/// A factor of 0 leaves nothing of its texture, and one of 1 all of it: `white` is what may not be reflected.
fn colour(
    factor: DVec3,
    (texture, white): (Option<&Info>, DVec3),
    pictures: &mut Pictures,
) -> Result<(Colour, Option<u32>)> {
    let used = texture.filter(|_| factor != DVec3::ZERO);
    let Some((texture, set)) = used.map(|info| pictures.texture(info, white)).transpose()? else {
        return Ok((Colour::plain(factor), None));
    };
    let texture = Some(texture);
    Ok((Colour { factor, texture }, Some(set)))
}

/// Its name, or its number.
pub fn name(material: &json::Material, index: usize) -> String {
    material.name.clone().unwrap_or_else(|| index.to_string())
}

/// What of the material is not imported, in a few words.
pub fn left_out(material: &json::Material) -> Vec<&'static str> {
    let pbr = &material.pbr_metallic_roughness;
    let opaque = matches!(material.alpha_mode, Checked::Valid(AlphaMode::Opaque));
    let extensions = material.extensions.as_ref();
    let mut words = Vec::new();
    if !opaque && (pbr.base_color_factor.0[3] < 1.0 || pbr.base_color_texture.is_some()) {
        words.push("transparent, taken as opaque");
    }
    if material.double_sided {
        words.push("double-sided, but its backs are black: import it two-sided");
    }
    if extensions.is_some_and(|e| e.unlit.is_some()) {
        words.push("unlit, taken as diffuse");
    }
    words
}
