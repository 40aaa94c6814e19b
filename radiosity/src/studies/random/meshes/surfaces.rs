//! Curved and cut surfaces of random meshes, made of panels that become triangles.

use super::super::loft::{Footprint, Loft, Panel};
use super::super::room::bounding_box;
use super::super::{RandomSource, draw_rotation};
use glam::{DMat3, DVec2, DVec3};
use rand::RngExt;
use std::f64::consts::{PI, TAU};

/// Number of waves of a rough surface.
const WAVE_COUNT: usize = 6;
/// Largest slope of one wave.
const MAX_WAVE_SLOPE: f64 = 0.15;
/// Largest number of cuts along one side of a panel.
const MAX_CUTS: f64 = 400.0;
/// Radius of a surface of revolution below which it is a pole, whose corners coincide.
const POLE_RADIUS: f64 = 1e-9;

/// Cuts the image of the unit square into cells, with the front where `at` runs counter-clockwise.
pub fn cut_surface(name: &str, [columns, rows]: [usize; 2], at: impl Fn(f64, f64) -> DVec3) -> Vec<Panel> {
    let at = |i: usize, j: usize| at(i as f64 / columns as f64, j as f64 / rows as f64);
    let cell = |(i, j)| Panel::new(name, [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    cells.map(cell).collect()
}

/// Cuts a panel into cells about `size` wide, and `stretch` times as long as wide.
pub fn cut_panel(panel: &Panel, size: f64, stretch: f64) -> Vec<Panel> {
    let [a, b, c, d] = panel.corners;
    let sides = [a.distance(b).max(c.distance(d)), a.distance(d).max(b.distance(c))];
    let (long, narrow) = (size * stretch.sqrt(), size / stretch.sqrt());
    let widths = if sides[0] > sides[1] {
        [long, narrow]
    } else {
        [narrow, long]
    };
    let cuts = [0, 1].map(|k| (sides[k] / widths[k]).round().clamp(1.0, MAX_CUTS) as usize);
    let at = |u: f64, v: f64| a.lerp(b, u).lerp(d.lerp(c, u), v);
    let cells = cut_surface(&panel.name, cuts, at).into_iter();
    cells
        .map(|cell| Panel {
            corners: cell.corners,
            ..panel.clone()
        })
        .collect()
}

/// Draws the height of a rough surface at a point: a sum of waves, the finest `size` long.
pub fn draw_roughness(source: &mut RandomSource, size: f64) -> impl Fn(DVec3) -> f64 + use<> {
    let waves: [(DVec3, f64, f64); WAVE_COUNT] = std::array::from_fn(|_| {
        let number = TAU / (size * source.random_range(1.0..8.0));
        let slope = source.random_range(0.0..MAX_WAVE_SLOPE);
        let along = draw_rotation(source) * DVec3::X;
        (along * number, source.random_range(0.0..TAU), slope / number)
    });
    move |p| {
        let wave = |(along, phase, height): &(DVec3, f64, f64)| height * (along.dot(p) + phase).sin();
        waves.iter().map(wave).sum()
    }
}

/// Makes a surface about the y axis with the front outwards, of radius and height (r, y) along a profile that
/// goes upwards outside.
pub fn revolve_profile(name: &str, cuts: [usize; 2], profile: impl Fn(f64) -> DVec2) -> Vec<Panel> {
    cut_surface(name, cuts, |u, v| {
        let (at, angle) = (profile(v), TAU * u);
        let radius = if at.x < POLE_RADIUS { 0.0 } else { at.x };
        DVec3::new(radius * angle.sin(), at.y, radius * angle.cos())
    })
}

/// Draws a body of about so many triangles and an extent of 1 to 2 about the origin: a ball, a vase or a ring, smooth
/// or rough.
pub fn draw_body(source: &mut RandomSource, name: &str, triangles: f64, stretch: f64) -> Vec<Panel> {
    // Two triangles a cell, twice as many cells around as along.
    let rows = (0.5 * (triangles / stretch).sqrt()).max(3.0);
    let cuts = [2.0 * rows * stretch, rows].map(|n| n.round().clamp(3.0, MAX_CUTS) as usize);
    let [belly, neck] = [source.random_range(0.3..0.7), source.random_range(0.1..0.25)];
    let profile: Box<dyn Fn(f64) -> DVec2> = match source.random_range(0..3) {
        0 => Box::new(|v| DVec2::new((PI * v).sin(), -(PI * v).cos())),
        1 => Box::new(move |v| DVec2::new((PI * v).sin() * (belly + neck * (3.0 * PI * v).cos()), 2.0 * v - 1.0)),
        _ => Box::new(move |v| DVec2::new(1.0 + 0.5 * neck * (TAU * v).cos(), 0.5 * neck * (TAU * v).sin())),
    };
    let mut panels = revolve_profile(name, cuts, profile);
    if source.random_bool(0.6) {
        let height = draw_roughness(source, 0.3);
        for corner in panels.iter_mut().flat_map(|panel| &mut panel.corners) {
            *corner *= 1.0 + height(*corner);
        }
    }
    panels
}

/// Rotates, then scales and moves panels.
pub fn place_panels(panels: &mut [Panel], turn: DMat3, scale: f64, to: DVec3) {
    for corner in panels.iter_mut().flat_map(|panel| &mut panel.corners) {
        *corner = turn * *corner * scale + to;
    }
}

/// Turns panels inside out.
pub fn reverse_panels(panels: &mut [Panel]) {
    for panel in panels {
        panel.corners.reverse();
    }
}

/// Returns the box around panels.
pub fn surround_panels(panels: &[Panel]) -> Loft {
    let bounds = bounding_box(panels.iter().flat_map(|panel| panel.corners));
    let size = bounds.end - bounds.start;
    let middle = 0.5 * (bounds.start + bounds.end);
    Loft::new(Footprint::rectangle(size.x, size.z), size.y, 1.0, DVec2::ZERO).move_by(DVec3::new(
        middle.x,
        bounds.start.y,
        middle.z,
    ))
}
