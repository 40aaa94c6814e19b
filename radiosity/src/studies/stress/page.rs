//! Content of `stress.html`.

use super::chart::{method_series, plot_case};
use super::methods::ITEM_BUFFER_PIXELS;
use super::summary::{self, Atlas, AtlasGate, CodeCount, HIGH_RATIO, LOW_RATIO, MIN_JUDGED_ERROR, WarningCounts};
use super::{
    AtlasRow, CaseStudy, ErrorMeasure, Processor, SolverSide, Verdict, WarningOutcome, format_value, specimen,
};
use crate::report::document::{
    Blocks, Cell, Document, Figure, Row, Section, Table, Text, VerdictTone, bold_text, code_text, line_break,
    link_text, pass_mark, plain_text, series_key, styled_text,
};
use crate::report::format::{format_duration, format_number, format_percent};
use crate::report::plot::{
    Axis, CPU_COLOUR, GPU_COLOUR, Legend, LineStyle, MarkShape, MarkStyle, Plot, PlotPoint, Series, format_share,
};

/// Most rows of a list.
const MAX_LISTED_ROWS: usize = 200;
/// Range of both axes of the chart of estimates; errors beyond are drawn at the ends.
const ESTIMATE_ENDS: [f64; 2] = [1e-4, 1.0];

/// Returns the page of cases or of random scenes.
pub fn render_page(atlas: &Atlas) -> String {
    let mut opening = Blocks::default();
    opening.add_paragraph(introduction(atlas));
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
    opening.add_remark(format!("GPU: {adapter} · {}", format_duration(atlas.seconds)));
    opening
        .add_table(gates_table(&atlas.gates))
        .add_table(scores_table(atlas));
    if !atlas.score.codes.is_empty() {
        opening.add_table(codes_table(atlas));
    }
    let mut sections = Vec::new();
    if atlas.estimate.is_some() {
        sections.extend(random_sections(atlas));
    } else {
        add_break_tables(&mut opening, &atlas.studies);
        sections.extend(
            atlas
                .studies
                .iter()
                .enumerate()
                .map(|(k, study)| case_section(k, study, &atlas.studies)),
        );
    }
    let document = Document {
        title: match atlas.estimate {
            Some(_) => "Radiosity: random scenes",
            None => "Radiosity: the failure atlas",
        },
        opening,
        sections,
        style: include_str!("style.css"),
    };
    document.to_html()
}

fn introduction(atlas: &Atlas) -> Text {
    if let (Some(_), Some(study)) = (atlas.estimate, atlas.studies.first()) {
        return plain_text(
            "Random rooms, on which nothing was tuned: convex and not, closed and open, with bodies that ",
        ) + "stand, hang, float, lean, touch or nearly do, sheets and several lamps. Each is solved as "
            + code_text("solve")
            + format!(
                " does without options and judged by {}. The scene of a seed is drawn again by ",
                study.case.truth
            )
            + code_text("stress random --seed N --count 1")
            + ".";
    }
    let limits = |measure: ErrorMeasure| measure.limits().map(|limit| measure.format_error(limit));
    let [safe, degraded] = limits(ErrorMeasure::RelativeRms);
    let [safe_leak, degraded_leak] = limits(ErrorMeasure::Leak);
    plain_text("Each case is a family of scenes built to break one method, made harder step by step until it does. ")
        + "Every method answers each of them on both solvers, and is judged by the truth: "
        + format!("up to {safe} off it is safe, up to {degraded} it degrades, beyond that it fails; ")
        + format!("of the emitted light {safe_leak} and {degraded_leak} may leak through a wall. ")
        + "A result that is not safe needs a warning. The default is "
        + code_text("solve")
        + format!(" without options; item buffers have {ITEM_BUFFER_PIXELS}² pixels, in the default as well.")
}

/// Table of the gates and their violations.
fn gates_table(gates: &[AtlasGate]) -> Table {
    let row = |gate: &AtlasGate| {
        let listed = gate.broken.iter().take(MAX_LISTED_ROWS);
        let lines = listed.fold(plain_text(""), |text, line| text + line + line_break());
        let more = gate.broken.len().saturating_sub(MAX_LISTED_ROWS);
        let lines = if more > 0 {
            lines + format!("{more} more in stress.json")
        } else {
            lines
        };
        Row::new([plain_text(gate.name), pass_mark(gate.held), lines])
    };
    Table::new(&["Gate", "Holds", "~Where it does not"], gates.iter().map(row))
}

