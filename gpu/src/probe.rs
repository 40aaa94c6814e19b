//! A cell's links made a sample at a time, with all that each stage leaves behind: for checks of
//! one stage after the other on the same input. Solves do not use it.

use crate::context::Context;
use crate::linker::{Linker, Shots, Step};
use crate::pipelines::LinkStages;
pub use crate::records::Aim;
use crate::records::{Params, SHOT_BYTES, ShotRecord};
use crate::shaders::Fault;
use crate::slots::Slots;
use crate::stage::PipelineMaker;
use bytemuck::pod_collect_to_vec;
use common::Result;
use common::settings::Visibility;
use common::shooting::Rule;
use glam::Vec4;

/// The last sample leaves its sums beside the link, as the others do; nothing else changes.
const TOLD: Fault = Fault {
    file: "link",
    from: "    links[shots[slot].place * params.texels + k] = link(sum);\n",
    to: "    links[shots[slot].place * params.texels + k] = link(sum);
    let told = sum;
    sums[at] = vec4f(told.form_factor, told.seen, told.all, told.before);\n",
};

/// Slots for one shot, one sample at a time, and the stages bound to them.
pub(crate) struct Probe {
    slots: Slots,
    stages: LinkStages,
}

/// What one sample left.
pub struct Sample {
    /// From where it was looked.
    pub aim: Aim,
    /// Face IDs + 1, row-major; empty where rays are asked.
    pub ids: Vec<u32>,
    /// Of each texel after it: F, Σ g·V, Σ g, Σ g·V without objects.
    pub sums: Vec<Vec4>,
}

/// What the cell's links came to.
pub struct Row {
    /// w of each texel.
    pub links: Vec<f32>,
    /// Σ w·A of each cell.
    pub taken: Vec<f32>,
    /// ΣF.
    pub sum: f32,
    /// The share that meets no front.
    pub escaped: f32,
    /// What the links are multiplied by when the cell shoots.
    pub scale: f32,
}

impl Probe {
    pub fn new(context: &Context, faults: &[Fault]) -> Result<Self> {
        let (gpu, transport) = (&context.host.gpu, &context.transport);
        let slots = Slots {
            step: 1,
            ..Slots::new(gpu, context.mesh, transport, 1, 1)
        };
        let maker = PipelineMaker::new(gpu, transport, &[&[TOLD], faults].concat());
        let stages = LinkStages::new(&maker, transport, &context.buffers, &slots)?;
        gpu.check()?;
        Ok(Self { slots, stages })
    }

    /// Makes the links of `cell`; `each` sees what every sample leaves.
    pub fn links_of(
        &self,
        context: &mut Context,
        cell: u32,
        each: &mut dyn FnMut(Sample),
    ) -> Result<Row> {
        let (mesh, groups) = (context.mesh, context.groups());
        let params: Params = context.params(&self.slots, Rule::PLAIN);
        context.host.write(&self.slots.params, &[params]);
        let mut record = ShotRecord::linking(mesh, cell, context.buffers.places);
        record.taken = 0;
        context.host.write(&self.slots.shots, &[record]);
        let cells = [cell];
        for _ in 0..mesh.samples {
            each(self.sample(context, &cells, groups)?);
        }
        self.row(context, &cells, groups)
    }

    fn linker<'l>(
        &'l self,
        context: &'l Context,
        cells: &'l [u32; 1],
        groups: [[u32; 4]; 3],
    ) -> Linker<'l> {
        Linker {
            mesh: context.mesh,
            buffers: &context.buffers,
            slots: &self.slots,
            stages: &self.stages,
            shots: Shots::These(cells, groups),
        }
    }

    fn sample(
        &self,
        context: &mut Context,
        cells: &[u32; 1],
        groups: [[u32; 4]; 3],
    ) -> Result<Sample> {
        let mut encoder = context.host.encoder();
        let linker = self.linker(context, cells, groups);
        linker.record(&mut encoder, Step::Draw);
        linker.record(&mut encoder, Step::Links);
        let texels = 16 * context.mesh.texels.len() as u64;
        let staging = context.host.staging(SHOT_BYTES + texels);
        encoder.copy_buffer_to_buffer(&self.slots.shots, 0, &staging, 0, SHOT_BYTES);
        encoder.copy_buffer_to_buffer(&self.slots.samples, 0, &staging, SHOT_BYTES, texels);
        let bytes = context.host.finish(encoder, staging)?;
        let (shot, sums) = bytes.split_at(SHOT_BYTES as usize);
        let ids = if context.transport.visibility == Visibility::Rays {
            Vec::new()
        } else {
            context.host.ids(&self.slots.item_buffer, self.slots.size)?
        };
        Ok(Sample {
            aim: pod_collect_to_vec::<u8, ShotRecord>(shot)[0].aim(),
            ids,
            sums: pod_collect_to_vec(sums),
        })
    }

    fn row(&self, context: &mut Context, cells: &[u32; 1], groups: [[u32; 4]; 3]) -> Result<Row> {
        let mut encoder = context.host.encoder();
        let linker = self.linker(context, cells, groups);
        linker.record(&mut encoder, Step::Escape);
        linker.record(&mut encoder, Step::Sums);
        let (texels, takers) = (
            4 * context.mesh.texels.len() as u64,
            4 * context.mesh.cells.len() as u64,
        );
        let place = u64::from(cells[0] % context.buffers.places);
        let staging = context.host.staging(SHOT_BYTES + texels + takers);
        encoder.copy_buffer_to_buffer(&self.slots.shots, 0, &staging, 0, SHOT_BYTES);
        let links = &context.buffers.links;
        encoder.copy_buffer_to_buffer(links, place * texels, &staging, SHOT_BYTES, texels);
        let end = SHOT_BYTES + texels;
        encoder.copy_buffer_to_buffer(&self.slots.taken, 0, &staging, end, takers);
        let bytes = context.host.finish(encoder, staging)?;
        let record = pod_collect_to_vec::<u8, ShotRecord>(&bytes[..SHOT_BYTES as usize])[0];
        Ok(Row {
            links: pod_collect_to_vec(&bytes[SHOT_BYTES as usize..end as usize]),
            taken: pod_collect_to_vec(&bytes[end as usize..]),
            sum: record.sum,
            escaped: record.escaped,
            scale: record.scale(),
        })
    }
}
