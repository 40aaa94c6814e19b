//! Checks the stages that make a patch's links: aim, item buffer, form factor, lookup or rays, link, escape,
//! received, closure.

use super::{SPARSE_VISIBILITY, StageChecker, VISIBILITY, buffer_ends, spread_patches};
use crate::compare::item_buffer;
use crate::compare::roundings::{MAX_END_ROUNDINGS, StageRoundings};
use crate::compare::statistics::{ValuePlace, ValueSource};
use common::escape::{ESCAPE_DIRECTION_COUNT, escape_directions};
use common::form_factor::FormFactor;
use common::mesh::{Mesh, Patch};
use common::passes::PatchClosure;
use common::rays::{LineOfSight, Rays};
use common::sampling::pcg_hash;
use common::settings::{Lookup, Transport};
use common::{Error, Result};
use cpu::shader_twins::closure::sum_form_factors;
use cpu::shader_twins::escape::escaped_share;
use cpu::shader_twins::frame::Frame;
use cpu::shader_twins::item_buffer::ItemBuffer;
use cpu::shader_twins::link::{Sums, add_sample, texel_form_factor};
use cpu::shader_twins::lookup::is_visible;
use cpu::shader_twins::patch_transfer::patch_transfer;
use cpu::shader_twins::view::{self, ShooterView};
use glam::{Vec3, Vec4};
use gpu::GpuSolver;
use gpu::buffer_ends::MarkedBuffer;
use gpu::probe::{ProbedRow, ProbedSample, SampleView};
use rayon::prelude::*;
use stage_check::tally::ulp_distance;
use std::cell::Cell as Slot;
use std::f32::consts::PI;

/// Largest relative difference of two weights of the same points; weights of other points differ more.
pub const MAX_WEIGHT_DIFFERENCE: f32 = 0.01;

/// Item buffers to which the pixels of one are distributed: of the nine that a lookup reads, about one is in each.
const SPARSE_BUFFERS: u32 = 8;

/// Sums of a texel over the samples: the GPU's, the twin's on the GPU's F and visibility, and the size of the
/// twin's terms, to which rounding is relative.
#[derive(Clone, Copy, Default)]
struct TexelSums {
    gpu: Vec4,
    twin: Sums,
    size: f32,
}

impl TexelSums {
    /// Returns the twin's link, and the size of its terms.
    fn link_weight(&self, open: f32) -> (f32, f32) {
        let twin = self.twin.link_weight(open);
        let spread = self.twin.form_factor * (self.size / (self.twin.all * open));
        (twin, if spread.is_finite() { spread } else { twin })
    }
}

/// Values of a texel after a sample, the GPU's and the twin's; each number with the size of its terms.
struct TexelValues {
    /// F, of the first sample.
    form_factor: Option<([f32; 2], f32)>,
    /// Σ g and Σ g·V.
    sums: [([f32; 2], f32); 2],
    /// Visibility, and whether rounding decides it; none if they have different points.
    sight: Option<([bool; 2], bool)>,
}

/// An item buffer that the GPU drew, with its view and lookup.
pub(super) struct DrawnView {
    pub view: ShooterView,
    pub buffer: ItemBuffer,
    pub lookup: Lookup,
}

