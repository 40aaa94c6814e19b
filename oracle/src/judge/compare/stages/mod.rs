//! WGSL against its Rust twin, one check per stage, each on the input that the GPU itself had
//! there: an error of one stage does not reach the next check. Only rounding may differ.
//!
//! On an adapter without fused multiply-add all differences are 0; elsewhere each stage has a
//! bound of k roundings of the terms that it adds, k counted from its operations.

mod links;
mod passes;
mod shots;

pub use links::sizes;

use super::raster::PIXEL_SHARE;
use super::tally::Tally;
use crate::judge::comparison::Stage;
use common::Result;
use common::constants::{LANES, SELECT_LANES};
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::settings::{Raster, Transport, Visibility};
use common::shooting::Order;
use gpu::GpuSolver;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::ControlFlow;

/// Shots that are checked: the first of a greedy run, and as many cells spread over the scene.
const SHOTS: usize = 4;
/// Roundings of a disc form factor and a deposit: 3 dot products of 5, division, square root,
/// 8 products, each up to 3 ulp in WGSL's weaker divisions and roots.
const DISC_ROUNDINGS: f64 = 32.0;
/// The same for a polygon: 5 edges of a cross product, a root, an angle and a division.
const POLYGON_ROUNDINGS: f64 = 128.0;

/// What has been found about each stage.
#[derive(Default)]
struct Tallies {
    aim: Tally,
    item_buffer: Tally,
    form_factor: Tally,
    sight: Tally,
    link: Tally,
    escape: Tally,
    received: Tally,
    closure: Tally,
    select: Tally,
    unshot: Tally,
    deposit: Tally,
    power: Tally,
    exchange: Tally,
    collect: Tally,
}

/// Compares all stages on a fresh `solver`.
pub fn stages(
    mesh: &Mesh,
    transport: &Transport,
    rays: &Rays,
    solver: &mut GpuSolver,
) -> Result<Vec<Stage>> {
    let mut tallies = Tallies::default();
    let mut rows = BTreeMap::new();
    let bench = Bench {
        mesh,
        transport,
        rays,
    };
    let spread = (0..SHOTS).map(|k| ((2 * k + 1) * mesh.cells.len() / (2 * SHOTS)) as u32);
    let greedy = std::iter::repeat_n(None, SHOTS);
    for order in greedy.chain(spread.map(Some)) {
        let before = shots::State::of(solver)?;
        let Some(shot) = shots::shoot(solver, order)? else {
            continue;
        };
        if order.is_none() {
            shots::select(&before, &shot, &mut tallies);
        }
        if shot.cell as usize >= mesh.cells.len() {
            tallies.select.same(false);
            continue;
        }
        // A cell's links are made at its first shot and kept.
        if let Entry::Vacant(place) = rows.entry(shot.cell) {
            place.insert(links::check(&bench, shot.cell, solver, &mut tallies)?);
        }
        let after = shots::State::of(solver)?;
        bench.shot(&before, &shot, &rows[&shot.cell], &after, &mut tallies);
    }
    if rows.is_empty() {
        // Nothing shines: links there are all the same.
        for cell in 0..mesh.cells.len().min(SHOTS) as u32 {
            rows.insert(cell, links::check(&bench, cell, solver, &mut tallies)?);
        }
    }
    let exchanged = passes::check(&bench, &rows, solver, &mut tallies)?;
    Ok(tallies.stages(mesh, transport, exchanged))
}

/// What every check works with.
struct Bench<'a> {
    mesh: &'a Mesh,
    transport: &'a Transport,
    rays: &'a Rays,
}

impl Tallies {
    fn stages(&self, mesh: &Mesh, transport: &Transport, exchanged: bool) -> Vec<Stage> {
        let mut stages = self.seeing(mesh, transport);
        stages.extend(self.summing(mesh));
        if exchanged {
            stages.extend(self.passing());
        }
        stages
    }

