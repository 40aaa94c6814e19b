//! Reads glTF materials: baseColorFactor × baseColorTexture is reflectance, emissiveFactor × strength ×
//! emissiveTexture emitted radiance.

use super::document::GltfResult;
use super::texture::GltfTextures;
use crate::import::material::{ImportedMaterial, TexturedColour};
use glam::DVec3;
use gltf::json;
use gltf::json::material::AlphaMode;
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use std::path::Path;

/// Reads a material, and the sets of texture coordinates of its textures. A `replaced` reflectance needs no
/// texture.
///
/// Errors: a texture cannot be read.
pub fn read_material(
    material: &json::Material,
    (file, name): (&Path, String),
    textures: &mut GltfTextures,
    replaced: bool,
) -> GltfResult<(ImportedMaterial, [Option<u32>; 2])> {
    let pbr = &material.pbr_metallic_roughness;
    let [r, g, b, _] = pbr.base_color_factor.0.map(f64::from);
    let extensions = material.extensions.as_ref();
    let strength = extensions
        .and_then(|e| e.emissive_strength.as_ref())
        .map_or(1.0, |s| s.emissive_strength.0);
    let emissive = DVec3::from(material.emissive_factor.0.map(f64::from));
    let base = pbr.base_color_texture.as_ref().filter(|_| !replaced);
    let base_factor = DVec3::new(r, g, b);
    let (reflectance, first) = read_colour(base_factor, (base, base_factor), textures)?;
    let (radiance, second) = read_colour(
        emissive * f64::from(strength),
        (material.emissive_texture.as_ref(), DVec3::ZERO),
        textures,
    )?;
    let material = ImportedMaterial {
        file: file.to_owned(),
        name,
        colours: [reflectance, radiance],
        names: ["baseColorFactor", "emissiveFactor"],
    };
    Ok((material, [first, second]))
}

/// Combines a factor with its texture; a factor of 0 needs no texture. Pixels stay below 1 in channels in which
/// `white` is 1 or more.
fn read_colour(
    factor: DVec3,
    (texture, white): (Option<&Info>, DVec3),
    textures: &mut GltfTextures,
) -> GltfResult<(TexturedColour, Option<u32>)> {
    let used = texture.filter(|_| factor != DVec3::ZERO);
    let Some((texture, set)) = used.map(|info| textures.read_texture(info, white)).transpose()? else {
        return Ok((TexturedColour::from_factor(factor), None));
    };
    let texture = Some(texture);
    Ok((TexturedColour { factor, texture }, Some(set)))
}

/// Returns the material's name, or its index.
pub fn material_name(material: &json::Material, index: usize) -> String {
    material.name.clone().unwrap_or_else(|| index.to_string())
}

/// Describes the features of the material that are not imported, for a note.
pub fn unsupported_features(material: &json::Material) -> Vec<&'static str> {
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
