//! What a captured wall reflects and what it emits: both are in its radiosity.
//!
//! ```text
//! B₀ = E + ρH₀
//! ```
//! H₀ is gathered from the map itself. A texel is explained by reflection alone, ρ = B₀/H₀ and
//! E = 0, unless that takes more than [`MOST`] in some channel: then it is an emitter, has the mean
//! ρ of its face's other texels, and E is the rest. So the equation holds by construction.

use crate::mesh::Mesh;
use crate::relight::Room;
use glam::{DVec3, Vec3, Vec4};

/// No wall is whiter: fresh snow.
pub const MOST: f32 = 0.9;

/// What the sum of some hundred shots may round off B₀: within it the walls' own E, where it is known,
/// is theirs.
const ROUNDING: f32 = 1e-5;

/// Where H₀ is less than this share of the room's mean, B₀/H₀ says nothing.
const TINY: f64 = 1e-3;

/// ρ of a room in which nothing can be told: a middling wall.
const UNKNOWN: Vec3 = Vec3::splat(0.5);

/// ρ and E of every texel, objects too, in the mesh's order.
#[derive(Clone, Debug)]
pub struct Surface {
    /// ρ.
    pub reflectance: Vec<Vec3>,
    /// E = B₀ − ρH₀, W/m²; where H₀ says nothing it may be negative.
    pub emission: Vec<Vec3>,
    /// The room's texels that were found to emit; none where ρ was known.
    pub emitters: Vec<u32>,
}

impl Surface {
    /// From B₀ and the irradiance `before` the objects.
    pub fn of(mesh: &Mesh, room: &Room, before: &[Vec4]) -> Self {
        let mut emitters = Vec::new();
        let reflectance = match &room.reflectance {
            Some(known) => known.clone(),
            None => recover(mesh, room, before, &mut emitters),
        };
        let emission_of = |(k, texel): (usize, &crate::mesh::Texel)| {
            if mesh.is_object(texel.face) {
                return texel.emission;
            }
            let (b, h) = (room.radiosity[k].truncate(), before[k].truncate());
            if room.reflectance.is_none() && h != Vec3::ZERO && reflectance[k] == b / h {
                // ρH₀ may round away from B₀; what was explained does not emit.
                return Vec3::ZERO;
            }
            let rest = b - reflectance[k] * h;
            let rounding = (rest - texel.emission).abs().cmple(b * ROUNDING);
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

fn recover(mesh: &Mesh, room: &Room, before: &[Vec4], emitters: &mut Vec<u32>) -> Vec<Vec3> {
    let mean = mean_irradiance(mesh, before);
    let explained: Vec<Option<Vec3>> = (0..mesh.texels.len())
        .map(|k| {
            let (b, h) = (room.radiosity[k].truncate(), before[k].truncate());
            let told = h.as_dvec3().cmpgt(mean * TINY).all();
            // A solver may leave −1e-9 of B₀ behind: that is no reflectance, and becomes E.
            let ratio = (b / h).max(Vec3::ZERO);
            (told && ratio.max_element() <= MOST).then_some(ratio)
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

/// The area's mean of H₀ over the room.
fn mean_irradiance(mesh: &Mesh, before: &[Vec4]) -> DVec3 {
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for (texel, h) in mesh.texels.iter().zip(before) {
        if !mesh.is_object(texel.face) {
            sum += h.truncate().as_dvec3() * f64::from(texel.area);
            area += f64::from(texel.area);
        }
    }
    if area > 0.0 { sum / area } else { DVec3::ZERO }
}

/// The mean ρ of each face's explained texels; of all of them where a face has none.
fn face_means(mesh: &Mesh, explained: &[Option<Vec3>]) -> Vec<Vec3> {
    let mut sums = vec![(DVec3::ZERO, 0.0); mesh.faces.len()];
    for (texel, reflectance) in mesh.texels.iter().zip(explained) {
        if let Some(reflectance) = reflectance.filter(|_| !mesh.is_object(texel.face)) {
            let sum = &mut sums[texel.face as usize];
            sum.0 += reflectance.as_dvec3() * f64::from(texel.area);
            sum.1 += f64::from(texel.area);
        }
    }
    let all = sums
        .iter()
        .fold((DVec3::ZERO, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let mean = |(sum, area): (DVec3, f64), other: Vec3| {
        if area > 0.0 {
            (sum / area).as_vec3()
        } else {
            other
        }
    };
    let room = mean(all, UNKNOWN);
    sums.into_iter().map(|sum| mean(sum, room)).collect()
}
