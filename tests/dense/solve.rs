//! The dense solver against exact solutions, on covered texels, and against the shooting solver with the same form
//! factors.

use common::energy::EnergyBalance;
use common::form_factor::form_factor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::{Face, Scene};
use common::settings::{Settings, Visibility};
use common::shooting::RadiosityField;
use cpu::dense::{DenseSolution, Matrix, shot_log};
use glam::{DVec3, Vec3, Vec4};
use oracle::exact;
use radiosity_tests::bounds::assert_near;
use radiosity_tests::dense::{assemble_dense, solve_matrix, texel_values};
use radiosity_tests::engines::{settings_of, shoot_on_cpu};
use radiosity_tests::{box_faces, box_in_room, furnace, lit_room, named_scene};

/// Returns the energy balance as `solve` reports it.
fn energy_balance(mesh: &Mesh, matrix: &Matrix, answer: &DenseSolution) -> EnergyBalance {
    let single = |v: &[DVec3]| v.iter().map(|x| x.as_vec3().extend(0.0)).collect();
    let field = RadiosityField {
        origin: "matrix".into(),
        radiosity: single(&answer.radiosity),
        residual: vec![Vec4::ZERO; mesh.texels.len()],
        irradiance: single(&answer.irradiance),
    };
    let emission = texel_values(mesh, |texel| texel.emission);
    EnergyBalance::new(mesh, &field, &shot_log::texel_shots(mesh, matrix, &emission, answer))
}

#[test]
fn the_cube_solved_by_hand() {
    for reflectance in [0.5f32, 0.7, 0.9] {
        let mut cube = furnace(reflectance);
        for face in &mut cube.faces {
            face.emission = if face.name == "ceiling" { Vec3::ONE } else { Vec3::ZERO };
        }
        let (mesh, matrix, _) = assemble_dense(&cube, 1);
        let answer = solve_matrix(&mesh, &matrix);
        let [top, bottom, side] = exact::cube_radiosities(f64::from(reflectance));
        for (face, b) in cube.faces.iter().zip(&answer.radiosity) {
            let expected = match face.name.as_str() {
                "ceiling" => top,
                "floor" => bottom,
                _ => side,
            };
            // ΣF within 1e−8, amplified by 1/(1−ρ) twice.
            assert_near(&face.name, b.x, expected, 1e-6);
        }
    }
}

/// A room of general quads and triangles: a prism over a trapezium with a slanted roof.
fn slanted_room() -> Scene {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let floor = [p(0.0, 0.0, 0.0), p(3.0, 0.0, 0.0), p(2.0, 1.5, 0.0), p(0.5, 1.0, 0.0)];
    let roof = floor.map(|q| p(q.x, q.y, 1.0 + 0.2 * q.x - 0.1 * q.y));
    let mut faces = vec![Face::quad("floor", floor, Vec3::ONE, Vec3::splat(0.5))];
    let [a, b, c, d] = roof;
    faces.push(Face::triangle("roof", [a, c, b], Vec3::ONE, Vec3::splat(0.5)));
    faces.push(Face::triangle("roof", [a, d, c], Vec3::ONE, Vec3::splat(0.5)));
    for k in 0..4 {
        let n = (k + 1) % 4;
        let wall = [floor[n], floor[k], roof[k], roof[n]];
        faces.push(Face::quad("wall", wall, Vec3::ONE, Vec3::splat(0.5)));
    }
    named_scene("slanted", faces)
}

/// A slab a thousandth as high as it is wide: every texel of the floor almost touches one above.
fn slab_room() -> Scene {
    let size = DVec3::new(1.0, 1e-3, 1.0);
    named_scene("slab", box_faces(DVec3::ZERO, size, true, Vec3::ONE, Vec3::splat(0.5)))
}

#[test]
fn closed_convex_rooms_have_unit_row_sums_and_even_furnace() {
    for (scene, texels) in [
        (furnace(0.5), 1),
        (furnace(0.5), 8),
        (slanted_room(), 1),
        (slanted_room(), 6),
        (slab_room(), 5),
    ] {
        let (mesh, matrix, quality) = assemble_dense(&scene, texels);
        let worst = matrix
            .form_factor_sums()
            .iter()
            .map(|s| (s - 1.0).abs())
            .fold(0.0, f64::max);
        assert!(worst <= 1e-7, "{}: {worst}", scene.name);
        assert!(quality.closure.max <= 1e-7 && quality.sampled_pairs == 0, "{quality:?}");
        assert!(quality.reciprocity <= 1e-7, "{quality:?}");
        let answer = solve_matrix(&mesh, &matrix);
        for b in &answer.radiosity {
            assert_near(&scene.name, b.x, exact::furnace_radiosity(1.0, 0.5), 1e-6);
        }
        assert!(energy_balance(&mesh, &matrix, &answer).imbalance < 1e-6);
    }
}

/// The furnace with a box on its floor, with and without a bottom.
fn furnace_with_box(bottom: bool) -> Scene {
    let mut faces = furnace(0.5).faces;
    let (low, high) = (DVec3::new(0.3, 0.0, 0.35), DVec3::new(0.6, 0.5, 0.75));
    let body = box_faces(low, high, false, Vec3::ONE, Vec3::splat(0.5));
    faces.extend(body.into_iter().filter(|face| bottom || face.name != "floor"));
    named_scene(if bottom { "box with a bottom" } else { "box" }, faces)
}

