//! `report.html`, one file that opens offline and is meant to be looked at, and `report.json`.

mod figures;
mod json;
pub(crate) mod number;
mod page;
mod section;
mod tables;

pub use json::json;
pub(crate) use page::document;
pub use page::html;
pub(crate) use section::{chart, colour_bar, figure};
