//! Follows the shots of both solvers from equal fields, and stops at the first that parts them.

use super::chain::{Chain, ObservedShot};
use super::field_difference::{FieldDifference, ShotComparison, TexelDifference, VALUE_NAMES};
use super::shooter_links::ShooterLinks;
use super::{MAX_FOLLOWED_SHOOTERS, MAX_FOLLOWED_SHOTS};
use crate::compare::parting::{ChainStep, Element, Factor, FirstDivergence, LargestDifference, Parting};
use crate::compare::roundings::{MAX_ESCAPE_DIRECTIONS, StageRoundings, escape_difference};
use crate::solve::progress::ProgressMonitor;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Transport;
use common::shooting::{DepositRule, RadiosityField, Restart, Shoot, Shot, ShotOrder, select_shooter};
use common::{Error, Result};
use cpu::CpuSolver;
use glam::Vec3;
use gpu::GpuSolver;
use stage_check::tally::ulp_distance;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::ControlFlow;

/// Both solvers on one mesh.
pub struct Search<'a> {
    /// The scene, for names of faces.
    pub scene: &'a Scene,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The GPU's light transport; the CPU's has visibility by rays.
    pub transport: &'a Transport,
    /// Σ|r|A at which a solve has converged.
    pub threshold: f32,
    /// The CPU's solver, by rays.
    pub cpu: CpuSolver<'a>,
    /// The GPU's solver.
    pub gpu: GpuSolver<'a>,
    /// Links of the shooters so far.
    pub shooters: BTreeMap<u32, ShooterLinks>,
}

/// Shot of both sides, and the fields around it.
struct FollowedShot {
    number: u32,
    shots: [Shot; 2],
    before: RadiosityField,
    /// Of GPU and CPU.
    after: [RadiosityField; 2],
}

impl<'a> Search<'a> {
    /// Follows shots until one parts the solvers, and records what it finds in `found`.
    ///
    /// Errors: the device fails, or `watch` interrupts.
    pub fn follow_shots(&mut self, found: &mut FirstDivergence, watch: &ProgressMonitor) -> Result<()> {
        let reflectance: Vec<Vec3> = self.mesh.texels.iter().map(|texel| texel.reflectance).collect();
        let mut within: Option<(TexelDifference, u32)> = None;
        for number in 1..=MAX_FOLLOWED_SHOTS {
            let shots = u64::from(MAX_FOLLOWED_SHOTS);
            if watch.report_count("first divergence", number.into(), shots).is_break() {
                return Err(Error::Interrupted);
            }
            let before = self.gpu.read_field()?;
            let gpu_power = self.gpu.patch_power()?;
            self.cpu
                .restart_from(DepositRule::FULL_DEPOSIT, &reflectance, &before)?;
            let power = self.cpu.patch_power()?;
            let mut shot = None;
            let order = ShotOrder::Greedy {
                threshold: self.threshold,
            };
            self.gpu.run(order, 1, &mut |done| {
                shot = Some(*done);
                ControlFlow::Continue(())
            })?;
            let chosen = shot.map(|shot: Shot| shot.patch);
            found.parting = self.compare_choice(number, chosen, [&gpu_power, &power]);
            let Some(shot) = shot.filter(|_| found.parting.is_none()) else {
                break;
            };
            if self.shooters.len() == MAX_FOLLOWED_SHOOTERS && !self.shooters.contains_key(&shot.patch) {
                break;
            }
            let cpu_shot = self.cpu.shoot(shot.patch)?;
            let followed = FollowedShot {
                number,
                shots: [shot, cpu_shot],
                before,
                after: [self.gpu.read_field()?, self.cpu.read_field()?],
            };
            self.make_shooter_links(shot.patch)?;
            found.followed_shots = number;
            let difference = self.compare_shot(&followed, found);
            if within.is_none_or(|(most, _)| difference.exceeds(&most)) {
                within = difference.within.map(|found| (found, number)).or(within);
            }
            if found.parting.is_some() {
                break;
            }
        }
        found.largest = within.map(|(difference, number)| self.describe_largest(&difference, number));
        Ok(())
    }

