//! What `relight` reads.

use super::{Arguments, MapOption};
use crate::cli::objects::Object;
use crate::cli::scene::lit;
use crate::relight::room::{Placement, read};
use crate::relight::stage::Stage;
use common::capture::Projection;
use common::constants::CONTACT;
use common::import::ImportOptions;
use common::scene::{Face, Scene};
use common::{Error, Result};
use glam::DVec3;

/// Meshes of more faces have one texel a face unless told otherwise.
const MANY_FACES: usize = 1000;
/// The room is at least this share of the extent of room and objects: CONTACT, within which fronts
/// exchange nothing, is then a thousandth of it at most.
const LEAST_ROOM: f64 = 1e3 * CONTACT as f64;

/// Texels a side of a panorama's wall that shoot as few nodes as light allows.
const FINE: u32 = 64;

/// Room and objects, put together; `to_error`: not every texel costs the same.
pub fn stage(arguments: &Arguments, to_error: bool) -> Result<Stage> {
    let common = &arguments.common;
    let usual = match to_error {
        true => FINE,
        false => common.quality().meshing().texels,
    };
    let texels_asked = common.texels.unwrap_or(usual);
    let placement = Placement {
        size: arguments.room_size,
        eye: arguments.eye,
        projection: arguments.map.map(|map| match map {
            MapOption::Latlong => Projection::LatLong,
            MapOption::Cube => Projection::Cube,
            MapOption::Angular => Projection::Angular,
        }),
    };
    let given = arguments.objects.room_reflectance;
    let import = ImportOptions {
        reflectance: given,
        ..common.import()
    };
    let captured = read(
        &arguments.room,
        &placement,
        texels_asked,
        common.texels.is_some(),
        &import,
    )?;
    let solved = captured.values.is_none();
    let mut resolutions = captured.resolutions.clone();
    let mut scenes = vec![captured.scene.clone()];
    let mut outside = Vec::new();
    for object in &arguments.objects.objects {
        let scene = object.load(&common.import())?;
        let side = match arguments.object_texels {
            Some(side) => side,
            None if scene.faces.len() > MANY_FACES => 1,
            None => texels_asked,
        };
        resolutions.extend(vec![[side; 2]; scene.faces.len()]);
        within_reach(&captured.scene, &scene, object)?;
        outside.extend(stray(&captured.scene, &scene, object));
        scenes.push(scene);
    }
    let scene = Scene::joined(&scenes);
    if solved {
        lit(&arguments.room, &scene, "")?;
    }
    let mut notes = scene.notes.clone();
    notes.extend(outside);
    notes.extend(captured.notes.iter().cloned());
    Ok(Stage {
        room: captured.scene.faces.len(),
        captured,
        scene,
        resolutions,
        reflectance: given.filter(|_| !solved),
        notes,
    })
}

/// An object so large or so far away that beside it nothing would be left of the room.
fn within_reach(room: &Scene, scene: &Scene, object: &Object) -> Result<()> {
    let (low, high) = extent(room);
    let (from, to) = extent(scene);
    let size = (high - low).max_element();
    let all = (high.max(to) - low.min(from)).max_element();
    // Not a number fails as well.
    if size >= LEAST_ROOM * all {
        return Ok(());
    }
    Err(Error::input(
        &object.file,
        "",
        format!(
            "reaches from {} to {}, too far outside a room of size {size:.3}: see --scale and --place",
            short(from),
            short(to)
        ),
    ))
}

/// An object that reaches out of the room's box: most likely its unit is another.
fn stray(room: &Scene, scene: &Scene, object: &Object) -> Option<String> {
    let (low, high) = extent(room);
    let (from, to) = extent(scene);
    let margin = (high - low).max_element() * 1e-6;
    let inside = from.cmpge(low - margin).all() && to.cmple(high + margin).all();
    (!inside).then(|| {
        format!(
            "{} reaches from {} to {}, the room only from {} to {}: see --scale and --place",
            object.file.display(),
            short(from),
            short(to),
            short(low),
            short(high)
        )
    })
}

fn extent(scene: &Scene) -> (DVec3, DVec3) {
    let corners = || scene.faces.iter().flat_map(Face::outline);
    (
        corners().copied().fold(DVec3::INFINITY, DVec3::min),
        corners().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
    )
}

fn short(p: DVec3) -> String {
    let one = |x: f64| {
        if x.abs() < 1e6 {
            format!("{x:.3}")
        } else {
            format!("{x:.3e}")
        }
    };
    p.to_array().map(one).join(",")
}
