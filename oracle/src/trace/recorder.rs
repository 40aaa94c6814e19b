//! An engine that records the shots of another.

use super::hemisphere::{PackedHemisphere, hemisphere_settings};
use super::packing::{PackedLinks, TexelLinks, TexelOrder};
use super::{PartBytes, RANKED_PATCHES, ShotTrace, TraceLimit, TracedRelight, TracedShot};
use crate::compare::roundings::StageRoundings;
use crate::compare::stages::factor_scales;
use common::energy::{EnergyBalance, LostPower};
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::rays::{LineOfSight, NO_FACE, Rays};
use common::settings::{ItemBufferSettings, Transport};
use common::shooting::{DepositRule, RadiosityField, Restart, Shoot, Shot, total_power};
use common::{Error, Result};
use cpu::shader_twins::link::{Sums, add_sample, link_texel, texel_form_factor};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::cell::Cell;
use std::collections::HashMap;

/// Roundings of the product of a link and the open share.
const OPEN_SHARE_ROUNDINGS: f64 = 1.0;

/// Engine that passes every call to another engine and records the shots. It observes: the shooting loop, its choices and
/// its results are those of the other engine. A relight restarts it: with the captured light, then with the change.
pub struct ShotRecorder<'a, E: Shoot + ?Sized> {
    engine: &'a mut E,
    record: ShotRecord<'a>,
    /// Unshot power of each patch, as the loop has last read it.
    power: Vec<f32>,
}

/// The record of a solve under way.
pub struct ShotRecord<'a> {
    links: LinkReader<'a>,
    /// Settings by which the hemispheres are drawn.
    drawing: ItemBufferSettings,
    /// Rule by which texels receive a shot.
    rule: DepositRule,
    trace: ShotTrace,
    /// Power that the recorded shots lost.
    lost: LostPower,
    /// Number of the recorded links of each patch, of captured light and of other light.
    linked: HashMap<(u32, bool), usize>,
    /// Bytes recorded so far.
    bytes: usize,
    limits: TraceLimits,
}

/// Reads the links of a shot.
struct LinkReader<'a> {
    mesh: &'a Mesh,
    form_factor: FormFactor,
    /// True if the solver looks visibility up in an item buffer.
    has_item_buffer: bool,
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

impl<'a, E: Shoot + ?Sized> ShotRecorder<'a, E> {
    /// Makes a recorder; shots beyond its limits are only counted.
    ///
    /// Errors: the engine's; those of [`ShotRecord::new`].
    pub fn new(engine: &'a mut E, mesh: &'a Mesh, transport: &Transport, limits: TraceLimits) -> Result<Self> {
        let record = ShotRecord::new(mesh, transport, limits, engine.read_field()?)?;
        Ok(Self {
            engine,
            record,
            power: Vec::new(),
        })
    }

    /// Returns the record.
    pub fn into_trace(self) -> ShotTrace {
        self.record.into_trace()
    }
}

impl<'a> ShotRecord<'a> {
    /// Makes the record of a solve that begins with the texels `initial`; shots beyond its limits are only counted.
    ///
    /// Errors: [`Error::Usage`] of form factors that are scaled to conserve power, which the record has no place for.
    pub fn new(mesh: &'a Mesh, transport: &Transport, limits: TraceLimits, initial: RadiosityField) -> Result<Self> {
        if transport.conserve {
            return Err(Error::Usage(
                "the form factors of a traced solve cannot be scaled to conserve power".into(),
            ));
        }
        Ok(Self {
            links: LinkReader {
                mesh,
                form_factor: transport.form_factor,
                has_item_buffer: transport.visibility.item_buffer().is_some(),
                roundings: StageRoundings::of(mesh, transport).links_of_both + OPEN_SHARE_ROUNDINGS,
                rays: Rays::new(mesh),
                order: TexelOrder::new(mesh),
            },
            drawing: hemisphere_settings(transport.visibility),
            rule: DepositRule::FULL_DEPOSIT,
            trace: ShotTrace {
                initial_energy: Some(EnergyBalance::new(mesh, &initial, &[])),
                initial,
                relight: None,
                shots: Vec::new(),
                links: Vec::new(),
                hemispheres: Vec::new(),
                shot_count: 0,
                reached_limit: None,
            },
            lost: LostPower::before_shots(mesh),
            linked: HashMap::new(),
            bytes: 0,
            limits,
        })
    }

