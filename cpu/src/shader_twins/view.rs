//! View of a shooter from a sample point, and the faces that its item buffer shows.

use crate::shader_twins::frame::{Frame, shooter_frame};
use common::mesh::{Mesh, MeshFace};
use common::settings::{ItemBufferProjection, ItemBufferSettings};

/// View from a sample point of a shooter: all that a raster pass needs beside the faces.
#[derive(Clone, Copy, Debug)]
pub struct ShooterView {
    /// The projection.
    pub projection: ItemBufferProjection,
    /// The shooter's frame.
    pub frame: Frame,
    /// The shooter's sheet: not drawn.
    pub sheet: u32,
    /// Pixels per side.
    pub size: u32,
    /// Scene units per mesh unit (Table 3's planes are in scene units).
    pub unit: f32,
}

impl ShooterView {
    /// Returns the view from sample point `s` of a patch.
    pub fn new(mesh: &Mesh, patch: u32, s: u32, drawing: &ItemBufferSettings) -> Self {
        let (frame, sheet) = view_sample(mesh, patch, s);
        Self {
            projection: drawing.projection,
            frame,
            sheet,
            size: drawing.size,
            unit: mesh.unit as f32,
        }
    }
}

/// Returns the frame at sample point `s` of a patch, and the patch's sheet.
pub fn view_sample(mesh: &Mesh, patch: u32, s: u32) -> (Frame, u32) {
    let face = &mesh.faces[mesh.patches[patch as usize].face as usize];
    let point = mesh.patch_points[(patch * mesh.samples + s) as usize];
    (shooter_frame(face, point.position), face.sheet)
}

/// Returns the number of faces of an item buffer with the objects.
pub fn view_all_faces(mesh: &Mesh) -> u32 {
    mesh.faces.len() as u32
}

/// Returns the first `count` faces, which an item buffer shows: the room comes before the objects.
pub fn select_faces(mesh: &Mesh, count: u32) -> &[MeshFace] {
    &mesh.faces[..count as usize]
}

/// IDs and depths of an item buffer that is being drawn.
pub struct ItemBufferTarget {
    size: u32,
    /// Face IDs + 1, row-major; 0 where no face was drawn.
    pub ids: Vec<u32>,
    depth: Vec<f32>,
}

impl ItemBufferTarget {
    /// Returns an empty target of `size`² pixels.
    pub fn new(size: u32) -> Self {
        let count = (size * size) as usize;
        Self {
            size,
            ids: vec![0; count],
            depth: vec![1.0; count],
        }
    }

    /// Draws face `id` in pixel (x, y), if it is the nearest there so far.
    pub fn draw_pixel(&mut self, id: u32, x: u32, y: u32, depth: f32) {
        let pixel = (y * self.size + x) as usize;
        if depth < self.depth[pixel] {
            self.depth[pixel] = depth;
            self.ids[pixel] = id + 1;
        }
    }
}
