//! Captured maps against the files of RADIOSITY_DATA: real rooms, every encoding, broken files.

use common::capture::room::{eye, room};
use common::capture::{Panorama, Projection, texel_radiosity};
use common::solution::pixels::Planes;
use common::{Error, texel};
use glam::{DVec2, DVec3, Vec3};
use radiosity_tests::captured::{data, pfm};
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.is_file()).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn name(path: &Path) -> &str {
    path.file_name().unwrap().to_str().unwrap()
}

fn worst(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (*a - *b).abs().max_element())
        .fold(0.0, f32::max)
}

#[test]
fn every_variant_of_a_radiance_picture_is_its_truth() {
    let Some(data) = data() else { return };
    let folder = data.join("hdr/variants");
    let truth = pfm(&folder.join("apartment_256_rgbe_truth.pfm"));
    let others = ["oldrle", "width7"].map(|n| pfm(&folder.join(format!("{n}_truth.pfm"))));
    for path in files(&folder)
        .iter()
        .filter(|path| name(path).ends_with(".hdr"))
    {
        let narrow = name(path).starts_with("width7");
        let map = Panorama::read(path, narrow.then_some(Projection::LatLong)).unwrap();
        let truth = match name(path) {
            "oldrle.hdr" => &others[0],
            "width7_flat.hdr" => &others[1],
            _ => &truth,
        };
        assert_eq!(map.size(), truth.0, "{}", name(path));
        match name(path) {
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
                let bias = map.mean()
                    / Panorama::from_pixels(truth.0, truth.1.clone(), None)
                        .unwrap()
                        .mean();
                assert!((bias - 1.0).abs().max_element() < 0.01, "{bias}");
            }
            _ => assert!(
                map.pixels() == truth.1,
                "{}: {}",
                name(path),
                worst(map.pixels(), &truth.1)
            ),
        }
    }
}

#[test]
fn every_variant_of_an_openexr_file_is_its_truth() {
    let Some(data) = data() else { return };
    let half = pfm(&data.join("hdr/variants_exr/half_truth.pfm"));
    let float = pfm(&data.join("hdr/variants/apartment_256_float_truth.pfm"));
    for path in files(&data.join("hdr/variants_exr")) {
        let name = name(&path).to_owned();
        if name.ends_with(".pfm") {
            continue;
        }
        let map = Panorama::read(&path, None).unwrap();
        let truth = if name.contains("float") {
            &float
        } else {
            &half
        };
        assert_eq!(map.size(), truth.0, "{name}");
        let error = worst(map.pixels(), &truth.1);
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
                    (a.x - y).abs() <= 1e-3 * y && a.x == a.y && a.y == a.z,
                    "{a} {y}"
                );
            }
        } else {
            assert!(error <= bound, "{name}: {error}");
        }
    }
}

