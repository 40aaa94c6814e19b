//! [`common::form_factor::polygon_factor`] of a shooter that the horizons of several lanes cut: the same operations in the
//! same order, lane by lane, with the same bits.

use super::lane_points::{LanePoints, LaneValues};
use super::receivers::LANE_COUNT;
use common::form_factor::{Shooter, edge_term};
use glam::Vec3;
use std::f32::consts::PI;

/// [`common::form_factor::ClippedOutline`] of each lane.
struct ClippedOutlines {
    first: LanePoints,
    last: LanePoints,
    count: [u32; LANE_COUNT],
    /// Σ Γ_k·n of the edges between the corners so far.
    sum: LaneValues,
}

impl ClippedOutlines {
    /// Adds one more corner, relative to the lane's position, to lane `l` if `is_added`: without a branch.
    #[inline(always)]
    fn add_corner(&mut self, l: usize, corner: Vec3, normal: Vec3, low: bool, is_added: bool) {
        let is_first = is_added & (self.count[l] == 0);
        let is_next = is_added & (self.count[l] > 0);
        let sum = self.sum[l] + edge_term(self.last.at(l), corner, normal, low);
        self.sum[l] = if is_next { sum } else { self.sum[l] };
        self.first.put_if(l, corner, is_first);
        self.last.put_if(l, corner, is_added);
        self.count[l] += u32::from(is_added);
    }
}

/// Returns the form factors of a shooter that is `low` from all lanes that count, or from none.
#[inline(always)]
pub fn clipped_polygon_factors(
    shooter: &Shooter,
    points: &LanePoints,
    normal: impl Fn(usize) -> Vec3,
    low: bool,
) -> LaneValues {
    let none = LanePoints::new([[0.0; LANE_COUNT]; 3], [1.0; LANE_COUNT]);
    let mut outlines = ClippedOutlines {
        first: none,
        last: none,
        count: [0; LANE_COUNT],
        sum: [0.0; LANE_COUNT],
    };
    for k in 0..4 {
        let ends = [shooter.corners[(k + 3) % 4], shooter.corners[k]];
        for l in 0..LANE_COUNT {
            let (position, normal) = (points.at(l), normal(l));
            let [a, b] = ends.map(|corner| corner - position);
            let [height_a, height_b] = [a, b].map(|corner| normal.dot(corner));
            let crossing = a + (b - a) * (height_a / (height_a - height_b));
            let crosses = (height_a > 0.0) != (height_b > 0.0);
            outlines.add_corner(l, crossing, normal, low, crosses);
            outlines.add_corner(l, b, normal, low, height_b > 0.0);
        }
    }
    let mut f = [0.0; LANE_COUNT];
    for (l, f) in f.iter_mut().enumerate() {
        let closing = edge_term(outlines.last.at(l), outlines.first.at(l), normal(l), low);
        let factor = (-(outlines.sum[l] + closing) / (2.0 * PI)).max(0.0);
        *f = if outlines.count[l] < 3 { 0.0 } else { factor };
    }
    f
}
