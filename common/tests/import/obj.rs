//! Import of each OBJ and MTL feature.

use super::files::{Folder, corners, notes, obj};
use common::import::{ImportOptions, from_srgb, load_scene};
use common::paint::MAX_WHITE_REFLECTANCE;
use common::scene::{Scene, Shape};
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

const SQUARE_VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn scene(text: &str) -> Scene {
    obj(text).expect("a scene")
}

fn with_materials(text: &str, materials: &str) -> Scene {
    Folder::new()
        .with("a.obj", text)
        .with("a.mtl", materials)
        .load("a.obj")
        .expect("a scene")
}

#[test]
fn quads_and_triangles_keep_corners_and_names() {
    let scene = scene(&format!("{SQUARE_VERTICES}o first\nf 1 2 3 4\ng second\nf 4 3 1\n"));
    assert_eq!(
        corners(&scene),
        [
            vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
            vec![[0., 1., 0.], [1., 1., 0.], [0., 0., 0.]],
        ]
    );
    assert_eq!(
        scene.faces.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(),
        ["first", "second"]
    );
    assert_eq!(
        scene.faces.iter().map(|f| f.input_face).collect::<Vec<_>>(),
        [None, None]
    );
    assert_eq!(scene.faces[0].vector_area(), DVec3::Z);
    assert_eq!(
        scene.faces[1].corners[3], scene.faces[1].corners[2],
        "a triangle repeats its third corner"
    );
    assert!(scene.name.ends_with("a.obj"));
}

#[test]
fn kd_and_ke_become_reflectance_and_emission() {
    let text = format!(
        "mtllib a.mtl\n{SQUARE_VERTICES}usemtl lamp\nf 1 2 3 4\nusemtl wall\nf 4 3 2 1\nusemtl lamp\nf 1 2 3\n"
    );
    let scene = with_materials(
        &text,
        "newmtl wall\nKd 0.1 0.2 0.3\nnewmtl lamp\n\tKd 0.5 # grey\n  Ke 1 2 3\n",
    );
    let [lamp, wall] = [
        (Vec3::splat(0.5), Vec3::new(1., 2., 3.) * PI),
        (Vec3::new(0.1, 0.2, 0.3), Vec3::ZERO),
    ];
    let found: Vec<_> = scene.faces.iter().map(|f| (f.reflectance, f.emission)).collect();
    assert_eq!(found, [lamp, wall, lamp]);
    assert_eq!(scene.notes, [""; 0]);
}

#[test]
fn reflectance_of_one_is_lowered_with_one_note() {
    let text = format!(
        "mtllib a.mtl\n{SQUARE_VERTICES}usemtl b\nf 1 2 3 4\nusemtl a\nf 4 3 2 1\nusemtl c\nf 1 2 3\nusemtl b\nf 1 2 4\n"
    );
    let materials = "newmtl a\nKd 1 1 1\nnewmtl b\nKd 0.5 1 0\nnewmtl c\nKd 0.95\nnewmtl unused\nKd 1\n";
    let scene = with_materials(&text, materials);
    let found: Vec<Vec3> = scene.faces.iter().map(|f| f.reflectance).collect();
    let [white, green] = [Vec3::splat(0.95), Vec3::new(0.5, 0.95, 0.0)];
    assert_eq!(found, [green, white, white, green]);
    assert_eq!(scene.notes, ["materials a, b reflect all light: taken as 0.95"]);
}

#[test]
fn reflectance_option_replaces_materials() {
    let text = format!("mtllib a.mtl\n{SQUARE_VERTICES}f 1 2 3\nusemtl lamp\nf 1 2 3 4\n");
    let folder = Folder::new()
        .with("a.obj", text)
        .with("a.mtl", "newmtl lamp\nKd 1.5 1 1\nKe 1 2 3\n");
    let given = Vec3::new(0.1, 0.99, 0.0);
    let options = ImportOptions {
        reflectance: Some(given),
        two_sided: true,
        ..Default::default()
    };
    let scene = load_scene(&folder.path("a.obj"), &options).expect("a scene");
    assert!(scene.faces.iter().all(|face| face.reflectance == given));
    assert_eq!(scene.faces[1].emission, Vec3::new(1., 2., 3.) * PI);
    assert_eq!(
        scene.notes,
        ["1 face without material: no emission (1)"],
        "white is no matter where it is replaced"
    );
}

