//! Room for one more: whether something fits where it is put.

use super::Source;
use super::convex::{Convex, Plane};
use super::room::Room;
use glam::DVec3;
use rand::RngExt;

/// Whatever is not meant to touch, or nearly to touch, is this far apart, of the room's height.
const MARGIN: f64 = 0.02;
/// What rests on a plane is above it but for rounding, scene units.
const ROUNDING: f64 = 1e-12;

/// What may be nearer than the margin.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rests {
    pub floor: bool,
    pub ceiling: bool,
    /// A wall: the room's convex part, and its plane there.
    pub wall: Option<(usize, usize)>,
    /// Another body.
    pub body: Option<usize>,
}

/// A room with what is in it.
pub struct Space<'a> {
    pub room: &'a Room,
    /// Bodies, sheets and lamps.
    pub taken: Vec<Convex>,
    /// Where nothing may be: the lamps' light.
    pub clear: Vec<Convex>,
}

impl<'a> Space<'a> {
    /// An empty one.
    pub fn new(room: &'a Room) -> Self {
        Self {
            room,
            taken: Vec::new(),
            clear: Vec::new(),
        }
    }

    /// Whether it touches, or nearly touches, only what it rests on.
    pub fn fits(&self, body: &Convex, rests: Rests) -> bool {
        self.within(body, rests)
            && self.clear.iter().all(|zone| zone.apart(body) >= 0.0)
            && self.taken.iter().enumerate().all(|(k, other)| {
                let least = self.least(rests.body == Some(k));
                other.apart(body) >= least
            })
    }

    fn least(&self, rests: bool) -> f64 {
        if rests {
            -ROUNDING
        } else {
            MARGIN * self.room.height
        }
    }

    /// Within one convex part of the room.
    fn within(&self, body: &Convex, rests: Rests) -> bool {
        let [low, high] = body.extent(DVec3::Y);
        let inside = |(k, part): (usize, &Convex)| {
            let walls = part.planes.iter().enumerate().skip(2);
            let chosen = rests.wall.is_none_or(|(part, _)| part == k);
            chosen
                && walls.into_iter().all(|(j, plane)| {
                    let least = self.least(rests.wall == Some((k, j)));
                    highest(plane, body) <= -least
                })
        };
        low >= self.least(rests.floor)
            && self.room.height - high >= self.least(rests.ceiling)
            && self.room.parts.iter().enumerate().any(inside)
    }

    /// Somewhere in the room's bounds, on the floor.
    pub fn somewhere(&self, source: &mut Source) -> DVec3 {
        let bounds = &self.room.bounds;
        let mut along = |k: usize| source.random_range(bounds.start[k]..bounds.end[k]);
        DVec3::new(along(0), 0.0, along(2))
    }
}

/// How far its highest corner is above a plane.
pub fn highest(plane: &Plane, body: &Convex) -> f64 {
    let above = body.corners.iter().map(|c| plane.above(*c));
    above.fold(f64::NEG_INFINITY, f64::max)
}
