//! The room that objects are put into: a scene yet to be solved, a solve, a folder of wall maps or
//! a panorama; told apart by content.

use crate::judge::diff::reflected::offsets;
use common::capture::{Panorama, Projection, maps, room, texel_radiosity};
use common::file::{MAX_BYTES, open};
use common::import::{ImportOptions, load};
use common::mesh::Mesh;
use common::relight::Room;
use common::scene::Scene;
use common::solution::Stored;
use common::text::plain;
use common::{Error, Result};
use glam::{DVec3, Vec3, Vec4};
use std::io::Read;
use std::path::Path;

/// How a panorama becomes a room.
#[derive(Clone, Copy, Debug, Default)]
pub struct Placement {
    /// X, Y, Z of the room.
    pub size: Option<DVec3>,
    /// Where it was captured.
    pub eye: Option<DVec3>,
    /// How its pixels are directions, if not as the file says.
    pub projection: Option<Projection>,
}

/// A room as it was read. Values are in face order, within a face row-major in its rectangle.
pub struct Captured {
    /// Its faces.
    pub scene: Scene,
    /// Texels of each.
    pub resolutions: Vec<[u32; 2]>,
    /// What was captured; none where the room is yet to be solved.
    pub values: Option<Values>,
    /// The panorama and where it was taken.
    pub panorama: Option<(Panorama, DVec3)>,
    /// What is worth saying.
    pub notes: Vec<String>,
}

/// Captured values of every texel.
pub struct Values {
    /// B₀, W/m².
    pub radiosity: Vec<Vec3>,
    /// The part of it that was not shot yet, where that is known.
    pub residual: Option<Vec<Vec3>>,
    /// ρ, where it is known.
    pub reflectance: Option<Vec<Vec3>>,
    /// E, where it is known; what bodies bury of it was not shot either.
    pub emission: Option<Vec<Vec3>>,
}

/// Reads the room at `path`; `texels` a side where the room does not bring its own.
///
/// Errors: what the kind of file can be wrong in; texels that differ from those captured.
pub fn read(
    path: &Path,
    placement: &Placement,
    texels: u32,
    asked: bool,
    import: &ImportOptions,
) -> Result<Captured> {
    if path.is_dir() {
        refuse(placement)?;
    }
    // A file that is placed as a panorama is one, or it is wrong: the decoder says how.
    let placed = refuse(placement).is_err();
    let captured = if path.join("room.json").is_file() {
        from_maps(path)?
    } else if path.is_dir() {
        from_solve(path)?
    } else if placed || is_map(path) {
        return from_panorama(path, placement, texels);
    } else {
        let scene = load(path, import)?;
        return Ok(Captured {
            resolutions: vec![[texels; 2]; scene.faces.len()],
            scene,
            values: None,
            panorama: None,
            notes: Vec::new(),
        });
    };
    let differs = |r: &[u32; 2]| *r != [texels; 2];
    if asked && captured.resolutions.iter().any(differs) {
        return Err(Error::Usage(format!(
            "--texels {texels}: {} was captured with other texels: leave it out",
            path.display()
        )));
    }
    Ok(captured)
}

