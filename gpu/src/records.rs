//! Records of the device buffers, byte for byte as `shaders/types.wgsl` has them.

use bytemuck::Zeroable;
use common::form_factor::Shooter;
use common::mesh::{Mesh, MeshFace, Patch, PatchPoint, Texel};
#[cfg(doc)]
use common::shooting::SubtractedLink;
use common::shooting::{DepositRule, Shot};
use glam::Vec3;
use std::ops::Range;

/// Offsets of the members of a shader's struct.
#[derive(Clone, Debug)]
pub struct RecordLayout {
    /// Its name in `types.wgsl`.
    pub name: &'static str,
    /// Bytes.
    pub size: usize,
    /// Each member's name and the bytes before it.
    pub members: &'static [(&'static str, usize)],
}

/// Defines a record, and the layout with which a test compares the shader's struct.
macro_rules! record {
    ($(#[$doc:meta])* pub struct $name:ident: $wgsl:literal {
        $($(#[$member_doc:meta])* $visible:vis $member:ident: $kind:ty,)*
    }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name {
            $($(#[$member_doc])* $visible $member: $kind,)*
        }

        impl $name {
            pub(crate) const LAYOUT: $crate::records::RecordLayout = $crate::records::RecordLayout {
                name: $wgsl,
                size: size_of::<Self>(),
                members: &[$((stringify!($member), std::mem::offset_of!(Self, $member)),)*],
            };
        }
    };
}
pub(crate) use record;

/// The layouts of all records.
pub const TRANSPORT_LAYOUTS: [RecordLayout; 8] = [
    FaceRecord::LAYOUT,
    PatchRecord::LAYOUT,
    TexelRecord::LAYOUT,
    PointRecord::LAYOUT,
    RowRecord::LAYOUT,
    LogRecord::LAYOUT,
    ShotRecord::LAYOUT,
    ShaderParams::LAYOUT,
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
    /// `Patch`.
    pub struct PatchRecord: "Patch" {
        centre: [f32; 3],
        area: f32,
        corners: [[f32; 4]; 4],
        face: u32,
        pub first: u32,
        pub count: u32,
        open: f32,
        open_before: f32,
        radius: f32,
        pad: [u32; 2],
    }
}

impl From<&Patch> for PatchRecord {
    fn from(patch: &Patch) -> Self {
        Self {
            centre: patch.shooter.centre.into(),
            area: patch.shooter.area,
            corners: patch.shooter.corners.map(|c| c.extend(0.0).into()),
            face: patch.face,
            first: patch.first,
            count: patch.count,
            open: patch.open_share,
            open_before: patch.room_open_share,
            radius: patch.shooter.radius,
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
            place: texel.lattice_corner,
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

impl From<&PatchPoint> for PointRecord {
    fn from(point: &PatchPoint) -> Self {
        Self {
            position: point.position.into(),
            weight: point.weight,
            cover: point.cover as u32,
            pad: [0; 3],
        }
    }
}

/// Bits of `params.rule` for [`SubtractedLink`].
pub const SUBTRACTED_BITS: u32 = 3;
/// Bit of `params.rule` for captured shots.
pub const CAPTURED_BIT: u32 = 4;
/// Bit of `params.rule` for a room that reflects the light it gains.
pub const KEEP_BIT: u32 = 8;
/// Bit of `params.rule`: the last sample of a link leaves its sums beside it, for checks of single stages.
pub const PROBE_BIT: u32 = 16;

/// Returns the bits of `params.rule`.
pub fn rule_bits(rule: DepositRule) -> u32 {
    let bit = |set: bool, bit: u32| if set { bit } else { 0 };
    rule.subtracted as u32 | bit(rule.captured, CAPTURED_BIT) | bit(rule.reshoot, KEEP_BIT)
}

record! {
    /// `Row`: the patch whose links a place keeps.
    pub struct RowRecord: "Row" {
        patch_index: u32,
        sum: f32,
    }
}

record! {
    /// `Record`.
    pub struct LogRecord: "Record" {
        flux: [f32; 3],
        patch_index: u32,
        form_factor_sum: f32,
        escaped: f32,
        unshot: f32,
        pad: u32,
    }
}

impl From<&LogRecord> for Shot {
    fn from(record: &LogRecord) -> Self {
        Self {
            patch: record.patch_index,
            power: record.flux,
            form_factor_sum: record.form_factor_sum,
            escaped: record.escaped,
            unshot: record.unshot,
        }
    }
}

record! {
    /// `Shot`: the host writes the shots whose links are to be made, and reads them back.
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
        pub(crate) patch_index: u32,
        flux: [f32; 3],
        pub(crate) first: u32,
        pub(crate) count: u32,
        sample: u32,
        next: u32,
        fresh: u32,
        place: u32,
        pub(crate) scale: f32,
        open: f32,
        drawn: u32,
        open_before: f32,
        pub(crate) transfer_start: u32,
        pub(crate) sum: f32,
        pub(crate) escaped: f32,
        middle: [f32; 3],
        radius: f32,
    }
}

impl ShotRecord {
    /// Returns a shot without light, for which the links of patch `index` are made and kept in one of `places`.
    /// The sums are NaN until they are made.
    pub fn for_links(mesh: &Mesh, index: u32, places: u32) -> Self {
        let patch = &mesh.patches[index as usize];
        Self {
            area: patch.shooter.area,
            shooting: 1,
            face: patch.face,
            corners: patch.shooter.corners.map(|c| c.extend(0.0).into()),
            patch_index: index,
            first: patch.first,
            count: patch.count,
            fresh: 1,
            place: index % places,
            open: patch.open_share,
            open_before: patch.room_open_share,
            transfer_start: index * mesh.patches.len() as u32,
            sum: f32::NAN,
            escaped: f32::NAN,
            middle: patch.shooter.centre.into(),
            radius: patch.shooter.radius,
            ..Self::zeroed()
        }
    }

    /// Returns a node of the hierarchical solve on face `number`; its child nodes follow it, none of a leaf.
    pub fn for_node(mesh: &Mesh, number: u32, shooter: &Shooter, children: &Range<u32>) -> Self {
        let face = &mesh.faces[number as usize];
        Self {
            area: shooter.area,
            normal: shooter.normal.into(),
            tangent: face.tangent.into(),
            bitangent: face.normal.cross(face.tangent).into(),
            sheet: face.sheet,
            face: number,
            corners: shooter.corners.map(|c| c.extend(0.0).into()),
            first: children.start,
            count: children.len() as u32,
            middle: shooter.centre.into(),
            radius: shooter.radius,
            ..Self::zeroed()
        }
    }

    /// Returns the frame of the current sample.
    pub fn sample_view(&self) -> SampleView {
        SampleView {
            centre: self.centre.into(),
            normal: self.normal.into(),
            tangent: self.tangent.into(),
            bitangent: self.bitangent.into(),
            sheet: self.sheet,
        }
    }
}

/// Frame of a shooter as `view.wgsl` sets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleView {
    /// The sample's point on the patch.
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
    pub struct ShaderParams: "Params" {
        pub texels: u32,
        pub patches: u32,
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
