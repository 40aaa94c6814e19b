//! Symmetry: the light of a scene does not depend on its place, direction, scale and handedness, nor on the order and the
//! division of its faces.
//!
//! Each tolerance is a share of the largest radiosity of the channel, since form factors are rounded to a share of 1. A ray
//! that passes an edge within rounding may change sides: among boxes a few texels may differ by more.

use crate::pairing::{Pairing, pair_by_face};
use crate::scene::MeshedScene;
use crate::solution::{SceneSolver, Solution, check_tolerance};
use crate::violation::Violation;
use glam::DVec3;

/// Checks a scene against its image, of which `to` maps the points.
fn check_image(
    property: &'static str,
    solver: &SceneSolver,
    [scene, image]: [&MeshedScene; 2],
    to: impl Fn(DVec3) -> DVec3,
    tolerance: f64,
) -> Result<(), Violation> {
    check_tolerance(property, tolerance)?;
    let (ours, theirs) = (Solution::new(solver, scene)?, Solution::new(solver, image)?);
    let pairs = Pairing::by_place(&ours.mesh, &theirs.mesh, to)?;
    ours.compare_with(property, &theirs, &pairs.texels, tolerance)
}

/// Checks that the radiosity stays after a similarity transform `to` that keeps handedness: a rotation, a shift and a
/// scale. The tolerance is a share of the channel's largest radiosity.
///
/// Errors: a [`Violation`].
pub fn check_similarity(
    solver: &SceneSolver,
    scene: &MeshedScene,
    to: impl Fn(DVec3) -> DVec3,
    tolerance: f64,
) -> Result<(), Violation> {
    let image = scene.map_corners(&to);
    check_image("similarity transform", solver, [scene, &image], to, tolerance)
}

/// Checks that the mirror image at the plane with this unit `normal` has the same radiosity. The tolerance is a share of
/// the channel's largest.
///
/// Errors: a [`Violation`].
pub fn check_mirror(solver: &SceneSolver, scene: &MeshedScene, normal: DVec3, tolerance: f64) -> Result<(), Violation> {
    let (image, to) = scene.mirror(normal);
    check_image("mirror image", solver, [scene, &image], to, tolerance)
}

/// Checks that the radiosity stays if the faces come in another order; `order` is a permutation of their indices (see
/// [`crate::order_by_keys`]). The tolerance is a share of the channel's largest radiosity.
///
/// Errors: a [`Violation`]; [`Violation::Nothing`] if it is no permutation.
pub fn check_face_order(
    solver: &SceneSolver,
    scene: &MeshedScene,
    order: &[usize],
    tolerance: f64,
) -> Result<(), Violation> {
    const PROPERTY: &str = "order of faces";
    check_tolerance(PROPERTY, tolerance)?;
    let mut indices = order.to_vec();
    indices.sort_unstable();
    if !indices.into_iter().eq(0..scene.scene.faces.len()) {
        return Err(Violation::nothing(PROPERTY, "the order is no permutation of the faces"));
    }
    let ours = Solution::new(solver, scene)?;
    let theirs = Solution::new(solver, &scene.reorder_faces(order))?;
    let texels = pair_by_face(&ours.mesh, &theirs.mesh, order)?;
    ours.compare_with(PROPERTY, &theirs, &texels, tolerance)
}

/// Checks that the radiosity stays if the corners of face k are rotated by `by[k]`; `by` repeats. The patches of a triangle
/// depend on its first corner: a solver that shoots from them differs by more than rounding. The tolerance is a share of
/// the channel's largest radiosity.
///
/// Errors: a [`Violation`].
pub fn check_corner_order(
    solver: &SceneSolver,
    scene: &MeshedScene,
    by: &[u32],
    tolerance: f64,
) -> Result<(), Violation> {
    let other = scene.rotate_first_corners(by);
    check_image("order of corners", solver, [scene, &other], |p| p, tolerance)
}

/// Checks that the radiosity stays if a face is split along the borders of its texels (see [`MeshedScene::split_face`]).
/// The parts have patches of their own: a solver that shoots from patches of several texels differs by more than rounding.
/// The tolerance is a share of the channel's largest radiosity.
///
/// Errors: a [`Violation`].
pub fn check_split(solver: &SceneSolver, scene: &MeshedScene, at: usize, tolerance: f64) -> Result<(), Violation> {
    scene.mesh()?;
    let [one, many] = scene.split_face(at);
    check_image("split face", solver, [&one, &many], |p| p, tolerance)
}
