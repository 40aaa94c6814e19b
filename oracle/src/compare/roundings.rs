//! Bounds of the rounding errors of each stage of a shot, counted from its operations: the checks of stages, of links,
//! and the search for the first divergence read them here.

use common::constants::{PATCH_SUM_LANES, SELECT_LANES};
use common::escape::ESCAPE_DIRECTION_COUNT;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::settings::Transport;

/// Roundings of a disc form factor and a deposit: 3 dot products of 5, division, square root,
/// 8 products, each up to 3 ulp in WGSL's weaker divisions and roots.
pub const DISC_ROUNDINGS: f64 = 32.0;
/// The same for a polygon: 5 edges of a cross product, a root, an angle and a division.
const POLYGON_ROUNDINGS: f64 = 128.0;
/// Largest number of roundings by which an adapter's arithmetic may move the end of a ray or its projection.
pub const MAX_END_ROUNDINGS: f32 = 32.0;
/// Largest rounding error of a block's sums and weights relative to its largest value, in units of 2⁻²⁴: a
/// polygon's form factor and its moments, a sum over links, and WGSL's weaker divisions and roots.
pub const MAX_BLOCK_ROUNDINGS: f64 = 384.0;
/// Directions of the hemisphere that both solvers may count differently: those through an edge.
pub const MAX_ESCAPE_DIRECTIONS: f64 = 2.0;

/// Largest differences by rounding, in ulp of the size of the terms that a stage adds.
#[derive(Clone, Copy, Debug)]
pub struct StageRoundings {
    /// Frame of a sample: one cross product.
    pub frame: f64,
    /// F.
    pub form_factor: f64,
    /// Σ g, Σ g·V, and w of the same F and visibility.
    pub link: f64,
    /// w of CPU and GPU with equal visibility.
    pub links_of_both: f64,
    /// H, B and r after a shot over the same links.
    pub deposit: f64,
    /// Sums over the texels of a patch: additions in one lane, a tree, and products.
    pub patch_sum: f64,
    /// Sums over all patches: additions in one lane, a tree, and a division.
    pub sum_of_patches: f64,
}

impl StageRoundings {
    /// Returns the bounds of shots on `mesh`.
    pub fn of(mesh: &Mesh, transport: &Transport) -> Self {
        let samples = f64::from(mesh.samples);
        let form_factor = form_factor_roundings(transport.form_factor);
        let most = mesh.patches.iter().map(|c| c.count as usize).max().unwrap_or(0);
        Self {
            frame: 2.0,
            form_factor,
            link: DISC_ROUNDINGS + samples,
            links_of_both: form_factor + samples,
            deposit: DISC_ROUNDINGS,
            patch_sum: (most.div_ceil(PATCH_SUM_LANES) + 6 + 4) as f64,
            sum_of_patches: (mesh.patches.len().div_ceil(SELECT_LANES) + 8 + 4) as f64,
        }
    }
}

/// Returns the number of roundings of a form factor.
pub fn form_factor_roundings(kind: FormFactor) -> f64 {
    match kind {
        FormFactor::Polygon => POLYGON_ROUNDINGS,
        _ => DISC_ROUNDINGS,
    }
}

/// Returns the difference of two escaped shares in directions of the hemisphere.
pub fn escape_difference(a: f32, b: f32) -> f64 {
    f64::from((a - b).abs()) * ESCAPE_DIRECTION_COUNT as f64
}
