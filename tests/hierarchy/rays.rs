//! Radiosity by rays: the noise that is told is the error against the dense solution on the same texels, and a scene of
//! many small faces is solved to the requested error.

use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::{Face, Scene};
use common::texel::Texel;
use cpu::dense::open_points::OpenParts;
use cpu::ray_cast::{Halves, RaySolve, solve_by_rays};
use glam::{DVec3, Vec3, Vec3A};
use radiosity_tests::dense::{assemble_dense, solve_matrix};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::solutions::{dense_truth_on, error_against, room_with_standing_box, solve_to_error};
use radiosity_tests::{ball, box_faces, bundled_scene, lit_room, named_scene};
use std::ops::ControlFlow;

const REQUESTED_NOISE: f32 = 0.02;

/// A room lit by nine lamps of 2 cm at 1 cm from the ceiling, which they light brightly.
fn room_of_small_lamps() -> Scene {
    let grey = Vec3::splat(0.6);
    let mut faces = box_faces(DVec3::ZERO, DVec3::new(4.0, 2.5, 3.0), true, Vec3::ZERO, grey);
    for k in 0..9 {
        let corner = [0.7 + 1.2 * f64::from(k % 3), 2.49, 0.5 + 0.9 * f64::from(k / 3)];
        let lamp = Face::quad(
            "lamp",
            rectangle(corner, [0.02, 0., 0.], [0., 0., 0.02]),
            Vec3::splat(100.0),
            grey,
        );
        faces.extend([lamp.reversed(), lamp]);
    }
    named_scene("small lamps", faces)
}

/// An open scene: a plate of four skewed quads under a lamp.
fn skewed_plates() -> Scene {
    let at = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let quad = |corners: [DVec3; 4]| Face::quad("plate", corners, Vec3::ZERO, Vec3::splat(0.7));
    let middle = at(0.3, -0.2);
    let lamp = rectangle([-0.3, 0.8, -0.3], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6]);
    let faces = vec![
        quad([at(-1.0, -1.0), at(-1.0, 0.1), middle, at(0.2, -1.0)]),
        quad([at(0.2, -1.0), middle, at(1.0, -0.3), at(1.0, -1.0)]),
        quad([at(-1.0, 0.1), at(-1.0, 1.0), at(0.0, 1.0), middle]),
        quad([middle, at(0.0, 1.0), at(1.0, 1.0), at(1.0, -0.3)]),
        Face::quad("lamp", lamp, Vec3::splat(5.0), Vec3::ZERO),
    ];
    named_scene("skewed plates", faces)
}

/// A solve by rays beside the dense one: RMS of the green channel over the reflected light.
struct Compared {
    off: f64,
    /// The noise that the solve tells, with the error of smoothing.
    told: f64,
    /// Rays that are kept.
    rays: u64,
}

/// Solves `scene` densely on these many texels of each side of a face, and by rays for each of `smooths`: with smoothed light
/// or without.
fn compare_with_dense<const N: usize>(scene: &Scene, texels: u32, smooths: [bool; N]) -> [Compared; N] {
    let (mesh, matrix, _) = assemble_dense(scene, texels);
    let truth = solve_matrix(&mesh, &matrix).radiosity;
    smooths.map(|smooths| compare_with_truth(scene, &mesh, &truth, smooths))
}

fn compare_with_truth(scene: &Scene, mesh: &Mesh, truth: &[DVec3], smooths: bool) -> Compared {
    let rays = Rays::new(mesh);
    let open = OpenParts::new(scene, mesh, &rays);
    let mut solve = RaySolve::new(scene, mesh, &rays, &open).unwrap();
    if smooths {
        solve.smooth_light();
    }
    let mut go_on = |_| ControlFlow::Continue(());
    let found = solve.solve_to_noise(REQUESTED_NOISE, &mut go_on).unwrap();
    assert_eq!(found.removed.is_empty(), !smooths);
    let (mut off, mut noise, mut removed, mut light) = (0.0, 0.0, 0.0, 0.0);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let [area, rho, emission] = [texel.area, texel.reflectance.y, texel.emission.y].map(f64::from);
        let reflected = truth[k].y - emission;
        off += area * (rho * f64::from(found.irradiance[k].y) - reflected).powi(2);
        noise += area * rho * rho * f64::from(found.noise[k].y).powi(2);
        if smooths {
            let [a, b] = found.removed[k].map(|half| rho * f64::from(half.y));
            removed += area * a * b;
        }
        light += area * reflected * reflected;
    }
    assert!(light > 0.0);
    Compared {
        off: (off / light).sqrt(),
        told: ((noise + removed.max(0.0)) / light).sqrt(),
        rays: found.links,
    }
}

