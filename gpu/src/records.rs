//! What the buffers hold, byte for byte: the Rust side of `shaders/types.wgsl`.

use bytemuck::Zeroable;
use common::form_factor::Shooter;
use common::mesh::{Cell, Mesh, MeshFace, Point, Texel};
#[cfg(doc)]
use common::shooting::Subtracted;
use common::shooting::{Rule, Shot};
use glam::Vec3;

/// Where the members of a shader's struct lie.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Its name in `types.wgsl`.
    pub name: &'static str,
    /// Bytes.
    pub size: usize,
    /// Each member's name and the bytes before it.
    pub members: &'static [(&'static str, usize)],
}

/// A record, and the layout by which a test holds the shader's struct to it.
macro_rules! record {
    ($(#[$doc:meta])* pub struct $name:ident: $wgsl:literal {
        $($visible:vis $member:ident: $kind:ty,)*
    }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name {
            $($visible $member: $kind,)*
        }

        impl $name {
            pub(crate) const LAYOUT: $crate::records::Layout = $crate::records::Layout {
                name: $wgsl,
                size: size_of::<Self>(),
                members: &[$((stringify!($member), std::mem::offset_of!(Self, $member)),)*],
            };
        }
    };
}
pub(crate) use record;

/// The layouts of all records.
pub const LAYOUTS: [Layout; 8] = [
    FaceRecord::LAYOUT,
    CellRecord::LAYOUT,
    TexelRecord::LAYOUT,
    PointRecord::LAYOUT,
    RowRecord::LAYOUT,
    LogRecord::LAYOUT,
    ShotRecord::LAYOUT,
    Params::LAYOUT,
];

record! {
    /// `Face`.
    pub struct FaceRecord: "Face" {
        plane: [f32; 4],
        tangent: [f32; 4],
        corners: [[f32; 4]; 4],
        edges: [[f32; 4]; 4],
        sheet: u32,
        two_sided: u32,
        resolution: [u32; 2],
    }
}

impl From<&MeshFace> for FaceRecord {
    fn from(face: &MeshFace) -> Self {
        Self {
            plane: face.plane.into(),
            tangent: face.tangent.extend(face.texel_radius).into(),
            corners: face.corners.map(|c| c.extend(0.0).into()),
            edges: face.edges.map(Into::into),
            sheet: face.sheet,
            two_sided: face.two_sided.into(),
            resolution: face.resolution,
        }
    }
}

record! {
    /// `Cell`.
    pub struct CellRecord: "Cell" {
        centre: [f32; 3],
        area: f32,
        corners: [[f32; 4]; 4],
        face: u32,
        first: u32,
        count: u32,
        open: f32,
        open_before: f32,
        radius: f32,
        pad: [u32; 2],
    }
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
            radius: cell.shooter.radius,
            pad: [0; 2],
        }
    }
}

record! {
    /// `Texel`.
    pub struct TexelRecord: "Texel" {
        position: [f32; 3],
        area: f32,
        reflectance: [f32; 3],
        face: u32,
        place: [u32; 2],
        kind: u32,
        pad: u32,
    }
}

impl From<&Texel> for TexelRecord {
    fn from(texel: &Texel) -> Self {
        Self {
            position: texel.position.into(),
            area: texel.area,
            reflectance: texel.reflectance.into(),
            face: texel.face,
            place: texel.place,
            kind: texel.kind as u32,
            pad: 0,
        }
    }
}

record! {
    /// `Point`.
    pub struct PointRecord: "Point" {
        position: [f32; 3],
        weight: f32,
        cover: u32,
        pad: [u32; 3],
    }
}

impl From<&Point> for PointRecord {
    fn from(point: &Point) -> Self {
        Self {
            position: point.position.into(),
            weight: point.weight,
            cover: point.cover as u32,
            pad: [0; 3],
        }
    }
}

/// The bits of `params.rule` that say which [`Subtracted`] it is.
pub const SUBTRACTED: u32 = 3;
/// The bit of `params.rule` for captured shots.
pub const CAPTURED: u32 = 4;
/// The bit of `params.rule` for a room that shoots on what it gains.
pub const KEEP: u32 = 8;

