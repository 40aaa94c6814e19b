//! Lightmap picture: radiosity and irradiance per pixel.

use common::Result;
use common::solution::write::encode_exr as openexr;
use glam::Vec3;

/// Radiosity B and irradiance H per pixel, W/m².
pub struct LightmapImage {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Radiosity, row-major from the upper left.
    pub radiosity: Vec<Vec3>,
    /// Irradiance, row-major from the upper left.
    pub irradiance: Vec<Vec3>,
}

impl LightmapImage {
    /// Creates a black picture.
    pub fn new_black(size: [u32; 2]) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self {
            size,
            radiosity: vec![Vec3::ZERO; count],
            irradiance: vec![Vec3::ZERO; count],
        }
    }

    /// Sets radiosity and irradiance of a pixel.
    pub fn set_pixel(&mut self, [x, y]: [u32; 2], [radiosity, irradiance]: [Vec3; 2]) {
        let at = y as usize * self.size[0] as usize + x as usize;
        self.radiosity[at] = radiosity;
        self.irradiance[at] = irradiance;
    }

    /// Encodes OpenEXR with channels R, G, B and `irradiance.*`.
    ///
    /// Errors: [`Error::Fault`] of the encoder.
    pub fn encode_exr(&self) -> Result<Vec<u8>> {
        let mut planes = Vec::new();
        for (prefix, values) in [("", &self.radiosity), ("irradiance.", &self.irradiance)] {
            for (c, letter) in ["R", "G", "B"].into_iter().enumerate() {
                let plane = values.iter().map(|v| v[c]).collect();
                planes.push((format!("{prefix}{letter}"), plane));
            }
        }
        openexr(self.size, planes)
    }
}
