//! Grids of triangles that tessellated faces are drawn as, a grid for each tessellation level.

use common::constants::TESSELLATION_LEVELS;
use common::mesh::Mesh;

/// Bytes of an instance: face, parts.
pub const INSTANCE_BYTES: u64 = 8;
/// Words of an indexed draw's arguments.
pub const DRAW_WORDS: u32 = 5;
/// Word that holds the number of instances.
pub const DRAW_INSTANCES: u32 = 1;

/// Returns the bytes of one level's list of instances.
pub fn level_bytes(mesh: &Mesh) -> u64 {
    INSTANCE_BYTES * mesh.faces.len() as u64
}

/// Returns the indices of 2^l × 2^l quads of two triangles, for every level l.
pub fn grid_indices() -> Vec<u32> {
    let mut indices = Vec::new();
    for level in 0..TESSELLATION_LEVELS {
        let parts = 1u32 << level;
        for j in 0..parts {
            for i in 0..parts {
                let a = j * (parts + 1) + i;
                let (b, c, d) = (a + 1, a + parts + 2, a + parts + 1);
                indices.extend([a, b, c, a, c, d]);
            }
        }
    }
    indices
}

/// Returns the arguments of each level's draw: index count, instances (set on the device), first index, base
/// vertex, first instance.
pub fn draw_arguments() -> Vec<u32> {
    let mut first = 0;
    let mut draws = Vec::new();
    for level in 0..TESSELLATION_LEVELS {
        let count = 6 << (2 * level);
        draws.extend([count, 0, first, 0, 0]);
        first += count;
    }
    draws
}
