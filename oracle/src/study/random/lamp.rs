//! What shines, with room to shine into.

use super::convex::Convex;
use super::loft::{Loft, Outline, Panel, dress};
use super::place::{Rests, Space};
use super::{Kind, Source, log_between, reflectance};
use glam::{DMat3, DVec2, DVec3, Vec3};
use rand::RngExt;
use std::f64::consts::TAU;
use std::fmt;

/// A lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lamp {
    /// A small panel below the ceiling that shines down.
    Panel,
    /// A small box that shines all around.
    Box,
    /// A part of the room itself.
    Wall,
}

impl fmt::Display for Lamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Panel => "panel",
            Self::Box => "box",
            Self::Wall => "wall",
        })
    }
}

/// Below a lamp nothing is nearer than this share of the height.
const CLEAR: f64 = 0.3;
/// Places that are tried.
const TRIES: usize = 400;

/// Hangs one up; none where there is no place. A shining wall has no panels: see [`paint`].
pub fn hang(source: &mut Source, space: &mut Space, kind: Kind) -> Option<(Lamp, Vec<Panel>)> {
    let lamp = match (kind, source.random_range(0..10)) {
        (Kind::Room, _) | (_, 0..6) => Lamp::Panel,
        (_, 6..8) => Lamp::Box,
        _ => Lamp::Wall,
    };
    match lamp {
        Lamp::Panel => panel(source, space).map(|panel| (lamp, vec![panel])),
        Lamp::Box => cube(source, space).map(|panels| (lamp, panels)),
        Lamp::Wall => Some((lamp, Vec::new())),
    }
}

/// White to coloured, over more than a decade, W/m².
fn shine(source: &mut Source) -> Vec3 {
    let strength = log_between(source, 2.0, 40.0) as f32;
    let mut channel = || strength * source.random_range(0.4f32..1.0);
    Vec3::new(channel(), channel(), channel())
}

/// Makes a part of the room shine; its floor never does.
pub fn paint(source: &mut Source, room: &mut [Panel]) {
    let first = room.iter().filter(|panel| panel.name == "floor").count();
    let chosen = source.random_range(first..room.len());
    room[chosen].emission = shine(source);
}

fn panel(source: &mut Source, space: &mut Space) -> Option<Panel> {
    let height = space.room.height;
    let [x, z] = std::array::from_fn(|_| source.random_range(0.15..0.5));
    let below = source.random_range(0.02..0.1) * height;
    let rests = Rests {
        ceiling: true,
        ..Rests::default()
    };
    let outline = |at: DVec3, turn: DMat3| {
        let corners = [[-x, -z], [x, -z], [x, z], [-x, z]];
        corners.map(|[x, z]| at + turn * (0.5 * DVec3::new(x, 0.0, z)))
    };
    for _ in 0..TRIES {
        let turn = DMat3::from_rotation_y(source.random_range(0.0..TAU));
        let at = space.somewhere(source) + DVec3::Y * (height - below);
        let corners = outline(at, turn);
        let shape = Convex::flat(&corners);
        let zone = Convex::prism(&corners.map(|c| c - DVec3::Y * CLEAR * height), &corners);
        if space.fits(&shape, rests) && space.fits(&zone, rests) {
            space.taken.push(shape);
            space.clear.push(zone);
            return Some(Panel {
                emission: shine(source),
                reflectance: reflectance(source),
                ..Panel::new("lamp", corners)
            });
        }
    }
    None
}

fn cube(source: &mut Source, space: &mut Space) -> Option<Vec<Panel>> {
    let height = space.room.height;
    let [x, y, z] = std::array::from_fn(|_| source.random_range(0.1..0.25));
    let body = |grown: f64| {
        let [x, y, z] = [x, y, z].map(|side| side + 2.0 * grown);
        let loft = Loft::new(Outline::rectangle(x, z), y, 1.0, DVec2::ZERO);
        loft.moved(DVec3::Y * -0.5 * y)
    };
    for _ in 0..TRIES {
        let turn = super::turned(source);
        let up = source.random_range(0.5..0.9) * height;
        let at = space.somewhere(source) + DVec3::Y * up;
        let [body, zone] = [0.0, 0.05 * height].map(|grown| body(grown).turned(turn).moved(at));
        let shape = body.parts().remove(0);
        let around = zone.parts().remove(0);
        if space.fits(&around, Rests::default()) {
            space.taken.push(shape);
            space.clear.push(around);
            let mut panels = body.outward("lamp");
            dress(source, &mut panels);
            let emission = shine(source);
            for panel in &mut panels {
                panel.emission = emission;
            }
            return Some(panels);
        }
    }
    None
}
