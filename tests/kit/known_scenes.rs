//! Scenes with known properties, and the loop over scenes, engines and settings that tests of invariants use.

use crate::engines::{AnyEngine, ENGINE_KINDS, EngineKind};
use crate::solutions::{room_with_standing_box, slit_room};
use crate::{box_in_room, furnace, halve_quads, lit_room};
use common::cover::sampled_mesh;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use gpu::ShaderFault;

/// A scene and the known properties of its solution.
pub struct KnownScene {
    /// Makes the scene.
    pub scene: fn() -> Scene,
    /// True if no power escapes.
    pub closed: bool,
    /// The uniform radiosity of a furnace.
    pub furnace: Option<f32>,
}

/// All scenes.
pub const KNOWN_SCENES: [KnownScene; 7] = [
    known_scene(|| furnace(0.5), true, Some(2.0)),
    known_scene(|| halve_quads(&furnace(0.5)), true, Some(2.0)),
    known_scene(box_in_room, true, None),
    known_scene(lit_room, true, None),
    known_scene(room_with_standing_box, true, None),
    known_scene(slit_room, true, None),
    known_scene(open_room, false, None),
];

const fn known_scene(scene: fn() -> Scene, closed: bool, furnace: Option<f32>) -> KnownScene {
    KnownScene { scene, closed, furnace }
}

/// Makes the lit room without two of its walls.
fn open_room() -> Scene {
    let mut scene = lit_room();
    scene.name = "an open room".into();
    scene.faces.drain(3..5);
    scene
}

/// Patches per side and samples: whole faces like the paper, parts of faces, and many points of each.
const PATCHES_AND_SAMPLES: [[u32; 2]; 3] = [[1, 1], [2, 1], [2, 4]];

/// A scene with engine and settings.
pub struct Case<'a> {
    /// The scene.
    pub known: &'a KnownScene,
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Engine.
    pub kind: EngineKind,
    /// Settings.
    pub settings: &'a Settings,
    /// Faults planted in the shaders.
    pub faults: &'a [ShaderFault],
}

impl<'a> Case<'a> {
    /// Makes an engine.
    pub fn fresh_engine(&self) -> AnyEngine<'a> {
        self.kind.fresh_engine(self.mesh, self.settings, self.faults)
    }
}

/// Runs `test` on every case, or on those of the GPU if faults are planted, and returns the messages of failed ones.
pub fn each_case(faults: &[ShaderFault], test: impl Fn(&Case) -> Result<(), String>) -> Vec<String> {
    let mut said = Vec::new();
    for known in &KNOWN_SCENES {
        let scene = (known.scene)();
        for [patches, samples] in PATCHES_AND_SAMPLES {
            let mut settings = crate::engines::engine_settings();
            settings.meshing.patches = patches;
            settings.meshing.samples = samples;
            let mesh = sampled_mesh(&scene, &settings.meshing).unwrap();
            for kind in ENGINE_KINDS.iter().filter(|k| k.on_gpu || faults.is_empty()) {
                let case = Case {
                    known,
                    mesh: &mesh,
                    kind: *kind,
                    settings: &settings,
                    faults,
                };
                let what = format!("{}, {patches} patches, {samples} samples, {}", scene.name, kind.name);
                said.extend(test(&case).err().map(|fault| format!("{what}: {fault}")));
            }
        }
    }
    said
}
