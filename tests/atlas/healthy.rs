//! The verdict on scenes drawn at random: green on healthy code, red on planted faults.
//!
//! VERDICT_SCENES and VERDICT_SEED ask for other scenes than those of every run.

use common::form_factor::FormFactor;
use common::import::{ImportOptions, load};
use common::settings::{
    Iteration, Meshing, Projection, Quality, Raster, Schedule, Settings, Transport, Visibility,
};
use gpu::{Fault, Gpu};
use oracle::judge::compare::ways::{Ways, judge};
use oracle::judge::compare::{Request, compare};
use oracle::judge::comparison::Comparison;
use oracle::solve::solver::{Asked, USUAL};
use oracle::solve::watch::unwatched;
use oracle::study::random::{Drawn, Faces, Options, scene};

fn number(name: &str, default: u64) -> u64 {
    let asked = std::env::var(name).ok();
    asked.map_or(default, |text| text.parse().expect("a number"))
}

/// Scenes of a run: quads, triangles and both in turn.
fn drawn(default: u64) -> impl Iterator<Item = Drawn> {
    let first = number("VERDICT_SEED", 1);
    (first..first + number("VERDICT_SCENES", default)).map(|seed| {
        let faces = match seed % 4 {
            0 => Faces::Quads,
            1 | 3 => Faces::Triangles,
            _ => Faces::Mixed,
        };
        scene(
            seed,
            Options {
                faces,
                ..Options::default()
            },
        )
    })
}

fn gpu() -> Gpu {
    Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh")
}

fn stereographic(size: u32) -> Visibility {
    Visibility::drawn(Projection::Stereographic(Raster::Pixel), size)
}

