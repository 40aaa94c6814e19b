//! The chain of one shot from the shooter to one texel: each quantity of the GPU beside the CPU's from the same values of
//! the steps before. The first that differs is the factor in which the solvers part.

use super::deposit_cause::{explain_irradiance, explain_reflection, ratio};
use super::form_factor_cause::FormFactorCause;
use super::shooter_links::ShooterLinks;
use crate::compare::parting::{ChainStep, Factor};
use crate::compare::roundings::StageRoundings;
use crate::compare::stages::factor_scales;
use common::mesh::Mesh;
use common::passes::PatchClosure;
use common::rays::{LineOfSight, Rays};
use common::settings::Transport;
use common::shooting::{RadiosityField, Shot};
use cpu::shader_twins::closure::sum_form_factors;
use cpu::shader_twins::link::{Sums, add_sample};
use cpu::shader_twins::patch_transfer::patch_transfer;
use cpu::shader_twins::unshot_power::unshot_power;
use cpu::shader_twins::view::view_sample;
use glam::Vec3;
use stage_check::tally::{larger_or_nan, ulp_distance};
use std::cell::RefCell;

/// Names of the colour channels.
const CHANNELS: [&str; 3] = ["r", "g", "b"];

/// A shot on the GPU with the fields around it.
pub struct ObservedShot<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Light transport.
    pub transport: &'a Transport,
    /// Bounds of rounding.
    pub bounds: StageRoundings,
    /// Visibility.
    pub rays: &'a Rays,
    /// The GPU's record of the shot.
    pub shot: &'a Shot,
    /// Links of the shooter.
    pub links: &'a ShooterLinks,
    /// The field before the shot.
    pub before: &'a RadiosityField,
    /// The GPU's field after it.
    pub after: &'a RadiosityField,
}

/// Quantities of a chain, and the cause of the first that differs.
#[derive(Default)]
pub struct Chain {
    /// In the order in which light passes them.
    pub steps: Vec<ChainStep>,
    /// The factor in which the solvers part, and its cause.
    pub cause: Option<(Factor, String)>,
}

/// A quantity on both sides.
struct Quantity {
    name: String,
    unit: &'static str,
    /// Of GPU and CPU.
    values: [f64; 2],
    differs: bool,
}

impl Chain {
    /// Adds a quantity; the first that differs names the factor.
    fn add(&mut self, quantity: Quantity, cause: impl FnOnce() -> (Factor, String)) {
        if quantity.differs && self.cause.is_none() {
            self.cause = Some(cause());
        }
        let [gpu, cpu] = quantity.values;
        self.steps.push(ChainStep {
            quantity: quantity.name,
            unit: quantity.unit,
            gpu,
            cpu,
            differs: quantity.differs,
        });
    }
}

