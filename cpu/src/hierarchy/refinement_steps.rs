//! Four steps of refining a pair of a node and a block: skip, subdivide or link. Between the steps form factors and
//! visibility of the block's spots are computed.

use crate::hierarchy::linear_radiosity::LinearRadiosity;
use crate::hierarchy::link::ExchangeBound;
use crate::hierarchy::linker::LinkThresholds;
use crate::hierarchy::tree::TreeNode;
use common::constants::{MAX_PEAK_TO_MEAN, ONE_SAMPLE_LIMIT, VISIBILITY_SAMPLE_COUNTS};
use glam::Vec3;

/// The light that a block would reflect at F = 1, over the RMS of the reflected light.
#[derive(Clone, Copy, Debug)]
pub struct ReflectedLight {
    /// Of the mean radiosity.
    pub mean: f32,
    /// Of the residual of the linear fit.
    pub rest: f32,
}

/// The decision by the variation of a node's radiosity.
pub enum SourceRefinement {
    /// The node sends nothing.
    Skip,
    /// The node's children are refined in turn.
    Subdivide,
    /// The node needs form factors.
    Pending {
        /// Light of the node.
        light: ReflectedLight,
        /// Points per side over which each spot's form factor is averaged.
        points_per_side: u32,
    },
}

/// Returns whether a node has no radiosity.
pub fn is_dark(radiosity: &LinearRadiosity) -> bool {
    radiosity.mean == Vec3::ZERO && radiosity.slope == [Vec3::ZERO; 2] && radiosity.deviation == Vec3::ZERO
}

/// Returns the light that a block of this `scale` would reflect of `light` at F = 1, over the RMS of the
/// reflected light.
pub fn reflected_light(light: Vec3, scale: Vec3) -> f32 {
    (light.abs() * scale).max_element()
}

/// Returns whether a node has no children.
pub fn is_leaf(node: &TreeNode) -> bool {
    node.children.is_empty()
}

/// Step 1: skips or subdivides a node by the variation of its radiosity at a block of this `scale`.
pub fn refine_by_source(
    node: &TreeNode,
    radiosity: &LinearRadiosity,
    bound: &ExchangeBound,
    scale: Vec3,
    thresholds: LinkThresholds,
) -> SourceRefinement {
    if bound.factor <= 0.0 {
        return SourceRefinement::Skip;
    }
    let [mean, rest, x, y] = [
        radiosity.mean,
        radiosity.deviation,
        radiosity.slope[0],
        radiosity.slope[1],
    ]
    .map(|v| reflected_light(v, scale));
    let slope = x.max(y) * node.shooter.radius;
    let variation = rest * bound.uneven + slope * bound.sloped;
    if variation > thresholds.source && !is_leaf(node) {
        return SourceRefinement::Subdivide;
    }
    SourceRefinement::Pending {
        light: ReflectedLight { mean, rest },
        points_per_side: receiver_points_per_side(bound.within, mean + rest, thresholds.near),
    }
}

/// Step 2: limits the bound by the form factors of the spots. Returns the number of the first visibility
/// samples; none where all form factors are 0.
pub fn start_sampling(bound: &mut ExchangeBound, factors: &[f32]) -> Option<u32> {
    let most = factors.iter().copied().fold(0.0, f32::max);
    bound.factor = bound.factor.min(MAX_PEAK_TO_MEAN * most);
    (most > 0.0).then_some(VISIBILITY_SAMPLE_COUNTS[0])
}

/// Step 3: returns the number of samples where the first ones are not enough.
pub fn request_samples(
    bound: &ExchangeBound,
    light: ReflectedLight,
    seen: f32,
    thresholds: LinkThresholds,
) -> Option<u32> {
    let shines = bound.factor * (light.mean + light.rest);
    let required = required_samples(shines, seen, thresholds.visibility);
    (required > ONE_SAMPLE_LIMIT).then_some(VISIBILITY_SAMPLE_COUNTS[1])
}

/// The decision to link by visibility.
pub struct VisibilityRefinement {
    /// Samples that the link needs; none where there are enough.
    pub samples: Option<u32>,
    /// True where a shadow's edge crosses the block.
    pub crosses_shadow_edge: bool,
}

/// Step 4: decides by visibility whether a source is linked; none where it is subdivided. A leaf is never
/// subdivided.
pub fn refine_by_visibility(
    bound: &ExchangeBound,
    light: ReflectedLight,
    seen: f32,
    leaf: bool,
    thresholds: LinkThresholds,
) -> Option<VisibilityRefinement> {
    let [_, second, subdivide, max] = VISIBILITY_SAMPLE_COUNTS;
    let shines = bound.factor * (light.mean + light.rest);
    let required = required_samples(shines, seen, thresholds.visibility);
    let hidden = bound.factor * light.rest * visibility_deviation(seen).max(0.125) / thresholds.near;
    if !leaf && (hidden > 1.0 || required > subdivide as f32) {
        return None;
    }
    Some(VisibilityRefinement {
        samples: (required > second as f32).then(|| required.ceil().min(max as f32) as u32),
        crosses_shadow_edge: shines * visibility_deviation(seen) > thresholds.edge,
    })
}

/// Returns the points per side of a spot over which its form factor is averaged.
pub fn receiver_points_per_side(within: f32, light: f32, near: f32) -> u32 {
    match within * light / near {
        ..1.0 => 1,
        1.0..10.0 => 2,
        10.0..100.0 => 4,
        _ => 8,
    }
}

/// Returns x^(85/64), near x^(4/3), by square roots: they are exact on every device.
pub fn four_thirds_power(x: f32) -> f32 {
    let fourth = x.sqrt().sqrt();
    let sixteenth = fourth.sqrt().sqrt();
    x * fourth * sixteenth * sixteenth.sqrt().sqrt()
}

/// Returns the standard deviation of the visibility of one sample.
pub fn visibility_deviation(seen: f32) -> f32 {
    (seen * (1.0 - seen)).max(0.0).sqrt()
}

/// Returns the number of samples for the threshold: the error of S stratified samples falls as S^(−3/4).
pub fn required_samples(shines: f32, seen: f32, visibility: f32) -> f32 {
    let error = shines * visibility_deviation(seen).max(0.125) * 0.5 / visibility;
    four_thirds_power(error)
}
