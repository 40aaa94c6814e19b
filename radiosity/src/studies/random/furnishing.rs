//! Furnishes a random room: lamps, bodies in any pose, sheets.

use super::convex::ConvexBody;
use super::lamp::{self, LampKind};
use super::loft::{Panel, SheetSides, paint_panels};
use super::placement::{AllowedContacts, OccupiedRoom};
use super::pose::{Pose, place_body};
use super::room::RandomRoom;
use super::{RandomSource, SceneKind, draw_reflectance, draw_rotation};
use glam::{DMat3, DVec3};
use rand::RngExt;
use std::f64::consts::TAU;

/// Contents of a room.
#[derive(Default)]
pub struct RoomContents {
    pub panels: Vec<Panel>,
    pub poses: Vec<Pose>,
    pub gaps: Vec<f64>,
    pub sheets: Vec<SheetSides>,
    pub lamps: Vec<LampKind>,
}

/// Most quads of a scene, so that the dense solver takes seconds.
const MAX_QUADS: usize = 30;
/// Placement attempts per body or sheet.
const MAX_TRIES: usize = 200;

/// Furnishes a room: lamps first, since they need free space, then bodies and sheets.
pub fn furnish_room(source: &mut RandomSource, kind: SceneKind, room: &RandomRoom) -> RoomContents {
    let mut space = OccupiedRoom::new(room);
    let mut all = RoomContents::default();
    place_lamps(source, kind, &mut space, &mut all);
    let lamps = space.bodies.len();
    let bodies = match kind {
        SceneKind::Any => source.random_range(1..=3),
        SceneKind::Room => source.random_range(2..=3),
    };
    for k in 0..bodies {
        let pose = match kind {
            SceneKind::Any => Pose::ALL[source.random_range(0..Pose::ALL.len())],
            SceneKind::Room => [Pose::Standing, Pose::Hanging][k % 2],
        };
        if room.panels.len() + all.panels.len() + 6 <= MAX_QUADS
            && let Some((loft, gap)) = place_body(source, kind, &mut space, pose, lamps)
        {
            let mut panels = loft.outward_panels(&format!("body {}", k + 1));
            paint_panels(source, &mut panels);
            all.panels.extend(panels);
            all.poses.push(pose);
            all.gaps.extend((gap > 0.0).then_some(gap / room.height));
        }
    }
    let sheets = match kind {
        SceneKind::Any => source.random_range(0..=1),
        SceneKind::Room => 0,
    };
    for _ in 0..sheets {
        if let Some((sheet, panel)) = place_sheet(source, &mut space) {
            all.panels.push(panel);
            all.sheets.push(sheet);
        }
    }
    all
}

/// Places one to three lamps; if none fits, a part of the room becomes the lamp.
fn place_lamps(source: &mut RandomSource, kind: SceneKind, space: &mut OccupiedRoom, all: &mut RoomContents) {
    let count = match kind {
        SceneKind::Any => [1, 1, 2, 3][source.random_range(0..4)],
        SceneKind::Room => 1,
    };
    for _ in 0..count {
        if let Some((lamp, panels)) = lamp::place_lamp(source, space, kind) {
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
        all.lamps.push(LampKind::Wall);
    }
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
