//! The dense solver's visibility against known cases: hidden, halved, and Lambert's sum past an edge.

use common::scene::Face;
use glam::DVec3;
use oracle::exact;
use radiosity_tests::bounds::assert_near;
use radiosity_tests::dense::{assemble_dense, black_rectangle, facing_squares};
use radiosity_tests::named_scene;

#[test]
fn complete_occluder_leaves_exactly_zero() {
    let lid = black_rectangle([-0.1, -0.1, 0.4], [1.2, 0.0, 0.0], [0.0, 1.2, 0.0]);
    for lid in [lid.reversed(), lid] {
        let (_, matrix, quality) = assemble_dense(&named_scene("lid", [facing_squares(), vec![lid]].concat()), 3);
        for floor in 0..9 {
            for ceiling in 9..18 {
                assert_eq!(matrix.weight(floor, ceiling), 0.0);
            }
        }
        assert_eq!((quality.hidden_pairs, quality.sampled_pairs), (81, 0));
    }
    let mut faces = facing_squares();
    // Two halves: no single face hides, both together do.
    faces.push(black_rectangle([-0.1, -0.1, 0.4], [0.6, 0.0, 0.0], [0.0, 1.2, 0.0]));
    faces.push(black_rectangle([0.5, -0.1, 0.4], [0.6, 0.0, 0.0], [0.0, 1.2, 0.0]).reversed());
    let (_, matrix, _) = assemble_dense(&named_scene("two lids", faces), 1);
    assert!(matrix.weight(0, 1) < 1e-15, "{}", matrix.weight(0, 1));
}

#[test]
fn partition_leaves_two_halves() {
    let mut faces = facing_squares();
    let wall = black_rectangle([0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    faces.push(wall);
    let (_, matrix, quality) = assemble_dense(&named_scene("partition", faces), 1);
    let expected = exact::parallel_rectangles(0.5, 1.0, 1.0);
    let value = matrix.weight(0, 1);
    assert_eq!(quality.sampled_pairs, 1);
    // Converged to a thousandth of the unoccluded factor.
    assert_near("two halves", value, expected, 1e-3 * 0.1998248957);
}

/// Returns the mean over points of a square at `corner`, of this side, of the factor to the part of the unit square
/// at height `far` that plates leave: from x of the receiver they leave the x of `seen(x)`.
fn mean_factor_past_edges(
    [x, y, z]: [f64; 3],
    side: f64,
    far: f64,
    [columns, rows]: [usize; 2],
    seen: impl Fn(f64) -> [f64; 2],
) -> f64 {
    let point = |k: usize, count: usize| side * (k as f64 + 0.5) / count as f64;
    let mut sum = 0.0;
    for u in (0..columns).map(|k| x + point(k, columns)) {
        let [from, to] = seen(u);
        let mut outline = [[from, 0.0], [from, 1.0], [to, 1.0], [to, 0.0]].map(|[x, y]| DVec3::new(x, y, far));
        if far < z {
            outline.reverse();
        }
        for v in (0..rows).map(|k| y + point(k, rows)) {
            let normal = DVec3::Z * (far - z).signum();
            sum += exact::point_to_polygon(DVec3::new(u, v, z), normal, &outline);
        }
    }
    sum / (columns * rows) as f64
}

/// Makes a plate at `height` over x > `edge`, which hides all behind it.
fn plate_beyond(edge: f64, height: f64) -> Face {
    black_rectangle([edge, -9.0, height], [9.0, 0.0, 0.0], [0.0, 19.0, 0.0])
}

/// Edges and heights of plates, numbers of points, and the bound of the relative error. The last has a plate just above the
/// floor and one just below the ceiling: sharp shadows from either end, so that the estimate has to find an edge.
#[test]
fn factor_past_plates_matches_lambert_sum_past_their_edges() {
    // Converged to a thousandth of the unoccluded factor, and the midpoint rule's error at kinks: (1/64)²·4. The finest
    // points are 1/32 apart: an edge is misplaced by half that at most.
    let (smooth, sharp) = (2e-3 * 0.1998248957, 1.0 / 64.0 / 0.3);
    for (plates, points, bound, is_relative) in [
        (&[[0.5, 0.5]][..], [64, 64], smooth, false),
        (&[[0.3, 0.2]], [64, 64], smooth, false),
        (&[[0.7, 0.8]], [64, 64], smooth, false),
        (&[[0.3, 0.01], [0.45, 0.99]], [1000, 16], sharp, true),
    ] {
        let mut faces = facing_squares();
        faces.extend(plates.iter().map(|[edge, height]| plate_beyond(*edge, *height)));
        let (_, matrix, _) = assemble_dense(&named_scene("plates", faces), 1);
        // From x of the floor the ceiling shows up to where the lines through the edges meet it.
        let seen = |x: f64| {
            let ends = plates.iter().map(|[edge, height]| x + (edge - x) / height);
            [0.0, ends.fold(1.0, f64::min).max(0.0)]
        };
        let expected = mean_factor_past_edges([0.0; 3], 1.0, 1.0, points, seen);
        let bound = if is_relative { bound * expected } else { bound };
        assert_near(format_args!("{plates:?}"), matrix.weight(0, 1), expected, bound);
    }
}

/// A plate hangs just below the ceiling and leaves a narrow strip of a texel free: the texel takes
/// the strip's light, though its centre sees almost only the plate's back.
#[test]
fn plate_just_below_ceiling_covers_nothing() {
    const GAP: f64 = 1e-3;
    const EDGE: f64 = 0.74;
    const N: u32 = 4;
    let corner = [-9.0, -9.0, 1.0 - GAP];
    let plate = black_rectangle(corner, [0.0, 19.0, 0.0], [9.0 + EDGE, 0.0, 0.0]);
    let faces = [facing_squares(), vec![plate]].concat();
    let (mesh, matrix, _) = assemble_dense(&named_scene("a plate that hangs", faces), N);
    for (k, texel) in mesh.texels.iter().enumerate().filter(|(_, t)| t.face == 1) {
        assert_eq!(matrix.open[k], 1.0, "texel {}", texel.index);
        let floor = (0..matrix.len()).filter(|from| mesh.texels[*from].face == 0);
        let value: f64 = floor.map(|from| matrix.weight(k, from)).sum();
        // The ceiling's j runs along x, its i along y.
        let side = 1.0 / f64::from(N);
        let [x, y] = [texel.index / N, texel.index % N].map(|n| f64::from(n) * side);
        let seen = |x: f64| [(x + (EDGE - x) / GAP).clamp(0.0, 1.0), 1.0];
        let expected = mean_factor_past_edges([x, y, 1.0], side, 0.0, [200, 8], seen);
        // Converged to a thousandth of the unoccluded factor, here below ¼.
        assert_near(texel.index, value, expected, 1e-3 * 0.25);
    }
}
