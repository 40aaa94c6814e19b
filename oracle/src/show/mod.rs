//! Pages, charts and pictures.

pub mod around;
pub mod bake;
pub mod cards;
pub mod chart;
pub(crate) mod number;
pub mod page;
pub mod picture;
pub mod preview;
pub mod report;
pub mod shown;
pub mod tone;
pub mod view;
pub mod viewer;
