//! Closed rooms: the one of the paper's experiment, empty and with two blocks, and a furnace.

use super::{Material, Part, Scene, parallelogram, parallelogram_grid, part, turned_box, unit_room};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Reflectances by which the room with objects, with whole faces as patches, takes about 330 shots to 5 %
/// unshot power; the paper took 322 and 334.
const WHITE: Material = Material::reflecting("white", [0.75, 0.75, 0.75]);
const RED: Material = Material::reflecting("red", [0.7, 0.15, 0.15]);
const GREEN: Material = Material::reflecting("green", [0.15, 0.7, 0.15]);
const BLOCKS: Material = Material::reflecting("block", [0.75, 0.75, 0.75]);
/// Only the lamp's underside emits: 10 W/m².
const LAMP: Material = Material {
    name: "lamp",
    reflectance: [0.75, 0.75, 0.75],
    radiance: [10.0 * FRAC_1_PI; 3],
};

/// Faces along a side of a wall.
const FACES_PER_SIDE: u32 = 5;

const LAMP_CENTRE: DVec3 = DVec3::new(0.5, 0.965, 0.5);
const LAMP_SIZE: DVec3 = DVec3::new(0.3, 0.05, 0.3);

/// Blocks hover, so that they do not touch the floor.
const TALL_CENTRE: DVec3 = DVec3::new(0.34, 0.31, 0.36);
const TALL_SIZE: DVec3 = DVec3::new(0.3, 0.6, 0.3);
const SHORT_CENTRE: DVec3 = DVec3::new(0.66, 0.16, 0.66);
const SHORT_SIZE: DVec3 = DVec3::new(0.3, 0.3, 0.3);
/// About the vertical axis, one way and the other.
const TURN_DEGREES: f64 = 17.0;

/// Enough digits for E = π·L to round to 1.
const FURNACE: Material = Material {
    name: "furnace",
    reflectance: [0.5; 3],
    radiance: [FRAC_1_PI; 3],
};

const WALLS: [&str; 6] = ["floor", "ceiling", "left_wall", "right_wall", "back_wall", "front_wall"];

pub fn scenes() -> Vec<Scene> {
    let blocks = [
        part("tall_block", BLOCKS, turned_box(TALL_CENTRE, TALL_SIZE, TURN_DEGREES)),
        part(
            "short_block",
            BLOCKS,
            turned_box(SHORT_CENTRE, SHORT_SIZE, -TURN_DEGREES),
        ),
    ];
    vec![
        Scene {
            name: "paper_room",
            about: "The room of the paper's experiment: 150 faces of walls, 6 of a lamp.",
            parts: paper_room(),
        },
        Scene {
            name: "paper_room_objects",
            about: "The room of the paper's experiment with its objects: 168 faces.",
            parts: [paper_room(), blocks.clone().into()].concat(),
        },
        Scene {
            name: "paper_objects",
            about: "The objects of the paper's experiment: two blocks, 12 faces.",
            parts: blocks.into(),
        },
        Scene {
            name: "furnace",
            about: "Every face emits 1 W/m2 and reflects half: B = 2 everywhere.",
            parts: furnace_room(),
        },
    ]
}

fn paper_room() -> Vec<Part> {
    let materials = [WHITE, WHITE, RED, GREEN, WHITE, WHITE];
    let walls = WALLS.into_iter().zip(materials).zip(unit_room());
    let mut parts: Vec<Part> = walls
        .map(|((name, material), (origin, u, v))| {
            part(name, material, parallelogram_grid(origin, u, v, FACES_PER_SIDE))
        })
        .collect();
    let mut lamp = turned_box(LAMP_CENTRE, LAMP_SIZE, 0.0);
    let housing = lamp.split_off(1);
    parts.push(part("lamp", LAMP, lamp));
    parts.push(part("lamp_housing", WHITE, housing));
    parts
}

fn furnace_room() -> Vec<Part> {
    WALLS
        .into_iter()
        .zip(unit_room())
        .map(|(name, (origin, u, v))| part(name, FURNACE, vec![parallelogram(origin, u, v)]))
        .collect()
}
