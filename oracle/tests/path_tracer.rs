//! The path tracer against what can be worked out by hand, and the matrix against the path tracer.
//!
//! A mean of 16 sets is about the truth as Student's t of 15 degrees. Bounds are 7 standard errors: each
//! figure that is held is beyond that by chance once in 230 000.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use cpu::matrix::Matrix;
use glam::{DVec3, Vec3};
use oracle::judge::diff::pair::Pair;
use oracle::judge::diff::reflected::Reflected;
use oracle::judge::exact::{furnace, parallel_rectangles, perpendicular_rectangles};
use oracle::judge::path_tracer::{Traced, rms, trace};
use oracle::solve::dense;
use oracle::study::random::{self, Faces, Kind, Lamp, Options};
use std::ops::ControlFlow;

const SIGMAS: f64 = 7.0;

fn scene(faces: Vec<Face>) -> Scene {
    Scene {
        name: "made".into(),
        faces,
        notes: Vec::new(),
    }
}

/// Six quads, fronts inwards or outwards: floor, ceiling, then the walls.
pub fn block(low: [f64; 3], high: [f64; 3], inward: bool) -> Vec<Face> {
    let p = |x: usize, y: usize, z: usize| {
        let ends = [low, high];
        DVec3::new(ends[x][0], ends[y][1], ends[z][2])
    };
    let quads = [
        [p(0, 0, 0), p(0, 0, 1), p(1, 0, 1), p(1, 0, 0)],
        [p(0, 1, 0), p(1, 1, 0), p(1, 1, 1), p(0, 1, 1)],
        [p(0, 0, 0), p(0, 1, 0), p(0, 1, 1), p(0, 0, 1)],
        [p(1, 0, 0), p(1, 0, 1), p(1, 1, 1), p(1, 1, 0)],
        [p(0, 0, 0), p(1, 0, 0), p(1, 1, 0), p(0, 1, 0)],
        [p(0, 0, 1), p(0, 1, 1), p(1, 1, 1), p(1, 0, 1)],
    ];
    let face = |corners| Face::quad("", corners, Vec3::ZERO, Vec3::ZERO);
    let faces = quads.into_iter().map(face);
    faces
        .map(|face| if inward { face } else { face.reversed() })
        .collect()
}

fn cube() -> Vec<Face> {
    block([0.0; 3], [1.0; 3], true)
}

fn all(mut faces: Vec<Face>, emission: f32, reflectance: f32) -> Vec<Face> {
    for face in &mut faces {
        face.emission = Vec3::splat(emission);
        face.reflectance = Vec3::splat(reflectance);
    }
    faces
}

fn mesh(scene: &Scene, texels: u32) -> Mesh {
    Mesh::uniform(scene, texels, 1).unwrap()
}

/// One of the means of the first channel against what it must be.
fn holds(traced: &Traced, k: usize, expected: f64) {
    let (found, error) = (traced.reflected.values[k].x, traced.error[k].x);
    let off = (found - expected) / error.max(1e-12);
    assert!(
        off.abs() < SIGMAS,
        "texel {k}: {found} ± {error} instead of {expected}: {off:.1} standard errors"
    );
}

#[test]
fn a_furnace_is_lit_alike_everywhere() {
    for reflectance in [0.5, 0.9] {
        let scene = scene(all(cube(), 2.0, reflectance));
        let traced = trace(&scene, &mesh(&scene, 2), 16_000, 1);
        let rho = f64::from(reflectance);
        for k in 0..24 {
            holds(&traced, k, furnace(2.0, rho) - 2.0);
            assert!(traced.error[k].x < 0.02 * furnace(2.0, rho));
        }
    }
}

#[test]
fn light_that_comes_straight_is_the_form_factor() {
    // The ceiling shines; one wall after the other reflects, the rest is black.
    for (wall, factor) in [
        (0, parallel_rectangles(1.0, 1.0, 1.0)),
        (2, perpendicular_rectangles(1.0, 1.0, 1.0)),
    ] {
        let mut faces = cube();
        faces[1].emission = Vec3::new(3.0, 1.0, 0.0);
        faces[wall].reflectance = Vec3::splat(0.9);
        let scene = scene(faces);
        let traced = trace(&scene, &mesh(&scene, 1), 40_000, 2);
        holds(&traced, wall, 0.9f32 as f64 * 3.0 * factor);
        let [red, green, blue] = traced.reflected.values[wall].to_array();
        // The same paths, whatever the channel; f32 colours are exact here.
        assert!(abs_diff_eq!(red / green, 3.0, epsilon = 1e-12) && blue == 0.0);
        let others = (0..6).filter(|k| *k != wall);
        assert!(
            others
                .into_iter()
                .all(|k| traced.reflected.values[k] == DVec3::ZERO)
        );
    }
}

