//! Trees of nodes: children tile their parents, each texel is one leaf, and linear radiosity is fitted exactly.

use common::constants::MIN_COMPACT_AREA;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use cpu::hierarchy::linear_radiosity::pull_radiosity;
use cpu::hierarchy::tree::TexelTree;
use glam::{DVec3, Vec3};
use radiosity_tests::named_scene;
use radiosity_tests::solutions::{FACE_SHAPES, drawn_scene};

fn random_scenes() -> impl Iterator<Item = Scene> {
    let seeds = (771_201..).zip(FACE_SHAPES);
    seeds.map(|(seed, faces)| drawn_scene(seed, faces))
}

/// A quad nine times as long as wide.
fn long_wall() -> Scene {
    let corners = [[0.0, 0.0], [9.0, 0.0], [9.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    named_scene("long wall", vec![Face::quad("wall", corners, Vec3::ZERO, Vec3::ONE)])
}

fn assert_children_tile(scene: &Scene, mesh: &Mesh) {
    let tree = TexelTree::new(scene, mesh);
    let mut seen = vec![0; mesh.texels.len()];
    for leaf in &tree.leaves {
        let texel = &mesh.texels[leaf.texel as usize];
        let shooter = &tree.nodes[leaf.node as usize].shooter;
        // Both are rounded from the same numbers.
        assert_eq!(shooter.centre, texel.position);
        seen[leaf.texel as usize] += 1;
    }
    assert!(seen.iter().all(|count| *count == 1), "{}", scene.name);
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
        assert!(off <= 3f32.sqrt() * bound, "{}: {off:e}", scene.name);
    }
}

#[test]
fn children_tile_their_node_and_each_texel_is_one_leaf() {
    for scene in random_scenes() {
        for n in [1, 2, 3, 6, 7, 8] {
            assert_children_tile(&scene, &Mesh::uniform(&scene, n, 1).unwrap());
        }
    }
    let scene = long_wall();
    for texels in [[8, 1], [1, 8], [16, 2], [16, 16], [6, 10]] {
        assert_children_tile(&scene, &Mesh::new(&scene, &[texels], 1).unwrap());
    }
}

#[test]
fn long_face_is_divided_along_it_until_nodes_are_compact() {
    let scene = long_wall();
    let tree = TexelTree::new(&scene, &Mesh::new(&scene, &[[16, 2]], 1).unwrap());
    for node in &tree.nodes {
        let compact = node.shooter.area >= MIN_COMPACT_AREA * node.shooter.radius.powi(2);
        assert_eq!(compact, node.level >= 2, "{node:?}");
        assert_eq!(node.children.len(), [2, 2, 2, 4, 0][node.level as usize]);
        assert_eq!(node.divides_both_sides, node.level >= 3);
    }
}

#[test]
fn row_of_texels_has_the_slope_along_it() {
    let scene = long_wall();
    let mesh = Mesh::new(&scene, &[[8, 1]], 1).unwrap();
    let tree = TexelTree::new(&scene, &mesh);
    let value: Vec<Vec3> = mesh.texels.iter().map(|t| Vec3::splat(2.0 + t.position.x)).collect();
    let area: Vec<f32> = mesh.texels.iter().map(|t| t.area).collect();
    for radiosity in pull_radiosity(&tree, &area, &value) {
        // Roundings of values of the order of one, over a texel's quarter.
        assert!(
            (radiosity.slope[0].x - 1.0).abs() <= 32.0 * f32::EPSILON,
            "{radiosity:?}"
        );
        assert!(radiosity.slope[1].x.abs() <= 32.0 * f32::EPSILON, "{radiosity:?}");
    }
}

/// Radiosity that is linear over a face has the same slope at every node, and no deviation.
#[test]
fn linear_radiosity_is_fitted_exactly() {
    for scene in random_scenes() {
        let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
        let tree = TexelTree::new(&scene, &mesh);
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
