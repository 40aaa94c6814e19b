//! Content of `stress.html`: verdict, gates, break points, and a section for each case.

use super::methods::ITEM_BUFFER_PIXELS;
use super::summary::{Atlas, AtlasGate, BreakPoint, find_breaks};
use super::{AtlasRow, CaseStudy, ErrorMeasure, SolverSide, Specimen, Verdict, WarningOutcome, format_value};
use crate::report::document::{
    Blocks, Cell, Figure, Row, Section, Table, Text, VerdictTone, bold_text, line_break, link_text, pass_mark,
    plain_text, render_document, styled_text,
};
use crate::report::format::{format_duration, format_percent};
use crate::report::plot::{Axis, CURVE_COLOURS, CURVE_MARKS, LineStyle, Plot, PlotPoint, Series, format_share};
use crate::report::solution_view::RenderedPreview;
use crate::report::view::camera::Camera;
use common::rays::Rays;
use oracle::solve::solver::SolverKind;

/// Most rows of a list.
const MAX_LISTED_ROWS: usize = 200;
/// Range of the charts' errors in units of the two limits; errors beyond are drawn at the ends.
const ERROR_RANGE: [f64; 2] = [5e-3, 100.0];
/// Width of the charts' legend, CSS pixels.
const LEGEND_WIDTH: u32 = 170;

const RANDOM_SCENES_TEXT: &str = "Random scenes, on which nothing was tuned: rooms, convex and not, closed and open, with bodies \
    that stand, hang, float, lean, touch or nearly do, sheets and several lamps; or meshes of many small triangles. Each \
    is solved as by “solve”. “stress random --seed N --count 1” draws the scene of a seed again.";
const CASES_TEXT: &str = "Each case is a family of scenes built to break one method, made harder step by step until it does. \
    Every method answers each of them on both solvers, and is judged by the truth. A result that is not safe needs a \
    warning. The default is “solve” without options.";

/// Returns the page of cases or of random scenes.
pub fn render_page(atlas: &Atlas) -> String {
    let is_random = atlas.studies.iter().any(|study| study.case.is_random());
    let [safe, degraded] = ErrorMeasure::RelativeRms.limits().map(format_percent);
    let [safe_leak, degraded_leak] = ErrorMeasure::Leak
        .limits()
        .map(|limit| ErrorMeasure::Leak.format_error(limit));
    let mut opening = Blocks::default();
    opening
        .add_paragraph(if is_random { RANDOM_SCENES_TEXT } else { CASES_TEXT })
        .add_paragraph(format!(
            "Up to {safe} off is safe, up to {degraded} it degrades, beyond that it fails; of the emitted light \
             {safe_leak} and {degraded_leak} may leak through a wall. Item buffers have {ITEM_BUFFER_PIXELS}² pixels."
        ));
    let broken = atlas.gates.iter().filter(|gate| !gate.held).count();
    let gates = atlas.gates.len();
    match broken {
        _ if atlas.studies.iter().all(|study| study.rows.is_empty()) => {
            opening.add_verdict(VerdictTone::Bad, "Not OK", "nothing was run")
        }
        0 => opening.add_verdict(VerdictTone::Good, "OK", format!("all {gates} gates hold")),
        _ => opening.add_verdict(
            VerdictTone::Bad,
            "Not OK",
            format!("{broken} of {gates} gates do not hold"),
        ),
    };
    let adapter = atlas.adapter.as_deref().unwrap_or("none");
    let ratios = atlas.estimate.map(|ratios| ratios.describe_ratios() + " · ");
    opening.add_remark(format!(
        "The default's errors and warnings: {} · {}GPU: {adapter} · {}",
        atlas.score.describe_counts(),
        ratios.unwrap_or_default(),
        format_duration(atlas.seconds)
    ));
    opening.add_table(gates_table(&atlas.gates));
    for group in ["Solved", "Relit"] {
        add_breaks(&mut opening, group, &atlas.studies);
    }
    let title = match is_random {
        true => "Radiosity: random scenes",
        false => "Radiosity: the failure atlas",
    };
    let sections: Vec<Section> = atlas.studies.iter().map(case_section).collect();
    render_document(title, &opening, &sections, include_str!("style.css"))
}

/// Table of the gates and their violations.
fn gates_table(gates: &[AtlasGate]) -> Table {
    let row = |gate: &AtlasGate| {
        let listed = gate.broken.iter().take(MAX_LISTED_ROWS);
        let lines = listed.fold(plain_text(""), |text, line| text + line + line_break());
        let more = match gate.broken.len().saturating_sub(MAX_LISTED_ROWS) {
            0 => String::new(),
            more => format!("{more} more in stress.json"),
        };
        Row::new([plain_text(gate.name), pass_mark(gate.held), lines + more])
    };
    Table::new("Gate;Holds;~Where it does not", gates.iter().map(row))
}

