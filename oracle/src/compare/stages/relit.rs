//! Checks the stages of a relight on a mesh whose last faces are objects: item buffers with and without them, links beside
//! those without the objects, and their deposit by each rule.

use super::links::{decided_by_rounding, drawn_view};
use super::{DRAWN_FACES_REASON, TEXEL_VALUES, check_drawn_faces};
use crate::compare::comparison::StageCheck;
use crate::compare::item_buffer::{self, pixel_tally};
use crate::compare::roundings::DISC_ROUNDINGS;
use crate::compare::statistics::{Elements, ErrorTally, ValueSource};
use common::constants::{PATCH_SUM_LANES, PI};
use common::cover::furnished_mesh;
use common::mesh::Mesh;
use common::rays::{LineOfSight, Rays};
use common::sampling::pcg_hash;
use common::scene::Scene;
use common::settings::Transport;
use common::shooting::{DepositRule, RadiosityField, Restart, SubtractedLink};
use common::{Error, Result};
use cpu::shader_twins::deposit::deposit;
use cpu::shader_twins::link::{Baseline, Sums, add_sample};
use cpu::shader_twins::lookup::SampleItemBuffers;
use cpu::shader_twins::select::load_shot;
use glam::{Vec3, Vec4};
use gpu::GpuSolver;
use gpu::probe::{ProbedRow, ProbedSample};
use rayon::prelude::*;
use stage_check::tally::ulp_distance;
use std::cell::Cell as Slot;

/// Most texels per side of a face: enough for more than one workgroup in scenes of a few faces.
const MAX_TEXELS: u32 = 4;
/// Sample points per patch: the sums of the first are read, and with several a body may cover one.
const SAMPLES_PER_PATCH: u32 = 2;

/// Most shooters of the room, and most of the objects.
const MAX_SHOOTERS: usize = 2;

/// Rules by which texels receive a shot, each with whether an object shoots. One patch shoots by several rules in turn, so
/// that links kept by the rule before are noticed.
const RULES_AND_SHOOTERS: [(DepositRule, bool); 11] = {
    const fn rule(captured: bool, subtracted: SubtractedLink, reshoot: bool) -> DepositRule {
        DepositRule {
            captured,
            subtracted,
            reshoot,
        }
    }
    [
        (rule(true, SubtractedLink::Nothing, false), false),
        (rule(true, SubtractedLink::Before, false), false),
        (rule(true, SubtractedLink::Unhidden, false), false),
        (rule(true, SubtractedLink::All, false), false),
        (rule(false, SubtractedLink::Nothing, false), false),
        (rule(false, SubtractedLink::Before, false), false),
        (rule(false, SubtractedLink::Before, false), true),
        (rule(false, SubtractedLink::Unhidden, true), true),
        (rule(false, SubtractedLink::All, false), true),
        (rule(true, SubtractedLink::Unhidden, false), true),
        (rule(false, SubtractedLink::Nothing, false), true),
    ]
};

/// Names of the values of a link: after a sample, and at the end.
const LINK_VALUES: [&str; 6] = [
    "Σg·V",
    "Σg",
    "Σg·V without objects",
    "w",
    "subtracted",
    "w without objects",
];

/// Inputs of the checks, and what they found.
struct RelitChecker<'a> {
    mesh: &'a Mesh,
    /// The mesh with all faces in its room, and its room alone.
    drawn: [Mesh; 2],
    transport: &'a Transport,
    rays: Rays,
    drawn_faces: ErrorTally,
    item_buffer: ErrorTally,
    sight: ErrorTally,
    link: ErrorTally,
    deposit: ErrorTally,
}

/// A texel during the samples of a patch: the twin's sums on the GPU's visibility, and the size of their terms.
#[derive(Clone, Copy, Default)]
struct TexelState {
    sums: Sums,
    size: f32,
}

/// Values of a texel after a sample.
struct TexelSample {
    state: TexelState,
    /// The GPU's and the twin's.
    values: [[f32; 2]; 3],
    size: f32,
    /// Visibility, the GPU's and the twin's, and whether rounding decides it.
    sight: Option<([LineOfSight; 2], bool)>,
}

