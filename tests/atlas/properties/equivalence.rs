//! Equality up to rounding of the links of a scene and its image.

use super::rounding::link_rounding;
use super::setups::SolverSetup;
use glam::DVec3;
use properties::{MeshedScene, Pairing};
use proptest::prelude::*;

/// One of so many links may differ: a ray that passes an edge within rounding is blocked in one mesh only.
const LINKS_PER_EDGE_RAY: usize = 1000;

/// Asserts that the links of two scenes, of which the second is the first mapped by `to`, are equal up to rounding.
/// Radiosity follows from them alone (`tests/dense/solve.rs`).
pub fn assert_same_links(
    setup: SolverSetup,
    [one, other]: [&MeshedScene; 2],
    to: impl Fn(DVec3) -> DVec3,
) -> Result<(), TestCaseError> {
    let (a, b) = (&one.sampled_mesh(setup.samples)?, &other.sampled_mesh(setup.samples)?);
    let pairs = Pairing::by_place(a, b, to)?;
    let [ours, theirs] = [a, b].map(|mesh| setup.link_rows(mesh));
    let mut differing = Vec::new();
    for (i, row) in ours.iter().enumerate() {
        let Some(other) = pairs.patches[i] else {
            continue;
        };
        for (k, link) in row.iter().enumerate() {
            let j = pairs.texels[k];
            let image = theirs[other][j];
            let found = f64::from((link - image).abs());
            let bound = link_rounding(a, i, k, *link) + link_rounding(b, other, j, image);
            if found > bound {
                differing.push(format!("link of texel {k} to patch {i}: {found:e} > {bound:e}"));
            }
        }
    }
    let all = a.texels.len() * a.patches.len();
    prop_assert!(differing.len() * LINKS_PER_EDGE_RAY <= all, "of {all}: {differing:#?}");
    Ok(())
}
