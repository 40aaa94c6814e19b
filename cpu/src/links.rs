//! The links of the cells that have shot: they never change, so a second shot of a cell needs
//! neither rays nor raster. Beyond a budget the latest of the cells that share a place stays.

use common::constants::LINK_BYTES;
use common::mesh::Mesh;

/// A cell's links to all texels.
#[derive(Clone, Default)]
pub struct Row {
    /// The cell.
    pub cell: u32,
    /// F·V of each texel.
    pub links: Vec<f32>,
    /// What each cell takes: Σ w·A.
    pub taken: Vec<f32>,
    /// ΣF.
    pub sum: f32,
    /// The escaped share.
    pub escaped: f32,
}

/// Places for rows.
pub struct Links {
    rows: Vec<Option<Row>>,
}

impl Links {
    /// As many empty places as the budget holds, at least one.
    pub fn new(mesh: &Mesh) -> Self {
        let row = 4 * mesh.texels.len().max(1) as u64;
        let places = (LINK_BYTES / row).clamp(1, mesh.cells.len().max(1) as u64);
        Self {
            rows: vec![None; places as usize],
        }
    }

    /// The row of `cell`, made now if it is not there.
    pub fn row(&mut self, cell: u32, make: impl FnOnce(Vec<f32>) -> Row) -> &Row {
        let places = self.rows.len();
        let place = &mut self.rows[cell as usize % places];
        let row = match place.take() {
            Some(row) if row.cell == cell => row,
            other => make(other.map_or_else(Vec::new, |row| row.links)),
        };
        place.insert(row)
    }

    /// Makes the row of `cell` whether it is there or not.
    pub fn replace(&mut self, cell: u32, make: impl FnOnce(Vec<f32>) -> Row) {
        let places = self.rows.len();
        let place = &mut self.rows[cell as usize % places];
        let old = place.take().map_or_else(Vec::new, |row| row.links);
        *place = Some(make(old));
    }
}
