//! [`common::passes`] on the GPU: links of many patches side by side, the exchange between patches, and the
//! final gather at the texels. Only a few numbers a patch cross the bus.

use crate::compute_stage::BindingSlot::{Read, Uniform, Write};
use crate::compute_stage::{ComputeStage, PipelineMaker};
use crate::device_queue::PendingRead;
use crate::link_recorder::{LinkRecorder, ShotSelection, bind_stage};
use crate::records::{SHOT_BYTES, ShaderParams, ShotRecord};
use crate::shot_slots::{ShotSlots, max_slots};
use crate::shot_stages::LinkStages;
use crate::solver_buffers::zeroed_buffer;
use crate::solver_context::SolverContext;
use crate::submission_pace::{IN_FLIGHT, SubmissionPace};
use bytemuck::pod_collect_to_vec;
use common::Result;
use common::constants::PATCH_SUM_LANES;
use common::passes::PatchClosure;
use common::shooting::DepositRule;
use glam::{Vec3, Vec4};
use std::collections::{HashSet, VecDeque};
use std::ops::{ControlFlow, Range};
use std::time::Instant;
use wgpu::BufferUsages as Usage;

/// Most links that one submission gathers: a gigabyte of them, some milliseconds on hardware.
const MAX_GATHERED_LINKS: u64 = 1 << 28;

/// Slots and stages of a solve by passes.
pub struct PassStages {
    pub slots: ShotSlots,
    pub stages: LinkStages,
    /// Radiosity that each patch shoots, or its residual.
    pub shot: wgpu::Buffer,
    flux: wgpu::Buffer,
    exchange: ComputeStage,
    gather: ComputeStage,
    update_radiosity: ComputeStage,
    /// Number + 1 of the patch whose links each place keeps.
    kept_patches: Vec<u32>,
    pace: SubmissionPace,
}

/// Links under way.
struct LinksInFlight {
    pending: PendingRead,
    patches: Vec<u32>,
    start: Instant,
}

/// Returns true where the transfers between all patches fit.
pub fn has_room(context: &SolverContext) -> bool {
    let patches = context.mesh.patches.len() as u64;
    4 * patches * patches <= context.buffers.budget
}

impl PassStages {
    pub fn new(context: &SolverContext, maker: &PipelineMaker) -> Result<Self> {
        let (gpu, b) = (&context.host.gpu, &context.buffers);
        if !has_room(context) {
            return Err(gpu.device_error("no room for the transfers between patches"));
        }
        let (mesh, transport) = (context.mesh, &context.transport);
        let patches = mesh.patches.len() as u32;
        let count = max_slots(gpu, mesh, transport, b);
        let slots = ShotSlots::new(gpu, mesh, transport, count, patches);
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let per_patch = |label| zeroed_buffer(&gpu.device, label, 16 * u64::from(patches), storage);
        let (shot, flux) = (per_patch("shot"), per_patch("flux"));
        let exchanged = [
            Uniform(&slots.params),
            Read(&shot),
            Read(&slots.transfers),
            Write(&flux),
        ];
        let collected = [
            Uniform(&slots.params),
            Read(&b.patches),
            Read(&b.texels),
            Read(&shot),
            Read(&b.links),
            Write(&b.irradiance),
            Write(&b.radiosity),
            Write(&b.residual),
        ];
        let passes = Self {
            stages: LinkStages::new(maker, transport, b, &slots)?,
            exchange: maker.make_stage("exchange", "exchange_flux", &exchanged)?,
            gather: maker.make_stage("gather", "gather_irradiance", &collected)?,
            update_radiosity: maker.make_stage("gather", "update_radiosity", &collected)?,
            shot,
            flux,
            kept_patches: vec![0; b.places as usize],
            pace: SubmissionPace::new(1, slots.count, gpu.line.software),
            slots,
        };
        gpu.check_errors()?;
        Ok(passes)
    }

    /// Marks all rows as not kept: single shots may have taken their places.
    pub fn forget_rows(&mut self) {
        self.kept_patches.fill(0);
    }

