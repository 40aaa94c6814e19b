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

use approx::abs_diff_eq;
use common::scene::{Face, Scene};
use cpu::dense::Matrix;
use glam::{DVec3, Vec3};
use radiosity_tests::dense::assemble_dense;
use radiosity_tests::{halve_quads, named_scene};

const EMISSIVITY: f64 = 0.9;
/// Tolerance for the L-shaped room: View3D stops at an estimated error of 10⁻⁴.
const CONVERGED: f64 = 1e-4;
/// Tolerance for the irregular room, where the two differ by 4.1·10⁻³ at most (RMS 6.9·10⁻⁴), for quads and triangles and
/// for any number of texels: View3D's error at partly hidden walls exceeds its estimate of 10⁻⁴.
const STOPPED: f64 = 5e-3;

/// A room by its corners, and its faces: four corners each, counted from 1, and their surface.
struct Room {
    name: &'static str,
    corners: &'static [[f64; 3]],
    faces: &'static [([usize; 4], usize)],
    surfaces: usize,
}

/// Pueltz's irregular room: sloping plans, a step in the floor, a niche.
const IRREGULAR: Room = Room {
    name: "irregular room",
    corners: &[
        [0.0, 0.0, 0.0],
        [22.0, 0.0, 0.0],
        [15.0, 45.0, 0.0],
        [33.0, 48.0, 0.0],
        [33.0, 67.0, 0.0],
        [33.0, 67.0, 5.0],
        [33.0, 153.0, 5.0],
        [8.0, 153.0, 5.0],
        [8.0, 175.0, 5.0],
        [-22.0, 175.0, 5.0],
        [-22.0, 153.0, 5.0],
        [-22.0, 67.0, 5.0],
        [0.0, 67.0, 5.0],
        [0.0, 67.0, 0.0],
        [0.0, 0.0, 22.0],
        [22.0, 0.0, 22.0],
        [15.0, 45.0, 22.0],
        [21.0, 46.0, 22.0],
        [27.0, 47.0, 22.0],
        [33.0, 48.0, 22.0],
        [33.0, 105.0, 22.0],
        [27.0, 105.0, 22.0],
        [21.0, 105.0, 22.0],
        [15.0, 105.0, 22.0],
        [0.0, 105.0, 22.0],
        [-19.0, 105.0, 22.0],
        [33.0, 153.0, 22.0],
        [8.0, 153.0, 22.0],
        [8.0, 175.0, 22.0],
        [-22.0, 175.0, 22.0],
        [-22.0, 153.0, 22.0],
        [-22.0, 105.0, 22.0],
        [-22.0, 67.0, 22.0],
        [-19.0, 67.0, 22.0],
        [0.0, 67.0, 22.0],
        [33.0, 48.0, 5.0],
    ],
    faces: &[
        ([1, 2, 3, 14], 0),
        ([3, 4, 5, 14], 0),
        ([5, 6, 13, 14], 1),
        ([6, 7, 11, 12], 2),
        ([8, 9, 10, 11], 2),
        ([15, 35, 17, 16], 3),
        ([17, 35, 25, 24], 3),
        ([17, 24, 23, 18], 3),
        ([19, 22, 21, 20], 3),
        ([34, 33, 32, 26], 3),
        ([35, 34, 26, 25], 4),
        ([18, 23, 22, 19], 4),
        ([21, 32, 31, 27], 5),
        ([28, 31, 30, 29], 5),
        ([2, 16, 17, 3], 6),
        ([4, 3, 17, 20], 7),
        ([36, 20, 27, 7], 8),
        ([4, 36, 6, 5], 8),
        ([8, 28, 29, 9], 9),
        ([1, 15, 16, 2], 10),
        ([1, 14, 35, 15], 11),
        ([13, 12, 33, 35], 12),
        ([12, 10, 30, 33], 13),
        ([7, 27, 28, 8], 14),
        ([9, 29, 30, 10], 15),
    ],
    surfaces: 16,
};

