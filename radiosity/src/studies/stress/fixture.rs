//! Invented studies for tests of the page.

use super::cases::shapes::{box_faces, lamp_above, plate_at, scene_of};
use super::cases::{CASES, Case};
use super::methods::{DEFAULT, DENSE};
use super::{AtlasRow, CaseStudy, Plate, SolverSide, Specimen};
use common::scene::Scene;
use common::settings::{Meshing, Settings};
use glam::DVec3;
use oracle::solve::progress::without_progress;
use oracle::solve::solved::Solved;
use oracle::solve::solver::SolverChoice;
use oracle::solve::{SolveRequest, solve_request};

/// A case of two methods.
pub const TEST_CASE: Case = Case {
    name: "one",
    parameter: "gap, m",
    methods: &[DEFAULT, DENSE],
    ..CASES[0]
};

/// Makes one solver's result; without an error it is a refusal. An empty code means no warning.
pub fn make_side(error: Option<f64>, code: &str) -> SolverSide {
    SolverSide {
        error,
        warnings: (!code.is_empty()).then(|| code.into()).into_iter().collect(),
        message: error.is_none().then(|| "it does not fit".into()),
        seconds: 0.25,
        ..SolverSide::default()
    }
}

/// Makes a row of the default method.
pub fn make_row(value: f64, cpu: SolverSide, gpu: Option<SolverSide>) -> AtlasRow {
    AtlasRow::new(&TEST_CASE, value, DEFAULT.name, cpu, gpu)
}

/// Makes a study with these rows and no specimen.
pub fn make_study(rows: Vec<AtlasRow>) -> CaseStudy {
    CaseStudy {
        case: TEST_CASE,
        rows,
        specimens: Vec::new(),
    }
}

/// Makes a closed room with a lamp below its ceiling and a shelf.
pub fn closed_room() -> Scene {
    let mut faces = box_faces([0.0; 3], [4.0, 4.0, 3.0], true, 0.7);
    faces.push(lamp_above([2.0, 2.0, 2.9], [1.0; 2], 40.0));
    let shelf = plate_at([1.3, 2.0, 1.2], [1.5, 2.0], 0.7);
    faces.extend([shelf.reversed(), shelf]);
    scene_of(faces)
}

/// Solves the scene and makes plates of one face: the truth and increasingly wrong answers.
pub fn make_specimen(scene: Scene, face: u32) -> Specimen {
    let texels = 12;
    let settings = Settings {
        meshing: Meshing {
            texels,
            patches: 2,
            samples: 1,
        },
        ..Settings::default()
    };
    let question = SolveRequest {
        task: &scene,
        settings: &settings,
        solver: SolverChoice::Cpu,
    };
    let Solved { mesh, run, .. } = solve_request(&question, &without_progress()).unwrap().solved;
    let own = mesh.texels_in_face_order().into_iter();
    let own = own.filter(|k| mesh.texels[*k].face == face);
    let reflected = |k: usize| run.field.radiosity[k].truncate() - mesh.texels[k].emission;
    let truth: Vec<DVec3> = own.map(|k| reflected(k).as_dvec3()).collect();
    let plate = |(label, size): (&str, f64)| Plate {
        label: label.into(),
        values: (0..truth.len())
            .map(|k| truth[k] * (1.0 + size * (k as f64 * 1.7).sin()))
            .collect(),
    };
    Specimen {
        value: 1e-3,
        description: None,
        plates: [("truth", 0.0), ("default", 0.05), ("dense", 0.6)].map(plate).into(),
        mesh,
        field: run.field,
        face,
        texels,
        scene,
    }
}