impl StageChecker<'_> {
    /// Makes the links of `patch` on the GPU and checks each stage on the output of the one before it.
    ///
    /// Errors: the device fails.
    pub async fn check_links(&mut self, patch: u32, solver: &mut GpuSolver<'_>) -> Result<ProbedRow> {
        self.check_sparse_lookups(patch, solver).await?;
        let mesh = self.mesh;
        let mut texels: Vec<TexelSums> = vec![TexelSums::default(); mesh.texels.len()];
        let mut complete = true;
        let mut s = 0;
        buffer_ends::mark_ends(solver, &[MarkedBuffer::Transfers]);
        let mut check = |probed: ProbedSample| {
            complete &= probed.sums.len() == texels.len();
            if complete {
                self.check_sample(patch, s, probed, &mut texels);
            }
            s += 1;
        };
        let row = solver.request_probed_links(patch, &mut check).await?;
        buffer_ends::check_ends(solver, &[MarkedBuffer::Transfers], self.tallies).await?;
        if !complete || row.links.len() != texels.len() || row.transfers.len() != mesh.patches.len() {
            return Err(Error::Device("the GPU's links are incomplete".into()));
        }
        let open = mesh.patches[patch as usize].open_share;
        for (k, (texel, w)) in texels.iter().zip(&row.links).enumerate() {
            let (twin, size) = texel.link_weight(open);
            (self.tallies.link).add_ulps(ValueSource::shot_by(patch), [k, 2], [*w, twin], size);
        }
        self.check_sums(patch, &row);
        Ok(row)
    }

    /// Checks links of some patches from points anywhere in and around the scene's box. From the points of a patch many faces are never in
    /// the way, and few images cross the horizon.
    ///
    /// Errors: the device fails.
    pub async fn check_scattered_links(&mut self, solver: &GpuSolver<'_>) -> Result<()> {
        let scattered = scatter_points(self.mesh);
        let mut solver = solver.request_for(&scattered).await?;
        let mut checker = StageChecker {
            mesh: &scattered,
            transport: self.transport,
            rays: self.rays,
            tallies: &mut *self.tallies,
        };
        for patch in spread_patches(&scattered) {
            checker.check_links(patch, &mut solver).await?;
        }
        Ok(())
    }

    /// Checks lookups in the item buffer of a patch's first sample, of which few pixels remain, each of them once: as drawn,
    /// those around a texel often show the same face, so that a wrong one does as well.
    async fn check_sparse_lookups(&mut self, patch: u32, solver: &mut GpuSolver<'_>) -> Result<()> {
        let (faces, seed) = (self.mesh.faces.len() as u32, pcg_hash(patch));
        let is_kept = |n, k: u32, id| id <= faces && pcg_hash(k ^ seed) % SPARSE_BUFFERS == n;
        let remove_others = |n, ids: &mut [u32]| {
            let others = ids.iter_mut().zip(0..).filter(|(id, k)| !is_kept(n, *k, **id));
            others.for_each(|(id, _)| *id = 0);
        };
        let source = ValueSource {
            shooter: Some(patch),
            sample: Some(0),
        };
        let mut check = |probed: ProbedSample| {
            let drawn = drawn_view(self.mesh, self.transport, (patch, 0), &probed.aim, probed.ids);
            let mut texels = vec![TexelSums::default(); self.mesh.texels.len()];
            let values = self.all_texel_values((patch, 0), drawn.as_ref(), &probed.sums, &mut texels);
            for (k, found) in values.into_iter().enumerate() {
                self.add_sight(source, [k, SPARSE_VISIBILITY], found.sight);
            }
        };
        solver
            .request_changed_buffers(patch, (SPARSE_BUFFERS, &remove_others), &mut check)
            .await
    }

    /// Returns the values of all texels after a sample, the GPU's and the twin's.
    fn all_texel_values(
        &self,
        (patch, s): (u32, u32),
        drawn: Option<&DrawnView>,
        gpu_sums: &[Vec4],
        texels: &mut [TexelSums],
    ) -> Vec<TexelValues> {
        let texels = texels.par_iter_mut().zip(gpu_sums).enumerate();
        let values = texels.map(|(k, (texel, sums))| self.texel_values((patch, s, k as u32), drawn, *sums, texel));
        values.collect()
    }

    fn check_sample(&mut self, patch: u32, s: u32, probed: ProbedSample, texels: &mut [TexelSums]) {
        let source = ValueSource {
            shooter: Some(patch),
            sample: Some(s),
        };
        let mesh = self.mesh;
        self.add_aim(source, &probed.aim, view::view_sample(mesh, patch, s));
        let mut drawn = drawn_view(mesh, self.transport, (patch, s), &probed.aim, probed.ids);
        if let Some(DrawnView { view, buffer, .. }) = &mut drawn {
            // Whole buffers are slow to check: only those of the first and the last sample.
            let whole = s == 0 || s + 1 == mesh.samples;
            let check = if whole {
                item_buffer::check_all_pixels
            } else {
                item_buffer::check_boundary_pixels
            };
            check(mesh, view, buffer, source, &mut self.tallies.item_buffer);
            item_buffer::remove_unknown_ids(mesh, buffer);
        }
        let values = self.all_texel_values((patch, s), drawn.as_ref(), &probed.sums, texels);
        for (k, found) in values.into_iter().enumerate() {
            self.add_sight(source, [k, VISIBILITY], found.sight);
            let tallies = &mut self.tallies;
            if let Some((values, size)) = found.form_factor {
                (tallies.form_factor).add_ulps(ValueSource::shot_by(patch), [k, 0], values, size);
            }
            for (n, (values, size)) in found.sums.into_iter().enumerate() {
                tallies.link.add_ulps(source, [k, n], values, size);
            }
        }
    }

    /// Adds the visibility of a sample, the GPU's and the twin's, and whether rounding decides it.
    fn add_sight(&mut self, source: ValueSource, place: ValuePlace, sight: Option<([bool; 2], bool)>) {
        if let Some((seen, undecided)) = sight {
            let wrong = seen[0] != seen[1] && !undecided;
            (self.tallies.sight).add(source, place, seen.map(u32::from), f64::from(u8::from(wrong)));
        }
    }

    /// Returns form factor, visibility and sums of one texel after one sample.
    fn texel_values(
        &self,
        (patch, s, k): (u32, u32, u32),
        drawn: Option<&DrawnView>,
        gpu_sums: Vec4,
        texel: &mut TexelSums,
    ) -> TexelValues {
        let mesh = self.mesh;
        let form_factor = (s == 0).then(|| {
            let twin = texel_form_factor(mesh, self.transport.form_factor, patch, k);
            let size = cosine_free_factor(
                self.transport.form_factor,
                &mesh.patches[patch as usize],
                mesh.texels[k as usize].position,
            );
            texel.twin.form_factor = gpu_sums.x;
            let any = twin > 0.0 || gpu_sums.x > 0.0;
            ([gpu_sums.x, twin], if any { size } else { 0.0 })
        });
        let face = mesh.texels[k as usize].face;
        let gpu_sees = gpu_sums.y > texel.gpu.y;
        let points = Slot::new(None);
        let all = texel.twin.all;
        add_sample(mesh, patch, k, s, &mut texel.twin, |q, p| {
            points.set(Some((q, p)));
            if gpu_sees {
                LineOfSight::Clear
            } else {
                LineOfSight::Blocked
            }
        });
        let g = texel.twin.all - all;
        if let Some((q, p)) = points.get() {
            let part = mesh.patches[patch as usize].shooter.area / mesh.samples as f32;
            texel.size += part / (PI * q.distance_squared(p) + part) + g;
        }
        let weights = [[gpu_sums.z, texel.twin.all], [gpu_sums.y, texel.twin.seen]];
        let weight_error = ulp_distance(gpu_sums.z, texel.twin.all, texel.size);
        // Visibility is checked only if both used the same points and the weight changes the sums.
        let rounding = StageRoundings::of(mesh, self.transport).link;
        let same_points = weight_error <= rounding && (gpu_sums.z - texel.gpu.z - g).abs() <= MAX_WEIGHT_DIFFERENCE * g;
        let same_points = same_points && texel.gpu.y + g > texel.gpu.y;
        let sight = points.get().filter(|_| same_points).map(|(q, p)| {
            let visible = |q, p| self.is_visible(patch, (q, p), drawn, face);
            let twin_sees = visible(q, p);
            (
                [gpu_sees, twin_sees],
                twin_sees != gpu_sees && decided_by_rounding(&visible, q, p),
            )
        });
        texel.gpu = gpu_sums;
        TexelValues {
            form_factor,
            sums: weights.map(|values| (values, texel.size)),
            sight,
        }
    }

    /// Compares the frame of a sample, and its sheet.
    fn add_aim(&mut self, source: ValueSource, aim: &SampleView, (frame, sheet): (Frame, u32)) {
        let pairs = [
            (aim.centre, frame.centre),
            (aim.normal, frame.normal),
            (aim.tangent, frame.tangent),
            (aim.bitangent, frame.bitangent),
        ];
        let tally = &mut self.tallies.aim;
        let patch = source.shooter.unwrap_or_default() as usize;
        for (n, (a, b)) in pairs.into_iter().enumerate() {
            for k in 0..3 {
                tally.add_ulps(source, [patch, n], [a[k], b[k]], 1.0);
            }
        }
        let error = f64::from(aim.sheet.abs_diff(sheet)) * 1e9;
        tally.add(source, [patch, 4], [aim.sheet, sheet], error);
    }

    fn is_visible(&self, patch: u32, (q, p): (Vec3, Vec3), drawn: Option<&DrawnView>, face: u32) -> bool {
        match drawn {
            Some(DrawnView { view, buffer, lookup }) => is_visible(self.mesh, buffer, view, *lookup, p, face),
            None => {
                let from = self.mesh.patches[patch as usize].face;
                self.rays.is_visible(q, p, [from, face])
            }
        }
    }

    /// Checks escape, received and closure, each on the GPU's input.
    fn check_sums(&mut self, patch: u32, row: &ProbedRow) {
        let (mesh, rays) = (self.mesh, self.rays);
        let directions = escape_directions();
        let twin = escaped_share(mesh, rays, patch, &directions);
        let difference = f64::from((twin - row.escaped).abs()) * ESCAPE_DIRECTION_COUNT as f64;
        let beyond_edges = match difference > 0.0 {
            true => (difference - undecided_directions(mesh, rays, patch, &directions)).max(0.0),
            // 0 or NaN.
            false => difference,
        };
        let tallies = &mut self.tallies;
        let (shooter, whole) = (patch as usize, ValueSource::default());
        (tallies.escape).add(whole, [shooter, 0], [row.escaped, twin], beyond_edges);
        for (c, (taker, taken)) in mesh.patches.iter().zip(&row.transfers).enumerate() {
            let twin = patch_transfer(mesh, &row.links, taker);
            (tallies.received).add_ulps(ValueSource::shot_by(patch), [c, 0], [*taken, twin], 0.0);
        }
        let sum = sum_form_factors(&row.transfers, mesh.patches[shooter].shooter.area);
        (tallies.closure).add_ulps(whole, [shooter, 0], [row.sum, sum], 0.0);
        let closure = PatchClosure {
            form_factor_sum: row.sum,
            escaped: row.escaped,
        };
        let scale = closure.link_scale(self.transport.conserve);
        (tallies.closure).add_ulps(whole, [shooter, 1], [row.scale, scale], 0.0);
    }
}