/// 𝓕 of the irregular room, row after row.
const PRINTED: [[f64; 16]; 16] = [
    [
        0.018172, 0.036336, 0.013551, 0.270637, 0.032861, 0.003987, 0.134525, 0.051777, 0.062412, 0.000063, 0.062358,
        0.208599, 0.000725, 0.003108, 0.000630, 0.000258,
    ],
    [
        0.337268, 0.002679, 0.009174, 0.111217, 0.018033, 0.002593, 0.017305, 0.118918, 0.108382, 0.000041, 0.017454,
        0.153409, 0.000429, 0.002178, 0.000722, 0.000196,
    ],
    [
        0.003850, 0.000281, 0.039999, 0.125680, 0.092916, 0.322876, 0.001669, 0.004977, 0.094457, 0.019226, 0.000960,
        0.006704, 0.021376, 0.113667, 0.024615, 0.026746,
    ],
    [
        0.162637, 0.007201, 0.265808, 0.017817, 0.005146, 0.013112, 0.082042, 0.029389, 0.093675, 0.000815, 0.038445,
        0.132119, 0.011326, 0.035528, 0.003002, 0.001939,
    ],
    [
        0.046903, 0.002773, 0.466745, 0.012222, 0.008839, 0.023243, 0.001893, 0.028092, 0.094153, 0.001874, 0.000803,
        0.013968, 0.068347, 0.122040, 0.004418, 0.003689,
    ],
    [
        0.001851, 0.000130, 0.527364, 0.010126, 0.007557, 0.028369, 0.000310, 0.002445, 0.086286, 0.030841, 0.000451,
        0.001564, 0.004843, 0.117782, 0.037821, 0.042260,
    ],
    [
        0.205633, 0.002850, 0.008981, 0.208687, 0.002027, 0.001021, 0.016967, 0.002794, 0.006215, 0.000037, 0.116752,
        0.325090, 0.000322, 0.002173, 0.000195, 0.000258,
    ],
    [
        0.197520, 0.048875, 0.066825, 0.186560, 0.075081, 0.020094, 0.006973, 0.003752, 0.169393, 0.000397, 0.003026,
        0.079081, 0.001322, 0.026033, 0.009249, 0.005819,
    ],
    [
        0.050842, 0.009512, 0.270811, 0.126984, 0.053737, 0.151460, 0.003312, 0.036173, 0.009465, 0.001492, 0.001558,
        0.048914, 0.009601, 0.081728, 0.039211, 0.005199,
    ],
    [
        0.000257, 0.000018, 0.277079, 0.005554, 0.005375, 0.272125, 0.000099, 0.000427, 0.007502, 0.004482, 0.000146,
        0.000397, 0.003539, 0.158347, 0.002197, 0.162455,
    ],
    [
        0.197316, 0.005950, 0.010690, 0.202431, 0.001780, 0.003078, 0.241684, 0.002510, 0.006053, 0.000113, 0.007316,
        0.213702, 0.000319, 0.001482, 0.002680, 0.002896,
    ],
    [
        0.216736, 0.017173, 0.024516, 0.228429, 0.010168, 0.003502, 0.220970, 0.021539, 0.062387, 0.000101, 0.070171,
        0.019806, 0.000508, 0.002071, 0.001681, 0.000243,
    ],
    [
        0.002971, 0.000189, 0.308069, 0.077177, 0.196086, 0.042735, 0.000862, 0.001419, 0.048262, 0.003539, 0.000413,
        0.002003, 0.003382, 0.186773, 0.012885, 0.013236,
    ],
    [
        0.002592, 0.000196, 0.333696, 0.049315, 0.071323, 0.211700, 0.001186, 0.005692, 0.083686, 0.032256, 0.000391,
        0.001663, 0.038046, 0.011425, 0.012003, 0.044829,
    ],
    [
        0.002270, 0.000280, 0.312171, 0.018000, 0.011155, 0.293666, 0.000459, 0.008737, 0.173449, 0.001934, 0.003052,
        0.005829, 0.011338, 0.051854, 0.003057, 0.002750,
    ],
    [
        0.000774, 0.000063, 0.282672, 0.009688, 0.007762, 0.273446, 0.000507, 0.004580, 0.019166, 0.119134, 0.002749,
        0.000702, 0.009707, 0.161385, 0.002292, 0.005372,
    ],
];

