//! Progressive radiosity on the CPU: the engine of the shooting loop.

use crate::links::{LinkCache, LinkRow, RowSlot, StoredRow};
use crate::occlusion::occluders::Occluders;
use crate::rows::RowBuilder;
use crate::rows::candidates::{OccluderCandidates, occluder_candidates};
use crate::rows::receivers::TexelArrays;
use crate::shader_twins::closure::sum_form_factors;
use crate::shader_twins::deposit::deposit;
use crate::shader_twins::escape::escaped_share;
use crate::shader_twins::exchange::exchange_flux;
use crate::shader_twins::gather::{gather_irradiance, update_radiosity};
use crate::shader_twins::link::{Baseline, Sums, add_sample, link_texel, texel_form_factor};
use crate::shader_twins::lookup::SampleItemBuffers;
use crate::shader_twins::patch_transfer::patch_transfer;
use crate::shader_twins::select::{load_shot, record_shot};
use crate::shader_twins::unshot_power::unshot_power;
use common::Result;
use common::escape::escape_directions;
use common::mesh::Mesh;
use common::passes::{Exchange, PatchClosure};
use common::rays::Rays;
use common::settings::{ItemBufferSettings, Transport, Visibility};
use common::shooting::{DepositRule, RadiosityField, Restart, Shoot, Shot, initial_field};
use glam::{Vec3, Vec4};
use pulp::Arch;
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::ControlFlow;

/// Texels per task: enough to hide the overhead, few enough to balance threads.
const TEXELS_PER_TASK: usize = 1024;

/// Patches per thread whose rows are computed between two calls of the progress callback.
const PATCHES_PER_THREAD: usize = 8;

/// Progressive refinement in parallel; visibility by rays, or by the item buffer's twin.
pub struct CpuSolver<'a> {
    builder: LinkBuilder<'a>,
    links: LinkCache,
    /// Baseline of the latest shot at each texel; empty if the rule does not compare.
    baseline: Vec<Baseline>,
    /// Unshot power of each patch.
    sums: Vec<Vec4>,
    field: RadiosityField,
    reflectance: Vec<Vec3>,
    rule: DepositRule,
}

/// Computes the links of patches.
struct LinkBuilder<'a> {
    mesh: &'a Mesh,
    transport: Transport,
    rays: Rays,
    occluders: Occluders,
    receivers: TexelArrays,
    directions: Vec<Vec3>,
    arch: Arch,
}

impl<'a> CpuSolver<'a> {
    /// A solver in its initial state: B = r = E.
    pub fn new(mesh: &'a Mesh, transport: &Transport) -> Self {
        let mut solver = Self {
            builder: LinkBuilder {
                mesh,
                transport: *transport,
                rays: Rays::new(mesh),
                occluders: Occluders::from_mesh(mesh),
                receivers: TexelArrays::new(mesh),
                directions: escape_directions(),
                arch: Arch::new(),
            },
            links: LinkCache::new(mesh),
            baseline: Vec::new(),
            sums: Vec::new(),
            field: initial_field(mesh, "cpu"),
            reflectance: mesh.texels.iter().map(|t| t.reflectance).collect(),
            rule: DepositRule::FULL_DEPOSIT,
        };
        solver.sum_unshot();
        solver
    }

    /// A solver on given links: a row and its closure for each patch, as far as its cache holds them.
    pub fn with_links(mesh: &'a Mesh, transport: &Transport, rows: &[Vec<f32>], closures: &[PatchClosure]) -> Self {
        let mut solver = Self::new(mesh, transport);
        let kept = solver.links.slot_count().min(rows.len());
        for (patch, (links, closure)) in (0..).zip(rows.iter().zip(closures)).take(kept) {
            solver.replace_row(patch, links, *closure);
        }
        solver
    }

