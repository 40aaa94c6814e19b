//! Criteria under which the two solvers agree. On any scene only a fault in the code violates one, never the
//! finite resolution of pixels. Each bound stands here once, with its reason; errors of the method are
//! [`item_buffer_findings`].

use super::roundings::form_factor_roundings;
use crate::compare::comparison::{Comparison, Criterion, MethodFinding, StageCheck};
use crate::diff::difference::Difference;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::precision::UNIT_ROUNDOFF;
use common::settings::{ItemBufferProjection, Iteration, Settings};
use common::shooting::{Shot, SolveRun};
use glam::Vec3;

/// Roundings of one reflection: a shot's flux, link and deposit, with the weaker divisions and roots that WGSL
/// allows.
const ROUNDINGS_PER_REFLECTION: f64 = 64.0;
/// Factor λ of the error λ√n·u of a sum of n terms, which holds for all but one sum in 10⁷ (Higham & Mary 2019:
/// probability 2·exp(−λ²/2)).
const SUM_ROUNDING_FACTOR: f64 = 6.0;
/// Largest side of an item buffer that the program accepts, pixels.
const MAX_ITEM_BUFFER_PIXELS: u32 = 8192;

/// Differences that the criteria allow or require beside those of the comparison.
pub struct LinkBounds {
    /// Bounds of the differences between GPU and CPU by silhouettes and unshot light: in lockstep, and of the free runs.
    pub possible_differences: [Difference; 2],
    /// Differences between GPU and the twin on the GPU's links: in lockstep, and of the free run.
    pub twin_differences: [Difference; 2],
    /// Largest (strongest − chosen) / strongest power of the GPU's shots; none for passes.
    pub shortfall: Option<f64>,
}

/// Returns the most shots that a solve on the GPU may take: a shader that leaves a shooter's light unshot would shoot it
/// for ever.
pub fn shot_limit(cpu: &SolveRun) -> u32 {
    const LEAST_SHOTS: u64 = 256;
    (4 * cpu.shooters)
        .saturating_add(LEAST_SHOTS)
        .try_into()
        .unwrap_or(u32::MAX)
}

/// Returns the criteria of shader stages.
pub fn stage_criteria(stages: &[StageCheck]) -> Vec<Criterion> {
    let of_stage = |stage: &StageCheck| Criterion {
        name: format!("WGSL = twin: {}", stage.name),
        value: stage.worst,
        bound: stage.bound,
        reason: stage.reason.clone(),
        pass: stage.agree,
        difference: stage.difference.clone(),
    };
    stages.iter().map(of_stage).collect()
}

/// Evaluates all criteria.
pub fn agreement_criteria(c: &Comparison, bounds: &LinkBounds) -> Vec<Criterion> {
    let mut criteria = stage_criteria(&c.stages);
    let mut require =
        |name: String, value, bound, reason| criteria.push(Criterion::at_most(&name, value, bound, reason));
    let pairs = &c.pairs;
    let share = |part: u64| part as f64 / pairs.facing.max(1) as f64;
    require(
        "visibility: unexplained".into(),
        pairs.unexplained as f64,
        0.0,
        "a mismatch away from every silhouette is a bug",
    );
    require(
        "visibility: mismatched share".into(),
        share(pairs.mismatched),
        share(pairs.explainable),
        "share of this scene's pairs within two pixels of a silhouette",
    );
    require(
        "visibility: weighted share".into(),
        pairs.weighted_mismatch,
        pairs.weighted_explainable,
        "the same, by form factor × area",
    );
    let rounding = [&c.cpu, &c.gpu].map(|run| rounding_bound(c, run.shots.len()));
    let silhouettes = "bound of all pairs near silhouettes together, and rounding";
    let unshot = "the same, and the unshot light of each run";
    let names = [
        ("lockstep", c.lockstep_difference, silhouettes),
        ("free", c.free_difference, unshot),
    ];
    for (k, (name, difference, reason)) in names.into_iter().enumerate() {
        let (possible, rounding) = (&bounds.possible_differences[k], rounding[k]);
        let (rms, bias) = (possible.relative_rms + rounding, possible.bias + rounding);
        require(format!("{name}: relative RMS"), difference.relative_rms, rms, reason);
        require(format!("{name}: |bias|"), difference.bias.abs(), bias, "the same");
        require(
            format!("{name}: GPU = twin on its links"),
            bounds.twin_differences[k].relative_rms,
            rounding,
            "roundings of each reflection, and of a sum over the shots",
        );
    }
    require(
        "free: shots of the GPU".into(),
        c.gpu.shooters as f64,
        f64::from(shot_limit(&c.cpu)),
        "a solve that takes more is stopped: light that was shot may stay unshot",
    );
    if let Some(shortfall) = bounds.shortfall {
        require(
            "free: strongest patches shoot".into(),
            shortfall,
            2.0 * rounding[1],
            "powers within rounding of each other may swap ranks",
        );
    }
    let sides = [("CPU", &c.cpu, &c.cpu_energy), ("GPU", &c.gpu, &c.gpu_energy)];
    for ((name, run, energy), rounding) in sides.into_iter().zip(rounding) {
        require(
            format!("energy imbalance, {name}"),
            energy.imbalance,
            imbalance_bound(&c.mesh, run, energy, pass_factor(&c.gpu_settings, run)),
            "roundings of each shot, and of the power that texels hold",
        );
        require(
            format!("unshot power as logged, {name}"),
            unlogged_power(&c.mesh, run),
            rounding,
            "Σ|r|A of the texels against the log, as a share of the emitted power",
        );
        let met = run.unshot_fraction() <= c.gpu_settings.schedule.epsilon * (1.0 + 4.0 * UNIT_ROUNDOFF);
        require(
            format!("stopped at ε, {name}"),
            f64::from(u8::from(met != run.converged)),
            0.0,
            "a run has converged if and only if its unshot power is at most ε",
        );
    }
    criteria
}

