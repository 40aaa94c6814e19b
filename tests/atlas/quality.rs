//! Sampled visibility against the dense solver, which shares neither form factors nor visibility with it. Every texel
//! shoots in both, so that they differ only by the error of the samples.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Visibility;
use glam::{DVec3, Vec3};
use radiosity_tests::dense::{assemble_dense, solve_matrix};
use radiosity_tests::engines::{mesh_scene, settings_of, shoot_on_cpu};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::solutions::{room_with_standing_box, slit_room};
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

/// Returns area-weighted relative RMS and bias of B − E, the worst channel of each.
fn rms_and_bias(mesh: &Mesh, b: impl Fn(usize) -> DVec3, truth: impl Fn(usize) -> DVec3) -> (f64, f64) {
    let (mut square, mut scale, mut sum, mut all) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let (area, truth) = (f64::from(texel.area), truth(k));
        let reflected = truth - texel.emission.as_dvec3();
        square += (b(k) - truth).powf(2.0) * area;
        scale += reflected.powf(2.0) * area;
        sum += (b(k) - truth) * area;
        all += reflected * area;
    }
    let rms = (square / scale).max_element().sqrt();
    (rms, (sum / all).abs().max_element())
}

#[test]
fn sampled_visibility_agrees_with_dense_solver() {
    for scene in shadowed_scenes() {
        let settings = settings_of([8, 8, 16], Visibility::Rays, 1e-4);
        let mesh = mesh_scene(&scene, &settings);
        let run = shoot_on_cpu(&mesh, &settings);
        let (dense_mesh, matrix, _) = assemble_dense(&scene, 8);
        let truth = solve_matrix(&dense_mesh, &matrix).radiosity;
        // The texels of `mesh` are ordered by patches, those of the dense solver face by face.
        let at = |k: usize| mesh.texels[k].face as usize * 64 + mesh.texels[k].index as usize;
        let b = |k: usize| run.field.radiosity[k].truncate().as_dvec3();
        let (rms, bias) = rms_and_bias(&mesh, b, |k| truth[at(k)]);
        assert!(rms <= RMS, "{}: {rms}", scene.name);
        assert!(bias <= BIAS, "{}: {bias}", scene.name);
    }
}
