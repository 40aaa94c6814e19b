//! Decoding of Radiance pictures in every encoding, from bytes made by the tests.

use approx::abs_diff_eq;
use common::Error;
use common::capture::{MAX_PIXELS, MapProjection, Panorama};
use glam::Vec3;
use radiosity_tests::radiance_files::{
    decode_rgbe, encode_new_rle, encode_old_rle, irregular_pixels, radiance_picture, read_panorama, refusal_of_bytes,
};

const RGBE: &str = "FORMAT=32-bit_rle_rgbe";

fn upright(pixels: &[[u8; 4]]) -> Vec<Vec3> {
    pixels.iter().map(|p| decode_rgbe(*p)).collect()
}

#[test]
fn all_radiance_encodings_decode_to_the_same_map() {
    let (w, h) = (1200, 600);
    let raw = irregular_pixels(w * h);
    let flat = raw.concat();
    let by_lines = |encode: fn(&[[u8; 4]]) -> Vec<u8>| raw.chunks(w).flat_map(encode).collect();
    let encodings: [Vec<u8>; 3] = [flat, by_lines(encode_new_rle), by_lines(encode_old_rle)];
    assert!(encodings[1].len() < encodings[0].len() && encodings[2].len() < encodings[0].len());
    for body in encodings {
        let map = read_panorama(&radiance_picture(&["#?RADIANCE", RGBE], "-Y 600 +X 1200", &body), None).unwrap();
        assert_eq!(map.size(), [w, h]);
        assert_eq!(map.projection(), MapProjection::LatLong);
        assert!(map.notes.is_empty(), "{:?}", map.notes);
        assert!(map.pixels() == upright(&raw));
    }
}

#[test]
fn all_eight_orientations_are_turned_upright() {
    let (w, h) = (16, 8);
    let raw = irregular_pixels(w * h);
    for (flip_x, flip_y, by_columns) in (0..8).map(|k| (k & 1 > 0, k & 2 > 0, k & 4 > 0)) {
        let x = |i: usize| if flip_x { w - 1 - i } else { i };
        let y = |j: usize| if flip_y { h - 1 - j } else { j };
        let (sx, sy) = (if flip_x { '-' } else { '+' }, if flip_y { '+' } else { '-' });
        let (line, body): (String, Vec<u8>) = if by_columns {
            let columns = (0..w).map(|i| (0..h).map(|j| raw[y(j) * w + x(i)]).collect::<Vec<_>>());
            (
                format!("{sx}X {w} {sy}Y {h}"),
                columns.flat_map(|c| encode_new_rle(&c)).collect(),
            )
        } else {
            let rows = (0..h).map(|j| (0..w).map(|i| raw[y(j) * w + x(i)]).collect::<Vec<_>>());
            (
                format!("{sy}Y {h} {sx}X {w}"),
                rows.flat_map(|r| encode_new_rle(&r)).collect(),
            )
        };
        let map = read_panorama(&radiance_picture(&["#?RADIANCE", RGBE], &line, &body), None).unwrap();
        assert_eq!(map.size(), [w, h], "{line}");
        assert!(map.pixels() == upright(&raw), "{line}");
    }
}

#[test]
fn header_lines_follow_the_radiance_format() {
    let raw = irregular_pixels(32);
    let body = raw.concat();
    let with = |lines: &[&str]| {
        let header: Vec<&str> = ["#?RGBE"].iter().chain(lines).copied().collect();
        read_panorama(&radiance_picture(&header, "-Y 4 +X 8", &body), None).unwrap()
    };
    let truth = upright(&raw);
    let lenient = with(&[
        "#?RADIANCE",
        "# by hand",
        "PRIMARIES=0 0 0 0 0 0 0 0",
        "GAMMA=1",
        "what",
        RGBE,
    ]);
    assert!(
        lenient.pixels() == truth && lenient.notes.is_empty(),
        "{:?}",
        lenient.notes
    );
    let exposed = with(&["EXPOSURE=2.0", RGBE, "EXPOSURE= 0.5", "EXPOSURE=4"]);
    assert!(exposed.pixels().iter().zip(&truth).all(|(a, b)| *a * 4.0 == *b));
    let corrected = with(&[RGBE, "COLORCORR=1 2 4"]);
    let factor = Vec3::new(1.0, 2.0, 4.0);
    assert!(corrected.pixels().iter().zip(&truth).all(|(a, b)| *a * factor == *b));
    let doubtful = with(&["EXPOSURE=much"]);
    assert!(doubtful.pixels() == truth);
    assert_eq!(doubtful.notes.len(), 2, "{:?}", doubtful.notes);
    // CIE's matrix to linear Rec. 709, as IEC 61966-2-1 prints it, to four digits.
    let xyz = with(&["FORMAT=32-bit_rle_xyze"]);
    for (a, b) in xyz.pixels().iter().zip(&truth) {
        let red = 3.2406 * b.x - 1.5372 * b.y - 0.4986 * b.z;
        let green = -0.9689 * b.x + 1.8758 * b.y + 0.0415 * b.z;
        let scale = 4e-4 * b.max_element();
        assert!(abs_diff_eq!(a.x, red.max(0.0), epsilon = scale), "{a} {b}");
        assert!(abs_diff_eq!(a.y, green.max(0.0), epsilon = scale), "{a} {b}");
    }
    let trailing = [&body[..], b"more"].concat();
    let trailing = read_panorama(&radiance_picture(&["#?RADIANCE", RGBE], "-Y 4 +X 8", &trailing), None).unwrap();
    assert!(trailing.pixels() == truth);
    assert!(trailing.notes[0].starts_with("4 bytes"), "{:?}", trailing.notes);
}

