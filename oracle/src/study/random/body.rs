//! What is put into the room: bodies in every position, and sheets.

use super::convex::Convex;
use super::lamp::{self, Lamp};
use super::loft::{Panel, Sheet, dress};
use super::place::{Rests, Space};
use super::pose::{Pose, put};
use super::room::Room;
use super::{Kind, Source, reflectance, turned};
use glam::{DMat3, DVec3};
use rand::RngExt;
use std::f64::consts::TAU;

/// What is in a room.
#[derive(Default)]
pub struct Furnished {
    pub panels: Vec<Panel>,
    pub poses: Vec<Pose>,
    pub gaps: Vec<f64>,
    pub sheets: Vec<Sheet>,
    pub lamps: Vec<Lamp>,
}

/// A scene has at most so many quads: its matrix must be solved in seconds.
const QUADS: usize = 30;
/// Places that are tried.
const TRIES: usize = 200;

/// Lamps first, for they need to be free; then bodies and sheets.
pub fn furnish(source: &mut Source, kind: Kind, room: &Room) -> Furnished {
    let mut space = Space::new(room);
    let mut all = Furnished::default();
    light(source, kind, &mut space, &mut all);
    let lamps = space.taken.len();
    let bodies = match kind {
        Kind::Any => source.random_range(1..=3),
        Kind::Room => source.random_range(2..=3),
    };
    for k in 0..bodies {
        let pose = match kind {
            Kind::Any => Pose::ALL[source.random_range(0..Pose::ALL.len())],
            Kind::Room => [Pose::Standing, Pose::Hanging][k % 2],
        };
        if room.panels.len() + all.panels.len() + 6 <= QUADS
            && let Some((loft, gap)) = put(source, kind, &mut space, pose, lamps)
        {
            let mut panels = loft.outward(&format!("body {}", k + 1));
            dress(source, &mut panels);
            all.panels.extend(panels);
            all.poses.push(pose);
            all.gaps.extend((gap > 0.0).then_some(gap / room.height));
        }
    }
    let sheets = match kind {
        Kind::Any => source.random_range(0..=1),
        Kind::Room => 0,
    };
    for _ in 0..sheets {
        if let Some((sheet, panel)) = hold(source, &mut space) {
            all.panels.push(panel);
            all.sheets.push(sheet);
        }
    }
    all
}

/// One to three lamps; a wall shines where there is no place for one.
fn light(source: &mut Source, kind: Kind, space: &mut Space, all: &mut Furnished) {
    let count = match kind {
        Kind::Any => [1, 1, 2, 3][source.random_range(0..4)],
        Kind::Room => 1,
    };
    for _ in 0..count {
        if let Some((lamp, panels)) = lamp::hang(source, space, kind) {
            all.lamps.push(lamp);
            let name = format!("lamp {}", all.lamps.len());
            let named = |panel| Panel {
                name: name.clone(),
                ..panel
            };
            all.panels.extend(panels.into_iter().map(named));
        }
    }
    if all.lamps.is_empty() {
        all.lamps.push(Lamp::Wall);
    }
}

/// A sheet that floats, or stands on an edge.
fn hold(source: &mut Source, space: &mut Space) -> Option<(Sheet, Panel)> {
    let extent = space.room.bounds.end - space.room.bounds.start;
    let size = extent.min_element();
    let sheet = [Sheet::Partners, Sheet::Coinciding][source.random_range(0..2)];
    let stands = source.random_bool(0.5);
    let rests = Rests {
        floor: stands,
        ..Rests::default()
    };
    for _ in 0..TRIES {
        let [x, y] = std::array::from_fn(|_| source.random_range(0.2..0.7) * size);
        let turn = if stands {
            let lean = DMat3::from_rotation_x(source.random_range(-0.5..0.5));
            DMat3::from_rotation_y(source.random_range(0.0..TAU)) * lean
        } else {
            turned(source)
        };
        let up = if stands {
            0.0
        } else {
            source.random_range(0.0..space.room.height)
        };
        let at = space.somewhere(source) + DVec3::Y * up;
        let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
        let corners = corners.map(|[x, y]| at + turn * DVec3::new(x, y, 0.0));
        let shape = Convex::flat(&corners);
        if space.fits(&shape, rests) {
            space.taken.push(shape);
            let panel = Panel {
                reflectance: reflectance(source),
                two_sided: Some(sheet),
                ..Panel::new("sheet", corners)
            };
            return Some((sheet, panel));
        }
    }
    None
}
