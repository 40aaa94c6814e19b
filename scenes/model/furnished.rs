//! A furnished room, in metres: x runs to the left as seen through the wall z = 0, which faces the sofa.

use super::{Material, Part, Scene, parallelogram, part, turned_box, unit_room};
use glam::DVec3;
use std::f64::consts::TAU;

const ROOM_SIZE: DVec3 = DVec3::new(4.2, 2.8, 4.0);

const PLASTER: Material = Material::reflecting("plaster", [0.8, 0.78, 0.74]);
const CLAY: Material = Material::reflecting("clay", [0.72, 0.36, 0.22]);
const SAGE: Material = Material::reflecting("sage", [0.36, 0.52, 0.42]);
const OAK: Material = Material::reflecting("oak", [0.56, 0.4, 0.26]);
const WALNUT: Material = Material::reflecting("walnut", [0.36, 0.21, 0.12]);
const WOOL: Material = Material::reflecting("wool", [0.74, 0.69, 0.6]);
const DENIM: Material = Material::reflecting("denim", [0.14, 0.25, 0.46]);
const MUSTARD: Material = Material::reflecting("mustard", [0.8, 0.54, 0.1]);
const RUST: Material = Material::reflecting("rust", [0.66, 0.2, 0.1]);
const LEAF: Material = Material::reflecting("leaf", [0.16, 0.42, 0.14]);
const CHINA: Material = Material::reflecting("china", [0.82, 0.82, 0.84]);
const PAPER_LAMP: Material = Material::emitting("paper_lamp", [0.7; 3], [40.0, 32.0, 22.0]);

/// Faces of a box in the order of [`turned_box`].
const BOTTOM: usize = 0;
const TOP: usize = 1;
const LOW_X: usize = 2;
const LOW_Z: usize = 4;
const HIGH_Z: usize = 5;

pub fn furnished_room() -> Scene {
    Scene {
        name: "room",
        about: "A furnished room with one lamp, in metres.",
        parts: [walls(), seating(), storage(), decoration()].concat(),
    }
}

fn walls() -> Vec<Part> {
    let surfaces = [
        ("floor", OAK),
        ("ceiling", PLASTER),
        ("right_wall", SAGE),
        ("left_wall", CLAY),
        ("front_wall", PLASTER),
        ("back_wall", PLASTER),
    ];
    let wall = |((name, material), corners): ((_, _), (DVec3, DVec3, DVec3))| {
        let [origin, u, v] = <[DVec3; 3]>::from(corners).map(|p| p * ROOM_SIZE);
        part(name, material, vec![parallelogram(origin, u, v)])
    };
    surfaces.into_iter().zip(unit_room()).map(wall).collect()
}

fn seating() -> Vec<Part> {
    let sofa = [
        open_box([1.0, 0.0, 3.0], [3.0, 0.4, 3.9], &[BOTTOM]),
        open_box([1.0, 0.4, 3.65], [3.0, 0.85, 3.9], &[BOTTOM]),
        open_box([1.0, 0.4, 3.0], [1.2, 0.6, 3.65], &[BOTTOM, HIGH_Z]),
        open_box([2.8, 0.4, 3.0], [3.0, 0.6, 3.65], &[BOTTOM, HIGH_Z]),
    ];
    let legs = [(1.55, 1.75), (2.45, 1.75), (1.55, 2.2), (2.45, 2.2)]
        .map(|(x, z)| open_box([x, 0.01, z], [x + 0.05, 0.4, z + 0.05], &[BOTTOM, TOP]));
    let top = open_box([1.5, 0.4, 1.7], [2.55, 0.44, 2.3], &[]);
    // Two centimetres above the seat: in contact with it they would need a third more links.
    let cushion = |x: f64, degrees: f64| turned_box(DVec3::new(x, 0.59, 3.53), DVec3::new(0.36, 0.34, 0.12), degrees);
    vec![
        part("sofa", DENIM, sofa.concat()),
        part("left_cushion", MUSTARD, cushion(2.5, 20.0)),
        part("right_cushion", RUST, cushion(1.5, -16.0)),
        part("table", WALNUT, [top, legs.concat()].concat()),
        part("rug", WOOL, open_box([1.0, 0.0, 1.3], [3.1, 0.01, 2.8], &[BOTTOM])),
    ]
}

