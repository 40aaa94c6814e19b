//! The Cornell box as measured at Cornell (mm): x runs to the left as the camera sees it, z into
//! the box. The front is open, blocks have no bottoms, and the left wall is 3.2 mm out of plane.

use super::{Material, Part, Scene, part};
use glam::DVec3;

/// Colours: the measured spectra under equal energy light, relative to a perfect white.
const WHITE: Material = Material::reflecting("white", [0.73797, 0.73616, 0.7372]);
const GREEN: Material = Material::reflecting("green", [0.08734, 0.3986, 0.08424]);
const RED: Material = Material::reflecting("red", [0.47491, 0.04507, 0.0491]);
const LIGHT: Material = Material {
    name: "light",
    reflectance: [0.78; 3],
    radiance: [20.7286, 10.8607, 2.77233],
};

type Quad = [[f64; 3]; 4];

const FLOOR: Quad = [
    [552.8, 0.0, 0.0],
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 559.2],
    [549.6, 0.0, 559.2],
];
const CEILING: Quad = [
    [556.0, 548.8, 0.0],
    [556.0, 548.8, 559.2],
    [0.0, 548.8, 559.2],
    [0.0, 548.8, 0.0],
];
const BACK: Quad = [
    [549.6, 0.0, 559.2],
    [0.0, 0.0, 559.2],
    [0.0, 548.8, 559.2],
    [556.0, 548.8, 559.2],
];
const RIGHT: Quad = [
    [0.0, 0.0, 559.2],
    [0.0, 0.0, 0.0],
    [0.0, 548.8, 0.0],
    [0.0, 548.8, 559.2],
];
const LEFT: Quad = [
    [552.8, 0.0, 0.0],
    [549.6, 0.0, 559.2],
    [556.0, 548.8, 559.2],
    [556.0, 548.8, 0.0],
];
/// Half a millimetre below the ceiling, in whose plane it was measured, so that it covers this part of it.
const LAMP: Quad = [
    [343.0, 548.3, 227.0],
    [343.0, 548.3, 332.0],
    [213.0, 548.3, 332.0],
    [213.0, 548.3, 227.0],
];

/// Tops of the blocks; sides go down to the floor.
const SHORT_BLOCK_TOP: Quad = [
    [130.0, 165.0, 65.0],
    [82.0, 165.0, 225.0],
    [240.0, 165.0, 272.0],
    [290.0, 165.0, 114.0],
];
const TALL_BLOCK_TOP: Quad = [
    [423.0, 330.0, 247.0],
    [265.0, 330.0, 296.0],
    [314.0, 330.0, 456.0],
    [472.0, 330.0, 406.0],
];

pub fn scenes() -> Vec<Scene> {
    let walls: [(&str, Material, Quad); 6] = [
        ("floor", WHITE, FLOOR),
        ("light", LIGHT, LAMP),
        ("ceiling", WHITE, CEILING),
        ("back_wall", WHITE, BACK),
        ("right_wall", GREEN, RIGHT),
        ("left_wall", RED, LEFT),
    ];
    let mut parts: Vec<Part> = walls
        .map(|(name, material, wall)| part(name, material, vec![quad_corners(wall)]))
        .into();
    parts.push(part("short_block", WHITE, block_faces(SHORT_BLOCK_TOP)));
    parts.push(part("tall_block", WHITE, block_faces(TALL_BLOCK_TOP)));
    vec![Scene {
        name: "cornell_box",
        about: "The Cornell box as measured, in mm; the light is 0.5 mm lower.",
        parts,
    }]
}

fn quad_corners(quad: Quad) -> Vec<DVec3> {
    quad.map(DVec3::from_array).into()
}

/// Returns the top and the four sides under it.
fn block_faces(top: Quad) -> Vec<Vec<DVec3>> {
    let top = quad_corners(top);
    let down = |p: DVec3| DVec3::new(p.x, 0.0, p.z);
    let sides = (0..4).map(|k| {
        let (a, b) = (top[k], top[(k + 3) % 4]);
        vec![down(a), a, b, down(b)]
    });
    std::iter::once(top.clone()).chain(sides).collect()
}
