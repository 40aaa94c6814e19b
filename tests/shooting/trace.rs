//! Record of a solve: it changes nothing, and repeated by its own numbers it gives the solver's radiosity.

use common::energy::EnergyBalance;
use common::mesh::{Mesh, TexelKind};
use common::rays::Rays;
use common::relight::{MendedFlaws, RelightMethod, relight_room};
use common::scene::Scene;
use common::settings::{Settings, Visibility};
use common::shooting::{RadiosityField, Restart, Shoot, Shot, SolveRun, shoot_until_converged};
use common::texel_point::texel_point;
use common::{Result, constants};
use cpu::CpuSolver;
use cpu::shader_twins::item_buffer::ItemBuffer;
use cpu::shader_twins::link::texel_form_factor;
use cpu::shader_twins::view::{ShooterView, view_all_faces};
use glam::{DVec3, Vec3, Vec4};
use half::f16;
use miniz_oxide::inflate::decompress_to_vec;
use oracle::trace::hemisphere::{PackedHemisphere, hemisphere_settings};
use oracle::trace::packing::{HALF_ROUNDING, PackedLinks, TexelLinks, TexelOrder};
use oracle::trace::recorder::{ShotRecorder, TraceLimits};
use oracle::trace::{PartBytes, ShotTrace, TraceLimit};
use radiosity_tests::engines::{
    ENGINE_KINDS, each_engine, engine_settings, hemicube, item_buffer, mesh_of, mesh_scene, settings_of, shoot_freely,
    shoot_on_cpu,
};
use radiosity_tests::lit_room;
use radiosity_tests::relighting::{FurnishedRoom, bottomless_box, relight_settings};
use std::ops::ControlFlow;

const PART_BYTES: PartBytes = PartBytes { shot: 84, shooter: 16 };
const UNLIMITED: TraceLimits = TraceLimits {
    bytes: usize::MAX,
    links: usize::MAX,
    each: PART_BYTES,
};

/// Returns a room whose lamp, the ceiling, is partly covered by a box.
fn room_with_box_at_lamp() -> Scene {
    let mut scene = lit_room();
    for face in &mut scene.faces[6..] {
        face.corners.iter_mut().for_each(|corner| corner.y += 0.5);
    }
    scene
}

/// Returns settings with four pairs of points for each link.
fn sampled_settings() -> Settings {
    settings_of([6, 2, 4], Visibility::Rays, engine_settings().schedule.epsilon)
}

/// Solves with a recorder in place.
fn record_solve(engine: &mut dyn Shoot, mesh: &Mesh, limits: TraceLimits) -> (SolveRun, ShotTrace) {
    let settings = engine_settings();
    let mut recorder = ShotRecorder::new(engine, mesh, &settings.transport, limits).unwrap();
    let run = shoot_until_converged(&mut recorder, &settings.schedule, &mut |_, _| ControlFlow::Continue(()));
    (run.unwrap(), recorder.into_trace())
}

/// Adds the prediction of each value by those before it on its face to its difference, which `bytes` hold as low bytes and
/// high bytes.
fn undo_predictions(mesh: &Mesh, order: &TexelOrder, bytes: &[u8]) -> Vec<u16> {
    let (low, high) = bytes.split_at(order.texels.len());
    let mut values: Vec<u16> = Vec::new();
    for (at, k) in order.texels.iter().enumerate() {
        let texel = &mesh.texels[*k];
        let (index, width) = (
            texel.index as usize,
            mesh.faces[texel.face as usize].resolution[0] as usize,
        );
        let before = |back: usize| values[at - back];
        let prediction = match (texel.kind, index / width, index % width) {
            (TexelKind::Quad, 1.., 1..) => before(1).wrapping_add(before(width)).wrapping_sub(before(width + 1)),
            (TexelKind::Quad, 1.., 0) => before(width),
            (TexelKind::Upright | TexelKind::Inverted, ..) if index > 1 => before(2),
            _ if at > 0 => before(1),
            _ => 0,
        };
        let folded = u16::from_le_bytes([low[at], high[at]]);
        values.push(prediction.wrapping_add((folded >> 1) ^ (folded & 1).wrapping_neg()));
    }
    values
}

