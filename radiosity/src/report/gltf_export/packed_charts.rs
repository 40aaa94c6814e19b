//! Renders the lightmap on packed charts, one per face.
//!
//! A chart has a pixel per node of a lattice as fine as its face's texels, or as those of a finer neighbour across a
//! shared edge; its corners lie on pixel centres. Bilinear sampling therefore never reads outside a chart and equals
//! the interpolation between nodes. Both charts of a shared edge have the same values on it, those at the nodes of the
//! finer face: there is no seam.

use super::LightmapImage;
use super::glb::{MeshPart, group_parts};
use crate::report::view::face_grid::{FaceGrid, LatticeNode};
use crate::report::view::interpolation::{InterpolatedField, InterpolationSurface};
use crate::report::view::weld::WELD_DISTANCE;
use common::Result;
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// A quad is drawn as two triangles if it is a parallelogram up to this share of its diagonal.
const PARALLELOGRAM_TOLERANCE: f64 = 1e-6;
/// Directions around a node, at least one of them towards each texel that meets there.
const NODE_DIRECTIONS: u32 = 24;
/// Distance from a node at which the texels around it are looked up, as a share of a texel.
const NODE_RADIUS: f64 = 1e-3;

/// Renders the lightmap; returns it with the mesh parts.
///
/// Errors: the charts do not fit in one picture.
pub fn render_packed_charts<'a>(
    scene: &'a Scene,
    light: &InterpolatedField,
) -> Result<(LightmapImage, Vec<MeshPart<'a>>)> {
    let steps = edge_steps(light.surface);
    let grids = light.surface.face_grids.iter().zip(&steps);
    let lattices: Vec<FaceGrid> = grids.map(|(grid, steps)| chart_lattice(grid, *steps)).collect();
    let nodes: Vec<[u32; 2]> = lattices.iter().map(|l| l.size.map(|n| n + 1)).collect();
    let charts = Mesh::new(scene, &nodes, 1)?;
    let faces = scene.faces.par_iter().enumerate();
    let own = faces.map(|(k, face)| chart_values(light, (k as u32, face), &lattices[k], steps[k]));
    let own: Vec<Vec<[Vec3; 2]>> = own.collect();
    let [width, height] = charts.atlas.map(|n| n as usize);
    let mut image = vec![[Vec3::ZERO; 2]; width * height];
    for (face, own) in charts.faces.iter().zip(own) {
        let [x, y, w, _] = face.rect.map(|n| n as usize);
        for (row, pixels) in own.chunks_exact(w).enumerate() {
            let start = (y + row) * width + x;
            image[start..start + w].copy_from_slice(pixels);
        }
    }
    let parts = group_parts(scene, |part, k| {
        part.add_face(&scene.faces[k], charts.faces[k].rect, charts.atlas);
    });
    let image = LightmapImage {
        size: charts.atlas,
        light: image,
    };
    Ok((image, parts))
}

/// Returns the intervals along each edge of each face between nodes with values of their own.
fn edge_steps(surface: &InterpolationSurface) -> Vec<[u32; 4]> {
    let grids = &surface.face_grids;
    let own: Vec<[u32; 4]> = grids.iter().map(|grid| [0, 1, 0, 1].map(|k| grid.size[k])).collect();
    let mut steps = own.clone();
    for (a, b) in &surface.pairs {
        let [a, b] = [*a, *b].map(|k| k as usize);
        for (i, j) in shared_edges(&grids[a], &grids[b]) {
            let (least, most) = (own[a][i].min(own[b][j]), own[a][i].max(own[b][j]));
            // Otherwise neither lattice contains the other's nodes.
            if most % least == 0 && (most / least).is_power_of_two() {
                steps[a][i] = steps[a][i].max(most);
                steps[b][j] = steps[b][j].max(most);
            }
        }
    }
    steps
}

/// Returns the pairs of edges that join the same two corners.
fn shared_edges(a: &FaceGrid, b: &FaceGrid) -> Vec<(usize, usize)> {
    let edges = (0..a.edge_count()).flat_map(|i| (0..b.edge_count()).map(move |j| (i, j)));
    let same = |(i, j): &(usize, usize)| {
        let ([from, to], [there, back]) = (a.edge_ends(*i), b.edge_ends(*j));
        from.distance(back) < WELD_DISTANCE && to.distance(there) < WELD_DISTANCE
    };
    edges.filter(same).collect()
}

