//! An engine that records the shots of another.

use super::hemisphere::{PackedHemisphere, hemisphere_settings};
use super::packing::{PackedLinks, TexelLinks, TexelOrder};
use super::{PartBytes, RANKED_PATCHES, ShotTrace, TraceLimit, TracedShot};
use crate::compare::roundings::StageRoundings;
use crate::compare::stages::factor_scales;
use common::energy::{EnergyBalance, LostPower};
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::{LineOfSight, NO_FACE, Rays};
use common::settings::{ItemBufferSettings, Transport};
use common::shooting::{RadiosityField, Shoot, Shot};
use common::{Error, Result};
use cpu::shader_twins::link::{Sums, add_sample, texel_form_factor};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::cell::Cell;
use std::collections::HashSet;

/// Roundings of the product of a link and the open share.
const OPEN_SHARE_ROUNDINGS: f64 = 1.0;

/// Engine that passes every call to another engine and records the shots. It observes: the shooting loop, its choices and
/// its results are those of the other engine.
pub struct ShotRecorder<'a> {
    engine: &'a mut dyn Shoot,
    links: LinkReader<'a>,
    /// Settings by which the hemispheres are drawn.
    drawing: ItemBufferSettings,
    /// Unshot power of each patch, as the loop has last read it.
    power: Vec<f32>,
    trace: ShotTrace,
    /// Power that the recorded shots lost.
    lost: LostPower,
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
    /// Largest difference by rounding of the solver's F · V from F, in ulp of F or of F without its cosines.
    roundings: f64,
    rays: Rays,
    order: TexelOrder,
}

/// Limits of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceLimits {
    /// Maximum bytes of shots, compressed links and hemispheres.
    pub bytes: usize,
    /// Maximum number of links: shooters times texels.
    pub links: usize,
    /// Bytes of each shot and each shooter.
    pub each: PartBytes,
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
                roundings: StageRoundings::of(mesh, transport).links_of_both + OPEN_SHARE_ROUNDINGS,
                rays: Rays::new(mesh),
                order: TexelOrder::new(mesh),
            },
            drawing: hemisphere_settings(transport.visibility),
            power: Vec::new(),
            trace: ShotTrace {
                initial_energy: EnergyBalance::new(mesh, &initial, &[]),
                initial,
                shots: Vec::new(),
                links: Vec::new(),
                hemispheres: Vec::new(),
                shot_count: 0,
                reached_limit: None,
            },
            lost: LostPower::before_shots(mesh),
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
        self.trace.shot_count += 1;
        if self.trace.reached_limit.is_some() {
            return Ok(());
        }
        let (limits, order) = (self.limits, &self.links.order);
        let is_new = !self.linked.contains(&shot.patch);
        if is_new && (self.linked.len() + 1) * order.texels.len() > limits.links {
            self.trace.reached_limit = Some(TraceLimit::Links);
            return Ok(());
        }
        let field = self.engine.read_field()?;
        let packed = is_new.then(|| {
            let links = self.links.read_links(shot.patch, &field.irradiance);
            (
                PackedLinks::new(shot.patch, &links, order),
                PackedHemisphere::new(self.links.mesh, shot.patch, &self.drawing),
            )
        });
        let own = packed.as_ref().map_or(0, |(links, hemisphere)| {
            links.byte_count() + hemisphere.byte_count() + limits.each.shooter
        });
        self.bytes += own + limits.each.shot;
        if self.bytes > limits.bytes {
            self.trace.reached_limit = Some(TraceLimit::Bytes);
            return Ok(());
        }
        self.linked.insert(shot.patch);
        if let Some((links, hemisphere)) = packed {
            self.trace.links.push(links);
            self.trace.hemispheres.push(hemisphere);
        }
        self.lost.add_shot(&shot);
        let mesh = self.links.mesh;
        self.trace.shots.push(TracedShot {
            shot,
            radiosity: Vec3::from(shot.power) / mesh.patches[shot.patch as usize].shooter.area,
            ranking: rank_patches(&self.power),
            energy: EnergyBalance::with_lost_power(mesh, &field, self.lost),
        });
        Ok(())
    }
}

impl LinkReader<'_> {
    /// Returns the links of the latest shot, which `irradiance` holds in its fourth component, with their factors.
    fn read_links(&self, patch: u32, irradiance: &[Vec4]) -> TexelLinks {
        let open = self.mesh.patches[patch as usize].open_share;
        let scales = factor_scales(self.mesh, self.form_factor, patch);
        let texel_links = self.order.texels.par_iter().map(|k| {
            let seen = irradiance[*k].w * open;
            let form_factor = texel_form_factor(self.mesh, self.form_factor, patch, *k as u32);
            // F is rounded, and the GPU's by other operations. What is seen beyond F is kept.
            let size = f64::from(form_factor.max(scales[*k]));
            let rounding = (self.roundings * f64::from(f32::EPSILON) * size) as f32;
            if seen >= form_factor || (seen > 0.0 && seen >= form_factor - rounding) {
                return (seen, 1.0, 0);
            }
            let occluder = self.find_occluder(patch, *k as u32, form_factor);
            (form_factor, seen / form_factor, occluder)
        });
        let texel_links: Vec<(f32, f32, u16)> = texel_links.collect();
        TexelLinks {
            form_factors: texel_links.iter().map(|link| link.0).collect(),
            shares: texel_links.iter().map(|link| link.1).collect(),
            occluders: texel_links.iter().map(|link| link.2).collect(),
        }
    }

    /// Returns the number, from 1, of a face between patch and texel on the way of a pair of sample points that could exchange
    /// light; 0 if there is none.
    fn find_occluder(&self, patch: u32, k: u32, form_factor: f32) -> u16 {
        let mesh = self.mesh;
        let ends = [mesh.patches[patch as usize].face, mesh.texels[k as usize].face];
        let (last, is_blocked) = (Cell::new(NO_FACE), Cell::new(false));
        let mut sums = Sums {
            form_factor,
            ..Sums::default()
        };
        for s in 0..mesh.samples {
            add_sample(mesh, patch, k, s, &mut sums, |from, to| {
                let sight = self.rays.find_sight_after(from, to, ends, false, &last);
                is_blocked.set(sight == LineOfSight::Blocked);
                sight
            });
            if is_blocked.get() {
                return u16::try_from(last.get() + 1).unwrap_or(0);
            }
        }
        0
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
