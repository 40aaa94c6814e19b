//! Light that goes one way: exact Lambert factors of what a texel sees of the lamps, and their mean
//! over the texel. f64, and nothing of what the solvers use for form factors and visibility.
//!
//! ```text
//! H̄ = 1/A ∫_A Σ_l E_l F(p → visible part of lamp l) dA
//! ```
//! What is hidden is cut out of the lamp exactly: by the pyramids that have the point as their apex
//! and an occluder as their base. A, p in scene units, E and H in W/m².

use crate::judge::exact::{clip, point_to_polygon, polygon_to_polygon, vector_area};
use common::scene::{Face, Scene};
use common::texel::{count, outline};
use glam::DVec3;
use rayon::prelude::*;

/// Relative to the largest value on the texel: a hundredth of what is called safe.
const TOLERANCE: f64 = 2e-4;
/// So often at least and at most a texel is cut into four; an edge's part of it is then 2^−depth.
const DEPTH: [u32; 2] = [1, 6];
/// What is darker than this share of an open texel counts as dark: rounding must not be refined.
const DARK: f64 = 1e-3;
/// A texel so many radii from a lamp: there the contour integral would be differences of logarithms
/// that are nearly equal.
const FAR: f64 = 4.0;

/// ρH̄ of every texel, in face order; `occluders` are faces that may hide lamps.
pub fn reflected(scene: &Scene, texels: u32, occluders: &[usize]) -> Vec<DVec3> {
    let lamps: Vec<usize> = (0..scene.faces.len())
        .filter(|k| scene.faces[*k].emission.max_element() > 0.0)
        .collect();
    let resolution = [texels, texels];
    let places: Vec<(usize, u32)> = (0..scene.faces.len())
        .flat_map(|k| (0..count(resolution)).map(move |t| (k, t)))
        .collect();
    let of = |(k, t): &(usize, u32)| {
        let face = &scene.faces[*k];
        let reflectance = face.reflectance.as_dvec3();
        if reflectance == DVec3::ZERO || face.area() == 0.0 {
            return DVec3::ZERO;
        }
        let texel = outline(face, resolution, *t);
        let from = lamps.iter().filter(|lamp| *lamp != k).map(|lamp| {
            let between = between(scene, occluders, [*k, *lamp]);
            let factor = mean_factor(face, texel.corners(), &scene.faces[*lamp], &between);
            scene.faces[*lamp].emission.as_dvec3() * factor
        });
        reflectance * from.sum::<DVec3>()
    };
    places.par_iter().map(of).collect()
}

/// The occluders but for the ends of the way.
fn between<'a>(scene: &'a Scene, occluders: &[usize], ends: [usize; 2]) -> Vec<&'a [DVec3]> {
    let others = occluders.iter().filter(|k| !ends.contains(k));
    others.map(|k| scene.faces[*k].outline()).collect()
}

/// The mean factor from a texel of `face` to the lamp.
fn mean_factor(face: &Face, texel: &[DVec3], lamp: &Face, occluders: &[&[DVec3]]) -> f64 {
    if occluders.is_empty() && near(texel, lamp.outline()) {
        return polygon_to_polygon(texel, lamp.outline());
    }
    let normal = face.vector_area().normalize_or_zero();
    let open = |p: DVec3| point_to_polygon(p, normal, lamp.outline());
    let corners = texel.iter().map(|p| open(*p));
    let scale = DARK * corners.fold(0.0, f64::max);
    mean(texel, scale, &|p| {
        visible(p, normal, lamp.outline(), occluders)
    })
}

fn near(a: &[DVec3], b: &[DVec3]) -> bool {
    let sphere = |polygon: &[DVec3]| {
        let centre = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
        let radii = polygon.iter().map(|p| p.distance(centre));
        (centre, radii.fold(0.0, f64::max))
    };
    let ((a, r), (b, s)) = (sphere(a), sphere(b));
    a.distance(b) < FAR * (r + s)
}

