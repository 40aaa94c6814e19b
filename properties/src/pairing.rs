//! Correspondence of texels and patches between two meshes.

use crate::violation::Violation;
use common::mesh::Mesh;
use glam::DVec3;

/// Largest distance of two corresponding places as a share of the scene's size, plus that of their unit normals.
const MAX_PLACE_DIFFERENCE: f64 = 1e-4;
/// Largest relative difference of two corresponding patches' shares of the scene's area.
const MAX_AREA_DIFFERENCE: f64 = 1e-4;

/// Correspondence of two meshes.
pub struct Pairing {
    /// Texel k of the one is texel `texels[k]` of the other.
    pub texels: Vec<usize>,
    /// Patch k of the one is patch `patches[k]` of the other; none if the other has no such patch.
    pub patches: Vec<Option<usize>>,
}

/// Finds for each place and normal the nearest one.
fn nearest_places(of: &[[DVec3; 2]], among: &[[DVec3; 2]], size: f64) -> Vec<Option<usize>> {
    let off = |[p, n]: &[DVec3; 2], [q, m]: &[DVec3; 2]| p.distance(*q) / size + n.distance(*m);
    let find = |one: &[DVec3; 2]| {
        (0..among.len())
            .min_by(|a, b| off(one, &among[*a]).total_cmp(&off(one, &among[*b])))
            .filter(|best| off(one, &among[*best]) < MAX_PLACE_DIFFERENCE)
    };
    of.iter().map(find).collect()
}

/// Returns the texels, or [`Violation::Nothing`] for one that is missing.
fn all_texels(found: impl Iterator<Item = Option<usize>>) -> Result<Vec<usize>, Violation> {
    let missing = |k| Violation::nothing("pairing", format!("texel {k} has no counterpart"));
    found
        .enumerate()
        .map(|(k, texel)| texel.ok_or_else(|| missing(k)))
        .collect()
}

impl Pairing {
    /// Pairs two meshes by place, of which the second is the first mapped by `to`.
    ///
    /// Errors: [`Violation::Nothing`] if a texel has no counterpart.
    pub fn by_place(a: &Mesh, b: &Mesh, to: impl Fn(DVec3) -> DVec3) -> Result<Self, Violation> {
        let place = |mesh: &Mesh, p: DVec3| p * mesh.unit + mesh.origin;
        let moved = |p: DVec3, n: DVec3| {
            let (from, along) = (to(place(a, p)), to(place(a, p) + n * a.unit));
            [from, (along - from).normalize()]
        };
        let kept = |p: DVec3, n: DVec3| [place(b, p), n];
        let normal = |mesh: &Mesh, face: u32| mesh.faces[face as usize].normal.as_dvec3();
        let texels = |mesh: &Mesh, at: &dyn Fn(DVec3, DVec3) -> [DVec3; 2]| -> Vec<[DVec3; 2]> {
            let each = mesh.texels.iter();
            each.map(|t| at(t.position.as_dvec3(), normal(mesh, t.face))).collect()
        };
        let patches = |mesh: &Mesh, at: &dyn Fn(DVec3, DVec3) -> [DVec3; 2]| -> Vec<[DVec3; 2]> {
            let each = mesh.patches.iter();
            each.map(|c| at(c.shooter.centre.as_dvec3(), normal(mesh, c.face)))
                .collect()
        };
        let found = nearest_places(&texels(a, &moved), &texels(b, &kept), b.unit);
        let mut patches = nearest_places(&patches(a, &moved), &patches(b, &kept), b.unit);
        for (k, patch) in patches.iter_mut().enumerate() {
            // A patch with the same centre but another area is another patch.
            let whole = |mesh: &Mesh| mesh.texels.iter().map(|t| f64::from(t.area)).sum::<f64>();
            let share = |mesh: &Mesh, k: usize| f64::from(mesh.patches[k].shooter.area) / whole(mesh);
            *patch = patch.filter(|other| (share(a, k) / share(b, *other) - 1.0).abs() < MAX_AREA_DIFFERENCE);
        }
        Ok(Self {
            texels: all_texels(found.into_iter())?,
            patches,
        })
    }
}

/// Pairs the texels of two meshes, of which the second has the faces of the first in this order. A texel keeps its index
/// in its face: a search by place could confuse bodies that touch.
///
/// Errors: [`Violation::Nothing`] if a texel has no counterpart.
pub(crate) fn pair_by_face(a: &Mesh, b: &Mesh, order: &[usize]) -> Result<Vec<usize>, Violation> {
    let place_of = |face: u32| order.iter().position(|k| *k == face as usize);
    let places: Vec<Option<usize>> = (0..a.faces.len() as u32).map(place_of).collect();
    all_texels(a.texels.iter().map(|t| {
        let face = places[t.face as usize]?;
        let is_same = |other: &common::mesh::Texel| other.face as usize == face && other.index == t.index;
        b.texels.iter().position(is_same)
    }))
}
