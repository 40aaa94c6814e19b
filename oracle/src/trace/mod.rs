//! The record of a solve that shoots one patch at a time: what each shot did, and why its patch was chosen. [`links`] records a
//! solve to an error.
//!
//! [`recorder`] wraps an engine and observes the shooting loop, [`packing`] compresses the links of a shooter,
//! [`hemisphere`] draws what it sees, [`task`] solves a scene with the recorder in place.
//!
//! ```text
//! ΔB_j = Δr_j = ρ_j · F_j · V_j · B_i / o_i
//! ```
//! In a relight a shot of the room's captured light changes only what the objects change: V is then the share with the objects less
//! the share without them on the room, and each is over its own open share.
//!
//! i is the shooter, B_i the radiosity that it shoots, F_j its form factor from texel j and V_j the share of it that j sees. All
//! its light leaves from its open share o_i, which no body covers; V_j does not include what a body covers. F and V of a patch
//! are the same in all of its shots, so they are kept once.

pub mod hemisphere;
pub mod links;
pub mod packing;
pub mod recorder;
pub mod task;

use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::relight::RoomRadiosity;
use common::shooting::{RadiosityField, Shot};
use glam::Vec3;
use hemisphere::PackedHemisphere;
use packing::PackedLinks;

/// Number of patches whose unshot power is recorded with a shot: the shooter and its rivals.
pub const RANKED_PATCHES: usize = 6;

/// Bytes that a page needs of the parts of a record, besides the compressed links and hemispheres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartBytes {
    /// Of each shot.
    pub shot: usize,
    /// Of each shooter.
    pub shooter: usize,
}

/// Limit that ends a record before its solve ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceLimit {
    /// Bytes of shots, compressed links and hemispheres.
    Bytes,
    /// Number of links: shooters times texels.
    Links,
}

/// What the record of a relight has beside that of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedRelight {
    /// Captured power before the first shot, Σ|B₀|A in the mesh's unit.
    pub captured_power: f32,
    /// True if texels of the room shoot the change of their light.
    pub reshoot: bool,
}

/// One shot with its reason and its effect.
#[derive(Clone, Debug)]
pub struct TracedShot {
    /// The solver's own record.
    pub shot: Shot,
    /// Number of its links among [`ShotTrace::links`].
    pub links: usize,
    /// Radiosity that the patch shot: the mean of its residual, W/m².
    pub radiosity: Vec3,
    /// Patches with the most unshot power before the shot, in falling order, with Σ|r|A in the mesh's unit.
    pub ranking: Vec<(u32, f32)>,
    /// Energy balance after the shot; none in a relight, which shoots a change.
    pub energy: Option<EnergyBalance>,
}

/// Record of a solve.
#[derive(Clone, Debug)]
pub struct ShotTrace {
    /// State before the first shot.
    pub initial: RadiosityField,
    /// Energy balance before the first shot; none in a relight.
    pub initial_energy: Option<EnergyBalance>,
    /// Of a relight.
    pub relight: Option<TracedRelight>,
    /// The first shots; all of them if [`Self::is_complete`].
    pub shots: Vec<TracedShot>,
    /// Links of the patches that have shot, in the order of their first shots; those of captured light by themselves.
    pub links: Vec<PackedLinks>,
    /// What the patch of each of these links sees.
    pub hemispheres: Vec<PackedHemisphere>,
    /// Number of shots of the solve.
    pub shot_count: usize,
    /// Limit that ended the record; none if it is complete.
    pub reached_limit: Option<TraceLimit>,
}

impl ShotTrace {
    /// Returns whether every shot was recorded.
    pub fn is_complete(&self) -> bool {
        self.shots.len() == self.shot_count
    }

    /// Adds the captured radiosity of the room to the state before the first shot of a relight.
    pub fn add_captured_light(&mut self, mesh: &Mesh, room: &RoomRadiosity) {
        let texels = mesh.texels.iter().zip(&room.radiosity).zip(&mut self.initial.radiosity);
        for ((_, captured), initial) in texels.filter(|((texel, _), _)| !mesh.is_object(texel.face)) {
            *initial += *captured;
        }
    }

    /// Returns the number of first shots whose records and links take at most `max_bytes`, at so many of `each`, and the number
    /// of links among [`Self::links`] that these need.
    pub fn count_fitting(&self, max_bytes: usize, each: PartBytes) -> (usize, usize) {
        let (mut bytes, mut links) = (0, 0);
        for (done, traced) in self.shots.iter().enumerate() {
            let is_new = traced.links == links;
            let own = self.links.get(links).zip(self.hemispheres.get(links));
            let own = own.filter(|_| is_new).map_or(0, |(links, hemisphere)| {
                links.byte_count() + hemisphere.byte_count() + each.shooter
            });
            bytes += own + each.shot;
            if bytes > max_bytes {
                return (done, links);
            }
            links += usize::from(is_new);
        }
        (self.shots.len(), links)
    }
}
