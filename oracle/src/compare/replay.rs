//! Replays a solve on given links with the scalar solver: with the GPU's links it must reach the GPU's result,
//! whatever the item buffer shows. It is the twin of all stages after the links.

use common::Result;
use common::mesh::Mesh;
use common::passes::PatchClosure;
use common::shooting::{DepositRule, RadiosityField, Shoot, Shot, initial_field, total_power};
use cpu::shader_twins::deposit::{ShotInFlight, deposit};
use cpu::shader_twins::gather::update_radiosity;
use cpu::shader_twins::link::Baseline;
use cpu::shader_twins::unshot_power::unshot_power;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Receivers per task.
const RECEIVERS_PER_TASK: usize = 1024;

/// Links of every patch with their sums.
pub struct LinkRows {
    /// Weight w of each texel, one row per patch.
    pub rows: Vec<Vec<f32>>,
    /// ΣF and the escaped share of each patch.
    pub closures: Vec<PatchClosure>,
}

/// State of a solve on given links.
pub struct LinkedReplay<'a> {
    mesh: &'a Mesh,
    links: &'a LinkRows,
    conserve: bool,
    reflectance: Vec<Vec3>,
    sums: Vec<Vec4>,
    field: RadiosityField,
    /// Largest (strongest − chosen) / strongest power of all shots.
    shortfall: f64,
}

impl<'a> LinkedReplay<'a> {
    /// Creates the initial state: B = r = E.
    pub fn new(mesh: &'a Mesh, links: &'a LinkRows, conserve: bool) -> Self {
        let mut linked = Self {
            mesh,
            links,
            conserve,
            reflectance: mesh.texels.iter().map(|t| t.reflectance).collect(),
            sums: Vec::new(),
            field: initial_field(mesh, "the twin on given links"),
            shortfall: 0.0,
        };
        linked.update_power();
        linked
    }

    /// Returns the largest (strongest − chosen) / strongest power of all shots.
    pub fn power_shortfall(&self) -> f64 {
        self.shortfall
    }

    /// Returns the solution.
    pub fn into_field(self) -> RadiosityField {
        self.field
    }

    fn update_power(&mut self) {
        let (mesh, field) = (self.mesh, &self.field);
        let sums = mesh.patches.par_iter().map(|patch| unshot_power(mesh, field, patch));
        self.sums = sums.collect();
    }

    fn record_shortfall(&mut self, patch: u32) {
        let strongest = self.sums.iter().map(|sum| sum.w).fold(0.0, f32::max);
        let chosen = self.sums[patch as usize].w;
        if strongest > 0.0 {
            let shortfall = f64::from(strongest - chosen) / f64::from(strongest);
            self.shortfall = self.shortfall.max(shortfall);
        }
    }

    fn link_scale(&self, patch: usize) -> f32 {
        self.links.closures[patch].link_scale(self.conserve)
    }

    /// Gathers all shots at once: patch i has shot `shot[i]` in all, and `unshot[i]` remains, both before the scaling
    /// of its links.
    pub fn gather_all(&mut self, shot: &[Vec3], unshot: &[Vec3]) {
        let mesh = self.mesh;
        let mut irradiance = vec![Vec3::ZERO; mesh.texels.len()];
        let scaled: Vec<Vec3> = (0..shot.len()).map(|i| shot[i] * self.link_scale(i)).collect();
        irradiance
            .par_chunks_mut(RECEIVERS_PER_TASK)
            .enumerate()
            .for_each(|(task, part)| {
                for (x, row) in scaled.iter().zip(&self.links.rows) {
                    if *x != Vec3::ZERO {
                        for (h, w) in part.iter_mut().zip(&row[task * RECEIVERS_PER_TASK..]) {
                            *h += *x * *w;
                        }
                    }
                }
            });
        for (k, texel) in mesh.texels.iter().enumerate() {
            let radiosity = update_radiosity(texel, self.reflectance[k], irradiance[k]);
            self.field.radiosity[k] = radiosity.extend(0.0);
            self.field.irradiance[k] = irradiance[k].extend(0.0);
        }
        for (patch, unshot) in mesh.patches.iter().zip(unshot) {
            self.field.residual[patch.texels()].fill(unshot.extend(0.0));
        }
    }
}

impl Shoot for LinkedReplay<'_> {
    fn patch_power(&mut self) -> Result<Vec<f32>> {
        Ok(self.sums.iter().map(|sum| sum.w).collect())
    }

    fn shoot(&mut self, patch: u32) -> Result<Shot> {
        self.record_shortfall(patch);
        let shooter = &self.mesh.patches[patch as usize];
        let flux = self.sums[patch as usize].truncate();
        let scale = self.link_scale(patch as usize);
        let in_flight = ShotInFlight {
            mesh: self.mesh,
            patch: shooter,
            radiosity: flux / shooter.shooter.area,
            scale,
            rule: DepositRule::FULL_DEPOSIT,
            reflectance: &self.reflectance,
        };
        let row = &self.links.rows[patch as usize];
        let field = &mut self.field;
        (field.radiosity.par_iter_mut())
            .zip(field.residual.par_iter_mut())
            .zip(field.irradiance.par_iter_mut())
            .zip(row.par_iter())
            .enumerate()
            .with_min_len(RECEIVERS_PER_TASK)
            .for_each(|(k, (((b, r), h), w))| {
                deposit(&in_flight, k as u32, *w, Baseline::default(), (b, r, h));
            });
        self.update_power();
        let closure = self.links.closures[patch as usize];
        Ok(Shot {
            patch,
            power: flux.into(),
            form_factor_sum: closure.form_factor_sum * scale,
            escaped: closure.escaped,
            unshot: total_power(&self.patch_power()?),
        })
    }

    fn read_field(&mut self) -> Result<RadiosityField> {
        Ok(self.field.clone())
    }
}
