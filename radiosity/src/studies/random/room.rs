//! Random rooms: outline, slant, missing walls.

use super::convex::ConvexBody;
use super::loft::{Footprint, Loft, Panel};
use super::{RandomSource, draw_reflectance};
use glam::{DVec2, DVec3};
use rand::RngExt;
use rand::seq::SliceRandom;
use std::f64::consts::TAU;
use std::ops::Range;

/// A room with its floor in y = 0 and its ceiling in y = `height`.
pub struct RandomRoom {
    pub panels: Vec<Panel>,
    /// Convex parts, each with the planes of floor and ceiling first.
    pub parts: Vec<ConvexBody>,
    pub height: f64,
    pub closed: bool,
    pub walls: usize,
    pub bounds: Range<DVec3>,
}

/// Draws a room.
pub fn draw_room(source: &mut RandomSource, closed: bool) -> RandomRoom {
    let height = source.random_range(1.0..3.0);
    let [x, z] = std::array::from_fn(|_| source.random_range(1.2..3.0));
    let (outline, walls) = match source.random_range(0..10) {
        0..4 => (Footprint::rectangle(x, z), 4),
        4..7 => {
            let at = DVec2::from_array(std::array::from_fn(|_| source.random_range(0.35..0.65)));
            (Footprint::l_shape(x, z, at), 6)
        }
        _ => {
            let walls = source.random_range(5..=8);
            (draw_polygon(source, walls, DVec2::new(x, z)), walls)
        }
    };
    let (scale, shift) = if source.random_bool(0.4) {
        let mut shift = || source.random_range(-0.3..0.3);
        let shift = DVec2::new(shift(), shift());
        (source.random_range(0.7..1.2), shift)
    } else {
        (1.0, DVec2::ZERO)
    };
    RandomRoom {
        walls,
        ..enclose_room(source, &Loft::new(outline, height, scale, shift), closed)
    }
}

/// Makes a room of the inside of a loft that stands on y = 0; an open one lacks some walls.
pub fn enclose_room(source: &mut RandomSource, loft: &Loft, closed: bool) -> RandomRoom {
    let parts = loft.convex_parts();
    let bounds = bounding_box(loft.corner_points());
    let [floor, ceiling, mut sides] = loft.inward_panels();
    let walls = sides.len();
    if !closed {
        let missing = source.random_range(1..=walls / 2);
        sides.shuffle(source);
        sides.truncate(walls - missing);
    }
    let floor_colour = draw_reflectance(source);
    let mut panels: Vec<Panel> = [floor, ceiling, sides].concat();
    for panel in &mut panels {
        panel.reflectance = match &*panel.name {
            "floor" => floor_colour,
            _ => draw_reflectance(source),
        };
    }
    RandomRoom {
        panels,
        parts,
        height: bounds.end.y,
        closed,
        walls,
        bounds,
    }
}

/// Draws a convex polygon within an ellipse. With an odd number of corners it gets another in the
/// middle of an edge, so that it can be cut into quads.
fn draw_polygon(source: &mut RandomSource, corners: usize, size: DVec2) -> Footprint {
    let step = TAU / corners as f64;
    let mut points: Vec<DVec2> = (0..corners)
        .map(|k| {
            let angle = step * (k as f64 + source.random_range(-0.25..0.25));
            DVec2::new(angle.sin(), angle.cos()) * 0.55 * size
        })
        .collect();
    if corners % 2 == 1 {
        points.insert(0, 0.5 * (points[0] + points[corners - 1]));
    }
    Footprint::from_convex(points)
}

pub fn bounding_box(points: impl Iterator<Item = DVec3>) -> Range<DVec3> {
    let all = DVec3::INFINITY..DVec3::NEG_INFINITY;
    points.fold(all, |b, p| b.start.min(p)..b.end.max(p))
}
