//! Reads glTF materials and their textures: baseColorFactor × baseColorTexture is reflectance, emissiveFactor ×
//! strength × emissiveTexture emitted radiance. [`super`] reads each one that a primitive uses.

use super::GltfImport;
use super::document::GltfResult;
use crate::import::material::{ImportedMaterial, TexturedColour};
use crate::import::uri::read_uri;
use crate::paint::{TexturePicture, WrapMode, WrappedTexture};
use glam::{DAffine2, DMat2, DVec2, DVec3};
use gltf::json::material::{AlphaMode, Material};
use gltf::json::texture::{Info, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Image, Index};
use std::sync::Arc;

/// Words of the note on materials whose backs would be seen.
pub const DOUBLE_SIDED: &str = "double-sided, but their backs are black";

impl GltfImport<'_, '_> {
    /// Reads a material, and the sets of texture coordinates of its textures. A replaced reflectance needs no texture.
    ///
    /// Errors: a texture cannot be read.
    pub fn read_material(
        &mut self,
        material: &Material,
        name: String,
    ) -> GltfResult<(ImportedMaterial, [Option<u32>; 2])> {
        let replaced = self.builder.reflectance.is_some();
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, _] = pbr.base_color_factor.0.map(f64::from);
        let strength = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |s| f64::from(s.emissive_strength.0));
        let base = DVec3::new(r, g, b);
        let emissive = DVec3::from(material.emissive_factor.0.map(f64::from)) * strength;
        let base_texture = pbr.base_color_texture.as_ref().filter(|_| !replaced);
        let (reflectance, first) = self.read_colour(base, base_texture, base)?;
        let (radiance, second) = self.read_colour(emissive, material.emissive_texture.as_ref(), DVec3::ZERO)?;
        let material = ImportedMaterial {
            file: self.path.to_owned(),
            name,
            colours: [reflectance, radiance],
            names: ["baseColorFactor", "emissiveFactor"],
        };
        Ok((material, [first, second]))
    }

    /// Combines a factor with its texture, and returns the texture's set of coordinates; a factor of 0 needs no
    /// texture. Pixels stay below 1 in channels in which `white` is 1 or more.
    fn read_colour(
        &mut self,
        factor: DVec3,
        info: Option<&Info>,
        white: DVec3,
    ) -> GltfResult<(TexturedColour, Option<u32>)> {
        let Some(info) = info.filter(|_| factor != DVec3::ZERO) else {
            return Ok((TexturedColour { factor, texture: None }, None));
        };
        let root = &self.document.root;
        let texture = root.get(info.index);
        let texture = texture.ok_or_else(|| format!("texture {} does not exist", info.index))?;
        let repeating = Sampler::default();
        let sampler = texture.sampler.map_or(Ok(&repeating), |index| {
            root.get(index).ok_or_else(|| format!("sampler {index} does not exist"))
        })?;
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        let place = transform.map_or(DAffine2::IDENTITY, |t| {
            let [offset, scale] = [t.offset.0, t.scale.0].map(|v| DVec2::from(v.map(f64::from)));
            // Counter-clockwise as seen with v downwards.
            let turn = DMat2::from_angle(-f64::from(t.rotation.0));
            DAffine2::from_mat2_translation(turn * DMat2::from_diagonal(scale), offset)
        });
        let wrap = [&sampler.wrap_s, &sampler.wrap_t].map(|mode| match mode {
            Checked::Valid(WrappingMode::ClampToEdge) => WrapMode::Clamp,
            Checked::Valid(WrappingMode::MirroredRepeat) => WrapMode::Mirror,
            _ => WrapMode::Repeat,
        });
        let picture = self.read_picture(texture.source, white)?;
        let texture = Some((WrappedTexture { picture, wrap }, place));
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        Ok((TexturedColour { factor, texture }, Some(set)))
    }

    fn read_picture(&mut self, index: Index<Image>, factor: DVec3) -> GltfResult<Arc<TexturePicture>> {
        let (path, document) = (self.path, self.document);
        self.pictures.get(index.value(), factor, |most| {
            // The crate `gltf` gives a texture without a source this index too.
            let Some(image) = document.root.get(index) else {
                return Err("a texture has no image: export with textures in PNG, JPEG or WebP".into());
            };
            let wrong = |message: String| format!("image {index} {message}");
            let decode = |bytes: &[u8]| TexturePicture::decode_image(bytes, most);
            let picture = match (&image.uri, image.buffer_view) {
                (Some(uri), _) => decode(&read_uri(path, uri).map_err(wrong)?),
                (None, Some(view)) => decode(document.view_bytes(view).map_err(wrong)?),
                (None, None) => Err("has neither a uri nor a buffer view".into()),
            };
            picture.map_err(|message| match image.uri.as_deref() {
                Some(uri) if !uri.starts_with("data:") => format!("image {uri} {message}"),
                _ => wrong(message),
            })
        })
    }
}

/// Describes the features of the material that are not imported, for a note; `two_sided`: all backs become fronts.
pub fn unsupported_features(material: &Material, two_sided: bool) -> Vec<&'static str> {
    let pbr = &material.pbr_metallic_roughness;
    let opaque = matches!(material.alpha_mode, Checked::Valid(AlphaMode::Opaque));
    let see_through = !opaque && (pbr.base_color_factor.0[3] < 1.0 || pbr.base_color_texture.is_some());
    let unlit = material.extensions.as_ref().is_some_and(|e| e.unlit.is_some());
    let features = [
        (see_through, "transparent, taken as opaque"),
        (material.double_sided && !two_sided, DOUBLE_SIDED),
        (unlit, "unlit, taken as diffuse"),
    ];
    features
        .into_iter()
        .filter(|(has, _)| *has)
        .map(|(_, words)| words)
        .collect()
}
