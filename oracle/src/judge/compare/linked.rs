//! The scalar solver on links that somebody else made: with a GPU's links it must end where the GPU
//! ended, whatever its item buffer shows. The twin of everything that follows the links.

use common::Result;
use common::mesh::Mesh;
use common::passes::Closure;
use common::shooting::{Field, Rule, Shoot, Shot, initial, total};
use cpu::twin::accumulate::settle;
use cpu::twin::deposit::{ShotInFlight, deposit};
use cpu::twin::link::Baseline;
use cpu::twin::power::power;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Receivers per task.
const TASK: usize = 1024;

/// The links of every cell, and what they sum to.
pub struct Links {
    /// w of each texel, cell after cell.
    pub rows: Vec<Vec<f32>>,
    /// ΣF and the escaped share of each cell.
    pub closures: Vec<Closure>,
}

/// The state of a solve on given links.
pub struct Linked<'a> {
    mesh: &'a Mesh,
    links: &'a Links,
    conserve: bool,
    reflectance: Vec<Vec3>,
    sums: Vec<Vec4>,
    field: Field,
    /// Of the shooters, how far the least strong was below the strongest there was.
    shortfall: f64,
}

impl<'a> Linked<'a> {
    /// The initial state: B = r = E.
    pub fn new(mesh: &'a Mesh, links: &'a Links, conserve: bool) -> Self {
        let mut linked = Self {
            mesh,
            links,
            conserve,
            reflectance: mesh.texels.iter().map(|t| t.reflectance).collect(),
            sums: Vec::new(),
            field: initial(mesh, "the twin on given links"),
            shortfall: 0.0,
        };
        linked.sum();
        linked
    }

    /// Of all shooters so far, the greatest (strongest − chosen) / strongest.
    pub fn shortfall(&self) -> f64 {
        self.shortfall
    }

    /// What it has come to.
    pub fn into_field(self) -> Field {
        self.field
    }

    fn sum(&mut self) {
        let (mesh, field) = (self.mesh, &self.field);
        let sums = mesh.cells.par_iter().map(|cell| power(mesh, field, cell));
        self.sums = sums.collect();
    }

    fn note(&mut self, cell: u32) {
        let most = self.sums.iter().map(|sum| sum.w).fold(0.0, f32::max);
        let chosen = self.sums[cell as usize].w;
        if most > 0.0 {
            let short = f64::from(most - chosen) / f64::from(most);
            self.shortfall = self.shortfall.max(short);
        }
    }

    fn scale(&self, cell: usize) -> f32 {
        self.links.closures[cell].scale(self.conserve)
    }

    /// Every cell i has shot `shot[i]` in all and has `unshot[i]` left, before its links are scaled.
    pub fn collect(&mut self, shot: &[Vec3], unshot: &[Vec3]) {
        let mesh = self.mesh;
        let mut irradiance = vec![Vec3::ZERO; mesh.texels.len()];
        let scaled: Vec<Vec3> = (0..shot.len()).map(|i| shot[i] * self.scale(i)).collect();
        irradiance
            .par_chunks_mut(TASK)
            .enumerate()
            .for_each(|(task, part)| {
                for (x, row) in scaled.iter().zip(&self.links.rows) {
                    if *x != Vec3::ZERO {
                        for (h, w) in part.iter_mut().zip(&row[task * TASK..]) {
                            *h += *x * *w;
                        }
                    }
                }
            });
        for (k, texel) in mesh.texels.iter().enumerate() {
            let radiosity = settle(texel, self.reflectance[k], irradiance[k]);
            self.field.radiosity[k] = radiosity.extend(0.0);
            self.field.irradiance[k] = irradiance[k].extend(0.0);
        }
        for (cell, unshot) in mesh.cells.iter().zip(unshot) {
            self.field.residual[cell.texels()].fill(unshot.extend(0.0));
        }
    }
}

impl Shoot for Linked<'_> {
    fn cell_power(&mut self) -> Result<Vec<f32>> {
        Ok(self.sums.iter().map(|sum| sum.w).collect())
    }

    fn shoot(&mut self, cell: u32) -> Result<Shot> {
        self.note(cell);
        let shooter = &self.mesh.cells[cell as usize];
        let flux = self.sums[cell as usize].truncate();
        let scale = self.scale(cell as usize);
        let in_flight = ShotInFlight {
            mesh: self.mesh,
            cell: shooter,
            radiosity: flux / shooter.shooter.area,
            scale,
            rule: Rule::PLAIN,
            reflectance: &self.reflectance,
        };
        let row = &self.links.rows[cell as usize];
        let field = &mut self.field;
        (field.radiosity.par_iter_mut())
            .zip(field.residual.par_iter_mut())
            .zip(field.irradiance.par_iter_mut())
            .zip(row.par_iter())
            .enumerate()
            .with_min_len(TASK)
            .for_each(|(k, (((b, r), h), w))| {
                deposit(&in_flight, k as u32, *w, Baseline::default(), (b, r, h));
            });
        self.sum();
        let closure = self.links.closures[cell as usize];
        Ok(Shot {
            cell,
            power: flux.into(),
            form_factor_sum: closure.form_factor_sum * scale,
            escaped: closure.escaped,
            unshot: total(&self.cell_power()?),
        })
    }

    fn field(&mut self) -> Result<Field> {
        Ok(self.field.clone())
    }
}
