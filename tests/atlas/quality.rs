//! Sampled visibility against the dense solver, which shares neither form factors nor visibility with it. Every texel
//! shoots in both, so that they differ only by the error of the samples.

use common::cover::sampled_mesh;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::{Meshing, Schedule, Settings};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use radiosity_tests::dense::assemble_dense;
use radiosity_tests::engines::shoot_freely;
use radiosity_tests::{box_faces, lit_room, named_scene};

/// Bound of the RMS error. 16 binary samples of a penumbra have an error of 16^(−3/4) = 12 %. A texel's light comes from
/// 64 patches of the lamp, a few of them partly visible, and from dozens of others: 12 %/√64, and a third more for
/// later reflections.
const RMS: f64 = 0.02;
/// Bound of the bias: samples are unbiased, and over thousands of texels their errors cancel to less than 0.3 %.
const BIAS: f64 = 0.003;
const WHITE: Vec3 = Vec3::new(0.7, 0.6, 0.5);

/// Makes a closed room with a lit ceiling and thin horizontal faces at heights y, given by their ranges of x and z.
fn room_with_sheets(name: &str, faces: &[(f64, [f64; 4])]) -> Scene {
    let mut all = box_faces(DVec3::ZERO, DVec3::ONE, true, Vec3::ZERO, WHITE);
    all[1].emission = Vec3::splat(3.0);
    for (y, [x0, x1, z0, z1]) in faces {
        let p = |x, z| DVec3::new(x, *y, z);
        let up = Face::quad(
            "hung",
            [p(*x0, *z0), p(*x0, *z1), p(*x1, *z1), p(*x1, *z0)],
            Vec3::ZERO,
            WHITE,
        );
        // Two quads back to back make a thin wall.
        all.push(up.reversed());
        all.push(up);
    }
    named_scene(name, all)
}

fn shadowed_scenes() -> Vec<Scene> {
    let slats: Vec<(f64, [f64; 4])> = (0..5)
        .map(|k| (0.6, [0.2 * f64::from(k), 0.2 * f64::from(k) + 0.1, 0.0, 1.0]))
        .collect();
    let mut standing = lit_room();
    standing.name = "a box on the floor".into();
    for face in &mut standing.faces[6..] {
        for corner in &mut face.corners {
            corner.y -= 0.25;
        }
    }
    vec![
        lit_room(),
        standing,
        room_with_sheets("blinds", &slats),
        room_with_sheets("a slit", &[(0.5, [0.0, 0.45, 0.0, 1.0]), (0.5, [0.55, 1.0, 0.0, 1.0])]),
        room_with_sheets(
            "plates",
            &[(0.3, [0.2, 0.8, 0.2, 0.8]), (0.31, [0.25, 0.75, 0.25, 0.75])],
        ),
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

/// Solves a scene by the dense solver on N×N texels a face.
fn dense_radiosity(scene: &Scene, texels: u32) -> (Mesh, Vec<DVec3>) {
    let (mesh, matrix, _) = assemble_dense(scene, texels);
    let emission: Vec<DVec3> = mesh.texels.iter().map(|t| t.emission.as_dvec3()).collect();
    let reflectance: Vec<DVec3> = mesh.texels.iter().map(|t| t.reflectance.as_dvec3()).collect();
    let radiosity = matrix.solve(&emission, &reflectance).unwrap().radiosity;
    (mesh, radiosity)
}

#[test]
fn sampled_visibility_agrees_with_dense_solver() {
    for scene in shadowed_scenes() {
        let settings = Settings {
            meshing: Meshing {
                texels: 8,
                patches: 8,
                samples: 16,
            },
            schedule: Schedule {
                epsilon: 1e-4,
                ..Schedule::default()
            },
            ..Settings::default()
        };
        let mesh = sampled_mesh(&scene, &settings.meshing).unwrap();
        let run = shoot_freely(&mut CpuSolver::new(&mesh, &settings.transport), &settings.schedule);
        let (_, truth) = dense_radiosity(&scene, 8);
        // The texels of `mesh` are ordered by patches, those of the dense solver face by face.
        let at = |k: usize| mesh.texels[k].face as usize * 64 + mesh.texels[k].index as usize;
        let b = |k: usize| run.field.radiosity[k].truncate().as_dvec3();
        let (rms, bias) = rms_and_bias(&mesh, b, |k| truth[at(k)]);
        println!("{}: RMS {:.2} %, bias {:.2} %", scene.name, 100.0 * rms, 100.0 * bias);
        assert!(rms <= RMS, "{}: {rms}", scene.name);
        assert!(bias <= BIAS, "{}: {bias}", scene.name);
    }
}
