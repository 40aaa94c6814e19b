//! A solved scene as glTF: its faces with their light on them, and that light as numbers.
//!
//! A face's chart has a pixel for each node of its texels' lattice, and its corners lie on pixel centres. So
//! nothing beside a chart is ever sampled, what lies between pixels is what lies between nodes, and faces that
//! share nodes share their values: bilinear sampling shows no seam.

use super::page::short;
use super::picture::{Exposure, Picture, encode};
use super::view::patch::Patch;
use super::view::surface::{Interpolant, Surface};
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use common::shooting::Field;
use common::solution::write::encode as openexr;
use common::texel::triangle_index;
use common::{Error, Result};
use glam::{DVec3, Vec3};
use gltf::Glb;
use gltf::binary::Header;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::borrow::Cow;

/// A quad is drawn as two triangles if its sides are parallel but for this share of them.
const PARALLEL: f64 = 1e-6;

/// Both files, not written yet.
pub struct Baked {
    /// The scene with its light as a texture: what is white stands in the material's `extras`.
    pub glb: Vec<u8>,
    /// The same charts as OpenEXR: R, G, B are radiosity, and `irradiance.*`; W/m².
    pub exr: Vec<u8>,
}

/// Bakes `scene` as `field` has solved it on the texels of `mesh`.
///
/// Errors: charts that are too many for one picture; [`Error::Fault`] of an encoder.
pub fn bake(scene: &Scene, mesh: &Mesh, field: &Field, exposure: Exposure) -> Result<Baked> {
    let nodes: Vec<[u32; 2]> = mesh
        .faces
        .iter()
        .map(|f| f.resolution.map(|n| n + 1))
        .collect();
    let charts = Mesh::new(scene, &nodes, 1)?;
    let surface = Surface::new(scene, mesh);
    let light = surface.interpolate(&field.irradiance);
    let painted: Vec<bool> = scene.faces.iter().map(|f| f.paint.is_some()).collect();
    let image = Image::new(&charts, &painted, &light);
    let white = Exposure::linear(exposure.white);
    let picture = Picture::from_pixels(image.size[0], image.size[1], |x, y| {
        let radiosity = image.radiosity[(y * image.size[0] + x) as usize];
        Some(encode(white.display(radiosity)))
    });
    let parts = parts(scene, &charts);
    let glb = glb(scene, &parts, &picture.png(), white.white);
    Ok(Baked {
        glb: glb.map_err(|error| Error::Fault(error.to_string()))?,
        exr: image.exr()?,
    })
}

/// Values at the pixels of all charts; black elsewhere.
struct Image {
    size: [u32; 2],
    radiosity: Vec<Vec3>,
    irradiance: Vec<Vec3>,
}

impl Image {
    fn new(charts: &Mesh, painted: &[bool], light: &Interpolant) -> Self {
        let size = charts.atlas;
        let count = size[0] as usize * size[1] as usize;
        let mut image = Self {
            size,
            radiosity: vec![Vec3::ZERO; count],
            irradiance: vec![Vec3::ZERO; count],
        };
        let faces = 0..charts.faces.len();
        let chart = |f: usize| chart(f, painted[f], light);
        let own: Vec<Vec<[Vec3; 2]>> = faces.into_par_iter().map(chart).collect();
        for (face, own) in charts.faces.iter().zip(own) {
            let [x, y, w, _] = face.rect;
            for (k, [radiosity, irradiance]) in (0..).zip(own) {
                let at = ((y + k / w) * size[0] + x + k % w) as usize;
                image.radiosity[at] = radiosity;
                image.irradiance[at] = irradiance;
            }
        }
        image
    }

    fn exr(&self) -> Result<Vec<u8>> {
        let mut planes = Vec::new();
        for (prefix, values) in [("", &self.radiosity), ("irradiance.", &self.irradiance)] {
            for (c, letter) in ["R", "G", "B"].into_iter().enumerate() {
                let plane = values.iter().map(|v| v[c]).collect();
                planes.push((format!("{prefix}{letter}"), plane));
            }
        }
        let size = self.size.map(|n| n as usize);
        openexr(size, planes).map_err(|error| Error::Fault(error.to_string()))
    }
}

