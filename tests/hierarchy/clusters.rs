//! Faces that shoot as one: every face once, the flow of all, and a body of many faces in a room.

use crate::hierarchy::asked::solved;
use common::mesh::Mesh;
use common::rays::{NOBODY, Rays, Sight};
use common::scene::{Face, Scene};
use cpu::hierarchy::block::{Block, Spot};
use cpu::hierarchy::cluster::{Clusters, Part};
use cpu::hierarchy::cluster_link::Group;
use cpu::hierarchy::light::pull;
use cpu::hierarchy::link::nobody;
use cpu::hierarchy::tree::Tree;
use glam::{DVec3, Vec3};
use radiosity_tests::answers::{error, truth_on};
use radiosity_tests::lit_room;
use std::cell::Cell;
use std::f64::consts::PI;

/// A lit room with a ball of 4·`rings`·(`rings` − 1) triangles.
fn ball(rings: u32) -> Scene {
    let mut scene = lit_room();
    scene.faces.truncate(6);
    let at = |i: u32, j: u32| {
        let (up, round) = (
            PI * f64::from(i) / f64::from(rings),
            PI * f64::from(j) / f64::from(rings),
        );
        let d = DVec3::new(up.sin() * round.cos(), up.cos(), up.sin() * round.sin());
        DVec3::new(1.4, 0.9, 1.9) + d * 0.6
    };
    for i in 0..rings {
        for j in 0..2 * rings {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            let grey = Vec3::new(0.6, 0.5, 0.4);
            if i + 1 < rings {
                scene
                    .faces
                    .push(Face::triangle("ball", [a, c, d], Vec3::ZERO, grey));
            }
            if i > 0 {
                scene
                    .faces
                    .push(Face::triangle("ball", [a, b, c], Vec3::ZERO, grey));
            }
        }
    }
    scene.name = format!("a ball of {} faces", 4 * rings * (rings - 1));
    scene
}

fn faces(clusters: &Clusters, part: Part, found: &mut Vec<u32>) {
    match part {
        Part::Face(f) => found.push(f),
        Part::Cluster(k) => {
            for part in clusters.all[k as usize].parts {
                faces(clusters, part, found);
            }
        }
    }
}

#[test]
fn every_face_is_in_a_cluster_once_and_looks_its_way() {
    let scene = ball(9);
    let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    let tree = Tree::new(&scene, &mesh).unwrap();
    let clusters = Clusters::new(&mesh, &tree);
    for (k, cluster) in (0..).zip(&clusters.all) {
        let mut found = Vec::new();
        faces(&clusters, Part::Cluster(k), &mut found);
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
fn what_a_cluster_sends_is_what_its_faces_send() {
    let scene = ball(24);
    let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    let tree = Tree::new(&scene, &mesh).unwrap();
    let clusters = Clusters::new(&mesh, &tree);
    let area: Vec<f32> = mesh.texels.iter().map(|texel| texel.area).collect();
    // Slopes a little, so that the middle and the mean are two things.
    let value = |k: usize| Vec3::new(1.0, 2.0, 3.0) * (1.0 + 0.2 * mesh.texels[k].position.x);
    let values: Vec<Vec3> = (0..mesh.texels.len()).map(value).collect();
    let mut glows = pull(&tree, &area, &values);
    clusters.pull(&tree, &mut glows);
    let rays = Rays::new(&mesh);
    let mut linked = 0;
    for f in 0..6 {
        let shooter = &tree.nodes[tree.roots[f] as usize].shooter;
        let spot = Spot {
            face: f as u32,
            target: 0,
            share: 1.0,
            corners: shooter.corners,
            centre: shooter.centre,
        };
        let block = Block::new(&mesh, &[spot]);
        for (k, cluster) in (0..).zip(&clusters.all) {
            let d = shooter.centre - cluster.centre;
            let ratio = cluster.radius / d.length();
            let group = Group {
                mesh: &mesh,
                tree: &tree,
                clusters: &clusters,
                rays: &rays,
                number: k,
                block: &block,
                passes: Sight::Clear,
                ended: &nobody(),
            };
            let bound = group.bound();
            let own =
                clusters.order[cluster.faces.start as usize..cluster.faces.end as usize].iter();
            let (mut sum, mut turned) = (Vec3::ZERO, false);
            for f in own {
                let root = tree.roots[*f as usize] as usize;
                let part = &tree.nodes[root].shooter;
                let d = shooter.centre - part.centre;
                let [out, up] = [part.normal.dot(d), -shooter.normal.dot(d)];
                turned |= out <= 0.0 || up <= 0.0;
                let square = d.length_squared();
                let factor = part.area * out * up / (std::f32::consts::PI * square * square);
                sum += glows[root].mean * factor.max(0.0);
            }
            if turned || cluster.cone < 0.5 || ratio > 0.2 {
                continue;
            }
            let mut received = [[0.0; 16]; 3];
            let link = group.asked(1).sampled(64).link;
            link.add(&glows[tree.nodes.len() + k as usize], &mut received);
            let found = Vec3::from_array(received.map(|lane| lane[0]));
            // What is hidden is not asked here: the room is empty but for the ball, which hides none of
            // its own that look towards the receiver.
            let off = (found - sum).abs().max_element();
            // Light and kernel fall off to the first order each, together to the second: the kernel's part is
            // h d⁻⁴, twice derived at most 20/(h d); then the disc's area, and the light's fifth of r.
            let height = -shooter.normal.dot(d);
            let square = cluster.radius * cluster.radius;
            let allowed =
                20.0 * square / (height * d.length()) + bound.factor + 0.8 * ratio * cluster.radius;
            assert!(off <= allowed, "face {f}, cluster {k}: {off} > {allowed}");
            assert!(
                sum.max_element() <= 3.9 * bound.factor,
                "face {f}, cluster {k}"
            );
            linked += 1;
        }
    }
    assert!(linked > 1000, "{linked}");
}

#[test]
fn a_face_that_ended_another_ray_changes_no_sight() {
    let mut scene = ball(6);
    scene.faces[4..6]
        .iter_mut()
        .for_each(|face| face.reflectance = Vec3::ZERO);
    let mut mesh = Mesh::uniform(&scene, 1, 1).unwrap();
    // As in a relight: what is no room's face may be seen through.
    mesh.room = 66;
    let rays = Rays::new(&mesh);
    let centre = |f: u32| mesh.cells[f as usize].shooter.centre;
    let (mut blocked, mut ended) = (0, 0);
    for (f, g) in (0..126).flat_map(|f| (f + 1..126).map(move |g| (f, g))) {
        let ends = [f, g];
        for through in [false, true] {
            let sight = rays.sight(centre(f), centre(g), ends, through);
            blocked += u32::from(sight == Sight::Blocked);
            for other in [NOBODY, f, g, (7 * f + g) % 126, (f + 5 * g) % 126] {
                let last = Cell::new(other);
                let found = rays.sight_past(centre(f), centre(g), ends, through, &last);
                assert_eq!(found, sight, "{f} to {g} past {other}");
                ended += u32::from(last.get() != other);
            }
        }
    }
    assert!(blocked > 500 && ended > 1000, "{blocked} {ended}");
}

#[test]
fn a_body_of_many_faces_is_lit_as_the_matrix_has_it() {
    let scene = ball(6);
    let asked = 0.02;
    let answer = solved(&scene, asked, 4);
    let off = error(&scene, &answer, &truth_on(&scene, 4));
    println!("{}: {off:.4} off, {:?}", scene.name, answer.estimate);
    assert!(off <= asked, "{off}");
}
