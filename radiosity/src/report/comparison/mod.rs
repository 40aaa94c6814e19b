//! Report of a CPU–GPU comparison: `report.html`, one page that opens offline, and `report.json`.

mod divergence;
mod figures;
mod json;
mod page;

pub use json::report_json;
pub use page::render_report;
