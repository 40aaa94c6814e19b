//! Decodes Radiance pictures (.hdr, .pic): `#?RADIANCE`, header lines, an empty line, the resolution line,
//! scanlines: flat, or with the old or new run-length encoding. (The decoder of the crate `image` knows one
//! orientation, one FORMAT and one EXPOSURE, and names no place in a damaged file.)
//!
//! Rules: radiance = pixel / product of all EXPOSURE lines (and of COLORCORR, per channel); Rec. 709 is assumed and
//! PRIMARIES ignored, as by nearly every program that writes it; without a FORMAT line the format is rgbe; bytes
//! after the last scanline are ignored. Notes report the last two.

use super::colour::{XYZ_PRIMARIES, convert_pixels};
use super::{DecodeFailure, DecodedMap, check_size};
use glam::Vec3;

/// Longest accepted header, bytes.
const MAX_HEADER_BYTES: usize = 1 << 16;

/// Widths for which the new run-length encoding is defined.
const NEW_RLE_WIDTHS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// The place of a fault, in bytes from the start of its scanline, and a message.
type ScanlineFault = (usize, String);

/// The resolution line. Scanlines run along the second axis and follow one another along the first.
#[derive(Clone, Copy)]
struct Resolution {
    /// True if scanlines are columns.
    by_columns: bool,
    /// Number of scanlines.
    scanlines: usize,
    /// Pixels per scanline.
    length: usize,
    /// True if the map's column 0, or its row 0, comes last.
    flips: [bool; 2],
}

/// Decodes a whole file.
pub(super) fn decode_bytes(bytes: &[u8]) -> Result<DecodedMap, DecodeFailure> {
    let mut lines = Lines { bytes, at: 0 };
    let mut notes = Vec::new();
    let (exposure, is_xyz) = read_variables(&mut lines, &mut notes)?;
    let resolution = Resolution::parse(&lines.read_line()?)?;
    let mut at = lines.at;
    let mut pixels: Vec<[u8; 4]> = Vec::new();
    for line in 0..resolution.scanlines {
        let taken = decode_scanline(&bytes[at..], resolution.length, &mut pixels);
        at += taken.map_err(|(offset, message)| DecodeFailure {
            place: format!("scanline {line}, byte {}", at + offset),
            message: format!("{message}: write or copy it again"),
        })?;
    }
    if at < bytes.len() {
        notes.push(format!(
            "{} bytes after the last scanline are ignored",
            bytes.len() - at
        ));
    }
    let (size, mut pixels) = resolution.turn_upright(&pixels);
    for pixel in &mut pixels {
        *pixel /= exposure;
    }
    if is_xyz {
        convert_pixels(XYZ_PRIMARIES, &mut pixels);
        notes.push("CIE XYZ was converted to Rec. 709; colours outside it turn negative".into());
    }
    Ok(DecodedMap {
        size,
        pixels,
        projection: None,
        notes,
    })
}

/// Reads the header up to its empty line; returns the exposure, and whether the pixels are CIE XYZ.
fn read_variables(lines: &mut Lines, notes: &mut Vec<String>) -> Result<(Vec3, bool), DecodeFailure> {
    let (mut exposure, mut format) = (Vec3::ONE, None);
    loop {
        let line = lines.read_line()?;
        if line.is_empty() {
            break;
        }
        let (key, value) = line.split_once('=').unwrap_or((&line, ""));
        match key.trim() {
            "EXPOSURE" | "COLORCORR" => match parse_factor(value) {
                Some(factor) => exposure *= factor,
                None => notes.push(format!("`{}` is not understood: ignored", shorten_text(&line))),
            },
            "FORMAT" => format = Some(value.trim().to_owned()),
            _ => {}
        }
    }
    if !exposure.is_finite() || exposure.min_element() <= 0.0 {
        return Err("its EXPOSURE lines multiply to something out of range".into());
    }
    match format.as_deref() {
        Some("32-bit_rle_rgbe") => Ok((exposure, false)),
        Some("32-bit_rle_xyze") => Ok((exposure, true)),
        Some(other) => Err(format!(
            "has the format `{}`: 32-bit_rle_rgbe or 32-bit_rle_xyze is needed",
            shorten_text(other)
        )
        .into()),
        None => {
            notes.push("has no FORMAT line: read as 32-bit_rle_rgbe".into());
            Ok((exposure, false))
        }
    }
}

/// Parses one number above 0 for all channels, or three, one per channel.
fn parse_factor(text: &str) -> Option<Vec3> {
    let number = |word: &str| word.parse().ok().filter(|n: &f32| n.is_finite() && *n > 0.0);
    let numbers: Option<Vec<f32>> = text.split_whitespace().map(number).collect();
    match numbers?[..] {
        [all] => Some(Vec3::splat(all)),
        [r, g, b] => Some(Vec3::new(r, g, b)),
        _ => None,
    }
}

