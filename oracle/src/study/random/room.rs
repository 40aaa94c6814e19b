//! The room: an outline, what leans, which walls are missing.

use super::convex::Convex;
use super::loft::{Loft, Outline, Panel};
use super::{Kind, Source, reflectance};
use glam::{DVec2, DVec3};
use rand::RngExt;
use rand::seq::SliceRandom;
use std::f64::consts::TAU;
use std::ops::Range;

/// A room: its floor in y = 0, its ceiling in y = height.
pub struct Room {
    pub panels: Vec<Panel>,
    /// Convex parts, each with floor and ceiling as its first planes.
    pub parts: Vec<Convex>,
    pub height: f64,
    pub closed: bool,
    pub convex: bool,
    pub walls: usize,
    pub bounds: Range<DVec3>,
}

/// Draws one.
pub fn draw(source: &mut Source, kind: Kind, closed: bool) -> Room {
    let height = source.random_range(1.0..3.0);
    let [x, z] = std::array::from_fn(|_| source.random_range(1.2..3.0));
    let (outline, walls) = match (kind, source.random_range(0..10)) {
        (Kind::Room, _) | (_, 0..4) => (Outline::rectangle(x, z), 4),
        (_, 4..7) => {
            let at = DVec2::from_array(std::array::from_fn(|_| source.random_range(0.35..0.65)));
            (Outline::angle(x, z, at), 6)
        }
        _ => {
            let walls = source.random_range(5..=8);
            (polygon(source, walls, DVec2::new(x, z)), walls)
        }
    };
    let (scale, shift) = if kind == Kind::Any && source.random_bool(0.4) {
        let mut shift = || source.random_range(-0.3..0.3);
        let shift = DVec2::new(shift(), shift());
        (source.random_range(0.7..1.2), shift)
    } else {
        (1.0, DVec2::ZERO)
    };
    let loft = Loft::new(outline, height, scale, shift);
    let parts = loft.parts();
    let bounds = bounds(loft.points());
    let [floor, ceiling, mut sides] = loft.inward();
    if !closed {
        let missing = source.random_range(1..=sides.len() / 2);
        sides.shuffle(source);
        sides.truncate(sides.len() - missing);
    }
    let mut panels: Vec<Panel> = Vec::new();
    let floor_colour = reflectance(source);
    panels.extend(floor.into_iter().map(|panel| Panel {
        reflectance: floor_colour,
        ..panel
    }));
    panels.extend(ceiling.into_iter().chain(sides));
    for panel in panels.iter_mut().filter(|p| p.name != "floor") {
        panel.reflectance = reflectance(source);
    }
    Room {
        convex: parts.len() == 1,
        panels,
        parts,
        height,
        closed,
        walls,
        bounds,
    }
}

/// A convex polygon within an ellipse. An odd one gets a corner in the middle of an edge, so that it
/// can be cut into quads.
fn polygon(source: &mut Source, corners: usize, size: DVec2) -> Outline {
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
    Outline::convex(points)
}

fn bounds(points: impl Iterator<Item = DVec3>) -> Range<DVec3> {
    let all = DVec3::INFINITY..DVec3::NEG_INFINITY;
    points.fold(all, |b, p| b.start.min(p)..b.end.max(p))
}
