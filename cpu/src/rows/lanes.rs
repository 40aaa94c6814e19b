//! [`crate::rows::texel_link::add_sample`] for a block of texels at once: the same operations in the same order,
//! lane by lane, with the same bits. Plain loops over arrays, which the compiler vectorises for the registers of the
//! caller's [`pulp::Arch`].

use crate::rows::clipped_lanes::clipped_polygon_factors;
use crate::rows::lane_points::{LanePoints, LaneValues};
use crate::rows::receivers::{LANE_COUNT, TexelArrays};
use common::constants::{CONTACT_DISTANCE, DEPTH_SCALE, MISS_DISTANCE, POINT_SOURCE_RADII, RAY_REACH};
use common::form_factor::{
    FormFactor, Shooter, disc_factor, is_far, is_low, is_remote, point_weight, polygon_factor_above,
};
use common::intersect::{intersect_planes, touches_plane};
use common::mesh::MeshFace;
use common::rays::start_near;
use glam::Vec3;

/// [`common::form_factor::form_factor`] of each lane. `above`: no corner of the shooter lies below the
/// receiver's horizon, and one lies well above it.
#[inline(always)]
pub fn lane_form_factors(
    kind: FormFactor,
    shooter: &Shooter,
    above: bool,
    points: &LanePoints,
    normal: impl Fn(usize) -> Vec3 + Copy,
    area: &[f32],
) -> LaneValues {
    let mut f = [0.0; LANE_COUNT];
    match kind {
        FormFactor::Polygon => f = lambert_factor(shooter, above, points, normal),
        FormFactor::Disc => {
            for (l, f) in f.iter_mut().enumerate() {
                *f = point_to_disc(shooter, points.at(l), normal(l), shooter.area);
            }
        }
        FormFactor::Paper => {
            for l in 0..LANE_COUNT {
                f[l] = point_to_disc(shooter, points.at(l), normal(l), area[l]);
            }
        }
    }
    for (l, f) in f.iter_mut().enumerate() {
        let height = shooter.normal.dot(points.at(l) - shooter.centre);
        *f = if height <= CONTACT_DISTANCE { 0.0 } else { *f };
    }
    f
}

/// Returns Lambert's form factor of each lane, of a point source where the shooter is remote. `above`: the
/// shooter lies above the horizon of every lane.
#[inline(always)]
pub fn lambert_factor(
    shooter: &Shooter,
    above: bool,
    points: &LanePoints,
    normal: impl Fn(usize) -> Vec3 + Copy,
) -> LaneValues {
    let mut f = [0.0; LANE_COUNT];
    // Most shooters are remote from no point: the mesh's diagonal is the largest distance.
    let remote = if POINT_SOURCE_RADII * shooter.radius * DEPTH_SCALE < 1.0 {
        are_remote(shooter, points)
    } else {
        [false; LANE_COUNT]
    };
    if remote.contains(&false) {
        f = lambert_sums(shooter, above, points, normal);
    }
    if remote.contains(&true) {
        for (l, f) in f.iter_mut().enumerate() {
            let point = point_to_disc(shooter, points.at(l), normal(l), 0.0);
            *f = if remote[l] { point } else { *f };
        }
    }
    f
}

/// Returns Lambert's sums over the edges of the shooter, clipped to the horizon of each lane.
#[inline(always)]
pub fn lambert_sums(shooter: &Shooter, above: bool, points: &LanePoints, normal: impl Fn(usize) -> Vec3) -> LaneValues {
    let mut f = [0.0; LANE_COUNT];
    if above {
        return whole_polygon_factors(shooter, points, &normal, false);
    }
    let mut visible = [false; LANE_COUNT];
    let (mut whole, mut low) = (visible, visible);
    for l in 0..LANE_COUNT {
        let (point, normal) = (points.at(l), normal(l));
        let heights = shooter.corners.map(|corner| normal.dot(corner - point));
        let lowest = heights.into_iter().fold(MISS_DISTANCE, f32::min);
        let highest = heights.into_iter().fold(-MISS_DISTANCE, f32::max);
        let front = shooter.normal.dot(point - shooter.centre) > CONTACT_DISTANCE;
        visible[l] = front && highest > CONTACT_DISTANCE;
        whole[l] = lowest > -CONTACT_DISTANCE;
        low[l] = is_low(shooter, point, highest);
    }
    // Each way is taken for all lanes at once, if any needs it.
    for (is_whole, is_low) in [(true, false), (true, true), (false, false), (false, true)] {
        let chosen: [bool; LANE_COUNT] =
            std::array::from_fn(|l| visible[l] & (whole[l] == is_whole) & (low[l] == is_low));
        if !chosen.contains(&true) {
            continue;
        }
        let all = match (is_whole, is_low) {
            (true, false) => whole_polygon_factors(shooter, points, &normal, false),
            (true, true) => whole_polygon_factors(shooter, points, &normal, true),
            (false, false) => clipped_polygon_factors(shooter, points, &normal, false),
            (false, true) => clipped_polygon_factors(shooter, points, &normal, true),
        };
        for l in 0..LANE_COUNT {
            f[l] = if chosen[l] { all[l] } else { f[l] };
        }
    }
    f
}

