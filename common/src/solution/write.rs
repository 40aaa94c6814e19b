//! Writing of a solution. Its files appear together ([`super::pending`]); the description lists them with their checksums.

use crate::energy::EnergyBalance;
use crate::error::{Error, Result};
use crate::file::file_checksum;
use crate::mesh::{Mesh, MeshFace, Texel};
use crate::scene::{Face, Scene};
use crate::settings::Settings;
use crate::shooting::{RadiosityField, SolveRun};
use crate::solution::faces::FaceEntry;
use crate::solution::pending::{NamedBytes, PendingFiles};
use crate::solution::warning::Warning;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2, WritableImage,
};
use glam::{DVec3, Vec3, Vec4};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// Options that the dense solver reads, and a solve to an error besides the error.
const MATRIX_SETTINGS: [&str; 3] = ["texels", "visibility", "form-factor"];

/// Wall-clock seconds of the phases before writing.
#[derive(Clone, Copy, Debug, Default)]
pub struct PhaseSeconds {
    /// Reading the scene.
    pub load: f64,
    /// Texels, BVH or device.
    pub prepare: f64,
    /// Shooting.
    pub solve: f64,
}

/// Content of `result.json` and of the files beside it.
pub struct Solution<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// "cpu", "gpu" or "dense".
    pub solver: &'a str,
    /// The GPU's name.
    pub adapter: Option<&'a str>,
    /// The options in force.
    pub settings: &'a Settings,
    /// The solve.
    pub run: &'a SolveRun,
    /// Share of each texel that no body covers; none if not known.
    pub open: Option<&'a [f32]>,
    /// Error estimate: `error`, the relative RMS error of B − E, and its parts; none if not estimated.
    pub certificate: Option<Value>,
    /// Error estimate of each texel, W/m², written as `error.exr`; none if not known by texel.
    pub texel_error: Option<Vec<f32>>,
    /// Warnings about the solution.
    pub warnings: &'a [Warning],
    /// Other notes.
    pub notes: &'a [String],
    /// Accuracy report of the dense solver, which has no shots and none of their options.
    pub matrix: Option<Value>,
    /// Requested error; a solve to an error chooses patches, samples and ε itself.
    pub error: Option<f64>,
    /// Report of a relighting; with it ρ and E vary by texel.
    pub relit: Option<Value>,
    /// Seconds of the phases.
    pub seconds: PhaseSeconds,
}

impl Solution<'_> {
    /// Returns whether ρ and E vary by texel, and are written too.
    fn has_texel_surfaces(&self) -> bool {
        self.relit.is_some() || self.scene.is_painted()
    }

    /// Writes the files into `dir`.
    ///
    /// Errors: [`Error::Write`] with the file.
    pub fn write(&self, dir: &Path) -> Result<()> {
        let mut files = PendingFiles::default();
        self.add_files(dir, || Ok(Vec::new()), &mut files)?;
        files.write()
    }

    /// Adds the files in `dir` to `files`, with `others` of the same result, which are made meanwhile.
    ///
    /// Errors: those of [`encode_exr`], and of `others`.
    pub fn add_files(
        &self,
        dir: &Path,
        others: impl FnOnce() -> Result<Vec<NamedBytes>> + Send,
        files: &mut PendingFiles,
    ) -> Result<()> {
        let start = Instant::now();
        let (maps, others) = rayon::join(|| self.encode_maps(), others);
        let mut all = maps?;
        all.extend(others?);
        let checksums = all.iter().map(|(name, bytes)| (name.as_str(), file_checksum(bytes)));
        let checksums: BTreeMap<&str, String> = checksums.collect();
        let mut description = self.summarise_run();
        description["seconds"]["write"] = start.elapsed().as_secs_f64().into();
        description["faces"] = json!(self.describe_faces());
        description["lightmap_crc32"] = json!(checksums["lightmap.exr"]);
        description["files"] = json!(checksums);
        all.push(("result.json".to_owned(), format!("{description:#}\n").into_bytes()));
        all.into_iter().for_each(|(name, bytes)| files.add(dir, name, bytes));
        Ok(())
    }

    /// Encodes `lightmap.exr`, and `error.exr` where the error is known by texel.
    fn encode_maps(&self) -> Result<Vec<NamedBytes>> {
        let image = encode_lightmap(self.mesh, &self.run.field, self.has_texel_surfaces())?;
        let mut maps = vec![("lightmap.exr".to_owned(), image)];
        if let Some(off) = &self.texel_error {
            let values: Vec<Vec4> = off.iter().map(|v| Vec4::splat(*v)).collect();
            let plane = ("Y".to_owned(), atlas_channel(self.mesh, &values, 0));
            maps.push(("error.exr".to_owned(), encode_exr(self.mesh.atlas, vec![plane])?));
        }
        Ok(maps)
    }

    /// Returns `result.json` without the faces and the entries that are known after writing.
    pub fn summarise_run(&self) -> Value {
        let mut description = json!({
            "scene": self.scene.name,
            "solver": self.solver,
            "adapter": self.adapter,
            "shots": self.run.shooters,
            "passes": self.run.passes,
            "converged": self.run.converged,
            "unshot_fraction": self.run.unshot_fraction(),
            "energy": EnergyBalance::new(self.mesh, &self.run.field, &self.run.shots),
            "estimated_error": self.certificate.as_ref().map(|parts| &parts["error"]),
            "certificate": self.certificate,
            "warnings": self.warnings,
            "notes": self.notes,
            "seconds": {
                "load": self.seconds.load,
                "prepare": self.seconds.prepare,
                "solve": self.seconds.solve,
            },
        });
        let mut settings = json!(self.settings);
        if let Some(all) = settings.as_object_mut() {
            if self.matrix.is_some() || self.error.is_some() {
                all.retain(|name, _| MATRIX_SETTINGS.contains(&name.as_str()));
            }
            if let Some(error) = self.error {
                all.insert("error".into(), error.into());
            }
            let texels = [self.settings.meshing.texels; 2];
            if self.mesh.faces.iter().any(|f| f.resolution != texels) {
                // Each face has its own entry.
                all.remove("texels");
            }
        }
        if let Some(sky) = &self.scene.sky {
            settings["sky"] = sky.source.clone().into();
            let suns = sky.suns.iter();
            let suns = suns.map(|sun| json!({ "direction": sun.direction, "irradiance": sun.irradiance }));
            settings["suns"] = suns.collect();
        }
        description["settings"] = settings;
        if let Some(matrix) = &self.matrix {
            description["matrix"] = matrix.clone();
            description["shots"] = 0.into();
            description["passes"] = 0.into();
        }
        if let (Some(Value::Object(relit)), Some(all)) = (self.relit.clone(), description.as_object_mut()) {
            all.extend(relit);
        }
        description
    }

    fn describe_faces(&self) -> Vec<FaceEntry> {
        let means = self.has_texel_surfaces().then(|| face_means(self.mesh));
        let faces = self.scene.faces.iter().zip(&self.mesh.faces).enumerate();
        let describe = |(k, (face, mesh)): (usize, (&Face, &MeshFace))| {
            let mut entry = FaceEntry::new(face, mesh.resolution);
            entry.rect = Some(mesh.rect);
            if let Some(means) = &means {
                [entry.emission, entry.reflectance] = means[k];
            }
            entry
        };
        faces.map(describe).collect()
    }
}

