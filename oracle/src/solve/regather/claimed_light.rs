//! The radiosity that a solution claims at every point of the scene, and sampling of points in proportion to
//! it.

use common::mesh::{Mesh, MeshFace, Texel};
use common::rays::Rays;
use common::scene::{Scene, Shape};
use common::shooting::RadiosityField;
use common::texel::{self, triangle_index};
use cpu::dense::open_area::open_shares;
use cpu::occlusion::occluders::Occluders;
use glam::{DVec3, Vec3};

/// Newton steps from a point of a quad to its u, v; each step squares the error, which starts at ½ at most.
const NEWTON_STEPS: usize = 5;

/// Smallest open share of a texel from which its reflected light leaves.
const MIN_OPEN_SHARE: f64 = 1e-3;

/// Share by which points are moved towards their texel's middle: far more than rounding, far less than the
/// distance over which light changes.
const EDGE_INSET: f32 = 1e-3;

/// The radiosity of a solution.
pub struct ClaimedLight<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    /// The texels in face order, within a face by index.
    order: Vec<usize>,
    /// Position of each face's first texel in `order`.
    first: Vec<usize>,
    /// True for texels that a body covers in part.
    partly_covered: Vec<bool>,
    /// Mean radiosity of the open part of each texel, W/m².
    radiosity: Vec<Vec3>,
    /// Sampling density of each texel, not normalised.
    density: Vec<f32>,
    outlines: Vec<SampledOutline>,
    /// Mean reflected radiosity ū, the control variate of gathering: in a white room it removes nearly all
    /// noise.
    pub mean_reflected: Vec3,
    /// Cumulative sum of density times area.
    cumulative_power: Vec<f64>,
}

/// A point drawn in proportion to its radiosity.
pub struct LightSample {
    /// Position in the mesh's unit.
    pub position: Vec3,
    /// Texel of the point.
    pub texel: usize,
}

impl<'a> ClaimedLight<'a> {
    /// Collects the light of `field`. Reflected light leaves from a texel's open share o only: u = E + (B − E)/o.
    pub fn new(scene: &'a Scene, mesh: &'a Mesh, field: &RadiosityField, rays: &Rays) -> Self {
        let open = open_shares(scene, mesh, &Occluders::new(scene, mesh), rays);
        let claimed = |k: usize| field.radiosity[k].truncate();
        let leaves = |k: usize| {
            let emission = mesh.texels[k].emission;
            emission + (claimed(k) - emission) / open[k].max(MIN_OPEN_SHARE) as f32
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
        let order = mesh.texels_in_face_order();
        let mut first = vec![0; mesh.faces.len()];
        for (place, k) in order.iter().enumerate().rev() {
            first[mesh.texels[*k].face as usize] = place;
        }
        let outline = |texel: &Texel| {
            let face = texel.face as usize;
            let resolution = mesh.faces[face].resolution;
            let outline = texel::texel_outline(&scene.faces[face], resolution, texel.index);
            SampledOutline::new(outline.padded_corners().map(|p| mesh.local_point(p).as_vec3()))
        };
        let outlines = mesh.texels.iter().map(outline).collect();
        Self {
            scene,
            mesh,
            order,
            first,
            partly_covered: open.iter().map(|share| *share < 1.0).collect(),
            radiosity,
            density,
            outlines,
            mean_reflected: mean_reflected(mesh, field),
            cumulative_power: passed,
        }
    }

    /// Power of all light, sum of channels; W in the mesh's unit.
    fn total_power(&self) -> f64 {
        self.cumulative_power.last().copied().unwrap_or(0.0)
    }

    /// Density with which [`Self::sample_point`] draws points of a texel; its integral over all faces is 1.
    pub fn sampling_density(&self, texel: usize) -> f32 {
        self.density[texel] / self.total_power() as f32
    }

    /// Mean of u over a texel.
    pub fn mean_radiosity(&self, texel: usize) -> Vec3 {
        self.radiosity[texel]
    }

    /// True if a body covers a part of a texel.
    pub fn is_partly_covered(&self, texel: usize) -> bool {
        self.partly_covered[texel]
    }

    /// Returns the texel that contains a point of a face.
    pub fn locate_point(&self, face: u32, point: Vec3) -> usize {
        let shape = self.scene.faces[face as usize].shape;
        let index = locate_texel(&self.mesh.faces[face as usize], shape, point);
        self.order[self.first[face as usize] + index as usize]
    }

    /// Maps u, v in 0…1 to a point of a texel; the map keeps ratios of areas.
    pub fn point_of_texel(&self, texel: usize, at: [f32; 2]) -> Vec3 {
        self.outlines[texel].point_at(at)
    }

    /// Moves a point of a texel away from the texel's edges, so that rounding does not put it behind another wall.
    pub fn inset_point(&self, texel: usize, point: Vec3) -> Vec3 {
        let middle = self.outlines[texel].corners.iter().sum::<Vec3>() / 4.0;
        point.lerp(middle, EDGE_INSET)
    }

    /// Draws a point in proportion to its radiosity, from three numbers in 0…1.
    pub fn sample_point(&self, [which, u, v]: [f32; 3]) -> LightSample {
        let wanted = f64::from(which) * self.total_power();
        let k = self.cumulative_power.partition_point(|passed| *passed <= wanted);
        let k = k.min(self.cumulative_power.len() - 1);
        LightSample {
            position: self.point_of_texel(k, [u, v]),
            texel: k,
        }
    }
}

/// A texel's corners in mesh units; a triangle repeats its third.
struct SampledOutline {
    corners: [Vec3; 4],
    /// Share of the area in the triangle of the first three corners.
    share: f32,
}

impl SampledOutline {
    fn new(corners: [Vec3; 4]) -> Self {
        let area = |p: Vec3, q: Vec3| (p - corners[0]).cross(q - corners[0]).length();
        let [one, other] = [1, 2].map(|k| area(corners[k], corners[k + 1]));
        let share = if other > 0.0 { one / (one + other) } else { 1.0 };
        Self { corners, share }
    }

