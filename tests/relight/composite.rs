//! Composite pictures of a relit room, compared pixel by pixel with geometry and arithmetic.

use approx::abs_diff_eq;
use common::scene::Face;
use glam::{DVec3, Vec3, Vec4};
use radiosity::relight::RelitScene;
use radiosity::relight::camera::camera_at;
use radiosity::relight::composite::{SPARSE_SAMPLES, render_composite};
use radiosity::relight::radiance::welded_surface;
use radiosity::report::view::interpolation::InterpolationSurface;
use radiosity_tests::composites::{camera_from_above, pixel_bits, room_by_hand, square_floor};
use radiosity_tests::{box_faces, named_scene};
use std::f32::consts::PI;

#[test]
fn planted_shadow_darkens_pixels_by_its_loss() {
    let dark = |p: DVec3| p.x > 0.0 && p.z > 0.25;
    let loss = Vec3::new(0.3, 0.2, 0.6);
    let solved = room_by_hand(
        named_scene("floor", vec![square_floor()]),
        1,
        8,
        |_, _| Vec3::ONE,
        |_, p| if dark(p) { Vec3::ONE - loss } else { Vec3::ONE },
    );
    let (w, h, height) = (60u32, 40u32, 2.0);
    let camera = camera_from_above(&solved.mesh, height, 32.0);
    let c = render_composite(&solved.as_relit(), &camera, [w, h], None);
    let surface = InterpolationSurface::new(&solved.scene, &solved.mesh);
    let relit = solved.as_relit();
    let after: Vec<Vec4> = (0..64).map(|k| relit.relit_radiosity(k).extend(0.0)).collect();
    let field = surface.interpolate_irradiance(&after);
    // Half the picture's height on the floor.
    let half = height * 16f64.to_radians().tan();
    let (mut touched, mut deep) = (0, 0);
    for k in 0..w * h {
        let (x, y) = (f64::from(k % w), f64::from(k / w));
        // One face fills the picture: a few of the sixteen samples suffice.
        let sample = |s: usize| {
            let [a, b] = [s % 4, s / 4].map(|i| (i as f64 + 0.5) / 4.0);
            let right = (2.0 * (x + a) - f64::from(w)) / f64::from(h) * half;
            let down = (2.0 * (y + b) - f64::from(h)) / f64::from(h) * half;
            let place = solved.mesh.local_point(DVec3::new(-right, 0.0, -down));
            field.value_at(0, place) - DVec3::ONE
        };
        let expected = SPARSE_SAMPLES.map(sample).iter().sum::<DVec3>().as_vec3() / 4.0 / PI;
        let k = k as usize;
        let got = c.composite[k] - c.background[k];
        assert!((got - expected).length() < 1e-6, "{k}: {got} {expected}");
        if expected == Vec3::ZERO {
            assert_eq!(pixel_bits(&c.composite[k..=k]), pixel_bits(&c.background[k..=k]));
        } else {
            touched += 1;
        }
        deep += u32::from((expected + loss / PI).length() < 1e-6);
    }
    // Deep are the pixels a texel or more within the shadow: two rows of twenty.
    assert!(touched > 200 && deep > 30, "{touched} {deep}");
    assert_eq!(c.negative, 0);
    // A loss larger than the light, where B₀ is unknown: counted, and black.
    let mut below = solved;
    below.before.fill(Vec4::splat(0.1));
    below.after.radiosity.fill(Vec4::splat(0.1));
    below.before[9].x = 0.0;
    below.after.radiosity[9].x = -0.05;
    let backdrop = |_: DVec3| Vec3::splat(0.001);
    let c = render_composite(&below.as_relit(), &camera, [w, h], Some(&backdrop));
    let taken = c.change.iter().zip(&c.background);
    let under = taken.filter(|(change, seen)| (**change + **seen).x < 0.0).count();
    assert!(c.negative == under && under > 0, "{under} {}", c.negative);
    assert!(c.composite.iter().all(|v| v.min_element() >= 0.0));
}

