//! [`common::passes`] on the GPU: links of many patches side by side, the exchange between patches, and the
//! final gather at the texels. Only a few numbers a patch cross the bus.

use crate::bindings::{BindingTable, STORAGE};
use crate::compute_stage::{ComputeStage, PipelineMaker};
use crate::device_queue::PendingRead;
use crate::link_recorder::{LinkRecorder, ShotSelection};
use crate::records::{SHOT_BYTES, ShaderParams, ShotRecord};
use crate::shot_slots::{ShotSlots, max_slots};
use crate::shot_stages::LinkStages;
use crate::solver_context::SolverContext;
use crate::submission_pace::{IN_FLIGHT, SubmissionPace};
use bytemuck::pod_collect_to_vec;
use common::Result;
use common::constants::PATCH_SUM_LANES;
use common::passes::PatchClosure;
use common::shooting::DepositRule;
use glam::{Vec3, Vec4};
use std::collections::{HashSet, VecDeque};
use std::ops::ControlFlow;
use web_time::Instant;

/// Most links that one submission gathers: a gigabyte of them, some milliseconds on hardware.
const MAX_GATHERED_LINKS: u64 = 1 << 28;

/// Slots and stages of a solve by passes.
pub struct PassStages {
    pub slots: ShotSlots,
    stages: LinkStages,
    /// `shot`: the radiosity that each patch shoots, or its residual; `flux`: the flux that it receives.
    table: BindingTable,
    exchange: ComputeStage,
    gather: ComputeStage,
    update_radiosity: ComputeStage,
    /// Number + 1 of the patch whose links each place keeps.
    kept_patches: Vec<u32>,
    pace: SubmissionPace,
    /// Most links that one submission gathers.
    max_gathered_links: u64,
}

/// Links under way.
struct LinksInFlight {
    pending: PendingRead,
    patches: Vec<u32>,
    start: Instant,
}

/// Returns true where the transfers between all patches fit.
pub fn transfer_fits(context: &SolverContext) -> bool {
    let patches = context.mesh.patches.len() as u64;
    4 * patches * patches <= context.buffers.budget
}

impl PassStages {
    pub fn new(context: &SolverContext, maker: &PipelineMaker) -> Result<Self> {
        let (gpu, b) = (&context.host.gpu, &context.buffers);
        if !transfer_fits(context) {
            return Err(gpu.device_error("no room for the transfers between patches"));
        }
        let (mesh, transport) = (context.mesh, &context.transport);
        let patches = mesh.patches.len() as u32;
        let count = max_slots(gpu, mesh, transport, b);
        let slots = ShotSlots::new(gpu, mesh, transport, count, patches);
        let per_patch = 16 * u64::from(patches);
        let behind_end = 16 * gpu.elements_behind_end() as u64;
        let zeroed = [("shot", per_patch, STORAGE), ("flux", per_patch + behind_end, STORAGE)];
        let own = BindingTable::zeroed(&gpu.device, zeroed);
        let table = b.table.joined_with(&slots.table).joined_with(&own);
        let passes = Self {
            stages: LinkStages::new(maker, b, &slots)?,
            exchange: maker.make_stage("exchange", "exchange_flux", &table)?,
            gather: maker.make_stage("gather", "gather_irradiance", &table)?,
            update_radiosity: maker.make_stage("gather", "update_radiosity", &table)?,
            table: own,
            max_gathered_links: match gpu.is_for_checks() {
                true => (mesh.texels.len() * mesh.patches.len()) as u64 / 3,
                false => MAX_GATHERED_LINKS,
            },
            kept_patches: vec![0; b.places as usize],
            pace: SubmissionPace::new(1, slots.count, gpu.line.software),
            slots,
        };
        gpu.check_errors()?;
        Ok(passes)
    }

    /// Returns the buffer of the flux that each patch receives.
    pub fn flux(&self) -> &wgpu::Buffer {
        &self.table["flux"]
    }

    /// Marks all rows as not kept: single shots may have taken their places.
    pub fn forget_rows(&mut self) {
        self.kept_patches.fill(0);
    }

