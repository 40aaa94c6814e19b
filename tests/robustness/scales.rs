//! Invariance of solutions under the unit of light, the origin, dark and degenerate faces, and the resolution of each
//! face.

use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::{Face, Scene};
use common::settings::Visibility;
use common::shooting::RadiosityField;
use glam::{DVec3, Vec3, Vec4};
use oracle::exact;
use radiosity_tests::bounds::U;
use radiosity_tests::engines::{
    ENGINE_KINDS, each_engine, engine_settings, mesh_of, mesh_scene, settings_of, shoot_freely, shoot_on_cpu,
};
use radiosity_tests::{furnace, halve_quads, lit_room, named_scene};

fn with_brightness(scene: &Scene, factor: f32) -> Scene {
    let mut scene = scene.clone();
    scene.faces.iter_mut().for_each(|face| face.emission *= factor);
    scene
}

/// Powers of two scale every number without rounding.
#[test]
fn power_of_two_brightness_keeps_shots_and_scales_radiosity() {
    let plain = lit_room();
    let settings = engine_settings();
    let meshes = [1.0, (-20f32).exp2(), 20f32.exp2()].map(|factor| (factor, mesh_of(&with_brightness(&plain, factor))));
    for kind in ENGINE_KINDS {
        let runs = meshes.each_ref().map(|(factor, mesh)| {
            let run = shoot_freely(&mut *kind.fresh_engine(mesh, &settings, &[]), &settings.schedule);
            (*factor, run)
        });
        let expected = &runs[0].1;
        for (factor, run) in &runs[1..] {
            assert_eq!(run.shooter_log(), expected.shooter_log(), "{}", kind.name);
            for (a, b) in run.field.radiosity.iter().zip(&expected.field.radiosity) {
                assert_eq!(*a, *b * *factor, "{}", kind.name);
            }
        }
    }
}

/// lit_room has dyadic coordinates: dyadic shifts are exact in f64, and so are units that are powers of two.
#[test]
fn dyadic_shift_and_power_of_two_unit_keep_every_bit() {
    let expected = shoot_on_cpu(&mesh_of(&lit_room()), &engine_settings());
    for scale in [1.0, (-40f64).exp2(), 39f64.exp2()] {
        let mut moved = lit_room();
        for face in &mut moved.faces {
            face.corners = face.corners.map(|p| (p + DVec3::new(1024.0, -0.125, 4096.5)) * scale);
        }
        let run = shoot_on_cpu(&mesh_of(&moved), &engine_settings());
        assert_eq!(run.shots, expected.shots, "{scale:e}");
        assert_eq!(run.field, expected.field, "{scale:e}");
    }
}

#[test]
fn dark_scene_converges_without_a_shot() {
    let mesh = mesh_of(&with_brightness(&lit_room(), 0.0));
    each_engine(&mesh, |name, fresh| {
        let run = shoot_freely(&mut *fresh(), &engine_settings().schedule);
        assert!(run.shots.is_empty() && run.converged, "{name}");
        assert_eq!(run.unshot_fraction(), 0.0, "{name}");
        assert!(run.field.radiosity.iter().all(|b| *b == Vec4::ZERO), "{name}");
    });
}

fn assert_finite(name: &str, field: &RadiosityField) {
    let all = field.radiosity.iter().chain(&field.residual).chain(&field.irradiance);
    assert!(all.into_iter().all(|v| v.is_finite()), "{name}");
}

/// Shoots until ε, and then from every patch once.
fn shoot_everything(name: &str, mesh: &Mesh, engine: &mut dyn Engine) {
    let run = shoot_freely(engine, &engine_settings().schedule);
    assert!(run.converged, "{name}");
    let area = |patch: u32| mesh.patches[patch as usize].shooter.area;
    assert!(run.shooter_log().iter().all(|patch| area(*patch) > 0.0), "{name}");
    assert_finite(name, &run.field);
    for patch in 0..mesh.patches.len() as u32 {
        let shot = engine.shoot(patch).unwrap();
        let finite = shot.form_factor_sum.is_finite() && shot.escaped.is_finite() && shot.unshot.is_finite();
        assert!(finite, "{name}: {shot:?}");
    }
    assert_finite(name, &engine.read_field().unwrap());
}

