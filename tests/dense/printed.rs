//! The dense solver against printed interchange factors, computed by View3D (Walton, *Calculation of
//! obstructed view factors by adaptive integration*, NISTIR 6925, 2002): rooms that are not convex,
//! walls that stand partly in front of each other, as quads and as triangles.
//!
//! 𝓕 is the share of the black-body emission of surface i that j absorbs; all surfaces have emissivity 0.9 and
//! uniform radiosity:
//!
//! ```text
//! 𝓕_ij = ε H_i    B = ε e_j + (1 − ε) F B    H = F B
//! ```

use common::scene::{Face, Scene};
use cpu::dense::Matrix;
use glam::{DVec3, Vec3};
use radiosity_tests::bounds::assert_near;
use radiosity_tests::dense::assemble_dense;
use radiosity_tests::{halve_quads, named_scene};
use serde_json::Value;

const EMISSIVITY: f64 = 0.9;
/// Tolerance for the L-shaped room: View3D stops at an estimated error of 10⁻⁴.
const CONVERGED: f64 = 1e-4;
/// Tolerance for the irregular room, where the two differ by 4.1·10⁻³ at most (RMS 6.9·10⁻⁴), for quads and triangles and
/// for any number of texels: View3D's error at partly hidden walls exceeds its estimate of 10⁻⁴.
const STOPPED: f64 = 5e-3;

/// Rooms by their corners, and the factors that View3D prints. A face has four corners, counted from 1, and belongs to
/// a surface.
///
/// Pueltz's irregular room has sloping plans, a step in the floor and a niche; its table is 𝓕, row after row. The
/// L-shaped room is Pinney and Bean's test 4; its table is A𝓕 up to the diagonal.
const ROOMS: &str = include_str!("view3d.json");

/// Returns a room, and its printed factors.
fn read_room(name: &str) -> (Scene, Vec<Vec<f64>>) {
    let mut rooms: Value = serde_json::from_str(ROOMS).unwrap();
    let [corners, faces, printed] = ["corners", "faces", "printed"].map(|field| rooms[name][field].take());
    let corners: Vec<[f64; 3]> = serde_json::from_value(corners).unwrap();
    let faces: Vec<([usize; 4], usize)> = serde_json::from_value(faces).unwrap();
    let face = |(outline, surface): ([usize; 4], usize)| {
        let outline = outline.map(|k| DVec3::from(corners[k - 1]));
        Face::quad(&surface.to_string(), outline, Vec3::ZERO, Vec3::ZERO)
    };
    let scene = named_scene(name, faces.into_iter().map(face).collect());
    (scene, serde_json::from_value(printed).unwrap())
}

/// Returns areas and 𝓕 of the `n` surfaces of a scene, with `texels` per side of each face.
fn interchange_factors(scene: &Scene, n: usize, texels: u32) -> (Vec<f64>, Vec<Vec<f64>>) {
    let (mesh, matrix, _) = assemble_dense(scene, texels);
    let surface = |k: usize| -> usize { scene.faces[mesh.texels[k].face as usize].name.parse().unwrap() };
    let area = |k: usize| f64::from(mesh.texels[k].area) * mesh.area_unit();
    let (mut areas, mut exchange) = (vec![0.0; n], vec![0.0; n * n]);
    for j in 0..mesh.texels.len() {
        areas[surface(j)] += area(j);
        for i in 0..mesh.texels.len() {
            exchange[surface(j) * n + surface(i)] += area(j) * matrix.weight(j, i);
        }
    }
    let whole = Matrix::from_weights(areas.clone(), |j, i| exchange[j * n + i] / areas[j]);
    let whole = whole.unwrap();
    let reflectance = vec![DVec3::splat(1.0 - EMISSIVITY); n];
    let absorbed = |j: usize| {
        let mut emission = vec![DVec3::ZERO; n];
        emission[j] = DVec3::splat(EMISSIVITY);
        let answer = whole.solve(&emission, &reflectance).unwrap();
        answer.irradiance.iter().map(|h| EMISSIVITY * h.x).collect()
    };
    (areas, (0..n).map(absorbed).collect())
}

/// Compares 𝓕_ij with the printed table, or A_i 𝓕_ij if that is what it has, for quads and for triangles.
fn assert_printed_factors(name: &str, texels: u32, times_area: bool, most: f64) {
    let (scene, printed) = read_room(name);
    assert!(printed.iter().flatten().count() >= 36, "{name}");
    for (shape, scene) in [("quads", &scene), ("triangles", &halve_quads(&scene))] {
        let (areas, factors) = interchange_factors(scene, printed.len(), texels);
        for (i, row) in printed.iter().enumerate() {
            let scale = if times_area { areas[i] } else { 1.0 };
            for (j, printed) in row.iter().enumerate() {
                let ours = scale * factors[j][i];
                assert!(ours > 0.0, "{name}, {shape}");
                assert_near(format_args!("{name}, {shape}"), ours, *printed, most);
            }
        }
    }
}

#[test]
fn irregular_room_matches_view3d() {
    assert_printed_factors("irregular room", 2, false, STOPPED);
}

#[test]
fn l_shaped_room_matches_view3d() {
    assert_printed_factors("L-shaped room", 4, true, CONVERGED);
}
