//! A point in words.

use super::Measurement;
use super::study::Point;
use crate::plan::fits::size;
use crate::show::number::{count, duration, percent};

/// Letters of a label at most.
const LABEL: usize = 38;

/// A point's name on the chart.
pub fn short(point: &Point) -> String {
    let text = format!(
        "{} {}",
        point.method.solver.name(),
        point.method.options.replace("--", "")
    );
    if text.chars().count() <= LABEL {
        text
    } else {
        text.chars().take(LABEL - 1).chain(['…']).collect()
    }
}

/// Seconds with their spread.
fn seconds(point: &Point) -> String {
    let [median, least, most] = point.spread(Measurement::seconds);
    match point.runs.len() {
        1 => duration(median),
        n => format!(
            "{} ({} – {}, {n} runs)",
            duration(median),
            duration(least),
            duration(most)
        ),
    }
}

/// What pointing at a mark tells.
pub fn about(point: &Point) -> String {
    let mut lines = vec![format!(
        "{} {}",
        point.method.solver.name(),
        point.method.options
    )];
    match (point.figures(), point.failure()) {
        (Some(figures), _) => {
            let (error, bias) = (percent(figures.error), percent(figures.bias));
            lines.push(format!("{}, error {error}, bias {bias}", seconds(point)));
            lines.push(format!(
                "{} shots in {} passes{}, {}",
                count(figures.shots),
                count(figures.passes.into()),
                if figures.one_by_one {
                    " (one by one)"
                } else {
                    ""
                },
                size(point.bytes)
            ));
        }
        (None, failure) => lines.push(format!(
            "failed after {}: {}",
            seconds(point),
            failure.unwrap_or_default()
        )),
    }
    let settings = serde_json::to_value(point.method.settings).unwrap_or_default();
    let words = settings.as_object().into_iter().flatten();
    let words = words.filter(|(name, _)| !["quality", "max-shots"].contains(&name.as_str()));
    let words: Vec<String> = words
        .map(|(name, value)| format!("{name} {}", value.to_string().trim_matches('"')))
        .collect();
    lines.push(words.join(", "));
    lines.join("\n")
}
