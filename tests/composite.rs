//! The picture of a relit room, against what geometry and arithmetic say it must show.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::shooting::{Field, initial};
use common::solution::pixels::Planes;
use cpu::CpuSolver;
use cpu::cover::sampled;
use glam::{DVec2, DVec3, Vec3, Vec4};
use oracle::relight::camera::{camera_at, camera_for};
use oracle::relight::composite::{Composite, composite};
use oracle::relight::page::{Report, html};
use oracle::relight::surfaces::{Renders, surface};
use oracle::relight::thumbnail::thumbnail;
use oracle::relight::{Backdrop, Relit, files};
use oracle::view::camera::Camera;
use oracle::view::surface::Surface;
use radiosity_tests::engines::free;
use radiosity_tests::{lit_room, room, scene};
use std::f32::consts::PI;

/// A room solved empty, then with objects: what a relight starts from and must end at.
struct Solved {
    scene: Scene,
    mesh: Mesh,
    room: usize,
    before: Vec<Vec4>,
    after: Field,
}

impl Solved {
    fn new(scene: Scene, room: usize) -> Self {
        let settings = Settings {
            texels: 8,
            cells: 2,
            ..Settings::default()
        };
        let field = |scene: &Scene| {
            let mesh = sampled(scene, &settings).unwrap();
            let run = free(&mut CpuSolver::new(&mesh, &settings), &settings);
            (mesh, run.field)
        };
        let empty = Scene {
            faces: scene.faces[..room].to_vec(),
            ..scene.clone()
        };
        let mut before = field(&empty).1.radiosity;
        let (mesh, after) = field(&scene);
        before.resize(mesh.texels.len(), Vec4::ZERO);
        Self {
            scene,
            mesh,
            room,
            before,
            after,
        }
    }

    fn relit(&self) -> Relit<'_> {
        Relit {
            scene: &self.scene,
            mesh: &self.mesh,
            room: self.room,
            before: &self.before,
            after: &self.after,
            eye: None,
        }
    }
}

/// A scene with radiosities by hand: `before` and `after` of (face, centre in the scene).
fn by_hand(
    scene: Scene,
    room: usize,
    texels: u32,
    before: impl Fn(u32, DVec3) -> Vec3,
    after: impl Fn(u32, DVec3) -> Vec3,
) -> Solved {
    let mesh = Mesh::uniform(&scene, texels, 1).unwrap();
    let at = |of: &dyn Fn(u32, DVec3) -> Vec3, object: bool| -> Vec<Vec4> {
        let texels = mesh.texels.iter();
        let value = texels.map(|t| {
            let place = t.position.as_dvec3() * mesh.unit + mesh.origin;
            let none = !object && t.face as usize >= room;
            let value = if none { Vec3::ZERO } else { of(t.face, place) };
            value.extend(0.0)
        });
        value.collect()
    };
    let mut field = initial(&mesh, "by hand");
    field.radiosity = at(&after, true);
    Solved {
        before: at(&before, false),
        after: field,
        scene,
        room,
        mesh,
    }
}

/// A floor of 2×2 in the plane y = 0, its front up.
fn floor() -> Face {
    let p = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let corners = [p(-1., -1.), p(-1., 1.), p(1., 1.), p(1., -1.)];
    Face::quad("floor", corners, Vec3::ZERO, Vec3::splat(0.5))
}

/// Straight down from y = `height`, +z up in the picture, +x to its left.
fn from_above(mesh: &Mesh, height: f64, fov: f64) -> Camera {
    let eye = DVec3::new(0.0, height, 0.0);
    Camera {
        up: Vec3::Z,
        ..camera_at(mesh, eye, DVec3::ZERO, fov)
    }
}

fn bits(pixels: &[Vec3]) -> Vec<[u32; 3]> {
    let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
    pixels.iter().map(bits).collect()
}

fn finite(c: &Composite) -> bool {
    let all = [&c.background, &c.composite, &c.change, &c.objects];
    let pictures = all.iter().flat_map(|pixels| pixels.iter());
    pictures.into_iter().all(|v| v.is_finite()) && c.mask.iter().all(|m| (0.0..=1.0).contains(m))
}

