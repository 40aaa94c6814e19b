//! Reads MTL files: `Kd` × `map_Kd` is reflectance, `Ke` × `map_Ke` emitted radiance L.

use super::text;
use crate::error::{Error, Result};
use crate::file::{self, MAX_FILE_BYTES};
use crate::import::material::{ImportedMaterial, TexturedColour};
use crate::import::picture_cache::PictureCache;
use crate::paint::{TexturePicture, WrapMode, WrappedTexture};
use glam::{DAffine2, DVec2, DVec3};
use std::path::{Path, PathBuf};

/// A material of an MTL file, its textures not yet read.
#[derive(Default)]
pub struct MtlMaterial {
    /// Name after `newmtl`.
    pub name: String,
    /// Folder of the scene.
    folder: PathBuf,
    file: PathBuf,
    /// `Kd` and `Ke`.
    factors: [Option<DVec3>; 2],
    /// Options and file names of `map_Kd` and `map_Ke`.
    maps: [Option<String>; 2],
    /// True if the material is glossy, transparent or mirroring.
    pub is_more_than_diffuse: bool,
}

/// Reads all materials of a file that belongs to a scene in `folder`.
///
/// Errors: a colour is not given as one or three RGB numbers, or a material has no name.
pub fn read_materials(folder: &Path, path: &Path, bytes: &[u8]) -> Result<Vec<MtlMaterial>> {
    let mut materials: Vec<MtlMaterial> = Vec::new();
    // Takes what comes before the first `newmtl`.
    let mut nameless = MtlMaterial::default();
    for (number, line) in text::logical_lines(text::decode_text(path, bytes)?) {
        let fail = |message: String| Error::bad_input(path, format!("line {number}"), message);
        let (key, rest) = line.split_once(' ').unwrap_or((&line, ""));
        let words: Vec<&str> = rest.split(' ').filter(|w| !w.is_empty()).collect();
        let number = |word: &&str| word.parse::<f64>();
        let material = materials.last_mut().unwrap_or(&mut nameless);
        match (key, words.as_slice()) {
            ("newmtl", []) => return Err(fail("a material needs a name".into())),
            ("newmtl", _) => materials.push(MtlMaterial {
                name: rest.into(),
                folder: folder.to_owned(),
                file: path.to_owned(),
                ..MtlMaterial::default()
            }),
            ("Kd", words) => material.factors[0] = Some(parse_colour(key, words).map_err(fail)?),
            ("Ke", words) => material.factors[1] = Some(parse_colour(key, words).map_err(fail)?),
            ("map_Kd", _) => material.maps[0] = Some(rest.into()),
            ("map_Ke", _) => material.maps[1] = Some(rest.into()),
            // These values only lead to a note: invalid ones are skipped.
            ("Ks", words) => material.is_more_than_diffuse |= words.iter().any(|w| number(w).is_ok_and(|x| x != 0.0)),
            ("illum", [model]) => material.is_more_than_diffuse |= number(model).is_ok_and(|model| model > 2.0),
            ("d", [opacity]) => material.is_more_than_diffuse |= number(opacity).is_ok_and(|d| d < 1.0),
            _ => {}
        }
    }
    Ok(materials)
}

/// Parses three numbers, or one that stands for all of them.
fn parse_colour(key: &str, words: &[&str]) -> std::result::Result<DVec3, String> {
    let words = match words {
        [grey] => [*grey; 3],
        [] | [_, _] => return Err(format!("{key} needs three numbers")),
        ["spectral" | "xyz", ..] => return Err(format!("{key} can only be given as RGB")),
        [r, g, b, ..] => [*r, *g, *b],
    };
    match words.map(str::parse) {
        [Ok(r), Ok(g), Ok(b)] => Ok(DVec3::new(r, g, b)),
        _ => Err("cannot be understood: is a number missing?".into()),
    }
}

