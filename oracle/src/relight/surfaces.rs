//! Both renders between the texels: the captured room, what the objects change in it, the objects.
//!
//! The reflected part B − E is interpolated and a texel's own E added, so that lamps keep their
//! borders; of what objects change the ratio B/B₀ is interpolated, E being the same before and after. Both
//! vary as smoothly as the light does even where a captured wall's reflectance is different in
//! each texel. Faces that reflect differently are not joined: light may pass their border smoothly,
//! what it becomes there may not. An object of facets with one texel each is shaded from their
//! corners, as if its surface were smooth.

use super::Relit;
use crate::show::view::surface::{Interpolant, Ring, Stencil, Surface};
use crate::show::view::weld::COSINE;
use common::scene::Face;
use glam::{DVec3, Vec3, Vec4};
use std::f32::consts::PI;

/// Cosine of the largest angle (40°) between two faces of an object that approximate one curved
/// surface: light passes their border smoothly. A box keeps its edges.
const CURVED: f64 = 0.766;
/// Never joined: no cosine is as large.
const APART: f64 = 2.0;
/// Joined whatever the angle.
const ANY: f64 = -1.0;
/// Cosine of the angle (2°) by which rounding turns normals that are the same.
const SAME: f32 = 0.9994;
/// B₀ that is less than this share of the room's mean is as good as none.
const SOUND: f32 = 1e-2;
/// Faces reflect alike whose reflectances differ by less than this share.
const ALIKE: f32 = 0.1;

/// The faces with their texels' nodes.
pub fn surface<'a>(relit: &Relit<'a>) -> Surface<'a> {
    let reflectance = reflectances(relit);
    let alike = |a: u32, b: u32| {
        let (a, b) = (reflectance[a as usize], reflectance[b as usize]);
        (a - b).abs().cmple(a.max(b) * ALIKE).all()
    };
    Surface::joined(relit.scene, relit.mesh, |a, b| {
        match (relit.is_object(a), relit.is_object(b)) {
            (false, false) if alike(a, b) => COSINE,
            (true, true) if alike(a, b) => bend(&relit.scene.faces, a, b),
            _ => APART,
        }
    })
}

/// Cosine of the largest angle at which two faces of an object are one surface: where the file has normals,
/// those at the corners that they share tell.
fn bend(faces: &[Face], a: u32, b: u32) -> f64 {
    let [a, b] = [a, b].map(|k| &faces[k as usize]);
    let (Some(first), Some(second)) = (a.normals, b.normals) else {
        return CURVED;
    };
    let own = a.corners.iter().zip(first);
    let shared = own.flat_map(|(p, n)| {
        let other = b.corners.iter().zip(second);
        other
            .filter(move |(q, _)| p == *q)
            .map(move |(_, m)| n.dot(m))
    });
    let least = shared.fold(f32::INFINITY, f32::min);
    match least {
        // Nothing in common but an edge that one of them divides.
        f32::INFINITY => CURVED,
        least if least >= SAME => ANY,
        _ => APART,
    }
}

/// The mean reflectance of each face.
fn reflectances(relit: &Relit) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::ZERO, 0.0); relit.mesh.faces.len()];
    for texel in &relit.mesh.texels {
        let sum = &mut sums[texel.face as usize];
        sum.0 += texel.reflectance;
        sum.1 += 1.0;
    }
    let mean = |(sum, count): (Vec3, f32)| if count > 0.0 { sum / count } else { sum };
    sums.into_iter().map(mean).collect()
}

/// The least B₀ of which B is a multiple.
fn sound(relit: &Relit) -> Vec3 {
    let room = relit.mesh.texels.iter().enumerate();
    let room = room.filter(|(_, texel)| !relit.is_object(texel.face));
    let (mut sum, mut area) = (Vec3::ZERO, 0.0);
    for (k, texel) in room {
        sum += relit.captured(k) * texel.area;
        area += texel.area;
    }
    sum * (SOUND / area.max(f32::MIN_POSITIVE))
}

