//! Matrix radiosity: the dense linear system over all texels, each of which shoots and receives.
//!
//! ```text
//! H = W (o∘E + ρ∘H)      B = E + ρ∘H      W_ji = G_ij / (A_j o_i)      G_ij = ∫∫ V k dA_i dA_j
//! ```
//! B, E, H in W/m² as means over a texel's whole area A (mesh units squared); o is the open share of the area, on
//! which no body stands. A covered part receives nothing and its emission is lost; a texel's reflected light leaves
//! from its open part: hence 1/o, and o∘E. With radiosity u = E + ρH/o on the open
//! parts this is the usual system over the areas oA, and G is symmetric. f64 throughout.
//!
//! Source: Goral et al. 1984; form factors as in [`exchange_area`], visibility as in [`visible_share`].

pub mod assemble;
pub mod contour_integral;
pub mod exchange_area;
mod lu_solve;
pub mod memory;
pub mod open_area;
pub mod open_points;
pub mod quadrature;
pub mod shot_log;
pub mod visible_share;

use crate::occlusion::occluders::Occluders;
use assemble::{Assembly, PairCounts};
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::{Error, Result};
use faer::{Mat, MatRef};
use glam::DVec3;
use memory::{allocate_weights, matrix_bytes};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;

/// Columns between two calls of the progress callback.
const COLUMNS_PER_BATCH: usize = 32;
/// Pairs whose two directions are computed and compared.
const COMPARED_PAIR_COUNT: usize = 4096;

/// The matrix W with the texels' areas.
pub struct Matrix {
    /// W, column after column: W_ji at i·n + j is the irradiance of j per radiosity of i.
    weights: Vec<f64>,
    /// Areas in squared mesh units.
    pub areas: Vec<f64>,
    /// Open share of each area.
    pub open: Vec<f64>,
    /// Share of each open part's hemisphere that meets no front.
    pub escaped: Vec<f64>,
}

/// Greatest and area-weighted mean |1 − ΣF − escaped| of the open parts.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ClosureDefects {
    /// The greatest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
}

/// Accuracy and size of an assembled matrix.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct AssemblyQuality {
    /// |1 − ΣF − escaped| of the texels' open parts.
    pub closure: ClosureDefects,
    /// Greatest relative |A_i F_ij − A_j F_ji| of a sample of unoccluded pairs.
    pub reciprocity: f64,
    /// Greatest difference of the visible shares from both ends in a sample of partly hidden pairs: the error of
    /// sampled visibility.
    pub visibility: f64,
    /// Unoccluded pairs.
    pub exact_pairs: u64,
    /// Pairs that one face hides: exactly 0.
    pub hidden_pairs: u64,
    /// Pairs whose visibility was sampled.
    pub sampled_pairs: u64,
    /// Memory of the matrix and its factors.
    pub bytes: u64,
}

/// The solution at each texel, W/m².
#[derive(Clone, Debug)]
pub struct DenseSolution {
    /// B.
    pub radiosity: Vec<DVec3>,
    /// H.
    pub irradiance: Vec<DVec3>,
    /// Greatest |H − W(o∘E + ρ∘H)| relative to the greatest H.
    pub residual: f64,
}

impl Matrix {
    /// Assembles W from exact form factors and sampled visibility; `watch` receives the finished columns and all, and
    /// may break.
    ///
    /// Errors: [`Error::Interrupted`]; memory.
    pub fn assemble(
        scene: &Scene,
        mesh: &Mesh,
        watch: &mut dyn FnMut(u64, u64) -> ControlFlow<()>,
    ) -> Result<(Self, AssemblyQuality)> {
        let n = mesh.texels.len();
        let occluders = Occluders::new(scene, mesh);
        let rays = Rays::new(mesh);
        let elements = open_area::open_elements(scene, mesh, &occluders, &rays);
        let assembly = Assembly::new(&occluders, &elements);
        let mut matrix = Self {
            weights: allocate_weights(n)?,
            areas: elements.iter().map(|element| element.area).collect(),
            open: elements.iter().map(|element| element.open).collect(),
            escaped: Vec::new(),
        };
        let mut pairs = PairCounts::default();
        for (batch, columns) in matrix.weights.chunks_mut(COLUMNS_PER_BATCH * n).enumerate() {
            let counts: Vec<PairCounts> = columns
                .par_chunks_mut(n)
                .enumerate()
                .map(|(k, column)| assembly.fill_column(batch * COLUMNS_PER_BATCH + k, column))
                .collect();
            for count in counts {
                pairs += count;
            }
            let done = ((batch + 1) * COLUMNS_PER_BATCH).min(n) as u64;
            if watch(done, n as u64).is_break() {
                return Err(Error::Interrupted);
            }
        }
        matrix.expand_symmetric();
        matrix.escaped = shot_log::escaped_shares(mesh, &rays, &elements);
        let [reciprocity, visibility] = assembly.max_asymmetry(COMPARED_PAIR_COUNT);
        let quality = AssemblyQuality {
            closure: shot_log::closure_defects(&matrix),
            reciprocity,
            visibility,
            exact_pairs: pairs.exact,
            hidden_pairs: pairs.hidden,
            sampled_pairs: pairs.sampled,
            bytes: matrix_bytes(n as u64),
        };
        Ok((matrix, quality))
    }