/// Adds the table of break points of the cases of a group: cases down, methods across.
fn add_breaks(blocks: &mut Blocks, group: &str, studies: &[CaseStudy]) {
    let members = studies.iter().filter(|study| study.case.group == group);
    let members: Vec<&CaseStudy> = members.filter(|study| !study.case.is_random()).collect();
    let mut methods = Vec::new();
    for row in members.iter().flat_map(|study| &study.rows) {
        if !methods.contains(&row.method) {
            methods.push(row.method);
        }
    }
    if methods.is_empty() {
        return;
    }
    let row = |study: &&CaseStudy| {
        let name = link_text(study.case.name, study.case.name) + line_break();
        let name = name + styled_text("facts", study.case.parameter);
        let breaks = find_breaks(study);
        let cells = methods.iter().map(|method| {
            let own = breaks.iter().filter(|point| point.method == *method);
            own.fold(plain_text(""), |all, point| all + break_text(study, point))
        });
        Row::new([name].into_iter().chain(cells))
    };
    let heads = format!("Case;{}", methods.join(";"));
    blocks
        .add_heading(format!("{group}: where each method breaks first"))
        .add_remark(
            plain_text("The first value at which it is not safe: ")
                + verdict_text(Verdict::Safe, "at none")
                + verdict_text(Verdict::Degrades, "degrades at the worst")
                + verdict_text(Verdict::Fails, "fails, or no answer, at the worst")
                + "✖2: not safe at two values without a warning",
        )
        .add_table(Table {
            class: "atlas",
            ..Table::new(&heads, members.iter().map(row))
        });
}

/// Returns a line of text on the colour of a verdict.
fn verdict_text(verdict: Verdict, text: impl Into<Text>) -> Text {
    let (class, sign) = verdict_style(verdict);
    styled_text(class, plain_text(sign) + " " + text) + " "
}

/// Returns the first value at which a method is not safe, on the colour of its worst verdict.
fn break_text(study: &CaseStudy, point: &BreakPoint) -> Text {
    let sides = || study.sides_of(point.method, point.solver).map(|(_, side)| side);
    let worst = sides().map(|side| side.verdict).max().unwrap_or_default();
    let missed = sides().filter(|side| side.outcome == WarningOutcome::Missed).count();
    let first = match point.degrades_at {
        None => "holds".to_owned(),
        at if at == study.rows.first().map(|row| row.value) => "at once".into(),
        Some(at) => format!("at {}", format_value(at)),
    };
    let silent = if missed > 0 {
        format!(" ✖{missed}")
    } else {
        String::new()
    };
    verdict_text(worst, format!("{} {first}{silent}", point.solver.name())) + line_break()
}

/// Returns a verdict's CSS class and sign.
fn verdict_style(verdict: Verdict) -> (&'static str, &'static str) {
    match verdict {
        Verdict::Safe => ("safe", "○"),
        Verdict::Degrades => ("degrades", "◐"),
        Verdict::Fails => ("fails", "●"),
    }
}

/// Returns the section of a case: description, chart, pictures and all results.
fn case_section(study: &CaseStudy) -> Section {
    let case = &study.case;
    let mut body = Blocks::default();
    body.add_table(Table::of_values([
        ("Breaks", case.weakness),
        ("Swept", case.parameter),
        ("Truth", case.truth),
        ("Error", case.measure.name()),
    ]));
    let mut figures = Vec::new();
    if !case.is_random() {
        let caption = "CPU; dashed: GPU. At the upper end: no answer. Point at a mark for details.";
        figures.push(Figure::from_plot(&plot_case(study), "Nothing was run.", caption));
    }
    figures.extend(
        study
            .specimens
            .iter()
            .map(|specimen| draw_scene(case.parameter, specimen)),
    );
    body.add_figure_row(&figures);
    let mut results = Blocks::default();
    results.add_table(results_table(study));
    body.add_details("All results", case.is_random(), results);
    body.into_section(case.name, case.name)
}

fn draw_scene(parameter: &str, specimen: &Specimen) -> Figure {
    let camera = Camera::oblique_view(&specimen.mesh, &Rays::new(&specimen.mesh), 0);
    let preview = RenderedPreview::new(&specimen.scene, &specimen.mesh, &specimen.field, Some(camera));
    let caption = bold_text("The scene") + format!(" at {} ({parameter})", format_value(specimen.value));
    Figure::from_picture(&preview.picture.data_uri(), "the scene, solved", caption)
}

