//! Relighting of a room, whose radiosity B₀ was captured, with objects in it.
//!
//! ```text
//! δ = B − B₀ on the room, B on objects      δ = Kδ + s
//! s = (K − K₀)B₀ on the room,  K B₀ + E on objects
//! ```
//! K₀ and K are transport without and with the objects. [`relight_room`] runs the shooting loop twice on one
//! engine. First every patch of the room shoots the captured radiosity, and texels record their irradiance
//! without the objects and its change. From these, [`surface`] recovers the walls' reflectance and
//! emission. Then δ, of both signs, is shot until it converges (George, Sillion & Greenberg 1990).
//! Table 2 of the paper is this method without some of its steps: [`MendedFlaws`].

pub mod surface;

use crate::error::Result;
use crate::mesh::Mesh;
use crate::settings::Schedule;
use crate::shooting::{
    DepositRule, RadiosityField, Restart, Shot, ShotOrder, SolveRun, SubtractedLink, require_southwell, total_power,
};
use glam::{Vec3, Vec4};
use serde::Serialize;
use std::ops::ControlFlow;
use surface::TexelSurfaces;

/// Radiosity of a captured room, in the order of the mesh's texels; the objects' entries are not read.
#[derive(Clone, Debug)]
pub struct RoomRadiosity {
    /// B₀, W/m².
    pub radiosity: Vec<Vec4>,
    /// Unshot part of it; 0 where it is not known.
    pub residual: Vec<Vec4>,
    /// ρ, where it is known.
    pub reflectance: Option<Vec<Vec3>>,
}

/// Method of relighting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RelightMethod {
    /// Signed changes, visibility with and without the objects, further bounces: converges to the full solution.
    Signed,
    /// Table 2 with its errors in loop and formula corrected, and these of its flaws mended.
    Paper(MendedFlaws),
}

/// Flaws of Table 2 that are mended; with all of them it is [`RelightMethod::Signed`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MendedFlaws {
    /// A texel that was occluded in the empty room loses no light.
    pub empty_room: bool,
    /// Objects subtract no light from the room that they did not give.
    pub object_shadows: bool,
    /// Objects shoot light to the room (and then subtract none).
    pub bleeding: bool,
    /// The room shoots the change of its radiosity.
    pub shadows: bool,
}

impl RelightMethod {
    /// Returns the rules of the captured shots and of the shots after them.
    fn deposit_rules(self) -> [DepositRule; 2] {
        let mended = match self {
            Self::Signed => MendedFlaws {
                empty_room: true,
                object_shadows: true,
                bleeding: true,
                shadows: true,
            },
            Self::Paper(mended) => mended,
        };
        // Table 2 as printed has all flaws: lines 6 to 9 subtract an occluded texel's light, whichever patch shoots.
        let captured = match mended.empty_room {
            true => SubtractedLink::Before,
            false => SubtractedLink::Unhidden,
        };
        let later = match (mended.bleeding, mended.object_shadows) {
            (true, _) => SubtractedLink::Nothing,
            (false, true) => SubtractedLink::All,
            (false, false) => SubtractedLink::Unhidden,
        };
        [(true, captured), (false, later)].map(|(captured, subtracted)| DepositRule {
            captured,
            subtracted,
            reshoot: mended.shadows,
        })
    }
}

/// Outcome of relighting: the room with the objects in it.
#[derive(Clone, Debug)]
pub struct RelitRoom {
    /// ρ and E of every texel.
    pub surface: TexelSurfaces,
    /// δ, its unshot part, and the change of H.
    pub change: RadiosityField,
    /// All shots and B, r, H. `emitted` is the power that ε is a share of: the power that the captured
    /// shots deposited, or more if the capture has more unshot power.
    pub run: SolveRun,
    /// True if all captured radiosity was shot; otherwise H₀, ρ and E are those of a part of the light.
    pub complete: bool,
    /// Shots from the room's patches.
    pub map_shots: usize,
    /// Shots from the objects' patches.
    pub object_shots: usize,
}

