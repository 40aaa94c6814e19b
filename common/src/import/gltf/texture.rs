//! Textures of glTF: pictures within the file or beside it, and how they lie on faces.

use super::accessor::Result;
use super::buffers::{Document, fetch};
use crate::import::material::Texture;
use crate::import::pictures;
use crate::paint::{Picture, Wrap};
use glam::{DAffine2, DMat2, DVec2, DVec3};
use gltf::json::texture::{Info, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Image, Index};
use std::path::Path;
use std::sync::Arc;

/// The pictures of a file that were read so far.
pub struct Pictures<'d> {
    path: &'d Path,
    document: &'d Document,
    read: pictures::Pictures<usize>,
}

impl<'d> Pictures<'d> {
    /// None yet.
    pub fn new(path: &'d Path, document: &'d Document) -> Self {
        Self {
            path,
            document,
            read: pictures::Pictures::new(),
        }
    }

    /// What is to be said of them.
    pub fn note(&self) -> Option<String> {
        self.read.note()
    }

    /// A texture for a colour of a `factor`, and the set of its coordinates.
    pub fn texture(&mut self, info: &Info, factor: DVec3) -> Result<(Texture, u32)> {
        let root = &self.document.root;
        let index = info.index;
        let texture = root
            .get(index)
            .ok_or_else(|| format!("texture {index} does not exist"))?;
        let wrap = match texture.sampler {
            None => [Wrap::Repeat; 2],
            Some(sampler) => {
                let sampler = root
                    .get(sampler)
                    .ok_or_else(|| format!("sampler {sampler} does not exist"))?;
                [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)]
            }
        };
        let extensions = info.extensions.as_ref();
        let transform = extensions.and_then(|e| e.texture_transform.as_ref());
        let place = transform.map_or(DAffine2::IDENTITY, |t| {
            let [offset, scale] = [t.offset.0, t.scale.0].map(|v| DVec2::from(v.map(f64::from)));
            // Counter-clockwise as seen, that is with v downwards.
            let turn = DMat2::from_angle(-f64::from(t.rotation.0));
            DAffine2::from_mat2_translation(turn * DMat2::from_diagonal(scale), offset)
        });
        let set = transform
            .and_then(|t| t.tex_coord)
            .unwrap_or(info.tex_coord);
        let texture = Texture {
            picture: self.picture(texture.source, factor)?,
            wrap,
            place,
        };
        Ok((texture, set))
    }

    fn picture(&mut self, index: Index<Image>, factor: DVec3) -> Result<Arc<Picture>> {
        let (path, document) = (self.path, self.document);
        self.read.get(index.value(), factor, |most| {
            // A texture without a source has this one too.
            let Some(image) = document.root.get(index) else {
                return Err("a texture has no image: export with textures in PNG or JPEG".into());
            };
            let wrong = |message: String| format!("image {index} {message}");
            let picture = match (&image.uri, image.buffer_view) {
                (Some(uri), _) => Picture::decode(&fetch(path, uri).map_err(wrong)?, most),
                (None, Some(view)) => Picture::decode(document.bytes(view).map_err(wrong)?, most),
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

fn wrap(mode: &Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
