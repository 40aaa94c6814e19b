//! From nodes down to texels, of light that is written down.

use common::mesh::Mesh;
use common::scene::Face;
use cpu::hierarchy::block::Receivers;
use cpu::hierarchy::descent::{Descent, Feet, Lit, Receiving};
use cpu::hierarchy::tree::Tree;
use cpu::hierarchy::world::EVEN;
use glam::{DVec3, Vec3};
use radiosity_tests::scene;

const THRESHOLD: f32 = 0.01;

/// Light that is `light` of x at each texel, and its mean on larger nodes, as the descent has it at the texels of
/// `mesh`; and how many nodes it asked about.
fn descended(
    tree: &Tree,
    mesh: &Mesh,
    first: f32,
    light: impl Fn(f32) -> f32,
) -> (usize, Vec<Vec3>) {
    let feet = Feet::new(tree, &[]);
    let receiving = Receiving::on(0..1).near(first);
    let scale = |_: u32| Vec3::ONE;
    let texels = mesh.texels.len();
    let mut descent = Descent::new(tree, &feet, &scale, THRESHOLD, &receiving, texels);
    let mean = |k: u32| {
        let (mut sum, mut area) = (0.0, 0.0);
        for leaf in tree.leaves(k) {
            let texel = &mesh.texels[leaf.texel as usize];
            sum += texel.area * light(texel.position.x);
            area += texel.area;
        }
        sum / area
    };
    let mut asked = 0;
    while let Some(spots) = descent.spots() {
        asked += spots.iter().map(Vec::len).sum::<usize>();
        let receivers = Receivers::new(mesh, &[0], |f| spots[f].clone());
        let lit = receivers.blocks.iter().map(|block| {
            let h = std::array::from_fn(|l| mean(block.target[l]));
            Lit {
                sums: [h; 3],
                edge: false,
            }
        });
        let lit: Vec<Lit> = lit.collect();
        descent.take(&receivers.blocks, &lit);
    }
    (asked, descent.texels())
}

/// A face that narrows: its parts at the wide end are too large to receive, those at the narrow end are not. Light
/// that varies along it alone lies in a plane at the four parts of each, however it bends.
#[test]
fn a_part_whose_neighbours_did_not_receive_does_not_tell_of_itself() {
    let face = |corners: [[f64; 2]; 4]| {
        let corners = corners.map(|[x, z]| DVec3::new(x, 0.0, z));
        Face::quad("face", corners, Vec3::ZERO, Vec3::ONE)
    };
    let narrowing = face([[0.0, -1.0], [4.0, -0.2], [4.0, 0.2], [0.0, 1.0]]);
    // Nodes receive first where they are small beside the whole.
    let far = face([[39.0, -1.0], [40.0, -1.0], [40.0, 1.0], [39.0, 1.0]]);
    let scene = scene("narrowing", vec![narrowing, far]);
    let mesh = Mesh::uniform(&scene, 16, 1).unwrap();
    let tree = Tree::new(&scene, &mesh).unwrap();
    let root = &tree.nodes[tree.roots[0] as usize];
    let radii: Vec<f32> = root
        .children
        .clone()
        .map(|k| tree.nodes[k as usize].shooter.radius)
        .collect();
    let [least, most] = [f32::min, f32::max].map(|of| radii.iter().copied().reduce(of).unwrap());
    assert!(most > 1.01 * least, "{radii:?}");
    let bent = |x: f32| (16.0 * (x + 0.7)).exp();
    let (_, found) = descended(&tree, &mesh, 0.5 * (least + most), bent);
    for (texel, found) in mesh.texels[..256].iter().zip(&found) {
        let off = (found.x - bent(texel.position.x)).abs();
        assert!(off <= EVEN * THRESHOLD, "{off} at {}", texel.position);
    }
    // Light that slopes goes no farther than it must.
    let sloped = |x: f32| 3.0 + x;
    let (asked, found) = descended(&tree, &mesh, 0.5 * (least + most), sloped);
    for (texel, found) in mesh.texels[..256].iter().zip(&found) {
        let off = (found.x - sloped(texel.position.x)).abs();
        assert!(off <= 1e-5, "{off} at {}", texel.position);
    }
    assert!(asked < 256 / 2, "{asked}");
}