#[test]
fn a_null_object_leaves_the_background_bit_for_bit() {
    let scene = lit_room();
    let count = scene.faces.len();
    let mut solved = Solved::new(scene, count);
    solved.before = solved.after.radiosity.clone();
    let camera = camera_for(&solved.relit());
    let panorama = |d: DVec3| (d.as_vec3() + 1.5) * 0.37;
    for backdrop in [None, Some(&panorama as Backdrop)] {
        let c = composite(&solved.relit(), &camera, [90, 60], backdrop);
        assert_eq!(bits(&c.composite), bits(&c.background));
        assert_eq!(c.negative, 0);
        assert!(c.mask.iter().all(|m| *m == 0.0) && c.background.iter().any(|v| *v != Vec3::ZERO));
    }
    // The equality is no accident: the least change of one texel in view shows.
    for value in &mut solved.after.radiosity {
        value.x += value.x * f32::EPSILON * 4.0;
    }
    let c = composite(&solved.relit(), &camera, [90, 60], None);
    assert_ne!(bits(&c.composite), bits(&c.background));
}

#[test]
fn a_planted_shadow_darkens_its_pixels_by_what_was_taken() {
    let dark = |p: DVec3| p.x > 0.0 && p.z > 0.25;
    let loss = Vec3::new(0.3, 0.2, 0.6);
    let solved = by_hand(
        scene("floor", vec![floor()]),
        1,
        8,
        |_, _| Vec3::ONE,
        |_, p| if dark(p) { Vec3::ONE - loss } else { Vec3::ONE },
    );
    let (w, h, height) = (60u32, 40u32, 2.0);
    let camera = from_above(&solved.mesh, height, 32.0);
    let c = composite(&solved.relit(), &camera, [w, h], None);
    let surface = Surface::new(&solved.scene, &solved.mesh);
    let relit = solved.relit();
    let change: Vec<Vec4> = (0..64).map(|k| relit.delta(k).extend(0.0)).collect();
    let field = surface.interpolate(&change);
    // The picture's half height on the floor, and a sample's place there.
    let half = height * 16f64.to_radians().tan();
    let (mut touched, mut deep) = (0, 0);
    for k in 0..w * h {
        let (x, y) = (f64::from(k % w), f64::from(k / w));
        let sample = |s: u32| {
            let [a, b] = [s % 4, s / 4].map(|i| (f64::from(i) + 0.5) / 4.0);
            let right = (2.0 * (x + a) - f64::from(w)) / f64::from(h) * half;
            let down = (2.0 * (y + b) - f64::from(h)) / f64::from(h) * half;
            let place = solved.mesh.local(DVec3::new(-right, 0.0, -down));
            field.at(0, place)
        };
        let expected = (0..16).map(sample).sum::<DVec3>().as_vec3() / 16.0 / PI;
        let k = k as usize;
        let got = c.composite[k] - c.background[k];
        assert!((got - expected).length() < 1e-6, "{k}: {got} {expected}");
        if expected == Vec3::ZERO {
            assert_eq!(bits(&c.composite[k..=k]), bits(&c.background[k..=k]));
        } else {
            touched += 1;
        }
        deep += u32::from((expected + loss / PI).length() < 1e-6);
    }
    assert!(touched > 200 && deep > 100, "{touched} {deep}");
    assert_eq!(c.negative, 0);
    // More taken than there is: counted, and not hidden.
    let mut below = solved;
    below.before.fill(Vec4::splat(0.1));
    below.after.radiosity.fill(Vec4::splat(0.1));
    let backdrop = |_: DVec3| Vec3::splat(0.01);
    below.after.radiosity[9].x = 0.0;
    let c = composite(&below.relit(), &camera, [w, h], Some(&backdrop));
    let under = c.composite.iter().filter(|v| v.x < 0.0).count();
    assert!(c.negative == under && under > 0);
}

/// Corners of a picture's pixels from those of the scene, x right and y down.
fn project(camera: &Camera, mesh: &Mesh, [w, h]: [u32; 2], point: DVec3) -> DVec2 {
    let forward = (camera.target - camera.eye).as_dvec3().normalize();
    let right = forward.cross(camera.up.as_dvec3()).normalize();
    let up = right.cross(forward);
    let p = mesh.local(point) - camera.eye.as_dvec3();
    let extent = (f64::from(camera.fov_degrees).to_radians() / 2.0).tan();
    let scale = f64::from(h) / 2.0 / (extent * p.dot(forward));
    DVec2::new(f64::from(w), f64::from(h)) / 2.0 + DVec2::new(p.dot(right), -p.dot(up)) * scale
}

