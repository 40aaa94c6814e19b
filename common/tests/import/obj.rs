//! Import of each OBJ and MTL feature.

use super::files::{Folder, corners, notes, obj, text_lines};
use common::import::{ImportOptions, from_srgb, load_scene};
use common::paint::MAX_WHITE_REFLECTANCE;
use common::scene::{Scene, Shape};
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

fn scene(text: &str) -> Scene {
    obj(text).expect("a scene")
}

/// Loads an OBJ, and its materials from the lines of `a.mtl`.
fn with_materials(text: &str, materials: &str, options: &ImportOptions) -> Scene {
    let text = format!("mtllib a.mtl\n{}", text_lines(text));
    let folder = Folder::new().with("a.obj", text).with("a.mtl", text_lines(materials));
    load_scene(&folder.path("a.obj"), options).expect("a scene")
}

fn reflectances(scene: &Scene) -> Vec<Vec3> {
    scene.faces.iter().map(|f| f.reflectance).collect()
}

#[test]
fn quads_and_triangles_keep_corners_and_names() {
    let scene = scene("S o first; f 1 2 3 4; g second; f 4 3 1;");
    let [a, b, c, d] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_eq!(corners(&scene), [vec![a, b, c, d], vec![d, c, a]]);
    let names: Vec<_> = scene.faces.iter().map(|f| (f.name.as_str(), f.input_face)).collect();
    assert_eq!(names, [("first", None), ("second", None)]);
    assert_eq!(scene.faces[0].vector_area(), DVec3::Z);
    let [.., third, fourth] = scene.faces[1].corners;
    assert_eq!(third, fourth, "a triangle repeats its third corner");
    assert!(scene.name.ends_with("a.obj"));
}

#[test]
fn kd_and_ke_become_reflectance_and_emission() {
    let faces = "S usemtl lamp; f 1 2 3 4; usemtl wall; f 4 3 2 1; usemtl lamp; f 1 2 3;";
    let materials = "newmtl wall; Kd 0.1 0.2 0.3; newmtl lamp; \tKd 0.5 # grey;   Ke 1 2 3;";
    let scene = with_materials(faces, materials, &ImportOptions::default());
    let lamp = (Vec3::splat(0.5), Vec3::new(1., 2., 3.) * PI);
    let wall = (Vec3::new(0.1, 0.2, 0.3), Vec3::ZERO);
    let found: Vec<_> = scene.faces.iter().map(|f| (f.reflectance, f.emission)).collect();
    assert_eq!(found, [lamp, wall, lamp]);
    assert_eq!(scene.notes, [""; 0]);
}

#[test]
fn reflectance_of_one_is_lowered_with_one_note() {
    let faces = "S usemtl b; f 1 2 3 4; usemtl a; f 4 3 2 1; usemtl c; f 1 2 3; usemtl b; f 1 2 4;";
    let materials = "newmtl a; Kd 1 1 1; newmtl b; Kd 0.5 1 0; newmtl c; Kd 0.95; newmtl unused; Kd 1;";
    let scene = with_materials(faces, materials, &ImportOptions::default());
    let [white, green] = [Vec3::splat(0.95), Vec3::new(0.5, 0.95, 0.0)];
    assert_eq!(reflectances(&scene), [green, white, white, green]);
    assert_eq!(scene.notes, ["materials a, b reflect all light: taken as 0.95"]);
}

#[test]
fn reflectance_option_replaces_materials() {
    let given = Vec3::new(0.1, 0.99, 0.0);
    let options = ImportOptions {
        reflectance: Some(given),
        two_sided: true,
        ..Default::default()
    };
    let white = "newmtl lamp; Kd 1.5 1 1; Ke 1 2 3;";
    let scene = with_materials("S f 1 2 3; usemtl lamp; f 1 2 3 4;", white, &options);
    assert_eq!(reflectances(&scene), [given; 4]);
    assert_eq!(scene.faces[1].emission, Vec3::new(1., 2., 3.) * PI);
    // White is no matter where it is replaced.
    assert_eq!(scene.notes, ["1 face without material: no emission (1)"]);
}

/// The same square: other indices, slashes, a continued line, comments, no last newline, order, colours and weights.
const SAME_SQUARE: &str = "
S f -4 -3 -2 -1;
S vt 0 0; vn 0 0 1; f 1/1/1 2/1/1 3//1 4/1;
S f 1// 2// 3// 4//;
S f 1//7 2//8 3//9 4//9;
S f 1 2 \\; 3 4;
# a; S f 1 2 3 4 # last;
S f 1 2 3 4
f 1 2 3 4; S ;
\u{feff}S f 1 2 3 4;
v 0 0 0 1 0 0; v 1 0 0; v 1 1 0 nan nan nan; v 0 1 0; f 1 2 3 4;
v 0 0 0 1; v 2 0 0 2; v 1 1 0; v 0 3 0 3; f 1 2 3 4;
";

