//! The path tracer against closed forms, and the dense solver against the path tracer.
//!
//! The mean of 16 sets is distributed about the truth like Student's t of 15 degrees. Bounds are 7 standard errors, which
//! are exceeded by chance once in 230 000.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use oracle::exact::direct_light::reflected_direct;
use oracle::exact::{furnace_radiosity, parallel_rectangles, perpendicular_rectangles};
use oracle::path_tracer::{TracedRadiosity, debiased_pair_rms, debiased_rms, path_growth_for_noise, trace_radiosity};
use radiosity::studies::random::{FaceShapes, LampKind, draw_scene};
use radiosity::studies::stress::cases::shapes::{box_faces, plate_at, scene_of, unit_room};
use radiosity_tests::solutions::dense_truth_on;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

const SIGMAS: f64 = 7.0;

fn with_material(mut faces: Vec<Face>, emission: f32, reflectance: f32) -> Vec<Face> {
    for face in &mut faces {
        face.emission = Vec3::splat(emission);
        face.reflectance = Vec3::splat(reflectance);
    }
    faces
}

fn uniform_mesh(scene: &Scene, texels: u32) -> Mesh {
    Mesh::uniform(scene, texels, 1).unwrap()
}

/// Asserts the mean of a texel's first channel.
fn assert_within_error(traced: &TracedRadiosity, k: usize, expected: f64) {
    let (found, error) = (traced.reflected.values[k].x, traced.error[k].x);
    let off = (found - expected) / error.max(1e-12);
    assert!(
        off.abs() < SIGMAS,
        "texel {k}: {found} ± {error} instead of {expected}: {off:.1} standard errors"
    );
}

#[test]
fn traced_furnace_is_uniform() {
    for reflectance in [0.5, 0.9] {
        let scene = scene_of(with_material(unit_room(0.0), 2.0, reflectance));
        let traced = trace_radiosity(&scene, &uniform_mesh(&scene, 2), 16_000, 1);
        let rho = f64::from(reflectance);
        for k in 0..24 {
            assert_within_error(&traced, k, furnace_radiosity(2.0, rho) - 2.0);
            assert!(traced.error[k].x < 0.02 * furnace_radiosity(2.0, rho));
        }
    }
}

#[test]
fn traced_direct_light_equals_form_factor() {
    // The ceiling emits, one wall reflects, the rest is black.
    for (wall, factor) in [
        (0, parallel_rectangles(1.0, 1.0, 1.0)),
        (2, perpendicular_rectangles(1.0, 1.0, 1.0)),
    ] {
        let mut faces = unit_room(0.0);
        faces[1].emission = Vec3::new(3.0, 1.0, 0.0);
        faces[wall].reflectance = Vec3::splat(0.9);
        let scene = scene_of(faces);
        let traced = trace_radiosity(&scene, &uniform_mesh(&scene, 1), 40_000, 2);
        assert_within_error(&traced, wall, 0.9f32 as f64 * 3.0 * factor);
        let [red, green, blue] = traced.reflected.values[wall].to_array();
        // All channels have the same paths, and these f32 colours are exact.
        assert!(abs_diff_eq!(red / green, 3.0, epsilon = 1e-12) && blue == 0.0);
        let others = (0..6).filter(|k| *k != wall);
        assert!(others.into_iter().all(|k| traced.reflected.values[k] == DVec3::ZERO));
    }
}

/// 100 lamps over a floor, of which a few light each point: a path asks one of them whether it is seen.
#[test]
fn traced_light_of_many_lamps_equals_sum_of_form_factors() {
    let mut faces = vec![plate_at([0.5, 0.5, 0.0], [1.0; 2], 0.8)];
    for k in 0..100 {
        let [x, y] = [k % 10, k / 10].map(|i| 0.05 + 0.1 * f64::from(i));
        let mut lamp = plate_at([x, y, 0.02], [0.02; 2], 0.0).reversed();
        lamp.emission = Vec3::new(1.0, 1.0 + (k % 3) as f32, (k % 2) as f32);
        faces.push(lamp);
    }
    let scene = scene_of(faces);
    // Lamps of one plane hide nothing of each other's light.
    let exact = reflected_direct(&scene, 3, &(0..0));
    let traced = trace_radiosity(&scene, &uniform_mesh(&scene, 3), 4000, 6);
    let mut noise = 0.0f64;
    for (k, exact) in exact.iter().take(9).enumerate() {
        for (found, error, exact) in (0..3).map(|c| (traced.reflected.values[k][c], traced.error[k][c], exact[c])) {
            assert!(
                exact > 0.0 && (found - exact).abs() < SIGMAS * error,
                "{found} ± {error} instead of {exact}"
            );
        }
        noise = noise.max(traced.error[k].x / exact.x);
    }
    // One candidate a vertex leaves 0.94 %, sixteen 0.59.
    assert!(noise < 0.0075, "{noise}");
}

