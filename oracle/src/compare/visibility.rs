//! Compares the visibility of all links: link by link for rays; for item buffers over all pairs of points of
//! (shooter, texel), sample by sample.
//!
//! A mismatch is explained if the texel's projection lies near a boundary in the item buffer between the
//! receiver's ID and the ID at that pixel: within 2 pixels (the texel's own pixel and the 3×3 lookup), plus the
//! sagitta of the edges (at most 1 pixel) for tessellated faces.
//! A face or a gap thinner than a pixel has no boundary in the buffer. Then a true outline within 2 pixels
//! explains the mismatch: that of the receiver or of a face in the buffer if rays see the receiver, else that of
//! a blocker. Such a mismatch also counts as vanished, and so does one whose rays are blocked within rounding of
//! an edge.

use super::comparison::{StageCheck, VisibilityStatistics};
use super::item_buffer::check_boundary_pixels;
use super::stages::{factor_scales, form_factor_roundings};
use super::statistics::{ErrorTally, PairTally, ulp_distance};
use common::constants::{HIDDEN_LEVEL, OUTLINE_MARGIN, TESSELLATION_LEVELS};
use common::escape::ESCAPE_DIRECTION_COUNT;
use common::intersect::intersect_face;
use common::mesh::Mesh;
use common::passes::{Exchange, PatchClosure};
use common::rays::{LineOfSight, Rays};
use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Raster, Transport, Visibility};
use common::{Error, Result};
use cpu::CpuSolver;
use cpu::shader_twins::edge_subdivision::subdivide_edge;
use cpu::shader_twins::item_buffer::ItemBuffer;
use cpu::shader_twins::link::{Sums, add_sample, texel_form_factor};
use cpu::shader_twins::lookup::is_visible;
use cpu::shader_twins::projection::{pixel_position, project_direction};
use cpu::shader_twins::tessellate::{edge_sagitta, tessellation_level};
use cpu::shader_twins::view::ShooterView;
use glam::{Vec2, Vec3, Vec4};
use gpu::GpuSolver;
use gpu::probe::ProbedRow;
use rayon::prelude::*;
use std::cell::Cell as Slot;
use std::ops::ControlFlow;

/// Smallest form factor that counts as positive: below it two solvers may disagree whether it is 0.
pub const MIN_FORM_FACTOR: f32 = 1e-7;
/// Texels per task.
const TEXELS_PER_TASK: usize = 4096;

/// Links of every patch with their sums.
#[derive(Default)]
pub struct LinkRows {
    /// Weight w of each texel, one row per patch.
    pub rows: Vec<Vec<f32>>,
    /// ΣF and the escaped share of each patch.
    pub closures: Vec<PatchClosure>,
}

impl LinkRows {
    fn push_row(&mut self, row: ProbedRow) {
        self.rows.push(row.links);
        self.closures.push(PatchClosure {
            form_factor_sum: row.sum,
            escaped: row.escaped,
        });
    }
}

/// Links of both sides and their differences.
#[derive(Default)]
pub struct VisibilityCheck {
    /// Visibility of the pairs of points.
    pub statistics: VisibilityStatistics,
    /// The GPU's links.
    pub gpu: LinkRows,
    /// The CPU's links.
    pub cpu: LinkRows,
    /// Change of each of the CPU's links if all its samples near silhouettes had the opposite visibility.
    pub link_bounds: Vec<Vec<f32>>,
    /// Checks of links with equal visibility, of escapes and of pixels at silhouettes.
    pub stages: Vec<StageCheck>,
}

