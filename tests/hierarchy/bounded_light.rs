//! Light never grows from bounce to bounce: over meshes that no modeller would make, and over links that add more light
//! than walls absorb.

use common::mesh::Mesh;
use common::sampling::pcg_hash;
use common::scene::{Face, Scene};
use cpu::hierarchy::coarse::{CoarseNodes, StoredLink, sum_link_amounts};
use cpu::hierarchy::iterate::{BounceIteration, BounceResult};
use cpu::hierarchy::linear_radiosity::pull_radiosity;
use cpu::hierarchy::link::BlockLink;
use cpu::hierarchy::solver::{ErrorBudget, TexelSolution, solve_scene};
use cpu::hierarchy::tree::TexelTree;
use glam::{DVec3, Vec3};
use radiosity_tests::{ball, box_faces, named_scene};
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Reflectance of all faces except the lamp: nearly all light goes on.
const RHO: f32 = 0.98;

/// Returns a generator of random numbers from 0 to 1.
fn random_numbers(seed: u32) -> impl FnMut() -> f64 {
    let mut counter = seed;
    move || {
        counter += 1;
        f64::from(pcg_hash(counter)) / f64::from(u32::MAX)
    }
}

fn grey_triangle(corners: [DVec3; 3]) -> Face {
    Face::triangle("part", corners, Vec3::ZERO, Vec3::splat(RHO))
}

/// Makes a closed room, two units wide, with a lamp in its ceiling and these faces in it.
fn room_around(name: &str, faces: Vec<Face>) -> Scene {
    let mut room = box_faces(
        DVec3::splat(-1.5),
        DVec3::splat(1.5),
        true,
        Vec3::ZERO,
        Vec3::splat(RHO),
    );
    room[1].emission = Vec3::splat(3.0);
    room[1].reflectance = Vec3::splat(0.5);
    room.extend(faces);
    named_scene(name, room)
}

fn grey_ball() -> Vec<Face> {
    let grey = |face| Face {
        reflectance: Vec3::splat(RHO),
        ..face
    };
    ball(DVec3::ZERO, 1.0, [5, 9]).into_iter().map(grey).collect()
}

/// Replaces the corners of every third face.
fn change_some(mut faces: Vec<Face>, change: impl Fn([DVec3; 4]) -> [DVec3; 4]) -> Vec<Face> {
    for face in faces.iter_mut().step_by(3) {
        face.corners = change(face.corners);
    }
    faces
}

/// Adds a copy of each face, its corners moved.
fn with_copies(faces: Vec<Face>, turned: bool, moved: impl Fn(DVec3) -> DVec3) -> Vec<Face> {
    let copy = |face: &Face| {
        let copy = Face {
            corners: face.corners.map(&moved),
            ..face.clone()
        };
        if turned { copy.reversed() } else { copy }
    };
    let copies: Vec<Face> = faces.iter().map(copy).collect();
    [faces, copies].concat()
}

/// Makes triangles of this length and of widths down to 10^−`decades` of it, in all directions.
fn triangle_soup(count: u32, decades: f64) -> Vec<Face> {
    let mut random = random_numbers(4711);
    let mut triangle = |_| {
        let mut draw = |size: f64| DVec3::from([0; 3].map(|_| size * (2.0 * random() - 1.0)));
        let (at, along, aside) = (draw(1.0), draw(0.5), draw(0.5));
        let width = 10f64.powf(-decades * random());
        grey_triangle([at, at + along, at + 0.5 * along + width * aside])
    };
    (0..count).map(&mut triangle).collect()
}

/// Makes half planes around one line, each with two fronts.
fn half_planes_on_line(count: u32) -> Vec<Face> {
    let half_plane = |k: u32| {
        let (sin, cos) = (PI * f64::from(k) / f64::from(count)).sin_cos();
        let [a, b] = [-1.0, 1.0].map(|y| DVec3::new(0.0, y, 0.0));
        let out = DVec3::new(cos, 0.0, sin);
        [grey_triangle([a, a + out, b + out]), grey_triangle([a, b + out, b])]
    };
    let faces: Vec<Face> = (0..count).flat_map(half_plane).collect();
    with_copies(faces, true, |p| p)
}

/// Solves one step on `texels`×`texels` to 10 %.
fn solve_coarsely(scene: &Scene, texels: u32) -> (Mesh, TexelSolution) {
    let mesh = Mesh::uniform(scene, texels, 1).unwrap();
    let mut go_on = |_| ControlFlow::Continue(());
    let solution = solve_scene(scene, &mesh, &[], ErrorBudget::for_error(0.1), &mut go_on).unwrap();
    (mesh, solution)
}