/// Returns the mean E and ρ of each face's texels.
fn face_means(mesh: &Mesh) -> Vec<[[f32; 3]; 2]> {
    let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, 0.0f64); mesh.faces.len()];
    for texel in &mesh.texels {
        let (sum, area) = (&mut sums[texel.face as usize], f64::from(texel.area));
        sum.0 += texel.emission.as_dvec3() * area;
        sum.1 += texel.reflectance.as_dvec3() * area;
        sum.2 += area;
    }
    let mean = |sum: DVec3, area: f64| (sum / area.max(f64::MIN_POSITIVE)).as_vec3().to_array();
    sums.into_iter()
        .map(|(emission, reflectance, area)| [mean(emission, area), mean(reflectance, area)])
        .collect()
}

/// Encodes the atlas as lossless 32-bit float EXR, with ρ and E of the texels if `surface` is true, and with the
/// irradiance from outside if there is any; pixels outside all faces are 0.
pub fn encode_lightmap(mesh: &Mesh, field: &RadiosityField, surface: bool) -> Result<Vec<u8>> {
    let mut channels = Vec::new();
    let of = |value: fn(&Texel) -> Vec3| -> Vec<Vec4> { mesh.texels.iter().map(|t| value(t).extend(0.0)).collect() };
    let (reflectance, emission, sky) = (of(|t| t.reflectance), of(|t| t.emission), of(|t| t.sky));
    let outside = sky.iter().any(|h| *h != Vec4::ZERO).then_some(("sky.", &sky));
    let planes = [
        ("", &field.radiosity),
        ("residual.", &field.residual),
        ("irradiance.", &field.irradiance),
        ("reflectance.", &reflectance),
        ("emission.", &emission),
    ];
    for (prefix, values) in planes.into_iter().take(if surface { 5 } else { 3 }).chain(outside) {
        for (c, letter) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push((format!("{prefix}{letter}"), atlas_channel(mesh, values, c)));
        }
    }
    encode_exr(mesh.atlas, channels)
}

/// Encodes named planes of `size` (width, height) as lossless 32-bit float EXR.
///
/// Errors: [`Error::Fault`] if their lengths are not that of the size.
pub fn encode_exr(size: [u32; 2], planes: Vec<(String, Vec<f32>)>) -> Result<Vec<u8>> {
    encode_image(size, planes, Encoding::SMALL_LOSSLESS)
}

/// Encodes as [`encode_exr`] does, but by run lengths: in a twentieth of the time, and a fifth larger where a picture has noise.
///
/// Errors: those of [`encode_exr`].
pub fn encode_exr_fast(size: [u32; 2], planes: Vec<(String, Vec<f32>)>) -> Result<Vec<u8>> {
    let run_lengths = Encoding {
        compression: Compression::RLE,
        ..Encoding::SMALL_LOSSLESS
    };
    encode_image(size, planes, run_lengths)
}

fn encode_image(size: [u32; 2], planes: Vec<(String, Vec<f32>)>, encoding: Encoding) -> Result<Vec<u8>> {
    let channel = |(name, values): (String, _)| AnyChannel::new(name.as_str(), FlatSamples::F32(values));
    let layer = Layer::new(
        Vec2(size[0] as usize, size[1] as usize),
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(planes.into_iter().map(channel).collect()),
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().to_buffered(&mut bytes);
    written.map_err(|error| Error::Fault(format!("an EXR cannot be encoded: {error}")))?;
    Ok(bytes.into_inner())
}

/// Returns one channel of `values` on the atlas, row-major.
pub fn atlas_channel(mesh: &Mesh, values: &[Vec4], channel: usize) -> Vec<f32> {
    let mut pixels = vec![0.0; (mesh.atlas[0] * mesh.atlas[1]) as usize];
    for (texel, value) in mesh.texels.iter().zip(values) {
        pixels[texel.pixel as usize] = value[channel];
    }
    pixels
}