#[test]
fn body_on_texel_covers_its_light_and_its_emission() {
    const N: u32 = 4;
    for bottom in [false, true] {
        let (mesh, matrix, quality) = assemble_dense(&furnace_with_box(bottom), N);
        let answer = solve_matrix(&mesh, &matrix);
        let side = 1.0 / f64::from(N);
        let overlap = |k: u32, low: f64, high: f64| {
            let from = f64::from(k) * side;
            (high.min(from + side) - low.max(from)).max(0.0) / side
        };
        for (k, texel) in mesh.texels.iter().enumerate() {
            let open = match texel.face {
                // The floor's i runs along z, its j along x.
                0 => 1.0 - overlap(texel.index % N, 0.35, 0.75) * overlap(texel.index / N, 0.3, 0.6),
                // The box's own bottom lies on the floor.
                f if bottom && f == 6 => 0.0,
                _ => 1.0,
            };
            assert_near(k, matrix.open[k], open, 1e-6);
            // u = E/(1−ρ) = 2 where it is open, B = E where it is covered.
            let (b, expected) = (answer.radiosity[k].x, 1.0 + open);
            assert_near(k, b, expected, 5e-3);
        }
        assert!(quality.closure.mean < 1e-3 && quality.closure.max < 1e-2, "{quality:?}");
        let energy = energy_balance(&mesh, &matrix, &answer);
        assert!(energy.imbalance < 1e-6);
        // Only the emission under the box is lost.
        let lost = 0.3 * 0.4 * if bottom { 2.0 } else { 1.0 };
        assert_near("escaped", energy.escaped[0], lost, 1e-6);
    }
}

/// A rotated sheet in the furnace, a quad on one side and two triangles on the other: by rounding some fronts lie
/// slightly above each other, but no part lies under a body.
#[test]
fn sheet_with_different_sides_is_open_on_both() {
    let mut faces = furnace(0.5).faces;
    let (u, v) = (DVec3::new(0.31, 0.17, -0.07), DVec3::new(-0.11, 0.29, 0.23));
    let a = DVec3::new(0.37, 0.31, 0.41);
    let [b, c, d] = [a + u, a + u + v, a + v];
    let grey = (Vec3::ONE, Vec3::splat(0.5));
    faces.push(Face::quad("sheet", [a, b, c, d], grey.0, grey.1));
    for corners in [[a, c, b], [a, d, c]] {
        faces.push(Face::triangle("sheet", corners, grey.0, grey.1));
    }
    let (mesh, matrix, _) = assemble_dense(&named_scene("a sheet in a furnace", faces), 4);
    let answer = solve_matrix(&mesh, &matrix);
    for (k, texel) in mesh.texels.iter().enumerate() {
        assert_eq!(matrix.open[k], 1.0, "{texel:?}");
        let b = answer.radiosity[k].x;
        assert_near(k, b, 2.0, 5e-3);
    }
}

#[test]
fn coincident_fronts_give_finite_solution() {
    let mut faces = furnace(0.9).faces;
    faces.push(faces[0].clone());
    let (mesh, matrix, quality) = assemble_dense(&named_scene("twice the same floor", faces), 2);
    let answer = solve_matrix(&mesh, &matrix);
    assert!(quality.closure.max < 1e-7, "{quality:?}");
    // The first of the two is lit.
    assert_near("the first floor", answer.radiosity[0].x, 10.0, 1e-5);
    assert_eq!(answer.radiosity[mesh.texels.len() - 1].x, 1.0);
}

/// Weights by the shooting solver's own form factors: one ray and one Lambert sum per patch and texel.
fn shooting_weights(mesh: &Mesh, settings: &Settings) -> Matrix {
    let rays = Rays::new(mesh);
    let mut shooter = vec![0; mesh.texels.len()];
    for (cell, owner) in mesh.patches.iter().enumerate() {
        shooter[owner.first as usize..(owner.first + owner.count) as usize].fill(cell);
    }
    let areas: Vec<f64> = mesh.texels.iter().map(|t| f64::from(t.area)).collect();
    Matrix::from_weights(areas.clone(), |j, i| {
        let (cell, texel) = (&mesh.patches[shooter[i]], &mesh.texels[j]);
        if cell.face == texel.face {
            return 0.0;
        }
        let normal = mesh.faces[texel.face as usize].normal;
        let f = form_factor(
            settings.transport.form_factor,
            &cell.shooter,
            texel.position,
            normal,
            texel.area,
        );
        let ends = [cell.face, texel.face];
        if f <= 0.0 || !rays.is_visible(cell.shooter.centre, texel.position, ends) {
            return 0.0;
        }
        // A patch shoots the mean of its texels.
        f64::from(f) * areas[i] / f64::from(cell.shooter.area)
    })
    .unwrap()
}

#[test]
fn shooting_converges_to_dense_solution_of_its_form_factors() {
    for (scene, texels, cells) in [(box_in_room(), 4, 4), (box_in_room(), 4, 1), (lit_room(), 6, 2)] {
        let settings = settings_of([texels, cells, 1], Visibility::Rays, 1e-6);
        let mesh = Mesh::uniform(&scene, texels, cells).unwrap();
        let answer = solve_matrix(&mesh, &shooting_weights(&mesh, &settings));
        let run = shoot_on_cpu(&mesh, &settings);
        let mut worst = 0.0f64;
        for (exact, shot) in answer.radiosity.iter().zip(&run.field.radiosity) {
            let shot = shot.truncate().as_dvec3();
            for c in 0..3 {
                if exact[c] > 0.0 {
                    worst = worst.max((shot[c] - exact[c]).abs() / exact[c]);
                }
            }
        }
        assert!(run.converged);
        assert!(worst < 1e-5, "{}: {worst}", scene.name);
    }
}
