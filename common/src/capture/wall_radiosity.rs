//! Resamples a panorama's pixels to the texels of the walls around its eye.
//!
//! A pixel is a spherical polygon. It is cut along the lines of the texel grid, which are great circles as seen from
//! the eye, and its exact solid angle is shared among the texels in proportion to the pieces. A texel's radiance is L
//! = Σ L Δω / Σ Δω, weighted by solid angle *as seen from the eye*. A texel thus sends the eye the same light as the
//! pixels that it covers. The sphere's total is kept, and the irradiance at the eye up to the change of cos θ within
//! a texel. Weighting by area on the wall would favour the parts that are far away or seen at a grazing angle, where
//! few pixels cover much wall.
//!
//! There is no sampling and no noise. Pixels are processed in a fixed order on one thread, so the result
//! is bitwise reproducible. Memory is 44 bytes per texel.

use super::panorama::Panorama;
use super::projection::MapProjection;
use crate::error::{Error, Result};
use crate::scene::{Face, Scene, Shape};
use crate::texel;
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::PI;

/// Parts per row into which the pixels of a lat-long or angular map are cut, at least. The arcs that bound
/// the parts are then straight to 1e-5 rad (a cube map's are great circles anyway).
const MIN_PARTS_PER_ROW: usize = 512;

/// Computes the radiosity B = πL (W/m²) of every texel of `scene` as `panorama` shows it from `eye`.
///
/// `scene` is a closed convex room of parallelograms whose fronts face the eye, such as
/// [`super::room::box_room`] makes; `resolutions` are its faces' texels W×H. The result lists the texels face
/// after face, within a face row-major in its rectangle as in [`crate::solution::StoredSolution`].
///
/// Errors ([`Error::Usage`]): another number of resolutions than of faces, a face without texels or
/// that is no parallelogram, an eye outside the room or on a wall.
pub fn texel_radiosity(panorama: &Panorama, scene: &Scene, resolutions: &[[u32; 2]], eye: DVec3) -> Result<Vec<Vec3>> {
    if scene.faces.len() != resolutions.len() {
        return Err(Error::Usage("each face needs its number of texels".into()));
    }
    let mut walls = Vec::new();
    let mut count = 0;
    for (face, resolution) in scene.faces.iter().zip(resolutions) {
        walls.push(Wall::new(face, *resolution, eye, count)?);
        count += texel::texel_count(*resolution) as usize;
    }
    let mut sums = vec![(DVec3::ZERO, 0.0); count];
    let mut shares = Vec::new();
    for (pixel, radiance, solid_angle) in panorama.captured_pixels() {
        shares.clear();
        distribute_pixel(panorama, pixel, &walls, &mut shares);
        let whole: f64 = shares.iter().map(|(_, part)| part).sum();
        if whole <= 0.0 {
            continue;
        }
        for (texel, part) in &shares {
            let weight = solid_angle * (part / whole);
            let (sum, weights) = &mut sums[*texel];
            *sum += radiance.as_dvec3() * weight;
            *weights += weight;
        }
    }
    let mut radiosity = Vec::with_capacity(count);
    for (wall, face) in walls.iter().zip(&scene.faces) {
        for index in 0..wall.size[0] * wall.size[1] {
            let (sum, weights) = sums[wall.first + index];
            let radiance = if weights > 0.0 {
                sum / weights
            } else {
                // The texel is too small, or seen too flat, for any part of a pixel to lie on it.
                let centre = texel::texel_outline(face, wall.size.map(|n| n as u32), index as u32).centroid();
                panorama.radiance(centre - eye).as_dvec3()
            };
            radiosity.push((radiance * PI).as_vec3());
        }
    }
    Ok(radiosity)
}

/// A face as seen from the eye.
struct Wall {
    /// Index of the face's first texel.
    first: usize,
    /// Texels W×H.
    size: [usize; 2],
    /// For a direction d, depth·d > 0 in front of the eye, u = along[0]·d / depth·d and v = along[1]·d / depth·d.
    depth: DVec3,
    along: [DVec3; 2],
}

