//! Records of the hierarchical solve: sources with their radiosity, receivers in blocks, and pairs of them.

pub use crate::hierarchy::block::{ReceiverBlock, Spot};
pub use crate::hierarchy::linear_radiosity::LinearRadiosity;
pub use crate::hierarchy::link::{BlockLink, Interaction};
pub use crate::hierarchy::linker::LinkThresholds;
pub use crate::hierarchy::tree::TreeNode;
