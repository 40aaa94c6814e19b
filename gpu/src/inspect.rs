//! What checks read of a solver beyond its answer: rows of links, and what each stage leaves behind.

use crate::probe::{Probe, Row, Sample};
use crate::solver::GpuSolver;
use bytemuck::pod_collect_to_vec;
use common::Result;

impl GpuSolver<'_> {
    /// Makes the links of `cell`; `each` sees what every sample leaves.
    pub fn probe(&mut self, cell: u32, each: &mut dyn FnMut(Sample)) -> Result<Row> {
        let probe = match self.probe.take() {
            Some(probe) => probe,
            None => Probe::new(&self.context, self.maker.faults())?,
        };
        if let Some(passes) = &mut self.passes {
            passes.forget();
        }
        let row = probe.links_of(&mut self.context, cell, each);
        self.probe = Some(probe);
        row
    }

    /// What `cells` take of each other as solves by passes keep it, a row a cell; their links must
    /// have been made.
    pub fn taken(&mut self, cells: &[u32]) -> Result<Vec<Vec<f32>>> {
        let (context, passes) = self.passes()?;
        let bytes = 4 * context.mesh.cells.len() as u64;
        let mut rows = Vec::with_capacity(cells.len());
        for cell in cells {
            let staging = context.host.staging(bytes);
            let mut encoder = context.host.encoder();
            let from = u64::from(*cell) * bytes;
            encoder.copy_buffer_to_buffer(&passes.slots.taken, from, &staging, 0, bytes);
            rows.push(pod_collect_to_vec(&context.host.finish(encoder, staging)?));
        }
        Ok(rows)
    }

    /// The links of `cells` to all texels as solves by passes make and keep them.
    pub fn rows(&mut self, cells: &[u32]) -> Result<Vec<Vec<f32>>> {
        let (context, passes) = self.passes()?;
        let bytes = 4 * context.mesh.texels.len() as u64;
        let mut rows = Vec::with_capacity(cells.len());
        for cell in cells {
            passes.keep(context, &[*cell])?;
            let place = u64::from(cell % context.buffers.places);
            let staging = context.host.staging(bytes);
            let mut encoder = context.host.encoder();
            encoder.copy_buffer_to_buffer(
                &context.buffers.links,
                place * bytes,
                &staging,
                0,
                bytes,
            );
            rows.push(pod_collect_to_vec(&context.host.finish(encoder, staging)?));
        }
        Ok(rows)
    }
}
