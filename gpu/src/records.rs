//! What the buffers hold, byte for byte: the Rust side of `shaders/types.wgsl`.

use bytemuck::{Pod, Zeroable};
use common::mesh::{Cell, Cover, MeshFace, Point, Texel, TexelKind};
use common::shooting::{Had, Rule, Shot};

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct FaceRecord {
    plane: [f32; 4],
    tangent: [f32; 4],
    corners: [[f32; 4]; 4],
    edges: [[f32; 4]; 4],
    sheet: u32,
    two_sided: u32,
    resolution: [u32; 2],
}

impl From<&MeshFace> for FaceRecord {
    fn from(face: &MeshFace) -> Self {
        Self {
            plane: face.plane.into(),
            tangent: face.tangent.extend(0.0).into(),
            corners: face.corners.map(|c| c.extend(0.0).into()),
            edges: face.edges.map(Into::into),
            sheet: face.sheet,
            two_sided: face.two_sided.into(),
            resolution: face.resolution,
        }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct CellRecord {
    centre: [f32; 3],
    area: f32,
    corners: [[f32; 4]; 4],
    face: u32,
    first: u32,
    count: u32,
    open: f32,
    open_before: f32,
    pad: [u32; 3],
}

impl From<&Cell> for CellRecord {
    fn from(cell: &Cell) -> Self {
        Self {
            centre: cell.shooter.centre.into(),
            area: cell.shooter.area,
            corners: cell.shooter.corners.map(|c| c.extend(0.0).into()),
            face: cell.face,
            first: cell.first,
            count: cell.count,
            open: cell.open,
            open_before: cell.open_before,
            pad: [0; 3],
        }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct TexelRecord {
    position: [f32; 3],
    area: f32,
    reflectance: [f32; 3],
    face: u32,
    place: [u32; 2],
    kind: u32,
    pad: u32,
}

impl From<&Texel> for TexelRecord {
    fn from(texel: &Texel) -> Self {
        Self {
            position: texel.position.into(),
            area: texel.area,
            reflectance: texel.reflectance.into(),
            face: texel.face,
            place: texel.place,
            kind: match texel.kind {
                TexelKind::Quad => 0,
                TexelKind::Upright => 1,
                TexelKind::Inverted => 2,
            },
            pad: 0,
        }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct PointRecord {
    position: [f32; 3],
    weight: f32,
    cover: u32,
    pad: [u32; 3],
}

impl From<&Point> for PointRecord {
    fn from(point: &Point) -> Self {
        Self {
            position: point.position.into(),
            weight: point.weight,
            cover: match point.cover {
                Cover::Open => 0,
                Cover::Object => 1,
                Cover::Room => 2,
            },
            pad: [0; 3],
        }
    }
}

/// `params.rule`: which of the four [`Had`] it is, and two bits.
pub fn rule_bits(rule: Rule) -> u32 {
    let had = match rule.had {
        Had::Nothing => 0,
        Had::Before => 1,
        Had::Unhidden => 2,
        Had::All => 3,
    };
    had | u32::from(rule.captured) << 2 | u32::from(rule.keep) << 3
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct LogRecord {
    flux: [f32; 3],
    cell: u32,
    form_factor_sum: f32,
    escaped: f32,
    unshot: f32,
    pad: u32,
}

impl From<&LogRecord> for Shot {
    fn from(record: &LogRecord) -> Self {
        Self {
            cell: record.cell,
            power: record.flux,
            form_factor_sum: record.form_factor_sum,
            escaped: record.escaped,
            unshot: record.unshot,
        }
    }
}

/// Bytes of `Shot`, the shot in flight.
pub const SHOT_BYTES: u64 = 208;
/// Bytes of `Row`, whose links a place keeps.
pub const ROW_BYTES: u64 = 8;
/// Bytes before the records of `Log`.
pub const LOG_HEAD_BYTES: u64 = 16;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct Params {
    pub texels: u32,
    pub cells: u32,
    pub faces: u32,
    pub replay: u32,
    pub threshold: f32,
    pub unit: f32,
    pub places: u32,
    pub step: u32,
    pub samples: u32,
    pub conserve: u32,
    pub room: u32,
    pub rule: u32,
    pub groups: [[u32; 4]; 3],
}
