//! Builds report pages, charts, pictures and glTF exports from solutions.

pub mod coarse_solution;
pub mod comparison;
pub mod document;
pub mod energy;
pub(crate) mod format;
pub mod gltf_export;
pub mod picture;
pub mod plot;
pub mod solution_view;
pub mod trace;
pub mod view;
pub mod viewer;