#[test]
fn face_without_material_is_grey() {
    let scene = scene(&format!("{SQUARE_VERTICES}f 1 2 3 4\n"));
    assert_eq!(
        (scene.faces[0].reflectance, scene.faces[0].emission),
        (Vec3::splat(0.7), Vec3::ZERO)
    );
    assert_eq!(
        scene.notes,
        ["1 face without material: reflectance 0.7, no emission (1)"]
    );
}

#[test]
fn variants_of_vertex_lines_give_equal_corners() {
    let plain = corners(&scene(&format!("{SQUARE_VERTICES}f 1 2 3 4\n")));
    let others = [
        ("negative indices", format!("{SQUARE_VERTICES}f -4 -3 -2 -1\n")),
        (
            "texture coordinates and normals",
            format!("{SQUARE_VERTICES}vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3//1 4/1\n"),
        ),
        ("only slashes", format!("{SQUARE_VERTICES}f 1// 2// 3// 4//\n")),
        ("missing normals", format!("{SQUARE_VERTICES}f 1//7 2//8 3//9 4//9\n")),
        ("a continued line", format!("{SQUARE_VERTICES}f 1 2 \\\n3 4\n")),
        (
            "carriage returns",
            format!("{SQUARE_VERTICES}f 1 2 3 4\n").replace('\n', "\r\n"),
        ),
        (
            "tabs and spaces",
            format!("{SQUARE_VERTICES}\tf\t1  2 3\t4 \n").replace("v ", " v\t"),
        ),
        ("comments", format!("# a\n{SQUARE_VERTICES}f 1 2 3 4 # last\n")),
        ("no last newline", format!("{SQUARE_VERTICES}f 1 2 3 4")),
        ("a byte order mark", format!("\u{feff}{SQUARE_VERTICES}f 1 2 3 4\n")),
        ("vertices after the face", format!("f 1 2 3 4\n{SQUARE_VERTICES}")),
        (
            "colours",
            "v 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0 nan nan nan\nv 0 1 0\nf 1 2 3 4\n".into(),
        ),
        (
            "weights",
            "v 0 0 0 1\nv 2 0 0 2\nv 1 1 0\nv 0 3 0 3\nf 1 2 3 4\n".into(),
        ),
    ];
    for (what, text) in others {
        assert_eq!(corners(&scene(&text)), plain, "{what}");
    }
}

#[test]
fn names_may_contain_spaces_and_hashes() {
    let text = format!("mtllib my room.mtl\n{SQUARE_VERTICES}g part #1\nusemtl matt  white #2\nf 1 2 3 4\n");
    let folder = Folder::new()
        .with("a.obj", text)
        .with("my room.mtl", "newmtl matt white #2\nKd .5 .5 .5\n");
    let scene = folder.load("a.obj").expect("a scene");
    assert_eq!(
        (scene.faces[0].name.as_str(), scene.faces[0].reflectance.x),
        ("part #1", 0.5)
    );
}

#[test]
fn several_libraries_on_one_line_are_read() {
    let text = format!("mtllib a.mtl b.mtl\n{SQUARE_VERTICES}usemtl b\nf 1 2 3 4\nusemtl a\nf 1 2 3\n");
    let folder = Folder::new()
        .with("a.obj", text)
        .with("a.mtl", "newmtl a\nKd 0.1\n")
        .with("b.mtl", "newmtl b\nKd 0.2\n");
    let scene = folder.load("a.obj").expect("a scene");
    assert_eq!(
        scene.faces.iter().map(|f| f.reflectance.x).collect::<Vec<_>>(),
        [0.2, 0.1]
    );
}

