//! Textures of an MTL file: pictures beside it.

use crate::file::{self, MAX_BYTES};
use crate::import::material::Texture;
use crate::import::pictures;
use crate::paint::{Picture, Wrap};
use glam::{DAffine2, DVec2, DVec3};
use std::path::{Path, PathBuf};

/// Those that were read so far.
pub struct Pictures(pub pictures::Pictures<PathBuf>);

impl Pictures {
    /// The texture that a line of `library` names, for a colour of a `factor`; the error follows its key.
    pub fn texture(
        &mut self,
        library: &Path,
        line: &str,
        factor: DVec3,
    ) -> Result<Texture, String> {
        let Line {
            name,
            scale,
            offset,
            clamp,
        } = Line::of(line)?;
        // Written on Windows, it may part folders by backslashes.
        let folder = library.parent().unwrap_or(Path::new(""));
        let path = folder.join(name.replace('\\', "/"));
        let picture = self.0.get(path.clone(), factor, |most| {
            let bytes = file::read(&path, MAX_BYTES)
                .map_err(|reason| format!("{name} cannot be read: {reason}"))?;
            Picture::decode(&bytes, most).map_err(|reason| format!("{name} {reason}"))
        })?;
        // MTL's v runs upwards from the lower edge, the picture's down from the upper one.
        let down = DAffine2::from_scale_angle_translation(DVec2::new(1.0, -1.0), 0.0, DVec2::Y);
        Ok(Texture {
            picture,
            wrap: [if clamp { Wrap::Clamp } else { Wrap::Repeat }; 2],
            place: down * DAffine2::from_scale_angle_translation(scale, 0.0, offset),
        })
    }
}

/// What a line says after its key: options, and the name of a file.
struct Line<'l> {
    name: &'l str,
    scale: DVec2,
    offset: DVec2,
    clamp: bool,
}

impl<'l> Line<'l> {
    fn of(line: &'l str) -> Result<Self, String> {
        let mut found = Self {
            name: line.trim(),
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
            clamp: false,
        };
        while found.name.starts_with('-') {
            let (option, rest) = found.name.split_once(' ').unwrap_or((found.name, ""));
            let (value, rest) = rest.split_once(' ').unwrap_or((rest, ""));
            found.name = rest;
            match option {
                "-clamp" => found.clamp = value == "on",
                "-blendu" | "-blendv" | "-cc" | "-bm" | "-imfchan" => {}
                "-s" => found.scale = found.vector(option, value, 1.0)?,
                "-o" => found.offset = found.vector(option, value, 0.0)?,
                _ => return Err(format!("has the option {option}, which is not supported")),
            }
        }
        if found.name.is_empty() {
            return Err("names no file".into());
        }
        Ok(found)
    }

    /// One to three numbers, the first of which is `first`; the third says nothing of a picture.
    fn vector(&mut self, option: &str, first: &str, other: f64) -> Result<DVec2, String> {
        let number = |word: &str| word.parse().ok().filter(|x: &f64| x.is_finite());
        let wrong = || format!("has an option {option} without numbers");
        let mut vector = DVec2::new(number(first).ok_or_else(wrong)?, other);
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
        let line = |text| {
            Line::of(text).map(|l| {
                (
                    l.name.to_owned(),
                    l.scale.to_array(),
                    l.offset.to_array(),
                    l.clamp,
                )
            })
        };
        let plain = |name: &str| Ok((name.to_owned(), [1., 1.], [0., 0.], false));
        assert_eq!(line("my wood.png"), plain("my wood.png"));
        assert_eq!(line("-bm 0.5 -blendu on a.png"), plain("a.png"));
        assert_eq!(
            line("-s 2 3 1 -o 0.5 -clamp on a b.png"),
            Ok(("a b.png".into(), [2., 3.], [0.5, 0.], true))
        );
        for bad in ["", "-s", "-s x a.png", "-mm 0 1 a.png", "-clamp on"] {
            assert!(line(bad).is_err(), "{bad}");
        }
    }
}
