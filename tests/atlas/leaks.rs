//! No light leaks through a wall: two rooms that share a wall, one lit and one dark.

use common::scene::{Face, Scene};
use common::settings::Visibility;
use glam::{DQuat, DVec3, EulerRot, Vec3};
use radiosity::studies::stress::cases::shapes::cut_face;
use radiosity_tests::engines::{gpu_solver, item_buffer, mesh_scene, settings_of, shoot_freely, shoot_on_cpu};
use radiosity_tests::{box_faces, halve_quads, named_scene};

/// The division of the wall in the lit room and in the dark one.
#[derive(Clone, Copy, Debug)]
enum Wall {
    /// One face of each.
    Whole,
    /// In 2 and in 7 parts: no corner of one is a corner of the other.
    Parts,
    /// In 7×3 quads and 3×2×2 triangles.
    Mixed,
    /// The lit room's alone, in parts that meet in T-vertices.
    Single,
    /// The lit room's alone, of 3×5×2 triangles.
    Triangles,
}

const WALLS: [Wall; 5] = [Wall::Whole, Wall::Parts, Wall::Mixed, Wall::Single, Wall::Triangles];

/// Makes two triangles of each quad.
fn triangles_of(quads: Vec<Face>) -> Vec<Face> {
    halve_quads(&named_scene("quads", quads)).faces
}

/// Makes the faces of the lit room, whose number is returned, then those of the dark one. Faces meet at edges and do not
/// overlap.
fn two_rooms(wall: Wall, thickness: f64, turned: bool) -> (Scene, u32) {
    let (near, far) = (thickness / 2.0, 1.0 + thickness / 2.0);
    let grey = Vec3::splat(0.7);
    let new = |low: f64, high: f64| {
        let (low, high) = (DVec3::new(low, 0.0, 0.0), DVec3::new(high, 1.0, 1.0));
        box_faces(low, high, true, Vec3::ZERO, grey)
    };
    let (mut lit, mut dark) = (new(-far, -near), new(near, far));
    lit[1].emission = Vec3::ONE;
    lit[2].emission = Vec3::splat(10.0);
    let (left, right) = (lit.remove(3), dark.remove(2));
    match wall {
        Wall::Whole => (lit.push(left), dark.push(right)).0,
        Wall::Parts => {
            lit.extend(cut_face(&left, [2, 1]));
            dark.extend(cut_face(&right, [1, 7]));
        }
        Wall::Mixed => {
            lit.extend(cut_face(&left, [7, 3]));
            dark.extend(triangles_of(cut_face(&right, [3, 2])));
        }
        Wall::Single => {
            let halves = cut_face(&left, [2, 1]);
            lit.extend(cut_face(&halves[0], [1, 2]));
            lit.extend(cut_face(&halves[1], [1, 7]));
        }
        Wall::Triangles => lit.extend(triangles_of(cut_face(&left, [3, 5]))),
    }
    let count = lit.len() as u32;
    lit.extend(dark);
    if turned {
        let turn = DQuat::from_euler(EulerRot::XYZ, 0.7123, -1.1931, 2.0177);
        let shift = DVec3::new(0.1237, 3.331, -0.777);
        for face in &mut lit {
            face.corners = face.corners.map(|p| turn * p + shift);
        }
    }
    (named_scene("two rooms", lit), count)
}

/// Returns the shares of the emitted power that the dark room and the lit room receive.
fn received_shares(
    (wall, thickness, turned): (Wall, f64, bool),
    counts: [u32; 3],
    visibility: Visibility,
    on_gpu: bool,
) -> [f64; 2] {
    let settings = settings_of(counts, visibility, 1e-2);
    let (scene, lit) = two_rooms(wall, thickness, turned);
    let mesh = mesh_scene(&scene, &settings);
    let run = if on_gpu {
        let mut engine = gpu_solver(&mesh, &settings.transport, &[]);
        shoot_freely(&mut engine, &settings.schedule)
    } else {
        shoot_on_cpu(&mesh, &settings)
    };
    let (mut sums, mut emitted) = ([0.0; 2], 0.0);
    for (texel, h) in mesh.texels.iter().zip(&run.field.irradiance) {
        sums[usize::from(texel.face < lit)] += f64::from(h.x * texel.area);
        emitted += f64::from(texel.emission.x * texel.area);
    }
    sums.map(|sum| sum / emitted)
}

/// The dark room receives exactly 0: a ray through the wall hits one of its faces, and fronts in one plane exchange
/// nothing.
fn assert_no_leak(rooms: (Wall, f64, bool), counts: [u32; 3], on_gpu: bool) {
    let [dark, light] = received_shares(rooms, counts, Visibility::Rays, on_gpu);
    assert!(light > 0.5, "{rooms:?} {counts:?}: {light}");
    assert_eq!(dark, 0.0, "{rooms:?} {counts:?}");
}

#[test]
fn cpu_rays_leak_no_light_through_walls() {
    for wall in WALLS {
        for thickness in [0.0, 1e-6, 1e-5, 1e-3, 1e-1] {
            for counts in [[4, 1, 1], [8, 4, 4]] {
                assert_no_leak((wall, thickness, false), counts, false);
            }
            for counts in [[4, 1, 1], [8, 4, 1], [4, 4, 4], [8, 4, 4]] {
                assert_no_leak((wall, thickness, true), counts, false);
            }
        }
    }
}

#[test]
fn gpu_rays_leak_no_light_through_walls() {
    for wall in [Wall::Parts, Wall::Triangles] {
        for (thickness, counts) in [(0.0, [4, 1, 1]), (1e-6, [4, 4, 4]), (0.0, [8, 4, 4])] {
            assert_no_leak((wall, thickness, true), counts, true);
        }
    }
}

/// Each pixel has its own ray, so that only rounding leaks: less than a thousandth.
#[test]
fn item_buffer_leaks_less_than_a_thousandth() {
    for (wall, thickness) in [(Wall::Parts, 1e-5), (Wall::Triangles, 0.0)] {
        let [dark, _] = received_shares((wall, thickness, true), [4, 4, 1], item_buffer(512), true);
        assert!(dark < 1e-3, "{wall:?} {thickness:e}: {dark:e}");
    }
}