#[test]
fn split_face_keeps_its_index() {
    let pentagon = "v 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 2 1\nv 0 1 1\n";
    let bent = "v 0 0 5\nv 1 0 5\nv 1 1 5.1\nv 0 1 5\n";
    let scene = scene(&format!(
        "{pentagon}{SQUARE_VERTICES}{bent}f 1 2 3 4 5\nf 6 7 8 9\nf 10 11 12 13\nf 6 7 8\n"
    ));
    let from: Vec<_> = scene.faces.iter().map(|f| f.input_face).collect();
    assert_eq!(from, [Some(0), None, Some(2), None, Some(0), Some(0), Some(2)]);
    let shapes: Vec<_> = scene.faces.iter().map(|f| f.shape == Shape::Quad).collect();
    assert_eq!(shapes, [false, true, false, false, false, false, false]);
    let area = |k: u32| {
        scene
            .faces
            .iter()
            .filter(|f| f.input_face == Some(k))
            .map(|f| f.vector_area().z)
            .sum::<f64>()
    };
    assert_eq!((area(0), area(2)), (3.0, 1.0));
    assert_eq!(
        notes(&scene, "split"),
        [
            "1 face not planar: split into two triangles (3)",
            "1 face with more than four corners: split into triangles (1)"
        ]
    );
}

#[test]
fn concave_quad_is_cut_at_its_reflex_corner() {
    let scene = scene("v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nf 1 2 3 4\n");
    assert_eq!(scene.faces.len(), 2);
    assert!(
        scene.faces.iter().all(|f| f.vector_area().z > 0.4),
        "{:?}",
        corners(&scene)
    );
    assert_eq!(notes(&scene, "not convex").len(), 1);
}

#[test]
fn backs_follow_all_faces() {
    let folder = Folder::new().with("a.obj", "v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nf 1 2 3 4\nf 1 2 4\n");
    let options = ImportOptions {
        two_sided: true,
        ..Default::default()
    };
    let scene = load_scene(&folder.path("a.obj"), &options).expect("a scene");
    let from: Vec<_> = scene.faces.iter().map(|f| f.input_face).collect();
    assert_eq!(from, [Some(0), None, Some(0), Some(0), Some(1), Some(0)]);
    for (front, back) in scene.faces.iter().zip(&scene.faces[3..]) {
        assert_eq!(back.vector_area(), -front.vector_area());
        assert_eq!(
            back.partner.map(|k| &scene.faces[k as usize].corners),
            Some(&front.corners)
        );
    }
}

#[test]
fn faces_without_area_keep_their_index() {
    let scene = scene(&format!("{SQUARE_VERTICES}f 1 2 2\nf 1 2 3 4\nf 3 3 3 3\nf 1 2 1 2\n"));
    assert_eq!(
        scene.faces.iter().map(|f| f.area()).collect::<Vec<_>>(),
        [0., 1., 0., 0.]
    );
    assert_eq!(
        notes(&scene, "without area"),
        ["3 faces without area: neither lit nor lighting (1, 3, 4)"]
    );
}

#[test]
fn notes_name_the_first_six_faces() {
    let scene = scene(&format!("{SQUARE_VERTICES}f 1 2 3\n{}", "f 1 1 2\n".repeat(9)));
    assert_eq!(
        notes(&scene, "without area"),
        ["9 faces without area: neither lit nor lighting (2, 3, 4, 5, 6, 7, …)"]
    );
}

#[test]
fn repeated_corner_counts_once() {
    let scene = scene(&format!("{SQUARE_VERTICES}v 1 1 0\nf 1 2 3 5\n"));
    assert_eq!(corners(&scene), [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]]]);
    assert_eq!(notes(&scene, "repeated corner").len(), 1);
}

#[test]
fn points_and_lines_are_skipped_with_a_note() {
    let scene = scene(&format!("{SQUARE_VERTICES}p 1\nl 1 2 3 4\nf 1 2\nf\nf 1 2 3 4\n"));
    assert_eq!(scene.faces.len(), 1);
    assert_eq!(notes(&scene, "points and lines"), ["4 points and lines left out"]);
}

#[test]
fn glossy_materials_are_noted_once() {
    let text = format!(
        "mtllib a.mtl\n{SQUARE_VERTICES}usemtl a\nf 1 2 3 4\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\nusemtl d\nf 1 2 3\n"
    );
    let materials = "newmtl a\nKd 0.5\nKs 0 0 0\nillum 2\nd 1\nnewmtl b\nKd 0.5\nKs 0 0.1 0\nnewmtl c\nKd 0.5\nillum 5\n\
        newmtl d\nKd 0.5\nd 0.5\nNs many\nnewmtl unused\nillum 9\n";
    let scene = with_materials(&text, materials);
    assert_eq!(
        scene.notes,
        ["materials of which only Kd and Ke are used, not Ks, illum or d: b, c, d"]
    );
}

