//! How much light every point of the scene gives off, according to the answer, and how to draw points
//! in proportion to it.

use super::slope::Slope;
use common::mesh::{Mesh, MeshFace, Texel};
use common::rays::Rays;
use common::scene::{Scene, Shape};
use common::shooting::Field;
use common::texel::{self, triangle_index};
use cpu::matrix::open::shares;
use cpu::occlusion::occluders::Occluders;
use glam::{DVec3, Vec2, Vec3};

/// Newton's steps from a point of a quad to its u, v: the error squares with each, from 1/2 at most.
const STEPS: usize = 5;

/// What is reflected leaves from no less than this share of a texel.
const LEAST: f64 = 1e-3;

/// Points are moved by this share of their way to the middle: far more than rounding, far less than
/// light changes over.
const INSET: f32 = 1e-3;

/// The answer's radiosity.
pub struct Light<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    /// The texels face by face, in each by their index.
    order: Vec<usize>,
    /// The first of each face in `order`.
    first: Vec<usize>,
    /// Whether a body stands on some of each texel.
    cut: Vec<bool>,
    /// What leaves the open part of each texel, W/m², its mean.
    radiosity: Vec<Vec3>,
    /// How densely points of each texel are drawn.
    density: Vec<f32>,
    /// How it changes within the texel.
    slopes: Vec<Slope>,
    outlines: Vec<Outline>,
    /// The mean of what is reflected. Rays that meet a front bring that much for certain: in a white
    /// room, where least is lost, no noise is left of it.
    pub flat: Vec3,
    /// The densities times the area, added up over the texels before.
    passed: Vec<f64>,
}

/// A point that was drawn.
pub struct Drawn {
    /// Where.
    pub position: Vec3,
    /// Its texel.
    pub texel: usize,
}

impl<'a> Light<'a> {
    /// What a texel reflects leaves from its open part: u = E + (B − E)/o.
    pub fn new(scene: &'a Scene, mesh: &'a Mesh, field: &Field, rays: &Rays) -> Self {
        let open = shares(scene, mesh, &Occluders::new(scene, mesh), rays);
        let claimed = |k: usize| field.radiosity[k].truncate();
        let leaves = |k: usize| {
            let emission = mesh.texels[k].emission;
            emission + (claimed(k) - emission) / open[k].max(LEAST) as f32
        };
        let texels = 0..mesh.texels.len();
        let radiosity: Vec<Vec3> = texels.clone().map(leaves).collect();
        let density: Vec<f32> = texels.map(|k| claimed(k).abs().element_sum()).collect();
        let mut sum = 0.0;
        let power = density.iter().zip(&mesh.texels).map(|(density, texel)| {
            sum += f64::from(density * texel.area);
            sum
        });
        let passed = power.collect();
        let order = mesh.in_face_order();
        let mut first = vec![0; mesh.faces.len()];
        for (place, k) in order.iter().enumerate().rev() {
            first[mesh.texels[*k].face as usize] = place;
        }
        // A texel on which nothing falls lies under a body, or in a gap, and tells nothing of others.
        let lit = |k: usize| field.irradiance[k].truncate() != Vec3::ZERO && open[k] == 1.0;
        let slope = |(k, texel): (usize, &Texel)| {
            let face = texel.face as usize;
            let own = radiosity[k];
            if !lit(k) {
                return Slope::default();
            }
            Slope::new(texel, mesh.faces[face].resolution, own, |index| {
                let other = order[first[face] + index as usize];
                lit(other).then(|| radiosity[other])
            })
        };
        let slopes = mesh.texels.iter().enumerate().map(slope).collect();
        let outline = |texel: &Texel| {
            let face = texel.face as usize;
            let resolution = mesh.faces[face].resolution;
            let outline = texel::outline(&scene.faces[face], resolution, texel.index);
            Outline::new(outline.padded().map(|p| mesh.local(p).as_vec3()))
        };
        let outlines = mesh.texels.iter().map(outline).collect();
        Self {
            scene,
            mesh,
            order,
            first,
            cut: open.iter().map(|share| *share < 1.0).collect(),
            radiosity,
            density,
            slopes,
            outlines,
            flat: mean(mesh, field),
            passed,
        }
    }

