//! The conditions under which the two solvers agree. On any scene, each is broken only by a fault in
//! the code, never by what pixels cannot resolve. Each bound stands here once, with its reason; the
//! errors of the method are [`findings`].

use super::stages::factor_roundings;
use crate::judge::comparison::{Difference, Finding, Gate, Pairs, Stage};
use common::energy::Energy;
use common::mesh::Mesh;
use common::settings::{Iteration, Projection, Settings, Visibility};
use common::shooting::{Run, Shot};
use glam::Vec3;

/// Unit roundoff of f32.
const U: f64 = f32::EPSILON as f64 / 2.0;
/// Roundings of one shot's flux, link and deposit, with the weaker divisions and roots that WGSL
/// allows: what light gathers each time that it is reflected.
const REFLECTION: f64 = 64.0;
/// A sum of n terms is off by 6√n roundings of it at most, but for one sum in 10⁷ (Higham & Mary
/// 2019: λ = 6, 2·exp(−λ²/2) for the sum).
const SUM: f64 = 6.0;
/// Item buffers beyond this are refused.
const MOST_PIXELS: u32 = 8192;

/// What the verdict is about.
pub struct Evidence<'a> {
    /// What is solved.
    pub mesh: &'a Mesh,
    /// Options of the GPU.
    pub settings: &'a Settings,
    /// WGSL against twin, and links against links.
    pub stages: &'a [Stage],
    /// Item buffer against rays.
    pub pairs: &'a Pairs,
    /// GPU against CPU: replayed log, free runs.
    pub apart: [&'a Difference; 2],
    /// What silhouettes and unshot light could come to in these.
    pub possible: [Difference; 2],
    /// GPU against the twin on the GPU's links: replayed log, free run.
    pub twin: [Difference; 2],
    /// How much less than the strongest the GPU's shooters had; none where many shoot at once.
    pub shortfall: Option<f64>,
    /// Free runs: CPU, GPU.
    pub runs: [&'a Run; 2],
    /// Their balances.
    pub energy: [&'a Energy; 2],
}

/// All conditions.
pub fn gates(e: &Evidence) -> Vec<Gate> {
    let mut gates = of_stages(e.stages);
    gates.extend(visibility(e.pairs));
    gates.extend(radiosity(e));
    gates.extend(runs(e));
    gates
}

/// Shaders against their twins.
pub fn of_stages(stages: &[Stage]) -> Vec<Gate> {
    let of_stage = |stage: &Stage| Gate {
        name: format!("WGSL = twin: {}", stage.name),
        value: stage.worst,
        bound: stage.bound,
        reason: stage.reason.clone(),
        pass: stage.agree,
    };
    stages.iter().map(of_stage).collect()
}

fn share(part: u64, pairs: &Pairs) -> f64 {
    if pairs.facing == 0 {
        0.0
    } else {
        part as f64 / pairs.facing as f64
    }
}

fn visibility(pairs: &Pairs) -> Vec<Gate> {
    vec![
        Gate::at_most(
            "visibility: unexplained",
            pairs.unexplained as f64,
            0.0,
            "a mismatch off every silhouette is a bug",
        ),
        Gate::at_most(
            "visibility: mismatched share",
            share(pairs.mismatched, pairs),
            share(pairs.explainable, pairs),
            "this scene's pairs within two pixels of a silhouette",
        ),
        Gate::at_most(
            "visibility: weighted share",
            pairs.weighted_mismatch,
            pairs.weighted_explainable,
            "the same, by form factor × area",
        ),
    ]
}

/// What rounding may leave between two solves by the same links: light that is reflected g times
/// has gathered g roundings of each reflection, and every texel adds n terms.
fn rounding(e: &Evidence, shots: usize) -> f64 {
    let cells = e.mesh.cells.len().max(1);
    let generations = shots.div_ceil(cells) as f64 + 1.0;
    let each = REFLECTION + 2.0 * factor_roundings(e.settings.transport.form_factor);
    U * (each * generations + SUM * (shots.max(cells) as f64).sqrt())
}

fn radiosity(e: &Evidence) -> Vec<Gate> {
    let mut gates = Vec::new();
    let names = ["lockstep", "free"];
    let shots = e.runs.map(|run| run.shots.len());
    let reasons = [
        "what all pairs near silhouettes together could bring, and rounding",
        "the same, and what each run left unshot",
    ];
    for k in 0..2 {
        let rounding = rounding(e, shots[k]);
        let name = names[k];
        gates.push(Gate::at_most(
            &format!("{name}: relative RMS"),
            e.apart[k].relative_rms,
            e.possible[k].relative_rms + rounding,
            reasons[k],
        ));
        gates.push(Gate::at_most(
            &format!("{name}: |bias|"),
            e.apart[k].bias.abs(),
            e.possible[k].bias + rounding,
            "the same",
        ));
        gates.push(Gate::at_most(
            &format!("{name}: GPU = twin on its links"),
            e.twin[k].relative_rms,
            rounding,
            "roundings of each reflection, and of a sum over the shots",
        ));
    }
    gates
}

fn runs(e: &Evidence) -> Vec<Gate> {
    let mut gates = Vec::new();
    if let Some(shortfall) = e.shortfall {
        gates.push(Gate::at_most(
            "free: strongest cells shoot",
            shortfall,
            2.0 * rounding(e, e.runs[1].shots.len()),
            "powers within rounding of each other may change places",
        ));
    }
    for (name, run, energy) in [
        ("CPU", e.runs[0], e.energy[0]),
        ("GPU", e.runs[1], e.energy[1]),
    ] {
        gates.push(Gate::at_most(
            &format!("energy imbalance, {name}"),
            energy.imbalance,
            imbalance(e.mesh, run, energy, again(e.settings, run)),
            "roundings of each shot, and of what texels hold",
        ));
        gates.push(Gate::at_most(
            &format!("unshot as told, {name}"),
            untold(e.mesh, run),
            rounding(e, run.shots.len()),
            "Σ|r|A of the texels against the log, as a share of the emitted power",
        ));
        let met = run.unshot_fraction() <= e.settings.schedule.epsilon * (1.0 + 4.0 * U);
        gates.push(Gate::at_most(
            &format!("stopped at ε, {name}"),
            f64::from(u8::from(met != run.converged)),
            0.0,
            "what is unshot tells whether a run has converged",
        ));
    }
    gates
}

/// |Σ|r|A − what the log says| over the emitted power; 0/0 is nothing to tell.
fn untold(mesh: &Mesh, run: &Run) -> f64 {
    let of = |(texel, r): (&common::mesh::Texel, &glam::Vec4)| {
        f64::from(r.truncate().abs().element_sum()) * f64::from(texel.area)
    };
    let left: f64 = mesh.texels.iter().zip(&run.field.residual).map(of).sum();
    let told = run.shots.last().map_or(run.emitted, |shot| shot.unshot);
    let off = (left - f64::from(told)).abs();
    if off == 0.0 {
        0.0
    } else {
        off / f64::from(run.emitted)
    }
}

/// What f32 rounding may leave of the balance, as a share of the emitted power (0/0 = 0).
///
/// Each shot: its flux is a sum over texels, ΣF one over texels and cells, then two products and
/// two quotients, `REFLECTION` roundings of the power shot (and of ΣF times it where the factors
/// exceed 1). What is held, absorbed and unshot, is a sum of as many terms as there are shots in a
/// texel, and the whole of it `again` as often.
pub fn imbalance(mesh: &Mesh, run: &Run, energy: &Energy, again: f64) -> f64 {
    let sum = |part: [f64; 3]| part.iter().sum::<f64>();
    let power = |s: &Shot| {
        let power = f64::from(Vec3::from(s.power).abs().element_sum());
        power * f64::from(s.form_factor_sum.max(1.0))
    };
    let shot: f64 = run.shots.iter().map(power).sum::<f64>() * mesh.area_unit();
    let terms = run.shots.len().max(mesh.cells.len()) as f64;
    let held = sum(energy.absorbed) + sum(energy.unshot);
    let emitted = sum(energy.emitted);
    if emitted > 0.0 {
        U * (REFLECTION + SUM * terms.sqrt()) * (shot * again + held) / emitted
    } else {
        0.0
    }
}

/// Where cells exchange, each pass adds over the cells again.
fn again(settings: &Settings, run: &Run) -> f64 {
    if settings.schedule.iteration == Iteration::Southwell {
        1.0
    } else {
        f64::from(run.passes).sqrt()
    }
}

/// What the method errs by, and the option that mends it.
pub fn findings(e: &Evidence) -> Vec<Finding> {
    let Visibility::Drawn(drawing) = e.settings.transport.visibility else {
        return Vec::new();
    };
    if e.pairs.mismatched == 0 {
        return Vec::new();
    }
    let (pairs, pixels) = (e.pairs, drawing.size);
    let printed = drawing.projection == Projection::Paper;
    let apart = e.apart[0].relative_rms;
    let cause = if printed {
        "Table 3 as printed clips and bends faces, and"
    } else {
        "Beside silhouettes"
    };
    let finer = match pixels * 2 {
        n if n <= MOST_PIXELS && !printed => {
            format!(", and --item-buffer {n} has about half of it")
        }
        _ => String::new(),
    };
    vec![Finding {
        name: "item buffer: error in radiosity".into(),
        value: apart,
        message: format!(
            "{cause} {pixels}×{pixels} pixels judge {} of {} pairs of points differently from rays: {:.2} % of the reflected radiosity (RMS). No fault of the code; --visibility rays has none of it{finer}",
            pairs.mismatched,
            pairs.facing,
            100.0 * apart,
        ),
    }]
}
