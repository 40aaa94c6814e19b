//! Reading of stored solutions: the faces of `result.json` and the texels of `lightmap.exr`, written by a
//! solve or, in the same layout, by another program.

use crate::error::{Error, Result};
use crate::file::{self, file_checksum};
use crate::scene::Scene;
use crate::solution::faces::{Description, FaceEntry, build_scene, face_label, is_in_range, is_reflectance};
use crate::solution::pending::locate_file;
use crate::solution::pixels::ImagePlanes;
use crate::texel;
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Channels that are read if all three of their colours exist.
const KEPT_CHANNELS: [&str; 6] = ["residual", "irradiance", "reflectance", "emission", "error", "sky"];

/// A solution that was read from a directory: faces with texels.
///
/// Texels are in face order, within a face row-major in its rectangle: texel `i` of face `k` is entry
/// `texels(k).start + i`. All values are finite.
#[derive(Clone, Debug)]
pub struct StoredSolution {
    /// Directory that it was read from.
    pub dir: PathBuf,
    /// The faces; reflectance is 0 where the file has none.
    pub scene: Scene,
    /// Texels W×H of each face (N×N on a triangle).
    pub resolutions: Vec<[u32; 2]>,
    /// B, W/m².
    pub radiosity: Vec<Vec3>,
    /// E, W/m²: the channels `emission.*`, or else the face's.
    pub emission: Vec<Vec3>,
    /// Other channels, of `residual`, `irradiance`, `reflectance`, `error` and `sky`.
    pub others: BTreeMap<&'static str, Vec<Vec3>>,
    first: Vec<usize>,
}

impl StoredSolution {
    /// Reads `dir`/result.json and `dir`/lightmap.exr.
    ///
    /// Errors: a file that is missing, damaged or truncated, a face without geometry or with a rectangle outside the
    /// image, a missing channel, a value that is not finite; each message names the file and the face.
    pub fn read(dir: &Path) -> Result<Self> {
        let path = locate_file(dir, "result.json");
        let description = Description::read(&path, "solve", "a directory written by solve is needed")?;
        let faces = &description.faces;
        let lightmap = Lightmap::read(dir, &path, &description)?;
        let mut others = BTreeMap::new();
        for name in KEPT_CHANNELS {
            if let Some(values) = lightmap.channel_values(&format!("{name}."))? {
                others.insert(name, values);
            }
        }
        let radiosity = lightmap
            .channel_values("")?
            .ok_or_else(|| Error::bad_input(&lightmap.path, "", "lacks a channel of R, G and B (radiosity)"))?;
        let resolutions: Vec<[u32; 2]> = faces.iter().map(|e| e.texels).collect();
        let first = texel::first_texels(&resolutions);
        let reflectances = others.get("reflectance").into_iter().flatten().enumerate();
        if let Some((texel, rho)) = { reflectances }.find(|(_, rho)| !is_reflectance(**rho)) {
            let face = first.partition_point(|start| *start <= texel) - 1;
            let message = format!("the channels reflectance.R, G, B hold {rho}, not at least 0 and below 1");
            return Err(Error::bad_input(&lightmap.path, face_label(face), message));
        }
        let emission = match others.remove("emission") {
            Some(emission) => emission,
            None => face_emission(&path, faces)?,
        };
        let unknown = format!(
            "{} has no lightmap_crc32: it is not known whether lightmap.exr belongs to it",
            path.display()
        );
        let name = description.scene.clone();
        let mut scene = build_scene(&path, &name.unwrap_or_else(|| dir.display().to_string()), faces)?;
        scene
            .notes
            .extend(description.lightmap_crc32.is_none().then_some(unknown));
        Ok(Self {
            dir: dir.to_path_buf(),
            resolutions,
            scene,
            radiosity,
            emission,
            others,
            first,
        })
    }

    /// Makes a solution from another solver's answer in memory: `resolutions[k]` texels on face k of
    /// `scene` and the radiosity of all texels, in the order above.
    ///
    /// Errors: [`Error::Usage`] of counts that do not fit or values that are not finite.
    pub fn from_radiosity(scene: Scene, resolutions: Vec<[u32; 2]>, radiosity: Vec<Vec3>) -> Result<Self> {
        let usage = |message| Err(Error::Usage(format!("{}: {message}", scene.name)));
        if resolutions.len() != scene.faces.len() {
            return usage("one resolution is needed for each face");
        }
        let first = texel::first_texels(&resolutions);
        if first.last() != Some(&radiosity.len()) {
            return usage("one radiosity is needed for each texel");
        }
        if !radiosity.iter().all(|b| b.is_finite()) {
            return usage("its radiosity is not finite");
        }
        let texels = |k: usize| std::iter::repeat_n(scene.faces[k].emission, first[k + 1] - first[k]);
        Ok(Self {
            dir: PathBuf::from(&scene.name),
            emission: (0..resolutions.len()).flat_map(texels).collect(),
            scene,
            resolutions,
            radiosity,
            others: BTreeMap::new(),
            first,
        })
    }

