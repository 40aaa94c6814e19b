//! Records of the hierarchical solve, byte for byte as `shaders/hierarchy_types.wgsl` has them.

pub use crate::records::ShotRecord;
use crate::records::{RecordLayout, record};
use glam::{Vec3, Vec4};

/// Spots of a block.
pub const BLOCK_SPOTS: u32 = 16;

/// State of a pair of a block and a node.
#[derive(Clone, Copy, PartialEq)]
pub enum PairState {
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
        /// The block.
        pub block: u32,
        /// The node.
        pub node: u32,
        /// [`PairState`].
        pub state: u32,
        /// Visibility samples that are requested.
        pub samples: u32,
        /// Samples that are known.
        pub known: u32,
        /// Points per side of a spot, of which its factor is the mean.
        pub places: u32,
        /// F at most.
        pub factor: f32,
        /// Light of the mean radiosity, reflected at F = 1.
        pub mean: f32,
        /// Light of the residual of the fit.
        pub rest: f32,
    }
}

impl PairRecord {
    /// Returns the pair of a block and a node; all else is the largest integer, or NaN, until it is computed.
    pub fn new(block: u32, node: u32) -> Self {
        let unknown = f32::from_bits(u32::MAX);
        Self {
            block,
            node,
            state: u32::MAX,
            samples: u32::MAX,
            known: u32::MAX,
            places: u32::MAX,
            factor: unknown,
            mean: unknown,
            rest: unknown,
        }
    }
}

record! {
    /// `Lane`.
    pub struct LaneRecord: "Lane" {
        /// Bounds of F and of the errors by variation, by slope, and within the spot.
        pub bound: [f32; 4],
        /// w·o.
        pub along: [f32; 2],
        /// F.
        pub factor: f32,
        /// w.
        pub weight: f32,
        /// A bit for each sample that is blocked.
        pub blocked: [u32; 2],
        /// F where some sample exchanges light.
        pub known: f32,
        /// Nothing.
        pub pad: u32,
    }
}

record! {
    /// `Request`.
    pub struct RequestRecord: "Request" {
        /// Largest error by the variation of a node's radiosity.
        pub source: f32,
        /// Largest error by partial visibility.
        pub visibility: f32,
        /// Largest error by the size of a spot.
        pub near: f32,
        /// Change at a shadow's edge that is followed.
        pub edge: f32,
        /// Blocks.
        pub blocks: u32,
        /// Most pairs.
        pub pairs: u32,
        /// Most links.
        pub links: u32,
        /// Nothing.
        pub pad: u32,
    }
}