    /// Puts `links` and their closure in the place of a patch's, until another patch needs their memory.
    pub fn replace_row(&mut self, patch: u32, links: &[f32], closure: PatchClosure) {
        for slot in self.links.slots_of(&[patch]) {
            slot.links.copy_from_slice(links);
            *slot.entry = Some(StoredRow { patch, closure });
        }
    }

    /// Returns the solver's rays.
    pub fn rays(&self) -> &Rays {
        &self.builder.rays
    }

    /// Returns the links of a patch to all texels.
    pub fn link_row(&mut self, patch: u32) -> Result<LinkRow<'_>> {
        self.make_rows(&[patch]);
        self.links.require_row(patch)
    }

    /// Computes the rows of `patches` that are not stored. The patches rise and span no more numbers than there are
    /// slots.
    fn make_rows(&mut self, patches: &[u32]) {
        let missing: Vec<u32> = (patches.iter().copied())
            .filter(|patch| self.links.stored_row(*patch).is_none())
            .collect();
        // A second shot changes no other slot.
        if !missing.is_empty() {
            let builder = &self.builder;
            builder.fill_slots(self.links.slots_of(&missing));
        }
    }

    /// Returns as many of the first `patches` as have a slot each.
    fn take_fitting<'c>(&self, patches: &'c [u32], most: usize) -> &'c [u32] {
        let Some(first) = patches.first() else {
            return patches;
        };
        let end = u64::from(*first) + self.links.slot_count() as u64;
        let fitting = patches.iter().take(most);
        let count = fitting.take_while(|patch| u64::from(**patch) < end).count();
        &patches[..count]
    }

    fn sum_unshot(&mut self) {
        let (mesh, field) = (self.builder.mesh, &self.field);
        self.sums = mesh
            .patches
            .par_iter()
            .map(|patch| unshot_power(mesh, field, patch))
            .collect();
    }
}

impl LinkBuilder<'_> {
    fn fill_slots(&self, mut slots: Vec<RowSlot>) {
        if self.transport.visibility != Visibility::Rays {
            for slot in &mut slots {
                self.weight_links(slot, &self.sum_links(slot.patch, false));
            }
            return;
        }
        let rows = RowBuilder {
            mesh: self.mesh,
            kind: self.transport.form_factor,
            rays: &self.rays,
            occluders: &self.occluders,
            receivers: &self.receivers,
            arch: self.arch,
        };
        let between = self.find_candidates(&slots);
        slots.par_iter_mut().for_each(|slot| {
            let face = self.mesh.patches[slot.patch as usize].face;
            rows.fill_row(slot.patch, &between[&face], slot.links);
            self.close_row(slot);
        });
    }

    /// Returns the occluder candidates between the faces of `slots` and each other face.
    fn find_candidates(&self, slots: &[RowSlot]) -> HashMap<u32, Vec<OccluderCandidates>> {
        let mut patches: HashMap<u32, usize> = HashMap::new();
        for slot in slots {
            *patches.entry(self.mesh.patches[slot.patch as usize].face).or_default() += 1;
        }
        let samples = self.mesh.samples as usize;
        patches
            .into_par_iter()
            .map(|(face, count)| {
                let tests = count * samples;
                (face, occluder_candidates(self.mesh, &self.occluders, face, tests))
            })
            .collect()
    }

    /// Computes the links of a slot from `sums`.
    fn weight_links(&self, slot: &mut RowSlot, sums: &[Sums]) {
        let open = self.mesh.patches[slot.patch as usize].open_share;
        for (link, sums) in slot.links.iter_mut().zip(sums) {
            *link = sums.link_weight(open);
        }
        self.close_row(slot);
    }

    fn close_row(&self, slot: &mut RowSlot) {
        let mesh = self.mesh;
        let links = &*slot.links;
        let mut own = Vec::new();
        let exchanges = if slot.exchanges.is_empty() {
            own.resize(mesh.patches.len(), 0.0);
            &mut own[..]
        } else {
            &mut *slot.exchanges
        };
        for (sum, patch) in exchanges.iter_mut().zip(&mesh.patches) {
            *sum = patch_transfer(mesh, links, patch);
        }
        let area = mesh.patches[slot.patch as usize].shooter.area;
        *slot.entry = Some(StoredRow {
            patch: slot.patch,
            closure: PatchClosure {
                form_factor_sum: sum_form_factors(exchanges, area),
                escaped: escaped_share(mesh, &self.rays, slot.patch, &self.directions),
            },
        });
    }

    fn sum_links(&self, patch: u32, through: bool) -> Vec<Sums> {
        let mesh = self.mesh;
        let mut sums = vec![Sums::default(); mesh.texels.len()];
        match self.transport.visibility {
            Visibility::Rays => self.sum_by_rays(patch, through, &mut sums),
            Visibility::ItemBuffer(drawing) => {
                let kind = self.transport.form_factor;
                for_each_texel(&mut sums, |k, sums| {
                    sums.form_factor = texel_form_factor(mesh, kind, patch, k);
                });
                for s in 0..mesh.samples {
                    self.sum_by_item_buffer(&drawing, patch, s, &mut sums);
                }
            }
        }
        sums
    }

    fn sum_by_rays(&self, patch: u32, through: bool, sums: &mut [Sums]) {
        let (mesh, kind) = (self.mesh, self.transport.form_factor);
        let shooter = mesh.patches[patch as usize].face;
        for_each_texel(sums, |k, sums| {
            let ends = [shooter, mesh.texels[k as usize].face];
            *sums = link_texel(mesh, kind, patch, k, |q, p| {
                self.rays.find_sight(q, p, ends, through && !mesh.is_object(ends[1]))
            });
        });
    }

    fn sum_by_item_buffer(&self, drawing: &ItemBufferSettings, patch: u32, s: u32, sums: &mut [Sums]) {
        let mesh = self.mesh;
        let buffers = SampleItemBuffers::new(mesh, patch, s, drawing);
        for_each_texel(sums, |k, sums| {
            let face = mesh.texels[k as usize].face;
            add_sample(mesh, patch, k, s, sums, |_, p| buffers.find_sight(mesh, p, face));
        });
    }
}

