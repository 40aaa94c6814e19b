//! WGSL against its Rust twin, stage by stage on the same input: only rounding may differ.
//!
//! On an adapter without fused multiply-add all differences are 0; elsewhere each stage has a
//! bound of k roundings of the terms that it adds, k counted from its operations.

use crate::comparison::Stage;
use common::constants::{OUTLINE, SELECT_LANES};
use common::escape::{DIRECTIONS, directions};
use common::form_factor::FormFactor;
use common::mesh::{Cell, Mesh};
use common::settings::{Raster, Settings, Visibility};
use common::shooting::{Engine, Field, Order, Rule, Shot, select};
use common::{Error, Result};
use cpu::deposit::{Flash, deposit};
use cpu::escape::escape;
use cpu::item_buffer::{ItemBuffer, View};
use cpu::link::{Past, Sums, factor, sample};
use cpu::lookup::visible;
use cpu::power;
use cpu::rays::{self, Rays};
use glam::Vec3;
use gpu::GpuSolver;
use rayon::prelude::*;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::ControlFlow;

/// Shots that are checked.
const SHOTS: usize = 8;
/// Roundings of a disc form factor and a deposit: 3 dot products of 5, division, square root,
/// 8 products, each up to 3 ulp in WGSL's weaker divisions and roots.
const DISC_ROUNDINGS: f64 = 32.0;
/// The same for a polygon: 5 edges of a cross product, a root, an angle and a division.
const POLYGON_ROUNDINGS: f64 = 128.0;
/// Rasterisers may snap vertices to 1/256 pixel, and a vertex's rounding moves it by less: a
/// pixel centre lies that close to an edge for 2 of 256 pixels on a boundary. Doubled, because
/// each boundary pixel has edges on two sides.
const PIXEL_SHARE: f64 = 4.0 / 256.0;
/// Where rays are asked, only those within a rounding of an edge may be judged otherwise: a strip
/// as wide as both outlines' margins on a face a quarter of a unit away, on two sides, in radians.
const RAY_STRIP: f64 = 16.0 * OUTLINE as f64;

