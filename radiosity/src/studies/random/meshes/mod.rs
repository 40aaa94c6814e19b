//! Random meshes: scenes of many small triangles, on which no solver was tuned.
//!
//! Each seed determines a scene of one of [`MeshKind`]: 10³ to 10⁵ triangles, some of them slivers; 1 to 200 lamps from
//! a thousandth to a tenth of the room; open or closed, with reflectances up to 0.98; any unit and rigid motion.

mod furniture;
mod surfaces;

use super::lamp::make_wall_emit;
use super::loft::{Footprint, Loft, Panel, faces_of_panels};
use super::placement::OccupiedRoom;
use super::room::{RandomRoom, bounding_box, draw_room, enclose_room};
use super::{FaceShapes, RandomSource, draw_log_uniform, draw_reflectance, move_panels};
use common::scene::Scene;
use furniture::{place_bodies, place_columns, place_lamps, place_partitions, place_stairs_and_louvres};
use glam::{DMat3, DVec2, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use std::f64::consts::PI;
use std::fmt;
use surfaces::{cut_panel, cut_surface, draw_roughness, place_panels, reverse_panels, revolve_profile};

/// Kind of a mesh; seeds take them in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshKind {
    /// A room with balls, vases and rings, smooth or rough.
    Bodies,
    /// A closed room with a round wall, or a hollow ball.
    CurvedWalls,
    /// A closed corridor of bright parts.
    Corridor,
    /// A hall of columns and many lamps.
    Columns,
    /// A room with stairs and a row of tilted sheets.
    Louvres,
    /// A room and bodies cut into long strips.
    Slivers,
    /// Open ground with bodies.
    Terrain,
}

impl MeshKind {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Bodies,
        Self::CurvedWalls,
        Self::Corridor,
        Self::Columns,
        Self::Louvres,
        Self::Slivers,
        Self::Terrain,
    ];
}

/// Cells of a sliver room are this many times as long as wide.
const SLIVER_STRETCH: f64 = 40.0;
/// Share of the triangles that bodies take.
const BODY_SHARE: f64 = 0.6;

/// A random mesh and its features.
#[derive(Clone, Debug)]
pub struct RandomMesh {
    /// Kind of the scene.
    pub kind: MeshKind,
    /// The scene, named `mesh-SEED`.
    pub scene: Scene,
    /// True if no light leaves the room.
    pub closed: bool,
    /// Number of lamps.
    pub lamps: usize,
    /// Width of the lamps over the least extent of the room; none of a lamp that is a part of the room.
    pub lamp_width: Option<f64>,
}

/// Draws the mesh of `seed`.
pub fn draw_mesh(seed: u64) -> RandomMesh {
    let mut source = RandomSource::seed_from_u64(seed);
    let kind = MeshKind::ALL[(seed % MeshKind::ALL.len() as u64) as usize];
    let triangles = match source.random_range(0..20) {
        0..16 => draw_log_uniform(&mut source, 6e2, 6e3),
        16..19 => draw_log_uniform(&mut source, 6e3, 2e4),
        _ => draw_log_uniform(&mut source, 2e4, 1e5),
    };
    let room = draw_shell(&mut source, kind, triangles);
    let mut space = OccupiedRoom {
        room: &room,
        bodies: Vec::new(),
        free_zones: Vec::new(),
    };
    let mut panels = room.panels.clone();
    panels.extend(match kind {
        MeshKind::Columns => place_columns(&mut source, &mut space),
        MeshKind::Corridor => place_partitions(&mut source, &mut space),
        MeshKind::Louvres => place_stairs_and_louvres(&mut source, &mut space),
        _ => Vec::new(),
    });
    if kind == MeshKind::Corridor || source.random_bool(0.2) {
        let bright = source.random_range(0.8..0.97);
        for panel in &mut panels {
            panel.reflectance = Vec3::from_array(std::array::from_fn(|_| source.random_range(bright..0.98)));
        }
    }
    let stretch = if kind == MeshKind::Slivers { SLIVER_STRETCH } else { 1.0 };
    let (bodies, share) = match kind {
        MeshKind::Bodies | MeshKind::Slivers => (source.random_range(1..=4), BODY_SHARE),
        _ => (source.random_range(0..=2), 0.3),
    };
    let bodies = place_bodies(&mut source, &mut space, (bodies, share * triangles), stretch);
    let extent = (room.bounds.end - room.bounds.start).min_element();
    let width = draw_log_uniform(&mut source, 1e-3, 1e-1);
    let count = draw_log_uniform(&mut source, if kind == MeshKind::Columns { 20.0 } else { 1.0 }, 200.0);
    let lamps = place_lamps(&mut source, &mut space, count.round() as usize, width * extent);
    if lamps.is_empty() {
        make_wall_emit(&mut source, &mut panels);
    }
    // Curved ground and walls are cut already.
    if room.walls > 1 {
        let rest = (triangles - 2.0 * bodies.len() as f64).max(0.2 * triangles);
        panels = cut_panels(&panels, rest, stretch);
    }
    panels.extend(bodies);
    let lamp_count = lamps.len().max(1);
    let lamp_width = (!lamps.is_empty()).then_some(width);
    panels.extend(lamps);
    move_panels(&mut source, &mut panels, &room.bounds);
    RandomMesh {
        kind,
        scene: Scene {
            name: format!("mesh-{seed}"),
            faces: faces_of_panels(&mut source, &panels, FaceShapes::Triangles),
            ..Scene::default()
        },
        closed: room.closed,
        lamps: lamp_count,
        lamp_width,
    }
}