fn for_each_texel(sums: &mut [Sums], add: impl Fn(u32, &mut Sums) + Sync) {
    sums.par_chunks_mut(TEXELS_PER_TASK)
        .enumerate()
        .for_each(|(task, part)| {
            for (k, sums) in part.iter_mut().enumerate() {
                add((task * TEXELS_PER_TASK + k) as u32, sums);
            }
        });
}

impl Exchange for CpuSolver<'_> {
    fn transfer_fits(&self) -> bool {
        self.links.exchanges_fit()
    }

    fn conserves_energy(&self) -> bool {
        self.builder.transport.conserve
    }

    fn make_links(
        &mut self,
        patches: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<PatchClosure>> {
        self.links.enable_exchanges();
        let mut closures = Vec::new();
        let mut flow = ControlFlow::Continue(());
        while closures.len() < patches.len() && flow.is_continue() {
            let most = PATCHES_PER_THREAD * rayon::current_num_threads();
            let group = self.take_fitting(&patches[closures.len()..], most);
            self.make_rows(group);
            for patch in group {
                closures.push(self.links.require_row(*patch)?.closure);
                if watch(closures.len()).is_break() {
                    flow = ControlFlow::Break(());
                }
            }
        }
        Ok(closures)
    }

    fn exchange_flux(&mut self, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        let rows = self.links.exchange_rows();
        Ok(exchange_flux(self.builder.arch, radiosity, rows))
    }

    fn gather_field(&mut self, shot: &[Vec3], unshot: &[Vec3]) -> Result<RadiosityField> {
        let mesh = self.builder.mesh;
        let shooters: Vec<u32> = (0..shot.len())
            .filter(|k| shot[*k] != Vec3::ZERO)
            .map(|k| k as u32)
            .collect();
        let mut irradiance = vec![Vec3::ZERO; mesh.texels.len()];
        let mut rest = &shooters[..];
        while !rest.is_empty() {
            let group = self.take_fitting(rest, usize::MAX);
            self.make_rows(group);
            let rows = group.iter().map(|patch| {
                let row = self.links.require_row(*patch)?;
                Ok((shot[*patch as usize], row.links))
            });
            let rows: Vec<(Vec3, &[f32])> = rows.collect::<Result<_>>()?;
            gather_irradiance(self.builder.arch, &rows, &mut irradiance);
            rest = &rest[group.len()..];
        }
        for (k, texel) in mesh.texels.iter().enumerate() {
            let radiosity = update_radiosity(texel, self.reflectance[k], irradiance[k]);
            self.field.radiosity[k] = radiosity.extend(0.0);
            self.field.irradiance[k] = irradiance[k].extend(0.0);
        }
        for (patch, unshot) in mesh.patches.iter().zip(unshot) {
            self.field.residual[patch.texels()].fill(unshot.extend(0.0));
        }
        self.sum_unshot();
        self.read_field()
    }
}

