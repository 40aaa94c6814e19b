//! Sampled visibility against the dense solver, which shares neither form factors nor visibility with it. Every texel
//! shoots in both, so that they differ only by the error of the samples.

use common::scene::{Face, Scene};
use common::settings::Visibility;
use glam::{DVec3, Vec3};
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use radiosity_tests::engines::{mesh_scene, settings_of, shoot_on_cpu};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::solutions::{dense_truth_on, room_with_standing_box, slit_room};
use radiosity_tests::{box_faces, lit_room, named_scene};

/// Bound of the RMS error. 16 binary samples of a penumbra have an error of 16^(−3/4) = 12 %. A texel's light comes from
/// 64 patches of the lamp, a few of them partly visible, and from dozens of others: 12 %/√64, and a third more for
/// later reflections.
const RMS: f64 = 0.02;
/// Bound of the bias: samples are unbiased, and over thousands of texels their errors cancel to less than 0.3 %.
const BIAS: f64 = 0.003;
const WHITE: Vec3 = Vec3::new(0.7, 0.6, 0.5);

/// Makes a closed room with a lit ceiling and thin horizontal plates at heights y, given by their ranges of x and z.
fn room_with_plates(name: &str, plates: &[(f64, [f64; 4])]) -> Scene {
    let mut faces = box_faces(DVec3::ZERO, DVec3::ONE, true, Vec3::ZERO, WHITE);
    faces[1].emission = Vec3::splat(3.0);
    for (y, [x0, x1, z0, z1]) in plates {
        let corners = rectangle([*x0, *y, *z0], [0.0, 0.0, z1 - z0], [x1 - x0, 0.0, 0.0]);
        let up = Face::quad("plate", corners, Vec3::ZERO, WHITE);
        // Two quads back to back make a thin wall.
        faces.extend([up.reversed(), up]);
    }
    named_scene(name, faces)
}

fn shadowed_scenes() -> Vec<Scene> {
    let slat = |k: i32| (0.6, [0.2 * f64::from(k), 0.2 * f64::from(k) + 0.1, 0.0, 1.0]);
    let near = [(0.3, [0.2, 0.8, 0.2, 0.8]), (0.31, [0.25, 0.75, 0.25, 0.75])];
    vec![
        lit_room(),
        room_with_standing_box(),
        room_with_plates("blinds", &[0, 1, 2, 3, 4].map(slat)),
        slit_room(),
        room_with_plates("plates", &near),
    ]
}

#[test]
fn sampled_visibility_agrees_with_dense_solver() {
    for scene in shadowed_scenes() {
        let settings = settings_of([8, 8, 16], Visibility::Rays, 1e-4);
        let mesh = mesh_scene(&scene, &settings);
        let field = shoot_on_cpu(&mesh, &settings).field;
        let (dense_mesh, truth) = dense_truth_on(&scene, 8);
        let ours = ReflectedField::from_field(&scene, &mesh, &field);
        let theirs = ReflectedField::from_field(&scene, &dense_mesh, &truth);
        let (rms, bias) = GridPair::new(&ours, &theirs, None).unwrap().worst_channel();
        assert!(rms <= RMS, "{}: {rms}", scene.name);
        assert!(bias.abs() <= BIAS, "{}: {bias}", scene.name);
    }
}
