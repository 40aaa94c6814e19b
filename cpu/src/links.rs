//! A cache of each patch's links to all texels, its row: links never change, so a patch that shoots again needs no new
//! visibility. Beyond a memory budget patches share slots, and a newer row replaces an older one.

use common::constants::MAX_LINK_BYTES;
use common::mesh::Mesh;
use common::passes::PatchClosure;
use common::{Error, Result};

/// A row in a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredRow {
    /// Number of the patch.
    pub patch: u32,
    /// Sum of the form factors, and the share of the patch's hemisphere that meets no front.
    pub closure: PatchClosure,
}

/// The links of a patch to all texels.
#[derive(Clone, Copy, Debug)]
pub struct LinkRow<'a> {
    /// Sum of the form factors, and the share of the patch's hemisphere that meets no front.
    pub closure: PatchClosure,
    /// w_ji of each texel j from the shooting patch i: share of the patch's radiosity that the texel receives.
    pub links: &'a [f32],
}

/// A slot for a row that is to be computed.
pub struct RowSlot<'a> {
    /// Number of the patch.
    pub patch: u32,
    /// Entry of the row: the caller sets it when the row is complete.
    pub entry: &'a mut Option<StoredRow>,
    /// Links of the row.
    pub links: &'a mut [f32],
    /// Share of the row's light that each patch receives; empty if exchanges are not stored.
    pub exchanges: &'a mut [f32],
}

/// All slots.
pub struct LinkCache {
    entries: Vec<Option<StoredRow>>,
    /// Links, row after row; memory pages not yet written take no RAM.
    values: Vec<f32>,
    texels: usize,
    /// Exchange matrix T of the patches, row after row: shares of a patch's light that each patch receives. Empty until
    /// exchanges are stored.
    exchanges: Vec<f32>,
    patches: usize,
}

impl LinkCache {
    /// Makes as many slots as the budget holds, at least one.
    pub fn new(mesh: &Mesh) -> Self {
        let row = 4 * mesh.texels.len().max(1) as u64;
        let slots = (MAX_LINK_BYTES / row).clamp(1, mesh.patches.len().max(1) as u64) as usize;
        Self {
            entries: vec![None; slots],
            values: vec![0.0; slots * mesh.texels.len()],
            texels: mesh.texels.len(),
            exchanges: Vec::new(),
            patches: mesh.patches.len(),
        }
    }

    /// Returns true if the exchange matrix fits into the budget.
    pub fn exchanges_fit(&self) -> bool {
        4 * (self.patches as u64).pow(2) <= MAX_LINK_BYTES
    }

    /// Stores exchanges from now on; earlier rows are dropped.
    pub fn enable_exchanges(&mut self) {
        if self.exchanges.is_empty() {
            self.exchanges = vec![0.0; self.patches * self.patches];
            self.entries.fill(None);
        }
    }

    /// Returns the rows of the exchange matrix.
    pub fn exchange_rows(&self) -> impl Iterator<Item = &[f32]> {
        self.exchanges.chunks(self.patches.max(1))
    }

    /// Returns the number of slots.
    pub fn slot_count(&self) -> usize {
        self.entries.len()
    }

    /// Returns the row of `patch`, if it is stored.
    pub fn stored_row(&self, patch: u32) -> Option<LinkRow<'_>> {
        let slot = patch as usize % self.slot_count();
        let entry = self.entries[slot].filter(|entry| entry.patch == patch)?;
        Some(LinkRow {
            closure: entry.closure,
            links: &self.values[slot * self.texels..(slot + 1) * self.texels],
        })
    }

    /// Returns the row of `patch`.
    ///
    /// Errors: the row is not stored.
    pub fn require_row(&self, patch: u32) -> Result<LinkRow<'_>> {
        let missing = || Error::Fault(format!("the links of patch {patch} are not in the cache"));
        self.stored_row(patch).ok_or_else(missing)
    }

    /// Returns the slots of `patches`, which must ascend; last − first must be below the number of slots.
    pub fn slots_of(&mut self, patches: &[u32]) -> Vec<RowSlot<'_>> {
        let count = self.slot_count();
        let rows = self.entries.iter_mut().zip(self.values.chunks_mut(self.texels.max(1)));
        let mut rows: Vec<_> = rows.map(Some).collect();
        let mut exchanges = self.exchanges.chunks_mut(self.patches.max(1)).enumerate();
        patches
            .iter()
            .filter_map(|patch| {
                let (entry, links) = rows[*patch as usize % count].take()?;
                let own = exchanges.find(|(k, _)| *k == *patch as usize);
                Some(RowSlot {
                    patch: *patch,
                    entry,
                    links,
                    exchanges: own.map_or_else(Default::default, |(_, exchanges)| exchanges),
                })
            })
            .collect()
    }
}
