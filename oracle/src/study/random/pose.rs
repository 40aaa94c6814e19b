//! Where a body lies in the room.

use super::convex::{Convex, Plane};
use super::loft::{Loft, Outline};
use super::place::{Rests, Space, highest};
use super::{Kind, Source, log_between, turned};
use glam::{DMat3, DVec2, DVec3};
use rand::RngExt;
use std::f64::consts::TAU;
use std::fmt;

/// How a body lies in the room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pose {
    /// On the floor, turned.
    Standing,
    /// From the ceiling, turned.
    Hanging,
    /// Anywhere, anyhow.
    Floating,
    /// Tilted, on one edge.
    Leaning,
    /// On the floor, at a wall.
    Against,
    /// On another body.
    Stacked,
    /// On the floor, side by side with another.
    Beside,
}

impl Pose {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Standing,
        Self::Hanging,
        Self::Floating,
        Self::Leaning,
        Self::Against,
        Self::Stacked,
        Self::Beside,
    ];
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Standing => "standing",
            Self::Hanging => "hanging",
            Self::Floating => "floating",
            Self::Leaning => "leaning",
            Self::Against => "at a wall",
            Self::Stacked => "on another",
            Self::Beside => "beside another",
        })
    }
}

/// Places that are tried.
const TRIES: usize = 200;

/// A body in a pose, and the gap to what it nearly touches; none where there is no place.
pub fn put(
    source: &mut Source,
    kind: Kind,
    space: &mut Space,
    pose: Pose,
    lamps: usize,
) -> Option<(Loft, f64)> {
    let near = kind == Kind::Any && pose != Pose::Floating && source.random_bool(0.35);
    let gap = if near {
        log_between(source, 1e-4, 1e-2) * space.room.height
    } else {
        0.0
    };
    for _ in 0..TRIES {
        let Some((loft, rests)) = place(source, kind, space, (pose, gap), lamps) else {
            continue;
        };
        let shape = loft.parts().remove(0);
        if space.fits(&shape, rests) {
            space.taken.push(shape);
            return Some((loft, gap));
        }
    }
    None
}

/// A box about the y axis on the origin: a cuboid, or one that tapers and leans.
fn cuboid(source: &mut Source, space: &Space, straight: bool) -> Loft {
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
    Loft::new(Outline::rectangle(x, z), height, scale, shift)
}

type Placed = (Loft, Rests);

/// Where a pose puts one, whether or not it fits there.
fn place(
    source: &mut Source,
    kind: Kind,
    space: &Space,
    (pose, gap): (Pose, f64),
    lamps: usize,
) -> Option<Placed> {
    let straight = kind == Kind::Room || pose == Pose::Beside;
    let loft = cuboid(source, space, straight);
    let yaw = DMat3::from_rotation_y(source.random_range(0.0..TAU));
    let at = space.somewhere(source);
    let mut rests = Rests::default();
    let placed = match pose {
        Pose::Standing => {
            rests.floor = true;
            loft.turned(yaw).moved(at + DVec3::Y * gap)
        }
        Pose::Hanging => {
            rests.ceiling = true;
            let top = space.room.height - gap;
            lowered(loft.turned(yaw).moved(at), top)
        }
        Pose::Floating => {
            let up = source.random_range(0.0..space.room.height);
            loft.turned(turned(source)).moved(at + DVec3::Y * up)
        }
        Pose::Leaning => {
            rests.floor = true;
            let tilt = DMat3::from_rotation_x(source.random_range(0.15..0.7));
            raised(loft.turned(yaw * tilt).moved(at), gap)
        }
        Pose::Against => {
            rests.floor = true;
            let part = source.random_range(0..space.room.parts.len());
            let planes = &space.room.parts[part].planes;
            let wall = source.random_range(2..planes.len());
            rests.wall = Some((part, wall));
            pushed(loft, at, &planes[wall], gap)?
        }
        Pose::Stacked => {
            let host = host(source, space, lamps)?;
            rests.body = Some(host);
            on(source, loft.turned(yaw), &space.taken[host], gap)?
        }
        Pose::Beside => {
            rests.floor = true;
            let host = host(source, space, lamps)?;
            rests.body = Some(host);
            beside(source, loft, &space.taken[host], gap)?
        }
    };
    Some((placed, rests))
}

/// One of the bodies that are there.
fn host(source: &mut Source, space: &Space, lamps: usize) -> Option<usize> {
    (space.taken.len() > lamps).then(|| source.random_range(lamps..space.taken.len()))
}

/// Its lowest corner at y = `low`.
fn raised(loft: Loft, low: f64) -> Loft {
    let lowest = loft.points().map(|p| p.y).fold(f64::INFINITY, f64::min);
    loft.moved(DVec3::Y * (low - lowest))
}

/// Its highest corner at y = `high`.
fn lowered(loft: Loft, high: f64) -> Loft {
    let highest = loft.points().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    loft.moved(DVec3::Y * (high - highest))
}

/// Turned towards a direction along the floor.
fn facing(loft: Loft, along: DVec3) -> Loft {
    loft.turned(DMat3::from_rotation_y((-along.z).atan2(along.x)))
}

/// Pushed along the floor up to a wall.
fn pushed(loft: Loft, at: DVec3, wall: &Plane, gap: f64) -> Option<Loft> {
    let along = DVec3::new(wall.normal.x, 0.0, wall.normal.z).try_normalize()?;
    let loft = facing(loft, along).moved(at);
    let shape = loft.parts().remove(0);
    let step = (-gap - highest(wall, &shape)) / wall.normal.dot(along);
    Some(loft.moved(along * step))
}

/// Upon another's level top.
fn on(source: &mut Source, loft: Loft, host: &Convex, gap: f64) -> Option<Loft> {
    let top = host.planes.get(1).filter(|p| p.normal.y > 1.0 - 1e-12)?;
    let corners = host.corners.iter().filter(|c| top.above(**c) > -1e-12);
    let (a, b) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), c| {
        (a.min(*c), b.max(*c))
    });
    let mut along = |k: usize| source.random_range(a[k]..b[k]);
    Some(loft.moved(DVec3::new(along(0), top.offset + gap, along(2))))
}

/// Side by side with another that stands, along one of its upright walls.
fn beside(source: &mut Source, loft: Loft, host: &Convex, gap: f64) -> Option<Loft> {
    let wall = host.planes.get(source.random_range(2..6))?;
    let [low, _] = host.extent(DVec3::Y);
    if wall.normal.y.abs() > 1e-12 || low.abs() > 1e-12 {
        return None;
    }
    let across = wall.normal.cross(DVec3::Y);
    let [a, b] = host.extent(across);
    let at = across * source.random_range(a..b);
    let loft = facing(loft, wall.normal).moved(at);
    let shape = loft.parts().remove(0);
    let [near, _] = shape.extent(wall.normal);
    Some(loft.moved(wall.normal * (wall.offset + gap - near)))
}