    /// Links these patches, in batches of as many as lie side by side; two are always under way.
    pub fn link_patches(
        &mut self,
        context: &mut SolverContext,
        patches: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<PatchClosure>> {
        self.write_params(context, [0, 0]);
        self.pace.start_series();
        let mut flights = VecDeque::new();
        let mut closures = Vec::with_capacity(patches.len());
        let mut launched = 0;
        let mut ended = false;
        loop {
            while !ended && flights.len() < IN_FLIGHT && launched < patches.len() {
                let left = &patches[launched..];
                let most = self.pace.next_shots(launched as u32, left.len() as u32);
                let batch = distinct_places(&left[..most as usize], context.buffers.places);
                flights.push_back(self.launch_links(context, batch));
                launched += batch.len();
            }
            let Some(flight) = flights.pop_front() else {
                return Ok(closures);
            };
            for closure in self.land_links(context, flight)? {
                closures.push(closure);
                ended |= watch(closures.len()).is_break();
            }
        }
    }

    /// Writes the parameters of the next submissions, which gather the shots of patches `first` to `end`.
    pub fn write_params(&self, context: &SolverContext, [first, end]: [u32; 2]) {
        let params = ShaderParams {
            first,
            end,
            ..context.shader_params(&self.slots, DepositRule::FULL_DEPOSIT)
        };
        context.host.write(&self.slots.params, &[params]);
    }

    /// Writes the shots whose links are to be made, one a slot.
    pub fn write_shots(&mut self, context: &SolverContext, patches: &[u32]) {
        let places = context.buffers.places;
        let records: Vec<ShotRecord> = patches
            .iter()
            .map(|k| ShotRecord::for_links(context.mesh, *k, places))
            .collect();
        for patch in patches {
            self.kept_patches[(patch % places) as usize] = patch + 1;
        }
        context.host.write(&self.slots.shots, &records);
    }

    fn launch_links(&mut self, context: &mut SolverContext, patches: &[u32]) -> LinksInFlight {
        self.write_shots(context, patches);
        let mut encoder = context.host.command_encoder();
        let linker = self.link_recorder(context, patches);
        for step in linker.link_steps() {
            linker.record_step(&mut encoder, step);
        }
        let bytes = SHOT_BYTES * patches.len() as u64;
        let staging = context.host.staging_buffer(bytes);
        encoder.copy_buffer_to_buffer(&self.slots.shots, 0, &staging, 0, bytes);
        LinksInFlight {
            start: Instant::now(),
            pending: context.host.submit_read(encoder, staging),
            patches: patches.to_vec(),
        }
    }

    pub fn link_recorder<'l>(&'l self, context: &'l SolverContext, patches: &'l [u32]) -> LinkRecorder<'l> {
        LinkRecorder {
            mesh: context.mesh,
            buffers: &context.buffers,
            slots: &self.slots,
            stages: &self.stages,
            shots: ShotSelection::These(patches, context.workgroup_counts()),
        }
    }

    fn land_links(&mut self, context: &SolverContext, flight: LinksInFlight) -> Result<Vec<PatchClosure>> {
        let bytes = context.host.wait_for_bytes(flight.pending)?;
        self.pace.record_landing(flight.start, flight.patches.len() as u32);
        let records: Vec<ShotRecord> = pod_collect_to_vec(&bytes);
        let closures = flight.patches.iter().zip(&records).map(|(patch, record)| {
            // The host writes both as NaN, the device makes them.
            if record.patch_index != *patch || record.sum.is_nan() || record.escaped.is_nan() {
                return Err(context.host.gpu.device_error("the links of a patch were not made"));
            }
            Ok(PatchClosure {
                form_factor_sum: record.sum,
                escaped: record.escaped,
            })
        });
        closures.collect()
    }

    /// Exchanges flux between patches: one dispatch over the receivers, one read-back.
    pub fn exchange_flux(&mut self, context: &mut SolverContext, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        let host = &mut context.host;
        host.write(&self.shot, &per_patch(radiosity));
        let bytes = self.flux.size();
        let staging = host.staging_buffer(bytes);
        let mut encoder = host.command_encoder();
        self.record_exchange(
            &mut encoder,
            host.split_workgroups(radiosity.len().div_ceil(PATCH_SUM_LANES)),
        );
        encoder.copy_buffer_to_buffer(&self.flux, 0, &staging, 0, bytes);
        let flux: Vec<Vec4> = pod_collect_to_vec(&host.read_back(encoder, staging)?);
        if flux.iter().any(|flux| flux.w != 1.0) {
            return Err(host.gpu.device_error("the exchange between patches was not made"));
        }
        Ok(flux.iter().map(|flux| flux.truncate()).collect())
    }

    pub fn record_exchange(&self, encoder: &mut wgpu::CommandEncoder, groups: [u32; 4]) {
        encoder.clear_buffer(&self.flux, 0, None);
        dispatch_stage(encoder, &self.exchange, groups);
    }

    /// Gathers all shots at the texels, one range of patches after the other; links that are no longer kept are
    /// made again.
    pub fn gather_light(&mut self, context: &mut SolverContext, shot: &[Vec3], unshot: &[Vec3]) -> Result<()> {
        let (b, texels) = (&context.buffers, &context.mesh.texels);
        let emission: Vec<Vec4> = texels.iter().map(|t| t.emission.extend(0.0)).collect();
        context.host.write(&b.radiosity, &emission);
        let mut encoder = context.host.command_encoder();
        encoder.clear_buffer(&b.irradiance, 0, None);
        context.host.submit_work(encoder);
        let step = (MAX_GATHERED_LINKS / texels.len().max(1) as u64).clamp(1, u64::from(b.places));
        let groups = context.workgroup_counts();
        for first in (0..shot.len()).step_by(step as usize) {
            let end = (first + step as usize).min(shot.len());
            self.remake_rows(context, first..end, shot)?;
            self.write_params(context, [first as u32, end as u32]);
            self.dispatch_over_texels(context, shot, &self.gather, groups[0]);
        }
        let last = self.dispatch_over_texels(context, unshot, &self.update_radiosity, groups[2]);
        context.host.wait_for_submission(last)
    }

    /// Makes the links of the shooters in a range that are not kept.
    fn remake_rows(&mut self, context: &mut SolverContext, patches: Range<usize>, shot: &[Vec3]) -> Result<()> {
        let shooters: Vec<u32> = patches.filter(|k| shot[*k] != Vec3::ZERO).map(|k| k as u32).collect();
        self.make_rows(context, &shooters)
    }

    /// Makes the links of these patches that are not kept.
    pub fn make_rows(&mut self, context: &mut SolverContext, patches: &[u32]) -> Result<()> {
        let places = self.kept_patches.len() as u32;
        let missing: Vec<u32> = (patches.iter().copied())
            .filter(|k| self.kept_patches[(k % places) as usize] != k + 1)
            .collect();
        if !missing.is_empty() {
            self.link_patches(context, &missing, &mut |_| ControlFlow::Continue(()))?;
        }
        Ok(())
    }

    /// Submits a stage that reads a colour of each patch.
    fn dispatch_over_texels(
        &self,
        context: &mut SolverContext,
        colours: &[Vec3],
        stage: &ComputeStage,
        groups: [u32; 4],
    ) -> wgpu::SubmissionIndex {
        context.host.write(&self.shot, &per_patch(colours));
        let mut encoder = context.host.command_encoder();
        dispatch_stage(&mut encoder, stage, groups);
        context.host.submit_work(encoder)
    }
}

/// Returns the first of these patches, as long as their places differ.
fn distinct_places(patches: &[u32], places: u32) -> &[u32] {
    let mut used = HashSet::new();
    let clash = patches.iter().position(|patch| !used.insert(patch % places));
    &patches[..clash.unwrap_or(patches.len())]
}

fn per_patch(colours: &[Vec3]) -> Vec<Vec4> {
    colours.iter().map(|colour| colour.extend(0.0)).collect()
}

/// Records one dispatch of a stage.
pub fn dispatch_stage(encoder: &mut wgpu::CommandEncoder, stage: &ComputeStage, groups: [u32; 4]) {
    let mut pass = encoder.begin_compute_pass(&Default::default());
    bind_stage(&mut pass, stage);
    pass.dispatch_workgroups(groups[0], groups[1], 1);
}
