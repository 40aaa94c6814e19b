//! `--dry-run` of `solve` and `shoot`: size, memory and time of a solve.

use super::console::output;
use super::progress::Progress;
use crate::plan::SceneCounts;
use crate::plan::forecast::forecast_solve;
use crate::plan::memory::{check_memory, format_bytes, memory_limit, solve_bytes};
use crate::report::format::{format_count, format_duration};
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use oracle::solve::solver::SolverChoice;
use serde_json::json;
use std::ops::ControlFlow;
use std::time::Instant;

/// Largest factor, either way, between the time and its forecast.
const TIME_UNCERTAINTY: f64 = 3.0;
/// Seconds after which the cheaper solve of a forecast is stopped.
const MAX_TRIAL_SECONDS: f64 = 20.0;

/// Prints the plan of a solve, as lines or as one line of JSON.
///
/// Errors: those of the forecast.
pub fn print_plan(scene: &Scene, settings: &Settings, solver: SolverChoice, in_json: bool) -> Result<()> {
    let (adapter, target) = (solver.adapter_name(), solver.error_target());
    // Texels that follow from the light are known only after the solve.
    let chosen = target.is_some_and(|target| target.texels.is_none());
    let counts = SceneCounts::new(scene, &settings.meshing);
    let bytes = solve_bytes(scene, settings, solver);
    let limit = memory_limit(solver);
    let mut plan = json!({
        "solver": solver.name(),
        "adapter": adapter,
        "error": target.map(|target| target.error),
        "texels": (!chosen).then_some(counts.texels),
        "bytes": bytes,
    });
    let device = adapter.map_or("CPU".into(), |name| format!("GPU, {name}"));
    let title = match (solver, target) {
        (SolverChoice::Dense, _) => "dense system".into(),
        (_, Some(target)) => format!("{device}, to {} %", 100.0 * target.error),
        (_, None) => device,
    };
    let mut size = format!("{} faces, ", format_count(counts.faces));
    size += &match chosen {
        true => "texels chosen by the solve".into(),
        false => format!("{} texels", format_count(counts.texels)),
    };
    if solver.is_shooting() {
        (plan["cells"], plan["links"]) = (counts.patches.into(), counts.link_count().into());
        plan["samples"] = counts.samples.into();
        let [patches, links] = [counts.patches, counts.link_count()].map(format_count);
        size += &format!(", {patches} patches; {links} links of {} samples", counts.samples);
    }
    let least = if chosen { "at least " } else { "" };
    let [needed, usable] = [bytes, limit.0].map(format_bytes);
    let memory = format!("{least}{needed} ({usable} {})", limit.1);
    let mut lines = vec![("size", size), ("memory", memory)];
    if let Err(error) = check_memory(scene, settings, solver, limit) {
        plan["refused"] = error.to_string().into();
        lines.push(("refused", error.to_string()));
    } else if !matches!(solver, SolverChoice::Dense) {
        let progress = Progress::new("plan");
        let start = Instant::now();
        let show = |phase: &str, done| match start.elapsed().as_secs_f64() > MAX_TRIAL_SECONDS {
            true => ControlFlow::Break(()),
            false => progress.show_phase(phase, done),
        };
        let ahead = forecast_solve(scene, settings, solver, &show)?;
        progress.clear();
        let expected = ahead.trial_seconds * ahead.work_ratio;
        let range = [expected, expected / TIME_UNCERTAINTY, expected * TIME_UNCERTAINTY];
        let (trial, spent) = (&ahead.trial, format_duration(ahead.trial_seconds));
        let time = if ahead.stopped {
            plan["seconds"] = json!({ "least": expected });
            let expected = format_duration(expected);
            format!("more than {expected} (a solve {trial} was not done in {spent})")
        } else {
            plan["seconds"] = json!({ "expected": range[0], "least": range[1], "most": range[2] });
            let [expected, least, most] = range.map(format_duration);
            format!("about {expected}, between {least} and {most} (a solve {trial} took {spent})")
        };
        plan["shots"] = ahead.shots.into();
        lines.push(("time", time));
    }
    if in_json {
        let plans = json!({ "scene": scene.name, "faces": scene.faces.len(), "plans": [plan] });
        return output!("{plans}");
    }
    output!("{}, {title}", scene.name)?;
    lines.iter().try_for_each(|(name, text)| output!("  {name:<7} {text}"))
}
