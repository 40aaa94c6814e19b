//! Which faces may come between two faces: rays are asked of no others, and of none where the
//! shaft between the two is empty.

use crate::occlusion::occluders::Occluders;
use crate::occlusion::shaft::{Shaft, TOUCH};
use common::mesh::Mesh;
use rayon::prelude::*;

/// What lies between a shooter's face and a receiver's.
#[derive(Clone, Debug, PartialEq)]
pub enum Between {
    /// One lies behind the other.
    Unseen,
    /// These faces, perhaps none.
    Faces(Vec<u32>),
    /// Too many, or not worth finding out: all of them.
    All,
}

/// More faces than this are faster found by a ray in the hierarchy.
pub const MOST: usize = 24;
/// So many questions pay for a shaft.
const WORTH: usize = 64;

/// What lies between face `a` and every other one; `questions` are the pairs of points that will
/// be asked about each texel.
pub fn candidates(mesh: &Mesh, occluders: &Occluders, a: u32, questions: usize) -> Vec<Between> {
    (0..mesh.faces.len() as u32)
        .into_par_iter()
        .with_min_len(32)
        .map(|b| between(mesh, occluders, a, b, questions))
        .collect()
}

fn between(mesh: &Mesh, occluders: &Occluders, a: u32, b: u32, questions: usize) -> Between {
    let [from, to] = [a, b].map(|k| &occluders.faces[k as usize]);
    // Fronts that touch a plane are left to the form factor, which rounds as a single shot does.
    let behind =
        from.polygon.heights(&to.plane)[1] <= -TOUCH || to.polygon.heights(&from.plane)[1] <= 0.0;
    if a == b || behind {
        return Between::Unseen;
    }
    let [w, h] = mesh.faces[b as usize].resolution;
    if (w as usize * h as usize) * questions < WORTH {
        return Between::All;
    }
    let shaft = Shaft::rays(&from.polygon, &from.plane, &to.polygon, &to.plane);
    let faces = occluders.stopping(&shaft, [from.sheet, to.sheet], MOST);
    faces.map_or(Between::All, Between::Faces)
}
