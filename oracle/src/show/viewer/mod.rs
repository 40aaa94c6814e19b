//! A solved scene to look around in: one element of a page, with all that it shows, and no network.
//!
//! The browser is given the texels as they are solved, in face order, and interpolates as
//! [`crate::show::view::surface`] does; what is read off a texel is what `lightmap.exr` holds.

use super::page::{Page, short};
use super::picture::{DIVERGING, Exposure};
use super::tone::SHOULDER;
use super::view::camera::Camera;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::mesh::{Mesh, Texel};
use common::scene::{Scene, Shape};
use common::shooting::Field;
use glam::Vec3;
use maud::{Markup, PreEscaped, html};
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use serde_json::{Value, json};
use std::collections::HashMap;

const SCRIPT: &str = include_str!("viewer.js");
const STYLE: &str = include_str!("viewer.css");
/// Stops of the rising colours.
const RISING: u32 = 9;

/// What is looked at.
pub struct Viewer<'a> {
    /// Faces and their names.
    pub scene: &'a Scene,
    /// Their texels.
    pub mesh: &'a Mesh,
    /// Who solved it, and what came of it: one answer, or two to be compared.
    pub layers: Vec<(&'a str, &'a Field)>,
    /// How far each texel may be off, W/m².
    pub off: Option<&'a [f32]>,
    /// Where one stands first.
    pub camera: Camera,
    /// What is white.
    pub exposure: Exposure,
}

/// What the page of a viewer needs once: its look and its program.
pub fn once() -> Markup {
    html! { style { (PreEscaped(STYLE)) } script { (PreEscaped(SCRIPT)) } }
}

impl Viewer<'_> {
    /// The element.
    pub fn element(&self) -> Markup {
        let two = self.layers.len() > 1;
        let kinds = [
            ("radiosity", "radiosity B", true),
            ("irradiance", "irradiance H", true),
            ("error", "error estimate", self.off.is_some()),
            ("difference", "difference", two),
        ];
        // "<" would end the element that holds it.
        let head = self.head().to_string().replace('<', "\\u003c");
        html! {
            div.viewer {
                canvas tabindex="0" role="img" aria-label={ "The scene " (self.scene.name) ", to look around in" } {}
                div.tools {
                    span.group role="group" aria-label="What is shown" {
                        @for (what, name, there) in kinds {
                            @if there { button type="button" data-what=(what) aria-pressed=(what == "radiosity") { (name) } }
                        }
                    }
                    @if two { span.group role="group" aria-label="Whose answer" {
                        @for (k, (name, _)) in self.layers.iter().enumerate() {
                            button type="button" data-layer=(k) aria-pressed=(k == 0) { (name) }
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
                script.data type="text/plain" { (STANDARD.encode(self.bytes())) }
            }
        }
    }

    /// A file with nothing else; `told` says what it is.
    pub fn page(&self, told: &str) -> String {
        let title = short(&self.scene.name);
        let page = Page {
            title,
            bar: ("Scene", html! { a href="#top" { (title) } }),
            verdict: html! { p.facts { (told) } },
            style: "",
            body: html! { (self.element()) (once()) },
        };
        page.html()
    }

    fn head(&self) -> Value {
        let linear = |[r, g, b]: [u8; 3]| [r, g, b].map(|x| f32::from(x) / 255.0);
        let rising = (0..RISING).map(|k| {
            let colour = ViridisRGB.get_color(k as f32 / (RISING - 1) as f32);
            linear([colour.0, colour.1, colour.2])
        });
        json!({
            "faces": self.mesh.faces.len(),
            "texels": self.mesh.texels.len(),
            "names": self.names().0,
            "layers": self.layers.iter().map(|(name, _)| name).collect::<Vec<_>>(),
            "by_texel": !self.alike(),
            "off": self.off.is_some(),
            "eye": self.camera.eye.to_array(),
            "target": self.camera.target.to_array(),
            "up": self.camera.up.to_array(),
            "fov": self.camera.fov_degrees,
            "white": self.exposure.white,
            "shoulder": SHOULDER,
            "rising": rising.collect::<Vec<_>>(),
            "signed": DIVERGING.map(linear),
        })
    }

    /// The names, each once, and that of each face.
    fn names(&self) -> (Vec<&str>, Vec<u32>) {
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

    /// Whether each face's texels have one ρ and one E.
    fn alike(&self) -> bool {
        let first = self.first();
        let of = |texel: &Texel| (texel.emission, texel.reflectance);
        let mut texels = self.mesh.texels.iter();
        texels.all(|texel| of(texel) == of(first[texel.face as usize]))
    }

    /// A texel of each face.
    fn first(&self) -> Vec<&Texel> {
        let Some(any) = self.mesh.texels.first() else {
            return Vec::new();
        };
        let mut first = vec![any; self.mesh.faces.len()];
        for texel in &self.mesh.texels {
            first[texel.face as usize] = texel;
        }
        first
    }

    /// Corners; texels a side, kinds and names; E and ρ; by layer B and H; what may be off.
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for corner in self.mesh.faces.iter().flat_map(|face| face.corners) {
            put(&mut bytes, corner);
        }
        let (_, names) = self.names();
        for ((face, own), name) in self.mesh.faces.iter().zip(&self.scene.faces).zip(names) {
            let [w, h] = face.resolution;
            let info = [w, h, u32::from(own.shape == Shape::Quad), name];
            bytes.extend(info.into_iter().flat_map(u32::to_le_bytes));
        }
        let order = self.mesh.in_face_order();
        let surfaces = match self.alike() {
            true => self.first(),
            false => order.iter().map(|k| &self.mesh.texels[*k]).collect(),
        };
        for texel in surfaces {
            put(&mut bytes, texel.emission);
            put(&mut bytes, texel.reflectance);
        }
        for (_, field) in &self.layers {
            for k in &order {
                put(&mut bytes, field.radiosity[*k].truncate());
                put(&mut bytes, field.irradiance[*k].truncate());
            }
        }
        if let Some(off) = self.off {
            bytes.extend(order.iter().flat_map(|k| off[*k].to_le_bytes()));
        }
        bytes
    }
}

fn put(bytes: &mut Vec<u8>, v: Vec3) {
    bytes.extend(v.to_array().into_iter().flat_map(f32::to_le_bytes));
}