fn scores_table(atlas: &Atlas) -> Table {
    let row = |(name, counts): (&str, &WarningCounts)| {
        let WarningCounts {
            caught,
            missed,
            false_alarms,
            quiet,
        } = counts;
        let share = format_percent(counts.false_alarm_share());
        let alarms = format!("{false_alarms} ({share})");
        Row::new([
            name.to_owned(),
            caught.to_string(),
            missed.to_string(),
            alarms,
            quiet.to_string(),
        ])
    };
    let heads = [
        "Results of",
        "#Caught|not safe, warned",
        "#Missed|not safe, silent",
        "#False alarms|safe, warned",
        "#Quiet|safe, silent",
    ];
    Table::new(
        &heads,
        [("the default", &atlas.score.default), ("all methods", &atlas.score.all)].map(row),
    )
}

/// Adds a table of break points for each group of cases: cases down, methods across.
fn add_break_tables(blocks: &mut Blocks, studies: &[CaseStudy]) {
    let box_of = |verdict| {
        let (class, sign) = verdict_style(verdict);
        styled_text(class, format!(" {sign} "))
    };
    blocks.add_heading("Where each method breaks first").add_paragraph(
        box_of(Verdict::Safe)
            + " safe at every value · "
            + box_of(Verdict::Degrades)
            + " degrades at the worst value · "
            + box_of(Verdict::Fails)
            + " fails, or no answer, at the worst · “at 0.1”: the first value at which it is not safe; “at once”: the \
               easiest already; “holds”: nowhere · ▲3: not safe at three values, and warned or refused · "
            + styled_text("missed", "✖2")
            + ": not safe at two, unwarned · △1: warned once, but safe",
    );
    for group in ["Solved", "Relit"] {
        let members = || {
            studies
                .iter()
                .enumerate()
                .filter(|(_, study)| study.case.group == group)
        };
        let methods = method_names(studies, group);
        if !methods.is_empty() {
            blocks.add_table(breaks_table(group, &methods, &members().collect::<Vec<_>>()));
        }
    }
}

fn breaks_table(group: &str, methods: &[&'static str], members: &[(usize, &CaseStudy)]) -> Table {
    let has_sides = |method: &str, solver: Processor| {
        let mut sides = members.iter().flat_map(|(_, study)| study.sides());
        sides.any(|(row, processor, _)| row.method == method && processor == solver)
    };
    let mut columns = Vec::new();
    let mut top = vec![Cell::from(bold_text(group))];
    for (k, method) in methods.iter().enumerate() {
        let solvers = Processor::BOTH.into_iter().filter(|solver| has_sides(method, *solver));
        let first = columns.len();
        columns.extend(solvers.map(|solver| (*method, solver)));
        top.push(Cell {
            columns: columns.len() - first,
            ..series_key(&method_series(k, method)).into()
        });
    }
    let row = |(k, study): &(usize, &CaseStudy)| {
        let name = link_text(case_anchor(*k), study.case.name) + line_break();
        let name = name + styled_text("facts", study.case.parameter);
        let cells = columns
            .iter()
            .map(|(method, solver)| break_cell(study, method, *solver));
        Row::new([Cell::from(name)].into_iter().chain(cells))
    };
    let solvers = columns.iter().map(|(_, solver)| solver.name().to_owned());
    Table {
        class: "atlas",
        top: Some(Row::new(top)),
        heads: ["Case".to_owned()].into_iter().chain(solvers).collect(),
        rows: members.iter().map(row).collect(),
    }
}

/// Makes the cell of the first value at which a method is not safe.
fn break_cell(study: &CaseStudy, method: &str, solver: Processor) -> Cell {
    let own = |(row, processor, _): &(&AtlasRow, Processor, &SolverSide)| row.method == method && *processor == solver;
    let sides: Vec<&SolverSide> = study.sides().filter(own).map(|(_, _, side)| side).collect();
    let breaks = summary::find_breaks(study);
    let breaks = breaks
        .iter()
        .find(|point| point.method == method && point.solver == solver);
    let (Some(point), Some(worst)) = (breaks, sides.iter().map(|side| side.verdict).max()) else {
        return Cell::from("n/a");
    };
    let first = match point.degrades_at {
        None => "holds".to_owned(),
        at if at == study.rows.first().map(|row| row.value) => "at once".into(),
        Some(at) => format!("at {}", format_value(at)),
    };
    let counts = WarningCounts::of_outcomes(sides.iter().copied());
    let (class, sign) = verdict_style(worst);
    let count = |mark: &str, n: usize| if n > 0 { format!(" {mark}{n}") } else { String::new() };
    let text = bold_text(first) + line_break() + sign + count("▲", counts.caught);
    let text = match counts.missed {
        0 => text,
        n => text + " " + styled_text("missed", format!("✖{n}")),
    };
    let [safe, degraded] = study
        .case
        .measure
        .limits()
        .map(|limit| study.case.measure.format_error(limit));
    let at = |value: Option<f64>| value.map_or("nowhere".into(), format_value);
    Cell {
        class,
        title: format!(
            "{}, {method}, {}: beyond {safe} at {}, beyond {degraded} at {}",
            study.case.name,
            solver.name(),
            at(point.degrades_at),
            at(point.fails_at)
        ),
        ..(text + count("△", counts.false_alarms)).into()
    }
}

/// Returns a verdict's CSS class and sign.
fn verdict_style(verdict: Verdict) -> (&'static str, &'static str) {
    match verdict {
        Verdict::Safe => ("safe", "○"),
        Verdict::Degrades => ("degrades", "◐"),
        Verdict::Fails => ("fails", "●"),
    }
}

/// Returns the names of the methods of a group, whose order determines their colours.
fn method_names(studies: &[CaseStudy], group: &str) -> Vec<&'static str> {
    let mut names = Vec::new();
    for row in studies
        .iter()
        .filter(|study| study.case.group == group)
        .flat_map(|study| &study.rows)
    {
        if !names.contains(&row.method) {
            names.push(row.method);
        }
    }
    names
}

