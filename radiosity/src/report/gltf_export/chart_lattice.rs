//! Node lattices of packed charts and the light at their nodes.
//!
//! A chart has the resolution of its face's texels, or of a finer neighbour across a shared edge.
//!
//! Both charts of a shared edge need the same nodes on it, those of the finer face: between nodes a chart is linear.

use crate::report::view::face_grid::FaceGrid;
use crate::report::view::interpolation::{InterpolatedField, InterpolationSurface};
use crate::report::view::weld::WELD_DISTANCE;
use common::scene::Shape;
use common::texel::triangle_index;
use glam::{DVec2, Vec3};

/// Node lattice of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartLattice {
    /// Intervals between nodes, across and down.
    pub size: [u32; 2],
    /// Intervals along each edge of the outline between nodes with values of their own.
    pub edge_steps: [u32; 4],
}

impl ChartLattice {
    /// Returns the lattices of all faces.
    pub fn for_all_faces(surface: &InterpolationSurface) -> Vec<Self> {
        let grids = &surface.face_grids;
        let mut edges: Vec<[u32; 4]> = grids.iter().map(texels_per_edge).collect();
        for (a, b) in &surface.pairs {
            let [a, b] = [*a, *b].map(|k| k as usize);
            for (i, j) in shared_edges(&grids[a], &grids[b]) {
                let [own, other] = [texels_per_edge(&grids[a])[i], texels_per_edge(&grids[b])[j]];
                let finer = own.max(other);
                // Otherwise neither lattice contains the other's nodes.
                if [own, other]
                    .into_iter()
                    .all(|n| finer % n == 0 && (finer / n).is_power_of_two())
                {
                    edges[a][i] = edges[a][i].max(finer);
                    edges[b][j] = edges[b][j].max(finer);
                }
            }
        }
        let lattices = grids.iter().zip(edges);
        lattices
            .map(|(grid, edges)| Self::from_edge_steps(grid, edges))
            .collect()
    }

    fn from_edge_steps(grid: &FaceGrid, edges: [u32; 4]) -> Self {
        let [a, b, c, d] = edges;
        let size = match grid.shape {
            Shape::Quad => [a.max(c), b.max(d)],
            Shape::Triangle => [a.max(b).max(c); 2],
        };
        Self {
            size,
            edge_steps: edges,
        }
    }

    /// Returns the two nodes between which node (i, j) is linearly interpolated and its share; twice the node itself
    /// where it has a value of its own.
    pub fn interpolation_nodes(&self, shape: Shape, [i, j]: [u32; 2]) -> ([[u32; 2]; 2], f32) {
        let [w, h] = self.size;
        let edge = match shape {
            _ if j == 0 => Some((0, w, i)),
            _ if i == 0 => Some((if shape == Shape::Quad { 3 } else { 2 }, h, j)),
            Shape::Quad if i == w => Some((1, h, j)),
            Shape::Quad if j == h => Some((2, w, i)),
            Shape::Triangle if i + j == w => Some((1, h, j)),
            _ => None,
        };
        let Some((edge, all, at)) = edge else {
            return ([[i, j]; 2], 0.0);
        };
        let step = all / self.edge_steps[edge];
        let (before, share) = (at - at % step, (at % step) as f32 / step as f32);
        if share == 0.0 {
            return ([[i, j]; 2], 0.0);
        }
        let node = |at: u32| match (shape, edge) {
            (_, 0) => [at, 0],
            (Shape::Quad, 1) => [w, at],
            (Shape::Quad, 2) => [at, h],
            (Shape::Triangle, 1) => [w - at, at],
            _ => [0, at],
        };
        ([node(before), node(before + step)], share)
    }
}

/// Returns the number of texels along each edge.
fn texels_per_edge(grid: &FaceGrid) -> [u32; 4] {
    let [w, h] = grid.size;
    [w, h, w, h]
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

/// Chart nodes of one face.
pub struct ChartNodes<'a> {
    /// Face index.
    pub face: u32,
    /// True if ρ and E vary over the face.
    pub painted: bool,
    /// Node lattice.
    pub lattice: &'a ChartLattice,
    /// Interpolated irradiance of the scene.
    pub light: &'a InterpolatedField<'a>,
}

