//! Reads glTF textures: pictures inside or relative to the file, wrap modes and coordinate transforms.

use super::document::{GltfDocument, GltfResult, read_uri};
use crate::import::material::MaterialTexture;
use crate::import::picture_cache::PictureCache;
use crate::paint::{TexturePicture, WrapMode};
use glam::{DAffine2, DMat2, DVec2, DVec3};
use gltf::json::texture::{Info, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Image, Index};
use std::path::Path;
use std::sync::Arc;

/// Textures of a file, with a cache of its pictures.
pub struct GltfTextures<'d> {
    path: &'d Path,
    document: &'d GltfDocument,
    /// Pictures read so far.
    pub pictures: PictureCache<usize>,
}

impl<'d> GltfTextures<'d> {
    /// Creates an empty cache.
    pub fn new(path: &'d Path, document: &'d GltfDocument) -> Self {
        Self {
            path,
            document,
            pictures: PictureCache::new(),
        }
    }

    /// Reads a texture for a colour of this `factor`; returns it with its set of texture coordinates.
    ///
    /// Errors: the texture, its sampler or its picture is missing or cannot be read.
    pub fn read_texture(&mut self, info: &Info, factor: DVec3) -> GltfResult<(MaterialTexture, u32)> {
        let root = &self.document.root;
        let index = info.index;
        let texture = root.get(index);
        let texture = texture.ok_or_else(|| format!("texture {index} does not exist"))?;
        let repeating = Sampler::default();
        let sampler = texture.sampler.map_or(Ok(&repeating), |index| {
            let missing = || format!("sampler {index} does not exist");
            root.get(index).ok_or_else(missing)
        })?;
        let extensions = info.extensions.as_ref();
        let transform = extensions.and_then(|e| e.texture_transform.as_ref());
        let place = transform.map_or(DAffine2::IDENTITY, |t| {
            let [offset, scale] = [t.offset.0, t.scale.0].map(|v| DVec2::from(v.map(f64::from)));
            // Counter-clockwise as seen with v downwards.
            let turn = DMat2::from_angle(-f64::from(t.rotation.0));
            DAffine2::from_mat2_translation(turn * DMat2::from_diagonal(scale), offset)
        });
        let set = transform.and_then(|t| t.tex_coord);
        let texture = MaterialTexture {
            picture: self.read_picture(texture.source, factor)?,
            wrap: [&sampler.wrap_s, &sampler.wrap_t].map(convert_wrap_mode),
            transform: place,
        };
        Ok((texture, set.unwrap_or(info.tex_coord)))
    }

    fn read_picture(&mut self, index: Index<Image>, factor: DVec3) -> GltfResult<Arc<TexturePicture>> {
        let (path, document) = (self.path, self.document);
        self.pictures.get(index.value(), factor, |most| {
            // The crate `gltf` gives a texture without a source this index too.
            let Some(image) = document.root.get(index) else {
                return Err("a texture has no image: export with textures in PNG or JPEG".into());
            };
            let wrong = |message: String| format!("image {index} {message}");
            let decode = |bytes: &[u8]| TexturePicture::decode_image(bytes, most);
            let picture = match (&image.uri, image.buffer_view) {
                (Some(uri), _) => decode(&read_uri(path, uri).map_err(wrong)?),
                (None, Some(view)) => decode(document.view_bytes(view).map_err(wrong)?),
                (None, None) => Err("has neither a uri nor a buffer view".into()),
            };
            let name = match image.uri.as_deref() {
                Some(uri) if !uri.starts_with("data:") => format!("image {uri}"),
                _ => format!("image {index}"),
            };
            picture.map_err(|message| format!("{name} {message}"))
        })
    }
}

fn convert_wrap_mode(mode: &Checked<WrappingMode>) -> WrapMode {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => WrapMode::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => WrapMode::Mirror,
        _ => WrapMode::Repeat,
    }
}