/// The L-shaped room of Pinney and Bean's test 4.
const CORNER: Room = Room {
    name: "L-shaped room",
    corners: &[
        [0.0, 3.0, 3.0],
        [1.0, 3.0, 3.0],
        [0.0, 3.0, 0.0],
        [1.0, 3.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [3.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [3.0, 0.0, 0.0],
        [0.0, 0.0, 3.0],
        [1.0, 0.0, 3.0],
        [3.0, 0.0, 3.0],
        [0.0, 1.0, 3.0],
        [1.0, 1.0, 3.0],
        [3.0, 1.0, 3.0],
    ],
    faces: &[
        ([11, 13, 10, 8], 0),
        ([10, 13, 16, 7], 1),
        ([6, 7, 16, 15], 2),
        ([4, 6, 15, 2], 3),
        ([3, 4, 2, 1], 4),
        ([8, 3, 1, 11], 5),
        ([11, 14, 15, 12], 6),
        ([8, 9, 6, 5], 7),
        ([1, 2, 15, 14], 6),
        ([15, 16, 13, 12], 6),
        ([5, 6, 4, 3], 7),
        ([9, 10, 7, 6], 7),
    ],
    surfaces: 8,
};

/// A𝓕 of the L-shaped room, up to the diagonal.
const PRINTED_CORNER: [&[f64]; 8] = [
    &[0.2711825],
    &[0.8931738, 0.02881335],
    &[2.828227, 0.8196874, 0.1512733],
    &[0.2932999, 0.02230434, 0.03695820, 0.1512733],
    &[0.2768928, 0.01114731, 0.02230434, 0.8196874, 0.02881335],
    &[1.431202, 0.2768927, 0.2932999, 2.828227, 0.8931738, 0.2711825],
    &[
        1.053011, 0.3239905, 0.6241250, 0.6241250, 0.3239905, 1.053011, 0.05466339,
    ],
    &[
        1.053011, 0.3239905, 0.6241250, 0.6241250, 0.3239905, 1.053011, 0.4430834, 0.05466339,
    ],
];

impl Room {
    fn scene(&self) -> Scene {
        let face = |(corners, surface): &([usize; 4], usize)| {
            let corners = corners.map(|k| DVec3::from(self.corners[k - 1]));
            Face::quad(&surface.to_string(), corners, Vec3::ZERO, Vec3::ZERO)
        };
        named_scene(self.name, self.faces.iter().map(face).collect())
    }

    /// Returns areas and 𝓕 of the surfaces, with `texels` per side of each face.
    fn interchange_factors(&self, scene: &Scene, texels: u32) -> (Vec<f64>, Vec<Vec<f64>>) {
        let n = self.surfaces;
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
}

/// Prints the greatest and the RMS difference; the greatest may be `most`.
fn assert_all_close(name: &str, pairs: &[[f64; 2]], most: f64) {
    assert!(pairs.iter().all(|[ours, _]| *ours > 0.0));
    let off = |[a, b]: &[f64; 2]| (a - b).abs();
    let greatest = pairs.iter().map(off).fold(0.0, f64::max);
    let rms = (pairs.iter().map(|p| off(p) * off(p)).sum::<f64>() / pairs.len() as f64).sqrt();
    println!("{name}: off by {greatest:.1e} at most, RMS {rms:.1e}");
    for [ours, printed] in pairs {
        assert!(
            abs_diff_eq!(*ours, *printed, epsilon = most),
            "{name}: {ours} {printed}"
        );
    }
}

#[test]
fn irregular_room_matches_view3d() {
    let quads = IRREGULAR.scene();
    for (name, scene) in [("quads", &quads), ("triangles", &halve_quads(&quads))] {
        let (_, factors) = IRREGULAR.interchange_factors(scene, 4);
        let pair = |i: usize, j: usize| [factors[j][i], PRINTED[i][j]];
        let pairs: Vec<_> = (0..256).map(|k| pair(k / 16, k % 16)).collect();
        assert_all_close(&format!("irregular room, {name}"), &pairs, STOPPED);
    }
}

#[test]
fn l_shaped_room_matches_view3d() {
    let quads = CORNER.scene();
    for (name, scene) in [("quads", &quads), ("triangles", &halve_quads(&quads))] {
        let (areas, factors) = CORNER.interchange_factors(scene, 4);
        let mut pairs = Vec::new();
        for (i, row) in PRINTED_CORNER.iter().enumerate() {
            for (j, printed) in row.iter().enumerate() {
                pairs.push([areas[i] * factors[j][i], *printed]);
            }
        }
        assert_eq!(pairs.len(), 36);
        assert_all_close(&format!("L-shaped room, {name}"), &pairs, CONVERGED);
    }
}
