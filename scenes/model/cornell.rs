//! The Cornell box as measured at Cornell (mm): x runs to the left as the camera sees it, z into
//! the box. The front is open, blocks have no bottoms, and the left wall is 3.2 mm out of plane.

use super::{Material, Scene, part};
use glam::DVec3;

/// Colours: the measured spectra under equal energy light, relative to a perfect white.
const WHITE: Material = Material::reflecting("white", [0.73797, 0.73616, 0.7372]);
const GREEN: Material = Material::reflecting("green", [0.08734, 0.3986, 0.08424]);
const RED: Material = Material::reflecting("red", [0.47491, 0.04507, 0.0491]);
const LIGHT: Material = Material::emitting("light", [0.78; 3], [20.7286, 10.8607, 2.77233]);

/// Names, materials and four corners of the walls. The light lies half a millimetre below the ceiling, in whose plane
/// it was measured, so that it covers this part of it.
const WALLS: [(&str, Material, &str); 6] = [
    ("floor", WHITE, "552.8 0 0, 0 0 0, 0 0 559.2, 549.6 0 559.2"),
    (
        "light",
        LIGHT,
        "343 548.3 227, 343 548.3 332, 213 548.3 332, 213 548.3 227",
    ),
    (
        "ceiling",
        WHITE,
        "556 548.8 0, 556 548.8 559.2, 0 548.8 559.2, 0 548.8 0",
    ),
    (
        "back_wall",
        WHITE,
        "549.6 0 559.2, 0 0 559.2, 0 548.8 559.2, 556 548.8 559.2",
    ),
    ("right_wall", GREEN, "0 0 559.2, 0 0 0, 0 548.8 0, 0 548.8 559.2"),
    (
        "left_wall",
        RED,
        "552.8 0 0, 549.6 0 559.2, 556 548.8 559.2, 556 548.8 0",
    ),
];

/// Tops of the blocks; sides go down to the floor.
const BLOCK_TOPS: [(&str, &str); 2] = [
    ("short_block", "130 165 65, 82 165 225, 240 165 272, 290 165 114"),
    ("tall_block", "423 330 247, 265 330 296, 314 330 456, 472 330 406"),
];

pub fn scenes() -> Vec<Scene> {
    let walls = WALLS.map(|(name, material, corners)| part(name, material, vec![parse_corners(corners)]));
    let blocks = BLOCK_TOPS.map(|(name, top)| part(name, WHITE, block_faces(&parse_corners(top))));
    vec![Scene {
        name: "cornell_box",
        about: "The Cornell box as measured, in mm; the light is 0.5 mm lower.",
        parts: walls.into_iter().chain(blocks).collect(),
    }]
}

fn parse_corners(corners: &str) -> Vec<DVec3> {
    let number = |word: &str| word.parse().expect("a number");
    let corner = |words: &str| DVec3::from_slice(&words.split_whitespace().map(number).collect::<Vec<f64>>());
    corners.split(',').map(corner).collect()
}

/// Returns the top and the four sides under it.
fn block_faces(top: &[DVec3]) -> Vec<Vec<DVec3>> {
    let down = |p: DVec3| DVec3::new(p.x, 0.0, p.z);
    let sides = (0..4).map(|k| {
        let (a, b) = (top[k], top[(k + 3) % 4]);
        vec![down(a), a, b, down(b)]
    });
    std::iter::once(top.to_vec()).chain(sides).collect()
}
