//! Finds links on the GPU for the CPU's hierarchical solve; converts its requests and results to plain records.

use common::Result;
use common::passes::ProgressCallback;
use cpu::hierarchy::block::ReceiverBlock;
use cpu::hierarchy::coarse::StoredLink;
use cpu::hierarchy::linear_radiosity::LinearRadiosity;
use cpu::hierarchy::link::BlockLink;
use cpu::hierarchy::linker::{BlockIrradiance, LinkRequest, Linker, LinkerScene};
use glam::Vec4;
use gpu::hierarchy::gpu_linker;
use gpu::link_records::{
    BLOCK_SPOTS, BlockReceiver, BlockRecord, RadiosityRecord, ShotRecord, SpotIrradiance, SpotRecord,
};
use gpu::{Gpu, ShaderFault};
use std::cell::RefCell;

/// The GPU as a linker of the CPU's hierarchical solve.
pub struct LinkerOnGpu {
    linker: RefCell<gpu_linker::GpuLinker>,
    nodes: usize,
    /// Plane of each face.
    planes: Vec<Vec4>,
}

impl LinkerOnGpu {
    /// Uploads the scene and tree of `scene`. `faults` are planted into the shaders, for tests.
    ///
    /// Errors: [`common::Error::Device`].
    pub fn new(gpu: &Gpu, scene: &LinkerScene, faults: &[ShaderFault]) -> Result<Self> {
        let nodes = node_records(scene);
        let linker = gpu_linker::GpuLinker::new(gpu, scene.mesh, &nodes, &scene.tree.roots, faults)?;
        Ok(Self {
            linker: RefCell::new(linker),
            nodes: nodes.len(),
            planes: scene.mesh.faces.iter().map(|face| face.plane).collect(),
        })
    }

    /// Returns a factory that makes the linker for a scene.
    pub fn factory_on<'m>(
        gpu: &'m Gpu,
        faults: &'m [ShaderFault],
    ) -> impl for<'w> Fn(&LinkerScene<'w>) -> Result<Box<dyn Linker + 'w>> + 'm {
        move |scene| Ok(Box::new(Self::new(gpu, scene, faults)?))
    }

    /// Uploads the nodes' radiosity and the thresholds; returns the receivers' records.
    fn upload_request(&self, request: &LinkRequest) -> Vec<BlockReceiver> {
        let light = radiosity_records(&request.radiosity[..self.nodes]);
        let thresholds = request.thresholds;
        let thresholds = [
            thresholds.source,
            thresholds.visibility,
            thresholds.near,
            thresholds.edge,
        ];
        self.linker.borrow_mut().set_light(&light, thresholds);
        let blocks = request.receivers.blocks.iter();
        blocks
            .map(|block| receiver_record(request, block, &self.planes))
            .collect()
    }
}

impl Linker for LinkerOnGpu {
    fn gather_irradiance(&self, request: &LinkRequest, progress: ProgressCallback) -> Result<Vec<BlockIrradiance>> {
        let blocks = self.upload_request(request);
        let mut callback = |done| progress(request.progress_of(done));
        let light = self.linker.borrow_mut().gather_light(&blocks, &mut callback)?;
        Ok(light.iter().map(block_irradiance).collect())
    }

    fn create_links(&self, request: &LinkRequest, progress: ProgressCallback) -> Result<Vec<Vec<StoredLink>>> {
        let blocks = self.upload_request(request);
        let mut callback = |done| progress(request.progress_of(done));
        let links = self.linker.borrow_mut().make_links(&blocks, &mut callback)?;
        let of_block = |links: &Vec<gpu::link_records::DeviceLink>| links.iter().map(stored_link).collect();
        Ok(links.iter().map(of_block).collect())
    }
}

/// Returns the records of the nodes of a tree.
pub(crate) fn node_records(scene: &LinkerScene) -> Vec<ShotRecord> {
    let nodes = scene.tree.nodes.iter();
    nodes
        .map(|node| ShotRecord::for_node(scene.mesh, node.face, &node.shooter, &node.children))
        .collect()
}

/// Returns the records of the radiosity of nodes.
pub(crate) fn radiosity_records(radiosity: &[LinearRadiosity]) -> Vec<RadiosityRecord> {
    let nodes = radiosity.iter();
    nodes
        .map(|node| RadiosityRecord::new(node.mean, node.slope, node.deviation))
        .collect()
}

/// Returns the record of a block; `planes` are those of the faces.
pub(crate) fn receiver_record(request: &LinkRequest, block: &ReceiverBlock, planes: &[Vec4]) -> BlockReceiver {
    let centres = block.centre_points();
    let spot = |l: usize| {
        let corners = [0, 1, 2, 3].map(|k| block.lane_corner(k, l));
        let ends = [block.faces[l], block.target[l]];
        SpotRecord::new(corners, centres.at(l), ends, block.lane_normal(l))
    };
    let scale = request.block_scale(block);
    let plane = block.single_face().map(|face| planes[face as usize]);
    let (count, plane) = (block.count as u32, plane.unwrap_or_default());
    let bounding_ball = (block.mean_centre, block.reach);
    BlockReceiver {
        spots: std::array::from_fn(spot),
        block: BlockRecord::new(scale, block.radius, count, plane, bounding_ball),
    }
}

fn block_irradiance(received: &SpotIrradiance) -> BlockIrradiance {
    let lane = |c: usize| received.sums.map(|sum| sum[c]);
    BlockIrradiance {
        sums: [0, 1, 2].map(lane),
        crosses_shadow_edge: received.edge,
    }
}

fn stored_link(link: &gpu::link_records::DeviceLink) -> StoredLink {
    let lane = |part: usize| -> [f32; BLOCK_SPOTS as usize] { link.spots.map(|spot| spot[part]) };
    StoredLink {
        node: link.node,
        link: BlockLink {
            weight: lane(0),
            along: [lane(1), lane(2)],
        },
    }
}
