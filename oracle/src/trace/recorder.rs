//! An engine that records the shots of another.

use super::packing::{PackedLinks, TexelLinks, TexelOrder};
use super::{RANKED_PATCHES, ShotTrace, TracedShot};
use common::energy::EnergyBalance;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::{LineOfSight, NO_FACE, Rays};
use common::settings::Transport;
use common::shooting::{RadiosityField, Shoot, Shot};
use common::texel_point::texel_point;
use common::{Error, Result};
use cpu::shader_twins::link::texel_form_factor;
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::cell::Cell;
use std::collections::HashSet;

/// Engine that passes every call to another engine and records the shots. It observes: the shooting loop, its choices and
/// its results are those of the other engine.
pub struct ShotRecorder<'a> {
    engine: &'a mut dyn Shoot,
    links: LinkReader<'a>,
    /// Unshot power of each patch, as the loop has last read it.
    power: Vec<f32>,
    trace: ShotTrace,
    /// All shots, which the energy balance needs.
    shots: Vec<Shot>,
    /// Patches whose links are recorded.
    linked: HashSet<u32>,
    /// Bytes recorded so far.
    bytes: usize,
    limits: TraceLimits,
}

/// Reads the links of a shot.
struct LinkReader<'a> {
    mesh: &'a Mesh,
    form_factor: FormFactor,
    rays: Rays,
    order: TexelOrder,
}

/// Limits of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceLimits {
    /// Maximum bytes of compressed links and shots.
    pub bytes: usize,
    /// Maximum number of links: shooters times texels.
    pub links: usize,
}

impl<'a> ShotRecorder<'a> {
    /// Makes a recorder; shots beyond its limits are only counted.
    ///
    /// Errors: the engine's; [`Error::Usage`] of form factors that are scaled to conserve power, which the record has no place
    /// for.
    pub fn new(engine: &'a mut dyn Shoot, mesh: &'a Mesh, transport: &Transport, limits: TraceLimits) -> Result<Self> {
        if transport.conserve {
            return Err(Error::Usage(
                "the form factors of a traced solve cannot be scaled to conserve power".into(),
            ));
        }
        let initial = engine.read_field()?;
        Ok(Self {
            engine,
            links: LinkReader {
                mesh,
                form_factor: transport.form_factor,
                rays: Rays::new(mesh),
                order: TexelOrder::new(mesh),
            },
            power: Vec::new(),
            trace: ShotTrace {
                initial_energy: EnergyBalance::new(mesh, &initial, &[]),
                initial,
                shots: Vec::new(),
                links: Vec::new(),
                shot_count: 0,
            },
            shots: Vec::new(),
            linked: HashSet::new(),
            bytes: 0,
            limits,
        })
    }

    /// Returns the record.
    pub fn into_trace(self) -> ShotTrace {
        self.trace
    }

    fn record_shot(&mut self, shot: Shot) -> Result<()> {
        let was_complete = self.trace.is_complete();
        self.trace.shot_count += 1;
        if !was_complete {
            return Ok(());
        }
        let field = self.engine.read_field()?;
        if !self.linked.contains(&shot.patch) {
            let order = &self.links.order;
            let links = self.links.read_links(shot.patch, &field.irradiance);
            let packed = PackedLinks::new(shot.patch, &links, order);
            self.bytes += packed.byte_count();
            let links = (self.linked.len() + 1) * order.texels.len();
            if self.bytes > self.limits.bytes || links > self.limits.links {
                return Ok(());
            }
            self.linked.insert(shot.patch);
            self.trace.links.push(packed);
        }
        self.bytes += size_of::<TracedShot>();
        if self.bytes > self.limits.bytes {
            return Ok(());
        }
        self.shots.push(shot);
        let mesh = self.links.mesh;
        self.trace.shots.push(TracedShot {
            shot,
            radiosity: Vec3::from(shot.power) / mesh.patches[shot.patch as usize].shooter.area,
            ranking: rank_patches(&self.power),
            energy: EnergyBalance::new(mesh, &field, &self.shots),
        });
        Ok(())
    }
}

impl LinkReader<'_> {
    /// Returns the links of the latest shot, which `irradiance` holds in its fourth component, with their factors.
    fn read_links(&self, patch: u32, irradiance: &[Vec4]) -> TexelLinks {
        let texel_links = self.order.texels.par_iter().map(|k| {
            let link = irradiance[*k].w;
            let form_factor = texel_form_factor(self.mesh, self.form_factor, patch, *k as u32);
            let share = if form_factor > 0.0 { link / form_factor } else { 1.0 };
            let occluder = match share < 1.0 {
                true => self.find_occluder(patch, *k as u32),
                false => 0,
            };
            (form_factor, share, occluder)
        });
        let texel_links: Vec<(f32, f32, u16)> = texel_links.collect();
        TexelLinks {
            form_factors: texel_links.iter().map(|link| link.0).collect(),
            shares: texel_links.iter().map(|link| link.1).collect(),
            occluders: texel_links.iter().map(|link| link.2).collect(),
        }
    }

    /// Returns the number, from 1, of a face between a pair of sample points of patch and texel; 0 if there is none.
    fn find_occluder(&self, patch: u32, k: u32) -> u16 {
        let mesh = self.mesh;
        let ends = [mesh.patches[patch as usize].face, mesh.texels[k as usize].face];
        let last = Cell::new(NO_FACE);
        let is_blocked = |s: &u32| {
            let from = mesh.patch_points[(patch * mesh.samples + s) as usize].position;
            let to = texel_point(mesh, k, patch, *s).truncate();
            self.rays.find_sight_after(from, to, ends, false, &last) == LineOfSight::Blocked
        };
        match (0..mesh.samples).find(is_blocked) {
            Some(_) => u16::try_from(last.get() + 1).unwrap_or(0),
            None => 0,
        }
    }
}

/// Returns the patches with the most unshot power, in falling order; of equals the lowest number first.
fn rank_patches(power: &[f32]) -> Vec<(u32, f32)> {
    let mut ranked: Vec<(u32, f32)> = Vec::new();
    for (patch, power) in (0..).zip(power.iter().copied()) {
        let at = ranked.partition_point(|(_, other)| *other >= power);
        if at < RANKED_PATCHES {
            ranked.insert(at, (patch, power));
            ranked.truncate(RANKED_PATCHES);
        }
    }
    ranked
}

impl Shoot for ShotRecorder<'_> {
    fn patch_power(&mut self) -> Result<Vec<f32>> {
        self.power = self.engine.patch_power()?;
        Ok(self.power.clone())
    }

    fn shoot(&mut self, patch: u32) -> Result<Shot> {
        let shot = self.engine.shoot(patch)?;
        self.record_shot(shot)?;
        Ok(shot)
    }

    fn read_field(&mut self) -> Result<RadiosityField> {
        self.engine.read_field()
    }
}
