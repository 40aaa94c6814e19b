//! [`crate::twin::link::sample`] for a block of texels at once: the same operations in the same order,
//! lane by lane, so that the same bits come out. Written as plain loops over arrays, which the
//! compiler turns into the widest registers that the caller's [`pulp::Arch`] found.

use crate::rows::receivers::{Block, LANES, Receivers};
use crate::twin::texel_point::point;
use common::constants::{CONTACT, DEPTH_SCALE, MISS, POINT, RAY_REACH};
use common::form_factor::{
    FormFactor, Shooter, disc, far, is_low, polygon, polygon_above, remote, weight,
};
use common::intersect::{meet, touches};
use common::mesh::{MeshFace, TexelKind};
use common::sampling::{near_uv, texel_uv};
use glam::Vec3;

/// A number of each lane.
pub type Lane = [f32; LANES];

/// Points of a block's texels.
#[derive(Clone, Copy)]
pub struct Points {
    x: Lane,
    y: Lane,
    z: Lane,
    /// The area that each stands for over the mean.
    pub weight: Lane,
}

impl Points {
    /// Of coordinates.
    #[inline(always)]
    pub fn new([x, y, z]: [Lane; 3], weight: Lane) -> Self {
        Self { x, y, z, weight }
    }

    /// Of lane `l`.
    #[inline(always)]
    pub fn at(&self, l: usize) -> Vec3 {
        Vec3::new(self.x[l], self.y[l], self.z[l])
    }

    /// The texels' centres.
    #[inline(always)]
    pub fn centres(receivers: &Receivers, first: usize) -> Self {
        let lane = |axis: usize| -> Lane {
            let mut lane = [0.0; LANES];
            lane.copy_from_slice(&receivers.centre[axis][first..first + LANES]);
            lane
        };
        Self {
            x: lane(0),
            y: lane(1),
            z: lane(2),
            weight: [1.0; LANES],
        }
    }

    /// Point `s` of each texel as `cell` sees it.
    #[inline(always)]
    pub fn sampled(
        receivers: &Receivers,
        face: &MeshFace,
        block: &Block,
        cell: u32,
        s: u32,
    ) -> Self {
        Self::of_quads_or_not(receivers, face, block, |k, _| texel_uv(s, k as u32, cell))
    }

    /// Place `place` of the grid on each texel.
    #[inline(always)]
    pub fn placed(receivers: &Receivers, face: &MeshFace, block: &Block, place: u32) -> Self {
        Self::of_quads_or_not(receivers, face, block, |_, kind| near_uv(place, kind))
    }

    #[inline(always)]
    fn of_quads_or_not(
        receivers: &Receivers,
        face: &MeshFace,
        block: &Block,
        uv: impl Fn(usize, TexelKind) -> [f32; 2],
    ) -> Self {
        if receivers.kind[block.first] == TexelKind::Quad {
            Self::of_kind(receivers, face, block, uv, |_| TexelKind::Quad)
        } else {
            Self::of_kind(receivers, face, block, uv, |k| receivers.kind[k])
        }
    }

    #[inline(always)]
    fn of_kind(
        receivers: &Receivers,
        face: &MeshFace,
        block: &Block,
        uv: impl Fn(usize, TexelKind) -> [f32; 2],
        kind: impl Fn(usize) -> TexelKind,
    ) -> Self {
        let mut points = Self {
            x: [0.0; LANES],
            y: [0.0; LANES],
            z: [0.0; LANES],
            weight: [1.0; LANES],
        };
        let first = block.first;
        let [i, j] = [0, 1].map(|axis| &receivers.place[axis][first..first + LANES]);
        let area = &receivers.area[first..first + LANES];
        for l in 0..LANES {
            let kind = kind(first + l);
            let p = point(face, kind, [i[l], j[l]], area[l], uv(first + l, kind));
            (points.x[l], points.y[l], points.z[l], points.weight[l]) = (p.x, p.y, p.z, p.w);
        }
        points
    }
}

/// [`common::form_factor::form_factor`] of each lane, whose `normal` is asked for. `above`: no corner of the shooter's lies
/// below the receiver's horizon, and one well above it.
#[inline(always)]
pub fn form_factors(
    kind: FormFactor,
    shooter: &Shooter,
    above: bool,
    points: &Points,
    normal: impl Fn(usize) -> Vec3 + Copy,
    area: &[f32],
) -> Lane {
    let mut f = [0.0; LANES];
    match kind {
        FormFactor::Polygon => f = lambert(shooter, above, points, normal),
        FormFactor::Disc => {
            for (l, f) in f.iter_mut().enumerate() {
                *f = point_to_disc(shooter, points.at(l), normal(l), shooter.area);
            }
        }
        FormFactor::Paper => {
            for l in 0..LANES {
                f[l] = point_to_disc(shooter, points.at(l), normal(l), area[l]);
            }
        }
    }
    for (l, f) in f.iter_mut().enumerate() {
        let height = shooter.normal.dot(points.at(l) - shooter.centre);
        *f = if height <= CONTACT { 0.0 } else { *f };
    }
    f
}