/// Compares all links of CPU and GPU; calls `progress` after each patch, which may break.
///
/// Errors: the device fails, or `progress` breaks.
pub fn check_visibility(
    mesh: &Mesh,
    transport: &Transport,
    cpu: &mut CpuSolver,
    solver: &mut GpuSolver,
    progress: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<VisibilityCheck> {
    let mut checker = VisibilityChecker {
        mesh,
        transport,
        pairs: PairTally::default(),
        links: ErrorTally::default(),
        escapes: ErrorTally::default(),
        pixels: ErrorTally::default(),
    };
    let mut check = VisibilityCheck::default();
    let patches: Vec<u32> = (0..mesh.patches.len() as u32).collect();
    let rays = transport.visibility == Visibility::Rays && solver.has_room();
    if rays {
        check.gpu.closures = solver.make_links(&patches, &mut |_| ControlFlow::Continue(()))?;
        check.gpu.rows = solver.read_rows(&patches)?;
    }
    for patch in patches {
        let cpu_row = cpu.link_row(patch)?;
        check.cpu.closures.push(cpu_row.closure);
        check.cpu.rows.push(cpu_row.links.to_vec());
        let bounds = match &transport.visibility {
            Visibility::Rays => {
                if !rays {
                    check.gpu.push_row(solver.probe_links(patch, &mut |_| ())?);
                }
                checker.check_by_rays(patch, &check)
            }
            Visibility::ItemBuffer(settings) => checker.check_by_pixels(settings, patch, cpu, solver, &mut check)?,
        };
        check.link_bounds.push(bounds);
        checker.check_escape(patch, &check);
        if progress().is_break() {
            return Err(Error::Interrupted);
        }
    }
    check.statistics = checker
        .pairs
        .into_statistics(mesh.patches.len() as u64 * mesh.texels.len() as u64);
    let factor = form_factor_roundings(transport.form_factor) + f64::from(mesh.samples);
    // Table 3 may clip the whole scene: then no links have equal visibility, and only the pairs count.
    if check.statistics.mismatched < check.statistics.facing {
        check.stages.push(checker.links.stage_check(
            "links of GPU and CPU",
            factor,
            "ulp of links with equal visibility: form factors and disc weights, one addition per sample",
        ));
    }
    check.stages.push(checker.escapes.stage_check(
        "escape, all patches",
        2.0,
        "directions of 1024 counted differently: a ray through an edge",
    ));
    if checker.pixels.values() > 0 {
        check.stages.push(checker.pixels.stage_check(
            "item buffer, all silhouettes",
            0.0,
            "a pixel on a boundary shows a different face from the one its ray meets, though no rounding decides it",
        ));
    }
    Ok(check)
}

struct VisibilityChecker<'a> {
    mesh: &'a Mesh,
    transport: &'a Transport,
    pairs: PairTally,
    links: ErrorTally,
    escapes: ErrorTally,
    pixels: ErrorTally,
}

impl VisibilityChecker<'_> {
    /// Compares links by the same rays: every difference is unexplained, and no link is uncertain.
    fn check_by_rays(&mut self, patch: u32, check: &VisibilityCheck) -> Vec<f32> {
        let mesh = self.mesh;
        let (gpu, cpu) = (&check.gpu.rows[patch as usize], &check.cpu.rows[patch as usize]);
        let sizes = factor_scales(mesh, self.transport.form_factor, patch);
        let bound = form_factor_roundings(self.transport.form_factor) + f64::from(mesh.samples);
        for (k, texel) in mesh.texels.iter().enumerate() {
            let f = gpu[k].max(cpu[k]);
            if f <= MIN_FORM_FACTOR && !f.is_nan() {
                continue;
            }
            let weight = f64::from(f) * f64::from(texel.area);
            self.pairs.add_facing(weight);
            let off = ulp_distance(gpu[k], cpu[k], sizes[k]);
            self.links.add(off);
            if off.is_nan() || off > bound {
                self.pairs.add_mismatch((patch, k as u32), weight, None);
            }
        }
        if gpu.is_empty() || self.links.values() == 0 {
            self.links.add_equality(gpu.len() == cpu.len());
        }
        vec![0.0; mesh.texels.len()]
    }

    fn check_by_pixels(
        &mut self,
        settings: &ItemBufferSettings,
        patch: u32,
        cpu: &CpuSolver,
        solver: &mut GpuSolver,
        check: &mut VisibilityCheck,
    ) -> Result<Vec<f32>> {
        let mesh = self.mesh;
        let kind = self.transport.form_factor;
        let factors: Vec<f32> = (0..mesh.texels.len() as u32)
            .into_par_iter()
            .map(|k| texel_form_factor(mesh, kind, patch, k))
            .collect();
        let mut pairs = PatchPairs::new(factors);
        let size = settings.size;
        let mut complete = true;
        let mut s = 0;
        let row = solver.probe_links(patch, &mut |probed| {
            let buffer = ItemBuffer { size, ids: probed.ids };
            let whole = buffer.ids.len() == (size * size) as usize;
            complete &= whole && probed.sums.len() == mesh.texels.len();
            if complete {
                let view = ShooterView::new(mesh, patch, s, settings);
                self.pixels.merge(check_boundary_pixels(mesh, &view, &buffer));
                let sample = SampleCheck::new(mesh, settings, cpu.rays(), (patch, s), &buffer);
                sample.count_pairs(&probed.sums, &mut pairs, &mut self.pairs);
            }
            s += 1;
        })?;
        if !complete || row.links.len() != mesh.texels.len() {
            return Err(Error::Device("the GPU's visibility is incomplete".into()));
        }
        let sizes = factor_scales(mesh, self.transport.form_factor, patch);
        let cpu_row = &check.cpu.rows[patch as usize];
        for k in (0..cpu_row.len()).filter(|k| pairs.sees_alike(*k)) {
            self.links.add(ulp_distance(row.links[k], cpu_row[k], sizes[k]));
        }
        check.gpu.push_row(row);
        Ok(pairs.link_bounds(mesh.patches[patch as usize].open_share))
    }

    fn check_escape(&mut self, patch: u32, check: &VisibilityCheck) {
        let [a, b] = [&check.gpu, &check.cpu].map(|l| l.closures[patch as usize].escaped);
        self.escapes
            .add(f64::from((a - b).abs()) * ESCAPE_DIRECTION_COUNT as f64);
    }
}