/// The convex hull, clockwise or not.
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<DVec2> = Vec::new();
    for pass in 0..2 {
        let start = hull.len();
        for p in &points {
            while hull.len() >= start + 2 {
                let [a, b] = [hull[hull.len() - 2], hull[hull.len() - 1]];
                if (b - a).perp_dot(p - b) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(*p);
        }
        hull.pop();
        if pass == 0 {
            points.reverse();
        }
    }
    hull
}

#[test]
fn the_mask_is_the_silhouette() {
    let solved = {
        let mut faces = room(
            DVec3::ZERO,
            DVec3::splat(4.0),
            true,
            Vec3::ZERO,
            Vec3::ONE * 0.5,
        );
        let (low, high) = (DVec3::new(1.3, 0.0, 1.6), DVec3::new(2.4, 1.7, 2.5));
        faces.extend(room(low, high, false, Vec3::ZERO, Vec3::ONE * 0.5));
        by_hand(
            scene("box", faces),
            6,
            4,
            |_, _| Vec3::ONE,
            |_, _| Vec3::ONE,
        )
    };
    let size = [150, 100];
    let target = DVec3::new(1.9, 0.9, 2.0);
    let camera = camera_at(&solved.mesh, DVec3::new(3.6, 2.9, 0.4), target, 60.0);
    let c = composite(&solved.relit(), &camera, size, None);
    let corners = solved.scene.faces[6..].iter().flat_map(|f| f.corners);
    let outline = hull(
        corners
            .map(|p| project(&camera, &solved.mesh, size, p))
            .collect(),
    );
    assert_eq!(outline.len(), 6);
    let edges = || (0..outline.len()).map(|k| (outline[k], outline[(k + 1) % outline.len()]));
    let area: f64 = edges().map(|(a, b)| a.perp_dot(b) / 2.0).sum();
    let length: f64 = edges().map(|(a, b)| a.distance(b)).sum();
    let covered: f64 = c.mask.iter().map(|m| f64::from(*m)).sum();
    // Each pixel on the silhouette may be wrong by a part of a sample row; they average out.
    assert!(
        (covered - area).abs() < 0.05 * length,
        "{covered} {area} {length}"
    );
    for (k, mask) in c.mask.iter().enumerate() {
        let at = DVec2::new((k % 150) as f64 + 0.5, (k / 150) as f64 + 0.5);
        let inside = |(a, b): (DVec2, DVec2)| (b - a).perp_dot(at - a) / (b - a).length();
        let depth = edges().map(inside).fold(f64::INFINITY, f64::min);
        if depth.abs() > 0.71 {
            assert_eq!(*mask, if depth > 0.0 { 1.0 } else { 0.0 }, "{k} {depth}");
        }
    }
}

#[test]
fn a_constant_backdrop_stays_constant() {
    let mut solved = Solved::new(lit_room(), 6);
    solved.before = solved.after.radiosity.clone();
    let constant = Vec3::new(0.5, 1.25, 3.0);
    let backdrop = |_: DVec3| constant;
    let camera = camera_for(&solved.relit());
    for eye in [None, Some(DVec3::new(1.0, 1.0, 1.0))] {
        let relit = Relit {
            eye,
            ..solved.relit()
        };
        let c = composite(&relit, &camera, [60, 40], Some(&backdrop));
        assert!(c.background.iter().all(|v| *v == constant));
        let open = c.composite.iter().zip(&c.mask).filter(|(_, m)| **m == 0.0);
        assert!(open.clone().count() > 100 && open.clone().all(|(v, _)| *v == constant));
        assert!(c.coverage.iter().flatten().all(|share| *share == 1.0));
    }
}

