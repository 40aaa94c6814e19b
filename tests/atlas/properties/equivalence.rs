//! Equality up to rounding of links and solutions of two meshes of the same scene.

use super::pairing::{Pairing, link_rounding};
use super::setups::{SolverSetup, radiosity_distance, reflection_gain, remaining_error};
use common::mesh::Mesh;
use common::shooting::SolveRun;
use glam::Vec3;
use proptest::prelude::*;

/// Returns bounds of the rounding of all links: a row of all texels for each patch.
fn link_roundings(mesh: &Mesh) -> Vec<Vec<f64>> {
    let row = |i: usize| {
        let texels = 0..mesh.texels.len();
        texels.map(|k| link_rounding(mesh, i, k)).collect()
    };
    (0..mesh.patches.len()).map(row).collect()
}

/// Returns ΣA|ΔB| caused by that rounding of links, before later reflections; scene units.
fn radiosity_rounding(mesh: &Mesh, run: &SolveRun, rounding: &[Vec<f64>]) -> f64 {
    let each = run.shots.iter().map(|shot| {
        let patch = shot.patch as usize;
        let radiosity = Vec3::from(shot.power).abs() / mesh.patches[patch].shooter.area;
        let texels = mesh.texels.iter().zip(&rounding[patch]);
        let taken: f64 = texels.map(|(texel, off)| f64::from(texel.area) * off).sum();
        radiosity.as_dvec3().element_sum() * taken
    });
    each.sum::<f64>() * mesh.area_unit()
}

/// Asserts that links and solutions of two meshes are equal up to rounding; lengths of the second are `scale` times as
/// long.
pub fn assert_same_light(
    way: SolverSetup,
    a: &Mesh,
    b: &Mesh,
    pairs: &Pairing,
    scale: f64,
) -> Result<(), TestCaseError> {
    let offs = [a, b].map(link_roundings);
    let links = [a, b].map(|mesh| way.link_rows(mesh));
    for (i, row) in links[0].iter().enumerate() {
        let Some(other) = pairs.patches[i] else {
            continue;
        };
        for (k, link) in row.iter().enumerate() {
            let j = pairs.texels[k];
            let found = f64::from((link - links[1][other][j]).abs());
            let bound = offs[0][i][k] + offs[1][other][j];
            prop_assert!(found <= bound, "link of texel {k} to patch {i}: {found:e} > {bound:e}");
        }
    }
    if pairs.patches.contains(&None) {
        return Ok(());
    }
    let gain = reflection_gain(a, &links[0]);
    prop_assume!(gain < 100.0);
    let runs = [a, b].map(|mesh| way.solve_mesh(mesh));
    let found = radiosity_distance(a, &runs[0].field, &runs[1].field, |k| pairs.texels[k]);
    let of_links =
        radiosity_rounding(a, &runs[0], &offs[0]) + radiosity_rounding(b, &runs[1], &offs[1]) / (scale * scale);
    let of_others = remaining_error(b, gain, &[&runs[1]]) / (scale * scale);
    let bound = gain * of_links + remaining_error(a, gain, &[&runs[0]]) + of_others;
    prop_assert!(found <= bound, "{found:e} > {bound:e}");
    Ok(())
}
