//! Two results compared: A against B as the truth, reflected part B − E, area-weighted.
//!
//! [`reflected`] takes what is compared, [`pair`] brings both to one grid, this module measures,
//! [`pictures`] draws both through one camera, [`flip`] asks what an eye would see of the
//! difference, [`page`] tells.

pub mod around;
pub mod flip;
pub mod page;
pub mod pair;
pub mod pictures;
pub mod reflected;

use crate::judge::compare::difference::{channels, worst};
use common::scene::Scene;
use common::solution::Stored;
use common::{Error, Result};
use glam::DVec3;
use pair::Pair;
use reflected::Reflected;
use serde::Serialize;
use serde_json::{Value, json};
use std::fs::canonicalize;

/// How far A is from B.
#[derive(Clone, Debug)]
pub struct Diff {
    /// √(ΣA(a−b)² / ΣA b²) per channel; infinite where only B is black.
    pub relative_rms: [f64; 3],
    /// ΣA(a−b) / ΣA b per channel.
    pub bias: [f64; 3],
    /// max|a−b| / rms(b), the worst channel.
    pub max_relative: f64,
    /// √(ΣA e² / ΣA b²) of the truth's own standard errors e.
    pub standard_error: Option<[f64; 3]>,
    /// Each face's part, in file order.
    pub faces: Vec<FaceDiff>,
    /// Both on the common grid.
    pub pair: Pair,
    /// What is worth saying.
    pub notes: Vec<String>,
}

/// One face's part in the difference.
#[derive(Clone, Debug, Serialize)]
pub struct FaceDiff {
    /// Its place in the file.
    pub face: usize,
    /// As the file calls it.
    pub name: String,
    /// The common grid on it.
    pub texels: [u32; 2],
    /// Scene units squared.
    pub area: f64,
    /// Its share of Σ A(a−b)² over all faces and channels.
    pub share: f64,
    /// √(ΣA(a−b)² / ΣA b²) over the face, the worst channel.
    pub relative_rms: f64,
    /// ΣA(a−b) / ΣA b over the face, the channel with the largest magnitude.
    pub bias: f64,
}

impl Diff {
    /// Compares A against B.
    ///
    /// Errors: the two are not results of one scene.
    pub fn new(a: &Stored, b: &Stored) -> Result<Self> {
        let error = b.others.get("error");
        let error: Option<Vec<DVec3>> = error.map(|e| e.iter().map(|v| v.as_dvec3()).collect());
        let pair = Pair::new(&a.into(), &Reflected::from(b), error.as_deref()).map_err(|m| {
            let place = m.face.map_or(String::new(), |k| format!("face {k}"));
            let message = format!("{} ({})", m.message, b.dir.display());
            Error::input(a.dir.join("result.json"), place, message)
        })?;
        let all = 0..pair.areas.len();
        let found = channels(pair.texels(all.clone()));
        let standard_error = pair.error.as_ref().map(|error| {
            let of_error = |k: usize| (pair.areas[k], pair.b[k] + error[k], pair.b[k]);
            channels(all.map(of_error)).map(|d| d.relative_rms)
        });
        let mut diff = Self {
            relative_rms: found.map(|d| d.relative_rms),
            bias: found.map(|d| d.bias),
            max_relative: worst(found).max_relative,
            standard_error,
            faces: faces(&pair, &b.scene),
            pair,
            notes: Vec::new(),
        };
        diff.notes = diff.remarks(a, b);
        Ok(diff)
    }

    /// The worst channel's relative RMS.
    pub fn worst(&self) -> f64 {
        self.relative_rms.into_iter().fold(0.0, f64::max)
    }

    fn remarks(&self, a: &Stored, b: &Stored) -> Vec<String> {
        let mut notes = [a, b].map(|stored| stored.scene.notes.clone()).concat();
        if let Some(how) = same_data(a, b) {
            notes.push(format!(
                "A and B are the same data ({how}): it is compared with itself"
            ));
        }
        let lights = a.scene.faces.iter().zip(&b.scene.faces);
        let unlike = lights.filter(|(a, b)| a.emission != b.emission).count();
        if unlike > 0 {
            notes.push(format!(
                "{unlike} faces emit differently in A and B; each result's own emission is left out of it"
            ));
        }
        if self.pair.cut > 0 {
            notes.push(format!(
                "on {} faces the texels of A and B do not share a useful grid: finer ones were cut, as if they were even",
                self.pair.cut
            ));
        }
        if self.relative_rms.iter().any(|x| x.is_infinite()) {
            notes.push("B reflects nothing in a channel in which A does".into());
        }
        notes
    }

    /// The contract's four figures and everything else that scripts may want; infinity is null.
    pub fn json(&self, a: &Stored, b: &Stored, flip: Option<f64>) -> Value {
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

fn faces(pair: &Pair, scene: &Scene) -> Vec<FaceDiff> {
    let square = |k: usize| pair.areas[k] * (pair.a[k] - pair.b[k]).length_squared();
    let total: f64 = (0..pair.areas.len()).map(square).sum();
    let face = |k: usize| {
        let texels = pair.first[k]..pair.first[k + 1];
        let part: f64 = texels.clone().map(square).sum();
        let worst = worst(channels(pair.texels(texels.clone())));
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

/// How A and B turn out to be one result, if they do.
pub fn same_data(a: &Stored, b: &Stored) -> Option<&'static str> {
    let place = |stored: &Stored| canonicalize(&stored.dir).ok();
    if place(a).is_some() && place(a) == place(b) {
        return Some("one directory");
    }
    // Both parts of what is compared, B − E.
    let bits = |stored: &Stored| -> Vec<[u32; 3]> {
        let values = stored.radiosity.iter().chain(&stored.emission);
        values.map(|v| v.to_array().map(f32::to_bits)).collect()
    };
    let equal = a.resolutions == b.resolutions && bits(a) == bits(b);
    equal.then_some("every texel equal bit for bit")
}