/// The told noise is a mean over at least 300 texels of squares of two halves' differences: its relative deviation is
/// about 1/√600 if texels are independent, and more because bounces make them depend on each other.
#[test]
fn told_noise_is_the_error_against_the_dense_solution() {
    let cases = [
        (bundled_scene("cornell_box.obj"), 8),
        (bundled_scene("paper_room_objects.obj"), 2),
        (room_with_standing_box(), 6),
        (room_of_small_lamps(), 8),
        (skewed_plates(), 10),
    ];
    for (scene, texels) in cases {
        let [Compared { off, told, .. }] = compare_with_dense(&scene, texels, [false]);
        // The solve relates it to its own light, which is off by about as much.
        let most = f64::from(REQUESTED_NOISE * (1.0 + REQUESTED_NOISE));
        assert!(told <= most, "{}: {told}", scene.name);
        let ratio = off / told;
        assert!((0.7..1.4).contains(&ratio), "{}: {off} off, {told} told", scene.name);
    }
}

/// Smoothed light has the error that is told, and needs fewer rays. What is removed is chosen by the same rays, so that the
/// error may be somewhat larger; told over more texels than above, it deviates less.
#[test]
fn told_noise_of_smoothed_light_is_its_error() {
    for (scene, texels) in [
        (bundled_scene("cornell_box.obj"), 12),
        (room_with_standing_box(), 12),
        (room_of_small_lamps(), 10),
    ] {
        let [plain, smoothed] = compare_with_dense(&scene, texels, [false, true]);
        let Compared { off, told, rays } = smoothed;
        let ratio = off / told;
        assert!((0.7..1.4).contains(&ratio), "{}: {off} off, {told} told", scene.name);
        assert!(rays < plain.rays, "{}: {rays} of {} rays", scene.name, plain.rays);
    }
}

/// Solves `scene` on 8×8 texels and passes the mesh, its open shares and the solve to `test`.
fn with_solve(scene: &Scene, test: impl FnOnce(&Mesh, &[f32], &mut RaySolve)) {
    let mesh = Mesh::uniform(scene, 8, 1).unwrap();
    let rays = Rays::new(&mesh);
    let open = OpenParts::new(scene, &mesh, &rays);
    let mut solve = RaySolve::new(scene, &mesh, &rays, &open).unwrap();
    let mut go_on = |_| ControlFlow::Continue(());
    solve.solve_to_noise(REQUESTED_NOISE / 8.0, &mut go_on).unwrap();
    test(&mesh, &open.shares, &mut solve);
}

/// Means over texels of half the resolution, of a matrix of mean form factors, are those of the merged texels.
#[test]
fn change_of_merged_texels_is_that_of_dense_solutions() {
    let scene = room_with_standing_box();
    let [fine, coarse] = [8, 4].map(|texels| dense_truth_on(&scene, texels));
    with_solve(&scene, |mesh, _, solve| {
        let change = solve.change_if_merged(&mut |_| ControlFlow::Continue(())).unwrap();
        let (mut off, mut all) = (0.0, 0.0);
        for (k, texel) in coarse.0.texels.iter().enumerate() {
            let [i, j] = texel.lattice_corner;
            let parts = mesh
                .texels
                .iter()
                .enumerate()
                .filter(|(_, part)| part.face == texel.face && part.lattice_corner.map(|n| n / 2) == [i, j]);
            let parts: Vec<usize> = parts.map(|(n, _)| n).collect();
            assert_eq!(parts.len(), 4);
            let mean = |of: &dyn Fn(usize) -> f32| 0.25 * parts.iter().map(|n| of(*n)).sum::<f32>();
            let expected = coarse.1.radiosity[k].y - mean(&|n| fine.1.radiosity[n].y);
            let found = mean(&|n| 0.5 * (change.reflected[n][0].y + change.reflected[n][1].y));
            off += texel.area * (found - expected).powi(2);
            all += texel.area * expected * expected;
        }
        // A tenth of the change: the dense factors of few points are as far off, and the rays' noise cancels.
        assert!(all > 0.0 && off < 0.01 * all, "{off} of {all}");
    });
}

