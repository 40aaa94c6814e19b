//! Two scenes that are the same but for rounding: their links and their answers.

use super::kit::{Way, apart, gain, left};
use super::places::{Pairing, link_rounding};
use common::mesh::Mesh;
use common::shooting::Run;
use glam::Vec3;
use proptest::prelude::*;

/// What rounding may change of all links: a row of all texels for each cell.
fn rounding(mesh: &Mesh) -> Vec<Vec<f64>> {
    let row = |i: usize| {
        let texels = 0..mesh.texels.len();
        texels.map(|k| link_rounding(mesh, i, k)).collect()
    };
    (0..mesh.cells.len()).map(row).collect()
}

/// ΣA|ΔB| of links that are off by that, before any of it is reflected on; scene units.
fn moved(mesh: &Mesh, run: &Run, rounding: &[Vec<f64>]) -> f64 {
    let each = run.shots.iter().map(|shot| {
        let cell = shot.cell as usize;
        let radiosity = Vec3::from(shot.power).abs() / mesh.cells[cell].shooter.area;
        let texels = mesh.texels.iter().zip(&rounding[cell]);
        let taken: f64 = texels.map(|(texel, off)| f64::from(texel.area) * off).sum();
        radiosity.as_dvec3().element_sum() * taken
    });
    each.sum::<f64>() * mesh.area_unit()
}

/// The links and the answers of two meshes that are the same but for rounding; lengths of the second
/// are `scale` times as long.
pub fn same(
    way: Way,
    a: &Mesh,
    b: &Mesh,
    pairs: &Pairing,
    scale: f64,
) -> Result<(), TestCaseError> {
    let offs = [a, b].map(rounding);
    let links = [a, b].map(|mesh| way.links(mesh));
    for (i, row) in links[0].iter().enumerate() {
        let Some(other) = pairs.cells[i] else {
            continue;
        };
        for (k, link) in row.iter().enumerate() {
            let j = pairs.texels[k];
            let found = f64::from((link - links[1][other][j]).abs());
            let bound = offs[0][i][k] + offs[1][other][j];
            prop_assert!(
                found <= bound,
                "link of texel {k} to cell {i}: {found:e} > {bound:e}"
            );
        }
    }
    if pairs.cells.contains(&None) {
        return Ok(());
    }
    let gain = gain(a, &links[0]);
    prop_assume!(gain < 100.0);
    let runs = [a, b].map(|mesh| way.solve(mesh));
    let found = apart(a, &runs[0].field, &runs[1].field, |k| pairs.texels[k]);
    let of_links = moved(a, &runs[0], &offs[0]) + moved(b, &runs[1], &offs[1]) / (scale * scale);
    let of_others = left(b, gain, &[&runs[1]]) / (scale * scale);
    let bound = gain * of_links + left(a, gain, &[&runs[0]]) + of_others;
    prop_assert!(found <= bound, "{found:e} > {bound:e}");
    Ok(())
}