fn case_anchor(k: usize) -> String {
    format!("case-{}", k + 1)
}

/// Returns the section of case `k`: description, chart, specimen and all figures.
fn case_section(k: usize, study: &CaseStudy, studies: &[CaseStudy]) -> Section {
    let case = &study.case;
    let mut body = Blocks::default();
    body.add_table(Table::of_values([
        ("Breaks", case.weakness),
        ("Swept", case.parameter),
        ("Truth", case.truth),
        ("Error", case.measure.name()),
    ]));
    let caption = "Broad: CPU; thin, dashed: GPU. Hollow: it warned; filled beyond the first limit: it failed in \
                   silence. ✖: no answer. Point at a mark for details.";
    let plot = plot_case(study, &method_names(studies, case.group));
    let chart = Figure::from_plot(
        Some(&plot).filter(|_| !study.rows.is_empty()),
        "Nothing was run.",
        caption,
    );
    add_pictures(&mut body, study, 0, Some(chart));
    let mut figures = Blocks::default();
    figures.add_table(results_table(study, study.sides()));
    let summary = format!(
        "All figures: {} values, {} methods",
        study.swept_values().len(),
        case.methods.len()
    );
    body.add_details(summary, false, figures);
    body.into_section(case_anchor(k), case.name)
}

/// Adds specimen `k` beside a figure, and its plates.
fn add_pictures(blocks: &mut Blocks, study: &CaseStudy, k: usize, beside: Option<Figure>) {
    let seen = study.specimens.get(k);
    let drawn = seen.map(|specimen| specimen::draw_specimen(specimen, study.case.parameter));
    blocks.add_figure_row(&beside.into_iter().chain(drawn).collect::<Vec<_>>());
    if let Some(specimen) = seen {
        specimen::add_plates(blocks, specimen);
    }
}

/// Table of results: one row each, those of the default that were missed marked.
fn results_table<'a>(
    study: &CaseStudy,
    sides: impl IntoIterator<Item = (&'a AtlasRow, Processor, &'a SolverSide)>,
) -> Table {
    let share = |share: Option<f64>| share.map_or("–".to_owned(), format_percent);
    let row = |(row, processor, side): (&AtlasRow, Processor, &SolverSide)| {
        let (class, sign) = verdict_style(side.verdict);
        let outcome = match side.outcome {
            WarningOutcome::Caught => " ▲",
            WarningOutcome::Missed => " ✖",
            WarningOutcome::FalseAlarm => " △",
            WarningOutcome::Quiet | WarningOutcome::Uncounted => "",
        };
        let error = Cell {
            class,
            ..format!("{sign} {}{outcome}", side.format_error(study.case.measure)).into()
        };
        let told = side
            .warnings
            .iter()
            .chain(&side.notes)
            .chain(&side.message)
            .chain(&row.scene);
        let told = told.map(String::as_str).collect::<Vec<_>>().join("; ");
        let cells = [
            format_value(row.value).into(),
            row.method.into(),
            processor.name().into(),
            error,
            share(side.bias).into(),
            share(side.estimate).into(),
            format_duration(side.seconds).into(),
            told.into(),
        ];
        let is_bad = study.is_default(row) && side.outcome == WarningOutcome::Missed;
        Row::new(cells).with_class_if(is_bad, "bad")
    };
    let parameter = format!("#{}", study.case.parameter);
    let heads = [
        &parameter,
        "Method",
        "Solver",
        "#Error",
        "#Bias",
        "#Estimate",
        "#Time",
        "~Warnings, notes, error message",
    ];
    Table::new(&heads, sides.into_iter().map(row))
}

