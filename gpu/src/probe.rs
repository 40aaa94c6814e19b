//! Links of a patch made a sample at a time, with the results of each stage: for checks of single stages on
//! the same input. Solves do not use it.

use crate::compute_stage::PipelineMaker;
use crate::link_recorder::{LinkRecorder, LinkStep, ShotSelection};
pub use crate::records::SampleView;
use crate::records::{SHOT_BYTES, ShaderParams, ShotRecord};
use crate::shaders::ShaderFault;
use crate::shot_slots::ShotSlots;
use crate::shot_stages::LinkStages;
use crate::solver_context::SolverContext;
use bytemuck::pod_collect_to_vec;
use common::Result;
use common::settings::Visibility;
use common::shooting::DepositRule;
use glam::Vec4;

/// Makes the last sample store its sums beside the link, as the others do; nothing else changes.
const SUMS_PROBE: ShaderFault = ShaderFault {
    file: "link",
    from: "    links[shots[slot].place * params.texels + k] = link_weight(sum);\n",
    to: "    links[shots[slot].place * params.texels + k] = link_weight(sum);
    let probed = sum;
    sums[at] = vec4f(probed.form_factor, probed.seen, probed.all, probed.before);\n",
};

/// Slots for one shot, one sample at a time, and the stages bound to them.
pub(crate) struct LinkProbe {
    slots: ShotSlots,
    stages: LinkStages,
}

/// Results of one sample.
pub struct ProbedSample {
    /// The frame of the sample.
    pub aim: SampleView,
    /// Face IDs + 1, row-major; empty with visibility by rays.
    pub ids: Vec<u32>,
    /// Sums of each texel after the sample: F, Σ g·V, Σ g, Σ g·V without objects.
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
        let maker = PipelineMaker::new(gpu, transport, &[&[SUMS_PROBE], faults].concat());
        let stages = LinkStages::new(&maker, transport, &context.buffers, &slots)?;
        gpu.check_errors()?;
        Ok(Self { slots, stages })
    }

    /// Makes the links of a patch; `each` receives the results of every sample.
    pub fn probe_links(
        &self,
        context: &mut SolverContext,
        patch: u32,
        each: &mut dyn FnMut(ProbedSample),
    ) -> Result<ProbedRow> {
        let (mesh, groups) = (context.mesh, context.workgroup_counts());
        let params: ShaderParams = context.shader_params(&self.slots, DepositRule::FULL_DEPOSIT);
        context.host.write(&self.slots.params, &[params]);
        let mut record = ShotRecord::for_links(mesh, patch, context.buffers.places);
        record.transfer_start = 0;
        context.host.write(&self.slots.shots, &[record]);
        let patches = [patch];
        for _ in 0..mesh.samples {
            each(self.probe_sample(context, &patches, groups)?);
        }
        self.probe_row(context, &patches, groups)
    }

    fn link_recorder<'l>(
        &'l self,
        context: &'l SolverContext,
        patches: &'l [u32; 1],
        groups: [[u32; 4]; 3],
    ) -> LinkRecorder<'l> {
        LinkRecorder {
            mesh: context.mesh,
            buffers: &context.buffers,
            slots: &self.slots,
            stages: &self.stages,
            shots: ShotSelection::These(patches, groups),
        }
    }

    fn probe_sample(
        &self,
        context: &mut SolverContext,
        patches: &[u32; 1],
        groups: [[u32; 4]; 3],
    ) -> Result<ProbedSample> {
        let mut encoder = context.host.command_encoder();
        let linker = self.link_recorder(context, patches, groups);
        linker.record_step(&mut encoder, LinkStep::Draw);
        linker.record_step(&mut encoder, LinkStep::Links);
        let texels = 16 * context.mesh.texels.len() as u64;
        let staging = context.host.staging_buffer(SHOT_BYTES + texels);
        encoder.copy_buffer_to_buffer(&self.slots.shots, 0, &staging, 0, SHOT_BYTES);
        encoder.copy_buffer_to_buffer(&self.slots.samples, 0, &staging, SHOT_BYTES, texels);
        let bytes = context.host.read_back(encoder, staging)?;
        let (shot, sums) = bytes.split_at(SHOT_BYTES as usize);
        let ids = if context.transport.visibility == Visibility::Rays {
            Vec::new()
        } else {
            context
                .host
                .read_item_buffer(&self.slots.item_buffer, self.slots.size)?
        };
        Ok(ProbedSample {
            aim: pod_collect_to_vec::<u8, ShotRecord>(shot)[0].sample_view(),
            ids,
            sums: pod_collect_to_vec(sums),
        })
    }

    fn probe_row(&self, context: &mut SolverContext, patches: &[u32; 1], groups: [[u32; 4]; 3]) -> Result<ProbedRow> {
        let mut encoder = context.host.command_encoder();
        let linker = self.link_recorder(context, patches, groups);
        linker.record_step(&mut encoder, LinkStep::Escape);
        linker.record_step(&mut encoder, LinkStep::Sums);
        let (texels, takers) = (
            4 * context.mesh.texels.len() as u64,
            4 * context.mesh.patches.len() as u64,
        );
        let place = u64::from(patches[0] % context.buffers.places);
        let staging = context.host.staging_buffer(SHOT_BYTES + texels + takers);
        encoder.copy_buffer_to_buffer(&self.slots.shots, 0, &staging, 0, SHOT_BYTES);
        let links = &context.buffers.links;
        encoder.copy_buffer_to_buffer(links, place * texels, &staging, SHOT_BYTES, texels);
        let end = SHOT_BYTES + texels;
        encoder.copy_buffer_to_buffer(&self.slots.transfers, 0, &staging, end, takers);
        let bytes = context.host.read_back(encoder, staging)?;
        let record = pod_collect_to_vec::<u8, ShotRecord>(&bytes[..SHOT_BYTES as usize])[0];
        Ok(ProbedRow {
            links: pod_collect_to_vec(&bytes[SHOT_BYTES as usize..end as usize]),
            transfers: pod_collect_to_vec(&bytes[end as usize..]),
            sum: record.sum,
            escaped: record.escaped,
            scale: record.link_scale(),
        })
    }
}
