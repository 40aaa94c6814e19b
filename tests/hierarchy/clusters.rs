//! Face clusters: each face is in one cluster, clusters send the sum of their faces' light, and a body of many faces is
//! lit correctly.

use common::mesh::Mesh;
use common::rays::{LineOfSight, NO_FACE, Rays};
use common::scene::{Face, Scene};
use cpu::hierarchy::block::{ReceiverBlock, Spot};
use cpu::hierarchy::cluster::{ClusterPart, Clusters};
use cpu::hierarchy::cluster_link::ClusterInteraction;
use cpu::hierarchy::linear_radiosity::pull_radiosity;
use cpu::hierarchy::link::no_last_blockers;
use cpu::hierarchy::solver::{ErrorBudget, solve_scene};
use cpu::hierarchy::tree::TexelTree;
use glam::{DVec3, Vec3};
use radiosity_tests::solutions::{dense_truth_on, error_against, solve_to_error};
use radiosity_tests::{ball, lit_room, named_scene};
use std::cell::Cell;
use std::ops::ControlFlow;

/// A lit room with a ball of 4·`rings`·(`rings` − 1) triangles.
fn room_with_ball(rings: u32) -> Scene {
    let mut scene = lit_room();
    scene.faces.truncate(6);
    let body = ball(DVec3::new(1.4, 0.9, 1.9), 0.6, [rings, 2 * rings]);
    scene.faces.extend(body);
    scene.name = format!("a ball of {} faces", 4 * rings * (rings - 1));
    scene
}

fn collect_faces(clusters: &Clusters, part: ClusterPart, found: &mut Vec<u32>) {
    match part {
        ClusterPart::Face(f) => found.push(f),
        ClusterPart::Cluster(k) => {
            for part in clusters.all[k as usize].parts {
                collect_faces(clusters, part, found);
            }
        }
    }
}

#[test]
fn every_face_is_in_one_cluster_and_within_its_cone() {
    let scene = room_with_ball(9);
    let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    let tree = TexelTree::new(&scene, &mesh);
    let clusters = Clusters::new(&mesh, &tree);
    for (k, cluster) in (0..).zip(&clusters.all) {
        let mut found = Vec::new();
        collect_faces(&clusters, ClusterPart::Cluster(k), &mut found);
        let range = cluster.faces.start as usize..cluster.faces.end as usize;
        assert_eq!(found, clusters.order[range]);
        for f in found {
            let shooter = &tree.nodes[tree.roots[f as usize] as usize].shooter;
            assert!(shooter.normal.dot(cluster.axis) >= cluster.cone);
            for corner in shooter.corners {
                let d = corner - cluster.centre;
                assert!(d.length() <= cluster.radius && d.abs().cmple(cluster.half).all());
            }
        }
    }
    let mut order = clusters.order.clone();
    order.sort_unstable();
    assert!(order.into_iter().eq(0..scene.faces.len() as u32));
}

#[test]
fn cluster_radiosity_equals_sum_of_faces() {
    let scene = room_with_ball(24);
    let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    let tree = TexelTree::new(&scene, &mesh);
    let clusters = Clusters::new(&mesh, &tree);
    let area: Vec<f32> = mesh.texels.iter().map(|texel| texel.area).collect();
    // The radiosity has a small slope, so that the value at the centre differs from the mean.
    let value = |k: usize| Vec3::new(1.0, 2.0, 3.0) * (1.0 + 0.2 * mesh.texels[k].position.x);
    let values: Vec<Vec3> = (0..mesh.texels.len()).map(value).collect();
    let mut radiosity = pull_radiosity(&tree, &area, &values);
    clusters.pull_radiosity(&tree, &mut radiosity);
    let rays = Rays::new(&mesh);
    let mut linked = 0;
    for f in 0..6 {
        let shooter = &tree.nodes[tree.roots[f] as usize].shooter;
        let block = ReceiverBlock::new(&mesh, &[Spot::of_node(&tree, tree.roots[f])]);
        for (k, cluster) in (0..).zip(&clusters.all) {
            let d = shooter.centre - cluster.centre;
            let ratio = cluster.radius / d.length();
            let interaction = ClusterInteraction {
                mesh: &mesh,
                tree: &tree,
                clusters: &clusters,
                rays: &rays,
                number: k,
                block: &block,
                counted: LineOfSight::Clear,
                last_blockers: &no_last_blockers(),
            };
            let bound = interaction.exchange_bound();
            let own = clusters.order[cluster.faces.start as usize..cluster.faces.end as usize].iter();
            let (mut sum, mut turned) = (Vec3::ZERO, false);
            for f in own {
                let root = tree.roots[*f as usize] as usize;
                let part = &tree.nodes[root].shooter;
                let d = shooter.centre - part.centre;
                let [out, up] = [part.normal.dot(d), -shooter.normal.dot(d)];
                turned |= out <= 0.0 || up <= 0.0;
                let square = d.length_squared();
                let factor = part.area * out * up / (std::f32::consts::PI * square * square);
                sum += radiosity[root].mean * factor.max(0.0);
            }
            if turned || cluster.cone < 0.5 || ratio > 0.2 {
                continue;
            }
            let mut received = [[0.0; 16]; 3];
            let link = interaction.start_sampling(1).sample_link(64).link;
            link.add_irradiance(&radiosity[tree.nodes.len() + k as usize], &mut received);
            let found = Vec3::from_array(received.map(|lane| lane[0]));
            // Nothing is occluded: the room is empty except for the ball, which hides none of its faces that face the
            // receiver.
            let off = (found - sum).abs().max_element();
            // Radiosity and kernel vary to first order each, their product to second order: the kernel is h d⁻⁴, its
            // second derivative at most 20/(h d); then the disc's area, and the radiosity's slope of 0.2.
            let height = -shooter.normal.dot(d);
            let square = cluster.radius * cluster.radius;
            let allowed = 20.0 * square / (height * d.length()) + bound.factor + 0.8 * ratio * cluster.radius;
            assert!(off <= allowed, "face {f}, cluster {k}: {off} > {allowed}");
            assert!(sum.max_element() <= 3.9 * bound.factor, "face {f}, cluster {k}");
            linked += 1;
        }
    }
    assert!(linked > 1000, "{linked}");
}