    /// Returns the entries of face `k`.
    pub fn texel_range(&self, k: usize) -> Range<usize> {
        self.first[k]..self.first[k + 1]
    }

    /// Returns B − E of every texel in f64.
    pub fn reflected_radiosity(&self) -> Vec<DVec3> {
        let texels = self.radiosity.iter().zip(&self.emission);
        texels.map(|(b, e)| b.as_dvec3() - e.as_dvec3()).collect()
    }
}

/// Returns the emission of every texel from its face. A face's emission must not be negative; only the
/// emission by texel, which a capture writes, may be.
fn face_emission(path: &Path, faces: &[FaceEntry]) -> Result<Vec<Vec3>> {
    let mut emission = Vec::new();
    for (k, entry) in faces.iter().enumerate() {
        entry
            .check_emission()
            .map_err(|message| Error::bad_input(path, face_label(k), message))?;
        let texels = texel::texel_count(entry.texels) as usize;
        emission.extend(std::iter::repeat_n(Vec3::from(entry.emission), texels));
    }
    Ok(emission)
}

/// The lightmap's image, and the faces with their rectangles in it.
struct Lightmap<'a> {
    path: PathBuf,
    planes: ImagePlanes,
    faces: &'a [FaceEntry],
}

impl<'a> Lightmap<'a> {
    /// Reads the lightmap in `dir` of the description at `beside`, and checks the faces' rectangles.
    fn read(dir: &Path, beside: &Path, description: &'a Description) -> Result<Self> {
        let faces = description.faces.as_slice();
        for (k, entry) in faces.iter().enumerate() {
            let ([w, h], [_, _, width, height]) = (entry.texels, entry.rect.unwrap_or_default());
            if [w, h] != [width, height] {
                let message = format!("{w}×{h} texels do not fit its rectangle of {width}×{height} pixels");
                return Err(Error::bad_input(beside, face_label(k), message));
            }
        }
        let path = locate_file(dir, "lightmap.exr");
        let bytes = file::read_input(&path, "")?;
        // A packed atlas is nearly full; a much larger image does not belong to these faces.
        let texels: u64 = faces.iter().map(|e| u64::from(texel::texel_count(e.texels))).sum();
        let planes = ImagePlanes::decode(&path, &bytes, 64 * texels + (1 << 16))?;
        if let Some(wanted) = &description.lightmap_crc32
            && *wanted != file_checksum(&bytes)
        {
            let message = "this and result.json are not of one solve (its lightmap_crc32 is another file's): solve again, or remove that entry if the lightmap was changed on purpose";
            return Err(Error::bad_input(&path, "", message));
        }
        for (k, entry) in faces.iter().enumerate() {
            let [x, y, w, h] = entry.rect.unwrap_or_default().map(u64::from);
            let (right, bottom) = (x + w, y + h);
            let (width, height) = (planes.width, planes.height);
            if right > width as u64 || bottom > height as u64 {
                let message = format!("its rectangle ends at {right}, {bottom}, the image at {width}, {height}");
                return Err(Error::bad_input(&path, face_label(k), message));
            }
        }
        Ok(Self { path, planes, faces })
    }

    /// Returns one colour per texel, or none if a channel is missing.
    ///
    /// Errors: a value that is not finite or too large.
    fn channel_values(&self, prefix: &str) -> Result<Option<Vec<Vec3>>> {
        let Some([r, g, b]) = self.planes.colour_planes(prefix) else {
            return Ok(None);
        };
        let mut values = Vec::new();
        for (k, entry) in self.faces.iter().enumerate() {
            let [x, y, w, h] = entry.rect.unwrap_or_default().map(|n| n as usize);
            for (x, y) in (y..y + h).flat_map(|y| (x..x + w).map(move |x| (x, y))) {
                let at = y * self.planes.width + x;
                let value = Vec3::new(r[at], g[at], b[at]);
                if !is_in_range(value) {
                    let message = format!("the channels {prefix}R, G, B are not finite or too large at pixel {x}, {y}");
                    return Err(Error::bad_input(&self.path, face_label(k), message));
                }
                values.push(value);
            }
        }
        Ok(Some(values))
    }
}
