//! Content of `chart.html` and `chart.svg`: per scene error against time of every method, or error and time
//! against each varied option.

use super::bench::MAX_REPEATED_SECONDS;
use super::methods::SolveMethod;
use super::points::{ChartPoint, MeasuredSet, SceneChart};
use super::sweeps::Sweep;
use crate::report::document::{
    Blocks, Cell, Figure, Row, Section, Table, bold_text, code_text, plain_text, render_document, styled_text,
};
use crate::report::format::{file_name, format_count, format_duration, format_number, format_percent};
use crate::report::plot::{
    Axis, CPU_COLOUR, CURVE_COLOURS, CURVE_MARKS, GPU_COLOUR, LineStyle, MarkShape, Plot, PlotPoint, Series,
    format_share, positive_range,
};
use oracle::solve::solver::SolverKind;

const PAGE_STYLE: &str =
    "main{max-width:84rem}figure,figure.wide{max-width:none}td.reason{min-width:15rem}tr.front td{font-weight:600}";
/// Size of a chart, CSS pixels.
const PLOT_SIZE: [u32; 2] = [1040, 560];
/// Width of a legend, CSS pixels.
const LEGEND_WIDTH: u32 = 240;
/// Colour of what is of neither solver.
const OTHERS_COLOUR: &str = "#828282";

const AXES_TEXT: &str = "Time is mesh, engine and solve by wall clock, of the fastest run. Error is the relative RMS of \
    the reflected radiosity B − E against the truth, area-weighted, the worst channel. A point is on the front when no \
    other is both faster and more accurate. Point at a mark to read its method.";
const METHOD_EXPLANATION: &str = "All methods compute the mean radiosity of the same texels: a solution on fewer is \
    constant over each of them. One parameter of the base is varied at a time, and a few together.";
const OPTION_EXPLANATION: &str = "One option is varied at a time, all others stay; texels of method and truth are \
    averaged by area over common ones. An error that falls as C hᵖ has order p (h: the step that goes to 0), the slope \
    of the straight line through the points of the logarithmic chart; it is about 0 where another parameter sets a \
    floor. A truth that is the same solve with a finer value has an error of its own: where that has the kind and sign \
    of the points', the slope is too steep.";

/// Returns the page.
pub fn render_page(charts: &[SceneChart]) -> String {
    let varies = charts
        .iter()
        .flat_map(|chart| &chart.sets)
        .any(|set| set.sweep.is_some());
    let (title, more) = match varies {
        true => ("Radiosity: error against options", OPTION_EXPLANATION),
        false => ("Radiosity: speed against accuracy", METHOD_EXPLANATION),
    };
    let mut opening = Blocks::default();
    opening.add_paragraph(AXES_TEXT).add_paragraph(more);
    let sections: Vec<Section> = charts.iter().enumerate().map(scene_section).collect();
    render_document(title, &opening, &sections, PAGE_STYLE)
}

/// Returns the plots of errors of all scenes with their titles, for an SVG file.
pub fn titled_plots(charts: &[SceneChart]) -> Vec<(String, Plot)> {
    let plots = charts.iter().flat_map(|chart| {
        chart.sets.iter().map(|set| match set.sweep {
            None => (chart.scene.clone(), plot_methods(set, chart)),
            Some(sweep) => (format!("{}: {}", chart.scene, sweep.name), plot_option(set, &sweep, 1)),
        })
    });
    plots.collect()
}

fn scene_section((k, chart): (usize, &SceneChart)) -> Section {
    let mut body = Blocks::default();
    let texels = chart.texels.map(|n| format!(", {n}×{n} texels on each"));
    body.add_remark(format!(
        "{} faces{} · GPU: {}",
        format_count(chart.faces as u64),
        texels.unwrap_or_default(),
        chart.adapter.as_deref().unwrap_or("none")
    ));
    let missing = chart.count_missing();
    let note = format!("{missing} points were not measured: the same command continues.");
    body.add_notes((missing > 0).then_some(note));
    for set in &chart.sets {
        match set.sweep {
            None => add_methods(&mut body, set, chart),
            Some(sweep) => add_option(&mut body, set, &sweep),
        }
    }
    body.into_section(format!("scene-{}", k + 1), file_name(&chart.scene))
}

/// Adds the chart of all methods, and the table of all points, fastest first.
fn add_methods(body: &mut Blocks, set: &MeasuredSet, chart: &SceneChart) {
    let caption =
        bold_text("Error against time") + " · down is more accurate, left is faster · truth: " + code_text(&set.truth);
    let plot = plot_methods(set, chart);
    body.add_figure(&Figure::from_plot(&plot, "Nothing measured.", caption));
    let mut points: Vec<&ChartPoint> = set.points.iter().collect();
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

/// Adds the charts of an option, the orders of its curves and the table of its points.
fn add_option(body: &mut Blocks, set: &MeasuredSet, sweep: &Sweep) {
    let figures = [("Error", 1), ("Time", 0)].map(|(name, quantity)| {
        let plot = plot_option(set, sweep, quantity);
        let caption = bold_text(name) + " · truth: " + code_text(&set.truth);
        Figure::from_plot(&plot, "Nothing above 0.", caption)
    });
    let orders = set.split_by_curve().map(|(name, points)| {
        let order = set.curve_order(points).map_or("–".into(), format_number);
        Row::new([name.to_owned(), order])
    });
    let orders = Table::new("Curve;#Order", orders);
    let points = set
        .split_by_curve()
        .flat_map(|(name, points)| points.iter().map(move |point| (name, point)));
    body.add_heading(plain_text(sweep.name) + " " + code_text(sweep.option))
        .add_figure(&figures[0])
        .add_figure(&figures[1])
        .add_table(orders)
        .add_table(points_table("Curve", points));
}

/// Makes a table of points with the head and the text of its first column.
fn points_table<'a>(first: &str, points: impl Iterator<Item = (&'a str, &'a ChartPoint)>) -> Table {
    let heads = format!("{first};~Options;#Time;#Error;#Bias");
    Table::new(&heads, points.map(|(name, point)| point_row(name, point)))
}