#[test]
fn photograph_is_multiplied_by_the_light_ratio() {
    // The model's floor is grey, the photograph's green. There is a shadow on the right, and B₀ is unknown in the
    // far part.
    let dark = |p: DVec3| p.x < 0.0;
    let unknown = |p: DVec3| p.z > 0.25;
    let shadow = Vec3::new(0.3, 0.4, 0.5);
    let gain = Vec3::new(0.2, 0.1, 0.0);
    let before = |_: u32, p: DVec3| if unknown(p) { Vec3::ZERO } else { Vec3::ONE };
    let after = |_: u32, p: DVec3| match (unknown(p), dark(p)) {
        (true, _) => gain,
        (false, true) => shadow,
        (false, false) => Vec3::ONE,
    };
    let solved = room_by_hand(named_scene("floor", vec![square_floor()]), 1, 16, before, after);
    let green = Vec3::new(0.02, 0.5, 0.04);
    let backdrop = |_: DVec3| green;
    let (w, h, height) = (60u32, 40u32, 2.0);
    let camera = camera_from_above(&solved.mesh, height, 32.0);
    let c = render_composite(&solved.as_relit(), &camera, [w, h], Some(&backdrop));
    let half = height * 16f64.to_radians().tan();
    let mut found = [0; 3];
    for (k, got) in c.composite.iter().enumerate() {
        let (x, y) = ((k % 60) as f64 + 0.5, (k / 60) as f64 + 0.5);
        let right = (2.0 * x - f64::from(w)) / f64::from(h) * half;
        let place = DVec3::new(-right, 0.0, -(2.0 * y - f64::from(h)) / f64::from(h) * half);
        // Skips a texel at the borders, where values are interpolated between the parts.
        if place.x.abs() < 0.14 || (place.z - 0.25).abs() < 0.14 {
            continue;
        }
        let (part, expected) = match (unknown(place), dark(place)) {
            (true, _) => (0, green + gain / PI),
            (false, true) => (1, green * shadow),
            (false, false) => (2, green),
        };
        found[part] += 1;
        assert!((*got - expected).length() < 1e-6, "{place}: {got} {expected}");
    }
    assert!(found.iter().all(|count| *count > 100), "{found:?}");
    assert_eq!(c.negative, 0);
    assert!(c.composite.iter().all(|v| v.min_element() >= 0.0));
}

/// Returns axis and side of the wall of the box from −half to half at which a ray from inside ends.
fn wall(half: DVec3, origin: DVec3, direction: DVec3) -> (usize, bool) {
    let exit = |k: usize| {
        let end = half[k].copysign(direction[k]);
        ((end - origin[k]) / direction[k], (k, direction[k] > 0.0))
    };
    let near = [0, 1, 2].map(exit).into_iter();
    near.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
}

#[test]
fn photograph_stays_on_the_walls_for_other_cameras() {
    let half = DVec3::new(2.0, 1.5, 3.0);
    let faces = box_faces(-half, half, true, Vec3::ZERO, Vec3::ONE * 0.5);
    let solved = room_by_hand(named_scene("hall", faces), 6, 2, |_, _| Vec3::ONE, |_, _| Vec3::ONE);
    let eye = DVec3::new(0.3, -0.2, 0.5);
    let colour = |(axis, side): (usize, bool)| Vec3::splat((1 + 2 * axis + usize::from(side)) as f32);
    let photograph = |d: DVec3| colour(wall(half, eye, d));
    let relit = RelitScene {
        eye: Some(eye),
        ..solved.as_relit()
    };
    let size = [150, 100];
    let place = DVec3::new(-1.4, 0.9, -2.0);
    for place in [eye, place] {
        let camera = camera_at(&solved.mesh, place, DVec3::new(1.9, -1.0, 2.0), 85.0);
        let c = render_composite(&relit, &camera, size, Some(&photograph));
        assert_eq!(pixel_bits(&c.composite), pixel_bits(&c.background));
        let mut whole = 0;
        for (k, got) in c.background.iter().enumerate() {
            let corner = |dx: usize, dy: usize| {
                let x = ((k % 150 + dx) as f32 * 2.0 - 150.0) / 100.0;
                let y = 1.0 - (k / 150 + dy) as f32 * 2.0 / 100.0;
                wall(half, place, camera.ray_generator()(x, y).as_dvec3())
            };
            let seen = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
            if seen.iter().all(|wall| *wall == seen[0]) {
                assert_eq!(*got, colour(seen[0]), "{place} {k}");
                whole += 1;
            }
        }
        assert!(whole > 13_500 && whole < 15_000, "{whole}");
    }
}

