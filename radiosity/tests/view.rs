//! The view: interpolation without seams, the automatic camera, degenerate scenes and NaN.

use super::scenes::{patchwork_floor, quad_grid};
use common::mesh::{Mesh, Texel};
use common::rays::Rays;
use common::scene::{Face, Scene};
use common::settings::{Settings, SolveQuality};
use common::shooting::initial_field;
use glam::{DVec3, Vec3, Vec4};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveRequest, solve_request};
use radiosity::report::coarse_solution::CoarseSolution;
use radiosity::report::picture::encode_srgb;
use radiosity::report::view::camera::Camera;
use radiosity::report::view::interpolation::{CarriedLight, InterpolatedField, InterpolationSurface};
use radiosity::report::view::render::ViewHits;
use radiosity::report::view::weld::position_on_edge;
use radiosity_tests::engines::shoot_on_cpu;
use radiosity_tests::{ball, box_faces};
use radiosity_tests::{bundled_scene, named_scene};
use std::f64::consts::PI;

/// 6 walls of 5×5 faces, a lamp box, two boxes; 168 faces.
const PAPER_ROOM: &str = "paper_room_objects.obj";

/// Bound of rounding: values and positions are f32 of order 1, and gradients divide by texel sides ≥ 1/40.
const ROUNDING: f64 = 1e-5;

/// Faces of one resolution and of different ones: neither a linear field nor noise has a step.
#[test]
fn fields_on_a_patchwork_are_without_steps() {
    let scene = patchwork_floor();
    let different = [[7, 4], [3, 8], [1, 1], [5, 5], [2, 2], [9, 9], [6, 13], [1, 2]];
    for sides in [[[1; 2]; 8], [[2; 2]; 8], [[5; 2]; 8], [[16; 2]; 8], different] {
        let mesh = Mesh::new(&scene, &sides, 1).unwrap();
        let surface = InterpolationSurface::new(&scene, &mesh);
        let noise = |k: usize| Vec4::splat((k as f32 * 0.618).fract());
        let noise: Vec<Vec4> = (0..mesh.texels.len()).map(noise).collect();
        // Unwelded, only noise has steps: a linear field continues by its slope.
        for (field, least) in [(noise, 0.1), (linear_field(&mesh), 0.0)] {
            let [joined, apart] = border_steps(&scene, &surface, &field);
            assert!(joined < ROUNDING && apart > least, "{sides:?} {joined} {apart}");
        }
    }
}

/// A page of too many texels shows means; a mean of open shares is the open share of the larger texel.
#[test]
fn coarse_texels_have_the_means_of_their_parts() {
    let e = [DVec3::Z * 3.0, DVec3::X * 2.0];
    let faces = quad_grid("floor", DVec3::ZERO, e, [3, 2], [Vec3::ZERO, Vec3::ONE * 0.5]);
    let scene = named_scene("floor", faces);
    let fine = Mesh::uniform(&scene, 6, 1).unwrap();
    let sizes = vec![[3; 2]; scene.faces.len()];
    let share = |k: usize| (k as f32 * 0.618).fract();
    let numbers = 0..fine.texels.len();
    let mut field = initial_field(&fine, "by hand");
    field.radiosity = numbers.clone().map(|k| Vec4::splat(1.0 + share(k))).collect();
    let (errors, open): (Vec<f32>, Vec<f32>) = numbers.map(|k| (2.0 * share(k), share(k))).unzip();
    let coarse = CoarseSolution::new(&scene, (&fine, &field, [Some(&errors), Some(&open)]), &sizes).unwrap();
    let [coarse_errors, coarse_open] = [&coarse.texel_errors, &coarse.open].map(|values| values.as_ref().unwrap());
    for (n, texel) in coarse.mesh.texels.iter().enumerate() {
        let [i, j] = [texel.index % 3, texel.index / 3];
        let part = |index: u32| {
            let is_part = |t: &Texel| t.face == texel.face && t.index == index;
            share(fine.texels.iter().position(is_part).unwrap())
        };
        let first = 12 * j + 2 * i;
        let mean = [0, 1, 6, 7].map(|next| part(first + next)).iter().sum::<f32>() / 4.0;
        let found = [
            coarse_open[n],
            coarse_errors[n] / 2.0,
            coarse.field.radiosity[n].x - 1.0,
        ];
        let off = found.map(|value| f64::from((value - mean).abs()));
        assert!(off.iter().all(|off| *off < ROUNDING), "{texel:?} {mean} {found:?}");
    }
}