/// Lambert's sum, and a point where the shooter is remote.
#[inline(always)]
fn lambert(
    shooter: &Shooter,
    above: bool,
    points: &Points,
    normal: impl Fn(usize) -> Vec3 + Copy,
) -> Lane {
    let mut f = [0.0; LANES];
    // Most shooters are nowhere remote: nothing is farther than the mesh's diagonal.
    let remote = if POINT * shooter.radius * DEPTH_SCALE < 1.0 {
        are_remote(shooter, points)
    } else {
        [false; LANES]
    };
    if remote.contains(&false) {
        f = sum(shooter, above, points, normal);
    }
    if remote.contains(&true) {
        for (l, f) in f.iter_mut().enumerate() {
            let point = point_to_disc(shooter, points.at(l), normal(l), 0.0);
            *f = if remote[l] { point } else { *f };
        }
    }
    f
}

#[inline(always)]
fn sum(shooter: &Shooter, above: bool, points: &Points, normal: impl Fn(usize) -> Vec3) -> Lane {
    let mut f = [0.0; LANES];
    if above {
        for (l, f) in f.iter_mut().enumerate() {
            *f = polygon_above(&shooter.corners, points.at(l), normal(l), false);
        }
        return f;
    }
    let (mut whole, mut some) = ([false; LANES], [false; LANES]);
    for l in 0..LANES {
        let (point, normal) = (points.at(l), normal(l));
        let heights = shooter.corners.map(|corner| normal.dot(corner - point));
        let lowest = heights.into_iter().fold(MISS, f32::min);
        let highest = heights.into_iter().fold(-MISS, f32::max);
        let front = shooter.normal.dot(point - shooter.centre) > CONTACT;
        some[l] = front && highest > CONTACT;
        whole[l] = some[l] && lowest > -CONTACT && !is_low(shooter, point, highest);
    }
    if whole.contains(&true) {
        for (l, f) in f.iter_mut().enumerate() {
            *f = polygon_above(&shooter.corners, points.at(l), normal(l), false);
        }
    }
    // The few that are to be clipped, one by one.
    for (l, f) in f.iter_mut().enumerate() {
        if !whole[l] {
            *f = match some[l] {
                true => polygon(shooter, points.at(l), normal(l)),
                false => 0.0,
            };
        }
    }
    f
}

#[inline(always)]
fn are_remote(shooter: &Shooter, points: &Points) -> [bool; LANES] {
    let mut result = [false; LANES];
    for (l, far_off) in result.iter_mut().enumerate() {
        let d = points.at(l) - shooter.centre;
        *far_off = remote(d.dot(d), shooter.radius);
    }
    result
}

#[inline(always)]
fn point_to_disc(shooter: &Shooter, position: Vec3, normal: Vec3, disc_area: f32) -> f32 {
    let d = position - shooter.centre;
    let r2 = d.dot(d);
    let r = r2.sqrt();
    let cos_i = shooter.normal.dot(d) / r;
    let cos_j = (-normal.dot(d) / r).max(0.0);
    disc(cos_i, cos_j, r2, shooter.area, disc_area)
}

/// Whether each texel is far from the cell at `centre`.
#[inline(always)]
pub fn are_far(receivers: &Receivers, first: usize, centre: Vec3, reach: f32) -> [bool; LANES] {
    let points = Points::centres(receivers, first);
    let mut result = [false; LANES];
    for (l, far_off) in result.iter_mut().enumerate() {
        *far_off = far(points.at(l), centre, reach);
    }
    result
}

/// The weight of each pair of points; nothing where no light arrives.
#[inline(always)]
pub fn weights(
    shooter: &Shooter,
    points: &Points,
    normal: impl Fn(usize) -> Vec3,
    (part, point_weight): (f32, f32),
    f: &Lane,
) -> Lane {
    let mut g = [0.0; LANES];
    for l in 0..LANES {
        let weight = weight(shooter, points.at(l), normal(l), part, f[l])
            * (points.weight[l] * point_weight);
        let height = shooter.normal.dot(points.at(l) - shooter.centre);
        let dark = (f[l] <= 0.0) | (height <= CONTACT);
        g[l] = if dark { 0.0 } else { weight };
    }
    g
}

/// Marks the lanes below whose horizon `q` lies.
#[inline(always)]
pub fn below(
    points: &Points,
    normal: impl Fn(usize) -> Vec3,
    q: Vec3,
    stopped: &mut [bool; LANES],
) {
    for (l, stopped) in stopped.iter_mut().enumerate() {
        *stopped |= normal(l).dot(points.at(l) - q) >= CONTACT;
    }
}

/// Marks the lanes whose ray from `q` the `face` stops: [`common::rays::Rays::visible`] of one face.
#[inline(always)]
pub fn stop(face: &MeshFace, q: Vec3, points: &Points, stopped: &mut [bool; LANES]) {
    for (l, stopped) in stopped.iter_mut().enumerate() {
        let p = points.at(l);
        let hit = meet(face.plane, face.edges, q, (p - q) / RAY_REACH);
        *stopped |= hit.between(RAY_REACH) & !touches(face, p);
    }
}
