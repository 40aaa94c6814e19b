//! From where a shooter looks, and the pixels in which it sees: what both rasters share.

use crate::twin::frame::Frame;
use common::mesh::Mesh;
use common::settings::{Drawing, Projection};

/// What a raster pass needs beside the faces.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The projection, and how faces are drawn.
    pub projection: Projection,
    /// The shooter's frame.
    pub frame: Frame,
    /// The shooter's sheet: not drawn.
    pub sheet: u32,
    /// Pixels per side.
    pub size: u32,
    /// Scene units per mesh unit (Table 3's planes are in scene units).
    pub unit: f32,
}

impl View {
    /// The view from point `s` of a cell.
    pub fn new(mesh: &Mesh, cell: u32, s: u32, drawing: &Drawing) -> Self {
        let (frame, sheet) = aim(mesh, cell, s);
        Self {
            projection: drawing.projection,
            frame,
            sheet,
            size: drawing.size,
            unit: mesh.unit as f32,
        }
    }
}

/// The frame at point `s` of a cell, and the cell's sheet: also where rays are asked from there.
pub fn aim(mesh: &Mesh, cell: u32, s: u32) -> (Frame, u32) {
    let face = &mesh.faces[mesh.cells[cell as usize].face as usize];
    let point = mesh.points[(cell * mesh.samples + s) as usize];
    (Frame::new(face, point.position), face.sheet)
}

/// IDs and depths under way.
pub struct Target {
    size: u32,
    /// Face IDs + 1, row-major; 0 where nothing was drawn.
    pub ids: Vec<u32>,
    depth: Vec<f32>,
}

impl Target {
    /// Nothing drawn, on `size`² pixels.
    pub fn new(size: u32) -> Self {
        let count = (size * size) as usize;
        Self {
            size,
            ids: vec![0; count],
            depth: vec![1.0; count],
        }
    }

    /// Face `id` in pixel (x, y), if it is the nearest there so far.
    pub fn write(&mut self, id: u32, x: u32, y: u32, depth: f32) {
        let pixel = (y * self.size + x) as usize;
        if depth < self.depth[pixel] {
            self.depth[pixel] = depth;
            self.ids[pixel] = id + 1;
        }
    }
}
