//! Interactive 3-D viewer of a solved scene: one HTML element with its data, without network access.
//!
//! The browser gets the nodes of [`crate::report::view::interpolation`] with their values, to draw the same light, and
//! the texels in face order; a texel's reading equals its value in `lightmap.exr`.

use super::document::{Blocks, render_document};
use super::format::file_name;
use super::picture::{DIVERGING_COLOURS, Exposure, SHOULDER_START};
use super::view::camera::Camera;
use super::view::interpolation::{CarriedLight, InterpolationSurface};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::mesh::{Mesh, Texel};
use common::scene::{Scene, Shape};
use common::shooting::RadiosityField;
use glam::{DVec3, Vec3};
use half::f16;
use maud::{Markup, PreEscaped, html};
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use serde_json::{Value, json};
use std::collections::HashMap;

/// Files of the viewer's script, in the order in which they are included.
pub const VIEWER_SCRIPTS: [&str; 3] = [
    include_str!("scene.js"),
    include_str!("lines.js"),
    include_str!("viewer.js"),
];
/// Opens each viewer of a page when it is first seen.
const START_SCRIPT: &str = include_str!("start.js");
const VIEWER_STYLE: &str = include_str!("viewer.css");
/// Stops of the sequential colour map.
const SEQUENTIAL_STOPS: u32 = 9;

/// Largest node value in the data, of those that 16 bits can hold.
const MAX_NODE_VALUE: f64 = 6e4;

/// Content of a viewer.
pub struct SceneViewer<'a> {
    /// Faces with names.
    pub scene: &'a Scene,
    /// Interpolation nodes of the layers' texels.
    pub surface: &'a InterpolationSurface<'a>,
    /// One solution, or two solutions on the same texels, whose difference is that of the first minus the second.
    pub layers: Vec<ViewerLayer<'a>>,
    /// True if irradiance H is known besides radiosity B.
    pub irradiance: bool,
    /// Interpolated light.
    pub carried: CarriedLight,
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
    /// Radiosity and irradiance; none if the page computes them.
    pub field: Option<&'a RadiosityField>,
}

/// Keys and movements of the pointer that every viewer has.
pub const VIEWER_HELP: &str = "Drag to orbit, drag with Shift or the right button to pan, wheel or pinch to zoom; tap or point to read a texel. Keys: arrows, Shift and arrows, + −, [ ] exposure, 1 to 4, g texels, f false colours, Enter reads the middle, r.";

/// Returns the style sheet and script that a page with viewers includes once.
pub fn page_assets() -> Markup {
    viewer_assets("", &[START_SCRIPT])
}

/// Returns the viewer's style sheet and script, each with more of a page that adds to the viewer.
pub fn viewer_assets(style: &str, scripts: &[&str]) -> Markup {
    let all = VIEWER_SCRIPTS.iter().chain(scripts);
    let parts = all.flat_map(|text| [text, "\n"]);
    let script: String = ["(() => {\n\"use strict\";\n"]
        .into_iter()
        .chain(parts)
        .chain(["})();"])
        .collect();
    html! {
        style { (PreEscaped(VIEWER_STYLE)) (PreEscaped(style)) }
        script { (PreEscaped(script)) }
    }
}

impl<'a> SceneViewer<'a> {
    /// Renders the viewer as an HTML element.
    pub fn render_element(&self) -> Markup {
        let name = |k: usize| self.layers.get(k).map_or("", |layer| layer.name);
        let difference = format!("{} − {}", name(0), name(1));
        let kinds = [
            ("radiosity", "radiosity B", true),
            ("irradiance", "irradiance H", self.irradiance),
            ("error", "error estimate", self.texel_errors.is_some()),
            ("difference", &difference, self.layers_differ()),
        ];
        let available = kinds.iter().filter(|kind| kind.2).map(|kind| (kind.0, kind.1));
        self.render_quantities(&available.collect::<Vec<_>>(), VIEWER_HELP)
    }

