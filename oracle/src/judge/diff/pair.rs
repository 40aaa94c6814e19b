//! Two results of one scene on one grid.

use super::reflected::{Reflected, offsets};
use crate::judge::compare::difference::{channels, worst};
use crate::judge::resample::{areas, average, average_error, common_resolution, pieces};
use common::scene::Scene;
use common::texel::count;
use glam::DVec3;
use std::ops::Range;

/// Corners may differ by this share of the scene's extent.
const CORNERS: f64 = 1e-4;

/// Both results' reflected part on the common grid, texels as in [`Reflected`].
#[derive(Clone, Debug)]
pub struct Pair {
    /// The common resolution of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// The first texel of each face, and the number of all.
    pub first: Vec<usize>,
    /// Texel areas, scene units squared.
    pub areas: Vec<f64>,
    /// What is judged.
    pub a: Vec<DVec3>,
    /// The truth.
    pub b: Vec<DVec3>,
    /// The truth's own standard errors, if it states them.
    pub error: Option<Vec<DVec3>>,
    /// Faces on which finer texels had to be cut.
    pub cut: usize,
}

/// Two scenes are not the same: the first face that tells (if one does), and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Mismatch {
    /// The face.
    pub face: Option<usize>,
    /// In words.
    pub message: String,
}

impl Pair {
    /// Averages `a` and `b` on common texels; `error` are standard errors of `b`.
    pub fn new(
        a: &Reflected,
        b: &Reflected,
        error: Option<&[DVec3]>,
    ) -> std::result::Result<Self, Mismatch> {
        check(a.scene, b.scene)?;
        let resolutions: Vec<[u32; 2]> = a
            .resolutions
            .iter()
            .zip(&b.resolutions)
            .map(|(a, b)| common_resolution(*a, *b))
            .collect();
        let first = offsets(&resolutions);
        let mut pair = Self {
            areas: Vec::with_capacity(first[resolutions.len()]),
            a: Vec::new(),
            b: Vec::new(),
            error: error.map(|_| Vec::new()),
            cut: 0,
            first,
            resolutions,
        };
        let (first_a, first_b) = (offsets(&a.resolutions), offsets(&b.resolutions));
        for (k, face) in b.scene.faces.iter().enumerate() {
            let to = pair.resolutions[k];
            let from = [a.resolutions[k], b.resolutions[k]];
            let [of_a, of_b] = from.map(|from| pieces(face, from, to));
            let (at_a, at_b) = (first_a[k]..first_a[k + 1], first_b[k]..first_b[k + 1]);
            pair.areas.extend(areas(&of_b, to));
            pair.a.extend(average(&a.values[at_a], &of_a, to));
            pair.b.extend(average(&b.values[at_b.clone()], &of_b, to));
            if let (Some(sums), Some(error)) = (&mut pair.error, error) {
                sums.extend(average_error(&error[at_b], &of_b, to));
            }
            let whole = |pieces: usize, from| pieces == count(from) as usize;
            let uncut = whole(of_a.len(), from[0]) && whole(of_b.len(), from[1]);
            pair.cut += usize::from(!uncut);
        }
        Ok(pair)
    }

    /// Relative RMS and bias, the worst channel of each.
    pub fn worst(&self) -> (f64, f64) {
        let worst = worst(channels(self.texels(0..self.areas.len())));
        (worst.relative_rms, worst.bias)
    }

    /// Area, a and b of some texels.
    pub fn texels(&self, some: Range<usize>) -> impl Iterator<Item = (f64, DVec3, DVec3)> {
        some.map(|k| (self.areas[k], self.a[k], self.b[k]))
    }
}

/// Whether two scenes have the same faces in the same order; names do not matter.
fn check(a: &Scene, b: &Scene) -> std::result::Result<(), Mismatch> {
    let (ours, theirs) = (a.faces.len(), b.faces.len());
    if ours != theirs {
        return Err(Mismatch {
            face: None,
            message: format!("has {ours} faces, the other result {theirs}"),
        });
    }
    let allowed = CORNERS * extent(b);
    for (k, (face, truth)) in a.faces.iter().zip(&b.faces).enumerate() {
        let differ = |message| {
            Err(Mismatch {
                face: Some(k),
                message,
            })
        };
        if face.shape != truth.shape {
            return differ("is a quad in one result and a triangle in the other".into());
        }
        for (c, (p, q)) in face.corners.iter().zip(&truth.corners).enumerate() {
            let distance = p.distance(*q);
            // Not ≤: NaN must not pass.
            if distance.is_nan() || distance > allowed {
                return differ(format!(
                    "its corner {c} is {distance:.3e} away from the other result's ({allowed:.3e} is allowed): not the same scene"
                ));
            }
        }
    }
    Ok(())
}

fn extent(scene: &Scene) -> f64 {
    let corners = || scene.faces.iter().flat_map(|f| f.outline());
    let low = corners().fold(DVec3::INFINITY, |low, c| low.min(*c));
    let high = corners().fold(DVec3::NEG_INFINITY, |high, c| high.max(*c));
    (high - low).max_element()
}