/// Makes a coarse mesh of a scene of whose faces the last five eighths are objects, so that some of them stand between faces of
/// the room; none of a scene with a single face.
///
/// Errors: as of [`furnished_mesh`].
pub fn relit_mesh(scene: &Scene, texels: u32) -> Result<Option<Mesh>> {
    let faces = scene.faces.len();
    if faces < 2 {
        return Ok(None);
    }
    let resolutions = vec![[texels.min(MAX_TEXELS); 2]; faces];
    furnished_mesh(
        scene,
        (3 * faces / 8).max(1),
        &resolutions,
        [1, SAMPLES_PER_PATCH],
        &|| false,
    )
    .map(Some)
}

/// Checks the stages of a relight on a `solver` of a mesh with objects.
///
/// Errors: the device fails.
pub async fn check_relit_stages(
    mesh: &Mesh,
    transport: &Transport,
    solver: &mut GpuSolver<'_>,
) -> Result<Vec<StageCheck>> {
    let mut checker = RelitChecker::new(mesh, transport);
    for object in [false, true] {
        let patches = (0..).zip(&mesh.patches);
        let own = patches.filter(|(_, patch)| mesh.is_object(patch.face) == object && patch.shooter.area > 0.0);
        let own: Vec<u32> = own.map(|(patch, _)| patch).collect();
        for patch in own.iter().take(MAX_SHOOTERS) {
            for (n, (rule, _)) in RULES_AND_SHOOTERS.iter().filter(|case| case.1 == object).enumerate() {
                checker.check_shot((*patch, *rule), n == 0 && !object, solver).await?;
            }
        }
    }
    let tallies = [
        &checker.drawn_faces,
        &checker.item_buffer,
        &checker.sight,
        &checker.link,
        &checker.deposit,
    ];
    let ran = tallies.into_iter().filter(|tally| tally.values() > 0);
    Ok(ran.map(|tally| tally.stage_check(mesh)).collect())
}

impl<'a> RelitChecker<'a> {
    fn new(mesh: &'a Mesh, transport: &'a Transport) -> Self {
        let (whole, mut room) = (mesh.clone(), mesh.clone());
        room.faces.truncate(mesh.room_faces as usize);
        let faces = mesh.faces.len() as u32;
        let texels = Elements {
            name: "texel",
            count: mesh.texels.len(),
            lanes: PATCH_SUM_LANES,
        };
        let projection = transport.visibility.item_buffer().map(|drawing| drawing.projection);
        let sight = "samples of different visibility among objects, though no rounding decides them";
        let link = "ulp of the sums and links, and of those without the objects: disc weights, one addition per sample";
        let deposit = "ulp of the terms of B, r and H after a shot by a rule of relighting: 3 products and two sums";
        Self {
            mesh,
            drawn: [
                Mesh {
                    room_faces: faces,
                    ..whole
                },
                room,
            ],
            transport,
            rays: Rays::new(mesh),
            drawn_faces: ErrorTally::new(
                "view: drawn faces, relit",
                (0.0, DRAWN_FACES_REASON),
                Elements {
                    name: "patch",
                    count: mesh.patches.len(),
                    lanes: 1,
                },
                &["vertices"],
            ),
            item_buffer: pixel_tally("item buffer, relit", projection),
            sight: ErrorTally::new(
                if projection.is_some() {
                    "lookup, relit"
                } else {
                    "rays, relit"
                },
                (0.0, sight),
                texels,
                &["visibility"],
            ),
            link: ErrorTally::new(
                "link, relit",
                (DISC_ROUNDINGS + f64::from(SAMPLES_PER_PATCH), link),
                texels,
                &LINK_VALUES,
            ),
            deposit: ErrorTally::new("deposit, relit", (DISC_ROUNDINGS, deposit), texels, &TEXEL_VALUES),
        }
    }

