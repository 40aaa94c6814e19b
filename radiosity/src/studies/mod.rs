//! Studies over many solves: speed against accuracy and error against an option ([`chart`]), the failure
//! atlas ([`stress`]), random scenes ([`random`]), mutants of the shaders ([`sabotage`]), the paper's Table 4
//! ([`table4`]) and a check of an adapter ([`hardware`]). A page in a browser has the cases of the atlas alone.

#[cfg(not(target_arch = "wasm32"))]
pub mod chart;
#[cfg(not(target_arch = "wasm32"))]
pub mod hardware;
#[cfg(not(target_arch = "wasm32"))]
pub mod hashes;
#[cfg(not(target_arch = "wasm32"))]
mod limited;
#[cfg(not(target_arch = "wasm32"))]
pub mod random;
#[cfg(not(target_arch = "wasm32"))]
pub mod sabotage;
pub mod stress;
#[cfg(not(target_arch = "wasm32"))]
pub mod table4;
