//! The per-pixel item buffer holds what rays see: the bound of a face's image misses no pixel, and
//! is tight enough to pay; projections and their inverses are each other's.

use common::constants::OUTLINE;
use common::intersect::intersect;
use common::mesh::Mesh;
use common::scene::Face;
use common::settings::{Drawing, Projection, Raster};
use cpu::twin::bound::{bound, hidden};
use cpu::twin::hemicube::{height, on_side, place, side_of};
use cpu::twin::item_buffer::ItemBuffer;
use cpu::twin::projection::{covered, pixel_centre, pixels, project, unproject};
use cpu::twin::tessellate::spread;
use cpu::twin::view::View;
use glam::{DVec3, Vec2, Vec3};
use proptest::prelude::*;
use radiosity_tests::pairs::rectangle;
use radiosity_tests::{box_in_room, cases, paper_room, random, scene};

const PROJECTIONS: [Projection; 3] = [
    Projection::Hemisphere(Raster::Pixel),
    Projection::Stereographic(Raster::Pixel),
    Projection::Hemicube,
];

fn drawing(projection: Projection, size: u32) -> Drawing {
    Drawing {
        projection,
        size,
        ..Drawing::DEFAULT
    }
}

/// Every pixel's ray against every face, no bounds; the first of equals stays.
fn brute_force(mesh: &Mesh, view: &View) -> Vec<u32> {
    let n = view.size;
    (0..n * n)
        .map(|k| {
            let p = pixel_centre(k % n, k / n, n);
            let mut nearest = (0, f32::INFINITY);
            for (id, face) in mesh.faces.iter().enumerate() {
                let ray = view.frame.to_world(unproject(view.projection, p));
                let hit = intersect(face, view.frame.centre, ray);
                let met = hit.t > 0.0 && hit.inside >= -OUTLINE;
                if met && hit.t < nearest.1 && !hidden(view, face) {
                    nearest = (id as u32 + 1, hit.t);
                }
            }
            if covered(view.projection, p, n) {
                nearest.0
            } else {
                0
            }
        })
        .collect()
}

