//! What many solves show: speed against accuracy, where methods fail, how errors fall, the paper's
//! own table.

pub mod chart;
pub mod converge;
pub mod random;
pub mod stress;
pub mod table4;
