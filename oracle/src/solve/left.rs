//! What no finer step finds: light that was not shot, that links made up or lost, and rounding.

use common::energy::Energy;
use common::mesh::Mesh;
use common::precision::ROUNDOFF;
use common::shooting::Run;
use glam::DVec3;

/// Light that white walls hold is bounded by this share that they absorb.
const LEAST: f64 = 1e-9;

/// What unshot light would still make, of the RMS of B − E, if it spread evenly: H = Σ|r|A/ΣA(1 − ρ̄), the
/// ambient term of Cohen et al. 1988. What escapes makes it less.
pub fn unspent(mesh: &Mesh, run: &Run) -> f64 {
    let (mut area, mut unshot, mut grey, mut light, mut square) =
        (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let (own, reflectance) = (f64::from(texel.area), texel.reflectance.as_dvec3());
        let reflected = (run.field.radiosity[k].truncate() - texel.emission).as_dvec3();
        area += own;
        unshot += own * run.field.residual[k].truncate().as_dvec3().abs();
        grey += own * reflectance;
        square += own * reflectance * reflectance;
        light += own * reflected * reflected;
    }
    let even = unshot / (area - grey).max(DVec3::splat(LEAST * area.max(f64::MIN_POSITIVE)));
    let off = even * (square / light).map(f64::sqrt);
    // A channel without light has nothing to be compared with.
    DVec3::select(light.cmpgt(DVec3::ZERO), off, DVec3::ZERO).max_element()
}

/// What links made up or lost, of the light that there is: from bounce to bounce it adds up. Only where nothing
/// escapes is it known without the noise of rays.
pub fn made_up(mesh: &Mesh, run: &Run) -> f64 {
    let energy = Energy::new(mesh, &run.field, &run.shots);
    let [off, kept] = [energy.closure, energy.absorbed].map(|part| energy.share(part).abs());
    if energy.escaped == [0.0; 3] && off > 0.0 {
        off / kept.min(1.0)
    } else {
        0.0
    }
}

/// How many times light is reflected before it is gone: G = ΣAB/ΣAE.
pub fn reflections(mesh: &Mesh, run: &Run) -> f64 {
    let (mut all, mut emitted) = (0.0f64, 0.0f64);
    for (texel, b) in mesh.texels.iter().zip(&run.field.radiosity) {
        all += f64::from(texel.area * b.truncate().abs().element_sum());
        emitted += f64::from(texel.area * texel.emission.element_sum());
    }
    if emitted > 0.0 { all / emitted } else { 0.0 }
}

/// Rounding that white walls add up: links in f32 make up or lose u = 6e−8 at each of the reflections
/// that light lasts; the deposit and the sum over the cells as much again.
pub fn rounding(mesh: &Mesh, run: &Run) -> f64 {
    2.0 * ROUNDOFF * reflections(mesh, run)
}
