//! Bounds of the rounding of links.

use super::setups::patch_outline;
use common::constants::NEAR_POINTS_PER_SIDE;
use common::form_factor::is_far;
use common::mesh::{Mesh, far_distance};
use common::sampling::near_point_uv;
use cpu::shader_twins::texel_point::point_on_texel;
use glam::DVec3;
use oracle::exact::point_to_polygon;
use radiosity_tests::bounds::{U, polygon_rounding};

/// Largest shift by rounding of a distance that decides between the grid and the centre of a texel, mesh units: a few of
/// 8u, the rounding of a coordinate times the steps of a plane's equation.
const ROUNDED_DISTANCE: f64 = 2e-6;

/// Share of a form factor that rounding may move between samples of a partly hidden link, whose weights are small where
/// a cosine is; a sample that changes sides moves a fourth of it.
const HIDDEN_SHARE: f64 = 1e-3;

/// Returns the regular grid of points on texel `k`.
fn texel_grid(mesh: &Mesh, k: usize) -> Vec<DVec3> {
    let texel = &mesh.texels[k];
    let face = &mesh.faces[texel.face as usize];
    let place = |n| {
        point_on_texel(
            face,
            texel.kind,
            texel.lattice_corner,
            texel.area,
            near_point_uv(n, texel.kind),
        )
    };
    (0..NEAR_POINTS_PER_SIDE * NEAR_POINTS_PER_SIDE)
        .map(|n| place(n).truncate().as_dvec3())
        .collect()
}

/// Returns true if texel `k` uses its grid of points for patch `i`: if it is near and there are several samples.
fn is_near(mesh: &Mesh, i: usize, k: usize) -> bool {
    let (patch, texel) = (&mesh.patches[i], &mesh.texels[k]);
    let reach = far_distance(patch, &mesh.faces[texel.face as usize]);
    mesh.samples > 1 && !is_far(texel.position, patch.shooter.centre, reach)
}

/// Returns the receiver points of texel `k` for patch `i`: its grid, or its centre.
fn receiver_points(mesh: &Mesh, i: usize, k: usize) -> Vec<DVec3> {
    if is_near(mesh, i, k) {
        texel_grid(mesh, k)
    } else {
        vec![mesh.texels[k].position.as_dvec3()]
    }
}

/// Returns the mean of the exact form factors of patch `i` from these points of texel `k`.
fn mean_factor(mesh: &Mesh, i: usize, k: usize, points: &[DVec3]) -> f64 {
    let normal = mesh.faces[mesh.texels[k].face as usize].normal.as_dvec3();
    let polygon = patch_outline(mesh, i);
    let sum: f64 = points.iter().map(|p| point_to_polygon(*p, normal, &polygon)).sum();
    sum / points.len() as f64
}

/// Returns the rounding of a texel's form factor of a patch: the mean over its receiver points.
fn factor_rounding(mesh: &Mesh, i: usize, k: usize) -> f64 {
    let (places, polygon) = (receiver_points(mesh, i, k), patch_outline(mesh, i));
    let sum: f64 = places.iter().map(|p| polygon_rounding(*p, &polygon)).sum();
    sum / places.len() as f64 + places.len() as f64 * U
}

/// Returns a bound of the rounding of a `link` of texel `k` to patch `i`, unless a ray passes an edge within rounding.
pub fn link_rounding(mesh: &Mesh, i: usize, k: usize, link: f32) -> f64 {
    let (patch, texel) = (&mesh.patches[i], &mesh.texels[k]);
    if patch.face == texel.face {
        return 0.0;
    }
    let face = &mesh.faces[texel.face as usize];
    let distance = texel.position.distance(patch.shooter.centre);
    // Rounding decides between the grid and the centre: the link may change by F < 1.
    if mesh.samples > 1 && f64::from((distance - far_distance(patch, face)).abs()) < ROUNDED_DISTANCE {
        return 1.0;
    }
    let rounding = factor_rounding(mesh, i, k);
    let factor = mean_factor(mesh, i, k, &receiver_points(mesh, i, k));
    let is_partly_hidden = link > 0.0 && f64::from(link) < factor - rounding;
    rounding + if is_partly_hidden { HIDDEN_SHARE * factor } else { 0.0 }
}
