//! Poses of bodies in a room.

use self::Pose::{Against, Beside, Floating, Hanging, Leaning, Stacked, Standing};
use super::convex::{BoundingPlane, ConvexBody};
use super::loft::{Footprint, Loft};
use super::placement::{AllowedContacts, OccupiedRoom};
use super::{RandomSource, draw_log_uniform, draw_rotation};
use glam::{DMat3, DVec2, DVec3};
use rand::RngExt;
use std::f64::consts::TAU;

/// Pose of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pose {
    /// On the floor, rotated about the vertical.
    Standing,
    /// On the ceiling, rotated about the vertical.
    Hanging,
    /// Anywhere, in any orientation.
    Floating,
    /// Tilted on one edge.
    Leaning,
    /// On the floor at a wall.
    Against,
    /// On another body.
    Stacked,
    /// On the floor beside another body.
    Beside,
}

impl Pose {
    /// All poses.
    pub const ALL: [Self; 7] = [Standing, Hanging, Floating, Leaning, Against, Stacked, Beside];
}

/// Placement attempts per body.
const MAX_TRIES: usize = 200;

/// Places a body in a pose and returns it with its gap to the contact, 0 if they touch; none if no
/// attempt fits.
pub fn place_body(
    source: &mut RandomSource,
    space: &mut OccupiedRoom,
    pose: Pose,
    lamps: usize,
) -> Option<(Loft, f64)> {
    let near = pose != Floating && source.random_bool(0.35);
    let gap = if near {
        draw_log_uniform(source, 1e-4, 1e-2) * space.room.height
    } else {
        0.0
    };
    for _ in 0..MAX_TRIES {
        let Some((loft, rests)) = pose_loft(source, space, (pose, gap), lamps) else {
            continue;
        };
        let shape = loft.convex_hull();
        if space.fits_body(&shape, rests) {
            space.bodies.push(shape);
            return Some((loft, gap));
        }
    }
    None
}

/// Draws a box about the y axis on the origin: a cuboid, or one that tapers and leans.
fn draw_box(source: &mut RandomSource, space: &OccupiedRoom, straight: bool) -> Loft {
    let extent = space.room.bounds.end - space.room.bounds.start;
    let size = extent.min_element();
    let [x, z] = std::array::from_fn(|_| source.random_range(0.12..0.45) * size);
    let height = source.random_range(0.12..0.6) * extent.y.min(2.0 * size);
    let (scale, shift) = if straight || source.random_bool(0.6) {
        (1.0, DVec2::ZERO)
    } else {
        let mut lean = || source.random_range(-0.4..0.4) * height;
        let shift = DVec2::new(lean(), lean());
        (source.random_range(0.5..1.3), shift)
    };
    Loft::new(Footprint::rectangle(x, z), height, scale, shift)
}

/// Draws a body in a pose with its allowed contacts, without a collision test.
fn pose_loft(
    source: &mut RandomSource,
    space: &OccupiedRoom,
    (pose, gap): (Pose, f64),
    lamps: usize,
) -> Option<(Loft, AllowedContacts)> {
    let loft = draw_box(source, space, pose == Beside);
    let yaw = DMat3::from_rotation_y(source.random_range(0.0..TAU));
    let at = space.draw_floor_point(source);
    let mut rests = AllowedContacts::default();
    let placed = match pose {
        Standing => {
            rests.floor = true;
            loft.rotate_by(yaw).move_by(at + DVec3::Y * gap)
        }
        Hanging => {
            rests.ceiling = true;
            let loft = loft.rotate_by(yaw).move_by(at);
            let [_, top] = loft.height_range();
            loft.move_by(DVec3::Y * (space.room.height - gap - top))
        }
        Floating => {
            let up = source.random_range(0.0..space.room.height);
            loft.rotate_by(draw_rotation(source)).move_by(at + DVec3::Y * up)
        }
        Leaning => {
            rests.floor = true;
            let tilt = DMat3::from_rotation_x(source.random_range(0.15..0.7));
            let loft = loft.rotate_by(yaw * tilt).move_by(at);
            let [low, _] = loft.height_range();
            loft.move_by(DVec3::Y * (gap - low))
        }
        Against => {
            rests.floor = true;
            let part = source.random_range(0..space.room.parts.len());
            let planes = &space.room.parts[part].planes;
            let wall = source.random_range(2..planes.len());
            rests.wall = Some((part, wall));
            push_to_wall(loft, at, &planes[wall], gap)?
        }
        Stacked => {
            let host = draw_host(source, space, lamps)?;
            rests.body = Some(host);
            stack_on(source, loft.rotate_by(yaw), &space.bodies[host], gap)?
        }
        Beside => {
            rests.floor = true;
            let host = draw_host(source, space, lamps)?;
            rests.body = Some(host);
            place_beside(source, loft, &space.bodies[host], gap)?
        }
    };
    Some((placed, rests))
}

/// Draws one of the placed bodies.
fn draw_host(source: &mut RandomSource, space: &OccupiedRoom, lamps: usize) -> Option<usize> {
    (space.bodies.len() > lamps).then(|| source.random_range(lamps..space.bodies.len()))
}

/// Rotates it towards a horizontal direction.
fn face_along(loft: Loft, along: DVec3) -> Loft {
    loft.rotate_by(DMat3::from_rotation_y((-along.z).atan2(along.x)))
}

/// Moves it along the floor up to a wall; none if the wall is horizontal.
fn push_to_wall(loft: Loft, at: DVec3, wall: &BoundingPlane, gap: f64) -> Option<Loft> {
    let along = DVec3::new(wall.normal.x, 0.0, wall.normal.z).try_normalize()?;
    let loft = face_along(loft, along).move_by(at);
    let shape = loft.convex_hull();
    let step = (-gap - shape.max_height_above(wall)) / wall.normal.dot(along);
    Some(loft.move_by(along * step))
}

/// Moves it onto another body's top; none if that is not horizontal.
fn stack_on(source: &mut RandomSource, loft: Loft, host: &ConvexBody, gap: f64) -> Option<Loft> {
    let top = host.planes.get(1).filter(|p| p.normal.y > 1.0 - 1e-12)?;
    let corners = host.corners.iter().filter(|c| top.height_above(**c) > -1e-12);
    let (a, b) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), c| {
        (a.min(*c), b.max(*c))
    });
    let mut along = |k: usize| source.random_range(a[k]..b[k]);
    Some(loft.move_by(DVec3::new(along(0), top.offset + gap, along(2))))
}

/// Moves it beside another standing body, along a wall of it; none if that is not vertical.
fn place_beside(source: &mut RandomSource, loft: Loft, host: &ConvexBody, gap: f64) -> Option<Loft> {
    let wall = host.planes.get(source.random_range(2..6))?;
    let [low, _] = host.extent_along(DVec3::Y);
    if wall.normal.y.abs() > 1e-12 || low.abs() > 1e-12 {
        return None;
    }
    let across = wall.normal.cross(DVec3::Y);
    let [a, b] = host.extent_along(across);
    let at = across * source.random_range(a..b);
    let loft = face_along(loft, wall.normal).move_by(at);
    let shape = loft.convex_hull();
    let [near, _] = shape.extent_along(wall.normal);
    Some(loft.move_by(wall.normal * (wall.offset + gap - near)))
}
