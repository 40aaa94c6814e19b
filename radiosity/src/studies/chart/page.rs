//! Content of `chart.html` and `chart.svg`: per scene error against time of every method, or error and time
//! against each varied option.

use super::bench::MAX_REPEATED_SECONDS;
use super::methods::{SolveMethod, SolverKind};
use super::points::{ChartPoint, SceneChart, is_on_front};
use super::store::Measurement;
use crate::report::document::{
    Blocks, Cell, Document, Figure, Row, Section, Table, bold_text, code_text, plain_text, series_key, styled_text,
};
use crate::report::format::{file_name, format_count, format_duration, format_number, format_percent};
use crate::report::plot::{
    Axis, CPU_COLOUR, CURVE_COLOURS, CURVE_MARKS, GPU_COLOUR, Legend, LineStyle, MarkShape, MarkStyle, Plot, PlotPoint,
    Series, format_share, positive_range,
};
use common::settings::ItemBufferProjection;

const PAGE_STYLE: &str =
    "main{max-width:84rem}figure,figure.wide{max-width:none}td.reason{min-width:15rem}tr.front td{font-weight:600}";
/// Size of the chart of all methods, CSS pixels.
const METHODS_SIZE: [u32; 2] = [1040, 640];
/// Size of the chart of an option, CSS pixels.
const OPTION_SIZE: [u32; 2] = [520, 330];
/// Width of a legend, CSS pixels.
const LEGEND_WIDTH: u32 = 240;
/// Title of an axis of time.
const SECONDS_TITLE: &str = "seconds (log)";
/// Title of an axis of errors.
const ERROR_TITLE: &str = "relative RMS of B − E (log)";

const EXPLANATION: &str = "Time is mesh, engine and solve by wall clock, the median of the runs. Error is the relative \
    RMS of the reflected radiosity B − E against the truth, area-weighted, the worst channel. A point is on the front \
    when no other is both faster and more accurate. Point at a mark to read its method.";
const METHOD_EXPLANATION: &str = "All methods compute the mean radiosity of the same texels: a solution on fewer is \
    constant over each of them. One parameter of the base is varied at a time, and a few together. A thin line through a \
    mark goes from its fastest to its slowest run.";
const OPTION_EXPLANATION: &str = "One option is varied at a time, all others stay; texels of method and truth are \
    averaged by area over common ones. An error that falls as C hᵖ has order p (h: the step that goes to 0), the slope \
    of the straight line through the points of the logarithmic chart. The last order is that of the last two points, \
    about 0 where another parameter sets a floor. A truth that is the same solve with a finer value has an error of its \
    own: where that has the kind and sign of the points', the slope is too steep.";

/// Returns the page.
pub fn render_page(charts: &[SceneChart]) -> String {
    let varies = charts.iter().any(|chart| !chart.curves.is_empty());
    let (title, more) = match varies {
        true => ("Radiosity: error against options", OPTION_EXPLANATION),
        false => ("Radiosity: speed against accuracy", METHOD_EXPLANATION),
    };
    let mut opening = Blocks::default();
    opening.add_paragraph(EXPLANATION).add_paragraph(more);
    Document {
        title,
        opening,
        sections: charts.iter().enumerate().map(scene_section).collect(),
        style: PAGE_STYLE,
    }
    .to_html()
}

/// Returns the plots of all scenes with their titles, for an SVG file.
pub fn titled_plots(charts: &[SceneChart]) -> Vec<(String, Plot)> {
    let mut plots = Vec::new();
    for chart in charts {
        if chart.curves.is_empty() {
            plots.push((chart.scene.clone(), plot_methods(chart)));
        }
        for curves in chart.sweep_curves() {
            let mut plot = plot_option(chart, curves.clone(), ERROR_TITLE);
            plot.size[0] += LEGEND_WIDTH;
            plot.legend = Legend::Beside(LEGEND_WIDTH);
            plots.push((format!("{}: {}", chart.scene, chart.curves[curves.start].name), plot));
        }
    }
    plots
}