#[test]
fn material_without_colours_is_black() {
    let text = format!("mtllib a.mtl\n{SQUARE_VERTICES}usemtl a\nf 1 2 3 4\n");
    let scene = with_materials(&text, "newmtl a\nKa 1 1 1\n");
    assert_eq!(scene.faces[0].reflectance, Vec3::ZERO);
    assert_eq!(notes(&scene, "black").len(), 1);
}

#[test]
fn unused_materials_and_vertices_are_ignored() {
    let text = format!("mtllib a.mtl\n{SQUARE_VERTICES}v nan inf 0\nusemtl a\nf 1 2 3 4\n");
    let scene = with_materials(&text, "newmtl a\nKd 0.5\nnewmtl mirror\nKd 1\nmap_Kd x.png\n");
    assert_eq!(scene.faces.len(), 1);
}

#[test]
fn quad_far_from_origin_stays_a_quad() {
    let scene = scene("v 1000000.25 0 0\nv 1000001.25 0 0\nv 1000001.25 1 0\nv 1000000.25 1 0\nf 1 2 3 4\n");
    assert_eq!((scene.faces[0].shape, scene.faces[0].area()), (Shape::Quad, 1.0));
}

#[test]
fn normals_are_kept_if_every_corner_has_one() {
    let text = "vn 0 0 2\nvn 0 0.6 0.8\nvn 0 0 0\nvn 0 x 1\n";
    let faces = "f 1//1 2//1 3/9/2 4//-3\nf 1//1 2//1 3\nf 1//1 2//1 3//5\nf 1//1 2//1 3//3\n\
        f 1//1 2//1 3//4\nf 1//1 2//1 3//-9\nf 1//1 2//1 3//0\n";
    let scene = scene(&format!("{SQUARE_VERTICES}{text}{faces}"));
    let [up, bent] = [Vec3::Z, Vec3::new(0.0, 0.6, 0.8)];
    assert_eq!(scene.faces[0].corner_normals, Some([up, up, bent, bent]));
    // Missing, nonexistent, zero and non-numeric normals.
    for face in &scene.faces[1..] {
        assert_eq!(face.corner_normals, None);
    }
    let turned = scene.faces[0].reversed();
    assert_eq!(turned.corner_normals, Some([-up, -bent, -bent, -up]));
}

#[test]
fn polygon_pieces_have_its_normals() {
    let scene = scene(&format!(
        "{SQUARE_VERTICES}v -1 0.5 0\nvn 0 0 1\nvn 1 0 0\nf 1//1 2//1 3//1 4//1 5//2\n"
    ));
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
    let even = "v 0 0 0 .5 0 .25\nv 1 0 0 .5 0 .25\nv 0 1 0 .5 0 .25\nf 1 2 3\n";
    let even = scene(even);
    assert_eq!(notes(&even, "colours"), told);
    assert_eq!(notes(&even, "without material"), [""; 0]);
    let colour = Vec3::new(half, 0.0, dark);
    assert!(even.faces[0].reflectance.abs_diff_eq(colour, 1e-6));
    assert!(even.faces[0].paint.is_none());
    // A vertex without a colour is white, one that comes after the face changes nothing of it, and a mean is
    // that of the corners.
    let mixed = scene("v 0 0 0 .5 .5 .5\nv 1 0 0\nv 0 1 0 .5 .5 .5\nf -3 -2 -1\nv 9 9 9 0 0 0\n");
    let mean = Vec3::splat((2.0 * half + MAX_WHITE_REFLECTANCE) / 3.0);
    assert!(mixed.faces[0].reflectance.abs_diff_eq(mean, 1e-6));
    assert!(mixed.faces[0].paint.is_some());
    let plain = scene(&format!("{SQUARE_VERTICES}f 1 2 3 4\n"));
    assert_eq!(notes(&plain, "colours"), [""; 0]);
    let weighed = obj("v 0 0 0 1\nv 1 0 0 .5 .5 .5\nv 0 1 0\nf 1 2 3\n");
    assert!(weighed.is_err_and(|error| error.to_string().contains("line 1: has a weight")));
}