/// Sums over the samples of one patch, per texel.
pub struct PatchPairs {
    /// Form factors F.
    factors: Vec<f32>,
    /// Σ g.
    total_weight: Vec<f32>,
    /// Σ g of the samples near a silhouette.
    doubtful_weight: Vec<f32>,
    /// True where rays and pixels disagree in any sample.
    differs: Vec<bool>,
    /// The GPU's Σ g·V after the last sample.
    seen_weight: Vec<f32>,
}

impl PatchPairs {
    /// Starts without samples.
    pub fn new(factors: Vec<f32>) -> Self {
        let zeros = vec![0.0; factors.len()];
        Self {
            total_weight: zeros.clone(),
            doubtful_weight: zeros.clone(),
            differs: vec![false; factors.len()],
            seen_weight: zeros,
            factors,
        }
    }

    /// True if texel `k` faces the patch, and rays and pixels agree in all samples.
    pub fn sees_alike(&self, k: usize) -> bool {
        self.factors[k] > MIN_FORM_FACTOR && !self.differs[k]
    }

    /// Returns the change of each link if all its samples near silhouettes had the opposite visibility.
    pub fn link_bounds(&self, open: f32) -> Vec<f32> {
        let of = |k: usize| {
            if self.doubtful_weight[k] > 0.0 {
                self.factors[k] * (self.doubtful_weight[k] / (self.total_weight[k] * open))
            } else {
                0.0
            }
        };
        (0..self.factors.len()).map(of).collect()
    }
}

/// Comparison of one sample of one patch.
pub struct SampleCheck<'a> {
    mesh: &'a Mesh,
    rays: &'a Rays,
    patch: u32,
    sample: u32,
    buffer: &'a ItemBuffer,
    view: ShooterView,
    lookup: Lookup,
    /// Distance from each face's outline that explains a mismatch, pixels.
    explained_distance: Vec<f32>,
}

/// Returns the distance from a boundary of each face within which a lookup may be wrong, pixels.
fn explained_distances(mesh: &Mesh, view: &ShooterView) -> Vec<f32> {
    let of = |face| {
        let level = tessellation_level(view, face);
        if view.projection.raster_method() == Raster::Pixel || level == HIDDEN_LEVEL {
            0.0
        } else {
            edge_sagitta(view, face, level).min(1.0)
        }
    };
    mesh.faces.iter().map(|face| 2.0 + of(face)).collect()
}

/// Result of one texel in one sample.
#[derive(Clone, Copy)]
struct PairResult {
    /// The sample's weight.
    weight: f32,
    explainable: bool,
    differs: bool,
}

impl<'a> SampleCheck<'a> {
    /// Creates the comparison of a sample with its item buffer.
    pub fn new(
        mesh: &'a Mesh,
        settings: &ItemBufferSettings,
        rays: &'a Rays,
        (patch, sample): (u32, u32),
        buffer: &'a ItemBuffer,
    ) -> Self {
        let view = ShooterView::new(mesh, patch, sample, settings);
        Self {
            mesh,
            rays,
            patch,
            sample,
            buffer,
            view,
            lookup: settings.lookup,
            explained_distance: explained_distances(mesh, &view),
        }
    }