    /// Returns the record.
    pub fn into_trace(self) -> ShotTrace {
        self.trace
    }

    /// Returns whether shots are only counted from now on.
    pub fn is_full(&self) -> bool {
        self.trace.reached_limit.is_some()
    }

    /// Counts a shot. Returns whether [`Self::add_shot`] may add it.
    pub fn count_shot(&mut self, shot: &Shot) -> bool {
        self.trace.shot_count += 1;
        let is_new = !self.linked.contains_key(&(shot.patch, self.rule.captured));
        if !self.is_full() && is_new && (self.linked.len() + 1) * self.links.order.texels.len() > self.limits.links {
            self.trace.reached_limit = Some(TraceLimit::Links);
        }
        !self.is_full()
    }

    /// Adds a shot that is counted, with the unshot power of the patches before it and the texels after it.
    pub fn add_shot(&mut self, shot: Shot, power: &[f32], field: &RadiosityField) {
        let (limits, order) = (self.limits, &self.links.order);
        let (key, captured) = ((shot.patch, self.rule.captured), self.rule.captured);
        let packed = (!self.linked.contains_key(&key)).then(|| {
            let mut links = self.links.read_links(shot.patch, captured, &field.irradiance);
            links.share_errors = match self.links.has_item_buffer && self.trace.relight.is_none() {
                true => self.links.find_share_errors(shot.patch, &links),
                false => vec![0.0; order.texels.len()],
            };
            (
                PackedLinks::new(shot.patch, captured, &links, order),
                PackedHemisphere::new(self.links.mesh, shot.patch, &self.drawing),
            )
        });
        let own = packed.as_ref().map_or(0, |(links, hemisphere)| {
            links.byte_count() + hemisphere.byte_count() + limits.each.shooter
        });
        self.bytes += own + limits.each.shot;
        if self.bytes > limits.bytes {
            self.trace.reached_limit = Some(TraceLimit::Bytes);
            return;
        }
        let links = *self.linked.entry(key).or_insert(self.trace.links.len());
        if let Some((links, hemisphere)) = packed {
            self.trace.links.push(links);
            self.trace.hemispheres.push(hemisphere);
        }
        self.lost.add_shot(&shot);
        let mesh = self.links.mesh;
        let balance = || EnergyBalance::with_lost_power(mesh, field, self.lost);
        self.trace.shots.push(TracedShot {
            shot,
            links,
            radiosity: Vec3::from(shot.power) / mesh.patches[shot.patch as usize].shooter.area,
            ranking: rank_patches(power),
            energy: self.trace.relight.is_none().then(balance),
        });
    }

    /// Continues by another rule of a relight from `field`, of which `power` is unshot.
    fn restart_from(&mut self, rule: DepositRule, power: f32, (reflectance, field): (&[Vec3], &RadiosityField)) {
        self.rule = rule;
        if rule.captured {
            self.trace.initial_energy = None;
            self.trace.relight = Some(TracedRelight {
                captured_power: power,
                reshoot: true,
            });
        } else if let Some(relight) = &mut self.trace.relight {
            relight.reshoot = rule.reshoot;
            self.trace.initial = undo_captured_shots(self.links.mesh, rule, reflectance, field);
        }
    }
}