    /// Checks the links of a patch by a rule, and the deposit of a shot on them; item buffers if they are `drawn`.
    async fn check_shot(
        &mut self,
        (patch, rule): (u32, DepositRule),
        drawn: bool,
        solver: &mut GpuSolver<'_>,
    ) -> Result<()> {
        let mesh = self.mesh;
        let field = varied_field(mesh);
        let lighten = |reflectance: Vec3| reflectance * 0.5 + 0.25;
        let reflectance: Vec<Vec3> = mesh.texels.iter().map(|texel| lighten(texel.reflectance)).collect();
        solver.restart_from(rule, &reflectance, &field)?;
        let mut samples = Vec::new();
        let row = solver
            .request_probed_links(patch, &mut |probed| samples.push(probed))
            .await?;
        let complete = samples.iter().all(|probed| probed.sums.len() == mesh.texels.len());
        let Some(last) = samples
            .last()
            .filter(|_| complete && row.links.len() == mesh.texels.len())
        else {
            return Err(Error::Device("the GPU's links are incomplete".into()));
        };
        if drawn {
            self.check_item_buffers(patch, &samples[0]);
        }
        let baselines: Vec<Baseline> = match rule.compares_links() {
            true => {
                self.check_links((patch, rule), &samples, &row);
                let baseline = |sums: &Vec4| Baseline {
                    subtracted: sums.x,
                    before: sums.y,
                };
                last.sums.iter().map(baseline).collect()
            }
            false => vec![Baseline::default(); mesh.texels.len()],
        };
        let shot = solver.request_shot(patch).await?;
        // The probe has kept the links, unless they are made anew for each rule.
        let faces = if rule.compares_links() { mesh.faces.len() } else { 0 };
        check_drawn_faces(&mut self.drawn_faces, self.transport, (patch, faces), solver).await?;
        let after = solver.request_field().await?;
        let in_flight = load_shot(mesh, patch, Vec3::from(shot.power), row.scale, rule, &reflectance);
        for (k, baseline) in baselines.into_iter().enumerate() {
            let (mut b, mut r, mut h) = (field.radiosity[k], field.residual[k], field.irradiance[k]);
            deposit(&in_flight, k as u32, row.links[k], baseline, (&mut b, &mut r, &mut h));
            let light = in_flight.radiosity.abs().max_element();
            let link = row.links[k]
                .abs()
                .max(baseline.subtracted.abs())
                .max(baseline.before.abs());
            let gpu = [after.radiosity[k], after.residual[k], after.irradiance[k]];
            let source = ValueSource::shot_by(patch);
            for (n, (a, b)) in gpu.into_iter().zip([b, r, h]).enumerate() {
                for c in 0..3 {
                    let size = a.truncate().abs().max_element().max(light * link);
                    self.deposit.add_ulps(source, [k, 3 * n + c], [a[c], b[c]], size);
                }
            }
            self.deposit
                .add_ulps(source, [k, 9], [after.irradiance[k].w, h.w], link);
        }
        Ok(())
    }

    /// Checks the item buffers of a sample, with and without the objects.
    fn check_item_buffers(&mut self, patch: u32, probed: &ProbedSample) {
        let source = ValueSource {
            shooter: Some(patch),
            sample: Some(0),
        };
        for (mesh, ids) in self.drawn.iter().zip([&probed.ids, &probed.room_ids]) {
            if let Some(drawn) = drawn_view(mesh, self.transport, (patch, 0), &probed.aim, ids.clone()) {
                item_buffer::check_all_pixels(mesh, &drawn.view, &drawn.buffer, source, &mut self.item_buffer);
            }
        }
    }

    /// Checks the sums of each sample, and the links and their baselines after the last.
    fn check_links(&mut self, (patch, rule): (u32, DepositRule), samples: &[ProbedSample], row: &ProbedRow) {
        let mut texels = vec![TexelState::default(); self.mesh.texels.len()];
        for (s, probed) in samples.iter().enumerate() {
            let buffers = self.sample_buffers((patch, s as u32), probed);
            let sample = |(k, state): (usize, &TexelState)| {
                let (sums, last) = (probed.sums[k], s + 1 == samples.len());
                let found = match last {
                    true => [row.links[k], sums.x, sums.y],
                    false => [sums.y, sums.z, sums.w],
                };
                let mut state = *state;
                if s == 0 {
                    state.sums.form_factor = sums.x;
                }
                let texel = [patch, s as u32, k as u32];
                self.sample_texel(texel, rule, buffers.as_ref(), (found, last), state)
            };
            let found: Vec<TexelSample> = texels.par_iter().enumerate().map(sample).collect();
            let source = ValueSource {
                shooter: Some(patch),
                sample: Some(s as u32),
            };
            for (k, (texel, found)) in texels.iter_mut().zip(found).enumerate() {
                if let Some((seen, undecided)) = found.sight {
                    let wrong = seen[0] != seen[1] && !undecided;
                    let seen = seen.map(|sight| sight as u32);
                    (self.sight).add(source, [k, 0], seen, f64::from(u8::from(wrong)));
                }
                let first = 3 * usize::from(s + 1 == samples.len());
                for (n, values) in found.values.into_iter().enumerate() {
                    self.link.add_ulps(source, [k, first + n], values, found.size);
                }
                *texel = found.state;
            }
        }
    }

