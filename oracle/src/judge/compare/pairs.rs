//! Item buffer against rays over all pairs of points of (shooter, texel).
//!
//! A mismatch is explained when the texel's projection lies within reach of a boundary in
//! the item buffer between the receiver's ID and the ID found there: 2 pixels (the texel's own
//! and the 3×3 lookup's), and where faces are tessellated their edges' sagitta, of which at most 1
//! counts.
//! A face or a gap that is thinner than a pixel there has no boundary in the buffer. Then the true
//! outline counts, within 2 pixels: where rays see the receiver its own or that of a face found
//! there, a blocker's where they do not; the mismatch is tallied as vanished as well. So it is where
//! rays were blocked within rounding of an edge.

use super::counts::Tally;
use super::outline::outline;
use common::constants::{HIDDEN, OUTLINE};
use common::intersect::intersect;
use common::mesh::Mesh;
use common::rays::{Rays, Sight};
use common::settings::{Drawing, Lookup, Projection, Raster};
use cpu::twin::item_buffer::ItemBuffer;
use cpu::twin::link::{Sums, sample};
use cpu::twin::lookup::visible;
use cpu::twin::projection::{pixels, project};
use cpu::twin::tessellate::{level, sagitta};
use cpu::twin::view::View;
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;
use std::cell::Cell as Slot;

/// F below this is rounding: two solvers may disagree whether it is 0.
pub const FACING: f32 = 1e-7;
/// Texels per task.
const TASK: usize = 4096;
/// What one cell's pairs have come to, over the samples so far.
pub struct CellPairs {
    /// F of each texel.
    factors: Vec<f32>,
    /// Σ g of each texel.
    all: Vec<f32>,
    /// Σ g of the samples within reach of a silhouette.
    doubtful: Vec<f32>,
    /// Whether rays and pixels disagreed on a sample.
    differs: Vec<bool>,
    /// Σ g·V as the GPU had it after the last sample.
    seen: Vec<f32>,
}

impl CellPairs {
    /// Nothing asked yet.
    pub fn new(factors: Vec<f32>) -> Self {
        let zeros = vec![0.0; factors.len()];
        Self {
            all: zeros.clone(),
            doubtful: zeros.clone(),
            differs: vec![false; factors.len()],
            seen: zeros,
            factors,
        }
    }

    /// Whether texel `k` faces the cell and is seen alike by rays and pixels, in all samples.
    pub fn alike(&self, k: usize) -> bool {
        self.factors[k] > FACING && !self.differs[k]
    }

    /// What each link would change by, were all samples near silhouettes judged the other way.
    pub fn doubt(&self, open: f32) -> Vec<f32> {
        let of = |k: usize| {
            if self.doubtful[k] > 0.0 {
                self.factors[k] * (self.doubtful[k] / (self.all[k] * open))
            } else {
                0.0
            }
        };
        (0..self.factors.len()).map(of).collect()
    }
}

/// One sample of one cell.
pub struct Probe<'a> {
    mesh: &'a Mesh,
    rays: &'a Rays,
    cell: u32,
    sample: u32,
    buffer: &'a ItemBuffer,
    view: View,
    lookup: Lookup,
    /// Explainable distance of each face's outline.
    reach: Vec<f32>,
}

/// How far from a boundary of `face` a lookup may go wrong, pixels.
fn reach(mesh: &Mesh, view: &View) -> Vec<f32> {
    let of = |face| {
        let level = level(view, face);
        if view.projection.raster() == Raster::Pixel || level == HIDDEN {
            0.0
        } else {
            sagitta(view, face, level).min(1.0)
        }
    };
    mesh.faces.iter().map(|face| 2.0 + of(face)).collect()
}

/// What is found out about one texel.
#[derive(Clone, Copy)]
struct Asked {
    /// The sample's weight.
    g: f32,
    explainable: bool,
    differs: bool,
}

impl<'a> Probe<'a> {
    /// The view of `buffer`.
    pub fn new(
        mesh: &'a Mesh,
        drawing: &Drawing,
        rays: &'a Rays,
        (cell, sample): (u32, u32),
        buffer: &'a ItemBuffer,
    ) -> Self {
        let view = View::new(mesh, cell, sample, drawing);
        Self {
            mesh,
            rays,
            cell,
            sample,
            buffer,
            view,
            lookup: drawing.lookup,
            reach: reach(mesh, &view),
        }
    }

