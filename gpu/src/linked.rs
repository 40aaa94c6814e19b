//! What is linked, in plain records: the Rust side of `shaders/hierarchy.wgsl`.

use crate::records::{Layout, ShotRecord, record};
use common::form_factor::Shooter;
use common::mesh::Mesh;
use glam::{Vec3, Vec4};
use std::ops::Range;

/// Spots of a block.
pub const SPOTS: u32 = 16;

/// What is done about a pair.
pub(crate) enum State {
    /// It exchanges nothing.
    Nothing,
    /// The node's parts are looked at.
    Cut,
    /// Its spots are still asked.
    Asked,
    /// It is a link.
    Link,
    /// And a shadow's edge crosses the block.
    Edge,
}

/// A node of the tree.
#[derive(Clone, Debug)]
pub struct Node {
    /// Geometry.
    pub shooter: Shooter,
    /// Its face.
    pub face: u32,
    /// The nodes that it consists of, which follow it; none of a leaf.
    pub children: Range<u32>,
}

impl Node {
    pub(crate) fn record(&self, mesh: &Mesh) -> ShotRecord {
        let face = &mesh.faces[self.face as usize];
        let parts = [self.children.start, self.children.len() as u32];
        ShotRecord::node(face, self.face, &self.shooter, parts)
    }
}

/// What links may leave out, of the RMS of the reflected light.
#[derive(Clone, Copy, Debug)]
pub struct Thresholds {
    /// By how a node's light varies.
    pub source: f32,
    /// By what stands between.
    pub visibility: f32,
    /// By a spot's size.
    pub near: f32,
}

/// Sixteen spots.
#[derive(Clone, Debug)]
pub struct Receiver {
    /// The last one again where there are fewer.
    pub spots: [SpotRecord; SPOTS as usize],
    /// How many there are, and what they share.
    pub block: BlockRecord,
}

/// What a block's spots receive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received {
    /// H.
    pub sums: [Vec3; SPOTS as usize],
    /// Whether a shadow's edge crosses it.
    pub edge: bool,
}

/// A node's link to a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// The node.
    pub node: u32,
    /// Of each spot: w, and w·o along tangent and bitangent.
    pub spots: [[f32; 3]; SPOTS as usize],
}

/// The layouts of all records.
pub const LAYOUTS: [Layout; 6] = [
    GlowRecord::LAYOUT,
    SpotRecord::LAYOUT,
    BlockRecord::LAYOUT,
    PairRecord::LAYOUT,
    LaneRecord::LAYOUT,
    AskedRecord::LAYOUT,
];

record! {
    /// `Glow`: what a node shines.
    pub struct GlowRecord: "Glow" {
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

impl GlowRecord {
    /// Mean, slopes along tangent and bitangent, and the RMS of what they leave.
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
    /// On `face`, which has this `normal`; it lights node `lit`.
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
    /// Of `count` spots no larger than `radius`; `scale` is reflectance over the RMS of the reflected light,
    /// `plane` that of the face on which all lie, or else 0.
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
    /// Of a block and a node; the rest is poison until it is known.
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
        stopped: [u32; 2],
        known: f32,
        pad: u32,
    }
}

record! {
    /// `Asked`.
    pub struct AskedRecord: "Asked" {
        pub(crate) source: f32,
        pub(crate) visibility: f32,
        pub(crate) near: f32,
        pub(crate) blocks: u32,
        pub(crate) pairs: u32,
        pub(crate) links: u32,
        pub(crate) pad: [u32; 2],
    }
}