    /// Renders the viewer with a button for each of these quantities (name in the script, text), the first displayed at
    /// first; `help` says how to use it.
    pub fn render_quantities(&self, quantities: &[(&str, &str)], help: &str) -> Markup {
        let two = self.layers.len() > 1;
        // A literal "</script" would end the element.
        let nodes = ViewerNodes::new(self);
        let head = self.header_json(&nodes).to_string().replace('<', "\\u003c");
        html! {
            div.viewer {
                canvas tabindex="0" role="img" aria-label={ "Interactive view of the scene " (self.scene.name) } {}
                div.tools {
                    span.group role="group" aria-label="Displayed quantity" {
                        @for (k, (what, name)) in quantities.iter().enumerate() {
                            button type="button" data-what=(what) aria-pressed=(k == 0) { (name) }
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
                p.keys { (help) }
                script.head type="application/json" { (PreEscaped(head)) }
                script.data type="text/plain" { (PreEscaped(STANDARD.encode(self.binary_data(&nodes)))) }
            }
        }
    }

    /// Renders a page with this viewer's `element` alone; `description` describes the solution.
    pub fn render_page(&self, element: Markup, description: &str) -> String {
        let mut opening = Blocks::default();
        opening
            .add_remark(description)
            .add_element(element)
            .add_element(page_assets());
        render_document(file_name(&self.scene.name), &opening, &[], "")
    }

    /// Returns the viewer's parameters for `viewer.js`.
    fn header_json(&self, nodes: &ViewerNodes) -> Value {
        let linear = |[r, g, b]: [u8; 3]| [r, g, b].map(|x| f32::from(x) / 255.0);
        let rising = (0..SEQUENTIAL_STOPS).map(|k| {
            let colour = ViridisRGB.get_color(k as f32 / (SEQUENTIAL_STOPS - 1) as f32);
            linear([colour.0, colour.1, colour.2])
        });
        json!({
            "faces": self.scene.faces.len(),
            "texels": self.surface.mesh.texels.len(),
            "light": self.stores_light(),
            "names": self.face_names().0,
            "under": self.faces_under_others(),
            "layers": self.layers.iter().map(|layer| layer.name).collect::<Vec<_>>(),
            "surfaces": self.layers.len(),
            "by_texel": !self.layers.iter().all(|layer| is_constant_per_face(layer.mesh)),
            "irradiance": self.irradiance,
            "carried": self.carried.name(),
            "fields": nodes.fields,
            "joins": nodes.joins.len(),
            "knots": nodes.knots.len(),
            "nodes": nodes.count,
            "step": nodes.step,
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

    /// Returns the faces on which a front lies that precedes them: they are drawn behind it.
    fn faces_under_others(&self) -> Vec<u32> {
        let overlapped = (0..).zip(self.surface.mesh.find_overlapped());
        overlapped.filter(|(_, under)| *under).map(|(k, _)| k).collect()
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
        let radiosity = |layer: &ViewerLayer<'a>| layer.field.map(|field| &field.radiosity);
        matches!(self.layers.as_slice(), [a, b] if radiosity(a) != radiosity(b))
    }

    /// Returns whether the data have the light of the layers.
    fn stores_light(&self) -> bool {
        self.layers.iter().all(|layer| layer.field.is_some())
    }

    /// Packs the binary data: corners; resolution, shape and name of each face; E and ρ, then B and H of
    /// each layer; error estimates; nodes.
    fn binary_data(&self, nodes: &ViewerNodes) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mesh = self.surface.mesh;
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
        for field in self.layers.iter().filter_map(|layer| layer.field) {
            for k in &order {
                push_vector(&mut bytes, field.radiosity[*k].truncate());
                push_vector(&mut bytes, field.irradiance[*k].truncate());
            }
        }
        if let Some(off) = self.texel_errors {
            bytes.extend(order.iter().flat_map(|k| off[*k].to_le_bytes()));
        }
        bytes.extend(nodes.joins.as_flattened().iter().flat_map(|k| k.to_le_bytes()));
        bytes.extend(nodes.knots.as_flattened().iter().flat_map(|k| k.to_le_bytes()));
        bytes.extend(nodes.values.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }
}

/// Interpolation nodes in a viewer's data. Nodes are numbered over the faces, (W + 1)(H + 1) of each.
struct ViewerNodes {
    /// Nodes that have the value of an earlier one, with that one.
    joins: Vec<[u32; 2]>,
    /// Knots between the corners of a texel: texel in face order, corner before it, node.
    knots: Vec<[u32; 3]>,
    /// Number of nodes with a value of their own.
    count: usize,
    /// Interpolated fields of each layer: the carried light, and H where that is another one and known.
    fields: usize,
    /// Value of 1 in `values`.
    step: f64,
    /// Values of each layer, field, node and channel.
    values: Vec<f16>,
}

impl ViewerNodes {
    fn new(viewer: &SceneViewer) -> Self {
        let (surface, carried) = (viewer.surface, viewer.carried);
        let slots = || (0..).zip(surface.node_slots().iter().copied());
        let is_inside = inside_nodes(surface);
        let own: Vec<u32> = slots()
            .filter(|(k, slot)| k == slot && is_inside[*k as usize])
            .map(|own| own.1)
            .collect();
        let mut knots = Vec::new();
        let mut ring = Vec::new();
        for (number, k) in (0..).zip(surface.mesh.texels_in_face_order()) {
            surface.collect_knots(k as u32, &mut ring);
            let mut corner = 0;
            for knot in &ring {
                corner += u32::from(knot.is_corner);
                if !knot.is_corner {
                    knots.push([number, corner - 1, knot.slot]);
                }
            }
        }
        let more = viewer.irradiance && carried != CarriedLight::Irradiance;
        let lights = [carried].into_iter().chain(more.then_some(CarriedLight::Irradiance));
        let mut values: Vec<DVec3> = Vec::new();
        for layer in &viewer.layers {
            let Some(known) = layer.field else { continue };
            for light in lights.clone() {
                let field = surface.interpolate_irradiance(&light.texel_values(layer.mesh, known));
                values.extend(own.iter().map(|slot| field.slot_value(*slot)));
            }
        }
        let most = values
            .iter()
            .map(|value| value.abs().max_element())
            .filter(|most| most.is_finite());
        let step = most.fold(f64::MIN_POSITIVE, f64::max) / MAX_NODE_VALUE;
        Self {
            joins: slots()
                .filter(|(k, slot)| k != slot)
                .map(|(k, slot)| [k, slot])
                .collect(),
            knots,
            count: own.len(),
            fields: lights.count(),
            step,
            values: values
                .iter()
                .flat_map(|value| (value / step).to_array().map(f16::from_f64))
                .collect(),
        }
    }
}

/// Returns for each node whether it is a corner of a texel: half of a triangle's are not.
fn inside_nodes(surface: &InterpolationSurface) -> Vec<bool> {
    let inside = surface.face_grids.iter().flat_map(|grid| {
        let [w, h] = grid.size;
        let places = (0..=h).flat_map(move |j| (0..=w).map(move |i| [i, j]));
        places.map(move |[i, j]| grid.shape == Shape::Quad || i + j <= w)
    });
    inside.collect()
}

/// Returns whether ρ and E are constant on each face.
pub fn is_constant_per_face(mesh: &Mesh) -> bool {
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
