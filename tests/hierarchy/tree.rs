//! Nodes tile their parents, texels are leaves once, and light that slopes is kept as it is.

use common::mesh::Mesh;
use common::scene::Scene;
use cpu::hierarchy::light::pull;
use cpu::hierarchy::tree::Tree;
use glam::Vec3;
use oracle::study::random::{Faces, Options, scene};

fn scenes() -> Vec<Scene> {
    let drawn = |seed, faces| {
        let options = Options {
            faces,
            ..Options::default()
        };
        scene(seed, options).scene
    };
    vec![
        drawn(771_201, Faces::Quads),
        drawn(771_202, Faces::Triangles),
        drawn(771_203, Faces::Mixed),
    ]
}

#[test]
fn parts_tile_their_node_and_texels_are_leaves_once() {
    for scene in scenes() {
        for n in [1, 2, 3, 6, 7, 8] {
            let mesh = Mesh::uniform(&scene, n, 1).unwrap();
            let tree = Tree::new(&scene, &mesh).unwrap();
            let mut seen = vec![0; mesh.texels.len()];
            for leaf in &tree.leaves {
                let texel = &mesh.texels[leaf.texel as usize];
                let shooter = &tree.nodes[leaf.node as usize].shooter;
                // Both are rounded from the same numbers.
                assert_eq!(shooter.centre, texel.position);
                seen[leaf.texel as usize] += 1;
            }
            assert!(seen.iter().all(|count| *count == 1), "{} {n}", scene.name);
            for node in tree.nodes.iter().filter(|node| !node.children.is_empty()) {
                let parts = node
                    .children
                    .clone()
                    .map(|k| &tree.nodes[k as usize].shooter);
                let (mut area, mut moment, mut count) = (0.0, Vec3::ZERO, 0.0);
                for part in parts {
                    area += part.area;
                    moment += part.centre * part.area;
                    count += 1.0;
                }
                // A rounding of each part's area and centre (which lies within the unit cube, √3 from
                // its middle), and one of each sum.
                let bound = 2.0 * (count + 2.0) * f32::EPSILON;
                assert!((area - node.shooter.area).abs() <= bound * area);
                let off = (moment / area - node.shooter.centre).length();
                assert!(off <= 3f32.sqrt() * bound, "{} {n}: {off:e}", scene.name);
            }
        }
    }
}

/// What slopes over a face has that slope at every node of it, and nothing is left.
#[test]
fn a_slope_is_a_slope() {
    for scene in scenes() {
        let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
        let tree = Tree::new(&scene, &mesh).unwrap();
        let mut value = vec![Vec3::ZERO; mesh.texels.len()];
        for leaf in &tree.leaves {
            let place = tree.nodes[leaf.node as usize].place;
            value[leaf.texel as usize] = Vec3::splat(10.0 + place.x - 2.0 * place.y);
        }
        let area: Vec<f32> = mesh.texels.iter().map(|t| t.area).collect();
        let glow = pull(&tree, &area, &value);
        for (node, glow) in tree.nodes.iter().zip(&glow) {
            let expected = 10.0 + node.place.x - 2.0 * node.place.y;
            // Values are of the order of ten, and rounded; a slope is their difference over a node's
            // width.
            let rounding = 32.0 * 16.0 * f32::EPSILON;
            assert!((glow.mean.x - expected).abs() <= rounding);
            let slope = rounding / node.shooter.radius.max(1e-6);
            assert!((glow.slope[0].x - 1.0).abs() <= slope, "{glow:?}");
            assert!((glow.slope[1].x + 2.0).abs() <= slope, "{glow:?}");
            if !node.children.is_empty() {
                // The root of a difference of squares.
                assert!(glow.rest.x <= 1e-3, "{glow:?}");
            }
        }
    }
}
