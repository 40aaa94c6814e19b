//! What must hold of any answer, held of every scene on every engine with every setting.

use common::energy::Energy;
use glam::Vec3;
use gpu::Fault;
use radiosity_tests::bounds::energy_rounding;
use radiosity_tests::cases::{Case, each_case};
use radiosity_tests::engines::free;
use std::ops::ControlFlow;

/// What the worst of the cases is off by, rounded up, in the order of the settings: closure and
/// reciprocity. A face as one point, or one point of a cell, sees a slit or does not.
const LINKS: [([u32; 2], [f64; 2]); 3] = [
    ([1, 1], [0.15, 0.2]),
    ([2, 1], [0.09, 0.065]),
    ([2, 4], [0.04, 0.05]),
];

fn hold(what: bool, said: impl Fn() -> String) -> Result<(), String> {
    if what { Ok(()) } else { Err(said()) }
}

/// Emitted = absorbed + unshot + escaped + lost, nothing escapes from closed rooms, and no light is
/// negative: B ≥ E, r ≥ 0, H ≥ 0.
fn balances(case: &Case) -> Result<(), String> {
    let run = free(case.engine().as_mut(), case.settings);
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
    let run = free(case.engine().as_mut(), case.settings);
    let even = |b: f32| (b / exact - 1.0).abs() < 0.01;
    let uneven = run.field.radiosity.iter().find(|b| !even(b.x));
    hold(uneven.is_none(), || format!("{uneven:?}, not {exact}"))
}

/// What each cell takes of each, T_ic A_i; ΣF + escaped = 1; T_ic A_i = T_ci A_c; none below 0.
fn closes(case: &Case) -> Result<(), String> {
    let mut engine = case.engine();
    let cells: Vec<u32> = (0..case.mesh.cells.len() as u32).collect();
    let closures = engine
        .link(&cells, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let mut row = |i: usize| -> Vec<f64> {
        let mut one = vec![Vec3::ZERO; cells.len()];
        one[i] = Vec3::ONE;
        let flux = engine.exchange(&one).unwrap();
        flux.iter().map(|f| f64::from(f.x)).collect()
    };
    let taken: Vec<Vec<f64>> = (0..cells.len()).map(&mut row).collect();
    let (mut lost, mut apart, mut whole) = (0.0, 0.0, 0.0);
    for (i, closure) in closures.iter().enumerate() {
        let area = f64::from(case.mesh.cells[i].shooter.area);
        whole += area;
        lost += area * f64::from((1.0 - closure.form_factor_sum - closure.escaped).abs());
        apart += (0..i)
            .map(|c| (taken[i][c] - taken[c][i]).abs())
            .sum::<f64>();
        let shut = closure.escaped == 0.0 || !case.known.closed;
        let positive = taken[i].iter().all(|t| *t >= 0.0) && closure.escaped >= 0.0;
        hold(shut && positive, || format!("cell {i}: {closure:?}"))?;
    }
    let own = [case.settings.cells, case.settings.samples];
    let (_, bounds) = LINKS.iter().find(|(setting, _)| *setting == own).unwrap();
    let found = [lost / whole, apart / whole];
    hold(found[0] < bounds[0] && found[1] < bounds[1], || {
        format!("closure and reciprocity {found:?} beyond {bounds:?}")
    })
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
fn what_cells_take_closes_and_is_mutual() {
    let said = each_case(&[], closes);
    assert!(said.is_empty(), "{said:#?}");
}

/// Each of them can fail: half of what is reflected is lost, form factors are a third too large.
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
    let factor = "return polygon(position, normal);";
    let large = fault(
        "form_factor",
        factor,
        "return 1.3 * polygon(position, normal);",
    );
    assert!(!each_case(&large, closes).is_empty());
}