/// Table of the results of all methods by warning code.
fn codes_table(atlas: &Atlas) -> Table {
    let row = |count: &CodeCount| {
        let numbers = [count.caught, count.false_alarms].map(plain_text);
        Row::new([code_text(&count.code)].into_iter().chain(numbers))
    };
    let heads = ["Warning", "#Caught|not safe", "#False alarms|safe"];
    Table::new(&heads, atlas.score.codes.iter().map(row))
}

/// Returns the sections of random scenes: estimates, pictures of the worst, all results.
fn random_sections(atlas: &Atlas) -> Vec<Section> {
    let mut estimates = Blocks::default();
    if let Some(ratios) = &atlas.estimate {
        let [below, above] = [ratios.below, ratios.above].map(format_percent);
        estimates.add_paragraph(format!(
            "Estimate over error, of the {} answers more than {} off ({} without an estimate, which counts as 0): \
             median {}, below half {below}, above three times {above}.",
            ratios.answers,
            format_percent(MIN_JUDGED_ERROR),
            ratios.unknown,
            format_number(ratios.median),
        ));
    }
    let caption = "Estimate against error; filled: beyond 2 % without a warning. On the thick line they are equal, the \
                   thin ones are half and three times the error; dashed: 0.2 %, below which estimates are not judged, \
                   and 2 %.";
    estimates.add_figure(&Figure::from_plot(
        Some(&plot_estimates(&atlas.studies)),
        "Nothing was estimated.",
        caption,
    ));
    let (mut worst, mut all) = (Blocks::default(), Blocks::default());
    for study in &atlas.studies {
        for (k, specimen) in study.specimens.iter().enumerate() {
            worst.add_heading(format!("Seed {}", specimen.value));
            worst.add_paragraph(specimen.description.as_deref().unwrap_or_default());
            add_pictures(&mut worst, study, k, None);
        }
        let mut sides: Vec<_> = study.sides().collect();
        let rank = |row: &AtlasRow| row.error.unwrap_or(f64::INFINITY);
        sides.sort_by(|(a, ..), (b, ..)| rank(b).total_cmp(&rank(a)));
        all.add_table(results_table(study, sides));
    }
    vec![
        estimates.into_section("estimates", "Error estimates"),
        worst.into_section("worst", "The worst"),
        all.into_section("all", "All scenes"),
    ]
}

