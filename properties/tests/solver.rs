//! A small solver, and the places at which faults are planted in it.

use common::form_factor::polygon_factor;
use common::mesh::{Mesh, Patch, Texel};
use glam::Vec3;

/// Bounces after which less than 0.8¹⁰⁰ = 2·10⁻¹⁰ of the light is left.
const BOUNCES: u32 = 100;

/// Changes of the solver's numbers.
#[derive(Clone, Copy)]
pub struct Fault {
    /// Factor of the form factor from texel k to patch i.
    pub link: fn(&Mesh, usize, usize) -> f32,
    /// Irradiance that a texel reflects for the irradiance that it receives.
    pub irradiance: fn(&Texel, Vec3) -> Vec3,
}

/// No fault.
pub const HONEST: Fault = Fault {
    link: |_, _, _| 1.0,
    irradiance: |_, h| h,
};

/// Returns the radiosity of each texel: gathers from all patches, of which each is visible in a convex room.
pub fn gather_light(mesh: &Mesh, fault: Fault) -> Vec<Vec3> {
    let link = |k: usize, i: usize| {
        let (texel, patch) = (&mesh.texels[k], &mesh.patches[i]);
        let normal = mesh.faces[texel.face as usize].normal;
        (fault.link)(mesh, k, i) * polygon_factor(&patch.shooter, texel.position, normal)
    };
    let row = |k: usize| Vec::from_iter((0..mesh.patches.len()).map(|i| link(k, i)));
    let links: Vec<Vec<f32>> = (0..mesh.texels.len()).map(row).collect();
    let mut radiosity: Vec<Vec3> = mesh.texels.iter().map(|texel| texel.emission).collect();
    for _ in 0..BOUNCES {
        let mean = |patch: &Patch| radiosity[patch.texels()].iter().sum::<Vec3>() / patch.count as f32;
        let sources: Vec<Vec3> = mesh.patches.iter().map(mean).collect();
        let gather = |(texel, links): (&Texel, &Vec<f32>)| {
            let received = links.iter().zip(&sources).map(|(f, b)| *f * *b).sum();
            texel.emission + texel.reflectance * (fault.irradiance)(texel, received)
        };
        radiosity = mesh.texels.iter().zip(&links).map(gather).collect();
    }
    radiosity
}
