//! Recovery of a captured wall's reflectance and emission from its radiosity. Relights reflect and emit by the
//! recovered values.
//!
//! ```text
//! B₀ = E + ρH₀
//! ```
//! H₀ is gathered from the captured radiosity. A texel reflects only, ρ = B₀/H₀ and E = 0, unless this ρ
//! is above [`MAX_WALL_REFLECTANCE`] in some channel: then it is an emitter with the mean ρ of its face's other texels, and
//! E is the difference. The equation holds by construction.

use crate::mesh::{Mesh, area_mean};
use crate::relight::RoomRadiosity;
use glam::{DVec3, Vec3, Vec4};

/// Largest reflectance of a wall: fresh snow.
pub const MAX_WALL_REFLECTANCE: f32 = 0.9;

/// Rounding of the sum of some hundred shots, as a share of B₀: within it of a wall's known emission, the
/// known emission is taken.
const ROUNDING_SHARE: f32 = 1e-5;

/// Share of the room's mean H₀ below which B₀/H₀ is not used.
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
    let mean = area_mean(of_room.map(|(texel, h)| (h.truncate(), texel.area)));
    let explained: Vec<Option<Vec3>> = (0..mesh.texels.len())
        .map(|k| {
            let (b, h) = (room.radiosity[k].truncate(), before[k].truncate());
            let is_lit = h.as_dvec3().cmpgt(mean * MIN_IRRADIANCE_SHARE).all();
            // A solver may leave −1e-9 of B₀: this is no reflectance, and becomes E.
            let ratio = (b / h).max(Vec3::ZERO);
            (is_lit && ratio.max_element() <= MAX_WALL_REFLECTANCE).then_some(ratio)
        })
        .collect();
    let of_faces = face_means(mesh, &explained);
    let choose = |(k, texel): (usize, &crate::mesh::Texel)| {
        if mesh.is_object(texel.face) {
            return texel.reflectance;
        }
        explained[k].unwrap_or_else(|| {
            let reflectance = of_faces[texel.face as usize];
            let (b, h) = (room.radiosity[k].truncate(), before[k].truncate());
            if (b - reflectance * h).max_element() > 0.0 {
                emitters.push(k as u32);
            }
            reflectance
        })
    };
    mesh.texels.iter().enumerate().map(choose).collect()
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
