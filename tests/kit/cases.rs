//! One list of scenes, engines and settings: what must hold of any answer is held of each of them.

use crate::answers::{slit, standing};
use crate::engines::{AnyEngine, KINDS, Kind};
use crate::{box_in_room, furnace, halved, lit_room};
use common::cover::sampled;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use gpu::Fault;

/// A scene, and what is known of its answer.
pub struct Known {
    /// Made anew for each case.
    pub scene: fn() -> Scene,
    /// Nothing escapes.
    pub closed: bool,
    /// The radiosity everywhere.
    pub furnace: Option<f32>,
}

/// Every scene.
pub const SCENES: [Known; 7] = [
    known(|| furnace(0.5), true, Some(2.0)),
    known(|| halved(&furnace(0.5)), true, Some(2.0)),
    known(box_in_room, true, None),
    known(lit_room, true, None),
    known(standing, true, None),
    known(slit, true, None),
    known(open, false, None),
];

const fn known(scene: fn() -> Scene, closed: bool, furnace: Option<f32>) -> Known {
    Known {
        scene,
        closed,
        furnace,
    }
}

/// The lit room without two of its walls.
fn open() -> Scene {
    let mut scene = lit_room();
    scene.name = "an open room".into();
    scene.faces.drain(3..5);
    scene
}

/// Cells a side and samples: the paper's way, parts of faces, and many points of each.
const FINENESS: [[u32; 2]; 3] = [[1, 1], [2, 1], [2, 4]];

/// One scene, solved in one way.
pub struct Case<'a> {
    /// The scene.
    pub known: &'a Known,
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Who solves.
    pub kind: Kind,
    /// How.
    pub settings: &'a Settings,
    /// Planted in the shaders.
    pub faults: &'a [Fault],
}

impl<'a> Case<'a> {
    /// A fresh solver.
    pub fn engine(&self) -> AnyEngine<'a> {
        self.kind.engine(self.mesh, self.settings, self.faults)
    }
}

/// What `test` has to say of every case; of those on the GPU where faults are planted in shaders.
/// There is no case that an engine cannot solve.
pub fn each_case(faults: &[Fault], test: impl Fn(&Case) -> Result<(), String>) -> Vec<String> {
    let mut said = Vec::new();
    for known in &SCENES {
        let scene = (known.scene)();
        for [cells, samples] in FINENESS {
            let mut settings = crate::engines::settings();
            settings.meshing.cells = cells;
            settings.meshing.samples = samples;
            let mesh = sampled(&scene, &settings.meshing).unwrap();
            for kind in KINDS.iter().filter(|k| k.on_gpu || faults.is_empty()) {
                let case = Case {
                    known,
                    mesh: &mesh,
                    kind: *kind,
                    settings: &settings,
                    faults,
                };
                let what = format!(
                    "{}, {cells} cells, {samples} samples, {}",
                    scene.name, kind.name
                );
                said.extend(test(&case).err().map(|fault| format!("{what}: {fault}")));
            }
        }
    }
    said
}
