//! Relighting: objects are put into a room whose radiosity B₀ was captured.
//!
//! ```text
//! δ = B − B₀ on the room, B on objects      δ = Kδ + s
//! s = (K − K₀)B₀ on the room,  K B₀ + E on objects
//! ```
//! K₀ and K are transport without and with the objects. [`relight`] runs the one loop twice on the
//! same engine: first every cell of the room shoots what was captured, and texels note what they
//! lose or gain by it and what they had; from that [`surface`] finds what the walls reflect and
//! emit; then δ is shot on, of both signs, until it is spent (George, Sillion & Greenberg 1990).
//! Table 2 of the paper is the same with some of it left out: [`Mended`].

pub mod surface;

use crate::error::Result;
use crate::mesh::Mesh;
use crate::settings::Schedule;
use crate::shooting::{Field, Order, Restart, Rule, Run, Shot, Subtracted, one_by_one, total};
use glam::{Vec3, Vec4};
use serde::Serialize;
use std::ops::ControlFlow;
use surface::Surface;

/// A captured room, in the order of the mesh's texels; what objects have here is not read.
#[derive(Clone, Debug)]
pub struct Room {
    /// B₀, W/m².
    pub radiosity: Vec<Vec4>,
    /// The part of it that the capture had not shot yet; 0 where that is not known.
    pub residual: Vec<Vec4>,
    /// ρ, where it is known.
    pub reflectance: Option<Vec<Vec3>>,
}

/// How the room takes what objects do to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Both signs, two visibilities, shot on: the limit is the full solution.
    Signed,
    /// Table 2 with its slips in loop and formula mended, and these of its flaws.
    Paper(Mended),
}

/// Which flaws of Table 2 are mended; all of them make it [`Method::Signed`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Mended {
    /// A texel that was hidden in the empty room already loses nothing.
    pub empty_room: bool,
    /// Objects take no light away from the room that they never gave.
    pub object_shadows: bool,
    /// Objects give light to the room (and then take none away).
    pub bleeding: bool,
    /// What the room gains and loses is shot on.
    pub shadows: bool,
}

impl Method {
    /// How captured shots are taken, and how those after them.
    fn rules(self) -> [Rule; 2] {
        let mended = match self {
            Self::Signed => Mended {
                empty_room: true,
                object_shadows: true,
                bleeding: true,
                shadows: true,
            },
            Self::Paper(mended) => mended,
        };
        let captured = if mended.empty_room {
            Subtracted::Before
        } else {
            Subtracted::Unhidden
        };
        let later = if mended.bleeding {
            Subtracted::Nothing
        } else if mended.object_shadows {
            Subtracted::All
        } else {
            Subtracted::Unhidden
        };
        let rule = |captured, subtracted| Rule {
            captured,
            subtracted,
            keep: mended.shadows,
        };
        // Table 2 as printed is all false: lines 6 to 9 take a hidden texel's light, whoever shoots.
        [rule(true, captured), rule(false, later)]
    }
}

/// The room with the objects in it.
#[derive(Clone, Debug)]
pub struct Relit {
    /// ρ and E of every texel.
    pub surface: Surface,
    /// δ, its unshot part, and the change of H.
    pub change: Field,
    /// All shots and B, r, H; `emitted` is the power that ε is a share of: what the captured shots
    /// deposited, or more where the capture left more unshot.
    pub run: Run,
    /// Whether all that was captured was shot: else H₀, ρ and E are those of a part of the light.
    pub complete: bool,
    /// Shots of the room's cells.
    pub map_shots: usize,
    /// Shots of the objects' cells.
    pub object_shots: usize,
}

