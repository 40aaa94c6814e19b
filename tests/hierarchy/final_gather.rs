//! The final gather of a given irradiance.

use common::mesh::Mesh;
use common::scene::Face;
use cpu::hierarchy::block::ReceiverBlocks;
use cpu::hierarchy::final_gather::{CoveredTexels, FinalGather, ReceiverSelection};
use cpu::hierarchy::linker::{BlockIrradiance, MAX_LINEAR_DEVIATION};
use cpu::hierarchy::tree::TexelTree;
use glam::{DVec3, Vec3};
use radiosity_tests::named_scene;

const THRESHOLD: f32 = 0.01;

/// Gathers an irradiance that is `light` of x at each texel, and its mean on larger nodes. Returns the number of spots
/// that gathered, and H of the texels.
fn gather_along_x(tree: &TexelTree, mesh: &Mesh, first: f32, light: impl Fn(f32) -> f32) -> (usize, Vec<Vec3>) {
    let covered = CoveredTexels::new(tree, &[]);
    let selection = ReceiverSelection::on_faces(0..1).limit_radius(first);
    let scale = |_: u32| Vec3::ONE;
    let texels = mesh.texels.len();
    let mut gather = FinalGather::new(tree, &covered, &scale, THRESHOLD, &selection, texels);
    let mean = |k: u32| {
        let (mut sum, mut area) = (0.0, 0.0);
        for leaf in tree.leaves_of(k) {
            let texel = &mesh.texels[leaf.texel as usize];
            sum += texel.area * light(texel.position.x);
            area += texel.area;
        }
        sum / area
    };
    let mut spot_count = 0;
    while let Some(spots) = gather.next_spots() {
        spot_count += spots.iter().map(Vec::len).sum::<usize>();
        let receivers = ReceiverBlocks::new(mesh, |f| spots[f].clone());
        let lit = receivers.blocks.iter().map(|block| {
            let h = std::array::from_fn(|l| mean(block.target[l]));
            BlockIrradiance {
                sums: [h; 3],
                crosses_shadow_edge: false,
            }
        });
        let lit: Vec<BlockIrradiance> = lit.collect();
        gather.take_irradiance(&receivers.blocks, &lit);
    }
    (spot_count, gather.into_texels())
}

/// A narrowing face: its children at the wide end are too large to gather first, those at the narrow end are not. Light
/// that varies along the face only lies on a plane at the four children of each node, however it bends.
#[test]
fn node_without_receiving_neighbours_is_refined() {
    let face = |corners: [[f64; 2]; 4]| {
        let corners = corners.map(|[x, z]| DVec3::new(x, 0.0, z));
        Face::quad("face", corners, Vec3::ZERO, Vec3::ONE)
    };
    let narrowing = face([[0.0, -1.0], [4.0, -0.2], [4.0, 0.2], [0.0, 1.0]]);
    // The first nodes are small against the mesh: a far face enlarges it.
    let far = face([[39.0, -1.0], [40.0, -1.0], [40.0, 1.0], [39.0, 1.0]]);
    let scene = named_scene("narrowing", vec![narrowing, far]);
    let mesh = Mesh::uniform(&scene, 16, 1).unwrap();
    let tree = TexelTree::new(&scene, &mesh);
    let root = &tree.nodes[tree.roots[0] as usize];
    let radii: Vec<f32> = root
        .children
        .clone()
        .map(|k| tree.nodes[k as usize].shooter.radius)
        .collect();
    let [least, most] = [f32::min, f32::max].map(|of| radii.iter().copied().reduce(of).unwrap());
    assert!(most > 1.01 * least, "{radii:?}");
    let bent = |x: f32| (16.0 * (x + 0.7)).exp();
    let (_, found) = gather_along_x(&tree, &mesh, 0.5 * (least + most), bent);
    for (texel, found) in mesh.texels[..256].iter().zip(&found) {
        let off = (found.x - bent(texel.position.x)).abs();
        assert!(off <= MAX_LINEAR_DEVIATION * THRESHOLD, "{off} at {}", texel.position);
    }
    // Linear light is interpolated.
    let sloped = |x: f32| 3.0 + x;
    let (spot_count, found) = gather_along_x(&tree, &mesh, 0.5 * (least + most), sloped);
    for (texel, found) in mesh.texels[..256].iter().zip(&found) {
        let off = (found.x - sloped(texel.position.x)).abs();
        assert!(off <= 1e-5, "{off} at {}", texel.position);
    }
    assert!(spot_count < 256 / 2, "{spot_count}");
}

/// A long face whose first nodes lie in a row: light that varies across the row only is the same on all of them.
#[test]
fn nodes_in_a_row_are_refined_across_it() {
    let corners = [[0.0, 0.0], [0.0, 8.0], [1.0, 8.0], [1.0, 0.0]].map(|[x, z]| DVec3::new(x, 0.0, z));
    let scene = named_scene("row", vec![Face::quad("face", corners, Vec3::ZERO, Vec3::ONE)]);
    let mesh = Mesh::new(&scene, &[[32, 4]], 1).unwrap();
    let tree = TexelTree::new(&scene, &mesh);
    let sloped = |x: f32| 3.0 + 4.0 * x;
    let (_, found) = gather_along_x(&tree, &mesh, 0.6, sloped);
    for (texel, found) in mesh.texels.iter().zip(&found) {
        let off = (found.x - sloped(texel.position.x)).abs();
        assert!(off <= 1e-5, "{off} at {}", texel.position);
    }
}