#[test]
fn linear_field_is_reproduced_up_to_the_border() {
    let e = [DVec3::Z * 3.0, DVec3::X * 2.0];
    let faces = quad_grid("floor", DVec3::ZERO, e, [3, 2], [Vec3::ZERO, Vec3::ONE * 0.5]);
    let scene = named_scene("floor", faces);
    let mesh = Mesh::uniform(&scene, 4, 1).unwrap();
    let surface = InterpolationSurface::new(&scene, &mesh);
    let field = surface.interpolate_irradiance(&linear_field(&mesh));
    for k in 0..10_000 {
        let (x, z) = (f64::from(k % 100) / 50.0 + 0.003, f64::from(k / 100) / 33.34 + 0.002);
        let point = (DVec3::new(x, 0.0, z) - DVec3::new(1.0, 0.0, 1.5)) / mesh.unit;
        let face = mesh
            .faces
            .iter()
            .position(|face| face.edges.iter().all(|e| e.truncate().dot(point.as_vec3()) >= e.w));
        let value = field.value_at(face.unwrap() as u32, point);
        let error = (value - linear_value(point.as_vec3()).as_dvec3()).length();
        assert!(error < ROUNDING, "{x} {z} {error}");
    }
}

/// Triangles of a row are cut differently by the edge of a shadow, which must not show along it.
#[test]
fn straight_shadow_edge_on_triangles_has_no_teeth() {
    let p = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let triangles = [[p(0., 0.), p(0., 1.), p(1., 1.)], [p(0., 0.), p(1., 1.), p(1., 0.)]];
    let faces = triangles.map(|corners| Face::triangle("floor", corners, Vec3::ZERO, Vec3::ONE * 0.5));
    let scene = named_scene("floor", faces.to_vec());
    const TEXELS: u32 = 8;
    let mesh = Mesh::uniform(&scene, TEXELS, 1).unwrap();
    let surface = InterpolationSurface::new(&scene, &mesh);
    for edge in [0.5, 0.53, 0.5625, 0.6] {
        // Means over texels from 32×32 parts of each.
        let fine = Mesh::uniform(&scene, 32 * TEXELS, 1).unwrap();
        let mut sums = vec![Vec4::ZERO; mesh.texels.len()];
        for part in &fine.texels {
            let lit = f64::from(part.position.z) * fine.unit + fine.origin.z < edge;
            let texel = surface.texel_at(part.face, part.position.as_dvec3());
            sums[texel as usize] += Vec4::splat(if lit { 1.0 } else { 0.0 }) / (32.0 * 32.0);
        }
        let field = surface.interpolate_irradiance(&sums);
        let mut most = 0f64;
        for z in (0..200).map(|k| (f64::from(k) + 0.5) / 200.0) {
            // From the third row of nodes on: two corrections carry what borders do past two.
            let along = (76..124).map(|k| {
                let (x, face) = (f64::from(k) / 200.0, u32::from(f64::from(k) / 200.0 > z));
                field.value_at(face, mesh.local_point(p(x, z))).x
            });
            let (low, high) = along.fold((1f64, 0f64), |(low, high), x| (low.min(x), high.max(x)));
            assert!(low >= -1e-12 && high <= 1.0 + 1e-12, "{low} {high}");
            most = most.max(high - low);
        }
        assert!(most < ROUNDING, "teeth of {most} at {edge}");
    }
}

