//! Light from outside against closed forms, on every solver.

use common::capture::Panorama;
use common::capture::sky::{even_sky, panorama_sky};
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Visibility;
use common::sky::{Sky, Sun};
use cpu::ray_cast::solve_by_rays;
use glam::{DVec3, Vec3};
use oracle::solve::dense::dense_settings;
use oracle::solve::progress::without_progress;
use oracle::solve::solved::Solved;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use oracle::solve::{SolveRequest, solve_request};
use radiosity_tests::engines::{item_buffer, settings_of, shared_gpu};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::{ball, box_faces, named_scene};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Requested error.
pub const ERROR: f64 = 0.01;
/// Texels per side of a face.
pub const TEXELS: u32 = 8;

/// Solves a scene by every solver; asserts the energy balance.
pub fn solve_by_all(scene: &Scene) -> Vec<(&'static str, Solved)> {
    let target = ErrorTarget {
        error: ERROR,
        texels: Some(TEXELS),
    };
    let rays = settings_of([TEXELS, 4, 16], Visibility::Rays, 1e-4);
    let pixels = rays.with_visibility(item_buffer(256));
    let gpu = shared_gpu();
    let solvers = [
        ("hierarchy", rays, SolverChoice::Hierarchy(target)),
        ("hierarchy on the GPU", rays, SolverChoice::GpuHierarchy(gpu, target)),
        ("shots", rays, SolverChoice::Cpu),
        ("shots on the GPU", pixels, SolverChoice::Gpu(gpu)),
        ("dense", dense_settings(TEXELS), SolverChoice::Dense),
    ];
    let solve = |(name, settings, solver): (&'static str, _, _)| {
        let request = SolveRequest {
            task: scene,
            settings: &settings,
            solver,
        };
        let solved = solve_request(&request, &without_progress()).unwrap().solved;
        let energy = EnergyBalance::new(&solved.mesh, &solved.run.field, &solved.run.shots);
        assert!(energy.imbalance < 1e-3, "{name}: {energy:?}");
        (name, solved)
    };
    solvers.map(solve).into()
}

/// Returns the mean irradiance of a face in the first channel.
pub fn mean_irradiance(solved: &Solved, face: u32) -> f64 {
    let texels = solved.mesh.texels.iter().zip(&solved.run.field.irradiance);
    let own = texels.filter(|(texel, _)| texel.face == face);
    let (sum, area) = own.fold((0.0, 0.0), |(sum, area), (texel, h)| {
        let own = f64::from(texel.area);
        (sum + own * f64::from(h.x), area + own)
    });
    sum / area
}

/// Returns the mean irradiance of a face in the first channel, by rays.
pub fn mean_irradiance_by_rays(scene: &Scene, face: u32) -> f64 {
    let mut mesh = Mesh::uniform(scene, TEXELS, 1).unwrap();
    let noise = 0.5 * ERROR as f32;
    let solution = solve_by_rays(scene, &mut mesh, noise, &mut |_| ControlFlow::Continue(())).unwrap();
    let texels = (0..mesh.texels.len()).filter(|k| mesh.texels[*k].face == face);
    let own: Vec<f64> = texels.map(|k| f64::from(solution.irradiance[k].x)).collect();
    own.iter().sum::<f64>() / own.len() as f64
}

fn assert_irradiance(scene: &Scene, expected: f64, tolerance: f64) {
    for (name, solved) in solve_by_all(scene) {
        let found = mean_irradiance(&solved, 0);
        let off = found / expected - 1.0;
        assert!(off.abs() < tolerance, "{}: {name}: {found} for {expected}", scene.name);
    }
}

fn under_sky(name: &str, faces: Vec<Face>, sky: Sky) -> Scene {
    Scene {
        sky: Some(Arc::new(sky)),
        ..named_scene(name, faces)
    }
}

/// A floor of side 2 that faces up; its front is face 0.
fn floor_face() -> Face {
    let corners = rectangle([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0]);
    Face::quad("floor", corners, Vec3::ZERO, Vec3::splat(0.5))
}

fn sun_of(direction: DVec3, irradiance: f32) -> Sky {
    let sun = Sun {
        direction: direction.normalize(),
        irradiance: Vec3::splat(irradiance),
    };
    Sky {
        suns: vec![sun],
        ..Sky::default()
    }
}

#[test]
fn open_floor_receives_all_of_an_even_sky() {
    // The faces of a closed box have a form factor of 1 in all but for the roundings of their texels' sum.
    assert_irradiance(&under_sky("even", vec![floor_face()], even_sky(2.0)), 2.0 * PI, 1e-4);
}

#[test]
fn open_floor_receives_the_cosine_of_the_sun() {
    for angle in [0.0, 0.5, 1.2] {
        let direction = DVec3::new(f64::sin(angle) * 0.6, f64::cos(angle), f64::sin(angle) * 0.8);
        let scene = under_sky("sun", vec![floor_face()], sun_of(direction, 900.0));
        // The sun's distance differs by 1/2048 of itself across the floor, and is a point's: (1/216)²/4.
        assert_irradiance(&scene, 900.0 * f64::cos(angle), 1e-3);
    }
}