impl fmt::Display for RandomMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let open = if self.closed { "closed" } else { "open" };
        let kind = format!("{:?}", self.kind).to_lowercase();
        let (faces, lamps) = (self.scene.faces.len(), self.lamps);
        write!(f, "{kind}, {open}; {faces} faces, {lamps} lamps")?;
        match self.lamp_width {
            Some(width) => write!(f, " of {width:.1e}")?,
            None => write!(f, " of a wall")?,
        }
        let reflectances = self.scene.faces.iter().map(|face| face.reflectance.max_element());
        write!(f, ", reflectance up to {:.2}", reflectances.fold(0.0, f32::max))
    }
}

/// Draws the room or ground of a mesh.
fn draw_shell(source: &mut RandomSource, kind: MeshKind, triangles: f64) -> RandomRoom {
    let height = source.random_range(1.0..3.0);
    let make = |outline, scale| Loft::new(outline, height, scale, DVec2::ZERO);
    match kind {
        MeshKind::CurvedWalls if source.random_bool(0.4) => hollow_ball(source, triangles),
        MeshKind::CurvedWalls => {
            let corners = 2 * source.random_range(10..=40);
            let radius = DVec2::from_array(std::array::from_fn(|_| source.random_range(0.8..2.0)));
            let scale = source.random_range(0.6..1.3);
            enclose_room(source, &make(Footprint::regular(corners, radius), scale), true)
        }
        MeshKind::Corridor => {
            let [x, z] = [source.random_range(0.8..2.0), source.random_range(5.0..15.0)];
            enclose_room(source, &make(Footprint::rectangle(x, z), 1.0), true)
        }
        MeshKind::Columns => {
            let [x, z] = std::array::from_fn(|_| source.random_range(2.0..8.0));
            let closed = source.random_bool(0.7);
            enclose_room(source, &make(Footprint::rectangle(x, z), 1.0), closed)
        }
        MeshKind::Terrain => draw_terrain(source, triangles),
        _ => {
            let closed = source.random_bool(0.7);
            draw_room(source, closed)
        }
    }
}

/// Makes a hollow ball or spheroid; things are placed in the box within it.
fn hollow_ball(source: &mut RandomSource, triangles: f64) -> RandomRoom {
    let rows = (0.25 * triangles).sqrt().max(6.0);
    let radius = DVec3::new(1.0, source.random_range(0.6..1.4), source.random_range(0.8..1.6));
    let ball = |v: f64| DVec2::new((PI * v).sin(), -(PI * v).cos());
    let mut panels = revolve_profile("wall", [2.0 * rows, rows].map(|n| n as usize), ball);
    reverse_panels(&mut panels);
    // The box within a ball of radius 1 has sides of 2/√3; its floor is at y = 0.
    let half = radius / 3.0f64.sqrt();
    place_panels(&mut panels, DMat3::from_diagonal(radius), 1.0, DVec3::Y * half.y);
    let reflectance = draw_reflectance(source);
    for panel in &mut panels {
        panel.reflectance = reflectance;
    }
    shell_around(panels, half, true)
}

/// Makes rough ground; things are placed above it.
fn draw_terrain(source: &mut RandomSource, triangles: f64) -> RandomRoom {
    let cells = (0.5 * triangles).sqrt().ceil().max(8.0) as usize;
    let height = draw_roughness(source, 0.3);
    let mut panels = cut_surface("ground", [cells; 2], |u, v| {
        let flat = DVec3::new(4.0 * u - 2.0, 0.0, 2.0 - 4.0 * v);
        flat + DVec3::Y * height(flat)
    });
    let top = bounding_box(panels.iter().flat_map(|panel| panel.corners)).end.y;
    place_panels(&mut panels, DMat3::IDENTITY, 1.0, DVec3::Y * -top);
    let patchy = source.random_bool(0.5);
    let even = draw_reflectance(source);
    for panel in &mut panels {
        panel.reflectance = if patchy { draw_reflectance(source) } else { even };
    }
    shell_around(panels, DVec3::new(2.0, 0.7, 2.0), false)
}

/// Makes a room of these panels with a box, on y = 0 and `half` its sides, in which things are placed.
fn shell_around(panels: Vec<Panel>, half: DVec3, closed: bool) -> RandomRoom {
    let inside = Loft::new(
        Footprint::rectangle(2.0 * half.x, 2.0 * half.z),
        2.0 * half.y,
        1.0,
        DVec2::ZERO,
    );
    RandomRoom {
        panels,
        parts: inside.convex_parts(),
        height: 2.0 * half.y,
        closed,
        walls: 1,
        bounds: bounding_box(inside.corner_points()),
    }
}

/// Cuts panels into cells that make about so many triangles; those that are small enough stay.
fn cut_panels(panels: &[Panel], triangles: f64, stretch: f64) -> Vec<Panel> {
    let area = |panel: &Panel| {
        let [a, b, c, d] = panel.corners;
        let sides = if panel.two_sided.is_some() { 2.0 } else { 1.0 };
        0.5 * sides * (c - a).cross(d - b).length()
    };
    let size = (2.0 * panels.iter().map(area).sum::<f64>() / triangles).sqrt();
    let cut = |panel: &Panel| cut_panel(panel, size, stretch);
    panels.iter().flat_map(cut).collect()
}
