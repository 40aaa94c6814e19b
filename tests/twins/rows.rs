//! A row of links with rays only where occluders are possible equals, bit for bit, the row with a ray for every
//! pair of points.

use common::cover;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Transport;
use cpu::CpuSolver;
use cpu::shader_twins::link::{Sums, add_sample, texel_form_factor};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use radiosity_tests::{any_lattice_face, box_in_room, bundled_scene, lit_room, named_scene, random_cases};

fn cut_mesh(scene: &Scene, texels: u32, cells: u32, samples: u32) -> Mesh {
    let mut mesh = Mesh::uniform(scene, texels, cells).unwrap();
    cover::sample_covers(&mut mesh, samples);
    mesh
}

/// Links one texel after the other, with all rays.
fn row_of_all_rays(solver: &CpuSolver, mesh: &Mesh, kind: FormFactor, cell: u32) -> Vec<f32> {
    let shooter = &mesh.patches[cell as usize];
    let of = |k: u32| {
        let ends = [shooter.face, mesh.texels[k as usize].face];
        let mut sums = Sums {
            form_factor: texel_form_factor(mesh, kind, cell, k),
            ..Sums::default()
        };
        for s in 0..mesh.samples {
            let sight = |q, p| solver.rays().find_sight(q, p, ends, false);
            add_sample(mesh, cell, k, s, &mut sums, sight);
        }
        sums.link_weight(shooter.open_share)
    };
    (0..mesh.texels.len() as u32).map(of).collect()
}

/// Counts links that differ, links between 0 and the form factor (partly occluded), and all.
fn compare_rows(mesh: &Mesh, kind: FormFactor, every: usize) -> [usize; 3] {
    let transport = Transport {
        form_factor: kind,
        ..Transport::default()
    };
    let mut solver = CpuSolver::new(mesh, &transport);
    let [mut differing, mut hidden, mut all] = [0; 3];
    for cell in (0..mesh.patches.len() as u32).step_by(every) {
        let expected = row_of_all_rays(&solver, mesh, kind, cell);
        let row: Vec<f32> = solver.link_row(cell).unwrap().links.to_vec();
        for (k, (a, b)) in row.iter().zip(&expected).enumerate() {
            assert!(a.is_finite());
            differing += usize::from(a.to_bits() != b.to_bits());
            hidden += usize::from(*b < texel_form_factor(mesh, kind, cell, k as u32));
        }
        all += expected.len();
    }
    [differing, hidden, all]
}

/// A face that reaches behind another: all sample points of a texel may lie behind a patch.
fn crossing_faces() -> [Scene; 3] {
    let quad = |c: [[f64; 3]; 4]| Face::quad("", c.map(DVec3::from), Vec3::ONE, Vec3::ZERO);
    let flat = quad([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
    let slanted = quad([[0.03, -1.0, -0.6], [0.2, -1.0, 0.7], [0.2, 1.0, 0.7], [0.03, 1.0, -0.6]]);
    [
        [flat.clone(), slanted.clone()],
        [flat.reversed(), slanted.clone()],
        [flat, slanted.reversed()],
    ]
    .map(|faces| named_scene("crossing", faces.into()))
}

#[test]
fn rows_equal_rows_of_all_rays() {
    let bundled = ["paper_room_objects.obj", "slivers.obj", "occluded_plates.obj"].map(bundled_scene);
    let occluded = [box_in_room(), lit_room()].into_iter().chain(bundled);
    for scene in occluded.chain(crossing_faces()) {
        for (texels, cells, samples) in [(8, 1, 1), (8, 2, 3), (6, 2, 2), (6, 3, 4), (5, 5, 1)] {
            let mesh = cut_mesh(&scene, texels, cells, samples);
            let every = match scene.faces.len() {
                0..10 => 1,
                10..100 => 7,
                _ => 61,
            };
            for kind in [FormFactor::Polygon, FormFactor::Disc, FormFactor::Paper] {
                let [differing, hidden, all] = compare_rows(&mesh, kind, every);
                let name = format!("{}, {texels} texels, {cells} cells, {samples} samples", scene.name);
                assert_eq!(differing, 0, "{name}: of {all}");
                let open = ["slivers", "crossing"].iter().any(|open| scene.name.contains(open));
                assert!(open || hidden > 0, "{name}: nothing is hidden");
            }
        }
    }
}

/// Draws triangles and quads anywhere in a cube, which intersect one another.
fn polygon_soup() -> impl Strategy<Value = Scene> {
    let face = any_lattice_face(8, 0.1, Vec3::ONE, Vec3::splat(0.5));
    let proper = face.prop_filter("no area", |face| face.vector_area().length() > 1e-3);
    prop::collection::vec(proper, 3..40).prop_map(|faces| named_scene("soup", faces))
}

proptest! {
    #![proptest_config(random_cases(48))]
    #[test]
    fn rows_of_polygon_soup_equal_rows_of_all_rays(scene in polygon_soup(), samples in 1u32..4) {
        let mesh = cut_mesh(&scene, 6, 2, samples);
        let [differing, _, all] = compare_rows(&mesh, FormFactor::Polygon, 11);
        prop_assert_eq!(differing, 0, "of {}", all);
    }
}
