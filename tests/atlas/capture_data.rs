//! Reading of radiance maps, on the files of RADIOSITY_DATA: every encoding, damaged files.

use approx::abs_diff_eq;
use common::Error;
use common::capture::{MapProjection, Panorama};
use common::solution::pixels::ImagePlanes;
use glam::Vec3;
use radiosity_tests::processor::thread_processor_seconds;
use radiosity_tests::radiance_files::{data_folder, read_pfm};
use std::fs;
use std::path::{Path, PathBuf};

fn sorted_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.is_file()).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn file_name(path: &Path) -> &str {
    path.file_name().unwrap().to_str().unwrap()
}

fn largest_difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (*a - *b).abs().max_element())
        .fold(0.0, f32::max)
}

#[test]
fn radiance_variants_equal_reference_pixels() {
    let Some(data) = data_folder() else { return };
    let folder = data.join("hdr/variants");
    let truth = read_pfm(&folder.join("apartment_256_rgbe_truth.pfm"));
    let others = ["oldrle", "width7"].map(|n| read_pfm(&folder.join(format!("{n}_truth.pfm"))));
    for path in sorted_files(&folder)
        .iter()
        .filter(|path| file_name(path).ends_with(".hdr"))
    {
        let narrow = file_name(path).starts_with("width7");
        let map = Panorama::read(path, narrow.then_some(MapProjection::LatLong)).unwrap();
        let truth = match file_name(path) {
            "oldrle.hdr" => &others[0],
            "width7_flat.hdr" => &others[1],
            _ => &truth,
        };
        assert_eq!(map.size(), truth.0, "{}", file_name(path));
        match file_name(path) {
            "exposure2.hdr" => {
                let scaled: Vec<Vec3> = map.pixels().iter().map(|p| *p * 4.0).collect();
                assert!(scaled == truth.1);
            }
            "xyze.hdr" => {
                for (a, b) in map.pixels().iter().zip(&truth.1) {
                    // X, Y and Z are cut to 1/128 of the largest; the inverse matrix's rows have
                    // sums of up to 5.3, Z/Y of white is 1.09.
                    let bound = 5.3 * 1.1 / 128.0 * b.max_element();
                    assert!((*a - *b).abs().max_element() <= bound, "{a} {b}");
                }
                let bias = map.mean_radiance()
                    / Panorama::from_pixels(truth.0, truth.1.clone(), None)
                        .unwrap()
                        .mean_radiance();
                assert!((bias - 1.0).abs().max_element() < 0.01, "{bias}");
            }
            _ => assert!(
                map.pixels() == truth.1,
                "{}: {}",
                file_name(path),
                largest_difference(map.pixels(), &truth.1)
            ),
        }
    }
}

#[test]
fn openexr_variants_equal_reference_pixels() {
    let Some(data) = data_folder() else { return };
    let half = read_pfm(&data.join("hdr/variants_exr/half_truth.pfm"));
    let float = read_pfm(&data.join("hdr/variants/apartment_256_float_truth.pfm"));
    for path in sorted_files(&data.join("hdr/variants_exr")) {
        let name = file_name(&path).to_owned();
        if name.ends_with(".pfm") {
            continue;
        }
        let map = Panorama::read(&path, None).unwrap();
        let truth = if name.contains("float") { &float } else { &half };
        assert_eq!(map.size(), truth.0, "{name}");
        let error = largest_difference(map.pixels(), &truth.1);
        // From data/README.md, which has them from OpenEXR and OpenImageIO.
        let bound = match () {
            () if name.contains("half_b44") => 0.8125,
            () if name.contains("dwa") => 0.25,
            () => 0.0,
        };
        println!("{name}: {error} {:?}", map.notes);
        if name.starts_with("data_window") {
            for (k, (a, b)) in map.pixels().iter().zip(&truth.1).enumerate() {
                let inside = (16..=143).contains(&(k % 256)) && (8..=71).contains(&(k / 256));
                assert_eq!(*a, if inside { *b } else { Vec3::ZERO }, "{k}");
            }
        } else if name.starts_with("luminance") {
            for (a, b) in map.pixels().iter().zip(&truth.1) {
                let y = b.dot(Vec3::new(0.2126, 0.7152, 0.0722));
                assert!(
                    abs_diff_eq!(a.x, y, epsilon = 1e-3 * y) && a.x == a.y && a.y == a.z,
                    "{a} {y}"
                );
            }
        } else {
            assert!(error <= bound, "{name}: {error}");
        }
    }
}

