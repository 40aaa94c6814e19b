//! Reads the room and the objects of `relight`.

use super::RelightArguments;
use crate::cli::objects::PlacedObject;
use crate::cli::options::require_light;
use common::constants::CONTACT_DISTANCE;
use common::import::ImportOptions;
use common::scene::Scene;
use common::{Error, Result};
use glam::DVec3;
use oracle::relight::captured_room::{PanoramaPlacement, read};
use oracle::relight::stage::RelightStage;

/// Objects of more faces have one texel a face by default.
const MAX_MESHED_FACES: usize = 1000;
/// Smallest share of the room in the extent of room and objects: the contact distance, within which fronts exchange
/// nothing, is then at most a thousandth of the room.
const MIN_ROOM_SHARE: f64 = 1e3 * CONTACT_DISTANCE as f64;

/// Texels per side of a panorama's wall in a solve to an error, where hierarchy nodes shoot instead of texels.
const PANORAMA_WALL_TEXELS: u32 = 64;

/// Reads room and objects and joins them; `to_error` selects the finer default texels of a solve to an error.
pub fn load_stage(arguments: &RelightArguments, to_error: bool) -> Result<RelightStage> {
    let common = &arguments.common;
    let usual = match to_error {
        true => PANORAMA_WALL_TEXELS,
        false => common.quality.unwrap_or_default().meshing().texels,
    };
    let texels_asked = common.texels.unwrap_or(usual);
    let placement = PanoramaPlacement {
        size: arguments.room_size,
        eye: arguments.eye,
        projection: arguments.map,
        turn: arguments.objects.room_turn,
    };
    let given = arguments.objects.room_reflectance;
    let import = ImportOptions {
        reflectance: given,
        ..common.import_options()
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
        let scene = object.load_scene(&common.import_options())?;
        let side = match arguments.object_texels {
            Some(side) => side,
            None if scene.faces.len() > MAX_MESHED_FACES => 1,
            None => texels_asked,
        };
        resolutions.extend(vec![[side; 2]; scene.faces.len()]);
        outside.extend(check_object_extent(&captured.scene, &scene, object)?);
        scenes.push(scene);
    }
    let scene = Scene::join_scenes(&scenes);
    if solved {
        require_light(&arguments.room, &scene)?;
    }
    let mut notes = scene.notes.clone();
    notes.extend(outside);
    notes.extend(captured.notes.iter().cloned());
    Ok(RelightStage {
        room_faces: captured.scene.faces.len(),
        captured,
        scene,
        resolutions,
        reflectance: given.filter(|_| !solved),
        notes,
    })
}

/// Returns a note on an object that reaches out of the room's box: it probably has another unit.
///
/// Errors: it is so large or so far away that the room would be lost in rounding.
fn check_object_extent(room: &Scene, scene: &Scene, object: &PlacedObject) -> Result<Option<String>> {
    let [[low, high], [from, to]] = [room, scene].map(Scene::bounds);
    let size = (high - low).max_element();
    let margin = size * 1e-6;
    if from.cmpge(low - margin).all() && to.cmple(high + margin).all() {
        return Ok(None);
    }
    let [low_text, high_text, from_text, to_text] = [low, high, from, to].map(format_point);
    let message = format!(
        "reaches from {from_text} to {to_text}, the room only from {low_text} to {high_text}: see --scale and --place"
    );
    // False for NaN, too.
    let visible = size >= MIN_ROOM_SHARE * (high.max(to) - low.min(from)).max_element();
    match visible {
        true => Ok(Some(format!("{} {message}", object.file.display()))),
        false => Err(Error::bad_input(&object.file, "", message)),
    }
}

fn format_point(p: DVec3) -> String {
    let coordinate = |x: f64| match x.abs() < 1e6 {
        true => format!("{x:.3}"),
        false => format!("{x:.3e}"),
    };
    p.to_array().map(coordinate).join(",")
}
