//! A face as the descriptions (`result.json`, `room.json`) tell it.

use crate::scene::{Face, Shape};
use crate::texel;
use crate::text::plain;
use glam::{DVec3, Vec3};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::HashMap;

/// A face with its texels, and where these are stored.
#[derive(Deserialize)]
pub(crate) struct Entry {
    #[serde(default)]
    pub name: String,
    pub kind: Kind,
    pub corners: Vec<[f64; 3]>,
    pub texels: [u32; 2],
    /// In `result.json`: its rectangle x, y, w, h in the atlas.
    #[serde(default)]
    pub rect: Option<[u32; 4]>,
    /// In `room.json`: its image.
    #[serde(default)]
    pub file: Option<String>,
    #[serde(default)]
    pub emission: [f32; 3],
    #[serde(default)]
    pub reflectance: [f32; 3],
    pub from: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    Quad,
    Triangle,
}

impl Entry {
    /// Whether the face has the corners and texels that its kind asks for.
    pub(crate) fn check(&self) -> Result<(), String> {
        let wanted = if self.kind == Kind::Quad { 4 } else { 3 };
        if self.corners.len() != wanted {
            let count = self.corners.len();
            return Err(format!("has {count} corners instead of {wanted}"));
        }
        if !self.emission.iter().all(|e| e.is_finite()) {
            return Err("its emission is out of range".into());
        }
        if !reflects(self.reflectance.into()) {
            return Err(format!(
                "its reflectance {:?} is not at least 0 and below 1 in every channel",
                self.reflectance
            ));
        }
        let [w, h] = self.texels;
        if w == 0 || h == 0 || (self.kind == Kind::Triangle && w != h) {
            return Err(format!("{w}×{h} texels do not fit its kind"));
        }
        Ok(())
    }

    /// Whether the face gives light, if anything.
    pub(crate) fn check_emission(&self) -> Result<(), String> {
        if self.emission.iter().all(|e| *e >= 0.0) {
            return Ok(());
        }
        Err(format!(
            "its emission {:?} is not at least 0 in every channel",
            self.emission
        ))
    }

    /// The face; `check` must have counted the corners.
    pub(crate) fn face(&self) -> Face {
        let c: Vec<DVec3> = self.corners.iter().map(|p| DVec3::from(*p)).collect();
        let name = plain(&self.name);
        let (emission, reflectance) = (self.emission.into(), self.reflectance.into());
        let face = match self.kind {
            Kind::Quad => Face::quad(&name, [c[0], c[1], c[2], c[3]], emission, reflectance),
            Kind::Triangle => Face::triangle(&name, [c[0], c[1], c[2]], emission, reflectance),
        };
        Face {
            from: self.from,
            ..face
        }
    }
}

/// All faces, the two sides of each sheet joined.
pub(crate) fn faces(entries: &[Entry]) -> Vec<Face> {
    let mut faces: Vec<Face> = entries.iter().map(Entry::face).collect();
    join_sheets(&mut faces);
    faces
}

/// What a description says of a face, but for where its texels are stored.
pub(crate) fn describe(face: &Face, resolution: [u32; 2]) -> Value {
    let mut entry = json!({
        "name": face.name,
        "kind": match face.shape { Shape::Quad => "quad", Shape::Triangle => "triangle" },
        "corners": face.outline().iter().map(|p| p.to_array()).collect::<Vec<_>>(),
        "area": face.area(),
        "texels": resolution,
        "emission": face.emission.to_array(),
        "reflectance": face.reflectance.to_array(),
    });
    if let Some(from) = face.from {
        entry["from"] = from.into();
    }
    entry
}

/// Whether a surface reflects less than it receives, and nothing negative.
pub(crate) fn reflects(reflectance: Vec3) -> bool {
    (reflectance.cmpge(Vec3::ZERO) & reflectance.cmplt(Vec3::ONE)).all()
}

/// The first face by which radiosity (in face order, `resolutions` W×H each), summed over texels and
/// channels as power is, leaves the range of 32-bit floats.
pub(crate) fn too_bright(radiosity: &[Vec3], resolutions: &[[u32; 2]]) -> Option<usize> {
    let mut rest = radiosity;
    let mut sum = 0.0;
    resolutions.iter().position(|resolution| {
        let (own, others) = rest.split_at(texel::count(*resolution) as usize);
        rest = others;
        sum += own
            .iter()
            .map(|b| b.as_dvec3().abs().element_sum())
            .sum::<f64>();
        sum > f64::from(f32::MAX)
    })
}

/// What is said of it.
pub(crate) const TOO_BRIGHT: &str =
    "its radiosity is too large to be summed in 32-bit floats: scale the light down";

/// How messages name face `k`.
pub(crate) fn label(k: usize) -> String {
    format!("face {k}")
}

/// A face that says from which other it is, and has that one's corners reversed, is its back.
fn join_sheets(faces: &mut [Face]) {
    let key = |face: &Face| face.corners.map(|c| c.to_array().map(f64::to_bits));
    let fronts: HashMap<_, usize> = faces.iter().enumerate().map(|(k, f)| (key(f), k)).collect();
    for back in 0..faces.len() {
        if faces[back].from.is_none() || faces[back].partner.is_some() {
            continue;
        }
        let Some(&front) = fronts.get(&key(&faces[back].reversed())) else {
            continue;
        };
        if front < back && faces[front].partner.is_none() {
            faces[back].partner = Some(front as u32);
            faces[front].partner = Some(back as u32);
        }
    }
}