/// B and H at the nodes of face `f`, row by row. Beyond a triangle's long side they go on as the plane through
/// the three nodes before it, so that bilinear sampling is linear up to that side.
fn chart(f: usize, painted: bool, light: &Interpolant) -> Vec<[Vec3; 2]> {
    let patch = &light.surface.patches[f];
    let [w, h] = patch.size;
    let row = w as usize + 1;
    let mut chart: Vec<[Vec3; 2]> = Vec::with_capacity(row * (h as usize + 1));
    for j in 0..=h {
        for i in 0..=w {
            let k = chart.len();
            let beyond = patch.shape == Shape::Triangle && i + j > w;
            chart.push(if beyond {
                let [a, b, c] = [k - 1, k - row, k - row - 1].map(|k| chart[k]);
                [0, 1].map(|n| a[n] + b[n] - c[n])
            } else {
                at(patch, (f, painted), light, [i, j])
            });
        }
    }
    chart
}

fn at(
    patch: &Patch,
    (f, painted): (usize, bool),
    light: &Interpolant,
    [i, j]: [u32; 2],
) -> [Vec3; 2] {
    let point = patch.position([2 * i, 2 * j]);
    let texel = light.surface.texel(f as u32, point);
    let stencil = light.surface.stencil(texel, point);
    let irradiance = light.value(&stencil).as_vec3();
    if !painted {
        return [light.radiosity(&stencil), irradiance];
    }
    // A node is nobody's: it reflects and emits as the texels around it do in the mean.
    let (mut emission, mut reflectance, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    for index in around(patch, [i, j]) {
        let texel = light.surface.texel_in(f as u32, index) as usize;
        emission += light.surface.mesh.texels[texel].emission;
        reflectance += light.surface.mesh.texels[texel].reflectance;
        count += 1.0;
    }
    [(emission + reflectance * irradiance) / count, irradiance]
}

/// The texels that meet in a node.
fn around(patch: &Patch, [i, j]: [u32; 2]) -> Vec<u32> {
    let [w, h] = patch.size;
    let below = |k: u32| k.checked_sub(1);
    let corners = [
        (Some(i), Some(j)),
        (below(i), Some(j)),
        (Some(i), below(j)),
        (below(i), below(j)),
    ];
    let corners = corners.into_iter().enumerate();
    let corners = corners.filter_map(|(n, (a, b))| Some((n, a?, b?)));
    if patch.shape == Shape::Quad {
        let inside = corners.filter(|(_, a, b)| *a < w && *b < h);
        return inside.map(|(_, a, b)| b * w + a).collect();
    }
    let mut found = Vec::new();
    for (n, a, b) in corners {
        // An upright one has corners at (a, b), (a + 1, b) and (a, b + 1), an inverted one at all but (a, b).
        if n < 3 && a + b < h {
            found.push(triangle_index(h, a, b, true));
        }
        if n > 0 && a + b + 1 < h {
            found.push(triangle_index(h, a, b, false));
        }
    }
    found
}

/// The faces of one name.
struct Part<'a> {
    name: &'a str,
    places: Vec<Vec3>,
    uvs: Vec<[f32; 2]>,
    index: Vec<u32>,
}

/// Faces that follow each other and have one name are one part.
fn parts<'a>(scene: &'a Scene, charts: &Mesh) -> Vec<Part<'a>> {
    let mut parts: Vec<Part> = Vec::new();
    for (face, chart) in scene.faces.iter().zip(&charts.faces) {
        if parts.last().is_none_or(|part| part.name != face.name) {
            parts.push(Part {
                name: &face.name,
                places: Vec::new(),
                uvs: Vec::new(),
                index: Vec::new(),
            });
        }
        if let Some(part) = parts.last_mut() {
            part.add(face, chart.rect, charts.atlas);
        }
    }
    parts
}

