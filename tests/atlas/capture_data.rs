//! The files of RADIOSITY_DATA: a radiance map merged from photographs; irradiance and orientation of real panoramas, and
//! conservation of light on the walls of their room.

use approx::abs_diff_eq;
use common::capture::room::{box_room, capture_point};
use common::capture::{Panorama, texel_radiosity};
use common::solution::pixels::ImagePlanes;
use glam::{DVec2, DVec3, Vec3};
use radiosity::merge::brackets::{Brackets, CameraResponse, RadianceMap};
use radiosity::merge::photographs::read_photographs;
use radiosity::report::picture::compute_luminance;
use radiosity_tests::radiance_files::{data_folder, irradiance_at_eye, light_at_eye, mean_radiance, texel_outlines};
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns percentiles 1…99 of log₂ luminance in the circle, without its outermost hundredth, where the rim of the lens
/// begins and the reference is warped.
fn luminance_percentiles([w, h]: [usize; 2], pixels: &[Vec3]) -> Vec<f64> {
    let from_centre = |k: usize, n: usize| (2 * k + 1) as f64 / n as f64 - 1.0;
    let inside = |k: &usize| from_centre(k % w, w).hypot(from_centre(k / w, h)) < 0.99;
    let luminances = (0..w * h).filter(inside).map(|k| compute_luminance(pixels[k]));
    let lit = luminances.filter(|y| *y > 0.0);
    let mut values: Vec<f64> = lit.map(|y| f64::from(y).log2()).collect();
    values.sort_by(f64::total_cmp);
    (1..100).map(|k| values[k * values.len() / 100]).collect()
}

/// Reads the photographs and their exact exposure times from the table beside them.
fn list_exposures(folder: &Path) -> Vec<(PathBuf, f64)> {
    let table = fs::read_to_string(folder.join("exposures.csv")).unwrap();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        (folder.join(fields[0]), fields[3].parse().unwrap())
    };
    table.lines().skip(1).map(row).collect()
}

#[test]
fn real_bracket_agrees_with_calibrated_map() {
    let Some(data) = data_folder() else { return };
    let folder = data.join("brackets");
    let (paths, seconds): (Vec<_>, Vec<f64>) = list_exposures(&folder.join("office")).into_iter().unzip();
    let brackets = Brackets::new(read_photographs(&paths, &seconds).unwrap()).unwrap();
    let response = CameraResponse::from_brackets(&brackets).unwrap();
    for c in 0..3 {
        assert_eq!(response.count_falls(c), 0, "channel {c}");
    }
    let steps = brackets.exposure_steps(&response);
    assert_eq!(steps.len(), 17);
    for (k, step) in steps.iter().enumerate() {
        let seen = step.measured.unwrap();
        println!("step {k}: said {:.3}, seen {seen:.3}", step.nominal);
        // The shutter is not exact; the last picture is nearly black.
        let expected = if k < 16 { 0.93..1.04 } else { 0.5..0.67 };
        assert!(expected.contains(&seen), "{k}: {seen}");
    }
    let merged = RadianceMap::new(&brackets, &response);
    let ours = luminance_percentiles(merged.size, &merged.radiance);
    let reference = Panorama::read(&folder.join("office_reference_fisheye_1000.hdr"), None);
    let reference = reference.unwrap();
    let theirs = luminance_percentiles(reference.size(), reference.pixels());
    let difference: Vec<f64> = ours.iter().zip(&theirs).map(|(a, b)| a - b).collect();
    let (low, high) = (
        difference.iter().copied().fold(f64::INFINITY, f64::min),
        difference.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    );
    let apart = 0.5 * (high - low);
    let ranges = [&ours, &theirs].map(|p| p[98] - p[0]);
    println!("within {apart:.3} stops after one factor; ranges {ranges:.2?} stops");
    assert!(apart < 0.3, "{difference:.2?}");
    assert!(abs_diff_eq!(ranges[0], 11.3, epsilon = 0.5), "{ranges:?}");
}

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
            let pixels = map.captured_pixels().map(|([x, y], radiance, angle)| {
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
            let cut = (irradiance_at_eye(&map, normal) / own - 1.0).max_element();
            assert!((0.0..0.1).contains(&(cut + 1e-12)), "{} {cut}", file_name(&path));
        }
        let walls = texel_radiosity(&map, &scene, &resolutions, eye).unwrap();
        let found = light_at_eye(&walls, &texel_outlines(&scene, &resolutions, eye), &SIX);
        let error = (found.sphere / (mean_radiance(&map) * 4.0 * PI) - 1.0)
            .abs()
            .max_element();
        assert!(error < 1e-5, "{}: {error}", file_name(&path));
        for (normal, irradiance) in SIX.into_iter().zip(found.irradiance) {
            let error = (irradiance - irradiance_at_eye(&map, normal)).abs();
            let within = error.cmple(found.bound).all();
            assert!(within, "{} {normal}: {error} {}", file_name(&path), found.bound);
        }
    }
}
