//! Made-up studies for the page's tests: every sort of side, value and specimen.

use super::{About, LEAK, Plate, RELATIVE, Row, Side, Specimen, Study, Verdict};
use crate::solve::solved::Solved;
use crate::solve::solver::Solver;
use crate::solve::watch::unwatched;
use crate::solve::{Given, Question, answer};
use common::scene::{Face, Scene};
use common::settings::Settings;
use glam::{DVec3, Vec3};

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
        mended: Vec::new(),
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

fn quad(name: &str, corners: [[f64; 3]; 4], colour: [f32; 3], light: f32) -> Face {
    let corners = corners.map(DVec3::from);
    Face::quad(name, corners, Vec3::splat(light), Vec3::from(colour))
}

fn scene(name: &str, faces: Vec<Face>) -> Scene {
    Scene {
        name: name.into(),
        faces,
        notes: Vec::new(),
    }
}

/// A closed room with coloured walls, a light below its ceiling and a shelf.
pub fn room() -> Scene {
    let (l, r, f) = (0.0, 4.0, 3.0);
    let (red, green, white) = ([0.6, 0.1, 0.1], [0.1, 0.5, 0.15], [0.75; 3]);
    let flat =
        |y: f64, [a, b]: [f64; 2], [c, d]: [f64; 2]| [[a, y, c], [a, y, d], [b, y, d], [b, y, c]];
    let down = |corners: [[f64; 3]; 4]| [corners[3], corners[2], corners[1], corners[0]];
    scene(
        "room",
        vec![
            quad("floor", flat(0.0, [l, r], [l, r]), white, 0.0),
            quad("ceiling", down(flat(f, [l, r], [l, r])), white, 0.0),
            quad(
                "left wall",
                [[l, 0.0, l], [l, f, l], [l, f, r], [l, 0.0, r]],
                red,
                0.0,
            ),
            quad(
                "right wall",
                [[r, 0.0, r], [r, f, r], [r, f, l], [r, 0.0, l]],
                green,
                0.0,
            ),
            quad(
                "back wall",
                [[l, 0.0, r], [l, f, r], [r, f, r], [r, 0.0, r]],
                white,
                0.0,
            ),
            quad(
                "front wall",
                [[r, 0.0, l], [r, f, l], [l, f, l], [l, 0.0, l]],
                white,
                0.0,
            ),
            quad(
                "lamp",
                down(flat(2.9, [1.5, 2.5], [1.5, 2.5])),
                [0.0; 3],
                40.0,
            ),
            quad("shelf", flat(1.2, [0.5, 2.0], [1.0, 3.0]), white, 0.0),
            quad(
                "under the shelf",
                down(flat(1.19, [0.5, 2.0], [1.0, 3.0])),
                white,
                0.0,
            ),
        ],
    )
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
        texels: 12,
        cells: 2,
        samples: 1,
        ..Settings::default()
    };
    let question = Question {
        task: &scene,
        settings: &settings,
        given: Given::ALL,
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
    let answers = METHODS.iter().enumerate().flat_map(|(k, method)| {
        let size = [0.02, 0.05, 0.15, 0.6][k % 4];
        let halves = [("CPU", size), ("GPU", 1.3 * size)];
        halves.map(|(half, size)| plate(&format!("{method}, {half}"), noisy(size)))
    });
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

const METHODS: [&str; 9] = [
    "default",
    "draft",
    "reference",
    "disc",
    "paper's factor",
    "stereographic 1024²",
    "hemicube 256²",
    "paper",
    "matrix",
];

const CASES: [(&str, &str, &str); 12] = [
    (
        "near-plates",
        "gap between the plates, edges",
        "closed form: two parallel squares",
    ),
    (
        "thin-slit",
        "width of the slit, m",
        "the matrix on 32² texels",
    ),
    ("far-light", "distance, edges of the light", "closed form"),
    (
        "leak <corner>",
        "wall's thickness, m",
        "none may be there: 0",
    ),
    ("bright-walls", "reflectance, 1 − ρ", "furnace: E / (1 − ρ)"),
    ("slivers", "width over length", "the matrix"),
    ("grazing", "angle, degrees", "double contour integral"),
    ("many-faces", "faces", "the matrix on 4² texels"),
    ("tiny-lamp", "edge of the lamp, m", "point light's limit"),
    ("stacked", "layers", "closed form"),
    (
        "far-from-origin",
        "distance from the origin, m",
        "the same at the origin",
    ),
    (
        "coplanar",
        "overlap, share of a face",
        "the union's closed form",
    ),
];

/// A dozen cases, nine methods, values over decades in both directions.
pub fn studies() -> Vec<Study> {
    let cases = CASES.iter().enumerate();
    cases
        .map(|(k, (name, parameter, truth))| {
            let mut one = study(name, Vec::new());
            one.about.parameter = parameter;
            one.about.truth = truth;
            if k == 3 {
                one.about.measure = LEAK;
            }
            let values: Vec<f64> = (0..4 + k % 6)
                .map(|j| match k % 4 {
                    3 => 10f64.powi(j as i32),
                    2 => 0.5 / 3f64.powi(j as i32),
                    _ => 10f64.powi(-(j as i32)),
                })
                .collect();
            for (j, value) in values.iter().enumerate() {
                for (m, method) in METHODS.iter().enumerate() {
                    if (k, *method) != (7, "matrix") {
                        one.rows.push(invented(k, j, m, *value));
                    }
                }
            }
            one.specimen = match k % 5 {
                4 => None,
                1 => Some(specimen(triangle(), 0)),
                _ => Some(specimen(room(), [0, 7, 2, 4][k % 4])),
            };
            one
        })
        .collect()
}

/// Harder values and later methods err more; some are warned about, some give no answer.
fn invented(case: usize, step: usize, method: usize, value: f64) -> Row {
    let power = [0.1, 0.8, 0.05, 1.6, 1.9, 0.6, 1.1, 2.2, 0.0][method] * (1.0 + case as f64 / 12.0);
    let floor = [4e-4, 6e-3, 1e-4, 2e-3, 8e-3, 1e-3, 4e-3, 3e-2, 1e-6][method];
    let error = floor * 10f64.powf(power * step as f64 * 0.6);
    let measure = if case == 3 { LEAK } else { RELATIVE };
    let one = |error: f64, n: usize| {
        let error = if case == 3 { error * 1e-5 } else { error };
        let late = step > 3 && (method + case + n).is_multiple_of(5);
        let code = match (
            side(Some(error), "").verdict != Verdict::Safe,
            (step + method + n) % 3,
        ) {
            (true, 0 | 1) => ["closure", "near", "thin"][(method + step) % 3],
            (false, 0) if method == 5 => "near",
            _ => "",
        };
        let mut one = side((!late).then_some(error), code);
        if (case, step, method, n) == (10, 2, 0, 1) {
            one.error = None;
            one.message = Some("panic: index out of bounds".into());
        }
        if method == 2 {
            one.mended.push("a face of no area was left out".into());
        }
        one.verdict = Verdict::of(measure, one.error);
        one
    };
    let gpu = (METHODS[method] != "matrix").then(|| one(error * 1.15 + 2e-4, 1));
    Row {
        case: CASES[case].0,
        parameter: CASES[case].1,
        method: METHODS[method],
        ..row(value, one(error, 0), gpu)
    }
}
