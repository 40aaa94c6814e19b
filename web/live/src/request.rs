//! What the page asks for.

use crate::change::GroupChange;
use common::form_factor::FormFactor;
use common::settings::{
    ItemBufferProjection, ItemBufferSettings, Meshing, Schedule, Settings, SolveQuality, Transport, Visibility,
};
use common::{Error, Result};
use radiosity::report::picture::Exposure;
use radiosity::report::view::camera::Camera;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Maximum texels and patches per side of a face, samples, and pixels per side of an item buffer.
const MAX_COUNTS: [(&str, u32); 4] = [("texels", 64), ("patches", 16), ("samples", 16), ("pixels", 1024)];

/// The solver of a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LiveSolver {
    /// The CPU.
    #[default]
    Cpu,
    /// The browser's GPU.
    Gpu,
}

/// A solve that the page asks for.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiveRequest {
    /// The solver.
    #[serde(default)]
    pub solver: LiveSolver,
    /// Texels per side of a face.
    pub texels: u32,
    /// Patches per side of a face.
    pub patches: u32,
    /// Visibility samples between a texel and a patch.
    pub samples: u32,
    /// `rays`, or the name of an item buffer's projection.
    pub visibility: String,
    /// Pixels per side of the item buffer.
    pub pixels: u32,
    /// `paper`, `disc` or `polygon`.
    pub form_factor: String,
    /// Share of the emitted power that may stay unshot, ε.
    pub epsilon: f64,
    /// Changes of the scene.
    #[serde(default)]
    pub changes: Vec<GroupChange>,
    /// Camera and exposure; none: those that suit the scene.
    #[serde(default)]
    pub view: Option<LiveView>,
}

/// Camera, in the coordinates of the mesh, and exposure of a picture.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LiveView {
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    fov_degrees: f32,
    white: f32,
    has_shoulder: bool,
}

impl LiveView {
    /// Makes the view of a camera and an exposure.
    pub fn new(camera: Camera, exposure: Exposure) -> Self {
        Self {
            eye: camera.eye.to_array(),
            target: camera.target.to_array(),
            up: camera.up.to_array(),
            fov_degrees: camera.fov_degrees,
            white: exposure.white,
            has_shoulder: exposure.has_shoulder,
        }
    }

    /// Returns camera and exposure.
    pub fn to_parts(self) -> (Camera, Exposure) {
        let camera = Camera {
            eye: self.eye.into(),
            target: self.target.into(),
            up: self.up.into(),
            fov_degrees: self.fov_degrees,
        };
        let exposure = Exposure {
            white: self.white,
            has_shoulder: self.has_shoulder,
        };
        (camera, exposure)
    }
}

/// Returns the settings as values of a request, by their names there.
pub fn name_settings(settings: &Settings) -> Value {
    let Settings { meshing, transport, .. } = settings;
    let drawing = transport.visibility.item_buffer();
    json!({
        "patches": meshing.patches,
        "samples": meshing.samples,
        "visibility": transport.visibility.name(),
        "pixels": drawing.map(|drawing| drawing.size),
        "form_factor": transport.form_factor,
    })
}

impl LiveRequest {
    /// Parses a request.
    ///
    /// Errors: [`Error::Usage`] of text that is none.
    pub fn parse(text: &str) -> Result<Self> {
        serde_json::from_str(text).map_err(|error| Error::Usage(format!("the request cannot be read: {error}")))
    }

    /// Returns the settings of the solve.
    ///
    /// Errors: [`Error::Usage`] of a number or a name out of range.
    pub fn to_settings(&self) -> Result<Settings> {
        let counts = [self.texels, self.patches, self.samples, self.pixels];
        for ((name, most), count) in MAX_COUNTS.into_iter().zip(counts) {
            if !(1..=most).contains(&count) {
                return Err(Error::Usage(format!(
                    "{count} {name} are not possible here: give 1 to {most}"
                )));
            }
        }
        if !(self.epsilon > 0.0 && self.epsilon <= 1.0) {
            return Err(Error::Usage(format!(
                "ε = {} is not possible: give 0 to 1",
                self.epsilon
            )));
        }
        Ok(Settings {
            quality: SolveQuality::Normal,
            meshing: Meshing {
                texels: self.texels,
                patches: self.patches,
                samples: self.samples,
            },
            transport: Transport {
                visibility: find_visibility(&self.visibility, self.pixels)?,
                form_factor: self.form_factor()?,
                conserve: false,
            },
            schedule: Schedule {
                epsilon: self.epsilon,
                ..Schedule::default()
            },
        })
    }

    fn form_factor(&self) -> Result<FormFactor> {
        match self.form_factor.as_str() {
            "paper" => Ok(FormFactor::Paper),
            "disc" => Ok(FormFactor::Disc),
            "polygon" => Ok(FormFactor::Polygon),
            other => Err(Error::Usage(format!("there is no form factor {other:?}"))),
        }
    }
}

/// Finds a visibility by its name: rays, or an item buffer of so many pixels a side.
///
/// Errors: [`Error::Usage`] of an unknown name.
pub fn find_visibility(name: &str, pixels: u32) -> Result<Visibility> {
    let drawn = ItemBufferProjection::ALL_PROJECTIONS.map(|projection| {
        Visibility::ItemBuffer(ItemBufferSettings {
            projection,
            size: pixels,
            ..ItemBufferSettings::DEFAULT
        })
    });
    let mut all = [Visibility::Rays].into_iter().chain(drawn);
    let found = all.find(|visibility| visibility.name() == name);
    found.ok_or_else(|| Error::Usage(format!("there is no visibility {name:?}")))
}