/// B/B₀ − 1 of a texel, and what of B − B₀ that leaves. What is seen is multiplied by it: a green floor
/// stays green in a shadow (a light map's modulation), and its texture stays. Light that is more than was there
/// is added: what is seen would be amplified with its noise.
fn parted(relit: &Relit, k: usize, sound: Vec3) -> [Vec3; 2] {
    let (change, before) = (relit.delta(k), relit.captured(k));
    let told = before.cmpgt(sound);
    let ratio = Vec3::select(told, change / before, Vec3::ZERO);
    let ratio = ratio.clamp(Vec3::NEG_ONE, Vec3::ONE);
    [ratio, change - ratio * before]
}

/// Radiance (W/m²/sr) at any point.
pub struct Renders<'a> {
    relit: Relit<'a>,
    /// B₀ − E on the room, B − E on objects.
    reflected: Interpolant<'a>,
    /// B/B₀ − 1 on the room, and what of B − B₀ it does not explain.
    ratio: Interpolant<'a>,
    added: Interpolant<'a>,
}

impl<'a> Renders<'a> {
    /// Interpolates over `surface`; what is seen is the room's own render.
    pub fn new(relit: &Relit<'a>, surface: &'a Surface<'a>) -> Self {
        Self::over(relit, surface, false)
    }

    /// The same where a `photograph` is seen. Without one B − B₀ is added, so that B shows between the texels
    /// as well.
    pub fn over(relit: &Relit<'a>, surface: &'a Surface<'a>, photograph: bool) -> Self {
        let texels = || (0..).zip(&relit.mesh.texels);
        let own = |(k, texel): (usize, &common::mesh::Texel)| {
            let leaving = if relit.is_object(texel.face) {
                relit.relit(k)
            } else {
                relit.captured(k)
            };
            (leaving - texel.emission).extend(0.0)
        };
        let reflected: Vec<Vec4> = texels().map(own).collect();
        let sound = sound(relit);
        let part = |k: usize| match photograph {
            true => parted(relit, k, sound),
            false => [Vec3::ZERO, relit.delta(k)],
        };
        let parts: Vec<[Vec3; 2]> = texels().map(|(k, _)| part(k)).collect();
        let part = |n: usize| -> Vec<Vec4> { parts.iter().map(|p| p[n].extend(0.0)).collect() };
        let mut reflected = surface.interpolate(&reflected);
        reflected.smooth_single(|face| relit.is_object(face));
        Self {
            relit: *relit,
            reflected,
            ratio: surface.interpolate(&part(0)),
            added: surface.interpolate(&part(1)),
        }
    }

    /// The texel at a point of a face.
    pub fn texel(&self, face: u32, point: DVec3) -> u32 {
        self.reflected.surface.texel(face, point)
    }

    /// Where a point of a texel lies among its neighbours.
    pub fn stencil(&self, ring: &mut Ring, texel: u32, point: DVec3) -> Stencil {
        self.reflected.surface.stencil_within(ring, texel, point)
    }

    /// Whether two texels emit the same: between them there is no step of the light.
    pub fn emit_alike(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|k| self.relit.mesh.texels[k as usize].emission);
        a == b
    }

    /// The captured room without objects, or an object relit.
    pub fn radiance(&self, stencil: &Stencil) -> Vec3 {
        let texel = &self.relit.mesh.texels[stencil.texel as usize];
        (texel.emission + self.reflected.value(stencil).as_vec3()) / PI
    }

    /// What the objects change in the room, of which `seen` is there; exactly 0 where no texel around
    /// changed.
    pub fn change(&self, stencil: &Stencil, seen: Vec3) -> Vec3 {
        let ratio = self.ratio.value(stencil).as_vec3();
        seen * ratio + self.added.value(stencil).as_vec3() / PI
    }

    /// Whether the point's texel is a light.
    pub fn is_light(&self, stencil: &Stencil) -> bool {
        self.relit.is_light(stencil.texel as usize)
    }
}
