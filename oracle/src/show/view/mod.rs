//! The solved scene seen from a camera, without seams between texels.
//!
//! [`camera`] shoots view rays, [`patch`] says where the nodes of a face's texels lie, [`weld`]
//! joins the nodes of coplanar neighbours, [`surface`] interpolates irradiance over them,
//! [`quality`] measures what the interpolation costs, [`render`] shades the hits.

pub mod camera;
pub mod patch;
pub mod quality;
pub mod render;
pub mod surface;
pub mod weld;
