//! Item buffer against rays over all (shooter, texel) pairs.
//!
//! A mismatch is explained when the texel's projection lies within reach of a boundary in
//! the item buffer between the receiver's ID and the ID found there: 2 pixels (the texel's own
//! and the 3×3 lookup's), and where faces are tessellated their edges' sagitta, of which at most 1
//! counts.
//! A face or a gap that is thinner than a pixel there has no boundary in the buffer. Then the true
//! outline counts, within 2 pixels: where rays see the receiver its own or that of a face found
//! there, a blocker's where they do not; the mismatch is tallied as vanished as well.

use super::outline::outline;
use crate::comparison::Pairs;
use common::constants::HIDDEN;
use common::form_factor::form_factor;
use common::mesh::{Cell, Mesh};
use common::settings::{Raster, Settings, Visibility};
use common::shooting::Engine;
use common::{Error, Result};
use cpu::item_buffer::{ItemBuffer, View};
use cpu::projection::{pixels, project};
use cpu::rays::Rays;
use cpu::tessellate::{level, sagitta};
use glam::{Vec2, Vec4};
use gpu::GpuSolver;
use rayon::prelude::*;

/// Bins of half a pixel.
const BINS: usize = 8;
/// F below this is rounding: two solvers may disagree whether it is 0.
const FACING: f32 = 1e-7;
/// Texels per task.
const TASK: usize = 4096;
/// Unexplained pairs that are named.
const EXAMPLES: usize = 12;

/// Counts over all cells; `progress` is told after each.
pub fn pairs(
    mesh: &Mesh,
    settings: &Settings,
    rays: &Rays,
    solver: &mut GpuSolver,
    progress: &mut dyn FnMut(),
) -> Result<Pairs> {
    let mut tally = Tally::default();
    for k in 0..mesh.cells.len() {
        solver.shoot(k as u32)?;
        let seen = solver.irradiance()?;
        let buffer = if settings.visibility == Visibility::Rays {
            ItemBuffer {
                size: 1,
                ids: vec![0],
            }
        } else {
            ItemBuffer {
                size: settings.item_buffer,
                ids: solver.item_buffer()?,
            }
        };
        if seen.len() != mesh.texels.len()
            || buffer.ids.len() != (buffer.size * buffer.size) as usize
        {
            return Err(Error::Device("the GPU's visibility is incomplete".into()));
        }
        let probe = Probe::new(mesh, settings, rays, k as u32, &buffer, &seen);
        tally = tally.merge(probe.count(k as u32));
        progress();
    }
    Ok(tally.finish(mesh))
}

/// One cell's pairs.
struct Probe<'a> {
    mesh: &'a Mesh,
    settings: &'a Settings,
    rays: &'a Rays,
    cell: &'a Cell,
    buffer: &'a ItemBuffer,
    seen: &'a [Vec4],
    view: View,
    /// Explainable distance of each face's outline.
    reach: Vec<f32>,
}

/// How far from a boundary of `face` a lookup may go wrong, pixels.
fn reach(mesh: &Mesh, view: &View) -> Vec<f32> {
    let of = |face| {
        let level = level(view, face);
        if view.raster == Raster::Pixel || level == HIDDEN {
            0.0
        } else {
            sagitta(view, face, level).min(1.0)
        }
    };
    mesh.faces.iter().map(|face| 2.0 + of(face)).collect()
}

impl<'a> Probe<'a> {
    fn new(
        mesh: &'a Mesh,
        settings: &'a Settings,
        rays: &'a Rays,
        cell: u32,
        buffer: &'a ItemBuffer,
        seen: &'a [Vec4],
    ) -> Self {
        let view = View::new(mesh, cell, 0, settings);
        Self {
            mesh,
            settings,
            rays,
            cell: &mesh.cells[cell as usize],
            buffer,
            seen,
            view,
            reach: reach(mesh, &view),
        }
    }