/// A point, a line and a folded quad, all of them bright: in the lit room and alone; and faces that see nothing.
#[test]
fn faces_without_area_shoot_nothing_and_give_no_nan() {
    let quad = |corners: [DVec3; 4]| Face::quad("flat", corners, Vec3::ONE, Vec3::splat(0.5));
    let (p, q) = (DVec3::new(2.0, 1.0, 3.0), DVec3::new(2.25, 1.0, 3.5));
    let [point, line, folded] = [[p; 4], [p, q, q, p], [p, q, p, q]].map(quad);
    let square = quad([p, p + DVec3::X, p + DVec3::X + DVec3::Y, p + DVec3::Y]);
    let straight = quad([p, p + DVec3::X, p + DVec3::X, p]);
    for faces in [vec![], vec![point.clone()]] {
        assert!(Mesh::uniform(&named_scene("nothing", faces), 4, 1).is_err());
    }
    let furnished = [lit_room().faces, vec![point, line, folded]].concat();
    for faces in [
        furnished,
        vec![straight.clone()],
        vec![straight; 3],
        vec![square.clone()],
        vec![square; 2],
    ] {
        let alone = faces.len() <= 3;
        let counts = if alone { [3, 2, 2] } else { [6, 2, 1] };
        let settings = settings_of(counts, Visibility::Rays, 1e-3);
        let mesh = mesh_scene(&named_scene("next to nothing", faces), &settings);
        each_engine(&mesh, |name, fresh| {
            let mut engine = fresh();
            shoot_everything(name, &mesh, &mut *engine);
            let field = engine.read_field().unwrap();
            let dark = field.irradiance.iter().all(|h| h.truncate() == Vec3::ZERO);
            assert!(dark == alone, "{name}");
        });
    }
}

/// In a furnace B = E/(1 − ρ) solves the discrete equations at any resolution: Lambert's factors
/// from a texel's centre to all patches around it sum to 1, wherever it is and however large they are.
#[test]
fn furnace_is_exact_with_faces_of_different_resolution() {
    const REFLECTANCE: f32 = 0.5;
    let quads = furnace(REFLECTANCE);
    let of_quads = (0..6).map(|k| [2 + k, 3 + 2 * k % 7]).collect();
    let of_triangles = (0..12).map(|k| [2 + k % 5; 2]).collect();
    let triangles = halve_quads(&quads);
    for (scene, resolutions) in [(quads, of_quads), (triangles, of_triangles)] {
        let resolutions: Vec<[u32; 2]> = resolutions;
        let mesh = Mesh::new(&scene, &resolutions, 2).unwrap();
        let quad_texels = resolutions.iter().map(|[w, h]| (w * h) as usize).sum::<usize>();
        assert_eq!(mesh.texels.len(), quad_texels, "{}", scene.name);
        let mut schedule = engine_settings().schedule;
        schedule.epsilon = 1e-4;
        each_engine(&mesh, |name, fresh| {
            let run = shoot_freely(&mut *fresh(), &schedule);
            assert!(run.converged, "{name}");
            // Unshot power would be reflected again and again; additions round by u each, F by 100u.
            let unshot = run.field.residual.iter().map(|r| f64::from(r.x)).fold(0.0, f64::max);
            let later = f64::from(REFLECTANCE / (1.0 - REFLECTANCE)) * unshot;
            let rounding = 2.0 * U * (run.shots.len() as f64 + 100.0);
            for b in &run.field.radiosity {
                let missing = exact::furnace_radiosity(1.0, f64::from(REFLECTANCE)) - f64::from(b.x);
                assert!(
                    (-rounding..=later + rounding).contains(&missing),
                    "{} {name}: {missing} of {later}",
                    scene.name
                );
            }
        });
    }
}
