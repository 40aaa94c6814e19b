//! The program's own glTF, which it writes of a scene file with its light.

use crate::allow_caught_panics;
use crate::folder::Folder;
use crate::requirements::{require_one_line, require_sound_scene};
use crate::scene_files::{PICTURE, split_at_zero};
use common::import::{ImportOptions, load_scene, load_scene_file};
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::shooting::initial_field;
use glam::DVec3;
use radiosity::report::gltf_export::{ExportCharts, export_lightmap};
use radiosity::report::picture::Exposure;

/// Largest number of faces of a scene that is written again.
const MAX_BAKED_FACES: usize = 32;
/// Pixels of the lightmap per unit of length: as few as can be.
const TEXELS_PER_UNIT: f64 = 1e-3;

thread_local! {
    static FOLDER: Folder = Folder::new(&[("p.png", PICTURE)]);
}

/// Checks that what is read of a glTF can be written with its light, and read again with the same faces. The input is that of
/// [`crate::scene_files::check_gltf`].
pub fn check_baked_scene(data: &[u8]) {
    allow_caught_panics();
    FOLDER.with(|folder| {
        let (json, buffer) = split_at_zero(data);
        folder.write("a.gltf", json);
        folder.write("b.bin", buffer);
        let options = ImportOptions {
            two_sided: data.len().is_multiple_of(2),
            ..ImportOptions::default()
        };
        let Ok((scene, file)) = load_scene_file(&folder.path("a.gltf"), &options) else {
            return;
        };
        // The program refuses to write these.
        let is_compressed = json.windows(5).any(|word| word == b"draco");
        if scene.faces.len() > MAX_BAKED_FACES || is_compressed {
            return;
        }
        let mesh = Mesh::uniform(&scene, 1, 1).expect("a mesh of a scene that was accepted");
        let field = initial_field(&mesh, "emission");
        let charts = ExportCharts::Packed(Some(TEXELS_PER_UNIT));
        match export_lightmap((&scene, file), charts, (&mesh, &field), Exposure::with_white(1.0)) {
            Ok(baked) => {
                folder.write("baked.glb", &baked.glb);
                let again = load_scene(&folder.path("baked.glb"), &ImportOptions::default());
                let again = again.unwrap_or_else(|error| panic!("what was written cannot be read: {error}"));
                require_sound_scene(&again);
                require_same_surface(&scene, &again);
            }
            Err(error) => require_one_line(&error),
        }
    });
}

/// Requires that two scenes have the same area and the same vector area.
fn require_same_surface(scene: &Scene, again: &Scene) {
    let measure = |scene: &Scene| -> (f64, DVec3) {
        let faces = scene.faces.iter();
        (faces.clone().map(Face::area).sum(), faces.map(Face::vector_area).sum())
    };
    let [(area, vector_area), (area_again, vector_area_again)] = [measure(scene), measure(again)];
    let tolerance = 1e-5 * area.max(f64::MIN_POSITIVE);
    let same = (area - area_again).abs() <= tolerance && (vector_area - vector_area_again).length() <= tolerance;
    assert!(
        same,
        "{area_again}, {vector_area_again} instead of {area}, {vector_area}"
    );
}
