//! Page of the error against options: charts and a table for each.

use super::item_buffer::ItemBufferRow;
use super::{ConvergenceStudy, MeasuredSweep, SweepPoint};
use crate::report::chart::{
    Axis, AxisLabel, CURVE_COLOURS, CURVE_MARKS, draw_legend, draw_path, format_share, render_svg,
};
use crate::report::format::{format_count, format_duration, format_number, format_percent};
use crate::report::page::{file_name, render_chart, render_mark};
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use crate::studies::chart::page::page_of_scenes;
use crate::studies::chart::plot::{describe_settings, positive_range};
use common::settings::{ItemBufferSettings, Lookup};
use maud::{Markup, html};

/// Size of a chart, CSS pixels; the page scales it.
const CHART_SIZE: (u32, u32) = (520, 330);
/// Width of the legend in an SVG file, CSS pixels.
const LEGEND_WIDTH: u32 = 240;

/// Returns the page of the finished studies.
pub fn render_page(studies: &[ConvergenceStudy]) -> String {
    let section = |study: &ConvergenceStudy| {
        html! {
            p.facts { (format_count(study.faces as u64)) " faces · item buffers by " (study.adapter) }
            @for sweep in &study.sweeps { (sweep_section(sweep)) }
            (item_buffer_table(study))
        }
    };
    let names = studies.iter().map(|study| &study.scene).collect();
    let head = html! { (explanation()) (overview_table(studies)) };
    let sections = studies.iter().map(section).collect();
    page_of_scenes(["Radiosity: error against options", ""], head, names, sections)
}

fn explanation() -> Markup {
    html! {
        p {
            "One option of a solve is varied at a time, all others stay. The error is the relative RMS of the "
            "reflected radiosity B − E against a truth, area-weighted, the worst channel, both averaged by area "
            "over common texels; so it is the error of texel means."
        }
        p {
            "An error that falls as " i { "C hᵖ" } " has order " i { "p" } " (h: the step that goes to 0), the slope "
            "of the straight line through the points of the logarithmic chart; points at the rounding of 32-bit "
            "numbers are left out. Where the truth is the same solve with a finer value, it has an error of its own. "
            "If that has the kind and sign of the points', the slope is too steep: “beside the truth” is p fitted to "
            "C (hᵖ − h₀ᵖ), h₀ the truth's step."
        }
    }
}

/// Returns ✓, or “stops”, which is no failure: rounding or another parameter may set the floor.
fn convergence_mark(converges: bool) -> Markup {
    html! {
        @if converges { (render_mark(true, ["falls to the end", ""], "")) }
        @else { span.stops-here title="does not fall any further" { "– stops" } }
    }
}

/// Formats an order for the tables.
pub fn format_order(order: Option<f64>) -> String {
    // Adding 0.0 avoids “−0.00”.
    let text = |p: f64| format!("{:.2}", (100.0 * p).round() / 100.0 + 0.0);
    order.map_or("–".into(), |p| text(p).replace('-', "−"))
}

fn overview_table(studies: &[ConvergenceStudy]) -> Markup {
    let mut rows = Vec::new();
    for study in studies {
        for sweep in &study.sweeps {
            for curve in &sweep.curves {
                let ends = [curve.points.first(), curve.points.last()];
                let [first, last] = ends.map(|point| point.map_or("–".into(), |p| format_percent(p.error)));
                rows.push(TableRow::new([
                    text_cell(file_name(&study.scene)),
                    text_cell(sweep.name),
                    text_cell(&curve.label),
                    number_cell(first),
                    number_cell(last),
                    number_cell(format_order(curve.order)),
                    text_cell(convergence_mark(curve.converges)),
                ]));
            }
        }
    }
    let heads = [
        "Scene",
        "Option",
        "Curve",
        "#First error",
        "#Last error",
        "#Order",
        "Falls",
    ];
    render_table("", &heads, rows)
}

