//! Decodes the scanlines of a Radiance picture: flat, or with the old or new run-length encoding.
//!
//! The crate `image` decodes them one at a time, each behind a canonical header for a picture of one
//! scanline. So an error has a scanline and a byte, and memory grows only with the decoded part. Checks
//! that `image` lacks are made here: the width in a scanline's own header, runs of length zero, and widths
//! outside the new encoding's range.

use glam::Vec3;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;
use std::io::{Cursor, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Widths for which the new run-length encoding is defined.
const NEW_RLE: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// Decodes one scanline and appends it to `lines`. Returns its length in bytes.
///
/// Errors: the byte of the error and a message.
pub(super) fn decode_scanline(bytes: &[u8], length: usize, lines: &mut Vec<Vec3>) -> Result<usize, (usize, String)> {
    let looks_new = matches!(bytes, [2, 2, high, _, ..] if *high < 128);
    if NEW_RLE.contains(&length) {
        if looks_new {
            check_runs(bytes, length)?;
        }
        return decode_with_image(bytes, length, &[], lines);
    }
    // A pixel put in front keeps `image` from taking such a scanline for the new encoding. A run at the
    // start would repeat that pixel, so such a run is refused first.
    if bytes.starts_with(&[1, 1, 1]) {
        return Err((0, "begins with a run of nothing".into()));
    }
    decode_with_image(bytes, length, &[0; 4], lines)
}

/// Checks the run lengths of the four components of a scanline in the new encoding.
fn check_runs(bytes: &[u8], length: usize) -> Result<(), (usize, String)> {
    let stated = usize::from(bytes[2]) << 8 | usize::from(bytes[3]);
    if stated != length {
        let message = format!("says that it has {stated} pixels and the resolution line {length}");
        return Err((2, message));
    }
    let mut at = 4;
    for _ in 0..4 {
        let mut done = 0;
        while done < length {
            let short = || (at, "ends within its pixels".to_owned());
            let count = usize::from(*bytes.get(at).ok_or_else(short)?);
            let (pixels, skip) = match count {
                0 => return Err((at, "has a run of no pixels".into())),
                1..=128 => (count, count + 1),
                _ => (count - 128, 2),
            };
            done += pixels;
            if done > length {
                return Err((at, format!("has a run that goes beyond {length} pixels")));
            }
            at += skip;
        }
    }
    Ok(())
}

/// Decodes `first` followed by `bytes` with `image`, as a picture of one scanline.
fn decode_with_image(
    bytes: &[u8],
    length: usize,
    first: &[u8],
    lines: &mut Vec<Vec3>,
) -> Result<usize, (usize, String)> {
    let extra = first.len() / 4;
    let width = length + extra;
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X {width}\n");
    let mut rest = Cursor::new(bytes);
    let mut pixels = vec![[0_f32; 3]; width];
    // The library may overflow when it multiplies repeated run markers; such a panic is an error.
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        HdrDecoder::new(header.as_bytes().chain(first).chain(&mut rest))?
            .read_image(bytemuck::cast_slice_mut(&mut pixels))
    }));
    let at = rest.position() as usize;
    match decoded {
        Ok(Ok(())) => {
            lines.extend(pixels[extra..].iter().map(|p| Vec3::from(*p)));
            Ok(at)
        }
        Ok(Err(_)) if at >= bytes.len() => Err((at, "ends within its pixels".into())),
        Ok(Err(error)) => Err((at, format!("cannot be decoded ({error})"))),
        Err(_) => Err((at, "cannot be decoded".into())),
    }
}
