//! Small radiance maps and their files, for tests of captured rooms.

use common::Error;
use common::capture::{MapProjection, Panorama};
use common::scene::Scene;
use common::texel;
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::PI;
use std::fs;
use std::io::Write;
use std::path::PathBuf;

/// Returns the folder RADIOSITY_DATA; without it prints that the test is skipped.
pub fn data_folder() -> Option<PathBuf> {
    let folder = std::env::var_os("RADIOSITY_DATA").map(PathBuf::from);
    if folder.is_none() {
        // Written to stderr directly: the test runner hides the output of passing tests.
        let thread = std::thread::current();
        let test = thread.name().unwrap_or("a test");
        let _ = writeln!(std::io::stderr(), "skipped {test}: RADIOSITY_DATA is not set");
    }
    folder
}

/// Returns a map's mean radiance over all directions, W/m²/sr.
pub fn mean_radiance(map: &Panorama) -> DVec3 {
    let sum = |(sum, whole): (DVec3, f64), (_, radiance, angle): (_, Vec3, f64)| {
        (sum + radiance.as_dvec3() * angle, whole + angle)
    };
    let (sum, whole) = map.captured_pixels().fold((DVec3::ZERO, 0.0), sum);
    sum / whole
}

/// Returns the irradiance at the eye on a surface with this unit normal, W/m²: Σ L cosθ Δω over the map's pixels in front
/// of it, with cosθ at each pixel's centre.
pub fn irradiance_at_eye(map: &Panorama, normal: DVec3) -> DVec3 {
    let part = |([x, y], radiance, angle): ([usize; 2], Vec3, f64)| {
        let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let cos = map.projection().direction_at(map.size(), at).dot(normal);
        radiance.as_dvec3() * (angle * cos.max(0.0))
    };
    map.captured_pixels().map(part).sum()
}