#[test]
fn light_beside_a_body_is_that_of_the_open_parts_of_texels() {
    let turn = |p: DVec3| DVec3::new(0.8 * p.x - 0.6 * p.z, p.y, 0.6 * p.x + 0.8 * p.z);
    let mut faces = box_faces(
        DVec3::splat(-2.0).with_y(0.0),
        DVec3::splat(2.0),
        true,
        Vec3::ZERO,
        Vec3::ONE * 0.5,
    );
    let (low, high) = (DVec3::new(-0.6, 0.0, -0.4), DVec3::new(0.6, 1.0, 0.4));
    for mut face in box_faces(low, high, false, Vec3::ZERO, Vec3::ONE * 0.5) {
        face.corners = face.corners.map(turn);
        faces.push(face);
    }
    let scene = named_scene("cupboard", faces);
    let mesh = Mesh::uniform(&scene, 9, 1).unwrap();
    let surface = InterpolationSurface::new(&scene, &mesh);
    // A texel's mean is its open share: the light is 1 wherever it comes.
    let lit: Vec<Vec4> = surface.open.iter().map(|open| Vec4::splat(*open)).collect();
    assert!(lit.iter().any(|mean| mean.x == 0.0) && lit.iter().any(|mean| mean.x > 0.2 && mean.x < 0.8));
    let field = surface.interpolate_irradiance(&lit);
    for (k, texel) in mesh.texels.iter().enumerate().filter(|(k, _)| surface.open[*k] > 0.0) {
        let value = field.stencil_value(&surface.stencil_at(k as u32, texel.position.as_dvec3()));
        assert!((value - DVec3::ONE).abs().max_element() < 1e-6, "texel {k}: {value}");
    }
}

#[test]
fn facets_of_a_ball_look_smooth_and_edges_of_a_box_stay_sharp() {
    let scene = named_scene("ball", ball(DVec3::ZERO, 1.0, [24, 24]));
    let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    let surface = InterpolationSurface::new(&scene, &mesh);
    // Light from above, over each facet its mean.
    let light = |p: DVec3| 1.0 + p.normalize().y;
    let values: Vec<Vec4> = mesh
        .texels
        .iter()
        .map(|t| Vec4::splat(light(t.position.as_dvec3()) as f32))
        .collect();
    let field = surface.interpolate_irradiance(&values);
    let step = 15f64.to_radians();
    for (k, texel) in mesh.texels.iter().enumerate() {
        for corner in mesh.faces[texel.face as usize].corners {
            let point = texel.position.lerp(corner, 0.99).as_dvec3();
            let value = field.stencil_value(&surface.stencil_at(k as u32, point)).x;
            // Neighbours differ by a step; the facets' values by themselves are off by half of one.
            assert!((value - light(point)).abs() < 0.2 * step, "{value} at {point}");
        }
    }
    let cube = box_faces(-DVec3::ONE, DVec3::ONE, false, Vec3::ZERO, Vec3::ONE * 0.5);
    let cube = named_scene("box", cube);
    let mesh = Mesh::uniform(&cube, 2, 1).unwrap();
    assert!(InterpolationSurface::new(&cube, &mesh).pairs.is_empty());
}

#[test]
fn solved_rooms_are_shown_without_seams() {
    // Shadows of texels as wide as the boxes keep no mean; the floor's smooth light keeps it to 0.1 %.
    for (scene, mean_bound) in [(bundled_scene(PAPER_ROOM), 0.05), (patchwork_floor(), 0.002)] {
        let texels = if scene.faces.len() > 100 { 8 } else { 16 };
        let mesh = Mesh::uniform(&scene, texels, 1).unwrap();
        let mut settings = Settings::default();
        (settings.meshing.texels, settings.meshing.patches) = (texels, 1);
        settings.schedule.epsilon = 0.03;
        let run = shoot_on_cpu(&mesh, &settings);
        let surface = InterpolationSurface::new(&scene, &mesh);
        let irradiance = &run.field.irradiance;
        let [joined, apart] = border_steps(&scene, &surface, irradiance);
        let error = texel_mean_error(&scene, &surface.interpolate_irradiance(irradiance), irradiance);
        println!("{} {texels}²: joined {joined} apart {apart} error {error}", scene.name);
        assert!(joined < 1e-4 && apart > 0.05, "{joined} {apart}");
        assert!(error < mean_bound, "{error}");
    }
}

