//! The links of the cells that have shot: they never change, so a second shot of a cell needs
//! neither rays nor raster. Beyond a budget the latest of the cells that share a place stays.

use common::constants::LINK_BYTES;
use common::mesh::Mesh;
use common::passes::Closure;
use common::{Error, Result};

/// What is known of the row in a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptRow {
    /// The cell.
    pub cell: u32,
    /// ΣF and the escaped share.
    pub closure: Closure,
}

/// A cell's links to all texels.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// ΣF and the escaped share.
    pub closure: Closure,
    /// w_ji of each texel.
    pub links: &'a [f32],
}

/// A place for a row that is to be made.
pub struct Place<'a> {
    /// For which cell.
    pub cell: u32,
    /// What is known of it afterwards.
    pub kept: &'a mut Option<KeptRow>,
    /// Its links.
    pub links: &'a mut [f32],
    /// What it brings to each cell, where that is kept.
    pub taken: &'a mut [f32],
}

/// Places for rows.
pub struct Links {
    kept: Vec<Option<KeptRow>>,
    /// Row after row; pages that no row has touched take no memory.
    values: Vec<f32>,
    texels: usize,
    /// T: what each cell takes of each one, cell after cell; empty until cells exchange.
    taken: Vec<f32>,
    cells: usize,
}

impl Links {
    /// As many empty places as the budget holds, at least one.
    pub fn new(mesh: &Mesh) -> Self {
        let row = 4 * mesh.texels.len().max(1) as u64;
        let places = (LINK_BYTES / row).clamp(1, mesh.cells.len().max(1) as u64) as usize;
        Self {
            kept: vec![None; places],
            values: vec![0.0; places * mesh.texels.len()],
            texels: mesh.texels.len(),
            taken: Vec::new(),
            cells: mesh.cells.len(),
        }
    }

    /// Whether there is room for what all cells take of each other.
    pub fn has_room(&self) -> bool {
        4 * (self.cells as u64).pow(2) <= LINK_BYTES
    }

    /// From now on keeps what the cells take; rows made before are forgotten.
    pub fn exchange(&mut self) {
        if self.taken.is_empty() {
            self.taken = vec![0.0; self.cells * self.cells];
            self.kept.fill(None);
        }
    }

    /// What the cells take of each one.
    pub fn taken(&self) -> impl Iterator<Item = &[f32]> {
        self.taken.chunks(self.cells.max(1))
    }

    /// How many rows can be kept at once.
    pub fn places(&self) -> usize {
        self.kept.len()
    }

    /// The row of `cell`, if it is kept.
    pub fn row(&self, cell: u32) -> Option<Row<'_>> {
        let place = cell as usize % self.places();
        let kept = self.kept[place].filter(|kept| kept.cell == cell)?;
        Some(Row {
            closure: kept.closure,
            links: &self.values[place * self.texels..(place + 1) * self.texels],
        })
    }

    /// The row of `cell`, which has been made.
    pub fn made(&self, cell: u32) -> Result<Row<'_>> {
        let missing = || Error::Fault(format!("the links of cell {cell} were not made"));
        self.row(cell).ok_or_else(missing)
    }

    /// The places of `cells`, in rising order and no more than there are places between the first
    /// and the last.
    pub fn places_of(&mut self, cells: &[u32]) -> Vec<Place<'_>> {
        let count = self.places();
        let rows = self
            .kept
            .iter_mut()
            .zip(self.values.chunks_mut(self.texels.max(1)));
        let mut rows: Vec<_> = rows.map(Some).collect();
        let mut taken = self.taken.chunks_mut(self.cells.max(1)).enumerate();
        cells
            .iter()
            .filter_map(|cell| {
                let (kept, links) = rows[*cell as usize % count].take()?;
                let own = taken.find(|(k, _)| *k == *cell as usize);
                Some(Place {
                    cell: *cell,
                    kept,
                    links,
                    taken: own.map_or_else(Default::default, |(_, taken)| taken),
                })
            })
            .collect()
    }
}