    fn point_at(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (c, share) = (&self.corners, self.share);
        let (u, p, q) = if u < share {
            (u / share, c[1], c[2])
        } else {
            ((u - share) / (1.0 - share), c[2], c[3])
        };
        // The square root makes the density uniform over a triangle.
        c[0] + ((p - c[0]) * (1.0 - v) + (q - c[0]) * v) * u.sqrt()
    }
}

/// Returns the index of the texel that contains a point of the face.
fn locate_texel(face: &MeshFace, shape: Shape, point: Vec3) -> u32 {
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
    let steps = if skew == Vec3::ZERO { 1 } else { NEWTON_STEPS };
    for _ in 0..steps {
        let off = point - a - along * u - across * v - skew * (u * v);
        let (du, dv) = least_squares_coordinates(along + skew * v, across + skew * u, off);
        (u, v) = (u + du, v + dv);
    }
    let (i, j) = (step(u, w), step(v, h));
    if shape == Shape::Quad {
        return j * w + i;
    }
    // Rounding may put a point outside.
    let j = j.min(w - 1 - i);
    let upright = u * w as f32 - i as f32 + (v * h as f32 - j as f32) < 1.0 || i + j + 1 >= w;
    triangle_index(h, i, j, upright)
}

/// Solves `off` = x·p + y·q for x and y in the sense of least squares.
fn least_squares_coordinates(p: Vec3, q: Vec3, off: Vec3) -> (f32, f32) {
    let (pp, pq, qq) = (p.dot(p), p.dot(q), q.dot(q));
    let (x, y) = (off.dot(p), off.dot(q));
    let scale = pp * qq - pq * pq;
    if scale > 0.0 {
        ((qq * x - pq * y) / scale, (pp * y - pq * x) / scale)
    } else {
        (0.0, 0.0)
    }
}

fn mean_reflected(mesh: &Mesh, field: &RadiosityField) -> Vec3 {
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for (texel, b) in mesh.texels.iter().zip(&field.radiosity) {
        sum += (b.truncate() - texel.emission).as_dvec3() * f64::from(texel.area);
        area += f64::from(texel.area);
    }
    (sum / f64::max(area, f64::MIN_POSITIVE)).as_vec3()
}

/// Reflected radiosity ρH that the solution claims for texel `k`.
pub fn claimed_reflection(mesh: &Mesh, field: &RadiosityField, k: usize) -> DVec3 {
    let texel = &mesh.texels[k];
    texel.reflectance.as_dvec3() * field.irradiance[k].truncate().as_dvec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;

    /// Rows of sample points.
    const POINT_ROWS: usize = 128;

    fn faces() -> [Face; 3] {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.5 * x - y);
        let skew = [p(0.0, 0.0), p(4.0, 0.5), p(3.0, 2.0), p(0.5, 1.0)];
        // Side by side: a face under another front would exchange no light.
        let straight = [p(6.0, 0.0), p(10.0, 0.5), p(11.0, 2.0), p(7.0, 1.5)];
        let triangle = [p(12.0, 0.0), p(16.0, 0.5), p(13.0, 3.0)];
        [
            Face::quad("skew", skew, Vec3::ZERO, Vec3::ONE),
            Face::quad("straight", straight, Vec3::ZERO, Vec3::ONE),
            Face::triangle("triangle", triangle, Vec3::ZERO, Vec3::ONE),
        ]
    }

    #[test]
    fn sampled_points_lie_in_their_texel_with_uniform_density() {
        let scene = Scene {
            name: "faces".into(),
            faces: faces().into(),
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 7, 1).unwrap();
        for texel in &mesh.texels {
            let face = texel.face as usize;
            let (own, of) = (&mesh.faces[face], &scene.faces[face]);
            let outline = texel::texel_outline(of, own.resolution, texel.index);
            let corners = SampledOutline::new(outline.padded_corners().map(|p| mesh.local_point(p).as_vec3()));
            let mut mean = Vec3::ZERO;
            for s in 0..4 * POINT_ROWS {
                let uv = [(s / 4) as f32 / POINT_ROWS as f32, (s % 4) as f32 / 4.0];
                let uv = [uv[0] + 0.5 / POINT_ROWS as f32, uv[1] + 0.125];
                let p = corners.point_at(uv);
                assert_eq!(locate_texel(own, of.shape, p), texel.index, "{face} {uv:?}");
                mean += p / (4 * POINT_ROWS) as f32;
            }
            // Half a row may fall into the wrong one of the two triangles, whose centroids are at most 4/3
            // radii apart; the quadrature over rows of density √u is off by less than 1e-3.
            let bound = 4.0 / 3.0 * 0.5 / POINT_ROWS as f32 + 1e-3;
            let off = mean.distance(mesh.local_point(outline.centroid()).as_vec3());
            assert!(off < bound * own.texel_radius, "{face}: {off}");
        }
    }
}