#[test]
fn variants_of_lines_give_equal_corners() {
    let plain = text_lines("S f 1 2 3 4;");
    let expected = corners(&scene(&plain));
    for text in SAME_SQUARE.lines().filter(|text| !text.is_empty()) {
        assert_eq!(corners(&scene(text)), expected, "{text}");
    }
    let tabs = plain.replace("v ", " v\t").replace("f 1 2", "\tf\t1  2");
    for text in [plain.replace('\n', "\r\n"), tabs] {
        assert_eq!(corners(&scene(&text)), expected, "{text}");
    }
}

#[test]
fn names_may_contain_spaces_and_hashes() {
    let text = text_lines("mtllib my room.mtl; S g part #1; usemtl matt  white #2; f 1 2 3 4;");
    let folder = Folder::new()
        .with("a.obj", text)
        .with("my room.mtl", "newmtl matt white #2\nKd .5 .5 .5\n");
    let face = &folder.load("a.obj").expect("a scene").faces[0];
    assert_eq!((face.name.as_str(), face.reflectance.x), ("part #1", 0.5));
}

#[test]
fn several_libraries_on_one_line_are_read() {
    let text = text_lines("mtllib a.mtl b.mtl; S usemtl b; f 1 2 3 4; usemtl a; f 1 2 3;");
    let folder = Folder::new()
        .with("a.obj", text)
        .with("a.mtl", "newmtl a\nKd 0.1\n")
        .with("b.mtl", "newmtl b\nKd 0.2\n");
    let found = reflectances(&folder.load("a.obj").expect("a scene"));
    assert_eq!(found, [Vec3::splat(0.2), Vec3::splat(0.1)]);
}

#[test]
fn split_face_keeps_its_index() {
    let pentagon = "v 0 0 1; v 2 0 1; v 2 1 1; v 1 2 1; v 0 1 1;";
    let bent = "v 0 0 5; v 1 0 5; v 1 1 5.1; v 0 1 5;";
    let faces = "f 1 2 3 4 5; f 6 7 8 9; f 10 11 12 13; f 6 7 8;";
    let scene = scene(&format!("{pentagon}S {bent}{faces}"));
    let from: Vec<_> = scene.faces.iter().map(|f| f.input_face).collect();
    assert_eq!(from, [Some(0), None, Some(2), None, Some(0), Some(0), Some(2)]);
    let shapes: Vec<_> = scene.faces.iter().map(|f| f.shape == Shape::Quad).collect();
    assert_eq!(shapes, [false, true, false, false, false, false, false]);
    let pieces = |k: u32| scene.faces.iter().filter(move |f| f.input_face == Some(k));
    let area = |k: u32| pieces(k).map(|f| f.vector_area().z).sum::<f64>();
    assert_eq!((area(0), area(2)), (3.0, 1.0));
    let told = [
        "1 face not planar: split into two triangles (3)",
        "1 face with more than four corners: split into triangles (1)",
    ];
    assert_eq!(notes(&scene, "split"), told);
}

#[test]
fn backs_follow_all_faces() {
    let options = ImportOptions {
        two_sided: true,
        ..Default::default()
    };
    let dart = "v 0 0 0; v 2 0 0; v 0.5 0.5 0; v 0 2 0; f 1 2 3 4; f 1 2 4;";
    let scene = with_materials(dart, "", &options);
    // A concave quad is cut at its reflex corner.
    assert_eq!(notes(&scene, "not convex").len(), 1);
    assert!(scene.faces[..3].iter().all(|f| f.vector_area().z > 0.4));
    let from: Vec<_> = scene.faces.iter().map(|f| f.input_face).collect();
    assert_eq!(from, [Some(0), None, Some(0), Some(0), Some(1), Some(0)]);
    for (front, back) in scene.faces.iter().zip(&scene.faces[3..]) {
        assert_eq!(back.vector_area(), -front.vector_area());
        assert_eq!((back.shape, back.corners[0]), (front.shape, front.corners[0]));
        assert_eq!((back.emission, back.reflectance), (front.emission, front.reflectance));
        let partner = back.partner.map(|k| &scene.faces[k as usize].corners);
        assert_eq!(partner, Some(&front.corners));
    }
}

/// Lines after a first face, the number of faces that they make, and a note on them.
const NOTES: [(&str, usize, &str); 5] = [
    ("", 0, "1 face without material: reflectance 0.7, no emission (1)"),
    ("p 1; l 1 2 3 4; f 1 2; f;", 0, "4 points and lines left out"),
    (
        "v 1 1 0; f 1 2 3 5;",
        1,
        "1 face with a repeated corner, which counts once (2)",
    ),
    ("f 1 2 2; f 3 3 3 3; f 1 2 1 2;", 3, "3 faces without area: L (2, 3, 4)"),
    ("DDDDDDD", 7, "7 faces without area: L (2, 3, 4, 5, 6, 7, …)"),
];

