//! Textures of MTL files: pictures in files relative to the MTL file.

use crate::file::{self, MAX_FILE_BYTES};
use crate::import::material::MaterialTexture;
use crate::import::picture_cache::PictureCache;
use crate::paint::{TexturePicture, WrapMode};
use glam::{DAffine2, DVec2, DVec3};
use std::path::{Path, PathBuf};

/// Reads the texture named by a line of `library`, for a colour of this `factor`.
///
/// Errors: an option is not supported, or the picture cannot be read; the message follows the line's key.
pub fn read_texture(
    pictures: &mut PictureCache<PathBuf>,
    library: &Path,
    line: &str,
    factor: DVec3,
) -> Result<MaterialTexture, String> {
    let line = TextureLine::parse(line)?;
    let name = line.name;
    // Files from Windows separate folders by backslashes.
    let folder = library.parent().unwrap_or(Path::new(""));
    let path = folder.join(name.replace('\\', "/"));
    let picture = pictures.get(path.clone(), factor, |most| {
        let bytes = file::read(&path, MAX_FILE_BYTES).map_err(|reason| format!("{name} cannot be read: {reason}"))?;
        TexturePicture::decode_image(&bytes, most).map_err(|reason| format!("{name} {reason}"))
    })?;
    let wrap = if line.clamp { WrapMode::Clamp } else { WrapMode::Repeat };
    // MTL's v runs upwards from the lower edge, the picture's downwards from the upper edge.
    let down = DAffine2::from_scale_angle_translation(DVec2::new(1.0, -1.0), 0.0, DVec2::Y);
    let place = DAffine2::from_scale_angle_translation(line.scale, 0.0, line.offset);
    Ok(MaterialTexture {
        picture,
        wrap: [wrap; 2],
        transform: down * place,
    })
}

/// Options and file name of a texture's line.
#[derive(Debug, PartialEq)]
struct TextureLine<'l> {
    name: &'l str,
    scale: DVec2,
    offset: DVec2,
    clamp: bool,
}

impl<'l> TextureLine<'l> {
    fn parse(line: &'l str) -> Result<Self, String> {
        let mut parsed = Self {
            name: line.trim(),
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
            clamp: false,
        };
        while parsed.name.starts_with('-') {
            let (option, rest) = parsed.name.split_once(' ').unwrap_or((parsed.name, ""));
            let (value, rest) = rest.split_once(' ').unwrap_or((rest, ""));
            parsed.name = rest;
            match option {
                "-clamp" => parsed.clamp = value == "on",
                "-blendu" | "-blendv" | "-cc" | "-bm" | "-imfchan" => {}
                "-s" => parsed.scale = parsed.parse_vector(option, value, 1.0)?,
                "-o" => parsed.offset = parsed.parse_vector(option, value, 0.0)?,
                _ => return Err(format!("has the option {option}, which is not supported")),
            }
        }
        if parsed.name.is_empty() {
            return Err("names no file".into());
        }
        Ok(parsed)
    }

    /// Parses one to three numbers, beginning with `first`; a picture does not use the third.
    fn parse_vector(&mut self, option: &str, first: &str, other: f64) -> Result<DVec2, String> {
        let number = |word: &str| word.parse().ok().filter(|x: &f64| x.is_finite());
        let missing_numbers = || format!("has an option {option} without numbers");
        let mut vector = DVec2::new(number(first).ok_or_else(missing_numbers)?, other);
        for k in 1..3 {
            let (word, rest) = self.name.split_once(' ').unwrap_or((self.name, ""));
            let Some(x) = number(word) else { break };
            if k == 1 {
                vector.y = x;
            }
            self.name = rest;
        }
        Ok(vector)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_before_the_name() {
        let plain = |name| TextureLine {
            name,
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
            clamp: false,
        };
        let line = TextureLine::parse;
        assert_eq!(line("my wood.png"), Ok(plain("my wood.png")));
        assert_eq!(line("-bm 0.5 -blendu on a.png"), Ok(plain("a.png")));
        let optional = TextureLine {
            scale: DVec2::new(2.0, 3.0),
            offset: DVec2::new(0.5, 0.0),
            clamp: true,
            ..plain("a b.png")
        };
        let text = "-s 2 3 1 -o 0.5 -clamp on a b.png";
        assert_eq!(line(text), Ok(optional));
        for bad in ["", "-s", "-s x a.png", "-mm 0 1 a.png", "-clamp on"] {
            assert!(line(bad).is_err(), "{bad}");
        }
    }
}
