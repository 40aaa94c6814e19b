//! The default projection and lookup of the item buffer err least against rays.

use common::form_factor::{FormFactor, form_factor};
use common::mesh::Mesh;
use common::rays::Rays;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Raster, Transport, Visibility};
use common::shooting::Shoot;
use gpu::{Gpu, GpuSolver};
use radiosity_tests::box_in_room;

/// A smaller form factor is rounding; two solvers may disagree whether it is 0.
const MIN_FORM_FACTOR: f32 = 1e-7;

/// Returns for each patch and texel F·A and visibility by rays, centre to centre; F·A = 0 for pairs not compared.
fn trace_pairs(mesh: &Mesh) -> Vec<Vec<(f64, bool)>> {
    let rays = Rays::new(mesh);
    let patches = mesh.patches.iter().map(|patch| {
        let pairs = mesh.texels.iter().map(|texel| {
            let normal = mesh.faces[texel.face as usize].normal;
            let factor = form_factor(FormFactor::Disc, &patch.shooter, texel.position, normal, texel.area);
            let compared = texel.face != patch.face && factor > MIN_FORM_FACTOR;
            let seen = compared && rays.is_visible(patch.shooter.centre, texel.position, [patch.face, texel.face]);
            (if compared { f64::from(factor * texel.area) } else { 0.0 }, seen)
        });
        pairs.collect()
    });
    patches.collect()
}

/// Returns the share of the transfer Σ F·A that an item buffer hides or lets through falsely.
fn wrong_share(gpu: &Gpu, mesh: &Mesh, traced: &[Vec<(f64, bool)>], drawing: ItemBufferSettings) -> f64 {
    let transport = Transport {
        visibility: Visibility::ItemBuffer(drawing),
        form_factor: FormFactor::Disc,
        conserve: false,
    };
    let mut solver = GpuSolver::new(gpu, mesh, &transport).unwrap();
    let (mut all, mut wrong) = (0.0, 0.0);
    for (patch, pairs) in traced.iter().enumerate() {
        solver.shoot(patch as u32).unwrap();
        for (irradiance, (weight, seen)) in solver.read_irradiance().unwrap().iter().zip(pairs) {
            all += weight;
            wrong += if (irradiance.w > 0.0) == *seen { 0.0 } else { *weight };
        }
    }
    assert!(all > 0.0, "no pair faces each other");
    wrong / all
}

#[test]
fn default_projection_and_lookup_err_least() {
    let gpu = Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh");
    let mesh = Mesh::uniform(&box_in_room(), 16, 1).unwrap();
    let traced = trace_pairs(&mesh);
    let share_of = |projection, size, lookup| {
        let drawing = ItemBufferSettings {
            projection,
            size,
            lookup,
        };
        wrong_share(&gpu, &mesh, &traced, drawing)
    };
    use ItemBufferProjection::{Hemicube, Hemisphere, Paper, Stereographic};
    use Lookup::{Exact, Neighbours};
    use Raster::{Pixel, Tessellated};
    for projection in [Hemisphere(Pixel), Stereographic(Pixel), Hemicube] {
        // More pixels, and nine of them instead of one.
        let few = share_of(projection, 128, Exact);
        assert!(share_of(projection, 512, Exact) < few);
        assert!(share_of(projection, 128, Neighbours) < 0.1 * few);
        assert!(share_of(projection, 512, Neighbours) < 1e-4);
    }
    for projection in [Hemisphere, Stereographic] {
        for size in [128, 512] {
            let cut = share_of(projection(Tessellated), size, Neighbours);
            assert!(share_of(projection(Pixel), size, Neighbours) <= 1.5 * cut + 1e-6);
        }
    }
    // The rim of the orthographic disc costs accuracy.
    let rim = share_of(Hemisphere(Pixel), 512, Exact);
    assert!(share_of(Stereographic(Pixel), 512, Exact) < rim);
    // Table 3 as printed: no resolution mends it.
    assert!(share_of(Paper, 512, Neighbours) > 0.1);
}
