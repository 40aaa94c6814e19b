//! Exchange of flux between all patches at once.

use crate::shader_twins::gather::gather_irradiance;
use glam::Vec3;
use pulp::Arch;

/// Returns Σ_i T_ci B_i for each receiver c, in the order of the patches: `radiosity` of patch i shoots,
/// `transfers` are the rows T_i.
pub fn exchange_flux<'a>(arch: Arch, radiosity: &[Vec3], transfers: impl Iterator<Item = &'a [f32]>) -> Vec<Vec3> {
    let rows: Vec<(Vec3, &[f32])> = (radiosity.iter().zip(transfers))
        .filter(|(shot, _)| **shot != Vec3::ZERO)
        .map(|(shot, row)| (*shot, row))
        .collect();
    let mut flux = vec![Vec3::ZERO; radiosity.len()];
    gather_irradiance(arch, &rows, &mut flux);
    flux
}
