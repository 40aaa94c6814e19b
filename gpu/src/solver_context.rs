//! Context of a solver: queue, mesh, settings and buffers.

use crate::device_queue::DeviceQueue;
use crate::records::{ShaderParams, rule_bits};
use crate::shot_slots::ShotSlots;
use crate::solver_buffers::SolverBuffers;
use bytemuck::Zeroable;
use common::constants::PATCH_SUM_LANES;
use common::escape::ESCAPE_DIRECTION_COUNT;
use common::mesh::Mesh;
use common::settings::Transport;
use common::shooting::DepositRule;

/// Queue, mesh, settings and device buffers of a solve.
pub struct SolverContext<'a> {
    pub host: DeviceQueue,
    pub mesh: &'a Mesh,
    pub transport: Transport,
    pub buffers: SolverBuffers,
}

impl SolverContext<'_> {
    /// Returns the parameters of the shaders.
    pub fn shader_params(&self, slots: &ShotSlots, rule: DepositRule) -> ShaderParams {
        ShaderParams {
            texels: self.mesh.texels.len() as u32,
            patches: self.mesh.patches.len() as u32,
            faces: self.mesh.faces.len() as u32,
            unit: self.mesh.unit as f32,
            places: self.buffers.places,
            step: slots.step,
            samples: self.mesh.samples,
            conserve: self.transport.conserve.into(),
            room: self.mesh.room_faces,
            rule: rule_bits(rule),
            groups: self.workgroup_counts().map(|[x, y, z]| [x, y, z, 0]),
            tiles: slots.tiles,
            ..ShaderParams::zeroed()
        }
    }

    /// Returns workgroups over texels, directions and patches; for checks a second row over texels and patches, which has
    /// nothing to do.
    pub fn workgroup_counts(&self) -> [[u32; 3]; 3] {
        let (texels, patches) = (self.mesh.texels.len(), self.mesh.patches.len());
        let lanes = PATCH_SUM_LANES;
        let groups = [texels.div_ceil(lanes), ESCAPE_DIRECTION_COUNT.div_ceil(lanes), patches];
        let mut groups = groups.map(|count| self.host.split_workgroups(count));
        if self.host.gpu.is_for_checks() {
            groups[0][1] *= 2;
            groups[2][1] *= 2;
        }
        groups
    }
}
