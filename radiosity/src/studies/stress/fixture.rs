//! Invented studies for tests of the page.

use super::cases::shapes::{box_faces, lamp_above, plate_at, scene_of};
use super::{AtlasRow, CaseInfo, CaseStudy, LEAK_MEASURE, Plate, RELATIVE_RMS, SolverSide, Specimen, Verdict};
use common::scene::{Face, Scene};
use common::settings::{Meshing, Settings};
use glam::{DVec3, Vec3};
use oracle::solve::progress::without_progress;
use oracle::solve::solved::Solved;
use oracle::solve::solver::SolverChoice;
use oracle::solve::{SolveRequest, solve_request};

const TEST_METHODS: [&str; 2] = ["default", "matrix"];

/// Makes one solver's result; without an error it is a refusal. An empty code means no warning.
pub fn make_side(error: Option<f64>, code: &str) -> SolverSide {
    SolverSide {
        error,
        noise: 0.0,
        bias: None,
        estimate: None,
        verdict: Verdict::of_error(RELATIVE_RMS, error),
        warnings: (!code.is_empty()).then(|| code.into()).into_iter().collect(),
        notes: Vec::new(),
        message: error.is_none().then(|| "it does not fit".into()),
        seconds: 0.25,
    }
}

/// Makes a row of the default method.
pub fn make_row(value: f64, cpu: SolverSide, gpu: Option<SolverSide>) -> AtlasRow {
    let worse = |a: &SolverSide, b: &SolverSide| a.error.is_none() || a.error > b.error;
    let worst = match &gpu {
        Some(gpu) if worse(gpu, &cpu) => gpu.clone(),
        _ => cpu.clone(),
    };
    AtlasRow {
        case: "one",
        parameter: "gap, m",
        value,
        method: "default",
        error: worst.error,
        warned: worst.is_warned(),
        verdict: worst.verdict,
        cpu,
        gpu,
    }
}

/// Makes a study with these rows and no specimen.
pub fn make_study(name: &'static str, rows: Vec<AtlasRow>) -> CaseStudy {
    CaseStudy {
        info: CaseInfo {
            name,
            parameter: "gap, m",
            breaks: "the point-to-polygon form factor where a texel nearly touches its shooter",
            truth: "closed form: two parallel squares",
            measure: RELATIVE_RMS,
        },
        rows,
        specimen: None,
    }
}

/// Makes a closed room with a lamp below its ceiling and a shelf.
pub fn closed_room() -> Scene {
    let mut faces = box_faces([0.0; 3], [4.0, 4.0, 3.0], true, 0.7);
    faces.push(lamp_above([2.0, 2.0, 2.9], [1.0; 2], 40.0));
    let shelf = plate_at([1.3, 2.0, 1.2], [1.5, 2.0], 0.7);
    faces.extend([shelf.reversed(), shelf]);
    scene_of("room", faces)
}

/// Makes two triangles that face each other, one of them a lamp.
pub fn triangle_pair() -> Scene {
    let at = |y: f64| [[0.0, y, 0.0], [0.4, y, 2.0], [2.0, y, 0.3]].map(DVec3::from);
    let [a, b, c] = at(1.5);
    scene_of(
        "triangles",
        vec![
            Face::triangle("ground", at(0.0), Vec3::ZERO, Vec3::splat(0.7)),
            Face::triangle("light", [c, b, a], Vec3::splat(9.0), Vec3::splat(0.2)),
        ],
    )
}

/// Solves the scene and makes plates of one face: the truth and increasingly wrong answers.
pub fn make_specimen(scene: Scene, face: u32) -> Specimen {
    let settings = Settings {
        meshing: Meshing {
            texels: 12,
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
    let field = run.field;
    let own = mesh.texels_in_face_order().into_iter();
    let own = own.filter(|k| mesh.texels[*k].face == face);
    let reflected = |k: usize| field.radiosity[k].truncate() - mesh.texels[k].emission;
    let truth: Vec<DVec3> = own.map(|k| reflected(k).as_dvec3()).collect();
    let resolution = mesh.faces[face as usize].resolution;
    let plate = |label: &str, values: Vec<DVec3>| Plate {
        label: label.into(),
        resolution,
        values,
    };
    let noisy = |size: f64| -> Vec<DVec3> {
        let off = |k: usize| 1.0 + size * (k as f64 * 1.7).sin();
        truth.iter().enumerate().map(|(k, v)| v * off(k)).collect()
    };
    let answers = TEST_METHODS.iter().zip([0.05, 0.6]);
    let answers = answers.map(|(method, size)| plate(method, noisy(size)));
    let plates = std::iter::once(plate("truth", truth.clone()));
    Specimen {
        value: 1e-3,
        plates: plates.chain(answers).collect(),
        mesh,
        field,
        face,
        scene,
    }
}

/// Makes three studies of two methods and three values: with a specimen, of a leak, of triangles.
pub fn make_studies() -> Vec<CaseStudy> {
    let rows = || -> Vec<AtlasRow> {
        let values = [(1.0, 0.001, ""), (0.1, 0.03, "closure"), (0.01, 0.5, "")];
        let of = |(value, error, code): (f64, f64, &str)| {
            TEST_METHODS.map(|method| AtlasRow {
                method,
                ..make_row(
                    value,
                    make_side(Some(error), code),
                    (method != "matrix").then(|| make_side(None, code)),
                )
            })
        };
        values.into_iter().flat_map(of).collect()
    };
    let mut all = ["near-plates", "leak <corner>", "slivers"].map(|name| make_study(name, rows()));
    all[0].specimen = Some(make_specimen(closed_room(), 7));
    all[1].info.measure = LEAK_MEASURE;
    all[2].specimen = Some(make_specimen(triangle_pair(), 0));
    all.into()
}
