//! The radiance map of a studio, a room of 5 × 3 × 6 m with a lamp and a window, as seen from its centre.
//!
//! Axes and projection are those of `common::capture`: lat-long, y up, +z in the middle, +x a quarter turn to its left.
//! Light of the lamp and the window is exact (Lambert's polygon formula); light between walls is that of their mean
//! radiosities.

use super::{parallelogram, unit_room};
use glam::DVec3;
use image::Rgb;
use image::codecs::hdr::HdrEncoder;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

const MAP_SIZE: [usize; 2] = [256, 128];
const ROOM_SIZE: DVec3 = DVec3::new(5.0, 3.0, 6.0);
/// Directions per side of a pixel.
const DIRECTIONS_PER_SIDE: usize = 4;
/// Points per side of a wall, for its mean irradiance.
const POINTS_PER_SIDE: u32 = 8;
/// Bounces between walls; the next adds less than the file's rounding.
const MAX_BOUNCES: u32 = 30;

/// Reflectance of floor, ceiling, right, left, back and front wall.
const WALL_REFLECTANCES: [DVec3; 6] = [
    DVec3::new(0.56, 0.42, 0.29),
    DVec3::new(0.78, 0.78, 0.76),
    DVec3::new(0.2, 0.42, 0.46),
    DVec3::new(0.74, 0.38, 0.22),
    DVec3::new(0.6, 0.58, 0.54),
    DVec3::new(0.76, 0.74, 0.68),
];
const CEILING: usize = 1;
const LEFT_WALL: usize = 3;
const BACK_WALL: usize = 4;
const FRONT_WALL: usize = 5;

/// A rectangle of another colour on a wall, between shares of its sides.
struct Panel {
    wall: usize,
    low: [f64; 2],
    high: [f64; 2],
    reflectance: DVec3,
    radiance: DVec3,
}

/// A lamp, a window, a door and a picture.
const PANELS: [Panel; 4] = [
    lit_panel(CEILING, [0.3, 0.3], [0.7, 0.5], [8.0, 6.5, 4.5]),
    lit_panel(LEFT_WALL, [0.68, 0.42], [0.88, 0.86], [26.0, 27.0, 28.0]),
    dark_panel(BACK_WALL, [0.2, 0.0], [0.4, 0.7], [0.25, 0.14, 0.08]),
    dark_panel(FRONT_WALL, [0.28, 0.15], [0.54, 0.42], [0.1, 0.16, 0.32]),
];

const fn lit_panel(wall: usize, low: [f64; 2], high: [f64; 2], radiance: [f64; 3]) -> Panel {
    Panel {
        wall,
        low,
        high,
        reflectance: DVec3::ZERO,
        radiance: DVec3::from_array(radiance),
    }
}

const fn dark_panel(wall: usize, low: [f64; 2], high: [f64; 2], reflectance: [f64; 3]) -> Panel {
    Panel {
        reflectance: DVec3::from_array(reflectance),
        ..lit_panel(wall, low, high, [0.0; 3])
    }
}

/// A wall; its front is on the side of u × v. The origin of coordinates is the room's centre.
#[derive(Clone, Copy)]
struct Wall {
    origin: DVec3,
    u: DVec3,
    v: DVec3,
}

impl Wall {
    fn point_at(&self, [s, t]: [f64; 2]) -> DVec3 {
        self.origin + self.u * s + self.v * t
    }

    fn normal(&self) -> DVec3 {
        self.u.cross(self.v).normalize()
    }

    /// Returns the corners of a part of the wall.
    fn part_corners(&self, low: [f64; 2], high: [f64; 2]) -> Vec<DVec3> {
        let (u, v) = (self.u * (high[0] - low[0]), self.v * (high[1] - low[1]));
        parallelogram(self.point_at(low), u, v)
    }
}

/// The walls and their mean radiosities, W/m².
struct Studio {
    walls: [Wall; 6],
    radiosities: [DVec3; 6],
}

