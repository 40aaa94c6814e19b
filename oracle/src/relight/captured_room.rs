//! Reads the room for a relight: a scene still to be solved, a solve, a folder of wall maps or a panorama. The kind
//! follows from whether the path is a folder, and one with `room.json`, then from the file's first bytes.

use common::capture::{MapProjection, Panorama, maps, room, texel_radiosity};
use common::file::{MAX_FILE_BYTES, open_file};
use common::import::{ImportOptions, load_scene};
use common::mesh::Mesh;
use common::relight::RoomRadiosity;
use common::scene::Scene;
use common::solution::StoredSolution;
use common::solution::pending::locate_file;
use common::texel::first_texels;
use common::text::escape_control;
use common::{Error, Result};
use glam::{DVec3, Vec3, Vec4};
use std::io::Read;
use std::path::Path;

/// Placement of a panorama in a box room.
#[derive(Clone, Copy, Debug, Default)]
pub struct PanoramaPlacement {
    /// Size X, Y, Z of the room.
    pub size: Option<DVec3>,
    /// Capture point.
    pub eye: Option<DVec3>,
    /// Projection that overrides the file's.
    pub projection: Option<MapProjection>,
    /// Turn of the map about the vertical axis, degrees counter-clockwise as seen from above.
    pub turn: Option<f64>,
}

