//! Radiance pictures (.hdr, .pic): `#?RADIANCE`, header lines, an empty line, the resolution line,
//! scanlines.
//!
//! The scanlines (flat, old and new run lengths) are decoded by the crate `image`, one at a time:
//! it gets a canonical header for a picture of one scanline and the bytes from there on. So a
//! fault has a scanline, memory grows with what has been decoded, and what `image` does not know
//! (orientations, XYZE, a second EXPOSURE) or check (the width in a scanline's own header, runs
//! of zero, widths that the new run lengths cannot have) is done here.
//!
//! Rules: radiance = pixel / product of all EXPOSURE lines (and of COLORCORR, per channel);
//! Rec. 709 is assumed whatever PRIMARIES says, as nearly every program that writes it does;
//! without a FORMAT line it is rgbe; what follows the last scanline is ignored. The last two are noted.

use super::colour::XYZ;
use super::{Decoded, Failure, check_size};
use glam::Vec3;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;
use std::io::{Cursor, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A header longer than this is none.
const MAX_HEADER: usize = 1 << 16;

/// New run lengths exist for these widths only.
const NEW_RLE: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// What stands before the scanlines.
struct Header {
    exposure: Vec3,
    xyz: bool,
    resolution: Resolution,
    notes: Vec<String>,
    /// Where the scanlines begin.
    end: usize,
}

/// The resolution line: scanlines run along the second axis, and follow one another along the first.
#[derive(Clone, Copy)]
struct Resolution {
    /// Scanlines are columns.
    by_columns: bool,
    /// Scanlines, and pixels in each.
    scanlines: usize,
    length: usize,
    /// Whether row 0, and column 0, of the map comes last.
    flip_x: bool,
    flip_y: bool,
}

/// Whether `bytes` begin like a Radiance picture.
pub(super) fn is(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// Decodes a whole file.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, Failure> {
    let header = Header::parse(bytes)?;
    let resolution = header.resolution;
    let mut lines: Vec<Vec3> = Vec::new();
    let mut at = header.end;
    for line in 0..resolution.scanlines {
        let failure = |(offset, message): (usize, String)| Failure {
            place: format!("scanline {line}, byte {}", at + offset),
            message: format!("{message}: write or copy it again"),
        };
        let taken = scanline(&bytes[at..], resolution.length, &mut lines).map_err(failure)?;
        at += taken;
    }
    let mut notes = header.notes;
    if at < bytes.len() {
        notes.push(format!(
            "{} bytes after the last scanline are ignored",
            bytes.len() - at
        ));
    }
    let (size, mut pixels) = resolution.upright(lines);
    for pixel in &mut pixels {
        *pixel /= header.exposure;
    }
    if header.xyz {
        XYZ.convert(&mut pixels);
        notes.push("CIE XYZ was converted to Rec. 709; colours outside it turn negative".into());
    }
    Ok(Decoded {
        size,
        pixels,
        projection: None,
        notes,
    })
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self, Failure> {
        let mut lines = Lines { bytes, at: 0 };
        let (mut exposure, mut format) = (Vec3::ONE, None);
        let mut notes = Vec::new();
        loop {
            let line = lines.next()?;
            if line.is_empty() {
                break;
            }
            let (key, value) = line.split_once('=').unwrap_or((&line, ""));
            match key.trim() {
                "EXPOSURE" | "COLORCORR" => match factor(value) {
                    Some(factor) => exposure *= factor,
                    None => notes.push(format!("`{}` is not understood: ignored", brief(&line))),
                },
                "FORMAT" => format = Some(value.trim().to_owned()),
                _ => {}
            }
        }
        let xyz = match format.as_deref() {
            Some("32-bit_rle_rgbe") => false,
            Some("32-bit_rle_xyze") => true,
            Some(other) => {
                let message = format!(
                    "has the format `{}`: 32-bit_rle_rgbe or 32-bit_rle_xyze is needed",
                    brief(other)
                );
                return Err(message.into());
            }
            None => {
                notes.push("has no FORMAT line: read as 32-bit_rle_rgbe".into());
                false
            }
        };
        if !exposure.is_finite() || exposure.min_element() <= 0.0 {
            return Err("its EXPOSURE lines multiply to something out of range".into());
        }
        let resolution = Resolution::parse(&lines.next()?)?;
        Ok(Self {
            exposure,
            xyz,
            resolution,
            notes,
            end: lines.at,
        })
    }
}

/// One number above 0 for all channels, or one for each.
fn factor(text: &str) -> Option<Vec3> {
    let number = |word: &str| {
        word.parse()
            .ok()
            .filter(|n: &f32| n.is_finite() && *n > 0.0)
    };
    let numbers: Option<Vec<f32>> = text.split_whitespace().map(number).collect();
    match numbers?[..] {
        [all] => Some(Vec3::splat(all)),
        [r, g, b] => Some(Vec3::new(r, g, b)),
        _ => None,
    }
}

/// As much of a file's own text as goes into a message of one line.
fn brief(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(40).collect()
}

/// The lines of a header, without their endings.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Lines<'_> {
    fn next(&mut self) -> Result<String, Failure> {
        let end = self.bytes.len().min(MAX_HEADER);
        let rest = self.bytes.get(self.at..end).unwrap_or_default();
        let Some(length) = rest.iter().position(|b| *b == b'\n') else {
            return Err(Failure {
                place: format!("byte {}", self.at + rest.len()),
                message: "ends within its header: write or copy it again".into(),
            });
        };
        self.at += length + 1;
        let line = String::from_utf8_lossy(&rest[..length]);
        Ok(line.trim_end_matches('\r').to_owned())
    }
}