impl Wall {
    fn new(face: &Face, [w, h]: [u32; 2], eye: DVec3, first: usize) -> Result<Self> {
        let fail = |why: &str| Error::Usage(format!("face {}: {why}", face.name));
        let [a, b, c, d] = face.corners;
        let (s, t) = (b - a, d - a);
        let normal = s.cross(t);
        let size = s.length() + t.length();
        if face.shape != Shape::Quad || (c - b - t).length() > 1e-9 * size || normal == DVec3::ZERO {
            return Err(fail("a captured room has parallelograms only"));
        }
        if w == 0 || h == 0 {
            return Err(fail("has no texels"));
        }
        let from = eye - a;
        let height = normal.dot(from);
        if height.is_nan() || height <= 0.0 {
            return Err(fail("the eye must lie in front of it"));
        }
        // The dual basis: dual[k] · (x − a) is the point's coordinate k.
        let square = normal.length_squared();
        let dual = [t.cross(normal) / square, normal.cross(s) / square];
        // The ray meets the plane after height / depth·d, depth = −normal.
        let depth = -normal;
        Ok(Self {
            first,
            size: [w as usize, h as usize],
            depth,
            along: dual.map(|g| depth * g.dot(from) + g * height),
        })
    }

    /// Returns coordinates in texels of the point in direction `d`, which must have a depth above 0.
    fn texel_coordinates(&self, d: DVec3) -> DVec2 {
        let depth = self.depth.dot(d);
        let [w, h] = self.size.map(|n| n as f64);
        DVec2::new(self.along[0].dot(d) / depth * w, self.along[1].dot(d) / depth * h)
    }

    /// Returns the normal of the plane through the eye and line `k` of the grid, towards larger coordinates.
    fn grid_plane(&self, axis: usize, k: usize) -> DVec3 {
        self.along[axis] - self.depth * (k as f64 / self.size[axis] as f64)
    }

    /// Returns the column and row hit by direction `d`, if it hits the wall.
    fn texel_in_direction(&self, d: DVec3) -> Option<[usize; 2]> {
        if self.depth.dot(d) <= 0.0 {
            return None;
        }
        let at = self.texel_coordinates(d);
        let [w, h] = self.size.map(|n| n as f64);
        (at.x >= 0.0 && at.y >= 0.0 && at.x < w && at.y < h).then_some([at.x as usize, at.y as usize])
    }

    /// Returns the part of `polygon` on column (or row) `k`.
    fn cut_strip(&self, polygon: &[DVec3], axis: usize, k: usize) -> Vec<DVec3> {
        let above = cut_by_plane(polygon, self.grid_plane(axis, k));
        cut_by_plane(&above, -self.grid_plane(axis, k + 1))
    }

    /// Returns the columns (or rows) touched by a polygon within the wall.
    fn touched_range(&self, polygon: &[DVec3], axis: usize) -> std::ops::RangeInclusive<usize> {
        let last = self.size[axis] - 1;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in polygon {
            let at = self.texel_coordinates(*corner)[axis];
            (low, high) = (low.min(at), high.max(at));
        }
        // Casts saturate: a value rounded to below 0 becomes 0.
        (low as usize).min(last)..=(high as usize).min(last)
    }

    /// Appends the texels covered by `polygon`, each with the solid angle (sr) of its part.
    fn add_covered_texels(&self, polygon: &[DVec3], shares: &mut Vec<(usize, f64)>) {
        // Most polygons lie wholly beyond one of the wall's edges.
        let [w, h] = self.size;
        let edges = [
            self.grid_plane(0, 0),
            -self.grid_plane(0, w),
            self.grid_plane(1, 0),
            -self.grid_plane(1, h),
        ];
        let outside = |edge: &DVec3| polygon.iter().all(|c| c.dot(*edge) < 0.0);
        if edges.iter().any(outside) {
            return;
        }
        let part = edges
            .iter()
            .fold(polygon.to_vec(), |part, edge| cut_by_plane(&part, *edge));
        if part.len() < 3 {
            return;
        }
        for i in self.touched_range(&part, 0) {
            let column = self.cut_strip(&part, 0, i);
            if column.len() < 3 {
                continue;
            }
            for j in self.touched_range(&column, 1) {
                let solid_angle = polygon_solid_angle(&self.cut_strip(&column, 1, j));
                if solid_angle > 0.0 {
                    shares.push((self.first + j * w + i, solid_angle));
                }
            }
        }
    }
}

