//! Code that all solvers share: scenes, texels, form factors and the shooting loop.
//!
//! Data flow in one direction: [`import`] → [`scene`] → [`mesh`] (with [`texel`]) → [`shooting`] or
//! [`passes`] (with [`form_factor`], [`constants`], [`escape`], [`reduce`], [`settings`]) → [`energy`] →
//! [`solution`]. [`capture`] makes a scene with radiosity from a photographed room.
//!
//! ```
//! use common::mesh::Mesh;
//! use common::scene::{Face, Scene};
//! use glam::{DVec3, Vec3};
//!
//! # fn main() -> common::Result<()> {
//! let square = [DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y];
//! let scene = Scene {
//!     faces: vec![Face::quad("lamp", square, Vec3::ONE, Vec3::splat(0.5))],
//!     ..Scene::default()
//! };
//! let mesh = Mesh::uniform(&scene, 8, 2)?;
//! assert_eq!((mesh.texels.len(), mesh.patches.len()), (64, 4));
//! let area: f32 = mesh.texels.iter().map(|texel| texel.area).sum();
//! assert!((f64::from(area) * mesh.area_unit() - 1.0).abs() < 1e-6);
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod bvh;
pub mod capture;
pub mod constants;
pub mod cover;
pub mod dispatch;
pub mod energy;
pub mod error;
pub mod escape;
mod face;
pub mod file;
pub mod form_factor;
pub mod import;
pub mod intersect;
pub mod jpeg;
pub mod mesh;
pub mod overlap;
pub mod paint;
pub mod passes;
pub mod polygon;
pub mod precision;
pub mod rays;
pub mod reduce;
pub mod relight;
pub mod resample;
pub mod sampling;
pub mod scene;
pub mod settings;
mod sheets;
pub mod shooting;
pub mod sky;
pub mod solution;
pub mod texel;
pub mod texel_point;
pub mod text;

pub use error::{Error, Result};