/// Compares all stages over the first shots of a greedy run on a fresh `solver`.
pub fn stages(
    mesh: &Mesh,
    settings: &Settings,
    rays: &Rays,
    solver: &mut GpuSolver,
) -> Result<Vec<Stage>> {
    let mut item_buffer = Tally::default();
    let mut deposits = Tally::default();
    let mut escapes = Tally::default();
    let mut powers = Tally::default();
    let mut received_sums = Tally::default();
    let mut choices = Tally::default();
    let mut boundary = 0u64;
    let directions = directions();
    let mut kept: HashMap<u32, Vec<f32>> = HashMap::new();
    for _ in 0..SHOTS {
        let before = solver.field()?;
        let power_before = solver.cell_power()?;
        let Some(shot) = greedy(solver)? else { break };
        choices.add(f64::from(u8::from(
            Some(shot.cell) != select(&power_before, 0.0),
        )));
        let shooter = mesh
            .cells
            .get(shot.cell as usize)
            .ok_or_else(|| Error::Device("the log names no cell".into()))?;
        let after = solver.field()?;
        // A cell's links are made at its first shot and kept: so are the twin's.
        if let Entry::Vacant(place) = kept.entry(shot.cell) {
            let sight = Sight::new(mesh, settings, rays, shot.cell, solver)?;
            if let Sight::ItemBuffer(view, buffer) = &sight {
                let twin = ItemBuffer::draw(mesh, view, mesh.room);
                boundary += boundary_pixels(&twin);
                for (a, b) in buffer.ids.iter().zip(&twin.ids) {
                    item_buffer.add(f64::from(u8::from(a != b)));
                }
            }
            place.insert(sight.links(mesh, settings, shot.cell));
        }
        let links = &kept[&shot.cell];
        deposits.extend(deposit_errors(
            mesh, settings, shot.cell, links, &before, &after,
        ));
        let share = escape(mesh, rays, shot.cell, &directions);
        escapes.add(f64::from((share - shot.escaped).abs()) * DIRECTIONS as f64);
        let sums: Vec<_> = mesh
            .cells
            .iter()
            .map(|cell| power::power(mesh, &after, cell))
            .collect();
        let cell_power = solver.cell_power()?;
        for (a, b) in cell_power.iter().zip(&sums) {
            powers.add(ulps(*a, b.w));
        }
        let area = shooter.shooter.area;
        let links: Vec<f32> = after.irradiance.iter().map(|h| h.w).collect();
        let taken: Vec<f32> = mesh
            .cells
            .iter()
            .map(|cell| power::received(mesh, &links, cell))
            .collect();
        received_sums.add(ulps(shot.form_factor_sum, power::closure(&taken, area)));
    }
    let texels_per_lane = mesh
        .cells
        .iter()
        .map(|c| c.count)
        .max()
        .unwrap_or(0)
        .div_ceil(64);
    let sum_roundings = f64::from(texels_per_lane) + 6.0 + 4.0;
    let all_roundings = sum_roundings + mesh.cells.len().div_ceil(SELECT_LANES) as f64 + 8.0;
    let deposit_roundings = match settings.form_factor {
        FormFactor::Polygon => POLYGON_ROUNDINGS,
        _ => DISC_ROUNDINGS,
    };
    let (bound, reason) = match settings.raster() {
        Raster::Tessellated => (
            PIXEL_SHARE,
            "pixels that differ, over pixels on an ID boundary: vertices snap to 1/256 pixel",
        ),
        Raster::Pixel => (
            RAY_STRIP * f64::from(settings.item_buffer) / 2.0,
            "pixels that differ, over pixels on an ID boundary: rays through an edge",
        ),
    };
    let mut raster = item_buffer.stage("item buffer", bound, reason);
    raster.max_ulp = item_buffer.differing as f64 / boundary.max(1) as f64;
    raster.pass = raster.values > 0 && raster.max_ulp <= raster.bound;
    // Rays draw nothing.
    let drawn = (settings.visibility != Visibility::Rays).then_some(raster);
    let mut stages: Vec<Stage> = drawn.into_iter().collect();
    stages.extend([
        deposits.stage("lookup, form factor, deposit", deposit_roundings, "roundings of B, r, H on the same item buffer, in ulp of the value and of the uncosined transfer"),
        escapes.stage("escape", 2.0, "directions of 1024 judged otherwise: a ray through an edge"),
        powers.stage("power", sum_roundings, "ulp of a cell's sum: additions in one lane + tree + products"),
        received_sums.stage("received", all_roundings, "ulp of ΣF: the same over all cells"),
        choices.stage("select", 0.0, "choices of the next shooter that differ on the same powers"),
    ]);
    Ok(stages)
}

/// What decides whether a texel sees the shooter.
enum Sight<'a> {
    Rays(&'a Rays),
    ItemBuffer(View, ItemBuffer),
}

impl<'a> Sight<'a> {
    /// The solver's own item buffer of its latest shot, or rays.
    fn new(
        mesh: &Mesh,
        settings: &Settings,
        rays: &'a Rays,
        cell: u32,
        solver: &mut GpuSolver,
    ) -> Result<Self> {
        if settings.visibility == Visibility::Rays {
            return Ok(Self::Rays(rays));
        }
        let size = settings.item_buffer;
        let view = View::new(mesh, cell, 0, settings);
        let ids = solver.item_buffer()?;
        Ok(Self::ItemBuffer(view, ItemBuffer { size, ids }))
    }

    /// The twin's links of `cell` to all texels.
    fn links(&self, mesh: &Mesh, settings: &Settings, cell: u32) -> Vec<f32> {
        let shooter = &mesh.cells[cell as usize];
        let of = |k: u32| {
            let face = mesh.texels[k as usize].face;
            let mut sums = Sums::default();
            let sight = |q, p| {
                if self.sees(mesh, settings, shooter.face, q, p, face) {
                    rays::Sight::Clear
                } else {
                    rays::Sight::Blocked
                }
            };
            sums.form_factor = factor(mesh, settings.form_factor, cell, k);
            sample(mesh, cell, k, 0, &mut sums, sight);
            sums.link(shooter.open)
        };
        (0..mesh.texels.len() as u32)
            .into_par_iter()
            .map(of)
            .collect()
    }

    fn sees(
        &self,
        mesh: &Mesh,
        settings: &Settings,
        from: u32,
        q: Vec3,
        p: Vec3,
        face: u32,
    ) -> bool {
        match self {
            Self::Rays(rays) => rays.visible(q, p, [from, face]),
            Self::ItemBuffer(view, buffer) => visible(mesh, buffer, view, settings.lookup, p, face),
        }
    }
}

