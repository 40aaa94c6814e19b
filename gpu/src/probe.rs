//! Links of a patch made a sample at a time, with the results of each stage: for checks of single stages on
//! the same input. Solves do not use it.

use crate::compute_stage::PipelineMaker;
use crate::link_recorder::{LinkRecorder, LinkStep, ShotSelection};
pub use crate::records::SampleView;
use crate::records::{PROBE_BIT, SHOT_BYTES, ShaderParams, ShotRecord};
use crate::shaders::ShaderFault;
use crate::shot_slots::ShotSlots;
use crate::shot_stages::LinkStages;
use crate::solver_context::SolverContext;
use bytemuck::pod_collect_to_vec;
use common::Result;
use common::settings::Visibility;
use common::shooting::DepositRule;
use glam::Vec4;

/// Slots for one shot, one sample at a time, and the stages bound to them.
pub(crate) struct LinkProbe {
    slots: ShotSlots,
    stages: LinkStages,
}

/// A change of the IDs of an item buffer, by its number.
pub type BufferChange<'a> = &'a dyn Fn(u32, &mut [u32]);

/// Results of one sample.
pub struct ProbedSample {
    /// The frame of the sample.
    pub aim: SampleView,
    /// Face IDs + 1, row-major; empty with visibility by rays.
    pub ids: Vec<u32>,
    /// The same of the room without objects; empty where there are none.
    pub room_ids: Vec<u32>,
    /// Sums of each texel after the sample: F, Σ g·V, Σ g, Σ g·V without objects; after the last one, by a rule that compares
    /// links, their baselines: the part that is subtracted, and the link without the objects.
    pub sums: Vec<Vec4>,
}

/// The patch's links and their closure.
pub struct ProbedRow {
    /// w of each texel.
    pub links: Vec<f32>,
    /// Transfer Σ w·A to each patch.
    pub transfers: Vec<f32>,
    /// ΣF.
    pub sum: f32,
    /// Share of the cosine hemisphere that meets no front.
    pub escaped: f32,
    /// Factor that scales the links when the patch shoots.
    pub scale: f32,
}

impl LinkProbe {
    pub fn new(context: &SolverContext, faults: &[ShaderFault]) -> Result<Self> {
        let (gpu, transport) = (&context.host.gpu, &context.transport);
        let slots = ShotSlots {
            step: 1,
            ..ShotSlots::new(gpu, context.mesh, transport, 1, 1)
        };
        let maker = PipelineMaker::new(gpu, transport, faults);
        let stages = LinkStages::new(&maker, &context.buffers, &slots)?;
        gpu.check_errors()?;
        Ok(Self { slots, stages })
    }

    /// Returns the buffer of the transfers to each patch.
    pub fn transfers(&self) -> &wgpu::Buffer {
        &self.slots.table["transfers"]
    }

    /// Awaits the links of a patch by `rule`; `each` receives the results of every sample.
    pub async fn request_links(
        &self,
        context: &mut SolverContext<'_>,
        (patch, rule): (u32, DepositRule),
        each: &mut dyn FnMut(ProbedSample),
    ) -> Result<ProbedRow> {
        self.write_shot(context, patch, rule);
        for _ in 0..context.mesh.samples {
            each(self.request_sample(context, patch).await?);
        }
        self.request_row(context, patch).await
    }

