//! Frame of a shooter: origin at its point, z along its normal.

use common::mesh::MeshFace;
use glam::Vec3;

/// A shooter's frame.
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

/// Returns the frame of a shooter at `centre` on `face`.
pub fn shooter_frame(face: &MeshFace, centre: Vec3) -> Frame {
    Frame {
        centre,
        tangent: face.tangent,
        bitangent: face.normal.cross(face.tangent),
        normal: face.normal,
    }
}

impl Frame {
    /// Returns `point` in the frame.
    pub fn to_local(self, point: Vec3) -> Vec3 {
        self.rotate_to_local(point - self.centre)
    }

    /// Returns a direction of the mesh in the frame.
    pub fn rotate_to_local(&self, d: Vec3) -> Vec3 {
        Vec3::new(self.tangent.dot(d), self.bitangent.dot(d), self.normal.dot(d))
    }

    /// Returns a direction of the frame in the mesh.
    pub fn to_world(self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}
