//! Reads scene files (OBJ with MTL, glTF, GLB) into a [`Scene`].
//!
//! Input face k is entry k of the scene's faces. The first piece of a split face is entry k, and its
//! other pieces follow after the last input face; all pieces have `from: k`.

mod builder;
mod gltf;
mod lamp;
mod material;
mod obj;
mod picture_cache;
mod polygon;
mod scene_file;
mod surface;
mod uri;

pub use crate::paint::from_srgb;
pub use gltf::DOUBLE_SIDED;
pub use lamp::add_lamp;
pub(crate) use polygon::is_convex_quad;
pub use scene_file::{ARRAY_BUFFER, FileTriangle, PlacedPrimitive, SceneFile, image_type};
pub(crate) use surface::is_solvable_emission;

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::scene_bounds;
use crate::scene::Scene;
use builder::Builder;
use glam::Vec3;
use std::path::Path;

/// Options of the import.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// Joins two consecutive triangles of a glTF primitive into one face if they form a planar convex
    /// quad. (An OBJ has quads of its own.)
    pub join_quads: bool,
    /// Adds to every face a second one with the opposite front.
    pub two_sided: bool,
    /// Reflectance of all faces in place of the file's, 0 ≤ ρ < 1.
    pub reflectance: Option<Vec3>,
    /// Keeps the lightmap coordinates of every face; a file without them is an error. Disables `join_quads`.
    pub charts: bool,
}

/// Reads a scene file. The content decides the format, and the file extension if the content is ambiguous.
///
/// Errors: the file cannot be read, is of no known format, or is invalid.
pub fn load_scene(path: &Path, options: &ImportOptions) -> Result<Scene> {
    load_with(Builder::new(path, options.reflectance), path, options).map(|(scene, _)| scene)
}

/// Reads a scene file, and keeps it as a glTF document.
///
/// Errors: those of [`load_scene`].
pub fn load_scene_file(path: &Path, options: &ImportOptions) -> Result<(Scene, SceneFile)> {
    let mut builder = Builder::new(path, options.reflectance);
    builder.file = Some(SceneFile {
        path: path.to_owned(),
        ..SceneFile::default()
    });
    let (scene, file) = load_with(builder, path, options)?;
    Ok((scene, file.unwrap_or_default()))
}

fn load_with(mut builder: Builder, path: &Path, options: &ImportOptions) -> Result<(Scene, Option<SceneFile>)> {
    let bytes = file::read_input(path, "")?;
    if is_gltf(path, &bytes)? {
        gltf::read(&mut builder, path, &bytes, options)?;
    } else if options.charts {
        let message = "an OBJ has one set of texture coordinates, and a lightmap wants a second one: export as glTF";
        return Err(Error::bad_input(path, "", message));
    } else {
        obj::read(&mut builder, path, &bytes)?;
    }
    let file = builder.file.take();
    let scene = builder.into_scene()?;
    scene_bounds(&scene)?;
    let scene = if options.two_sided { scene.two_sided() } else { scene };
    Ok((scene, file))
}

/// Returns whether a file is a glTF, and not an OBJ.
///
/// Errors: it is neither.
fn is_gltf(path: &Path, bytes: &[u8]) -> Result<bool> {
    let fail = |message| Err(Error::bad_input(path, "", message));
    let extension = path.extension().unwrap_or_default();
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let first = text.iter().find(|b| !b.is_ascii_whitespace());
    match (first, &*extension.to_string_lossy().to_lowercase()) {
        (None, _) => fail("is empty"),
        (Some(b'{'), _) => Ok(true),
        _ if bytes.starts_with(b"glTF") => Ok(true),
        (_, "obj") => Ok(false),
        (_, "gltf" | "glb") => {
            fail("does not begin as glTF does (`{` or the letters glTF): is it damaged, or another type of file?")
        }
        _ => fail("is of no known type: give an .obj, a .gltf or a .glb"),
    }
}

/// Byte order mark of UTF-8, which some editors write.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
