//! Reads back what a solve wrote, or a file of the same layout from elsewhere: the faces of
//! `result.json` and the texels of `lightmap.exr`, and nothing of how they came about.

use crate::error::{Error, Result};
use crate::mesh::MAX_TEXELS;
use crate::scene::Scene;
use crate::solution::faces::{Entry, faces, label};
use crate::solution::pixels::Planes;
use crate::texel;
use glam::{DVec3, Vec3};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Channels that are kept when all three colours of them are there.
const KEPT: [&str; 5] = ["residual", "irradiance", "reflectance", "emission", "error"];

/// Faces with texels, as stored in a directory.
///
/// Texels are counted face after face, within a face row-major in its rectangle: texel `i` of
/// face `k` is entry `texels(k).start + i`. All values are finite.
#[derive(Clone, Debug)]
pub struct Stored {
    /// Where it was read.
    pub dir: PathBuf,
    /// The faces; reflectance is 0 where the file has none.
    pub scene: Scene,
    /// Texels W×H of each face (N×N on a triangle).
    pub resolutions: Vec<[u32; 2]>,
    /// B, W/m².
    pub radiosity: Vec<Vec3>,
    /// E, W/m²: the channels `emission.*`, or else the face's.
    pub emission: Vec<Vec3>,
    /// What else there is of `residual`, `irradiance`, `reflectance` and `error`.
    pub others: BTreeMap<&'static str, Vec<Vec3>>,
    first: Vec<usize>,
}

#[derive(Deserialize)]
struct Description {
    scene: Option<String>,
    faces: Vec<Entry>,
}

impl Stored {
    /// Reads `dir`/result.json and `dir`/lightmap.exr.
    ///
    /// Errors: a file that is missing, damaged or cut short, a face without geometry or with a
    /// rectangle outside the image, a missing channel, a value that is not finite; each names
    /// the file and the face.
    pub fn read(dir: &Path) -> Result<Self> {
        let path = dir.join("result.json");
        let description = describe(&path)?;
        let mut first = vec![0];
        for (k, entry) in description.faces.iter().enumerate() {
            check(entry).map_err(|message| Error::input(&path, label(k), message))?;
            let texels = u64::from(entry.texels[0]) * u64::from(entry.texels[1]);
            let end = first[k] as u64 + texels;
            if end > MAX_TEXELS {
                return Err(Error::input(
                    &path,
                    label(k),
                    "too many texels in all faces",
                ));
            }
            first.push(end as usize);
        }
        let lightmap = Lightmap::read(dir, &description.faces)?;
        let mut others = BTreeMap::new();
        for name in KEPT {
            if let Some(values) = lightmap.values(&format!("{name}."))? {
                others.insert(name, values);
            }
        }
        let radiosity = lightmap.values("")?.ok_or_else(|| {
            Error::input(
                &lightmap.path,
                "",
                "lacks a channel of R, G and B (radiosity)",
            )
        })?;
        let of_faces = |e: &Entry| vec![Vec3::from(e.emission); texel::count(e.texels) as usize];
        let emission = others
            .remove("emission")
            .unwrap_or_else(|| description.faces.iter().flat_map(of_faces).collect());
        Ok(Self {
            dir: dir.to_path_buf(),
            resolutions: description.faces.iter().map(|e| e.texels).collect(),
            scene: scene(dir, description),
            radiosity,
            emission,
            others,
            first,
        })
    }

    /// The entries of face `k`.
    pub fn texels(&self, k: usize) -> Range<usize> {
        self.first[k]..self.first[k + 1]
    }

    /// B − E of every texel in f64.
    pub fn reflected(&self) -> Vec<DVec3> {
        self.radiosity
            .iter()
            .zip(&self.emission)
            .map(|(b, e)| b.as_dvec3() - e.as_dvec3())
            .collect()
    }
}

fn describe(path: &Path) -> Result<Description> {
    let text = fs::read(path).map_err(|e| {
        let message = format!("cannot be read: {e}; a directory written by solve is needed");
        Error::input(path, "", message)
    })?;
    let description: Description = serde_json::from_slice(&text)
        .map_err(|e| Error::input(path, "", format!("is no description of a solve: {e}")))?;
    if description.faces.is_empty() {
        return Err(Error::input(path, "", "has no faces"));
    }
    Ok(description)
}

/// Whether a face is whole, and its rectangle in the image as large as its texels ask for.
fn check(entry: &Entry) -> std::result::Result<(), String> {
    entry.check()?;
    let [_, _, width, height] = rect(entry);
    let [w, h] = entry.texels;
    if [w, h] != [width, height] {
        return Err(format!(
            "{w}×{h} texels do not fit its rectangle of {width}×{height} pixels"
        ));
    }
    Ok(())
}

/// The face's rectangle; empty where the description has none.
fn rect(entry: &Entry) -> [u32; 4] {
    entry.rect.unwrap_or_default()
}

/// The image, and where each face's texels lie in it.
struct Lightmap<'a> {
    path: PathBuf,
    planes: Planes,
    faces: &'a [Entry],
}

impl<'a> Lightmap<'a> {
    fn read(dir: &Path, faces: &'a [Entry]) -> Result<Self> {
        let path = dir.join("lightmap.exr");
        // A packed atlas is nearly full; a much larger image has nothing to do with these faces.
        let texels: u64 = faces
            .iter()
            .map(|e| u64::from(texel::count(e.texels)))
            .sum();
        let planes = Planes::read(&path, 64 * texels + (1 << 16))?;
        for (k, entry) in faces.iter().enumerate() {
            let [x, y, w, h] = rect(entry).map(u64::from);
            if x + w > planes.width as u64 || y + h > planes.height as u64 {
                let message = format!(
                    "its rectangle ends at {}, {}, the image at {}, {}",
                    x + w,
                    y + h,
                    planes.width,
                    planes.height
                );
                return Err(Error::input(&path, label(k), message));
            }
        }
        Ok(Self {
            path,
            planes,
            faces,
        })
    }

    /// One colour per texel, or none when a channel is missing.
    fn values(&self, prefix: &str) -> Result<Option<Vec<Vec3>>> {
        let Some([r, g, b]) = self.planes.colours(prefix) else {
            return Ok(None);
        };
        let mut values = Vec::new();
        for (k, entry) in self.faces.iter().enumerate() {
            let [x, y, w, h] = rect(entry).map(|n| n as usize);
            for pixel in (0..h).flat_map(|j| (0..w).map(move |i| (x + i, y + j))) {
                let at = pixel.1 * self.planes.width + pixel.0;
                let value = Vec3::new(r[at], g[at], b[at]);
                if !value.is_finite() {
                    let message = format!(
                        "the channels {prefix}R, G, B are not finite at pixel {}, {}",
                        pixel.0, pixel.1
                    );
                    return Err(Error::input(&self.path, label(k), message));
                }
                values.push(value);
            }
        }
        Ok(Some(values))
    }
}

fn scene(dir: &Path, description: Description) -> Scene {
    Scene {
        name: description
            .scene
            .unwrap_or_else(|| dir.display().to_string()),
        faces: faces(&description.faces),
        notes: Vec::new(),
    }
}
