//! The furniture of random meshes: columns, partitions, stairs, louvres, bodies and lamps.

use super::super::convex::ConvexBody;
use super::super::lamp::draw_emission;
use super::super::loft::{Footprint, Loft, Panel, SheetSides};
use super::super::placement::{AllowedContacts, OccupiedRoom};
use super::super::{RandomSource, draw_log_uniform, draw_reflectance, draw_rotation};
use super::surfaces::{draw_body, place_panels, surround_panels};
use glam::{DMat3, DVec2, DVec3};
use rand::RngExt;
use std::f64::consts::{PI, TAU};

/// Length of the free space before a lamp, as a share of the room's height.
const CLEARANCE_SHARE: f64 = 0.2;
/// Placement attempts.
const MAX_TRIES: usize = 200;

/// Paints a thing with one colour.
fn paint_thing(source: &mut RandomSource, mut panels: Vec<Panel>) -> Vec<Panel> {
    let reflectance = draw_reflectance(source);
    for panel in &mut panels {
        panel.reflectance = reflectance;
    }
    panels
}

/// Adds a loft that stands or hangs where nothing else is.
fn add_loft(source: &mut RandomSource, space: &mut OccupiedRoom, loft: &Loft, name: &str) -> Vec<Panel> {
    space.bodies.push(loft.convex_hull());
    paint_thing(source, loft.outward_panels(name))
}

/// Places columns from floor to ceiling on a lattice.
pub fn place_columns(source: &mut RandomSource, space: &mut OccupiedRoom) -> Vec<Panel> {
    let extent = space.room.bounds.end - space.room.bounds.start;
    let [nx, nz] = std::array::from_fn(|_| source.random_range(2..=5));
    let pitch = DVec2::new(extent.x / nx as f64, extent.z / nz as f64);
    let corners = 2 * source.random_range(3..=12);
    let radius = source.random_range(0.08..0.25) * pitch.min_element();
    let mut panels = Vec::new();
    for (i, k) in (0..nx).flat_map(|i| (0..nz).map(move |k| (i, k))) {
        let outline = Footprint::regular(corners, DVec2::splat(radius));
        let at = space.room.bounds.start + DVec3::new((i as f64 + 0.5) * pitch.x, 0.0, (k as f64 + 0.5) * pitch.y);
        let loft = Loft::new(outline, space.room.height, 1.0, DVec2::ZERO).move_by(at);
        panels.extend(add_loft(source, space, &loft, "column"));
    }
    panels
}

/// Divides a corridor along z into parts by walls that leave a passage on alternating sides.
pub fn place_partitions(source: &mut RandomSource, space: &mut OccupiedRoom) -> Vec<Panel> {
    let (bounds, height) = (space.room.bounds.clone(), space.room.height);
    let extent = bounds.end - bounds.start;
    let parts = source.random_range(2..=8);
    let pitch = extent.z / f64::from(parts);
    let mut panels = Vec::new();
    for k in 1..parts {
        let wide = source.random_range(0.4..0.85) * extent.x;
        let thick = source.random_range(0.02..0.2) * pitch;
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        let at = DVec3::new(
            side * 0.5 * (extent.x - wide),
            0.0,
            bounds.start.z + f64::from(k) * pitch,
        );
        let loft = Loft::new(Footprint::rectangle(wide, thick), height, 1.0, DVec2::ZERO).move_by(at);
        panels.extend(add_loft(source, space, &loft, "partition"));
    }
    panels
}

/// Makes a panel whose front faces `towards`.
fn facing_panel(name: &str, mut corners: [DVec3; 4], towards: DVec3) -> Panel {
    let [a, b, c, d] = corners;
    if (c - a).cross(d - b).dot(towards) < 0.0 {
        corners.reverse();
    }
    Panel::new(name, corners)
}

/// Makes stairs of `count` steps that rise along z, on the origin.
fn make_stairs(count: usize, [width, depth, height]: [f64; 3]) -> Vec<Panel> {
    let at = |side: f64, k: usize, level: usize| {
        let steps = count as f64;
        DVec3::new(
            side * 0.5 * width,
            level as f64 * height / steps,
            k as f64 * depth / steps,
        )
    };
    let strip = |[k, y]: [usize; 2], [l, z]: [usize; 2], towards| {
        facing_panel(
            "stairs",
            [at(-1.0, k, y), at(1.0, k, y), at(1.0, l, z), at(-1.0, l, z)],
            towards,
        )
    };
    let mut panels = vec![strip([count, 0], [count, count], DVec3::Z)];
    for k in 0..count {
        panels.push(strip([k, k], [k, k + 1], -DVec3::Z));
        panels.push(strip([k, k + 1], [k + 1, k + 1], DVec3::Y));
        for side in [-1.0, 1.0] {
            let corners = [(k, 0), (k, k + 1), (k + 1, k + 1), (k + 1, 0)].map(|(k, level)| at(side, k, level));
            panels.push(facing_panel("stairs", corners, DVec3::X * side));
        }
    }
    panels
}

