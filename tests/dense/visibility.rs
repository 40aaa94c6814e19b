//! The dense solver's visibility against known cases: hidden, halved, and Lambert's sum past an edge.

use approx::abs_diff_eq;
use glam::DVec3;
use oracle::exact;
use radiosity_tests::dense::{assemble_dense, black_rectangle, facing_squares};
use radiosity_tests::named_scene;

#[test]
fn complete_occluder_leaves_exactly_zero() {
    let lid = black_rectangle("lid", [-0.1, -0.1, 0.4], [1.2, 0.0, 0.0], [0.0, 1.2, 0.0]);
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
    faces.push(black_rectangle(
        "left",
        [-0.1, -0.1, 0.4],
        [0.6, 0.0, 0.0],
        [0.0, 1.2, 0.0],
    ));
    faces.push(black_rectangle("right", [0.5, -0.1, 0.4], [0.6, 0.0, 0.0], [0.0, 1.2, 0.0]).reversed());
    let (_, matrix, _) = assemble_dense(&named_scene("two lids", faces), 1);
    assert!(matrix.weight(0, 1) < 1e-15, "{}", matrix.weight(0, 1));
}

#[test]
fn partition_leaves_two_halves() {
    let mut faces = facing_squares();
    let wall = black_rectangle("partition", [0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    faces.push(wall);
    let (_, matrix, quality) = assemble_dense(&named_scene("partition", faces), 1);
    let expected = exact::parallel_rectangles(0.5, 1.0, 1.0);
    let value = matrix.weight(0, 1);
    println!("partition {value} ({expected})");
    assert_eq!(quality.sampled_pairs, 1);
    // Converged to a thousandth of the unoccluded factor.
    assert!(
        abs_diff_eq!(value, expected, epsilon = 1e-3 * 0.1998248957),
        "{value} {expected}"
    );
}

#[test]
fn half_plane_matches_lambert_sum_past_its_edge() {
    for (height, edge) in [(0.5, 0.5), (0.2, 0.3), (0.8, 0.7)] {
        let mut faces = facing_squares();
        let corner = [edge, -9.0, height];
        faces.push(black_rectangle("half", corner, [9.0, 0.0, 0.0], [0.0, 19.0, 0.0]));
        let (_, matrix, _) = assemble_dense(&named_scene("half plane", faces.clone()), 1);
        // From x of the floor the ceiling shows up to where the line through the edge meets it.
        const N: usize = 64;
        let point = |k: usize| (k as f64 + 0.5) / N as f64;
        let mut expected = 0.0;
        for x in (0..N).map(point) {
            let end = (x + (edge - x) / height).clamp(0.0, 1.0);
            // Under the plate the part past the edge is visible, beside it all up to the edge's shadow.
            let seen = [[0.0, 0.0], [0.0, 1.0], [end, 1.0], [end, 0.0]];
            let seen = seen.map(|[x, y]| DVec3::new(x, y, 1.0));
            for y in (0..N).map(point) {
                let from = DVec3::new(x, y, 0.0);
                expected += exact::point_to_polygon(from, DVec3::Z, &seen) / (N * N) as f64;
            }
        }
        let value = matrix.weight(0, 1);
        println!("half plane at {height}, {edge}: {value} ({expected})");
        // Converged to a thousandth, and the midpoint rule's error at kinks: (1/64)²·4.
        assert!(
            abs_diff_eq!(value, expected, epsilon = 2e-3 * 0.1998248957),
            "{value} {expected}"
        );
    }
}

/// A plate just above the floor, and one just below the ceiling: sharp shadows from either end, so
/// that the estimate has to find an edge.
#[test]
fn sharp_shadow_edges_at_both_ends_are_resolved() {
    const GAP: f64 = 0.01;
    const EDGES: [f64; 2] = [0.3, 0.45];
    let mut faces = facing_squares();
    for (edge, height) in EDGES.into_iter().zip([GAP, 1.0 - GAP]) {
        let corner = [edge, -9.0, height];
        faces.push(black_rectangle("plate", corner, [9.0, 0.0, 0.0], [0.0, 19.0, 0.0]));
    }
    let (_, matrix, _) = assemble_dense(&named_scene("two plates", faces), 1);
    const N: usize = 1000;
    let point = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let mut expected = 0.0;
    for x in (0..N).map(|k| point(k, N)) {
        let end = EDGES
            .into_iter()
            .zip([GAP, 1.0 - GAP])
            .map(|(edge, height)| x + (edge - x) / height)
            .fold(1.0, f64::min);
        let seen = [[0.0, 0.0], [0.0, 1.0], [end, 1.0], [end, 0.0]];
        let seen = seen.map(|[x, y]| DVec3::new(x, y, 1.0));
        if end > 0.0 {
            for y in (0..16).map(|k| point(k, 16)) {
                let from = DVec3::new(x, y, 0.0);
                let n = (N * 16) as f64;
                expected += exact::point_to_polygon(from, DVec3::Z, &seen) / n;
            }
        }
    }
    let value = matrix.weight(0, 1);
    println!("two plates: {value} ({expected})");
    // The finest points are 1/32 apart: an edge is misplaced by half that at most.
    assert!(
        abs_diff_eq!(value / expected, 1.0, epsilon = 1.0 / 64.0 / EDGES[0]),
        "{value} {expected}"
    );
}

/// A plate hangs just below the ceiling and leaves a narrow strip of a texel free: the texel takes
/// the strip's light, though its centre sees almost only the plate's back.
#[test]
fn plate_just_below_ceiling_covers_nothing() {
    const GAP: f64 = 1e-3;
    const EDGE: f64 = 0.74;
    const N: u32 = 4;
    let mut faces = facing_squares();
    let corner = [-9.0, -9.0, 1.0 - GAP];
    let plate = black_rectangle("plate", corner, [0.0, 19.0, 0.0], [9.0 + EDGE, 0.0, 0.0]);
    faces.push(plate);
    let (mesh, matrix, _) = assemble_dense(&named_scene("a plate that hangs", faces), N);
    for (k, texel) in mesh.texels.iter().enumerate().filter(|(_, t)| t.face == 1) {
        assert_eq!(matrix.open[k], 1.0, "texel {}", texel.index);
        // The ceiling's j runs along x, its i along y.
        let (j, i) = (texel.index / N, texel.index % N);
        let value: f64 = (0..matrix.len())
            .filter(|from| mesh.texels[*from].face == 0)
            .map(|from| matrix.weight(k, from))
            .sum();
        let corner = [j, i].map(|n| f64::from(n) / f64::from(N));
        let expected = mean_factor_past_edge(EDGE, GAP, corner, 1.0 / f64::from(N));
        println!("texel {i}, {j}: {value} ({expected})");
        // Converged to a thousandth of the unoccluded factor, here below ¼.
        assert!(
            abs_diff_eq!(value, expected, epsilon = 1e-3 * 0.25),
            "{value} {expected}"
        );
    }
}

/// Mean factor from the ceiling's square at (x, y) to the floor past a plate that ends at `edge`,
/// `gap` below the ceiling.
fn mean_factor_past_edge(edge: f64, gap: f64, [x, y]: [f64; 2], side: f64) -> f64 {
    const N: usize = 200;
    const M: usize = 8;
    let mut sum = 0.0;
    for k in 0..N {
        let u = x + side * (k as f64 + 0.5) / N as f64;
        let start = (u + (edge - u) / gap).clamp(0.0, 1.0);
        let seen = [[start, 0.0], [1.0, 0.0], [1.0, 1.0], [start, 1.0]];
        let seen = seen.map(|[x, y]| DVec3::new(x, y, 0.0));
        for m in 0..M {
            let v = y + side * (m as f64 + 0.5) / M as f64;
            let from = DVec3::new(u, v, 1.0);
            sum += exact::point_to_polygon(from, DVec3::NEG_Z, &seen);
        }
    }
    sum / (N * M) as f64
}