fn refuse(placement: &Placement) -> Result<()> {
    let given = [
        ("--room-size", placement.size.is_some()),
        ("--eye", placement.eye.is_some()),
        ("--map", placement.projection.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((name, _)) => Err(Error::Usage(format!(
            "{name} is for panoramas only: the room brings its own geometry"
        ))),
        None => Ok(()),
    }
}

/// Whether the file begins as a Radiance picture or an OpenEXR file. One that cannot be read is
/// reported by whoever reads it next.
fn is_map(path: &Path) -> bool {
    let mut start = [0u8; 4];
    let mut file = open(path, MAX_BYTES);
    let read = file.as_mut().map(|file| file.read_exact(&mut start));
    matches!(read, Ok(Ok(()))) && (start.starts_with(b"#?") || start == [0x76, 0x2f, 0x31, 0x01])
}

/// What a map is, `--map` says.
fn asked(error: Error) -> Error {
    match error {
        Error::Input {
            path,
            place,
            message,
        } if message.ends_with("say which it is") => Error::Input {
            path,
            place,
            message: message + " with --map",
        },
        other => other,
    }
}

/// A usage error with the option that it is about.
fn named<T>(option: &str, result: Result<T>) -> Result<T> {
    result.map_err(|error| match error {
        Error::Usage(message) => Error::Usage(format!("{option}: {message}")),
        other => other,
    })
}

fn from_panorama(path: &Path, placement: &Placement, texels: u32) -> Result<Captured> {
    let size = placement.size.ok_or_else(|| {
        Error::Usage(format!(
            "{} is a panorama: give the room's --room-size X,Y,Z",
            path.display()
        ))
    })?;
    let mut scene = named("--room-size", room::room(size))?;
    scene.name = plain(&path.display().to_string());
    let eye = named("--eye", room::eye(size, placement.eye))?;
    let panorama = Panorama::read(path, placement.projection).map_err(asked)?;
    let resolutions = vec![[texels; 2]; scene.faces.len()];
    let radiosity = texel_radiosity(&panorama, &scene, &resolutions, eye)?;
    Ok(Captured {
        scene,
        resolutions,
        values: Some(Values {
            radiosity,
            residual: None,
            reflectance: None,
            emission: None,
        }),
        notes: panorama.notes.clone(),
        panorama: Some((panorama, eye)),
    })
}

fn from_solve(path: &Path) -> Result<Captured> {
    let mut stored = Stored::read(path)?;
    let reflectance = stored
        .others
        .remove("reflectance")
        .or_else(|| of_faces(&stored.scene, &stored.resolutions));
    Ok(Captured {
        resolutions: stored.resolutions,
        values: Some(Values {
            residual: stored.others.remove("residual"),
            emission: reflectance.is_some().then_some(stored.emission),
            radiosity: stored.radiosity,
            reflectance,
        }),
        scene: stored.scene,
        panorama: None,
        notes: Vec::new(),
    })
}

fn from_maps(path: &Path) -> Result<Captured> {
    let room = maps::read(path)?;
    Ok(Captured {
        values: Some(Values {
            radiosity: room.radiosity,
            residual: None,
            reflectance: of_faces(&room.scene, &room.resolutions),
            emission: None,
        }),
        scene: room.scene,
        resolutions: room.resolutions,
        panorama: None,
        notes: Vec::new(),
    })
}

/// The faces' reflectance on all their texels; none where no face has any.
fn of_faces(scene: &Scene, resolutions: &[[u32; 2]]) -> Option<Vec<Vec3>> {
    let known = scene.faces.iter().any(|f| f.reflectance != Vec3::ZERO);
    let of = |(face, r): (&common::scene::Face, &[u32; 2])| {
        vec![face.reflectance; common::texel::count(*r) as usize]
    };
    known.then(|| scene.faces.iter().zip(resolutions).flat_map(of).collect())
}

impl Values {
    /// On the texels of `mesh`, whose first faces are the room's. The mesh's texels take what is
    /// known of ρ and E; a reflectance that is `given` counts for more.
    pub fn on(&self, mesh: &mut Mesh, given: Option<Vec3>) -> Room {
        let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
        let first = offsets(&resolutions);
        let room = mesh.room;
        let place = |texel: &common::mesh::Texel| {
            (texel.face < room).then(|| first[texel.face as usize] + texel.index as usize)
        };
        let spread = |values: &[Vec3]| -> Vec<Vec4> {
            let of = |texel| place(texel).map_or(Vec4::ZERO, |k| values[k].extend(0.0));
            mesh.texels.iter().map(of).collect()
        };
        let radiosity = spread(&self.radiosity);
        let residual = match &self.residual {
            Some(residual) => spread(residual),
            None => vec![Vec4::ZERO; mesh.texels.len()],
        };
        for texel in &mut mesh.texels {
            let Some(k) =
                (texel.face < room).then(|| first[texel.face as usize] + texel.index as usize)
            else {
                continue;
            };
            texel.reflectance = given
                .or_else(|| self.reflectance.as_ref().map(|r| r[k]))
                .unwrap_or(Vec3::ZERO);
            texel.emission = self.emission.as_ref().map_or(Vec3::ZERO, |e| e[k]);
        }
        let known = given.is_some() || self.reflectance.is_some();
        Room {
            radiosity,
            residual,
            reflectance: known.then(|| mesh.texels.iter().map(|t| t.reflectance).collect()),
        }
    }
}
