//! `--dry-run` of `solve` and `shoot`: size, memory and time of a solve.

use super::console::output;
use super::progress::Progress;
use crate::plan::SceneCounts;
use crate::plan::forecast::forecast_solve;
use crate::plan::memory::{adaptive_bytes, check_memory, format_bytes, memory_limit, solve_bytes};
use crate::report::format::{format_count, format_duration};
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use oracle::solve::solver::SolverChoice;
use serde_json::json;
use std::ops::ControlFlow;
use std::time::Instant;

/// Largest factor, either way, between the time and its forecast: of shooting, and of a solve to an error.
const TIME_UNCERTAINTY: [f64; 2] = [3.0, 2.0];
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
    let describe_memory = |least: &str, bytes: u64| {
        let [needed, usable] = [bytes, limit.0].map(format_bytes);
        format!("{least}{needed} ({usable} {})", limit.1)
    };
    let least = if chosen { "at least " } else { "" };
    let mut lines = vec![("size", size), ("memory", describe_memory(least, bytes))];
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
        progress.remove_bar();
        let expected = ahead.seconds;
        let factor = TIME_UNCERTAINTY[usize::from(target.is_some())];
        let range = [expected, expected / factor, expected * factor];
        let (trial, spent) = (&ahead.trial, format_duration(ahead.trial_seconds));
        let time = if ahead.stopped {
            plan["seconds"] = json!({ "least": expected });
            let expected = format_duration(expected);
            format!("more than {expected} ({spent} did not suffice for {trial})")
        } else {
            plan["seconds"] = json!({ "expected": range[0], "least": range[1], "most": range[2] });
            let [expected, least, most] = range.map(format_duration);
            format!("about {expected}, between {least} and {most} ({spent} for {trial})")
        };
        plan["shots"] = ahead.shots.into();
        if let Some([texels, rays]) = ahead.kept {
            let bytes = adaptive_bytes(counts.faces, [texels, rays]);
            (plan["rays"], plan["bytes"]) = (rays.into(), bytes.into());
            if chosen {
                plan["texels"] = texels.into();
                lines[0].1 = format!(
                    "{} faces, about {} texels",
                    format_count(counts.faces),
                    format_count(texels)
                );
            }
            if rays > 0 {
                lines[0].1 += &format!(", about {} rays", format_count(rays));
            }
            lines[1].1 = describe_memory("about ", bytes);
        }
        lines.push(("time", time));
    }
    if in_json {
        let plans = json!({ "scene": scene.name, "faces": scene.faces.len(), "plans": [plan] });
        return output!("{plans}");
    }
    output!("{}, {title}", scene.name)?;
    lines.iter().try_for_each(|(name, text)| output!("  {name:<7} {text}"))
}
