//! Recovery of a captured wall's reflectance and emission from its radiosity. Relights reflect and emit by the
//! recovered values.
//!
//! ```text
//! B₀ = E + ρH₀
//! ```
//! H₀ is gathered from the captured radiosity. A texel reflects only, ρ = B₀/H₀ and E = 0, unless this ratio
//! is above [`MAX_WALL_REFLECTANCE`] in some channel: then it emits, too. Its ρ goes from the ratio to the mean ρ of its
//! face's other texels as the ratio rises to [`MIN_EMITTER_RATIO`], so that noise of B₀ makes no step between neighbours;
//! E is the difference. The equation holds by construction.

use crate::mesh::{Mesh, area_mean};
use crate::relight::RoomRadiosity;
use glam::{DVec3, Vec3, Vec4};

/// Largest reflectance of a wall: fresh snow.
pub const MAX_WALL_REFLECTANCE: f32 = 0.9;

/// Ratio B₀/H₀ from which a texel has the mean ρ of its face.
pub const MIN_EMITTER_RATIO: f32 = 1.8;

/// Rounding of the sum of some hundred shots, as a share of B₀: within it of a wall's known emission, the
/// known emission is taken.
const ROUNDING_SHARE: f32 = 1e-5;

/// Share of the room's mean H₀ below which B₀/H₀ is not used; from twice this share on, it is used fully.
const MIN_IRRADIANCE_SHARE: f64 = 1e-3;

/// ρ of a room without any texel of known ρ.
const DEFAULT_REFLECTANCE: Vec3 = Vec3::splat(0.5);

/// ρ and E of every texel, objects too, in the mesh's order.
#[derive(Clone, Debug)]
pub struct TexelSurfaces {
    /// ρ.
    pub reflectance: Vec<Vec3>,
    /// E = B₀ − ρH₀, W/m²; it may be negative where H₀ is too small.
    pub emission: Vec<Vec3>,
    /// The room's texels that emit; empty if ρ was known.
    pub emitters: Vec<u32>,
}

impl TexelSurfaces {
    /// Recovers ρ and E from B₀ and the irradiance `before` the objects.
    pub fn recover_surfaces(mesh: &Mesh, room: &RoomRadiosity, before: &[Vec4]) -> Self {
        let mut emitters = Vec::new();
        let reflectance = match &room.reflectance {
            Some(known) => known.clone(),
            None => recover_reflectance(mesh, room, before, &mut emitters),
        };
        let emission_of = |(k, texel): (usize, &crate::mesh::Texel)| {
            if mesh.is_object(texel.face) {
                return texel.emission;
            }
            let (b, h) = (room.radiosity[k].truncate(), before[k].truncate());
            if room.reflectance.is_none() && h != Vec3::ZERO && reflectance[k] == b / h {
                // ρH₀ may differ from B₀ by rounding; a texel that reflects only does not emit.
                return Vec3::ZERO;
            }
            let rest = b - reflectance[k] * h;
            let rounding = (rest - texel.emission).abs().cmple(b * ROUNDING_SHARE);
            if rounding.all() { texel.emission } else { rest }
        };
        let emission = mesh.texels.iter().enumerate().map(emission_of).collect();
        Self {
            reflectance,
            emission,
            emitters,
        }
    }
}

fn recover_reflectance(mesh: &Mesh, room: &RoomRadiosity, before: &[Vec4], emitters: &mut Vec<u32>) -> Vec<Vec3> {
    let of_room = mesh
        .texels
        .iter()
        .zip(before)
        .filter(|(texel, _)| !mesh.is_object(texel.face));
    let least = area_mean(of_room.map(|(texel, h)| (h.truncate(), texel.area))) * MIN_IRRADIANCE_SHARE;
    let light = |k: usize| (room.radiosity[k].truncate(), before[k].truncate());
    // A solver may leave −1e-9 of B₀: this is no reflectance, and becomes E.
    let ratio = |k: usize| (light(k).0 / light(k).1).max(Vec3::ZERO);
    // How well a texel is lit: 0…1.
    let lit = |k: usize| smooth_step((light(k).1.as_dvec3() / least).min_element() as f32 - 1.0);
    let explained: Vec<Option<Vec3>> = (0..mesh.texels.len())
        .map(|k| (lit(k) > 0.0 && ratio(k).max_element() <= MAX_WALL_REFLECTANCE).then(|| ratio(k)))
        .collect();
    let of_faces = face_means(mesh, &explained);
    let choose = |(k, texel): (usize, &crate::mesh::Texel)| {
        if mesh.is_object(texel.face) {
            return texel.reflectance;
        }
        let mean = of_faces[texel.face as usize];
        let (b, h) = light(k);
        let reflectance = match lit(k) {
            lit if lit > 0.0 => mean.lerp(blend_reflectance(ratio(k), mean), lit),
            _ => mean,
        };
        if reflectance != ratio(k) && (b - reflectance * h).max_element() > 0.0 {
            emitters.push(k as u32);
        }
        reflectance
    };
    mesh.texels.iter().enumerate().map(choose).collect()
}

