//! Numbers of a run's results.
//!
//! ```text
//! error                  relative RMS error of a diff, of the worst channel
//! share of PART          a part of the energy balance over the emitted energy
//! irradiance of FACE     mean over a face, W/m², of the first channel; also: radiosity
//! /a/b/0                 the value at this JSON pointer of result.json
//! /a/b/0 %               the same, as a percentage
//! ```

use crate::Result;
use crate::runs::FinishedRuns;
use common::solution::read::StoredSolution;
use serde_json::Value;

/// Digits of a number that is not whole.
const NUMBER_DIGITS: usize = 4;
/// Digits of a percentage.
const PERCENT_DIGITS: usize = 3;

/// Returns a number of a run as text.
///
/// Errors: the results have no such number.
pub fn read_number(runs: &FinishedRuns, run: &str, quantity: &[&str]) -> Result<String> {
    let missing = || format!("{run} has no number {}", quantity.join(" "));
    match quantity {
        ["error"] => {
            let channels = &read_json(runs, run, "diff.json")?["relative_rms"];
            let channels = channels.as_array().ok_or_else(missing)?;
            let worst = channels.iter().filter_map(Value::as_f64).fold(0.0, f64::max);
            Ok(format_percentage(worst))
        }
        ["share", "of", part] => {
            let energy = &read_json(runs, run, "result.json")?["energy"];
            let sum = |part: &str| Some(energy[part].as_array()?.iter().filter_map(Value::as_f64).sum::<f64>());
            let (own, all) = sum(part).zip(sum("emitted")).ok_or_else(missing)?;
            Ok(format_percentage(own / all))
        }
        [channel, "of", face] => {
            let solution = StoredSolution::read(&runs.folder_of(run)?).map_err(|error| error.to_string())?;
            Ok(format_number(
                mean_of_face(&solution, channel, face).ok_or_else(missing)?,
            ))
        }
        [pointer, rest @ ..] => {
            let result = read_json(runs, run, "result.json")?;
            let value = result.pointer(pointer).and_then(Value::as_f64).ok_or_else(missing)?;
            match rest {
                ["%"] => Ok(format_percentage(value)),
                [] => Ok(format_number(value)),
                _ => Err(missing()),
            }
        }
        [] => Err(missing()),
    }
}

/// Returns the number of shots of a run.
pub fn count_shots(runs: &FinishedRuns, run: &str) -> Result<u64> {
    let shots = read_json(runs, run, "result.json")?["shots"].as_u64();
    shots.ok_or_else(|| format!("{run} has no shots"))
}

fn read_json(runs: &FinishedRuns, run: &str, file: &str) -> Result<Value> {
    serde_json::from_slice(&runs.read_file(run, file)?).map_err(|error| format!("{file} of {run}: {error}"))
}

/// Returns the mean of a channel over the texels of a face, the first of this name; all its texels have the same area.
fn mean_of_face(solution: &StoredSolution, channel: &str, face: &str) -> Option<f64> {
    let values = match channel {
        "radiosity" => &solution.radiosity,
        _ => solution.others.get(channel)?,
    };
    let k = solution.scene.faces.iter().position(|own| own.name == face)?;
    let texels = &values[solution.texel_range(k)];
    Some(texels.iter().map(|value| f64::from(value.x)).sum::<f64>() / texels.len() as f64)
}

/// Formats a number: a whole one with all its digits, else with four.
fn format_number(value: f64) -> String {
    match value.fract() == 0.0 {
        true => format!("{value:.0}"),
        false => format_digits(value, NUMBER_DIGITS),
    }
    .replace('-', "−")
}

/// Formats a share as a percentage.
fn format_percentage(share: f64) -> String {
    let digits = format_digits(100.0 * share, PERCENT_DIGITS);
    let short = digits.trim_end_matches('0').trim_end_matches('.');
    format!("{} %", if digits.contains('.') { short } else { &digits }).replace('-', "−")
}

/// Formats a value with so many significant digits.
fn format_digits(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let whole = value.abs().log10().floor() as i32 + 1;
    let decimals = (digits as i32 - whole).max(0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_significant_digits() {
        let numbers = [418.0, 0.200_297_3, 1.998_19, 0.0, 12345.6, -0.001_308].map(format_number);
        assert_eq!(numbers, ["418", "0.2003", "1.998", "0", "12346", "−0.001308"]);
        let shares = [0.916_666, 0.000_905, 1.0, 0.004_618, -0.042, 0.0].map(format_percentage);
        assert_eq!(shares, ["91.7 %", "0.0905 %", "100 %", "0.462 %", "−4.2 %", "0 %"]);
    }
}
