//! Trees of nodes: children tile their parents, each texel is one leaf, and linear radiosity is fitted exactly.

use common::mesh::Mesh;
use common::scene::Scene;
use cpu::hierarchy::linear_radiosity::pull_radiosity;
use cpu::hierarchy::tree::TexelTree;
use glam::Vec3;
use radiosity_tests::solutions::{FACE_SHAPES, drawn_scene};

fn random_scenes() -> impl Iterator<Item = Scene> {
    let seeds = (771_201..).zip(FACE_SHAPES);
    seeds.map(|(seed, faces)| drawn_scene(seed, faces))
}

#[test]
fn children_tile_their_node_and_each_texel_is_one_leaf() {
    for scene in random_scenes() {
        for n in [1, 2, 3, 6, 7, 8] {
            let mesh = Mesh::uniform(&scene, n, 1).unwrap();
            let tree = TexelTree::new(&scene, &mesh).unwrap();
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
                let parts = node.children.clone().map(|k| &tree.nodes[k as usize].shooter);
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

/// Radiosity that is linear over a face has the same slope at every node, and no deviation.
#[test]
fn linear_radiosity_is_fitted_exactly() {
    for scene in random_scenes() {
        let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
        let tree = TexelTree::new(&scene, &mesh).unwrap();
        let mut value = vec![Vec3::ZERO; mesh.texels.len()];
        for leaf in &tree.leaves {
            let position = tree.nodes[leaf.node as usize].face_position;
            value[leaf.texel as usize] = Vec3::splat(10.0 + position.x - 2.0 * position.y);
        }
        let area: Vec<f32> = mesh.texels.iter().map(|t| t.area).collect();
        let radiosity = pull_radiosity(&tree, &area, &value);
        for (node, radiosity) in tree.nodes.iter().zip(&radiosity) {
            let expected = 10.0 + node.face_position.x - 2.0 * node.face_position.y;
            // Values are of the order of ten, and rounded; a slope is their difference over a node's
            // width.
            let rounding = 32.0 * 16.0 * f32::EPSILON;
            assert!((radiosity.mean.x - expected).abs() <= rounding);
            let slope = rounding / node.shooter.radius.max(1e-6);
            assert!((radiosity.slope[0].x - 1.0).abs() <= slope, "{radiosity:?}");
            assert!((radiosity.slope[1].x + 2.0).abs() <= slope, "{radiosity:?}");
            if !node.children.is_empty() {
                // The root of a difference of squares.
                assert!(radiosity.deviation.x <= 1e-3, "{radiosity:?}");
            }
        }
    }
}
