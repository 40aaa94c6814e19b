//! The properties, one function each: energy, closure, reciprocity, linearity, monotonicity, symmetry.

mod closure;
mod energy;
mod escape;
mod linearity;
mod monotonicity;
mod reciprocity;
mod symmetry;

pub use closure::check_closure;
pub use energy::check_energy;
pub use linearity::check_linearity;
pub use monotonicity::check_monotonicity;
pub use reciprocity::check_reciprocity;
pub use symmetry::{check_corner_order, check_face_order, check_mirror, check_similarity, check_split};