impl ChartNodes<'_> {
    /// Returns B and H per node, row-major. Beyond a triangle's long side they are extrapolated as a plane, so that
    /// bilinear sampling is linear up to that side.
    pub fn chart_values(&self) -> Vec<[Vec3; 2]> {
        let shape = self.face_grid().shape;
        let [w, h] = self.lattice.size;
        let row = w as usize + 1;
        let mut chart: Vec<[Vec3; 2]> = Vec::with_capacity(row * (h as usize + 1));
        for j in 0..=h {
            for i in 0..=w {
                let k = chart.len();
                let beyond = shape == Shape::Triangle && i + j > w;
                chart.push(if beyond {
                    let [a, b, c] = [k - 1, k - row, k - row - 1].map(|k| chart[k]);
                    [0, 1].map(|n| a[n] + b[n] - c[n])
                } else {
                    let ([from, to], share) = self.lattice.interpolation_nodes(shape, [i, j]);
                    let [from, to] = [from, to].map(|node| self.node_value(node));
                    [0, 1].map(|n| from[n].lerp(to[n], share))
                });
            }
        }
        chart
    }

    fn face_grid(&self) -> &FaceGrid {
        &self.light.surface.face_grids[self.face as usize]
    }

    fn node_value(&self, [i, j]: [u32; 2]) -> [Vec3; 2] {
        let (grid, light) = (self.face_grid(), self.light);
        let [w, h] = self.lattice.size.map(f64::from);
        let [u, v] = [f64::from(i) / w, f64::from(j) / h];
        let point = grid.point_at(u, v);
        let texel = light.surface.texel_at(self.face, point);
        let stencil = light.surface.stencil_at(texel, point);
        let irradiance = light.stencil_value(&stencil).as_vec3();
        if !self.painted {
            return [light.radiosity_at(&stencil), irradiance];
        }
        // A node takes the mean emission and reflectance of the texels around it.
        let (mut emission, mut reflectance, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for index in adjacent_texels(grid, DVec2::new(u, v)) {
            let texel = light.surface.texel_of_index(self.face, index) as usize;
            emission += light.surface.mesh.texels[texel].emission;
            reflectance += light.surface.mesh.texels[texel].reflectance;
            count += 1.0;
        }
        [(emission + reflectance * irradiance) / count, irradiance]
    }
}

/// Returns the texels that meet at (u, v) of a face. Lattices are finer than texels by powers of two, so only the
/// texel count itself causes rounding.
fn adjacent_texels(grid: &FaceGrid, place: DVec2) -> Vec<u32> {
    let [w, h] = grid.size;
    let place = place * DVec2::new(f64::from(w), f64::from(h));
    let nearest = place.round();
    let place = DVec2::select((place - nearest).abs().cmplt(DVec2::splat(1e-6)), nearest, place);
    let squares = |at: f64| {
        let square = at.floor() as u32;
        let before = (at == at.floor()).then(|| square.checked_sub(1)).flatten();
        before.into_iter().chain([square])
    };
    let mut texels = Vec::new();
    for (b, a) in squares(place.y).flat_map(|b| squares(place.x).map(move |a| (b, a))) {
        if grid.shape == Shape::Quad {
            if a < w && b < h {
                texels.push(b * w + a);
            }
            continue;
        }
        // Of the two triangles of a square the upright one lies below the diagonal.
        let across = place.x - f64::from(a) + place.y - f64::from(b);
        if across < 1.0 + 1e-6 && a + b < h {
            texels.push(triangle_index(h, a, b, true));
        }
        if across > 1.0 - 1e-6 && a + b + 1 < h {
            texels.push(triangle_index(h, a, b, false));
        }
    }
    texels
}