/// The light that a face sends into a closed room arrives: Σ A F over the texels that receive it is the face's open area.
#[test]
fn change_is_attributed_to_the_face_that_sends_it() {
    let scene = room_with_standing_box();
    with_solve(&scene, |mesh, open, solve| {
        let areas: Vec<Halves> = mesh.texels.iter().map(|texel| [Vec3A::X * texel.area; 2]).collect();
        for f in [0, 2, 7] {
            let only = |texel: &Texel| [Vec3A::splat(if texel.face == f { 0.5 } else { 0.0 }); 2];
            let sent: Vec<Halves> = mesh.texels.iter().map(only).collect();
            let shares = solve.attribute_change(&sent, &areas);
            let texels = mesh.texels.iter().zip(open).filter(|(texel, _)| texel.face == f);
            let area: f32 = texels.map(|(texel, open)| texel.area * open).sum();
            for (g, share) in shares.iter().enumerate() {
                let expected = if g == f as usize { f64::from(area) } else { 0.0 };
                // Of some 10⁴ rays that meet the face.
                assert!(
                    (share - expected).abs() <= 0.05 * expected,
                    "face {g} of {f}: {share}, {expected}"
                );
            }
        }
    });
}

/// Eight cells in a row, with a small lamp in each and slits between them.
fn row_of_cells() -> Scene {
    let grey = Vec3::splat(0.6);
    let mut faces = box_faces(DVec3::ZERO, DVec3::new(8.0, 1.0, 1.0), true, Vec3::ZERO, grey);
    for k in 1..8 {
        // Slits alternate in their side.
        let [low, high] = if k % 2 == 0 { [0.0, 0.8] } else { [0.2, 1.0] };
        let wall = rectangle([f64::from(k), 0., low], [0., 1., 0.], [0., 0., high - low]);
        let wall = Face::quad("wall", wall, Vec3::ZERO, grey);
        faces.extend([wall.reversed(), wall]);
    }
    for k in 0..8 {
        let corner = [f64::from(k) + 0.3, 0.7, 0.2 + 0.07 * f64::from(k)];
        let lamp = rectangle(corner, [0.03, 0., 0.], [0., 0., 0.03]);
        let lamp = Face::quad("lamp", lamp, Vec3::splat(100.0), grey);
        faces.extend([lamp.reversed(), lamp]);
    }
    named_scene("row of cells", faces)
}

/// Light that few rays find is absorbed like all other: a texel whose first rays brought little gets few, and the mean
/// over them must not be too dark.
#[test]
fn light_that_rays_seldom_find_is_absorbed_as_a_whole() {
    let scene = row_of_cells();
    let mut mesh = Mesh::uniform(&scene, 8, 1).unwrap();
    let mut go_on = |_| ControlFlow::Continue(());
    let found = solve_by_rays(&scene, &mut mesh, REQUESTED_NOISE, &mut go_on).unwrap();
    let (mut emitted, mut absorbed) = (0.0, 0.0);
    for (texel, h) in mesh.texels.iter().zip(&found.irradiance) {
        emitted += f64::from(texel.area * texel.emission.y);
        absorbed += f64::from(texel.area * (1.0 - texel.reflectance.y) * h.y);
    }
    // The noise of the mean over 2 432 texels would be 50 times smaller if they were independent; all that a bright spot
    // lights shares its noise.
    let off = absorbed / emitted - 1.0;
    assert!(off.abs() < f64::from(REQUESTED_NOISE) / 4.0, "{off}");
}

/// Noise that is asked of the hollow ball.
const FURNACE_NOISE: f32 = 0.002;

