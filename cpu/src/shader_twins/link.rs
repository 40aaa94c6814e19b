//! Link from a patch to a texel, the share of the patch's radiosity that the texel receives: the form factor
//! times the visible part of the patch, from S pairs of points on the two.

pub use crate::rows::texel_link::{Baseline, Sums, add_sample, link_texel, mean_over_texel, texel_form_factor};
