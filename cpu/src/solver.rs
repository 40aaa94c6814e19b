//! The CPU engine of the shooting loop.

use crate::deposit::{Flash, deposit};
use crate::escape::escape;
use crate::link::{Past, Sums, sample};
use crate::links::{Links, Row};
use crate::lookup::Buffers;
use crate::power::{closure, power, received};
use crate::rays::Rays;
use common::Result;
use common::constants::LINK_BYTES;
use common::escape::directions;
use common::mesh::Mesh;
use common::passes::Closure;
use common::settings::{Settings, Visibility};
use common::shooting::{Engine, Field, Rule, Shot, initial, total};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Texels per task: long enough to hide the task, short enough to share.
const TASK: usize = 1024;

/// Progressive refinement on rayon; visibility by rays, or by the item buffer's twin.
pub struct CpuSolver<'a> {
    caster: Caster<'a>,
    links: Links,
    /// What the room had of the latest shot; empty where the rule does not ask.
    past: Vec<Past>,
    /// What each cell has yet to shoot.
    sums: Vec<Vec4>,
    field: Field,
    reflectance: Vec<Vec3>,
    /// T: what each cell takes of each linked one.
    received: Vec<Vec<f32>>,
    rule: Rule,
}

/// What makes a cell's links.
struct Caster<'a> {
    mesh: &'a Mesh,
    settings: Settings,
    rays: Rays,
    directions: Vec<Vec3>,
}

impl<'a> CpuSolver<'a> {
    /// A solver in its initial state: B = r = E.
    pub fn new(mesh: &'a Mesh, settings: &Settings) -> Self {
        let mut solver = Self {
            caster: Caster {
                mesh,
                settings: settings.clone(),
                rays: Rays::new(mesh),
                directions: directions(),
            },
            links: Links::new(mesh),
            past: Vec::new(),
            sums: Vec::new(),
            field: initial(mesh, "cpu"),
            reflectance: mesh.texels.iter().map(|t| t.reflectance).collect(),
            received: Vec::new(),
            rule: Rule::PLAIN,
        };
        solver.sum();
        solver
    }

    /// The rays that this solver asks.
    pub fn rays(&self) -> &Rays {
        &self.caster.rays
    }

    /// The links of a cell.
    pub fn row(&mut self, cell: u32) -> &Row {
        let caster = &self.caster;
        self.links.row(cell, |links| {
            caster.row(cell, &caster.sums(cell, false), links)
        })
    }

    fn sum(&mut self) {
        let (mesh, field) = (self.caster.mesh, &self.field);
        self.sums = mesh
            .cells
            .par_iter()
            .map(|cell| power(mesh, field, cell))
            .collect();
    }
}

impl Caster<'_> {
    fn row(&self, cell: u32, sums: &[Sums], mut links: Vec<f32>) -> Row {
        let mesh = self.mesh;
        links.clear();
        let open = mesh.cells[cell as usize].open;
        links.extend(sums.iter().map(|sums| sums.link(mesh.samples, open)));
        let taken: Vec<f32> = mesh
            .cells
            .par_iter()
            .map(|cell| received(mesh, &links, cell))
            .collect();
        Row {
            cell,
            taken: taken.clone(),
            sum: closure(&taken, mesh.cells[cell as usize].shooter.area),
            escaped: escape(mesh, &self.rays, cell, &self.directions),
            links,
        }
    }

    fn sums(&self, cell: u32, through: bool) -> Vec<Sums> {
        let mesh = self.mesh;
        let mut sums = vec![Sums::default(); mesh.texels.len()];
        if self.settings.visibility == Visibility::Rays {
            self.by_rays(cell, through, &mut sums);
        } else {
            for s in 0..mesh.samples {
                self.by_item_buffer(cell, s, &mut sums);
            }
        }
        sums
    }

    fn by_rays(&self, cell: u32, through: bool, sums: &mut [Sums]) {
        let (mesh, kind) = (self.mesh, self.settings.form_factor);
        let shooter = mesh.cells[cell as usize].face;
        each(sums, |k, sums| {
            let ends = [shooter, mesh.texels[k as usize].face];
            for s in 0..mesh.samples {
                sample(mesh, kind, cell, k, s, sums, |q, p| {
                    self.rays
                        .sight(q, p, ends, through && !mesh.is_object(ends[1]))
                });
            }
        });
    }

    fn by_item_buffer(&self, cell: u32, s: u32, sums: &mut [Sums]) {
        let (mesh, settings) = (self.mesh, &self.settings);
        let buffers = Buffers::new(mesh, cell, s, settings);
        each(sums, |k, sums| {
            let face = mesh.texels[k as usize].face;
            sample(mesh, settings.form_factor, cell, k, s, sums, |_, p| {
                buffers.sight(mesh, p, face)
            });
        });
    }
}

fn each(sums: &mut [Sums], add: impl Fn(u32, &mut Sums) + Sync) {
    sums.par_chunks_mut(TASK)
        .enumerate()
        .for_each(|(task, part)| {
            for (k, sums) in part.iter_mut().enumerate() {
                add((task * TASK + k) as u32, sums);
            }
        });
}

