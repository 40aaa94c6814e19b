//! Radiance pictures (.hdr, .pic): `#?RADIANCE`, header lines, an empty line, the resolution line,
//! scanlines.
//!
//! The scanlines are decoded by [`super::scanline`]; the rest, of which the crate `image` knows
//! one orientation, one FORMAT and one EXPOSURE, is read here.
//!
//! Rules: radiance = pixel / product of all EXPOSURE lines (and of COLORCORR, per channel);
//! Rec. 709 is assumed whatever PRIMARIES says, as nearly every program that writes it does;
//! without a FORMAT line it is rgbe; what follows the last scanline is ignored. The last two are noted.

use super::colour::XYZ;
use super::scanline::scanline;
use super::{Decoded, Failure, check_size};
use glam::Vec3;

/// A header longer than this is none.
const MAX_HEADER: usize = 1 << 16;

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