/// Returns the mesh with the points of its patches anywhere in a box half as large again as that of its faces: from outside,
/// each face is in the way of others.
fn scatter_points(mesh: &Mesh) -> Mesh {
    let corners = || mesh.faces.iter().flat_map(|face| face.corners);
    let low = corners().fold(Vec3::INFINITY, Vec3::min);
    let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
    let mut scattered = mesh.clone();
    for (k, point) in (0..).zip(&mut scattered.patch_points) {
        let share = |axis: u32| 1.5 * ((pcg_hash(3 * k + axis) >> 8) as f32 / (1 << 24) as f32) - 0.25;
        point.position = low + (high - low) * Vec3::new(share(0), share(1), share(2));
    }
    scattered
}

/// Returns the number of directions of which rounding decides whether they meet a front.
fn undecided_directions(mesh: &Mesh, rays: &Rays, patch: u32, directions: &[Vec3]) -> f64 {
    let step = MAX_END_ROUNDINGS * f32::EPSILON;
    let of = |move_by: Vec3| {
        let moved: Vec<Vec3> = directions.iter().map(|d| *d + move_by * step).collect();
        escaped_share(mesh, rays, patch, &moved)
    };
    let shares = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y].map(of);
    let largest = shares.iter().fold(0.0f32, |a, b| a.max(*b));
    let smallest = shares.iter().fold(1.0f32, |a, b| a.min(*b));
    f64::from(largest - smallest) * ESCAPE_DIRECTION_COUNT as f64
}