/// Unpacks links, as the page's script does.
fn unpack_links(mesh: &Mesh, packed: &PackedLinks) -> TexelLinks {
    let order = TexelOrder::new(mesh);
    let count = order.texels.len();
    let bytes = decompress_to_vec(&packed.deflated).unwrap();
    let plane_count = 1 + 2 * usize::from(packed.is_occluded) + usize::from(packed.is_wrong);
    assert_eq!(bytes.len(), 2 * plane_count * count);
    let mut planes = bytes
        .chunks(2 * count)
        .map(|plane| undo_predictions(mesh, &order, plane));
    let numbers = |plane: Vec<u16>, scale: f64| -> Vec<f32> {
        let halves = plane.into_iter().map(f16::from_bits);
        halves.map(|half| (f64::from(half) * scale) as f32).collect()
    };
    let form_factors = numbers(planes.next().unwrap(), f64::from(packed.exponent).exp2());
    let mut seen = planes.by_ref().take(2 * usize::from(packed.is_occluded));
    let shares = seen.next().map_or(vec![1.0; count], |plane| numbers(plane, 1.0));
    let occluders = seen.next().unwrap_or(vec![0; count]);
    TexelLinks {
        form_factors,
        shares,
        occluders,
        share_errors: planes.next().map_or(vec![0.0; count], |plane| numbers(plane, 1.0)),
    }
}

/// Returns radiosity and residual after the recorded shots, and Σ|ΔB|.
fn repeat_shots(mesh: &Mesh, trace: &ShotTrace) -> [Vec<DVec3>; 3] {
    let order = TexelOrder::new(mesh);
    let links: Vec<TexelLinks> = trace.links.iter().map(|own| unpack_links(mesh, own)).collect();
    let mut changed = vec![DVec3::ZERO; mesh.texels.len()];
    let initial = [&trace.initial.radiosity, &trace.initial.residual];
    let [mut radiosity, mut residual] =
        initial.map(|values| values.iter().map(|v| v.truncate().as_dvec3()).collect::<Vec<_>>());
    for traced in &trace.shots {
        let (own, packed) = (&links[traced.links], &trace.links[traced.links]);
        assert_eq!(packed.patch, traced.shot.patch);
        let shooter = &mesh.patches[traced.shot.patch as usize];
        let open = match packed.is_captured {
            true => 1.0,
            false => f64::from(shooter.open_share),
        };
        for (at, k) in order.texels.iter().enumerate() {
            if shooter.texels().contains(k) {
                continue;
            }
            let link = f64::from(own.form_factors[at]) * f64::from(own.shares[at]) / open;
            let change = mesh.texels[*k].reflectance.as_dvec3() * traced.radiosity.as_dvec3() * link;
            radiosity[*k] += change;
            changed[*k] += change.abs();
            if trace.relight.is_none_or(|relight| relight.reshoot) || mesh.is_object(mesh.texels[*k].face) {
                residual[*k] += change;
            }
        }
        if !packed.is_captured {
            residual[shooter.texels()].fill(DVec3::ZERO);
        }
    }
    [radiosity, residual, changed]
}

/// Returns the largest difference of the repeated shots from the solver's field, over its bound. Form factor and share are
/// half floats: together they are off by twice the rounding and its square. The solver rounds each deposit to f32.
fn worst_over_bound(mesh: &Mesh, trace: &ShotTrace, run: &SolveRun) -> f64 {
    let halves = f64::from(HALF_ROUNDING);
    let roundings = run.shots.len() as f64 * f64::from(f32::EPSILON);
    let [radiosity, residual, changed] = repeat_shots(mesh, trace);
    let mut worst: f64 = 0.0;
    for k in 0..mesh.texels.len() {
        let truth = run.field.radiosity[k].truncate().as_dvec3();
        let size = truth.abs() + changed[k];
        let bound = changed[k] * (2.0 * halves + halves * halves) + size * roundings + DVec3::splat(1e-12);
        let unshot = run.field.residual[k].truncate().as_dvec3();
        for off in [radiosity[k] - truth, residual[k] - unshot] {
            worst = worst.max((off.abs() / bound).max_element());
        }
    }
    worst
}

