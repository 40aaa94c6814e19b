//! The matrix solver against what is known exactly: enclosures, hidden pairs, covered texels, and
//! the shooting solver on the same form factors.

use common::energy::Energy;
use common::form_factor::form_factor;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::shooting::{Field, solve};
use cpu::CpuSolver;
use cpu::matrix::{Answer, Matrix, Quality, ledger};
use cpu::rays::Rays;
use glam::{DVec3, Vec3, Vec4};
use oracle::exact;
use radiosity_tests::{box_in_room, furnace, lit_room, room, scene};
use std::ops::ControlFlow;

fn assemble(scene: &Scene, texels: u32) -> (Mesh, Matrix, Quality) {
    let mesh = Mesh::uniform(scene, texels, 1).unwrap();
    let (matrix, quality) =
        Matrix::assemble(scene, &mesh, &mut |_, _| ControlFlow::Continue(())).unwrap();
    println!("{}, {} texels: {quality:?}", scene.name, matrix.len());
    (mesh, matrix, quality)
}

fn answer(mesh: &Mesh, matrix: &Matrix) -> Answer {
    let emission = values(mesh, |texel| texel.emission);
    let reflectance = values(mesh, |texel| texel.reflectance);
    let answer = matrix.solve(&emission, &reflectance).unwrap();
    assert!(answer.residual < 1e-12, "{}", answer.residual);
    answer
}

fn values(mesh: &Mesh, of: impl Fn(&common::mesh::Texel) -> Vec3) -> Vec<DVec3> {
    mesh.texels
        .iter()
        .map(|texel| of(texel).as_dvec3())
        .collect()
}

/// The balance as `solve` reports it.
fn energy(mesh: &Mesh, matrix: &Matrix, answer: &Answer) -> Energy {
    let single = |v: &[DVec3]| v.iter().map(|x| x.as_vec3().extend(0.0)).collect();
    let field = Field {
        origin: "matrix".into(),
        radiosity: single(&answer.radiosity),
        residual: vec![Vec4::ZERO; mesh.texels.len()],
        irradiance: single(&answer.irradiance),
    };
    let emission = values(mesh, |texel| texel.emission);
    Energy::new(
        mesh,
        &field,
        &ledger::shots(mesh, matrix, &emission, answer),
    )
}