/// Returns [`polygon_factor_above`] of each lane.
#[inline(always)]
fn whole_polygon_factors(
    shooter: &Shooter,
    points: &LanePoints,
    normal: impl Fn(usize) -> Vec3,
    low: bool,
) -> LaneValues {
    let mut f = [0.0; LANE_COUNT];
    for (l, f) in f.iter_mut().enumerate() {
        *f = polygon_factor_above(&shooter.corners, points.at(l), normal(l), low);
    }
    f
}

/// Returns the lanes from which the shooter is remote.
#[inline(always)]
pub fn are_remote(shooter: &Shooter, points: &LanePoints) -> [bool; LANE_COUNT] {
    let mut result = [false; LANE_COUNT];
    for (l, far_off) in result.iter_mut().enumerate() {
        let d = points.at(l) - shooter.centre;
        *far_off = is_remote(d.dot(d), shooter.radius);
    }
    result
}

/// Returns the form factor of a disc of `disc_area`.
#[inline(always)]
pub fn point_to_disc(shooter: &Shooter, position: Vec3, normal: Vec3, disc_area: f32) -> f32 {
    let d = position - shooter.centre;
    let r2 = d.dot(d);
    let r = r2.sqrt();
    let cos_i = shooter.normal.dot(d) / r;
    let cos_j = (-normal.dot(d) / r).max(0.0);
    disc_factor(cos_i, cos_j, r2, shooter.area, disc_area)
}

/// Marks the texels that are far from the patch at `centre`.
#[inline(always)]
pub fn are_far(receivers: &TexelArrays, first: usize, centre: Vec3, reach: f32) -> [bool; LANE_COUNT] {
    let points = LanePoints::texel_centres(receivers, first);
    let mut result = [false; LANE_COUNT];
    for (l, far_off) in result.iter_mut().enumerate() {
        *far_off = is_far(points.at(l), centre, reach);
    }
    result
}

/// Returns the weight of each point pair; 0 where no light arrives.
#[inline(always)]
pub fn pair_weights(
    shooter: &Shooter,
    points: &LanePoints,
    normal: impl Fn(usize) -> Vec3,
    (part, area_weight): (f32, f32),
    f: &LaneValues,
) -> LaneValues {
    let mut g = [0.0; LANE_COUNT];
    for l in 0..LANE_COUNT {
        let weight = point_weight(shooter, points.at(l), normal(l), part, f[l]) * (points.weight[l] * area_weight);
        let height = shooter.normal.dot(points.at(l) - shooter.centre);
        let dark = (f[l] <= 0.0) | (height <= CONTACT_DISTANCE);
        g[l] = if dark { 0.0 } else { weight };
    }
    g
}

/// Marks the lanes whose horizon `q` lies below.
#[inline(always)]
pub fn mark_below_horizon(
    points: &LanePoints,
    normal: impl Fn(usize) -> Vec3,
    q: Vec3,
    blocked: &mut [bool; LANE_COUNT],
) {
    for (l, blocked) in blocked.iter_mut().enumerate() {
        *blocked |= normal(l).dot(points.at(l) - q) >= CONTACT_DISTANCE;
    }
}

/// Marks the lanes whose ray from `q` the `face` blocks: [`common::rays::Rays::is_visible`] of one face.
#[inline(always)]
pub fn mark_blocked(face: &MeshFace, q: Vec3, points: &LanePoints, blocked: &mut [bool; LANE_COUNT]) {
    let (plane, edges) = (face.plane, face.edges);
    for (l, blocked) in blocked.iter_mut().enumerate() {
        let p = points.at(l);
        let [from, to] = start_near(q, p);
        let hit = intersect_planes(plane, edges, from, (to - from) / RAY_REACH);
        *blocked |= hit.stops_ray(RAY_REACH) & !touches_plane(face, p);
    }
}