/// Meshes that end in a result whose surfaces absorb at most what the lamp emits, to the error requested.
#[test]
fn broken_meshes_absorb_no_more_than_is_emitted() {
    let turned = |p: DVec3| DVec3::new(0.76 * p.x - 0.65 * p.y, 0.65 * p.x + 0.76 * p.y, p.z);
    let cases: [(&str, u32, Vec<Face>); 12] = [
        ("closed ball", 1, grey_ball()),
        ("open ball", 2, grey_ball().into_iter().step_by(2).collect()),
        ("turned faces", 1, change_some(grey_ball(), |[a, b, c, _]| [b, a, c, c])),
        (
            "faces without area",
            1,
            change_some(grey_ball(), |[a, b, _, _]| [a, b, a.midpoint(b), a.midpoint(b)]),
        ),
        (
            "needles",
            2,
            change_some(grey_ball(), |[a, b, c, _]| {
                [a, b, a.midpoint(b) + 1e-7 * c, a.midpoint(b) + 1e-7 * c]
            }),
        ),
        ("copies", 1, with_copies(grey_ball(), false, |p| p)),
        ("copies turned over", 1, with_copies(grey_ball(), true, |p| p)),
        ("balls through each other", 1, with_copies(grey_ball(), false, turned)),
        ("shells", 2, with_copies(grey_ball(), true, |p| p * 1.001)),
        ("triangles through each other", 1, triangle_soup(60, 0.0)),
        ("spikes", 1, triangle_soup(60, 4.0)),
        ("wedges", 1, half_planes_on_line(12)),
    ];
    for (name, texels, faces) in cases {
        let (mesh, solution) = solve_coarsely(&room_around(name, faces), texels);
        let (mut absorbed, mut emitted) = (0.0, 0.0);
        for (k, texel) in mesh.texels.iter().enumerate() {
            absorbed += texel.area * (solution.irradiance[k] * (1.0 - texel.reflectance)).x;
            emitted += texel.area * texel.emission.x;
        }
        println!("{name}: {absorbed} of {emitted}, {}", solution.converged);
        assert!(solution.irradiance.iter().all(|h| h.is_finite()), "{name}");
        assert!(absorbed <= 1.1 * emitted, "{name}: {absorbed} of {emitted}");
    }
}

/// Iterates over links of random factors, as large as `amount` and of both signs if `signed`, between all nodes of
/// a room. Returns the result and the largest sum of a row of K, by amount, in units of radiosity.
fn iterate_over_random_links(amount: f32, signed: bool) -> (BounceResult, f32) {
    let scene = room_around("random links", grey_ball());
    let mesh = Mesh::uniform(&scene, 4, 1).unwrap();
    let tree = TexelTree::new(&scene, &mesh);
    let area: Vec<f32> = mesh.texels.iter().map(|texel| texel.area).collect();
    let mut coarse = CoarseNodes::new(
        &mesh,
        &tree,
        |k| tree.nodes[k as usize].level == 1,
        [&area, &vec![0.0; area.len()]],
    );
    let mut random = random_numbers(7);
    let mut draw = |least: f32| [0; 16].map(|_| amount * (least + (1.0 - least) * random() as f32));
    let least = if signed { -1.0 } else { 0.0 };
    let sources = tree.nodes.len() as u32;
    let mut link_of = |node| StoredLink {
        node,
        link: BlockLink {
            weight: draw(least),
            along: [draw(-1.0), draw(-1.0)],
        },
    };
    let blocks = 0..coarse.receivers.blocks.len();
    let links: Vec<Vec<StoredLink>> = blocks.map(|_| (0..sources).map(&mut link_of).collect()).collect();
    coarse.prepare_sources(&links);
    let emission: Vec<Vec3> = mesh.texels.iter().map(|texel| texel.emission).collect();
    let radiosity = pull_radiosity(&tree, &area, &emission);
    let sums = sum_link_amounts(&links, &radiosity);
    let first = sums.as_flattened().as_flattened().iter().copied().fold(0.0, f32::max);
    let mut iteration = BounceIteration {
        tree: &tree,
        coarse: &mut coarse,
        links: &links,
        radiosity,
        passes: 0,
    };
    let result = iteration.iterate_until(1e-4, &mut || Ok(())).unwrap();
    assert!(coarse.constant_radiosity, "the power grows at first");
    (result, first)
}

/// x = K(s + ρx) is at most |Ks|/(1 − ρ) where the sums of K's rows are at most 1.
#[test]
fn iteration_over_links_that_gain_is_bounded() {
    for (amount, signed) in [(0.05, false), (1.0, false), (0.05, true), (1.0, true), (1e6, true)] {
        let (result, first) = iterate_over_random_links(amount, signed);
        let most = first / (1.0 - RHO);
        let found = result
            .received
            .iter()
            .map(|h| h.abs().max_element())
            .fold(0.0, f32::max);
        assert!(result.converged, "{amount} {signed}");
        assert!(found > 0.0 && found <= most, "{amount} {signed}: {found} of {most}");
    }
}