fn square(name: &str, corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Face {
    let [c, u, v] = [corner, u, v].map(DVec3::from);
    Face::quad(name, [c, c + u, c + u + v, c + v], Vec3::ZERO, Vec3::ZERO)
}

/// Unit floor, and the unit ceiling at height 1 above it.
fn facing() -> Vec<Face> {
    vec![
        square("floor", [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        square("ceiling", [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
    ]
}

#[test]
fn the_cube_solved_by_hand() {
    for reflectance in [0.5f32, 0.7, 0.9] {
        let mut cube = furnace(reflectance);
        for face in &mut cube.faces {
            face.emission = if face.name == "ceiling" {
                Vec3::ONE
            } else {
                Vec3::ZERO
            };
        }
        let (mesh, matrix, _) = assemble(&cube, 1);
        let answer = answer(&mesh, &matrix);
        let [top, bottom, side] = exact::cube(f64::from(reflectance));
        for (face, b) in cube.faces.iter().zip(&answer.radiosity) {
            let expected = match face.name.as_str() {
                "ceiling" => top,
                "floor" => bottom,
                _ => side,
            };
            println!(
                "ρ {reflectance} {}: {:.10} ({expected:.10})",
                face.name, b.x
            );
            // ΣF within 1e−8, amplified by 1/(1−ρ) twice.
            assert!(
                (b.x - expected).abs() < 1e-6,
                "{} {b} {expected}",
                face.name
            );
        }
    }
}

/// A room of general quads and triangles: a prism over a trapezium with a slanted roof.
fn slanted() -> Scene {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let floor = [
        p(0.0, 0.0, 0.0),
        p(3.0, 0.0, 0.0),
        p(2.0, 1.5, 0.0),
        p(0.5, 1.0, 0.0),
    ];
    let roof = floor.map(|q| p(q.x, q.y, 1.0 + 0.2 * q.x - 0.1 * q.y));
    let mut faces = vec![Face::quad("floor", floor, Vec3::ONE, Vec3::splat(0.5))];
    let [a, b, c, d] = roof;
    faces.push(Face::triangle(
        "roof",
        [a, c, b],
        Vec3::ONE,
        Vec3::splat(0.5),
    ));
    faces.push(Face::triangle(
        "roof",
        [a, d, c],
        Vec3::ONE,
        Vec3::splat(0.5),
    ));
    for k in 0..4 {
        let n = (k + 1) % 4;
        let wall = [floor[n], floor[k], roof[k], roof[n]];
        faces.push(Face::quad("wall", wall, Vec3::ONE, Vec3::splat(0.5)));
    }
    scene("slanted", faces)
}

/// A slab a thousandth as high as it is wide: every texel of the floor nearly touches one above.
fn slab() -> Scene {
    let size = DVec3::new(1.0, 1e-3, 1.0);
    scene(
        "slab",
        room(DVec3::ZERO, size, true, Vec3::ONE, Vec3::splat(0.5)),
    )
}

#[test]
fn rows_of_closed_convex_rooms_sum_to_one_and_the_furnace_is_even() {
    for (scene, texels) in [
        (furnace(0.5), 1),
        (furnace(0.5), 8),
        (slanted(), 1),
        (slanted(), 6),
        (slab(), 5),
    ] {
        let (mesh, matrix, quality) = assemble(&scene, texels);
        let worst = matrix
            .sums()
            .iter()
            .map(|s| (s - 1.0).abs())
            .fold(0.0, f64::max);
        println!("rows off by {worst:.1e}");
        assert!(worst <= 1e-7, "{}: {worst}", scene.name);
        assert!(
            quality.closure_max <= 1e-7 && quality.sampled_pairs == 0,
            "{quality:?}"
        );
        assert!(quality.reciprocity <= 1e-7, "{quality:?}");
        let answer = answer(&mesh, &matrix);
        for b in &answer.radiosity {
            assert!(
                (b.x - exact::furnace(1.0, 0.5)).abs() <= 1e-6,
                "{}: {b}",
                scene.name
            );
        }
        assert!(energy(&mesh, &matrix, &answer).imbalance < 1e-6);
    }
}

#[test]
fn a_whole_blocker_leaves_exactly_nothing() {
    let lid = square("lid", [-0.1, -0.1, 0.4], [1.2, 0.0, 0.0], [0.0, 1.2, 0.0]);
    for lid in [lid.reversed(), lid] {
        let (_, matrix, quality) = assemble(&scene("lid", [facing(), vec![lid]].concat()), 3);
        for floor in 0..9 {
            for ceiling in 9..18 {
                assert_eq!(matrix.weight(floor, ceiling), 0.0);
            }
        }
        assert_eq!((quality.hidden_pairs, quality.sampled_pairs), (81, 0));
    }
    let mut faces = facing();
    // Two halves: no single face hides, both together do.
    faces.push(square(
        "left",
        [-0.1, -0.1, 0.4],
        [0.6, 0.0, 0.0],
        [0.0, 1.2, 0.0],
    ));
    faces.push(square("right", [0.5, -0.1, 0.4], [0.6, 0.0, 0.0], [0.0, 1.2, 0.0]).reversed());
    let (_, matrix, _) = assemble(&scene("two lids", faces), 1);
    assert!(matrix.weight(0, 1) < 1e-15, "{}", matrix.weight(0, 1));
}

#[test]
fn a_partition_leaves_the_two_halves() {
    let mut faces = facing();
    let wall = square(
        "partition",
        [0.5, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    );
    faces.push(wall);
    let (_, matrix, quality) = assemble(&scene("partition", faces), 1);
    let expected = exact::parallel_rectangles(0.5, 1.0, 1.0);
    let value = matrix.weight(0, 1);
    println!("partition {value} ({expected})");
    assert_eq!(quality.sampled_pairs, 1);
    // Settled to a thousandth of what nothing would hide.
    assert!(
        (value - expected).abs() < 1e-3 * 0.1998248957,
        "{value} {expected}"
    );
}

#[test]
fn a_half_plane_leaves_what_lambert_sees_past_it() {
    for (height, edge) in [(0.5, 0.5), (0.2, 0.3), (0.8, 0.7)] {
        let mut faces = facing();
        let corner = [edge, -9.0, height];
        faces.push(square("half", corner, [9.0, 0.0, 0.0], [0.0, 19.0, 0.0]));
        let (_, matrix, _) = assemble(&scene("half plane", faces.clone()), 1);
        // From x of the floor the ceiling shows up to where the line through the edge meets it.
        const N: usize = 64;
        let point = |k: usize| (k as f64 + 0.5) / N as f64;
        let mut expected = 0.0;
        for x in (0..N).map(point) {
            let end = (x + (edge - x) / height).clamp(0.0, 1.0);
            // Under the plate only what the edge uncovers shows, beside it all up to the edge's shadow.
            let seen = [[0.0, 0.0], [0.0, 1.0], [end, 1.0], [end, 0.0]];
            let seen = seen.map(|[x, y]| DVec3::new(x, y, 1.0));
            for y in (0..N).map(point) {
                let from = DVec3::new(x, y, 0.0);
                expected += exact::point_to_polygon(from, DVec3::Z, &seen) / (N * N) as f64;
            }
        }
        let value = matrix.weight(0, 1);
        println!("half plane at {height}, {edge}: {value} ({expected})");
        // Settled to a thousandth, and the midpoint rule's kinks: (1/64)²·4.
        assert!(
            (value - expected).abs() < 2e-3 * 0.1998248957,
            "{value} {expected}"
        );
    }
}

/// A plate just above the floor, and one just below the ceiling: sharp shadows from either end, so
/// that the estimate has to find an edge.
#[test]
fn sharp_shadows_on_both_ends_are_found() {
    const GAP: f64 = 0.01;
    const EDGES: [f64; 2] = [0.3, 0.45];
    let mut faces = facing();
    for (edge, height) in EDGES.into_iter().zip([GAP, 1.0 - GAP]) {
        let corner = [edge, -9.0, height];
        faces.push(square("plate", corner, [9.0, 0.0, 0.0], [0.0, 19.0, 0.0]));
    }
    let (_, matrix, _) = assemble(&scene("two plates", faces), 1);
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
        (value / expected - 1.0).abs() < 1.0 / 64.0 / EDGES[0],
        "{value} {expected}"
    );
}

/// The furnace with a box on its floor, with and without a bottom.
fn furnace_with_box(bottom: bool) -> Scene {
    let mut faces = furnace(0.5).faces;
    let (low, high) = (DVec3::new(0.3, 0.0, 0.35), DVec3::new(0.6, 0.5, 0.75));
    let body = room(low, high, false, Vec3::ONE, Vec3::splat(0.5));
    faces.extend(
        body.into_iter()
            .filter(|face| bottom || face.name != "floor"),
    );
    scene(if bottom { "box with a bottom" } else { "box" }, faces)
}

#[test]
fn what_stands_on_a_texel_takes_its_light_and_its_emission() {
    const N: u32 = 4;
    for bottom in [false, true] {
        let (mesh, matrix, quality) = assemble(&furnace_with_box(bottom), N);
        let answer = answer(&mesh, &matrix);
        let side = 1.0 / f64::from(N);
        let overlap = |k: u32, low: f64, high: f64| {
            let from = f64::from(k) * side;
            (high.min(from + side) - low.max(from)).max(0.0) / side
        };
        for (k, texel) in mesh.texels.iter().enumerate() {
            let open = match texel.face {
                // The floor's i runs along z, its j along x.
                0 => {
                    1.0 - overlap(texel.index % N, 0.35, 0.75) * overlap(texel.index / N, 0.3, 0.6)
                }
                // The box's own bottom lies on the floor.
                f if bottom && f == 6 => 0.0,
                _ => 1.0,
            };
            assert!(
                (matrix.open[k] - open).abs() < 1e-6,
                "{k}: {} {open}",
                matrix.open[k]
            );
            // u = E/(1−ρ) = 2 where it is open, B = E where it is covered.
            let (b, expected) = (answer.radiosity[k].x, 1.0 + open);
            assert!((b - expected).abs() < 5e-3, "{k}: {b} {expected}");
        }
        assert!(
            quality.closure_mean < 1e-3 && quality.closure_max < 1e-2,
            "{quality:?}"
        );
        let energy = energy(&mesh, &matrix, &answer);
        println!("{energy:?}");
        assert!(energy.imbalance < 1e-6);
        // What is emitted under the box is lost there, and nothing else is.
        let lost = 0.3 * 0.4 * if bottom { 2.0 } else { 1.0 };
        assert!((energy.escaped[0] - lost).abs() < 1e-6, "{energy:?}");
    }
}

#[test]
fn fronts_that_lie_on_each_other_give_a_finite_answer() {
    let mut faces = furnace(0.9).faces;
    faces.push(faces[0].clone());
    let (mesh, matrix, quality) = assemble(&scene("twice the same floor", faces), 2);
    let answer = answer(&mesh, &matrix);
    assert!(quality.closure_max < 1e-7, "{quality:?}");
    // The first of the two is lit.
    assert!((answer.radiosity[0].x - 10.0).abs() < 1e-5);
    assert_eq!(answer.radiosity[mesh.texels.len() - 1].x, 1.0);
}

/// Weights by the shooting solver's own form factors: one ray and one Lambert sum per cell and texel.
fn shot_weights(mesh: &Mesh, settings: &Settings) -> Matrix {
    let rays = Rays::new(mesh);
    let mut shooter = vec![0; mesh.texels.len()];
    for (cell, owner) in mesh.cells.iter().enumerate() {
        shooter[owner.first as usize..(owner.first + owner.count) as usize].fill(cell);
    }
    let areas: Vec<f64> = mesh.texels.iter().map(|t| f64::from(t.area)).collect();
    Matrix::from_weights(areas.clone(), |j, i| {
        let (cell, texel) = (&mesh.cells[shooter[i]], &mesh.texels[j]);
        if cell.face == texel.face {
            return 0.0;
        }
        let normal = mesh.faces[texel.face as usize].normal;
        let f = form_factor(
            settings.form_factor,
            &cell.shooter,
            texel.position,
            normal,
            texel.area,
        );
        let ends = [cell.face, texel.face];
        if f <= 0.0 || !rays.visible(cell.shooter.centre, texel.position, ends) {
            return 0.0;
        }
        // A cell shoots the mean of its texels.
        f64::from(f) * areas[i] / f64::from(cell.shooter.area)
    })
    .unwrap()
}

#[test]
fn shooting_ends_where_the_matrix_of_its_form_factors_does() {
    for (scene, texels, cells) in [
        (box_in_room(), 4, 4),
        (box_in_room(), 4, 1),
        (lit_room(), 6, 2),
    ] {
        let settings = Settings {
            texels,
            cells,
            epsilon: 1e-6,
            ..Settings::default()
        };
        let mesh = Mesh::uniform(&scene, texels, cells).unwrap();
        let matrix = shot_weights(&mesh, &settings);
        let answer = answer(&mesh, &matrix);
        let mut engine = CpuSolver::new(&mesh, &settings);
        let run = solve(
            &mut engine,
            &settings,
            &mut |_, _| ControlFlow::Continue(()),
        )
        .unwrap();
        let mut worst = 0.0f64;
        for (exact, shot) in answer.radiosity.iter().zip(&run.field.radiosity) {
            let shot = shot.truncate().as_dvec3();
            for c in 0..3 {
                if exact[c] > 0.0 {
                    worst = worst.max((shot[c] - exact[c]).abs() / exact[c]);
                }
            }
        }
        println!(
            "{}: {} shots, off by {worst:.1e}",
            scene.name,
            run.shots.len()
        );
        assert!(run.converged);
        assert!(worst < 1e-5, "{}: {worst}", scene.name);
    }
}