    /// The power of all light, channels added up; W in the mesh's unit.
    fn power(&self) -> f64 {
        self.passed.last().copied().unwrap_or(0.0)
    }

    /// How densely [`Self::draw`] draws points of a texel, of 1 over all faces.
    pub fn density(&self, texel: usize) -> f32 {
        self.density[texel] / self.power() as f32
    }

    /// The mean of u over a texel.
    pub fn of(&self, texel: usize) -> Vec3 {
        self.radiosity[texel]
    }

    /// Whether a body stands on some of a texel.
    pub fn cut(&self, texel: usize) -> bool {
        self.cut[texel]
    }

    /// The texel that holds a point of a face, and what its slope makes of u there.
    pub fn at(&self, face: u32, point: Vec3) -> (usize, Vec3) {
        let own = &self.mesh.faces[face as usize];
        let (index, place) = index(own, self.shape(face), point);
        let k = self.order[self.first[face as usize] + index as usize];
        let kind = self.mesh.texels[k].kind;
        (k, self.slopes[k].at(kind, place))
    }

    fn shape(&self, face: u32) -> Shape {
        self.scene.faces[face as usize].shape
    }

    /// A point of a texel at u, v in 0…1: equal areas to equal areas.
    pub fn spread(&self, texel: usize, at: [f32; 2]) -> Vec3 {
        self.outlines[texel].spread(at)
    }

    /// A point of a texel, moved away from its edges as far as it takes that rounding does not lay it
    /// behind another wall.
    pub fn inside(&self, texel: usize, point: Vec3) -> Vec3 {
        let middle = self.outlines[texel].corners.iter().sum::<Vec3>() / 4.0;
        point.lerp(middle, INSET)
    }

    /// A point of all that shine, as dense as its radiosity, by three numbers in 0…1.
    pub fn draw(&self, [which, u, v]: [f32; 3]) -> Drawn {
        let wanted = f64::from(which) * self.power();
        let k = self.passed.partition_point(|passed| *passed <= wanted);
        let k = k.min(self.passed.len() - 1);
        Drawn {
            position: self.spread(k, [u, v]),
            texel: k,
        }
    }
}

/// A texel's corners, a triangle repeats its third, in mesh units.
struct Outline {
    corners: [Vec3; 4],
    /// The first three corners' share of the area.
    share: f32,
}

impl Outline {
    fn new(corners: [Vec3; 4]) -> Self {
        let area = |p: Vec3, q: Vec3| (p - corners[0]).cross(q - corners[0]).length();
        let [one, other] = [1, 2].map(|k| area(corners[k], corners[k + 1]));
        let share = if other > 0.0 {
            one / (one + other)
        } else {
            1.0
        };
        Self { corners, share }
    }

    fn spread(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (c, share) = (&self.corners, self.share);
        let (u, p, q) = if u < share {
            (u / share, c[1], c[2])
        } else {
            ((u - share) / (1.0 - share), c[2], c[3])
        };
        // The root makes a triangle's rows equally dense.
        c[0] + ((p - c[0]) * (1.0 - v) + (q - c[0]) * v) * u.sqrt()
    }
}

/// The texel that holds a point of the face, and where in it, from its lower corner on the lattice.
fn index(face: &MeshFace, shape: Shape, point: Vec3) -> (u32, Vec2) {
    let [w, h] = face.resolution;
    let [a, b, c, d] = face.corners;
    let step = |x: f32, n: u32| ((x.max(0.0) * n as f32) as u32).min(n - 1);
    let (along, across) = (b - a, if shape == Shape::Quad { d - a } else { c - a });
    let skew = if shape == Shape::Quad {
        a - b + c - d
    } else {
        Vec3::ZERO
    };
    let (mut u, mut v) = (0.5, 0.5);
    let steps = if skew == Vec3::ZERO { 1 } else { STEPS };
    for _ in 0..steps {
        let off = point - a - along * u - across * v - skew * (u * v);
        let (du, dv) = coordinates(along + skew * v, across + skew * u, off);
        (u, v) = (u + du, v + dv);
    }
    if shape == Shape::Quad {
        let (i, j) = (step(u, w), step(v, h));
        let place = Vec2::new(u * w as f32 - i as f32, v * h as f32 - j as f32);
        return (j * w + i, place);
    }
    let (i, mut j) = (step(u, w), step(v, h));
    // A point outside by rounding.
    j = j.min(w - 1 - i);
    let (x, y) = (u * w as f32 - i as f32, v * h as f32 - j as f32);
    let upright = x + y < 1.0 || i + j + 1 >= w;
    (triangle_index(h, i, j, upright), Vec2::new(x, y))
}