/// A furnace with a box on its floor and a floating sheet: B = E/(1 − ρ) on all lit texels. Under the box, and on its
/// underside, there is no light.
#[test]
fn texels_under_box_are_dark_and_both_sides_of_sheet_are_lit() {
    let mut faces = unit_room(0.0);
    faces.extend(box_faces([0.25, 0.25, 0.0], [0.75, 0.75, 0.5], false, 0.0));
    let up = plate_at([0.5, 0.5, 0.75], [0.6; 2], 0.0);
    faces.extend([up.reversed(), up]);
    let scene = scene_of(with_material(faces, 1.0, 0.6));
    let traced = trace_radiosity(&scene, &uniform_mesh(&scene, 4), 2000, 3);
    let lit = furnace_radiosity(1.0, f64::from(0.6f32)) - 1.0;
    for k in 0..14 * 16 {
        let (face, i, j) = (k / 16, k % 4, k / 4 % 4);
        let covered = face == 6 || (face == 0 && (1..3).contains(&i) && (1..3).contains(&j));
        assert_within_error(&traced, k, if covered { 0.0 } else { lit });
        assert_eq!(traced.error[k].x == 0.0, covered);
    }
}

/// A box in a corner: two of its sides lie on emitting walls, its underside on the floor.
#[test]
fn box_in_corner_blocks_light_of_walls_behind_it() {
    let mut faces = with_material(unit_room(0.0), 1.0, 0.6);
    faces.extend(with_material(
        box_faces([0.5, 0.5, 0.0], [1.0, 1.0, 0.5], false, 0.0),
        0.0,
        0.6,
    ));
    let scene = scene_of(faces);
    let traced = trace_radiosity(&scene, &uniform_mesh(&scene, 2), 400, 3);
    // The quarter of the floor in the corner, and the underside, are dark.
    let texel = |face: usize, k: usize| traced.reflected.values[4 * face + k];
    let dark: Vec<usize> = (0..4).filter(|k| texel(0, *k) == DVec3::ZERO).collect();
    assert_eq!(dark, [3], "{:?}", &traced.reflected.values[..4]);
    assert!((0..4).all(|k| texel(6, k) == DVec3::ZERO));
}

/// A closed room of two-sided walls, cut alike or otherwise outside: the back of its lamp is all that is no front, and the
/// ceiling is lit.
#[test]
fn two_sided_walls_are_lit_as_one_sided_ones() {
    let mut faces = unit_room(0.7);
    let mut lamp = plate_at([0.5, 0.5, 0.9], [0.3; 2], 0.0).reversed();
    lamp.emission = Vec3::ONE;
    faces.push(lamp);
    let thin = scene_of(faces.clone());
    let outside: Vec<Face> = unit_room(0.7).iter().map(Face::reversed).collect();
    let halves = outside.iter().flat_map(|wall| {
        let [a, b, c, d] = wall.corners;
        [[a, b, c], [a, c, d]].map(|corners| Face::triangle("half", corners, Vec3::ZERO, wall.reflectance))
    });
    let cut = scene_of(faces.iter().cloned().chain(halves).collect());
    faces.extend(outside.iter().cloned());
    let walled = scene_of(faces);
    let [thin, walled, cut] = [thin, walled, cut].map(|scene| {
        let traced = trace_radiosity(&scene, &uniform_mesh(&scene, 1), 8000, 9);
        [0, 1].map(|k| (traced.reflected.values[k].x, traced.error[k].x))
    });
    for ((expected, error), (found, own)) in thin.into_iter().chain(thin).zip(walled.into_iter().chain(cut)) {
        let off = (found - expected) / error.hypot(own);
        assert!(
            expected > 0.0 && off.abs() < SIGMAS,
            "{found} instead of {expected}: {off:.1} standard errors"
        );
    }
}