fn scene_section((k, chart): (usize, &SceneChart)) -> Section {
    let mut body = Blocks::default();
    let texels = chart
        .texels
        .map(|n| format!(", {n}×{n} texels on each · truth: {}", chart.truth));
    body.add_remark(format!(
        "{} faces{} · GPU: {}",
        format_count(chart.faces as u64),
        texels.unwrap_or_default(),
        chart.adapter.as_deref().unwrap_or("none")
    ));
    let missing = format!(
        "{} points were not measured: the same command continues.",
        chart.missing
    );
    body.add_notes((chart.missing > 0).then_some(missing));
    if chart.curves.is_empty() {
        add_methods(&mut body, chart);
    } else {
        add_options(&mut body, chart);
    }
    body.into_section(format!("scene-{}", k + 1), file_name(&chart.scene))
}

/// Adds the chart of all methods, and the table of all points, fastest first.
fn add_methods(body: &mut Blocks, chart: &SceneChart) {
    let caption = bold_text("Error against time") + " · down is more accurate, left is faster";
    body.add_figure(&Figure::from_plot(
        Some(&plot_methods(chart)),
        "Nothing measured.",
        caption,
    ));
    let mut points: Vec<&ChartPoint> = chart.points.iter().collect();
    points.sort_by(|a, b| {
        let ([a_time, a_error], [b_time, b_error]) = (a.time_and_error(), b.time_and_error());
        a_error.is_nan().cmp(&b_error.is_nan()).then(a_time.total_cmp(&b_time))
    });
    body.add_heading("All points")
        .add_remark(format!(
            "Options are those that differ from the solver's base. Runs longer than {} s are not repeated.",
            format_number(MAX_REPEATED_SECONDS)
        ))
        .add_table(points_table(
            "Solver",
            points.into_iter().map(|p| (p.method.solver.name(), p)),
        ));
}

/// Adds the table of all curves, and charts and points of each option.
fn add_options(body: &mut Blocks, chart: &SceneChart) {
    let rows = chart.curves.iter().map(|curve| {
        let [order, last_order] = [curve.order, curve.last_order].map(format_order);
        let (option, truth) = (code_text(curve.option), code_text(&curve.truth));
        Row::new([option, plain_text(&curve.label), truth, order.into(), last_order.into()])
    });
    let heads = ["Option", "Curve", "Truth", "#Order", "#Last order"];
    body.add_table(Table::new(&heads, rows));
    for curves in chart.sweep_curves() {
        let first = &chart.curves[curves.start];
        let figures = [("Error", ERROR_TITLE), ("Time", SECONDS_TITLE)].map(|(name, title)| {
            let plot = plot_option(chart, curves.clone(), title);
            let keys = plot.series.iter().map(series_key);
            let caption = keys.fold(bold_text(name), |all, key| all + " " + key);
            Figure::from_plot(Some(&plot), "Nothing above 0.", caption)
        });
        let points = curves.flat_map(|k| {
            chart
                .curve_points(k)
                .map(move |point| (chart.curves[k].label.as_str(), point))
        });
        body.add_heading(plain_text(first.name) + " " + code_text(first.option))
            .add_figures(&figures)
            .add_table(points_table("Curve", points));
    }
}

/// Makes a table of points with the head and the text of its first column.
fn points_table<'a>(first: &str, points: impl Iterator<Item = (&'a str, &'a ChartPoint)>) -> Table {
    let heads = [
        first,
        "~Options",
        "#Time",
        "#Least – most",
        "#Error",
        "#Bias",
        "#Energy imbalance",
        "#Shots",
        "#Passes",
    ];
    Table::new(&heads, points.map(|(name, point)| point_row(name, point)))
}

fn point_row(name: &str, point: &ChartPoint) -> Row {
    let [median, min, max] = point.median_and_range(Measurement::total_seconds).map(format_duration);
    let options = code_text(&point.method.options);
    let mut cells: Vec<Cell> = vec![
        name.into(),
        options.into(),
        median.into(),
        format!("{min} – {max}").into(),
    ];
    match point.first_result() {
        Ok(figures) => cells.extend([
            format_percent(figures.error).into(),
            format_percent(figures.bias).into(),
            format_number(figures.imbalance).into(),
            format_count(figures.shots).into(),
            format_count(figures.passes.into()).into(),
        ]),
        Err(reason) => cells.push(Cell {
            columns: 5,
            ..styled_text("fail", format!("■ {reason}")).into()
        }),
    }
    Row::new(cells).with_class_if(point.on_front, "front")
}