/// Whole faces and single shots, as the paper; coarse pixels, so that many pairs are mistaken.
fn paper() -> Settings {
    Settings {
        meshing: Meshing {
            texels: 8,
            cells: 1,
            ..Meshing::default()
        },
        transport: Transport {
            visibility: stereographic(256),
            form_factor: FormFactor::Disc,
            ..Transport::default()
        },
        schedule: Schedule {
            epsilon: 0.01,
            // A kept residual never ends.
            max_shots: 400,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// As `solve` does before it mends itself.
fn solve(visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 4,
            cells: 2,
            samples: 2,
        },
        transport: Transport {
            visibility,
            ..Transport::default()
        },
        schedule: Schedule {
            iteration: Iteration::Cg,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

fn judged(drawn: &Drawn, gpu: &Gpu, settings: Settings, faults: &[Fault]) -> Option<Comparison> {
    let request = Request {
        settings,
        gpu,
        faults,
    };
    // What the host refuses is noticed as well.
    compare(&drawn.scene, &request, &unwatched()).ok()
}

fn failing(comparison: &Comparison) -> Vec<String> {
    let red = comparison.gates.iter().filter(|gate| !gate.pass);
    red.map(|g| format!("{} {:.3e} > {:.3e}", g.name, g.value, g.bound))
        .collect()
}

/// How near each bound that is not 0 was come to.
fn nearest(comparison: &Comparison) -> (f64, String) {
    let of = |g: &oracle::judge::comparison::Gate| (g.value / g.bound, g.name.clone());
    let ratios = comparison.gates.iter().filter(|g| g.bound > 0.0).map(of);
    ratios
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or_default()
}

#[test]
fn healthy_code_is_green_on_any_scene() {
    let gpu = gpu();
    let mut red = Vec::new();
    for drawn in drawn(4) {
        let ways = [paper(), solve(stereographic(128)), solve(Visibility::Rays)];
        for settings in ways {
            let c = judged(&drawn, &gpu, settings, &[]).unwrap();
            let share = c.pairs.mismatched as f64 / c.pairs.facing.max(1) as f64;
            println!(
                "{} {} faces, {:?}: mismatched {:.2} %, {} unexplained {:?}, lockstep {:.3} %, nearest {:?}",
                c.scene.name,
                c.scene.faces.len(),
                c.gpu_settings.transport.visibility,
                100.0 * share,
                c.pairs.unexplained,
                c.pairs.examples,
                100.0 * c.lockstep_difference.relative_rms,
                nearest(&c),
            );
            if !c.agree() {
                red.push(format!(
                    "{} {:?}: {:?}",
                    c.scene.name,
                    c.gpu_settings,
                    failing(&c)
                ));
            }
        }
    }
    assert!(red.is_empty(), "{red:#?}");
}

/// Of every kind of fault one, of those that any scene with light can feel.
const FAULTS: &[(&str, &str, &str)] = &[
    (
        "form_factor",
        "return disc(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);",
        "return disc(cos_i, 1.0, r2, shots[slot].area, shots[slot].area);",
    ),
    (
        "form_factor",
        "return disc(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);",
        "return disc(cos_i, cos_j, r2, texel_area, texel_area);",
    ),
    (
        "aim",
        "shots[slot].normal = faces[face].plane.xyz;",
        "shots[slot].normal = -faces[face].plane.xyz;",
    ),
    ("deposit", "texels[k].reflectance * received;", "received;"),
    ("deposit", "residual[k] = vec4f(0.0);", ""),
    (
        "deposit",
        "radiosity[k] += vec4f(reflected, 0.0);",
        "radiosity[k] = vec4f(0.0);",
    ),
    (
        "deposit",
        "shot.radiosity * f;",
        "shot.radiosity * (f / (f - f));",
    ),
    (
        "lookup",
        "clamp(i32(floor(p.x)), 0, last)",
        "clamp(i32(floor(p.x)) + 1, 0, last)",
    ),
    (
        "item_buffer",
        "pixel_centre(pixel.x, ",
        "pixel_centre(pixel.x + 1u, ",
    ),
    ("select", "if power > best {", "if power < best {"),
];

#[test]
fn planted_faults_are_red_on_nearly_any_scene() {
    let gpu = gpu();
    let (mut asked, mut missed) = (0, Vec::new());
    for drawn in drawn(2) {
        for (file, from, to) in FAULTS {
            let fault = [Fault { file, from, to }];
            let c = judged(&drawn, &gpu, paper(), &fault);
            asked += 1;
            if c.is_some_and(|c| c.agree()) {
                missed.push(format!("{}: {file}, {to}", drawn.scene.name));
            }
        }
    }
    println!("{} of {asked} missed: {missed:#?}", missed.len());
    assert!(20 * missed.len() <= asked, "{missed:#?}");
}

/// With nothing asked for: what `solve` does, and the paper's way, each with its error.
#[test]
fn two_ways_are_judged_and_their_errors_told() {
    let file = std::env::var("VERDICT_FILE").unwrap_or_else(|_| {
        concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/facing_plates.obj").into()
    });
    let texels = number("VERDICT_TEXELS", 8) as u32;
    let scene = load(file.as_ref(), &ImportOptions::default()).unwrap();
    let pixels = number("VERDICT_PIXELS", 256) as u32;
    let normal = Settings::of(Quality::Normal).by(stereographic(pixels));
    let paper = Settings {
        meshing: Meshing {
            texels,
            cells: 1,
            samples: 1,
        },
        transport: Transport {
            form_factor: FormFactor::Disc,
            ..normal.transport
        },
        schedule: Schedule {
            iteration: Iteration::Southwell,
            ..normal.schedule
        },
        ..normal
    };
    let asked = Asked {
        error: USUAL,
        texels: Some(texels),
    };
    let ways = Ways::Both { paper, asked };
    let judged = judge(&scene, &ways, &gpu(), &[], &unwatched()).unwrap();
    for c in judged.ways() {
        println!(
            "{} {:?} {:?} {:?} {:?}",
            c.way.name(),
            failing(c),
            c.error,
            c.truth,
            c.seconds
        );
        println!("{:?} {:?}", c.findings, c.notes);
    }
    assert!(judged.agree());
    let error = |c: &Comparison| c.error.map(|e| e.expect("a truth"));
    let as_solved = error(judged.as_solved.as_ref().expect("both ways"));
    let paper = error(&judged.first);
    // Whole faces are far off between plates as near as these: the verdict is green, the error says it.
    assert!(paper.iter().all(|e| *e > 0.02), "{paper:?}");
    assert!(as_solved.iter().all(|e| *e < 0.02), "{as_solved:?}");
    if let Some(out) = std::env::var_os("VERDICT_OUT") {
        let page = oracle::show::report::html(std::slice::from_ref(&judged), &[]);
        std::fs::write(std::path::Path::new(&out).join("report.html"), page).unwrap();
        let json = oracle::show::report::json(std::slice::from_ref(&judged)).to_string();
        std::fs::write(std::path::Path::new(&out).join("report.json"), json).unwrap();
    }
}
