//! Renders the page of `diff`: views of both results, their difference in false colours, HDR-FLIP.

pub mod flip;
pub mod page;
pub mod pictures;
