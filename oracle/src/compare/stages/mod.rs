//! Compares each WGSL stage with its Rust twin on the input that the GPU had at that stage, so that an error of
//! one stage does not reach the next check. Only rounding may differ.
//!
//! On an adapter without fused multiply-add all differences are 0. Elsewhere the bound of a stage is k roundings of
//! the terms that it adds, k counted from its operations.

mod buffer_ends;
mod links;
mod relit;
mod shots;

pub use links::factor_scales;
pub(super) use links::{MAX_WEIGHT_DIFFERENCE, decided_by_rounding};
pub use relit::{check_relit_stages, relit_mesh};

use super::item_buffer::pixel_tally;
use super::roundings::StageRoundings;
use super::statistics::{Elements, ErrorTally, ValueSource};
use crate::compare::checked_stages::CheckedStages;
use crate::compare::comparison::StageCheck;
use common::Result;
use common::constants::PATCH_SUM_LANES;
use common::mesh::{Mesh, Patch};
use common::passes::Exchange;
use common::rays::Rays;
use common::settings::Transport;
use common::shooting::{Shot, ShotOrder, select_shooter};
use gpu::GpuSolver;
use gpu::buffer_ends::MarkedBuffer;
use stage_check::tally::Value;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::ControlFlow;

/// Number of greedy shots that are checked, and of further shots by patches spread over the scene; one more is by a patch that is
/// partly covered.
const CHECKED_SHOTS: usize = 4;
/// Buffers that the stages of a shot write.
const SHOT_BUFFERS: [MarkedBuffer; 4] = [
    MarkedBuffer::Radiosity,
    MarkedBuffer::Residual,
    MarkedBuffer::Irradiance,
    MarkedBuffer::PatchPower,
];
/// Buffers that the stages of passes write.
const PASS_BUFFERS: [MarkedBuffer; 4] = [
    MarkedBuffer::Radiosity,
    MarkedBuffer::Residual,
    MarkedBuffer::Irradiance,
    MarkedBuffer::Flux,
];
/// Names of the values of a sample's frame.
const FRAME_VALUES: [&str; 5] = ["centre", "normal", "tangent", "bitangent", "sheet"];
/// Names of the values of a selection: workgroups of stages of the next shot.
const COUNTED_STAGES: [&str; 5] = [
    "workgroups of deposit",
    "workgroups of escape",
    "workgroups of power",
    "workgroups of link",
    "workgroups of received",
];
/// Reason of the bound of the number of vertices.
const DRAWN_FACES_REASON: &str = "vertices of the item buffer: of all faces, or none where links are kept";
/// Vertices of a side of a face in an item buffer: two triangles.
const VERTICES_PER_SIDE: u32 = 6;
/// Names of the visibility of a texel: by all pixels or rays, and by few pixels.
const SIGHT_VALUES: [&str; 2] = ["visibility", "visibility by few pixels"];
const VISIBILITY: usize = 0;
const SPARSE_VISIBILITY: usize = 1;
/// Names of the values of a texel: radiosity, residual, irradiance, and the link of the latest shot.
const TEXEL_VALUES: [&str; 10] = ["B.r", "B.g", "B.b", "r.r", "r.g", "r.b", "H.r", "H.g", "H.b", "H.w"];

/// Comparisons of each stage.
struct Tallies {
    aim: ErrorTally,
    item_buffer: ErrorTally,
    form_factor: ErrorTally,
    sight: ErrorTally,
    link: ErrorTally,
    escape: ErrorTally,
    received: ErrorTally,
    closure: ErrorTally,
    select: ErrorTally,
    workgroups: ErrorTally,
    drawn: ErrorTally,
    unshot: ErrorTally,
    deposit: ErrorTally,
    power: ErrorTally,
    exchange: ErrorTally,
    collect: ErrorTally,
    side_by_side: ErrorTally,
}

/// Inputs of all checks, and what they found.
struct StageChecker<'a> {
    mesh: &'a Mesh,
    transport: &'a Transport,
    rays: &'a Rays,
    tallies: &'a mut Tallies,
}

/// Checks all stages on a fresh `solver`.
///
/// Errors: the device fails.
pub async fn check_stages(
    mesh: &Mesh,
    transport: &Transport,
    rays: &Rays,
    solver: &mut GpuSolver<'_>,
) -> Result<CheckedStages> {
    let mut tallies = Tallies::new(mesh, transport);
    let mut checker = StageChecker {
        mesh,
        transport,
        rays,
        tallies: &mut tallies,
    };
    let ended = checker.check_shots(solver).await;
    let (checks, unreached) = tallies.stage_checks(mesh, transport, ended.is_ok());
    let mut checked = CheckedStages {
        checks,
        unreached,
        refusal: None,
    };
    ended.or_else(|error| checked.take_refusal(error))?;
    Ok(checked)
}

