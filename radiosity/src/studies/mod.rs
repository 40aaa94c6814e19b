//! Studies over many solves: speed against accuracy and error against an option ([`chart`]), the failure
//! atlas ([`stress`]), random scenes ([`random`]) and the paper's Table 4 ([`table4`]).

pub mod chart;
mod limited;
pub mod random;
pub mod stress;
pub mod table4;

use common::settings::ItemBufferProjection;

/// Stereographic projection, rasterised pixel by pixel.
const PIXEL_STEREOGRAPHIC: ItemBufferProjection = ItemBufferProjection::Stereographic;
/// Orthographic projection of the hemisphere, rasterised pixel by pixel.
const PIXEL_HEMISPHERE: ItemBufferProjection = ItemBufferProjection::Hemisphere;
