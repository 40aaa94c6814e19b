//! Read-backs for checks: rows of links, transfers, the results and times of each stage, and races.

use crate::adapter::Gpu;
use crate::device_queue::DeviceQueue;
use crate::dispatch_arguments::DISPATCH_BYTES;
use crate::probe::{BufferChange, LinkProbe, ProbedRow, ProbedSample};
use crate::solver::GpuSolver;
use crate::solver_context::SolverContext;
use common::Result;
use stage_check::races::RaceReport;

impl Gpu {
    /// Awaits what each shader file with workgroup memory has counted so far, in the order of a solve; nothing of a device
    /// without a log of races.
    ///
    /// Errors: the device fails.
    pub async fn request_races(&self) -> Result<Vec<(&'static str, RaceReport)>> {
        let Some(log) = &self.watch_log else {
            return Ok(Vec::new());
        };
        // A loop without an end would be an error.
        let mut host = DeviceQueue::new(&self.without_log());
        let range = (&log.buffer, 0, log.buffer.size());
        let words: Vec<u32> = host.request_values(host.command_encoder(), &[range]).await?;
        Ok(log.race_reports(&words))
    }
}

impl<'a> GpuSolver<'a> {
    /// Makes the links of a patch by the solver's rule, sample by sample; `each` receives the results of every sample.
    pub fn probe_links(&mut self, patch: u32, each: &mut dyn FnMut(ProbedSample)) -> Result<ProbedRow> {
        pollster::block_on(self.request_probed_links(patch, each))
    }

    /// Awaits the links of [`Self::probe_links`].
    pub async fn request_probed_links(&mut self, patch: u32, each: &mut dyn FnMut(ProbedSample)) -> Result<ProbedRow> {
        let rule = self.rule;
        let (probe, context) = self.prepare_probe()?;
        probe.request_links(context, (patch, rule), each).await
    }

    /// Awaits the first sample of a patch by its item buffer after each of so many changes; `each` receives the results.
    /// The links must be made again. With visibility by rays nothing is made.
    pub async fn request_changed_buffers(
        &mut self,
        patch: u32,
        changes: (u32, BufferChange<'_>),
        each: &mut dyn FnMut(ProbedSample),
    ) -> Result<()> {
        let (probe, context) = self.prepare_probe()?;
        probe.request_changed_buffers(context, patch, changes, each).await
    }

    /// Returns the seconds that each step of the links of a patch takes alone.
    pub fn time_link_steps(&mut self, patch: u32) -> Result<Vec<(&'static str, f64)>> {
        let (probe, context) = self.prepare_probe()?;
        probe.time_steps(context, patch)
    }

    /// Returns the probe, which overwrites kept links, and the context; makes it when the first check begins.
    fn prepare_probe(&mut self) -> Result<(&LinkProbe, &mut SolverContext<'a>)> {
        let probe = match self.probe.take() {
            Some(probe) => probe,
            None => LinkProbe::new(&self.context, &self.maker.faults)?,
        };
        if let Some(passes) = &mut self.passes {
            passes.forget_rows();
        }
        Ok((self.probe.insert(probe), &mut self.context))
    }

    /// Awaits the workgroups that the latest selection counted for the stages of the next shot (deposit, escape, power,
    /// links, transfer), each beside those of a stage that has work.
    pub async fn request_counted_workgroups(&mut self) -> Result<Vec<[[u32; 3]; 2]>> {
        let host = &mut self.context.host;
        let range = (&self.context.buffers.table["dispatches"], 0, DISPATCH_BYTES);
        let counted: Vec<[u32; 3]> = host.request_values(host.command_encoder(), &[range]).await?;
        let [texels, directions, patches] = self.context.workgroup_counts();
        let all = [texels, directions, patches, texels, patches];
        Ok(counted
            .into_iter()
            .zip(all)
            .map(|(counted, all)| [counted, all])
            .collect())
    }

    /// Awaits the number of vertices that the latest shot has drawn of each item buffer: six for each side of a face.
    pub async fn request_drawn_vertices(&mut self) -> Result<u32> {
        let host = &mut self.context.host;
        let drawn = (&self.slots.table["rectangles"], 0, 4);
        let words: Vec<u32> = host.request_values(host.command_encoder(), &[drawn]).await?;
        Ok(words[0])
    }

    /// Awaits the transfers from each of these patches to all patches, a row a patch, as solves by passes keep
    /// them; the links must have been made.
    pub async fn request_transfers(&mut self, patches: &[u32]) -> Result<Vec<Vec<f32>>> {
        let (context, passes) = self.prepare_passes()?;
        let bytes = 4 * context.mesh.patches.len() as u64;
        let mut rows = Vec::with_capacity(patches.len());
        for patch in patches {
            let row = (&passes.slots.table["transfers"], u64::from(*patch) * bytes, bytes);
            let encoder = context.host.command_encoder();
            rows.push(context.host.request_values(encoder, &[row]).await?);
        }
        Ok(rows)
    }

    /// Reads the links of these patches to all texels, as solves by passes make and keep them.
    pub fn read_rows(&mut self, patches: &[u32]) -> Result<Vec<Vec<f32>>> {
        pollster::block_on(self.request_rows(patches))
    }

    /// Awaits the links of [`Self::read_rows`].
    pub async fn request_rows(&mut self, patches: &[u32]) -> Result<Vec<Vec<f32>>> {
        let (context, passes) = self.prepare_passes()?;
        let bytes = 4 * context.mesh.texels.len() as u64;
        let mut rows = Vec::with_capacity(patches.len());
        for patch in patches {
            passes.request_rows(context, &[*patch]).await?;
            let place = u64::from(patch % context.buffers.places);
            let row = (&context.buffers.table["links"], place * bytes, bytes);
            let encoder = context.host.command_encoder();
            rows.push(context.host.request_values(encoder, &[row]).await?);
        }
        Ok(rows)
    }
}
