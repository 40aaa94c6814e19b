//! What must hold of every reader of files and settings, whatever its input: it does not panic, an error is one line, and
//! what it accepts keeps the limits that it promises.
//!
//! A check takes any bytes, and panics if its reader breaks a promise. [`CHECKS`] lists them all: `fuzz/fuzz_targets` hands
//! each to libFuzzer, and the test `corpus` repeats the inputs that are kept in `fuzz/corpus`.

pub mod baked_scenes;
pub mod folder;
pub mod numbers;
pub mod photographs;
pub mod radiance_maps;
pub mod requirements;
pub mod results;
pub mod scene_files;
pub mod settings;
pub mod shaders;
pub mod study_files;

use std::panic::take_hook;
use std::sync::Once;

/// A check: it panics if a reader of these bytes breaks a promise.
pub type Check = fn(&[u8]);

/// Name of each check, which is that of its fuzz target and of its folder of inputs, and the check.
pub const CHECKS: [(&str, Check); 21] = [
    ("baked_scene", baked_scenes::check_baked_scene),
    ("command_line", settings::check_command_line),
    ("draco", scene_files::check_draco),
    ("glb", scene_files::check_glb),
    ("gltf", scene_files::check_gltf),
    ("hdr", radiance_maps::check_hdr),
    ("lamp", settings::check_lamp),
    ("lightmap", results::check_lightmap),
    ("merge", photographs::check_merge),
    ("mtl", scene_files::check_mtl),
    ("obj", scene_files::check_obj),
    ("openexr", radiance_maps::check_openexr),
    ("outdated_files", results::check_outdated_files),
    ("photograph", photographs::check_photograph),
    ("polygon", scene_files::check_polygon),
    ("result", results::check_result),
    ("room", results::check_room),
    ("settings", settings::check_settings),
    ("shader", shaders::check_shader),
    ("study_files", study_files::check_study_files),
    ("texture", photographs::check_texture),
];

/// Lets a reader catch the panics of a decoder. libFuzzer's own hook would end the program at each of them; a panic that
/// nobody catches still ends it.
pub fn allow_caught_panics() {
    static HOOK_REMOVAL: Once = Once::new();
    HOOK_REMOVAL.call_once(|| drop(take_hook()));
}
