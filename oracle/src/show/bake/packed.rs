//! Charts of our own, one a face.
//!
//! A face's chart has a pixel for each node of its texels' lattice, and its corners lie on pixel centres. So
//! nothing beside a chart is ever sampled, what lies between pixels is what lies between nodes, and faces that
//! share an edge share the nodes on it and their values: bilinear sampling shows no seam.

use super::glb::{Part, parts};
use super::image::Image;
use super::lattice::Lattice;
use super::nodes::Nodes;
use crate::show::view::surface::Interpolant;
use common::Result;
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A quad is drawn as two triangles if its sides are parallel but for this share of them.
const PARALLEL: f64 = 1e-6;

/// The picture and what it lies on.
///
/// Errors: charts that are too many for one picture.
pub fn lay<'a>(scene: &'a Scene, light: &Interpolant) -> Result<(Image, Vec<Part<'a>>)> {
    let lattices = Lattice::all(light.surface);
    let nodes: Vec<[u32; 2]> = lattices.iter().map(|l| l.size.map(|n| n + 1)).collect();
    let charts = Mesh::new(scene, &nodes, 1)?;
    let faces = scene.faces.par_iter().zip(&lattices).enumerate();
    let chart = |(k, (face, lattice)): (usize, (&Face, &Lattice))| {
        let nodes = Nodes {
            face: k as u32,
            painted: face.paint.is_some(),
            lattice,
            light,
        };
        nodes.chart()
    };
    let own: Vec<Vec<[Vec3; 2]>> = faces.map(chart).collect();
    let mut image = Image::dark(charts.atlas);
    for (face, own) in charts.faces.iter().zip(own) {
        let [x, y, w, _] = face.rect;
        for (k, light) in (0..).zip(own) {
            image.put([x + k % w, y + k / w], light);
        }
    }
    let parts = parts(scene, |part, k| {
        part.add(&scene.faces[k], charts.faces[k].rect, charts.atlas);
    });
    Ok((image, parts))
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