fn storage() -> Vec<Part> {
    let book = |y: f64, thickness: f64, z: f64| open_box([0.08, y, z], [0.3, y + thickness, z + 0.3], &[BOTTOM]);
    let bowl = [(0.07, 0.0), (0.18, 0.14), (0.0, 0.06)];
    vec![
        part(
            "sideboard",
            WALNUT,
            open_box([0.0, 0.0, 1.5], [0.42, 0.75, 3.0], &[BOTTOM, LOW_X]),
        ),
        part("large_book", DENIM, book(0.75, 0.06, 2.5)),
        part("small_book", RUST, book(0.81, 0.05, 2.47)),
        part("bowl", CHINA, turned_body([0.22, 0.75, 1.9], &bowl, 7)),
    ]
}

fn decoration() -> Vec<Part> {
    let front = |[x, y]: [f64; 2], [width, height]: [f64; 2]| {
        parallelogram(DVec3::new(x, y, 3.97), DVec3::Y * height, DVec3::X * width)
    };
    let (outer, inner) = (front([1.5, 1.3], [1.0, 0.7]), front([1.57, 1.37], [0.86, 0.56]));
    let bars = (0..4).map(|k| vec![outer[k], outer[(k + 1) % 4], inner[(k + 1) % 4], inner[k]]);
    let mut frame = open_box([1.5, 1.3, 3.97], [2.5, 2.0, 4.0], &[LOW_Z, HIGH_Z]);
    frame.extend(bars);
    let pot = [(0.14, 0.0), (0.19, 0.34), (0.0, 0.3)];
    let crown = [(0.0, 0.62), (0.28, 0.78), (0.34, 1.05), (0.2, 1.4), (0.0, 1.6)];
    let lamp = [(0.0, 0.0), (0.2, 0.07), (0.24, 0.2), (0.2, 0.33), (0.0, 0.4)];
    let trunk = [(0.025, 0.3), (0.025, 0.66)];
    let cord = [(0.01, 2.2), (0.01, 2.8)];
    let corner = [3.7, 0.0, 3.45];
    vec![
        part("frame", WALNUT, frame),
        part("picture_sky", MUSTARD, vec![front([1.57, 1.58], [0.86, 0.35])]),
        part("picture_field", SAGE, vec![front([1.57, 1.37], [0.86, 0.21])]),
        part("pot", CLAY, turned_body(corner, &pot, 6)),
        part("trunk", WALNUT, turned_body(corner, &trunk, 4)),
        part("crown", LEAF, turned_body(corner, &crown, 7)),
        part("lamp", PAPER_LAMP, turned_body([2.6, 1.8, 2.1], &lamp, 7)),
        part("cord", WALNUT, turned_body([2.6, 0.0, 2.1], &cord, 4)),
    ]
}

/// Returns a box without the faces `omitted`, which lie on another surface.
fn open_box(low: [f64; 3], high: [f64; 3], omitted: &[usize]) -> Vec<Vec<DVec3>> {
    let [low, high] = [low, high].map(DVec3::from_array);
    let mut faces = turned_box((low + high) / 2.0, high - low, 0.0);
    let mut places = 0..;
    faces.retain(|_| places.next().is_some_and(|k| !omitted.contains(&k)));
    faces
}

/// Returns the surface that a profile of (radius, height), from below upwards, makes about a vertical axis: a ring of
/// quads between two points of it, of triangles where a radius is 0.
fn turned_body(base: [f64; 3], profile: &[(f64, f64)], sides: u32) -> Vec<Vec<DVec3>> {
    let corner = |(radius, height): (f64, f64), k: u32| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
        DVec3::from_array(base) + DVec3::new(radius * sin, height, radius * cos)
    };
    let mut faces = Vec::new();
    for (ring, k) in profile.windows(2).flat_map(|ring| (0..sides).map(move |k| (ring, k))) {
        let [low, high] = [ring[0], ring[1]];
        let mut face = vec![corner(low, k), corner(low, k + 1), corner(high, k + 1), corner(high, k)];
        if high.0 == 0.0 {
            face.remove(2);
        } else if low.0 == 0.0 {
            face.remove(1);
        }
        faces.push(face);
    }
    faces
}
