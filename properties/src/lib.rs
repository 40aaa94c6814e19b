//! Properties of radiosity solutions, to test any solver with `proptest`. [`strategies`] draw scenes; each function
//! `check_…` solves one by a [`SceneSolver`] and returns a [`Violation`] if the property does not hold.
//!
//! | Property | Function | Scenes |
//! |---|---|---|
//! | emitted = absorbed + escaped power | [`check_energy`] | any |
//! | Σ F = 1: E = (1 − ρ)·b gives B = b | [`check_closure`] | closed |
//! | a lamp and a receiver may be swapped | [`check_reciprocity`] | any |
//! | light adds up | [`check_linearity`] | any |
//! | more light darkens nothing | [`check_monotonicity`] | any |
//! | no place, direction, scale or handedness is preferred | [`check_similarity`], [`check_mirror`] | any |
//! | faces and their corners may come in any order, and be split | [`check_face_order`], [`check_corner_order`], [`check_split`] | any |
//!
//! ```
//! use common::{form_factor::polygon_factor, mesh::{Mesh, Patch}, scene::Scene};
//! use glam::Vec3;
//! use properties::{check_closure, strategies::convex_room};
//! use proptest::{prelude::*, test_runner::RngSeed};
//!
//! /// Gathers from all patches until the light is spread evenly; in a convex room all are visible.
//! fn solve(mesh: &Mesh, reflect: fn(Vec3, Vec3) -> Vec3) -> Vec<Vec3> {
//!     let mut b: Vec<Vec3> = mesh.texels.iter().map(|t| t.emission).collect();
//!     for _ in 0..80 {
//!         let mean = |p: &Patch| b[p.texels()].iter().sum::<Vec3>() / p.count as f32;
//!         let sources: Vec<Vec3> = mesh.patches.iter().map(mean).collect();
//!         b = Vec::from_iter(mesh.texels.iter().map(|t| {
//!             let normal = mesh.faces[t.face as usize].normal;
//!             let factors = mesh.patches.iter().map(|p| polygon_factor(&p.shooter, t.position, normal));
//!             let irradiance = factors.zip(&sources).map(|(f, b)| f * *b).sum();
//!             t.emission + reflect(t.reflectance, irradiance)
//!         }));
//!     }
//!     b
//! }
//!
//! # fn main() {
//! let right = |_: &Scene, mesh: &Mesh| solve(mesh, |rho, h| rho * h);
//! let wrong = |_: &Scene, mesh: &Mesh| solve(mesh, |rho, h| rho * rho * h);
//! let config = ProptestConfig { cases: 4, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() };
//! proptest!(config, |(scene in convex_room())| {
//!     check_closure(&right, &scene, 1e-4)?;
//!     let violation = check_closure(&wrong, &scene, 1e-4).unwrap_err();
//!     // closure: texel 0 of face 2 (quad), red: 0.34787583351135254, expected 0.5 within 5e-5
//!     println!("{violation}");
//! });
//! # }
//! ```
//!
//! A tolerance is a share, of what each function says. It must hold the errors of the solver: those of its form factors
//! and its visibility on these texels, and the light that it leaves undistributed in each channel. One that does not
//! vanish on finer texels is a fault. A solution that is too short, not finite, negative or dark is a violation of every
//! property, and so is a scene on which there is nothing to compare.

mod checks;
mod faces;
mod pairing;
mod scene;
mod solution;
pub mod strategies;
mod violation;

pub use checks::{
    check_closure, check_corner_order, check_energy, check_face_order, check_linearity, check_mirror,
    check_monotonicity, check_reciprocity, check_similarity, check_split,
};
pub use faces::{box_faces, named_scene};
pub use pairing::Pairing;
pub use scene::{MeshedScene, order_by_keys};
pub use solution::SceneSolver;
pub use violation::Violation;