    /// Makes a matrix of given weights: `weight(j, i)` is the irradiance of texel j per radiosity of texel i.
    pub fn from_weights(areas: Vec<f64>, weight: impl Fn(usize, usize) -> f64 + Sync) -> Result<Self> {
        let n = areas.len();
        let mut weights = allocate_weights(n)?;
        weights.par_chunks_mut(n.max(1)).enumerate().for_each(|(i, column)| {
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

    /// Replaces G, of which each column holds the part below the diagonal, by W.
    fn expand_symmetric(&mut self) {
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

    /// Returns the number of texels.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Returns true if there are no texels.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Returns the irradiance of texel `j` per radiosity of texel `i`.
    pub fn weight(&self, j: usize, i: usize) -> f64 {
        self.weights[i * self.len() + j]
    }

    /// Returns ΣF of each texel: the share of the light from its open part that other texels receive.
    pub fn form_factor_sums(&self) -> Vec<f64> {
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

    /// Solves for B and H, given E and ρ of each texel.
    pub fn solve(&self, emission: &[DVec3], reflectance: &[DVec3]) -> Result<DenseSolution> {
        let n = self.len();
        let mut irradiance = vec![DVec3::ZERO; n];
        let mut residual = 0.0f64;
        let direct = self.times_weights(&|i, c| self.open[i] * emission[i][c], &[0, 1, 2]);
        for channels in channel_groups(reflectance) {
            let mut unknown = Mat::from_fn(n, channels.len(), |j, c| direct[(j, channels[c])]);
            let scale: Vec<f64> = reflectance.iter().map(|r| r[channels[0]]).collect();
            lu_solve::solve_dense(&self.weights, &scale, &mut unknown)?;
            for (c, channel) in channels.iter().enumerate() {
                for (j, h) in irradiance.iter_mut().enumerate() {
                    h[*channel] = unknown[(j, c)];
                }
            }
        }
        let product = self.times_weights(
            &|i, c| self.open[i] * emission[i][c] + reflectance[i][c] * irradiance[i][c],
            &[0, 1, 2],
        );
        for c in 0..3 {
            let (mut worst, mut greatest) = (0.0f64, 0.0f64);
            for (j, h) in irradiance.iter().enumerate() {
                worst = worst.max((h[c] - product[(j, c)]).abs());
                greatest = greatest.max(h[c].abs());
            }
            if greatest > 0.0 {
                residual = residual.max(worst / greatest);
            }
        }
        let radiosity = (0..n).map(|k| emission[k] + reflectance[k] * irradiance[k]).collect();
        Ok(DenseSolution {
            radiosity,
            irradiance,
            residual,
        })
    }

    /// Multiplies W by a value of each texel and channel.
    fn times_weights(&self, value: &dyn Fn(usize, usize) -> f64, channels: &[usize]) -> Mat<f64> {
        let n = self.len();
        let weights = MatRef::from_column_major_slice(&self.weights, n, n);
        weights * Mat::from_fn(n, channels.len(), |i, c| value(i, channels[c]))
    }
}

/// Groups channels of equal reflectance, which share their LU factors.
fn channel_groups(reflectance: &[DVec3]) -> Vec<Vec<usize>> {
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
