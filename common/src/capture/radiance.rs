//! Decodes Radiance pictures (.hdr, .pic): `#?RADIANCE`, header lines, an empty line, the resolution line,
//! scanlines.
//!
//! The scanlines are decoded by [`super::scanline`]. The header is read here, because the crate `image`
//! supports only one orientation, one FORMAT and one EXPOSURE.
//!
//! Rules: radiance = pixel / product of all EXPOSURE lines (and of COLORCORR, per channel);
//! Rec. 709 is assumed and PRIMARIES ignored, as by nearly every program that writes it;
//! without a FORMAT line the format is rgbe; bytes after the last scanline are ignored. Notes report the
//! last two.

use super::colour::XYZ_PRIMARIES;
use super::scanline::decode_scanline;
use super::{DecodeFailure, DecodedMap, check_size};
use glam::Vec3;

/// Longest accepted header, bytes.
const MAX_HEADER_BYTES: usize = 1 << 16;

/// The header of a picture.
struct Header {
    exposure: Vec3,
    xyz: bool,
    resolution: Resolution,
    notes: Vec<String>,
    /// Byte at which the scanlines begin.
    end: usize,
}

/// The resolution line. Scanlines run along the second axis and follow one another along the first.
#[derive(Clone, Copy)]
struct Resolution {
    /// True if scanlines are columns.
    by_columns: bool,
    /// Number of scanlines.
    scanlines: usize,
    /// Pixels per scanline.
    length: usize,
    /// True if the map's column 0 comes last.
    flip_x: bool,
    /// True if the map's row 0 comes last.
    flip_y: bool,
}

/// Tests for a Radiance picture's first two bytes.
pub(super) fn is_radiance(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// Decodes a whole file.
pub(super) fn decode_bytes(bytes: &[u8]) -> Result<DecodedMap, DecodeFailure> {
    let header = Header::parse(bytes)?;
    let resolution = header.resolution;
    let mut lines: Vec<Vec3> = Vec::new();
    let mut at = header.end;
    for line in 0..resolution.scanlines {
        let failure = |(offset, message): (usize, String)| DecodeFailure {
            place: format!("scanline {line}, byte {}", at + offset),
            message: format!("{message}: write or copy it again"),
        };
        let taken = decode_scanline(&bytes[at..], resolution.length, &mut lines).map_err(failure)?;
        at += taken;
    }
    let mut notes = header.notes;
    if at < bytes.len() {
        notes.push(format!(
            "{} bytes after the last scanline are ignored",
            bytes.len() - at
        ));
    }
    let (size, mut pixels) = resolution.turn_upright(lines);
    for pixel in &mut pixels {
        *pixel /= header.exposure;
    }
    if header.xyz {
        XYZ_PRIMARIES.convert_pixels(&mut pixels);
        notes.push("CIE XYZ was converted to Rec. 709; colours outside it turn negative".into());
    }
    Ok(DecodedMap {
        size,
        pixels,
        projection: None,
        notes,
    })
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self, DecodeFailure> {
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
                "EXPOSURE" | "COLORCORR" => match parse_factor(value) {
                    Some(factor) => exposure *= factor,
                    None => notes.push(format!("`{}` is not understood: ignored", shorten_text(&line))),
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
                    shorten_text(other)
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
    fn next(&mut self) -> Result<String, DecodeFailure> {
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
            flip_x,
            flip_y,
        })
    }

    /// Reorders scanlines; returns width and height, and the pixels row by row from the upper left.
    fn turn_upright(&self, lines: Vec<Vec3>) -> ([usize; 2], Vec<Vec3>) {
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
