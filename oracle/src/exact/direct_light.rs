//! Direct illumination: exact point-to-polygon factors (Lambert) of the visible parts of the lamps
//! and their mean over a texel. In f64, and without the solvers' form factors and visibility; the failure atlas judges
//! by it.
//!
//! ```text
//! H̄ = 1/A ∫_A Σ_l E_l F(p → visible part of lamp l) dA
//! ```
//! The hidden parts are clipped from the lamp exactly, by the pyramids whose apex is the point and
//! whose base is an occluder. A and p in scene units, E and H in W/m².

use super::{point_to_polygon, polygon_to_polygon, vector_area};
use common::polygon::clip_by_plane;
use common::scene::{Face, Scene};
use common::texel::{texel_count, texel_outline};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Tolerance of the quadrature relative to the largest value on the texel: a hundredth of the error
/// that counts as safe.
const MEAN_TOLERANCE: f64 = 2e-4;
/// Least and greatest depth of subdivision into four; an edge then covers 2^−depth of the texel.
const DEPTH_RANGE: [u32; 2] = [1, 6];
/// Values below this share of the unoccluded ones are not refined further.
const DARK_SHARE: f64 = 1e-3;
/// Distance in radii beyond which a texel is integrated by quadrature: the contour integral would
/// subtract nearly equal logarithms.
const MAX_CONTOUR_RADII: f64 = 4.0;

/// Returns ρH̄ of every texel in face order, W/m². `occluders` are the faces that may hide lamps.
pub fn reflected_direct(scene: &Scene, texels: u32, occluders: &Range<usize>) -> Vec<DVec3> {
    let lamps: Vec<usize> = (0..scene.faces.len())
        .filter(|k| scene.faces[*k].emission.max_element() > 0.0)
        .collect();
    let resolution = [texels, texels];
    let places: Vec<(usize, u32)> = (0..scene.faces.len())
        .flat_map(|k| (0..texel_count(resolution)).map(move |t| (k, t)))
        .collect();
    let of = |(k, t): &(usize, u32)| {
        let face = &scene.faces[*k];
        let reflectance = face.reflectance.as_dvec3();
        if reflectance == DVec3::ZERO || face.area() == 0.0 {
            return DVec3::ZERO;
        }
        let texel = texel_outline(face, resolution, *t);
        let from = lamps.iter().filter(|lamp| *lamp != k).map(|lamp| {
            let others = occluders.clone().filter(|other| ![*k, *lamp].contains(other));
            let between: Vec<&[DVec3]> = others.map(|other| scene.faces[other].outline()).collect();
            let factor = mean_factor(face, texel.corners(), &scene.faces[*lamp], &between);
            scene.faces[*lamp].emission.as_dvec3() * factor
        });
        reflectance * from.sum::<DVec3>()
    };
    places.par_iter().map(of).collect()
}

/// Returns the mean form factor from a texel of `face` to the visible part of the lamp.
fn mean_factor(face: &Face, texel: &[DVec3], lamp: &Face, occluders: &[&[DVec3]]) -> f64 {
    if occluders.is_empty() && is_near(texel, lamp.outline()) {
        return polygon_to_polygon(texel, lamp.outline());
    }
    let normal = face.vector_area().normalize_or_zero();
    let open = |p: DVec3| point_to_polygon(p, normal, lamp.outline());
    let corners = texel.iter().map(|p| open(*p));
    let scale = DARK_SHARE * corners.fold(0.0, f64::max);
    polygon_mean(texel, scale, &|p| visible_factor(p, normal, lamp.outline(), occluders))
}

fn is_near(a: &[DVec3], b: &[DVec3]) -> bool {
    let sphere = |polygon: &[DVec3]| {
        let centre = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
        let radii = polygon.iter().map(|p| p.distance(centre));
        (centre, radii.fold(0.0, f64::max))
    };
    let ((a, r), (b, s)) = (sphere(a), sphere(b));
    a.distance(b) < MAX_CONTOUR_RADII * (r + s)
}