/// `params.rule`.
pub fn rule_bits(rule: Rule) -> u32 {
    let bit = |set: bool, bit: u32| if set { bit } else { 0 };
    rule.subtracted as u32 | bit(rule.captured, CAPTURED) | bit(rule.keep, KEEP)
}

record! {
    /// `Row`, whose links a place keeps.
    pub struct RowRecord: "Row" {
        cell: u32,
        sum: f32,
    }
}

record! {
    /// `Record`.
    pub struct LogRecord: "Record" {
        flux: [f32; 3],
        cell: u32,
        form_factor_sum: f32,
        escaped: f32,
        unshot: f32,
        pad: u32,
    }
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

record! {
    /// `Shot`, as the host writes those whose links are to be made, and reads them back.
    pub struct ShotRecord: "Shot" {
        centre: [f32; 3],
        area: f32,
        normal: [f32; 3],
        shooting: u32,
        tangent: [f32; 3],
        sheet: u32,
        bitangent: [f32; 3],
        face: u32,
        corners: [[f32; 4]; 4],
        radiosity: [f32; 3],
        pub cell: u32,
        flux: [f32; 3],
        first: u32,
        count: u32,
        sample: u32,
        next: u32,
        fresh: u32,
        place: u32,
        scale: f32,
        open: f32,
        drawn: u32,
        open_before: f32,
        pub taken: u32,
        pub sum: f32,
        pub escaped: f32,
        middle: [f32; 3],
        radius: f32,
    }
}

impl ShotRecord {
    /// A shot of nothing, for the sake of the cell's links, kept in one of `places`. The sums read
    /// as NaN until they are made.
    pub fn linking(mesh: &Mesh, index: u32, places: u32) -> Self {
        let cell = &mesh.cells[index as usize];
        Self {
            area: cell.shooter.area,
            shooting: 1,
            face: cell.face,
            corners: cell.shooter.corners.map(|c| c.extend(0.0).into()),
            cell: index,
            first: cell.first,
            count: cell.count,
            fresh: 1,
            place: index % places,
            open: cell.open,
            open_before: cell.open_before,
            taken: index * mesh.cells.len() as u32,
            sum: f32::NAN,
            escaped: f32::NAN,
            middle: cell.shooter.centre.into(),
            radius: cell.shooter.radius,
            ..Self::zeroed()
        }
    }

    /// A node of the hierarchical solve on `face`: its parts are `count` nodes, from `first`.
    pub fn node(face: &MeshFace, number: u32, shooter: &Shooter, [first, count]: [u32; 2]) -> Self {
        Self {
            area: shooter.area,
            normal: shooter.normal.into(),
            tangent: face.tangent.into(),
            bitangent: face.normal.cross(face.tangent).into(),
            sheet: face.sheet,
            face: number,
            corners: shooter.corners.map(|c| c.extend(0.0).into()),
            first,
            count,
            middle: shooter.centre.into(),
            radius: shooter.radius,
            ..Self::zeroed()
        }
    }

    /// From where the sample in hand looks.
    pub fn aim(&self) -> Aim {
        Aim {
            centre: self.centre.into(),
            normal: self.normal.into(),
            tangent: self.tangent.into(),
            bitangent: self.bitangent.into(),
            sheet: self.sheet,
        }
    }

    /// What the links are multiplied by.
    pub fn scale(&self) -> f32 {
        self.scale
    }
}

/// The frame of a shooter as `aim` leaves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The sample's point on the cell.
    pub centre: Vec3,
    /// The face's normal.
    pub normal: Vec3,
    /// x of the frame.
    pub tangent: Vec3,
    /// y of the frame.
    pub bitangent: Vec3,
    /// The sheet that is not drawn.
    pub sheet: u32,
}

/// Bytes of `Shot`.
pub const SHOT_BYTES: u64 = size_of::<ShotRecord>() as u64;
/// Bytes of `Row`.
pub const ROW_BYTES: u64 = size_of::<RowRecord>() as u64;
/// Bytes before the records of `Log`.
pub const LOG_COUNT_BYTES: u64 = 16;

record! {
    /// `Params`.
    pub struct Params: "Params" {
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
        pub tiles: u32,
        pub first: u32,
        pub end: u32,
        pub pad: u32,
    }
}
