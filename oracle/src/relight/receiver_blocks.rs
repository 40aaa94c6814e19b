//! Sizes of the blocks of texels of the room that receive the objects' light by the same rays: as wide as the change of the
//! light in the step before allows.

use common::mesh::Mesh;
use common::scene::{Face, Shape};
use common::texel::first_texels;
use glam::{DVec3, Vec3};

/// Largest number of texels of the step before along a block, a power of two.
const MAX_BLOCK_TEXELS: u32 = 8;

/// Returns the texels along and across of the block of each texel of `mesh`, so that `changes` of B, on `coarse` texels of
/// each face, differ by about `limit` from block to block. Texels of objects and of triangles are blocks of their own.
pub fn choose_block_sizes(
    faces: &[Face],
    mesh: &Mesh,
    (changes, coarse): (&[Vec3], &[[u32; 2]]),
    limit: f64,
) -> Vec<[u32; 2]> {
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|face| face.resolution).collect();
    let [starts, coarse_starts] = [&resolutions[..], coarse].map(first_texels);
    let mut sizes = vec![[1; 2]; mesh.texels.len()];
    for f in 0..mesh.room_faces as usize {
        let parts = [0, 1].map(|a| resolutions[f][a] / coarse[f][a]);
        let is_halved = |a: usize| parts[a].is_power_of_two() && parts[a] * coarse[f][a] == resolutions[f][a];
        if faces[f].shape != Shape::Quad || !(is_halved(0) && is_halved(1)) {
            continue;
        }
        let own = changes[coarse_starts[f]..coarse_starts[f + 1]].iter();
        let own: Vec<DVec3> = own.map(|change| change.as_dvec3()).collect();
        let widths = choose_widths(&own, coarse[f], limit);
        for (n, size) in sizes[starts[f]..starts[f + 1]].iter_mut().enumerate() {
            let [i, j] = [n as u32 % resolutions[f][0], n as u32 / resolutions[f][0]];
            let width = widths[(j / parts[1] * coarse[f][0] + i / parts[0]) as usize];
            *size = parts.map(|part| ((f64::from(part) * width) as u32).max(1));
        }
    }
    sizes
}

/// Returns the width of the block of each of W×H texels, in texels: a power of two, so that `values` differ by about `limit`
/// over it if their slopes are those between neighbours.
fn choose_widths(values: &[DVec3], [w, h]: [u32; 2], limit: f64) -> Vec<f64> {
    let index = |i: u32, j: u32| (j * w + i) as usize;
    let largest_step = |i: u32, j: u32| {
        let own = values[index(i, j)];
        let around = (j.saturating_sub(1)..(j + 2).min(h))
            .flat_map(|j| (i.saturating_sub(1)..(i + 2).min(w)).map(move |i| (i, j)));
        around
            .map(|(i, j)| (values[index(i, j)] - own).abs().max_element())
            .fold(0.0, f64::max)
    };
    let most = f64::from(MAX_BLOCK_TEXELS);
    let allowed = |i, j| (limit / largest_step(i, j)).min(most).log2().floor().exp2();
    let mut widths: Vec<f64> = (0..h)
        .flat_map(|j| (0..w).map(move |i| (i, j)))
        .map(|(i, j)| allowed(i, j))
        .collect();
    // A block of several texels is as wide as each of them allows.
    let mut width = MAX_BLOCK_TEXELS;
    while width > 1 {
        for (j, i) in (0..h)
            .step_by(width as usize)
            .flat_map(|j| (0..w).step_by(width as usize).map(move |i| (j, i)))
        {
            let members = || (j..(j + width).min(h)).flat_map(|j| (i..(i + width).min(w)).map(move |i| index(i, j)));
            if members().any(|k| widths[k] < f64::from(width)) {
                for k in members() {
                    widths[k] = widths[k].min(f64::from(width / 2));
                }
            }
        }
        width /= 2;
    }
    widths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_wide_where_little_changes() {
        let [w, h] = [16, 8];
        // A step of 8 limits between columns 3 and 4, and a slope of a quarter of the limit from column 12 on.
        let value = |i: u32| match i {
            0..4 => 0.0,
            4..12 => 8.0,
            _ => 8.0 + 0.25 * f64::from(i - 11),
        };
        let values: Vec<DVec3> = (0..w * h).map(|k| DVec3::splat(value(k % w))).collect();
        let widths = choose_widths(&values, [w, h], 1.0);
        for (k, width) in widths.iter().enumerate() {
            let expected = match k as u32 % w {
                3 | 4 => 0.125,
                2 | 5 => 1.0,
                0 | 1 | 6 | 7 => 2.0,
                _ => 4.0,
            };
            assert_eq!(*width, expected, "column {}", k as u32 % w);
        }
    }
}
