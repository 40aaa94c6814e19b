//! Records of the hierarchical solve, byte for byte as `shaders/hierarchy_types.wgsl` has them.

pub use crate::records::ShotRecord;
use crate::records::{RecordLayout, record};
use glam::{Vec3, Vec4};

/// Spots of a block.
pub const BLOCK_SPOTS: u32 = 16;

/// State of a pair of a block and a node.
pub(crate) enum PairState {
    /// Exchanges nothing.
    Skip,
    /// Is replaced by pairs with the node's children.
    Subdivide,
    /// Awaits results of its spots.
    Pending,
    /// Is a link.
    Link,
    /// Is a link, and a shadow's edge crosses the block.
    Edge,
}

/// Sixteen spots.
#[derive(Clone, Debug)]
pub struct BlockReceiver {
    /// The last one again where there are fewer.
    pub spots: [SpotRecord; BLOCK_SPOTS as usize],
    /// Number of spots, and their common data.
    pub block: BlockRecord,
}

/// Irradiance of a block's spots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotIrradiance {
    /// H.
    pub sums: [Vec3; BLOCK_SPOTS as usize],
    /// True where a shadow's edge crosses the block.
    pub edge: bool,
}

/// A node's link to a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceLink {
    /// The node.
    pub node: u32,
    /// For each spot w, and w·o along tangent and bitangent.
    pub spots: [[f32; 3]; BLOCK_SPOTS as usize],
}

/// The layouts of all records.
pub const LINK_LAYOUTS: [RecordLayout; 6] = [
    RadiosityRecord::LAYOUT,
    SpotRecord::LAYOUT,
    BlockRecord::LAYOUT,
    PairRecord::LAYOUT,
    LaneRecord::LAYOUT,
    RequestRecord::LAYOUT,
];

record! {
    /// `Radiosity`: linear radiosity of a node.
    pub struct RadiosityRecord: "Radiosity" {
        mean: [f32; 3],
        pad0: u32,
        slope_x: [f32; 3],
        pad1: u32,
        slope_y: [f32; 3],
        pad2: u32,
        rest: [f32; 3],
        pad3: u32,
    }
}

impl RadiosityRecord {
    /// Returns mean, slopes along tangent and bitangent, and the RMS of the residual of that fit.
    pub fn new(mean: Vec3, [x, y]: [Vec3; 2], rest: Vec3) -> Self {
        Self {
            mean: mean.into(),
            pad0: 0,
            slope_x: x.into(),
            pad1: 0,
            slope_y: y.into(),
            pad2: 0,
            rest: rest.into(),
            pad3: 0,
        }
    }
}

record! {
    /// `Spot`.
    #[derive(Debug)]
    pub struct SpotRecord: "Spot" {
        corners: [[f32; 4]; 4],
        centre: [f32; 3],
        face: u32,
        normal: [f32; 3],
        lit: u32,
    }
}

impl SpotRecord {
    /// Returns a spot on `face`, which has this `normal`; its light goes to node `lit`.
    pub fn new(corners: [Vec3; 4], centre: Vec3, [face, lit]: [u32; 2], normal: Vec3) -> Self {
        Self {
            corners: corners.map(|c| c.extend(0.0).into()),
            centre: centre.into(),
            face,
            normal: normal.into(),
            lit,
        }
    }
}

record! {
    /// `Block`.
    #[derive(Debug)]
    pub struct BlockRecord: "Block" {
        scale: [f32; 3],
        radius: f32,
        plane: [f32; 4],
        middle: [f32; 3],
        reach: f32,
        count: u32,
        pad: [u32; 3],
    }
}

impl BlockRecord {
    /// Returns a block of `count` spots no larger than `radius` within `ball`; `scale` is reflectance over the
    /// RMS of the reflected light, `plane` that of the face on which all lie, or else 0.
    pub fn new(scale: Vec3, radius: f32, count: u32, plane: Vec4, ball: (Vec3, f32)) -> Self {
        Self {
            scale: scale.into(),
            radius,
            plane: plane.into(),
            middle: ball.0.into(),
            reach: ball.1,
            count,
            pad: [0; 3],
        }
    }
}

record! {
    /// `Pair`.
    pub struct PairRecord: "Pair" {
        pub(crate) block: u32,
        pub(crate) node: u32,
        state: u32,
        samples: u32,
        known: u32,
        places: u32,
        factor: f32,
        mean: f32,
        rest: f32,
    }
}

impl PairRecord {
    /// Returns the pair of a block and a node; all else is NaN or the largest integer until it is computed.
    pub(crate) fn new(block: u32, node: u32) -> Self {
        Self {
            block,
            node,
            state: u32::MAX,
            samples: u32::MAX,
            known: u32::MAX,
            places: u32::MAX,
            factor: f32::NAN,
            mean: f32::NAN,
            rest: f32::NAN,
        }
    }
}

record! {
    /// `Lane`.
    pub struct LaneRecord: "Lane" {
        bound: [f32; 4],
        along: [f32; 2],
        factor: f32,
        weight: f32,
        blocked: [u32; 2],
        known: f32,
        pad: u32,
    }
}

record! {
    /// `Request`.
    pub struct RequestRecord: "Request" {
        pub(crate) source: f32,
        pub(crate) visibility: f32,
        pub(crate) near: f32,
        pub(crate) blocks: u32,
        pub(crate) pairs: u32,
        pub(crate) links: u32,
        pub(crate) pad: [u32; 2],
    }
}
