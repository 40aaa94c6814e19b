//! A row of links made with rays only where they can matter is the row that a ray for every pair
//! of points makes, bit for bit.

use common::cover;
use common::form_factor::FormFactor;
use common::import::{ImportOptions, load};
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Transport;
use cpu::CpuSolver;
use cpu::twin::link::{Sums, factor, sample};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use radiosity_tests::{box_in_room, cases, lit_room, paper_room, scene};
use std::path::Path;

fn mesh(scene: &Scene, texels: u32, cells: u32, samples: u32) -> Mesh {
    let mut mesh = Mesh::uniform(scene, texels, cells).unwrap();
    cover::sample(&mut mesh, samples);
    mesh
}

/// One texel after the other, with all rays.
fn plain(solver: &CpuSolver, mesh: &Mesh, kind: FormFactor, cell: u32) -> Vec<f32> {
    let shooter = &mesh.cells[cell as usize];
    let of = |k: u32| {
        let ends = [shooter.face, mesh.texels[k as usize].face];
        let mut sums = Sums {
            form_factor: factor(mesh, kind, cell, k),
            ..Sums::default()
        };
        for s in 0..mesh.samples {
            let sight = |q, p| solver.rays().sight(q, p, ends, false);
            sample(mesh, cell, k, s, &mut sums, sight);
        }
        sums.link(shooter.open)
    };
    (0..mesh.texels.len() as u32).map(of).collect()
}

/// Links that differ, links between 0 and the form factor (hidden in part), and all.
fn compare(mesh: &Mesh, kind: FormFactor, every: usize) -> [usize; 3] {
    let transport = Transport {
        form_factor: kind,
        ..Transport::default()
    };
    let mut solver = CpuSolver::new(mesh, &transport);
    let [mut differing, mut hidden, mut all] = [0; 3];
    for cell in (0..mesh.cells.len() as u32).step_by(every) {
        let expected = plain(&solver, mesh, kind, cell);
        let row: Vec<f32> = solver.row(cell).unwrap().links.to_vec();
        for (k, (a, b)) in row.iter().zip(&expected).enumerate() {
            assert!(a.is_finite());
            differing += usize::from(a.to_bits() != b.to_bits());
            hidden += usize::from(*b < factor(mesh, kind, cell, k as u32));
        }
        all += expected.len();
    }
    [differing, hidden, all]
}

fn bundled(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenes")
        .join(name);
    load(&path, &ImportOptions::default()).unwrap()
}

#[test]
fn rows_are_those_of_all_rays() {
    let scenes = [
        box_in_room(),
        lit_room(),
        paper_room(),
        bundled("cornell_box.obj"),
        bundled("paper_room_objects.obj"),
        bundled("slivers.obj"),
        bundled("occluded_plates.obj"),
    ];
    for scene in &scenes {
        let many = scene.faces.len() > 100;
        for (texels, cells, samples) in [(8, 1, 1), (8, 2, 3), (6, 3, 4), (5, 5, 1)] {
            let mesh = mesh(scene, texels, cells, samples);
            for kind in [FormFactor::Polygon, FormFactor::Disc, FormFactor::Paper] {
                let every = if many { 61 } else { 7 };
                let [differing, hidden, all] = compare(&mesh, kind, every);
                assert_eq!(
                    differing, 0,
                    "{}, {texels} texels, {cells} cells, {samples} samples: {differing} of {all}",
                    scene.name
                );
                let open = ["slivers"].iter().any(|name| scene.name.contains(name));
                assert!(open || hidden > 0, "{}: nothing is hidden", scene.name);
            }
        }
    }
}

/// A texel that reaches behind a cell is asked at points which may all lie there.
#[test]
fn rows_of_faces_that_cross_are_those_of_all_rays() {
    let quad = |c: [[f64; 3]; 4]| Face::quad("", c.map(DVec3::from), Vec3::ONE, Vec3::ZERO);
    let flat = quad([
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ]);
    let slanted = quad([
        [0.03, -1.0, -0.6],
        [0.2, -1.0, 0.7],
        [0.2, 1.0, 0.7],
        [0.03, 1.0, -0.6],
    ]);
    for faces in [
        [flat.clone(), slanted.clone()],
        [flat.reversed(), slanted.clone()],
        [flat, slanted.reversed()],
    ] {
        let scene = scene("crossing", faces.into());
        for samples in 1..5 {
            let mesh = mesh(&scene, 6, 2, samples);
            let [differing, _, all] = compare(&mesh, FormFactor::Polygon, 1);
            assert_eq!(differing, 0, "{samples} samples: {differing} of {all}");
        }
    }
}

/// Triangles and quads anywhere in a cube: they cut one another.
fn soup() -> impl Strategy<Value = Scene> {
    let coordinate = || (-8i32..8).prop_map(|x| f64::from(x) / 8.0 + 0.013);
    let corner = move || (coordinate(), coordinate(), coordinate());
    let face = (corner(), corner(), corner(), any::<bool>()).prop_map(|(a, b, c, quad)| {
        let [a, b, c] = [a, b, c].map(|(x, y, z)| DVec3::new(x, y, z));
        let grey = Vec3::splat(0.5);
        if quad {
            Face::quad("face", [a, b, b + c - a, c], Vec3::ONE, grey)
        } else {
            Face::triangle("face", [a, b, c], Vec3::ONE, grey)
        }
    });
    let proper = face.prop_filter("no area", |face| face.vector_area().length() > 1e-3);
    prop::collection::vec(proper, 3..40).prop_map(|faces| scene("soup", faces))
}

proptest! {
    #![proptest_config(cases(48))]
    #[test]
    fn rows_of_a_soup_are_those_of_all_rays(scene in soup(), samples in 1u32..4) {
        let mesh = mesh(&scene, 6, 2, samples);
        let [differing, _, all] = compare(&mesh, FormFactor::Polygon, 11);
        prop_assert_eq!(differing, 0, "of {}", all);
    }
}