#[test]
fn automatic_camera_looks_through_open_front_or_wall_back() {
    let scene = bundled_scene("cornell_box.obj");
    let mesh = Mesh::uniform(&scene, 2, 1).unwrap();
    let rays = Rays::new(&mesh);
    let camera = Camera::automatic_view(&mesh, &rays);
    assert!(camera.eye.z < -1.0 && camera.eye.x.abs() < 0.1, "{camera:?}");
    let surface = InterpolationSurface::new(&scene, &mesh);
    let view = ViewHits::new(&camera, &surface, &rays, 64);
    let mut seen = vec![false; mesh.faces.len()];
    view.iter_hits().for_each(|hit| seen[hit.face as usize] = true);
    let is_seen = |(face, seen): (&Face, &bool), name: &str| *seen && face.name.starts_with(name);
    let names = |name: &str| scene.faces.iter().zip(&seen).any(|pair| is_seen(pair, name));
    for name in ["floor", "back", "left", "right", "ceiling", "light", "tall", "short"] {
        assert!(names(name), "{name}");
    }
    // x points to the left, as in the Cornell box: the red wall is at the larger x.
    let picture = view.shade_hits(|hit| mesh.texels[hit.stencil.texel as usize].reflectance);
    let pixel = |x: u32, y: u32| &picture.rgba[((y * 64 + x) * 4) as usize..][..4];
    assert!(pixel(6, 32)[0] > pixel(6, 32)[1] && pixel(57, 32)[1] > pixel(57, 32)[0]);
    // The scene fills the frame.
    let covered = picture.rgba.chunks(4).filter(|p| p[3] > 0).count();
    assert!(covered > 64 * 64 * 8 / 10, "{covered}");

    let mesh = Mesh::uniform(&bundled_scene(PAPER_ROOM), 1, 1).unwrap();
    let camera = Camera::automatic_view(&mesh, &Rays::new(&mesh));
    assert!(camera.eye.z < -1.0, "{camera:?}");
}

#[test]
fn automatic_camera_sees_front_of_single_face() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    for (a, b) in [(x, z), (z, x), (y, x), (x, y)] {
        let faces = quad_grid("f", DVec3::ONE * 7.0, [a, b], [1, 1], [Vec3::ONE, Vec3::ZERO]);
        let scene = named_scene("one", faces);
        let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        let rays = Rays::new(&mesh);
        let surface = InterpolationSurface::new(&scene, &mesh);
        let view = ViewHits::new(&Camera::automatic_view(&mesh, &rays), &surface, &rays, 16);
        assert!(view.iter_hits().count() > 20);
    }
}

#[test]
fn degenerate_scenes_and_nan_do_not_panic() {
    let p = DVec3::splat(1.0);
    let q = DVec3::new(2.0, 1.0, 1.0);
    let flat = Face::quad("line", [p, q, q, p], Vec3::ONE, Vec3::ONE * 0.5);
    let point = Face::triangle("point", [p, p, p], Vec3::ONE, Vec3::ONE * 0.5);
    let only_flat = named_scene("flat", vec![flat.clone(), point.clone()]);
    let mut mixed = patchwork_floor();
    mixed.faces.extend([flat, point]);
    for scene in [only_flat, mixed] {
        let mesh = Mesh::uniform(&scene, 3, 1).unwrap();
        let rays = Rays::new(&mesh);
        let surface = InterpolationSurface::new(&scene, &mesh);
        let mut values = linear_field(&mesh);
        values[0] = Vec4::NAN;
        values.pop();
        let field = surface.interpolate_irradiance(&values);
        assert!(texel_mean_error(&scene, &field, &values).is_nan());
        for camera in [
            Camera::automatic_view(&mesh, &rays),
            Camera::new(Vec3::ZERO, Vec3::ZERO, f32::NAN),
        ] {
            let view = ViewHits::new(&camera, &surface, &rays, 24);
            let picture = view.shade_hits(|hit| field.radiosity_at(&hit.stencil));
            assert_eq!(picture.rgba.len(), 24 * 24 * 4);
        }
        for texel in 0..mesh.texels.len() as u32 {
            let position = mesh.texels[texel as usize].position.as_dvec3();
            let value = field.stencil_value(&surface.stencil_at(texel, position));
            assert!(value.is_nan() || value.length() < 10.0);
        }
    }
    assert_eq!(encode_srgb(Vec3::NAN), radiosity::report::picture::NOT_A_NUMBER);
}

