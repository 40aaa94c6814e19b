//! Invariants of every solution, checked on every scene on every engine with every setting.

use common::energy::EnergyBalance;
use glam::Vec3;
use gpu::ShaderFault;
use radiosity_tests::bounds::{U, energy_rounding};
use radiosity_tests::engines::shoot_freely;
use radiosity_tests::known_scenes::{Case, each_case};
use std::ops::ControlFlow;

fn require(condition: bool, message: impl Fn() -> String) -> Result<(), String> {
    if condition { Ok(()) } else { Err(message()) }
}

/// Checks that emitted = absorbed + unshot + escaped + lost, that nothing escapes from closed rooms, and
/// that no light is negative: B ≥ E, r ≥ 0, H ≥ 0.
fn energy_balances(case: &Case) -> Result<(), String> {
    let run = shoot_freely(case.fresh_engine().as_mut(), &case.settings.schedule);
    require(run.converged && !run.stagnated, || "no end".to_owned())?;
    let energy = EnergyBalance::new(case.mesh, &run.field, &run.shots);
    let bound = energy_rounding(&energy, case.mesh.area_unit(), &run.shots);
    // A NaN is not below its bound.
    require(energy.imbalance <= bound, || {
        format!("imbalance {} > {bound}", energy.imbalance)
    })?;
    let escaped = energy.escaped != [0.0; 3];
    require(escaped != case.known.closed, || format!("escaped {:?}", energy.escaped))?;
    let field = &run.field;
    for (k, texel) in case.mesh.texels.iter().enumerate() {
        let [b, r, h] = [&field.radiosity, &field.residual, &field.irradiance].map(|values| values[k].truncate());
        let bright = b.cmpge(texel.emission).all() && r.min_element() >= 0.0;
        require(bright && h.min_element() >= 0.0 && b.is_finite(), || {
            format!("texel {k}: B {b}, r {r}, H {h}")
        })?;
    }
    Ok(())
}

/// Checks that B = E/(1 − ρ) everywhere, within the bound of `exact::furnace`.
fn furnace_is_uniform(case: &Case) -> Result<(), String> {
    let Some(exact) = case.known.furnace else {
        return Ok(());
    };
    let run = shoot_freely(case.fresh_engine().as_mut(), &case.settings.schedule);
    let even = |b: f32| (b / exact - 1.0).abs() < 0.01;
    let uneven = run.field.radiosity.iter().find(|b| !even(b.x));
    require(uneven.is_none(), || format!("{uneven:?}, not {exact}"))
}

/// Checks that the transfer from a patch sums to its power, Σ_c T_ci = A_i ΣF, that no transfer is
/// negative, and that nothing escapes from closed rooms. (The property tests check ΣF against 1 − escaped,
/// and T_ic A_i against T_ci A_c, on convex rooms, where the bounds are known.)
fn transfer_sums_match(case: &Case) -> Result<(), String> {
    let mut engine = case.fresh_engine();
    let count = case.mesh.patches.len();
    let patches: Vec<u32> = (0..count as u32).collect();
    let closures = engine.make_links(&patches, &mut |_| ControlFlow::Continue(())).unwrap();
    let mut sent = 0.0;
    for (i, closure) in closures.iter().enumerate() {
        let mut one = vec![Vec3::ZERO; count];
        one[i] = Vec3::ONE;
        let received = engine.exchange_flux(&one).unwrap();
        let shut = closure.escaped == 0.0 || !case.known.closed;
        let positive = received.iter().all(|t| t.x >= 0.0) && closure.escaped >= 0.0;
        require(shut && positive, || format!("patch {i}: {closure:?}"))?;
        let all: f64 = received.iter().map(|t| f64::from(t.x)).sum();
        let area = f64::from(case.mesh.patches[i].shooter.area);
        let off = (all - area * f64::from(closure.form_factor_sum)).abs();
        // One rounding per term of the sum in f32, in any order, and those of product and quotient.
        let bound = (count + 2) as f64 * U * all;
        require(off <= bound, || {
            format!("patch {i} shoots {off:e} more than is received, bound {bound:e}")
        })?;
        sent += all;
    }
    // The bottom of a box shoots nothing, but other faces do.
    require(sent > 0.0, || "no patch shoots".to_owned())
}

#[test]
fn energy_balances_and_light_is_not_negative() {
    let failures = each_case(&[], energy_balances);
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn furnace_radiosity_is_uniform() {
    let failures = each_case(&[], furnace_is_uniform);
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn patch_transfer_sums_to_form_factor_sum() {
    let failures = each_case(&[], transfer_sums_match);
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Shows that each check can fail: half of the reflected light is lost, or the last patch is not counted.
#[test]
fn invariants_detect_planted_faults() {
    let fault = |file, from, to| [ShaderFault { file, from, to }];
    let dark = fault(
        "deposit",
        "texels[k].reflectance * received;",
        "0.5 * texels[k].reflectance * received;",
    );
    assert!(!each_case(&dark, energy_balances).is_empty());
    assert!(!each_case(&dark, furnace_is_uniform).is_empty());
    let short = fault(
        "closure",
        "k = lane; k < params.patches;",
        "k = lane; k + 1u < params.patches;",
    );
    assert!(!each_case(&short, transfer_sums_match).is_empty());
}