/// Plots error against the swept values in even steps, harder ones to the right.
fn plot_case(study: &CaseStudy) -> Plot {
    let measure = study.case.measure;
    let values = study.swept_values();
    let last = values.len().saturating_sub(1) as f64;
    let [safe, degraded] = measure.limits();
    let label = |error: f64| match measure {
        ErrorMeasure::RelativeRms => format_share(error),
        ErrorMeasure::Leak => format_value(error),
    };
    let x = Axis {
        title: format!("{} → harder", study.case.parameter),
        ends: [-0.2, last + 0.2],
        is_logarithmic: false,
        ticks: (0..values.len()).map(|k| (k as f64, format_value(values[k]))).collect(),
    };
    let y = Axis::logarithmic_scale(
        format!("{} (log)", measure.name()),
        [safe * ERROR_RANGE[0], degraded * ERROR_RANGE[1]],
        label,
    );
    let mut series: Vec<Series> = Vec::new();
    for (k, method) in study.case.methods.iter().enumerate() {
        let colour = k.checked_sub(1).map(|k| CURVE_COLOURS[k % CURVE_COLOURS.len()]);
        let colour = colour.unwrap_or("currentColor");
        for (device, dashes, name) in [(SolverKind::Cpu, None, method.name), (SolverKind::Gpu, Some("6 4"), "")] {
            let sides = study.sides_of(method.name, device);
            let point = |(row, side): (&AtlasRow, &SolverSide)| {
                let at = values.iter().position(|value| *value == row.value);
                PlotPoint {
                    title: mark_title(row, device, side, measure),
                    ..[at.map_or(f64::NAN, |at| at as f64), side.error.unwrap_or(f64::NAN)].into()
                }
            };
            series.push(Series {
                name: name.into(),
                line: Some(LineStyle {
                    dashes,
                    ..LineStyle::with_width(1.8)
                }),
                mark: Some(CURVE_MARKS[k % CURVE_MARKS.len()]),
                colour,
                points: sides.map(point).collect(),
            });
        }
    }
    series.retain(|series| !series.points.is_empty());
    for limit in [safe, degraded] {
        let line = LineStyle {
            dashes: Some("2 4"),
            ..LineStyle::with_width(1.5)
        };
        series.push(Series {
            name: measure.format_error(limit),
            ..Series::through_points("#808080", line, x.ends.map(|x| [x, limit]))
        });
    }
    Plot {
        size: [860, 470],
        axes: [x, y],
        series,
        legend_width: LEGEND_WIDTH,
    }
}

/// Returns the tooltip of a mark.
fn mark_title(row: &AtlasRow, device: SolverKind, side: &SolverSide, measure: ErrorMeasure) -> String {
    let (value, error) = (format_value(row.value), side.format_error(measure));
    let head = format!("{}, {}, at {value}: {error}", row.method, device.name());
    format!("{head}\n{}", told_lines(side)).trim_end().to_owned()
}

/// Returns warnings, notes and error message.
fn told_lines(side: &SolverSide) -> String {
    let lines = side.warnings.iter().chain(&side.notes).chain(&side.message);
    lines.map(String::as_str).collect::<Vec<_>>().join("; ")
}

/// Table of results: one row each, those of the default that were missed marked.
fn results_table(study: &CaseStudy) -> Table {
    let row = |(row, device, side): (&AtlasRow, SolverKind, &SolverSide)| {
        let (class, sign) = verdict_style(side.verdict);
        let outcome = match side.outcome {
            WarningOutcome::Caught => " ▲ warned",
            WarningOutcome::Missed => " ✖ silent",
            WarningOutcome::FalseAlarm => " △ warned",
            WarningOutcome::Quiet => "",
        };
        let error = Cell {
            class,
            ..format!("{sign} {}{outcome}", side.format_error(study.case.measure)).into()
        };
        let scene = row.scene.iter().map(|scene| format!("{scene}; "));
        let cells = [
            format_value(row.value).into(),
            row.method.into(),
            device.name().into(),
            error,
            side.estimate.map_or("–".to_owned(), format_percent).into(),
            format_duration(side.seconds).into(),
            (scene.collect::<String>() + &told_lines(side)).into(),
        ];
        let is_bad = study.is_default(row) && side.outcome == WarningOutcome::Missed;
        Row::new(cells).with_class_if(is_bad, "bad")
    };
    let parameter = study.case.parameter;
    let heads = format!("#{parameter};Method;Solver;#Error;#Estimate;#Time;~Warnings, notes, error message");
    Table::new(&heads, study.sides().map(row))
}