#[test]
fn recorded_shots_repeat_the_solve_on_every_engine() {
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        let untraced = shoot_freely(&mut *fresh(), &engine_settings().schedule);
        let mut engine = fresh();
        let (run, mut trace) = record_solve(&mut *engine, &mesh, UNLIMITED);
        assert_eq!((&run.shots, &run.field), (&untraced.shots, &untraced.field), "{name}");
        assert!(trace.is_complete() && trace.shots.len() > 100, "{name}");
        for traced in &trace.shots {
            assert_eq!(traced.ranking[0].0, traced.shot.patch, "{name}");
            assert!(traced.ranking.is_sorted_by(|a, b| a.1 >= b.1), "{name}");
        }
        let last = trace.shots.last().unwrap().energy.unwrap();
        let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
        assert_eq!(last.absorbed, energy.absorbed, "{name}");
        assert_eq!(last.unshot, energy.unshot, "{name}");
        let worst = worst_over_bound(&mesh, &trace, &run);
        assert!(worst <= 1.0, "{name}: {worst}");
        // Faults are noticed: the links of one patch, and one shot.
        trace.links[0].exponent += 1;
        assert!(worst_over_bound(&mesh, &trace, &run) > 10.0, "{name}");
        trace.links[0].exponent -= 1;
        trace.shots[3].radiosity *= 1.05;
        assert!(worst_over_bound(&mesh, &trace, &run) > 2.0, "{name}");
    });
}

/// Captured light, of which the room loses what the objects hide, and the change after it, by both methods that shoot it.
#[test]
fn recorded_relight_repeats_the_run() {
    let methods = [RelightMethod::Signed, RelightMethod::Paper(MendedFlaws::default())];
    for (kind, method) in ENGINE_KINDS
        .into_iter()
        .flat_map(|kind| methods.map(|method| (kind, method)))
    {
        let objects = bottomless_box(Vec3::splat(0.25), Vec3::splat(0.5));
        let FurnishedRoom {
            settings,
            mut mesh,
            room,
        } = FurnishedRoom::furnish(relight_settings(engine_settings().transport.visibility), objects, 1e-3);
        let relight = |engine: &mut dyn Restart, mesh: &Mesh| {
            let mut on = |_: &Shot, _| ControlFlow::Continue(());
            relight_room(engine, mesh, &room, method, &settings.schedule, &mut on).unwrap()
        };
        let untraced = relight(&mut *kind.fresh_engine(&mesh, &settings, &[]), &mesh);
        let (relit, mut trace) = {
            let mut engine = kind.fresh_engine(&mesh, &settings, &[]);
            let mut recorder = ShotRecorder::new(&mut *engine, &mesh, &settings.transport, UNLIMITED).unwrap();
            (relight(&mut recorder, &mesh), recorder.into_trace())
        };
        assert_eq!(
            (&relit.run.shots, &relit.run.field),
            (&untraced.run.shots, &untraced.run.field)
        );
        assert!(trace.is_complete() && trace.initial_energy.is_none());
        trace.add_captured_light(&mesh, &room);
        for (k, texel) in mesh.texels.iter_mut().enumerate() {
            (texel.reflectance, texel.emission) = (relit.surface.reflectance[k], relit.surface.emission[k]);
        }
        let shares_of = |captured: bool| {
            let own = trace.links.iter().filter(move |own| own.is_captured == captured);
            own.flat_map(|own| unpack_links(&mesh, own).shares)
        };
        let lost = shares_of(true).filter(|share| *share < 0.0).count();
        assert!(
            lost > 10 && shares_of(false).count() > 0,
            "{kind:?}, {method:?}: {lost}"
        );
        let worst = worst_over_bound(&mesh, &trace, &relit.run);
        assert!(worst <= 1.0, "{kind:?}, {method:?}: {worst}");
        trace.initial.radiosity[0] *= 1.01;
        assert!(
            worst_over_bound(&mesh, &trace, &relit.run) > 10.0,
            "{kind:?}, {method:?}"
        );
    }
}

/// Power that is lost is summed shot by shot: as much as all shots so far give at once.
#[test]
fn energy_after_each_shot_is_that_of_all_shots() {
    let mesh = mesh_scene(&room_with_box_at_lamp(), &sampled_settings());
    let mut engine = CpuSolver::new(&mesh, &engine_settings().transport);
    let (run, trace) = record_solve(&mut engine, &mesh, UNLIMITED);
    assert!(trace.initial_energy.unwrap().escaped[0] > 0.0 && trace.shots.len() > 50);
    for (n, traced) in (1..).zip(&trace.shots) {
        let energy = EnergyBalance::new(&mesh, &run.field, &run.shots[..n]);
        let recorded = traced.energy.unwrap();
        assert_eq!(recorded.escaped, energy.escaped, "shot {n}");
        assert_eq!(recorded.closure, energy.closure, "shot {n}");
    }
}

