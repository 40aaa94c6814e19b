//! Pictures of a relit room: shading, cameras, degenerate input and files.

use approx::abs_diff_eq;
use common::scene::Face;
use common::solution::pixels::ImagePlanes;
use glam::{DVec3, Vec3};
use radiosity::relight::camera::{automatic_camera, camera_at};
use radiosity::relight::composite::render_composite;
use radiosity::relight::radiance::{RelitRadiance, welded_surface};
use radiosity::relight::{Backdrop, RelitScene, files};
use radiosity::report::view::interpolation::KnotCache;
use radiosity_tests::composites::{SolvedRoom, is_finite, pixel_bits, room_by_hand, square_floor};
use radiosity_tests::{ball, box_faces, lit_room, named_scene};
use std::f32::consts::PI;

#[test]
fn composite_of_a_scene_equals_its_full_render() {
    let solved = SolvedRoom::new(lit_room(), 6);
    let relit = solved.as_relit();
    let camera = automatic_camera(&relit);
    let c = render_composite(&relit, &camera, [90, 60], None);
    // With the relit room itself as the background there is no change to add.
    let full = render_composite(
        &RelitScene {
            before: &solved.after.radiosity,
            ..relit
        },
        &camera,
        [90, 60],
        None,
    );
    for (a, b) in c.composite.iter().zip(&full.composite) {
        assert!((*a - *b).length() < 1e-5 * (1.0 + b.length()), "{a} {b}");
    }
    let share = c.mask.iter().sum::<f32>() / c.mask.len() as f32;
    assert!(share > 0.02 && share < 0.7, "{share}");
    assert!(c.change.iter().any(|v| v.x < 0.0));
    assert!(is_finite(&c) && c.negative == 0);
    // The lamp is in the picture, but does not set the white point.
    let lamp = solved.scene.faces[1].emission / PI;
    let shown = c.background.iter().zip(&c.dark[0]);
    let bright = shown.filter(|(v, _)| v.cmpgt(lamp).all());
    assert!(bright.clone().count() > 100 && bright.clone().all(|(_, dark)| *dark < 0.5));
    let mut blind = c.clone();
    blind.dark = c.coverage.clone();
    assert!(files::choose_exposure(&c).white < 0.8 * files::choose_exposure(&blind).white);
}

/// Returns the radiance of a face at a point of the mesh.
fn radiance_at(renders: &RelitRadiance, face: u32, point: DVec3) -> Vec3 {
    let texel = renders.texel_at(face, point);
    renders.radiance_at(&renders.stencil_at(&mut KnotCache::default(), texel, point))
}

#[test]
fn light_is_continuous_over_edges_of_a_ball_but_not_of_a_box() {
    let step = |object: Vec<Face>| {
        let mut faces = vec![square_floor()];
        faces.extend(object);
        let value = |face: u32, p: DVec3| Vec3::splat(1.0 + face as f32 * 0.01 + p.y as f32);
        let solved = room_by_hand(named_scene("object", faces), 1, 1, value, value);
        let relit = solved.as_relit();
        let surface = welded_surface(&relit);
        let renders = RelitRadiance::new(&relit, &surface, false);
        let (mut largest, mut edges) = (0f32, 0);
        for (a, b) in surface.pairs.iter().copied() {
            for k in 0..surface.face_grids[a as usize].edge_count() {
                let [from, to] = surface.face_grids[a as usize].edge_ends(k);
                let both = (0..surface.face_grids[b as usize].edge_count()).any(|l| {
                    let [start, end] = surface.face_grids[b as usize].edge_ends(l);
                    start.distance(to) < 1e-6 && end.distance(from) < 1e-6
                });
                for share in [0.1, 0.3, 0.5, 0.8].into_iter().filter(|_| both) {
                    let point = from.lerp(to, share);
                    let [one, other] = [a, b].map(|face| radiance_at(&renders, face, point));
                    largest = largest.max((one - other).abs().max_element());
                    edges += 1;
                }
            }
        }
        (largest, edges)
    };
    let (largest, edges) = step(ball(DVec3::Y * 0.5, 0.4, [16, 16]));
    assert!(edges > 1000 && largest < 1e-5, "{largest} {edges}");
    let cube = box_faces(DVec3::ONE * 0.1, DVec3::ONE * 0.4, false, Vec3::ZERO, Vec3::ONE * 0.5);
    assert_eq!(step(cube).1, 0);
}

