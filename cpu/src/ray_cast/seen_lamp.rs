//! A lamp as a point sees it, and points of it that are drawn: evenly over its solid angle where it is near, since
//! points drawn over its area would bring very different light; over its area where it is far.

use common::mesh::MeshFace;
use common::texel_point::SampledOutline;
use glam::Vec3;
use std::f32::consts::PI;

/// Area of a lamp over its squared distance from which on its solid angle is drawn from.
const MIN_NEAR_AREA: f32 = 0.05;
/// Least solid angle that is drawn from, sr: in less the spherical excess has too few digits.
const MIN_SOLID_ANGLE: f32 = 2e-3;

/// A lamp seen from a point.
pub struct SeenLamp {
    /// The corners, from the point; a triangle repeats its third.
    corners: [Vec3; 4],
    /// Its normal.
    pub normal: Vec3,
    area: f32,
    /// Solid angles of the triangles of corners 0, 1, 2 and 0, 2, 3 where the lamp is near.
    solid_angles: Option<[f32; 2]>,
}

impl SeenLamp {
    /// Makes the lamp `face`, seen from `point`.
    pub fn new(face: &MeshFace, point: Vec3) -> Self {
        let corners = face.corners.map(|c| c - point);
        let [a, b, c, d] = corners;
        let area = 0.5 * (c - a).cross(d - b).length();
        let square = ((a + b + c + d) / 4.0).length_squared();
        let solid_angles = (area > MIN_NEAR_AREA * square).then(|| [[a, b, c], [a, c, d]].map(solid_angle));
        Self {
            corners,
            normal: face.normal,
            area,
            solid_angles: solid_angles.filter(|[one, other]| one + other > MIN_SOLID_ANGLE),
        }
    }

    /// Returns the vector from the point to a point of the lamp, for (u, v) in the unit square.
    pub fn draw_ray(&self, [u, v]: [f32; 2]) -> Vec3 {
        let Some([one, other]) = self.solid_angles else {
            return SampledOutline::new(self.corners).point_at([u, v]);
        };
        let [a, b, c, d] = self.corners;
        let share = one / (one + other);
        let (triangle, u) = match u < share {
            true => ([a, b, c], u / share),
            false => ([a, c, d], (u - share) / (1.0 - share)),
        };
        let direction = draw_direction(triangle, [u, v]);
        direction * (a.dot(self.normal) / direction.dot(self.normal))
    }

    /// Returns the density of [`Self::draw_ray`] over directions, 1/sr, at a `ray` to a point of the lamp.
    pub fn direction_density(&self, ray: Vec3) -> f32 {
        if let Some([one, other]) = self.solid_angles {
            return 1.0 / (one + other);
        }
        let square = ray.length_squared();
        let sent = -self.normal.dot(ray) / square.sqrt();
        square / (sent * self.area)
    }
}

/// Returns the solid angle of a triangle seen from the origin (Van Oosterom & Strackee 1983).
fn solid_angle(triangle: [Vec3; 3]) -> f32 {
    let [a, b, c] = triangle.map(Vec3::normalize_or_zero);
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Draws a direction evenly over the solid angle of a triangle seen from the origin (Arvo 1995).
fn draw_direction(triangle: [Vec3; 3], [u, v]: [f32; 2]) -> Vec3 {
    let [a, b, c] = triangle.map(Vec3::normalize_or_zero);
    let [ab, bc, ca] = [a.cross(b), b.cross(c), c.cross(a)].map(Vec3::normalize_or_zero);
    let [alpha, beta, gamma] = [(ab, ca), (bc, ab), (ca, bc)].map(|(p, q)| p.angle_between(-q));
    // The part of the triangle at the corner a with the share u of its area.
    let (sin_sum, cos_sum) = (PI + u * (alpha + beta + gamma - PI)).sin_cos();
    let (sin_alpha, cos_alpha) = alpha.sin_cos();
    let sin_phi = sin_sum * cos_alpha - cos_sum * sin_alpha;
    let cos_phi = cos_sum * cos_alpha + sin_sum * sin_alpha;
    let p = cos_phi + cos_alpha;
    let q = sin_phi - sin_alpha * a.dot(b);
    let cosine = (q + (q * cos_phi - p * sin_phi) * cos_alpha) / ((q * sin_phi + p * cos_phi) * sin_alpha);
    let turn_to = |from: Vec3, to: Vec3, cosine: f32| {
        let across = (to - from * from.dot(to)).normalize_or_zero();
        from * cosine + across * (1.0 - cosine * cosine).max(0.0).sqrt()
    };
    // A triangle that is seen edge-on has no angle: its cosine is not a number.
    let cosine = if cosine.is_nan() { 1.0 } else { cosine.clamp(-1.0, 1.0) };
    let corner = turn_to(a, c, cosine);
    turn_to(b, corner, 1.0 - v * (1.0 - corner.dot(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::mesh::Mesh;
    use common::scene::{Face, Scene};
    use glam::{DVec3, Vec3};

    /// Points drawn per side of a square of numbers.
    const SIDE: u32 = 256;

    /// A quad, skewed in its plane, whose normal is +z, and a triangle beside it.
    fn lamps() -> Mesh {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let faces = vec![
            Face::quad(
                "",
                [p(0., 0.), p(1., 0.1), p(0.8, 0.9), p(0.1, 0.6)],
                Vec3::ONE,
                Vec3::ZERO,
            ),
            Face::triangle("", [p(2., 0.), p(3., 0.2), p(2.2, 1.)], Vec3::ONE, Vec3::ZERO),
        ];
        let scene = Scene {
            faces,
            ..Scene::default()
        };
        Mesh::uniform(&scene, 1, 1).unwrap()
    }

    /// The mean of cos/density over drawn points is the projected solid angle, which Lambert's sum over edges gives.
    #[test]
    fn rays_drawn_to_a_lamp_bring_its_exact_irradiance() {
        let mesh = lamps();
        for (face, height) in mesh.faces.iter().flat_map(|f| [0.02, 0.3, 1.0, 20.0].map(|h| (f, h))) {
            let point = face.corners[0].lerp(face.corners[2], 0.4) + face.normal * height * face.texel_radius;
            let lamp = SeenLamp::new(face, point);
            assert_eq!(lamp.solid_angles.is_some(), height < 10.0, "{height}");
            let mut mean = 0.0f64;
            for k in 0..SIDE * SIDE {
                let uv = [k / SIDE, k % SIDE].map(|x| (x as f32 + 0.5) / SIDE as f32);
                let ray = lamp.draw_ray(uv);
                assert!((ray + point - face.corners[0]).dot(face.normal).abs() < 1e-5 * ray.length());
                mean +=
                    f64::from(-ray.normalize().dot(face.normal) / lamp.direction_density(ray)) / f64::from(SIDE * SIDE);
            }
            let [a, b, c, d] = lamp.corners.map(Vec3::as_dvec3);
            let edge = |p: DVec3, q: DVec3| match p.cross(q).try_normalize() {
                Some(across) => across * p.angle_between(q),
                None => DVec3::ZERO,
            };
            let edges = [edge(a, b), edge(b, c), edge(c, d), edge(d, a)];
            let exact = 0.5 * edges.iter().sum::<DVec3>().dot(face.normal.as_dvec3()).abs();
            // The midpoint rule is off by 0.7 % with 64 points a side, since the map is steep at corners, and by less with more.
            assert!((mean / exact - 1.0).abs() < 3e-3, "{mean} for {exact} at {height}");
        }
    }
}
