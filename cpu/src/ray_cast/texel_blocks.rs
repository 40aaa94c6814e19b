//! Blocks of texels that receive light by the same rays where it varies little: on a finely divided face, few rays then
//! serve many texels.

use common::mesh::Mesh;
use common::texel::{Texel, TexelKind, first_texels};
use glam::Vec3;
use std::ops::Range;

const NO_BLOCK: u32 = u32::MAX;

/// The texels of a mesh in blocks. A block is a rectangle on the lattice of a quad, or one texel.
pub struct TexelBlocks {
    /// Block of each texel.
    block_of: Vec<u32>,
    /// Texels along and across of each texel's block.
    sizes: Vec<[u32; 2]>,
    /// The texels, block by block.
    members: Vec<u32>,
    /// First member of each block, and the number of all.
    firsts: Vec<u32>,
}

impl TexelBlocks {
    /// Divides the texels of `mesh`: texel k of a quad lies in a block of `sizes[k]` texels along and across, whose corner is
    /// at multiples of these on the lattice. A block with a texel that `is_alone` is divided into its texels.
    pub fn new(mesh: &Mesh, mut sizes: Vec<[u32; 2]>, is_alone: impl Fn(usize) -> bool) -> Self {
        let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|face| face.resolution).collect();
        let starts = first_texels(&resolutions);
        // Place of the corner of a texel's block in the order of faces.
        let corner = |texel: &Texel, [along, across]: [u32; 2]| {
            let (face, [i, j]) = (texel.face as usize, texel.lattice_corner);
            let index = match texel.kind {
                TexelKind::Quad => (j - j % across) * resolutions[face][0] + i - i % along,
                _ => texel.index,
            };
            starts[face] + index as usize
        };
        let mut is_divided = vec![false; sizes.len()];
        for (k, texel) in mesh.texels.iter().enumerate().filter(|(k, _)| is_alone(*k)) {
            is_divided[corner(texel, sizes[k])] = true;
        }
        for (texel, size) in mesh.texels.iter().zip(&mut sizes) {
            if texel.kind != TexelKind::Quad || is_divided[corner(texel, *size)] {
                *size = [1; 2];
            }
        }
        let mut numbers = vec![NO_BLOCK; sizes.len()];
        let mut block_of = Vec::with_capacity(sizes.len());
        let mut counts = Vec::new();
        for (texel, size) in mesh.texels.iter().zip(&sizes) {
            let number = &mut numbers[corner(texel, *size)];
            if *number == NO_BLOCK {
                *number = counts.len() as u32;
                counts.push(0);
            }
            counts[*number as usize] += 1;
            block_of.push(*number);
        }
        let mut firsts = vec![0];
        for (block, count) in counts.iter().enumerate() {
            firsts.push(firsts[block] + count);
        }
        let mut next = firsts.clone();
        let mut members = vec![0; sizes.len()];
        for (k, block) in block_of.iter().enumerate() {
            members[next[*block as usize] as usize] = k as u32;
            next[*block as usize] += 1;
        }
        Self {
            block_of,
            sizes,
            members,
            firsts,
        }
    }

    /// Returns the number of blocks.
    pub fn len(&self) -> usize {
        self.firsts.len() - 1
    }

    /// Returns the texels of a block.
    pub fn members(&self, block: usize) -> &[u32] {
        let range: Range<usize> = self.firsts[block] as usize..self.firsts[block + 1] as usize;
        &self.members[range]
    }

    /// Returns the sum of the `values` of the texels of each block.
    pub fn sum_blocks(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.len()];
        for (value, block) in values.zip(&self.block_of) {
            sums[*block as usize] += value;
        }
        sums
    }

    /// Returns the value of each texel's block.
    pub fn spread_blocks<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.block_of.iter().map(|block| values[*block as usize]).collect()
    }

    /// Replaces the value of each texel in a block by the mean over the block's width around it, along and then across: a
    /// linear interpolation between equal blocks.
    pub fn interpolate_blocks(&self, mesh: &Mesh, values: &mut [Vec3]) {
        let order = mesh.texels_in_face_order();
        let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|face| face.resolution).collect();
        let starts = first_texels(&resolutions);
        for axis in 0..2 {
            let known = values.to_vec();
            for (k, value) in values.iter_mut().enumerate().filter(|(k, _)| self.sizes[*k] != [1; 2]) {
                let texel = &mesh.texels[k];
                let (face, corner) = (texel.face as usize, texel.lattice_corner);
                let stride = [1, resolutions[face][0] as usize][axis];
                let row = starts[face] + texel.index as usize - corner[axis] as usize * stride;
                let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
                for (n, share) in window(corner[axis], self.sizes[k][axis], resolutions[face][axis]) {
                    sum += known[order[row + n as usize * stride]] * share;
                    weight += share;
                }
                *value = sum / weight;
            }
        }
    }
}

