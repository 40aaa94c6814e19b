//! What `relight` reads.

use super::{Arguments, MapOption};
use crate::cli::objects::joined;
use crate::relight::room::{Placement, read};
use crate::relight::work::Stage;
use common::Result;
use common::capture::Projection;

/// Meshes of more faces have one texel a face unless told otherwise.
const MANY_FACES: usize = 1000;
/// Room and objects, put together.
pub fn stage(arguments: &Arguments) -> Result<Stage> {
    let common = &arguments.common;
    let (texels, ..) = common.quality().settings();
    let texels_asked = common.texels.unwrap_or(texels);
    let placement = Placement {
        size: arguments.room_size,
        eye: arguments.eye,
        projection: arguments.map.map(|map| match map {
            MapOption::Latlong => Projection::LatLong,
            MapOption::Cube => Projection::Cube,
            MapOption::Angular => Projection::Angular,
        }),
    };
    let mut captured = read(
        &arguments.room,
        &placement,
        texels_asked,
        common.texels.is_some(),
        &common.import(),
    )?;
    let given = arguments.objects.room_reflectance;
    let solved = captured.values.is_none();
    if let (true, Some(given)) = (solved, given) {
        for face in &mut captured.scene.faces {
            face.reflectance = given;
        }
    }
    let mut resolutions = captured.resolutions.clone();
    let mut scenes = vec![captured.scene.clone()];
    for object in &arguments.objects.objects {
        let scene = object.load(&common.import())?;
        let side = match arguments.object_texels {
            Some(side) => side,
            None if scene.faces.len() > MANY_FACES => 1,
            None => texels_asked,
        };
        resolutions.extend(vec![[side; 2]; scene.faces.len()]);
        scenes.push(scene);
    }
    let scene = joined(&scenes.iter().collect::<Vec<_>>())?;
    let mut notes = scene.notes.clone();
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
