//! The live page's program: opens a scene, changes it, solves it shot by shot and renders the record. A browser runs it as
//! WebAssembly, in a worker; the same functions run natively in tests.

pub mod browser_gpu;
pub mod case;
pub mod change;
pub mod description;
pub mod fault;
pub mod gpu_comparison;
pub mod gpu_stages;
pub mod request;
pub mod slice;
pub mod solve;

#[cfg(target_arch = "wasm32")]
mod bindings;
