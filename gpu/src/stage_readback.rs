//! Read-backs for checks: rows of links, transfers, and the results of each stage.

use crate::probe::{LinkProbe, ProbedRow, ProbedSample};
use crate::solver::GpuSolver;
use bytemuck::pod_collect_to_vec;
use common::Result;

impl GpuSolver<'_> {
    /// Makes the links of a patch sample by sample; `each` receives the results of every sample.
    pub fn probe_links(&mut self, patch: u32, each: &mut dyn FnMut(ProbedSample)) -> Result<ProbedRow> {
        let probe = match self.probe.take() {
            Some(probe) => probe,
            None => LinkProbe::new(&self.context, self.maker.planted_faults())?,
        };
        if let Some(passes) = &mut self.passes {
            passes.forget_rows();
        }
        let row = probe.probe_links(&mut self.context, patch, each);
        self.probe = Some(probe);
        row
    }

    /// Reads the transfers from each of these patches to all patches, a row a patch, as solves by passes keep
    /// them; the links must have been made.
    pub fn read_transfers(&mut self, patches: &[u32]) -> Result<Vec<Vec<f32>>> {
        let (context, passes) = self.prepare_passes()?;
        let bytes = 4 * context.mesh.patches.len() as u64;
        let mut rows = Vec::with_capacity(patches.len());
        for patch in patches {
            let staging = context.host.staging_buffer(bytes);
            let mut encoder = context.host.command_encoder();
            let from = u64::from(*patch) * bytes;
            encoder.copy_buffer_to_buffer(&passes.slots.transfers, from, &staging, 0, bytes);
            rows.push(pod_collect_to_vec(&context.host.read_back(encoder, staging)?));
        }
        Ok(rows)
    }

    /// Reads the links of these patches to all texels, as solves by passes make and keep them.
    pub fn read_rows(&mut self, patches: &[u32]) -> Result<Vec<Vec<f32>>> {
        let (context, passes) = self.prepare_passes()?;
        let bytes = 4 * context.mesh.texels.len() as u64;
        let mut rows = Vec::with_capacity(patches.len());
        for patch in patches {
            passes.make_rows(context, &[*patch])?;
            let place = u64::from(patch % context.buffers.places);
            let staging = context.host.staging_buffer(bytes);
            let mut encoder = context.host.command_encoder();
            encoder.copy_buffer_to_buffer(&context.buffers.links, place * bytes, &staging, 0, bytes);
            rows.push(pod_collect_to_vec(&context.host.read_back(encoder, staging)?));
        }
        Ok(rows)
    }
}
