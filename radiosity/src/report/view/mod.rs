//! Renders a solved scene from a camera with irradiance interpolated between texels.
//!
//! [`camera`] generates view rays, [`face_grid`] places interpolation nodes on a face, [`weld`] joins the nodes of
//! neighbours that form one surface, [`interpolation`] interpolates light over them, [`render`] shades the hits.

pub mod camera;
pub mod face_grid;
pub mod interpolation;
pub mod render;
pub mod weld;