fn sweep_section(sweep: &MeasuredSweep) -> Markup {
    let varied = sweep.option.trim_start_matches('-');
    html! {
        h3 { (sweep.name) " " code { (sweep.option) } }
        p.small { "Truth: " code { (sweep.truth) } " · " (describe_settings(&sweep.base, &[varied, "max-shots"])) }
        div.grid {
            (render_chart(error_chart(sweep, 0).as_deref(), "No error above 0.", html! { b { "Error" } " · " (curve_legend(sweep)) }))
            (render_chart(time_chart(sweep).as_deref(), "No seconds.", html! {
                b { "Time" } " · preparing and shooting, wall clock; " (curve_legend(sweep))
            }))
        }
        (points_table(sweep))
        ul {
            @for curve in &sweep.curves {
                li { (convergence_mark(curve.converges)) " " b { (curve.label) } ": " (curve.finding) "." }
            }
        }
    }
}

/// Table of item buffers against rays.
fn item_buffer_table(study: &ConvergenceStudy) -> Markup {
    let name = |v: &dyn std::fmt::Debug| format!("{v:?}").to_lowercase();
    let lookup = |lookup: Lookup| match lookup {
        Lookup::Exact => "exact",
        Lookup::Neighbours => "3x3",
    };
    let row = |row: &ItemBufferRow| {
        TableRow::new([
            text_cell(row.visibility),
            text_cell(name(&row.raster)),
            number_cell(html! { (row.size) "²" }),
            text_cell(lookup(row.lookup)),
            number_cell(format_percent(row.mismatched)),
            number_cell(format_percent(row.falsely_hidden)),
            number_cell(format_percent(row.falsely_seen)),
            number_cell(format_number(1e3 * row.shot_seconds)),
        ])
    };
    let heads = [
        "Projection",
        "Raster",
        "#Pixels",
        "Lookup",
        "#Mismatched",
        "#Falsely hidden",
        "#Falsely seen",
        "#ms a shot",
    ];
    html! {
        @if !study.item_buffers.is_empty() {
            h3 { "Item buffers against rays " code { "--visibility --raster --item-buffer --lookup" } }
            p.small {
                "All pairs of a face's centre and a texel's that face each other. Mismatched: the share of pairs that "
                "rays judge differently. Hidden and seen: the share of the transfer F·A that the item buffer loses or "
                "makes up. Time: a patch's first shot, wall clock."
            }
            (render_table("", &heads, study.item_buffers.iter().map(row)))
            (best_item_buffer(&study.item_buffers))
        }
    }
}

/// Names the setting with the least wrong transfer at the default size.
fn best_item_buffer(rows: &[ItemBufferRow]) -> Markup {
    let wrong = |row: &ItemBufferRow| row.falsely_hidden + row.falsely_seen;
    let size = ItemBufferSettings::DEFAULT.size;
    let best = rows
        .iter()
        .filter(|row| row.size == size)
        .min_by(|a, b| wrong(a).total_cmp(&wrong(b)));
    html! {
        @if let Some(row) = best {
            p {
                "Least wrong at " (size) "²: " b { (row.visibility) } ", "
                (format_percent(wrong(row))) " of the transfer. The default is stereographic, by pixels, 3x3."
            }
        }
    }
}

fn curve_legend(sweep: &MeasuredSweep) -> Markup {
    html! {
        @for (k, curve) in sweep.curves.iter().enumerate() {
            (legend_entry(k, &curve.label)) " "
        }
    }
}

fn points_table(sweep: &MeasuredSweep) -> Markup {
    let max_points = sweep.curves.iter().map(|c| c.points.len()).max().unwrap_or(0);
    let longest = sweep.curves.iter().find(|c| c.points.len() == max_points);
    let beside = sweep.curves.iter().any(|c| c.order_beside.is_some());
    let values = longest.iter().flat_map(|c| &c.points);
    let values = values.map(|point| format!("#{}", format_number(point.value)));
    let mut heads: Vec<String> = vec!["Curve".into()];
    heads.extend(values);
    heads.push("#Order".into());
    if beside {
        heads.push("#Beside the truth".into());
    }
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let rows = sweep.curves.iter().enumerate().map(|(k, curve)| {
        let points = (0..max_points).map(|j| {
            number_cell(html! {
                @if let Some(point) = curve.points.get(j) {
                    (format_percent(point.error)) br;
                    span.facts { (format_percent(point.bias)) " bias" br; (format_duration(point.seconds)) }
                }
            })
        });
        let order = number_cell(format_order(curve.order));
        let order_beside = beside.then(|| number_cell(format_order(curve.order_beside)));
        let cells = [text_cell(legend_entry(k, &curve.label))].into_iter().chain(points);
        TableRow::new(cells.chain([order]).chain(order_beside))
    });
    render_table("", &heads, rows)
}

