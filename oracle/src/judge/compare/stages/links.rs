//! The stages that make a cell's links: aim, item buffer, form factor, lookup or rays, link,
//! escape, received, closure.

use super::{Bench, DISC_ROUNDINGS, Tallies};
use crate::judge::compare::raster;
use crate::judge::compare::tally::{Tally, ulps};
use common::escape::{DIRECTIONS, directions};
use common::form_factor::FormFactor;
use common::mesh::{Cell, Mesh};
use common::passes::Closure;
use common::rays::Sight;
use common::settings::Lookup;
use common::{Error, Result};
use cpu::twin::closure::closure;
use cpu::twin::escape::escape;
use cpu::twin::frame::Frame;
use cpu::twin::item_buffer::ItemBuffer;
use cpu::twin::link::{Sums, factor, sample};
use cpu::twin::lookup::visible;
use cpu::twin::received::received;
use cpu::twin::view::{self, View};
use glam::{Vec3, Vec4};
use gpu::GpuSolver;
use gpu::probe::{Aim, Row, Sample};
use rayon::prelude::*;
use std::cell::Cell as Slot;
use std::f32::consts::PI;

/// Roundings by which another adapter's arithmetic may move the end of a ray, or its projection.
const MOVED: f32 = 32.0;

/// Weights so close are of the same points: others differ by a good part of themselves.
const SAME: f32 = 0.01;

/// Makes the links of `cell` on the GPU and checks each stage on what the one before it left.
pub fn check(
    bench: &Bench,
    cell: u32,
    solver: &mut GpuSolver,
    tallies: &mut Tallies,
) -> Result<Row> {
    let mesh = bench.mesh;
    let mut texels: Vec<Texel> = vec![Texel::default(); mesh.texels.len()];
    let mut complete = true;
    let mut s = 0;
    let row = solver.probe(cell, &mut |left| {
        complete &= left.sums.len() == texels.len();
        if complete {
            bench.sample(cell, s, &left, &mut texels, tallies);
        }
        s += 1;
    })?;
    if !complete || row.links.len() != texels.len() || row.taken.len() != mesh.cells.len() {
        return Err(Error::Device("the GPU's links are incomplete".into()));
    }
    let open = mesh.cells[cell as usize].open;
    for (texel, w) in texels.iter().zip(&row.links) {
        tallies.link.add(texel.link(open, *w));
    }
    bench.sums(cell, &row, tallies);
    Ok(row)
}

/// A texel over the samples: the GPU's sums, the twin's on the GPU's F and visibility, and the
/// largest terms that the twin's could have been rounded by.
#[derive(Clone, Copy, Default)]
struct Texel {
    gpu: Vec4,
    twin: Sums,
    size: f32,
}

impl Texel {
    /// How far the link `w` is off, in ulp.
    fn link(&self, open: f32, w: f32) -> f64 {
        let twin = self.twin.link(open);
        let spread = self.twin.form_factor * (self.size / (self.twin.all * open));
        let size = if spread.is_finite() { spread } else { twin };
        ulps(w, twin, size)
    }
}

/// An item buffer that the GPU drew, and how it is asked.
struct Drawn {
    view: View,
    buffer: ItemBuffer,
    lookup: Lookup,
}