/// Returns the form factor from a point to the visible part of `lamp`.
pub fn visible_factor(point: DVec3, normal: DVec3, lamp: &[DVec3], occluders: &[&[DVec3]]) -> f64 {
    let mut pieces = vec![clip_by_plane(lamp, point, normal)];
    for occluder in occluders {
        // Only parts above the horizon and in front of the lamp occlude it.
        let above = clip_by_plane(occluder, point, normal);
        let before = clip_by_plane(&above, lamp[0], vector_area(lamp));
        if let Some(pyramid) = pyramid_planes(point, &before) {
            pieces = pieces
                .iter()
                .flat_map(|piece| subtract_pyramid(piece, point, &pyramid))
                .collect();
        }
    }
    let factor = |piece: &Vec<DVec3>| point_to_polygon(point, normal, piece);
    pieces.iter().map(factor).sum()
}

/// Returns the inward normals of the planes through the apex and each edge of the base; none if the
/// base is seen edge-on.
fn pyramid_planes(apex: DVec3, base: &[DVec3]) -> Option<Vec<DVec3>> {
    if base.len() < 3 {
        return None;
    }
    let centre = base.iter().sum::<DVec3>() / base.len() as f64 - apex;
    let area = vector_area(base);
    if area.dot(centre).abs() <= 1e-12 * area.length() * centre.length() {
        return None;
    }
    let plane = |k: usize| {
        let normal = (base[k] - apex).cross(base[(k + 1) % base.len()] - apex);
        normal * normal.dot(centre).signum()
    };
    let planes = (0..base.len()).map(plane);
    Some(planes.filter(|plane| *plane != DVec3::ZERO).collect())
}

/// Subtracts a pyramid from a convex polygon and returns the convex pieces.
fn subtract_pyramid(polygon: &[DVec3], apex: DVec3, planes: &[DVec3]) -> Vec<Vec<DVec3>> {
    let beside = |plane: &&DVec3| polygon.iter().all(|p| plane.dot(*p - apex) <= 0.0);
    if planes.iter().any(|plane| beside(&plane)) {
        return vec![polygon.to_vec()];
    }
    let mut rest = polygon.to_vec();
    let mut pieces = Vec::new();
    for plane in planes {
        let outside = clip_by_plane(&rest, apex, -*plane);
        if outside.len() >= 3 {
            pieces.push(outside);
        }
        rest = clip_by_plane(&rest, apex, *plane);
        if rest.len() < 3 {
            break;
        }
    }
    pieces
}

/// Returns the mean of `f` over a convex polygon by adaptive quadrature: Dunavant's rule of degree 5
/// on triangles, each cut into four until the mean settles. Values below `scale` are not resolved.
pub fn polygon_mean(polygon: &[DVec3], scale: f64, f: &dyn Fn(DVec3) -> f64) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for k in 2..polygon.len() {
        let triangle = [polygon[0], polygon[k - 1], polygon[k]];
        let size = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).length();
        let mut greatest = scale;
        let first = dunavant_mean(triangle, f, &mut greatest);
        sum += size * refine_mean(triangle, f, first, greatest, 0);
        area += size;
    }
    if area > 0.0 { sum / area } else { 0.0 }
}

fn refine_mean(t: [DVec3; 3], f: &dyn Fn(DVec3) -> f64, coarse: f64, greatest: f64, depth: u32) -> f64 {
    let [a, b, c] = t;
    let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
    let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
    let mut greatest = greatest;
    let means = parts.map(|part| dunavant_mean(part, f, &mut greatest));
    let fine = means.iter().sum::<f64>() / 4.0;
    // An edge crosses 2^depth parts of 4^−depth of the area each: errors add up as 2^−depth.
    let settled = (fine - coarse).abs() <= MEAN_TOLERANCE * greatest * f64::from(1u32 << depth);
    if (settled && depth >= DEPTH_RANGE[0]) || depth == DEPTH_RANGE[1] {
        return fine;
    }
    let finer = |k: usize| refine_mean(parts[k], f, means[k], greatest, depth + 1);
    (0..4).map(finer).sum::<f64>() / 4.0
}