impl Part<'_> {
    fn add(&mut self, face: &Face, [x, y, w, h]: [u32; 4], size: [u32; 2]) {
        let [a, b, c, d] = face.corners;
        let first = self.places.len() as u32;
        let mut put = |place: DVec3, [i, j]: [u32; 2]| {
            self.places.push(place.as_vec3());
            let at = |start: u32, k: u32, all: u32| (f64::from(start + k) + 0.5) / f64::from(all);
            let uv = [at(x, i, size[0]), at(y, j, size[1])];
            self.uvs.push(uv.map(|t| t as f32));
        };
        let (w, h) = (w - 1, h - 1);
        if face.shape == Shape::Triangle {
            put(a, [0, 0]);
            put(b, [w, 0]);
            put(c, [0, h]);
            self.index.extend([0, 1, 2].map(|k| first + k));
            return;
        }
        // A texture goes straight over triangles: where a quad's sides are not parallel, node by node.
        let skew = (a - b + c - d).length() > PARALLEL * (c - a).length();
        let (m, n) = if skew { (w, h) } else { (1, 1) };
        for j in 0..=n {
            for i in 0..=m {
                let (u, v) = (f64::from(i) / f64::from(m), f64::from(j) / f64::from(n));
                put(
                    a.lerp(b, u).lerp(d.lerp(c, u), v),
                    [i * (w / m), j * (h / n)],
                );
            }
        }
        for (i, j) in (0..n).flat_map(|j| (0..m).map(move |i| (i, j))) {
            let k = first + j * (m + 1) + i;
            self.index
                .extend([k, k + 1, k + m + 2, k, k + m + 2, k + m + 1]);
        }
    }
}

/// The file: a mesh and a node for each part, one material, one picture.
fn glb(
    scene: &Scene,
    parts: &[Part],
    png: &[u8],
    white: f32,
) -> std::result::Result<Vec<u8>, gltf::Error> {
    let mut file = File::default();
    let mut meshes = Vec::new();
    for part in parts {
        let places: Vec<f32> = part.places.iter().flat_map(|p| p.to_array()).collect();
        let low = part.places.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = part
            .places
            .iter()
            .copied()
            .fold(Vec3::NEG_INFINITY, Vec3::max);
        let bounds = json!({ "min": low.to_array(), "max": high.to_array() });
        let floats = |v: &[f32]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let count = part.places.len();
        let place = file.accessor(&floats(&places), 34962, (5126, "VEC3", count), bounds);
        let uvs = floats(&part.uvs.concat());
        let uv = file.accessor(&uvs, 34962, (5126, "VEC2", count), json!({}));
        let index: Vec<u8> = part.index.iter().flat_map(|k| k.to_le_bytes()).collect();
        let of = (5125, "SCALAR", part.index.len());
        let index = file.accessor(&index, 34963, of, json!({}));
        meshes.push(json!({ "name": part.name, "primitives": [{
            "attributes": { "POSITION": place, "TEXCOORD_0": uv, "TEXCOORD_1": uv },
            "indices": index, "material": 0,
        }] }));
    }
    let image = file.view(png, None);
    let nodes = parts.iter().enumerate();
    let nodes: Vec<Value> = nodes
        .map(|(k, part)| json!({ "name": part.name, "mesh": k }))
        .collect();
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("radiosity ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": short(&scene.name), "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "extensionsUsed": ["KHR_materials_unlit"],
        "materials": [{
            "name": "baked radiosity",
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1 }, "metallicFactor": 0.0 },
            "extensions": { "KHR_materials_unlit": {} },
            "extras": { "white": white, "unit": "W/m²" },
        }],
        "textures": [{ "source": 0, "sampler": 0 }],
        // Bilinear, clamped: coarser levels would mix charts.
        "samplers": [{ "magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071 }],
        "images": [{ "name": "radiosity", "mimeType": "image/png", "bufferView": image }],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "byteLength": file.bytes.len() }],
    });
    let glb = Glb {
        header: Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        },
        json: Cow::Owned(document.to_string().into_bytes()),
        bin: Some(Cow::Owned(file.bytes)),
    };
    glb.to_vec()
}

/// The binary part of a file, and what lies where.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view =
            json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(
        &mut self,
        bytes: &[u8],
        target: u32,
        (kind, of, count): (u32, &str, usize),
        mut told: Value,
    ) -> usize {
        told["bufferView"] = self.view(bytes, Some(target)).into();
        told["componentType"] = kind.into();
        told["type"] = of.into();
        told["count"] = count.into();
        self.accessors.push(told);
        self.accessors.len() - 1
    }
}
