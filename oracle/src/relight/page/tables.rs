//! The tables of a relight's report.

use super::Report;
use crate::show::number::{count, duration};
use crate::show::page::{list, table};
use maud::{Markup, html};

/// How much was shot, and what came out below 0.
pub fn shots(report: &Report) -> Markup {
    let rows = [
        ("Shots of the room", u64::from(report.map_shots)),
        ("Shots of the objects", u64::from(report.object_shots)),
        ("Texels below 0", report.negative_texels as u64),
        (
            "Pixels of the composite below 0",
            report.composite.negative as u64,
        ),
    ];
    list(rows.map(|(name, n)| (name, count(n))))
}

/// Wall-clock seconds of each phase, with bars.
pub fn seconds(phases: &[(&str, f64)]) -> Markup {
    let total: f64 = phases.iter().map(|(_, s)| s).sum();
    let share = |s: f64| {
        if total > 0.0 {
            (s / total).max(0.0)
        } else {
            0.0
        }
    };
    html! {
        @if !phases.is_empty() {
            h3 { "Time" }
            @for (name, s) in phases {
                div.energy {
                    span.phase { (name) }
                    div.bar {
                        span.absorbed style=(format!("flex-grow:{:.5}", share(*s))) {}
                        span style=(format!("flex-grow:{:.5}", 1.0 - share(*s))) {}
                    }
                    span.seconds { (duration(*s)) }
                }
            }
        }
    }
}

/// Every option in force.
pub fn settings(settings: &[(String, String)]) -> Markup {
    html! {
        @if !settings.is_empty() {
            h3 { "Settings in force" }
            (table("", &[], html! { @for (name, value) in settings { tr { td { (name) } td { (value) } } } }))
        }
    }
}
