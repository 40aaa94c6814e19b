//! Pairs of faces whose form factor is known exactly.

use crate::named_scene;
use common::mesh::Mesh;
use common::scene::Face;
use glam::{DVec3, Vec3};
use oracle::exact;

/// Two faces and the exact factor from the first to the second.
pub struct FactorCase {
    /// For messages.
    pub name: String,
    /// Shooter.
    pub from: Face,
    /// Receiver.
    pub to: Face,
    /// F.
    pub exact: f64,
    /// True if the faces share an edge: F jumps at its ends, and the extent of patches matters near it.
    pub touching: bool,
}

impl FactorCase {
    /// Makes a case from one outline to another.
    pub fn new(name: &str, from: &[DVec3], to: &[DVec3], exact: f64) -> Self {
        let face = |c: &[DVec3]| match *c {
            [a, b, c] => Face::triangle("", [a, b, c], Vec3::ZERO, Vec3::ZERO),
            [a, b, c, d] => Face::quad("", [a, b, c, d], Vec3::ZERO, Vec3::ZERO),
            _ => unreachable!("a face has three or four corners"),
        };
        let touching = from.iter().any(|p| to.contains(p));
        Self {
            name: name.to_owned(),
            from: face(from),
            to: face(to),
            exact,
            touching,
        }
    }

    /// Returns the pair in the other direction, by reciprocity.
    pub fn reverse_pair(&self) -> Self {
        Self {
            name: format!("{}, reversed", self.name),
            from: self.to.clone(),
            to: self.from.clone(),
            exact: self.exact * self.from.area() / self.to.area(),
            touching: self.touching,
        }
    }

    /// Meshes the pair: K×K patches shoot at N×N texels.
    pub fn pair_mesh(&self, patches: u32, texels: u32) -> Mesh {
        let pair = named_scene(&self.name, vec![self.from.clone(), self.to.clone()]);
        Mesh::new(&pair, &[[patches, patches], [texels, texels]], patches).unwrap()
    }
}

/// Makes a parallelogram from `corner` along `u` and `v`; its front is u × v.
pub fn rectangle(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [DVec3; 4] {
    let [c, u, v] = [corner, u, v].map(DVec3::from);
    [c, c + u, c + u + v, c + v]
}

/// Returns every closed form of the reference, in both directions.
pub fn factor_cases() -> Vec<FactorCase> {
    let mut cases = Vec::new();
    let mut add = |name: &str, from: &[DVec3], to: &[DVec3], exact| {
        let case = FactorCase::new(name, from, to, exact);
        cases.extend([case.reverse_pair(), case]);
    };
    let floor = rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let above = |x: f64| rectangle([x, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    add("facing unit squares", &floor, &above(0.0), 0.1998248957);
    add("2 sideways", &floor, &above(2.0), 0.0152754501);
    let far = rectangle([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let high = rectangle([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    add("floor x in 1..2, wall z in 1..2", &far, &high, 0.0329381623);
    let legs = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let [a, b, c] = legs.map(|p| p + DVec3::Z);
    add("facing triangles", &legs, &[a, c, b], 0.1150492281);
    // The first two are printed in the reference, to four digits; the others are chosen here.
    for (a, b, c) in [(1.0, 1.5, 0.5), (0.1, 0.1, 0.05), (3.0, 0.5, 2.0), (40.0, 30.0, 50.0)] {
        let low = rectangle([0.0; 3], [a, 0.0, 0.0], [0.0, b, 0.0]);
        let high = rectangle([0.0, 0.0, c], [0.0, b, 0.0], [a, 0.0, 0.0]);
        let exact = exact::parallel_rectangles(a, b, c);
        add(&format!("{a}×{b} at {c}"), &low, &high, exact);
    }
    for (l, w, h) in [(1.0, 1.0, 1.0), (1.0, 2.0, 0.5), (5.0, 4.0, 3.0)] {
        let low = rectangle([0.0; 3], [w, 0.0, 0.0], [0.0, l, 0.0]);
        let wall = rectangle([0.0; 3], [0.0, l, 0.0], [0.0, 0.0, h]);
        let exact = exact::perpendicular_rectangles(l, w, h);
        add(&format!("perpendicular {w} and {h}, edge {l}"), &low, &wall, exact);
    }
    for (degrees, exact) in [
        (30.0, 0.6190283231),
        (45.0, 0.4833476955),
        (60.0, 0.3709053212),
        (120.0, 0.0866150011),
        (135.0, 0.0483094478),
        (150.0, 0.0213453254),
    ] {
        let (s, c) = f64::to_radians(degrees).sin_cos();
        let leaf = rectangle([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s]);
        add(&format!("hinge {degrees}°"), &floor, &leaf, exact);
    }
    cases
}