impl Resolution {
    fn parse(line: &str) -> Result<Self, Failure> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let refuse = || {
            let line = brief(line);
            format!("its resolution line `{line}` should read like `-Y 512 +X 1024`")
        };
        let [first, scanlines, second, length] = words[..] else {
            return Err(refuse().into());
        };
        let number = |word: &str| word.parse::<u64>().map_err(|_| refuse());
        let (scanlines, length) = (number(scanlines)?, number(length)?);
        // Rows come first at the top (−Y) and columns at the left (+X).
        let (by_columns, flip_y, flip_x) = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => (false, first == "+Y", second == "-X"),
            ("-X" | "+X", "-Y" | "+Y") => (true, second == "+Y", first == "-X"),
            _ => return Err(refuse().into()),
        };
        check_size(length, scanlines)?;
        Ok(Self {
            by_columns,
            scanlines: scanlines as usize,
            length: length as usize,
            flip_x,
            flip_y,
        })
    }

    /// Width and height, and the pixels row by row from the upper left.
    fn upright(&self, lines: Vec<Vec3>) -> ([usize; 2], Vec<Vec3>) {
        let size = match self.by_columns {
            true => [self.scanlines, self.length],
            false => [self.length, self.scanlines],
        };
        if !(self.by_columns || self.flip_x || self.flip_y) {
            return (size, lines);
        }
        let [w, h] = size;
        let from = |x: usize, y: usize| {
            let x = if self.flip_x { w - 1 - x } else { x };
            let y = if self.flip_y { h - 1 - y } else { y };
            let (line, place) = if self.by_columns { (x, y) } else { (y, x) };
            lines[line * self.length + place]
        };
        let pixels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        (size, pixels.map(|(x, y)| from(x, y)).collect())
    }
}

/// Appends one scanline; returns how many bytes it took, or where it fails and why.
fn scanline(bytes: &[u8], length: usize, lines: &mut Vec<Vec3>) -> Result<usize, (usize, String)> {
    let looks_new = matches!(bytes, [2, 2, high, _, ..] if *high < 128);
    if NEW_RLE.contains(&length) {
        if looks_new {
            check_runs(bytes, length)?;
        }
        return by_image(bytes, length, &[], lines);
    }
    // A pixel in front keeps `image` from taking such a scanline for the new encoding; it would
    // also be what a run at the start repeats.
    if bytes.starts_with(&[1, 1, 1]) {
        return Err((0, "begins with a run of nothing".into()));
    }
    by_image(bytes, length, &[0; 4], lines)
}

/// Walks the four components of a scanline in the new encoding.
fn check_runs(bytes: &[u8], length: usize) -> Result<(), (usize, String)> {
    let own = usize::from(bytes[2]) << 8 | usize::from(bytes[3]);
    if own != length {
        let message = format!("says that it has {own} pixels and the resolution line {length}");
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

/// Hands `first` and then `bytes` to the library as a picture of one scanline.
fn by_image(
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
    // The library counts what repeated run markers say without asking for overflow.
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