fn holds_what_rays_see(mesh: &Mesh, size: u32) {
    for projection in PROJECTIONS {
        for k in 0..mesh.cells.len() as u32 {
            let view = View::new(mesh, k, 0, &drawing(projection, size));
            let drawn = ItemBuffer::draw(mesh, &view, mesh.room).ids;
            let wrong = drawn
                .iter()
                .zip(brute_force(mesh, &view))
                .enumerate()
                .find(|(_, (a, b))| **a != *b);
            assert_eq!(wrong, None, "{projection:?}, cell {k}");
        }
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn random_rooms_are_drawn_as_rays_see_them(sample in random::open(), size in 16u32..80) {
        let mesh = Mesh::uniform(&sample.scene, 2, sample.cells.min(2)).unwrap();
        holds_what_rays_see(&mesh, size);
    }
}

#[test]
fn rooms_are_drawn_as_rays_see_them() {
    holds_what_rays_see(&Mesh::uniform(&box_in_room(), 3, 3).unwrap(), 100);
    let mut mesh = Mesh::uniform(&paper_room(), 1, 1).unwrap();
    // Wall, lamp, and between them.
    mesh.cells = [12, 60, 152, 155].map(|k| mesh.cells[k]).to_vec();
    holds_what_rays_see(&mesh, 256);
}

/// The image of a plate that fills the view, has the pole in it and bulges beyond its corners.
#[test]
fn a_plate_overhead_bulges_beyond_its_corners() {
    let quad = |c| Face::quad("", c, Vec3::ONE, Vec3::ONE);
    let floor = quad(rectangle(
        [-0.1, -0.1, 0.0],
        [0.2, 0.0, 0.0],
        [0.0, 0.2, 0.0],
    ));
    let above = quad(rectangle(
        [-1.0, -1.0, 0.3],
        [0.0, 2.0, 0.0],
        [2.0, 0.0, 0.0],
    ));
    // Crosses the horizon, stands almost on the shooter's centre.
    let post = quad(rectangle(
        [-1e-4, -0.9, -0.5],
        [0.0, 1.8, 0.0],
        [0.0, 0.0, 0.7],
    ));
    let tilted = quad([
        DVec3::new(0.5, -1.0, -0.3),
        DVec3::new(0.9, 1.0, 0.25),
        DVec3::new(0.4, 1.0, 0.28),
        DVec3::new(0.1, -1.0, 0.0),
    ]);
    for others in [
        vec![above.clone()],
        vec![post.clone()],
        vec![tilted],
        vec![post, above],
    ] {
        let mut faces = vec![floor.clone()];
        faces.extend(others);
        let mut mesh = Mesh::uniform(&scene("plate", faces), 2, 2).unwrap();
        mesh.cells.truncate(4);
        for size in [16, 63, 300] {
            holds_what_rays_see(&mesh, size);
        }
    }
}

/// A floor of 0.02 × 0.02 at the origin, and a parallelogram or triangle of any size near it.
fn faces() -> impl Strategy<Value = Vec<Face>> {
    let number = || -1.0f64..1.0;
    let vector = move || prop::array::uniform3(number()).prop_map(DVec3::from);
    (vector(), vector(), vector(), -4.0f64..0.0, any::<bool>())
        .prop_filter("the corners are not sharp", |(_, u, v, _, _)| {
            u.length() > 0.1
                && v.length() > 0.1
                && u.normalize().cross(v.normalize()).length() > 0.5
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
            vec![
                black(&low),
                black(if triangle { &high[..3] } else { &high }),
            ]
        })
}

proptest! {
    #![proptest_config(cases(2000))]

    /// Pixels too small to hide behind: the outline itself, as wide as rays see it, lies in the bound.
    #[test]
    fn the_bound_holds_the_widened_outline(faces in faces()) {
        let mesh = Mesh::uniform(&scene("near", faces), 1, 1).unwrap();
        let face = &mesh.faces[1];
        for projection in PROJECTIONS {
            let view = View::new(&mesh, 0, 0, &drawing(projection, 1 << 20));
            if hidden(&view, face) {
                continue;
            }
            for (k, i) in (0..4).flat_map(|k| (0..=200).map(move |i| (k, i))) {
                let [a, b] = [k, (k + 1) % 4].map(|k| face.corners[k] - view.frame.centre);
                let t = spread(a, b, i as f32 / 200.0);
                let p = a * (1.0 - t) + b * t - face.edges[k].truncate() * OUTLINE;
                let v = view.frame.turn(p);
                if v.z < 0.0 {
                    continue;
                }
                let cube = projection == Projection::Hemicube;
                let steep = v.z >= v.truncate().abs().max_element();
                let side = if cube && !steep { side_of(v.truncate()) } else { 0 };
                let p = if cube { on_side(side, v, height(side, v)) } else { project(projection, v) };
                let limits = bound(&view, face, side);
                let out = Vec2::new(limits.x, limits.y) - p;
                let out = out.max(p - Vec2::new(limits.z, limits.w)).max_element();
                prop_assert!(out < 1e-5, "{projection:?}, side {side}: {p} not in {limits}");
            }
        }
    }
}

#[test]
fn the_bound_is_tight() {
    let mesh = Mesh::uniform(&paper_room(), 1, 1).unwrap();
    for projection in PROJECTIONS {
        let view = View::new(&mesh, 12, 0, &drawing(projection, 1024));
        let mut asked = 0.0;
        for face in &mesh.faces {
            for side in 0..projection.sides() {
                let b = bound(&view, face, side);
                let p = pixels(place(side, Vec2::new(b.x, b.y)), view.size);
                let q = pixels(place(side, Vec2::new(b.z, b.w)), view.size);
                if b.x < b.z && b.y < b.w {
                    asked += f64::from(((p - q).x * (p - q).y).abs());
                }
            }
        }
        let drawn = ItemBuffer::draw(&mesh, &view, mesh.room).ids;
        let shown = drawn.iter().filter(|id| **id != 0).count() as f64;
        println!(
            "{projection:?}: {:.2} pixels asked for each shown",
            asked / shown
        );
        assert!(asked < 2.5 * shown, "{projection:?}: {asked} of {shown}");
    }
}

#[test]
fn a_pixel_s_ray_comes_back_to_its_centre() {
    for projection in PROJECTIONS {
        for size in [16, 17, 64, 1024] {
            for k in (0..size * size).step_by(7) {
                let p = pixel_centre(k % size, k / size, size);
                // Beyond a fold the image of the ray lies on the other side.
                let beyond = projection == Projection::Hemicube
                    && p.abs().max_element() > 0.5
                    && p.abs().min_element() > 0.5;
                if covered(projection, p, size) && !beyond {
                    let ray = unproject(projection, p);
                    assert!(ray.z >= 0.0);
                    let back = project(projection, ray);
                    assert!(
                        back.distance(p) < 1e-3 / size as f32,
                        "{projection:?} {p} {back}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_direction_lies_on_the_side_that_it_points_to() {
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
        assert_eq!(project(Projection::Hemicube, v), p, "{v}");
    }
    assert_eq!(side_of(Vec2::new(-1.0, 0.5)), 2);
    assert_eq!(side_of(Vec2::new(0.5, -1.0)), 4);
}