impl Shoot for CpuSolver<'_> {
    fn patch_power(&mut self) -> Result<Vec<f32>> {
        Ok(self.sums.iter().map(|sum| sum.w).collect())
    }

    fn shoot(&mut self, patch: u32) -> Result<Shot> {
        let (builder, rule) = (&self.builder, self.rule);
        let shooter = &builder.mesh.patches[patch as usize];
        if rule.compares_links() {
            // The baseline needs the sums of this shot, so its links are computed again.
            let sums = builder.sum_links(patch, rule.captured);
            let baseline = |(k, sums): (usize, &Sums)| sums.link_baseline(builder.mesh, rule, shooter, k as u32);
            self.baseline = sums.par_iter().enumerate().map(baseline).collect();
            for slot in &mut self.links.slots_of(&[patch]) {
                builder.weight_links(slot, &sums);
            }
        } else {
            self.make_rows(&[patch]);
        }
        let builder = &self.builder;
        let row = self.links.require_row(patch)?;
        let flux = self.sums[patch as usize].truncate();
        let closure = row.closure;
        let scale = closure.link_scale(builder.transport.conserve);
        let in_flight = load_shot(builder.mesh, patch, flux, scale, rule, &self.reflectance);
        let (field, baseline) = (&mut self.field, &self.baseline);
        field
            .radiosity
            .par_chunks_mut(TEXELS_PER_TASK)
            .zip(field.residual.par_chunks_mut(TEXELS_PER_TASK))
            .zip(field.irradiance.par_chunks_mut(TEXELS_PER_TASK))
            .zip(row.links.par_chunks(TEXELS_PER_TASK))
            .enumerate()
            .for_each(|(task, (((radiosity, residual), irradiance), links))| {
                for k in 0..radiosity.len() {
                    let state = (&mut radiosity[k], &mut residual[k], &mut irradiance[k]);
                    let texel = task * TEXELS_PER_TASK + k;
                    let baseline = baseline.get(texel).copied().unwrap_or_default();
                    deposit(&in_flight, texel as u32, links[k], baseline, state);
                }
            });
        self.sum_unshot();
        Ok(record_shot(patch, flux, scale, closure, &self.patch_power()?))
    }

    fn read_field(&mut self) -> Result<RadiosityField> {
        Ok(self.field.clone())
    }
}

impl Restart for CpuSolver<'_> {
    fn restart_from(&mut self, rule: DepositRule, reflectance: &[Vec3], field: &RadiosityField) -> Result<()> {
        self.rule = rule.check_conserve(self.builder.transport.conserve)?;
        self.reflectance = reflectance.to_vec();
        self.field = RadiosityField {
            origin: self.field.origin.clone(),
            ..field.clone()
        };
        self.baseline.clear();
        self.sum_unshot();
        Ok(())
    }
}
