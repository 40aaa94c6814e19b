//! The CPU engine of the shooting loop.

use crate::links::{KeptRow, Links, Place, Row};
use crate::occlusion::occluders::Occluders;
use crate::rows::Rows;
use crate::rows::candidates::{Between, candidates};
use crate::rows::receivers::Receivers;
use crate::twin::accumulate::{accumulate, settle};
use crate::twin::closure::closure;
use crate::twin::deposit::{ShotInFlight, deposit};
use crate::twin::escape::escape;
use crate::twin::link::{Baseline, Sums, factor, sample};
use crate::twin::lookup::Buffers;
use crate::twin::power::power;
use crate::twin::received::received;
use common::Result;
use common::escape::directions;
use common::mesh::Mesh;
use common::passes::{Closure, Exchange};
use common::rays::Rays;
use common::settings::{Drawing, Transport, Visibility};
use common::shooting::{Field, Restart, Rule, Shoot, Shot, initial, total};
use glam::{Vec3, Vec4};
use pulp::Arch;
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::ControlFlow;

/// Texels per task: long enough to hide the task, short enough to share.
const TASK: usize = 1024;

/// Cells of each thread whose links are made between two looks at the progress.
const GROUP: usize = 8;

/// Progressive refinement on rayon; visibility by rays, or by the item buffer's twin.
pub struct CpuSolver<'a> {
    caster: Caster<'a>,
    links: Links,
    /// What the room had of the latest shot; empty where the rule does not ask.
    baseline: Vec<Baseline>,
    /// What each cell has yet to shoot.
    sums: Vec<Vec4>,
    field: Field,
    reflectance: Vec<Vec3>,
    rule: Rule,
}

/// What makes a cell's links.
struct Caster<'a> {
    mesh: &'a Mesh,
    transport: Transport,
    rays: Rays,
    occluders: Occluders,
    receivers: Receivers,
    directions: Vec<Vec3>,
    arch: Arch,
}

impl<'a> CpuSolver<'a> {
    /// A solver in its initial state: B = r = E.
    pub fn new(mesh: &'a Mesh, transport: &Transport) -> Self {
        let mut solver = Self {
            caster: Caster {
                mesh,
                transport: *transport,
                rays: Rays::new(mesh),
                occluders: Occluders::rounded(mesh),
                receivers: Receivers::new(mesh),
                directions: directions(),
                arch: Arch::new(),
            },
            links: Links::new(mesh),
            baseline: Vec::new(),
            sums: Vec::new(),
            field: initial(mesh, "cpu"),
            reflectance: mesh.texels.iter().map(|t| t.reflectance).collect(),
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
    pub fn row(&mut self, cell: u32) -> Result<Row<'_>> {
        self.make(&[cell]);
        self.links.made(cell)
    }

    /// Makes the rows of `cells` that are not kept; the cells in rising order, and no more than
    /// there are places from the first to the last.
    fn make(&mut self, cells: &[u32]) {
        let missing: Vec<u32> = (cells.iter().copied())
            .filter(|cell| self.links.row(*cell).is_none())
            .collect();
        // A second shot touches no place but its own.
        if !missing.is_empty() {
            let caster = &self.caster;
            caster.fill(self.links.places_of(&missing));
        }
    }

    /// As many of the first of `cells` as have a place each.
    fn group<'c>(&self, cells: &'c [u32], most: usize) -> &'c [u32] {
        let Some(first) = cells.first() else {
            return cells;
        };
        let end = u64::from(*first) + self.links.places() as u64;
        let fitting = cells.iter().take(most);
        let count = fitting.take_while(|cell| u64::from(**cell) < end).count();
        &cells[..count]
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
    fn fill(&self, mut places: Vec<Place>) {
        if self.transport.visibility != Visibility::Rays {
            for place in &mut places {
                self.weigh(place, &self.sums(place.cell, false));
            }
            return;
        }
        let rows = Rows {
            mesh: self.mesh,
            kind: self.transport.form_factor,
            rays: &self.rays,
            occluders: &self.occluders,
            receivers: &self.receivers,
            arch: self.arch,
        };
        let between = self.between(&places);
        places.par_iter_mut().for_each(|place| {
            let face = self.mesh.cells[place.cell as usize].face;
            rows.fill(place.cell, &between[&face], place.links);
            self.close(place);
        });
    }

