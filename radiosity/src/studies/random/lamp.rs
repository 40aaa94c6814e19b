//! Lamps, each with free space around or below it.

use super::convex::ConvexBody;
use super::loft::{Footprint, Loft, Panel, paint_panels};
use super::placement::{AllowedContacts, OccupiedRoom};
use super::{RandomSource, draw_log_uniform, draw_reflectance};
use glam::{DMat3, DVec2, DVec3, Vec3};
use rand::RngExt;
use std::f64::consts::TAU;

/// Kind of a lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LampKind {
    /// A small panel below the ceiling that emits downwards.
    Panel,
    /// A small box that emits on all sides.
    Box,
    /// A part of the room itself.
    Wall,
}

/// Height of the free space below a lamp panel, as a share of the room's height.
const CLEARANCE_SHARE: f64 = 0.3;
/// Placement attempts per lamp.
const MAX_TRIES: usize = 400;

/// Places a lamp; none if no attempt fits. An emitting wall has no panels of its own; see
/// [`make_wall_emit`].
pub fn place_lamp(source: &mut RandomSource, space: &mut OccupiedRoom) -> Option<(LampKind, Vec<Panel>)> {
    match source.random_range(0..10) {
        0..6 => place_lamp_panel(source, space).map(|panel| (LampKind::Panel, vec![panel])),
        6..8 => place_lamp_box(source, space).map(|panels| (LampKind::Box, panels)),
        _ => Some((LampKind::Wall, Vec::new())),
    }
}

/// Draws an emission, white to coloured, over more than a decade, W/m².
pub fn draw_emission(source: &mut RandomSource) -> Vec3 {
    let strength = draw_log_uniform(source, 2.0, 40.0) as f32;
    let mut channel = || strength * source.random_range(0.4f32..1.0);
    Vec3::new(channel(), channel(), channel())
}

/// Makes a random part of the room emit, except the floor.
pub fn make_wall_emit(source: &mut RandomSource, room: &mut [Panel]) {
    let first = room.iter().filter(|panel| panel.name == "floor").count();
    let chosen = source.random_range(first..room.len());
    room[chosen].emission = draw_emission(source);
}

fn place_lamp_panel(source: &mut RandomSource, space: &mut OccupiedRoom) -> Option<Panel> {
    let height = space.room.height;
    let [x, z] = std::array::from_fn(|_| source.random_range(0.15..0.5));
    let below = source.random_range(0.02..0.1) * height;
    let rests = AllowedContacts {
        ceiling: true,
        ..AllowedContacts::default()
    };
    let outline = |at: DVec3, turn: DMat3| {
        let corners = [[-x, -z], [x, -z], [x, z], [-x, z]];
        corners.map(|[x, z]| at + turn * (0.5 * DVec3::new(x, 0.0, z)))
    };
    for _ in 0..MAX_TRIES {
        let turn = DMat3::from_rotation_y(source.random_range(0.0..TAU));
        let at = space.draw_floor_point(source) + DVec3::Y * (height - below);
        let corners = outline(at, turn);
        let shape = ConvexBody::from_outline(&corners);
        let zone = ConvexBody::from_prism(&corners.map(|c| c - DVec3::Y * CLEARANCE_SHARE * height), &corners);
        if space.fits_body(&shape, rests) && space.fits_body(&zone, rests) {
            space.bodies.push(shape);
            space.free_zones.push(zone);
            return Some(Panel {
                emission: draw_emission(source),
                reflectance: draw_reflectance(source),
                ..Panel::new("lamp", corners)
            });
        }
    }
    None
}

fn place_lamp_box(source: &mut RandomSource, space: &mut OccupiedRoom) -> Option<Vec<Panel>> {
    let height = space.room.height;
    let [x, y, z] = std::array::from_fn(|_| source.random_range(0.1..0.25));
    let body = |grown: f64| {
        let [x, y, z] = [x, y, z].map(|side| side + 2.0 * grown);
        let loft = Loft::new(Footprint::rectangle(x, z), y, 1.0, DVec2::ZERO);
        loft.move_by(DVec3::Y * -0.5 * y)
    };
    for _ in 0..MAX_TRIES {
        let turn = super::draw_rotation(source);
        let up = source.random_range(0.5..0.9) * height;
        let at = space.draw_floor_point(source) + DVec3::Y * up;
        let [body, zone] = [0.0, 0.05 * height].map(|grown| body(grown).rotate_by(turn).move_by(at));
        let shape = body.convex_hull();
        let around = zone.convex_hull();
        if space.fits_body(&around, AllowedContacts::default()) {
            space.bodies.push(shape);
            space.free_zones.push(around);
            let mut panels = body.outward_panels("lamp");
            paint_panels(source, &mut panels);
            let emission = draw_emission(source);
            for panel in &mut panels {
                panel.emission = emission;
            }
            return Some(panels);
        }
    }
    None
}