/// Returns the lattice that contains the nodes of all edges.
fn chart_lattice(grid: &FaceGrid, [a, b, c, d]: [u32; 4]) -> FaceGrid {
    let size = match grid.shape {
        Shape::Quad => [a.max(c), b.max(d)],
        Shape::Triangle => [a.max(b).max(c); 2],
    };
    FaceGrid { size, ..grid.clone() }
}

/// Returns B and H per node of a lattice, row-major. Beyond a triangle's long side they are extrapolated as a plane, so
/// that bilinear sampling is linear up to that side.
fn chart_values(
    light: &InterpolatedField,
    (k, face): (u32, &Face),
    lattice: &FaceGrid,
    steps: [u32; 4],
) -> Vec<[Vec3; 2]> {
    let [w, h] = lattice.size;
    let row = w as usize + 1;
    let is_beyond = |[i, j]: [u32; 2]| lattice.shape == Shape::Triangle && i + j > w;
    let places: Vec<[u32; 2]> = (0..=h).flat_map(|j| (0..=w).map(move |i| [i, j])).collect();
    let mut values = vec![[Vec3::ZERO; 2]; places.len()];
    for (value, [i, j]) in values.iter_mut().zip(&places).filter(|(_, at)| !is_beyond(**at)) {
        let at = DVec2::new(f64::from(*i) / f64::from(w), f64::from(*j) / f64::from(h));
        *value = node_light(light, k, face.paint.is_some(), at);
    }
    for (edge, steps) in steps.into_iter().enumerate().take(lattice.edge_count()) {
        let index = |[a, b]: LatticeNode| (b / 2) as usize * row + (a / 2) as usize;
        let nodes: Vec<usize> = lattice
            .edge_nodes(edge)
            .step_by(2)
            .map(|(_, node)| index(node))
            .collect();
        let stride = (nodes.len() - 1) / steps as usize;
        for (i, node) in nodes.iter().enumerate().filter(|(i, _)| i % stride > 0) {
            let (before, share) = (i - i % stride, (i % stride) as f32 / stride as f32);
            let [from, to] = [before, before + stride].map(|i| values[nodes[i]]);
            values[*node] = [0, 1].map(|n| from[n].lerp(to[n], share));
        }
    }
    for (k, _) in places.iter().enumerate().filter(|(_, at)| is_beyond(**at)) {
        let [a, b, c] = [k - 1, k - row, k - row - 1].map(|k| values[k]);
        values[k] = [0, 1].map(|n| a[n] + b[n] - c[n]);
    }
    values
}

/// Returns B and H at (u, v) of face `k`.
fn node_light(light: &InterpolatedField, k: u32, is_painted: bool, at: DVec2) -> [Vec3; 2] {
    let (surface, grid) = (light.surface, &light.surface.face_grids[k as usize]);
    let point = grid.point_at(at.x, at.y);
    let [radiosity, irradiance] = light.light_at(k, point);
    if !is_painted {
        return [radiosity, irradiance];
    }
    // ρ and E vary over the face: a node takes their mean over the texels around it.
    let radius = NODE_RADIUS / DVec2::new(f64::from(grid.size[0]), f64::from(grid.size[1]));
    let around: BTreeSet<u32> = (0..NODE_DIRECTIONS)
        .map(|turn| {
            let angle = TAU * (f64::from(turn) + 0.5) / f64::from(NODE_DIRECTIONS);
            let beside = at + radius * DVec2::from_angle(angle);
            surface.texel_at(k, grid.point_at(beside.x, beside.y))
        })
        .collect();
    let texels = || around.iter().map(|texel| &surface.mesh.texels[*texel as usize]);
    let emission: Vec3 = texels().map(|texel| texel.emission).sum();
    let reflectance: Vec3 = texels().map(|texel| texel.reflectance).sum();
    [(emission + reflectance * irradiance) / around.len() as f32, irradiance]
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
