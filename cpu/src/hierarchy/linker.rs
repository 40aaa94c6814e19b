//! The interface between the solver and the linkers that find its links: the scene, the request, and the
//! trait [`Linker`]. The CPU's linker is [`crate::hierarchy::cpu_linker`]; a GPU implements the same trait.

use crate::hierarchy::block::{ReceiverBlock, ReceiverBlocks};
use crate::hierarchy::coarse::StoredLink;
use crate::hierarchy::linear_radiosity::LinearRadiosity;
use crate::hierarchy::tree::TexelTree;
use crate::occlusion::occluders::Occluders;
use crate::rows::lane_points::LaneValues;
use common::Result;
use common::mesh::Mesh;
use common::passes::ProgressCallback;
use common::rays::Rays;
use glam::Vec3;
use pulp::Arch;
use std::ops::Range;

/// The scene with everything that linking needs.
#[derive(Clone, Copy)]
pub struct LinkerScene<'a> {
    /// Faces.
    pub mesh: &'a Mesh,
    /// Sources: the nodes of each face.
    pub tree: &'a TexelTree,
    /// All faces, for rays.
    pub rays: &'a Rays,
    /// All faces, for shafts and shadows.
    pub occluders: &'a Occluders,
    /// The widest registers.
    pub arch: Arch,
}

/// The light that is gathered.
#[derive(Clone, Copy)]
pub enum RequestedLight<'a> {
    /// Light that arrives.
    Arriving,
    /// Light that would arrive in the room alone and that these objects occlude.
    OccludedBy(&'a Occluders),
}

/// Light is linear where it deviates from its prediction by no more than this many thresholds.
pub const MAX_LINEAR_DEVIATION: f32 = 4.0;

/// Change at the edge of a soft shadow that is followed, in `source` thresholds: about half of it is linear.
const SOFT_EDGE_CHANGE: f32 = 2.0 * MAX_LINEAR_DEVIATION;

/// Errors that a link may have, relative to the RMS of the reflected light.
#[derive(Clone, Copy, Debug)]
pub struct LinkThresholds {
    /// From the variation of radiosity over the source.
    pub source: f32,
    /// From sampled visibility.
    pub visibility: f32,
    /// From the size of a receiver spot, and from what hides just the bright part of a source.
    pub near: f32,
    /// Change at a shadow's edge that is followed.
    pub edge: f32,
}

impl LinkThresholds {
    /// Returns the allowed errors times `factor`.
    pub fn scaled_by(self, factor: f32) -> Self {
        Self {
            source: self.source * factor,
            visibility: self.visibility * factor,
            near: self.near * factor,
            edge: self.edge * factor,
        }
    }

    /// Returns the thresholds for light from all sides, whose shadows are soft.
    pub fn with_soft_edges(self) -> Self {
        Self {
            edge: SOFT_EDGE_CHANGE * self.source,
            ..self
        }
    }
}

/// A request for all links of some receivers.
pub struct LinkRequest<'a> {
    /// Light that is gathered.
    pub light: RequestedLight<'a>,
    /// Radiosity of every node.
    pub radiosity: &'a [LinearRadiosity],
    /// Allowed errors of a link.
    pub thresholds: LinkThresholds,
    /// Receivers.
    pub receivers: &'a ReceiverBlocks,
    /// A face's reflectance over the RMS of the reflected light, by channel.
    pub scale: &'a (dyn Fn(u32) -> Vec3 + Sync),
    /// Range of the solve's progress that this request covers.
    pub progress: Range<f64>,
}

impl LinkRequest<'_> {
    /// Returns the scale of a block: the largest of its faces.
    pub fn block_scale(&self, block: &ReceiverBlock) -> Vec3 {
        let faces = block.faces[..block.count].iter();
        faces.fold(Vec3::ZERO, |most, face| most.max((self.scale)(*face)))
    }

    /// Returns the solve's progress after `done` blocks.
    pub fn progress_of(&self, done: usize) -> f64 {
        let share = done as f64 / self.receivers.blocks.len().max(1) as f64;
        self.progress.start + share * (self.progress.end - self.progress.start)
    }
}

/// Irradiance of a block's lanes.
#[derive(Clone)]
pub struct BlockIrradiance {
    /// H by channel and lane.
    pub sums: [LaneValues; 3],
    /// A shadow edge crosses the block: its spots may differ by much.
    pub crosses_shadow_edge: bool,
}

/// Finds links.
pub trait Linker {
    /// Returns the irradiance of each block.
    ///
    /// Errors: [`common::Error::Interrupted`]; of a device.
    fn gather_irradiance(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<BlockIrradiance>>;

    /// Returns the links of each block.
    ///
    /// Errors: [`common::Error::Interrupted`]; of a device.
    fn create_links(&self, request: &LinkRequest, watch: ProgressCallback) -> Result<Vec<Vec<StoredLink>>>;
}

/// Makes a linker for a prepared scene.
pub type LinkerFactory<'m> = &'m dyn for<'w> Fn(&LinkerScene<'w>) -> Result<Box<dyn Linker + 'w>>;

/// The method by which links are found.
#[derive(Clone, Copy)]
pub enum LinkMethod<'m> {
    /// Shafts where they pay.
    Shafts,
    /// Rays alone, face by face and level by level, as on a GPU.
    Rays,
    /// Another linker.
    Custom(LinkerFactory<'m>),
}

impl LinkMethod<'_> {
    /// Returns the method's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shafts => "shafts",
            Self::Rays => "rays",
            Self::Custom(_) => "a device",
        }
    }
}
