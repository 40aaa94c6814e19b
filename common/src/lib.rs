//! Scene, texels, form factors and the shooting loop: what every solver shares.
//!
//! Data flows one way: [`import`] → [`scene`] → [`mesh`] (with [`texel`]) → [`shooting`] (with
//! [`form_factor`], [`constants`], [`escape`], [`reduce`], [`settings`]) → [`energy`] → [`solution`].
//! [`capture`] makes a scene with radiosity from a photographed room.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod bvh;
pub mod capture;
pub mod constants;
pub mod cover;
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
pub mod passes;
pub mod precision;
pub mod rays;
pub mod reduce;
pub mod relight;
pub mod sampling;
pub mod scene;
pub mod settings;
pub mod shooting;
pub mod solution;
pub mod texel;
pub mod text;

pub use error::{Error, Result};
