//! `converge.html`: a chart and a table per sweep, in one file that opens offline.

use super::chart::{errors, key, seconds};
use super::item_buffer::Row;
use super::{MeasuredSweep, Study};
use crate::show::number::{count, duration, number, percent};
use crate::show::page::{self, Page, chart, scenes, short, table};
use common::settings::{Drawing, Lookup};
use maud::{Markup, html};

/// The page of what is done so far.
pub fn html(studies: &[Study]) -> String {
    let body = html! {
        (explanation())
        (overview(studies))
        @for (k, study) in studies.iter().enumerate() {
            section #{ "scene-" (k + 1) } {
                h2 { (short(&study.scene)) }
                p.facts { (count(study.faces as u64)) " faces · item buffers by " (study.adapter) }
                @for sweep in &study.sweeps { (section(sweep)) }
                (item_buffers(study))
            }
        }
    };
    Page {
        title: "Radiosity: convergence",
        bar: ("Scenes", scenes(studies.iter().map(|study| &study.scene))),
        verdict: html! {},
        style: "",
        body,
    }
    .html()
}

fn explanation() -> Markup {
    html! {
        p {
            "One parameter of a solve is varied at a time, all others stay. The error is the relative RMS of the "
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

/// ✓, or that the error stops: at the rounding or at another parameter's error, which is no failure.
fn mark(converges: bool) -> Markup {
    html! {
        @if converges { (page::mark(true, ["falls to the end", ""], "")) }
        @else { span.stops-here title="does not fall any further" { "– stops" } }
    }
}

/// An order as the tables show it.
pub fn order(order: Option<f64>) -> String {
    // No −0.00.
    let text = |p: f64| format!("{:.2}", (100.0 * p).round() / 100.0 + 0.0);
    order.map_or("–".into(), |p| text(p).replace('-', "−"))
}

fn overview(studies: &[Study]) -> Markup {
    html! {
        (table("", &["Scene", "Parameter", "Curve", "#First error", "#Last error", "#Order", "Falls"], html! {
            @for study in studies { @for sweep in &study.sweeps { @for curve in &sweep.curves { tr {
                td { (short(&study.scene)) }
                td { (sweep.name) }
                td { (curve.label) }
                @for point in [curve.points.first(), curve.points.last()] {
                    td.n { (point.map_or("–".into(), |p| percent(p.error))) }
                }
                td.n { (order(curve.order)) }
                td { (mark(curve.converges)) }
            } } } }
        }))
    }
}

fn section(sweep: &MeasuredSweep) -> Markup {
    html! {
        h3 { (sweep.name) " " code { (sweep.option) } }
        p.small { "Truth: " code { (sweep.truth) } " · " (base(sweep)) }
        div.grid {
            (chart(errors(sweep).as_deref(), "No error above 0.", html! { b { "Error" } " · " (legend(sweep)) }))
            (chart(seconds(sweep).as_deref(), "No seconds.", html! {
                b { "Time" } " · preparing and shooting, wall clock; " (legend(sweep))
            }))
        }
        (points(sweep))
        ul {
            @for curve in &sweep.curves {
                li { (mark(curve.converges)) " " b { (curve.label) } ": " (curve.finding) "." }
            }
        }
    }
}

/// Item buffers against rays, one row each.
fn item_buffers(study: &Study) -> Markup {
    let name = |v: &dyn std::fmt::Debug| format!("{v:?}").to_lowercase();
    let lookup = |lookup: Lookup| match lookup {
        Lookup::Exact => "exact",
        Lookup::Neighbours => "3x3",
    };
    html! {
        @if !study.item_buffers.is_empty() {
            h3 { "Item buffers against rays " code { "--visibility --raster --item-buffer --lookup" } }
            p.small {
                "All pairs of a face's centre and a texel's that face each other. Mismatched: the share of pairs that "
                "rays judge differently. Hidden and seen: the share of the transfer F·A that the item buffer loses or "
                "makes up. Time: a cell's first shot, wall clock."
            }
            (table("", &["Projection", "Raster", "#Pixels", "Lookup", "#Mismatched", "#Falsely hidden",
                "#Falsely seen", "#ms a shot"], html! {
                @for row in &study.item_buffers { tr {
                    td { (row.visibility) }
                    td { (name(&row.raster)) }
                    td.n { (row.size) "²" }
                    td { (lookup(row.lookup)) }
                    td.n { (percent(row.mismatched)) }
                    td.n { (percent(row.falsely_hidden)) }
                    td.n { (percent(row.falsely_seen)) }
                    td.n { (number(1e3 * row.shot_seconds)) }
                } }
            }))
            (choice(&study.item_buffers))
        }
    }
}

/// What the default rests on: the least wrong transfer at the default's size.
fn choice(rows: &[Row]) -> Markup {
    let wrong = |row: &Row| row.falsely_hidden + row.falsely_seen;
    let size = Drawing::DEFAULT.size;
    let best = rows
        .iter()
        .filter(|row| row.size == size)
        .min_by(|a, b| wrong(a).total_cmp(&wrong(b)));
    html! {
        @if let Some(row) = best {
            p {
                "Least wrong at " (size) "²: " b { (row.visibility) } ", "
                (percent(wrong(row))) " of the transfer. The default is stereographic, by pixels, 3x3."
            }
        }
    }
}

/// What is not varied.
fn base(sweep: &MeasuredSweep) -> String {
    let own = sweep.option.trim_start_matches('-');
    let settings = sweep.base.as_object().into_iter().flatten();
    let others = settings.filter(|(name, _)| *name != own && *name != "max-shots");
    let words =
        others.map(|(name, value)| format!("{name} {}", value.to_string().trim_matches('"')));
    words.collect::<Vec<_>>().join(", ")
}

fn legend(sweep: &MeasuredSweep) -> Markup {
    html! {
        @for (k, curve) in sweep.curves.iter().enumerate() {
            (key(k, &curve.label)) " "
        }
    }
}

fn points(sweep: &MeasuredSweep) -> Markup {
    let most = sweep
        .curves
        .iter()
        .map(|c| c.points.len())
        .max()
        .unwrap_or(0);
    let longest = sweep.curves.iter().find(|c| c.points.len() == most);
    let beside = sweep.curves.iter().any(|c| c.order_beside.is_some());
    let values = longest.iter().flat_map(|c| &c.points);
    let values = values.map(|point| format!("#{}", number(point.value)));
    let mut heads: Vec<String> = vec!["Curve".into()];
    heads.extend(values);
    heads.push("#Order".into());
    if beside {
        heads.push("#Beside the truth".into());
    }
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    table(
        "",
        &heads,
        html! {
            @for (k, curve) in sweep.curves.iter().enumerate() { tr {
                td { (key(k, &curve.label)) }
                @for j in 0..most { td.n {
                    @if let Some(point) = curve.points.get(j) {
                        (percent(point.error)) br;
                        span.facts { (percent(point.bias)) " bias" br; (duration(point.seconds)) }
                    }
                } }
                td.n { (order(curve.order)) }
                @if beside { td.n { (order(curve.order_beside)) } }
            } }
        },
    )
}
