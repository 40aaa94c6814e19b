//! Error against time of every method, and error and time against one option (`--vary`).
//!
//! All methods compute the mean reflected radiosity B − E of each texel. [`methods`] and [`sweeps`] are the
//! tables of what is solved, [`mod@bench`] solves it, [`store`] keeps the measurements between runs of the program,
//! [`points`] finds fronts and orders. [`page`] shows the results, [`peers`] reads measurements of other programs.

pub mod bench;
pub mod methods;
pub mod page;
pub mod peers;
pub mod points;
pub mod store;
pub mod sweeps;
