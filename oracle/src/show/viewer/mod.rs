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
    /// One answer, or two to be compared: of the same texels.
    pub layers: Vec<Layer<'a>>,
    /// Which of two is subtracted from which: first the one that it is taken from.
    pub difference: [usize; 2],
    /// Whether H is known beside B.
    pub irradiance: bool,
    /// Whether B − E is interpolated in the place of H: where B = E + ρH need not hold.
    pub reflected: bool,
    /// How far each texel may be off, W/m².
    pub off: Option<&'a [f32]>,
    /// Where one stands first.
    pub camera: Camera,
    /// What is white.
    pub exposure: Exposure,
}

/// An answer.
pub struct Layer<'a> {
    /// Whose.
    pub name: &'a str,
    /// Its texels: two answers may differ in ρ and E.
    pub mesh: &'a Mesh,
    /// Its light.
    pub field: &'a Field,
}

/// What the page of a viewer needs once: its look and its program.
pub fn once() -> Markup {
    html! { style { (PreEscaped(STYLE)) } script { (PreEscaped(SCRIPT)) } }
}

impl Viewer<'_> {
    /// The element.
    pub fn element(&self) -> Markup {
        let two = self.layers.len() > 1;
        let name = |k: usize| self.layers.get(k).map_or("", |layer| layer.name);
        let difference = format!(
            "{} − {}",
            name(self.difference[0]),
            name(self.difference[1])
        );
        let kinds = [
            ("radiosity", "radiosity B", true),
            ("irradiance", "irradiance H", self.irradiance),
            ("error", "error estimate", self.off.is_some()),
            ("difference", &difference, self.differ()),
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
            "faces": self.scene.faces.len(),
            "texels": self.layers.first().map_or(0, |layer| layer.mesh.texels.len()),
            "names": self.names().0,
            "layers": self.layers.iter().map(|layer| layer.name).collect::<Vec<_>>(),
            "surfaces": self.surfaces().len(),
            "by_texel": !self.surfaces().iter().all(|mesh| alike(mesh)),
            "irradiance": self.irradiance,
            "reflected": self.reflected,
            "difference": self.differ().then_some(self.difference),
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

    /// Whether two answers are two: not the same bits.
    fn differ(&self) -> bool {
        let bits = |layer: &Layer| -> Vec<[u32; 4]> {
            let values = layer.field.radiosity.iter();
            values.map(|b| b.to_array().map(f32::to_bits)).collect()
        };
        match self.layers.as_slice() {
            [a, b] => bits(a) != bits(b),
            _ => false,
        }
    }

    /// The meshes with ρ and E: one where all layers have the same.
    fn surfaces(&self) -> Vec<&Mesh> {
        let mut meshes: Vec<&Mesh> = self.layers.iter().map(|layer| layer.mesh).collect();
        let of = |mesh: &Mesh| -> Vec<(Vec3, Vec3)> {
            let texels = mesh.texels.iter();
            texels.map(|t| (t.emission, t.reflectance)).collect()
        };
        if let [a, b] = meshes.as_slice()
            && (std::ptr::eq(*a, *b) || of(a) == of(b))
        {
            meshes.truncate(1);
        }
        meshes
    }

    /// Corners; texels a side, kinds and names; E and ρ of each surface; by layer B and H; what may be off.
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let Some(mesh) = self.layers.first().map(|layer| layer.mesh) else {
            return bytes;
        };
        for corner in mesh.faces.iter().flat_map(|face| face.corners) {
            put(&mut bytes, corner);
        }
        let (_, names) = self.names();
        for ((face, own), name) in mesh.faces.iter().zip(&self.scene.faces).zip(names) {
            let [w, h] = face.resolution;
            let info = [w, h, u32::from(own.shape == Shape::Quad), name];
            bytes.extend(info.into_iter().flat_map(u32::to_le_bytes));
        }
        let order = mesh.in_face_order();
        let surfaces = self.surfaces();
        let plain = surfaces.iter().all(|mesh| alike(mesh));
        for mesh in surfaces {
            let texels = match plain {
                true => first(mesh),
                false => order.iter().map(|k| &mesh.texels[*k]).collect(),
            };
            for texel in texels {
                put(&mut bytes, texel.emission);
                put(&mut bytes, texel.reflectance);
            }
        }
        for layer in &self.layers {
            for k in &order {
                put(&mut bytes, layer.field.radiosity[*k].truncate());
                put(&mut bytes, layer.field.irradiance[*k].truncate());
            }
        }
        if let Some(off) = self.off {
            bytes.extend(order.iter().flat_map(|k| off[*k].to_le_bytes()));
        }
        bytes
    }
}

/// Whether each face's texels have one ρ and one E.
fn alike(mesh: &Mesh) -> bool {
    let first = first(mesh);
    let of = |texel: &Texel| (texel.emission, texel.reflectance);
    let mut texels = mesh.texels.iter();
    texels.all(|texel| of(texel) == of(first[texel.face as usize]))
}

/// A texel of each face.
fn first(mesh: &Mesh) -> Vec<&Texel> {
    let Some(any) = mesh.texels.first() else {
        return Vec::new();
    };
    let mut first = vec![any; mesh.faces.len()];
    for texel in &mesh.texels {
        first[texel.face as usize] = texel;
    }
    first
}

fn put(bytes: &mut Vec<u8>, v: Vec3) {
    bytes.extend(v.to_array().into_iter().flat_map(f32::to_le_bytes));
}
