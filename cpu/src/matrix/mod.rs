//! Matrix radiosity: the dense linear system over all texels, each of which shoots and receives.
//!
//! ```text
//! H = W (o∘E + ρ∘H)      B = E + ρ∘H      W_ji = G_ij / (A_j o_i)      G_ij = ∫∫ V k dA_i dA_j
//! ```
//! B, E, H in W/m² as means over a texel's whole area A (mesh units squared); o is the share of it on
//! which nothing stands. A covered part receives nothing, what it emits is lost, and what a texel
//! reflects leaves from its open part: hence 1/o, and o∘E. With radiosity u = E + ρH/o on the open
//! parts this is the usual system over the areas oA, and G is symmetric. f64 throughout.
//!
//! Source: Goral et al. 1984; form factors as in [`pair`], visibility as in [`share`].

pub mod assemble;
pub mod contour;
pub mod gauss;
pub mod ledger;
pub mod memory;
pub mod open;
pub mod pair;
pub mod share;
mod system;

use crate::occlusion::occluders::Occluders;
use assemble::{Assembly, Pairs};
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use faer::{Mat, MatRef};
use glam::DVec3;
use memory::{allocate, bytes};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;

/// Columns between two looks at the progress.
const BATCH: usize = 32;
/// Pairs whose two directions are computed and compared.
const COMPARED: usize = 4096;

/// W with the texels' areas.
pub struct Matrix {
    /// W, column after column: W_ji at i·n + j is the irradiance of j per radiosity of i.
    weights: Vec<f64>,
    /// Areas in squared mesh units.
    pub areas: Vec<f64>,
    /// Open share of each area.
    pub open: Vec<f64>,
    /// The share of each open part's hemisphere that meets no front.
    pub escaped: Vec<f64>,
}

/// What the assembly knows about its accuracy.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Quality {
    /// Greatest |1 − ΣF − escaped| of a texel's open part.
    pub closure_max: f64,
    /// Its area-weighted mean.
    pub closure_mean: f64,
    /// Greatest |A_i F_ij − A_j F_ji| relative to it, pairs with nothing in between, of a sample.
    pub reciprocity: f64,
    /// Greatest difference of the visible share seen from either end, pairs partly hidden, of a
    /// sample: the error of sampled visibility.
    pub visibility: f64,
    /// Pairs with nothing in between.
    pub exact_pairs: u64,
    /// Pairs that one face hides: exactly 0.
    pub hidden_pairs: u64,
    /// Pairs whose visibility was sampled.
    pub sampled_pairs: u64,
    /// Memory of the matrix and its factors.
    pub bytes: u64,
}

/// The texels' state, W/m².
#[derive(Clone, Debug)]
pub struct Answer {
    /// B.
    pub radiosity: Vec<DVec3>,
    /// H.
    pub irradiance: Vec<DVec3>,
    /// Greatest |H − W(o∘E + ρ∘H)| relative to the greatest H.
    pub residual: f64,
}

impl Matrix {
    /// Exact form factors and sampled visibility; `watch` sees columns done of all, and may break.
    pub fn assemble(
        scene: &Scene,
        mesh: &Mesh,
        watch: &mut dyn FnMut(u64, u64) -> ControlFlow<()>,
    ) -> Result<(Self, Quality)> {
        let n = mesh.texels.len();
        let occluders = Occluders::new(scene, mesh);
        let rays = Rays::new(mesh);
        let elements = open::elements(scene, mesh, &occluders, &rays);
        let assembly = Assembly::new(&occluders, &elements);
        let mut matrix = Self {
            weights: allocate(n)?,
            areas: elements.iter().map(|element| element.area).collect(),
            open: elements.iter().map(|element| element.open).collect(),
            escaped: Vec::new(),
        };
        let mut pairs = Pairs::default();
        for (batch, columns) in matrix.weights.chunks_mut(BATCH * n).enumerate() {
            let counts: Vec<Pairs> = columns
                .par_chunks_mut(n)
                .enumerate()
                .map(|(k, column)| assembly.fill(batch * BATCH + k, column))
                .collect();
            for count in counts {
                pairs += count;
            }
            let done = ((batch + 1) * BATCH).min(n) as u64;
            if watch(done, n as u64).is_break() {
                return Err(Error::Interrupted);
            }
        }
        matrix.mirror();
        matrix.escaped = ledger::escaped_shares(mesh, &rays, &elements);
        let [closure_max, closure_mean] = ledger::closure(&matrix);
        let [reciprocity, visibility] = assembly.reciprocity(COMPARED);
        let quality = Quality {
            closure_max,
            closure_mean,
            reciprocity,
            visibility,
            exact_pairs: pairs.exact,
            hidden_pairs: pairs.hidden,
            sampled_pairs: pairs.sampled,
            bytes: bytes(n as u64),
        };
        Ok((matrix, quality))
    }

