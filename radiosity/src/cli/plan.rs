//! `--dry-run` of `solve` and `shoot`: size, memory and time of a solve.

use super::console::{output, print_json};
use super::progress::Progress;
use crate::plan::SceneCounts;
use crate::plan::forecast::forecast_solve;
use crate::plan::memory::{MemoryLimit, SolveMemory, check_memory, format_bytes};
use crate::report::format::{format_count, format_number};
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use cpu::dense::memory::{MAX_MATRIX_BYTES, matrix_bytes};
use oracle::solve::solver::SolverChoice;
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::time::Instant;

/// Largest factor, either way, between the time and its forecast.
const TIME_UNCERTAINTY: f64 = 3.0;
/// Seconds after which the cheaper solve of a forecast is stopped.
const MAX_TRIAL_SECONDS: f64 = 20.0;

/// Plan of a solve, for people and for programs.
struct SolvePlan {
    title: String,
    lines: Vec<(&'static str, String)>,
    json: Value,
}

/// Prints the plan of a solve, as lines or as one line of JSON; `note` tells why the settings are not those asked for.
///
/// Errors: those of the forecast.
pub fn print_plan(
    scene: &Scene,
    settings: &Settings,
    solver: SolverChoice,
    note: Option<&str>,
    [json, quiet]: [bool; 2],
) -> Result<()> {
    let mut plan = SolvePlan::new(scene, settings, solver);
    if let Some(note) = note {
        plan.json["note"] = note.into();
        plan.lines.push(("note", note.to_owned()));
    }
    if let Err(error) = check_memory(scene, settings, solver, MemoryLimit::of_this_machine()) {
        plan.json["refused"] = error.to_string().into();
        plan.lines.push(("refused", error.to_string()));
    } else if !matches!(solver, SolverChoice::Dense) {
        plan.add_time(scene, settings, solver, quiet)?;
    }
    if json {
        return print_json(&json!({ "scene": scene.name, "faces": scene.faces.len(), "plans": [plan.json] }));
    }
    output!("{}, {}", scene.name, plan.title)?;
    let mut lines = plan.lines.iter();
    lines.try_for_each(|(name, text)| output!("  {name:<7} {text}"))
}

impl SolvePlan {
    /// Makes a plan of size and memory.
    fn new(scene: &Scene, settings: &Settings, solver: SolverChoice) -> Self {
        let counts = SceneCounts::new(scene, &settings.meshing);
        let (faces, texels) = (format_count(counts.faces), format_count(counts.texels));
        let adapter = solver.adapter_name();
        let device = adapter.map_or("CPU".into(), |name| format!("GPU, {name}"));
        let mut json = json!({ "solver": solver.name(), "adapter": adapter, "texels": counts.texels });
        if let Some(target) = solver.error_target() {
            json["error"] = target.error.into();
            json["texels"] = target.texels.into();
            let each = match target.texels {
                Some(side) => format!("{side}×{side} texels each"),
                None => "texels chosen by the solve".into(),
            };
            return Self {
                title: format!("{device}, to {} %", 100.0 * target.error),
                lines: vec![("size", format!("{faces} faces, {each}"))],
                json,
            };
        }
        if let SolverChoice::Dense = solver {
            let bytes = matrix_bytes(counts.texels);
            json["bytes"] = bytes.into();
            let [needed, allowed] = [bytes, MAX_MATRIX_BYTES].map(format_bytes);
            return Self {
                title: "dense system".into(),
                lines: vec![
                    ("size", format!("{faces} faces, {texels} texels")),
                    ("memory", format!("{needed} ({allowed} are allowed)")),
                ],
                json,
            };
        }
        let memory = SolveMemory::new(&counts, settings, solver.gpu());
        let limit = MemoryLimit::of_this_machine();
        json["cells"] = counts.patches.into();
        json["links"] = counts.link_count().into();
        json["samples"] = counts.samples.into();
        json["bytes"] = memory.peak_bytes().into();
        let [patches, links] = [counts.patches, counts.link_count()].map(format_count);
        let [peak, of_links, usable] = [memory.peak_bytes(), memory.links, limit.bytes].map(format_bytes);
        let samples = counts.samples;
        Self {
            title: device,
            lines: vec![
                (
                    "size",
                    format!("{faces} faces, {texels} texels, {patches} patches; {links} links of {samples} samples"),
                ),
                (
                    "memory",
                    format!("{peak}, {of_links} at most for links ({usable} {})", limit.source),
                ),
            ],
            json,
        }
    }

    /// Adds passes, if it shoots, and time.
    fn add_time(&mut self, scene: &Scene, settings: &Settings, solver: SolverChoice, quiet: bool) -> Result<()> {
        let progress = Progress::new("plan", quiet);
        let start = Instant::now();
        let show = |phase: &str, done| match start.elapsed().as_secs_f64() > MAX_TRIAL_SECONDS {
            true => ControlFlow::Break(()),
            false => progress.show_phase(phase, done),
        };
        let ahead = forecast_solve(scene, settings, solver, &show)?;
        progress.clear();
        if let Some([passes, shots]) = ahead.passes {
            self.json["passes"] = passes.into();
            self.json["shots"] = shots.into();
            let [passes, shots] = [passes, shots].map(|count| format_count(count.round() as u64));
            let iteration = format!("{:?}", settings.schedule.iteration).to_lowercase();
            let text = format!("about {passes} by {iteration} with {shots} shots");
            self.lines.push(("passes", text));
        }
        let expected = ahead.trial_seconds * ahead.work_ratio;
        let (least, most) = (expected / TIME_UNCERTAINTY, expected * TIME_UNCERTAINTY);
        let (trial, spent) = (&ahead.trial, format_duration(ahead.trial_seconds));
        let text = if ahead.stopped {
            self.json["seconds"] = json!({ "least": expected });
            format!(
                "more than {} (a solve {trial} was not done in {spent})",
                format_duration(expected)
            )
        } else {
            self.json["seconds"] = json!({ "expected": expected, "least": least, "most": most });
            let [expected, least, most] = [expected, least, most].map(format_duration);
            format!("about {expected}, between {least} and {most} (a solve {trial} took {spent})")
        };
        self.lines.push(("time", text));
        Ok(())
    }
}

/// Formats a time with two digits in seconds, minutes, hours or days.
fn format_duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 120.0 => (s, "seconds"),
        s if s < 7200.0 => (s / 60.0, "minutes"),
        s if s < 172_800.0 => (s / 3600.0, "hours"),
        s => (s / 86_400.0, "days"),
    };
    let scale = 10f64.powf(value.log10().floor() - 1.0);
    let rounded = (value / scale).round() * scale;
    format!(
        "{} {unit}",
        format_number(if rounded.is_finite() { rounded } else { value })
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duration_has_two_digits_and_a_unit_for_people() {
        let texts = [0.0, 64.0, 1234.0, 13_000.0, 1e7].map(format_duration);
        assert_eq!(
            texts,
            ["0 seconds", "64 seconds", "21 minutes", "3.6 hours", "120 days"]
        );
    }
}
