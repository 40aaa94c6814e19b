//! What every way to solve works with.

use crate::buffers::Buffers;
use crate::host::Host;
use crate::records::{Params, rule_bits};
use crate::slots::Slots;
use bytemuck::Zeroable;
use common::constants::LANES;
use common::escape::DIRECTIONS;
use common::mesh::Mesh;
use common::settings::Transport;
use common::shooting::Rule;

/// The queue, and what lies on the device.
pub struct Context<'a> {
    pub host: Host,
    pub mesh: &'a Mesh,
    pub transport: Transport,
    pub buffers: Buffers,
}

impl Context<'_> {
    /// What the shaders are told of a solve.
    pub fn params(&self, slots: &Slots, rule: Rule) -> Params {
        Params {
            texels: self.mesh.texels.len() as u32,
            cells: self.mesh.cells.len() as u32,
            faces: self.mesh.faces.len() as u32,
            unit: self.mesh.unit as f32,
            places: self.buffers.places,
            step: slots.step,
            samples: self.mesh.samples,
            conserve: self.transport.conserve.into(),
            room: self.mesh.room,
            rule: rule_bits(rule),
            groups: self.groups(),
            tiles: slots.tiles,
            ..Params::zeroed()
        }
    }

    /// Workgroups over texels, directions and cells.
    pub fn groups(&self) -> [[u32; 4]; 3] {
        [
            self.host.groups(self.mesh.texels.len().div_ceil(LANES)),
            self.host.groups(DIRECTIONS.div_ceil(LANES)),
            self.host.groups(self.mesh.cells.len()),
        ]
    }
}
