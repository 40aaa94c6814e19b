//! Compares the fields of both sides after a shot, texel by texel, with the largest difference that rounding and
//! silhouettes of item buffers can make.

use super::shooter_links::ShooterLinks;
use crate::compare::roundings::{MAX_ESCAPE_DIRECTIONS, StageRoundings};
use crate::compare::stages::factor_scales;
use common::escape::ESCAPE_DIRECTION_COUNT;
use common::mesh::Mesh;
use common::settings::Transport;
use common::shooting::{RadiosityField, Shot};
use glam::Vec4;

/// Names of the compared values of a texel.
pub const VALUE_NAMES: [&str; 3] = ["B", "r", "H"];

/// Value of a texel that differs.
#[derive(Clone, Copy, Debug)]
pub struct TexelDifference {
    /// The texel.
    pub texel: usize,
    /// Index of the value in [`VALUE_NAMES`].
    pub value: usize,
    /// Colour channel.
    pub channel: usize,
    /// Difference, W/m².
    pub difference: f64,
    /// Bound of rounding, and of silhouettes beside it, W/m².
    pub bounds: [f64; 2],
}

impl TexelDifference {
    fn share_of_bound(&self) -> f64 {
        self.difference / (self.bounds[0] + self.bounds[1])
    }

    /// Returns how far the difference is beyond rounding and the share `of_silhouettes` of the other bound; infinite for NaN.
    fn excess(&self, of_silhouettes: f64) -> f64 {
        match self.difference - self.bounds[0] - of_silhouettes * self.bounds[1] {
            excess if excess.is_nan() => f64::INFINITY,
            excess => excess,
        }
    }
}

/// Differences after one shot; each is the worst of its kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct FieldDifference {
    /// Beyond both bounds.
    pub beyond: Option<TexelDifference>,
    /// Beyond rounding, within the bound of silhouettes.
    pub at_silhouette: Option<TexelDifference>,
    /// Within both bounds, the largest share of them.
    pub within: Option<TexelDifference>,
}

/// Inputs of the comparison of a shot.
pub struct ShotComparison<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Light transport.
    pub transport: &'a Transport,
    /// Bounds of rounding.
    pub bounds: StageRoundings,
    /// The CPU's shot.
    pub shot: &'a Shot,
    /// Links of the shooter.
    pub links: &'a ShooterLinks,
}

impl ShotComparison<'_> {
    /// Compares the GPU's field after the shot with the CPU's; both had the same field before.
    pub fn compare(&self, gpu: &RadiosityField, cpu: &RadiosityField) -> FieldDifference {
        let sizes = factor_scales(self.mesh, self.transport.form_factor, self.shot.patch);
        let scale = f64::from(self.links.closure.link_scale(self.transport.conserve));
        let of_scale = self.scale_bounds();
        let area = f64::from(self.mesh.patches[self.shot.patch as usize].shooter.area);
        let shooter = self.shot.power.map(|flux| f64::from(flux.abs()) / area);
        let mut found = FieldDifference::default();
        for (k, texel) in self.mesh.texels.iter().enumerate() {
            let [w, gpu_w] = [self.links.links[k], self.links.gpu.row.links[k]].map(|w| f64::from(w.abs()));
            let ulp = f64::from(f32::EPSILON)
                * f64::from(sizes[k])
                    .max(w)
                    .max(if gpu_w.is_finite() { gpu_w } else { 0.0 });
            let of_flux = self.bounds.patch_sum * f64::from(f32::EPSILON) + of_scale[0];
            let link_bounds = [
                scale * (self.bounds.links_of_both * ulp + w * of_flux),
                scale * (f64::from(self.links.silhouette_bound(k)) + w * of_scale[1]),
            ];
            let fields = [gpu, cpu].map(|field| [field.radiosity[k], field.residual[k], field.irradiance[k]]);
            let link = (f64::from(fields[0][2].w) - f64::from(fields[1][2].w)).abs();
            found.add(TexelDifference {
                texel: k,
                value: 2,
                channel: 0,
                difference: link * shooter[0],
                bounds: link_bounds.map(|bound| bound * shooter[0]),
            });
            for (value, (a, b)) in fields[0].into_iter().zip(fields[1]).enumerate() {
                let size = [a, b].map(|v| f64::from(v.truncate().abs().max_element()));
                let rounding = self.bounds.deposit * f64::from(f32::EPSILON) * size[0].min(f64::MAX).max(size[1]);
                for (channel, radiosity) in shooter.iter().enumerate() {
                    let reflectance = if value == 2 {
                        1.0
                    } else {
                        f64::from(texel.reflectance[channel])
                    };
                    let [round, outline] = link_bounds.map(|bound| bound * radiosity * reflectance);
                    found.add(TexelDifference {
                        texel: k,
                        value,
                        channel,
                        difference: channel_difference(a, b, channel),
                        bounds: [round + rounding, outline],
                    });
                }
            }
        }
        found
    }

    /// Returns the largest relative difference of the scale by rounding and escapes, and by silhouettes; 0 unless links are
    /// scaled to their closure.
    fn scale_bounds(&self) -> [f64; 2] {
        let closure = self.links.closure;
        if !self.transport.conserve || closure.form_factor_sum <= 0.0 {
            return [0.0; 2];
        }
        let area = f64::from(self.mesh.patches[self.shot.patch as usize].shooter.area);
        let bounds = self.links.gpu.link_bounds.iter().zip(&self.mesh.texels);
        let doubtful: f64 = bounds
            .map(|(bound, texel)| f64::from(*bound) * f64::from(texel.area))
            .sum();
        let sum = f64::from(closure.form_factor_sum);
        let escape = MAX_ESCAPE_DIRECTIONS / ESCAPE_DIRECTION_COUNT as f64 / f64::from(1.0 - closure.escaped);
        [
            self.bounds.sum_of_patches * f64::from(f32::EPSILON) + escape,
            sum / (sum - doubtful / area).max(f64::MIN_POSITIVE) - 1.0,
        ]
    }
}

fn channel_difference(a: Vec4, b: Vec4, channel: usize) -> f64 {
    if a[channel] == b[channel] {
        return 0.0;
    }
    (f64::from(a[channel]) - f64::from(b[channel])).abs()
}

impl FieldDifference {
    fn add(&mut self, found: TexelDifference) {
        let by_excess = |of: f64| move |difference: &TexelDifference| difference.excess(of);
        if found.excess(1.0) > 0.0 {
            replace_if_larger(&mut self.beyond, found, by_excess(1.0));
        } else if found.excess(0.0) > 0.0 {
            replace_if_larger(&mut self.at_silhouette, found, by_excess(0.0));
        }
        if found.excess(1.0) <= 0.0 && found.bounds != [0.0; 2] {
            replace_if_larger(&mut self.within, found, TexelDifference::share_of_bound);
        }
    }

    /// Returns whether the largest share of a bound exceeds that of `other`.
    pub fn exceeds(&self, other: &TexelDifference) -> bool {
        self.within
            .is_some_and(|found| found.share_of_bound() > other.share_of_bound())
    }
}

fn replace_if_larger(
    place: &mut Option<TexelDifference>,
    found: TexelDifference,
    size: impl Fn(&TexelDifference) -> f64,
) {
    if place.as_ref().is_none_or(|old| size(&found) > size(old)) {
        *place = Some(found);
    }
}
