//! Light at the pixels of a picture.

use common::solution::write::encode as openexr;
use common::{Error, Result};
use glam::Vec3;

/// B and H, W/m².
pub struct Image {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Row by row.
    pub radiosity: Vec<Vec3>,
    /// The same.
    pub irradiance: Vec<Vec3>,
}

impl Image {
    /// Black.
    pub fn dark(size: [u32; 2]) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self {
            size,
            radiosity: vec![Vec3::ZERO; count],
            irradiance: vec![Vec3::ZERO; count],
        }
    }

    /// Sets B and H of a pixel.
    pub fn put(&mut self, [x, y]: [u32; 2], [radiosity, irradiance]: [Vec3; 2]) {
        let at = y as usize * self.size[0] as usize + x as usize;
        self.radiosity[at] = radiosity;
        self.irradiance[at] = irradiance;
    }

    /// As OpenEXR.
    pub fn exr(&self) -> Result<Vec<u8>> {
        let mut planes = Vec::new();
        for (prefix, values) in [("", &self.radiosity), ("irradiance.", &self.irradiance)] {
            for (c, letter) in ["R", "G", "B"].into_iter().enumerate() {
                let plane = values.iter().map(|v| v[c]).collect();
                planes.push((format!("{prefix}{letter}"), plane));
            }
        }
        let size = self.size.map(|n| n as usize);
        openexr(size, planes).map_err(|error| Error::Fault(error.to_string()))
    }
}