    /// Judges the sample by what the GPU had after it.
    pub fn count(&self, sums: &[Vec4], pairs: &mut CellPairs, tally: &mut Tally) {
        // Fixed tasks merged in order: the same sums on any number of threads.
        let count = self.mesh.texels.len();
        let known = &*pairs;
        let tasks: Vec<(Tally, Vec<Option<Asked>>)> = (0..count.div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                let mut tally = Tally::default();
                let range = task * TASK..count.min((task + 1) * TASK);
                let asked = range.map(|k| self.pair(k, sums[k], known, &mut tally));
                let asked = asked.collect();
                (tally, asked)
            })
            .collect();
        let mut k = 0;
        for (part, asked) in tasks {
            tally.merge(part);
            for one in asked {
                if let Some(one) = one {
                    pairs.all[k] += one.g;
                    pairs.doubtful[k] += if one.explainable { one.g } else { 0.0 };
                    pairs.differs[k] |= one.differs;
                }
                pairs.seen[k] = sums[k].y;
                k += 1;
            }
        }
    }

    /// The two points of a pair and the sample's weight; none where no light could arrive.
    fn points(&self, k: usize, form_factor: f32) -> Option<(Vec3, Vec3, f32)> {
        let asked = Slot::new(None);
        let mut sums = Sums {
            form_factor,
            ..Sums::default()
        };
        sample(
            self.mesh,
            self.cell,
            k as u32,
            self.sample,
            &mut sums,
            |q, p| {
                asked.set(Some((q, p)));
                Sight::Clear
            },
        );
        let (q, p) = asked.get()?;
        (sums.seen > 0.0).then_some((q, p, sums.all))
    }

    fn pair(&self, k: usize, sums: Vec4, known: &CellPairs, tally: &mut Tally) -> Option<Asked> {
        let texel = &self.mesh.texels[k];
        let f = known.factors[k];
        if f <= FACING {
            return None;
        }
        let (q, position, g) = self.points(k, f)?;
        let mut asked = Asked {
            g,
            explainable: false,
            differs: false,
        };
        let before = known.seen[k];
        if before + g == before {
            // Too little to tell by the sum whether it was seen.
            return Some(asked);
        }
        let weight = f64::from(f) * f64::from(texel.area);
        let ends = [self.mesh.cells[self.cell as usize].face, texel.face];
        let by_rays = self.rays.visible(q, position, ends);
        let by_pixels = sums.y > before;
        tally.facing(weight);
        let p = pixels(
            project(self.view.projection, self.view.frame.to_local(position)),
            self.buffer.size,
        );
        let found = self.id(p.x.floor() as i32, p.y.floor() as i32);
        let mine = texel.face + 1;
        if by_rays == by_pixels {
            asked.explainable = found != mine && self.boundary(p, mine, &[found]).is_some();
            if asked.explainable {
                tally.explainable(weight);
            }
            return Some(asked);
        }
        let (boundary, outline) = self.explain(p, (q, position), ends, by_rays);
        let distance = boundary.or(outline);
        tally.mismatch((self.cell, k as u32), weight, distance);
        if outline.is_some() {
            tally.vanished();
        }
        asked.explainable = distance.is_some();
        asked.differs = true;
        Some(asked)
    }

    /// How far the nearest boundary is, else the nearest true outline.
    fn explain(
        &self,
        p: Vec2,
        (q, position): (Vec3, Vec3),
        ends: [u32; 2],
        by_rays: bool,
    ) -> (Option<f32>, Option<f32>) {
        let found = self.id(p.x.floor() as i32, p.y.floor() as i32);
        let mine = ends[1] + 1;
        // Who is in the way: nobody but the receiver itself where rays see it.
        let blockers = self.rays.blockers(q, position, ends);
        let other: Vec<u32> = if found == mine {
            blockers.iter().map(|k| k + 1).collect()
        } else {
            vec![found]
        };
        let boundary = self.boundary(p, mine, &other);
        if boundary.is_none() && self.view.projection == Projection::Paper {
            return (self.as_printed(position, ends[1], by_rays), None);
        }
        if boundary.is_none() && self.grazed((q, position), &blockers) {
            return (None, Some(0.0));
        }
        let thin = if by_rays {
            // What the pixels show hides their centres but not the texel: a gap ends in between.
            let nine = (0..9).map(|k| self.id(p.x as i32 + k % 3 - 1, p.y as i32 + k / 3 - 1));
            let shown = nine.filter_map(|id| id.checked_sub(1));
            shown.chain([ends[1]]).collect()
        } else {
            blockers
        };
        let outline = boundary
            .is_none()
            .then(|| outline(self.mesh, &self.view, p, &thin))
            .flatten();
        (boundary, outline)
    }

    /// Whether rays are blocked by edges alone, which they take to be wider than they are: those of a
    /// face on which a sample lies have no outline in its own view.
    fn grazed(&self, (q, position): (Vec3, Vec3), blockers: &[u32]) -> bool {
        let edge = |k: &u32| {
            let hit = intersect(&self.mesh.faces[*k as usize], q, position - q);
            hit.inside <= OUTLINE
        };
        !blockers.is_empty() && blockers.iter().all(edge)
    }

    /// Table 3 as printed clips at half a unit and draws corners only: that is the method's, and
    /// explained wherever its twin errs alike.
    fn as_printed(&self, position: Vec3, face: u32, by_rays: bool) -> Option<f32> {
        let twin = visible(
            self.mesh,
            self.buffer,
            &self.view,
            self.lookup,
            position,
            face,
        );
        (twin != by_rays).then_some(f32::INFINITY)
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