    /// What may come between the faces of `places` and every other one.
    fn between(&self, places: &[Place]) -> HashMap<u32, Vec<Between>> {
        let mut cells: HashMap<u32, usize> = HashMap::new();
        for place in places {
            *cells
                .entry(self.mesh.cells[place.cell as usize].face)
                .or_default() += 1;
        }
        let samples = self.mesh.samples as usize;
        cells
            .into_par_iter()
            .map(|(face, count)| {
                let questions = count * samples;
                (
                    face,
                    candidates(self.mesh, &self.occluders, face, questions),
                )
            })
            .collect()
    }

    /// The links by `sums`.
    fn weigh(&self, place: &mut Place, sums: &[Sums]) {
        let open = self.mesh.cells[place.cell as usize].open;
        for (link, sums) in place.links.iter_mut().zip(sums) {
            *link = sums.link(open);
        }
        self.close(place);
    }

    fn close(&self, place: &mut Place) {
        let mesh = self.mesh;
        let links = &*place.links;
        let mut own = Vec::new();
        let taken = if place.taken.is_empty() {
            own.resize(mesh.cells.len(), 0.0);
            &mut own[..]
        } else {
            &mut *place.taken
        };
        for (sum, cell) in taken.iter_mut().zip(&mesh.cells) {
            *sum = received(mesh, links, cell);
        }
        let area = mesh.cells[place.cell as usize].shooter.area;
        *place.kept = Some(KeptRow {
            cell: place.cell,
            closure: Closure {
                form_factor_sum: closure(taken, area),
                escaped: escape(mesh, &self.rays, place.cell, &self.directions),
            },
        });
    }

    fn sums(&self, cell: u32, through: bool) -> Vec<Sums> {
        let mesh = self.mesh;
        let mut sums = vec![Sums::default(); mesh.texels.len()];
        match self.transport.visibility {
            Visibility::Rays => self.by_rays(cell, through, &mut sums),
            Visibility::Drawn(drawing) => {
                let kind = self.transport.form_factor;
                each(&mut sums, |k, sums| {
                    sums.form_factor = factor(mesh, kind, cell, k);
                });
                for s in 0..mesh.samples {
                    self.by_item_buffer(&drawing, cell, s, &mut sums);
                }
            }
        }
        sums
    }

    fn by_rays(&self, cell: u32, through: bool, sums: &mut [Sums]) {
        let (mesh, kind) = (self.mesh, self.transport.form_factor);
        let shooter = mesh.cells[cell as usize].face;
        each(sums, |k, sums| {
            let ends = [shooter, mesh.texels[k as usize].face];
            sums.form_factor = factor(mesh, kind, cell, k);
            for s in 0..mesh.samples {
                sample(mesh, cell, k, s, sums, |q, p| {
                    self.rays
                        .sight(q, p, ends, through && !mesh.is_object(ends[1]))
                });
            }
        });
    }

