//! What is put into the room: bodies in every position, and sheets.

use super::convex::{Convex, Plane};
use super::lamp::{self, Lamp};
use super::loft::{Loft, Outline, Panel};
use super::place::{Rests, Space, highest};
use super::room::Room;
use super::{Kind, Source, log_between, reflectance, turned};
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
    const ALL: [Self; 7] = [
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

/// How the two sides of a sheet are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheet {
    /// Each is the other's partner.
    Partners,
    /// Two faces that coincide.
    Coinciding,
}

impl fmt::Display for Sheet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Partners => "two-sided",
            Self::Coinciding => "of two faces",
        })
    }
}

/// What is in a room.
#[derive(Default)]
pub struct Furnished {
    pub panels: Vec<Panel>,
    pub poses: Vec<Pose>,
    pub gaps: Vec<f64>,
    pub sheets: Vec<Sheet>,
    pub lamps: Vec<Lamp>,
}

/// A scene has at most so many quads: its matrix must be solved in seconds.
const QUADS: usize = 30;
/// Places that are tried.
const TRIES: usize = 200;

/// Lamps first, for they need to be free; then bodies and sheets.
pub fn furnish(source: &mut Source, kind: Kind, room: &Room) -> Furnished {
    let mut space = Space::new(room);
    let mut all = Furnished::default();
    light(source, kind, &mut space, &mut all);
    let lamps = space.taken.len();
    let bodies = match kind {
        Kind::Any => source.random_range(1..=3),
        Kind::Room => source.random_range(2..=3),
    };
    for k in 0..bodies {
        let pose = match kind {
            Kind::Any => Pose::ALL[source.random_range(0..Pose::ALL.len())],
            Kind::Room => [Pose::Standing, Pose::Hanging][k % 2],
        };
        if room.panels.len() + all.panels.len() + 6 <= QUADS
            && let Some((loft, gap)) = put(source, kind, &mut space, pose, lamps)
        {
            let mut panels = loft.outward(&format!("body {}", k + 1));
            dress(source, &mut panels);
            all.panels.extend(panels);
            all.poses.push(pose);
            all.gaps.extend((gap > 0.0).then_some(gap / room.height));
        }
    }
    let sheets = match kind {
        Kind::Any => source.random_range(0..=1),
        Kind::Room => 0,
    };
    for _ in 0..sheets {
        if let Some((sheet, panel)) = hold(source, &mut space) {
            all.panels.push(panel);
            all.sheets.push(sheet);
        }
    }
    all
}

/// One to three lamps; a wall shines where there is no place for one.
fn light(source: &mut Source, kind: Kind, space: &mut Space, all: &mut Furnished) {
    let count = match kind {
        Kind::Any => [1, 1, 2, 3][source.random_range(0..4)],
        Kind::Room => 1,
    };
    for _ in 0..count {
        if let Some((lamp, panels)) = lamp::hang(source, space, kind) {
            all.lamps.push(lamp);
            let name = format!("lamp {}", all.lamps.len());
            let named = |panel| Panel {
                name: name.clone(),
                ..panel
            };
            all.panels.extend(panels.into_iter().map(named));
        }
    }
    if all.lamps.is_empty() {
        all.lamps.push(Lamp::Wall);
    }
}

/// One colour for all faces, or each its own.
pub fn dress(source: &mut Source, panels: &mut [Panel]) {
    let same = reflectance(source);
    let one = source.random_bool(0.6);
    for panel in panels {
        panel.reflectance = if one { same } else { reflectance(source) };
    }
}

/// A body in a pose, and the gap to what it nearly touches; none where there is no place.
fn put(
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

/// A sheet that floats, or stands on an edge.
fn hold(source: &mut Source, space: &mut Space) -> Option<(Sheet, Panel)> {
    let extent = space.room.bounds.end - space.room.bounds.start;
    let size = extent.min_element();
    let sheet = [Sheet::Partners, Sheet::Coinciding][source.random_range(0..2)];
    let stands = source.random_bool(0.5);
    let rests = Rests {
        floor: stands,
        ..Rests::default()
    };
    for _ in 0..TRIES {
        let [x, y] = std::array::from_fn(|_| source.random_range(0.2..0.7) * size);
        let turn = if stands {
            let lean = DMat3::from_rotation_x(source.random_range(-0.5..0.5));
            DMat3::from_rotation_y(source.random_range(0.0..TAU)) * lean
        } else {
            turned(source)
        };
        let up = if stands {
            0.0
        } else {
            source.random_range(0.0..space.room.height)
        };
        let at = space.somewhere(source) + DVec3::Y * up;
        let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
        let corners = corners.map(|[x, y]| at + turn * DVec3::new(x, y, 0.0));
        let shape = Convex::flat(&corners);
        if space.fits(&shape, rests) {
            space.taken.push(shape);
            let panel = Panel {
                reflectance: reflectance(source),
                two_sided: Some(sheet),
                ..Panel::new("sheet", corners)
            };
            return Some((sheet, panel));
        }
    }
    None
}
