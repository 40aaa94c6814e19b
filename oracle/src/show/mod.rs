//! Pages, charts and pictures.

pub mod chart;
pub mod page;
pub mod picture;
pub mod report;
pub mod view;
