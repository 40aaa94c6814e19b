//! Interactive 3-D viewer of a solved scene: one HTML element with its data, without network access.
//!
//! The browser gets the texels in face order and interpolates like [`crate::report::view::interpolation`]; a texel's
//! reading equals its value in `lightmap.exr`.

use super::document::{Blocks, render_document};
use super::format::file_name;
use super::picture::{DIVERGING_COLOURS, Exposure, SHOULDER_START};
use super::view::camera::Camera;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::mesh::{Mesh, Texel};
use common::scene::{Scene, Shape};
use common::shooting::RadiosityField;
use glam::Vec3;
use maud::{Markup, PreEscaped, html};
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use serde_json::{Value, json};
use std::collections::HashMap;

const VIEWER_SCRIPT: &str = include_str!("viewer.js");
const VIEWER_STYLE: &str = include_str!("viewer.css");
/// Stops of the sequential colour map.
const SEQUENTIAL_STOPS: u32 = 9;

/// Content of a viewer.
pub struct SceneViewer<'a> {
    /// Faces with names.
    pub scene: &'a Scene,
    /// One solution, or two solutions on the same texels, whose difference is that of the first minus the second.
    pub layers: Vec<ViewerLayer<'a>>,
    /// True if irradiance H is known besides radiosity B.
    pub irradiance: bool,
    /// True to interpolate B − E instead of H, where B = E + ρH need not hold.
    pub reflected: bool,
    /// Error estimate per texel, W/m².
    pub texel_errors: Option<&'a [f32]>,
    /// Initial camera.
    pub camera: Camera,
    /// Initial exposure.
    pub exposure: Exposure,
}

/// Solution shown by a viewer.
pub struct ViewerLayer<'a> {
    /// Name of the solver.
    pub name: &'a str,
    /// Texels; layers may differ in ρ and E.
    pub mesh: &'a Mesh,
    /// Radiosity and irradiance.
    pub field: &'a RadiosityField,
}

/// Returns the style sheet and script that a page with viewers includes once.
pub fn page_assets() -> Markup {
    html! { style { (PreEscaped(VIEWER_STYLE)) } script { (PreEscaped(VIEWER_SCRIPT)) } }
}

