//! `compare` finds races within a workgroup, of which an adapter that runs lanes in order shows nothing.

use common::scene::Scene;
use common::settings::{Settings, Visibility};
use gpu::ShaderFault;
use oracle::compare::comparison::StageCheck;
use radiosity_tests::engines::settings_of;
use radiosity_tests::lit_room;
use radiosity_tests::shader_faults::compare_with_faults;

/// Shaders of shots with workgroup memory.
const SUMMING_SHADERS: [&str; 4] = ["patch_transfer", "closure", "unshot_power", "select"];

/// Few patches by rays.
fn scene_and_settings() -> (Scene, Settings) {
    (lit_room(), settings_of([4, 2, 1], Visibility::Rays, 1e-2))
}

/// Returns the checks of races of a comparison with these faults.
fn race_checks(faults: &[ShaderFault]) -> Vec<StageCheck> {
    let (scene, settings) = scene_and_settings();
    let stages = compare_with_faults(&scene, settings, faults).unwrap().stages;
    stages
        .into_iter()
        .filter(|stage| stage.name.ends_with(", races"))
        .collect()
}

#[test]
fn shaders_with_workgroup_memory_are_watched_and_none_races() {
    let found = race_checks(&[]);
    let names: Vec<&str> = found.iter().map(|stage| stage.name.as_str()).collect();
    let expected = SUMMING_SHADERS.map(|file| format!("{file}, races"));
    assert_eq!(names, expected);
    assert!(
        found.iter().all(|stage| stage.agree && stage.values > 1000),
        "{found:?}"
    );
}

/// Removes the barrier, and then lets a lane too many add: both fail the shader's own check of races.
#[test]
fn removed_barrier_and_wrong_lane_condition_are_races() {
    for file in SUMMING_SHADERS {
        for (from, to) in [
            ("workgroupBarrier();", ""),
            ("if lane < stride {", "if lane <= stride {"),
        ] {
            let found = race_checks(&[ShaderFault { file, from, to }]);
            let failing: Vec<&StageCheck> = found.iter().filter(|stage| !stage.agree).collect();
            let [only] = failing[..] else {
                panic!("{file}: {failing:?}");
            };
            println!("{}: {}", only.name, only.difference.as_ref().unwrap());
            assert_eq!(only.name, format!("{file}, races"));
        }
    }
}