/// True if moving an end of the ray within rounding changes its visibility.
pub fn decided_by_rounding<T: PartialEq>(visible: &impl Fn(Vec3, Vec3) -> T, q: Vec3, p: Vec3) -> bool {
    let step = MAX_END_ROUNDINGS * f32::EPSILON * p.distance(q).max(1e-3);
    let unmoved = visible(q, p);
    [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|axis| [axis * step, axis * -step])
        .any(|by| visible(q, p + by) != unmoved || visible(q + by, p) != unmoved)
}

/// Returns an item buffer of the GPU with the view of sample `s` of a patch; none with visibility by rays.
pub(super) fn drawn_view(
    mesh: &Mesh,
    transport: &Transport,
    (patch, s): (u32, u32),
    aim: &SampleView,
    ids: Vec<u32>,
) -> Option<DrawnView> {
    transport.visibility.item_buffer().map(|drawing| DrawnView {
        view: with_gpu_frame(ShooterView::new(mesh, patch, s, &drawing), aim),
        buffer: ItemBuffer {
            size: drawing.size,
            ids,
        },
        lookup: drawing.lookup,
    })
}

/// Returns the view with the GPU's frame, for the checks that follow.
fn with_gpu_frame(view: ShooterView, aim: &SampleView) -> ShooterView {
    let frame = Frame {
        centre: aim.centre,
        tangent: aim.tangent,
        bitangent: aim.bitangent,
        normal: aim.normal,
    };
    ShooterView {
        frame,
        sheet: aim.sheet,
        ..view
    }
}

/// Returns F without its cosines, the scale of its rounding error (a rounding of a cosine is absolute). For a
/// polygon: the angle that its outline spans over 2π, as for a circle of its radius.
fn cosine_free_factor(kind: FormFactor, patch: &Patch, position: Vec3) -> f32 {
    let (area, radius) = (patch.shooter.area, patch.shooter.radius);
    let distance = position.distance(patch.shooter.centre);
    match kind {
        FormFactor::Polygon => (4.0 * radius / (distance - radius).max(1e-30)).min(1.0),
        _ => area / (PI * distance * distance + area),
    }
}

/// Returns the scale of the rounding error of F for each texel.
pub fn factor_scales(mesh: &Mesh, kind: FormFactor, patch: u32) -> Vec<f32> {
    let patch = &mesh.patches[patch as usize];
    let of = |texel: &common::mesh::Texel| cosine_free_factor(kind, patch, texel.position);
    mesh.texels.iter().map(of).collect()
}