/// Returns the texels of 0 to `count` within half of `size` of the middle of texel `at`, and the share of each therein.
fn window(at: u32, size: u32, count: u32) -> impl Iterator<Item = (u32, f32)> {
    let reach = size / 2;
    let share = move |i: u32| {
        if size.is_multiple_of(2) && i.abs_diff(at) == reach {
            0.5
        } else {
            1.0
        }
    };
    (at.saturating_sub(reach)..(at + reach + 1).min(count)).map(move |i| (i, share(i)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};
    use glam::DVec3;

    /// A unit square of 8×8 texels.
    fn square() -> Mesh {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let scene = Scene {
            faces: vec![Face::quad("square", corners, Vec3::ZERO, Vec3::ONE)],
            ..Scene::default()
        };
        Mesh::new(&scene, &[[8, 8]], 1).unwrap()
    }

    fn texel_at(mesh: &Mesh, place: [u32; 2]) -> usize {
        mesh.texels
            .iter()
            .position(|texel| texel.lattice_corner == place)
            .unwrap()
    }

    #[test]
    fn blocks_are_rectangles_and_divided_where_a_texel_is_alone() {
        let mesh = square();
        let alone = texel_at(&mesh, [5, 1]);
        // The left half in blocks of 4×2.
        let sizes = mesh
            .texels
            .iter()
            .map(|texel| if texel.lattice_corner[0] < 4 { [4, 2] } else { [2, 2] });
        let blocks = TexelBlocks::new(&mesh, sizes.collect(), |k| k == alone);
        assert_eq!(blocks.len(), 4 + 7 + 4);
        let mut seen = vec![0; mesh.texels.len()];
        for block in 0..blocks.len() {
            let members = blocks.members(block);
            let places = members.iter().map(|k| mesh.texels[*k as usize].lattice_corner);
            let size = blocks.sizes[members[0] as usize];
            let low = places.clone().min().unwrap();
            assert_eq!(members.len() as u32, size[0] * size[1]);
            for place in places {
                assert!(
                    (0..2).all(|a| low[a] % size[a] == 0 && place[a] < low[a] + size[a]),
                    "{place:?}"
                );
            }
            for k in members {
                assert_eq!(blocks.block_of[*k as usize], block as u32);
                seen[*k as usize] += 1;
            }
        }
        assert!(seen.iter().all(|count| *count == 1));
        assert_eq!(blocks.members(blocks.block_of[alone] as usize), [alone as u32]);
        let sums = blocks.sum_blocks(mesh.texels.iter().map(|_| 1.0));
        assert_eq!(sums.iter().sum::<f64>(), 64.0);
        assert_eq!(blocks.spread_blocks(&sums)[alone], 1.0);
    }

    /// Between the middles of blocks of equal size, the interpolated values lie on the line through these.
    #[test]
    fn interpolation_is_linear_between_blocks() {
        let mesh = square();
        let blocks = TexelBlocks::new(&mesh, vec![[4, 4]; 64], |_| false);
        let of_block = |texel: &Texel| Vec3::splat((texel.lattice_corner[0] / 4) as f32);
        let mut values: Vec<Vec3> = mesh.texels.iter().map(of_block).collect();
        blocks.interpolate_blocks(&mesh, &mut values);
        for i in 2..6 {
            for j in 0..8 {
                let found = values[texel_at(&mesh, [i, j])].x;
                let expected = (i as f32 + 0.5 - 2.0) / 4.0;
                assert!((found - expected).abs() < 1e-6, "{i}, {j}: {found}, {expected}");
            }
        }
    }
}
