//! Light at the nodes of a chart.

use super::lattice::Lattice;
use crate::show::view::patch::Patch;
use crate::show::view::surface::Interpolant;
use common::scene::Shape;
use common::texel::triangle_index;
use glam::{DVec2, Vec3};

/// Those of a face.
pub struct Nodes<'a> {
    /// It.
    pub face: u32,
    /// Whether ρ and E vary over it.
    pub painted: bool,
    /// How finely.
    pub lattice: &'a Lattice,
    /// Everywhere.
    pub light: &'a Interpolant<'a>,
}

impl Nodes<'_> {
    /// B and H, row by row. Beyond a triangle's long side they go on as the plane through the three nodes before
    /// it, so that bilinear sampling is linear up to that side.
    pub fn chart(&self) -> Vec<[Vec3; 2]> {
        let shape = self.patch().shape;
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
                    let ([from, to], share) = self.lattice.between(shape, [i, j]);
                    let [from, to] = [from, to].map(|node| self.at(node));
                    [0, 1].map(|n| from[n].lerp(to[n], share))
                });
            }
        }
        chart
    }

    fn patch(&self) -> &Patch {
        &self.light.surface.patches[self.face as usize]
    }

    fn at(&self, [i, j]: [u32; 2]) -> [Vec3; 2] {
        let (patch, light) = (self.patch(), self.light);
        let [w, h] = self.lattice.size.map(f64::from);
        let [u, v] = [f64::from(i) / w, f64::from(j) / h];
        let point = patch.point(u, v);
        let texel = light.surface.texel(self.face, point);
        let stencil = light.surface.stencil(texel, point);
        let irradiance = light.value(&stencil).as_vec3();
        if !self.painted {
            return [light.radiosity(&stencil), irradiance];
        }
        // A node is nobody's: it reflects and emits as the texels around it do in the mean.
        let (mut emission, mut reflectance, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for index in around(patch, DVec2::new(u, v)) {
            let texel = light.surface.texel_in(self.face, index) as usize;
            emission += light.surface.mesh.texels[texel].emission;
            reflectance += light.surface.mesh.texels[texel].reflectance;
            count += 1.0;
        }
        [(emission + reflectance * irradiance) / count, irradiance]
    }
}

/// The texels that meet at a place (u, v) of a face. Lattices are finer than texels by powers of two: nothing is
/// rounded but by a number of texels that is none, and back.
fn around(patch: &Patch, place: DVec2) -> Vec<u32> {
    let [w, h] = patch.size;
    let place = place * DVec2::new(f64::from(w), f64::from(h));
    let nearest = place.round();
    let place = DVec2::select(
        (place - nearest).abs().cmplt(DVec2::splat(1e-6)),
        nearest,
        place,
    );
    let cells = |at: f64| {
        let cell = at.floor() as u32;
        let before = (at == at.floor()).then(|| cell.checked_sub(1)).flatten();
        before.into_iter().chain([cell])
    };
    let mut found = Vec::new();
    for (b, a) in cells(place.y).flat_map(|b| cells(place.x).map(move |a| (b, a))) {
        if patch.shape == Shape::Quad {
            if a < w && b < h {
                found.push(b * w + a);
            }
            continue;
        }
        // Of the two triangles of a cell the upright one lies below its diagonal.
        let across = place.x - f64::from(a) + place.y - f64::from(b);
        if across < 1.0 + 1e-6 && a + b < h {
            found.push(triangle_index(h, a, b, true));
        }
        if across > 1.0 - 1e-6 && a + b + 1 < h {
            found.push(triangle_index(h, a, b, false));
        }
    }
    found
}