/// Which wall of the box from −half to half a ray from inside it ends at: axis, side.
fn wall(half: DVec3, origin: DVec3, direction: DVec3) -> (usize, bool) {
    let exit = |k: usize| {
        let end = half[k].copysign(direction[k]);
        ((end - origin[k]) / direction[k], (k, direction[k] > 0.0))
    };
    let near = [0, 1, 2].map(exit).into_iter();
    near.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
}

#[test]
fn the_photograph_stays_on_the_walls_when_the_camera_leaves_the_eye() {
    let half = DVec3::new(2.0, 1.5, 3.0);
    let faces = room(-half, half, true, Vec3::ZERO, Vec3::ONE * 0.5);
    let solved = by_hand(
        scene("hall", faces),
        6,
        2,
        |_, _| Vec3::ONE,
        |_, _| Vec3::ONE,
    );
    let eye = DVec3::new(0.3, -0.2, 0.5);
    let colour =
        |(axis, side): (usize, bool)| Vec3::splat((1 + 2 * axis + usize::from(side)) as f32);
    let photograph = |d: DVec3| colour(wall(half, eye, d));
    let relit = Relit {
        eye: Some(eye),
        ..solved.relit()
    };
    let size = [150, 100];
    let place = DVec3::new(-1.4, 0.9, -2.0);
    for place in [eye, place] {
        let camera = camera_at(&solved.mesh, place, DVec3::new(1.9, -1.0, 2.0), 85.0);
        let c = composite(&relit, &camera, size, Some(&photograph));
        assert_eq!(bits(&c.composite), bits(&c.background));
        let mut whole = 0;
        for (k, got) in c.background.iter().enumerate() {
            let corner = |dx: usize, dy: usize| {
                let x = ((k % 150 + dx) as f32 * 2.0 - 150.0) / 100.0;
                let y = 1.0 - (k / 150 + dy) as f32 * 2.0 / 100.0;
                wall(half, place, camera.direction(x, y).as_dvec3())
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
fn a_pixel_on_an_edge_is_a_mix() {
    // An upright edge of a square above the floor, a quarter of a pixel from a pixel's border.
    let (size, height) = ([40, 20], 2.0);
    let pixel = 2.0 * height * 20f64.to_radians().tan() / 20.0;
    let scene_with = |z: f64| {
        let y = 0.5;
        let near = (height - y) / height;
        let p = |x: f64, z: f64| DVec3::new(x * near, y, z * near);
        let corners = [p(-0.2, z), p(-0.2, 0.3), p(0.2, 0.3), p(0.2, z)];
        let square = Face::quad("square", corners, Vec3::ZERO, Vec3::splat(0.5));
        scene("square", vec![floor(), square])
    };
    // Down in the picture is −z: the square's lower edge covers a quarter of row 12.
    let scene = scene_with(-2.25 * pixel);
    let value = |face: u32, _: DVec3| Vec3::splat([1.0, 5.0][face as usize]) * PI;
    let solved = by_hand(scene, 1, 3, value, value);
    let camera = from_above(&solved.mesh, height, 40.0);
    let c = composite(&solved.relit(), &camera, size, None);
    let column: Vec<f32> = (0..20).map(|row| c.mask[row * 40 + 20]).collect();
    assert_eq!(column[11..14], [1.0, 0.25, 0.0]);
    let value = c.composite[12 * 40 + 20];
    assert!(
        (value - Vec3::splat(0.25 * 5.0 + 0.75)).length() < 1e-5,
        "{value}"
    );
    assert!((c.background[12 * 40 + 20] - Vec3::ONE).length() < 1e-6);
    // Beyond the floor there is nothing: transparent, and premultiplied.
    assert_eq!(c.coverage[1][0], 0.0);
    assert_eq!(c.composite[0], Vec3::ZERO);
    let mut rim = 0;
    for (k, share) in c.coverage[1]
        .iter()
        .enumerate()
        .filter(|(k, _)| c.mask[*k] == 0.0)
    {
        assert!(
            (c.composite[k] - Vec3::splat(*share)).length() < 1e-5,
            "{k} {share}"
        );
        rim += u32::from(*share > 0.0 && *share < 1.0);
    }
    assert!(rim >= 40, "{rim}");
}

#[test]
fn the_composite_of_a_scene_is_its_full_render() {
    let solved = Solved::new(lit_room(), 6);
    let relit = solved.relit();
    let camera = camera_for(&relit);
    let c = composite(&relit, &camera, [90, 60], None);
    // The same with nothing to add: the relit room itself is the background.
    let full = composite(
        &Relit {
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
    assert!(finite(&c) && c.negative == 0);
    // The lamp is in the picture, and white is not made for it.
    let lamp = solved.scene.faces[1].emission / PI;
    let shown = c.background.iter().zip(&c.dark[0]);
    let bright = shown.filter(|(v, _)| v.cmpgt(lamp).all());
    assert!(bright.clone().count() > 100 && bright.clone().all(|(_, dark)| *dark < 0.5));
    let mut blind = c.clone();
    blind.dark = c.coverage.clone();
    assert!(files::exposure(&c).white < 0.8 * files::exposure(&blind).white);
}

/// A ball of 2·n·(n − 1) triangles, from south to north.
fn ball(centre: DVec3, radius: f64, n: u32) -> Vec<Face> {
    let at = |i: u32, j: u32| {
        let (s, c) = (std::f64::consts::PI * f64::from(j) / f64::from(n)).sin_cos();
        let (x, z) = (std::f64::consts::TAU * f64::from(i % n) / f64::from(n)).sin_cos();
        centre + DVec3::new(s * x, -c, s * z) * radius
    };
    let mut faces = Vec::new();
    let mut add = |corners: [DVec3; 3]| {
        faces.push(Face::triangle(
            "ball",
            corners,
            Vec3::ZERO,
            Vec3::splat(0.6),
        ));
    };
    for j in 0..n {
        for i in 0..n {
            if j > 0 {
                add([at(i, j), at(i + 1, j), at(i, j + 1)]);
            }
            if j > 0 && j + 1 < n {
                add([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            } else if j == 0 {
                add([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    faces
}

#[test]
fn light_passes_the_edges_of_a_ball_and_not_those_of_a_box() {
    let step = |object: Vec<Face>| {
        let mut faces = vec![floor()];
        faces.extend(object);
        let value = |face: u32, p: DVec3| Vec3::splat(1.0 + face as f32 * 0.01 + p.y as f32);
        let solved = by_hand(scene("object", faces), 1, 1, value, value);
        let relit = solved.relit();
        let surface = surface(&relit);
        let renders = Renders::new(&relit, &surface);
        let (mut largest, mut edges) = (0f32, 0);
        for (a, b) in surface.pairs.iter().copied() {
            for k in 0..surface.patches[a as usize].edges() {
                let [from, to] = surface.patches[a as usize].edge(k);
                let both = (0..surface.patches[b as usize].edges()).any(|l| {
                    let [start, end] = surface.patches[b as usize].edge(l);
                    start.distance(to) < 1e-6 && end.distance(from) < 1e-6
                });
                for share in [0.1, 0.3, 0.5, 0.8].into_iter().filter(|_| both) {
                    let point = from.lerp(to, share);
                    let at = |face: u32| renders.radiance(&renders.stencil(face, point));
                    largest = largest.max((at(a) - at(b)).abs().max_element());
                    edges += 1;
                }
            }
        }
        (largest, edges)
    };
    let (largest, edges) = step(ball(DVec3::Y * 0.5, 0.4, 16));
    assert!(edges > 1000 && largest < 1e-5, "{largest} {edges}");
    let cube = room(
        DVec3::ONE * 0.1,
        DVec3::ONE * 0.4,
        false,
        Vec3::ZERO,
        Vec3::ONE * 0.5,
    );
    assert_eq!(step(cube).1, 0);
}

#[test]
fn the_noise_of_single_facets_is_averaged() {
    let mut faces = vec![floor()];
    faces.extend(ball(DVec3::Y * 0.5, 0.4, 16));
    // A tenth up or down, without pattern.
    let noise = |face: u32| (face.wrapping_mul(2_654_435_761) >> 16 & 1) as f32 * 0.2 - 0.1;
    let value = |face: u32, _: DVec3| Vec3::splat(1.0 + noise(face));
    let solved = by_hand(scene("ball", faces), 1, 1, value, value);
    let relit = solved.relit();
    let surface = surface(&relit);
    let renders = Renders::new(&relit, &surface);
    let facets = &solved.mesh.texels[1..];
    let square = facets.iter().map(|t| {
        let at = renders.stencil(t.face, t.position.as_dvec3());
        (renders.radiance(&at).x * PI - 1.0).powi(2)
    });
    let rms = (square.sum::<f32>() / facets.len() as f32).sqrt();
    // Three corners with six facets each, some of them shared: 0.1/√(12…18).
    assert!(rms < 0.035, "{rms}");
}

#[test]
fn lamps_and_rugs_keep_their_borders() {
    let p = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let strip = |from: f64, emission: f32, reflectance: f32| {
        let to = from + 1.0;
        let corners = [p(from, 0.), p(from, 1.), p(to, 1.), p(to, 0.)];
        Face::quad(
            "strip",
            corners,
            Vec3::splat(emission),
            Vec3::splat(reflectance),
        )
    };
    // Lamp, floor, floor, rug.
    let strips = [(20.0, 0.5), (0.0, 0.5), (0.0, 0.5), (0.0, 0.1)];
    let faces = (0..)
        .zip(strips)
        .map(|(k, (e, r))| strip(f64::from(k), e, r));
    let radiosity = |face: u32, place: DVec3| {
        let (emission, reflectance) = strips[face as usize];
        // Light varies up to the rug; no border of two faces may show in it.
        let slope = if face < 3 { place.x as f32 } else { 0.0 };
        Vec3::splat(emission + 2.0 * reflectance + slope)
    };
    let solved = by_hand(scene("strips", faces.collect()), 4, 4, radiosity, radiosity);
    let relit = solved.relit();
    let surface = surface(&relit);
    let renders = Renders::new(&relit, &surface);
    let at = |face: u32, x: f64| {
        let at = renders.stencil(face, solved.mesh.local(p(x, 0.4)));
        renders.radiance(&at).x * PI
    };
    let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-4, "{a} {b}");
    close(at(0, 0.999), 20.0 + 1.0 + 0.999);
    close(at(1, 1.001), 1.0 + 1.001);
    close(at(1, 2.0), 3.0);
    close(at(2, 2.0), 3.0);
    // The outermost half texels are level: nothing is known beyond them.
    close(at(2, 2.999), 1.0 + 2.875);
    close(at(3, 3.001), 0.2);
    assert!(relit.is_light(0) && !relit.is_light(20));
}

#[test]
fn cameras_see_the_object() {
    let half = DVec3::new(2.0, 1.5, 3.0);
    let hall = |centre: DVec3, size: f64, eye: Option<DVec3>| {
        let mut faces = room(-half, half, true, Vec3::ZERO, Vec3::ONE * 0.5);
        let reach = DVec3::splat(size / 2.0);
        faces.extend(room(
            centre - reach,
            centre + reach,
            false,
            Vec3::ZERO,
            Vec3::ONE * 0.5,
        ));
        let value = |_: u32, _: DVec3| Vec3::ONE;
        let solved = by_hand(scene("hall", faces), 6, 2, value, value);
        let relit = Relit {
            eye,
            ..solved.relit()
        };
        let camera = camera_for(&relit);
        let c = composite(&relit, &camera, [60, 40], None);
        let place = camera.eye.as_dvec3() * solved.mesh.unit + solved.mesh.origin;
        assert!((35.0..=90.0).contains(&camera.fov_degrees), "{camera:?}");
        (place, c.mask.iter().sum::<f32>() / 2400.0)
    };
    let on_floor = DVec3::new(0.5, -1.2, 1.5);
    let (place, share) = hall(on_floor, 0.6, Some(DVec3::ZERO));
    assert!(place.length() < 1e-5 && share > 0.02, "{place} {share}");
    // In the object, and just outside it: a step back, but not out of the room.
    for eye in [on_floor, on_floor + DVec3::X * 0.5] {
        let (place, share) = hall(on_floor, 0.6, Some(eye));
        assert!(
            place.abs().cmplt(half).all() && share > 0.02,
            "{place} {share}"
        );
        assert!(place.distance(on_floor) > 1.0, "{place}");
    }
    assert!(hall(on_floor, 0.6, None).1 > 0.005);
    let (place, share) = hall(DVec3::ZERO, 2.5, Some(DVec3::ZERO));
    assert!(
        place.abs().cmplt(half).all() && share > 0.05,
        "{place} {share}"
    );
    // Too small to be seen from the eye: nearer.
    let (place, share) = hall(DVec3::new(0.0, -1.49, 0.0), 0.02, Some(DVec3::ZERO));
    assert!(place.length() > 1.0 && share > 0.02, "{place} {share}");
}

#[test]
fn odd_input_is_drawn_without_a_panic() {
    let value = |_: u32, _: DVec3| Vec3::ONE;
    let mut faces = lit_room().faces;
    // Faces without area: a point and a line.
    let point = DVec3::ONE;
    for corners in [[point; 4], [point, point * 2.0, point * 3.0, point]] {
        faces.push(Face::quad("flat", corners, Vec3::ZERO, Vec3::splat(0.5)));
    }
    for room in [0, 6, 12, 14, 99] {
        let mut solved = by_hand(scene("odd", faces.clone()), room, 3, value, value);
        for short in [false, true] {
            if short {
                solved.before.clear();
                solved.after.radiosity.truncate(7);
            }
            let relit = solved.relit();
            let still = camera_at(&solved.mesh, DVec3::ONE, DVec3::ONE, 50.0);
            for camera in [camera_for(&relit), still] {
                let c = composite(&relit, &camera, [12, 8], None);
                assert!(finite(&c));
                assert!(files::exposure(&c).white > 0.0);
                let none = composite(&relit, &camera, [0, 8], None);
                assert!(none.composite.is_empty());
            }
        }
    }
}

#[test]
fn the_files_hold_the_pictures_and_the_page_needs_nothing_else() {
    let solved = Solved::new(lit_room(), 6);
    let dir = std::env::temp_dir().join(format!("composite-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let panorama = |d: DVec3| (d.as_vec3() + 1.5) * 0.37;
    for backdrop in [None, Some(&panorama as Backdrop)] {
        let relit = Relit {
            eye: backdrop.map(|_| DVec3::new(1.5, 1.0, 3.0)),
            ..solved.relit()
        };
        let camera = camera_for(&relit);
        let size = [90, 60];
        let c = composite(&relit, &camera, size, backdrop);
        files::write(&dir, &c, files::exposure(&c)).unwrap();
        for (name, colours) in [("composite", &c.composite), ("background", &c.background)] {
            let planes = Planes::read(&dir.join(name).with_extension("exr"), 1 << 20).unwrap();
            assert_eq!([planes.width, planes.height], [90, 60]);
            let [r, g, b] = planes.colours("").unwrap();
            let read: Vec<Vec3> = (0..r.len()).map(|k| Vec3::new(r[k], g[k], b[k])).collect();
            assert_eq!(bits(&read), bits(colours));
            assert_eq!(
                planes.channels.contains_key("A"),
                backdrop.is_none(),
                "{name}"
            );
        }
        let png = std::fs::read(dir.join("composite.png")).unwrap();
        assert!(png.starts_with(b"\x89PNG"));
        let page = html(&Report {
            room: "lit <room>",
            objects: &["box.obj".into()],
            settings: &[("method".into(), "signed".into())],
            relit: &relit,
            composite: &c,
            camera,
            energy: None,
            map_shots: 24,
            object_shots: 1234,
            converged: true,
            negative_texels: 0,
            seconds: &[("load", 0.1), ("solve", 2.5)],
            warnings: &[],
            notes: &["a note".into()],
            thumbnail: backdrop.map(|backdrop| thumbnail(backdrop, 64)),
        });
        for wanted in [
            "lit &lt;room&gt;",
            "box.obj",
            "1\u{202f}234",
            "a note",
            "signed",
            "−z",
        ] {
            let panorama = wanted != "−z" || backdrop.is_some();
            assert_eq!(page.contains(wanted), panorama, "{wanted}");
        }
        // Without the pictures: in their letters anything may stand.
        let text = page.split("base64,").enumerate().map(|(k, part)| {
            let end = if k == 0 { 0 } else { part.find('"').unwrap() };
            &part[end..]
        });
        let text: String = text.collect();
        assert!(text.len() < 40_000 && !text.contains("http") && !text.contains("NaN"));
    }
}
