//! Numerical stability: contact, small angles, slivers, twelve decades of light, degenerate faces.

use approx::abs_diff_eq;
use common::cover;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::passes;
use common::passes::Engine;
use common::precision::find_shape_losses;
use common::scene::{Face, Scene};
use common::settings::{Iteration, Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{RadiosityField, Shoot, Shot};
use cpu::CpuSolver;
use glam::{DQuat, DVec3, EulerRot, Vec3};
use gpu::GpuSolver;
use oracle::exact;
use proptest::prelude::*;
use radiosity_tests::bounds::{energy_rounding, polygon_rounding};
use radiosity_tests::engines::{item_buffer, open_gpu, shoot_freely};
use radiosity_tests::{lit_room, named_scene, random_cases};
use std::ops::ControlFlow;

fn grey_quad(corners: [DVec3; 4]) -> Face {
    Face::quad("", corners, Vec3::ONE, Vec3::splat(0.5))
}

/// Makes unit squares at this distance, fronts facing, rotated so that no coordinate is exact.
fn facing_squares(gap: f64) -> Scene {
    let p = |x: f64, y: f64, z: f64| turn_point(DVec3::new(x, y, z));
    let low = [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(0.0, 1.0, 0.0)];
    let high = [p(0.0, 0.0, gap), p(0.0, 1.0, gap), p(1.0, 1.0, gap), p(1.0, 0.0, gap)];
    named_scene("facing", vec![grey_quad(low), grey_quad(high)])
}

/// Makes unit squares that share an edge, fronts facing.
fn hinged_squares(degrees: f64) -> Scene {
    let (s, c) = degrees.to_radians().sin_cos();
    let p = |x: f64, y: f64, z: f64| turn_point(DVec3::new(x, y, z));
    let low = [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(0.0, 1.0, 0.0)];
    let high = [p(0.0, 0.0, 0.0), p(0.0, 1.0, 0.0), p(c, 1.0, s), p(c, 0.0, s)];
    named_scene("hinge", vec![grey_quad(low), grey_quad(high)])
}

fn turn_point(p: DVec3) -> DVec3 {
    DQuat::from_euler(EulerRot::XYZ, 0.7123, -1.1931, 2.0177) * p + DVec3::new(0.31, -0.7, 0.2)
}

/// Compares Lambert's formula in f32, on both engines, with the exact factor near contact and in corners.
#[test]
fn links_equal_lambert_factor_near_contact() {
    let gpu = open_gpu();
    let scenes = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5].map(facing_squares);
    let hinges = [90.0, 45.0, 10.0, 3.0, 1.0].map(hinged_squares);
    for (n, scene) in scenes.iter().chain(&hinges).enumerate() {
        let settings = Settings {
            meshing: Meshing {
                texels: 8,
                patches: 2,
                ..Meshing::default()
            },
            ..Settings::default()
        };
        let mesh = Mesh::uniform(scene, 8, 2).unwrap();
        let mut cpu = CpuSolver::new(&mesh, &settings.transport);
        let mut device = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
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
                    assert!(
                        abs_diff_eq!(f, expected, epsilon = bound),
                        "scene {n}: {f} {expected} {bound:e}"
                    );
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
    let floor = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
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
            let mut cpu = CpuSolver::new(&mesh, &Settings::default().transport);
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
            println!("{width:.1e} {is_triangle}: off by {error:.1e}, told {told}");
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

/// Thirteen emitters, each ten times as bright as the one before.
#[test]
fn emission_over_twelve_decades_balances_on_both_engines() {
    let mut scene = lit_room();
    for (k, face) in scene.faces.iter_mut().enumerate() {
        face.emission = Vec3::splat(10f32.powi(k as i32 - 6));
    }
    let settings = Settings {
        meshing: Meshing {
            texels: 6,
            patches: 2,
            samples: 2,
        },
        schedule: Schedule {
            epsilon: 1e-4,
            ..Schedule::default()
        },
        ..Settings::default()
    };
    let mesh = cover::sampled_mesh(&scene, &settings.meshing).unwrap();
    let cpu = shoot_freely(&mut CpuSolver::new(&mesh, &settings.transport), &settings.schedule);
    let device = shoot_freely(
        &mut GpuSolver::new(&open_gpu(), &mesh, &settings.transport).unwrap(),
        &settings.schedule,
    );
    for run in [&cpu, &device] {
        assert!(run.converged);
        assert_finite_and_at_least(&run.field, 0.0);
        assert_balanced(&mesh, &run.field, &run.shots);
    }
    for (a, b) in cpu.field.radiosity.iter().zip(&device.field.radiosity) {
        // Some hundred shots of a few roundings each.
        assert!((*a - *b).abs().max_element() <= 1e-4 * b.max_element(), "{a} {b}");
    }
}

#[test]
fn degenerate_scenes_converge_without_panic() {
    let p = DVec3::new(0.25, 0.5, 0.75);
    let line = [p, p + DVec3::X, p + DVec3::X, p];
    let square = [p, p + DVec3::X, p + DVec3::X + DVec3::Y, p + DVec3::Y];
    assert!(Mesh::uniform(&named_scene("empty", vec![]), 4, 1).is_err());
    assert!(Mesh::uniform(&named_scene("a point", vec![grey_quad([p; 4])]), 4, 1).is_err());
    let gpu = open_gpu();
    for faces in [
        vec![grey_quad(line)],
        vec![grey_quad(line); 3],
        vec![grey_quad(square)],
        vec![grey_quad(square); 2],
    ] {
        let scene = named_scene("next to nothing", faces);
        for visibility in [Visibility::Rays, item_buffer(64)] {
            let settings = Settings {
                meshing: Meshing {
                    texels: 3,
                    patches: 2,
                    samples: 2,
                },
                transport: Transport {
                    visibility,
                    ..Transport::default()
                },
                ..Settings::default()
            };
            let mesh = cover::sampled_mesh(&scene, &settings.meshing).unwrap();
            for engine in [
                &mut CpuSolver::new(&mesh, &settings.transport) as &mut dyn Engine,
                &mut GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap(),
            ] {
                let run = shoot_freely(engine, &settings.schedule);
                assert!(run.converged);
                assert_finite_and_at_least(&run.field, 0.0);
                assert!(run.field.irradiance.iter().all(|h| h.truncate() == Vec3::ZERO));
                assert_balanced(&mesh, &run.field, &run.shots);
            }
        }
    }
}

/// Draws faces with corners on a coarse lattice: points, lines, copies, faces that cross, touch and enclose others.
fn any_rubble() -> impl Strategy<Value = Scene> {
    let corner = || prop::array::uniform3(-2i32..=2).prop_map(|p| DVec3::from(p.map(f64::from)));
    let face = (corner(), corner(), corner(), any::<bool>(), -6i32..=6).prop_map(|(a, b, c, whole, e)| {
        let emission = Vec3::splat(10f32.powi(e));
        let grey = Vec3::new(0.0, 0.5, 0.95);
        if whole {
            Face::quad("", [a, b, b + c - a, c], emission, grey)
        } else {
            Face::triangle("", [a, b, c], emission, grey)
        }
    });
    prop::collection::vec(face, 2..14).prop_map(|faces| named_scene("rubble", faces))
}

proptest! {
    #![proptest_config(random_cases(192))]
    #[test]
    fn random_rubble_is_solved_without_panic(scene in any_rubble(), samples in 1u32..4, patches in 1u32..4, iteration in 0usize..2) {
        let settings = Settings { meshing: Meshing { texels: 4, patches, samples }, schedule: Schedule { max_shots: 64, iteration: [Iteration::Southwell, Iteration::Cg][iteration], ..Schedule::default() }, ..Settings::default() };
        let Ok(mesh) = cover::sampled_mesh(&scene, &settings.meshing) else {
            return Ok(());
        };
        let mut engine = CpuSolver::new(&mesh, &settings.transport);
        let run = passes::solve_by_schedule(&mut engine, &mesh, &settings.schedule, &mut |_| ControlFlow::Continue(())).unwrap();
        // Conjugate directions may overshoot before they converge.
        assert_finite_and_at_least(&run.field, if iteration == 0 { 0.0 } else { f32::MIN });
        if iteration == 0 {
            assert_balanced(&mesh, &run.field, &run.shots);
        }
    }
}
