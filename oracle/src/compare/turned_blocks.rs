//! Judges blocks whose light or links differ between two linkers: how far rounding may move them, and whether it turns a
//! decision of the CPU, too, where faces are moved or thresholds changed by rounding.

use super::link_stages::factor_sizes;
use super::roundings::{MAX_BLOCK_ROUNDINGS, MAX_END_ROUNDINGS};
use common::Result;
use common::mesh::{Mesh, MeshFace};
use common::precision::UNIT_ROUNDOFF;
use common::rays::Rays;
use cpu::hierarchy::block::ReceiverBlocks;
use cpu::hierarchy::cpu_linker::CpuLinker;
use cpu::hierarchy::linker::{LinkRequest, Linker, LinkerScene};
use glam::Vec3;
use std::cell::OnceCell;
use std::ops::ControlFlow;

/// Directions in which faces are moved.
const MOVES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// A block of a request, with the others of its task: a thread links them together.
pub struct BlockTask<'r> {
    scene: LinkerScene<'r>,
    request: &'r LinkRequest<'r>,
    receivers: ReceiverBlocks,
    /// Number of the block in its task.
    index: usize,
}

impl<'r> BlockTask<'r> {
    /// Returns the task of block number `block`.
    pub fn of_block(scene: &LinkerScene<'r>, request: &'r LinkRequest<'r>, block: usize) -> Self {
        let tasks = &request.receivers.tasks;
        let blocks = tasks.iter().find(|blocks| blocks.contains(&block)).cloned();
        let blocks = blocks.unwrap_or(block..block + 1);
        Self {
            scene: *scene,
            request,
            index: block - blocks.start,
            receivers: ReceiverBlocks {
                tasks: std::iter::once(0..blocks.len()).collect(),
                blocks: request.receivers.blocks[blocks].to_vec(),
            },
        }
    }

    /// Returns the size of each link of the block on the CPU, to which rounding is relative: the largest form factor without its
    /// cosines. Beside it the link's node.
    ///
    /// Errors: those of the linker.
    pub fn link_sizes(&self) -> Result<Vec<(usize, f32)>> {
        let linker = self.linker(self.scene.rays);
        let links = linker.create_links(&self.request_by(1.0), &mut |_| ControlFlow::Continue(()))?;
        let block = &self.receivers.blocks[self.index];
        let size = |node: usize| {
            let sizes = factor_sizes(&self.scene.tree.nodes[node].shooter, block);
            sizes[..block.count].iter().fold(0.0f32, |most, size| most.max(*size))
        };
        let nodes = links[self.index].iter().map(|stored| stored.node as usize);
        Ok(nodes.map(|node| (node, size(node))).collect())
    }

    /// Finds the block's links once for each move of the faces and each change of the thresholds; calls `each` with what is found.
    ///
    /// Errors: those of `find`.
    pub fn find_moved<T>(
        &self,
        moved: &MovedFaces,
        find: impl Fn(&dyn Linker, &LinkRequest) -> Result<Vec<T>>,
        mut each: impl FnMut(&T),
    ) -> Result<()> {
        let change = (MAX_BLOCK_ROUNDINGS * UNIT_ROUNDOFF) as f32;
        let rays = moved.rays.get_or_init(|| move_faces(self.scene.mesh));
        let moved = rays.iter().map(|rays| (rays, 1.0));
        let changed = [1.0 - change, 1.0 + change].map(|factor| (self.scene.rays, factor));
        for (rays, factor) in moved.chain(changed) {
            let found = find(&self.linker(rays), &self.request_by(factor))?;
            found.get(self.index).into_iter().for_each(&mut each);
        }
        Ok(())
    }

    fn linker<'s>(&'s self, rays: &'s Rays) -> CpuLinker<'s> {
        CpuLinker {
            scene: LinkerScene { rays, ..self.scene },
            rays_only: true,
        }
    }

    /// Returns the request for this task alone, with its thresholds times `factor`.
    fn request_by(&self, factor: f32) -> LinkRequest<'_> {
        LinkRequest {
            light: self.request.light,
            radiosity: self.request.radiosity,
            thresholds: self.request.thresholds.scaled_by(factor),
            receivers: &self.receivers,
            scale: self.request.scale,
            progress: self.request.progress.clone(),
        }
    }
}

/// The faces of a scene after each move, made when first needed.
#[derive(Default)]
pub struct MovedFaces {
    rays: OnceCell<Vec<Rays>>,
}

/// Returns rays among all faces of a mesh, after each move by the roundings of a ray's end.
fn move_faces(mesh: &Mesh) -> Vec<Rays> {
    let step = MAX_END_ROUNDINGS * f32::EPSILON;
    let moved = |direction: Vec3| {
        let mut moved = mesh.clone();
        for face in &mut moved.faces {
            move_face(face, direction * step);
        }
        Rays::new(&moved)
    };
    MOVES.map(moved).into()
}

fn move_face(face: &mut MeshFace, by: Vec3) {
    face.corners = face.corners.map(|corner| corner + by);
    for plane in face.edges.iter_mut().chain([&mut face.plane]) {
        plane.w += plane.truncate().dot(by);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};
    use glam::DVec3;

    #[test]
    fn moved_faces_turn_rays_beside_their_edges() {
        let quad = |z: f64, half: f64| {
            let corner = |x: f64, y: f64| DVec3::new(x * half, y * half, z);
            let corners = [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ];
            Face::quad("quad", corners, Vec3::ONE, Vec3::ZERO)
        };
        let scene = Scene {
            faces: vec![quad(-1.0, 1.0), quad(0.0, 0.25), quad(1.0, 1.0).reversed()],
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        let seen = |rays: &Rays, x: f32| rays.is_visible(Vec3::new(x, 0.0, -0.9), Vec3::new(x, 0.0, 0.9), [0, 2]);
        let outside = 0.25 + 0.5 * MAX_END_ROUNDINGS * f32::EPSILON;
        let (unmoved, moved) = (Rays::new(&mesh), move_faces(&mesh));
        for (x, turns) in [(outside, 1), (0.25 + 1e-3, 0), (0.25 - 1e-3, 0)] {
            let turned = moved.iter().filter(|rays| seen(rays, x) != seen(&unmoved, x));
            assert_eq!(turned.count(), turns, "{x}");
        }
    }
}