impl Engine for CpuSolver<'_> {
    fn exchanges(&self) -> bool {
        let cells = self.caster.mesh.cells.len() as u64;
        4 * cells * cells <= LINK_BYTES
    }

    fn link(
        &mut self,
        cells: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<Closure>> {
        self.received
            .resize(self.caster.mesh.cells.len(), Vec::new());
        let mut closures = Vec::new();
        for cell in cells {
            let row = self.row(*cell);
            closures.push(Closure {
                form_factor_sum: row.sum,
                escaped: row.escaped,
            });
            self.received[*cell as usize] = row.taken.clone();
            if watch(closures.len()).is_break() {
                break;
            }
        }
        Ok(closures)
    }

    fn exchange(&mut self, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        let received = &self.received;
        Ok((0..radiosity.len())
            .into_par_iter()
            .map(|c| {
                let mut sum = Vec3::ZERO;
                for (shot, taken) in radiosity.iter().zip(received) {
                    if *shot != Vec3::ZERO {
                        sum += *shot * taken[c];
                    }
                }
                sum
            })
            .collect())
    }

    fn gather(&mut self, shot: &[Vec3], unshot: &[Vec3]) -> Result<()> {
        let mesh = self.caster.mesh;
        let mut irradiance = vec![Vec4::ZERO; mesh.texels.len()];
        for (cell, shot) in (0..).zip(shot).filter(|(_, shot)| **shot != Vec3::ZERO) {
            let row = self.row(cell);
            irradiance
                .par_iter_mut()
                .zip(&row.links)
                .for_each(|(h, w)| *h += (*shot * *w).extend(0.0));
        }
        for (k, texel) in mesh.texels.iter().enumerate() {
            let reflected = self.reflectance[k] * irradiance[k].truncate();
            self.field.radiosity[k] = (texel.emission + reflected).extend(0.0);
        }
        self.field.irradiance = irradiance;
        for (cell, unshot) in mesh.cells.iter().zip(unshot) {
            self.field.residual[cell.texels()].fill(unshot.extend(0.0));
        }
        self.sum();
        Ok(())
    }

    fn cell_power(&mut self) -> Result<Vec<f32>> {
        Ok(self.sums.iter().map(|sum| sum.w).collect())
    }

    fn shoot(&mut self, cell: u32) -> Result<Shot> {
        let (caster, rule) = (&self.caster, self.rule);
        let shooter = &caster.mesh.cells[cell as usize];
        if rule.compares() {
            // The sums are those of this shot: its links are made anew.
            let sums = caster.sums(cell, rule.captured);
            let past = |(k, sums): (usize, &Sums)| sums.past(caster.mesh, rule, shooter, k as u32);
            self.past = sums.par_iter().enumerate().map(past).collect();
            self.links
                .replace(cell, |links| caster.row(cell, &sums, links));
        }
        let row = self.links.row(cell, |links| {
            caster.row(cell, &caster.sums(cell, false), links)
        });
        let flux = self.sums[cell as usize].truncate();
        let flash = Flash {
            mesh: caster.mesh,
            cell: shooter,
            radiosity: flux / shooter.shooter.area,
            scale: conserving(caster.settings.conserve, row.sum, row.escaped),
            rule,
            reflectance: &self.reflectance,
        };
        let (form_factor_sum, escaped) = (row.sum * flash.scale, row.escaped);
        let (field, past) = (&mut self.field, &self.past);
        field
            .radiosity
            .par_chunks_mut(TASK)
            .zip(field.residual.par_chunks_mut(TASK))
            .zip(field.irradiance.par_chunks_mut(TASK))
            .zip(row.links.par_chunks(TASK))
            .enumerate()
            .for_each(|(task, (((radiosity, residual), irradiance), links))| {
                for k in 0..radiosity.len() {
                    let state = (&mut radiosity[k], &mut residual[k], &mut irradiance[k]);
                    let texel = task * TASK + k;
                    let past = past.get(texel).copied().unwrap_or_default();
                    deposit(&flash, texel as u32, links[k], past, state);
                }
            });
        self.sum();
        Ok(Shot {
            cell,
            power: flux.into(),
            form_factor_sum,
            escaped,
            unshot: total(&self.cell_power()?),
        })
    }

    fn field(&mut self) -> Result<Field> {
        Ok(self.field.clone())
    }

    fn restart(&mut self, rule: Rule, reflectance: &[Vec3], field: &Field) -> Result<()> {
        self.rule = rule;
        self.reflectance = reflectance.to_vec();
        self.field = Field {
            origin: self.field.origin.clone(),
            ..field.clone()
        };
        self.past.clear();
        self.sum();
        Ok(())
    }
}

/// What brings ΣF to 1 − escaped. Twin of the function in `gpu/src/shaders/closure.wgsl`.
pub fn conserving(asked: bool, sum: f32, escaped: f32) -> f32 {
    if asked && sum > 0.0 {
        (1.0 - escaped) / sum
    } else {
        1.0
    }
}
