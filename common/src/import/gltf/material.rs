//! glTF materials: baseColorFactor is reflectance, emissiveFactor × strength emitted radiance.

use crate::import::builder::Builder;
use crate::import::surface::Surface;
use glam::DVec3;
use gltf::json::Material;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;

/// Reflectance and emission, or what is wrong with them.
pub fn surface(material: &Material, name: &str, builder: &mut Builder) -> Result<Surface, String> {
    let pbr = &material.pbr_metallic_roughness;
    let base = pbr.base_color_factor.0.map(f64::from);
    let reflectance = DVec3::new(base[0], base[1], base[2]);
    let emissive = DVec3::from(material.emissive_factor.0.map(f64::from));
    // A factor of 0 leaves nothing of its texture.
    let textures = [
        (
            "baseColorTexture",
            "baseColorFactor",
            pbr.base_color_texture.is_some() && reflectance != DVec3::ZERO,
        ),
        (
            "emissiveTexture",
            "emissiveFactor",
            material.emissive_texture.is_some() && emissive != DVec3::ZERO,
        ),
    ];
    if let Some((texture, factor, _)) = textures.iter().find(|(.., used)| *used) {
        return Err(format!(
            "a {texture} is not supported: remove it and set {factor}"
        ));
    }
    let extensions = material.extensions.as_ref();
    let strength = extensions
        .and_then(|e| e.emissive_strength.as_ref())
        .map_or(1.0, |s| s.emissive_strength.0);
    builder.surface(
        name,
        [reflectance, emissive * f64::from(strength)],
        ["baseColorFactor", "emissiveFactor"],
    )
}

/// Its name, or its number.
pub fn name(material: &Material, index: usize) -> String {
    material.name.clone().unwrap_or_else(|| index.to_string())
}

/// What of the material is not imported, in a few words.
pub fn left_out(material: &Material) -> Vec<&'static str> {
    let opaque = matches!(material.alpha_mode, Checked::Valid(AlphaMode::Opaque));
    let mut words = Vec::new();
    if !opaque && material.pbr_metallic_roughness.base_color_factor.0[3] < 1.0 {
        words.push("transparent, taken as opaque");
    }
    if material.double_sided {
        words.push("double-sided, but its backs are black: import it two-sided");
    }
    words
}