/// Makes a row of tilted sheets along z, about the origin.
fn make_louvres(source: &mut RandomSource, count: usize, [width, length]: [f64; 2]) -> Vec<Panel> {
    let pitch = length / count as f64;
    let depth = source.random_range(0.4..1.5) * pitch;
    let tilt = DMat3::from_rotation_x(source.random_range(-1.3..1.3));
    let sheet = |k: usize| {
        let middle = DVec3::Z * ((k as f64 + 0.5) * pitch - 0.5 * length);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let corners = corners.map(|[x, z]| middle + tilt * (0.5 * DVec3::new(x * width, 0.0, z * depth)));
        Panel {
            two_sided: Some(SheetSides::Partners),
            ..Panel::new("louvre", corners)
        }
    };
    (0..count).map(sheet).collect()
}

/// Places a thing, which stands on the floor or floats; nothing if no attempt fits.
fn place_thing(source: &mut RandomSource, space: &mut OccupiedRoom, thing: &[Panel], stands: bool) -> Vec<Panel> {
    let rests = AllowedContacts {
        floor: stands,
        ..AllowedContacts::default()
    };
    for _ in 0..MAX_TRIES {
        let yaw = DMat3::from_rotation_y(source.random_range(0.0..TAU));
        let mut placed = thing.to_vec();
        let up = match stands {
            true => 0.0,
            false => source.random_range(0.1..0.9) * space.room.height,
        };
        let at = space.draw_floor_point(source) + DVec3::Y * up;
        place_panels(&mut placed, yaw, 1.0, at);
        let around = surround_panels(&placed).convex_hull();
        if space.fits_body(&around, rests) {
            space.bodies.push(around);
            return paint_thing(source, placed);
        }
    }
    Vec::new()
}

/// Places stairs and a row of louvres.
pub fn place_stairs_and_louvres(source: &mut RandomSource, space: &mut OccupiedRoom) -> Vec<Panel> {
    let extent = space.room.bounds.end - space.room.bounds.start;
    let size = extent.x.min(extent.z);
    let mut draw = |low: f64, high: f64| source.random_range(low..high);
    let stairs = [draw(0.2, 0.4) * size, draw(0.3, 0.6) * size, draw(0.3, 0.6) * extent.y];
    let sheets = [draw(0.3, 0.6) * size, draw(0.3, 0.6) * size];
    let [steps, count] = [source.random_range(4..16), source.random_range(6..30)];
    let stairs = make_stairs(steps, stairs);
    let louvres = make_louvres(source, count, sheets);
    let mut panels = place_thing(source, space, &louvres, false);
    panels.extend(place_thing(source, space, &stairs, true));
    panels
}

/// Places up to `count` bodies of `triangles` triangles in all, in any orientation.
pub fn place_bodies(
    source: &mut RandomSource,
    space: &mut OccupiedRoom,
    (count, triangles): (usize, f64),
    stretch: f64,
) -> Vec<Panel> {
    let extent = space.room.bounds.end - space.room.bounds.start;
    let mut panels = Vec::new();
    for k in 0..count {
        let mut body = draw_body(source, &format!("body {}", k + 1), triangles / count as f64, stretch);
        let (turn, scale) = (
            draw_rotation(source),
            source.random_range(0.08..0.25) * extent.min_element(),
        );
        place_panels(&mut body, turn, scale, DVec3::ZERO);
        let [low, _] = surround_panels(&body).height_range();
        let stands = source.random_bool(0.6);
        if stands {
            let gap = [0.0, draw_log_uniform(source, 1e-3, 1e-1)][source.random_range(0..2)];
            place_panels(&mut body, DMat3::IDENTITY, 1.0, DVec3::Y * (gap * scale - low));
        }
        panels.extend(place_thing(source, space, &body, stands));
    }
    panels
}

/// Places up to `count` lamp panels about `size` wide, half of them facing down, with free space before them: paths find
/// the spot that a near lamp lights too seldom to judge by.
pub fn place_lamps(source: &mut RandomSource, space: &mut OccupiedRoom, count: usize, size: f64) -> Vec<Panel> {
    let mut lamps: Vec<Panel> = Vec::new();
    for _ in 0..count {
        let [x, z] = std::array::from_fn(|_| 0.5 * size * source.random_range(0.6..1.6));
        for _ in 0..MAX_TRIES {
            let turn = match source.random_bool(0.5) {
                true => DMat3::from_rotation_y(source.random_range(0.0..PI)),
                false => draw_rotation(source),
            };
            let up = source.random_range(0.1..0.95) * space.room.height;
            let at = space.draw_floor_point(source) + DVec3::Y * up;
            let corners = [[-x, -z], [x, -z], [x, z], [-x, z]].map(|[x, z]| at + turn * DVec3::new(x, 0.0, z));
            let shape = ConvexBody::from_outline(&corners);
            let ahead = turn * DVec3::NEG_Y * (CLEARANCE_SHARE * space.room.height);
            let zone = ConvexBody::from_prism(&corners.map(|corner| corner + ahead), &corners);
            if [&shape, &zone]
                .iter()
                .all(|body| space.fits_body(body, AllowedContacts::default()))
            {
                space.bodies.push(shape);
                lamps.push(Panel {
                    emission: draw_emission(source),
                    reflectance: draw_reflectance(source),
                    ..Panel::new(&format!("lamp {}", lamps.len() + 1), corners)
                });
                break;
            }
        }
    }
    lamps
}
