//! Made-up studies for the page's tests: every sort of side, value and specimen.

use super::cases::shapes::{cuboid, lamp_above, plate, scene};
use super::{About, LEAK, Plate, RELATIVE, Row, Side, Specimen, Study, Verdict};
use crate::solve::solved::Solved;
use crate::solve::solver::Solver;
use crate::solve::watch::unwatched;
use crate::solve::{Question, answer};
use common::scene::{Face, Scene};
use common::settings::{Meshing, Settings};
use glam::{DVec3, Vec3};

const METHODS: [&str; 2] = ["default", "matrix"];

/// A side; without an error it is refused. An empty code is no warning.
pub fn side(error: Option<f64>, code: &str) -> Side {
    Side {
        error,
        noise: 0.0,
        bias: None,
        estimate: None,
        verdict: Verdict::of(RELATIVE, error),
        warnings: (!code.is_empty())
            .then(|| code.into())
            .into_iter()
            .collect(),
        notes: Vec::new(),
        message: error.is_none().then(|| "it does not fit".into()),
        seconds: 0.25,
    }
}

/// A row of the default method.
pub fn row(value: f64, cpu: Side, gpu: Option<Side>) -> Row {
    let worse = |a: &Side, b: &Side| a.error.is_none() || a.error > b.error;
    let worst = match &gpu {
        Some(gpu) if worse(gpu, &cpu) => gpu.clone(),
        _ => cpu.clone(),
    };
    Row {
        case: "one",
        parameter: "gap, m",
        value,
        method: "default",
        error: worst.error,
        warned: worst.warned(),
        verdict: worst.verdict,
        cpu,
        gpu,
    }
}

/// A case with these rows and no specimen.
pub fn study(name: &'static str, rows: Vec<Row>) -> Study {
    Study {
        about: About {
            name,
            parameter: "gap, m",
            breaks: "the point-to-polygon form factor where a texel nearly touches its shooter",
            truth: "closed form: two parallel squares",
            measure: RELATIVE,
        },
        rows,
        specimen: None,
    }
}

/// A closed room, a light below its ceiling and a shelf.
pub fn room() -> Scene {
    let mut faces = cuboid([0.0; 3], [4.0, 4.0, 3.0], true, 0.7);
    faces.push(lamp_above([2.0, 2.0, 2.9], [1.0; 2], 40.0));
    let shelf = plate([1.3, 2.0, 1.2], [1.5, 2.0], 0.7);
    faces.extend([shelf.reversed(), shelf]);
    scene("room", faces)
}

/// Two triangles that face each other, one of them a light.
pub fn triangle() -> Scene {
    let at = |y: f64| [[0.0, y, 0.0], [0.4, y, 2.0], [2.0, y, 0.3]].map(DVec3::from);
    let [a, b, c] = at(1.5);
    scene(
        "triangles",
        vec![
            Face::triangle("ground", at(0.0), Vec3::ZERO, Vec3::splat(0.7)),
            Face::triangle("light", [c, b, a], Vec3::splat(9.0), Vec3::splat(0.2)),
        ],
    )
}

/// The scene solved, and plates of a face: the truth, and answers that are more and more off.
pub fn specimen(scene: Scene, face: u32) -> Specimen {
    let settings = Settings {
        meshing: Meshing {
            texels: 12,
            cells: 2,
            samples: 1,
        },
        ..Settings::default()
    };
    let question = Question {
        task: &scene,
        settings: &settings,
        solver: Solver::Cpu,
    };
    let Solved { mesh, run, .. } = answer(&question, &unwatched()).unwrap().solved;
    let field = run.field;
    let own = mesh.in_face_order().into_iter();
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
    let answers = METHODS.iter().zip([0.05, 0.6]);
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

/// A case that breaks, one of leaks, and one whose specimen is of triangles: two methods, three values.
pub fn studies() -> Vec<Study> {
    let rows = || -> Vec<Row> {
        let values = [(1.0, 0.001, ""), (0.1, 0.03, "closure"), (0.01, 0.5, "")];
        let of = |(value, error, code): (f64, f64, &str)| {
            METHODS.map(|method| Row {
                method,
                ..row(
                    value,
                    side(Some(error), code),
                    (method != "matrix").then(|| side(None, code)),
                )
            })
        };
        values.into_iter().flat_map(of).collect()
    };
    let mut all = ["near-plates", "leak <corner>", "slivers"].map(|name| study(name, rows()));
    all[0].specimen = Some(specimen(room(), 7));
    all[1].about.measure = LEAK;
    all[2].specimen = Some(specimen(triangle(), 0));
    all.into()
}