/// A covered part of a shooter is not seen; all light leaves from the open part.
#[test]
fn visible_share_of_covered_lamp_is_at_most_one() {
    let settings = sampled_settings();
    let mesh = mesh_scene(&room_with_box_at_lamp(), &settings);
    for kind in ENGINE_KINDS {
        let mut engine = kind.fresh_engine(&mesh, &settings, &[]);
        let (run, trace) = record_solve(&mut *engine, &mesh, UNLIMITED);
        let mut covered = 0;
        for own in &trace.links {
            let links = unpack_links(&mesh, own);
            let most = links.shares.iter().copied().fold(0.0, f32::max);
            assert!(
                links.shares.iter().all(|share| *share >= 0.0) && most <= 1.0,
                "{kind:?}: {most}"
            );
            let open = mesh.patches[own.patch as usize].open_share;
            if open > 0.0 && open < 1.0 {
                assert!(own.is_occluded, "{kind:?}");
                covered += 1;
            }
        }
        assert!(covered > 0, "{kind:?}");
        let worst = worst_over_bound(&mesh, &trace, &run);
        assert!(worst <= 1.0, "{kind:?}: {worst}");
    }
}

/// V less its error is the share that rays find. Of these there are some in an item buffer of few pixels, and none by rays.
#[test]
fn share_errors_are_those_of_the_item_buffer() {
    let settings = sampled_settings();
    let mesh = mesh_scene(&lit_room(), &settings);
    let record = |visibility| {
        let transport = settings.with_visibility(visibility).transport;
        let mut engine = CpuSolver::new(&mesh, &transport);
        let mut recorder = ShotRecorder::new(&mut engine, &mesh, &transport, UNLIMITED).unwrap();
        shoot_until_converged(&mut recorder, &settings.schedule, &mut |_, _| ControlFlow::Continue(())).unwrap();
        recorder.into_trace().links
    };
    let by_rays = record(Visibility::Rays);
    assert!(by_rays.iter().all(|own| !own.is_wrong));
    let count_errors = |visibility| {
        let [mut errors, mut compared] = [0, 0];
        for own in record(visibility) {
            let Some(known) = by_rays.iter().find(|known| known.patch == own.patch) else {
                continue;
            };
            let [own, known] = [&own, known].map(|links| unpack_links(&mesh, links));
            for k in 0..own.shares.len() {
                let off = own.shares[k] - own.share_errors[k] - known.shares[k];
                // Three half floats of at most 1.
                assert!(off.abs() <= 3.0 * HALF_ROUNDING, "{visibility:?}, texel {k}: {off}");
                errors += usize::from(own.share_errors[k] != 0.0);
                compared += 1;
            }
        }
        assert!(compared > 1000, "{visibility:?}: {compared}");
        errors
    };
    let fine = count_errors(item_buffer(512));
    for coarse in [item_buffer(16), hemicube(16)] {
        let errors = count_errors(coarse);
        assert!(
            errors > 2 * fine.max(10),
            "{coarse:?}: {errors}, and {fine} of a fine one"
        );
    }
}

/// An engine whose links are changed when its field is read.
struct ChangedLinks<'a> {
    engine: CpuSolver<'a>,
    /// Factor of a link and what is added to it.
    change: [f32; 2],
}

impl Shoot for ChangedLinks<'_> {
    fn patch_power(&mut self) -> Result<Vec<f32>> {
        self.engine.patch_power()
    }

    fn shoot(&mut self, patch: u32) -> Result<Shot> {
        self.engine.shoot(patch)
    }

    fn read_field(&mut self) -> Result<RadiosityField> {
        let mut field = self.engine.read_field()?;
        let change = |h: &mut Vec4| h.w = h.w * self.change[0] + self.change[1];
        field.irradiance.iter_mut().for_each(change);
        Ok(field)
    }
}

/// Returns the links of the first shooter with the CPU's form factors, in the order of files.
fn first_links(mesh: &Mesh, change: [f32; 2]) -> (TexelLinks, Vec<f32>) {
    let transport = engine_settings().transport;
    let engine = CpuSolver::new(mesh, &transport);
    let (_, trace) = record_solve(&mut ChangedLinks { engine, change }, mesh, UNLIMITED);
    let packed = &trace.links[0];
    let order = TexelOrder::new(mesh);
    let factor = |k: &usize| texel_form_factor(mesh, transport.form_factor, packed.patch, *k as u32);
    (unpack_links(mesh, packed), order.texels.iter().map(factor).collect())
}

