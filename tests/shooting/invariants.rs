//! What must hold of any answer, held of every scene on every engine with every setting.

use common::energy::Energy;
use glam::Vec3;
use gpu::Fault;
use radiosity_tests::bounds::{U, energy_rounding};
use radiosity_tests::cases::{Case, each_case};
use radiosity_tests::engines::free;
use std::ops::ControlFlow;

fn hold(what: bool, said: impl Fn() -> String) -> Result<(), String> {
    if what { Ok(()) } else { Err(said()) }
}

/// Emitted = absorbed + unshot + escaped + lost, nothing escapes from closed rooms, and no light is
/// negative: B ≥ E, r ≥ 0, H ≥ 0.
fn balances(case: &Case) -> Result<(), String> {
    let run = free(case.engine().as_mut(), &case.settings.schedule);
    hold(run.converged && !run.stagnated, || "no end".to_owned())?;
    let energy = Energy::new(case.mesh, &run.field, &run.shots);
    let bound = energy_rounding(&energy, case.mesh.area_unit(), &run.shots);
    // A NaN is not below its bound.
    hold(energy.imbalance <= bound, || {
        format!("imbalance {} > {bound}", energy.imbalance)
    })?;
    let escaped = energy.escaped != [0.0; 3];
    hold(escaped != case.known.closed, || {
        format!("escaped {:?}", energy.escaped)
    })?;
    let field = &run.field;
    for (k, texel) in case.mesh.texels.iter().enumerate() {
        let [b, r, h] = [&field.radiosity, &field.residual, &field.irradiance]
            .map(|values| values[k].truncate());
        let bright = b.cmpge(texel.emission).all() && r.min_element() >= 0.0;
        hold(bright && h.min_element() >= 0.0 && b.is_finite(), || {
            format!("texel {k}: B {b}, r {r}, H {h}")
        })?;
    }
    Ok(())
}

/// B = E/(1 − ρ) everywhere, as closely as in `exact::furnace`.
fn glows(case: &Case) -> Result<(), String> {
    let Some(exact) = case.known.furnace else {
        return Ok(());
    };
    let run = free(case.engine().as_mut(), &case.settings.schedule);
    let even = |b: f32| (b / exact - 1.0).abs() < 0.01;
    let uneven = run.field.radiosity.iter().find(|b| !even(b.x));
    hold(uneven.is_none(), || format!("{uneven:?}, not {exact}"))
}

/// What the cells take of one is all that it gives, Σ_c T_ci = A_i ΣF; none takes less than nothing,
/// and nothing escapes from closed rooms. (How near ΣF comes to 1 − escaped, and T_ic A_i to T_ci A_c,
/// the properties hold on convex rooms, where it can be told beforehand.)
fn adds_up(case: &Case) -> Result<(), String> {
    let mut engine = case.engine();
    let count = case.mesh.cells.len();
    let cells: Vec<u32> = (0..count as u32).collect();
    let closures = engine
        .link(&cells, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let mut given = 0.0;
    for (i, closure) in closures.iter().enumerate() {
        let mut one = vec![Vec3::ZERO; count];
        one[i] = Vec3::ONE;
        let taken = engine.exchange(&one).unwrap();
        let shut = closure.escaped == 0.0 || !case.known.closed;
        let positive = taken.iter().all(|t| t.x >= 0.0) && closure.escaped >= 0.0;
        hold(shut && positive, || format!("cell {i}: {closure:?}"))?;
        let all: f64 = taken.iter().map(|t| f64::from(t.x)).sum();
        let area = f64::from(case.mesh.cells[i].shooter.area);
        let off = (all - area * f64::from(closure.form_factor_sum)).abs();
        // One rounding a term of the sum in f32, whatever its order, and those of product and quotient.
        let bound = (count + 2) as f64 * U * all;
        hold(off <= bound, || {
            format!("cell {i} gives {off:e} more than is taken, of {bound:e}")
        })?;
        given += all;
    }
    // The foot of a box gives nothing, but not all are feet.
    hold(given > 0.0, || "nothing is given".to_owned())
}

#[test]
fn energy_balances_and_no_light_is_negative() {
    let said = each_case(&[], balances);
    assert!(said.is_empty(), "{said:#?}");
}

#[test]
fn a_furnace_glows_evenly() {
    let said = each_case(&[], glows);
    assert!(said.is_empty(), "{said:#?}");
}

#[test]
fn what_cells_take_is_what_one_gives() {
    let said = each_case(&[], adds_up);
    assert!(said.is_empty(), "{said:#?}");
}

/// Each of them can fail: half of what is reflected is lost, the last cell is not counted.
#[test]
fn planted_faults_are_noticed() {
    let fault = |file, from, to| [Fault { file, from, to }];
    let dark = fault(
        "deposit",
        "texels[k].reflectance * received;",
        "0.5 * texels[k].reflectance * received;",
    );
    assert!(!each_case(&dark, balances).is_empty());
    assert!(!each_case(&dark, glows).is_empty());
    let short = fault(
        "closure",
        "k = lane; k < params.cells;",
        "k = lane; k + 1u < params.cells;",
    );
    assert!(!each_case(&short, adds_up).is_empty());
}
