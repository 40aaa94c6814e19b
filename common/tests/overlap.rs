//! Overlapping fronts: detection, and removal of covered area.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};

fn square(x: f64, z: f64, side: f64) -> Face {
    let p = |i: f64, j: f64| DVec3::new(x + i * side, j * side, z);
    let corners = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
    Face::quad("", corners, Vec3::ZERO, Vec3::ZERO)
}

fn mesh(faces: Vec<Face>, texels: u32, patches: u32) -> Mesh {
    let scene = Scene {
        name: "squares".into(),
        faces,
        ..Scene::default()
    };
    Mesh::uniform(&scene, texels, patches).unwrap()
}

fn area(mesh: &Mesh, face: u32) -> f64 {
    let own = mesh.texels.iter().filter(|t| t.face == face);
    own.map(|t| f64::from(t.area)).sum::<f64>() * mesh.area_unit()
}

#[test]
fn coplanar_fronts_of_one_orientation_overlap() {
    let faces = vec![
        square(0.0, 0.0, 1.0),
        square(1.0, 0.0, 1.0),             // shares an edge with 0
        square(0.25, 0.0, 0.5),            // inside 0
        square(0.25, 0.0, 0.5).reversed(), // touches from the other side
        square(0.25, 0.01, 0.5),           // above
    ];
    assert_eq!(mesh(faces, 1, 1).overlaps, [[0, 2]]);
}

#[test]
fn face_under_earlier_front_has_no_area() {
    let whole = square(0.0, 0.0, 1.0);
    let [a, b, c, d] = whole.corners;
    let half = |c| Face::triangle("", c, Vec3::ZERO, Vec3::ZERO);
    let halves = [half([a, b, c]), half([a, c, d])];
    let far = square(3.0, 0.0, 1.0);
    for (texels, patches) in [(1, 1), (8, 2), (8, 8)] {
        // The same corners in rotated order, and the same square as two triangles.
        let mut turned = whole.clone();
        turned.corners.rotate_left(1);
        let faces = [&[whole.clone(), turned, far.clone()], &halves[..]].concat();
        let all = mesh(faces, texels, patches);
        let areas: Vec<f64> = (0..5).map(|k| area(&all, k)).collect();
        assert_eq!(areas[1..5], [0.0, 1.0, 0.0, 0.0], "{texels}, {patches}");
        assert!(abs_diff_eq!(areas[0], 1.0, epsilon = 1e-6));
        let buried = |k: usize| all.faces[k].normal == Vec3::ZERO;
        assert_eq!([0, 1, 2, 3, 4].map(buried), [false, true, false, true, true]);
        // A square under two triangles.
        let faces = [&halves[..], &[whole.clone(), far.clone()]].concat();
        let all = mesh(faces, texels, patches);
        assert_eq!(area(&all, 2), 0.0, "{texels}, {patches}");
        assert!(abs_diff_eq!(area(&all, 0) + area(&all, 1), 1.0, epsilon = 1e-6));
    }
}

/// A lamp is often modelled flush with a ceiling.
#[test]
fn lamp_covers_an_earlier_front() {
    let mut lamp = square(0.25, 0.0, 0.5);
    lamp.emission = Vec3::ONE;
    let all = mesh(vec![square(0.0, 0.0, 1.0), lamp.clone()], 4, 4);
    assert_eq!(all.overlaps, [[1, 0]]);
    assert!(abs_diff_eq!(area(&all, 1), 0.25, epsilon = 1e-6));
    assert!(abs_diff_eq!(area(&all, 0), 0.75, epsilon = 1e-6));
    // Of two lamps the first, and of exact copies the lamp.
    let mut whole = square(0.0, 0.0, 1.0);
    whole.emission = Vec3::ONE;
    assert_eq!(mesh(vec![whole.clone(), lamp], 1, 1).overlaps, [[0, 1]]);
    assert_eq!(mesh(vec![square(0.0, 0.0, 1.0), whole], 1, 1).overlaps, [[1, 0]]);
}

