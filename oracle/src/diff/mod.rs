//! Compares result A with result B as the truth: reflected radiosity B − E, area-weighted.
//!
//! [`reflected`] extracts B − E, [`pair`] averages both results on a common grid, [`difference`] measures.

pub mod difference;
pub mod pair;
pub mod reflected;

use common::scene::Scene;
use common::solution::StoredSolution;
use common::{Error, Result};
use difference::{channel_differences, worst_channel};
use glam::DVec3;
use pair::GridPair;
use reflected::ReflectedField;
use serde::Serialize;
use serde_json::{Value, json};
use std::fs::canonicalize;

/// Difference of result A from result B.
#[derive(Clone, Debug)]
pub struct Diff {
    /// √(ΣA(a−b)² / ΣA b²) per channel; infinite where only B is black.
    pub relative_rms: [f64; 3],
    /// ΣA(a−b) / ΣA b per channel.
    pub bias: [f64; 3],
    /// max|a−b| / rms(b), the worst channel.
    pub max_relative: f64,
    /// √(ΣA e² / ΣA b²) per channel of the truth's own standard errors e.
    pub standard_error: Option<[f64; 3]>,
    /// Difference of each face, in file order.
    pub faces: Vec<FaceDiff>,
    /// Both results on the common grid.
    pub pair: GridPair,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Difference of one face.
#[derive(Clone, Debug, Serialize)]
pub struct FaceDiff {
    /// Index in the file.
    pub face: usize,
    /// Name in the file.
    pub name: String,
    /// Texels W×H of the common grid.
    pub texels: [u32; 2],
    /// Area, scene units squared.
    pub area: f64,
    /// Share of Σ A(a−b)² over all faces and channels.
    pub share: f64,
    /// √(ΣA(a−b)² / ΣA b²) over the face, the worst channel.
    pub relative_rms: f64,
    /// ΣA(a−b) / ΣA b over the face, the channel with the largest magnitude.
    pub bias: f64,
}

impl Diff {
    /// Compares A against B.
    ///
    /// Errors: A and B are not results of one scene.
    pub fn new(a: &StoredSolution, b: &StoredSolution) -> Result<Self> {
        let error = b.others.get("error");
        let error: Option<Vec<DVec3>> = error.map(|e| e.iter().map(|v| v.as_dvec3()).collect());
        let pair = GridPair::new(&a.into(), &ReflectedField::from(b), error.as_deref()).map_err(|m| {
            let place = m.face.map_or(String::new(), |k| format!("face {k}"));
            let message = format!("{} ({})", m.message, b.dir.display());
            Error::bad_input(a.dir.join("result.json"), place, message)
        })?;
        let all = 0..pair.areas.len();
        let found = channel_differences(pair.weighted_texels(all.clone()));
        let standard_error = pair.error.as_ref().map(|error| {
            let of_error = |k: usize| (pair.areas[k], pair.b[k] + error[k], pair.b[k]);
            channel_differences(all.map(of_error)).map(|d| d.relative_rms)
        });
        let mut diff = Self {
            relative_rms: found.map(|d| d.relative_rms),
            bias: found.map(|d| d.bias),
            max_relative: worst_channel(found).max_relative,
            standard_error,
            faces: face_differences(&pair, &b.scene),
            pair,
            notes: Vec::new(),
        };
        diff.notes = diff.collect_notes(a, b);
        Ok(diff)
    }

    /// Returns the worst channel's relative RMS.
    pub fn worst_rms(&self) -> f64 {
        self.relative_rms.into_iter().fold(0.0, f64::max)
    }

    fn collect_notes(&self, a: &StoredSolution, b: &StoredSolution) -> Vec<String> {
        let mut notes = [a, b].map(|stored| stored.scene.notes.clone()).concat();
        if let Some(how) = same_data(a, b) {
            notes.push(format!("A and B are the same data ({how})"));
        }
        let lights = a.scene.faces.iter().zip(&b.scene.faces);
        let unlike = lights.filter(|(a, b)| a.emission != b.emission).count();
        if unlike > 0 {
            notes.push(format!(
                "{unlike} faces emit differently in A and B; each result's own emission is subtracted from it"
            ));
        }
        if self.pair.cut > 0 {
            notes.push(format!(
                "on {} faces the texels of A and B share no useful grid: finer texels were cut and taken as constant",
                self.pair.cut
            ));
        }
        if self.relative_rms.iter().any(|x| x.is_infinite()) {
            notes.push("B reflects nothing in a channel in which A does".into());
        }
        notes
    }

    /// Returns the contract's four figures and further ones for scripts; infinity is null.
    pub fn to_json(&self, a: &StoredSolution, b: &StoredSolution, flip: Option<f64>) -> Value {
        json!({
            "relative_rms": self.relative_rms,
            "bias": self.bias,
            "max_relative": self.max_relative,
            "flip": flip,
            "a": a.dir.display().to_string(),
            "b": b.dir.display().to_string(),
            "identical": same_data(a, b).is_some(),
            "standard_error": self.standard_error,
            "texels": { "a": a.radiosity.len(), "b": b.radiosity.len(), "compared": self.pair.areas.len() },
            "notes": self.notes,
            "faces": self.faces,
        })
    }
}

fn face_differences(pair: &GridPair, scene: &Scene) -> Vec<FaceDiff> {
    let square = |k: usize| pair.areas[k] * (pair.a[k] - pair.b[k]).length_squared();
    let total: f64 = (0..pair.areas.len()).map(square).sum();
    let face = |k: usize| {
        let texels = pair.first[k]..pair.first[k + 1];
        let part: f64 = texels.clone().map(square).sum();
        let worst = worst_channel(channel_differences(pair.weighted_texels(texels.clone())));
        FaceDiff {
            face: k,
            name: scene.faces[k].name.clone(),
            texels: pair.resolutions[k],
            area: pair.areas[texels].iter().sum(),
            share: if part == 0.0 { 0.0 } else { part / total },
            relative_rms: worst.relative_rms,
            bias: worst.bias,
        }
    };
    (0..pair.resolutions.len()).map(face).collect()
}

/// Returns the reason if A and B are the same result: one directory, or equal bits.
pub fn same_data(a: &StoredSolution, b: &StoredSolution) -> Option<&'static str> {
    let place = |stored: &StoredSolution| canonicalize(&stored.dir).ok();
    if place(a).is_some() && place(a) == place(b) {
        return Some("one directory");
    }
    // B and E, from which the compared B − E follows.
    let bits = |stored: &StoredSolution| -> Vec<[u32; 3]> {
        let values = stored.radiosity.iter().chain(&stored.emission);
        values.map(|v| v.to_array().map(f32::to_bits)).collect()
    };
    let equal = a.resolutions == b.resolutions && bits(a) == bits(b);
    equal.then_some("every texel equal bit for bit")
}