/// B = E/(1 − ρ) at every texel, whatever the rays meet.
#[test]
fn hollow_ball_by_rays_has_the_radiosity_of_a_furnace() {
    let inside = |face: Face| Face {
        emission: Vec3::ONE,
        reflectance: Vec3::splat(0.8),
        ..face.reversed()
    };
    let faces: Vec<Face> = ball(DVec3::ZERO, 1.0, [15, 20]).into_iter().map(inside).collect();
    let scene = named_scene("hollow ball", faces);
    let mut mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    let mut go_on = |_| ControlFlow::Continue(());
    let found = solve_by_rays(&scene, &mut mesh, FURNACE_NOISE, &mut go_on).unwrap();
    let mean = |of: &dyn Fn(usize) -> f32| (0..mesh.texels.len()).map(of).sum::<f32>() / mesh.texels.len() as f32;
    let radiosity = mean(&|k| 1.0 + 0.8 * found.irradiance[k].x);
    // A texel's direct light has 1/√N of its noise in the mean over N = 560 texels; 1/(1 − ρ) = 5 bounces carry it on:
    // 0.2 of the noise of one, which four deviations of the mean stay below.
    let noise_of_mean = FURNACE_NOISE * 5.0 / (560.0f32).sqrt();
    assert!((radiosity / 5.0 - 1.0).abs() < 4.0 * noise_of_mean, "{radiosity}");
    let spread = mean(&|k| (0.8 * found.irradiance[k].x - 4.0).powi(2)).sqrt() / 4.0;
    assert!(spread < 1.3 * FURNACE_NOISE, "{spread}");
}

#[test]
fn body_of_many_faces_is_solved_by_rays_within_the_requested_error() {
    let mut scene = lit_room();
    scene.faces.truncate(6);
    let body = ball(DVec3::new(1.4, 0.9, 1.9), 0.6, [8, 16]);
    scene.faces.extend(body);
    scene.name = "a ball of 224 faces".into();
    let requested = 0.03;
    let answer = solve_to_error(&scene, requested, 4);
    assert_eq!(answer.solved.run.field.origin, "rays");
    let off = error_against(&scene, &answer, &dense_truth_on(&scene, 4));
    let told = answer.estimate.unwrap().error;
    assert!(off <= requested, "{off} off, {told} told");
    assert!(told <= requested && told < 4.0 * off, "{told} told, {off} off");
}

/// Rays to lamps alone, beside reflected light that is known, find the light that a solve finds.
#[test]
fn lamps_light_is_gathered_beside_known_light() {
    let scene = row_of_cells();
    let mesh = Mesh::uniform(&scene, 4, 1).unwrap();
    let rays = Rays::new(&mesh);
    let open = OpenParts::new(&scene, &mesh, &rays);
    let mut go_on = |_| ControlFlow::Continue(());
    let mut solve = RaySolve::new(&scene, &mesh, &rays, &open).unwrap();
    let found = solve.solve_to_noise(REQUESTED_NOISE, &mut go_on).unwrap();
    let light = solve.divided_light();
    for (k, h) in found.irradiance.iter().enumerate() {
        let parts = [&light.direct, &light.reflected].map(|part| 0.5 * (part[k][0] + part[k][1]));
        // Of f32.
        let off = (Vec3A::from(*h) - parts[0] - parts[1]).abs().max_element();
        assert!(off <= 1e-5 * h.max_element(), "{off} of {h}");
    }
    let reflected: Vec<Vec3A> = light.reflected.iter().map(|[a, b]| 0.5 * (*a + *b)).collect();
    // Every second texel is known, and gathers nothing.
    let half = open.keep_texels(|k| k % 2 == 0);
    let gather = RaySolve::new(&scene, &mesh, &rays, &half).unwrap();
    let mut gather = gather.beside_light(reflected.clone());
    let gathered = gather.solve_to_noise(REQUESTED_NOISE, &mut go_on).unwrap();
    let (mut off, mut noise, mut lit) = (0.0, 0.0, 0);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let own = gathered.irradiance[k] - Vec3::from(reflected[k]);
        if k % 2 == 1 {
            assert_eq!(own, Vec3::ZERO);
            continue;
        }
        let [a, b] = light.direct[k];
        lit += usize::from(own.x > 0.0);
        off += f64::from((own.x - 0.5 * (a + b).x).powi(2) * texel.area);
        noise += f64::from((gathered.noise[k].x.powi(2) + 0.25 * (a - b).x.powi(2)) * texel.area);
    }
    // Squares over some hundred texels, a few of which have most of the noise.
    let ratio = (off / noise).sqrt();
    assert!(
        lit > mesh.texels.len() / 8 && (0.5..2.0).contains(&ratio),
        "{ratio}, {lit} lit"
    );
}