/// The factor from a point to what it sees of `lamp`.
pub fn visible(point: DVec3, normal: DVec3, lamp: &[DVec3], occluders: &[&[DVec3]]) -> f64 {
    let mut pieces = vec![clip(lamp, point, normal)];
    for occluder in occluders {
        // Only what stands above the horizon and before the lamp hides anything.
        let above = clip(occluder, point, normal);
        let before = clip(&above, lamp[0], vector_area(lamp));
        if let Some(pyramid) = pyramid(point, &before) {
            pieces = pieces
                .iter()
                .flat_map(|piece| without(piece, point, &pyramid))
                .collect();
        }
    }
    let factor = |piece: &Vec<DVec3>| point_to_polygon(point, normal, piece);
    pieces.iter().map(factor).sum()
}

/// Inward normals of the planes through the apex and the edges of its base; none where the base is
/// seen edge-on.
fn pyramid(apex: DVec3, base: &[DVec3]) -> Option<Vec<DVec3>> {
    let centre = base.iter().sum::<DVec3>() / base.len().max(1) as f64 - apex;
    let area = vector_area_of(base);
    let flat = area.dot(centre).abs() <= 1e-12 * area.length() * centre.length();
    if base.len() < 3 || flat {
        return None;
    }
    let plane = |k: usize| {
        let normal = (base[k] - apex).cross(base[(k + 1) % base.len()] - apex);
        normal * normal.dot(centre).signum()
    };
    let planes = (0..base.len()).map(plane);
    Some(planes.filter(|plane| *plane != DVec3::ZERO).collect())
}

fn vector_area_of(polygon: &[DVec3]) -> DVec3 {
    if polygon.len() < 3 {
        DVec3::ZERO
    } else {
        vector_area(polygon)
    }
}

/// A convex polygon without what lies inside the pyramid, in convex pieces.
fn without(polygon: &[DVec3], apex: DVec3, planes: &[DVec3]) -> Vec<Vec<DVec3>> {
    let beside = |plane: &&DVec3| polygon.iter().all(|p| plane.dot(*p - apex) <= 0.0);
    if planes.iter().any(|plane| beside(&plane)) {
        return vec![polygon.to_vec()];
    }
    let mut rest = polygon.to_vec();
    let mut pieces = Vec::new();
    for plane in planes {
        let outside = clip(&rest, apex, -*plane);
        if outside.len() >= 3 {
            pieces.push(outside);
        }
        rest = clip(&rest, apex, *plane);
        if rest.len() < 3 {
            break;
        }
    }
    pieces
}

/// The mean of `f` over a convex polygon: Dunavant's rule of degree 5 on triangles, each cut into
/// four until that changes nothing; `scale` and more is what counts.
pub fn mean(polygon: &[DVec3], scale: f64, f: &dyn Fn(DVec3) -> f64) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for k in 2..polygon.len() {
        let triangle = [polygon[0], polygon[k - 1], polygon[k]];
        let size = (triangle[1] - triangle[0])
            .cross(triangle[2] - triangle[0])
            .length();
        let mut greatest = scale;
        let first = rule(triangle, f, &mut greatest);
        sum += size * refined(triangle, f, first, greatest, 0);
        area += size;
    }
    if area > 0.0 { sum / area } else { 0.0 }
}

fn refined(t: [DVec3; 3], f: &dyn Fn(DVec3) -> f64, coarse: f64, greatest: f64, depth: u32) -> f64 {
    let [a, b, c] = t;
    let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
    let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
    let mut greatest = greatest;
    let means = parts.map(|part| rule(part, f, &mut greatest));
    let fine = means.iter().sum::<f64>() / 4.0;
    // An edge is in 2^depth parts, each of 4^−depth of the area: errors add up as 2^−depth.
    let settled = (fine - coarse).abs() <= TOLERANCE * greatest * f64::from(1u32 << depth);
    if (settled && depth >= DEPTH[0]) || depth == DEPTH[1] {
        return fine;
    }
    let finer = |k: usize| refined(parts[k], f, means[k], greatest, depth + 1);
    (0..4).map(finer).sum::<f64>() / 4.0
}

