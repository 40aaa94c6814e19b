//! Texels merged two by two, each with its neighbours of the same face: where the light of the merged ones differs, texels
//! are too large.

use super::Halves;
use common::mesh::Mesh;
use common::resample::halve_even;
use common::texel::{Texel, TexelKind, triangle_index};
use glam::Vec3A;

/// The texels of a mesh in groups: on each face two by two, or in pairs or alone where a side has an odd number of them.
pub struct MergedTexels {
    /// Group of each texel.
    group_of: Vec<u32>,
    /// Open area of each texel over that of its group.
    share: Vec<f32>,
    group_count: usize,
}

impl MergedTexels {
    /// Merges the texels of `mesh`, of these `open` shares.
    pub fn new(mesh: &Mesh, open: &[f32]) -> Self {
        let mut group_count = 0;
        let mut first_of_face = Vec::with_capacity(mesh.faces.len());
        for face in &mesh.faces {
            first_of_face.push(group_count);
            let [w, h] = halve_even(face.resolution);
            group_count += (w * h) as usize;
        }
        let group = |texel: &Texel| {
            let resolution = mesh.faces[texel.face as usize].resolution;
            first_of_face[texel.face as usize] as u32 + group_index(texel, resolution)
        };
        let group_of: Vec<u32> = mesh.texels.iter().map(group).collect();
        let mut areas = vec![0.0; group_count];
        let open_area = |k: usize| mesh.texels[k].area * open[k];
        for (k, group) in group_of.iter().enumerate() {
            areas[*group as usize] += open_area(k);
        }
        let share = |(k, group): (usize, &u32)| match areas[*group as usize] {
            area if area > 0.0 => open_area(k) / area,
            _ => 0.0,
        };
        Self {
            share: group_of.iter().enumerate().map(share).collect(),
            group_of,
            group_count,
        }
    }

    /// Replaces each texel's radiosity by the mean of its group.
    pub fn average_groups(&self, radiosity: &mut [Halves]) {
        let mut means = vec![[Vec3A::ZERO; 2]; self.group_count];
        for ((values, group), share) in radiosity.iter().zip(&self.group_of).zip(&self.share) {
            for (mean, value) in means[*group as usize].iter_mut().zip(values) {
                *mean += *value * *share;
            }
        }
        for (values, group) in radiosity.iter_mut().zip(&self.group_of) {
            *values = means[*group as usize];
        }
    }
}

/// Returns the index on its face of the merged texel that holds `texel` of a face of W×H texels.
fn group_index(texel: &Texel, [w, h]: [u32; 2]) -> u32 {
    let [wide, high] = halve_even([w, h]);
    let [along, across] = [w / wide, h / high];
    let [i, j] = texel.lattice_corner;
    let (column, row) = (i / along, j / across);
    // Lines of constant i + j bound sub-triangles, too.
    let is_upright = |diagonal: u32| diagonal / across == row + column;
    match texel.kind {
        TexelKind::Quad => row * wide + column,
        TexelKind::Upright => triangle_index(high, column, row, is_upright(i + j)),
        TexelKind::Inverted => triangle_index(high, column, row, is_upright(i + j + 1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::resample::shared_pieces;
    use common::scene::{Face, Scene};
    use glam::{DVec3, Vec3};

    /// The group of a texel is the larger texel with which it shares area.
    #[test]
    fn groups_are_the_texels_of_half_the_resolution() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let quad = Face::quad("quad", corners, Vec3::ZERO, Vec3::ONE);
        let triangle = Face::triangle("triangle", [corners[0], corners[1], corners[3]], Vec3::ZERO, Vec3::ONE);
        let mut merged = 0;
        for (face, sizes) in [
            (quad, vec![[4, 2], [3, 6], [1, 1], [8, 5]]),
            (triangle, vec![[8, 8], [6, 6], [3, 3], [2, 2]]),
        ] {
            for size in sizes {
                let scene = Scene {
                    faces: vec![face.clone()],
                    ..Scene::default()
                };
                let mesh = Mesh::new(&scene, &[size], 1).unwrap();
                let pieces = shared_pieces(&face, size, halve_even(size));
                assert_eq!(pieces.len(), mesh.texels.len());
                for piece in pieces {
                    let texel = mesh.texels.iter().find(|texel| texel.index == piece.from).unwrap();
                    assert_eq!(group_index(texel, size), piece.to, "{size:?} {}", piece.from);
                    merged += u32::from(piece.from != piece.to);
                }
            }
        }
        assert!(merged > 50);
    }
}
