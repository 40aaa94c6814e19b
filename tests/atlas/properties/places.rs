//! Which texel of one mesh is which of another, and what rounding may change of a link.

use super::kit::outline;
use common::constants::{CONTACT, NEAR, OUTLINE};
use common::form_factor::far;
use common::mesh::{Mesh, reach};
use common::sampling::near_uv;
use cpu::twin::texel_point::{point, texel_point};
use glam::{DVec3, Vec3, Vec4};
use oracle::judge::exact::point_to_polygon;
use radiosity_tests::bounds::{U, disc_rounding, polygon_rounding};
use std::f64::consts::PI;

/// Rounding moves what is compared with [`CONTACT`] and [`OUTLINE`] by less than so much (mesh units):
/// a few of 8u, the rounding of a coordinate times the steps of a plane's equation.
const MOVED: f64 = 2e-6;

/// What corresponds in two meshes.
pub struct Pairing {
    /// Texel k of the one is texel `texels[k]` of the other.
    pub texels: Vec<usize>,
    /// The same of cells; none where the other has no such cell.
    pub cells: Vec<Option<usize>>,
}

/// Places and normals in the scene: the nearest within a thousandth of its size.
fn nearest(of: &[[DVec3; 2]], among: &[[DVec3; 2]], size: f64) -> Vec<Option<usize>> {
    let off = |[p, n]: &[DVec3; 2], [q, m]: &[DVec3; 2]| p.distance(*q) / size + n.distance(*m);
    let find = |one: &[DVec3; 2]| {
        (0..among.len())
            .min_by(|a, b| off(one, &among[*a]).total_cmp(&off(one, &among[*b])))
            .filter(|best| off(one, &among[*best]) < 1e-4)
    };
    of.iter().map(find).collect()
}

/// That of all texels, mesh units.
fn area(mesh: &Mesh) -> f64 {
    mesh.texels.iter().map(|t| f64::from(t.area)).sum()
}

impl Pairing {
    /// That of two meshes of which the second is the first moved `to` there.
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
            each.map(|t| at(t.position.as_dvec3(), normal(mesh, t.face)))
                .collect()
        };
        let cells = |mesh: &Mesh, at: &dyn Fn(DVec3, DVec3) -> [DVec3; 2]| -> Vec<[DVec3; 2]> {
            let each = mesh.cells.iter();
            each.map(|c| at(c.shooter.centre.as_dvec3(), normal(mesh, c.face)))
                .collect()
        };
        let found = nearest(&texels(a, &moved), &texels(b, &kept), b.unit);
        let mut cells = nearest(&cells(a, &moved), &cells(b, &kept), b.unit);
        for (k, cell) in cells.iter_mut().enumerate() {
            // A cell with the same centre may be another one.
            let share = |mesh: &Mesh, k: usize| f64::from(mesh.cells[k].shooter.area) / area(mesh);
            *cell = cell.filter(|other| (share(a, k) / share(b, *other) - 1.0).abs() < 1e-4);
        }
        Self {
            texels: found
                .into_iter()
                .map(|k| k.expect("each texel has its own"))
                .collect(),
            cells,
        }
    }
}

/// What lies between two points, in f64.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Sight {
    Clear,
    /// Rounding decides.
    Near,
    Blocked,
}

fn height(plane: Vec4, p: DVec3) -> f64 {
    plane.truncate().as_dvec3().dot(p) - f64::from(plane.w)
}

/// Whether face `k` of `mesh` lies between `q` and `p`.
fn between(mesh: &Mesh, k: usize, q: DVec3, p: DVec3) -> Sight {
    let face = &mesh.faces[k];
    let [from, to] = [q, p].map(|point| height(face.plane, point));
    let contact = f64::from(CONTACT) + MOVED;
    if from * to > 0.0 && from.abs().min(to.abs()) > contact {
        return Sight::Clear;
    }
    // Rounded heights move the crossing along the ray.
    let slide = MOVED * p.distance(q) / (from - to).abs().max(1e-30);
    let crossing = q + (p - q) * (from / (from - to)).clamp(0.0, 1.0);
    let inside = face
        .edges
        .iter()
        .filter(|edge| edge.truncate() != Vec3::ZERO)
        .map(|edge| height(*edge, crossing))
        .fold(f64::INFINITY, f64::min)
        + f64::from(OUTLINE);
    if inside < -(MOVED + slide) {
        Sight::Clear
    } else if inside > MOVED + slide && from.abs().min(to.abs()) > contact {
        Sight::Blocked
    } else {
        Sight::Near
    }
}

