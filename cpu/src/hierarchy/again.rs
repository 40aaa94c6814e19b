//! What each thing that a gather leaves out is worth: some texels receive again, with one threshold
//! lowered at a time.

use crate::hierarchy::block::{Receivers, Spot};
use crate::hierarchy::find::Way;
use crate::hierarchy::light::Glow;
use crate::hierarchy::solve::Goal;
use crate::hierarchy::state::{Solve, prepared};
use crate::hierarchy::world::{Thresholds, Watch, What};
use crate::rows::receivers::LANES;
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use glam::{DVec3, Vec3};

/// Runs of neighbours that receive again.
const RUNS: usize = 32;
/// The threshold that is lowered, of what it was: what it still leaves out is little of what it did.
const FINER: f32 = 0.25;
/// Runs are drawn by their weight, and as often as if so much of all weight were spread evenly.
const EVEN: f64 = 0.1;

/// What a gather leaves out, each ∫ (ρΔH)² dA over ∫ (ρH)² dA by channel, from the texels that were looked at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Left {
    /// By how a node's light varies.
    pub sources: DVec3,
    /// By what stands between.
    pub visibility: DVec3,
    /// By light that neighbours tell, and no texel has received for itself.
    pub receivers: DVec3,
    /// By what is sent on: neighbours are off together.
    pub propagation: DVec3,
    /// By the size of texels.
    pub texels: DVec3,
}

/// What the answer `irradiance`, the mean over each texel's area, has left out; texels are drawn where
/// `weight`, of each of them, is large.
///
/// Errors: those of [`crate::hierarchy::solve::solve`].
pub fn again(
    scene: &Scene,
    mesh: &Mesh,
    irradiance: &[Vec3],
    weight: &[f32],
    goal: Goal,
    watch: Watch,
) -> Result<Left> {
    prepared(scene, mesh, &[], Way::Shafts, |solve| {
        look(solve, irradiance, weight, goal.fine, watch)
    })
}

/// Neighbours of a face which receive again, and how many of all they stand for.
struct Look {
    /// Leaves of the tree.
    leaves: Vec<u32>,
    stands_for: f64,
}

fn look(
    mut solve: Solve,
    irradiance: &[Vec3],
    weight: &[f32],
    fine: Thresholds,
    watch: Watch,
) -> Result<Left> {
    let texels = &solve.world.mesh.texels;
    let received = solve.of_open(irradiance);
    let shone = solve.reflected(&received);
    let shone: Vec<Vec3> = (shone.iter().zip(texels))
        .map(|(r, t)| *r + t.emission)
        .collect();
    let glow = solve.glow(&shone);
    solve.scale = solve.inverse_rms(&received);
    let looks = drawn(&solve, weight);
    let receivers = spots(&solve, &looks);
    let mut found = |thresholds| at(&solve, &glow, thresholds, &receivers, watch);
    let same = found(fine)?;
    let sources = found(Thresholds {
        source: FINER * fine.source,
        ..fine
    })?;
    let visibility = found(Thresholds {
        visibility: FINER * fine.visibility,
        ..fine
    })?;
    let near = found(Thresholds {
        near: FINER * fine.near,
        ..fine
    })?;
    let reflected = |k: usize| (texels[k].reflectance * irradiance[k]).as_dvec3();
    let light = |k: usize| reflected(k).powf(2.0) * f64::from(texels[k].area);
    let light: DVec3 = (0..texels.len()).map(light).sum();
    let share = light.map(|light| if light > 0.0 { 1.0 / light } else { 0.0 });
    let mut left = Left::default();
    for look in &looks {
        let texel = |leaf: &u32| solve.world.tree.leaves[*leaf as usize].texel as usize;
        let all: Vec<usize> = look.leaves.iter().map(texel).collect();
        let reflects = |k: usize| texels[k].reflectance.as_dvec3();
        let square = |off: &dyn Fn(usize) -> DVec3| -> DVec3 {
            let of = |k: &usize| (reflects(*k) * off(*k)).powf(2.0) * f64::from(texels[*k].area);
            share * look.stands_for * all.iter().map(of).sum::<DVec3>()
        };
        let off = |k: usize| (irradiance[k] - same[k]).as_dvec3();
        let together: DVec3 = all.iter().map(|k| off(*k)).sum::<DVec3>() / all.len() as f64;
        left.sources += square(&|k| (sources[k] - same[k]).as_dvec3());
        left.visibility += square(&|k| (visibility[k] - same[k]).as_dvec3());
        left.texels += square(&|k| (near[k] - same[k]).as_dvec3());
        left.propagation += square(&|_| together);
        left.receivers += square(&|k| off(k) - together);
    }
    Ok(left)
}

/// Runs of sixteen neighbours at most, at even steps of the sum of their weights.
fn drawn(solve: &Solve, weight: &[f32]) -> Vec<Look> {
    let tree = solve.world.tree;
    let of_face = |root: &u32| tree.nodes[*root as usize].leaves.clone();
    let runs: Vec<Vec<u32>> = tree
        .roots
        .iter()
        .flat_map(|root| {
            let leaves: Vec<u32> = of_face(root).collect();
            leaves
                .chunks(LANES)
                .map(<[u32]>::to_vec)
                .collect::<Vec<_>>()
        })
        .collect();
    let of_run = |run: &Vec<u32>| -> f64 {
        let texels = run.iter().map(|leaf| tree.leaves[*leaf as usize].texel);
        texels.map(|k| f64::from(weight[k as usize])).sum()
    };
    let own: Vec<f64> = runs.iter().map(of_run).collect();
    let all: f64 = own.iter().sum();
    let even = EVEN * all / runs.len() as f64;
    let step = (1.0 + EVEN) * all / RUNS as f64;
    let (mut sum, mut next) = (0.0, 0.5 * step);
    let mut looks = Vec::new();
    for (leaves, own) in runs.into_iter().zip(own) {
        let own = own + even;
        sum += own;
        let mut times = 0;
        while step > 0.0 && next < sum {
            next += step;
            times += 1;
        }
        if times > 0 {
            looks.push(Look {
                leaves,
                stands_for: f64::from(times) * step / own,
            });
        }
    }
    looks
}

fn spots(solve: &Solve, looks: &[Look]) -> Receivers {
    let world = &solve.world;
    let mut by_face: Vec<Vec<Spot>> = vec![Vec::new(); world.mesh.faces.len()];
    for leaf in looks.iter().flat_map(|look| &look.leaves) {
        let node = world.tree.leaves[*leaf as usize].node;
        let face = world.tree.nodes[node as usize].face;
        by_face[face as usize].extend(solve.feet.of_node(world.tree, node));
    }
    Receivers::new(world.mesh, &world.clusters.order, |f| by_face[f].clone())
}

/// H of the texels that receive, the mean over each one's area; 0 of the others.
fn at(
    solve: &Solve,
    glow: &[Glow],
    thresholds: Thresholds,
    receivers: &Receivers,
    watch: Watch,
) -> Result<Vec<Vec3>> {
    let lit = solve.gathered(What::Light, glow, thresholds, receivers, 0.0..1.0, watch)?;
    let mut found = vec![Vec3::ZERO; solve.area.len()];
    for (block, lit) in receivers.blocks.iter().zip(&lit) {
        for l in 0..block.count {
            let texel = solve.world.tree.leaves(block.target[l])[0].texel as usize;
            let [r, g, b] = lit.sums;
            found[texel] += Vec3::new(r[l], g[l], b[l]) * block.share[l];
        }
    }
    Ok(found)
}