/// Faces with the same corners and opposite fronts are the sides of a sheet, whichever corner comes first.
#[test]
fn opposite_faces_are_a_sheet() {
    let [a, b, c, d] = square(0.0, 0.0, 1.0).corners;
    for turn in 0..4 {
        let mut back = [d, c, b, a];
        back.rotate_left(turn);
        assert_eq!(
            joined_sheets(&[blank_quad([a, b, c, d]), blank_quad(back)]),
            [Some(0); 2],
            "{turn}"
        );
    }
    for turn in 0..3 {
        let mut back = [c, b, a];
        back.rotate_left(turn);
        assert_eq!(
            joined_sheets(&[blank_triangle([a, b, c]), blank_triangle(back)]),
            [Some(0); 2],
            "{turn}"
        );
    }
    assert_eq!(
        joined_sheets(&[blank_triangle([a, b, c]), blank_triangle([d, b, a])]),
        [None; 2]
    );
}

/// Two triangles that form a quad are a side of a sheet: both sides may be cut along different diagonals.
#[test]
fn sides_of_a_sheet_may_be_cut_along_different_diagonals() {
    let [a, b, c, d] = square(0.0, 0.0, 1.0).corners;
    let front = [blank_triangle([a, b, c]), blank_triangle([a, c, d])];
    let back = [blank_triangle([d, b, a]), blank_triangle([b, d, c])];
    assert_eq!(joined_sheets(&[&front[..], &back[..]].concat()), [Some(0); 4]);
    assert_eq!(
        joined_sheets(&[&front[..], &[blank_quad([d, c, b, a])]].concat()),
        [Some(0); 3]
    );
    // Of one front, and bent.
    assert_eq!(
        joined_sheets(&[&front[..], &[blank_triangle([a, b, d]), blank_triangle([b, c, d])]].concat()),
        [None; 4]
    );
    let raised = d + 0.1 * DVec3::Z;
    let bent = [blank_triangle([a, b, c]), blank_triangle([a, c, raised])];
    assert_eq!(
        joined_sheets(
            &[
                &bent[..],
                &[blank_triangle([raised, b, a]), blank_triangle([b, raised, c])]
            ]
            .concat()
        ),
        [None; 4]
    );
}

fn blank_quad(corners: [DVec3; 4]) -> Face {
    Face::quad("", corners, Vec3::ZERO, Vec3::ZERO)
}

fn blank_triangle(corners: [DVec3; 3]) -> Face {
    Face::triangle("", corners, Vec3::ZERO, Vec3::ZERO)
}

/// Returns for each face the sheet of which it is a side, by its lowest face; none for a face that is alone.
fn joined_sheets(faces: &[Face]) -> Vec<Option<u32>> {
    let all = mesh(faces.to_vec(), 1, 1);
    all.faces
        .iter()
        .map(|face| face.two_sided.then_some(face.sheet))
        .collect()
}

#[test]
fn covered_patches_of_half_covered_face_have_no_area() {
    let all = mesh(vec![square(0.0, 0.0, 1.0), square(0.5, 0.0, 1.0)], 8, 4);
    assert!(abs_diff_eq!(area(&all, 1), 0.5, epsilon = 1e-6));
    let shooting: f32 = all.patches.iter().map(|c| c.shooter.area).sum();
    let receiving: f32 = all.texels.iter().map(|t| t.area).sum();
    assert!(abs_diff_eq!(shooting, receiving, epsilon = 1e-6));
}

#[test]
fn ten_thousand_nested_squares_are_compared_once_each() {
    // Ten thousand squares, each a little smaller than the one before.
    let faces = (0..10_000).map(|k| square(0.0, 0.0, 1.0 - f64::from(k) * 1e-5));
    let all = mesh(faces.collect(), 1, 1);
    // Every pair compared overlaps and is stored: a comparison of all pairs would store 5e7.
    assert_eq!(all.overlaps.len(), 9_999);
}