/// A furnace with a box on its floor and a sheet in the air: B = E/(1 − ρ) wherever there is light;
/// under the box, and on its underside, there is none at all.
#[test]
fn nothing_is_lit_under_a_body_and_both_sides_of_a_sheet_are() {
    let mut faces = cube();
    faces.extend(block([0.25, 0.0, 0.25], [0.75, 0.5, 0.75], false));
    let p = |x, z| DVec3::new(x, 0.75, z);
    let up = Face::quad(
        "",
        [p(0.2, 0.2), p(0.2, 0.8), p(0.8, 0.8), p(0.8, 0.2)],
        Vec3::ZERO,
        Vec3::ZERO,
    );
    faces.extend([up.reversed(), up]);
    let scene = scene(all(faces, 1.0, 0.6));
    let traced = trace(&scene, &mesh(&scene, 4), 2000, 3);
    let lit = furnace(1.0, f64::from(0.6f32)) - 1.0;
    for k in 0..14 * 16 {
        let (face, i, j) = (k / 16, k % 4, k / 4 % 4);
        let covered = face == 6 || (face == 0 && (1..3).contains(&i) && (1..3).contains(&j));
        holds(&traced, k, if covered { 0.0 } else { lit });
        assert_eq!(traced.error[k].x == 0.0, covered);
    }
}

/// A body in a corner: two of its sides lie on walls that shine, its underside on the floor.
#[test]
fn no_light_comes_through_the_sides_of_a_body_that_lie_on_walls() {
    let mut faces = all(cube(), 1.0, 0.6);
    faces.extend(all(
        block([0.5, 0.0, 0.5], [1.0, 0.5, 1.0], false),
        0.0,
        0.6,
    ));
    let scene = scene(faces);
    let traced = trace(&scene, &mesh(&scene, 2), 400, 3);
    // The floor's quarter in the corner, and the underside.
    let texel = |face: usize, k: usize| traced.reflected.values[4 * face + k];
    let dark: Vec<usize> = (0..4).filter(|k| texel(0, *k) == DVec3::ZERO).collect();
    assert_eq!(dark, [3], "{:?}", &traced.reflected.values[..4]);
    assert!((0..4).all(|k| texel(6, k) == DVec3::ZERO));
}

#[test]
fn the_same_seed_is_the_same_answer() {
    let scene = random::scene(1, Options::default()).scene;
    let [a, b, other] = [4, 4, 5].map(|seed| trace(&scene, &mesh(&scene, 2), 50, seed));
    assert_eq!(a.reflected.values, b.reflected.values);
    assert_eq!(a.error, b.error);
    assert_ne!(a.reflected.values, other.reflected.values);
}

fn drawn(seed: u64, kind: Kind, faces: Faces) -> random::Drawn {
    random::scene(seed, Options { kind, faces })
}

/// Σ A(1 − ρ)H = Σ AE wherever nothing gets out: no light is lost in a body or through a seam. Lamps
/// are boxes: the black back of a panel takes what falls on it, and what a wall emits under a body is
/// lost.
#[test]
fn closed_rooms_absorb_what_they_emit() {
    let closed = (0..).map(|seed| drawn(seed, Kind::Any, Faces::Triangles));
    for drawn in closed
        .filter(|d| d.closed && d.lamps.iter().all(|l| *l == Lamp::Box))
        .take(4)
    {
        let scene = &drawn.scene;
        let traced = trace(scene, &mesh(scene, 1), 3000, 4);
        let (mut absorbed, mut variance, mut emitted) = (0.0, 0.0, 0.0);
        for (k, face) in scene.faces.iter().enumerate() {
            let [area, rho] = [face.area(), f64::from(face.reflectance.x)];
            let gain = area * (1.0 - rho) / rho;
            absorbed += gain * traced.reflected.values[k].x;
            variance += (gain * traced.error[k].x).powi(2);
            emitted += area * f64::from(face.emission.x);
        }
        let off = (absorbed - emitted) / variance.sqrt();
        println!(
            "{drawn}: absorbed {:.4} ± {:.4}",
            absorbed / emitted,
            variance.sqrt() / emitted
        );
        assert!(off.abs() < SIGMAS, "{drawn}: {off:.1} standard errors");
    }
}

fn solved(scene: &Scene, texels: u32) -> (Mesh, common::shooting::Field) {
    let mesh = mesh(scene, texels);
    let (matrix, _) =
        Matrix::assemble(scene, &mesh, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let field = dense::by(&mesh, &matrix).unwrap().0.field;
    (mesh, field)
}

/// What is left of the matrix's error on texels half as wide is at most what halving them changed.
#[test]
fn the_matrix_is_right_on_triangles_drawn_at_random() {
    for (seed, kind) in [(1, Kind::Room), (11, Kind::Any), (12, Kind::Any)] {
        let drawn = drawn(seed, kind, Faces::Triangles);
        let scene = &drawn.scene;
        let [(rough_mesh, rough), (fine_mesh, fine)] = [2, 4].map(|texels| solved(scene, texels));
        let rough = Reflected::of(scene, &rough_mesh, &rough);
        let fine = Reflected::of(scene, &fine_mesh, &fine);
        let traced = trace(scene, &rough_mesh, 6000, 5);
        let of = |a| Pair::new(a, &traced.reflected, Some(&traced.error)).unwrap();
        let [of_rough, of_fine] = [&rough, &fine].map(|a| rms(&of(a)));
        let changed = Pair::new(&rough, &fine, None).unwrap().worst().0;
        let [error, noise] = of_fine;
        println!("{drawn}: 2² {of_rough:?}, 4² {of_fine:?}, halving changed {changed:.4}");
        assert!(
            error <= changed + SIGMAS * noise,
            "{drawn}: {error} ± {noise}, {changed}"
        );
        // Else nothing is said.
        assert!(SIGMAS * noise < 0.05, "{drawn}: {noise}");
    }
}