    /// What looks from a cell.
    fn seeing(&self, mesh: &Mesh, transport: &Transport) -> Vec<Stage> {
        let samples = f64::from(mesh.samples);
        let factor = factor_roundings(transport.form_factor);
        let mut stages = vec![self.aim.stage(
            "aim",
            2.0,
            "ulp of the frame at a sample's point: one cross product",
        )];
        if let Some(drawing) = transport.visibility.drawing() {
            let (bound, reason) = match drawing.projection.raster() {
                Raster::Tessellated => (
                    PIXEL_SHARE,
                    "pixels that differ, over pixels on an ID boundary: vertices snap to 1/256 pixel",
                ),
                Raster::Pixel => (
                    0.0,
                    "a pixel shows a different face from the one its ray meets, though no edge is a rounding away",
                ),
            };
            stages.push(self.item_buffer.stage("item buffer", bound, reason));
        }
        stages.extend([
            self.form_factor.stage(
                "form factor",
                factor,
                "ulp of F and of F without its cosines, which a rounding of a cosine moves it by",
            ),
            self.sight.stage(
                match transport.visibility {
                    Visibility::Rays => "rays",
                    Visibility::Drawn(_) => "lookup",
                },
                0.0,
                "samples judged differently from the same points, though no rounding decides them",
            ),
            self.link.stage(
                "link",
                DISC_ROUNDINGS + samples,
                "ulp of Σg, Σg·V and w on the same visibility: disc weights, one addition a sample",
            ),
            self.escape.stage(
                "escape",
                0.0,
                "directions counted differently, beyond those that go through an edge",
            ),
        ]);
        stages
    }

    /// What adds, chooses and deposits.
    fn summing(&self, mesh: &Mesh) -> Vec<Stage> {
        let texels = mesh
            .cells
            .iter()
            .map(|c| c.count as usize)
            .max()
            .unwrap_or(0);
        let in_cell = (texels.div_ceil(LANES) + 6 + 4) as f64;
        let over_cells = (mesh.cells.len().div_ceil(SELECT_LANES) + 8 + 4) as f64;
        let mut stages = vec![
            self.received.stage("received", in_cell, "ulp of a cell's Σ w·A of the same links: additions in one lane + tree + products"),
            self.closure.stage("closure", over_cells, "ulp of ΣF and of the scale, of the same sums: additions in one lane + tree + division"),
        ];
        if self.deposit.values() > 0 {
            stages.extend([
                self.select.stage(
                    "select",
                    0.0,
                    "shooters chosen differently from the same powers",
                ),
                self.unshot.stage(
                    "select: unshot",
                    over_cells,
                    "ulp of Σ|r|A over the cells: additions in one lane + tree",
                ),
                self.deposit.stage(
                    "deposit",
                    DISC_ROUNDINGS,
                    "ulp of B, r and H after a shot by the same links: 3 products and a sum",
                ),
                self.power.stage(
                    "power",
                    in_cell,
                    "ulp of a cell's Σ r·A and Σ|r|·A of the same residual",
                ),
            ]);
        }
        stages
    }

    /// What passes over all cells at once need.
    fn passing(&self) -> [Stage; 2] {
        let terms = 2.0 * SHOTS as f64 + 4.0;
        [
            self.exchange.stage(
                "exchange",
                terms,
                "ulp of what a cell receives from all shots: a product and a sum per shot",
            ),
            self.collect.stage(
                "collect",
                terms,
                "ulp of H, B and r after all shots by the same links: a product and a sum per shot",
            ),
        ]
    }
}

/// Roundings of a form factor.
pub fn factor_roundings(kind: FormFactor) -> f64 {
    match kind {
        FormFactor::Polygon => POLYGON_ROUNDINGS,
        _ => DISC_ROUNDINGS,
    }
}

/// One shot of the solver's own choice, or of `cell`; none when nothing is left to shoot.
fn one(solver: &mut GpuSolver, cell: Option<u32>) -> Result<Option<common::shooting::Shot>> {
    use common::shooting::Shoot;
    let mut done = None;
    let script = cell.map(|cell| [cell]);
    let order = match &script {
        None => Order::Greedy { threshold: 0.0 },
        Some(script) => Order::Replay(script),
    };
    solver.run(order, 1, &mut |shot| {
        done = Some(*shot);
        ControlFlow::Continue(())
    })?;
    Ok(done)
}