#[test]
fn narrow_pictures_are_read_without_run_lengths() {
    // Their first pixels look like the start of a scanline in the new encoding.
    let mut raw = irregular_pixels(7 * 7);
    for line in raw.chunks_mut(7) {
        line[0] = [2, 2, 0, 7];
    }
    let map = read_panorama(
        &radiance_picture(&["#?RADIANCE", RGBE], "-Y 7 +X 7", &raw.concat()),
        None,
    )
    .unwrap();
    assert!(map.pixels() == upright(&raw));
    assert_eq!(map.projection(), MapProjection::Angular);
}

#[test]
fn broken_picture_is_refused_with_scanline_and_byte() {
    let line = vec![[9, 8, 7, 128]; 16];
    let scanline = encode_new_rle(&line);
    let body = scanline.repeat(8);
    let start = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n".len();
    let header = ["#?RADIANCE", RGBE];
    let all = |body: &[u8]| radiance_picture(&header, "-Y 8 +X 16", body);
    assert!(read_panorama(&all(&body), None).is_ok());
    let broken = |at: usize, value: u8| {
        let mut body = body.clone();
        body[3 * scanline.len() + at] = value;
        refusal_of_bytes(&all(&body))
    };
    let place = |at: usize| format!("scanline 3, byte {}", start + 3 * scanline.len() + at);
    for (at, value, what) in [(3, 15, "15 pixels"), (4, 0, "no pixels"), (4, 255, "beyond 16")] {
        let at_place = if at == 3 { 2 } else { at };
        let text = broken(at, value);
        assert!(text.starts_with(&place(at_place)) && text.contains(what), "{text}");
    }
    let text = refusal_of_bytes(&all(&body[..body.len() - 1]));
    assert!(text.starts_with("scanline 7") && text.contains("ends within"), "{text}");
    let text = refusal_of_bytes(&radiance_picture(&header, "-Y 8 +X 16", &[9; 16 * 8 * 4 - 2]));
    assert!(text.starts_with("scanline 7") && text.contains("ends within"), "{text}");
    for markers in [vec![1; 64], [[9, 9, 9, 9], [1, 1, 1, 17]].concat()] {
        let text = refusal_of_bytes(&all(&markers));
        assert!(text.starts_with("scanline 0"), "{text}");
    }
}

#[test]
fn invalid_headers_are_refused() {
    let header = ["#?RADIANCE", RGBE];
    let body = irregular_pixels(128).concat();
    let resolutions = [
        "-Y 1000000 +X 1000000",
        "-Y 99999999999999999999 +X 16",
        "-Y 0 +X 0",
        "-Y -8 +X 16",
        "FOO BAR",
        "-Y 8 -Y 16",
        "*Y 8 +X 16",
        "é 8 +X 16",
        "-Y 8",
    ];
    for resolution in resolutions {
        refusal_of_bytes(&radiance_picture(&header, resolution, &body));
    }
    let most = refusal_of_bytes(&radiance_picture(&header, "-Y 8192 +X 8193", &body));
    assert!(most.contains(&MAX_PIXELS.to_string()), "{most}");
    assert!(
        refusal_of_bytes(&radiance_picture(
            &["#?RADIANCE", "FORMAT=64-bit_foo"],
            "-Y 8 +X 16",
            &body
        ))
        .contains("foo")
    );
    for bytes in [
        &b""[..],
        b"#",
        b"P6 16 8 255\n",
        b"\x76\x2f",
        b"\x76\x2f\x31\x01",
        b"#?RADIANCE\n",
    ] {
        refusal_of_bytes(bytes);
    }
    let endless = [&b"#?RADIANCE\n"[..], &[b'a'; 1 << 20]].concat();
    assert!(refusal_of_bytes(&endless).contains("header"));
    let shape = refusal_of_bytes(&radiance_picture(&header, "-Y 8 +X 12", &body[..8 * 12 * 4]));
    assert!(shape.contains("say which it is"), "{shape}");
}

#[test]
fn invalid_pixels_are_repaired_and_counted() {
    let mut pixels = vec![Vec3::ONE; 8 * 4];
    pixels[0] = Vec3::new(f32::NAN, 5.0, 5.0);
    pixels[1] = Vec3::splat(3.0);
    pixels[8] = Vec3::new(-4.0, 6.0, 2.0);
    pixels[9] = Vec3::new(0.0, f32::INFINITY, f32::NAN);
    pixels[31] = Vec3::new(0.0, f32::NEG_INFINITY, -1.0);
    let map = Panorama::from_pixels([8, 4], pixels, None).unwrap();
    let counts = map.counts;
    assert_eq!((counts.nan, counts.infinite, counts.negative), (2, 1, 1));
    assert_eq!(map.notes.len(), 3, "{:?}", map.notes);
    assert!(map.notes[0].starts_with("2 of 32 pixels"), "{:?}", map.notes);
    // One of the corner's three neighbours is not finite, one had a negative channel set to 0.
    assert_eq!(map.pixels()[0], Vec3::new(1.5, 4.5, 2.5));
    assert_eq!(map.pixels()[8], Vec3::new(0.0, 6.0, 2.0));
    assert_eq!(map.pixels()[31], Vec3::ONE);
    let alone = Panorama::from_pixels([2, 1], vec![Vec3::NAN; 2], None).unwrap();
    assert_eq!(alone.pixels(), [Vec3::ZERO; 2]);
    let large = Panorama::from_pixels([2, 1], vec![Vec3::splat(2e38); 2], None);
    assert!(matches!(large, Err(Error::Usage(_))));
}