/// Returns the largest relative difference by rounding between two solves on the same links: light reflected g
/// times accumulates the roundings of g reflections, and every texel adds n terms.
fn rounding_bound(c: &Comparison, shots: usize) -> f64 {
    let patches = c.mesh.patches.len().max(1);
    let generations = shots.div_ceil(patches) as f64 + 1.0;
    let each = ROUNDINGS_PER_REFLECTION + 2.0 * form_factor_roundings(c.gpu_settings.transport.form_factor);
    UNIT_ROUNDOFF * (each * generations + SUM_ROUNDING_FACTOR * (shots.max(patches) as f64).sqrt())
}

/// Returns |Σ|r|A − the logged unshot power| over the emitted power (0/0 = 0).
fn unlogged_power(mesh: &Mesh, run: &SolveRun) -> f64 {
    let of = |(texel, r): (&common::mesh::Texel, &glam::Vec4)| {
        f64::from(r.truncate().abs().element_sum()) * f64::from(texel.area)
    };
    let unshot: f64 = mesh.texels.iter().zip(&run.field.residual).map(of).sum();
    let logged = run.shots.last().map_or(run.emitted, |shot| shot.unshot);
    let difference = (unshot - f64::from(logged)).abs();
    if difference == 0.0 {
        0.0
    } else {
        difference / f64::from(run.emitted)
    }
}

/// Returns the largest energy imbalance by f32 rounding, as a share of the emitted power (0/0 = 0).
///
/// A shot's flux is a sum over texels, ΣF one over texels and patches, followed by two products and two quotients:
/// `ROUNDINGS_PER_REFLECTION` roundings of the shot power (times ΣF if that exceeds 1). The absorbed and unshot power of a texel
/// is a sum of one term per shot. `pass_factor` multiplies the shot power for solves by passes.
pub fn imbalance_bound(mesh: &Mesh, run: &SolveRun, energy: &EnergyBalance, pass_factor: f64) -> f64 {
    let sum = |part: [f64; 3]| part.iter().sum::<f64>();
    let power = |s: &Shot| {
        let power = f64::from(Vec3::from(s.power).abs().element_sum());
        power * f64::from(s.form_factor_sum.max(1.0))
    };
    let shot: f64 = run.shots.iter().map(power).sum::<f64>() * mesh.area_unit();
    let terms = run.shots.len().max(mesh.patches.len()) as f64;
    let held = sum(energy.absorbed) + sum(energy.unshot);
    let emitted = sum(energy.emitted);
    if emitted > 0.0 {
        UNIT_ROUNDOFF * (ROUNDINGS_PER_REFLECTION + SUM_ROUNDING_FACTOR * terms.sqrt()) * (shot * pass_factor + held)
            / emitted
    } else {
        0.0
    }
}

/// Returns the factor of the rounding of a solve by passes, each of which adds over all patches again.
fn pass_factor(settings: &Settings, run: &SolveRun) -> f64 {
    if settings.schedule.iteration == Iteration::Southwell {
        1.0
    } else {
        f64::from(run.passes).sqrt()
    }
}

/// Returns the errors of the item buffer, with the option that reduces them.
pub fn item_buffer_findings(c: &Comparison) -> Vec<MethodFinding> {
    let (pairs, drawing) = (&c.pairs, c.gpu_settings.transport.visibility.item_buffer());
    let Some(drawing) = drawing.filter(|_| pairs.mismatched > 0) else {
        return Vec::new();
    };
    let pixels = drawing.size;
    let printed = drawing.projection == ItemBufferProjection::Paper;
    let error = c.lockstep_difference.relative_rms;
    let cause = if printed {
        "Table 3 as printed clips and bends faces, and"
    } else {
        "Beside silhouettes"
    };
    let finer = match pixels * 2 {
        n if n <= MAX_ITEM_BUFFER_PIXELS && !printed => {
            format!(", and --item-buffer {n} has about half of it")
        }
        _ => String::new(),
    };
    vec![MethodFinding {
        name: "item buffer: error in radiosity".into(),
        value: error,
        message: format!(
            "{cause} {pixels}×{pixels} pixels differ from rays on {} of {} pairs of points: {:.2} % of the reflected radiosity (RMS). This is no fault of the code; --visibility rays avoids it{finer}",
            pairs.mismatched,
            pairs.facing,
            100.0 * error,
        ),
    }]
}
