//! What many solves show together: speed against accuracy, where methods fail, how errors fall, and
//! the paper's Table 4.

pub mod chart;
pub mod converge;
pub mod random;
pub mod stress;
pub mod table4;