/// Seven points (Dunavant 1985).
fn rule([a, b, c]: [DVec3; 3], f: &dyn Fn(DVec3) -> f64, greatest: &mut f64) -> f64 {
    const ROWS: [(f64, f64); 2] = [
        (0.132_394_152_788_506_2, 0.470_142_064_105_115_1),
        (0.125_939_180_544_827_15, 0.101_286_507_323_456_33),
    ];
    let mut value = |u: f64, v: f64| {
        let value = f(a + (b - a) * u + (c - a) * v);
        *greatest = greatest.max(value.abs());
        value
    };
    let mut sum = 0.225 * value(1.0 / 3.0, 1.0 / 3.0);
    for (weight, u) in ROWS {
        let w = 1.0 - 2.0 * u;
        sum += weight * (value(u, u) + value(w, u) + value(u, w));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::stress::cases::shapes::{lamp, scene, square};
    use approx::abs_diff_eq;
    use glam::Vec3;

    /// A lamp over a floor, and a plate between them.
    fn plates() -> Scene {
        let floor = square([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5);
        let plate = square([0.2, 0.3, 0.4], [0.5, 0.0, 0.0], [0.0, 0.4, 0.0], 0.0);
        let lamp = lamp([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], 1.0);
        scene("plates", vec![floor, plate, lamp])
    }

    #[test]
    fn quadrature_and_contour_integral_agree() {
        let scene = plates();
        let exact = reflected(&scene, 4, &[]);
        // The plate behind the floor hides nothing, but the other way is taken.
        let mut below = scene.clone();
        for corner in &mut below.faces[1].corners {
            corner.z = -1.0;
        }
        let sampled = reflected(&below, 4, &[1]);
        for (a, b) in exact[..16].iter().zip(&sampled[..16]) {
            assert!(abs_diff_eq!(a.x, b.x, epsilon = 1e-4 * a.x), "{a} {b}");
        }
    }

    #[test]
    fn a_shadow_is_what_the_plate_hides() {
        let lamp = &plates().faces[2];
        let plate = &plates().faces[1];
        // Seen from a point, lamp and plate are told by Lambert's sum: what is hidden of the lamp is
        // the plate's image on it.
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
                seen = clip(&seen, at, inward);
            }
            seen.reverse();
            let all = point_to_polygon(p, DVec3::Z, lamp.outline());
            let hidden = point_to_polygon(p, DVec3::Z, &seen);
            let open = visible(p, DVec3::Z, lamp.outline(), &[plate.outline()]);
            assert!(abs_diff_eq!(all - hidden, open, epsilon = 1e-14), "{p}");
            // A second plate in the first one's shadow hides no more.
            let again = visible(p, DVec3::Z, lamp.outline(), &[plate.outline(); 2]);
            assert!(abs_diff_eq!(again, open, epsilon = 1e-14));
        }
    }

    #[test]
    fn what_is_behind_the_lamp_or_below_the_horizon_hides_nothing() {
        let lamp = &plates().faces[2];
        let p = DVec3::new(0.5, 0.5, 0.0);
        let all = point_to_polygon(p, DVec3::Z, lamp.outline());
        for z in [-0.5, 1.5] {
            let far = square([0.0, 0.0, z], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.0);
            assert_eq!(visible(p, DVec3::Z, lamp.outline(), &[far.outline()]), all);
        }
        assert_eq!(lamp.reflectance, Vec3::ZERO);
    }

    #[test]
    fn the_mean_finds_an_edge() {
        let unit = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let step = |p: DVec3| f64::from(p.x + 0.3 * p.y < 0.37);
        assert!(abs_diff_eq!(mean(&unit, 0.0, &step), 0.22, epsilon = 1e-3));
        let smooth = |p: DVec3| (3.0 * p.x).sin() * p.y;
        assert!(abs_diff_eq!(
            mean(&unit, 0.0, &smooth),
            (1.0 - 3f64.cos()) / 6.0,
            epsilon = 1e-6
        ));
    }
}
