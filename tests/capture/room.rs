//! The walls of a captured room: orientation, and radiosity resampled from a panorama.

use common::Error;
use common::capture::room::{box_room, capture_point};
use common::capture::{MapProjection, Panorama, texel_radiosity};
use glam::{DVec2, DVec3, Vec3};
use radiosity_tests::radiance_files::{irradiance_at_eye, light_at_eye, mean_radiance, paint_panorama, texel_outlines};
use std::f64::consts::PI;

const SIZE: DVec3 = DVec3::new(4.0, 2.5, 6.0);
const EYE: DVec3 = DVec3::new(0.7, 1.6, -1.9);
const MAPS: [(MapProjection, [usize; 2]); 3] = [
    (MapProjection::LatLong, [96, 48]),
    (MapProjection::Cube, [24, 144]),
    (MapProjection::Angular, [80, 80]),
];

/// Noise over four decades, black outside an angular map's disc.
fn noise(projection: MapProjection, size: [usize; 2]) -> Panorama {
    let mut state = 7_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        10_f32.powf((state >> 8) as f32 / (1 << 24) as f32 * 4.0 - 2.0)
    };
    paint_panorama(projection, size, |_| Vec3::new(next(), next(), next()))
}

fn uniform(radiance: Vec3, projection: MapProjection, size: [usize; 2]) -> Panorama {
    Panorama::from_pixels(size, vec![radiance; size[0] * size[1]], Some(projection)).unwrap()
}

#[test]
fn box_room_has_documented_orientation() {
    let scene = box_room(SIZE).unwrap();
    let names: Vec<&str> = scene.faces.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["floor", "ceiling", "left", "right", "front", "back"]);
    let outward = [DVec3::NEG_Y, DVec3::Y, DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z];
    let middle = capture_point(SIZE, None).unwrap();
    assert_eq!(middle, DVec3::new(0.0, 1.25, 0.0));
    for (face, out) in scene.faces.iter().zip(outward) {
        assert!(face.vector_area().normalize().dot(-out) > 1.0 - 1e-12, "{}", face.name);
        let centre = face.corners.iter().sum::<DVec3>() / 4.0 - middle;
        assert!(
            (centre - out * (SIZE * 0.5).dot(out.abs())).length() < 1e-12,
            "{}",
            face.name
        );
        if out.y == 0.0 {
            let [a, b, _, d] = face.corners;
            assert!(
                a.y == 0.0 && b.y == 0.0 && d.y == SIZE.y,
                "{} stands upright",
                face.name
            );
        }
    }
    let lie = |k: usize, corner: usize| scene.faces[k].corners[corner].z;
    assert!(
        lie(0, 0) < 0.0 && lie(1, 0) > 0.0,
        "the floor starts at the back, the ceiling in front"
    );
}

#[test]
fn uniform_map_gives_uniform_walls() {
    let scene = box_room(SIZE).unwrap();
    let radiance = Vec3::new(0.3, 1.7, 250.0);
    let exact = (radiance.as_dvec3() * PI).as_vec3();
    for (projection, size) in MAPS {
        let map = uniform(radiance, projection, size);
        for resolution in [[1, 1], [7, 3], [64, 64]] {
            let walls = texel_radiosity(&map, &scene, &[resolution; 6], EYE).unwrap();
            assert!(walls.iter().all(|b| *b == exact), "{projection:?} {resolution:?}");
        }
        let received = irradiance_at_eye(&map, DVec3::Y) / (radiance.as_dvec3() * PI) - 1.0;
        // Error of the midpoint rule over rows: about (π/48)²/24.
        assert!(received.abs().max_element() < 2e-3, "{projection:?} {received}");
    }
}

#[test]
fn wall_texel_shows_the_pixel_behind_it() {
    let scene = box_room(SIZE).unwrap();
    let resolutions = [[16, 24], [16, 24], [24, 10], [24, 10], [16, 10], [16, 10]];
    let outlines = texel_outlines(&scene, &resolutions, EYE);
    for (projection, size) in MAPS {
        for k in (0..size[0] * size[1]).step_by(331) {
            let [x, y] = [k % size[0], k / size[0]];
            let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let half = size[0] as f64 / 2.0;
            if projection == MapProjection::Angular && (at - half).length() > half - 1.0 {
                continue;
            }
            let mut pixels = vec![Vec3::ZERO; size[0] * size[1]];
            pixels[k] = Vec3::ONE;
            let map = Panorama::from_pixels(size, pixels, Some(projection)).unwrap();
            let walls = texel_radiosity(&map, &scene, &resolutions, EYE).unwrap();
            let direction = projection.direction_at(size, at);
            let inside = |corners: &[DVec3; 4]| {
                // Counter-clockwise as seen from the eye.
                (0..4).all(|i| corners[i].cross(corners[(i + 1) % 4]).dot(direction) <= 1e-12)
            };
            let texel = outlines.iter().position(inside).unwrap();
            assert!(walls[texel].x > 0.0, "{projection:?} {x} {y}: texel {texel} is dark");
            let lit = |b: &&Vec3| b.x > 0.0;
            assert!(walls.iter().filter(lit).count() < 100, "{projection:?} {x} {y}");
        }
    }
}