#[test]
fn every_bad_radiance_picture_is_refused_or_noted() {
    let Some(data) = data() else { return };
    for path in files(&data.join("hdr/bad")) {
        let start = Instant::now();
        let result = Panorama::read(&path, None);
        assert!(start.elapsed().as_secs_f64() < 1.0, "{}", name(&path));
        match (name(&path), result) {
            ("no_format_line.hdr" | "trailing_bytes.hdr", Ok(map)) => {
                assert_eq!(map.notes.len(), 1, "{:?}", map.notes);
            }
            (name, Err(error @ Error::Input { .. })) => {
                println!("{error}");
                assert!(error.to_string().contains(name) && !error.to_string().contains('\n'));
                assert!(!matches!(name, "no_format_line.hdr" | "trailing_bytes.hdr"));
            }
            (name, other) => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn no_damaged_openexr_file_does_harm() {
    let Some(data) = data() else { return };
    let (mut read, mut slowest) = (0, 0.0);
    let files = files(&data.join("openexr-images/Damaged"));
    for path in &files {
        let start = Instant::now();
        match Panorama::read(path, Some(Projection::LatLong)) {
            Ok(_) => read += 1,
            Err(error @ Error::Input { .. }) => {
                let text = error.to_string();
                assert!(text.contains(name(path)) && !text.contains('\n'), "{text}");
            }
            Err(error) => panic!("{error}"),
        }
        // The reader of lightmaps meets the same files.
        let _ = Planes::read(path, 1 << 20);
        let seconds = start.elapsed().as_secs_f64();
        assert!(seconds < 10.0, "{}: {seconds} s", name(path));
        slowest = f64::max(slowest, seconds);
    }
    println!(
        "{} damaged files, {read} of them read, the slowest in {slowest:.2} s",
        files.len()
    );
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    println!(
        "{}",
        status
            .lines()
            .find(|l| l.starts_with("VmHWM"))
            .unwrap_or("memory unknown")
    );
}

#[test]
fn counted_is_what_no_radiance_can_be() {
    let Some(data) = data() else { return };
    let images = data.join("openexr-images/TestImages");
    let any = Some(Projection::LatLong);
    let rings = Panorama::read(&images.join("BrightRingsNanInf.exr"), any).unwrap();
    // 18 values in 12 pixels.
    let planes = Planes::read(&images.join("BrightRingsNanInf.exr"), 1 << 24).unwrap();
    let values = planes.colours("").unwrap().concat();
    assert_eq!(values.iter().filter(|v| !v.is_finite()).count(), 18);
    assert_eq!(rings.counts.nan + rings.counts.infinite, 12);
    let intact = Panorama::read(&images.join("BrightRings.exr"), any).unwrap();
    assert_eq!((intact.counts.nan, intact.counts.infinite), (0, 0));
    // Every half there is: 2 × 1023 mantissas of NaN and the two infinities, each in all channels.
    let halves = Panorama::read(&images.join("AllHalfValues.exr"), any).unwrap();
    println!("{:?}", halves.counts);
    assert_eq!((halves.counts.nan, halves.counts.infinite), (2046, 2));
    let interior = Panorama::read(&data.join("hdr/interior_1k_dwab.exr"), None).unwrap();
    assert_eq!(interior.counts.negative, 5053);
    assert!(interior.pixels().iter().all(|p| p.min_element() >= 0.0));
    let lobby = Panorama::read(&data.join("hdr/lobby_npm_512_dwab.exr"), None).unwrap();
    assert_eq!(lobby.counts.negative, 739);
}

/// Rows of irradiance_reference.csv: file, mean, and the irradiance of six directions.
fn references(data: &Path) -> Vec<(PathBuf, DVec3, [DVec3; 6])> {
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

/// The pixels as they are in the file.
fn raw(path: &Path) -> Vec<Vec3> {
    let planes = Planes::read(path, 1 << 24).unwrap();
    let [r, g, b] = planes.colours("").unwrap();
    (0..r.len()).map(|k| Vec3::new(r[k], g[k], b[k])).collect()
}

/// Up, down, forward, back, right, left.
const SIX: [DVec3; 6] = [
    DVec3::Y,
    DVec3::NEG_Y,
    DVec3::Z,
    DVec3::NEG_Z,
    DVec3::NEG_X,
    DVec3::X,
];

#[test]
fn real_rooms_have_the_light_of_the_reference() {
    let Some(data) = data() else { return };
    let scene = room(DVec3::new(4.0, 3.0, 5.0)).unwrap();
    let eye = eye(DVec3::new(4.0, 3.0, 5.0), None).unwrap();
    let resolutions = [[64, 64]; 6];
    for (path, mean, irradiance) in references(&data) {
        let map = Panorama::read(&path, None).unwrap();
        // The reference does not cut negative radiance off.
        let raw = (map.counts.negative > 0).then(|| raw(&path));
        let light = |weight: &dyn Fn(DVec3) -> f64| -> DVec3 {
            let [w, _] = map.size();
            let pixels = map.lit().map(|([x, y], radiance, angle)| {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let direction = map.projection().direction(map.size(), at);
                let radiance = raw.as_ref().map_or(radiance, |raw| raw[y * w + x]);
                radiance.as_dvec3() * (angle * weight(direction))
            });
            pixels.sum()
        };
        let error = (light(&|_| 0.25 / PI) / mean - 1.0).abs().max_element();
        assert!(error < 1e-5, "{}: {error}", name(&path));
        for (normal, truth) in SIX.into_iter().zip(irradiance) {
            let own = light(&|d: DVec3| d.dot(normal).max(0.0));
            let error = (own / truth - 1.0).abs().max_element();
            assert!(error < 1e-4, "{} {normal}: {error}", name(&path));
            let cut = (map.irradiance(normal) / own - 1.0).max_element();
            assert!((0.0..0.1).contains(&(cut + 1e-12)), "{} {cut}", name(&path));
        }
        let start = Instant::now();
        let walls = texel_radiosity(&map, &scene, &resolutions, eye).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        let (mut whole, mut received) = (DVec3::ZERO, [DVec3::ZERO; 6]);
        let mut square = DVec3::ZERO;
        let mut rest = walls.iter();
        for (face, resolution) in scene.faces.iter().zip(resolutions) {
            for k in 0..texel::count(resolution) {
                let [a, b, c, d] = texel::outline(face, resolution, k)
                    .padded()
                    .map(|p| (p - eye).normalize());
                let angle = triangle(a, b, c) + triangle(a, c, d);
                let flux = rest.next().unwrap().as_dvec3() / PI * angle;
                whole += flux;
                let middle = (a + b + c + d).normalize();
                for (sum, normal) in received.iter_mut().zip(SIX) {
                    *sum += flux * middle.dot(normal).max(0.0);
                }
                square += (flux * 2.0 * (a - middle).length()).powf(2.0);
            }
        }
        let error = (whole / (map.mean() * 4.0 * PI) - 1.0).abs().max_element();
        println!("{}: {seconds:.2} s, sphere {error:.1e}", name(&path));
        assert!(error < 1e-5, "{}: {error}", name(&path));
        for (received, normal) in received.into_iter().zip(SIX) {
            // Each texel's cosθ is off by its half width at most; errors of texels are independent.
            let error = (received - map.irradiance(normal)).abs();
            let bound = square.map(f64::sqrt);
            println!(
                "    {:.5} of {:.5}",
                (error / received).max_element(),
                (bound / received).max_element()
            );
            assert!(
                error.cmple(bound).all(),
                "{} {normal}: {error} {bound}",
                name(&path)
            );
        }
    }
}

/// Solid angle of a triangle with corners of length 1.
fn triangle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let volume = a.dot(b.cross(c)).abs();
    2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

#[test]
fn labels_point_the_same_way_in_openexrs_two_projections() {
    let Some(data) = data() else { return };
    let folder = data.join("openexr-images/MultiResolution");
    let compare = |lat_long: &str, cube: &str, turn: fn(DVec3) -> DVec3| -> f64 {
        let a = Panorama::read(&folder.join(lat_long), None).unwrap();
        let b = Panorama::read(&folder.join(cube), None).unwrap();
        assert_eq!(
            (a.projection(), b.projection()),
            (Projection::LatLong, Projection::Cube)
        );
        let (mut sum, mut scale) = (0.0, 0.0);
        let golden = PI * (3.0 - 5_f64.sqrt());
        for k in 0..50_000 {
            let y = 1.0 - (2.0 * f64::from(k) + 1.0) / 50_000.0;
            let (sin, cos) = (golden * f64::from(k)).sin_cos();
            let d = DVec3::new(sin * (1.0 - y * y).sqrt(), y, cos * (1.0 - y * y).sqrt());
            // Film lights would decide alone.
            let (a, b) = (
                a.radiance(d).min(Vec3::ONE),
                b.radiance(turn(d)).min(Vec3::ONE),
            );
            sum += f64::from((a - b).abs().element_sum());
            scale += f64::from(a.element_sum());
        }
        sum / scale
    };
    for (lat_long, cube) in [
        ("OrientationLatLong.exr", "OrientationCube.exr"),
        ("StageEnvLatLong.exr", "StageEnvCube.exr"),
    ] {
        let same = compare(lat_long, cube, |d| d);
        let turned = compare(lat_long, cube, |d| DVec3::new(d.z, d.y, -d.x));
        let mirrored = compare(lat_long, cube, |d| DVec3::new(-d.x, d.y, d.z));
        let tilted = compare(lat_long, cube, |d| DVec3::new(d.x, d.z, -d.y));
        println!(
            "{lat_long}: {same:.4}; turned {turned:.4}, mirrored {mirrored:.4}, tilted {tilted:.4}"
        );
        for wrong in [turned, mirrored, tilted] {
            assert!(same < 0.5 * wrong, "{lat_long}: {same}, {wrong}");
        }
    }
}

#[test]
fn the_angular_lobby_is_the_lobby() {
    let Some(data) = data() else { return };
    let angular = Panorama::read(&data.join("hdr/lobby_angular_512.hdr"), None).unwrap();
    assert_eq!(angular.projection(), Projection::Angular);
    let lobby = Panorama::read(&data.join("hdr/lobby_1k.hdr"), None).unwrap();
    let error = (angular.mean() / lobby.mean() - 1.0).abs().max_element();
    println!("mean {error}");
    assert!(error < 6e-3, "{error}");
    for normal in SIX {
        let error = (angular.irradiance(normal) / lobby.irradiance(normal) - 1.0).abs();
        println!("{normal}: {error}");
        assert!(error.max_element() < 2e-2, "{normal} {error}");
    }
}