/// Makes an empty folder of this process.
pub fn empty_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("capture-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Reads `bytes` from a file without an extension.
pub fn read_panorama(bytes: &[u8], projection: Option<MapProjection>) -> Result<Panorama, Error> {
    // Tests run in parallel threads of one process.
    let thread = format!("{:?}", std::thread::current().id());
    let folder = empty_folder(&format!("read-{}", thread.replace(['(', ')'], "")));
    let path = folder.join("map");
    fs::write(&path, bytes).unwrap();
    let panorama = Panorama::read(&path, projection);
    fs::remove_dir_all(folder).unwrap();
    panorama
}

/// Reads `bytes`, which must be refused in one line that names the file; returns the reason.
pub fn refusal_of_bytes(bytes: &[u8]) -> String {
    match read_panorama(bytes, None) {
        Err(error @ Error::Input { .. }) => {
            let text = error.to_string();
            assert!(!text.contains('\n') && text.contains("map"), "{text}");
            text.split_once("map: ").unwrap().1.to_owned()
        }
        Err(error) => panic!("{error}"),
        Ok(map) => panic!("loaded: {:?}", map.notes),
    }
}

/// Decodes a pixel of a Radiance picture by the format's definition.
pub fn decode_rgbe(p: [u8; 4]) -> Vec3 {
    let scale = 2_f64.powi(i32::from(p[3]) - 136);
    let value = |c: u8| {
        if p[3] == 0 { 0.0 } else { (f64::from(c) * scale) as f32 }
    };
    Vec3::new(value(p[0]), value(p[1]), value(p[2]))
}

/// Makes irregular pixels with some runs; none is a run marker or the start of a scanline.
pub fn irregular_pixels(count: usize) -> Vec<[u8; 4]> {
    let mut state = 12345_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let mut pixels: Vec<[u8; 4]> = Vec::new();
    while pixels.len() < count {
        let run = if next() < 64 { usize::from(next()) } else { 1 };
        let pixel = [next() | 4, next(), next(), 120 + next() % 16];
        pixels.extend(std::iter::repeat_n(pixel, run.clamp(1, count - pixels.len())));
    }
    pixels
}

/// Joins a Radiance picture: header lines, an empty line, the resolution line, and `body`.
pub fn radiance_picture(header: &[&str], resolution: &str, body: &[u8]) -> Vec<u8> {
    let mut bytes = header.join("\n").into_bytes();
    bytes.extend(format!("\n\n{resolution}\n").into_bytes());
    bytes.extend(body);
    bytes
}

/// Encodes a scanline in the new run-length encoding: each component as runs and literals.
pub fn encode_new_rle(line: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = vec![2, 2, (line.len() >> 8) as u8, line.len() as u8];
    for c in 0..4 {
        let mut at = 0;
        while at < line.len() {
            let same = line[at..].iter().take_while(|p| p[c] == line[at][c]);
            let run = same.count().min(127);
            if run >= 3 {
                bytes.extend([128 + run as u8, line[at][c]]);
                at += run;
            } else {
                bytes.extend([1, line[at][c]]);
                at += 1;
            }
        }
    }
    bytes
}

/// Encodes a scanline in the old run-length encoding: a pixel, then its number of repetitions in base 256.
pub fn encode_old_rle(line: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut at = 0;
    while at < line.len() {
        bytes.extend(line[at]);
        let same = line[at..].iter().take_while(|p| **p == line[at]).count();
        let mut rest = same - 1;
        while rest > 0 {
            bytes.extend([1, 1, 1, (rest % 256) as u8]);
            rest /= 256;
        }
        at += same;
    }
    bytes
}

/// Makes the map whose pixels hold `radiance` at their centres; nothing outside an angular map's disc.
pub fn paint_panorama(
    projection: MapProjection,
    size: [usize; 2],
    mut radiance: impl FnMut(DVec3) -> Vec3,
) -> Panorama {
    let pixels = (0..size[0] * size[1]).map(|k| {
        let at = DVec2::new((k % size[0]) as f64 + 0.5, (k / size[0]) as f64 + 0.5);
        let half = size[0] as f64 / 2.0;
        match projection {
            MapProjection::Angular if (at - half).length() >= half => Vec3::ZERO,
            _ => radiance(projection.direction_at(size, at)),
        }
    });
    Panorama::from_pixels(size, pixels.collect(), Some(projection)).unwrap()
}

/// Returns the outline of every texel relative to `eye`.
pub fn texel_outlines(scene: &Scene, resolutions: &[[u32; 2]], eye: DVec3) -> Vec<[DVec3; 4]> {
    let texels = scene.faces.iter().zip(resolutions).flat_map(|(face, resolution)| {
        (0..texel::texel_count(*resolution)).map(|k| texel::texel_outline(face, *resolution, k).padded_corners())
    });
    texels.map(|corners| corners.map(|corner| corner - eye)).collect()
}

/// Light that walls send to a point.
pub struct LightAtEye {
    /// Radiance, integrated over the sphere.
    pub sphere: DVec3,
    /// Irradiance in each direction.
    pub irradiance: Vec<DVec3>,
    /// Bound of its error: a texel's cosine is off by half its width at most, errors of texels are independent.
    pub bound: DVec3,
}

/// Integrates the light of texels of these radiosities, with their outlines relative to the point.
pub fn light_at_eye(radiosity: &[Vec3], outlines: &[[DVec3; 4]], normals: &[DVec3]) -> LightAtEye {
    let mut found = LightAtEye {
        sphere: DVec3::ZERO,
        irradiance: vec![DVec3::ZERO; normals.len()],
        bound: DVec3::ZERO,
    };
    for (b, outline) in radiosity.iter().zip(outlines) {
        let ends @ [p, q, r, s] = outline.map(DVec3::normalize);
        let flux = b.as_dvec3() / PI * (solid_angle([p, q, r]).abs() + solid_angle([p, r, s]).abs());
        let middle = ends.iter().sum::<DVec3>().normalize();
        let width = ends.iter().map(|end| end.distance(middle)).fold(0.0, f64::max);
        found.sphere += flux;
        for (sum, normal) in found.irradiance.iter_mut().zip(normals) {
            *sum += flux * middle.dot(*normal).max(0.0);
        }
        found.bound += (flux * 2.0 * width).powf(2.0);
    }
    found.bound = found.bound.map(f64::sqrt);
    found
}

/// Returns the solid angle of a triangle with corners of length 1 about the origin (van Oosterom & Strackee 1983), negative
/// of one that turns clockwise.
pub fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}