impl LinkReader<'_> {
    /// Returns the links of the latest shot, which `irradiance` holds in its fourth component, with their factors.
    fn read_links(&self, patch: u32, is_captured: bool, irradiance: &[Vec4]) -> TexelLinks {
        let open = match is_captured {
            true => 1.0,
            false => self.mesh.patches[patch as usize].open_share,
        };
        let scales = factor_scales(self.mesh, self.form_factor, patch);
        let texel_links = self.order.texels.par_iter().map(|k| {
            let seen = irradiance[*k].w * open;
            let form_factor = texel_form_factor(self.mesh, self.form_factor, patch, *k as u32);
            // F is rounded, and the GPU's by other operations. What is seen beyond F is kept.
            let rounding = self.rounding_of(form_factor.max(scales[*k]));
            let is_whole = seen.abs() >= form_factor || (seen != 0.0 && seen.abs() >= form_factor - rounding);
            if is_whole && seen >= 0.0 {
                return (seen, 1.0, 0);
            }
            if is_captured && seen == 0.0 && !self.mesh.is_object(self.mesh.texels[*k].face) {
                // The objects change nothing; form factors of all these would take most of a page.
                return (0.0, 0.0, 0);
            }
            let occluder = self.find_occluder(patch, *k as u32, form_factor);
            match is_whole {
                true => (-seen, -1.0, occluder),
                false => (form_factor, seen / form_factor, occluder),
            }
        });
        let texel_links: Vec<(f32, f32, u16)> = texel_links.collect();
        TexelLinks {
            form_factors: texel_links.iter().map(|link| link.0).collect(),
            shares: texel_links.iter().map(|link| link.1).collect(),
            occluders: texel_links.iter().map(|link| link.2).collect(),
            share_errors: Vec::new(),
        }
    }

    /// Returns the rounding of a link whose F, or F without its cosines, is `size`.
    fn rounding_of(&self, size: f32) -> f32 {
        (self.roundings * f64::from(f32::EPSILON) * f64::from(size)) as f32
    }

    /// Returns by how much the share that each texel sees differs from that by rays between the same points; 0 for roundings.
    fn find_share_errors(&self, patch: u32, links: &TexelLinks) -> Vec<f32> {
        let scales = factor_scales(self.mesh, self.form_factor, patch);
        let texels = self.order.texels.par_iter().zip(&links.form_factors).zip(&links.shares);
        let errors = texels.map(|((k, form_factor), share)| {
            if *form_factor == 0.0 {
                return 0.0;
            }
            let texel = *k as u32;
            let ends = [self.mesh.patches[patch as usize].face, self.mesh.texels[*k].face];
            let last = Cell::new(NO_FACE);
            let by_rays = link_texel(self.mesh, self.form_factor, patch, texel, |from, to| {
                self.rays.find_sight_after(from, to, ends, false, &last)
            });
            let seen = if by_rays.all > 0.0 {
                by_rays.seen / by_rays.all
            } else {
                0.0
            };
            let error = share - seen;
            match error.abs() * form_factor > self.rounding_of(form_factor.max(scales[*k])) {
                true => error,
                false => 0.0,
            }
        });
        errors.collect()
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

impl<E: Shoot + ?Sized> Shoot for ShotRecorder<'_, E> {
    fn patch_power(&mut self) -> Result<Vec<f32>> {
        self.power = self.engine.patch_power()?;
        Ok(self.power.clone())
    }

    fn shoot(&mut self, patch: u32) -> Result<Shot> {
        let shot = self.engine.shoot(patch)?;
        if self.record.count_shot(&shot) {
            self.record.add_shot(shot, &self.power, &self.engine.read_field()?);
        }
        Ok(shot)
    }

    fn read_field(&mut self) -> Result<RadiosityField> {
        self.engine.read_field()
    }
}

impl<E: Restart + ?Sized> Restart for ShotRecorder<'_, E> {
    fn restart_from(&mut self, rule: DepositRule, reflectance: &[Vec3], field: &RadiosityField) -> Result<()> {
        self.engine.restart_from(rule, reflectance, field)?;
        let power = total_power(&self.engine.patch_power()?);
        self.record.restart_from(rule, power, (reflectance, field));
        Ok(())
    }
}

/// Returns the change of radiosity and its unshot part before the captured shots, of which `change` holds the outcome.
fn undo_captured_shots(
    mesh: &Mesh,
    rule: DepositRule,
    reflectance: &[Vec3],
    change: &RadiosityField,
) -> RadiosityField {
    let mut initial = change.clone();
    for (k, texel) in mesh.texels.iter().enumerate() {
        let gained = (reflectance[k] * change.irradiance[k].truncate()).extend(0.0);
        initial.radiosity[k] -= gained;
        if rule.reshoot || mesh.is_object(texel.face) {
            initial.residual[k] -= gained;
        }
    }
    initial
}
