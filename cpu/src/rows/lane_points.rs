//! Values and points of a block of texels, one per lane.

use crate::rows::receivers::{LANE_COUNT, TexelArrays, TexelBlock};
use common::mesh::{MeshFace, TexelKind};
use common::sampling::{near_point_uv, texel_uv};
use common::texel_point::point_on_texel;
use glam::Vec3;

/// One value per lane.
pub type LaneValues = [f32; LANE_COUNT];

/// One point per lane.
#[derive(Clone, Copy)]
pub struct LanePoints {
    x: LaneValues,
    y: LaneValues,
    z: LaneValues,
    /// Area that each point represents over the mean.
    pub weight: LaneValues,
}

impl LanePoints {
    /// Makes points of coordinates.
    #[inline(always)]
    pub fn new([x, y, z]: [LaneValues; 3], weight: LaneValues) -> Self {
        Self { x, y, z, weight }
    }

    /// Returns the point of lane `l`.
    #[inline(always)]
    pub fn at(&self, l: usize) -> Vec3 {
        Vec3::new(self.x[l], self.y[l], self.z[l])
    }

    /// Replaces the point of lane `l` if `is_replaced`.
    #[inline(always)]
    pub fn put_if(&mut self, l: usize, point: Vec3, is_replaced: bool) {
        for (values, x) in [&mut self.x, &mut self.y, &mut self.z]
            .into_iter()
            .zip(point.to_array())
        {
            values[l] = if is_replaced { x } else { values[l] };
        }
    }

    /// Returns the texels' centres.
    #[inline(always)]
    pub fn texel_centres(receivers: &TexelArrays, first: usize) -> Self {
        let lane = |axis: usize| -> LaneValues {
            let mut lane = [0.0; LANE_COUNT];
            lane.copy_from_slice(&receivers.centre[axis][first..first + LANE_COUNT]);
            lane
        };
        Self {
            x: lane(0),
            y: lane(1),
            z: lane(2),
            weight: [1.0; LANE_COUNT],
        }
    }

    /// Returns sample point `s` of each texel against patch `patch`.
    #[inline(always)]
    pub fn texel_samples(receivers: &TexelArrays, face: &MeshFace, block: &TexelBlock, patch: u32, s: u32) -> Self {
        Self::of_quads_or_not(receivers, face, block, |k, _| texel_uv(s, k as u32, patch))
    }

    /// Returns point `place` of the grid on each texel.
    #[inline(always)]
    pub fn grid_points(receivers: &TexelArrays, face: &MeshFace, block: &TexelBlock, place: u32) -> Self {
        Self::of_quads_or_not(receivers, face, block, |_, kind| near_point_uv(place, kind))
    }

    #[inline(always)]
    fn of_quads_or_not(
        receivers: &TexelArrays,
        face: &MeshFace,
        block: &TexelBlock,
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
        receivers: &TexelArrays,
        face: &MeshFace,
        block: &TexelBlock,
        uv: impl Fn(usize, TexelKind) -> [f32; 2],
        kind: impl Fn(usize) -> TexelKind,
    ) -> Self {
        let mut points = Self {
            x: [0.0; LANE_COUNT],
            y: [0.0; LANE_COUNT],
            z: [0.0; LANE_COUNT],
            weight: [1.0; LANE_COUNT],
        };
        let first = block.first;
        let [i, j] = [0, 1].map(|axis| &receivers.place[axis][first..first + LANE_COUNT]);
        let area = &receivers.area[first..first + LANE_COUNT];
        for l in 0..LANE_COUNT {
            let kind = kind(first + l);
            let p = point_on_texel(face, kind, [i[l], j[l]], area[l], uv(first + l, kind));
            (points.x[l], points.y[l], points.z[l], points.weight[l]) = (p.x, p.y, p.z, p.w);
        }
        points
    }
}