/// Appends the texels covered by a pixel, each with the solid angle (sr) of its part.
fn distribute_pixel(panorama: &Panorama, [x, y]: [usize; 2], walls: &[Wall], shares: &mut Vec<(usize, f64)>) {
    let (projection, size) = (panorama.projection(), panorama.size());
    let parts = match projection {
        MapProjection::Cube => 1,
        MapProjection::LatLong | MapProjection::Angular => MIN_PARTS_PER_ROW.div_ceil(size[0]),
    };
    let corner = |i: usize, j: usize| {
        let within = |k: usize, i: usize| k as f64 + i as f64 / parts as f64;
        let mut at = DVec2::new(within(x, i), within(y, j));
        if projection == MapProjection::Angular {
            // Points of a pixel outside the disc are moved to its rim.
            let half = size[0] as f64 / 2.0;
            at = DVec2::splat(half) + (at - half).clamp_length_max(half);
        }
        panorama.direction_at(y / size[0], at)
    };
    for (i, j) in (0..parts).flat_map(|j| (0..parts).map(move |i| (i, j))) {
        let corners = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        // Texels are convex: a part with all corners in one texel lies in it.
        let inside = walls
            .iter()
            .find_map(|wall| Some((wall, wall.texel_in_direction(corners[0])?)));
        if let Some((wall, [i, j])) = inside
            && corners[1..].iter().all(|c| wall.texel_in_direction(*c) == Some([i, j]))
        {
            shares.push((wall.first + j * wall.size[0] + i, polygon_solid_angle(&corners)));
            continue;
        }
        for wall in walls {
            wall.add_covered_texels(&corners, shares);
        }
    }
}

/// Returns the part of a convex spherical polygon on the side of a plane through the eye to which `normal` points. Its
/// corners are directions of any length, in either sense of rotation.
fn cut_by_plane(polygon: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut part = Vec::with_capacity(polygon.len() + 1);
    let ends = polygon
        .iter()
        .cycle()
        .skip(polygon.len().saturating_sub(1))
        .zip(polygon);
    for (last, corner) in ends {
        let [from, to] = [last, corner].map(|c| c.dot(normal));
        if (from < 0.0) != (to < 0.0) {
            part.push(last.lerp(*corner, from / (from - to)));
        }
        if to >= 0.0 {
            part.push(*corner);
        }
    }
    part
}

/// Returns the solid angle in sr: a fan of triangles (Van Oosterom and Strackee 1983).
fn polygon_solid_angle(polygon: &[DVec3]) -> f64 {
    let Some((first, rest)) = polygon.split_first() else {
        return 0.0;
    };
    let a = first.normalize();
    let fan = rest.windows(2).map(|pair| {
        let (b, c) = (pair[0].normalize(), pair[1].normalize());
        // Differences, not a × b: the corners of a small triangle are nearly parallel.
        let volume = a.dot((b - a).cross(c - a));
        2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    });
    fan.sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn cube_side_has_a_sixth_of_the_sphere_and_cut_parts_sum_to_the_whole() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let side = [p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)];
        assert!(abs_diff_eq!(
            polygon_solid_angle(&side),
            4.0 * PI / 6.0,
            epsilon = 1e-14
        ));
        for normal in [p(0.3, 0.2), DVec3::new(1.0, 0.1, -0.2), DVec3::X] {
            let parts = [normal, -normal].map(|normal| polygon_solid_angle(&cut_by_plane(&side, normal)));
            assert!(
                abs_diff_eq!(parts[0] + parts[1], 4.0 * PI / 6.0, epsilon = 1e-14),
                "{normal}"
            );
        }
        assert!(cut_by_plane(&side, DVec3::NEG_Z).is_empty());
    }
}
