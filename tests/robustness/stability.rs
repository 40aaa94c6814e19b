//! Numerical stability: contact, small angles, slivers, twelve decades of light, degenerate faces.

use common::cover;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::precision::find_shape_losses;
use common::scene::{Face, Scene};
use common::settings::{Iteration, Transport, Visibility};
use common::shooting::{RadiosityField, Shoot, Shot};
use cpu::CpuSolver;
use glam::{DQuat, DVec3, EulerRot, Vec3};
use oracle::exact;
use proptest::prelude::*;
use radiosity_tests::bounds::{assert_near, energy_rounding, polygon_rounding};
use radiosity_tests::engines::{gpu_solver, settings_of, solve_by_schedule};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::{any_lattice_face, named_scene, random_cases};

fn grey_quad(corners: [DVec3; 4]) -> Face {
    Face::quad("", corners, Vec3::ONE, Vec3::splat(0.5))
}

/// Makes a unit square and another one, rotated so that no coordinate is exact.
fn turned_squares(other: [DVec3; 4]) -> Scene {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.7123, -1.1931, 2.0177);
    let floor = rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let faces = [floor, other].map(|corners| grey_quad(corners.map(|p| turn * p + DVec3::new(0.31, -0.7, 0.2))));
    named_scene("turned", faces.into())
}

/// Makes unit squares at this distance, fronts facing.
fn facing_squares(gap: f64) -> Scene {
    turned_squares(rectangle([0.0, 0.0, gap], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]))
}

/// Makes unit squares that share an edge, fronts facing.
fn hinged_squares(degrees: f64) -> Scene {
    let (s, c) = degrees.to_radians().sin_cos();
    turned_squares(rectangle([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s]))
}

/// Compares Lambert's formula in f32, on both engines, with the exact factor near contact and in corners.
#[test]
fn links_equal_lambert_factor_near_contact() {
    let scenes = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5].map(facing_squares);
    let hinges = [90.0, 45.0, 10.0, 3.0, 1.0].map(hinged_squares);
    for (n, scene) in scenes.iter().chain(&hinges).enumerate() {
        let mesh = Mesh::uniform(scene, 8, 2).unwrap();
        let mut cpu = CpuSolver::new(&mesh, &Transport::default());
        let mut device = gpu_solver(&mesh, &Transport::default(), &[]);
        let (mut worst, mut allowed) = (0.0f64, 0.0f64);
        for patch in 0..mesh.patches.len() as u32 {
            device.shoot(patch).unwrap();
            let seen = device.read_irradiance().unwrap();
            let links = cpu.link_row(patch).unwrap().links.to_vec();
            let outline = mesh.patches[patch as usize].shooter.corners.map(|c| c.as_dvec3());
            for (k, texel) in mesh.texels.iter().enumerate() {
                if texel.face == mesh.patches[patch as usize].face {
                    assert_eq!((links[k], seen[k].w), (0.0, 0.0));
                    continue;
                }
                let (p, normal) = (texel.position.as_dvec3(), mesh.faces[texel.face as usize].normal);
                let expected = exact::point_to_polygon(p, normal.as_dvec3(), &outline);
                let bound = polygon_rounding(p, &outline);
                for f in [links[k], seen[k].w].map(f64::from) {
                    assert_near(format_args!("scene {n}"), f, expected, bound);
                    worst = worst.max((f - expected).abs());
                    allowed = allowed.max(bound);
                }
            }
        }
        println!("scene {n}: off by {worst:.1e} ({allowed:.1e})");
    }
}

/// The light of a sliver is accurate to 2 %, or the loss of its shape is reported.
#[test]
fn slivers_are_accurate_or_reported() {
    let floor = rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    for exponent in 0..=16 {
        let width = 10f64.powf(-0.5 * f64::from(exponent));
        for is_triangle in [false, true] {
            let (from, along) = (DVec3::new(0.12, 0.07, 0.4), DVec3::new(0.71, 0.83, 0.13));
            let across = along.cross(DVec3::Z).normalize() * -width * along.length();
            let c = [from, from + across, from + along + across, from + along];
            let sliver = if is_triangle {
                Face::triangle("", [c[0], c[1], c[3]], Vec3::ONE, Vec3::ZERO)
            } else {
                grey_quad(c)
            };
            let scene = named_scene("sliver", vec![grey_quad(floor), sliver]);
            let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
            let mut cpu = CpuSolver::new(&mesh, &Transport::default());
            let outline: Vec<DVec3> = scene.faces[1].outline().iter().map(|p| mesh.local_point(*p)).collect();
            let (mut sum, mut expected) = (0.0, 0.0);
            let links = cpu.link_row(1).unwrap().links.to_vec();
            for (k, texel) in mesh.texels.iter().enumerate().filter(|(_, t)| t.face == 0) {
                let normal = mesh.faces[0].normal.as_dvec3();
                sum += f64::from(links[k]);
                expected += exact::point_to_polygon(texel.position.as_dvec3(), normal, &outline);
            }
            let error = (sum / expected - 1.0).abs();
            let told = find_shape_losses(&scene, &mesh, 0.02).iter().any(|loss| loss.face == 1);
            assert!(sum.is_finite() && (error < 0.02 || told), "{width:e}: {error}");
            assert!(!told || width < 1e-4, "{width:e} is no sliver");
        }
    }
}

fn assert_finite_and_at_least(field: &RadiosityField, least: f32) {
    for v in field.radiosity.iter().chain(&field.irradiance).chain(&field.residual) {
        assert!(v.is_finite() && v.truncate().min_element() >= least, "{v}");
    }
}

fn assert_balanced(mesh: &Mesh, field: &RadiosityField, shots: &[Shot]) {
    let energy = EnergyBalance::new(mesh, field, shots);
    let bound = energy_rounding(&energy, mesh.area_unit(), shots);
    assert!(energy.imbalance <= bound, "{} {bound}", energy.imbalance);
}

/// Draws faces with corners on a coarse lattice: points, lines, copies, faces that cross, touch and enclose others.
fn any_rubble() -> impl Strategy<Value = Scene> {
    let face = (-6i32..=6).prop_flat_map(|e| {
        let emission = Vec3::splat(10f32.powi(e));
        any_lattice_face(2, 0.0, emission, Vec3::new(0.0, 0.5, 0.95))
    });
    prop::collection::vec(face, 2..14).prop_map(|faces| named_scene("rubble", faces))
}

proptest! {
    #![proptest_config(random_cases(192))]
    #[test]
    fn random_rubble_is_solved_without_panic(
        scene in any_rubble(),
        samples in 1u32..4,
        patches in 1u32..4,
        single: bool,
    ) {
        let mut settings = settings_of([4, patches, samples], Visibility::Rays, 1e-3);
        settings.schedule.max_shots = 64;
        settings.schedule.iteration = if single { Iteration::Southwell } else { Iteration::Cg };
        let Ok(mesh) = cover::sampled_mesh(&scene, &settings.meshing) else {
            return Ok(());
        };
        let mut engine = CpuSolver::new(&mesh, &settings.transport);
        let run = solve_by_schedule(&mut engine, &mesh, &settings.schedule);
        // Conjugate directions may overshoot before they converge.
        assert_finite_and_at_least(&run.field, if single { 0.0 } else { f32::MIN });
        if single {
            assert_balanced(&mesh, &run.field, &run.shots);
        }
    }
}