/// Returns ρ of a texel of the given ratio B₀/H₀ on a face of the given mean: continuous in the ratio.
fn blend_reflectance(ratio: Vec3, mean: Vec3) -> Vec3 {
    let most = ratio.max_element();
    if most <= MAX_WALL_REFLECTANCE {
        return ratio;
    }
    let emits = smooth_step((most - MAX_WALL_REFLECTANCE) / (MIN_EMITTER_RATIO - MAX_WALL_REFLECTANCE));
    (ratio * (MAX_WALL_REFLECTANCE / most)).lerp(mean.min(ratio), emits)
}

/// Returns 3x² − 2x³ for x in 0…1, 0 below and 1 above; 0 for NaN.
fn smooth_step(x: f32) -> f32 {
    let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
    x * x * (3.0 - 2.0 * x)
}

/// Returns the mean ρ of each face's explained texels; for a face without any, the mean of all.
fn face_means(mesh: &Mesh, explained: &[Option<Vec3>]) -> Vec<Vec3> {
    let mut sums = vec![(DVec3::ZERO, 0.0); mesh.faces.len()];
    for (texel, reflectance) in mesh.texels.iter().zip(explained) {
        if let Some(reflectance) = reflectance.filter(|_| !mesh.is_object(texel.face)) {
            let sum = &mut sums[texel.face as usize];
            sum.0 += reflectance.as_dvec3() * f64::from(texel.area);
            sum.1 += f64::from(texel.area);
        }
    }
    let all = sums.iter().fold((DVec3::ZERO, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let mean = |(sum, area): (DVec3, f64), other: Vec3| {
        if area > 0.0 { (sum / area).as_vec3() } else { other }
    };
    let room = mean(all, DEFAULT_REFLECTANCE);
    sums.into_iter().map(|sum| mean(sum, room)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Face, Scene};

    #[test]
    fn reflectance_is_continuous_in_captured_light_and_explains_it() {
        let corners = [[0., 0., 0.], [0., 0., 1.], [1., 0., 1.], [1., 0., 0.]].map(DVec3::from);
        let scene = Scene {
            faces: vec![Face::quad("wall", corners, Vec3::ZERO, Vec3::ZERO)],
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 64, 1).unwrap();
        // Neighbours' ratios of B₀ and H₀ differ by 1/1000 from 0.4 to 4.5, those of the channels by factors.
        let ratio = |k: usize| Vec3::new(1.0, 0.8, 0.3) * (0.4 + k as f32 * 1e-3);
        let irradiance = |k: usize| Vec3::new(2.0, 3.0, 5.0) * (1.0 + 1e-4 * k as f32);
        let texels = || 0..mesh.texels.len();
        let room = RoomRadiosity {
            radiosity: texels().map(|k| (ratio(k) * irradiance(k)).extend(0.0)).collect(),
            residual: Vec::new(),
            reflectance: None,
        };
        let before: Vec<Vec4> = texels().map(|k| irradiance(k).extend(0.0)).collect();
        let surface = TexelSurfaces::recover_surfaces(&mesh, &room, &before);
        for k in texels() {
            let (rho, e) = (surface.reflectance[k], surface.emission[k]);
            let explained = e + rho * irradiance(k);
            let captured = room.radiosity[k].truncate();
            assert!(
                (explained - captured).abs().cmple(captured * 4.0 * f32::EPSILON).all(),
                "{k}"
            );
            assert!(
                rho.max_element() <= MAX_WALL_REFLECTANCE + 1e-6 && e.min_element() >= 0.0,
                "{k}: {rho} {e}"
            );
            if k > 0 {
                let step = (rho - surface.reflectance[k - 1]).abs().max_element();
                // The slope of the blend: at most 3/2 of 0.9 over the width of 0.9, and the ratio's own.
                assert!(step < 2.5e-3, "{k}: {step}");
            }
        }
        let emits = |k: usize| ratio(k).max_element() > MAX_WALL_REFLECTANCE;
        let emitters: Vec<u32> = (0..mesh.texels.len() as u32).filter(|k| emits(*k as usize)).collect();
        assert_eq!(surface.emitters, emitters);
    }
}