/// Relights by `method`; `watch` sees every shot and the power that its loop began with.
///
/// Errors: the engine's; a usage error of an iteration over many cells at once.
pub fn relight(
    engine: &mut dyn Restart,
    mesh: &Mesh,
    room: &Room,
    method: Method,
    schedule: &Schedule,
    watch: &mut dyn FnMut(&Shot, f32) -> ControlFlow<()>,
) -> Result<Relit> {
    one_by_one(schedule)?;
    let [captured, later] = method.rules();
    let nothing = vec![Vec4::ZERO; mesh.texels.len()];
    let start = Field {
        origin: String::new(),
        radiosity: nothing.clone(),
        residual: to_shoot(mesh, room),
        irradiance: nothing,
    };
    engine.restart(captured, &reflectances(mesh), &start)?;
    let mut shots = Vec::new();
    let mut stopped = false;
    let mut phase = |engine: &mut dyn Restart, threshold, shots: &mut Vec<Shot>| -> Result<()> {
        let power = total(&engine.cell_power()?);
        let left = schedule.max_shots - (shots.len() as u32).min(schedule.max_shots);
        if stopped || power <= threshold {
            return Ok(());
        }
        engine.run(Order::Greedy { threshold }, left, &mut |shot| {
            shots.push(*shot);
            let flow = watch(shot, power);
            stopped |= flow.is_break();
            flow
        })
    };
    // Table 2, line 1, for every face of the map.
    phase(engine, 0.0, &mut shots)?;
    let noted = engine.field()?;
    let surface = Surface::of(mesh, room, &noted.radiosity);
    let (change, deposited) = first_change(mesh, room, &surface, &noted, later.keep);
    engine.restart(later, &surface.reflectance, &change)?;
    // What the capture left unshot is owed no better than the captured power.
    let captured = power_of(mesh, &start.residual);
    let left = power_of(mesh, &room.residual).min(schedule.epsilon * captured);
    let basis = if deposited > 0.0 {
        deposited.max(left / schedule.epsilon)
    } else {
        0.0
    };
    let threshold = (schedule.epsilon * basis) as f32;
    // Lines 16 and 17: objects shoot on what they received; mended, so does the room.
    if deposited > 0.0 {
        phase(engine, threshold, &mut shots)?;
    }
    let unshot = total(&engine.cell_power()?);
    let change = engine.field()?;
    let field = whole(room, &change, &noted.radiosity, mesh);
    let (map_shots, object_shots) = count(mesh, &shots);
    Ok(Relit {
        surface,
        change,
        run: Run {
            converged: unshot <= threshold || deposited == 0.0,
            stagnated: false,
            passes: shots.len() as u32,
            shooters: shots.len() as u64,
            shots,
            emitted: basis as f32,
            field,
        },
        complete: noted.residual.iter().all(|r| r.truncate() == Vec3::ZERO),
        map_shots,
        object_shots,
    })
}

/// What the captured shots carry: B₀ but for what had not been shot, and what a body of the room
/// buries.
fn to_shoot(mesh: &Mesh, room: &Room) -> Vec<Vec4> {
    let mut values = vec![Vec4::ZERO; mesh.texels.len()];
    for cell in mesh.cells.iter().filter(|c| !mesh.is_object(c.face)) {
        for k in cell.texels() {
            let buried = mesh.texels[k].emission * (1.0 - cell.open_before);
            values[k] = room.radiosity[k] - room.residual[k] - buried.extend(0.0);
        }
    }
    values
}

/// δ and r after the captured shots, and the power Σ|r|A that they deposited. `noted` has the change
/// of H, and H as it was.
fn first_change(
    mesh: &Mesh,
    room: &Room,
    surface: &Surface,
    noted: &Field,
    keep: bool,
) -> (Field, f64) {
    let mut change = Field {
        radiosity: vec![Vec4::ZERO; mesh.texels.len()],
        ..noted.clone()
    };
    let mut residual = vec![Vec4::ZERO; mesh.texels.len()];
    for cell in &mesh.cells {
        let object = mesh.is_object(cell.face);
        for k in cell.texels() {
            let gained = surface.reflectance[k] * noted.irradiance[k].truncate();
            let emission = mesh.texels[k].emission;
            let (radiosity, unshot) = if object {
                (emission + gained, emission * cell.open + gained)
            } else {
                let buried = surface.emission[k] * (cell.open_before - cell.open);
                (gained, if keep { gained - buried } else { Vec3::ZERO })
            };
            change.radiosity[k] = radiosity.extend(0.0);
            residual[k] = unshot.extend(0.0);
        }
    }
    let deposited = power_of(mesh, &residual);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let owed = if mesh.is_object(texel.face) {
            Vec4::ZERO
        } else {
            room.residual[k]
        };
        // Captured power is left only where the run was stopped.
        change.residual[k] = residual[k] + owed + noted.residual[k];
    }
    (change, deposited)
}

/// Σ|r|A over texels and channels, in the mesh's unit.
fn power_of(mesh: &Mesh, residual: &[Vec4]) -> f64 {
    mesh.texels
        .iter()
        .zip(residual)
        .map(|(texel, r)| f64::from(r.truncate().abs().element_sum()) * f64::from(texel.area))
        .sum()
}

fn reflectances(mesh: &Mesh) -> Vec<Vec3> {
    mesh.texels.iter().map(|t| t.reflectance).collect()
}

/// B, r and H of everything.
fn whole(room: &Room, change: &Field, before: &[Vec4], mesh: &Mesh) -> Field {
    let mut field = change.clone();
    for (k, texel) in mesh.texels.iter().enumerate() {
        if !mesh.is_object(texel.face) {
            field.radiosity[k] += room.radiosity[k];
            field.irradiance[k] += before[k].truncate().extend(0.0);
        }
    }
    field
}

/// Shots of the room's cells, and of the objects'.
fn count(mesh: &Mesh, shots: &[Shot]) -> (usize, usize) {
    let of_objects = |shot: &&Shot| mesh.is_object(mesh.cells[shot.cell as usize].face);
    let objects = shots.iter().filter(of_objects).count();
    (shots.len() - objects, objects)
}
