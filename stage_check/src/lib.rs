//! Checks WGSL compute shaders against plain Rust, in `cargo test`. A [`Stage`] is an entry point of any WGSL file; a
//! [`Case`] fills its buffers by their names and holds what Rust makes of them. The stage runs at the sizes at which
//! shaders fail, and each value is held to the reference under a [`Bound`] of counted roundings.
//!
//! ```
//! use stage_check::{Bound, Case, Failure, Gpu, Stage, values};
//!
//! const WGSL: &str = "
//! @group(0) @binding(0) var<storage, read> x: array<f32>;
//! @group(0) @binding(1) var<storage, read_write> root: array<f32>;
//! @compute @workgroup_size(64)
//! fn square_root(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
//!                @builtin(local_invocation_index) lane: u32) {
//!     let k = (group.y * groups.x + group.x) * 64u + lane;
//!     if k < arrayLength(&x) { root[k] = sqrt(x[k]); }
//! }";
//!
//! fn main() -> Result<(), Failure> {
//!     let stage = Stage::new(&Gpu::open(None)?, "root.wgsl", WGSL, "square_root")?;
//!     let report = stage.check(|size| {
//!         let x = values::random_f32(1, size, 0.0..9.0);
//!         let root: Vec<f32> = x.iter().map(|x| x.sqrt()).collect();
//!         // WGSL allows a root 1/(1/√x): two of 2.5 and 2 ulp.
//!         Case::new().input("x", &x).output("root", &root, Bound::Ulps(5.0))
//!     })?;
//!     println!("{report}");
//!     Ok(())
//! }
//! ```
//!
//! With `< arrayLength(&x) - 1u` the test ends with an error, which `Debug` prints as `Display` does:
//!
//! ```text
//! root.wgsl: square_root, size 1: `root` differs in 1 of 1 values: all of them, none of them written
//!   first: root[0] = not written, the reference is 2.7026856
//!   inputs of the first: x[0] = 7.304509
//!   at size 321: `root` differs in 1 of 321 values: only element 320, none of them written
//! ```
//!
//! A case compares in the order of the bindings. Integers must be equal, unless the bound is [`Bound::Absolute`]. A
//! device adds sums in any order that the shader allows: count the roundings, or give the size of the terms with
//! [`Bound::UlpsOf`].
//!
//! A test is worth the mistakes that it finds: [`mutants`] lists small ones of any WGSL, to plant.
//!
//! A barrier that is missing often changes no value: a software adapter runs the lanes of a workgroup in an order of its
//! own. So a shader with workgroup memory runs first as a text that watches its accesses ([`races`]), and two
//! lanes that use an element without a barrier between, one of them to write, are an error.
//!
//! A loop that takes more than [`loops::max_loop_turns`] is an error as well: that text counts them. A run that does not
//! end is given up ([`Stage::with_time_limit`]); a device that cannot be opened is an error. Hardware goes on running it: the
//! driver may end other programs' work on it, and this process by a signal when it exits. A software adapter hides races
//! between workgroups: test on hardware as well.
//!
//! WebAssembly has neither the devices nor the checks of stages: a page may not wait.

pub mod adapters;
#[cfg(not(target_arch = "wasm32"))]
mod case;
#[cfg(not(target_arch = "wasm32"))]
mod compare;
#[cfg(not(target_arch = "wasm32"))]
mod device;
mod edits;
#[cfg(not(target_arch = "wasm32"))]
mod entry_point;
#[cfg(not(target_arch = "wasm32"))]
mod failure;
pub mod loops;
pub mod mutants;
pub mod races;
#[cfg(not(target_arch = "wasm32"))]
mod stage;
pub mod tally;
mod tokens;
pub mod values;
pub mod watch;
pub mod wgsl;

#[cfg(not(target_arch = "wasm32"))]
pub use case::{Bound, Case};
#[cfg(not(target_arch = "wasm32"))]
pub use device::Gpu;
#[cfg(not(target_arch = "wasm32"))]
pub use failure::{Difference, Failure, Fault};
#[cfg(not(target_arch = "wasm32"))]
pub use stage::{Report, Stage};