fn sight(mesh: &Mesh, q: DVec3, p: DVec3, ends: [u32; 2]) -> Sight {
    let ends = ends.map(|k| mesh.faces[k as usize].sheet);
    let others = (0..mesh.faces.len()).filter(|k| {
        let face = &mesh.faces[*k];
        !ends.contains(&face.sheet) && face.normal != Vec3::ZERO
    });
    others
        .map(|k| between(mesh, k, q, p))
        .max()
        .unwrap_or(Sight::Clear)
}

/// The part of the samples' weight that rounding may move between seen and unseen.
fn share(mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (cell, texel) = (&mesh.cells[i], &mesh.texels[k]);
    let (own, other) = (
        cell.shooter.normal.as_dvec3(),
        mesh.faces[texel.face as usize].normal.as_dvec3(),
    );
    let part = f64::from(cell.shooter.area) / f64::from(mesh.samples);
    let (mut all, mut rounding, mut open) = (0.0, 0.0, 0.0);
    let mut found = [false; 3];
    for s in 0..mesh.samples {
        let q = mesh.points[i * mesh.samples as usize + s as usize];
        let to = texel_point(mesh, k as u32, i as u32, s);
        let (from, to, weight) = (
            q.position.as_dvec3(),
            to.truncate().as_dvec3(),
            to.w * q.weight,
        );
        let d = to - from;
        let r = d.length();
        let cosines = [own.dot(d) / r, -other.dot(d) / r].map(|c| c.max(0.0));
        let [low, below] =
            [own.dot(d), other.dot(d)].map(|h| (h - f64::from(CONTACT)).abs() < MOVED);
        let g = f64::from(weight) * part * cosines[0] * cosines[1] / (PI * r * r + part);
        all += g;
        rounding += f64::from(weight) * disc_rounding(d, cosines, part, part);
        let seen = if low || below {
            Sight::Near
        } else {
            sight(mesh, from, to, [cell.face, texel.face])
        };
        if seen == Sight::Near {
            open += g;
        }
        found[seen as usize] = true;
    }
    // All points see the other, or none: then their weights do not matter.
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

/// The even grid of points on texel `k`.
pub fn grid(mesh: &Mesh, k: usize) -> Vec<DVec3> {
    let texel = &mesh.texels[k];
    let face = &mesh.faces[texel.face as usize];
    let place = |n| {
        point(
            face,
            texel.kind,
            texel.place,
            texel.area,
            near_uv(n, texel.kind),
        )
    };
    (0..NEAR * NEAR)
        .map(|n| place(n).truncate().as_dvec3())
        .collect()
}

/// Whether texel `k` looks at cell `i` from its grid: where it is near and has many samples.
pub fn is_near(mesh: &Mesh, i: usize, k: usize) -> bool {
    let (cell, texel) = (&mesh.cells[i], &mesh.texels[k]);
    let reach = reach(cell, &mesh.faces[texel.face as usize]);
    mesh.samples > 1 && !far(texel.position, cell.shooter.centre, reach)
}

/// The points of texel `k` from which cell `i` is looked at: its grid, or its centre.
pub fn places(mesh: &Mesh, i: usize, k: usize) -> Vec<DVec3> {
    if is_near(mesh, i, k) {
        grid(mesh, k)
    } else {
        vec![mesh.texels[k].position.as_dvec3()]
    }
}

/// The mean of cell `i`'s exact factors from these points of texel `k`.
pub fn mean_factor(mesh: &Mesh, i: usize, k: usize, points: &[DVec3]) -> f64 {
    let normal = mesh.faces[mesh.texels[k].face as usize].normal.as_dvec3();
    let polygon = outline(mesh, i);
    let sum: f64 = points
        .iter()
        .map(|p| point_to_polygon(*p, normal, &polygon))
        .sum();
    sum / points.len() as f64
}

/// What a texel's form factor of a cell is rounded by: the mean over its places.
pub fn factor_rounding(mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (places, polygon) = (places(mesh, i, k), outline(mesh, i));
    let sum: f64 = places.iter().map(|p| polygon_rounding(*p, &polygon)).sum();
    sum / places.len() as f64 + places.len() as f64 * U
}

/// What rounding may change of the link of texel `k` to cell `i`: of its form factor, and of the share
/// that it sees, all of it where a point's ray passes an edge by no more than rounding.
pub fn link_rounding(mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (cell, texel) = (&mesh.cells[i], &mesh.texels[k]);
    if cell.face == texel.face {
        return 0.0;
    }
    let face = &mesh.faces[texel.face as usize];
    let factor = mean_factor(mesh, i, k, &places(mesh, i, k));
    let distance = texel.position.distance(cell.shooter.centre);
    // The mean over the places of a near texel, or its centre: F is below 1.
    if mesh.samples > 1 && f64::from((distance - reach(cell, face)).abs()) < MOVED {
        return 1.0;
    }
    factor_rounding(mesh, i, k) + factor * share(mesh, i, k)
}