#[test]
fn noise_of_facets_is_averaged() {
    let mut faces = vec![square_floor()];
    faces.extend(ball(DVec3::Y * 0.5, 0.4, [16, 16]));
    // Pseudo-random, a tenth up or down.
    let noise = |face: u32| (face.wrapping_mul(2_654_435_761) >> 16 & 1) as f32 * 0.2 - 0.1;
    let value = |face: u32, _: DVec3| Vec3::splat(1.0 + noise(face));
    let solved = room_by_hand(named_scene("ball", faces), 1, 1, value, value);
    let relit = solved.as_relit();
    let surface = welded_surface(&relit);
    let renders = RelitRadiance::new(&relit, &surface, false);
    let facets = &solved.mesh.texels[1..];
    let square = facets.iter().map(|t| {
        let point = t.position.as_dvec3();
        (radiance_at(&renders, t.face, point).x * PI - 1.0).powi(2)
    });
    let rms = (square.sum::<f32>() / facets.len() as f32).sqrt();
    // Three corners with six facets each, some of them shared: RMS 0.1/√(12…18).
    assert!(rms < 0.035, "{rms}");
}

#[test]
fn borders_of_lamps_and_rugs_stay_sharp() {
    let p = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let strip = |from: f64, emission: f32, reflectance: f32| {
        let to = from + 1.0;
        let corners = [p(from, 0.), p(from, 1.), p(to, 1.), p(to, 0.)];
        Face::quad("strip", corners, Vec3::splat(emission), Vec3::splat(reflectance))
    };
    // Lamp, floor, floor, rug.
    let strips = [(20.0, 0.5), (0.0, 0.5), (0.0, 0.5), (0.0, 0.1)];
    let faces = (0..).zip(strips).map(|(k, (e, r))| strip(f64::from(k), e, r));
    let radiosity = |face: u32, place: DVec3| {
        let (emission, reflectance) = strips[face as usize];
        // Light varies linearly up to the rug; the border between two floors must not show.
        let slope = if face < 3 { place.x as f32 } else { 0.0 };
        Vec3::splat(emission + 2.0 * reflectance + slope)
    };
    let solved = room_by_hand(named_scene("strips", faces.collect()), 4, 4, radiosity, radiosity);
    let relit = solved.as_relit();
    let surface = welded_surface(&relit);
    let renders = RelitRadiance::new(&relit, &surface, false);
    let at = |face: u32, x: f64| {
        let point = solved.mesh.local_point(p(x, 0.4));
        radiance_at(&renders, face, point).x * PI
    };
    let close = |a: f32, b: f32| assert!(abs_diff_eq!(a, b, epsilon = 1e-4), "{a} {b}");
    close(at(0, 0.999), 20.0 + 1.0 + 0.999);
    close(at(1, 1.001), 1.0 + 1.001);
    close(at(1, 2.0), 3.0);
    close(at(2, 2.0), 3.0);
    close(at(2, 2.999), 1.0 + 2.999);
    close(at(3, 3.001), 0.2);
    assert!(relit.is_light(0) && !relit.is_light(20));
}