    /// Awaits the first sample of a patch by its item buffer after each of so many `changes`; the links must be made again.
    /// With visibility by rays nothing is made.
    pub async fn request_changed_buffers(
        &self,
        context: &mut SolverContext<'_>,
        patch: u32,
        (changes, change): (u32, BufferChange<'_>),
        each: &mut dyn FnMut(ProbedSample),
    ) -> Result<()> {
        let Visibility::ItemBuffer(drawing) = context.transport.visibility else {
            return Ok(());
        };
        self.write_shot(context, patch, DepositRule::FULL_DEPOSIT);
        let encoder = self.record_steps(context, patch, &[LinkStep::Draw]);
        context.host.submit_work(encoder);
        let texture = &self.slots.item_buffer;
        let drawn = context.host.request_item_buffer(texture, drawing.size).await?;
        for n in 0..changes {
            let mut ids = drawn.clone();
            change(n, &mut ids);
            context.host.write_item_buffer(texture, drawing.size, &ids);
            let encoder = self.record_steps(context, patch, &[LinkStep::Links]);
            let (aim, sums) = self.request_sums(context, encoder).await?;
            each(ProbedSample {
                aim,
                ids,
                room_ids: Vec::new(),
                sums,
            });
        }
        Ok(())
    }

    /// Writes the parameters of a probe, and the shot of a patch before its first sample.
    pub(crate) fn write_shot(&self, context: &SolverContext, patch: u32, rule: DepositRule) {
        let mut params: ShaderParams = context.shader_params(&self.slots, rule);
        params.rule |= PROBE_BIT;
        context.host.write(&self.slots.table["params"], &[params]);
        let mut record = ShotRecord::for_links(context.mesh, patch, context.buffers.places);
        record.transfer_start = 0;
        context.host.write(&self.slots.table["shots"], &[record]);
    }

    /// Returns the recorded `steps` of the links of a patch.
    pub(crate) fn record_steps(&self, context: &SolverContext, patch: u32, steps: &[LinkStep]) -> wgpu::CommandEncoder {
        let mut encoder = context.host.command_encoder();
        let linker = LinkRecorder {
            mesh: context.mesh,
            buffers: &context.buffers,
            slots: &self.slots,
            stages: &self.stages,
            shots: ShotSelection::These(&[patch], context.workgroup_counts()),
        };
        for step in steps {
            linker.record_step(&mut encoder, *step);
        }
        encoder
    }

    async fn request_sample(&self, context: &mut SolverContext<'_>, patch: u32) -> Result<ProbedSample> {
        let encoder = self.record_steps(context, patch, &[LinkStep::Draw, LinkStep::Links]);
        let (aim, sums) = self.request_sums(context, encoder).await?;
        let (mut ids, mut room_ids) = (Vec::new(), Vec::new());
        if let Visibility::ItemBuffer(drawing) = context.transport.visibility {
            let (slots, host) = (&self.slots, &mut context.host);
            ids = host.request_item_buffer(&slots.item_buffer, drawing.size).await?;
            if let Some(room) = &slots.room_buffer {
                room_ids = host.request_item_buffer(room.texture(), drawing.size).await?;
            }
        }
        Ok(ProbedSample {
            aim,
            ids,
            room_ids,
            sums,
        })
    }

    /// Submits work, and awaits the frame of a sample and the sums after it.
    async fn request_sums(
        &self,
        context: &mut SolverContext<'_>,
        encoder: wgpu::CommandEncoder,
    ) -> Result<(SampleView, Vec<Vec4>)> {
        let table = &self.slots.table;
        let texels = 16 * context.mesh.texels.len() as u64;
        let ranges = [(&table["shots"], 0, SHOT_BYTES), (&table["sums"], 0, texels)];
        let bytes: Vec<u8> = context.host.request_values(encoder, &ranges).await?;
        let (shot, sums) = bytes.split_at(SHOT_BYTES as usize);
        let record = pod_collect_to_vec::<u8, ShotRecord>(shot)[0];
        Ok((record.sample_view(), pod_collect_to_vec(sums)))
    }

    async fn request_row(&self, context: &mut SolverContext<'_>, patch: u32) -> Result<ProbedRow> {
        let encoder = self.record_steps(context, patch, &[LinkStep::Escape, LinkStep::Sums]);
        let mesh = context.mesh;
        let [texels, takers] = [mesh.texels.len(), mesh.patches.len()].map(|count| 4 * count as u64);
        let place = u64::from(patch % context.buffers.places);
        let table = &self.slots.table;
        let ranges = [
            (&table["shots"], 0, SHOT_BYTES),
            (&context.buffers.table["links"], place * texels, texels),
            (&table["transfers"], 0, takers),
        ];
        let bytes: Vec<u8> = context.host.request_values(encoder, &ranges).await?;
        let (shot, rest) = bytes.split_at(SHOT_BYTES as usize);
        let (links, transfers) = rest.split_at(texels as usize);
        let record = pod_collect_to_vec::<u8, ShotRecord>(shot)[0];
        Ok(ProbedRow {
            links: pod_collect_to_vec(links),
            transfers: pod_collect_to_vec(transfers),
            sum: record.sum,
            escaped: record.escaped,
            scale: record.scale,
        })
    }
}