impl MtlMaterial {
    /// Reads the textures of the material. A `replaced` reflectance needs no texture.
    ///
    /// Errors: a texture cannot be read.
    pub fn read_textures(&self, pictures: &mut PictureCache<PathBuf>, replaced: bool) -> Result<ImportedMaterial> {
        Ok(ImportedMaterial {
            file: self.file.clone(),
            name: self.name.clone(),
            colours: [
                self.read_colour(0, replaced, pictures)?,
                self.read_colour(1, false, pictures)?,
            ],
            names: ["Kd", "Ke"],
        })
    }

    /// Combines colour `k` with its texture. A missing colour counts as 1 beside a texture and as 0 without one;
    /// a colour of 0 needs no texture. Pixels of a reflectance stay below 1.
    fn read_colour(&self, k: usize, replaced: bool, pictures: &mut PictureCache<PathBuf>) -> Result<TexturedColour> {
        let map = self.maps[k].as_deref().filter(|_| !replaced);
        let alone = if map.is_some() { DVec3::ONE } else { DVec3::ZERO };
        let factor = self.factors[k].unwrap_or(alone);
        let white = if k == 0 { factor } else { DVec3::ZERO };
        let read = |map| {
            self.read_texture(pictures, map, white).map_err(|message| {
                let key = ["map_Kd", "map_Ke"][k];
                Error::bad_input(
                    &self.file,
                    format!("material {}", self.name),
                    format!("{key} {message}"),
                )
            })
        };
        let texture = map.filter(|_| factor != DVec3::ZERO).map(read).transpose()?;
        Ok(TexturedColour { factor, texture })
    }

    /// Reads the texture named by a line of the file, for a colour of this `factor`. Also returns the transform from the
    /// file's texture coordinates to the picture's.
    ///
    /// Errors: an option is not supported, or the picture cannot be read; the message follows the line's key.
    fn read_texture(
        &self,
        pictures: &mut PictureCache<PathBuf>,
        line: &str,
        factor: DVec3,
    ) -> std::result::Result<(WrappedTexture, DAffine2), String> {
        let line = TextureLine::parse(line)?;
        let name = line.name;
        let unread = |reason| format!("{name} cannot be read: {reason}");
        let path = self.path_of(name).map_err(unread)?;
        let picture = pictures.get(path.clone(), factor, |most| {
            let bytes = file::read(&path, MAX_FILE_BYTES).map_err(unread)?;
            TexturePicture::decode_image(&bytes, most).map_err(|reason| format!("{name} {reason}"))
        })?;
        let wrap = if line.clamp { WrapMode::Clamp } else { WrapMode::Repeat };
        // MTL's v runs upwards from the lower edge, the picture's downwards from the upper edge.
        let down = DAffine2::from_scale_angle_translation(DVec2::new(1.0, -1.0), 0.0, DVec2::Y);
        let place = DAffine2::from_scale_angle_translation(line.scale, 0.0, line.offset);
        Ok((
            WrappedTexture {
                picture,
                wrap: [wrap; 2],
            },
            down * place,
        ))
    }

    /// Returns the path of a file that the material names.
    fn path_of(&self, name: &str) -> std::result::Result<PathBuf, String> {
        let base = self.file.parent().unwrap_or(Path::new(""));
        // Files from Windows separate folders by backslashes.
        file::path_below(&self.folder, base, &name.replace('\\', "/"))
    }

    /// Returns the file of the texture of colour `k`.
    pub fn texture_file(&self, k: usize) -> Option<PathBuf> {
        let line = TextureLine::parse(self.maps[k].as_deref()?).ok()?;
        self.path_of(line.name).ok()
    }

    /// Returns whether the material has neither `Kd` nor `Ke`, nor a texture for one of them.
    pub fn is_blank(&self) -> bool {
        self.factors == [None; 2] && self.maps.iter().all(Option::is_none)
    }
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
    fn parse(line: &'l str) -> std::result::Result<Self, String> {
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
    fn parse_vector(&mut self, option: &str, first: &str, other: f64) -> std::result::Result<DVec2, String> {
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