/// Returns the largest step of interpolated values across borders of coplanar faces, relative to their rms, with these
/// borders welded and without.
fn border_steps(scene: &Scene, surface: &InterpolationSurface, values: &[Vec4]) -> [f64; 2] {
    let apart = InterpolationSurface::with_welding(scene, surface.mesh, None, |_, _| false);
    let squares = surface.mesh.texels.iter().zip(values);
    let (square, area) = squares.fold((0.0, 0.0), |(square, area), (texel, value)| {
        let own = f64::from(texel.area);
        (
            square + own * f64::from(value.truncate().length_squared()),
            area + 3.0 * own,
        )
    });
    [surface, &apart].map(|welded| {
        let field = welded.interpolate_irradiance(values);
        let (mut largest, mut samples) = (0.0, 0);
        for (a, b) in surface.pairs.iter().flat_map(|(a, b)| [(*a, *b), (*b, *a)]) {
            let [from, to] = [a, b].map(|face| &surface.face_grids[face as usize]);
            for k in 0..from.edge_count() {
                let [start, end] = from.edge_ends(k);
                let count = 8 * from.size[k % 2];
                for i in 0..count {
                    let point = start.lerp(end, (f64::from(i) + 0.5) / f64::from(count));
                    if (0..to.edge_count()).any(|k| position_on_edge(to, k, point).is_some()) {
                        let step = (field.value_at(a, point) - field.value_at(b, point)).abs();
                        assert!(!step.is_nan());
                        largest = step.max_element().max(largest);
                        samples += 1;
                    }
                }
            }
        }
        assert!(samples > 100);
        largest / (square / area).sqrt()
    })
}

/// Returns the relative RMS by which the interpolation's means over texels differ from the `values`, from 8×8 samples
/// of each texel.
fn texel_mean_error(scene: &Scene, field: &InterpolatedField, values: &[Vec4]) -> f64 {
    let mesh = field.surface.mesh;
    let finer: Vec<[u32; 2]> = mesh.faces.iter().map(|face| face.resolution.map(|n| 8 * n)).collect();
    let mut sums = vec![(DVec3::ZERO, 0.0); mesh.texels.len()];
    for sample in Mesh::new(scene, &finer, 1).unwrap().texels {
        let point = sample.position.as_dvec3();
        let (sum, area) = &mut sums[field.surface.texel_at(sample.face, point) as usize];
        *sum += field.value_at(sample.face, point) * f64::from(sample.area);
        *area += f64::from(sample.area);
    }
    let (mut error, mut square) = (0.0, 0.0);
    for ((texel, value), (sum, area)) in mesh.texels.iter().zip(values).zip(sums) {
        let own = value.truncate().as_dvec3();
        error += (sum / area - own).length_squared() * f64::from(texel.area);
        square += own.length_squared() * f64::from(texel.area);
    }
    (error / square).sqrt()
}

