//! Random scenes, on which no solver was tuned.
//!
//! Each seed determines a scene: rooms convex and not, closed and open, upright and aslant; bodies
//! that stand, hang, float, lean, touch each other or nearly do; sheets; several lamps; any unit and
//! rigid motion. A seed gives the same room as quads, triangles or both. Fronts never overlap in one
//! plane, and bodies never intersect each other or a wall.

mod convex;
mod lamp;
mod loft;
pub mod meshes;
mod placement;
mod pose;
mod room;

use common::scene::Scene;
use convex::ConvexBody;
use glam::{DMat3, DQuat, DVec3, Vec3};
use lamp::{make_wall_emit, place_lamp};
use loft::{Panel, faces_of_panels, paint_panels};
use placement::{AllowedContacts, OccupiedRoom};
use pose::place_body;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use room::RandomRoom;
use std::f64::consts::TAU;
use std::fmt;
use std::ops::Range;

pub use lamp::LampKind;
pub use loft::SheetSides;
pub use pose::Pose;

/// Random number generator, fixed by name so that seeds keep their scenes.
type RandomSource = Xoshiro256PlusPlus;

/// Most quads of a scene, so that the dense solver takes seconds.
const MAX_QUADS: usize = 30;
/// Placement attempts per sheet.
const MAX_TRIES: usize = 200;

/// Shape of a scene's faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FaceShapes {
    /// Quads
    #[default]
    Quads,
    /// Each quad as two triangles, each beginning at a random corner
    Triangles,
    /// Quads and triangles
    Mixed,
}

/// A random scene and its features.
#[derive(Clone, Debug)]
pub struct RandomScene {
    /// Seed that determines the scene.
    pub seed: u64,
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

/// Draws the scene of `seed`; two of three are closed.
pub fn draw_scene(seed: u64, faces: FaceShapes) -> RandomScene {
    let mut source = RandomSource::seed_from_u64(seed);
    let room = room::draw_room(&mut source, !seed.is_multiple_of(3));
    let mut drawn = RandomScene {
        seed,
        scene: Scene {
            name: format!("random-{seed}"),
            ..Scene::default()
        },
        closed: room.closed,
        walls: room.walls,
        convex: room.parts.len() == 1,
        poses: Vec::new(),
        gaps: Vec::new(),
        sheets: Vec::new(),
        lamps: Vec::new(),
        unit: 1.0,
    };
    let things = furnish_room(&mut source, &room, &mut drawn);
    let mut panels = room.panels;
    for _ in drawn.lamps.iter().filter(|lamp| **lamp == LampKind::Wall) {
        make_wall_emit(&mut source, &mut panels);
    }
    panels.extend(things);
    drawn.unit = move_panels(&mut source, &mut panels, &room.bounds);
    // A generator of its own, so that the faces' shape does not change the scene.
    let mut cuts = RandomSource::seed_from_u64(!seed);
    drawn.scene.faces = faces_of_panels(&mut cuts, &panels, faces);
    drawn
}

impl fmt::Display for RandomScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let open = if self.closed { "closed" } else { "open" };
        let shape = if self.convex { "convex" } else { "not convex" };
        write!(f, "{open}, {shape}, {} walls", self.walls)?;
        for (what, kinds) in [
            ("bodies", format!("{:?}", self.poses)),
            ("sheets", format!("{:?}", self.sheets)),
            ("lamps", format!("{:?}", self.lamps)),
        ] {
            let kinds = kinds.trim_matches(['[', ']']).to_lowercase();
            if !kinds.is_empty() {
                write!(f, "; {what} {kinds}")?;
            }
        }
        write!(f, "; {} faces, unit {:.1e}", self.scene.faces.len(), self.unit)
    }
}

/// Furnishes a room: lamps first, since they need free space, then bodies and sheets. Returns the panels and
/// describes them in `drawn`.
fn furnish_room(source: &mut RandomSource, room: &RandomRoom, drawn: &mut RandomScene) -> Vec<Panel> {
    let mut space = OccupiedRoom {
        room,
        bodies: Vec::new(),
        free_zones: Vec::new(),
    };
    let mut panels = Vec::new();
    let lamps = [1, 1, 2, 3][source.random_range(0..4)];
    for _ in 0..lamps {
        if let Some((lamp, mut parts)) = place_lamp(source, &mut space) {
            drawn.lamps.push(lamp);
            for part in &mut parts {
                part.name = format!("lamp {}", drawn.lamps.len());
            }
            panels.extend(parts);
        }
    }
    if drawn.lamps.is_empty() {
        drawn.lamps.push(LampKind::Wall);
    }
    let first_body = space.bodies.len();
    let bodies = source.random_range(1..=3);
    for k in 0..bodies {
        let pose = Pose::ALL[source.random_range(0..Pose::ALL.len())];
        if room.panels.len() + panels.len() + 6 <= MAX_QUADS
            && let Some((loft, gap)) = place_body(source, &mut space, pose, first_body)
        {
            let mut sides = loft.outward_panels(&format!("body {}", k + 1));
            paint_panels(source, &mut sides);
            panels.extend(sides);
            drawn.poses.push(pose);
            drawn.gaps.extend((gap > 0.0).then_some(gap / room.height));
        }
    }
    if source.random_range(0..=1) == 1
        && let Some((sheet, panel)) = place_sheet(source, &mut space)
    {
        panels.push(panel);
        drawn.sheets.push(sheet);
    }
    panels
}

/// Places a sheet that floats or stands on an edge; none if no attempt fits.
fn place_sheet(source: &mut RandomSource, space: &mut OccupiedRoom) -> Option<(SheetSides, Panel)> {
    let extent = space.room.bounds.end - space.room.bounds.start;
    let size = extent.min_element();
    let sheet = [SheetSides::Partners, SheetSides::Coinciding][source.random_range(0..2)];
    let stands = source.random_bool(0.5);
    let rests = AllowedContacts {
        floor: stands,
        ..AllowedContacts::default()
    };
    for _ in 0..MAX_TRIES {
        let [x, y] = std::array::from_fn(|_| source.random_range(0.2..0.7) * size);
        let turn = if stands {
            let lean = DMat3::from_rotation_x(source.random_range(-0.5..0.5));
            DMat3::from_rotation_y(source.random_range(0.0..TAU)) * lean
        } else {
            draw_rotation(source)
        };
        let up = if stands {
            0.0
        } else {
            source.random_range(0.0..space.room.height)
        };
        let at = space.draw_floor_point(source) + DVec3::Y * up;
        let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
        let corners = corners.map(|[x, y]| at + turn * DVec3::new(x, y, 0.0));
        let shape = ConvexBody::from_outline(&corners);
        if space.fits_body(&shape, rests) {
            space.bodies.push(shape);
            let panel = Panel {
                reflectance: draw_reflectance(source),
                two_sided: Some(sheet),
                ..Panel::new("sheet", corners)
            };
            return Some((sheet, panel));
        }
    }
    None
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
