//! Marks behind the ends of buffers. A lane that a shader does not stop writes there; WGSL then allows any place of the
//! buffer, and a software adapter would hide it. On a device for checks the buffers that stages write are longer than their
//! elements, and there are more workgroups than are needed.

use crate::adapter::Gpu;
use crate::records::PatchRecord;
use crate::solver::GpuSolver;
use bytemuck::Zeroable;
use common::Result;
use common::constants::PATCH_SUM_LANES;
use glam::Vec4;

/// Elements behind the end of a buffer: one for each lane of a workgroup.
pub const ELEMENTS_BEHIND_END: usize = PATCH_SUM_LANES;
/// Words behind the end before a stage: NaN that no arithmetic makes.
pub const END_MARK: u32 = 0x7fc5_a5a5;

/// Buffers whose ends are marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkedBuffer {
    /// Radiosity of texels.
    Radiosity,
    /// Residual of texels.
    Residual,
    /// Irradiance of texels.
    Irradiance,
    /// Unshot power of patches.
    PatchPower,
    /// Transfers from the latest patch whose links were probed.
    Transfers,
    /// Flux that patches receive.
    Flux,
}

impl Gpu {
    /// Returns the elements that follow the end of a buffer: none but for checks.
    pub(crate) fn elements_behind_end(&self) -> usize {
        if self.is_for_checks() { ELEMENTS_BEHIND_END } else { 0 }
    }

    /// Returns the records that follow the patches: one of a texel behind the last, so that who takes it for a patch writes there.
    pub(crate) fn patches_behind_end(&self, texels: usize) -> Vec<PatchRecord> {
        let mut patches = vec![PatchRecord::zeroed(); self.elements_behind_end()];
        if let Some(first) = patches.first_mut() {
            (first.first, first.count) = (texels as u32, 1);
        }
        patches
    }
}

impl GpuSolver<'_> {
    /// Marks the words behind the end of a buffer; of one that does not exist yet, nothing.
    pub fn mark_end(&self, which: MarkedBuffer) {
        if let Some((buffer, end)) = self.find_end(which) {
            let marks = vec![END_MARK; (buffer.size() - end) as usize / 4];
            self.context.host.write_at(buffer, end, &marks);
        }
    }

    /// Awaits the words behind the end of a buffer; none but on a device for checks.
    pub async fn request_end(&mut self, which: MarkedBuffer) -> Result<Vec<u32>> {
        let Some((buffer, end)) = self.find_end(which).map(|(buffer, end)| (buffer.clone(), end)) else {
            return Ok(Vec::new());
        };
        let host = &mut self.context.host;
        let range = (&buffer, end, buffer.size() - end);
        host.request_values(host.command_encoder(), &[range]).await
    }

    /// Returns a buffer and the byte at which its elements end, if there are bytes behind.
    fn find_end(&self, which: MarkedBuffer) -> Option<(&wgpu::Buffer, u64)> {
        let (mesh, table) = (self.context.mesh, &self.context.buffers.table);
        let [texels, patches] = [mesh.texels.len(), mesh.patches.len()].map(|count| count as u64);
        let vector = size_of::<Vec4>() as u64;
        let (buffer, end) = match which {
            MarkedBuffer::Radiosity => (&table["radiosity"], vector * texels),
            MarkedBuffer::Residual => (&table["residual"], vector * texels),
            MarkedBuffer::Irradiance => (&table["irradiance"], vector * texels),
            MarkedBuffer::PatchPower => (&table["sums"], vector * patches),
            MarkedBuffer::Transfers => (self.probe.as_ref()?.transfers(), 4 * patches),
            MarkedBuffer::Flux => (self.passes.as_ref()?.flux(), vector * patches),
        };
        (buffer.size() > end).then_some((buffer, end))
    }
}