/// A room read from a file or folder. Values are in face order, within a face row-major in its rectangle.
pub struct InputRoom {
    /// The room's faces.
    pub scene: Scene,
    /// Texels W×H of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// Captured values; `None` if the room is still to be solved.
    pub values: Option<CapturedValues>,
    /// The panorama and its capture point.
    pub panorama: Option<(Panorama, DVec3)>,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

impl InputRoom {
    /// Makes a room without panorama and remarks.
    pub fn new(scene: Scene, resolutions: Vec<[u32; 2]>, values: Option<CapturedValues>) -> Self {
        Self {
            scene,
            resolutions,
            values,
            panorama: None,
            notes: Vec::new(),
        }
    }
}

/// Captured values of every texel.
#[derive(Default)]
pub struct CapturedValues {
    /// B₀, W/m².
    pub radiosity: Vec<Vec3>,
    /// The unshot part of it, where known.
    pub residual: Option<Vec<Vec3>>,
    /// ρ, where known.
    pub reflectance: Option<Vec<Vec3>>,
    /// E, where known; that of parts covered by bodies was never shot.
    pub emission: Option<Vec<Vec3>>,
}

/// Reads the room at `path`, with `texels` per side of each face if the room has none of its own.
///
/// Errors: those of the kind of file; `texels_requested` with other texels than the captured ones.
pub fn read(
    path: &Path,
    placement: &PanoramaPlacement,
    texels: u32,
    texels_requested: bool,
    import: &ImportOptions,
) -> Result<InputRoom> {
    if path.is_dir() {
        refuse_placement(placement)?;
    }
    // With a size the file must be a panorama; the decoder reports the error if it is not.
    let placed = placement.size.is_some();
    let captured = if locate_file(path, "room.json").is_file() {
        from_maps(path)?
    } else if path.is_dir() {
        from_solve(path)?
    } else if placed || is_panorama(path) {
        return from_panorama(path, placement, texels);
    } else {
        refuse_placement(placement)?;
        let scene = load_scene(path, import)?;
        let resolutions = vec![[texels; 2]; scene.faces.len()];
        return Ok(InputRoom::new(scene, resolutions, None));
    };
    let differs = |r: &[u32; 2]| *r != [texels; 2];
    if texels_requested && captured.resolutions.iter().any(differs) {
        return Err(Error::Usage(format!(
            "--texels {texels}: {} was captured with other texels: leave it out",
            path.display()
        )));
    }
    Ok(captured)
}

fn refuse_placement(placement: &PanoramaPlacement) -> Result<()> {
    let given = [
        ("--room-size", placement.size.is_some()),
        ("--eye", placement.eye.is_some()),
        ("--map", placement.projection.is_some()),
        ("--turn before the first --object", placement.turn.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((name, _)) => Err(Error::Usage(format!(
            "{name} is for panoramas only: the room brings its own geometry"
        ))),
        None => Ok(()),
    }
}

/// Tests if the file begins like a Radiance picture or an OpenEXR file. An unreadable file counts as no panorama;
/// the scene's reader reports the error.
fn is_panorama(path: &Path) -> bool {
    let mut start = [0u8; 4];
    let mut file = open_file(path, MAX_FILE_BYTES);
    let read = file.as_mut().map(|file| file.read_exact(&mut start));
    matches!(read, Ok(Ok(()))) && (start.starts_with(b"#?") || start == [0x76, 0x2f, 0x31, 0x01])
}

/// Adds `--map` to an error about an unknown projection.
fn suggest_map_option(error: Error) -> Error {
    match error {
        Error::Input { path, place, message } if message.ends_with("say which it is") => Error::Input {
            path,
            place,
            message: message + " with --map",
        },
        other => other,
    }
}

/// Puts the option's name before a usage error.
fn name_option<T>(option: &str, result: Result<T>) -> Result<T> {
    result.map_err(|error| match error {
        Error::Usage(message) => Error::Usage(format!("{option}: {message}")),
        other => other,
    })
}

fn from_panorama(path: &Path, placement: &PanoramaPlacement, texels: u32) -> Result<InputRoom> {
    let size = placement.size.ok_or_else(|| {
        Error::Usage(format!(
            "{} is a panorama: give the room's --room-size X,Y,Z",
            path.display()
        ))
    })?;
    let mut scene = name_option("--room-size", room::box_room(size))?;
    scene.name = escape_control(&path.display().to_string());
    let eye = name_option("--eye", room::capture_point(size, placement.eye))?;
    let panorama = Panorama::read(path, placement.projection).map_err(suggest_map_option)?;
    let panorama = panorama.turn_by(placement.turn.unwrap_or(0.0));
    let resolutions = vec![[texels; 2]; scene.faces.len()];
    let values = CapturedValues {
        radiosity: texel_radiosity(&panorama, &scene, &resolutions, eye)?,
        ..CapturedValues::default()
    };
    Ok(InputRoom {
        notes: panorama.notes.clone(),
        panorama: Some((panorama, eye)),
        ..InputRoom::new(scene, resolutions, Some(values))
    })
}

fn from_solve(path: &Path) -> Result<InputRoom> {
    let mut stored = StoredSolution::read(path)?;
    let reflectance = stored
        .others
        .remove("reflectance")
        .or_else(|| reflectance_of_faces(&stored.scene, &stored.resolutions));
    let values = CapturedValues {
        residual: stored.others.remove("residual"),
        emission: reflectance.is_some().then_some(stored.emission),
        radiosity: stored.radiosity,
        reflectance,
    };
    let mut room = InputRoom::new(stored.scene, stored.resolutions, Some(values));
    if stored.others.contains_key("sky") {
        room.notes
            .push("the room's light from outside is kept: objects neither receive nor block it".into());
    }
    Ok(room)
}

fn from_maps(path: &Path) -> Result<InputRoom> {
    let room = maps::read(path)?;
    let values = CapturedValues {
        radiosity: room.radiosity,
        reflectance: reflectance_of_faces(&room.scene, &room.resolutions),
        ..CapturedValues::default()
    };
    Ok(InputRoom::new(room.scene, room.resolutions, Some(values)))
}

/// Returns the faces' reflectance for all their texels; `None` if no face has any.
fn reflectance_of_faces(scene: &Scene, resolutions: &[[u32; 2]]) -> Option<Vec<Vec3>> {
    let known = scene.faces.iter().any(|f| f.reflectance != Vec3::ZERO);
    let of =
        |(face, r): (&common::scene::Face, &[u32; 2])| vec![face.reflectance; common::texel::texel_count(*r) as usize];
    known.then(|| scene.faces.iter().zip(resolutions).flat_map(of).collect())
}

impl CapturedValues {
    /// Assigns the values to the texels of `mesh`, whose first faces are the room's. Known ρ and E are copied to the
    /// mesh's texels, unknown ones become 0; a `given` reflectance takes precedence.
    pub fn apply_to_mesh(&self, mesh: &mut Mesh, given: Option<Vec3>) -> RoomRadiosity {
        let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
        let first = first_texels(&resolutions);
        let room = mesh.room_faces;
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
            let Some(k) = place(texel) else {
                continue;
            };
            texel.reflectance = given
                .or_else(|| self.reflectance.as_ref().map(|r| r[k]))
                .unwrap_or(Vec3::ZERO);
            texel.emission = self.emission.as_ref().map_or(Vec3::ZERO, |e| e[k]);
        }
        let known = given.is_some() || self.reflectance.is_some();
        RoomRadiosity {
            radiosity,
            residual,
            reflectance: known.then(|| mesh.texels.iter().map(|t| t.reflectance).collect()),
        }
    }
}
