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
const LAMP: Material = Material::emitting("lamp", [0.75; 3], [10.0 * FRAC_1_PI; 3]);

/// Faces along a side of a wall.
const FACES_PER_SIDE: u32 = 5;

const LAMP_CENTRE: DVec3 = DVec3::new(0.5, 0.965, 0.5);
const LAMP_SIZE: DVec3 = DVec3::new(0.3, 0.05, 0.3);

/// Names, centres, sizes and turns in degrees of the blocks; they hover, so that they do not touch the floor.
const BLOCK_BOXES: [(&str, DVec3, DVec3, f64); 2] = [
    (
        "tall_block",
        DVec3::new(0.34, 0.31, 0.36),
        DVec3::new(0.3, 0.6, 0.3),
        17.0,
    ),
    (
        "short_block",
        DVec3::new(0.66, 0.16, 0.66),
        DVec3::new(0.3, 0.3, 0.3),
        -17.0,
    ),
];

/// Enough digits for E = π·L to round to 1.
const FURNACE: Material = Material::emitting("furnace", [0.5; 3], [FRAC_1_PI; 3]);

/// Names and materials of the walls, in the order of [`unit_room`].
const WALLS: [(&str, Material); 6] = [
    ("floor", WHITE),
    ("ceiling", WHITE),
    ("left_wall", RED),
    ("right_wall", GREEN),
    ("back_wall", WHITE),
    ("front_wall", WHITE),
];

pub fn scenes() -> Vec<Scene> {
    let block = |(name, centre, size, degrees)| part(name, BLOCKS, turned_box(centre, size, degrees));
    let blocks = BLOCK_BOXES.map(block);
    let scene = |name, about, parts| Scene { name, about, parts };
    vec![
        scene(
            "paper_room",
            "The room of the paper's experiment: 150 faces of walls, 6 of a lamp.",
            paper_room(),
        ),
        scene(
            "paper_room_objects",
            "The room of the paper's experiment with its objects: 168 faces.",
            [paper_room(), blocks.clone().into()].concat(),
        ),
        scene(
            "paper_objects",
            "The objects of the paper's experiment: two blocks, 12 faces.",
            blocks.into(),
        ),
        scene(
            "furnace",
            "Every face emits 1 W/m2 and reflects half: B = 2 everywhere.",
            furnace_room(),
        ),
    ]
}

fn paper_room() -> Vec<Part> {
    let walls = WALLS.into_iter().zip(unit_room());
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
    let walls = WALLS.into_iter().zip(unit_room());
    walls
        .map(|((name, _), (origin, u, v))| part(name, FURNACE, vec![parallelogram(origin, u, v)]))
        .collect()
}
