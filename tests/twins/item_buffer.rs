//! The per-pixel item buffer equals rays: the bound of a face's image misses no pixel and is tight; projections
//! and their inverses agree.

use common::constants::OUTLINE_MARGIN;
use common::intersect::intersect_face;
use common::mesh::Mesh;
use common::scene::Face;
use common::settings::{ItemBufferProjection, ItemBufferSettings};
use cpu::shader_twins::hemicube::{facing_side, project_to_side, side_height, unfold_side};
use cpu::shader_twins::image_bound::{image_bound, is_hidden_face};
use cpu::shader_twins::item_buffer::ItemBuffer;
use cpu::shader_twins::projection::{is_covered, pixel_centre, pixel_position, project_direction, unproject_point};
use cpu::shader_twins::view::ShooterView;
use glam::{DVec3, Vec2, Vec3};
use oracle::compare::visibility::subdivide_edge;
use properties::strategies::open_room;
use proptest::prelude::*;
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::{named_scene, paper_room, random_cases};

const PROJECTIONS: [ItemBufferProjection; 3] = [
    ItemBufferProjection::Hemisphere,
    ItemBufferProjection::Stereographic,
    ItemBufferProjection::Hemicube,
];

fn drawing_settings(projection: ItemBufferProjection, size: u32) -> ItemBufferSettings {
    ItemBufferSettings {
        projection,
        size,
        ..ItemBufferSettings::DEFAULT
    }
}

/// Intersects every pixel's ray with every face, without bounds; the first of equals stays.
fn intersect_all_faces(mesh: &Mesh, view: &ShooterView) -> Vec<u32> {
    let n = view.size;
    (0..n * n)
        .map(|k| {
            let p = pixel_centre(k % n, k / n, n);
            let mut nearest = (0, f32::INFINITY);
            for (id, face) in mesh.faces.iter().enumerate() {
                let ray = view.frame.to_world(unproject_point(view.projection, p));
                let hit = intersect_face(face, view.frame.centre, ray);
                let met = hit.t > 0.0 && hit.inside >= -OUTLINE_MARGIN;
                if met && hit.t < nearest.1 && !is_hidden_face(view, face) {
                    nearest = (id as u32 + 1, hit.t);
                }
            }
            if is_covered(view.projection, p, n) {
                nearest.0
            } else {
                0
            }
        })
        .collect()
}

fn assert_ids_equal_rays(mesh: &Mesh, size: u32) {
    for projection in PROJECTIONS {
        for k in 0..mesh.patches.len() as u32 {
            let view = ShooterView::new(mesh, k, 0, &drawing_settings(projection, size));
            let drawn = ItemBuffer::draw_faces(mesh, &view, mesh.room_faces).ids;
            let wrong = drawn
                .iter()
                .zip(intersect_all_faces(mesh, &view))
                .enumerate()
                .find(|(_, (a, b))| **a != *b);
            assert_eq!(wrong, None, "{projection:?}, cell {k}");
        }
    }
}

proptest! {
    #![proptest_config(random_cases(24))]

    #[test]
    fn item_buffer_of_random_room_equals_rays(sample in open_room(), size in 16u32..80) {
        let mesh = Mesh::uniform(&sample.scene, 2, sample.patches.min(2)).unwrap();
        assert_ids_equal_rays(&mesh, size);
    }
}

/// The image of a plate that fills the view, has the pole in it and bulges beyond its corners.
#[test]
fn bound_holds_plate_around_the_pole() {
    let quad = |c| Face::quad("", c, Vec3::ONE, Vec3::ONE);
    let floor = quad(rectangle([-0.1, -0.1, 0.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0]));
    let above = quad(rectangle([-1.0, -1.0, 0.3], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]));
    // Crosses the horizon, stands almost on the shooter's centre.
    let post = quad(rectangle([-1e-4, -0.9, -0.5], [0.0, 1.8, 0.0], [0.0, 0.0, 0.7]));
    let tilted = quad([
        DVec3::new(0.5, -1.0, -0.3),
        DVec3::new(0.9, 1.0, 0.25),
        DVec3::new(0.4, 1.0, 0.28),
        DVec3::new(0.1, -1.0, 0.0),
    ]);
    for others in [vec![above.clone()], vec![post.clone()], vec![tilted], vec![post, above]] {
        let mut faces = vec![floor.clone()];
        faces.extend(others);
        let mut mesh = Mesh::uniform(&named_scene("plate", faces), 2, 2).unwrap();
        mesh.patches.truncate(4);
        for size in [16, 63, 300] {
            assert_ids_equal_rays(&mesh, size);
        }
    }
}

/// A floor of 0.02 × 0.02 at the origin, and a parallelogram or triangle of any size near it.
fn floor_and_polygon() -> impl Strategy<Value = Vec<Face>> {
    let number = || -1.0f64..1.0;
    let vector = move || prop::array::uniform3(number()).prop_map(DVec3::from);
    (vector(), vector(), vector(), -4.0f64..0.0, any::<bool>())
        .prop_filter("the corners are not sharp", |(_, u, v, _, _)| {
            u.length() > 0.1 && v.length() > 0.1 && u.normalize().cross(v.normalize()).length() > 0.5
        })
        .prop_map(|(corner, u, v, scale, triangle)| {
            let scale = 10f64.powf(scale);
            // Half of them straddle the shooter's axis.
            let c = (corner - if triangle { (u + v) / 3.0 } else { DVec3::ZERO }) * scale;
            let (u, v) = (u * scale, v * scale);
            let black = |c: &[DVec3]| match *c {
                [a, b, c] => Face::triangle("", [a, b, c], Vec3::ZERO, Vec3::ZERO),
                _ => Face::quad("", [c[0], c[1], c[2], c[3]], Vec3::ZERO, Vec3::ZERO),
            };
            let low = rectangle([-0.01, -0.01, 0.0], [0.02, 0.0, 0.0], [0.0, 0.02, 0.0]);
            let high = [c, c + u, c + u + v, c + v];
            vec![black(&low), black(if triangle { &high[..3] } else { &high })]
        })
}