    /// Makes the links of a shooter, unless they are known.
    ///
    /// Errors: the device fails.
    pub fn make_shooter_links(&mut self, patch: u32) -> Result<()> {
        if let Entry::Vacant(place) = self.shooters.entry(patch) {
            let (cpu, gpu) = (&mut self.cpu, &mut self.gpu);
            place.insert(ShooterLinks::new(self.mesh, self.transport, patch, cpu, gpu)?);
        }
        Ok(())
    }

    /// Compares the fields after a shot and its record; sets the parting and the first silhouette.
    fn compare_shot(&self, followed: &FollowedShot, found: &mut FirstDivergence) -> FieldDifference {
        let links = &self.shooters[&followed.shots[0].patch];
        let comparison = ShotComparison {
            mesh: self.mesh,
            transport: self.transport,
            bounds: self.bounds(),
            shot: &followed.shots[1],
            links,
        };
        let difference = comparison.compare(&followed.after[0], &followed.after[1]);
        let observed = ObservedShot {
            mesh: self.mesh,
            transport: self.transport,
            bounds: self.bounds(),
            rays: self.cpu.rays(),
            shot: &followed.shots[0],
            links,
            before: &followed.before,
            after: &followed.after[0],
        };
        found.parting = match difference.beyond {
            Some(worst) => {
                let chain = observed.follow(worst.texel, worst.channel);
                Some(self.parting_at(followed, Some(&worst), chain))
            }
            None => self
                .compare_hidden(followed, &observed)
                .or_else(|| self.compare_record(followed, &observed)),
        };
        let is_first = found.silhouette.is_none() && found.parting.is_none();
        if let Some(worst) = difference.at_silhouette.filter(|_| is_first) {
            let visible = [links.gpu_visible_part(worst.texel), links.cpu_visible_part(worst.texel)];
            let text = observed.describe_visibility(worst.texel, visible);
            let mut chain = observed.follow(worst.texel, worst.channel);
            chain.cause = Some((Factor::Visibility, text));
            found.silhouette = Some(self.parting_at(followed, Some(&worst), chain));
        }
        difference
    }

    /// Compares the form factors and weights of a shot whose fields agree: those of invisible texels change no link.
    fn compare_hidden(&self, followed: &FollowedShot, observed: &ObservedShot) -> Option<Parting> {
        let texel = observed.worst_form_factor()?;
        let mut chain = observed.follow(texel, 0);
        if let Some((_, cause)) = &mut chain.cause {
            cause.push_str("; no link changes");
        }
        Some(Parting {
            texel: Some(self.texel_element(texel)),
            ..self.parting_at(followed, None, chain)
        })
    }

    /// Compares flux, ΣF and escaped share of a shot whose fields agree.
    fn compare_record(&self, followed: &FollowedShot, observed: &ObservedShot) -> Option<Parting> {
        let mut chain = observed.follow_record();
        let escaped = followed.shots.map(|shot| shot.escaped);
        let difference = escape_difference(escaped[0], escaped[1]);
        let within = difference <= MAX_ESCAPE_DIRECTIONS;
        chain.steps.push(ChainStep {
            quantity: "escaped share of the shooter's hemisphere".into(),
            unit: "",
            gpu: escaped[0].into(),
            cpu: escaped[1].into(),
            differs: !within,
        });
        if !within && chain.cause.is_none() {
            let text = format!("{difference} of 1024 directions meet a front on one side only");
            chain.cause = Some((Factor::Escape, text));
        }
        chain.cause.is_some().then(|| self.parting_at(followed, None, chain))
    }

    fn parting_at(&self, followed: &FollowedShot, at: Option<&TexelDifference>, chain: Chain) -> Parting {
        let (factor, cause) = chain.cause.unwrap_or_else(|| {
            let text = "no quantity of the chain differs by more than its own bound";
            (Factor::Stage, text.into())
        });
        let mut steps = chain.steps;
        if let Some(found) = at {
            let fields = followed.after.each_ref().map(|field| {
                let values = [&field.radiosity, &field.residual, &field.irradiance];
                f64::from(values[found.value][found.texel][found.channel])
            });
            steps.push(ChainStep {
                quantity: format!("{} after the shot", value_name(found)),
                unit: "W/m²",
                gpu: fields[0],
                cpu: fields[1],
                differs: true,
            });
        }
        Parting {
            shot: Some(followed.number),
            shooter: self.patch_element(followed.shots[0].patch),
            texel: at.map(|found| self.texel_element(found.texel)),
            factor,
            stage: None,
            cause,
            steps,
        }
    }