impl StageChecker<'_> {
    /// Checks the stages of some shots, and of passes by their shooters.
    ///
    /// Errors: the device fails; a stage leaves no result.
    async fn check_shots(&mut self, solver: &mut GpuSolver<'_>) -> Result<()> {
        let mesh = self.mesh;
        let mut rows = BTreeMap::new();
        let greedy = std::iter::repeat_n(None, CHECKED_SHOTS);
        let chosen = spread_patches(mesh).chain(partly_covered_patch(mesh));
        for (n, patch) in greedy.chain(chosen.map(Some)).enumerate() {
            let before = (solver.request_field().await?, solver.request_power().await?);
            buffer_ends::mark_ends(solver, &SHOT_BUFFERS);
            let script = patch.map(|patch| [patch]);
            let order = match &script {
                None => ShotOrder::Greedy { threshold: 0.0 },
                Some(script) => ShotOrder::Replay(script),
            };
            let mut done: Option<Shot> = None;
            let mut watch = |shot: &Shot| {
                done = Some(*shot);
                ControlFlow::Continue(())
            };
            solver.request_shots(order, 1, &mut watch).await?;
            let twin = patch.or_else(|| select_shooter(&before.1, 0.0));
            if twin.is_some() || done.is_some() {
                let values = [done.map(|shot| shot.patch), twin].map(|of| of.map_or(Value::Unwritten, Value::from));
                let wrong = f64::from(u8::from(values[0] != values[1]));
                (self.tallies.select).add(ValueSource::default(), [n, 0], values, wrong);
            }
            let is_known = |shot: &Shot| (shot.patch as usize) < mesh.patches.len();
            let Some(shot) = done.filter(is_known) else {
                continue;
            };
            let drawn_faces = if rows.contains_key(&shot.patch) {
                0
            } else {
                mesh.faces.len()
            };
            check_drawn_faces(
                &mut self.tallies.drawn,
                self.transport,
                (shot.patch, drawn_faces),
                solver,
            )
            .await?;
            let after = (solver.request_field().await?, solver.request_power().await?);
            if patch.is_none() {
                let counted = solver.request_counted_workgroups().await?;
                let has_links = |next| next == shot.patch || rows.contains_key(&next);
                self.add_workgroups(n, &counted, select_shooter(&after.1, 0.0).map(has_links));
            }
            // The links of a patch are made at its first shot and kept.
            if let Entry::Vacant(place) = rows.entry(shot.patch) {
                place.insert(self.check_links(shot.patch, solver).await?);
            }
            if shot.power.iter().any(|power| *power != 0.0) {
                self.check_shot(&shot, &rows[&shot.patch], [&before, &after]);
                buffer_ends::check_ends(solver, &SHOT_BUFFERS, self.tallies).await?;
            }
        }
        if solver.transfer_fits() {
            self.check_passes(&rows, solver).await?;
        }
        self.check_signed_power(solver).await?;
        self.check_scattered_links(solver).await
    }
}

/// Returns `CHECKED_SHOTS` patches at most, spread over the scene.
fn spread_patches(mesh: &Mesh) -> impl Iterator<Item = u32> {
    let count = mesh.patches.len();
    (0..CHECKED_SHOTS).map(move |k| ((2 * k + 1) * count / (2 * CHECKED_SHOTS)) as u32)
}

/// Returns the first patch on a part of which a body stands: its links are divided by the open share.
fn partly_covered_patch(mesh: &Mesh) -> Option<u32> {
    let is_partly_covered = |patch: &Patch| 0.0 < patch.open_share && patch.open_share < 1.0;
    mesh.patches.iter().position(is_partly_covered).map(|k| k as u32)
}

/// Checks the number of vertices of the latest item buffer of a patch, which shows so many faces; with visibility by rays
/// nothing is drawn.
///
/// Errors: the device fails.
async fn check_drawn_faces(
    tally: &mut ErrorTally,
    transport: &Transport,
    (patch, faces): (u32, usize),
    solver: &mut GpuSolver<'_>,
) -> Result<()> {
    let Some(drawing) = transport.visibility.item_buffer() else {
        return Ok(());
    };
    let twin = VERTICES_PER_SIDE * drawing.projection.plane_count() * faces as u32;
    let found = solver.request_drawn_vertices().await?;
    let wrong = f64::from(found.abs_diff(twin));
    tally.add(ValueSource::shot_by(patch), [patch as usize, 0], [found, twin], wrong);
    Ok(())
}

