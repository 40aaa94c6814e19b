//! Real panoramas of RADIOSITY_DATA: irradiance, orientation, and conservation of light on the walls of the room.

use common::capture::room::{box_room, capture_point};
use common::capture::{Panorama, texel_radiosity};
use common::solution::pixels::ImagePlanes;
use glam::{DVec2, DVec3, Vec3};
use radiosity_tests::radiance_files::{data_folder, light_at_eye, texel_outlines};
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

fn file_name(path: &Path) -> &str {
    path.file_name().unwrap().to_str().unwrap()
}

/// Reads irradiance_reference.csv: file, mean, and the irradiance in six directions.
fn reference_rows(data: &Path) -> Vec<(PathBuf, DVec3, [DVec3; 6])> {
    let text = fs::read_to_string(data.join("hdr/irradiance_reference.csv")).unwrap();
    let rows = text.lines().skip(1).map(|line| {
        let words: Vec<&str> = line.split(',').collect();
        let colour = |k: usize| DVec3::from([0, 1, 2].map(|c| words[k + c].parse().unwrap()));
        let folder = if words[0].starts_with("Stage") {
            "openexr-images/MultiResolution"
        } else {
            "hdr"
        };
        let irradiance = [0, 1, 2, 3, 4, 5].map(|k| colour(9 + 3 * k));
        (data.join(folder).join(words[0]), colour(6), irradiance)
    });
    rows.collect()
}

/// Reads the pixels as they are in the file.
fn raw_pixels(path: &Path) -> Vec<Vec3> {
    let planes = ImagePlanes::read(path, 1 << 24).unwrap();
    let [r, g, b] = planes.colour_planes("").unwrap();
    (0..r.len()).map(|k| Vec3::new(r[k], g[k], b[k])).collect()
}

/// Up, down, forward, back, right, left.
const SIX: [DVec3; 6] = [DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z, DVec3::NEG_X, DVec3::X];

#[test]
fn real_panoramas_have_reference_irradiance() {
    let Some(data) = data_folder() else { return };
    let scene = box_room(DVec3::new(4.0, 3.0, 5.0)).unwrap();
    let eye = capture_point(DVec3::new(4.0, 3.0, 5.0), None).unwrap();
    let resolutions = [[64, 64]; 6];
    for (path, mean, irradiance) in reference_rows(&data) {
        let map = Panorama::read(&path, None).unwrap();
        // The reference keeps negative radiance.
        let raw = (map.counts.negative > 0).then(|| raw_pixels(&path));
        let light = |weight: &dyn Fn(DVec3) -> f64| -> DVec3 {
            let [w, _] = map.size();
            let pixels = map.lit_pixels().map(|([x, y], radiance, angle)| {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let direction = map.projection().direction_at(map.size(), at);
                let radiance = raw.as_ref().map_or(radiance, |raw| raw[y * w + x]);
                radiance.as_dvec3() * (angle * weight(direction))
            });
            pixels.sum()
        };
        let error = (light(&|_| 0.25 / PI) / mean - 1.0).abs().max_element();
        assert!(error < 1e-5, "{}: {error}", file_name(&path));
        for (normal, truth) in SIX.into_iter().zip(irradiance) {
            let own = light(&|d: DVec3| d.dot(normal).max(0.0));
            let error = (own / truth - 1.0).abs().max_element();
            assert!(error < 1e-4, "{} {normal}: {error}", file_name(&path));
            let cut = (map.irradiance(normal) / own - 1.0).max_element();
            assert!((0.0..0.1).contains(&(cut + 1e-12)), "{} {cut}", file_name(&path));
        }
        let walls = texel_radiosity(&map, &scene, &resolutions, eye).unwrap();
        let found = light_at_eye(&walls, &texel_outlines(&scene, &resolutions, eye), &SIX);
        let error = (found.sphere / (map.mean_radiance() * 4.0 * PI) - 1.0)
            .abs()
            .max_element();
        assert!(error < 1e-5, "{}: {error}", file_name(&path));
        for (normal, irradiance) in SIX.into_iter().zip(found.irradiance) {
            let error = (irradiance - map.irradiance(normal)).abs();
            let within = error.cmple(found.bound).all();
            assert!(within, "{} {normal}: {error} {}", file_name(&path), found.bound);
        }
    }
}