/// Formats an order for the tables.
fn format_order(order: Option<f64>) -> String {
    // Adding 0.0 avoids “−0.00”.
    let text = |p: f64| format!("{:.2}", (100.0 * p).round() / 100.0 + 0.0);
    order.map_or("–".into(), |p| text(p).replace('-', "−"))
}

/// Returns name, colour and mark of a method in the chart.
fn mark_family(method: &SolveMethod) -> (&'static str, &'static str, MarkShape) {
    let drawing = method.settings.transport.visibility.item_buffer();
    match (
        method.solver,
        method.target_error,
        drawing.map(|drawing| drawing.projection),
    ) {
        (SolverKind::Dense, ..) => ("dense, fewer texels", "#828282", MarkShape::Ring),
        (SolverKind::Cpu, Some(_), _) => ("CPU, to an error", "#e8459c", MarkShape::Diamond),
        (SolverKind::Gpu, Some(_), _) => ("GPU, to an error", "#5f9e2f", MarkShape::Diamond),
        (SolverKind::Cpu, None, None) => ("CPU, rays", CPU_COLOUR, MarkShape::Circle),
        (SolverKind::Cpu, None, Some(_)) => ("CPU, item buffer", "#19a3a8", MarkShape::Square),
        (SolverKind::Gpu, None, None) => ("GPU, rays", "#7a4fd0", MarkShape::Circle),
        (SolverKind::Gpu, None, Some(projection)) => match projection {
            ItemBufferProjection::Stereographic(_) => ("GPU, stereographic", GPU_COLOUR, MarkShape::Square),
            ItemBufferProjection::Hemisphere(_) => ("GPU, hemisphere", "#c4a000", MarkShape::Triangle),
            ItemBufferProjection::Hemicube => ("GPU, hemicube", "#b06ac8", MarkShape::DownTriangle),
            ItemBufferProjection::Paper => ("GPU, paper", "#9a6a4a", MarkShape::Bar),
        },
    }
}

/// Makes the chart of error against time; failed methods lie on its upper edge.
fn plot_methods(chart: &SceneChart) -> Plot {
    let mut series: Vec<Series> = Vec::new();
    let mut add_point = |(name, colour, shape), point| match series.iter_mut().find(|series| series.name == name) {
        Some(series) => series.points.push(point),
        None => series.push(marked_series(name, colour, shape, [point])),
    };
    for peer in &chart.peers {
        let [seconds, error] = peer.time_and_error();
        let text = format!("{}, error {}", format_duration(seconds), format_percent(error));
        let point = PlotPoint {
            title: format!("{}\n{text}", peer.describe_peer()),
            ..[seconds, error].into()
        };
        add_point(("other programs", "#828282", MarkShape::Cross), point);
    }
    for point in &chart.points {
        let is_named = point.on_front || point.method.options == "base" && point.first_result().is_ok();
        let [_, min, max] = point.median_and_range(Measurement::total_seconds);
        let plotted = PlotPoint {
            label: if is_named { point_name(point) } else { String::new() },
            whisker: point.first_result().is_ok().then_some([min, max]),
            ..point_at(point, point.time_and_error())
        };
        let failed = ("failed", "currentColor", MarkShape::Cross);
        add_point(
            point.first_result().map_or(failed, |_| mark_family(&point.method)),
            plotted,
        );
    }
    let fronts = [
        ("front of the CPU", CPU_COLOUR, Some(SolverKind::Cpu)),
        ("front of the GPU", GPU_COLOUR, Some(SolverKind::Gpu)),
        ("front of all", "currentColor", None),
    ];
    for (name, colour, solver) in fronts {
        let points = chart
            .points
            .iter()
            .filter(|p| solver.is_none_or(|solver| p.method.solver == solver));
        let places: Vec<[f64; 2]> = points.map(ChartPoint::time_and_error).collect();
        let is_on = |place: &[f64; 2]| is_on_front(*place, places.iter().copied());
        let mut front: Vec<[f64; 2]> = places.iter().copied().filter(is_on).collect();
        front.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let line = match solver {
            Some(_) => LineStyle {
                dashes: Some("6 4"),
                ..LineStyle::with_width(1.5)
            },
            None => LineStyle {
                opacity: 0.35,
                ..LineStyle::with_width(5.0)
            },
        };
        if !front.is_empty() {
            series.push(Series {
                name: name.into(),
                ..Series::through_points(colour, line, front)
            });
        }
    }
    Plot {
        legend: Legend::Beside(LEGEND_WIDTH),
        ..logarithmic_plot(METHODS_SIZE, [SECONDS_TITLE, ERROR_TITLE], series)
    }
}