impl Tallies {
    /// Starts the tallies of all stages, each with its bound and the reason.
    fn new(mesh: &Mesh, transport: &Transport) -> Self {
        let bounds = StageRoundings::of(mesh, transport);
        let (in_patch, over_patches) = (bounds.patch_sum, bounds.sum_of_patches);
        let per_shot = (2 * CHECKED_SHOTS + 1) as f64 + 4.0;
        let projection = transport.visibility.item_buffer().map(|drawing| drawing.projection);
        let frame = "ulp of the frame at a sample's point: one cross product";
        let factor_reason = "ulp of F, or of F without its cosines, whose roundings are absolute";
        let sight = "samples of different visibility from the same points, though no rounding decides them";
        let link = "ulp of Σg, Σg·V and w on the same visibility: disc weights, one addition per sample";
        let escape = "directions that differ, beyond those through an edge";
        let received = "ulp of a patch's Σ w·A of the same links: additions in one lane + tree + products";
        let closure = "ulp of ΣF and of the scale, of the same sums: additions in one lane + tree + division";
        let select = "different shooters selected from the same powers";
        let workgroups = "workgroups of the next shot's stages: all where there is work, else none";
        let unshot = "ulp of Σ|r|A over the patches: additions in one lane + tree";
        let deposit = "ulp of B, r and H after a shot by the same links: 3 products and a sum";
        let power = "ulp of a patch's Σ r·A and Σ|r|·A of the same residual";
        let exchange = "ulp of the flux that a patch receives from all shots: a product and a sum per shot";
        let collect = "ulp of H, B and r after all shots by the same links: a product and a sum per shot";
        let side_by_side = "ulp of w beside other patches' and alone: disc weights, one addition per sample";
        let elements = |name, count, lanes| Elements { name, count, lanes };
        let texels = elements("texel", mesh.texels.len(), PATCH_SUM_LANES);
        let patches = elements("patch", mesh.patches.len(), 1);
        let of = ErrorTally::new;
        Self {
            aim: of("aim", (bounds.frame, frame), patches, &FRAME_VALUES),
            item_buffer: pixel_tally("item buffer", projection),
            form_factor: of("form factor", (bounds.form_factor, factor_reason), texels, &["F"]),
            sight: of(
                if projection.is_some() { "lookup" } else { "rays" },
                (0.0, sight),
                texels,
                &SIGHT_VALUES,
            ),
            link: of("link", (bounds.link, link), texels, &["Σg", "Σg·V", "w"]),
            escape: of("escape", (0.0, escape), patches, &["escaped share"]),
            received: of("received", (in_patch, received), patches, &["Σw·A"]),
            closure: of(
                "closure",
                (over_patches, closure),
                patches,
                &["ΣF", "scale", "ΣF of the shot"],
            ),
            select: of("select", (0.0, select), elements("shot", 0, 1), &["shooter"]),
            workgroups: of(
                "select: workgroups",
                (0.0, workgroups),
                elements("the shot after shot", 0, 1),
                &COUNTED_STAGES,
            ),
            drawn: of("view: drawn faces", (0.0, DRAWN_FACES_REASON), patches, &["vertices"]),
            unshot: of(
                "select: unshot",
                (over_patches, unshot),
                elements("the shot by patch", 0, 1),
                &["Σ|r|A"],
            ),
            deposit: of("deposit", (bounds.deposit, deposit), texels, &TEXEL_VALUES),
            power: of(
                "power",
                (in_patch, power),
                patches,
                &["Σr·A.r", "Σr·A.g", "Σr·A.b", "Σ|r|A"],
            ),
            exchange: of(
                "exchange",
                (per_shot, exchange),
                patches,
                &["flux.r", "flux.g", "flux.b"],
            ),
            collect: of("collect", (per_shot, collect), texels, &TEXEL_VALUES),
            side_by_side: of("links side by side", (bounds.link, side_by_side), texels, &["w"]),
        }
    }

    /// Returns the checks of all stages that ran, and the names of the others.
    fn stage_checks(
        &self,
        mesh: &Mesh,
        transport: &Transport,
        completed: bool,
    ) -> (Vec<StageCheck>, Vec<&'static str>) {
        let drawn = transport.visibility.item_buffer().is_some();
        let (shot, exchanged) = (self.deposit.values() > 0, self.exchange.values() > 0);
        let has_drawn = self.drawn.values() > 0;
        // Weights of other points hide the visibility: then the link is at fault.
        let seen = self.sight.values() > 0 || self.link.agrees();
        let chosen = self.select.values() > 0;
        let table = [
            (chosen, &self.select),
            (shot, &self.workgroups),
            (has_drawn, &self.drawn),
            (true, &self.aim),
            (drawn, &self.item_buffer),
            (true, &self.form_factor),
            (seen, &self.sight),
            (true, &self.link),
            (true, &self.escape),
            (true, &self.received),
            (true, &self.closure),
            (shot, &self.unshot),
            (shot, &self.deposit),
            (self.power.values() > 0, &self.power),
            (exchanged, &self.exchange),
            (exchanged, &self.collect),
            (exchanged, &self.side_by_side),
        ];
        let reached = |(ran, tally): &(bool, &ErrorTally)| *ran && (completed || tally.values() > 0);
        let (ran, others): (Vec<_>, Vec<_>) = table.into_iter().partition(reached);
        (
            ran.into_iter().map(|(_, tally)| tally.stage_check(mesh)).collect(),
            others.into_iter().map(|(_, tally)| tally.name).collect(),
        )
    }
}