/// A floor of many small faces with the shadow of a sheet: the picture of its light errs by the requested error at most, edges
/// of the shadow included.
#[test]
fn shadow_on_small_faces_is_within_the_requested_error() {
    const LAMP_POINTS: u32 = 16;
    let (rho, emission, requested) = (0.5, 50.0, 0.02);
    let square =
        |corner: DVec3, side: f64| [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Z, DVec3::Z].map(|to| corner + side * to);
    let (lamp, sheet) = (DVec3::new(0.5, 0.8, 0.45), DVec3::new(0.35, 0.2, 0.35));
    let (lamp_side, sheet_side) = (0.05, 0.3);
    let mut faces = quad_grid(
        "floor",
        DVec3::ZERO,
        [DVec3::Z, DVec3::X],
        [16, 16],
        [Vec3::ZERO, Vec3::splat(rho)],
    );
    faces.push(Face::quad(
        "lamp",
        square(lamp, lamp_side),
        Vec3::splat(emission),
        Vec3::ZERO,
    ));
    let down = Face::quad("sheet", square(sheet, sheet_side), Vec3::ZERO, Vec3::ZERO);
    faces.extend([down.reversed(), down]);
    let scene = named_scene("sheet over small faces", faces);
    let radiosity_at = |x: f64, z: f64| {
        let from_lamp = |k: u32| {
            let at =
                [k % LAMP_POINTS, k / LAMP_POINTS].map(|n| (f64::from(n) + 0.5) / f64::from(LAMP_POINTS) * lamp_side);
            let offset = lamp + DVec3::new(at[0], 0.0, at[1]) - DVec3::new(x, 0.0, z);
            let crossing = DVec3::new(x, 0.0, z) + offset * (sheet.y / offset.y) - sheet;
            let is_hidden = [crossing.x, crossing.z].iter().all(|at| (0.0..sheet_side).contains(at));
            let square = offset.length_squared();
            if is_hidden { 0.0 } else { (offset.y / square).powi(2) }
        };
        let sum: f64 = (0..LAMP_POINTS * LAMP_POINTS).map(from_lamp).sum();
        f64::from(rho * emission) * sum * (lamp_side / f64::from(LAMP_POINTS)).powi(2) / PI
    };
    let target = ErrorTarget {
        error: requested,
        texels: None,
    };
    let request = SolveRequest {
        task: &scene,
        settings: &Settings::with_quality(SolveQuality::Normal),
        solver: SolverChoice::to_error(None, target),
    };
    let answer = solve_request(&request, &without_progress()).unwrap();
    let solved = &answer.solved;
    assert_eq!(solved.run.field.origin, "rays");
    let surface = InterpolationSurface::with_welding(&scene, &solved.mesh, solved.open.as_deref(), |_, _| true);
    let light = surface.interpolate_light(&solved.run.field, CarriedLight::Irradiance);
    let (mut error, mut whole) = (0.0, 0.0);
    for k in 0..240 * 240 {
        let [x, z] = [k % 240, k / 240].map(|n| (f64::from(n) + 0.5) / 240.0);
        let face = (x * 16.0) as u32 * 16 + (z * 16.0) as u32;
        let point = solved.mesh.local_point(DVec3::new(x, 0.0, z));
        let texel = surface.texel_at(face, point);
        let found = light.radiosity_at(&surface.stencil_at(texel, point));
        let exact = radiosity_at(x, z);
        error += (f64::from(found.x) - exact).powi(2);
        whole += exact.powi(2);
    }
    let error = (error / whole).sqrt();
    assert!(error <= requested, "{error}");
}

/// Makes a field that is linear in position.
fn linear_field(mesh: &Mesh) -> Vec<Vec4> {
    mesh.texels
        .iter()
        .map(|texel| linear_value(texel.position).extend(0.0))
        .collect()
}

/// Returns the value of [`linear_field`] at a position.
fn linear_value(p: Vec3) -> Vec3 {
    Vec3::splat(2.0) + Vec3::new(1.0, -0.5, 0.2) * p.x + Vec3::new(0.3, 0.6, -0.9) * p.z + p.y
}
