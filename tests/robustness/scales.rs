//! What must not matter: the unit of light, the unit of length, the origin, dark and degenerate
//! faces, and how finely each face is cut.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Schedule;
use common::shooting::{Field, Shoot, replay};
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use oracle::judge::exact;
use radiosity_tests::bounds::U;
use radiosity_tests::engines::{each_engine, free, mesh_of, settings};
use radiosity_tests::{furnace, lit_room};

fn scaled(scene: &Scene, factor: f32) -> Scene {
    let mut scene = scene.clone();
    scene
        .faces
        .iter_mut()
        .for_each(|face| face.emission *= factor);
    scene
}

/// Powers of two scale every number without rounding.
#[test]
fn brightness_by_powers_of_two_changes_no_shot() {
    let plain = lit_room();
    each_engine(&mesh_of(&plain), |name, fresh| {
        let run = free(&mut *fresh(), &settings().schedule);
        for factor in [(-20f32).exp2(), 20f32.exp2()] {
            each_engine(&mesh_of(&scaled(&plain, factor)), |other, fresh| {
                if other == name {
                    let scaled = free(&mut *fresh(), &settings().schedule);
                    assert_eq!(scaled.cells(), run.cells(), "{name}");
                    for (a, b) in scaled.field.radiosity.iter().zip(&run.field.radiosity) {
                        assert_eq!(*a, *b * factor, "{name}");
                    }
                }
            });
        }
    });
}

/// Other factors round E and all that follows: the choice is the same or one of equals.
#[test]
fn brightness_changes_no_shooter_but_among_equals() {
    let plain = lit_room();
    let meshes = [1.0, 1e-6, 1e6].map(|factor| mesh_of(&scaled(&plain, factor)));
    let [reference, small, large] = &meshes;
    let log = free(
        &mut CpuSolver::new(reference, &settings().transport),
        &settings().schedule,
    );
    for mesh in [small, large] {
        let own = free(
            &mut CpuSolver::new(mesh, &settings().transport),
            &settings().schedule,
        );
        assert_eq!(own.shots.len(), log.shots.len());
        let mut engine = CpuSolver::new(mesh, &settings().transport);
        for (k, cell) in log.cells().into_iter().enumerate() {
            let power = engine.cell_power().unwrap();
            let best = power.iter().copied().fold(0.0, f32::max);
            // A cell's power is the sum of what k shots left: k + 40 roundings.
            let bound = 1.0 - (k as f64 + 40.0) * U;
            assert!(
                f64::from(power[cell as usize]) >= bound * f64::from(best),
                "shot {k}"
            );
            engine.shoot(cell).unwrap();
        }
    }
}

fn moved(scene: &Scene, scale: f64, shift: DVec3) -> Scene {
    let mut scene = scene.clone();
    for face in &mut scene.faces {
        face.corners = face.corners.map(|p| p * scale + shift);
    }
    scene
}

fn same_bits(a: &Field, b: &Field) -> bool {
    a.radiosity == b.radiosity && a.residual == b.residual && a.irradiance == b.irradiance
}

/// lit_room has dyadic coordinates: powers of two and dyadic shifts are exact in f64.
#[test]
fn units_and_origin_change_no_bit() {
    let plain = lit_room();
    let run = |scene: &Scene| {
        let mesh = mesh_of(scene);
        free(
            &mut CpuSolver::new(&mesh, &settings().transport),
            &settings().schedule,
        )
    };
    let expected = run(&plain);
    let shift = DVec3::new(1024.0, -0.125, 4096.5);
    for scene in [
        moved(&plain, (-40f64).exp2(), DVec3::ZERO),
        moved(&plain, 40f64.exp2(), DVec3::ZERO),
        moved(&plain, 1.0, shift),
    ] {
        let run = run(&scene);
        assert_eq!(run.shots, expected.shots);
        assert!(same_bits(&run.field, &expected.field));
    }
}

