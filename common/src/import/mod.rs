//! Scene files: OBJ with MTL, glTF and GLB → [`Scene`].
//!
//! Input face k is entry k of the scene's faces. Where a face has to be split, its first piece is
//! entry k and the others follow after the last input face; all of them say `from: k`.

mod builder;
mod gltf;
mod input;
mod material;
mod obj;
mod pictures;
mod polygon;
mod surface;

pub use crate::paint::from_srgb;

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::bounds;
use crate::scene::Scene;
use builder::Builder;
use glam::Vec3;
use std::path::Path;

/// What to make of a file beyond what it says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// Two consecutive triangles of a glTF primitive that form a planar convex quad become one
    /// face. (An OBJ has quads of its own.)
    pub join_quads: bool,
    /// Every face gets a front on its other side.
    pub two_sided: bool,
    /// ρ of all faces instead of the file's, 0 ≤ ρ < 1.
    pub reflectance: Option<Vec3>,
    /// Every face keeps its place on the file's own lightmap, which a file without is an error. Quads are
    /// not joined then.
    pub charts: bool,
}

/// Reads a scene; the type of file is told by content, and by extension where content leaves it
/// open.
pub fn load(path: &Path, options: &ImportOptions) -> Result<Scene> {
    let bytes = file::input(path, "")?;
    let mut builder = Builder::new(path, options.reflectance);
    match Format::of(path, &bytes)? {
        Format::Obj if options.charts => return Err(Error::input(path, "", NO_CHARTS)),
        Format::Obj => obj::read(&mut builder, path, &bytes)?,
        Format::Gltf => gltf::read(&mut builder, path, &bytes, options)?,
    }
    let scene = builder.finish()?;
    bounds(&scene)?;
    Ok(if options.two_sided {
        scene.two_sided()
    } else {
        scene
    })
}

enum Format {
    Obj,
    Gltf,
}

impl Format {
    fn of(path: &Path, bytes: &[u8]) -> Result<Self> {
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_lowercase())
            .unwrap_or_default();
        let first = bytes
            .strip_prefix(BOM)
            .unwrap_or(bytes)
            .iter()
            .find(|b| !b.is_ascii_whitespace());
        match (first, extension.as_str()) {
            (None, _) => Err(Error::input(path, "", "is empty")),
            (Some(b'{'), _) => Ok(Self::Gltf),
            _ if bytes.starts_with(b"glTF") => Ok(Self::Gltf),
            (_, "obj") => Ok(Self::Obj),
            (_, "gltf" | "glb") => Err(Error::input(
                path,
                "",
                "does not begin as glTF does (`{` or the letters glTF): is it damaged, or another type of file?",
            )),
            _ => Err(Error::input(
                path,
                "",
                "is of no known type: give an .obj, a .gltf or a .glb",
            )),
        }
    }
}

const NO_CHARTS: &str =
    "an OBJ has one set of texture coordinates, and a lightmap wants a second one: export as glTF";

/// The byte order mark that some editors put before UTF-8.
const BOM: &[u8] = b"\xEF\xBB\xBF";