impl SceneViewer<'_> {
    /// Renders the viewer as an HTML element.
    pub fn render_element(&self) -> Markup {
        let two = self.layers.len() > 1;
        let name = |k: usize| self.layers.get(k).map_or("", |layer| layer.name);
        let difference = format!("{} − {}", name(0), name(1));
        let kinds = [
            ("radiosity", "radiosity B", true),
            ("irradiance", "irradiance H", self.irradiance),
            ("error", "error estimate", self.texel_errors.is_some()),
            ("difference", &difference, self.layers_differ()),
        ];
        // A literal "</script" would end the element.
        let head = self.header_json().to_string().replace('<', "\\u003c");
        html! {
            div.viewer {
                canvas tabindex="0" role="img" aria-label={ "Interactive view of the scene " (self.scene.name) } {}
                div.tools {
                    span.group role="group" aria-label="Displayed quantity" {
                        @for (what, name, available) in kinds {
                            @if available { button type="button" data-what=(what) aria-pressed=(what == "radiosity") { (name) } }
                        }
                    }
                    @if two { span.group role="group" aria-label="Displayed solution" {
                        @for (k, layer) in self.layers.iter().enumerate() {
                            button type="button" data-layer=(k) aria-pressed=(k == 0) { (layer.name) }
                        }
                    } }
                    span.group {
                        button type="button" data-toggle="grid" aria-pressed="false" { "texels" }
                        button type="button" data-toggle="false_colours" aria-pressed="false" { "false colours" }
                        button.reset type="button" { "reset view" }
                    }
                    label { "exposure" input type="range" min="-8" max="8" step="0.5" value="0"; span.stops { "0 stops" } }
                }
                div.legend hidden { div.scale { span.low { "0" } span.ramp {} span.high {} } }
                div.told aria-live="polite" { "Point at a texel to read its light." }
                p.keys { "Drag to orbit, drag with Shift or the right button to pan, wheel or pinch to zoom; tap or point to read a texel. Keys: arrows, Shift and arrows, + −, [ ] exposure, 1 to 4, g texels, f false colours, Enter reads the middle, r." }
                script.head type="application/json" { (PreEscaped(head)) }
                script.data type="text/plain" { (STANDARD.encode(self.binary_data())) }
            }
        }
    }

    /// Renders a page with this viewer alone; `description` describes the solution.
    pub fn render_page(&self, description: &str) -> String {
        let mut opening = Blocks::default();
        opening
            .add_remark(description)
            .add_element(self.render_element())
            .add_element(page_assets());
        render_document(file_name(&self.scene.name), &opening, &[], "")
    }

    /// Returns the viewer's parameters for `viewer.js`.
    fn header_json(&self) -> Value {
        let linear = |[r, g, b]: [u8; 3]| [r, g, b].map(|x| f32::from(x) / 255.0);
        let rising = (0..SEQUENTIAL_STOPS).map(|k| {
            let colour = ViridisRGB.get_color(k as f32 / (SEQUENTIAL_STOPS - 1) as f32);
            linear([colour.0, colour.1, colour.2])
        });
        json!({
            "faces": self.scene.faces.len(),
            "texels": self.layers.first().map_or(0, |layer| layer.mesh.texels.len()),
            "names": self.face_names().0,
            "layers": self.layers.iter().map(|layer| layer.name).collect::<Vec<_>>(),
            "surfaces": self.layers.len(),
            "by_texel": !self.layers.iter().all(|layer| is_constant_per_face(layer.mesh)),
            "irradiance": self.irradiance,
            "reflected": self.reflected,
            "difference": self.layers_differ().then_some([0, 1]),
            "off": self.texel_errors.is_some(),
            "eye": self.camera.eye.to_array(),
            "target": self.camera.target.to_array(),
            "up": self.camera.up.to_array(),
            "fov": self.camera.fov_degrees,
            "white": self.exposure.white,
            "shoulder": SHOULDER_START,
            "rising": rising.collect::<Vec<_>>(),
            "signed": DIVERGING_COLOURS.map(linear),
        })
    }

    /// Returns the distinct face names and each face's index into them.
    fn face_names(&self) -> (Vec<&str>, Vec<u32>) {
        let (mut names, mut known) = (Vec::new(), HashMap::new());
        let mut own = Vec::with_capacity(self.scene.faces.len());
        for face in &self.scene.faces {
            let name = face.name.as_str();
            own.push(*known.entry(name).or_insert_with(|| {
                names.push(name);
                names.len() as u32 - 1
            }));
        }
        (names, own)
    }

    /// Returns whether there are two layers and they differ in radiosity.
    fn layers_differ(&self) -> bool {
        matches!(self.layers.as_slice(), [a, b] if a.field.radiosity != b.field.radiosity)
    }

    /// Packs the binary data: corners; resolution, shape and name of each face; E and ρ, then B and H of
    /// each layer; error estimates.
    fn binary_data(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let Some(mesh) = self.layers.first().map(|layer| layer.mesh) else {
            return bytes;
        };
        for corner in mesh.faces.iter().flat_map(|face| face.corners) {
            push_vector(&mut bytes, corner);
        }
        let (_, names) = self.face_names();
        for ((face, own), name) in mesh.faces.iter().zip(&self.scene.faces).zip(names) {
            let [w, h] = face.resolution;
            let info = [w, h, u32::from(own.shape == Shape::Quad), name];
            bytes.extend(info.into_iter().flat_map(u32::to_le_bytes));
        }
        let order = mesh.texels_in_face_order();
        let plain = self.layers.iter().all(|layer| is_constant_per_face(layer.mesh));
        for layer in &self.layers {
            let texels = match plain {
                true => texel_per_face(layer.mesh),
                false => order.iter().map(|k| &layer.mesh.texels[*k]).collect(),
            };
            for texel in texels {
                push_vector(&mut bytes, texel.emission);
                push_vector(&mut bytes, texel.reflectance);
            }
        }
        for layer in &self.layers {
            for k in &order {
                push_vector(&mut bytes, layer.field.radiosity[*k].truncate());
                push_vector(&mut bytes, layer.field.irradiance[*k].truncate());
            }
        }
        if let Some(off) = self.texel_errors {
            bytes.extend(order.iter().flat_map(|k| off[*k].to_le_bytes()));
        }
        bytes
    }
}

/// Returns whether ρ and E are constant on each face.
fn is_constant_per_face(mesh: &Mesh) -> bool {
    let first = texel_per_face(mesh);
    let of = |texel: &Texel| (texel.emission, texel.reflectance);
    let mut texels = mesh.texels.iter();
    texels.all(|texel| of(texel) == of(first[texel.face as usize]))
}

/// Returns one texel of each face.
fn texel_per_face(mesh: &Mesh) -> Vec<&Texel> {
    let Some(any) = mesh.texels.first() else {
        return Vec::new();
    };
    let mut first = vec![any; mesh.faces.len()];
    for texel in &mesh.texels {
        first[texel.face as usize] = texel;
    }
    first
}

/// Appends a vector as three little-endian floats.
fn push_vector(bytes: &mut Vec<u8>, v: Vec3) {
    bytes.extend(v.to_array().into_iter().flat_map(f32::to_le_bytes));
}