    fn by_item_buffer(&self, drawing: &Drawing, cell: u32, s: u32, sums: &mut [Sums]) {
        let mesh = self.mesh;
        let buffers = Buffers::new(mesh, cell, s, drawing);
        each(sums, |k, sums| {
            let face = mesh.texels[k as usize].face;
            sample(mesh, cell, k, s, sums, |_, p| buffers.sight(mesh, p, face));
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

impl Exchange for CpuSolver<'_> {
    fn has_room(&self) -> bool {
        self.links.has_room()
    }

    fn conserves(&self) -> bool {
        self.caster.transport.conserve
    }

    fn link(
        &mut self,
        cells: &[u32],
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<Closure>> {
        self.links.exchange();
        let mut closures = Vec::new();
        let mut flow = ControlFlow::Continue(());
        while closures.len() < cells.len() && flow.is_continue() {
            let most = GROUP * rayon::current_num_threads();
            let group = self.group(&cells[closures.len()..], most);
            self.make(group);
            for cell in group {
                closures.push(self.links.made(*cell)?.closure);
                if watch(closures.len()).is_break() {
                    flow = ControlFlow::Break(());
                }
            }
        }
        Ok(closures)
    }

    fn exchange(&mut self, radiosity: &[Vec3]) -> Result<Vec<Vec3>> {
        let rows: Vec<(Vec3, &[f32])> = (radiosity.iter().zip(self.links.taken()))
            .filter(|(shot, _)| **shot != Vec3::ZERO)
            .map(|(shot, row)| (*shot, row))
            .collect();
        let mut sums = vec![Vec3::ZERO; radiosity.len()];
        accumulate(self.caster.arch, &rows, &mut sums);
        Ok(sums)
    }

    fn gather(&mut self, shot: &[Vec3], unshot: &[Vec3]) -> Result<Field> {
        let mesh = self.caster.mesh;
        let shooters: Vec<u32> = (0..shot.len())
            .filter(|k| shot[*k] != Vec3::ZERO)
            .map(|k| k as u32)
            .collect();
        let mut irradiance = vec![Vec3::ZERO; mesh.texels.len()];
        let mut rest = &shooters[..];
        while !rest.is_empty() {
            let group = self.group(rest, usize::MAX);
            self.make(group);
            let rows = group.iter().map(|cell| {
                let row = self.links.made(*cell)?;
                Ok((shot[*cell as usize], row.links))
            });
            let rows: Vec<(Vec3, &[f32])> = rows.collect::<Result<_>>()?;
            accumulate(self.caster.arch, &rows, &mut irradiance);
            rest = &rest[group.len()..];
        }
        for (k, texel) in mesh.texels.iter().enumerate() {
            let radiosity = settle(texel, self.reflectance[k], irradiance[k]);
            self.field.radiosity[k] = radiosity.extend(0.0);
            self.field.irradiance[k] = irradiance[k].extend(0.0);
        }
        for (cell, unshot) in mesh.cells.iter().zip(unshot) {
            self.field.residual[cell.texels()].fill(unshot.extend(0.0));
        }
        self.sum();
        self.field()
    }
}

impl Shoot for CpuSolver<'_> {
    fn cell_power(&mut self) -> Result<Vec<f32>> {
        Ok(self.sums.iter().map(|sum| sum.w).collect())
    }

    fn shoot(&mut self, cell: u32) -> Result<Shot> {
        let (caster, rule) = (&self.caster, self.rule);
        let shooter = &caster.mesh.cells[cell as usize];
        if rule.compares() {
            // The sums are those of this shot: its links are made anew.
            let sums = caster.sums(cell, rule.captured);
            let baseline =
                |(k, sums): (usize, &Sums)| sums.baseline(caster.mesh, rule, shooter, k as u32);
            self.baseline = sums.par_iter().enumerate().map(baseline).collect();
            for place in &mut self.links.places_of(&[cell]) {
                caster.weigh(place, &sums);
            }
        } else {
            self.make(&[cell]);
        }
        let caster = &self.caster;
        let row = self.links.made(cell)?;
        let flux = self.sums[cell as usize].truncate();
        let in_flight = ShotInFlight {
            mesh: caster.mesh,
            cell: shooter,
            radiosity: flux / shooter.shooter.area,
            scale: row.closure.scale(caster.transport.conserve),
            rule,
            reflectance: &self.reflectance,
        };
        let form_factor_sum = row.closure.form_factor_sum * in_flight.scale;
        let escaped = row.closure.escaped;
        let (field, baseline) = (&mut self.field, &self.baseline);
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
                    let baseline = baseline.get(texel).copied().unwrap_or_default();
                    deposit(&in_flight, texel as u32, links[k], baseline, state);
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
}

impl Restart for CpuSolver<'_> {
    fn restart(&mut self, rule: Rule, reflectance: &[Vec3], field: &Field) -> Result<()> {
        self.rule = rule.with(self.caster.transport.conserve)?;
        self.reflectance = reflectance.to_vec();
        self.field = Field {
            origin: self.field.origin.clone(),
            ..field.clone()
        };
        self.baseline.clear();
        self.sum();
        Ok(())
    }
}
