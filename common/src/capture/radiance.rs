//! Decodes Radiance pictures (.hdr, .pic): `#?RADIANCE`, header lines, an empty line, the resolution line, scanlines:
//! flat, or with the old or new run-length encoding. (The decoder of the crate `image` knows one orientation, one
//! FORMAT and one EXPOSURE, and names no place in a damaged file.) [`super::panorama`] reads files by it.
//!
//! Rules: radiance = pixel / product of all EXPOSURE lines (and of COLORCORR, per channel); Rec. 709 is assumed and
//! PRIMARIES ignored, as by nearly every program that writes it; without a FORMAT line the format is rgbe; bytes
//! after the last scanline are ignored. Notes report the last two.

use super::colour::{XYZ_PRIMARIES, convert_pixels};
use super::{DecodedMap, check_size};
use glam::Vec3;

/// Longest accepted header, bytes.
const MAX_HEADER_BYTES: usize = 1 << 16;

/// Widths for which the new run-length encoding is defined.
const NEW_RLE_WIDTHS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// Reason for which a scanline that ends early cannot be decoded.
const CUT_OFF: &str = "ends within its pixels";

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
pub(super) fn decode_bytes(bytes: &[u8]) -> Result<DecodedMap, String> {
    let mut reader = FileReader { bytes, at: 0 };
    let mut notes = Vec::new();
    let (exposure, is_xyz) = read_variables(&mut reader, &mut notes)?;
    let resolution = Resolution::parse(&reader.read_line()?)?;
    let mut pixels: Vec<[u8; 4]> = Vec::new();
    for line in 0..resolution.scanlines {
        let first = pixels.len();
        pixels.resize(first + resolution.length, [0; 4]);
        let read = reader.read_scanline(&mut pixels[first..]);
        read.map_err(|message| format!("scanline {line}, byte {}: {message}: write or copy it again", reader.at))?;
    }
    let at = reader.at;
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
fn read_variables(reader: &mut FileReader, notes: &mut Vec<String>) -> Result<(Vec3, bool), String> {
    let (mut exposure, mut format) = (Vec3::ONE, None);
    loop {
        let line = reader.read_line()?;
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
        )),
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

/// Reader of a file; `at` is the place of the next byte, or of a fault.
struct FileReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl FileReader<'_> {
    /// Reads a line of the header, without its ending.
    fn read_line(&mut self) -> Result<String, String> {
        let end = self.bytes.len().min(MAX_HEADER_BYTES);
        let rest = self.bytes.get(self.at..end).unwrap_or_default();
        let Some(length) = rest.iter().position(|b| *b == b'\n') else {
            let at = self.at + rest.len();
            return Err(format!("byte {at}: ends within its header: write or copy it again"));
        };
        self.at += length + 1;
        let line = String::from_utf8_lossy(&rest[..length]);
        Ok(line.trim_end_matches('\r').to_owned())
    }

    /// Reads a scanline, flat or in one of the run-length encodings.
    fn read_scanline(&mut self, line: &mut [[u8; 4]]) -> Result<(), String> {
        let length = line.len();
        match self.bytes[self.at..] {
            [2, 2, high, low, ..] if high < 128 && NEW_RLE_WIDTHS.contains(&length) => {
                let stated = usize::from(high) << 8 | usize::from(low);
                self.at += 2;
                if stated != length {
                    return Err(format!(
                        "says that it has {stated} pixels and the resolution line {length}"
                    ));
                }
                self.at += 2;
                (0..4).try_for_each(|c| self.read_component(line, c))
            }
            _ => self.read_pixels(line),
        }
    }

    /// Reads a component in the new run-length encoding: runs of one value or of several.
    fn read_component(&mut self, line: &mut [[u8; 4]], c: usize) -> Result<(), String> {
        let (length, mut rest) = (line.len(), line);
        while !rest.is_empty() {
            let code = usize::from(*self.bytes.get(self.at).ok_or(CUT_OFF)?);
            let (count, stored) = if code > 128 { (code - 128, 1) } else { (code, code) };
            if count == 0 {
                return Err("has a run of no pixels".into());
            }
            let Some((run, after)) = rest.split_at_mut_checked(count) else {
                return Err(beyond_line(length));
            };
            let values = self.bytes.get(self.at + 1..=self.at + stored).ok_or(CUT_OFF)?;
            for (pixel, value) in run.iter_mut().zip(values.iter().cycle()) {
                pixel[c] = *value;
            }
            self.at += 1 + stored;
            rest = after;
        }
        Ok(())
    }

    /// Reads pixels, flat or in the old run-length encoding, in which 1, 1, 1, n repeats the pixel before it n times;
    /// further such pixels are higher digits of n.
    fn read_pixels(&mut self, line: &mut [[u8; 4]]) -> Result<(), String> {
        let (mut done, mut shift) = (0, 0);
        while done < line.len() {
            let pixel = *self.bytes[self.at..].first_chunk::<4>().ok_or(CUT_OFF)?;
            let (mut value, mut count) = (pixel, 1);
            if let [1, 1, 1, digit] = pixel {
                let last = done.checked_sub(1);
                let last = last.ok_or("begins with a run of nothing")?;
                value = line[last];
                count = usize::from(digit).checked_shl(shift).unwrap_or(usize::MAX);
                shift += 8;
            } else {
                shift = 0;
            }
            let length = line.len();
            let run = line[done..].get_mut(..count).ok_or_else(|| beyond_line(length))?;
            run.fill(value);
            done += count;
            self.at += 4;
        }
        Ok(())
    }
}

fn beyond_line(length: usize) -> String {
    format!("has a run that goes beyond {length} pixels")
}

impl Resolution {
    fn parse(line: &str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let refuse = || {
            let line = shorten_text(line);
            format!("its resolution line `{line}` should read like `-Y 512 +X 1024`")
        };
        let [first, scanlines, second, length] = words[..] else {
            return Err(refuse());
        };
        let number = |word: &str| word.parse::<u64>().map_err(|_| refuse());
        let (scanlines, length) = (number(scanlines)?, number(length)?);
        // Rows come first at the top (−Y) and columns at the left (+X).
        let (by_columns, flip_y, flip_x) = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => (false, first == "+Y", second == "-X"),
            ("-X" | "+X", "-Y" | "+Y") => (true, second == "+Y", first == "-X"),
            _ => return Err(refuse()),
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