/// One shot of the solver's own choice; none when nothing is left to shoot.
fn greedy(solver: &mut GpuSolver) -> Result<Option<Shot>> {
    let mut chosen = None;
    solver.run(Order::Greedy { threshold: 0.0 }, 1, &mut |shot| {
        chosen = Some(*shot);
        ControlFlow::Continue(())
    })?;
    Ok(chosen)
}

/// What the twin makes of the state `before`, given the twin's links, against `after`.
fn deposit_errors(
    mesh: &Mesh,
    settings: &Settings,
    number: u32,
    links: &[f32],
    before: &Field,
    after: &Field,
) -> Tally {
    let cell = &mesh.cells[number as usize];
    let flux = power::power(mesh, before, cell).truncate();
    let reflectance: Vec<Vec3> = mesh.texels.iter().map(|t| t.reflectance).collect();
    let flash = Flash {
        mesh,
        cell,
        radiosity: flux / cell.shooter.area,
        scale: 1.0,
        rule: Rule::PLAIN,
        reflectance: &reflectance,
    };
    let errors: Vec<f64> = (0..mesh.texels.len())
        .into_par_iter()
        .flat_map_iter(|k| {
            let (mut b, mut r, mut h) = (
                before.radiosity[k],
                before.residual[k],
                before.irradiance[k],
            );
            let past = Past::default();
            deposit(&flash, k as u32, links[k], past, (&mut b, &mut r, &mut h));
            let transfer = transfer(settings.form_factor, cell, mesh.texels[k].position);
            let scale = flash.radiosity.abs().max_element() * transfer;
            [
                (b, after.radiosity[k]),
                (r, after.residual[k]),
                (h, after.irradiance[k]),
            ]
            .map(|(x, y)| {
                let error = f64::from((x - y).truncate().abs().max_element());
                let size = f64::from(x.truncate().abs().max_element() + scale);
                if error == 0.0 {
                    0.0
                } else {
                    error / (size * f64::from(f32::EPSILON))
                }
            })
        })
        .collect();
    let mut tally = Tally::default();
    for error in errors {
        tally.add(error);
    }
    tally
}

/// F without its cosines: a rounding of a cosine is absolute, so this is what it moves.
fn transfer(kind: FormFactor, cell: &Cell, position: Vec3) -> f32 {
    let area = cell.shooter.area;
    match kind {
        FormFactor::Polygon => 1.0,
        _ => area / (std::f32::consts::PI * position.distance_squared(cell.shooter.centre) + area),
    }
}

/// Pixels whose right or lower neighbour has another ID.
fn boundary_pixels(buffer: &ItemBuffer) -> u64 {
    let n = buffer.size as usize;
    let ids = &buffer.ids;
    (0..n * n)
        .filter(|k| {
            (k % n + 1 < n && ids[*k] != ids[k + 1]) || (k + n < n * n && ids[*k] != ids[k + n])
        })
        .count() as u64
}

fn ulps(a: f32, b: f32) -> f64 {
    let size = f64::from(a.abs().max(b.abs())) * f64::from(f32::EPSILON);
    if a == b {
        0.0
    } else {
        (f64::from(a) - f64::from(b)).abs() / size
    }
}

#[derive(Default)]
struct Tally {
    values: u64,
    differing: u64,
    max: f64,
}

impl Tally {
    fn add(&mut self, error: f64) {
        self.values += 1;
        self.differing += u64::from(error != 0.0);
        // A NaN must stay: f64::max would drop it.
        self.max = if error > self.max || error.is_nan() {
            error
        } else {
            self.max
        };
    }

    fn extend(&mut self, other: Self) {
        self.values += other.values;
        self.differing += other.differing;
        self.max = if other.max > self.max || other.max.is_nan() {
            other.max
        } else {
            self.max
        };
    }

    fn stage(&self, name: &str, bound: f64, reason: &str) -> Stage {
        Stage {
            name: name.to_owned(),
            values: self.values,
            differing: self.differing,
            max_ulp: self.max,
            bound,
            reason: reason.to_owned(),
            pass: self.values > 0 && self.max <= bound,
        }
    }
}
