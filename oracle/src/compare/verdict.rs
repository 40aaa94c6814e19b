//! The conditions under which the two solvers agree. Each bound stands here once, with its reason.

use crate::comparison::{Difference, Gate, Pairs, Stage};
use common::energy::Energy;
use common::escape::DIRECTIONS;
use common::settings::Settings;
use common::shooting::Run;

/// f32 sums of textures and log over a solve: a few hundred roundings of 6e−8 at most.
pub const CPU_IMBALANCE: f64 = 1e-5;
/// The same with the weaker divisions and roots that WGSL allows.
pub const GPU_IMBALANCE: f64 = 1e-4;
/// Texels on silhouettes: their number over all is that of boundary pixels over all pixels.
pub const MISMATCHED: f64 = 0.005;
/// The same, weighted by form factor × area.
pub const WEIGHTED: f64 = 0.01;
/// The band in which a mismatch can be explained must stay a small part of all pairs, or
/// everything could be explained.
pub const EXPLAINABLE: f64 = 0.05;
/// Every light path loses at most the weighted share of wrong visibilities.
pub const RADIOSITY: f64 = 0.01;
/// Shots of two greedy runs whose powers differ by up to [`RADIOSITY`].
pub const SHOTS: f64 = 0.02;
/// A closed scene has no way out; the ray through an edge is the only exception.
pub const ESCAPED: f64 = 1e-6;

/// What the verdict is about.
pub struct Evidence<'a> {
    /// Options of the CPU.
    pub settings: &'a Settings,
    /// WGSL against twin.
    pub stages: &'a [Stage],
    /// Item buffer against rays.
    pub pairs: &'a Pairs,
    /// Replayed log.
    pub lockstep: &'a Difference,
    /// Free runs.
    pub free: &'a Difference,
    /// Free runs: CPU, GPU.
    pub runs: [&'a Run; 2],
    /// Their balances.
    pub energy: [&'a Energy; 2],
}

/// All conditions.
pub fn gates(e: &Evidence) -> Vec<Gate> {
    let mut gates: Vec<Gate> = e
        .stages
        .iter()
        .map(|stage| Gate {
            name: format!("WGSL = twin: {}", stage.name),
            value: stage.max_ulp,
            bound: stage.bound,
            reason: stage.reason.clone(),
            pass: stage.pass,
        })
        .collect();
    gates.extend(visibility(e.pairs));
    gates.extend(radiosity(e));
    gates.extend(energy(e));
    gates
}

fn visibility(pairs: &Pairs) -> Vec<Gate> {
    let share = |count: u64| {
        if pairs.facing == 0 {
            0.0
        } else {
            count as f64 / pairs.facing as f64
        }
    };
    vec![
        Gate::at_most(
            "visibility: unexplained",
            pairs.unexplained as f64,
            0.0,
            "a mismatch off every silhouette is a bug",
        ),
        Gate::at_most(
            "visibility: mismatched share",
            share(pairs.mismatched),
            MISMATCHED,
            "facing pairs on silhouettes",
        ),
        Gate::at_most(
            "visibility: weighted share",
            pairs.weighted_mismatch,
            WEIGHTED,
            "the same, by form factor × area",
        ),
        Gate::at_most(
            "visibility: explainable share",
            share(pairs.explainable),
            EXPLAINABLE,
            "a wide band would explain anything",
        ),
    ]
}

fn radiosity(e: &Evidence) -> Vec<Gate> {
    let [cpu, gpu] = e.runs.map(|run| run.shots.len() as f64);
    let free = RADIOSITY + 2.0 * e.settings.epsilon;
    vec![
        Gate::at_most(
            "lockstep: relative RMS",
            e.lockstep.relative_rms,
            RADIOSITY,
            "wrong visibility, weighted",
        ),
        Gate::at_most(
            "lockstep: |bias|",
            e.lockstep.bias.abs(),
            RADIOSITY,
            "the same",
        ),
        Gate::at_most(
            "free: relative RMS",
            e.free.relative_rms,
            free,
            "lockstep, and ε unshot on each side",
        ),
        Gate::at_most("free: |bias|", e.free.bias.abs(), free, "the same"),
        Gate::at_most(
            "free: shots apart",
            (cpu - gpu).abs(),
            (SHOTS * cpu).max(2.0),
            "2 % or 2 shots",
        ),
        Gate::at_most(
            "both converged alike",
            f64::from(u8::from(e.runs[0].converged != e.runs[1].converged)),
            0.0,
            "same ε",
        ),
    ]
}

fn energy(e: &Evidence) -> Vec<Gate> {
    let [cpu, gpu] = e.energy;
    let [cpu_escaped, gpu_escaped] = e.energy.map(|energy| energy.share(energy.escaped));
    // In a closed scene nothing escapes; elsewhere the runs' shooters differ as their powers do.
    let escaped = if cpu_escaped <= ESCAPED {
        ESCAPED
    } else {
        2.0 / DIRECTIONS as f64 + RADIOSITY
    };
    vec![
        Gate::at_most(
            "energy imbalance, CPU",
            cpu.imbalance,
            CPU_IMBALANCE,
            "f32 rounding",
        ),
        Gate::at_most(
            "energy imbalance, GPU",
            gpu.imbalance,
            GPU_IMBALANCE,
            "f32 rounding in WGSL",
        ),
        Gate::at_most(
            "escaped, difference",
            (cpu_escaped - gpu_escaped).abs(),
            escaped,
            "0 in a closed scene; else two of 1024 directions, and the bound on radiosity",
        ),
    ]
}