#[test]
fn odd_faces_are_noted() {
    for (lines, count, note) in NOTES {
        let scene = scene(&format!("S f 1 2 3 4; {}", lines.replace('D', "f 1 1 2; ")));
        let note = note.replace('L', "neither lit nor lighting");
        assert!(scene.notes.contains(&note), "{note}: {:?}", scene.notes);
        let first = &scene.faces[0];
        assert_eq!((first.reflectance, first.emission), (Vec3::splat(0.7), Vec3::ZERO));
        let areas: Vec<f64> = scene.faces.iter().map(|f| f.area()).collect();
        let area = if note.contains("repeated") { 0.5 } else { 0.0 };
        assert_eq!((areas[0], &areas[1..]), (1.0, &vec![area; count][..]), "{note}");
    }
}

#[test]
fn glossy_and_black_materials_are_noted() {
    let faces = "S usemtl a; f 1 2 3 4; usemtl b; f 1 2 3; usemtl c; f 1 2 3; usemtl d; f 1 2 3;";
    let materials = "newmtl a; Kd 0.5; Ks 0 0 0; illum 2; d 1; newmtl b; Kd 0.5; Ks 0 0.1 0; \
        newmtl c; Kd 0.5; illum 5; newmtl d; Kd 0.5; d 0.5; Ns many; newmtl unused; illum 9;";
    let glossy = "materials of which only Kd and Ke are used, not Ks, illum or d: b, c, d";
    let options = ImportOptions::default();
    assert_eq!(with_materials(faces, materials, &options).notes, [glossy]);
    let black = with_materials("S usemtl a; f 1 2 3 4;", "newmtl a; Ka 1 1 1;", &options);
    assert_eq!(black.faces[0].reflectance, Vec3::ZERO);
    assert_eq!(notes(&black, "black").len(), 1);
    // Unused materials and vertices may be invalid.
    let unused = "newmtl a; Kd 0.5; newmtl mirror; Kd 1; map_Kd x.png;";
    let scene = with_materials("S v nan inf 0; usemtl a; f 1 2 3 4;", unused, &options);
    assert_eq!(scene.faces.len(), 1);
}

#[test]
fn normals_are_kept_if_every_corner_has_one() {
    // Behind the first face, missing, nonexistent, zero and non-numeric normals.
    let scene = scene(
        "S vn 0 0 2; vn 0 0.6 0.8; vn 0 0 0; vn 0 x 1; f 1//1 2//1 3/9/2 4//-3; f 1//1 2//1 3; f 1//1 2//1 3//5; \
         f 1//1 2//1 3//3; f 1//1 2//1 3//4; f 1//1 2//1 3//-9; f 1//1 2//1 3//0;",
    );
    let [up, bent] = [Vec3::Z, Vec3::new(0.0, 0.6, 0.8)];
    assert_eq!(scene.faces[0].corner_normals, Some([up, up, bent, bent]));
    assert!(scene.faces[1..].iter().all(|face| face.corner_normals.is_none()));
    let turned = scene.faces[0].reversed();
    assert_eq!(turned.corner_normals, Some([-up, -bent, -bent, -up]));
}

#[test]
fn polygon_pieces_have_its_normals() {
    let scene = scene("S v -1 0.5 0; vn 0 0 1; vn 1 0 0; f 1//1 2//1 3//1 4//1 5//2;");
    assert_eq!(scene.faces.len(), 3);
    for face in &scene.faces {
        let normals = face.corner_normals.expect("normals");
        for (corner, normal) in face.corners.iter().zip(normals) {
            let own = if corner.x < 0.0 { Vec3::X } else { Vec3::Z };
            assert_eq!(normal, own);
        }
    }
}

#[test]
fn vertex_colours_become_reflectance() {
    let told = ["colours of vertices are taken as sRGB, and multiply Kd"];
    let (half, dark) = (from_srgb(0.5) as f32, from_srgb(0.25) as f32);
    let even = scene("v 0 0 0 .5 0 .25; v 1 0 0 .5 0 .25; v 0 1 0 .5 0 .25; f 1 2 3;");
    assert_eq!(notes(&even, "colours"), told);
    assert_eq!(notes(&even, "without material"), [""; 0]);
    let colour = Vec3::new(half, 0.0, dark);
    assert!(even.faces[0].reflectance.abs_diff_eq(colour, 1e-6));
    assert!(even.faces[0].paint.is_none());
    // A vertex without a colour is white, one that comes after the face changes nothing of it, and a mean is
    // that of the corners.
    let mixed = scene("v 0 0 0 .5 .5 .5; v 1 0 0; v 0 1 0 .5 .5 .5; f -3 -2 -1; v 9 9 9 0 0 0;");
    let mean = Vec3::splat((2.0 * half + MAX_WHITE_REFLECTANCE) / 3.0);
    assert!(mixed.faces[0].reflectance.abs_diff_eq(mean, 1e-6));
    assert!(mixed.faces[0].paint.is_some());
    assert_eq!(notes(&scene("S f 1 2 3 4;"), "colours"), [""; 0]);
    let weighed = obj("v 0 0 0 1; v 1 0 0 .5 .5 .5; v 0 1 0; f 1 2 3;");
    assert!(weighed.is_err_and(|error| error.to_string().contains("line 1: has a weight")));
}