#[test]
fn wall_beside_the_floor_hides_its_form_factor() {
    let wall = rectangle([-1.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let wall = Face::quad("wall", wall, Vec3::ZERO, Vec3::ZERO);
    // Squares with a common edge: F = 0.20004 (Howell, C-14).
    let scene = under_sky("wall", vec![floor_face(), wall], even_sky(1.0));
    assert_irradiance(&scene, PI * (1.0 - 0.200_04), ERROR);
}

/// Rays by the cosine and rays to the sky share its light.
#[test]
fn rays_bring_the_light_of_the_sky_once() {
    let wall = rectangle([-1.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let wall = Face::quad("wall", wall, Vec3::ZERO, Vec3::ZERO);
    let scene = under_sky("wall", vec![floor_face(), wall], even_sky(1.0));
    let mut mesh = Mesh::uniform(&scene, TEXELS, 1).unwrap();
    solve_by_rays(&scene, &mut mesh, ERROR as f32, &mut |_| ControlFlow::Continue(())).unwrap();
    let floor = mesh.texels.iter().filter(|texel| texel.face == 0);
    let (sum, area) = floor.fold((0.0, 0.0), |(sum, area), texel| {
        (sum + texel.sky.x * texel.area, area + texel.area)
    });
    // Squares with a common edge: F = 0.20004 (Howell, C-14).
    let off = f64::from(sum / area) / (PI * (1.0 - 0.200_04)) - 1.0;
    assert!(off.abs() < ERROR, "{off}");
}

#[test]
fn plate_casts_the_shadow_of_its_area() {
    let corners = rectangle([-0.5, 0.4, -0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let plate = Face::quad("plate", corners, Vec3::ZERO, Vec3::ZERO);
    let scene = under_sky(
        "shadow",
        vec![floor_face(), plate],
        sun_of(DVec3::new(0.2, 1.0, 0.1), 100.0),
    );
    let cosine = 1.0 / f64::sqrt(1.05);
    assert_irradiance(&scene, 100.0 * cosine * 0.75, ERROR);
}

#[test]
fn open_floor_receives_the_cosine_weighted_map() {
    let [w, h] = [128, 64];
    let light = |k: usize| {
        let (x, y) = ((k % w) as f32 / w as f32, (k / w) as f32 / h as f32);
        Vec3::splat(1.0 + (6.0 * x).sin() + 2.0 * y)
    };
    let map = Panorama::from_pixels([w, h], (0..w * h).map(light).collect(), None).unwrap();
    let expected: f64 = map
        .captured_pixels()
        .map(|([_, y], radiance, solid_angle)| {
            let height = f64::cos((y as f64 + 0.5) / h as f64 * PI);
            f64::from(radiance.x) * solid_angle * height.max(0.0)
        })
        .sum();
    let scene = under_sky("map", vec![floor_face()], panorama_sky(&map, String::new()).unwrap());
    assert_irradiance(&scene, expected, ERROR);
}

/// Where walls emit (1 − ρ)πL under a sky of radiance L, B is πL everywhere, whatever the shapes are.
#[test]
fn scene_in_equilibrium_with_its_sky_is_even() {
    let mut faces = vec![floor_face()];
    let grey = Vec3::new(0.3, 0.5, 0.7);
    let box_at = |low: [f64; 3], high: [f64; 3]| box_faces(low.into(), high.into(), false, Vec3::ZERO, grey);
    faces.extend(box_at([-0.6, 0.3, -0.5], [0.0, 0.9, 0.2]));
    faces.extend(box_at([0.2, 0.1, -0.2], [0.5, 1.3, 0.4]));
    for face in &mut faces {
        face.emission = (Vec3::ONE - face.reflectance) * std::f32::consts::PI;
    }
    let scene = under_sky("equilibrium", faces, even_sky(1.0));
    for (name, solved) in solve_by_all(&scene) {
        let (mut square, mut area) = (0.0, 0.0);
        for (texel, b) in solved.mesh.texels.iter().zip(&solved.run.field.radiosity) {
            let off = (b.truncate().as_dvec3() - PI).max_element().abs() / PI;
            square += f64::from(texel.area) * off * off;
            area += f64::from(texel.area);
        }
        let rms = (square / area).sqrt();
        assert!(rms < 0.02, "{name}: {rms}");
    }
}

/// Solves a ball of triangles of which the fronts look inwards, by links or, if they are many, by rays; returns the light from
/// outside that they receive, and what an opening of the last triangle lets in.
fn light_within_ball(rows: u32, opened: bool) -> [f64; 2] {
    let inside = ball(DVec3::Y * 2.0, 1.0, [rows, 2 * rows]).into_iter();
    let mut faces: Vec<Face> = inside.map(|face| face.reversed()).collect();
    let opening = if opened {
        faces.remove(faces.len() / 2).area()
    } else {
        0.0
    };
    let count = faces.len() as u32;
    if !opened {
        // It is lit, so that the sky is gathered at all faces.
        faces.push(floor_face());
    }
    let scene = under_sky("ball", faces, even_sky(2.0));
    let target = ErrorTarget {
        error: 0.05,
        texels: Some(1),
    };
    let solver = SolverChoice::Hierarchy(target);
    let settings = settings_of([1, 1, 1], Visibility::Rays, 1e-4);
    let solved = scene.solve_once(&settings, solver, &without_progress()).unwrap();
    let inside = solved.mesh.texels.iter().filter(|texel| texel.face < count);
    let received: f64 = inside.map(|texel| f64::from(texel.sky.x * texel.area)).sum();
    [received * solved.mesh.area_unit(), 2.0 * PI * opening]
}

/// Rays from a sky far away would pass between triangles if they were as coarse as its coordinates.
#[test]
fn closed_ball_is_dark_and_an_open_one_receives_what_its_opening_lets_in() {
    for rows in [4, 12] {
        assert_eq!(light_within_ball(rows, false), [0.0; 2], "{rows} rows");
        let [received, expected] = light_within_ball(rows, true);
        assert!(
            (received / expected - 1.0).abs() < 0.05,
            "{rows} rows: {received} for {expected}"
        );
    }
}
