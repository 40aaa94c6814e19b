//! Occluder candidates: the faces that may block rays between two faces, found by shaft culling (Haines & Wallace
//! 1994). An empty shaft needs no rays.

use crate::occlusion::occluders::Occluders;
use crate::occlusion::shaft::{Shaft, TOUCH_DISTANCE};
use common::mesh::Mesh;
use rayon::prelude::*;

/// Occluder candidates between a shooter's face and a receiver's.
#[derive(Clone, Debug, PartialEq)]
pub enum OccluderCandidates {
    /// One face lies behind the other.
    Unseen,
    /// These faces may occlude.
    Faces(Vec<u32>),
    /// Any face may occlude: there are too many candidates, or too few rays to search for them.
    All,
}

/// Largest number of candidates; with more, rays through the BVH are faster.
pub const MAX_CANDIDATES: usize = 24;
/// Fewest visibility tests for which a shaft pays.
const MIN_SHAFT_QUESTIONS: usize = 64;

/// Returns the candidates between face `a` and every other face; `tests` is the number of visibility tests per texel.
pub fn occluder_candidates(mesh: &Mesh, occluders: &Occluders, a: u32, tests: usize) -> Vec<OccluderCandidates> {
    (0..mesh.faces.len() as u32)
        .into_par_iter()
        .with_min_len(32)
        .map(|b| candidates_between(mesh, occluders, a, b, tests))
        .collect()
}

fn candidates_between(mesh: &Mesh, occluders: &Occluders, a: u32, b: u32, tests: usize) -> OccluderCandidates {
    let [from, to] = [a, b].map(|k| &occluders.faces[k as usize]);
    // The form factor decides about fronts that touch a plane, with the rounding of a single shot.
    let behind =
        from.polygon.height_range(&to.plane)[1] <= -TOUCH_DISTANCE || to.polygon.height_range(&from.plane)[1] <= 0.0;
    if a == b || behind {
        return OccluderCandidates::Unseen;
    }
    let [w, h] = mesh.faces[b as usize].resolution;
    if (w as usize * h as usize) * tests < MIN_SHAFT_QUESTIONS {
        return OccluderCandidates::All;
    }
    let shaft = Shaft::for_rays(&from.polygon, &from.plane, &to.polygon, &to.plane);
    let faces = occluders.faces_blocking_rays(&shaft, [from.sheet, to.sheet], MAX_CANDIDATES);
    faces.map_or(OccluderCandidates::All, OccluderCandidates::Faces)
}