/// Plots a mark for each answer that has an estimate.
fn plot_estimates(studies: &[CaseStudy]) -> Plot {
    let axis = |title: &str| Axis::logarithmic_scale(title, ESTIMATE_ENDS, format_share);
    let [low, high] = ESTIMATE_ENDS;
    let guide = |points: [[f64; 2]; 2], width, dashes| {
        let line = LineStyle {
            dashes,
            ..LineStyle::with_width(width)
        };
        Series::through_points("#808080", line, points)
    };
    // The line estimate = ratio × error within the axes.
    let slope = |ratio: f64| [low.max(low / ratio), high.min(high / ratio)].map(|error| [error, error * ratio]);
    let [safe, _] = ErrorMeasure::RelativeRms.limits();
    let upright = |error: f64| guide([[error, low], [error, high]], 1.0, Some("3 4"));
    let marks = [(Processor::Cpu, CPU_COLOUR), (Processor::Gpu, GPU_COLOUR)].map(|(solver, colour)| {
        let sides = studies.iter().flat_map(CaseStudy::sides);
        let sides = sides.filter(|(_, processor, _)| *processor == solver);
        let point = |(row, _, side): (&AtlasRow, Processor, &SolverSide)| {
            Some(PlotPoint {
                title: format!("seed {}, {}", row.value, solver.name()),
                is_hollow: side.outcome != WarningOutcome::Missed,
                ..[side.error?, side.estimate?].into()
            })
        };
        Series {
            name: solver.name().into(),
            colour,
            mark: Some(MarkStyle {
                shape: MarkShape::Circle,
                radius: 4.5,
                opacity: 1.0,
                outline: Some(colour),
            }),
            points: sides.filter_map(point).collect(),
            ..Series::default()
        }
    });
    let mut series = vec![guide(slope(1.0), 2.0, None), guide(slope(LOW_RATIO), 1.0, None)];
    series.extend([
        guide(slope(HIGH_RATIO), 1.0, None),
        upright(MIN_JUDGED_ERROR),
        upright(safe),
    ]);
    series.extend(marks.into_iter().filter(|marks| !marks.points.is_empty()));
    Plot {
        size: [720, 520],
        axes: [axis("true error (log)"), axis("estimated error (log)")],
        areas: Vec::new(),
        series,
        notes: Vec::new(),
        legend: Legend::Inside,
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{closed_room, make_row, make_side, make_specimen, make_study};
    use super::super::random::RANDOM_CASE;
    use super::*;

    fn page_of(study: CaseStudy) -> String {
        render_page(&Atlas::new(vec![study], Some("llvmpipe <&>".into()), 12.5))
    }

    #[test]
    fn page_has_break_points_charts_pictures_and_figures() {
        let row = |value, error, code: &str, method| AtlasRow {
            method,
            ..make_row(value, make_side(error, code), None)
        };
        let mut study = make_study(vec![
            row(1.0, Some(0.001), "", "default"),
            row(1.0, Some(0.5), "thin", "dense"),
            row(0.1, Some(0.05), "", "default"),
            row(0.1, None, "", "dense"),
        ]);
        study.specimens.push(make_specimen(closed_room(), 7));
        let page = page_of(study);
        for wanted in [
            "class=\"degrades\" title=\"one, default, CPU: beyond 2\u{202f}% at 0.1, beyond 10\u{202f}% at nowhere\"",
            "<b>at 0.1</b><br>◐ <span class=\"missed\">✖1</span>",
            "<b>at once</b><br>● ▲2",
            "<h2>one</h2>",
            "href=\"#case-1\"",
            "class=\"map\"",
            "data:image/png",
            "All figures: 2 values, 2 methods",
            "it does not fit",
            "<code>(refused)</code>",
            "llvmpipe &lt;&amp;&gt;",
            "Not OK",
        ] {
            assert!(page.contains(wanted), "{wanted}");
        }
        assert_eq!(page.matches("class=\"chart\"").count(), 1);
        let own = page.replace("http://www.w3.org/2000/svg", "");
        for outside in ["http://", "https://", "url(", "@import", "<script", "<link"] {
            assert!(!own.contains(outside), "{outside}");
        }
    }

    #[test]
    fn verdict_is_ok_only_if_all_gates_hold() {
        for (rows, ok) in [
            (vec![(0.01, "")], true),
            (vec![(0.5, "thin")], true),
            (vec![(0.5, "")], false),
            (vec![(f64::NAN, "thin")], false),
            (vec![], false),
        ] {
            let row = |(error, code)| make_row(1.0, make_side(Some(error), code), None);
            let page = page_of(make_study(rows.iter().copied().map(row).collect()));
            assert_eq!(page.contains("<strong>OK</strong>"), ok, "{rows:?}");
            assert_eq!(page.contains("<strong>Not OK</strong>"), !ok, "{rows:?}");
        }
    }

    #[test]
    fn random_page_shows_every_scene_and_the_worst() {
        let row = |(seed, error, code): (f64, f64, &str)| {
            let cpu = SolverSide {
                estimate: Some(0.02),
                ..make_side(Some(error), code)
            };
            AtlasRow {
                scene: Some(format!("scene <{seed}>")),
                ..make_row(seed, cpu, Some(make_side(Some(0.5 * error), code)))
            }
        };
        let page = page_of(CaseStudy {
            case: RANDOM_CASE,
            specimens: vec![make_specimen(closed_room(), 0)],
            ..make_study([(0.0, 0.03, ""), (1.0, 0.01, ""), (2.0, 0.05, "cells")].map(row).into())
        });
        assert_eq!(page.matches("<tr class=\"bad\">").count(), 1);
        assert!(page.contains("<h3>Seed 0.001</h3>") && page.contains("scene &lt;1&gt;"));
        // Three estimates, since the GPU has none.
        assert_eq!(page.matches("<g class=\"mark\">").count(), 3);
    }
}