/// Returns the colour of curve `k`.
fn curve_colour(k: usize) -> &'static str {
    CURVE_COLOURS[k % CURVE_COLOURS.len()]
}

/// Draws the mark of curve `k` centred at a pixel.
fn curve_mark(k: usize, at: (f64, f64), size: f64) -> Markup {
    html! { path d=(CURVE_MARKS[k % CURVE_MARKS.len()].outline_path(at, size)) fill=(curve_colour(k)) {} }
}

/// Returns the legend entry of curve `k`: colour, mark and name.
fn legend_entry(k: usize, name: &str) -> Markup {
    html! { span.key {
        svg.inline viewBox="0 0 26 16" aria-hidden="true" {
            (draw_path("M0 8H26", curve_colour(k), 2.0, 1.0, None)) (curve_mark(k, (13.0, 8.0), 5.0))
        }
        (name)
    } }
}

/// Returns the charts of error against each scene's options, with titles and legends, for an SVG file.
pub fn error_charts(studies: &[ConvergenceStudy]) -> Vec<(String, String)> {
    let sweeps = studies
        .iter()
        .flat_map(|study| study.sweeps.iter().map(move |sweep| (study, sweep)));
    let chart = |(study, sweep): (&ConvergenceStudy, &MeasuredSweep)| {
        Some((
            format!("{}: {}", study.scene, sweep.name),
            error_chart(sweep, LEGEND_WIDTH)?,
        ))
    };
    sweeps.filter_map(chart).collect()
}

/// Returns the chart of error against the option with a legend `legend` pixels wide, or none if no
/// error is above 0.
fn error_chart(sweep: &MeasuredSweep, legend: u32) -> Option<String> {
    draw_curves(sweep, "relative RMS (log)", &format_share, |point| point.error, legend)
}

/// Returns the chart of seconds against the option.
fn time_chart(sweep: &MeasuredSweep) -> Option<String> {
    draw_curves(sweep, "seconds (log)", &|y| format_number(*y), |p| p.seconds, 0)
}

fn draw_curves(
    sweep: &MeasuredSweep,
    name: &str,
    label: AxisLabel,
    size: impl Fn(&SweepPoint) -> f64,
    legend: u32,
) -> Option<String> {
    let curve = |points: &[SweepPoint]| -> Vec<(f64, f64)> {
        let points = points.iter().map(|point| (point.value, size(point)));
        points.filter(|(_, y)| *y > 0.0 && y.is_finite()).collect()
    };
    let curves: Vec<_> = sweep.curves.iter().map(|c| curve(&c.points)).collect();
    let all = || curves.iter().flatten();
    let mut values: Vec<f64> = all().map(|p| p.0).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let (low, high) = (*values.first()?, *values.last()?);
    let value = |x: &f64| format_number(*x);
    let x = Axis {
        ticks: Some(values),
        ..Axis::logarithmic_scale(sweep.option, [low * 0.85, high * 1.15], &value)
    };
    let y_range = positive_range(all().map(|p| p.1), [0.7, 1.4], [0.1, 1.0]);
    let y = Axis::logarithmic_scale(name, y_range, label);
    let size = (CHART_SIZE.0 + legend, CHART_SIZE.1);
    render_svg(size, 24 + legend, [&x, &y], |frame| {
        let names = sweep.curves.iter().enumerate().filter(|_| legend > 0);
        let rows = names.map(|(k, curve)| (curve_mark(k, (0.0, 0.0), 5.0), &curve.label));
        html! {
            @for (k, curve) in curves.iter().enumerate() {
                // A curve without points has no path.
                @if !curve.is_empty() { (draw_path(&frame.plot_path(curve.iter().copied()), curve_colour(k), 2.0, 1.0, None)) }
                @for (x, y) in curve { (curve_mark(k, (frame.x_pixel(*x), frame.y_pixel(*y)), 4.5)) }
            }
            (draw_legend((f64::from(CHART_SIZE.0), 30.0), 14.0, rows))
        }
    })
}
