//! Correspondence of texels and patches between two meshes, and bounds of the rounding of links.

use super::setups::patch_outline;
use common::constants::{CONTACT_DISTANCE, NEAR_POINTS_PER_SIDE, OUTLINE_MARGIN};
use common::form_factor::is_far;
use common::mesh::{Mesh, far_distance};
use common::sampling::near_point_uv;
use cpu::shader_twins::texel_point::{point_on_texel, texel_point};
use glam::{DVec3, Vec3, Vec4};
use oracle::exact::point_to_polygon;
use radiosity_tests::bounds::{U, disc_rounding, polygon_rounding};
use std::f64::consts::PI;

/// Largest shift by rounding of a distance that is compared with [`CONTACT_DISTANCE`] and [`OUTLINE_MARGIN`] by less than so much (mesh units):
/// a few of 8u, the rounding of a coordinate times the steps of a plane's equation.
const ROUNDED_DISTANCE: f64 = 2e-6;

/// Correspondence of two meshes.
pub struct Pairing {
    /// Texel k of the one is texel `texels[k]` of the other.
    pub texels: Vec<usize>,
    /// Patch k of the one is patch `patches[k]` of the other; none if the other has no such patch.
    pub patches: Vec<Option<usize>>,
}

/// Finds for each place and normal the nearest one within a ten-thousandth of the scene's size.
fn nearest_places(of: &[[DVec3; 2]], among: &[[DVec3; 2]], size: f64) -> Vec<Option<usize>> {
    let off = |[p, n]: &[DVec3; 2], [q, m]: &[DVec3; 2]| p.distance(*q) / size + n.distance(*m);
    let find = |one: &[DVec3; 2]| {
        (0..among.len())
            .min_by(|a, b| off(one, &among[*a]).total_cmp(&off(one, &among[*b])))
            .filter(|best| off(one, &among[*best]) < 1e-4)
    };
    of.iter().map(find).collect()
}

/// Returns the area of all texels, mesh units.
fn total_area(mesh: &Mesh) -> f64 {
    mesh.texels.iter().map(|t| f64::from(t.area)).sum()
}

impl Pairing {
    /// Pairs two meshes, of which the second is the first mapped by `to`.
    pub fn new(a: &Mesh, b: &Mesh, to: impl Fn(DVec3) -> DVec3) -> Self {
        let place = |mesh: &Mesh, p: DVec3| p * mesh.unit + mesh.origin;
        let moved = |p: DVec3, n: DVec3| {
            let (from, along) = (to(place(a, p)), to(place(a, p) + n * a.unit));
            [from, (along - from).normalize()]
        };
        let kept = |p: DVec3, n: DVec3| [place(b, p), n];
        let normal = |mesh: &Mesh, face: u32| mesh.faces[face as usize].normal.as_dvec3();
        let texels = |mesh: &Mesh, at: &dyn Fn(DVec3, DVec3) -> [DVec3; 2]| -> Vec<[DVec3; 2]> {
            let each = mesh.texels.iter();
            each.map(|t| at(t.position.as_dvec3(), normal(mesh, t.face))).collect()
        };
        let patches = |mesh: &Mesh, at: &dyn Fn(DVec3, DVec3) -> [DVec3; 2]| -> Vec<[DVec3; 2]> {
            let each = mesh.patches.iter();
            each.map(|c| at(c.shooter.centre.as_dvec3(), normal(mesh, c.face)))
                .collect()
        };
        let found = nearest_places(&texels(a, &moved), &texels(b, &kept), b.unit);
        let mut patches = nearest_places(&patches(a, &moved), &patches(b, &kept), b.unit);
        for (k, patch) in patches.iter_mut().enumerate() {
            // A patch with the same centre but another area is another patch.
            let share = |mesh: &Mesh, k: usize| f64::from(mesh.patches[k].shooter.area) / total_area(mesh);
            *patch = patch.filter(|other| (share(a, k) / share(b, *other) - 1.0).abs() < 1e-4);
        }
        Self {
            texels: found.into_iter().map(|k| k.expect("each texel has its own")).collect(),
            patches,
        }
    }
}

/// Visibility between two points, in f64.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Sight {
    Clear,
    /// Decided by rounding.
    Near,
    Blocked,
}

fn signed_distance(plane: Vec4, p: DVec3) -> f64 {
    plane.truncate().as_dvec3().dot(p) - f64::from(plane.w)
}

/// Returns the visibility between `q` and `p` past face `k` of `mesh`.
fn face_between(mesh: &Mesh, k: usize, q: DVec3, p: DVec3) -> Sight {
    let face = &mesh.faces[k];
    let [from, to] = [q, p].map(|point| signed_distance(face.plane, point));
    let contact = f64::from(CONTACT_DISTANCE) + ROUNDED_DISTANCE;
    if from * to > 0.0 && from.abs().min(to.abs()) > contact {
        return Sight::Clear;
    }
    // Rounded heights move the crossing along the ray.
    let slide = ROUNDED_DISTANCE * p.distance(q) / (from - to).abs().max(1e-30);
    let crossing = q + (p - q) * (from / (from - to)).clamp(0.0, 1.0);
    let inside = face
        .edges
        .iter()
        .filter(|edge| edge.truncate() != Vec3::ZERO)
        .map(|edge| signed_distance(*edge, crossing))
        .fold(f64::INFINITY, f64::min)
        + f64::from(OUTLINE_MARGIN);
    if inside < -(ROUNDED_DISTANCE + slide) {
        Sight::Clear
    } else if inside > ROUNDED_DISTANCE + slide && from.abs().min(to.abs()) > contact {
        Sight::Blocked
    } else {
        Sight::Near
    }
}

