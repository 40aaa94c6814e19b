//! Readers of radiance maps: Radiance pictures, OpenEXR.

use crate::allow_caught_panics;
use crate::folder::Folder;
use crate::requirements::require_one_line;
use common::capture::{MapProjection, Panorama};
use common::solution::pixels::ImagePlanes;
use glam::DVec3;
use std::f32::consts::PI;
use std::path::Path;

/// Largest number of pixels of which every solid angle is summed.
const MAX_SUMMED_PIXELS: usize = 1 << 12;
/// Largest number of pixels of an image that is read as planes.
const MAX_PLANE_PIXELS: u64 = 1 << 16;

thread_local! {
    static FOLDER: Folder = Folder::new(&[]);
}

/// Checks the reader of Radiance pictures.
pub fn check_hdr(data: &[u8]) {
    require_sound_panorama(data, Some(MapProjection::LatLong));
}

/// Checks the readers of OpenEXR files: as planes, and as a panorama.
pub fn check_openexr(data: &[u8]) {
    allow_caught_panics();
    match ImagePlanes::decode(Path::new("a.exr"), data, MAX_PLANE_PIXELS) {
        Ok(planes) => {
            let pixels = planes.width * planes.height;
            assert!(pixels as u64 <= MAX_PLANE_PIXELS);
            assert!(planes.channels.values().all(|values| values.len() == pixels));
        }
        Err(error) => require_one_line(&error),
    }
    require_sound_panorama(data, None);
}

fn require_sound_panorama(data: &[u8], projection: Option<MapProjection>) {
    FOLDER.with(|folder| {
        folder.write("a.map", data);
        let panorama = match Panorama::read(&folder.path("a.map"), projection) {
            Ok(panorama) => panorama,
            Err(error) => return require_one_line(&error),
        };
        let [width, height] = panorama.size();
        assert_eq!(panorama.pixels().len(), width * height);
        for pixel in panorama.pixels() {
            assert!(pixel.min_element() >= 0.0 && (*pixel * PI).is_finite(), "{pixel}");
        }
        for direction in [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(-0.3, 0.8, -0.1)] {
            let radiance = panorama.radiance(direction);
            assert!(
                radiance.min_element() >= 0.0 && radiance.is_finite(),
                "{radiance} at {direction}"
            );
        }
        if projection.is_some() && width * height <= MAX_SUMMED_PIXELS {
            let whole: f64 = panorama.captured_pixels().map(|(_, _, solid_angle)| solid_angle).sum();
            assert!((whole / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-9, "{whole} sr");
        }
        for note in &panorama.notes {
            require_one_line(note);
        }
    });
}
