//! Chart of a case: error against the parameter, logarithmic, harder values to the right.

use super::{AtlasRow, CaseStudy, ErrorMeasure, Processor, SolverSide, format_value};
use crate::report::plot::{
    Axis, CURVE_COLOURS, CURVE_MARKS, Legend, LineStyle, MarkShape, MarkStyle, Plot, PlotArea, PlotNote, PlotPoint,
    Series, format_share, logarithmic_ticks,
};

/// Factor from the highest error of the axis to its end, between which missing answers are marked.
const STRIP_FACTOR: f64 = 6.0;
/// Error range of the axis in units of the safe limit; errors beyond are drawn at its ends.
const ERROR_RANGE: [f64; 2] = [1e-5, 1e5];
/// Ends of the parameter's axis; the values lie on 0…1, the limits' names beyond.
const AXIS_ENDS: [f64; 2] = [-0.04, 1.09];
/// Least distance of values on a logarithmic axis, in units of even steps.
const MIN_VALUE_DISTANCE: f64 = 0.25;
/// Least distance of labels on the parameter's axis, as a share of it.
const MIN_TICK_DISTANCE: f64 = 0.085;
/// Distance of two methods' marks of missing answers at one value.
const MISSING_MARK_DISTANCE: f64 = 0.011;

/// Returns colour and mark of method `k` on the CPU; the first has the page's own colour. There is one mark
/// fewer than colours, so no two methods share both; the cross is reserved for missing answers.
pub fn method_series(k: usize, name: &str) -> Series {
    let mut marks = CURVE_MARKS.to_vec();
    marks.retain(|mark| *mark != MarkShape::Cross);
    let colour = k.checked_sub(1).map(|k| CURVE_COLOURS[k % CURVE_COLOURS.len()]);
    let colour = colour.unwrap_or("currentColor");
    Series {
        name: name.to_owned(),
        colour,
        line: Some(LineStyle {
            opacity: 0.4,
            ..LineStyle::with_width(4.5)
        }),
        mark: Some(MarkStyle {
            shape: marks[k % marks.len()],
            radius: 6.0,
            opacity: 0.4,
            outline: Some(colour),
        }),
        points: Vec::new(),
    }
}