/// The GPU may find a link where the CPU's form factor is 0.
#[test]
fn link_without_form_factor_is_kept() {
    let mesh = mesh_of(&lit_room());
    let added = 1e-5;
    let (links, factors) = first_links(&mesh, [1.0, added]);
    let missing: Vec<usize> = (0..factors.len()).filter(|at| factors[*at] == 0.0).collect();
    assert!(missing.len() > 10);
    for at in missing {
        let link = links.form_factors[at] * links.shares[at];
        assert!((link / added - 1.0).abs() <= 2.0 * HALF_ROUNDING, "{link}");
    }
    assert!(links.shares.iter().all(|share| *share <= 1.0));
}

/// A share that is below 1 by rounding only is 1, and one that is further below is not.
#[test]
fn share_below_one_by_rounding_is_whole() {
    let mesh = mesh_of(&lit_room());
    let (exact, factors) = first_links(&mesh, [1.0, 0.0]);
    // A quarter of the roundings of a polygon near by, which a half float of a small form factor shows.
    let less = 32.0 * f32::EPSILON;
    let (near, _) = first_links(&mesh, [1.0, -less]);
    let (far, _) = first_links(&mesh, [0.99, 0.0]);
    let mut whole = 0;
    for at in (0..factors.len()).filter(|at| exact.shares[*at] == 1.0 && factors[*at] > 0.0) {
        if factors[at] < less / HALF_ROUNDING && factors[at] > 2.0 * less {
            assert_eq!(near.shares[at], 1.0, "{at}");
            whole += 1;
        }
        assert!(far.shares[at] < 1.0 || factors[at] < 1e-2, "{at}");
    }
    assert!(whole > 10, "{whole}");
}

/// Where a texel does not see the whole shooter, the record names a face between them.
#[test]
fn hidden_texels_name_their_occluder() {
    let mesh = mesh_of(&lit_room());
    let mut engine = CpuSolver::new(&mesh, &engine_settings().transport);
    let (_, trace) = record_solve(&mut engine, &mesh, UNLIMITED);
    let links = unpack_links(&mesh, &trace.links[0]);
    let hidden: Vec<usize> = (0..links.shares.len()).filter(|at| links.shares[*at] < 1.0).collect();
    assert!(hidden.len() > 10);
    for at in hidden {
        // The faces of the box follow the six of the room.
        assert!((7..=12).contains(&links.occluders[at]), "{}", links.occluders[at]);
    }
}

/// A pair of points of which one is below the other's horizon exchanges no light: no face on its way is named.
#[test]
fn named_occluder_blocks_pair_above_both_horizons() {
    let settings = sampled_settings();
    let mesh = mesh_scene(&lit_room(), &settings);
    let rays = Rays::new(&mesh);
    let mut engine = CpuSolver::new(&mesh, &settings.transport);
    let (_, trace) = record_solve(&mut engine, &mesh, UNLIMITED);
    let order = TexelOrder::new(&mesh);
    let [mut named, mut unnamed] = [0; 2];
    for own in &trace.links {
        let links = unpack_links(&mesh, own);
        let patch = &mesh.patches[own.patch as usize];
        for (at, k) in order.texels.iter().enumerate() {
            let texel = &mesh.texels[*k];
            let blocks = |s: u32| {
                let from = mesh.patch_points[(own.patch * mesh.samples + s) as usize].position;
                let to = texel_point(&mesh, *k as u32, own.patch, s).truncate();
                let way = to - from;
                let normal = mesh.faces[texel.face as usize].normal;
                patch.shooter.normal.dot(way) > constants::CONTACT_DISTANCE
                    && normal.dot(way) < constants::CONTACT_DISTANCE
                    && rays
                        .find_blockers(from, to, [patch.face, texel.face])
                        .contains(&(u32::from(links.occluders[at]) - 1))
            };
            match links.occluders[at] {
                0 => unnamed += usize::from(links.shares[at] < 1.0),
                face => {
                    assert!(
                        (0..mesh.samples).any(blocks),
                        "patch {}, texel {k}, face {face}",
                        own.patch
                    );
                    named += 1;
                }
            }
        }
    }
    assert!(named > 100 && unnamed > 0, "{named} {unnamed}");
}

