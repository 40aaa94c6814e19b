//! Read-backs for checks: rows of links, transfers, and the results of each stage.

use crate::probe::{LinkProbe, ProbedRow, ProbedSample};
use crate::solver::GpuSolver;
use common::Result;

impl GpuSolver<'_> {
    /// Makes the links of a patch sample by sample; `each` receives the results of every sample.
    pub fn probe_links(&mut self, patch: u32, each: &mut dyn FnMut(ProbedSample)) -> Result<ProbedRow> {
        let probe = match self.probe.take() {
            Some(probe) => probe,
            None => LinkProbe::new(&self.context, &self.maker.faults)?,
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
            let row = (&passes.slots.table["transfers"], u64::from(*patch) * bytes, bytes);
            rows.push(context.host.read_back(context.host.command_encoder(), &[row])?);
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
            let row = (&context.buffers.table["links"], place * bytes, bytes);
            rows.push(context.host.read_back(context.host.command_encoder(), &[row])?);
        }
        Ok(rows)
    }
}