/// Returns the chart. `methods` are those of the whole group, which determine
/// the colours.
pub fn plot_case(study: &CaseStudy, methods: &[&'static str]) -> Plot {
    let measure = study.case.measure;
    let limits = measure.limits();
    let values = study.swept_values();
    let places = value_places(&values);
    let mut ticks: Vec<(f64, String)> = Vec::new();
    for (place, value) in places.iter().zip(&values) {
        if ticks.last().is_none_or(|(last, _)| place - last > MIN_TICK_DISTANCE) {
            ticks.push((*place, format_value(*value)));
        }
    }
    let [low, high] = error_range(study);
    let top = high * STRIP_FACTOR;
    let label = |error: f64| match measure {
        ErrorMeasure::RelativeRms => format_share(error),
        ErrorMeasure::Leak => format_value(error),
    };
    let error_ticks = logarithmic_ticks([low, high])
        .into_iter()
        .map(|error| (error, label(error)));
    let x = Axis {
        title: format!("{} → harder", study.case.parameter),
        ends: AXIS_ENDS,
        is_logarithmic: false,
        ticks,
    };
    let y = Axis {
        title: format!("{} (log)", measure.name()),
        ends: [low, top],
        is_logarithmic: true,
        ticks: error_ticks
            .chain([(high * STRIP_FACTOR.sqrt(), "no answer".into())])
            .collect(),
    };
    let zone = |y: [f64; 2], colour, opacity| PlotArea {
        x: [f64::NEG_INFINITY, f64::INFINITY],
        y,
        colour,
        opacity,
    };
    let across = |error: f64, width: f64, dashes: Option<&'static str>| {
        let line = LineStyle {
            dashes,
            ..LineStyle::with_width(width)
        };
        Series::through_points("currentColor", line, AXIS_ENDS.map(|x| [x, error]))
    };
    let mut series = vec![
        across(limits[0], 1.2, None),
        across(limits[1], 1.2, None),
        across(high, 1.0, Some("2 4")),
    ];
    // The first method is drawn last, over the others; of each method the GPU over the CPU.
    for (k, method) in methods.iter().enumerate().rev() {
        for processor in Processor::BOTH {
            let rows = study.rows.iter().filter(|row| row.method == *method);
            let sides = rows.filter_map(|row| Some((row, row.side_on(processor)?)));
            let points: Vec<(bool, PlotPoint)> = sides
                .map(|(row, side)| {
                    let place = values
                        .iter()
                        .position(|value| *value == row.value)
                        .map_or(0.5, |at| places[at]);
                    let missing = (k as f64 - methods.len() as f64 / 2.0) * MISSING_MARK_DISTANCE;
                    let strip = if processor == Processor::Cpu { 0.7 } else { 0.3 };
                    let at = match side.error {
                        Some(error) => [place, if error.is_nan() { high } else { error.clamp(low, high) }],
                        None => [place + missing, high * STRIP_FACTOR.powf(strip)],
                    };
                    let point = PlotPoint {
                        title: mark_tooltip(row, processor, side, measure),
                        is_hollow: side.is_warned(),
                        ..at.into()
                    };
                    (side.error.is_some(), point)
                })
                .collect();
            series.extend(method_curves(method_series(k, method), processor, &points));
        }
    }
    let note = |limit: f64| PlotNote {
        at: [AXIS_ENDS[1], limit],
        shift: [-4.0, -4.0],
        anchor: "end",
        text: measure.format_error(limit),
    };
    Plot {
        size: [860, 470],
        axes: [x, y],
        areas: vec![
            zone(limits, "#e69f00", 0.09),
            zone([limits[1], f64::INFINITY], "#d55e00", 0.13),
        ],
        series,
        notes: limits.map(note).into(),
        legend: Legend::CurveEnds(156),
    }
}

/// Returns the curves of a method on one processor, interrupted at values without an answer, which are marked
/// by crosses. The last curve on the CPU carries the name; without one the GPU's crosses do.
fn method_curves(style: Series, processor: Processor, points: &[(bool, PlotPoint)]) -> Vec<Series> {
    let mark = |radius, opacity| {
        style.mark.map(|mark| MarkStyle {
            radius,
            opacity,
            ..mark
        })
    };
    let style = match processor {
        Processor::Cpu => style,
        // A thin dashed line over a broad one: both are visible where they agree.
        Processor::Gpu => Series {
            name: String::new(),
            line: Some(LineStyle {
                dashes: Some("6 4"),
                ..LineStyle::with_width(1.8)
            }),
            mark: mark(3.2, 1.0),
            ..style.clone()
        },
    };
    let curve = |points: &[(bool, PlotPoint)]| Series {
        name: String::new(),
        points: points.iter().map(|(_, point)| point.clone()).collect(),
        ..style.clone()
    };
    let parts = points.split(|(answered, _)| !answered).filter(|part| !part.is_empty());
    let mut curves: Vec<Series> = parts.map(curve).collect();
    let missing: Vec<_> = points.iter().filter(|(answered, _)| !answered).cloned().collect();
    curves.insert(
        0,
        Series {
            line: None,
            mark: style.mark.map(|mark| MarkStyle {
                shape: MarkShape::Cross,
                radius: 4.5,
                opacity: 1.0,
                ..mark
            }),
            ..curve(&missing)
        },
    );
    if let Some(last) = curves.last_mut() {
        last.name = style.name;
    }
    curves
}

/// Maps the values to 0…1: logarithmically, or in even steps if some would be too close.
fn value_places(values: &[f64]) -> Vec<f64> {
    let [Some(a), Some(b)] = [values.first(), values.last()] else {
        return Vec::new();
    };
    if a == b {
        return vec![0.5; values.len()];
    }
    let step = 1.0 / (values.len() - 1) as f64;
    let places: Vec<f64> = values.iter().map(|v| (v / a).ln() / (b / a).ln()).collect();
    // A value of 0 or out of order makes a step that is not a number, or negative.
    if places.windows(2).all(|w| w[1] - w[0] >= MIN_VALUE_DISTANCE * step) {
        return places;
    }
    (0..values.len()).map(|k| k as f64 * step).collect()
}