/// The hemisphere of a shooter is the item buffer that the CPU's twin draws: that of the solver itself if it is small.
#[test]
fn hemispheres_are_item_buffers_of_the_shooters() {
    let mesh = mesh_of(&lit_room());
    for (visibility, size) in [(Visibility::Rays, 64), (hemicube(1024), 64), (item_buffer(48), 48)] {
        let drawing = hemisphere_settings(visibility);
        assert_eq!(drawing.size, size);
        if let Some(own) = visibility.item_buffer() {
            assert_eq!(drawing.projection, own.projection);
        }
        let transport = engine_settings().with_visibility(visibility).transport;
        let mut engine = CpuSolver::new(&mesh, &transport);
        let mut recorder = ShotRecorder::new(&mut engine, &mesh, &transport, UNLIMITED).unwrap();
        let shooters = [1, 7, 20];
        for patch in shooters {
            recorder.shoot(patch).unwrap();
        }
        let trace = recorder.into_trace();
        assert_eq!(trace.hemispheres.len(), shooters.len());
        for (patch, packed) in shooters.into_iter().zip(&trace.hemispheres) {
            let bytes = decompress_to_vec(&packed.deflated).unwrap();
            let (low, high) = bytes.split_at(bytes.len() / 2);
            let ids: Vec<u32> = low
                .iter()
                .zip(high)
                .map(|(a, b)| u16::from_le_bytes([*a, *b]).into())
                .collect();
            let view = ShooterView::new(&mesh, patch, 0, &drawing);
            assert_eq!(ids, ItemBuffer::draw_faces(&mesh, &view, view_all_faces(&mesh)).ids);
            assert!(ids.iter().any(|id| *id > 6), "none sees the box");
        }
    }
}

#[test]
fn full_record_keeps_the_first_shots() {
    let mesh = mesh_of(&lit_room());
    let whole = shoot_on_cpu(&mesh, &engine_settings());
    let record = |limits| {
        let mut engine = CpuSolver::new(&mesh, &engine_settings().transport);
        let (run, trace) = record_solve(&mut engine, &mesh, limits);
        assert_eq!(run.shots, whole.shots);
        assert_eq!(trace.shot_count, whole.shots.len());
        for (traced, shot) in trace.shots.iter().zip(&whole.shots) {
            assert_eq!(traced.shot, *shot);
        }
        trace
    };
    let bytes_of = |trace: &ShotTrace, shots: usize, links: usize| {
        let own = trace.links[..links].iter().map(PackedLinks::byte_count);
        let seen = trace.hemispheres[..links].iter().map(PackedHemisphere::byte_count);
        let deflated: usize = own.chain(seen).sum();
        deflated + shots * PART_BYTES.shot + links * PART_BYTES.shooter
    };
    let all = record(UNLIMITED);
    assert!(all.is_complete() && all.reached_limit.is_none());
    // The record takes all shots that its bytes hold.
    let some = TraceLimits {
        bytes: 20_000,
        ..UNLIMITED
    };
    let first = record(some);
    assert_eq!(first.reached_limit, Some(TraceLimit::Bytes));
    let [shots, links] = [first.shots.len(), first.links.len()];
    assert!(!first.is_complete() && shots > 5);
    let next = all.shots[shots].shot.patch;
    let is_new = first.links.iter().all(|own| own.patch != next);
    assert!(bytes_of(&all, shots, links) <= some.bytes);
    assert!(bytes_of(&all, shots + 1, links + usize::from(is_new)) > some.bytes);
    assert_eq!(all.count_fitting(some.bytes, PART_BYTES), (shots, links));
    // So it does of the links that a browser holds.
    let texels = mesh.texels.len();
    let few = record(TraceLimits {
        links: 3 * texels,
        ..UNLIMITED
    });
    assert_eq!((few.reached_limit, few.links.len()), (Some(TraceLimit::Links), 3));
    assert!(!few.is_complete() && few.shots.len() >= 3);

    let fitting = first.count_fitting(5_000, PART_BYTES);
    assert!(fitting.0 > 0 && fitting.0 < shots && fitting.1 <= fitting.0);
    assert_eq!(first.count_fitting(usize::MAX, PART_BYTES).0, shots);
    assert_eq!(first.count_fitting(0, PART_BYTES), (0, 0));
}