    /// Awaits the links of these patches, in batches of as many as lie side by side; two are always under way.
    pub async fn request_links(
        &mut self,
        context: &mut SolverContext<'_>,
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
            for closure in self.land_links(context, flight).await? {
                closures.push(closure);
                ended |= watch(closures.len()).is_break();
            }
        }
    }

    /// Writes the parameters of the next submissions, which gather the shots of patches `first` to `end`.
    fn write_params(&self, context: &SolverContext, [first, end]: [u32; 2]) {
        let params = ShaderParams {
            first,
            end,
            ..context.shader_params(&self.slots, DepositRule::FULL_DEPOSIT)
        };
        context.host.write(&self.slots.table["params"], &[params]);
    }

    fn launch_links(&mut self, context: &mut SolverContext, patches: &[u32]) -> LinksInFlight {
        let places = context.buffers.places;
        let shot = |k: &u32| ShotRecord::for_links(context.mesh, *k, places);
        let records: Vec<ShotRecord> = patches.iter().map(shot).collect();
        for patch in patches {
            self.kept_patches[(patch % places) as usize] = patch + 1;
        }
        let shots = &self.slots.table["shots"];
        context.host.write(shots, &records);
        let mut encoder = context.host.command_encoder();
        let linker = LinkRecorder {
            mesh: context.mesh,
            buffers: &context.buffers,
            slots: &self.slots,
            stages: &self.stages,
            shots: ShotSelection::These(patches, context.workgroup_counts()),
        };
        for step in linker.link_steps() {
            linker.record_step(&mut encoder, step);
        }
        let made = (shots, 0, SHOT_BYTES * patches.len() as u64);
        LinksInFlight {
            start: Instant::now(),
            pending: context.host.submit_read(encoder, &[made]),
            patches: patches.to_vec(),
        }
    }

    async fn land_links(&mut self, context: &SolverContext<'_>, flight: LinksInFlight) -> Result<Vec<PatchClosure>> {
        let bytes = context.host.request_bytes(flight.pending).await?;
        self.pace.record_landing(flight.start, flight.patches.len() as u32);
        let records: Vec<ShotRecord> = pod_collect_to_vec(&bytes);
        let closures = flight.patches.iter().zip(&records).map(|(patch, record)| {
            // The host writes both as NaN, the device makes them.
            if record.patch_index != *patch || record.sum.is_nan() || record.escaped.is_nan() {
                let gpu = &context.host.gpu;
                return Err(gpu.stage_error("closure", "the links of a patch were not made"));
            }
            Ok(PatchClosure {
                form_factor_sum: record.sum,
                escaped: record.escaped,
            })
        });
        closures.collect()
    }

    /// Awaits the exchange of flux between patches: one dispatch over the receivers, one read-back.
    pub async fn request_flux(&mut self, context: &mut SolverContext<'_>, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        let host = &mut context.host;
        host.write(&self.table["shot"], &pad_colours(radiosity));
        let flux = &self.table["flux"];
        let bytes = 16 * radiosity.len() as u64;
        let mut encoder = host.command_encoder();
        encoder.clear_buffer(flux, 0, Some(bytes));
        let groups = host.split_workgroups(radiosity.len().div_ceil(PATCH_SUM_LANES));
        self.exchange
            .dispatch_groups(&mut encoder.begin_compute_pass(&Default::default()), groups);
        let flux: Vec<Vec4> = host.request_values(encoder, &[(flux, 0, bytes)]).await?;
        if flux.iter().any(|flux| flux.w != 1.0) {
            let text = "the exchange between patches was not made";
            return Err(host.gpu.stage_error("exchange", text));
        }
        Ok(flux.iter().map(|flux| flux.truncate()).collect())
    }

    /// Gathers all shots at the texels, one range of patches after the other, and awaits the end; links that are no longer kept
    /// are made again.
    pub async fn request_gather(
        &mut self,
        context: &mut SolverContext<'_>,
        shot: &[Vec3],
        unshot: &[Vec3],
    ) -> Result<()> {
        let (b, texels) = (&context.buffers, &context.mesh.texels);
        let emission: Vec<Vec4> = texels.iter().map(|t| t.emission.extend(0.0)).collect();
        context.host.write(&b.table["radiosity"], &emission);
        let mut encoder = context.host.command_encoder();
        encoder.clear_buffer(&b.table["irradiance"], 0, Some(16 * texels.len() as u64));
        context.host.submit_work(encoder);
        let step = (self.max_gathered_links / texels.len().max(1) as u64).clamp(1, u64::from(b.places));
        let groups = context.workgroup_counts();
        for first in (0..shot.len()).step_by(step as usize) {
            let end = (first + step as usize).min(shot.len());
            let shooters: Vec<u32> = (first..end)
                .filter(|k| shot[*k] != Vec3::ZERO)
                .map(|k| k as u32)
                .collect();
            self.request_rows(context, &shooters).await?;
            self.write_params(context, [first as u32, end as u32]);
            self.dispatch_over_texels(context, shot, &self.gather, groups[0]);
        }
        let last = self.dispatch_over_texels(context, unshot, &self.update_radiosity, groups[2]);
        context.host.request_submission(last).await
    }

    /// Awaits the links of these patches that are not kept.
    pub async fn request_rows(&mut self, context: &mut SolverContext<'_>, patches: &[u32]) -> Result<()> {
        let places = self.kept_patches.len() as u32;
        let missing: Vec<u32> = (patches.iter().copied())
            .filter(|k| self.kept_patches[(k % places) as usize] != k + 1)
            .collect();
        if !missing.is_empty() {
            self.request_links(context, &missing, &mut |_| ControlFlow::Continue(()))
                .await?;
        }
        Ok(())
    }

    /// Submits a stage that reads a colour of each patch.
    fn dispatch_over_texels(
        &self,
        context: &mut SolverContext,
        colours: &[Vec3],
        stage: &ComputeStage,
        groups: [u32; 3],
    ) -> wgpu::SubmissionIndex {
        context.host.write(&self.table["shot"], &pad_colours(colours));
        let mut encoder = context.host.command_encoder();
        stage.dispatch_groups(&mut encoder.begin_compute_pass(&Default::default()), groups);
        context.host.submit_work(encoder)
    }
}

/// Returns the first of these patches, as long as their places differ.
fn distinct_places(patches: &[u32], places: u32) -> &[u32] {
    let mut used = HashSet::new();
    let clash = patches.iter().position(|patch| !used.insert(patch % places));
    &patches[..clash.unwrap_or(patches.len())]
}

fn pad_colours(colours: &[Vec3]) -> Vec<Vec4> {
    colours.iter().map(|colour| colour.extend(0.0)).collect()
}
