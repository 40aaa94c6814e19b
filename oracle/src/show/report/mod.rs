//! `report.html`, one file that opens offline and is meant to be looked at, and `report.json`.

mod charts;
mod figures;
mod json;
mod page;
mod section;
pub(crate) mod tables;

pub use json::json;
pub use page::html;