fn point_row(name: &str, point: &ChartPoint) -> Row {
    let seconds = format_duration(point.measurement.seconds);
    let mut cells: Vec<Cell> = vec![name.into(), code_text(&point.method.options).into(), seconds.into()];
    match &point.measurement.result {
        Ok(figures) => cells.extend([
            format_percent(figures.error).into(),
            format_percent(figures.bias).into(),
        ]),
        Err(reason) => cells.push(Cell {
            columns: 2,
            ..styled_text("fail", format!("■ {reason}")).into()
        }),
    }
    Row::new(cells).with_class_if(point.on_front, "front")
}

/// Returns name, colour and mark of a method in the chart: the colour is the solver's.
fn mark_family(method: &SolveMethod) -> (String, &'static str, MarkShape) {
    let (kind, shape) = match (method.target_error, method.settings.transport.visibility.item_buffer()) {
        (Some(_), _) => (", to an error", MarkShape::Diamond),
        (None, Some(_)) => (", item buffer", MarkShape::Square),
        (None, None) => (", rays", MarkShape::Circle),
    };
    let colour = match method.solver {
        SolverKind::Cpu => CPU_COLOUR,
        SolverKind::Gpu => GPU_COLOUR,
        SolverKind::Dense => return ("dense, fewer texels".into(), OTHERS_COLOUR, MarkShape::DownTriangle),
    };
    (method.solver.name().to_owned() + kind, colour, shape)
}

/// Makes the chart of error against time; failed methods lie on its upper edge.
fn plot_methods(set: &MeasuredSet, chart: &SceneChart) -> Plot {
    let mut series: Vec<Series> = Vec::new();
    let mut add_point = |(name, colour, shape): (String, &'static str, MarkShape), point| match series
        .iter_mut()
        .find(|series| series.name == name)
    {
        Some(series) => series.points.push(point),
        None => series.push(marked_series(&name, colour, shape, [point])),
    };
    for peer in &chart.peers {
        let [seconds, error] = peer.time_and_error();
        let text = format!("{}, error {}", format_duration(seconds), format_percent(error));
        let point = PlotPoint {
            title: format!("{}\n{text}", peer.describe_peer()),
            ..[seconds, error].into()
        };
        add_point(("other programs".into(), OTHERS_COLOUR, MarkShape::Cross), point);
    }
    for point in &set.points {
        let family = match point.solve_figures() {
            Some(_) => mark_family(&point.method),
            None => ("failed".into(), "currentColor", MarkShape::Cross),
        };
        add_point(family, point_at(point, point.time_and_error()));
    }
    let on_front = set.points.iter().filter(|point| point.on_front);
    let mut front: Vec<[f64; 2]> = on_front.map(ChartPoint::time_and_error).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    if !front.is_empty() {
        series.push(Series {
            name: "front".into(),
            ..Series::through_points("currentColor", LineStyle::with_width(1.5), front)
        });
    }
    logarithmic_plot("seconds (log)", 1, series)
}

/// Makes the chart of time (0) or error (1) against an option.
fn plot_option(set: &MeasuredSet, sweep: &Sweep, quantity: usize) -> Plot {
    let series = set.split_by_curve().enumerate().map(|(k, (name, points))| {
        let points = points.iter().filter_map(|point| {
            let y = point.time_and_error()[quantity];
            (y > 0.0).then_some(point_at(point, [point.method.curve?.1, y]))
        });
        let (colour, shape) = (
            CURVE_COLOURS[k % CURVE_COLOURS.len()],
            CURVE_MARKS[k % CURVE_MARKS.len()],
        );
        Series {
            line: Some(LineStyle::with_width(2.0)),
            ..marked_series(name, colour, shape, points)
        }
    });
    let mut plot = logarithmic_plot(sweep.option, quantity, series.collect());
    let values = sweep.values.iter();
    plot.axes[0].ticks = values.map(|value| (*value, format_number(*value))).collect();
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
        mark: Some(shape),
        points: points.into_iter().collect(),
        ..Series::default()
    }
}

/// Makes a plot of time (0) or error (1) whose axes hold all points.
fn logarithmic_plot(across: &str, quantity: usize, series: Vec<Series>) -> Plot {
    let range = |k: usize| {
        let values = series.iter().flat_map(|s| &s.points).map(|point| point.at[k]);
        positive_range(values, [0.7, 1.5], [0.1, 1.0])
    };
    let y = match quantity {
        0 => Axis::logarithmic_scale("seconds (log)", range(1), format_number),
        _ => Axis::logarithmic_scale("relative RMS of B − E (log)", range(1), format_share),
    };
    Plot {
        size: PLOT_SIZE,
        axes: [Axis::logarithmic_scale(across, range(0), format_number), y],
        series,
        legend_width: LEGEND_WIDTH,
    }
}

/// Makes the mark of a point with its tooltip.
fn point_at(point: &ChartPoint, at: [f64; 2]) -> PlotPoint {
    let seconds = format_duration(point.measurement.seconds);
    let outcome = match &point.measurement.result {
        Ok(figures) => format!(
            "{seconds}, error {}, bias {}",
            format_percent(figures.error),
            format_percent(figures.bias)
        ),
        Err(reason) => format!("failed after {seconds}: {reason}"),
    };
    let options = point.method.options.replace("--", "");
    PlotPoint {
        title: format!("{} {options}\n{outcome}", point.method.solver.name()),
        ..at.into()
    }
}
