//! The CPU engine of the shooting loop.

use crate::deposit::{Flash, deposit};
use crate::escape::escape;
use crate::item_buffer::{ItemBuffer, View};
use crate::lookup;
use crate::power::{CellSum, power};
use crate::rays::Rays;
use common::Result;
use common::constants::SELECT_LANES;
use common::escape::directions;
use common::mesh::Mesh;
use common::reduce::tree_sum;
use common::settings::{Settings, Visibility};
use common::shooting::{Engine, Field, Shot, initial, total};
use glam::Vec3;
use rayon::prelude::*;

/// Texels per task: long enough to hide the task, short enough to share.
const TASK: usize = 1024;

/// Progressive refinement on rayon; visibility by rays, or by the item buffer's twin.
pub struct CpuSolver<'a> {
    mesh: &'a Mesh,
    settings: Settings,
    rays: Rays,
    directions: Vec<Vec3>,
    /// Escaped share of each cell that has shot: it never changes.
    escaped: Vec<Option<f32>>,
    sums: Vec<CellSum>,
    field: Field,
}

impl<'a> CpuSolver<'a> {
    /// A solver in its initial state: B = r = E.
    pub fn new(mesh: &'a Mesh, settings: &Settings) -> Self {
        let mut solver = Self {
            mesh,
            settings: settings.clone(),
            rays: Rays::new(mesh),
            directions: directions(),
            escaped: vec![None; mesh.cells.len()],
            sums: Vec::new(),
            field: initial(mesh, "cpu"),
        };
        solver.sum();
        solver
    }

    /// The rays that this solver asks.
    pub fn rays(&self) -> &Rays {
        &self.rays
    }

    fn sum(&mut self) {
        let (mesh, field) = (self.mesh, &self.field);
        self.sums = mesh
            .cells
            .par_iter()
            .map(|cell| power(mesh, field, cell))
            .collect();
    }

    fn deposit_all(&mut self, flash: &Flash) {
        let (mesh, settings, rays, cell) = (self.mesh, &self.settings, &self.rays, flash.cell);
        let view = View::new(mesh, cell, settings);
        let buffer =
            (settings.visibility != Visibility::Rays).then(|| ItemBuffer::draw(mesh, &view));
        let visible = |texel: &common::mesh::Texel| match &buffer {
            None => rays.visible(cell.shooter.centre, texel.position, [cell.face, texel.face]),
            Some(buffer) => lookup::visible(
                mesh,
                buffer,
                &view,
                settings.lookup,
                texel.position,
                texel.face,
            ),
        };
        let field = &mut self.field;
        field
            .radiosity
            .par_chunks_mut(TASK)
            .zip(field.residual.par_chunks_mut(TASK))
            .zip(field.irradiance.par_chunks_mut(TASK))
            .enumerate()
            .for_each(|(task, ((radiosity, residual), irradiance))| {
                for k in 0..radiosity.len() {
                    let state = (&mut radiosity[k], &mut residual[k], &mut irradiance[k]);
                    deposit(flash, (task * TASK + k) as u32, state, visible);
                }
            });
    }

    fn escaped(&mut self, cell: u32) -> f32 {
        let (mesh, rays, directions) = (self.mesh, &self.rays, &self.directions);
        *self.escaped[cell as usize]
            .get_or_insert_with(|| escape(mesh, rays, &mesh.cells[cell as usize], directions))
    }
}

impl Engine for CpuSolver<'_> {
    fn cell_power(&mut self) -> Result<Vec<f32>> {
        Ok(self.sums.iter().map(|sum| sum.residual.w).collect())
    }

    fn shoot(&mut self, cell: u32) -> Result<Shot> {
        let shooter = self.mesh.cells[cell as usize];
        let flux = self.sums[cell as usize].residual.truncate();
        let flash = Flash {
            mesh: self.mesh,
            cell: &shooter,
            radiosity: flux / shooter.shooter.area,
            form_factor: self.settings.form_factor,
        };
        self.deposit_all(&flash);
        self.sum();
        let received =
            tree_sum::<f32, SELECT_LANES>(0.0, self.sums.len(), |k| self.sums[k].received);
        Ok(Shot {
            cell,
            power: flux.into(),
            form_factor_sum: if shooter.shooter.area > 0.0 {
                received / shooter.shooter.area
            } else {
                0.0
            },
            escaped: self.escaped(cell),
            unshot: total(&self.cell_power()?),
        })
    }

    fn field(&mut self) -> Result<Field> {
        Ok(self.field.clone())
    }
}
