//! Builds report pages, charts, pictures and glTF exports from solutions.

pub mod chart;
pub mod coarse_solution;
pub mod comparison;
pub(crate) mod format;
pub mod gltf_export;
pub mod page;
pub mod picture;
pub mod preview;
pub mod solution_view;
pub mod table;
pub mod tone_mapping;
pub mod view;
pub mod viewer;
