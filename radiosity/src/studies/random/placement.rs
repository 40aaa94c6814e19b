//! Collision tests for placing bodies in a room.

use super::RandomSource;
use super::convex::ConvexBody;
use super::room::RandomRoom;
use glam::DVec3;
use rand::RngExt;

/// Least distance of bodies without an allowed contact, as a share of the room's height.
const MIN_GAP_SHARE: f64 = 0.02;
/// Tolerance of an allowed contact, scene units.
const CONTACT_TOLERANCE: f64 = 1e-12;

/// Contacts for which the margin does not apply.
#[derive(Clone, Copy, Debug, Default)]
pub struct AllowedContacts {
    pub floor: bool,
    pub ceiling: bool,
    /// A wall: index of the room's convex part, and of the plane there.
    pub wall: Option<(usize, usize)>,
    /// Index of another body.
    pub body: Option<usize>,
}

/// A room and the bodies placed in it.
pub struct OccupiedRoom<'a> {
    pub room: &'a RandomRoom,
    /// Placed bodies, sheets and lamps.
    pub bodies: Vec<ConvexBody>,
    /// Space around lamps that is kept free.
    pub free_zones: Vec<ConvexBody>,
}

impl OccupiedRoom<'_> {
    /// Returns whether `body` keeps the margin from everything but the allowed contacts.
    pub fn fits_body(&self, body: &ConvexBody, rests: AllowedContacts) -> bool {
        let is_clear = |(k, other): (usize, &ConvexBody)| other.separation(body) >= self.min_gap(rests.body == Some(k));
        self.lies_within(body, rests)
            && self.free_zones.iter().all(|zone| zone.separation(body) >= 0.0)
            && self.bodies.iter().enumerate().all(is_clear)
    }

    fn min_gap(&self, rests: bool) -> f64 {
        if rests {
            -CONTACT_TOLERANCE
        } else {
            MIN_GAP_SHARE * self.room.height
        }
    }

    /// Returns whether `body` lies within one convex part of the room.
    fn lies_within(&self, body: &ConvexBody, rests: AllowedContacts) -> bool {
        let [low, high] = body.extent_along(DVec3::Y);
        let inside = |(k, part): (usize, &ConvexBody)| {
            let mut walls = part.planes.iter().enumerate().skip(2);
            rests.wall.is_none_or(|(part, _)| part == k)
                && walls.all(|(j, plane)| body.max_height_above(plane) <= -self.min_gap(rests.wall == Some((k, j))))
        };
        low >= self.min_gap(rests.floor)
            && self.room.height - high >= self.min_gap(rests.ceiling)
            && self.room.parts.iter().enumerate().any(inside)
    }

    /// Draws a point on the floor within the room's bounds.
    pub fn draw_floor_point(&self, source: &mut RandomSource) -> DVec3 {
        let bounds = &self.room.bounds;
        let mut along = |k: usize| source.random_range(bounds.start[k]..bounds.end[k]);
        DVec3::new(along(0), 0.0, along(2))
    }
}