#[test]
fn bad_radiance_pictures_are_refused_or_noted() {
    let Some(data) = data_folder() else { return };
    for path in sorted_files(&data.join("hdr/bad")) {
        let start = thread_processor_seconds();
        let result = Panorama::read(&path, None);
        let work = thread_processor_seconds() - start;
        assert!(work < 1.0, "{}: {work} s of work", file_name(&path));
        match (file_name(&path), result) {
            ("no_format_line.hdr" | "trailing_bytes.hdr", Ok(map)) => {
                assert_eq!(map.notes.len(), 1, "{:?}", map.notes);
            }
            (name, Err(error @ Error::Input { .. })) => {
                assert!(error.to_string().contains(name) && !error.to_string().contains('\n'));
                assert!(!matches!(name, "no_format_line.hdr" | "trailing_bytes.hdr"));
            }
            (name, other) => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn damaged_openexr_files_are_read_or_refused() {
    let Some(data) = data_folder() else { return };
    for path in sorted_files(&data.join("openexr-images/Damaged")) {
        let start = thread_processor_seconds();
        match Panorama::read(&path, Some(MapProjection::LatLong)) {
            Ok(_) => {}
            Err(error @ Error::Input { .. }) => {
                let text = error.to_string();
                assert!(text.contains(file_name(&path)) && !text.contains('\n'), "{text}");
            }
            Err(error) => panic!("{error}"),
        }
        // The reader of lightmaps must survive the same files.
        let _ = ImagePlanes::read(&path, 1 << 20);
        let seconds = thread_processor_seconds() - start;
        assert!(seconds < 10.0, "{}: {seconds} s of work", file_name(&path));
    }
}

#[test]
fn nan_infinite_and_negative_pixels_are_counted() {
    let Some(data) = data_folder() else { return };
    let images = data.join("openexr-images/TestImages");
    let any = Some(MapProjection::LatLong);
    let rings = Panorama::read(&images.join("BrightRingsNanInf.exr"), any).unwrap();
    // 18 values in 12 pixels.
    let planes = ImagePlanes::read(&images.join("BrightRingsNanInf.exr"), 1 << 24).unwrap();
    let values = planes.colour_planes("").unwrap().concat();
    assert_eq!(values.iter().filter(|v| !v.is_finite()).count(), 18);
    assert_eq!(rings.counts.nan + rings.counts.infinite, 12);
    let intact = Panorama::read(&images.join("BrightRings.exr"), any).unwrap();
    assert_eq!((intact.counts.nan, intact.counts.infinite), (0, 0));
    // Every half there is: 2 × 1023 mantissas of NaN and the two infinities, each in all channels.
    let halves = Panorama::read(&images.join("AllHalfValues.exr"), any).unwrap();
    assert_eq!((halves.counts.nan, halves.counts.infinite), (2046, 2));
    let interior = Panorama::read(&data.join("hdr/interior_1k_dwab.exr"), None).unwrap();
    assert_eq!(interior.counts.negative, 5053);
    assert!(interior.pixels().iter().all(|p| p.min_element() >= 0.0));
    let lobby = Panorama::read(&data.join("hdr/lobby_npm_512_dwab.exr"), None).unwrap();
    assert_eq!(lobby.counts.negative, 739);
}