    /// Compares all texels; `sums` are the GPU's sums after the sample.
    pub fn count_pairs(&self, sums: &[Vec4], pairs: &mut PatchPairs, tally: &mut PairTally) {
        // Fixed tasks, merged in order, give equal sums on any number of threads.
        let count = self.mesh.texels.len();
        let known = &*pairs;
        let tasks: Vec<(PairTally, Vec<Option<PairResult>>)> = (0..count.div_ceil(TEXELS_PER_TASK))
            .into_par_iter()
            .map(|task| {
                let mut tally = PairTally::default();
                let range = task * TEXELS_PER_TASK..count.min((task + 1) * TEXELS_PER_TASK);
                let results = range.map(|k| self.check_pair(k, sums[k], known, &mut tally));
                let results = results.collect();
                (tally, results)
            })
            .collect();
        let mut k = 0;
        for (part, results) in tasks {
            tally.merge(part);
            for result in results {
                if let Some(result) = result {
                    pairs.total_weight[k] += result.weight;
                    pairs.doubtful_weight[k] += if result.explainable { result.weight } else { 0.0 };
                    pairs.differs[k] |= result.differs;
                }
                pairs.seen_weight[k] = sums[k].y;
                k += 1;
            }
        }
    }

    /// Returns the two points of a pair and the sample's weight; none if the points do not face each other.
    fn sample_points(&self, k: usize, form_factor: f32) -> Option<(Vec3, Vec3, f32)> {
        let points = Slot::new(None);
        let mut sums = Sums {
            form_factor,
            ..Sums::default()
        };
        add_sample(self.mesh, self.patch, k as u32, self.sample, &mut sums, |q, p| {
            points.set(Some((q, p)));
            LineOfSight::Clear
        });
        let (q, p) = points.get()?;
        (sums.seen > 0.0).then_some((q, p, sums.all))
    }

    fn check_pair(&self, k: usize, sums: Vec4, known: &PatchPairs, tally: &mut PairTally) -> Option<PairResult> {
        let texel = &self.mesh.texels[k];
        let f = known.factors[k];
        if f <= MIN_FORM_FACTOR {
            return None;
        }
        let (q, position, g) = self.sample_points(k, f)?;
        let mut result = PairResult {
            weight: g,
            explainable: false,
            differs: false,
        };
        let before = known.seen_weight[k];
        if before + g == before {
            // The weight is too small to change the sum, which therefore does not show the visibility.
            return Some(result);
        }
        let weight = f64::from(f) * f64::from(texel.area);
        let ends = [self.mesh.patches[self.patch as usize].face, texel.face];
        let by_rays = self.rays.is_visible(q, position, ends);
        let by_pixels = sums.y > before;
        tally.add_facing(weight);
        let p = pixel_position(
            project_direction(self.view.projection, self.view.frame.to_local(position)),
            self.buffer.size,
        );
        let pixel_id = self.id_at(p.x.floor() as i32, p.y.floor() as i32);
        let receiver_id = texel.face + 1;
        if by_rays == by_pixels {
            result.explainable =
                pixel_id != receiver_id && self.boundary_distance(p, receiver_id, &[pixel_id]).is_some();
            if result.explainable {
                tally.add_explainable(weight);
            }
            return Some(result);
        }
        let (boundary, outline) = self.explain_mismatch(p, (q, position), ends, by_rays);
        let distance = boundary.or(outline);
        tally.add_mismatch((self.patch, k as u32), weight, distance);
        if outline.is_some() {
            tally.add_vanished();
        }
        result.explainable = distance.is_some();
        result.differs = true;
        Some(result)
    }

    /// Returns the distance to the nearest boundary, else to the nearest true outline.
    fn explain_mismatch(
        &self,
        p: Vec2,
        (q, position): (Vec3, Vec3),
        ends: [u32; 2],
        by_rays: bool,
    ) -> (Option<f32>, Option<f32>) {
        let pixel_id = self.id_at(p.x.floor() as i32, p.y.floor() as i32);
        let receiver_id = ends[1] + 1;
        // Blockers of the ray; empty if the rays see the receiver.
        let blockers = self.rays.find_blockers(q, position, ends);
        let other: Vec<u32> = if pixel_id == receiver_id {
            blockers.iter().map(|k| k + 1).collect()
        } else {
            vec![pixel_id]
        };
        let boundary = self.boundary_distance(p, receiver_id, &other);
        if boundary.is_none() && self.view.projection == ItemBufferProjection::Paper {
            return (self.explain_paper_projection(position, ends[1], by_rays), None);
        }
        if boundary.is_none() && self.blocked_by_edges_only((q, position), &blockers) {
            return (None, Some(0.0));
        }
        let thin = if by_rays {
            // The faces in the buffer cover pixel centres but not the texel: a gap ends in between.
            let nine = (0..9).map(|k| self.id_at(p.x as i32 + k % 3 - 1, p.y as i32 + k / 3 - 1));
            let shown = nine.filter_map(|id| id.checked_sub(1));
            shown.chain([ends[1]]).collect()
        } else {
            blockers
        };
        let outline = boundary
            .is_none()
            .then(|| outline_distance(self.mesh, &self.view, p, &thin))
            .flatten();
        (boundary, outline)
    }

