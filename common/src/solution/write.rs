//! Writes a solve: both files go to a temporary name first and are renamed when both are complete,
//! the description last; it holds the lightmap's checksum, so that a kill in between is seen.

use crate::energy::Energy;
use crate::error::{Error, Result};
use crate::mesh::{Mesh, MeshFace, Texel};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::shooting::{Field, Run};
use crate::solution::faces::describe;
use crate::solution::pending::{Pending, temporary};
use crate::solution::warning::Warning;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use glam::{DVec3, Vec3, Vec4};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::time::Instant;

/// The options that the matrix solver obeys.
const MATRIX_SETTINGS: [&str; 3] = ["texels", "visibility", "form-factor"];
/// Those that a solve to an error obeys beside it.
const ERROR_SETTINGS: [&str; 3] = MATRIX_SETTINGS;

/// The entry of `result.json` that ties it to its lightmap.
pub(crate) const CHECKSUM: &str = "lightmap_crc32";

/// CRC-32 (ISO 3309) of a file, eight hexadecimal digits.
pub(crate) fn checksum(bytes: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(bytes))
}

/// Wall-clock seconds of the phases before writing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seconds {
    /// Reading the scene.
    pub load: f64,
    /// Texels, BVH or device.
    pub prepare: f64,
    /// Shooting.
    pub solve: f64,
}

/// Everything that `result.json` tells.
pub struct Solution<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its texels.
    pub mesh: &'a Mesh,
    /// "cpu", "gpu" or "matrix".
    pub solver: &'a str,
    /// The GPU's name.
    pub adapter: Option<&'a str>,
    /// The options in force.
    pub settings: &'a Settings,
    /// The solve.
    pub run: &'a Run,
    /// How far it may be off from the truth, as far as that can be told: `error`, the relative RMS of
    /// B − E, and its parts; none: not looked at.
    pub certificate: Option<Value>,
    /// How far each texel may be off, W/m², written as `error.exr`; none: not known by texel.
    pub off: Option<Vec<f32>>,
    /// What may be wrong with the answer.
    pub warnings: &'a [Warning],
    /// Everything else worth saying.
    pub notes: &'a [String],
    /// What the matrix solver says of its accuracy; it has no shots and obeys none of their options.
    pub matrix: Option<Value>,
    /// The error that was asked for; a solve to an error chooses cells, samples and ε by itself.
    pub error: Option<f64>,
    /// What a relight says of itself; then ρ and E vary by texel.
    pub relit: Option<Value>,
    /// Phases.
    pub seconds: Seconds,
}

