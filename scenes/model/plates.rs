//! Unit squares whose form factors are known, and a room of slivers.

use super::{Material, Part, Scene, parallelogram, part, turned_box, unit_room};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

const GREY: Material = Material::reflecting("grey", [0.5; 3]);
/// Emits 1 W/m².
const LIGHT: Material = Material::emitting("light", [0.5; 3], [FRAC_1_PI; 3]);

/// Height of a sliver over its length.
const SLIVER_HEIGHT: f64 = 1e-3;

pub fn scenes() -> Vec<Scene> {
    let blocker = turned_box(DVec3::splat(0.5), DVec3::new(0.5, 0.02, 0.5), 0.0);
    vec![
        Scene {
            name: "facing_plates",
            about: "Unit squares at distance 1, F = 0.1998248957; the upper one emits 1 W/m2.",
            parts: facing_plates(),
        },
        Scene {
            name: "perpendicular_plates",
            about: "Unit squares sharing an edge, F = 0.2000437761; the wall emits 1 W/m2.",
            parts: vec![
                lower_plate(),
                part("wall", LIGHT, vec![parallelogram(DVec3::ZERO, DVec3::Y, DVec3::Z)]),
            ],
        },
        Scene {
            name: "occluded_plates",
            about: "The facing plates with a thin block half as wide between them.",
            parts: [facing_plates(), vec![part("blocker", GREY, blocker)]].concat(),
        },
        Scene {
            name: "slivers",
            about: "A closed unit room with a quad and a triangle of aspect 1000:1.",
            parts: sliver_room(),
        },
    ]
}

fn lower_plate() -> Part {
    part("lower", GREY, vec![parallelogram(DVec3::ZERO, DVec3::Z, DVec3::X)])
}

fn facing_plates() -> Vec<Part> {
    vec![
        lower_plate(),
        part("upper", LIGHT, vec![parallelogram(DVec3::Y, DVec3::X, DVec3::Z)]),
    ]
}

fn sliver_room() -> Vec<Part> {
    let [floor, ceiling, left, right, back, front] = unit_room().map(|(origin, u, v)| parallelogram(origin, u, v));
    // The floor is cut close to the right wall, the ceiling along a diagonal, and the left wall
    // is four triangles about a point just above its lower edge.
    let [a, b, c, d] = [floor[0], floor[1], floor[2], floor[3]];
    let strip = DVec3::X * SLIVER_HEIGHT;
    let floor = vec![vec![a, b, c - strip, d - strip], vec![d - strip, c - strip, c, d]];
    let ceiling = vec![
        vec![ceiling[0], ceiling[1], ceiling[2]],
        vec![ceiling[0], ceiling[2], ceiling[3]],
    ];
    let point = DVec3::new(0.0, SLIVER_HEIGHT, 0.5);
    let left = (0..4).map(|k| vec![left[k], left[(k + 1) % 4], point]).collect();
    vec![
        part("floor", GREY, floor),
        part("ceiling", LIGHT, ceiling),
        part("left_wall", GREY, left),
        part("walls", GREY, vec![right, back, front]),
    ]
}