    /// True if only edges block the ray, which rays widen by [`OUTLINE_MARGIN`]: the face of the sample has no outline
    /// in its own view.
    fn blocked_by_edges_only(&self, (q, position): (Vec3, Vec3), blockers: &[u32]) -> bool {
        let edge = |k: &u32| {
            let hit = intersect_face(&self.mesh.faces[*k as usize], q, position - q);
            hit.inside <= OUTLINE_MARGIN
        };
        !blockers.is_empty() && blockers.iter().all(edge)
    }

    /// Explains mismatches of Table 3 as printed, which clips at half a unit and projects corners only: they
    /// belong to the method wherever the CPU twin has the same error.
    fn explain_paper_projection(&self, position: Vec3, face: u32, by_rays: bool) -> Option<f32> {
        let twin = is_visible(self.mesh, self.buffer, &self.view, self.lookup, position, face);
        (twin != by_rays).then_some(f32::INFINITY)
    }

    fn id_at(&self, x: i32, y: i32) -> u32 {
        let last = self.buffer.size as i32 - 1;
        let (x, y) = (x.clamp(0, last), y.clamp(0, last));
        self.buffer.ids[(y * (last + 1) + x) as usize]
    }

    /// Returns the distance from `p` to the nearest pixel edge between `receiver_id` and one of `others`, if it explains a
    /// mismatch.
    fn boundary_distance(&self, p: Vec2, receiver_id: u32, others: &[u32]) -> Option<f32> {
        let reach_of = |id: u32| {
            if id == 0 {
                2.0
            } else {
                self.explained_distance[id as usize - 1]
            }
        };
        let reach = others
            .iter()
            .map(|id| reach_of(*id))
            .fold(reach_of(receiver_id), f32::max);
        let window = reach.ceil() as i32 + 1;
        let (cx, cy) = (p.x.floor() as i32, p.y.floor() as i32);
        let mut nearest = f32::INFINITY;
        for y in cy - window..=cy + window {
            for x in cx - window..=cx + window {
                let a = self.id_at(x, y);
                for (dx, dy) in [(1, 0), (0, 1)] {
                    let b = self.id_at(x + dx, y + dy);
                    if (a == receiver_id && others.contains(&b)) || (b == receiver_id && others.contains(&a)) {
                        nearest = nearest.min(edge_distance(p, x, y, dx == 1));
                    }
                }
            }
        }
        (nearest <= reach).then_some(nearest)
    }
}

/// Returns the distance from `p` to the edge between pixel (x, y) and its right or lower neighbour.
fn edge_distance(p: Vec2, x: i32, y: i32, right: bool) -> f32 {
    let a = Vec2::new(
        x as f32 + f32::from(u8::from(right)),
        y as f32 + f32::from(u8::from(!right)),
    );
    let b = Vec2::new(x as f32 + 1.0, y as f32 + 1.0);
    p.distance(p.clamp(a, b))
}

/// Returns the distance from `p` to the nearest true outline of `faces`, if it is within 2 pixels.
fn outline_distance(mesh: &Mesh, view: &ShooterView, p: Vec2, faces: &[u32]) -> Option<f32> {
    let parts = 1u32 << (TESSELLATION_LEVELS - 1);
    let mut nearest = f32::INFINITY;
    for face in faces {
        let corners = mesh.faces[*face as usize].corners.map(|c| c - view.frame.centre);
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let at = |i: u32| {
                let t = subdivide_edge(a, b, i as f32 / parts as f32);
                let v = view.frame.rotate_to_local(a * (1.0 - t) + b * t);
                pixel_position(project_direction(view.projection, v), view.size)
            };
            for i in 0..parts {
                let (start, end) = (at(i), at(i + 1));
                // A longer part connects different sides of the hemicube.
                if start.distance(end) < view.size as f32 / 16.0 {
                    nearest = nearest.min(segment_distance(p, start, end));
                }
            }
        }
    }
    (nearest <= 2.0).then_some(nearest)
}

fn segment_distance(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
    p.distance(a + along * t)
}
