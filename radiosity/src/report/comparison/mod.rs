//! Report of a CPU–GPU comparison: `report.html`, one page that opens offline, and `report.json`.

mod charts;
mod figures;
mod json;
mod page;
mod section;
pub(crate) mod tables;

pub use json::report_json;
pub use page::render_report;
