//! Reading of radiance maps, on the files of RADIOSITY_DATA: every encoding.

use approx::abs_diff_eq;
use common::capture::{MapProjection, Panorama};
use glam::Vec3;
use radiosity_tests::radiance_files::data_folder;
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

/// Reads a little-endian PFM: width and height, and the pixels row by row from the upper left.
fn read_pfm(path: &Path) -> ([usize; 2], Vec<Vec3>) {
    let bytes = fs::read(path).unwrap();
    let mut at = 0;
    let mut line = || {
        let end = at + bytes[at..].iter().position(|b| *b == b'\n').unwrap();
        let line = String::from_utf8(bytes[at..end].to_vec()).unwrap();
        at = end + 1;
        line
    };
    assert_eq!(line(), "PF");
    let size: Vec<usize> = line().split(' ').map(|n| n.parse().unwrap()).collect();
    assert!(line().starts_with('-'), "little-endian");
    let value = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let pixel = |b: &[u8]| Vec3::new(value(b), value(&b[4..]), value(&b[8..]));
    let rows = bytes[at..].chunks_exact(12 * size[0]).rev();
    let pixels: Vec<Vec3> = rows.flat_map(|row| row.chunks_exact(12)).map(pixel).collect();
    assert_eq!(pixels.len(), size[0] * size[1]);
    ([size[0], size[1]], pixels)
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
