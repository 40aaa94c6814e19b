//! Interpolates radiance between texels: of the captured room, of the objects' change, and of the objects.
//!
//! The reflected part B − E is interpolated and the texel's own E added, so that lamps keep sharp borders. The
//! objects' change is interpolated as the ratio B/B₀. Both vary as smoothly as the irradiance even where a captured
//! wall's reflectance differs in each texel. Faces of different reflectance are not welded: irradiance is continuous
//! across their border, radiosity is not.

use super::RelitScene;
use crate::report::view::interpolation::{InterpolatedField, InterpolationStencil, InterpolationSurface, KnotCache};
use glam::{DVec3, Vec3, Vec4};
use std::f32::consts::PI;

/// Minimum B₀, as a share of the room's mean, for which the ratio B/B₀ is used.
const MIN_RADIOSITY_SHARE: f32 = 1e-2;
/// Maximum relative difference between the reflectances of welded faces.
const REFLECTANCE_TOLERANCE: f32 = 0.1;

/// Places the interpolation nodes and welds faces of equal reflectance that form one surface.
pub fn welded_surface<'a>(relit: &RelitScene<'a>) -> InterpolationSurface<'a> {
    let reflectance = mean_reflectances(relit);
    let alike = |a: u32, b: u32| {
        let (a, b) = (reflectance[a as usize], reflectance[b as usize]);
        (a - b).abs().cmple(a.max(b) * REFLECTANCE_TOLERANCE).all()
    };
    InterpolationSurface::with_welding(relit.scene, relit.mesh, relit.open, |a, b| {
        relit.is_object(a) == relit.is_object(b) && alike(a, b)
    })
}

/// Returns the mean reflectance of each face.
fn mean_reflectances(relit: &RelitScene) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::ZERO, 0.0); relit.mesh.faces.len()];
    for texel in &relit.mesh.texels {
        let sum = &mut sums[texel.face as usize];
        sum.0 += texel.reflectance;
        sum.1 += 1.0;
    }
    let mean = |(sum, count): (Vec3, f32)| if count > 0.0 { sum / count } else { sum };
    sums.into_iter().map(mean).collect()
}

/// Returns the minimum B₀ for which the ratio B/B₀ is used, W/m².
fn min_ratio_radiosity(relit: &RelitScene) -> Vec3 {
    let room = relit.mesh.texels.iter().enumerate();
    let room = room.filter(|(_, texel)| !relit.is_object(texel.face));
    let (mut sum, mut area) = (Vec3::ZERO, 0.0);
    for (k, texel) in room {
        sum += relit.captured_radiosity(k) * texel.area;
        area += texel.area;
    }
    sum * (MIN_RADIOSITY_SHARE / area.max(f32::MIN_POSITIVE))
}

/// Splits a texel's change B − B₀ into the ratio B/B₀ − 1, clamped to −1…1, and a remainder. The photograph is
/// multiplied by the ratio, so that its texture stays in shadows (light-map modulation); the remainder is added, since
/// a larger factor would amplify the photograph's noise.
fn split_change(relit: &RelitScene, k: usize, sound: Vec3) -> [Vec3; 2] {
    let (change, before) = (relit.radiosity_change(k), relit.captured_radiosity(k));
    let divisible = before.cmpgt(sound);
    let ratio = Vec3::select(divisible, change / before, Vec3::ZERO);
    let ratio = ratio.clamp(Vec3::NEG_ONE, Vec3::ONE);
    [ratio, change - ratio * before]
}

/// Interpolated radiance of room and objects, W/m²/sr.
pub struct RelitRadiance<'a> {
    relit: RelitScene<'a>,
    /// B₀ − E on the room, B − E on objects.
    reflected: InterpolatedField<'a>,
    /// B/B₀ − 1 on the room, and the remainder of B − B₀; without a photograph 0 and B − E.
    ratio: InterpolatedField<'a>,
    remainder: InterpolatedField<'a>,
    photograph: bool,
}

impl<'a> RelitRadiance<'a> {
    /// Interpolates over `surface` for a background that is a `photograph`, or is rendered from the room's model. Without
    /// a photograph B − B₀ is added as a whole, so that the composite shows B between texels too.
    pub fn new(relit: &RelitScene<'a>, surface: &'a InterpolationSurface<'a>, photograph: bool) -> Self {
        let texels = || (0..).zip(&relit.mesh.texels);
        let shown = |k: usize| relit.shown_radiosity(k);
        // An object takes no B₀ from a texel that it covers in part: that texel's values are taken as they are.
        let share = |k: usize| {
            if relit.is_object(relit.mesh.texels[k].face) {
                1.0
            } else {
                surface.open[k]
            }
        };
        let reflected = texels().map(|(k, texel)| ((shown(k) - texel.emission) * share(k)).extend(0.0));
        let reflected: Vec<Vec4> = reflected.collect();
        let sound = min_ratio_radiosity(relit);
        let part = |k: usize| match photograph {
            true => split_change(relit, k, sound).map(|part| part * share(k)),
            false => [
                Vec3::ZERO,
                (relit.relit_radiosity(k) - relit.mesh.texels[k].emission) * share(k),
            ],
        };
        let parts: Vec<[Vec3; 2]> = texels().map(|(k, _)| part(k)).collect();
        let part = |n: usize| {
            let values: Vec<Vec4> = parts.iter().map(|p| p[n].extend(0.0)).collect();
            surface.interpolate_irradiance(&values)
        };
        let (reflected, [ratio, remainder]) =
            rayon::join(|| surface.interpolate_irradiance(&reflected), || [0, 1].map(part));
        Self {
            relit: *relit,
            reflected,
            ratio,
            remainder,
            photograph,
        }
    }

    /// Returns the texel at a point of a face.
    pub fn texel_at(&self, face: u32, point: DVec3) -> u32 {
        self.reflected.surface.texel_at(face, point)
    }

    /// Returns the interpolation weights at a point of a texel.
    pub fn stencil_at(&self, ring: &mut KnotCache, texel: u32, point: DVec3) -> InterpolationStencil {
        self.reflected.surface.stencil_within(ring, texel, point)
    }

    /// Returns whether two texels have equal emission.
    pub fn emit_alike(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|k| self.relit.mesh.texels[k as usize].emission);
        a == b
    }

    /// Returns the radiance of the captured room without objects, or of a relit object.
    pub fn radiance_at(&self, stencil: &InterpolationStencil) -> Vec3 {
        let texel = &self.relit.mesh.texels[stencil.texel as usize];
        (texel.emission + self.reflected.stencil_value(stencil).as_vec3()) / PI
    }

    /// Returns the objects' change of the room's radiance `seen`; exactly 0 where no adjacent texel changed.
    pub fn change_at(&self, stencil: &InterpolationStencil, seen: Vec3) -> Vec3 {
        let remainder = self.remainder.stencil_value(stencil);
        if !self.photograph {
            return (remainder - self.reflected.stencil_value(stencil)).as_vec3() / PI;
        }
        seen * self.ratio.stencil_value(stencil).as_vec3() + remainder.as_vec3() / PI
    }

    /// Returns whether the point's texel is a light.
    pub fn is_light(&self, stencil: &InterpolationStencil) -> bool {
        self.relit.is_light(stencil.texel as usize)
    }
}
