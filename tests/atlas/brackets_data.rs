//! A radiance map merged from the photographs of RADIOSITY_DATA.

use approx::abs_diff_eq;
use common::capture::Panorama;
use glam::Vec3;
use radiosity::merge::brackets::{Brackets, CameraResponse, RadianceMap};
use radiosity::merge::photographs::read_photographs;
use radiosity::report::picture::luminance;
use radiosity_tests::radiance_files::data_folder;
use std::path::{Path, PathBuf};

/// Returns percentiles 1…99 of log₂ luminance in the circle, without its outermost hundredth, where the rim of the lens
/// begins and the reference is warped.
fn luminance_percentiles([w, h]: [usize; 2], pixels: &[Vec3]) -> Vec<f64> {
    let from_centre = |k: usize, n: usize| (2 * k + 1) as f64 / n as f64 - 1.0;
    let inside = |k: &usize| from_centre(k % w, w).hypot(from_centre(k / w, h)) < 0.99;
    let luminances = (0..w * h).filter(inside).map(|k| luminance(pixels[k]));
    let lit = luminances.filter(|y| *y > 0.0);
    let mut values: Vec<f64> = lit.map(|y| f64::from(y).log2()).collect();
    values.sort_by(f64::total_cmp);
    (1..100).map(|k| values[k * values.len() / 100]).collect()
}

/// Reads the photographs and their exact exposure times from the table beside them.
fn list_exposures(folder: &Path) -> Vec<(PathBuf, f64)> {
    let table = std::fs::read_to_string(folder.join("exposures.csv")).unwrap();
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
