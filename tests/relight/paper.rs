//! Table 2 of the paper with its flaws mended one by one, and Fig. 7 by hand.

use common::form_factor::form_factor;
use common::relight::{MendedFlaws, RelightMethod, RoomRadiosity};
use common::scene::Face;
use common::settings::{Meshing, Schedule, Settings, Visibility};
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use radiosity_tests::engines::open_gpu;
use radiosity_tests::named_scene;
use radiosity_tests::relighting::*;

#[test]
fn table_2_with_all_flaws_mended_equals_signed() {
    let settings = relight_settings(Visibility::Rays);
    let (scene, count) = furnished_room(bottomless_box(Vec3::ZERO, Vec3::splat(0.7)));
    let mesh = furnished_mesh(&scene, count, &settings);
    let room = capture_room(&scene, &mesh, &settings, 1e-6);
    let truth = full_solution(
        &mesh,
        &settings.transport,
        &Schedule {
            epsilon: 1e-6,
            ..settings.schedule
        },
    );
    let of = |method| {
        run_relight(
            &mut CpuSolver::new(&mesh, &settings.transport),
            &mesh,
            &room,
            method,
            &settings.schedule,
        )
    };
    let all = MendedFlaws {
        empty_room: true,
        object_shadows: true,
        bleeding: true,
        shadows: true,
    };
    let (signed, mended) = (of(RelightMethod::Signed), of(RelightMethod::Paper(all)));
    assert_eq!(signed.run.field.radiosity, mended.run.field.radiosity);
    let error_of = |mended| relative_error(&mesh, &of(RelightMethod::Paper(mended)).run.field, &truth);
    let steps = [
        MendedFlaws::default(),
        MendedFlaws {
            empty_room: true,
            ..MendedFlaws::default()
        },
        MendedFlaws { shadows: false, ..all },
        all,
    ];
    let errors = steps.map(error_of);
    println!(
        "printed {:.3}, empty room {:.3}, without shadows shot on {:.3}, all {:.5}",
        errors[0], errors[1], errors[2], errors[3]
    );
    assert!(errors[0] > 0.02 && errors.is_sorted_by(|a, b| a > b), "{errors:?}");
}

/// Fig. 7: a lit plate above a floor of the room and a floor of an object, with another object between. Case A: a
/// hidden texel of the object receives nothing. Case B: a hidden texel of the room loses its captured light ρB₀F.
#[test]
fn figure_7_cases_a_and_b_are_exact() {
    let quad = |name, low: [f64; 2], high: [f64; 2], y, up: bool| {
        let p = |x, z| DVec3::new(x, y, z);
        let face = Face::quad(
            name,
            [
                p(low[0], low[1]),
                p(low[0], high[1]),
                p(high[0], high[1]),
                p(high[0], low[1]),
            ],
            Vec3::ZERO,
            Vec3::splat(0.5),
        );
        if up { face } else { face.reversed() }
    };
    let lamp = quad("i", [0.0, 0.0], [1.0, 1.0], 1.0, false);
    let floor = quad("c", [0.0, 0.0], [1.0, 1.0], 0.0, true);
    // The blocker between the plates hides all of the floor.
    let blocker = quad("a", [-1.0, -1.0], [2.0, 2.0], 0.5, true);
    let below = quad("b", [0.0, 0.0], [1.0, 1.0], 0.25, true);
    let scene = named_scene("figure 7", vec![lamp, floor, blocker, below]);
    let gpu = open_gpu();
    for visibility in [Visibility::Rays, ITEM_BUFFER] {
        let settings = Settings {
            meshing: Meshing {
                texels: 1,
                patches: 1,
                samples: 1,
            },
            ..relight_settings(visibility)
        };
        let mesh = furnished_mesh(&scene, 2, &settings);
        let (lit, captured) = (8.0f32, 3.0f32);
        let mut radiosity = vec![Vec4::ZERO; 4];
        radiosity[0] = Vec4::new(lit, lit, lit, 0.0);
        radiosity[1] = Vec4::new(captured, captured, captured, 0.0);
        let room = RoomRadiosity {
            radiosity,
            residual: vec![Vec4::ZERO; 4],
            reflectance: Some(vec![Vec3::splat(0.5); 4]),
        };
        for make in [&cpu_engine as &EngineMaker, &gpu_engine(&gpu)] {
            let mut engine = make(&mesh, &settings.transport);
            let paper = RelightMethod::Paper(MendedFlaws::default());
            let relit = run_relight(engine.as_mut(), &mesh, &room, paper, &settings.schedule);
            let (floor, texel) = (&mesh.patches[0].shooter, &mesh.texels[1]);
            let f = form_factor(
                settings.transport.form_factor,
                floor,
                texel.position,
                mesh.faces[1].normal,
                texel.area,
            );
            assert!(f > 0.2);
            // Case B: exactly ρB₀F; δ is that number, negative.
            assert_eq!(relit.change.radiosity[1].x, -(0.5 * (lit * f)), "{visibility:?}");
            // Case A: no light from the lamp; the floor's own light is hidden from the back too.
            assert_eq!(relit.run.field.radiosity[3], Vec4::ZERO);
            assert_eq!(relit.run.field.irradiance[3].truncate(), Vec3::ZERO);
            // And the blocker's lit side is lit.
            assert!(relit.run.field.radiosity[2].x > 1.0);
        }
    }
}
