//! The box room in which a panorama is captured.
//!
//! x ∈ [−X/2, X/2], y ∈ [0, Y] (up), z ∈ [−Z/2, Z/2]; fronts face inward. In the order of the faces: floor (y = 0),
//! ceiling (y = Y), left (+x, a quarter left of the map's centre), right (−x), front (+z, which the map's centre
//! shows) and back (−z). As seen from within, corner 0 is a wall's lower left and corner 1 its lower right; the
//! floor's lower edge is at the back wall, the ceiling's at the front wall, so that right stays right.

use crate::error::{Error, Result};
use crate::scene::{Face, Scene};
use glam::{DVec3, Vec3};

/// Makes a box room of `size` X, Y, Z (scene units), dark and black: six quads, see the module.
///
/// Errors ([`Error::Usage`]): a side that is not above 0 or not finite.
pub fn box_room(size: DVec3) -> Result<Scene> {
    check_room_size(size)?;
    // A corner by its side of the room: left (+x) or right, top (+y) or bottom, front (+z) or back.
    let p = |left: bool, top: bool, front: bool| {
        let half = |side: bool, length: f64| if side { length / 2.0 } else { -length / 2.0 };
        let y = if top { size.y } else { 0.0 };
        DVec3::new(half(left, size.x), y, half(front, size.z))
    };
    // Each quad starts at its lower left and runs counter-clockwise as seen from within.
    let (l, r, t, u, f, b) = (true, false, true, false, true, false);
    let quads = [
        ("floor", [p(l, u, b), p(r, u, b), p(r, u, f), p(l, u, f)]),
        ("ceiling", [p(l, t, f), p(r, t, f), p(r, t, b), p(l, t, b)]),
        ("left", [p(l, u, b), p(l, u, f), p(l, t, f), p(l, t, b)]),
        ("right", [p(r, u, f), p(r, u, b), p(r, t, b), p(r, t, f)]),
        ("front", [p(l, u, f), p(r, u, f), p(r, t, f), p(l, t, f)]),
        ("back", [p(r, u, b), p(l, u, b), p(l, t, b), p(r, t, b)]),
    ];
    let face = |(name, corners)| Face::quad(name, corners, Vec3::ZERO, Vec3::ZERO);
    Ok(Scene {
        name: "captured room".into(),
        faces: quads.map(face).into(),
        ..Scene::default()
    })
}

/// Returns the capture point of the panorama: `given`, or the middle of the room of `size`.
///
/// Errors ([`Error::Usage`]): a room without extent; an eye outside it or on a wall.
pub fn capture_point(size: DVec3, given: Option<DVec3>) -> Result<DVec3> {
    check_room_size(size)?;
    let middle = DVec3::new(0.0, size.y / 2.0, 0.0);
    let eye = given.unwrap_or(middle);
    // NaN fails this test too.
    if (eye - middle).abs().cmplt(size / 2.0).all() {
        return Ok(eye);
    }
    let [x, z] = [size.x / 2.0, size.z / 2.0];
    Err(Error::Usage(format!(
        "an eye at {},{},{} does not lie inside the room: between −{x},0,−{z} and {x},{},{z}",
        eye.x, eye.y, eye.z, size.y
    )))
}

fn check_room_size(size: DVec3) -> Result<()> {
    if size.is_finite() && size.min_element() > 0.0 {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "a room of size {},{},{}: all three must be above 0",
        size.x, size.y, size.z
    )))
}