/// Shortens a file's own text to fit into a message of one line.
fn shorten_text(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(40).collect()
}

/// The lines of a header, without their endings.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Lines<'_> {
    fn read_line(&mut self) -> Result<String, DecodeFailure> {
        let end = self.bytes.len().min(MAX_HEADER_BYTES);
        let rest = self.bytes.get(self.at..end).unwrap_or_default();
        let Some(length) = rest.iter().position(|b| *b == b'\n') else {
            return Err(DecodeFailure {
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
    fn parse(line: &str) -> Result<Self, DecodeFailure> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let refuse = || {
            let line = shorten_text(line);
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
            flips: [flip_x, flip_y],
        })
    }

    /// Returns width and height, and the radiance row by row from the upper left.
    fn turn_upright(&self, pixels: &[[u8; 4]]) -> ([usize; 2], Vec<Vec3>) {
        let [w, h] = match self.by_columns {
            true => [self.scanlines, self.length],
            false => [self.length, self.scanlines],
        };
        let from = |x: usize, y: usize| {
            let x = if self.flips[0] { w - 1 - x } else { x };
            let y = if self.flips[1] { h - 1 - y } else { y };
            let (line, place) = if self.by_columns { (x, y) } else { (y, x) };
            decode_rgbe(pixels[line * self.length + place])
        };
        let places = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        ([w, h], places.map(|(x, y)| from(x, y)).collect())
    }
}

/// Decodes a pixel: three mantissas and a common exponent.
fn decode_rgbe([r, g, b, exponent]: [u8; 4]) -> Vec3 {
    let scale = if exponent == 0 {
        0.0
    } else {
        2_f64.powi(i32::from(exponent) - 136)
    };
    Vec3::from([r, g, b].map(|c| (f64::from(c) * scale) as f32))
}

/// Decodes a scanline of `length` pixels, appends it to `pixels` and returns its length in bytes.
fn decode_scanline(bytes: &[u8], length: usize, pixels: &mut Vec<[u8; 4]>) -> Result<usize, ScanlineFault> {
    match *bytes {
        [2, 2, high, low, ..] if high < 128 && NEW_RLE_WIDTHS.contains(&length) => {
            let stated = usize::from(high) << 8 | usize::from(low);
            if stated != length {
                let message = format!("says that it has {stated} pixels and the resolution line {length}");
                return Err((2, message));
            }
            decode_components(bytes, length, pixels)
        }
        _ => decode_pixels(bytes, length, pixels),
    }
}

/// Decodes the new run-length encoding: the four components one after the other, each in runs of one value or of
/// several.
fn decode_components(bytes: &[u8], length: usize, pixels: &mut Vec<[u8; 4]>) -> Result<usize, ScanlineFault> {
    let first = pixels.len();
    pixels.resize(first + length, [0; 4]);
    let mut at = 4;
    for c in 0..4 {
        let mut rest = &mut pixels[first..];
        while !rest.is_empty() {
            let byte = |k: usize| {
                bytes
                    .get(k)
                    .copied()
                    .ok_or_else(|| (at, "ends within its pixels".to_owned()))
            };
            let code = usize::from(byte(at)?);
            let is_run = code > 128;
            let count = if is_run { code - 128 } else { code };
            if count == 0 {
                return Err((at, "has a run of no pixels".into()));
            }
            let Some((run, after)) = rest.split_at_mut_checked(count) else {
                return Err((at, format!("has a run that goes beyond {length} pixels")));
            };
            for (k, pixel) in run.iter_mut().enumerate() {
                pixel[c] = byte(at + 1 + if is_run { 0 } else { k })?;
            }
            at += if is_run { 2 } else { 1 + count };
            rest = after;
        }
    }
    Ok(at)
}

/// Decodes pixels, flat or in the old run-length encoding, in which 1, 1, 1, n repeats the pixel before it n times;
/// further such pixels are higher digits of n.
fn decode_pixels(bytes: &[u8], length: usize, pixels: &mut Vec<[u8; 4]>) -> Result<usize, ScanlineFault> {
    let end = pixels.len() + length;
    let first = pixels.len();
    let (mut at, mut shift) = (0, 0);
    while pixels.len() < end {
        let Some(&pixel) = bytes[at..].first_chunk::<4>() else {
            return Err((at, "ends within its pixels".into()));
        };
        if let [1, 1, 1, count] = pixel {
            let count = usize::from(count).checked_shl(shift).unwrap_or(usize::MAX);
            if pixels.len() == first {
                return Err((at, "begins with a run of nothing".into()));
            } else if count > end - pixels.len() {
                return Err((at, format!("has a run that goes beyond {length} pixels")));
            }
            let last = pixels[pixels.len() - 1];
            pixels.extend(std::iter::repeat_n(last, count));
            shift += 8;
        } else {
            pixels.push(pixel);
            shift = 0;
        }
        at += 4;
    }
    Ok(at)
}