impl ObservedShot<'_> {
    /// Follows the light to texel `k` in a colour channel.
    pub fn follow(&self, k: usize, channel: usize) -> Chain {
        let mut chain = Chain::default();
        self.add_frame(&mut chain);
        self.add_flux(&mut chain, channel);
        self.add_form_factor(&mut chain, k);
        self.add_visibility(&mut chain, k);
        self.add_link(&mut chain, k);
        self.add_closure(&mut chain);
        self.add_deposit(&mut chain, k, channel);
        chain
    }

    /// Follows what concerns the whole shot.
    pub fn follow_record(&self) -> Chain {
        let mut chain = Chain::default();
        self.add_frame(&mut chain);
        (0..3).for_each(|channel| self.add_flux(&mut chain, channel));
        self.add_closure(&mut chain);
        chain
    }

    /// Returns the texel whose form factor, or weight of its samples, differs most beyond rounding.
    pub fn worst_form_factor(&self) -> Option<usize> {
        let sizes = factor_scales(self.mesh, self.transport.form_factor, self.shot.patch);
        let excess = |k: usize| {
            let (gpu, links) = (self.links.gpu.sums[k], self.links);
            let factor = ulp_distance(gpu.x, links.form_factors[k], sizes[k]) - self.bounds.form_factor;
            let weight = ulp_distance(gpu.z, links.by_rays[k].all, sizes[k]) - self.bounds.link;
            let weight = if gpu.x > 0.0 { weight } else { 0.0 };
            larger_or_nan(factor, weight)
        };
        let within = |excess: f64| excess <= 0.0;
        let beyond = (0..sizes.len())
            .map(|k| (k, excess(k)))
            .filter(|(_, excess)| !within(*excess));
        beyond.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
    }

    /// Adds the frame of the first sample, if it differs.
    fn add_frame(&self, chain: &mut Chain) {
        let (frame, _) = view_sample(self.mesh, self.shot.patch, 0);
        let aim = &self.links.gpu.aim;
        let differ = |a: Vec3, b: Vec3| {
            let beyond = |k: usize| !is_within(ulp_distance(a[k], b[k], 1.0), self.bounds.frame);
            (0..3).any(beyond)
        };
        if differ(aim.normal, frame.normal) {
            let cosine = f64::from(aim.normal.dot(frame.normal));
            let quantity = Quantity {
                name: "normal of the shooter · normal of its face".into(),
                unit: "",
                values: [cosine, 1.0],
                differs: true,
            };
            chain.add(quantity, || {
                let text = if cosine < -0.999 {
                    "points to the back"
                } else {
                    "is not that of its face"
                };
                (
                    Factor::Frame,
                    format!("the normal from which the shooter's hemisphere is seen {text}"),
                )
            });
        }
        if differ(aim.centre, frame.centre) {
            let distance = f64::from(aim.centre.distance(frame.centre)) * self.mesh.unit;
            let quantity = Quantity {
                name: "distance of the point of view from the shooter's sample point".into(),
                unit: "scene units",
                values: [distance, 0.0],
                differs: true,
            };
            chain.add(quantity, || {
                (
                    Factor::Frame,
                    "the scene is seen from another point than the shooter's".into(),
                )
            });
        }
    }

    fn add_flux(&self, chain: &mut Chain, channel: usize) {
        let shooter = &self.mesh.patches[self.shot.patch as usize];
        let twin = unshot_power(self.mesh, self.before, shooter);
        let values = [self.shot.power[channel], twin[channel]];
        let watts = self.mesh.area_unit();
        let quantity = Quantity {
            name: format!("flux of the shooter Φ.{}", CHANNELS[channel]),
            unit: "W",
            values: values.map(|flux| f64::from(flux) * watts),
            differs: !is_within(ulp_distance(values[0], values[1], twin.w), self.bounds.patch_sum),
        };
        chain.add(quantity, || {
            let text = format!(
                "the sum of residual × area over the shooter's texels is {} times the CPU's",
                ratio(values)
            );
            (Factor::Power, text)
        });
    }

    fn add_form_factor(&self, chain: &mut Chain, k: usize) {
        let (patch, kind) = (self.shot.patch, self.transport.form_factor);
        let shooter = &self.mesh.patches[patch as usize].shooter;
        let size = factor_scales(self.mesh, kind, patch)[k];
        let values = [self.links.gpu.sums[k].x, self.links.form_factors[k]];
        chain.add(self.number("form factor F", values, size, self.bounds.form_factor), || {
            let gpu: Vec<f32> = self.links.gpu.sums.iter().map(|sums| sums.x).collect();
            let cause = FormFactorCause::new(self.mesh, kind, patch, [&gpu, &self.links.form_factors]);
            let (factor, text) = cause.find_cause(k as u32, values);
            let texel = &self.mesh.texels[k];
            let d = texel.position - shooter.centre;
            let distance = d.length();
            let normal = self.mesh.faces[texel.face as usize].normal;
            let [at_shooter, at_receiver] = [shooter.normal.dot(d) / distance, -normal.dot(d) / distance];
            let geometry = format!(
                "distance {:.4} scene units, cosines {at_shooter:.4} at the shooter and {at_receiver:.4} at the receiver",
                f64::from(distance) * self.mesh.unit
            );
            (factor, format!("{text} ({geometry})"))
        });
    }

    /// Adds the weights of the samples and the visible part.
    fn add_visibility(&self, chain: &mut Chain, k: usize) {
        let (gpu, twin) = (self.links.gpu.sums[k], self.links.by_rays[k]);
        if gpu.x.is_nan() || gpu.x <= 0.0 {
            return;
        }
        let size = factor_scales(self.mesh, self.transport.form_factor, self.shot.patch)[k];
        let weights = [gpu.z, twin.all];
        chain.add(
            self.number("weights of the samples Σg", weights, size, self.bounds.link),
            || {
                let text = format!("the sum of the samples' weights is {} times the CPU's", ratio(weights));
                (Factor::SampleWeight, text)
            },
        );
        let visible = [self.links.gpu_visible_part(k), self.links.cpu_visible_part(k)];
        let open = self.mesh.patches[self.shot.patch as usize].open_share;
        let change = f64::from(gpu.x / open) * f64::from((visible[0] - visible[1]).abs());
        let rounding = self.bounds.link * f64::from(f32::EPSILON) * f64::from(size.max(gpu.x));
        let quantity = Quantity {
            name: "visible part of the shooter V".into(),
            unit: "",
            values: visible.map(f64::from),
            differs: !is_within(change, rounding + f64::from(self.links.silhouette_bound(k))),
        };
        chain.add(quantity, || (Factor::Visibility, self.describe_visibility(k, visible)));
    }

    /// Returns the difference of visibility at texel `k` in words, with the faces that rays meet in between.
    pub fn describe_visibility(&self, k: usize, [gpu, cpu]: [f32; 2]) -> String {
        let blockers = self.find_blockers(k as u32);
        let between = match blockers.first() {
            None => "rays meet no face in between".to_owned(),
            Some(face) => format!("rays meet face {face} in between"),
        };
        let text = if gpu < cpu {
            "hides more of the shooter than rays do"
        } else {
            "shows more of the shooter than rays do"
        };
        format!("the GPU {text}; {between}")
    }

    /// Returns the faces between texel `k` and the sample points of the shooter, by rays.
    fn find_blockers(&self, k: u32) -> Vec<u32> {
        let patch = self.shot.patch;
        let ends = [
            self.mesh.patches[patch as usize].face,
            self.mesh.texels[k as usize].face,
        ];
        let blockers = RefCell::new(Vec::new());
        let mut sums = Sums {
            form_factor: self.links.by_rays[k as usize].form_factor,
            ..Sums::default()
        };
        for s in 0..self.mesh.samples {
            add_sample(self.mesh, patch, k, s, &mut sums, |q, p| {
                blockers.borrow_mut().extend(self.rays.find_blockers(q, p, ends));
                LineOfSight::Clear
            });
        }
        blockers.into_inner()
    }

    fn add_link(&self, chain: &mut Chain, k: usize) {
        let sums = self.links.gpu.sums[k];
        let of_sums = Sums {
            form_factor: sums.x,
            seen: sums.y,
            all: sums.z,
            before: sums.w,
        };
        let open = self.mesh.patches[self.shot.patch as usize].open_share;
        let size = factor_scales(self.mesh, self.transport.form_factor, self.shot.patch)[k];
        let values = [self.links.gpu.row.links[k], of_sums.link_weight(open)];
        chain.add(self.number("link w = F·V", values, size, self.bounds.link), || {
            let text = format!("the link is {} times F × the visible part", ratio(values));
            (Factor::Link, text)
        });
    }

    /// Adds ΣF, the escaped share and the scale of the links.
    fn add_closure(&self, chain: &mut Chain) {
        let (row, shooter) = (
            &self.links.gpu.row,
            &self.mesh.patches[self.shot.patch as usize].shooter,
        );
        let transfers: Vec<f32> = (self.mesh.patches.iter())
            .map(|patch| patch_transfer(self.mesh, &row.links, patch))
            .collect();
        let sums = [row.sum, sum_form_factors(&transfers, shooter.area)];
        let bound = self.bounds.sum_of_patches + self.bounds.patch_sum;
        chain.add(self.number("sum of the form factors ΣF", sums, 0.0, bound), || {
            let text = format!("the sum over the GPU's own links is {} times the CPU's", ratio(sums));
            (Factor::Closure, text)
        });
        if self.transport.conserve {
            let closure = PatchClosure {
                form_factor_sum: row.sum,
                escaped: row.escaped,
            };
            let scales = [row.scale, closure.link_scale(true)];
            chain.add(self.number("scale of the links", scales, 0.0, bound), || {
                (
                    Factor::Closure,
                    format!("the scale from ΣF is {} times the CPU's", ratio(scales)),
                )
            });
        }
    }

    /// Adds the link that the shot used, and the changes of H, B and r.
    fn add_deposit(&self, chain: &mut Chain, k: usize, channel: usize) {
        let patch = &self.mesh.patches[self.shot.patch as usize];
        let used = [
            self.after.irradiance[k].w,
            self.links.gpu.row.links[k] * self.links.gpu.row.scale,
        ];
        let size = factor_scales(self.mesh, self.transport.form_factor, self.shot.patch)[k];
        chain.add(self.number("link of the shot", used, size, self.bounds.link), || {
            (Factor::Link, format!("the shot used {} times the link", ratio(used)))
        });
        let is_own = patch.texels().contains(&k);
        let radiosity = self.shot.power[channel] / patch.shooter.area;
        let received = if is_own { 0.0 } else { radiosity * used[0] };
        let reflectance = self.mesh.texels[k].reflectance[channel];
        let reflected = reflectance * received;
        let fields = [self.before, self.after];
        let irradiance = fields.map(|field| field.irradiance[k]);
        let name = |symbol: &str| format!("{symbol}.{}", CHANNELS[channel]);
        let deposit = |name: String, [before, after]: [glam::Vec4; 2], expected: f32| {
            let total = before[channel] + expected;
            let size = after.truncate().abs().max_element();
            Quantity {
                name,
                unit: "W/m²",
                values: [f64::from(after[channel] - before[channel]), f64::from(expected)],
                differs: !is_within(ulp_distance(after[channel], total, size), self.bounds.deposit),
            }
        };
        chain.add(deposit(name("irradiance ΔH"), irradiance, received), || {
            let values = [irradiance[1][channel] - irradiance[0][channel], received];
            explain_irradiance(values, patch.shooter.area)
        });
        let radiosities = fields.map(|field| field.radiosity[k]);
        let explain = |[before, after]: [glam::Vec4; 2], symbol: &str| {
            explain_reflection([after[channel] - before[channel], reflected], reflectance, symbol)
        };
        chain.add(deposit(name("radiosity ΔB"), radiosities, reflected), || {
            explain(radiosities, "radiosity")
        });
        let residuals = fields.map(|field| field.residual[k]);
        let expected = if is_own { -residuals[0][channel] } else { reflected };
        chain.add(deposit(name("residual Δr"), residuals, expected), || match is_own {
            true => (Factor::Accumulation, "the shooter's residual is not cleared".into()),
            false => explain(residuals, "residual"),
        });
    }

    fn number(&self, name: &str, values: [f32; 2], size: f32, bound: f64) -> Quantity {
        Quantity {
            name: name.to_owned(),
            unit: "",
            values: values.map(f64::from),
            differs: !is_within(ulp_distance(values[0], values[1], size), bound),
        }
    }
}

/// True if an error is at most `bound`; false for NaN.
fn is_within(error: f64, bound: f64) -> bool {
    error <= bound
}