    /// Returns the item buffers that the GPU drew for a sample; none with visibility by rays.
    fn sample_buffers(&self, (patch, s): (u32, u32), probed: &ProbedSample) -> Option<SampleItemBuffers> {
        let drawn = |ids: &[u32]| {
            let mut drawn = drawn_view(self.mesh, self.transport, (patch, s), &probed.aim, ids.to_vec())?;
            item_buffer::remove_unknown_ids(self.mesh, &mut drawn.buffer);
            Some(drawn)
        };
        let with = drawn(&probed.ids)?;
        let object = self.mesh.is_object(self.mesh.patches[patch as usize].face);
        let without = drawn(&probed.room_ids).filter(|_| !object);
        let buffers = (with.buffer, without.map(|drawn| drawn.buffer));
        Some(SampleItemBuffers::of_buffers(with.view, with.lookup, buffers))
    }

    /// Returns the values of a texel after a sample: the twin's on the visibility by which it makes the GPU's, its own first.
    fn sample_texel(
        &self,
        [patch, s, k]: [u32; 3],
        rule: DepositRule,
        buffers: Option<&SampleItemBuffers>,
        (found, last): ([f32; 3], bool),
        state: TexelState,
    ) -> TexelSample {
        let mesh = self.mesh;
        let shooter = &mesh.patches[patch as usize];
        let face = mesh.texels[k as usize].face;
        let through = rule.captured && !mesh.is_object(face);
        let own_sight = |q, p| match buffers {
            Some(buffers) => buffers.find_sight(mesh, p, face),
            None => self.rays.find_sight(q, p, [shooter.face, face], through),
        };
        let traced = Slot::new(None);
        let add = |sight: Option<LineOfSight>| {
            let mut sums = state.sums;
            add_sample(mesh, patch, k, s, &mut sums, |q, p| {
                let sight = sight.unwrap_or_else(|| own_sight(q, p));
                traced.set(Some((q, p, sight)));
                sight
            });
            sums
        };
        let values = |sums: &Sums| match last {
            true => {
                let baseline = sums.link_baseline(mesh, rule, shooter, k);
                [
                    sums.link_weight(shooter.open_share),
                    baseline.subtracted,
                    baseline.before,
                ]
            }
            false => [sums.seen, sums.all, sums.before],
        };
        let mut sums = add(None);
        let mut state_size = state.size;
        if let Some((q, p, _)) = traced.get() {
            let part = shooter.shooter.area / mesh.samples as f32;
            state_size += part / (PI * q.distance_squared(p) + part) + sums.all - state.sums.all;
        }
        let spread = sums.form_factor * (state_size / (sums.all * shooter.open_share));
        let size = match last {
            true if spread.is_finite() => spread.max(sums.form_factor),
            true => sums.form_factor,
            false => state_size,
        };
        let bound = DISC_ROUNDINGS + f64::from(mesh.samples);
        let alike = |sums: &Sums| {
            let mut pairs = found.into_iter().zip(values(sums));
            pairs.all(|(a, b)| ulp_distance(a, b, size) <= bound)
        };
        let sight = traced.get().map(|(q, p, sight)| {
            if alike(&sums) {
                return ([sight; 2], false);
            }
            let others = [LineOfSight::Blocked, LineOfSight::HiddenByObject, LineOfSight::Clear];
            let mut made = others.into_iter().map(|other| (other, add(Some(other))));
            match made.find(|(_, sums)| alike(sums)) {
                Some((other, made)) => {
                    sums = made;
                    ([other, sight], decided_by_rounding(&own_sight, q, p))
                }
                // The link itself is wrong.
                None => ([sight; 2], false),
            }
        });
        let expected = values(&sums);
        TexelSample {
            state: TexelState { sums, size: state_size },
            values: [0, 1, 2].map(|n| [found[n], expected[n]]),
            size,
            sight,
        }
    }
}

/// Returns a field of values that vary from texel to texel, each between 0.5 and 1.5.
fn varied_field(mesh: &Mesh) -> RadiosityField {
    let value = |k: u32| 0.5 + (pcg_hash(k) >> 8) as f32 / (1 << 24) as f32;
    let texels = 0..mesh.texels.len() as u32;
    let values = |first: u32| {
        let of = |k: u32| Vec4::from_array(std::array::from_fn(|c| value(16 * k + first + c as u32)));
        texels.clone().map(of).collect()
    };
    RadiosityField {
        origin: "varied".into(),
        radiosity: values(0),
        residual: values(4),
        irradiance: values(8),
    }
}
