//! Which texels of an answer are looked at.

use common::mesh::Mesh;
use common::sampling::{STEPS, hash};
use common::shooting::Field;
use glam::DVec3;

/// Texels at even steps of a density, with each the area that it stands for. The density is a quarter
/// each of area; of light, so that a small face in strong light is not missed; of roughness, the
/// difference to the next texels of the face: noise and missed edges show there; and of the same for
/// every face, so that one which has lost all its light is not missed. Within a face the order is
/// scattered, so that the steps do not follow its rows.
pub fn choose(mesh: &Mesh, field: &Field, count: u64) -> Vec<(usize, f64)> {
    let mut order = mesh.in_face_order();
    let area = |k: usize| f64::from(mesh.texels[k].area);
    let light = |k: usize| area(k) * reflected(mesh, field, k).length_squared();
    let roughness = roughness(mesh, field, &order);
    let sum = |part: &dyn Fn(usize) -> f64| {
        (0..order.len())
            .map(part)
            .sum::<f64>()
            .max(f64::MIN_POSITIVE)
    };
    let sums = [sum(&area), sum(&light), sum(&|k| roughness[k])];
    let share = |k: usize| {
        let [w, h] = mesh.faces[mesh.texels[k].face as usize].resolution;
        1.0 / (mesh.faces.len() as f64 * f64::from(w * h))
    };
    let density = |k: usize| {
        let parts = [
            area(k) / sums[0],
            light(k) / sums[1],
            roughness[k] / sums[2],
            share(k),
        ];
        parts.iter().sum::<f64>() / parts.len() as f64
    };
    let step = sum(&density) / count as f64;
    order.sort_by_key(|k| {
        let texel = &mesh.texels[*k];
        (texel.face, hash(texel.index), texel.index)
    });
    let mut next = step * f64::from(STEPS[0]) / (1u64 << 32) as f64;
    let (mut passed, mut chosen) = (0.0, Vec::new());
    for k in order {
        passed += density(k);
        let mut hits = 0;
        while next < passed {
            next += step;
            hits += 1;
        }
        if hits > 0 {
            chosen.push((k, f64::from(hits) * step * area(k) / density(k)));
        }
    }
    chosen
}

/// B − E.
fn reflected(mesh: &Mesh, field: &Field, k: usize) -> DVec3 {
    (field.radiosity[k].truncate() - mesh.texels[k].emission).as_dvec3()
}

/// A (B_j − B_j')² of each texel, j' the one before it in its face's row or the one after.
fn roughness(mesh: &Mesh, field: &Field, order: &[usize]) -> Vec<f64> {
    let mut squares = vec![0.0f64; order.len()];
    for pair in order.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        if mesh.texels[a].face == mesh.texels[b].face {
            let square = (reflected(mesh, field, a) - reflected(mesh, field, b)).length_squared();
            for k in [a, b] {
                squares[k] = squares[k].max(square * f64::from(mesh.texels[k].area));
            }
        }
    }
    squares
}