#[test]
fn last_blocker_does_not_change_visibility() {
    let mut scene = room_with_ball(6);
    scene.faces[4..6]
        .iter_mut()
        .for_each(|face| face.reflectance = Vec3::ZERO);
    let mut mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    // As in a relight: rays may pass through objects, the faces beyond the room's.
    mesh.room_faces = 66;
    let rays = Rays::new(&mesh);
    let centre = |f: u32| mesh.patches[f as usize].shooter.centre;
    let (mut blocked, mut ended) = (0, 0);
    for (f, g) in (0..126).flat_map(|f| (f + 1..126).map(move |g| (f, g))) {
        let ends = [f, g];
        for through in [false, true] {
            let sight = rays.find_sight(centre(f), centre(g), ends, through);
            blocked += u32::from(sight == LineOfSight::Blocked);
            for other in [NO_FACE, f, g, (7 * f + g) % 126, (f + 5 * g) % 126] {
                let last = Cell::new(other);
                let found = rays.find_sight_after(centre(f), centre(g), ends, through, &last);
                assert_eq!(found, sight, "{f} to {g} past {other}");
                ended += u32::from(last.get() != other);
            }
        }
    }
    assert!(blocked > 500 && ended > 1000, "{blocked} {ended}");
}

#[test]
fn body_of_many_faces_matches_dense_solution() {
    let scene = room_with_ball(6);
    let requested = 0.02;
    let answer = solve_to_error(&scene, requested, 4);
    let off = error_against(&scene, &answer, &dense_truth_on(&scene, 4));
    assert!(off <= requested, "{off}");
}

/// Returns the largest relative error of a furnace's faces, seen from within: exactly B = E/(1 − ρ) everywhere.
fn furnace_error(faces: Vec<Face>, reflectance: f32, requested: f32) -> f32 {
    let inside = |face: Face| Face {
        emission: Vec3::ONE,
        reflectance: Vec3::splat(reflectance),
        ..face.reversed()
    };
    let scene = named_scene("furnace", faces.into_iter().map(inside).collect());
    let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    let mut go_on = |_| ControlFlow::Continue(());
    let found = solve_scene(&scene, &mesh, &[], ErrorBudget::for_error(requested), &mut go_on).unwrap();
    let radiosity = found.irradiance.iter().map(|h| Vec3::ONE + reflectance * *h);
    let off = radiosity.map(|b| (b * (1.0 - reflectance) - 1.0).abs().max_element());
    off.fold(0.0, f32::max)
}

#[test]
fn hollow_ball_has_the_radiosity_of_a_furnace() {
    let requested = 0.005;
    let worst = furnace_error(ball(DVec3::ZERO, 1.0, [19, 36]), 0.8, requested);
    assert!(worst <= requested, "{worst}");
}

/// Caps of thin triangles, and walls that look at each other at a grazing angle.
#[test]
fn hollow_drum_has_the_radiosity_of_a_furnace() {
    let (around, rows) = (32, 12);
    let rim = |k: u32, y: f64| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(around)).sin_cos();
        DVec3::new(cos, y, sin)
    };
    let mut faces = Vec::new();
    let mut add = |corners: [DVec3; 3]| faces.push(Face::triangle("drum", corners, Vec3::ZERO, Vec3::ZERO));
    for k in 0..around {
        for row in 0..rows {
            let [low, high] = [row, row + 1].map(|row| 6.0 * f64::from(row) / f64::from(rows));
            let quad = [rim(k + 1, low), rim(k, low), rim(k, high), rim(k + 1, high)];
            add([quad[0], quad[1], quad[2]]);
            add([quad[0], quad[2], quad[3]]);
        }
        add([DVec3::ZERO, rim(k, 0.0), rim(k + 1, 0.0)]);
        add([DVec3::new(0.0, 6.0, 0.0), rim(k + 1, 6.0), rim(k, 6.0)]);
    }
    let requested = 0.01;
    let worst = furnace_error(faces, 0.9, requested);
    assert!(worst <= requested, "{worst}");
}