/// Returns the mean over a triangle by seven points (Dunavant 1985) and raises `greatest`.
fn dunavant_mean([a, b, c]: [DVec3; 3], f: &dyn Fn(DVec3) -> f64, greatest: &mut f64) -> f64 {
    const DUNAVANT_POINTS: [(f64, f64); 2] = [
        (0.132_394_152_788_506_2, 0.470_142_064_105_115_1),
        (0.125_939_180_544_827_15, 0.101_286_507_323_456_33),
    ];
    let mut value = |u: f64, v: f64| {
        let value = f(a + (b - a) * u + (c - a) * v);
        *greatest = greatest.max(value.abs());
        value
    };
    let mut sum = 0.225 * value(1.0 / 3.0, 1.0 / 3.0);
    for (weight, u) in DUNAVANT_POINTS {
        let w = 1.0 - 2.0 * u;
        sum += weight * (value(u, u) + value(w, u) + value(u, w));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;
    use glam::Vec3;

    fn parallelogram(corner: [f64; 3], u: DVec3, v: DVec3) -> Face {
        let c = DVec3::from(corner);
        Face::quad("square", [c, c + u, c + u + v, c + v], Vec3::ZERO, Vec3::ZERO)
    }

    /// Makes a plate and a lamp above it.
    fn plate_and_lamp() -> [Face; 2] {
        let plate = parallelogram([0.2, 0.3, 0.4], 0.5 * DVec3::X, 0.4 * DVec3::Y);
        [plate, parallelogram([0.0, 0.0, 1.0], DVec3::Y, DVec3::X)]
    }

    #[test]
    fn visible_factor_is_open_factor_minus_hidden_image() {
        let [plate, lamp] = plate_and_lamp();
        // The hidden part of the lamp is the plate's image on it, projected from the point.
        for (x, y) in [(0.45, 0.5), (0.1, 0.9), (0.7, 0.2)] {
            let p = DVec3::new(x, y, 0.0);
            let image: Vec<DVec3> = plate.outline().iter().map(|q| p + (*q - p) / 0.4).collect();
            let mut seen = image;
            for (at, inward) in [
                (DVec3::ZERO, DVec3::X),
                (DVec3::ZERO, DVec3::Y),
                (DVec3::ONE, DVec3::NEG_X),
                (DVec3::ONE, DVec3::NEG_Y),
            ] {
                seen = clip_by_plane(&seen, at, inward);
            }
            seen.reverse();
            let all = point_to_polygon(p, DVec3::Z, lamp.outline());
            let hidden = point_to_polygon(p, DVec3::Z, &seen);
            let open = visible_factor(p, DVec3::Z, lamp.outline(), &[plate.outline()]);
            assert!(abs_diff_eq!(all - hidden, open, epsilon = 1e-14), "{p}");
            // A second plate in the shadow of the first hides nothing more.
            let again = visible_factor(p, DVec3::Z, lamp.outline(), &[plate.outline(); 2]);
            assert!(abs_diff_eq!(again, open, epsilon = 1e-14));
        }
    }

    #[test]
    fn plates_behind_the_lamp_or_below_the_horizon_occlude_nothing() {
        let [_, lamp] = plate_and_lamp();
        let p = DVec3::new(0.5, 0.5, 0.0);
        let all = point_to_polygon(p, DVec3::Z, lamp.outline());
        for z in [-0.5, 1.5] {
            let far = parallelogram([0.0, 0.0, z], DVec3::X, DVec3::Y);
            assert_eq!(visible_factor(p, DVec3::Z, lamp.outline(), &[far.outline()]), all);
        }
    }

    #[test]
    fn mean_of_a_step_function_resolves_its_edge() {
        let unit = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let step = |p: DVec3| f64::from(p.x + 0.3 * p.y < 0.37);
        assert!(abs_diff_eq!(polygon_mean(&unit, 0.0, &step), 0.22, epsilon = 1e-3));
        let smooth = |p: DVec3| (3.0 * p.x).sin() * p.y;
        assert!(abs_diff_eq!(
            polygon_mean(&unit, 0.0, &smooth),
            (1.0 - 3f64.cos()) / 6.0,
            epsilon = 1e-6
        ));
    }
}
