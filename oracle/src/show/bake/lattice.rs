//! How finely charts are divided: as their texels, or as finely as a neighbour's where they share an edge.
//!
//! Two faces that meet along an edge have the same values at the nodes of both. What lies between is a line on
//! either chart, so that both must have the finer one's nodes there, and no others.

use crate::show::view::patch::Patch;
use crate::show::view::surface::Surface;
use crate::show::view::weld::TOLERANCE;
use common::scene::Shape;

/// The nodes of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Steps from node to node, across and down.
    pub size: [u32; 2],
    /// Those along each edge of the outline that have values of their own.
    pub edges: [u32; 4],
}

impl Lattice {
    /// Those of all faces.
    pub fn all(surface: &Surface) -> Vec<Self> {
        let patches = &surface.patches;
        let mut edges: Vec<[u32; 4]> = patches.iter().map(steps).collect();
        for (a, b) in &surface.pairs {
            let [a, b] = [*a, *b].map(|k| k as usize);
            for (i, j) in shared(&patches[a], &patches[b]) {
                let [own, other] = [steps(&patches[a])[i], steps(&patches[b])[j]];
                let finer = own.max(other);
                // Else neither has the other's nodes.
                if [own, other]
                    .into_iter()
                    .all(|n| finer % n == 0 && (finer / n).is_power_of_two())
                {
                    edges[a][i] = edges[a][i].max(finer);
                    edges[b][j] = edges[b][j].max(finer);
                }
            }
        }
        let lattices = patches.iter().zip(edges);
        lattices
            .map(|(patch, edges)| Self::of(patch, edges))
            .collect()
    }

    fn of(patch: &Patch, edges: [u32; 4]) -> Self {
        let [a, b, c, d] = edges;
        let size = match patch.shape {
            Shape::Quad => [a.max(c), b.max(d)],
            Shape::Triangle => [a.max(b).max(c); 2],
        };
        Self { size, edges }
    }

    /// Nodes between which node (i, j) lies on a line, and its share of the way; twice the same where it has a value
    /// of its own.
    pub fn between(&self, shape: Shape, [i, j]: [u32; 2]) -> ([[u32; 2]; 2], f32) {
        let [w, h] = self.size;
        let edge = match shape {
            _ if j == 0 => Some((0, w, i)),
            _ if i == 0 => Some((if shape == Shape::Quad { 3 } else { 2 }, h, j)),
            Shape::Quad if i == w => Some((1, h, j)),
            Shape::Quad if j == h => Some((2, w, i)),
            Shape::Triangle if i + j == w => Some((1, h, j)),
            _ => None,
        };
        let Some((edge, all, at)) = edge else {
            return ([[i, j]; 2], 0.0);
        };
        let step = all / self.edges[edge];
        let (before, share) = (at - at % step, (at % step) as f32 / step as f32);
        if share == 0.0 {
            return ([[i, j]; 2], 0.0);
        }
        let node = |at: u32| match (shape, edge) {
            (_, 0) => [at, 0],
            (Shape::Quad, 1) => [w, at],
            (Shape::Quad, 2) => [at, h],
            (Shape::Triangle, 1) => [w - at, at],
            _ => [0, at],
        };
        ([node(before), node(before + step)], share)
    }
}

/// Texels along each edge.
fn steps(patch: &Patch) -> [u32; 4] {
    let [w, h] = patch.size;
    [w, h, w, h]
}

/// Edges of the two that run from the same corner to the same corner.
fn shared(a: &Patch, b: &Patch) -> Vec<(usize, usize)> {
    let edges = (0..a.edges()).flat_map(|i| (0..b.edges()).map(move |j| (i, j)));
    let same = |(i, j): &(usize, usize)| {
        let ([from, to], [there, back]) = (a.edge(*i), b.edge(*j));
        from.distance(back) < TOLERANCE && to.distance(there) < TOLERANCE
    };
    edges.filter(same).collect()
}
