//! The GPU's links to all cells, and what they differ from the CPU's by: pair by pair and sample by
//! sample where an item buffer is asked, link by link where rays are.

use super::counts::Tally;
use super::linked::Links;
use super::pairs::{CellPairs, FACING, Probe};
use super::raster;
use super::stages::{factor_roundings, sizes};
use super::tally::{Tally as Errors, ulps};
use crate::judge::comparison::{Pairs, Stage};
use common::escape::DIRECTIONS;
use common::mesh::Mesh;
use common::passes::Closure;
use common::passes::Exchange;
use common::settings::{Drawing, Transport, Visibility};

use common::{Error, Result};
use cpu::CpuSolver;
use cpu::twin::item_buffer::ItemBuffer;
use cpu::twin::link::factor;
use cpu::twin::view::View;
use gpu::GpuSolver;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// What is known of all links.
pub struct Sights {
    /// Who sees whom.
    pub pairs: Pairs,
    /// The GPU's links.
    pub gpu: Links,
    /// The CPU's.
    pub cpu: Links,
    /// What each of them would change by, were all samples near silhouettes judged the other way.
    pub doubt: Vec<Vec<f32>>,
    /// Links that differ by more than what is seen, and pixels of silhouettes.
    pub stages: Vec<Stage>,
}

/// All links of both; `progress` is told after each cell, and may break.
pub fn sights(
    mesh: &Mesh,
    transport: &Transport,
    cpu: &mut CpuSolver,
    solver: &mut GpuSolver,
    progress: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Sights> {
    let mut all = All {
        mesh,
        transport,
        tally: Tally::default(),
        links: Errors::default(),
        escapes: Errors::default(),
        pixels: Errors::default(),
    };
    let mut sights = Sights {
        pairs: Pairs::default(),
        gpu: empty(),
        cpu: empty(),
        doubt: Vec::new(),
        stages: Vec::new(),
    };
    let cells: Vec<u32> = (0..mesh.cells.len() as u32).collect();
    let rays = transport.visibility == Visibility::Rays && solver.has_room();
    if rays {
        sights.gpu.closures = solver.link(&cells, &mut |_| ControlFlow::Continue(()))?;
        sights.gpu.rows = solver.rows(&cells)?;
    }
    for cell in cells {
        let own = cpu.row(cell)?;
        sights.cpu.closures.push(own.closure);
        sights.cpu.rows.push(own.links.to_vec());
        let doubt = match &transport.visibility {
            Visibility::Rays => {
                if !rays {
                    push(&mut sights.gpu, solver.probe(cell, &mut |_| ())?);
                }
                all.by_rays(cell, &sights)
            }
            Visibility::Drawn(drawing) => all.by_pixels(drawing, cell, cpu, solver, &mut sights)?,
        };
        sights.doubt.push(doubt);
        all.escape(cell, &sights);
        if progress().is_break() {
            return Err(Error::Interrupted);
        }
    }
    sights.pairs = all
        .tally
        .finish(mesh.cells.len() as u64 * mesh.texels.len() as u64);
    let factor = factor_roundings(transport.form_factor) + f64::from(mesh.samples);
    // Table 3 may clip a whole scene away: then no link sees alike, and the pairs tell.
    if sights.pairs.mismatched < sights.pairs.facing {
        sights.stages.push(all.links.stage(
            "links of GPU and CPU",
            factor,
            "ulp of links that see alike: form factors and disc weights, one addition per sample",
        ));
    }
    sights.stages.push(all.escapes.stage(
        "escape, all cells",
        2.0,
        "directions of 1024 counted differently: a ray through an edge",
    ));
    if all.pixels.values() > 0 {
        sights.stages.push(all.pixels.stage(
            "item buffer, all silhouettes",
            0.0,
            "a pixel on a boundary shows a different face from the one its ray meets, though no rounding decides it",
        ));
    }
    Ok(sights)
}

fn empty() -> Links {
    Links {
        rows: Vec::new(),
        closures: Vec::new(),
    }
}

fn push(links: &mut Links, row: gpu::probe::Row) {
    links.rows.push(row.links);
    links.closures.push(Closure {
        form_factor_sum: row.sum,
        escaped: row.escaped,
    });
}

struct All<'a> {
    mesh: &'a Mesh,
    transport: &'a Transport,
    tally: Tally,
    links: Errors,
    escapes: Errors,
    pixels: Errors,
}

impl All<'_> {
    /// The same rays: nothing explains a difference, and nothing is in doubt.
    fn by_rays(&mut self, cell: u32, sights: &Sights) -> Vec<f32> {
        let mesh = self.mesh;
        let (gpu, cpu) = (
            &sights.gpu.rows[cell as usize],
            &sights.cpu.rows[cell as usize],
        );
        let sizes = sizes(mesh, self.transport.form_factor, cell);
        let bound = factor_roundings(self.transport.form_factor) + f64::from(mesh.samples);
        for (k, texel) in mesh.texels.iter().enumerate() {
            let f = gpu[k].max(cpu[k]);
            if f <= FACING && !f.is_nan() {
                continue;
            }
            let weight = f64::from(f) * f64::from(texel.area);
            self.tally.facing(weight);
            let off = ulps(gpu[k], cpu[k], sizes[k]);
            self.links.add(off);
            if off.is_nan() || off > bound {
                self.tally.mismatch((cell, k as u32), weight, None);
            }
        }
        if gpu.is_empty() || self.links.values() == 0 {
            self.links.same(gpu.len() == cpu.len());
        }
        vec![0.0; mesh.texels.len()]
    }

    fn by_pixels(
        &mut self,
        drawing: &Drawing,
        cell: u32,
        cpu: &CpuSolver,
        solver: &mut GpuSolver,
        sights: &mut Sights,
    ) -> Result<Vec<f32>> {
        let mesh = self.mesh;
        let kind = self.transport.form_factor;
        let factors: Vec<f32> = (0..mesh.texels.len() as u32)
            .into_par_iter()
            .map(|k| factor(mesh, kind, cell, k))
            .collect();
        let mut pairs = CellPairs::new(factors);
        let size = drawing.size;
        let mut complete = true;
        let mut s = 0;
        let row = solver.probe(cell, &mut |left| {
            let buffer = ItemBuffer {
                size,
                ids: left.ids,
            };
            let whole = buffer.ids.len() == (size * size) as usize;
            complete &= whole && left.sums.len() == mesh.texels.len();
            if complete {
                let view = View::new(mesh, cell, s, drawing);
                self.pixels.merge(raster::some(mesh, &view, &buffer));
                let probe = Probe::new(mesh, drawing, cpu.rays(), (cell, s), &buffer);
                probe.count(&left.sums, &mut pairs, &mut self.tally);
            }
            s += 1;
        })?;
        if !complete || row.links.len() != mesh.texels.len() {
            return Err(Error::Device("the GPU's visibility is incomplete".into()));
        }
        let sizes = sizes(mesh, self.transport.form_factor, cell);
        let own = &sights.cpu.rows[cell as usize];
        for k in (0..own.len()).filter(|k| pairs.alike(*k)) {
            self.links.add(ulps(row.links[k], own[k], sizes[k]));
        }
        push(&mut sights.gpu, row);
        Ok(pairs.doubt(mesh.cells[cell as usize].open))
    }

    fn escape(&mut self, cell: u32, sights: &Sights) {
        let [a, b] = [&sights.gpu, &sights.cpu].map(|l| l.closures[cell as usize].escaped);
        self.escapes
            .add(f64::from((a - b).abs()) * DIRECTIONS as f64);
    }
}