/// A quarter turn moves the light of the front wall to the left one, and directions alike.
#[test]
fn turned_map_lights_the_wall_to_which_it_turns() {
    let size = DVec3::splat(2.0);
    let (scene, eye) = (box_room(size).unwrap(), capture_point(size, None).unwrap());
    let map = noise(MapProjection::LatLong, [64, 32]);
    let walls = |map: &Panorama| texel_radiosity(map, &scene, &[[8, 8]; 6], eye).unwrap();
    let (before, turned) = (walls(&map), map.clone().turn_by(90.0));
    let after = walls(&turned);
    let wall = |walls: &[Vec3], k: usize| walls[64 * k..64 * (k + 1)].to_vec();
    let [front, left] = [wall(&before, 4), wall(&after, 2)];
    for (a, b) in front.iter().zip(&left) {
        assert!((*a - *b).abs().max_element() < 1e-4 * a.max_element(), "{a} {b}");
    }
    for direction in [DVec3::new(0.2, 0.3, 1.0), DVec3::new(-1.0, 0.1, -0.4)] {
        let [a, b] = [map.radiance(direction), turned.radiance(direction.rotate_y(PI / 2.0))];
        assert!((a - b).abs().max_element() < 1e-4 * a.max_element(), "{a} {b}");
    }
}

#[test]
fn irradiance_at_the_eye_is_preserved() {
    let scene = box_room(SIZE).unwrap();
    for (projection, size) in MAPS {
        let map = noise(projection, size);
        for resolution in [[5, 8], [48, 32]] {
            let resolutions = [resolution; 6];
            let walls = texel_radiosity(&map, &scene, &resolutions, EYE).unwrap();
            assert_eq!(walls, texel_radiosity(&map, &scene, &resolutions, EYE).unwrap());
            let normals = [DVec3::X, DVec3::NEG_Y, DVec3::new(0.48, 0.6, -0.64)];
            let found = light_at_eye(&walls, &texel_outlines(&scene, &resolutions, EYE), &normals);
            let exact = mean_radiance(&map) * 4.0 * PI;
            // Parallels are cut as 512 chords: each is π/512 wide and 5e-6 high. An angular map's
            // rim is counted in 64ths of a pixel.
            let error = (found.sphere / exact - 1.0).abs().max_element();
            let limit = if projection == MapProjection::Angular {
                2e-4
            } else {
                1e-5
            };
            assert!(error < limit, "{projection:?} {resolution:?} {error}");
            for (normal, irradiance) in normals.into_iter().zip(found.irradiance) {
                // The map is noise, so the errors of texels are independent.
                let error = (irradiance - irradiance_at_eye(&map, normal)).abs();
                let within = error.cmple(found.bound).all();
                assert!(within, "{projection:?} {normal} {error} {}", found.bound);
            }
        }
    }
}

#[test]
fn invalid_rooms_and_eyes_are_refused() {
    let usage = |result: Result<(), Error>| match result {
        Err(Error::Usage(message)) => assert!(!message.contains('\n'), "{message}"),
        other => panic!("{other:?}"),
    };
    let (n, i) = (f64::NAN, f64::INFINITY);
    for size in [[0.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, n, 1.0], [1.0, 1.0, i]] {
        usage(box_room(DVec3::from(size)).map(|_| ()));
        usage(capture_point(DVec3::from(size), None).map(|_| ()));
    }
    let outside = [
        [2.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 2.5, 0.0],
        [0.0, 1.0, -3.5],
        [n, 1.0, 0.0],
    ];
    for at in outside {
        usage(capture_point(SIZE, Some(DVec3::from(at))).map(|_| ()));
        let map = uniform(Vec3::ONE, MapProjection::LatLong, [4, 2]);
        let scene = box_room(SIZE).unwrap();
        usage(texel_radiosity(&map, &scene, &[[2, 2]; 6], DVec3::from(at)).map(|_| ()));
    }
    assert_eq!(capture_point(SIZE, Some(EYE)).unwrap(), EYE);
    let map = uniform(Vec3::ONE, MapProjection::LatLong, [4, 2]);
    let scene = box_room(SIZE).unwrap();
    usage(texel_radiosity(&map, &scene, &[[2, 2]; 5], EYE).map(|_| ()));
    usage(texel_radiosity(&map, &scene, &[[0, 2]; 6], EYE).map(|_| ()));
    let mut bent = scene.clone();
    bent.faces[0].corners[2].x += 0.5;
    usage(texel_radiosity(&map, &bent, &[[2, 2]; 6], EYE).map(|_| ()));
}
