//! Settings: the command line, lamps, and the settings of a solve.

use crate::numbers::Numbers;
use crate::requirements::{require_one_line, require_sound_faces};
use common::form_factor::FormFactor;
use common::import::add_lamp;
use common::scene::{Face, Scene};
use common::settings::{
    ItemBufferProjection, ItemBufferSettings, Iteration, Lookup, Meshing, Schedule, Settings, SolveQuality, Transport,
    Visibility,
};
use glam::{DVec3, Vec3};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveRequest, solve_request};
use std::ffi::OsString;

/// Checks the parser of the command line; each line of the input is a word after the program's name.
pub fn check_command_line(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let words = ["radiosity"].into_iter().chain(text.lines());
    let words: Vec<OsString> = words.map(OsString::from).collect();
    if let Err(message) = radiosity::cli::check_command_line(words) {
        require_one_line(&message);
    }
}

/// Checks the place and the light of a lamp in a small room: three coordinates and a power, of 64 bits each.
pub fn check_lamp(data: &[u8]) {
    let mut numbers = Numbers(data);
    let place = DVec3::new(numbers.real(), numbers.real(), numbers.real());
    let power = numbers.real();
    let mut scene = small_room();
    let walls = scene.faces.len();
    match add_lamp(&mut scene, "lamp", place, power) {
        Ok(()) => {
            require_sound_faces(&scene);
            let lamp = &scene.faces[walls..];
            assert!(
                lamp.iter().all(|face| face.emission.min_element() > 0.0),
                "{:?}",
                lamp[0]
            );
            let emitted: f64 = lamp.iter().map(|face| face.area() * f64::from(face.emission.x)).sum();
            assert!((emitted / power - 1.0).abs() < 1e-4, "{emitted} W of {power} W");
        }
        Err(message) => require_one_line(&message),
    }
}

/// Checks that a small scene is solved, or refused in one line, with any settings.
pub fn check_settings(data: &[u8]) {
    let mut numbers = Numbers(data);
    let solver = match numbers.byte() % 4 {
        0 => SolverChoice::Dense,
        1 => SolverChoice::Hierarchy(ErrorTarget {
            error: numbers.real(),
            texels: numbers.choice(&[None, Some(0), Some(1), Some(3)]),
        }),
        _ => SolverChoice::Cpu,
    };
    let settings = take_settings(&mut numbers);
    let scene = small_room();
    let request = SolveRequest {
        task: &scene,
        settings: &settings,
        solver,
    };
    match solve_request(&request, &without_progress()) {
        Ok(answer) => {
            let field = &answer.solved.run.field;
            assert!(field.radiosity.iter().all(|b| b.is_finite()), "{settings:?}");
        }
        Err(error) => require_one_line(&error),
    }
}

fn take_settings(numbers: &mut Numbers) -> Settings {
    let drawing = ItemBufferSettings {
        projection: numbers.choice(&ItemBufferProjection::ALL_PROJECTIONS),
        size: numbers.choice(&[16, 0, 1, 17]),
        lookup: numbers.choice(&[Lookup::Exact, Lookup::Neighbours]),
    };
    Settings {
        quality: numbers.choice(&[SolveQuality::Draft, SolveQuality::Normal, SolveQuality::Reference]),
        meshing: Meshing {
            texels: numbers.choice(&[1, 0, 2, 3, u32::MAX]),
            patches: numbers.choice(&[1, 0, 2, 5, u32::MAX]),
            samples: numbers.choice(&[1, 0, 2, 5]),
        },
        transport: Transport {
            visibility: numbers.choice(&[Visibility::Rays, Visibility::ItemBuffer(drawing)]),
            form_factor: numbers.choice(&[FormFactor::Paper, FormFactor::Disc, FormFactor::Polygon]),
            conserve: numbers.choice(&[false, true]),
        },
        schedule: Schedule {
            iteration: numbers.choice(&[Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg]),
            max_shots: numbers.choice(&[20, 0, 1]),
            epsilon: numbers.real(),
        },
    }
}

/// Makes a room of four faces: a floor, a lamp above it, a wall and a triangle.
fn small_room() -> Scene {
    let corner = DVec3::new;
    let floor = [
        corner(0., 0., 0.),
        corner(0., 0., 2.),
        corner(2., 0., 2.),
        corner(2., 0., 0.),
    ];
    let lamp = [
        corner(0.5, 1., 0.5),
        corner(1., 1., 0.5),
        corner(1., 1., 1.),
        corner(0.5, 1., 1.),
    ];
    let wall = [
        corner(0., 0., 0.),
        corner(2., 0., 0.),
        corner(2., 1.5, 0.),
        corner(0., 1.5, 0.),
    ];
    let triangle = [corner(0., 0., 0.), corner(0., 1.5, 0.), corner(0., 0., 2.)];
    let grey = Vec3::new(0.8, 0.5, 0.2);
    Scene {
        name: "small room".into(),
        faces: vec![
            Face::quad("floor", floor, Vec3::ZERO, grey),
            Face::quad("lamp", lamp, Vec3::ONE, Vec3::ZERO),
            Face::quad("wall", wall, Vec3::ZERO, grey),
            Face::triangle("triangle", triangle, Vec3::ZERO, grey),
        ],
        ..Scene::default()
    }
}