fn sight_between(mesh: &Mesh, q: DVec3, p: DVec3, ends: [u32; 2]) -> Sight {
    let ends = ends.map(|k| mesh.faces[k as usize].sheet);
    let others = (0..mesh.faces.len()).filter(|k| {
        let face = &mesh.faces[*k];
        !ends.contains(&face.sheet) && face.normal != Vec3::ZERO
    });
    others
        .map(|k| face_between(mesh, k, q, p))
        .max()
        .unwrap_or(Sight::Clear)
}

/// Returns the share of the samples' weight that rounding may move between visible and hidden.
fn uncertain_share(mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (patch, texel) = (&mesh.patches[i], &mesh.texels[k]);
    let (own, other) = (
        patch.shooter.normal.as_dvec3(),
        mesh.faces[texel.face as usize].normal.as_dvec3(),
    );
    let part = f64::from(patch.shooter.area) / f64::from(mesh.samples);
    let (mut all, mut rounding, mut open) = (0.0, 0.0, 0.0);
    let mut found = [false; 3];
    for s in 0..mesh.samples {
        let q = mesh.patch_points[i * mesh.samples as usize + s as usize];
        let to = texel_point(mesh, k as u32, i as u32, s);
        let (from, to, weight) = (q.position.as_dvec3(), to.truncate().as_dvec3(), to.w * q.weight);
        let d = to - from;
        let r = d.length();
        let cosines = [own.dot(d) / r, -other.dot(d) / r].map(|c| c.max(0.0));
        let [low, below] =
            [own.dot(d), other.dot(d)].map(|h| (h - f64::from(CONTACT_DISTANCE)).abs() < ROUNDED_DISTANCE);
        let g = f64::from(weight) * part * cosines[0] * cosines[1] / (PI * r * r + part);
        all += g;
        rounding += f64::from(weight) * disc_rounding(d, cosines, part, part);
        let seen = if low || below {
            Sight::Near
        } else {
            sight_between(mesh, from, to, [patch.face, texel.face])
        };
        if seen == Sight::Near {
            open += g;
        }
        found[seen as usize] = true;
    }
    // If all samples are visible, or none, their weights do not matter.
    let weights = if found == [true, false, false] || found == [false, false, true] {
        0.0
    } else {
        2.0 * rounding
    };
    if all > 0.0 {
        ((weights + open) / all).min(1.0)
    } else {
        1.0
    }
}

/// Returns the regular grid of points on texel `k`.
pub fn texel_grid(mesh: &Mesh, k: usize) -> Vec<DVec3> {
    let texel = &mesh.texels[k];
    let face = &mesh.faces[texel.face as usize];
    let place = |n| {
        point_on_texel(
            face,
            texel.kind,
            texel.lattice_corner,
            texel.area,
            near_point_uv(n, texel.kind),
        )
    };
    (0..NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE)
        .map(|n| place(n).truncate().as_dvec3())
        .collect()
}

/// Returns true if texel `k` uses its grid of points for patch `i`: if it is near and there are several samples.
pub fn is_near(mesh: &Mesh, i: usize, k: usize) -> bool {
    let (patch, texel) = (&mesh.patches[i], &mesh.texels[k]);
    let reach = far_distance(patch, &mesh.faces[texel.face as usize]);
    mesh.samples > 1 && !is_far(texel.position, patch.shooter.centre, reach)
}

/// Returns the receiver points of texel `k` for patch `i`: its grid, or its centre.
pub fn receiver_points(mesh: &Mesh, i: usize, k: usize) -> Vec<DVec3> {
    if is_near(mesh, i, k) {
        texel_grid(mesh, k)
    } else {
        vec![mesh.texels[k].position.as_dvec3()]
    }
}

/// Returns the mean of the exact form factors of patch `i` from these points of texel `k`.
pub fn mean_factor(mesh: &Mesh, i: usize, k: usize, points: &[DVec3]) -> f64 {
    let normal = mesh.faces[mesh.texels[k].face as usize].normal.as_dvec3();
    let polygon = patch_outline(mesh, i);
    let sum: f64 = points.iter().map(|p| point_to_polygon(*p, normal, &polygon)).sum();
    sum / points.len() as f64
}

/// Returns the rounding of a texel's form factor of a patch: the mean over its receiver points.
pub fn factor_rounding(mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (places, polygon) = (receiver_points(mesh, i, k), patch_outline(mesh, i));
    let sum: f64 = places.iter().map(|p| polygon_rounding(*p, &polygon)).sum();
    sum / places.len() as f64 + places.len() as f64 * U
}

/// Returns a bound of the rounding of the link of texel `k` to patch `i`: of its form factor, and of the visible share
/// where rays pass edges within rounding.
pub fn link_rounding(mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (patch, texel) = (&mesh.patches[i], &mesh.texels[k]);
    if patch.face == texel.face {
        return 0.0;
    }
    let face = &mesh.faces[texel.face as usize];
    let factor = mean_factor(mesh, i, k, &receiver_points(mesh, i, k));
    let distance = texel.position.distance(patch.shooter.centre);
    // Rounding decides between the grid and the centre: the link may change by F < 1.
    if mesh.samples > 1 && f64::from((distance - far_distance(patch, face)).abs()) < ROUNDED_DISTANCE {
        return 1.0;
    }
    factor_rounding(mesh, i, k) + factor * uncertain_share(mesh, i, k)
}