/// Returns the error range of the axis: all errors and both limits, with a margin.
fn error_range(study: &CaseStudy) -> [f64; 2] {
    let [safe, degraded] = study.case.measure.limits();
    let errors = study.sides().filter_map(|(_, _, side)| side.error);
    let errors = errors.filter(|error| error.is_finite() && *error > 0.0);
    let [low, high] = errors.fold([safe / 3.0, degraded * 3.0], |[low, high], error| {
        [low.min(error * 0.6), high.max(error * 1.7)]
    });
    [low.max(ERROR_RANGE[0] * safe), high.min(ERROR_RANGE[1] * safe)]
}

/// Returns the tooltip of a mark.
fn mark_tooltip(row: &AtlasRow, processor: Processor, side: &SolverSide, measure: ErrorMeasure) -> String {
    let (value, error) = (format_value(row.value), side.format_error(measure));
    let head = format!("{}, {}, at {value}: {error}", row.method, processor.name());
    let warned = (!side.warnings.is_empty()).then(|| format!("warned: {}", side.warnings.join(", ")));
    let lines = [head]
        .into_iter()
        .chain(warned)
        .chain(side.notes.iter().chain(&side.message).cloned());
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{make_row, make_side, make_study};
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn methods_differ_in_colour_or_mark() {
        let looks: Vec<_> = (0..2 * CURVE_COLOURS.len())
            .map(|k| method_series(k, ""))
            .map(|series| (series.colour, series.mark.unwrap().shape))
            .collect();
        for (k, look) in looks.iter().enumerate() {
            assert!(!looks[..k].contains(look), "{k}: {look:?}");
            assert_ne!(look.1, MarkShape::Cross);
        }
    }

    #[test]
    fn harder_values_lie_to_the_right_in_either_order() {
        for (values, places) in [
            (&[1.0, 0.1, 0.001][..], &[0.0, 1.0 / 3.0, 1.0][..]),
            (&[1.0, 10.0, 100.0], &[0.0, 0.5, 1.0]),
            (&[0.0, 10.0, 15.0], &[0.0, 0.5, 1.0]),
            (&[1.0, 1e3, 1e-3], &[0.0, 0.5, 1.0]),
            (&[0.01, 0.1, 0.5, 0.9, 0.99], &[0.0, 0.25, 0.5, 0.75, 1.0]),
            (&[0.3, 0.1, 0.0], &[0.0, 0.5, 1.0]),
            (&[7.0], &[0.5]),
            (&[], &[]),
        ] {
            let found = value_places(values);
            assert_eq!(found.len(), places.len());
            let near = found
                .iter()
                .zip(places)
                .all(|(a, b)| abs_diff_eq!(a, b, epsilon = 1e-12));
            assert!(near, "{found:?} instead of {places:?}");
        }
    }

    #[test]
    fn missing_and_nan_errors_are_drawn() {
        let rows = vec![
            make_row(0.1, make_side(Some(0.0), ""), None),
            make_row(0.01, make_side(None, ""), Some(make_side(Some(1e9), "thin"))),
            make_row(0.001, make_side(Some(f64::NAN), ""), Some(make_side(None, ""))),
        ];
        let svg = plot_case(&make_study(rows), &["default", "not run"])
            .render_svg()
            .unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<g class=\"mark\">").count(), 5);
        assert_eq!(
            svg.matches("</text>").count() - svg.replace(">default</text>", "").matches("</text>").count(),
            1
        );
        // Two refusals and a warning.
        assert_eq!(svg.matches("fill=\"var(--card)\"").count(), 3);
        let nothing = vec![make_row(0.1, make_side(None, ""), None)];
        assert!(plot_case(&make_study(nothing), &["default"]).render_svg().is_some());
    }
}