    fn count(&self, cell: u32) -> Tally {
        // Fixed tasks merged in order: the same sums on any number of threads.
        let count = self.mesh.texels.len();
        let tasks: Vec<Tally> = (0..count.div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                let mut tally = Tally::default();
                for k in task * TASK..count.min((task + 1) * TASK) {
                    self.pair(cell, k, &mut tally);
                }
                tally
            })
            .collect();
        tasks.into_iter().fold(Tally::default(), Tally::merge)
    }

    fn pair(&self, cell: u32, k: usize, tally: &mut Tally) {
        let texel = &self.mesh.texels[k];
        let shooter = &self.cell.shooter;
        if texel.face == self.cell.face {
            return;
        }
        let normal = self.mesh.faces[texel.face as usize].normal;
        let f = form_factor(
            self.settings.form_factor,
            shooter,
            texel.position,
            normal,
            texel.area,
        );
        if f <= FACING {
            return;
        }
        let weight = f64::from(f) * f64::from(texel.area);
        let ends = [self.cell.face, texel.face];
        let by_rays = self.rays.visible(shooter.centre, texel.position, ends);
        let by_pixels = self.seen[k].w > 0.0;
        tally.facing += 1;
        tally.weight += weight;
        if self.settings.visibility == Visibility::Rays {
            // The same rays: nothing explains a difference.
            if by_rays != by_pixels {
                tally.mismatch(cell, k as u32, weight, None);
            }
            return;
        }
        let p = pixels(
            project(self.view.visibility, self.view.frame.local(texel.position)),
            self.buffer.size,
        );
        let found = self.id(p.x.floor() as i32, p.y.floor() as i32);
        let mine = texel.face + 1;
        if by_rays == by_pixels {
            let explainable = found != mine && self.boundary(p, mine, &[found]).is_some();
            tally.explainable += u64::from(explainable);
            return;
        }
        // Who is in the way: nobody but the receiver itself where rays see it.
        let blockers = self.rays.blockers(shooter.centre, texel.position, ends);
        let other: Vec<u32> = if found == mine {
            blockers.iter().map(|k| k + 1).collect()
        } else {
            vec![found]
        };
        let boundary = self.boundary(p, mine, &other);
        let thin = if by_rays {
            // What the pixels show hides their centres but not the texel: a gap ends in between.
            let nine = (0..9).map(|k| self.id(p.x as i32 + k % 3 - 1, p.y as i32 + k / 3 - 1));
            let shown = nine.filter_map(|id| id.checked_sub(1));
            shown.chain([texel.face]).collect()
        } else {
            blockers
        };
        let outline = boundary
            .is_none()
            .then(|| outline(self.mesh, &self.view, p, &thin))
            .flatten();
        tally.vanished += u64::from(outline.is_some());
        tally.mismatch(cell, k as u32, weight, boundary.or(outline));
    }

    fn id(&self, x: i32, y: i32) -> u32 {
        let last = self.buffer.size as i32 - 1;
        let (x, y) = (x.clamp(0, last), y.clamp(0, last));
        self.buffer.ids[(y * (last + 1) + x) as usize]
    }

    /// Distance from `p` to the nearest pixel edge between `mine` and one of `others`, if it is
    /// within reach.
    fn boundary(&self, p: Vec2, mine: u32, others: &[u32]) -> Option<f32> {
        let reach_of = |id: u32| {
            if id == 0 {
                2.0
            } else {
                self.reach[id as usize - 1]
            }
        };
        let reach = others
            .iter()
            .map(|id| reach_of(*id))
            .fold(reach_of(mine), f32::max);
        let window = reach.ceil() as i32 + 1;
        let (cx, cy) = (p.x.floor() as i32, p.y.floor() as i32);
        let mut nearest = f32::INFINITY;
        for y in cy - window..=cy + window {
            for x in cx - window..=cx + window {
                let a = self.id(x, y);
                for (dx, dy) in [(1, 0), (0, 1)] {
                    let b = self.id(x + dx, y + dy);
                    if (a == mine && others.contains(&b)) || (b == mine && others.contains(&a)) {
                        nearest = nearest.min(edge_distance(p, x, y, dx == 1));
                    }
                }
            }
        }
        (nearest <= reach).then_some(nearest)
    }
}

/// Distance from `p` to the edge between pixel (x, y) and its right or lower neighbour.
fn edge_distance(p: Vec2, x: i32, y: i32, right: bool) -> f32 {
    let a = Vec2::new(
        x as f32 + f32::from(u8::from(right)),
        y as f32 + f32::from(u8::from(!right)),
    );
    let b = Vec2::new(x as f32 + 1.0, y as f32 + 1.0);
    p.distance(p.clamp(a, b))
}

#[derive(Default)]
struct Tally {
    facing: u64,
    explainable: u64,
    mismatched: u64,
    explained: u64,
    vanished: u64,
    weight: f64,
    weight_mismatched: f64,
    histogram: [u64; BINS],
    examples: Vec<(u32, u32)>,
}

impl Tally {
    fn mismatch(&mut self, cell: u32, texel: u32, weight: f64, distance: Option<f32>) {
        self.mismatched += 1;
        self.weight_mismatched += weight;
        match distance {
            Some(distance) => {
                self.explained += 1;
                self.explainable += 1;
                self.histogram[((distance * 2.0) as usize).min(BINS - 1)] += 1;
            }
            None => self.examples.push((cell, texel)),
        }
    }

    fn merge(mut self, other: Self) -> Self {
        self.facing += other.facing;
        self.explainable += other.explainable;
        self.mismatched += other.mismatched;
        self.explained += other.explained;
        self.vanished += other.vanished;
        self.weight += other.weight;
        self.weight_mismatched += other.weight_mismatched;
        for (a, b) in self.histogram.iter_mut().zip(other.histogram) {
            *a += b;
        }
        self.examples.extend(other.examples);
        self.examples.sort_unstable();
        self.examples.truncate(EXAMPLES);
        self
    }

    fn finish(self, mesh: &Mesh) -> Pairs {
        Pairs {
            pairs: mesh.cells.len() as u64 * mesh.texels.len() as u64,
            facing: self.facing,
            mismatched: self.mismatched,
            explained: self.explained,
            vanished: self.vanished,
            unexplained: self.mismatched - self.explained,
            explainable: self.explainable,
            weighted_mismatch: if self.weight > 0.0 {
                self.weight_mismatched / self.weight
            } else {
                0.0
            },
            histogram: self.histogram.to_vec(),
            examples: self.examples,
        }
    }
}