impl Solution<'_> {
    /// Whether ρ and E vary by texel, and are written as well.
    fn varies(&self) -> bool {
        self.relit.is_some() || self.scene.is_painted()
    }

    /// Writes its files into `dir`.
    pub fn write(&self, dir: &Path) -> Result<()> {
        let start = Instant::now();
        let mut files = Pending::default();
        let image = lightmap(self.mesh, &self.run.field, self.varies())?;
        files.add(&dir.join("lightmap.exr"), &image)?;
        match &self.off {
            Some(off) => files.add(&dir.join("error.exr"), &map(self.mesh, off)?)?,
            // An earlier solve's is not this one's.
            None => drop(fs::remove_file(dir.join("error.exr"))),
        }
        let mut description = self.summary();
        description["seconds"]["write"] = start.elapsed().as_secs_f64().into();
        description["faces"] = self.faces().into();
        description[CHECKSUM] = checksum(&image).into();
        files.add(
            &dir.join("result.json"),
            format!("{description:#}\n").as_bytes(),
        )?;
        files.finish()
    }

    /// What `result.json` has but for the faces and what only its writing tells.
    pub fn summary(&self) -> Value {
        let mut description = json!({
            "scene": self.scene.name,
            "solver": self.solver,
            "adapter": self.adapter,
            "settings": self.settings,
            "shots": self.run.shooters,
            "passes": self.run.passes,
            "converged": self.run.converged,
            "unshot_fraction": self.run.unshot_fraction(),
            "energy": Energy::new(self.mesh, &self.run.field, &self.run.shots),
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
        if let Some(matrix) = &self.matrix {
            description["matrix"] = matrix.clone();
            description["shots"] = 0.into();
            description["passes"] = 0.into();
            if let Some(settings) = description["settings"].as_object_mut() {
                settings.retain(|name, _| MATRIX_SETTINGS.contains(&name.as_str()));
            }
        }
        if let (Some(error), Some(settings)) = (self.error, description["settings"].as_object_mut())
        {
            settings.retain(|name, _| ERROR_SETTINGS.contains(&name.as_str()));
            settings.insert("error".into(), error.into());
        }
        let alike = |f: &MeshFace| f.resolution == [self.settings.meshing.texels; 2];
        if let (false, Some(settings)) = (
            self.mesh.faces.iter().all(alike),
            description["settings"].as_object_mut(),
        ) {
            // Each face says its own.
            settings.remove("texels");
        }
        if let (Some(Value::Object(relit)), Some(all)) =
            (self.relit.clone(), description.as_object_mut())
        {
            all.extend(relit);
        }
        description
    }

    fn faces(&self) -> Vec<Value> {
        let means = self.varies().then(|| means(self.mesh));
        self.scene
            .faces
            .iter()
            .zip(&self.mesh.faces)
            .enumerate()
            .map(|(k, (face, mesh))| {
                let mut entry = describe(face, mesh.resolution);
                entry["rect"] = json!(mesh.rect);
                if let Some([emission, reflectance]) = means.as_ref().map(|means| means[k]) {
                    entry["emission"] = json!(emission);
                    entry["reflectance"] = json!(reflectance);
                }
                entry
            })
            .collect()
    }
}

/// Mean E and ρ of each face's texels.
fn means(mesh: &Mesh) -> Vec<[[f32; 3]; 2]> {
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

/// Makes sure that `dir` exists and takes files, before any long work.
pub fn prepare(dir: &Path) -> Result<()> {
    let fail = |source| Error::Write {
        path: dir.to_path_buf(),
        source,
    };
    fs::create_dir_all(dir).map_err(fail)?;
    let probe = temporary(&dir.join(".radiosity-probe"));
    fs::write(&probe, b"").map_err(fail)?;
    fs::remove_file(&probe).map_err(fail)
}

/// Writes `bytes` under a temporary name and renames it to `path`.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut file = Pending::default();
    file.add(path, bytes)?;
    file.finish()
}

/// The atlas as lossless 32-bit float EXR, with ρ and E of the texels if `surface` is asked for;
/// pixels that belong to no face are 0.
pub fn lightmap(mesh: &Mesh, field: &Field, surface: bool) -> Result<Vec<u8>> {
    let [w, h] = mesh.atlas.map(|n| n as usize);
    let mut channels = Vec::new();
    let of = |value: fn(&Texel) -> Vec3| -> Vec<Vec4> {
        mesh.texels.iter().map(|t| value(t).extend(0.0)).collect()
    };
    let (reflectance, emission) = (of(|t| t.reflectance), of(|t| t.emission));
    let planes = [
        ("", &field.radiosity),
        ("residual.", &field.residual),
        ("irradiance.", &field.irradiance),
        ("reflectance.", &reflectance),
        ("emission.", &emission),
    ];
    for (prefix, values) in planes.into_iter().take(if surface { 5 } else { 3 }) {
        for (c, letter) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push((format!("{prefix}{letter}"), atlas_channel(mesh, values, c)));
        }
    }
    encode([w, h], channels).map_err(|source| Error::Write {
        path: "lightmap.exr".into(),
        source,
    })
}

/// A value of each texel on the atlas, as EXR of one channel; pixels that belong to no face are 0.
fn map(mesh: &Mesh, values: &[f32]) -> Result<Vec<u8>> {
    let values: Vec<Vec4> = values.iter().map(|v| Vec4::splat(*v)).collect();
    let size = mesh.atlas.map(|n| n as usize);
    let plane = ("Y".to_owned(), atlas_channel(mesh, &values, 0));
    encode(size, vec![plane]).map_err(|source| Error::Write {
        path: "error.exr".into(),
        source,
    })
}

/// Named planes of `size` (width, height) as lossless 32-bit float EXR.
///
/// Errors: what the encoder has to say.
pub fn encode(size: [usize; 2], planes: Vec<(String, Vec<f32>)>) -> std::io::Result<Vec<u8>> {
    let channel =
        |(name, values): (String, _)| AnyChannel::new(name.as_str(), FlatSamples::F32(values));
    let layer = Layer::new(
        Vec2(size[0], size[1]),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(planes.into_iter().map(channel).collect()),
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| std::io::Error::other(error.to_string()))?;
    Ok(bytes.into_inner())
}

/// One channel of `values` on the atlas, row-major.
pub fn atlas_channel(mesh: &Mesh, values: &[Vec4], channel: usize) -> Vec<f32> {
    let mut pixels = vec![0.0; (mesh.atlas[0] * mesh.atlas[1]) as usize];
    for (texel, value) in mesh.texels.iter().zip(values) {
        pixels[texel.pixel as usize] = value[channel];
    }
    pixels
}