/// Millimetres, and a place far from the origin: coordinates round differently.
#[test]
fn other_units_and_origins_change_only_rounding() {
    // At 1e6 from the origin f64 leaves 1e−10, less than f32's own rounding in the mesh. That moves
    // each texel and corner by √3·u, which near an edge (half a texel, h = ⅙ of 1/4, away) changes
    // F by √3·u/(h/2) of itself, here 100u, and B by that at each of a handful of reflections.
    const BOUND: f64 = 1000.0 * U;
    let plain = lit_room();
    let mesh = mesh_of(&plain);
    let expected = free(
        &mut CpuSolver::new(&mesh, &settings().transport),
        &settings().schedule,
    );
    for (scale, shift) in [
        (1000.0, DVec3::ZERO),
        (0.3, DVec3::splat(0.1)),
        (1.0, DVec3::new(1e6, 0.1, -3e5)),
    ] {
        let mesh = mesh_of(&moved(&plain, scale, shift));
        assert_eq!(mesh.unit.log2().fract(), 0.0, "the unit is a power of two");
        let mut engine = CpuSolver::new(&mesh, &settings().transport);
        let run = replay(&mut engine, &expected.cells()).unwrap();
        let pairs = run.field.radiosity.iter().zip(&expected.field.radiosity);
        let worst = pairs
            .map(|(a, b)| f64::from((a.x - b.x).abs() / b.x))
            .fold(0.0, f64::max);
        assert!(
            worst < BOUND,
            "scale {scale}, shift {shift}: {} u",
            worst / U
        );
    }
}

#[test]
fn a_dark_scene_is_done_before_it_starts() {
    let mesh = mesh_of(&scaled(&lit_room(), 0.0));
    each_engine(&mesh, |name, fresh| {
        let run = free(&mut *fresh(), &settings().schedule);
        assert!(run.shots.is_empty() && run.converged, "{name}");
        assert_eq!(run.unshot_fraction(), 0.0, "{name}");
        assert!(
            run.field.radiosity.iter().all(|b| *b == Vec4::ZERO),
            "{name}"
        );
    });
}

/// A point, a line and a folded quad among the faces, all of them bright.
#[test]
fn faces_without_area_do_no_harm() {
    let mut scene = lit_room();
    let (p, q) = (DVec3::new(2.0, 1.0, 3.0), DVec3::new(2.25, 1.0, 3.5));
    for corners in [[p; 4], [p, q, q, p], [p, q, p, q]] {
        scene
            .faces
            .push(Face::quad("flat", corners, Vec3::ONE, Vec3::splat(0.5)));
    }
    let mesh = mesh_of(&scene);
    each_engine(&mesh, |name, fresh| {
        let run = free(&mut *fresh(), &settings().schedule);
        assert!(run.converged, "{name}");
        let area = |cell: &u32| mesh.cells[*cell as usize].shooter.area;
        assert!(run.cells().iter().all(|cell| area(cell) > 0.0), "{name}");
        let mut engine = fresh();
        for cell in 0..mesh.cells.len() as u32 {
            let shot = engine.shoot(cell).unwrap();
            let finite = shot.form_factor_sum.is_finite()
                && shot.escaped.is_finite()
                && shot.unshot.is_finite();
            assert!(finite, "{name}: {shot:?}");
        }
        for field in [run.field, engine.field().unwrap()] {
            let all = field
                .radiosity
                .iter()
                .chain(&field.residual)
                .chain(&field.irradiance);
            assert!(all.into_iter().all(|v| v.is_finite()), "{name}");
        }
    });
}

/// In a furnace B = E/(1 − ρ) solves the discrete equations at any resolution: Lambert's factors
/// from a texel's centre to all cells around it sum to 1, wherever it is and however large they are.
#[test]
fn faces_may_differ_in_resolution() {
    const REFLECTANCE: f32 = 0.5;
    let resolutions: Vec<[u32; 2]> = (0..6).map(|k| [2 + k, 3 + 2 * k % 7]).collect();
    let mesh = Mesh::new(&furnace(REFLECTANCE), &resolutions, 2).unwrap();
    assert_eq!(
        mesh.texels.len() as u32,
        resolutions.iter().map(|[w, h]| w * h).sum::<u32>()
    );
    each_engine(&mesh, |name, fresh| {
        let run = free(
            &mut *fresh(),
            &Schedule {
                epsilon: 1e-4,
                ..settings().schedule
            },
        );
        assert!(run.converged, "{name}");
        // What is unshot will yet be reflected again and again; additions round by u each, F by 100u.
        let unshot = run
            .field
            .residual
            .iter()
            .map(|r| f64::from(r.x))
            .fold(0.0, f64::max);
        let later = f64::from(REFLECTANCE / (1.0 - REFLECTANCE)) * unshot;
        let rounding = 2.0 * U * (run.shots.len() as f64 + 100.0);
        for b in &run.field.radiosity {
            let missing = exact::furnace(1.0, f64::from(REFLECTANCE)) - f64::from(b.x);
            assert!(
                (-rounding..=later + rounding).contains(&missing),
                "{name}: {missing} of {later}"
            );
        }
    });
}