    /// Any weights: `weight(j, i)` is the irradiance of texel j per radiosity of texel i.
    pub fn from_weights(
        areas: Vec<f64>,
        weight: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Result<Self> {
        let n = areas.len();
        let mut weights = allocate(n)?;
        weights
            .par_chunks_mut(n.max(1))
            .enumerate()
            .for_each(|(i, column)| {
                for (j, entry) in column.iter_mut().enumerate() {
                    *entry = weight(j, i);
                }
            });
        Ok(Self {
            weights,
            open: vec![1.0; n],
            escaped: vec![0.0; n],
            areas,
        })
    }

    /// Makes W of G, of which each column holds what follows the diagonal.
    fn mirror(&mut self) {
        let n = self.areas.len();
        let inverse = |x: f64| if x > 0.0 { 1.0 / x } else { 0.0 };
        let receives: Vec<f64> = self.areas.iter().map(|a| inverse(*a)).collect();
        let shoots: Vec<f64> = self.open.iter().map(|o| inverse(*o)).collect();
        for i in 0..n {
            for j in i + 1..n {
                let exchange = self.weights[i * n + j];
                self.weights[i * n + j] = exchange * receives[j] * shoots[i];
                self.weights[j * n + i] = exchange * receives[i] * shoots[j];
            }
        }
    }

    /// How many texels.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// The irradiance of texel `j` per radiosity of texel `i`.
    pub fn weight(&self, j: usize, i: usize) -> f64 {
        self.weights[i * self.len() + j]
    }

    /// ΣF of each texel: the share of what leaves its open part that other texels receive.
    pub fn sums(&self) -> Vec<f64> {
        let n = self.len();
        self.weights
            .par_chunks(n.max(1))
            .zip(&self.areas)
            .map(|(column, area)| {
                let taken: f64 = column.iter().zip(&self.areas).map(|(w, a)| w * a).sum();
                if *area > 0.0 { taken / area } else { 0.0 }
            })
            .collect()
    }

    /// B and H for the given E and ρ of each texel.
    pub fn solve(&self, emission: &[DVec3], reflectance: &[DVec3]) -> Result<Answer> {
        let n = self.len();
        let mut irradiance = vec![DVec3::ZERO; n];
        let mut residual = 0.0f64;
        let direct = self.times(&|i, c| self.open[i] * emission[i][c], &[0, 1, 2]);
        for channels in alike(reflectance) {
            let mut unknown = Mat::from_fn(n, channels.len(), |j, c| direct[(j, channels[c])]);
            let scale: Vec<f64> = reflectance.iter().map(|r| r[channels[0]]).collect();
            system::solve_dense(&self.weights, &scale, &mut unknown)?;
            for (c, channel) in channels.iter().enumerate() {
                for (j, h) in irradiance.iter_mut().enumerate() {
                    h[*channel] = unknown[(j, c)];
                }
            }
        }
        let again = self.times(
            &|i, c| self.open[i] * emission[i][c] + reflectance[i][c] * irradiance[i][c],
            &[0, 1, 2],
        );
        for c in 0..3 {
            let (mut worst, mut greatest) = (0.0f64, 0.0f64);
            for (j, h) in irradiance.iter().enumerate() {
                worst = worst.max((h[c] - again[(j, c)]).abs());
                greatest = greatest.max(h[c].abs());
            }
            if greatest > 0.0 {
                residual = residual.max(worst / greatest);
            }
        }
        let radiosity = (0..n)
            .map(|k| emission[k] + reflectance[k] * irradiance[k])
            .collect();
        Ok(Answer {
            radiosity,
            irradiance,
            residual,
        })
    }

    /// W times a value of each texel and channel.
    fn times(&self, value: &dyn Fn(usize, usize) -> f64, channels: &[usize]) -> Mat<f64> {
        let n = self.len();
        let weights = MatRef::from_column_major_slice(&self.weights, n, n);
        weights * Mat::from_fn(n, channels.len(), |i, c| value(i, channels[c]))
    }
}

/// Channels in groups of equal reflectance, which share their factors.
fn alike(reflectance: &[DVec3]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for c in 0..3 {
        let same = |group: &&mut Vec<usize>| reflectance.iter().all(|r| r[group[0]] == r[c]);
        match groups.iter_mut().find(same) {
            Some(group) => group.push(c),
            None => groups.push(vec![c]),
        }
    }
    groups
}
