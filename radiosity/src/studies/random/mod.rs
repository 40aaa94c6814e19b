//! Random scenes, on which no solver was tuned.
//!
//! Each seed determines a scene: rooms convex and not, closed and open, upright and aslant; bodies
//! that stand, hang, float, lean, touch each other or nearly do; sheets; several lamps; any unit and
//! rigid motion. A seed gives the same room as quads, triangles or both. Fronts never overlap in one
//! plane, and bodies never intersect each other or a wall.

mod convex;
mod faces;
mod furnishing;
mod lamp;
mod loft;
mod placement;
mod pose;
mod room;

use common::scene::Scene;
use furnishing::RoomContents;
use glam::{DMat3, DQuat, DVec3, Vec3};
use loft::Panel;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use std::fmt;
use std::ops::Range;

pub use lamp::LampKind;
pub use loft::SheetSides;
pub use pose::Pose;

/// Random number generator, fixed by name so that seeds keep their scenes.
type RandomSource = Xoshiro256PlusPlus;

/// Shape of a scene's faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FaceShapes {
    /// Only quads.
    #[default]
    Quads,
    /// Only triangles: each quad is split along either diagonal, each triangle begins at any corner.
    Triangles,
    /// Quads and triangles.
    Mixed,
}

/// Family of scenes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SceneKind {
    /// Any room, pose, lamp, sheet, unit and motion.
    #[default]
    Any,
    /// Upright boxes, two of three closed, with turned boxes that stand and hang and one lamp below the
    /// ceiling.
    Room,
}

/// Options of a random scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SceneOptions {
    /// Family of the scene.
    pub kind: SceneKind,
    /// Shape of its faces.
    pub faces: FaceShapes,
}

/// A random scene and its features.
#[derive(Clone, Debug)]
pub struct RandomScene {
    /// Seed that determines the scene.
    pub seed: u64,
    /// Options that it was drawn with.
    pub options: SceneOptions,
    /// The scene, named `random-SEED`.
    pub scene: Scene,
    /// True if no light leaves the room. The black back of a lamp panel absorbs light all the same.
    pub closed: bool,
    /// Number of the floor's corners.
    pub walls: usize,
    /// True if the room is convex.
    pub convex: bool,
    /// Poses of the bodies.
    pub poses: Vec<Pose>,
    /// Gaps of the bodies that nearly touch something, over the room's height.
    pub gaps: Vec<f64>,
    /// Kinds of the sheets.
    pub sheets: Vec<SheetSides>,
    /// Kinds of the lamps.
    pub lamps: Vec<LampKind>,
    /// Scene units per unit of the room, which is 1 to 3 of these high.
    pub unit: f64,
}

/// Draws the scene of `seed`.
pub fn draw_scene(seed: u64, options: SceneOptions) -> RandomScene {
    let mut source = RandomSource::seed_from_u64(seed);
    let room = room::draw_room(&mut source, options.kind, !seed.is_multiple_of(3));
    let RoomContents {
        panels: things,
        poses,
        gaps,
        sheets,
        lamps,
    } = furnishing::furnish_room(&mut source, options.kind, &room);
    let mut panels = room.panels;
    for _ in lamps.iter().filter(|lamp| **lamp == LampKind::Wall) {
        lamp::make_wall_emit(&mut source, &mut panels);
    }
    panels.extend(things);
    let unit = match options.kind {
        SceneKind::Any => move_panels(&mut source, &mut panels, &room.bounds),
        SceneKind::Room => 1.0,
    };
    // A generator of its own, so that the faces' shape does not change the scene.
    let mut cuts = RandomSource::seed_from_u64(!seed);
    RandomScene {
        seed,
        options,
        scene: Scene {
            name: format!("random-{seed}"),
            faces: faces::faces_of_panels(&mut cuts, &panels, options.faces),
            notes: Vec::new(),
        },
        closed: room.closed,
        walls: room.walls,
        convex: room.convex,
        poses,
        gaps,
        sheets,
        lamps,
        unit,
    }
}

impl fmt::Display for RandomScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let open = if self.closed { "closed" } else { "open" };
        let shape = if self.convex { "convex" } else { "not convex" };
        write!(f, "{open}, {shape}, {} walls", self.walls)?;
        let mut list = |what: &str, each: Vec<String>| {
            if each.is_empty() {
                return Ok(());
            }
            write!(f, "; {what} {}", each.join(", "))
        };
        let names = |each: &dyn Fn(usize) -> String, n: usize| (0..n).map(each).collect();
        list("bodies", names(&|k| self.poses[k].to_string(), self.poses.len()))?;
        list("sheets", names(&|k| self.sheets[k].to_string(), self.sheets.len()))?;
        list("lamps", names(&|k| self.lamps[k].to_string(), self.lamps.len()))?;
        write!(f, "; {} faces, unit {:.1e}", self.scene.faces.len(), self.unit)
    }
}

/// Applies a random rigid motion and unit; the room lies up to ten of its extents from the origin.
/// Returns the unit.
fn move_panels(source: &mut RandomSource, panels: &mut [Panel], room: &Range<DVec3>) -> f64 {
    let turn = draw_rotation(source);
    let extent = (room.end - room.start).length();
    let reach = DVec3::splat(10.0 * extent);
    let to = DVec3::from_array(std::array::from_fn(|k| source.random_range(-reach[k]..reach[k])));
    let unit = draw_log_uniform(source, 1e-3, 1e3);
    for corner in panels.iter_mut().flat_map(|panel| &mut panel.corners) {
        *corner = (turn * *corner + to) * unit;
    }
    unit
}

/// Draws a uniformly distributed rotation (Shoemake 1992).
fn draw_rotation(source: &mut RandomSource) -> DMat3 {
    let [u, v, w] = std::array::from_fn(|_| source.random::<f64>());
    let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
    let [v, w] = [v, w].map(|x| x * std::f64::consts::TAU);
    let q = [a * v.sin(), a * v.cos(), b * w.sin(), b * w.cos()];
    DMat3::from_quat(DQuat::from_array(q).normalize())
}

/// Draws a number between `low` and `high`, uniform in its logarithm.
fn draw_log_uniform(source: &mut RandomSource, low: f64, high: f64) -> f64 {
    source.random_range(low.ln()..high.ln()).exp()
}

/// Draws a reflectance within 0.05…0.95: white, dark, grey or coloured.
fn draw_reflectance(source: &mut RandomSource) -> Vec3 {
    let (low, high) = match source.random_range(0..5) {
        0 => (0.7, 0.95),
        1 => (0.05, 0.3),
        _ => (0.05, 0.95),
    };
    let mut channel = || source.random_range(low..high);
    let first: f32 = channel();
    let coloured = Vec3::new(first, channel(), channel());
    if source.random_bool(0.4) {
        Vec3::splat(first)
    } else {
        coloured
    }
}