/// Encodes the map as a Radiance picture.
pub fn write_studio() -> Vec<u8> {
    let studio = Studio::solve();
    let [width, height] = MAP_SIZE;
    let mut pixels = Vec::new();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let mut sum = DVec3::ZERO;
        for k in 0..DIRECTIONS_PER_SIDE * DIRECTIONS_PER_SIDE {
            let offset = |k: usize| (k as f64 + 0.5) / DIRECTIONS_PER_SIDE as f64;
            let column = x as f64 + offset(k % DIRECTIONS_PER_SIDE);
            let row = y as f64 + offset(k / DIRECTIONS_PER_SIDE);
            let (sin, cos) = ((0.5 - column / width as f64) * TAU).sin_cos();
            let (up, flat) = ((0.5 - row / height as f64) * PI).sin_cos();
            sum += studio.radiance(DVec3::new(sin * flat, up, cos * flat));
        }
        let mean = sum / (DIRECTIONS_PER_SIDE * DIRECTIONS_PER_SIDE) as f64;
        pixels.push(Rgb(mean.as_vec3().to_array()));
    }
    let mut bytes = Vec::new();
    let encoded = HdrEncoder::new(&mut bytes).encode(&pixels, width, height);
    encoded.expect("a write to memory succeeds");
    bytes
}

impl Studio {
    /// Iterates the mean radiosities of the walls, by a grid of points on each.
    fn solve() -> Self {
        let walls = unit_room().map(|(origin, u, v)| Wall {
            origin: (origin - 0.5) * ROOM_SIZE,
            u: u * ROOM_SIZE,
            v: v * ROOM_SIZE,
        });
        let mut studio = Self {
            walls,
            radiosities: [DVec3::ZERO; 6],
        };
        let n = POINTS_PER_SIDE;
        for _ in 0..MAX_BOUNCES {
            studio.radiosities = std::array::from_fn(|wall| {
                let share = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
                let places = (0..n * n).map(|k| [share(k % n), share(k / n)]);
                let sum: DVec3 = places
                    .map(|place| reflectance_at(wall, place) * studio.irradiance(wall, place))
                    .sum();
                sum / f64::from(n * n)
            });
        }
        studio
    }

    /// Returns the irradiance of a place on a wall from the panels that emit and from the other walls.
    fn irradiance(&self, wall: usize, place: [f64; 2]) -> DVec3 {
        let (at, normal) = (self.walls[wall].point_at(place), self.walls[wall].normal());
        let panels = PANELS.iter().filter(|panel| panel.wall != wall);
        let direct = panels.map(|panel| {
            let corners = self.walls[panel.wall].part_corners(panel.low, panel.high);
            panel.radiance * projected_solid_angle(at, normal, &corners)
        });
        let others = (0..6).filter(|other| *other != wall);
        let reflected = others.map(|other| {
            let corners = self.walls[other].part_corners([0.0; 2], [1.0; 2]);
            self.radiosities[other] * (FRAC_1_PI * projected_solid_angle(at, normal, &corners))
        });
        direct.chain(reflected).sum()
    }

    /// Returns the radiance from a direction at the room's centre.
    fn radiance(&self, direction: DVec3) -> DVec3 {
        let distance = |wall: &Wall| wall.origin.dot(wall.normal()) / direction.dot(wall.normal());
        let ahead = |wall: &usize| direction.dot(self.walls[*wall].normal()) < 0.0;
        let wall = (0..6)
            .filter(ahead)
            .min_by(|a, b| distance(&self.walls[*a]).total_cmp(&distance(&self.walls[*b])))
            .expect("a closed room");
        let Wall { origin, u, v } = self.walls[wall];
        let from_origin = direction * distance(&self.walls[wall]) - origin;
        let place = [u, v].map(|side| from_origin.dot(side) / side.length_squared());
        let emitted = panel_at(wall, place).map_or(DVec3::ZERO, |panel| panel.radiance);
        emitted + reflectance_at(wall, place) * self.irradiance(wall, place) * FRAC_1_PI
    }
}

fn panel_at(wall: usize, [s, t]: [f64; 2]) -> Option<&'static Panel> {
    PANELS.iter().find(|panel| {
        let [across, along] = [0, 1].map(|k| panel.low[k]..panel.high[k]);
        panel.wall == wall && across.contains(&s) && along.contains(&t)
    })
}

fn reflectance_at(wall: usize, place: [f64; 2]) -> DVec3 {
    panel_at(wall, place).map_or(WALL_REFLECTANCES[wall], |panel| panel.reflectance)
}

/// Returns ∫cosθ dω over a polygon in front of a point (Lambert 1760).
fn projected_solid_angle(at: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let sum: f64 = corners
        .iter()
        .zip(next)
        .map(|(a, b)| {
            let [a, b] = [*a - at, *b - at];
            let axis = a.cross(b);
            a.angle_between(b) * axis.dot(normal) / axis.length()
        })
        .sum();
    sum.abs() / 2.0
}