/// A lamp in the plane of a ceiling, before it in the file or twice after it, lights the room as one in a hole of the ceiling.
#[test]
fn lamp_in_the_plane_of_a_ceiling_is_met() {
    let mut faces = unit_room(0.7);
    let ceiling = faces
        .iter()
        .position(|face| face.corners.iter().all(|corner| corner.z == 1.0));
    let whole = faces.remove(ceiling.expect("a ceiling"));
    // The lamp is black: where the ceiling is met instead, there is more light.
    let strip = |x: [f64; 2], emission: f32| {
        let corners = [[x[0], 0.0], [x[0], 1.0], [x[1], 1.0], [x[1], 0.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
        Face::quad(
            "strip",
            corners,
            Vec3::splat(emission),
            whole.reflectance * (1.0 - emission),
        )
    };
    let lamp = strip([0.4, 0.7], 1.0);
    let [beside, around] = [strip([0.0, 0.4], 0.0), strip([0.7, 1.0], 0.0)];
    let [cut, after, before] = [
        vec![lamp.clone(), beside, around],
        vec![lamp.clone(), whole.clone()],
        vec![whole.clone(), lamp.clone(), lamp],
    ]
    .map(|ceiling| {
        let scene = scene_of([faces.clone(), ceiling].concat());
        let traced = trace_radiosity(&scene, &uniform_mesh(&scene, 1), 8000, 9);
        // The floor; what the ceiling reflects in all.
        let of_ceiling = (5..traced.reflected.values.len())
            .filter(|k| scene.faces[*k].emission == Vec3::ZERO)
            .map(|k| (traced.reflected.values[k].x * scene.faces[k].area(), traced.error[k].x));
        let ceiling = of_ceiling.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
        [(traced.reflected.values[0].x, traced.error[0].x), ceiling]
    });
    for ((expected, error), (found, own)) in cut.into_iter().chain(cut).zip(after.into_iter().chain(before)) {
        let off = (found - expected) / error.hypot(own);
        assert!(
            expected > 0.0 && off.abs() < SIGMAS,
            "{found} instead of {expected}: {off:.1} standard errors"
        );
    }
}

#[test]
fn same_seed_gives_same_result() {
    let scene = draw_scene(1, FaceShapes::Quads).scene;
    let [a, b, other] = [4, 4, 5].map(|seed| trace_radiosity(&scene, &uniform_mesh(&scene, 2), 50, seed));
    assert_eq!(a.reflected.values, b.reflected.values);
    assert_eq!(a.error, b.error);
    assert_ne!(a.reflected.values, other.reflected.values);
}

/// Σ A(1 − ρ)H = Σ AE in closed rooms: no light is lost in a body or through a seam. All lamps are boxes: the black back
/// of a panel absorbs light, and so does a body on an emitting wall.
#[test]
fn closed_rooms_absorb_emitted_power() {
    let closed = (0..).map(|seed| draw_scene(seed, FaceShapes::Triangles));
    for drawn in closed
        .filter(|d| d.closed && d.lamps.iter().all(|l| *l == LampKind::Box))
        .take(4)
    {
        let scene = &drawn.scene;
        let traced = trace_radiosity(scene, &uniform_mesh(scene, 1), 3000, 4);
        let (mut absorbed, mut variance, mut emitted) = (0.0, 0.0, 0.0);
        for (k, face) in scene.faces.iter().enumerate() {
            let [area, rho] = [face.area(), f64::from(face.reflectance.x)];
            let gain = area * (1.0 - rho) / rho;
            absorbed += gain * traced.reflected.values[k].x;
            variance += (gain * traced.error[k].x).powi(2);
            emitted += area * f64::from(face.emission.x);
        }
        let off = (absorbed - emitted) / variance.sqrt();
        println!(
            "{drawn}: absorbed {:.4} ± {:.4}",
            absorbed / emitted,
            variance.sqrt() / emitted
        );
        assert!(off.abs() < SIGMAS, "{drawn}: {off:.1} standard errors");
    }
}

/// Compares the dense solver on `texels` per side, and on texels half as wide, with `paths` per texel and set.
/// The error on the narrow ones is at most the change by halving. With more noise than `noise_limit` the comparison
/// would prove nothing.
pub fn assert_dense_solver_agrees(scene: &Scene, texels: u32, paths: u32, noise_limit: f64) {
    let [(rough_mesh, rough), (fine_mesh, fine)] = [texels, 2 * texels].map(|n| dense_truth_on(scene, n));
    let rough = ReflectedField::from_field(scene, &rough_mesh, &rough);
    let fine = ReflectedField::from_field(scene, &fine_mesh, &fine);
    let traced = trace_radiosity(scene, &rough_mesh, paths, 5);
    let pair = GridPair::new(&fine, &traced.reflected, Some(&traced.error)).unwrap();
    let [error, noise] = debiased_pair_rms(&pair);
    let changed = GridPair::new(&rough, &fine, None).unwrap().worst_channel().0;
    let text = format!("{}: {error} ± {noise}, halving changed {changed}", scene.name);
    assert!(error <= changed + SIGMAS * noise, "{text}");
    assert!(SIGMAS * noise < noise_limit, "{text}");
}

#[test]
fn dense_solver_agrees_with_paths_on_random_triangles() {
    for seed in [10, 11, 12] {
        let drawn = draw_scene(seed, FaceShapes::Triangles);
        println!("{drawn}");
        assert_dense_solver_agrees(&drawn.scene, 2, 6000, 0.05);
    }
}

/// With as many paths as are predicted, the error of an answer that is 1 % off scatters by the noise that was requested.
#[test]
fn predicted_paths_leave_requested_noise() {
    const TEXELS: usize = 1000;
    const SAMPLES: usize = 200;
    const OFF: f64 = 0.01;
    const NOISE: f64 = 0.002;
    let areas: Vec<f64> = (0..TEXELS).map(|k| 1.0 + (k % 5) as f64).collect();
    let exact: Vec<DVec3> = (0..TEXELS).map(|k| DVec3::splat(1.0 + (k % 7) as f64)).collect();
    let first: Vec<DVec3> = (0..TEXELS).map(|k| DVec3::splat(0.1 + 0.2 * (k % 3) as f64)).collect();
    let growth = path_growth_for_noise(&areas, &exact, &first, OFF, NOISE);
    assert!(growth > 2.0, "{growth}");
    let error: Vec<DVec3> = first.iter().map(|error| error / growth.sqrt()).collect();
    let answer: Vec<DVec3> = exact.iter().map(|light| light * (1.0 + OFF)).collect();
    let mut source = Xoshiro256PlusPlus::seed_from_u64(4);
    let mut judge = || {
        // The sum of twelve uniform numbers has variance 1.
        let mut noise = || (0..12).map(|_| source.random::<f64>()).sum::<f64>() - 6.0;
        let traced: Vec<DVec3> = exact
            .iter()
            .zip(&error)
            .map(|(light, error)| light + error * noise())
            .collect();
        debiased_rms((&areas, &[1.0; TEXELS]), &answer, &traced, &error)
    };
    let judged: Vec<f64> = (0..SAMPLES).map(|_| judge()[0]).collect();
    let mean = judged.iter().sum::<f64>() / SAMPLES as f64;
    let scatter = (judged.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / SAMPLES as f64).sqrt();
    let known = 1.0 / (2.0 * SAMPLES as f64).sqrt();
    assert!(
        (scatter / NOISE - 1.0).abs() < SIGMAS * known,
        "{scatter} instead of {NOISE}"
    );
    assert!((mean - OFF).abs() < SIGMAS * NOISE / (SAMPLES as f64).sqrt(), "{mean}");
}

/// The error of a random sample of texels, judged by an exact truth, scatters by the noise that is told.
#[test]
fn choice_of_texels_is_in_the_noise() {
    const TEXELS: usize = 2000;
    const SAMPLES: usize = 400;
    let truth: Vec<DVec3> = (0..TEXELS).map(|k| DVec3::splat(1.0 + (k % 7) as f64)).collect();
    let off = |k: usize| DVec3::splat(0.1 * (k as f64).sin().powi(3));
    let answer: Vec<DVec3> = truth.iter().enumerate().map(|(k, light)| light + off(k)).collect();
    let exact = vec![DVec3::ZERO; TEXELS];
    let probabilities: Vec<f64> = (0..TEXELS).map(|k| [0.1, 0.3, 1.0][k % 3]).collect();
    let mut source = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut judge = || {
        let mut area = |p: &f64| if source.random_bool(*p) { 1.0 / p } else { 0.0 };
        let areas: Vec<f64> = probabilities.iter().map(&mut area).collect();
        debiased_rms((&areas, &probabilities), &answer, &truth, &exact)
    };
    let judged: Vec<[f64; 2]> = (0..SAMPLES).map(|_| judge()).collect();
    let mean = |values: &dyn Fn(&[f64; 2]) -> f64| judged.iter().map(values).sum::<f64>() / SAMPLES as f64;
    let error = mean(&|[error, _]| *error);
    let scatter = mean(&|[own, _]| (own - error).powi(2)).sqrt();
    let told = mean(&|[_, noise]| noise * noise).sqrt();
    // The scatter of n samples is known to 1/√2n.
    let known = 1.0 / (2.0 * SAMPLES as f64).sqrt();
    assert!((told / scatter - 1.0).abs() < SIGMAS * known, "{told} of {scatter}");
    let all = debiased_rms((&[1.0; TEXELS], &[1.0; TEXELS]), &answer, &truth, &exact);
    assert!(
        (error - all[0]).abs() < SIGMAS * scatter / (SAMPLES as f64).sqrt(),
        "{error} of {all:?}"
    );
    assert_eq!(all[1], 0.0);
}
