//! Where a shooter stands and how it looks. Twin of `gpu/src/shaders/frame.wgsl`.

use common::mesh::MeshFace;
use glam::Vec3;

/// A shooter's frame: z along the normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Origin: the shooter's centre.
    pub centre: Vec3,
    /// x.
    pub tangent: Vec3,
    /// y.
    pub bitangent: Vec3,
    /// z.
    pub normal: Vec3,
}

impl Frame {
    /// The frame of a shooter at `centre` on `face`.
    pub fn new(face: &MeshFace, centre: Vec3) -> Self {
        Self {
            centre,
            tangent: face.tangent,
            bitangent: face.normal.cross(face.tangent),
            normal: face.normal,
        }
    }

    /// `point` in the frame.
    pub fn to_local(self, point: Vec3) -> Vec3 {
        self.turn(point - self.centre)
    }

    /// A direction of the mesh in the frame.
    pub fn turn(&self, d: Vec3) -> Vec3 {
        Vec3::new(
            self.tangent.dot(d),
            self.bitangent.dot(d),
            self.normal.dot(d),
        )
    }

    /// A direction of the frame in the mesh.
    pub fn to_world(self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}