impl Bench<'_> {
    fn sample(
        &self,
        cell: u32,
        s: u32,
        left: &Sample,
        texels: &mut [Texel],
        tallies: &mut Tallies,
    ) {
        tallies
            .aim
            .merge(aim(&left.aim, view::aim(self.mesh, cell, s)));
        let drawn = self.transport.visibility.drawing().map(|drawing| Drawn {
            view: as_aimed(View::new(self.mesh, cell, s, &drawing), &left.aim),
            buffer: ItemBuffer {
                size: drawing.size,
                ids: left.ids.clone(),
            },
            lookup: drawing.lookup,
        });
        if let Some(Drawn { view, buffer, .. }) = &drawn {
            // Whole buffers take their time: the first sample's and the last one's, if there are many.
            let whole = s == 0 || s + 1 == self.mesh.samples;
            let check = if whole { raster::whole } else { raster::some };
            tallies.item_buffer.merge(check(self.mesh, view, buffer));
        }
        let found: Vec<[Tally; 3]> = texels
            .par_iter_mut()
            .enumerate()
            .map(|(k, texel)| self.texel((cell, s, k as u32), drawn.as_ref(), left.sums[k], texel))
            .collect();
        for [form_factor, sight, link] in found {
            tallies.form_factor.merge(form_factor);
            tallies.sight.merge(sight);
            tallies.link.merge(link);
        }
    }

    /// Form factor, sight and sums of one texel after one sample.
    fn texel(
        &self,
        (cell, s, k): (u32, u32, u32),
        drawn: Option<&Drawn>,
        now: Vec4,
        texel: &mut Texel,
    ) -> [Tally; 3] {
        let mesh = self.mesh;
        let mut tallies = [Tally::default(); 3];
        if s == 0 {
            let twin = factor(mesh, self.transport.form_factor, cell, k);
            let size = transfer(
                self.transport.form_factor,
                &mesh.cells[cell as usize],
                mesh.texels[k as usize].position,
            );
            tallies[0].add(ulps(
                now.x,
                twin,
                if twin > 0.0 || now.x > 0.0 { size } else { 0.0 },
            ));
            texel.twin.form_factor = now.x;
        }
        let face = mesh.texels[k as usize].face;
        let seen = now.y > texel.gpu.y;
        let asked = Slot::new(None);
        let all = texel.twin.all;
        sample(mesh, cell, k, s, &mut texel.twin, |q, p| {
            asked.set(Some((q, p)));
            if seen { Sight::Clear } else { Sight::Blocked }
        });
        let g = texel.twin.all - all;
        if let Some((q, p)) = asked.get() {
            let part = mesh.cells[cell as usize].shooter.area / mesh.samples as f32;
            texel.size += part / (PI * q.distance_squared(p) + part) + g;
            let size = texel.size;
            let points = ulps(now.z, texel.twin.all, size);
            tallies[2].add(points);
            tallies[2].add(ulps(now.y, texel.twin.seen, size));
            // Of other points, or too weak to show in the sums, nothing can be said.
            let rounding = DISC_ROUNDINGS + f64::from(mesh.samples);
            let same = points <= rounding && (now.z - texel.gpu.z - g).abs() <= SAME * g;
            if same && texel.gpu.y + g > texel.gpu.y {
                let ask = |q, p| self.sees(cell, (q, p), drawn, face);
                tallies[1].same(ask(q, p) == seen || decided_by_rounding(&ask, q, p));
            }
        } else {
            tallies[2].add(ulps(now.z, texel.twin.all, texel.size));
            tallies[2].add(ulps(now.y, texel.twin.seen, texel.size));
        }
        texel.gpu = now;
        tallies
    }

    fn sees(&self, cell: u32, (q, p): (Vec3, Vec3), drawn: Option<&Drawn>, face: u32) -> bool {
        match drawn {
            Some(Drawn {
                view,
                buffer,
                lookup,
            }) => visible(self.mesh, buffer, view, *lookup, p, face),
            None => {
                let from = self.mesh.cells[cell as usize].face;
                self.rays.visible(q, p, [from, face])
            }
        }
    }

    /// Escape, received and closure, each on what the GPU had.
    fn sums(&self, cell: u32, row: &Row, tallies: &mut Tallies) {
        let mesh = self.mesh;
        let directions = directions();
        let twin = escape(mesh, self.rays, cell, &directions);
        let off = f64::from((twin - row.escaped).abs()) * DIRECTIONS as f64;
        let edge = if off > 0.0 {
            edges(self, cell, &directions)
        } else {
            0.0
        };
        tallies.escape.add(if off.is_nan() {
            off
        } else {
            (off - edge).max(0.0)
        });
        for (c, taken) in mesh.cells.iter().zip(&row.taken) {
            let twin = received(mesh, &row.links, c);
            tallies.received.add(ulps(*taken, twin, 0.0));
        }
        let sum = closure(&row.taken, mesh.cells[cell as usize].shooter.area);
        tallies.closure.add(ulps(row.sum, sum, 0.0));
        let closure = Closure {
            form_factor_sum: row.sum,
            escaped: row.escaped,
        };
        let scale = closure.scale(self.transport.conserve);
        tallies.closure.add(ulps(row.scale, scale, 0.0));
    }
}

/// Directions of which a rounding decides whether they meet a front.
fn edges(bench: &Bench, cell: u32, directions: &[Vec3]) -> f64 {
    let step = MOVED * f32::EPSILON;
    let of = |move_by: Vec3| {
        let moved: Vec<Vec3> = directions.iter().map(|d| *d + move_by * step).collect();
        escape(bench.mesh, bench.rays, cell, &moved)
    };
    let shares = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y].map(of);
    let most = shares.iter().fold(0.0f32, |a, b| a.max(*b));
    let least = shares.iter().fold(1.0f32, |a, b| a.min(*b));
    f64::from(most - least) * DIRECTIONS as f64
}

/// Whether ends that are moved by as much as rounding may move them are seen otherwise.
fn decided_by_rounding(ask: &impl Fn(Vec3, Vec3) -> bool, q: Vec3, p: Vec3) -> bool {
    let step = MOVED * f32::EPSILON * p.distance(q).max(1e-3);
    let here = ask(q, p);
    [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|axis| [axis * step, axis * -step])
        .any(|by| ask(q, p + by) != here || ask(q + by, p) != here)
}

/// The view that the GPU had: what follows is asked from there.
fn as_aimed(view: View, aim: &Aim) -> View {
    let frame = Frame {
        centre: aim.centre,
        tangent: aim.tangent,
        bitangent: aim.bitangent,
        normal: aim.normal,
    };
    View {
        frame,
        sheet: aim.sheet,
        ..view
    }
}

fn aim(aim: &Aim, (frame, sheet): (Frame, u32)) -> Tally {
    let pairs = [
        (aim.centre, frame.centre),
        (aim.normal, frame.normal),
        (aim.tangent, frame.tangent),
        (aim.bitangent, frame.bitangent),
    ];
    let axes = pairs
        .into_iter()
        .flat_map(|(a, b)| (0..3).map(move |k| ulps(a[k], b[k], 1.0)));
    let sheet = f64::from(aim.sheet.abs_diff(sheet)) * 1e9;
    axes.chain([sheet]).collect()
}

/// F without its cosines: a rounding of a cosine is absolute, so this is what it moves. Of a
/// polygon, the angle that its outline spans over 2π, as a circle of its radius would.
pub fn transfer(kind: FormFactor, cell: &Cell, position: Vec3) -> f32 {
    let (area, radius) = (cell.shooter.area, cell.shooter.radius);
    let distance = position.distance(cell.shooter.centre);
    match kind {
        FormFactor::Polygon => (4.0 * radius / (distance - radius).max(1e-30)).min(1.0),
        _ => area / (PI * distance * distance + area),
    }
}

/// The size of F that its rounding is measured by, for each texel.
pub fn sizes(mesh: &Mesh, kind: FormFactor, cell: u32) -> Vec<f32> {
    let cell = &mesh.cells[cell as usize];
    let of = |texel: &common::mesh::Texel| transfer(kind, cell, texel.position);
    mesh.texels.iter().map(of).collect()
}