#[test]
fn automatic_camera_sees_the_object() {
    let half = DVec3::new(2.0, 1.5, 3.0);
    let hall = |centre: DVec3, size: f64, eye: Option<DVec3>| {
        let mut faces = box_faces(-half, half, true, Vec3::ZERO, Vec3::ONE * 0.5);
        let reach = DVec3::splat(size / 2.0);
        faces.extend(box_faces(
            centre - reach,
            centre + reach,
            false,
            Vec3::ZERO,
            Vec3::ONE * 0.5,
        ));
        let value = |_: u32, _: DVec3| Vec3::ONE;
        let solved = room_by_hand(named_scene("hall", faces), 6, 2, value, value);
        let relit = RelitScene {
            eye,
            ..solved.as_relit()
        };
        let camera = automatic_camera(&relit);
        let c = render_composite(&relit, &camera, [60, 40], None);
        let place = camera.eye.as_dvec3() * solved.mesh.unit + solved.mesh.origin;
        assert!((35.0..=90.0).contains(&camera.fov_degrees), "{camera:?}");
        (place, c.mask.iter().sum::<f32>() / 2400.0)
    };
    let on_floor = DVec3::new(0.5, -1.2, 1.5);
    let (place, share) = hall(on_floor, 0.6, Some(DVec3::ZERO));
    assert!(place.length() < 1e-5 && share > 0.02, "{place} {share}");
    // An eye inside or just outside the object moves back, but not out of the room.
    for eye in [on_floor, on_floor + DVec3::X * 0.5] {
        let (place, share) = hall(on_floor, 0.6, Some(eye));
        assert!(place.abs().cmplt(half).all() && share > 0.02, "{place} {share}");
        assert!(place.distance(on_floor) > 1.0, "{place}");
    }
    assert!(hall(on_floor, 0.6, None).1 > 0.005);
    let (place, share) = hall(DVec3::ZERO, 2.5, Some(DVec3::ZERO));
    assert!(place.abs().cmplt(half).all() && share > 0.05, "{place} {share}");
    // An object too small to be seen from the eye: the camera moves nearer.
    let (place, share) = hall(DVec3::new(0.0, -1.49, 0.0), 0.02, Some(DVec3::ZERO));
    assert!(place.length() > 1.0 && share > 0.02, "{place} {share}");
}

#[test]
fn degenerate_input_is_drawn_without_panic() {
    let value = |_: u32, _: DVec3| Vec3::ONE;
    let mut faces = lit_room().faces;
    // Faces without area: a point and a line.
    let point = DVec3::ONE;
    for corners in [[point; 4], [point, point * 2.0, point * 3.0, point]] {
        faces.push(Face::quad("flat", corners, Vec3::ZERO, Vec3::splat(0.5)));
    }
    for room in [0, 6, 12, 14, 99] {
        let mut solved = room_by_hand(named_scene("odd", faces.clone()), room, 3, value, value);
        for short in [false, true] {
            if short {
                solved.before.clear();
                solved.after.radiosity.truncate(7);
            }
            let relit = solved.as_relit();
            let still = camera_at(&solved.mesh, DVec3::ONE, DVec3::ONE, 50.0);
            for camera in [automatic_camera(&relit), still] {
                let c = render_composite(&relit, &camera, [12, 8], None);
                assert!(is_finite(&c));
                assert!(files::choose_exposure(&c).white > 0.0);
                let none = render_composite(&relit, &camera, [0, 8], None);
                assert!(none.composite.is_empty());
            }
        }
    }
}

#[test]
fn files_hold_the_pictures() {
    let solved = SolvedRoom::new(lit_room(), 6);
    let dir = std::env::temp_dir().join(format!("composite-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let panorama = |d: DVec3| (d.as_vec3() + 1.5) * 0.37;
    for backdrop in [None, Some(&panorama as Backdrop)] {
        let relit = RelitScene {
            eye: backdrop.map(|_| DVec3::new(1.5, 1.0, 3.0)),
            ..solved.as_relit()
        };
        let camera = automatic_camera(&relit);
        let size = [90, 60];
        let c = render_composite(&relit, &camera, size, backdrop);
        common::solution::write_files(&dir, files::encode_radiance(&c).unwrap()).unwrap();
        for (name, colours) in [("composite", &c.composite), ("background", &c.background)] {
            let planes = ImagePlanes::read(&dir.join(name).with_extension("exr"), 1 << 20).unwrap();
            assert_eq!([planes.width, planes.height], [90, 60]);
            let [r, g, b] = planes.colour_planes("").unwrap();
            let read: Vec<Vec3> = (0..r.len()).map(|k| Vec3::new(r[k], g[k], b[k])).collect();
            assert_eq!(pixel_bits(&read), pixel_bits(colours));
            assert_eq!(planes.channels.contains_key("A"), backdrop.is_none(), "{name}");
        }
        let png = files::encode_composite(&c, files::choose_exposure(&c));
        assert!(png.starts_with(b"\x89PNG"));
    }
}