    /// Compares the powers of all patches, then the choice by them.
    fn compare_choice(&self, number: u32, chosen: Option<u32>, [gpu, cpu]: [&[f32]; 2]) -> Option<Parting> {
        let bound = self.bounds().patch_sum;
        let watts = |power: Option<&f32>| power.map_or(f64::NAN, |power| f64::from(*power) * self.mesh.area_unit());
        let step = |patch: u32| ChainStep {
            quantity: format!("unshot power Σ|r|A of patch {}", self.describe_patch(patch)),
            unit: "W",
            gpu: watts(gpu.get(patch as usize)),
            cpu: watts(cpu.get(patch as usize)),
            differs: false,
        };
        let parting = |factor, cause: String, steps| Parting {
            shot: Some(number),
            shooter: chosen.and_then(|patch| self.patch_element(patch)),
            texel: None,
            factor,
            stage: None,
            cause,
            steps,
        };
        let differs = |k: &usize| {
            let equal = gpu
                .get(*k)
                .is_some_and(|found| ulp_distance(*found, cpu[*k], 0.0) <= bound);
            !equal
        };
        let expected = select_shooter(cpu, self.threshold);
        if let Some(k) = (0..cpu.len()).find(differs) {
            let step = ChainStep {
                differs: true,
                ..step(k as u32)
            };
            let text = "the sums of |residual| × area over a patch's texels differ";
            return Some(parting(Factor::Power, text.into(), vec![step]));
        }
        if chosen == expected {
            return None;
        }
        let power_of = |patch: Option<u32>| patch.and_then(|patch| cpu.get(patch as usize)).copied();
        if let (Some(a), Some(b)) = (power_of(chosen), power_of(expected))
            && ulp_distance(a, b, 0.0) <= 2.0 * bound
        {
            return None;
        }
        let total = f64::from(cpu.iter().sum::<f32>());
        let at_threshold = (total / f64::from(self.threshold) - 1.0).abs() <= f64::from(f32::EPSILON) * bound * 2.0;
        if chosen.is_none() != expected.is_none() && at_threshold {
            return None;
        }
        let [found, wanted] = [chosen, expected].map(|patch| match patch {
            None => "no patch".to_owned(),
            Some(patch) => format!("patch {}", self.describe_patch(patch)),
        });
        let known = |patch: &u32| (*patch as usize) < cpu.len();
        let steps = [chosen, expected].into_iter().flatten().filter(known).map(step);
        let text = format!("the GPU chooses {found}, the CPU {wanted}, from equal powers");
        Some(parting(Factor::Choice, text, steps.collect()))
    }

    fn describe_largest(&self, found: &TexelDifference, number: u32) -> LargestDifference {
        LargestDifference {
            value: format!(
                "{} of texel {} after shot {number}",
                value_name(found),
                self.texel_element(found.texel)
            ),
            difference: found.difference,
            bound: found.bounds.iter().sum(),
        }
    }

    fn bounds(&self) -> StageRoundings {
        StageRoundings::of(self.mesh, self.transport)
    }

    fn element(&self, number: u32, face: u32) -> Element {
        Element {
            number,
            face,
            name: self
                .scene
                .faces
                .get(face as usize)
                .map_or(String::new(), |face| face.name.clone()),
        }
    }

    /// Returns a patch; none if there is no such patch.
    fn patch_element(&self, patch: u32) -> Option<Element> {
        let known = self.mesh.patches.get(patch as usize)?;
        Some(self.element(patch, known.face))
    }

    fn describe_patch(&self, patch: u32) -> String {
        match self.patch_element(patch) {
            Some(element) => element.to_string(),
            None => format!("{patch}, which does not exist"),
        }
    }

    fn texel_element(&self, k: usize) -> Element {
        self.element(k as u32, self.mesh.texels[k].face)
    }
}

fn value_name(found: &TexelDifference) -> String {
    format!("{}.{}", VALUE_NAMES[found.value], ["r", "g", "b"][found.channel])
}