#[test]
fn edge_pixel_is_mixed_by_coverage() {
    // An edge of a square above the floor, a quarter of a pixel from a pixel's border.
    let (size, height) = ([40, 20], 2.0);
    let pixel = 2.0 * height * 20f64.to_radians().tan() / 20.0;
    let scene_with = |z: f64| {
        let y = 0.5;
        let near = (height - y) / height;
        let p = |x: f64, z: f64| DVec3::new(x * near, y, z * near);
        let corners = [p(-0.2, z), p(-0.2, 0.3), p(0.2, 0.3), p(0.2, z)];
        let square = Face::quad("square", corners, Vec3::ZERO, Vec3::splat(0.5));
        named_scene("square", vec![square_floor(), square])
    };
    // Down in the picture is −z: the square's lower edge covers a quarter of row 12.
    let scene = scene_with(-2.25 * pixel);
    let value = |face: u32, _: DVec3| Vec3::splat([1.0, 5.0][face as usize]) * PI;
    let solved = room_by_hand(scene, 1, 3, value, value);
    let camera = camera_from_above(&solved.mesh, height, 40.0);
    let c = render_composite(&solved.as_relit(), &camera, size, None);
    let column: Vec<f32> = (0..20).map(|row| c.mask[row * 40 + 20]).collect();
    assert_eq!(column[11..14], [1.0, 0.25, 0.0]);
    // The mask is the square's silhouette, to a quarter of a pixel, the distance of samples: the floor's 0.2 is to the
    // left and to the right, 0.3 above.
    let [half, above] = [0.2, 0.3].map(|length| length / pixel);
    for (k, mask) in c.mask.iter().enumerate() {
        let (x, y) = ((k % 40) as f64 + 0.5 - 20.0, 10.0 - (k / 40) as f64 - 0.5);
        let depth = (half - x.abs()).min(above - y).min(y + 2.25);
        let expected = (depth + 0.5).clamp(0.0, 1.0);
        let is_corner = x.abs() > half - 1.0 && y > above - 1.0 || x.abs() > half - 1.0 && y < -1.25;
        assert!(
            is_corner || abs_diff_eq!(f64::from(*mask), expected, epsilon = 0.25),
            "{x} {y}: {mask}"
        );
    }
    let value = c.composite[12 * 40 + 20];
    assert!((value - Vec3::splat(0.25 * 5.0 + 0.75)).length() < 1e-5, "{value}");
    assert!((c.background[12 * 40 + 20] - Vec3::ONE).length() < 1e-6);
    // Beyond the floor the picture is transparent, with premultiplied alpha.
    assert_eq!(c.coverage[1][0], 0.0);
    assert_eq!(c.composite[0], Vec3::ZERO);
    let mut rim = 0;
    for (k, share) in c.coverage[1].iter().enumerate().filter(|(k, _)| c.mask[*k] == 0.0) {
        assert!((c.composite[k] - Vec3::splat(*share)).length() < 1e-5, "{k} {share}");
        rim += u32::from(*share > 0.0 && *share < 1.0);
    }
    assert!(rim >= 40, "{rim}");
}

#[test]
fn file_normals_decide_smooth_edges() {
    let roof = |normals: [Option<[Vec3; 4]>; 2]| {
        let p = |x: f64, y: f64| [DVec3::new(x, y, -0.2), DVec3::new(x, y, 0.2)];
        let ([a, b], [c, d], [e, f]) = (p(-0.3, 0.1), p(0.0, 0.5), p(0.3, 0.1));
        let mut faces = vec![
            square_floor(),
            Face::quad("left", [a, b, d, c], Vec3::ZERO, Vec3::splat(0.5)),
            Face::quad("right", [c, d, f, e], Vec3::ZERO, Vec3::splat(0.5)),
        ];
        for (face, normals) in faces[1..].iter_mut().zip(normals) {
            face.corner_normals = normals;
        }
        let solved = room_by_hand(named_scene("roof", faces), 1, 1, |_, _| Vec3::ONE, |_, _| Vec3::ONE);
        let pairs = welded_surface(&solved.as_relit()).pairs.clone();
        pairs.contains(&(1, 2))
    };
    let (left, right) = (Vec3::new(-0.8, 0.6, 0.0), Vec3::new(0.8, 0.6, 0.0));
    let ridge = Vec3::Y;
    // The ridge is sharp without normals and with face normals, smooth if both faces have the same normal there.
    assert!(!roof([None, None]));
    assert!(!roof([Some([left; 4]), Some([right; 4])]));
    assert!(!roof([Some([left, left, ridge, ridge]), None]));
    assert!(roof([
        Some([left, left, ridge, ridge]),
        Some([ridge, ridge, right, right])
    ]));
}