proptest! {
    #![proptest_config(random_cases(2000))]

    /// Pixels too small to hide behind: the outline itself, as wide as rays see it, lies in the bound.
    #[test]
    fn bound_holds_widened_outline(faces in floor_and_polygon()) {
        let mesh = Mesh::uniform(&named_scene("near", faces), 1, 1).unwrap();
        let face = &mesh.faces[1];
        for projection in PROJECTIONS {
            let view = ShooterView::new(&mesh, 0, 0, &drawing_settings(projection, 1 << 20));
            if is_hidden_face(&view, face) {
                continue;
            }
            for (k, i) in (0..4).flat_map(|k| (0..=200).map(move |i| (k, i))) {
                let [a, b] = [k, (k + 1) % 4].map(|k| face.corners[k] - view.frame.centre);
                let t = subdivide_edge(a, b, i as f32 / 200.0);
                let p = a * (1.0 - t) + b * t - face.edges[k].truncate() * OUTLINE_MARGIN;
                let v = view.frame.rotate_to_local(p);
                if v.z < 0.0 {
                    continue;
                }
                let cube = projection == ItemBufferProjection::Hemicube;
                let steep = v.z >= v.truncate().abs().max_element();
                let side = if cube && !steep { facing_side(v.truncate()) } else { 0 };
                let p = if cube { project_to_side(side, v, side_height(side, v)) } else { project_direction(projection, v) };
                let limits = image_bound(&view, face, side);
                let out = Vec2::new(limits.x, limits.y) - p;
                let out = out.max(p - Vec2::new(limits.z, limits.w)).max_element();
                prop_assert!(out < 1e-5, "{projection:?}, side {side}: {p} not in {limits}");
            }
        }
    }
}

#[test]
fn bound_is_tight() {
    let mesh = Mesh::uniform(&paper_room(), 1, 1).unwrap();
    for projection in PROJECTIONS {
        let view = ShooterView::new(&mesh, 12, 0, &drawing_settings(projection, 1024));
        let mut asked = 0.0;
        for face in &mesh.faces {
            for side in 0..projection.plane_count() {
                let b = image_bound(&view, face, side);
                let p = pixel_position(unfold_side(side, Vec2::new(b.x, b.y)), view.size);
                let q = pixel_position(unfold_side(side, Vec2::new(b.z, b.w)), view.size);
                if b.x < b.z && b.y < b.w {
                    asked += f64::from(((p - q).x * (p - q).y).abs());
                }
            }
        }
        let drawn = ItemBuffer::draw_faces(&mesh, &view, mesh.room_faces).ids;
        let shown = drawn.iter().filter(|id| **id != 0).count() as f64;
        assert!(asked < 2.5 * shown, "{projection:?}: {asked} of {shown}");
    }
}

#[test]
fn unprojected_pixel_projects_to_its_centre() {
    for projection in PROJECTIONS {
        for size in [16, 17, 64, 1024] {
            for k in (0..size * size).step_by(7) {
                let p = pixel_centre(k % size, k / size, size);
                // Beyond a fold the image of the ray lies on the other side.
                let beyond = projection == ItemBufferProjection::Hemicube
                    && p.abs().max_element() > 0.5
                    && p.abs().min_element() > 0.5;
                if is_covered(projection, p, size) && !beyond {
                    let ray = unproject_point(projection, p);
                    assert!(ray.z >= 0.0);
                    let back = project_direction(projection, ray);
                    assert!(back.distance(p) < 1e-3 / size as f32, "{projection:?} {p} {back}");
                }
            }
        }
    }
}

#[test]
fn hemicube_direction_lies_on_facing_side() {
    let points = [
        (Vec3::new(0.0, 0.0, 1.0), Vec2::ZERO),
        (Vec3::new(1.0, 1.0, 1.0), Vec2::new(0.5, 0.5)),
        (Vec3::new(1.0, 0.0, 1.0), Vec2::new(0.5, 0.0)),
        (Vec3::new(2.0, 1.0, 0.0), Vec2::new(1.0, 0.25)),
        (Vec3::new(-2.0, 1.0, 1.0), Vec2::new(-0.75, 0.25)),
        (Vec3::new(1.0, 2.0, 0.0), Vec2::new(0.25, 1.0)),
        (Vec3::new(1.0, -2.0, 1.0), Vec2::new(0.25, -0.75)),
    ];
    for (v, p) in points {
        assert_eq!(project_direction(ItemBufferProjection::Hemicube, v), p, "{v}");
    }
    assert_eq!(facing_side(Vec2::new(-1.0, 0.5)), 2);
    assert_eq!(facing_side(Vec2::new(0.5, -1.0)), 4);
}
