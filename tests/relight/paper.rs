//! Table 2 of the paper with its flaws mended one by one, and Fig. 7 by hand.

use common::form_factor::form_factor;
use common::relight::{MendedFlaws, RelightMethod, RoomRadiosity};
use common::scene::Face;
use common::settings::Visibility;
use cpu::CpuSolver;
use glam::{Vec3, Vec4};
use radiosity_tests::bounds::{U, assert_near};
use radiosity_tests::engines::{both_engines, settings_of, shared_gpu};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::named_scene;
use radiosity_tests::relighting::*;

#[test]
fn table_2_with_all_flaws_mended_equals_signed() {
    let objects = bottomless_box(Vec3::ZERO, Vec3::splat(0.7));
    let captured = FurnishedRoom::furnish(relight_settings(Visibility::Rays), objects, 1e-6);
    let truth = captured.full_solution(1e-6);
    let field_of = |method| {
        let mut engine = CpuSolver::new(&captured.mesh, &captured.settings.transport);
        captured.relight(&mut engine, method).run.field
    };
    let all = MendedFlaws {
        empty_room: true,
        object_shadows: true,
        bleeding: true,
        shadows: true,
    };
    let empty_room = MendedFlaws {
        empty_room: true,
        ..MendedFlaws::default()
    };
    let without_shadows = MendedFlaws { shadows: false, ..all };
    let steps = [MendedFlaws::default(), empty_room, without_shadows, all];
    let fields = steps.map(|mended| field_of(RelightMethod::Paper(mended)));
    assert_eq!(field_of(RelightMethod::Signed).radiosity, fields[3].radiosity);
    let errors = fields.map(|field| relative_error(&captured.mesh, &field, &truth));
    assert!(errors[0] > 0.02 && errors.is_sorted_by(|a, b| a > b), "{errors:?}");
}

/// Returns the largest relative rounding of a form factor on the GPU: none where the adapter does not fuse
/// multiplications and additions, else the bound of that stage, 32 ulp.
fn factor_rounding() -> f64 {
    if shared_gpu().line.software { 0.0 } else { 64.0 * U }
}

/// Fig. 7: a lit plate above a floor of the room and a floor of an object, with another object between. Case A: a
/// hidden texel of the object receives nothing. Case B: a hidden texel of the room loses its captured light ρB₀F.
#[test]
fn figure_7_cases_a_and_b_are_exact() {
    let plate = |name, low: f64, side: f64, y| {
        let corners = rectangle([low, y, low], [0.0, 0.0, side], [side, 0.0, 0.0]);
        Face::quad(name, corners, Vec3::ZERO, Vec3::splat(0.5))
    };
    let lamp = plate("i", 0.0, 1.0, 1.0).reversed();
    let floor = plate("c", 0.0, 1.0, 0.0);
    // The blocker between the plates hides all of the floor.
    let blocker = plate("a", -1.0, 3.0, 0.5);
    let below = plate("b", 0.0, 1.0, 0.25);
    let scene = named_scene("figure 7", vec![lamp, floor, blocker, below]);
    let (lit, captured) = (8.0f32, 3.0f32);
    for visibility in [Visibility::Rays, ITEM_BUFFER] {
        let settings = settings_of([1, 1, 1], visibility, 1e-4);
        let mesh = furnished_mesh(&scene, 2, &settings);
        let radiosity = [lit, captured, 0.0, 0.0].map(|b| Vec3::splat(b).extend(0.0));
        let room = RoomRadiosity {
            radiosity: radiosity.to_vec(),
            residual: vec![Vec4::ZERO; 4],
            reflectance: Some(vec![Vec3::splat(0.5); 4]),
        };
        let captured = FurnishedRoom { settings, mesh, room };
        let mesh = &captured.mesh;
        let engines = both_engines(mesh, &settings.transport);
        for (mut engine, rounding) in engines.into_iter().zip([0.0, factor_rounding()]) {
            let relit = captured.relight(engine.as_mut(), RelightMethod::Paper(MendedFlaws::default()));
            let (shooter, texel) = (&mesh.patches[0].shooter, &mesh.texels[1]);
            let kind = settings.transport.form_factor;
            let f = form_factor(kind, shooter, texel.position, mesh.faces[1].normal, texel.area);
            assert!(f > 0.2);
            // Case B: exactly ρB₀F; δ is that number, negative.
            let lost = 0.5 * (lit * f);
            assert_near(
                format!("{visibility:?}"),
                (-relit.change.radiosity[1].x).into(),
                lost.into(),
                rounding * f64::from(lost),
            );
            // Case A: no light from the lamp; the floor's own light is hidden from the back too.
            assert_eq!(relit.run.field.radiosity[3], Vec4::ZERO);
            assert_eq!(relit.run.field.irradiance[3].truncate(), Vec3::ZERO);
            // And the blocker's lit side is lit.
            assert!(relit.run.field.radiosity[2].x > 1.0);
        }
    }
}