/// Makes the chart of error or time against an option.
fn plot_option(chart: &SceneChart, curves: std::ops::Range<usize>, title: &'static str) -> Plot {
    let option = chart.curves[curves.start].option;
    let series = curves.enumerate().map(|(k, curve)| {
        let points = chart.curve_points(curve).filter_map(|point| {
            let (_, value) = point.method.varied?;
            let y = point.time_and_error()[usize::from(title == ERROR_TITLE)];
            (y > 0.0).then(|| point_at(point, [value, y]))
        });
        let (colour, shape) = (
            CURVE_COLOURS[k % CURVE_COLOURS.len()],
            CURVE_MARKS[k % CURVE_MARKS.len()],
        );
        Series {
            line: Some(LineStyle::with_width(2.0)),
            ..marked_series(&chart.curves[curve].label, colour, shape, points)
        }
    });
    let mut plot = logarithmic_plot(OPTION_SIZE, [option, title], series.collect());
    let mut values: Vec<f64> = plot
        .series
        .iter()
        .flat_map(|s| &s.points)
        .map(|point| point.at[0])
        .collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    plot.axes[0].ticks = values.into_iter().map(|value| (value, format_number(value))).collect();
    plot
}

fn marked_series(
    name: &str,
    colour: &'static str,
    shape: MarkShape,
    points: impl IntoIterator<Item = PlotPoint>,
) -> Series {
    Series {
        name: name.to_owned(),
        colour,
        mark: Some(MarkStyle {
            shape,
            radius: 5.0,
            opacity: 0.85,
            outline: None,
        }),
        points: points.into_iter().collect(),
        ..Series::default()
    }
}

/// Makes a plot without a legend whose axes hold all points.
fn logarithmic_plot(size: [u32; 2], titles: [&str; 2], series: Vec<Series>) -> Plot {
    let range = |k: usize| {
        let values = series.iter().flat_map(|s| &s.points).map(|point| point.at[k]);
        positive_range(values, [0.7, 1.5], [0.1, 1.0])
    };
    let labels: [fn(f64) -> String; 2] = [
        format_number,
        if titles[1] == ERROR_TITLE {
            format_share
        } else {
            format_number
        },
    ];
    let axes = [0, 1].map(|k| Axis::logarithmic_scale(titles[k], range(k), labels[k]));
    Plot {
        size,
        axes,
        areas: Vec::new(),
        series,
        notes: Vec::new(),
        legend: Legend::None,
    }
}

/// Makes the mark of a point with its tooltip.
fn point_at(point: &ChartPoint, at: [f64; 2]) -> PlotPoint {
    let [median, min, max] = point.median_and_range(Measurement::total_seconds).map(format_duration);
    let outcome = match point.first_result() {
        Ok(figures) => format!(
            "{median} ({min} – {max}), error {}, bias {}",
            format_percent(figures.error),
            format_percent(figures.bias)
        ),
        Err(reason) => format!("failed after {median}: {reason}"),
    };
    PlotPoint {
        title: format!("{}\n{outcome}", point_name(point)),
        ..at.into()
    }
}

/// Returns solver and options of a point.
fn point_name(point: &ChartPoint) -> String {
    let options = point.method.options.replace("--", "");
    format!("{} {options}", point.method.solver.name())
}
