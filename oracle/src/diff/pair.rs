//! Averages two results of one scene on a common grid. Diffs, charts and the truth of a comparison measure errors on
//! it.

use super::reflected::ReflectedField;
use crate::diff::difference::{channel_differences, worst_channel};
use common::resample::{area_average, average_standard_error, common_resolution, shared_pieces, summed_areas};
use common::scene::Scene;
use common::texel::{first_texels, texel_count};
use glam::DVec3;
use std::ops::Range;

/// Largest distance between corners of the same scene, as a share of its extent.
const MAX_CORNER_DISTANCE: f64 = 1e-4;

/// Reflected radiosity of both results on the common grid, texels in the order of [`ReflectedField`].
#[derive(Clone, Debug)]
pub struct GridPair {
    /// Common resolution of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// First texel of each face, followed by the number of all texels.
    pub first: Vec<usize>,
    /// Texel areas, scene units squared.
    pub areas: Vec<f64>,
    /// Compared result.
    pub a: Vec<DVec3>,
    /// Truth.
    pub b: Vec<DVec3>,
    /// Standard errors of the truth, if it has any.
    pub error: Option<Vec<DVec3>>,
    /// Number of faces on which finer texels were cut.
    pub cut: usize,
}

/// Reason why two scenes are not the same.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMismatch {
    /// First face that differs, if the faces correspond.
    pub face: Option<usize>,
    /// Description of the difference.
    pub message: String,
}

impl GridPair {
    /// Averages `a` and `b` on common texels; `error` are the standard errors of `b`.
    ///
    /// Errors: the scenes differ.
    pub fn new(
        a: &ReflectedField,
        b: &ReflectedField,
        error: Option<&[DVec3]>,
    ) -> std::result::Result<Self, SceneMismatch> {
        check_same_scene(a.scene, b.scene)?;
        let resolutions = a.resolutions.iter().zip(&b.resolutions);
        let resolutions: Vec<[u32; 2]> = resolutions.map(|(a, b)| common_resolution(*a, *b)).collect();
        let first = first_texels(&resolutions);
        let mut pair = Self {
            areas: Vec::with_capacity(first[resolutions.len()]),
            a: Vec::new(),
            b: Vec::new(),
            error: error.map(|_| Vec::new()),
            cut: 0,
            first,
            resolutions,
        };
        let (first_a, first_b) = (first_texels(&a.resolutions), first_texels(&b.resolutions));
        for (k, face) in b.scene.faces.iter().enumerate() {
            let to = pair.resolutions[k];
            let from = [a.resolutions[k], b.resolutions[k]];
            let [of_a, of_b] = from.map(|from| shared_pieces(face, from, to));
            let (at_a, at_b) = (first_a[k]..first_a[k + 1], first_b[k]..first_b[k + 1]);
            pair.areas.extend(summed_areas(&of_b, to));
            pair.a.extend(area_average(&a.values[at_a], &of_a, to));
            pair.b.extend(area_average(&b.values[at_b.clone()], &of_b, to));
            if let (Some(sums), Some(error)) = (&mut pair.error, error) {
                sums.extend(average_standard_error(&error[at_b], &of_b, to));
            }
            let whole = |pieces: usize, from| pieces == texel_count(from) as usize;
            let uncut = whole(of_a.len(), from[0]) && whole(of_b.len(), from[1]);
            pair.cut += usize::from(!uncut);
        }
        Ok(pair)
    }

    /// Returns relative RMS and bias, the worst channel of each.
    pub fn worst_channel(&self) -> (f64, f64) {
        let worst = worst_channel(channel_differences(self.weighted_texels(0..self.areas.len())));
        (worst.relative_rms, worst.bias)
    }

    /// Iterates over area, a and b of a range of texels.
    pub fn weighted_texels(&self, range: Range<usize>) -> impl Iterator<Item = (f64, DVec3, DVec3)> {
        range.map(|k| (self.areas[k], self.a[k], self.b[k]))
    }
}

/// Checks that two scenes have the same faces in the same order; names do not matter.
///
/// Errors: they differ.
fn check_same_scene(a: &Scene, b: &Scene) -> std::result::Result<(), SceneMismatch> {
    let differ = |face, message| Err(SceneMismatch { face, message });
    let (ours, theirs) = (a.faces.len(), b.faces.len());
    if ours != theirs {
        return differ(None, format!("has {ours} faces, the other result {theirs}"));
    }
    let [low, high] = b.bounds();
    let allowed = MAX_CORNER_DISTANCE * (high - low).max_element();
    for (k, (face, truth)) in a.faces.iter().zip(&b.faces).enumerate() {
        if face.shape != truth.shape {
            let message = "is a quad in one result and a triangle in the other";
            return differ(Some(k), message.into());
        }
        for (c, (p, q)) in face.corners.iter().zip(&truth.corners).enumerate() {
            let distance = p.distance(*q);
            // Not ≤: NaN must not pass.
            if distance.is_nan() || distance > allowed {
                let message = format!(
                    "its corner {c} is {distance:.3e} away from the other result's ({allowed:.3e} is allowed): not the same scene"
                );
                return differ(Some(k), message);
            }
        }
    }
    Ok(())
}