/// x and y of `off` = x·p + y·q, in the least squares' sense.
fn coordinates(p: Vec3, q: Vec3, off: Vec3) -> (f32, f32) {
    let (pp, pq, qq) = (p.dot(p), p.dot(q), q.dot(q));
    let (x, y) = (off.dot(p), off.dot(q));
    let scale = pp * qq - pq * pq;
    if scale > 0.0 {
        ((qq * x - pq * y) / scale, (pp * y - pq * x) / scale)
    } else {
        (0.0, 0.0)
    }
}

fn mean(mesh: &Mesh, field: &Field) -> Vec3 {
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for (texel, b) in mesh.texels.iter().zip(&field.radiosity) {
        sum += (b.truncate() - texel.emission).as_dvec3() * f64::from(texel.area);
        area += f64::from(texel.area);
    }
    (sum / f64::max(area, f64::MIN_POSITIVE)).as_vec3()
}

/// B − E as the answer claims it.
pub fn reflected(mesh: &Mesh, field: &Field, k: usize) -> DVec3 {
    let texel = &mesh.texels[k];
    texel.reflectance.as_dvec3() * field.irradiance[k].truncate().as_dvec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;

    /// Rows of points.
    const ROWS: usize = 128;

    fn faces() -> [Face; 3] {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.5 * x - y);
        let skew = [p(0.0, 0.0), p(4.0, 0.5), p(3.0, 2.0), p(0.5, 1.0)];
        // Beside each other: what lies under another front gives and takes nothing.
        let straight = [p(6.0, 0.0), p(10.0, 0.5), p(11.0, 2.0), p(7.0, 1.5)];
        let triangle = [p(12.0, 0.0), p(16.0, 0.5), p(13.0, 3.0)];
        [
            Face::quad("skew", skew, Vec3::ZERO, Vec3::ONE),
            Face::quad("straight", straight, Vec3::ZERO, Vec3::ONE),
            Face::triangle("triangle", triangle, Vec3::ZERO, Vec3::ONE),
        ]
    }

    #[test]
    fn a_point_finds_its_texel_and_points_are_spread_by_area() {
        let scene = Scene {
            name: "faces".into(),
            faces: faces().into(),
            notes: Vec::new(),
        };
        let mesh = Mesh::uniform(&scene, 7, 1).unwrap();
        for texel in &mesh.texels {
            let face = texel.face as usize;
            let (own, of) = (&mesh.faces[face], &scene.faces[face]);
            let outline = texel::outline(of, own.resolution, texel.index);
            let corners = Outline::new(outline.padded().map(|p| mesh.local(p).as_vec3()));
            let mut mean = Vec3::ZERO;
            for s in 0..4 * ROWS {
                let uv = [(s / 4) as f32 / ROWS as f32, (s % 4) as f32 / 4.0];
                let uv = [uv[0] + 0.5 / ROWS as f32, uv[1] + 0.125];
                let p = corners.spread(uv);
                assert_eq!(index(own, of.shape, p).0, texel.index, "{face} {uv:?}");
                mean += p / (4 * ROWS) as f32;
            }
            // Half a row may go to the wrong one of the two triangles, whose centroids are at most 4/3
            // radii apart; the rule of rows of density √u is off by less than 1e-3.
            let bound = 4.0 / 3.0 * 0.5 / ROWS as f32 + 1e-3;
            let off = mean.distance(mesh.local(outline.centroid()).as_vec3());
            assert!(off < bound * own.texel_radius, "{face}: {off}");
        }
    }
}
