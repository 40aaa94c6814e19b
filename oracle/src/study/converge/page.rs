//! `converge.html`: a chart and a table per sweep, in one file that opens offline.

use super::chart::{colour, errors, seconds};
use super::item_buffer::Row;
use super::{MeasuredSweep, Study};
use crate::show::number::{count, number, percent};
use crate::show::page::{self, Page, chart, scenes, table};
use common::settings::{Drawing, Lookup};
use maud::{Markup, html};

/// The page of what is done so far.
pub fn html(studies: &[Study]) -> String {
    let body = html! {
        (explanation())
        (overview(studies))
        @for (k, study) in studies.iter().enumerate() {
            section #{ "scene-" (k + 1) } {
                h2 { (study.scene) }
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

/// ✓ or –, and no colour alone.
fn mark(converges: bool) -> Markup {
    page::mark(converges, ["falls to the end", "stops"], "■")
}

/// An order as the tables show it.
pub fn order(order: Option<f64>) -> String {
    // No −0.00.
    let text = |p: f64| format!("{:.2}", (100.0 * p).round() / 100.0 + 0.0);
    order.map_or("–".into(), |p| text(p).replace('-', "−"))
}

fn overview(studies: &[Study]) -> Markup {
    html! {
        (table("", &["Scene", "Parameter", "Curve", "#First error", "#Last error", "#Order", ""], html! {
            @for study in studies { @for sweep in &study.sweeps { @for curve in &sweep.curves { tr {
                td { (study.scene) }
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
            (swatch(k, &curve.label)) " "
        }
    }
}

fn swatch(k: usize, name: &str) -> Markup {
    page::key(colour(k), html! { (name) })
}

fn points(sweep: &MeasuredSweep) -> Markup {
    let most = sweep
        .curves
        .iter()
        .map(|c| c.points.len())
        .max()
        .unwrap_or(0);
    let longest = sweep.curves.iter().find(|c| c.points.len() == most);
    html! {
        div.scroll { table {
            thead { tr {
                th { "Curve" }
                @for point in longest.iter().flat_map(|c| &c.points) { th.n { (number(point.value)) } }
                th.n { "Order" } th.n { "Beside the truth" }
            } }
            tbody { @for (k, curve) in sweep.curves.iter().enumerate() { tr {
                td { (swatch(k, &curve.label)) }
                @for j in 0..most { td.n {
                    @if let Some(point) = curve.points.get(j) {
                        (percent(point.error)) br;
                        span.facts { (percent(point.bias)) " bias" br; (number(point.seconds)) " s" }
                    }
                } }
                td.n { (order(curve.order)) }
                td.n { (order(curve.order_beside)) }
            } } }
        } }
    }
}