/// Relights a room by `method`; `watch` receives every shot and the power at the start of its loop.
///
/// Errors: the engine's; a usage error of an iteration over many patches at once.
pub fn relight_room(
    engine: &mut dyn Restart,
    mesh: &Mesh,
    room: &RoomRadiosity,
    method: RelightMethod,
    schedule: &Schedule,
    watch: &mut dyn FnMut(&Shot, f32) -> ControlFlow<()>,
) -> Result<RelitRoom> {
    require_southwell(schedule)?;
    let [captured, later] = method.deposit_rules();
    let nothing = vec![Vec4::ZERO; mesh.texels.len()];
    let start = RadiosityField {
        origin: String::new(),
        radiosity: nothing.clone(),
        residual: captured_residual(mesh, room),
        irradiance: nothing,
    };
    let reflectances: Vec<Vec3> = mesh.texels.iter().map(|t| t.reflectance).collect();
    engine.restart_from(captured, &reflectances, &start)?;
    let mut shots = Vec::new();
    let mut stopped = false;
    let mut phase = |engine: &mut dyn Restart, threshold, shots: &mut Vec<Shot>| -> Result<()> {
        let power = total_power(&engine.patch_power()?);
        let remaining_shots = schedule.max_shots - (shots.len() as u32).min(schedule.max_shots);
        if stopped || power <= threshold {
            return Ok(());
        }
        engine.run(ShotOrder::Greedy { threshold }, remaining_shots, &mut |shot| {
            shots.push(*shot);
            let flow = watch(shot, power);
            stopped |= flow.is_break();
            flow
        })
    };
    // Table 2, line 1, for every face of the map.
    phase(engine, 0.0, &mut shots)?;
    let recorded = engine.read_field()?;
    let surface = TexelSurfaces::recover_surfaces(mesh, room, &recorded.radiosity);
    let (change, deposited) = first_change(mesh, room, &surface, &recorded, later.reshoot);
    engine.restart_from(later, &surface.reflectance, &change)?;
    // The capture's unshot power counts up to ε of the captured power.
    let captured = residual_power(mesh, &start.residual);
    let captured_unshot = residual_power(mesh, &room.residual).min(schedule.epsilon * captured);
    let basis = if deposited > 0.0 {
        deposited.max(captured_unshot / schedule.epsilon)
    } else {
        0.0
    };
    let threshold = (schedule.epsilon * basis) as f32;
    // Lines 16 and 17: objects reflect the light that they received; mended, the room does too.
    if deposited > 0.0 {
        phase(engine, threshold, &mut shots)?;
    }
    let unshot = total_power(&engine.patch_power()?);
    let change = engine.read_field()?;
    // B, r and H of room and objects.
    let mut field = change.clone();
    for (k, _) in mesh
        .texels
        .iter()
        .enumerate()
        .filter(|(_, texel)| !mesh.is_object(texel.face))
    {
        field.radiosity[k] += room.radiosity[k];
        field.irradiance[k] += recorded.radiosity[k].truncate().extend(0.0);
    }
    let of_objects = |shot: &&Shot| mesh.is_object(mesh.patches[shot.patch as usize].face);
    let object_shots = shots.iter().filter(of_objects).count();
    let map_shots = shots.len() - object_shots;
    Ok(RelitRoom {
        surface,
        change,
        run: SolveRun {
            converged: unshot <= threshold || deposited == 0.0,
            stagnated: false,
            passes: shots.len() as u32,
            shooters: shots.len() as u64,
            shots,
            emitted: basis as f32,
            field,
        },
        complete: recorded.residual.iter().all(|r| r.truncate() == Vec3::ZERO),
        map_shots,
        object_shots,
    })
}

/// Returns the radiosity of the captured shots: B₀ less its unshot part and the emission under bodies of the room.
fn captured_residual(mesh: &Mesh, room: &RoomRadiosity) -> Vec<Vec4> {
    let mut values = vec![Vec4::ZERO; mesh.texels.len()];
    for patch in mesh.patches.iter().filter(|c| !mesh.is_object(c.face)) {
        for k in patch.texels() {
            let covered_emission = mesh.texels[k].emission * (1.0 - patch.room_open_share);
            values[k] = room.radiosity[k] - room.residual[k] - covered_emission.extend(0.0);
        }
    }
    values
}

/// Returns δ and r after the captured shots, and the power Σ|r|A that they deposited. `recorded` holds the
/// change of H, and H without the objects.
fn first_change(
    mesh: &Mesh,
    room: &RoomRadiosity,
    surface: &TexelSurfaces,
    recorded: &RadiosityField,
    keep: bool,
) -> (RadiosityField, f64) {
    let mut change = RadiosityField {
        radiosity: vec![Vec4::ZERO; mesh.texels.len()],
        ..recorded.clone()
    };
    let mut residual = vec![Vec4::ZERO; mesh.texels.len()];
    for patch in &mesh.patches {
        let object = mesh.is_object(patch.face);
        for k in patch.texels() {
            let gained = surface.reflectance[k] * recorded.irradiance[k].truncate();
            let emission = mesh.texels[k].emission;
            let (radiosity, unshot) = if object {
                (emission + gained, emission * patch.open_share + gained)
            } else {
                let covered_emission = surface.emission[k] * (patch.room_open_share - patch.open_share);
                (gained, if keep { gained - covered_emission } else { Vec3::ZERO })
            };
            change.radiosity[k] = radiosity.extend(0.0);
            residual[k] = unshot.extend(0.0);
        }
    }
    let deposited = residual_power(mesh, &residual);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let room_residual = if mesh.is_object(texel.face) {
            Vec4::ZERO
        } else {
            room.residual[k]
        };
        // Captured power remains only if the run was stopped.
        change.residual[k] = residual[k] + room_residual + recorded.residual[k];
    }
    (change, deposited)
}

/// Returns Σ|r|A over texels and channels, in the mesh's unit.
fn residual_power(mesh: &Mesh, residual: &[Vec4]) -> f64 {
    let texels = mesh.texels.iter().zip(residual);
    texels
        .map(|(texel, r)| f64::from(r.truncate().abs().element_sum()) * f64::from(texel.area))
        .sum()
}
