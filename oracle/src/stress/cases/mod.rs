//! The catalogue: every case once, by what it is about.

mod contact;
pub mod shapes;

use super::trial::Case;

/// All cases, in the order of the report.
pub fn all() -> Vec<&'static Case> {
    [contact::CASES].into_iter().flatten().collect()
}
