//! Scenes drawn at random, for claims that must hold on scenes that nobody tuned to.
//!
//! A seed is a scene: rooms convex and not, closed and open, upright and aslant; bodies that stand,
//! hang, float, lean, touch each other or nearly do; sheets; several lamps; any unit and rigid motion.
//! The same seed gives the same room as quads, as triangles and mixed. Fronts never overlap in one
//! plane and bodies never enter each other or a wall.

mod body;
mod convex;
mod faces;
mod lamp;
mod loft;
mod place;
mod pose;
mod room;

use body::Furnished;
use common::scene::Scene;
use glam::{DMat3, DQuat, DVec3, Vec3};
use loft::Panel;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use std::fmt;
use std::ops::Range;

pub use lamp::Lamp;
pub use loft::Sheet;
pub use pose::Pose;

/// The numbers drawn: a named generator, so that a seed stays the same scene.
type Source = Xoshiro256PlusPlus;

/// What the faces are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Faces {
    /// Quads.
    #[default]
    Quads,
    /// Each quad as two triangles: either diagonal, and each triangle begins at any of its corners.
    Triangles,
    /// Some of each.
    Mixed,
}

/// What is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Everything.
    #[default]
    Any,
    /// Upright boxes, two of three closed, with turned boxes that stand and hang in them and one lamp
    /// below the ceiling.
    Room,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Options {
    /// What is drawn.
    pub kind: Kind,
    /// What the faces are.
    pub faces: Faces,
}

/// A scene that was drawn, and what it has.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// It is drawn anew from this number.
    pub seed: u64,
    /// What was asked for.
    pub options: Options,
    /// The scene; its name is `random-SEED`.
    pub scene: Scene,
    /// Whether no light gets out of the room; the black back of a lamp that is a panel takes what falls
    /// on it all the same.
    pub closed: bool,
    /// The room's outline: corners of the floor.
    pub walls: usize,
    /// Whether the room is convex.
    pub convex: bool,
    /// Each body's.
    pub poses: Vec<Pose>,
    /// The gaps of bodies that nearly touch something, over the room's height.
    pub gaps: Vec<f64>,
    /// Each sheet's.
    pub sheets: Vec<Sheet>,
    /// Each lamp's.
    pub lamps: Vec<Lamp>,
    /// Scene units in one of the room's own: its height is 1 to 3 of these.
    pub unit: f64,
}

/// Draws the scene of a seed.
pub fn scene(seed: u64, options: Options) -> Drawn {
    let mut source = Source::seed_from_u64(seed);
    let room = room::draw(&mut source, options.kind, !seed.is_multiple_of(3));
    let Furnished {
        panels: things,
        poses,
        gaps,
        sheets,
        lamps,
    } = body::furnish(&mut source, options.kind, &room);
    let mut panels = room.panels;
    for _ in lamps.iter().filter(|lamp| **lamp == Lamp::Wall) {
        lamp::paint(&mut source, &mut panels);
    }
    panels.extend(things);
    let unit = match options.kind {
        Kind::Any => move_all(&mut source, &mut panels, &room.bounds),
        Kind::Room => 1.0,
    };
    // Its own numbers: what the faces are does not change what is drawn.
    let mut cuts = Source::seed_from_u64(!seed);
    Drawn {
        seed,
        options,
        scene: Scene {
            name: format!("random-{seed}"),
            faces: faces::of(&mut cuts, &panels, options.faces),
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

impl fmt::Display for Drawn {
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
        list(
            "bodies",
            names(&|k| self.poses[k].to_string(), self.poses.len()),
        )?;
        list(
            "sheets",
            names(&|k| self.sheets[k].to_string(), self.sheets.len()),
        )?;
        list(
            "lamps",
            names(&|k| self.lamps[k].to_string(), self.lamps.len()),
        )?;
        write!(
            f,
            "; {} faces, unit {:.1e}",
            self.scene.faces.len(),
            self.unit
        )
    }
}

/// Any rigid motion and any unit: the room lies up to ten of its extents from the origin.
fn move_all(source: &mut Source, panels: &mut [Panel], room: &Range<DVec3>) -> f64 {
    let turn = turned(source);
    let extent = (room.end - room.start).length();
    let reach = DVec3::splat(10.0 * extent);
    let to = DVec3::from_array(std::array::from_fn(|k| {
        source.random_range(-reach[k]..reach[k])
    }));
    let unit = log_between(source, 1e-3, 1e3);
    for corner in panels.iter_mut().flat_map(|panel| &mut panel.corners) {
        *corner = (turn * *corner + to) * unit;
    }
    unit
}

/// A rotation, all of them as likely (Shoemake 1992).
fn turned(source: &mut Source) -> DMat3 {
    let [u, v, w] = std::array::from_fn(|_| source.random::<f64>());
    let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
    let [v, w] = [v, w].map(|x| x * std::f64::consts::TAU);
    let q = [a * v.sin(), a * v.cos(), b * w.sin(), b * w.cos()];
    DMat3::from_quat(DQuat::from_array(q).normalize())
}

/// Any order of magnitude from `low` to `high`.
fn log_between(source: &mut Source, low: f64, high: f64) -> f64 {
    source.random_range(low.ln()..high.ln()).exp()
}

/// Three channels within 0.05…0.95: white, dark, grey or of any colour.
fn reflectance(source: &mut Source) -> Vec3 {
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
