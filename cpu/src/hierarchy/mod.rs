//! Hierarchical radiosity (Hanrahan, Salzman & Aupperle 1991): light travels over links between nodes that are as
//! large as the requested error allows.
//!
//! Data passes the modules in this order: [`tree`] (sources), [`block`] (receivers),
//! [`linear_radiosity`] (radiosity of sources), [`link`] (links), [`refine`] (decisions),
//! [`linker`] and [`cpu_linker`] (all links of a request), [`coarse`] and [`iterate`] (bounces),
//! [`final_gather`] (texels), [`solver`] (the whole solve), [`shot_log`] (the result as a run). [`sky`] gathers
//! light from outside; [`relight`] and [`residual`] solve related problems with the same parts.

pub mod block;
pub mod coarse;
pub mod cpu_linker;
mod defect_correction;
pub mod final_gather;
pub mod iterate;
pub mod level;
pub mod linear_radiosity;
pub mod link;
pub mod linker;
pub mod refine;
pub mod refinement_steps;
pub mod relight;
pub mod residual;
pub mod shot_log;
pub mod sky;
pub mod solver;
pub mod tree;
