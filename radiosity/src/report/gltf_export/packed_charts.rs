//! Renders the lightmap on packed charts, one per face.
//!
//! A chart has a pixel per lattice node, and its corners lie on pixel centres. Bilinear sampling therefore never
//! reads outside a chart and equals the interpolation between nodes. Faces that share an edge share its nodes and
//! their values: there is no seam.

use super::chart_lattice::{ChartLattice, ChartNodes};
use super::glb::{MeshPart, group_parts};
use super::lightmap_image::LightmapImage;
use crate::report::view::interpolation::InterpolatedField;
use common::Result;
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A quad is drawn as two triangles if it is a parallelogram up to this share of its diagonal.
const PARALLELOGRAM_TOLERANCE: f64 = 1e-6;

/// Renders the lightmap; returns it with the mesh parts.
///
/// Errors: the charts do not fit in one picture.
pub fn render_packed_charts<'a>(
    scene: &'a Scene,
    light: &InterpolatedField,
) -> Result<(LightmapImage, Vec<MeshPart<'a>>)> {
    let lattices = ChartLattice::for_all_faces(light.surface);
    let nodes: Vec<[u32; 2]> = lattices.iter().map(|l| l.size.map(|n| n + 1)).collect();
    let charts = Mesh::new(scene, &nodes, 1)?;
    let faces = scene.faces.par_iter().zip(&lattices).enumerate();
    let chart = |(k, (face, lattice)): (usize, (&Face, &ChartLattice))| {
        let nodes = ChartNodes {
            face: k as u32,
            painted: face.paint.is_some(),
            lattice,
            light,
        };
        nodes.chart_values()
    };
    let own: Vec<Vec<[Vec3; 2]>> = faces.map(chart).collect();
    let mut image = LightmapImage::new_black(charts.atlas);
    for (face, own) in charts.faces.iter().zip(own) {
        let [x, y, w, _] = face.rect;
        for (k, light) in (0..).zip(own) {
            image.set_pixel([x + k % w, y + k / w], light);
        }
    }
    let parts = group_parts(scene, |part, k| {
        part.add_face(&scene.faces[k], charts.faces[k].rect, charts.atlas);
    });
    Ok((image, parts))
}

impl MeshPart<'_> {
    /// Appends a face whose chart is the rectangle (x, y, w, h) of a picture of `size` pixels.
    fn add_face(&mut self, face: &Face, [x, y, w, h]: [u32; 4], size: [u32; 2]) {
        let [a, b, c, d] = face.corners;
        let first = self.positions.len() as u32;
        let mut put = |place: DVec3, [i, j]: [u32; 2]| {
            self.positions.push(place.as_vec3());
            let at = |start: u32, k: u32, all: u32| (f64::from(start + k) + 0.5) / f64::from(all);
            let uv = [at(x, i, size[0]), at(y, j, size[1])];
            self.uvs.push(uv.map(|t| t as f32));
        };
        let (w, h) = (w - 1, h - 1);
        if face.shape == Shape::Triangle {
            put(a, [0, 0]);
            put(b, [w, 0]);
            put(c, [0, h]);
            self.indices.extend([0, 1, 2].map(|k| first + k));
            return;
        }
        // Textures are affine on triangles, so other quads are divided node by node.
        let skew = (a - b + c - d).length() > PARALLELOGRAM_TOLERANCE * (c - a).length();
        let (m, n) = if skew { (w, h) } else { (1, 1) };
        for j in 0..=n {
            for i in 0..=m {
                let (u, v) = (f64::from(i) / f64::from(m), f64::from(j) / f64::from(n));
                put(a.lerp(b, u).lerp(d.lerp(c, u), v), [i * (w / m), j * (h / n)]);
            }
        }
        for (i, j) in (0..n).flat_map(|j| (0..m).map(move |i| (i, j))) {
            let k = first + j * (m + 1) + i;
            self.indices.extend([k, k + 1, k + m + 2, k, k + m + 2, k + m + 1]);
        }
    }
}
