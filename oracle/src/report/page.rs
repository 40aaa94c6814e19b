//! The page: what is compared, the verdicts, and a section per scene.

use super::number::{count, number, percent};
use super::section::section;
use super::tables::mark;
use crate::comparison::Comparison;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
const TITLE: &str = "Radiosity: CPU against GPU";

/// The whole report; `notes` says what was left out and why.
pub fn html(comparisons: &[Comparison], notes: &[String]) -> String {
    let body = html! {
        header #top {
            h1 { (TITLE) }
            (headline(comparisons))
        }
        @if !notes.is_empty() { div.notes { @for note in notes { p { (note) } } } }
        (overview(comparisons))
        (explanation())
        @for (k, c) in comparisons.iter().enumerate() { (section(k, c)) }
    };
    document(TITLE, &index(comparisons), &body)
}

/// A page in the reports' look, in one file that needs no other: `nav` is the bar on top.
pub fn document(title: &str, nav: &Markup, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                (nav)
                main { (body) }
            }
        }
    };
    page.into_string()
}

fn index(comparisons: &[Comparison]) -> Markup {
    html! {
        nav aria-label="Scenes" {
            a href="#top" { "Overview" }
            a href="#how" { "How it is compared" }
            @for (k, c) in comparisons.iter().enumerate() {
                a href={ "#scene-" (k + 1) } { (mark(c.agree())) " " (c.scene.name) }
            }
        }
    }
}

fn headline(comparisons: &[Comparison]) -> Markup {
    let agree = comparisons.iter().filter(|c| c.agree()).count();
    let all = comparisons.len();
    html! {
        @if all == 0 {
            p.verdict.disagree { strong { "Nothing compared" } " no scene was solved by both" }
        } @else if agree == all {
            p.verdict.agree {
                strong { "Agree" } " CPU and GPU, on "
                @if all == 1 { "the scene" } @else { "all " (all) " scenes" }
            }
        } @else {
            p.verdict.disagree {
                strong { "Disagree" } " on " (all - agree) " of " (all)
                @if all == 1 { " scene" } @else { " scenes" }
            }
        }
    }
}

fn overview(comparisons: &[Comparison]) -> Markup {
    let both = |text: &dyn Fn(usize) -> String| html! { (text(0)) " · " (text(1)) };
    html! {
        div.scroll { table.overview {
            thead { tr {
                th {} th { "Scene" } th.n { "Faces · texels" } th.n { "Shots" br; "CPU · GPU" }
                th.n { "Relative RMS" br; "lockstep · free" } th.n { "Pairs mismatched" br; "· unexplained" }
                th.n { "Energy imbalance" br; "CPU · GPU" } th.n { "Seconds" br; "CPU · GPU" }
            } }
            tbody { @for (k, c) in comparisons.iter().enumerate() {
                tr.bad[!c.agree()] {
                    td { (mark(c.agree())) }
                    td { a href={ "#scene-" (k + 1) } { (c.scene.name) } }
                    td.n { (both(&|i| count([c.mesh.faces.len(), c.mesh.texels.len()][i] as u64))) }
                    td.n { (both(&|i| count([&c.cpu, &c.gpu][i].shots.len() as u64))) }
                    td.n { (both(&|i| percent([c.lockstep_difference, c.free_difference][i].relative_rms))) }
                    td.n { (both(&|i| count([c.pairs.mismatched, c.pairs.unexplained][i]))) }
                    td.n { (both(&|i| percent([c.cpu_energy, c.gpu_energy][i].imbalance))) }
                    td.n { (both(&|i| number(c.seconds[i]))) }
                }
            } }
        } }
    }
}

fn explanation() -> Markup {
    html! {
        section #how {
            h2 { "What is compared, and why by three solvers" }
            p {
                "Each scene is solved twice. On the " b.cpu { "CPU" } " a ray decides whether a texel sees the "
                "face that is shooting. On the " b.gpu { "GPU" } " the scene is drawn as the shooter sees it, each "
                "face in its own colour (the item buffer), and a texel is lit where it finds its own colour. "
                "Everything else is meant to be the same."
            }
            p {
                "Were only these two compared, a bug and the item buffer's finite pixels would look alike. So a "
                "third solver stands between them: the " b { "twin" } ", the shaders' algorithm in plain Rust."
            }
            ol {
                li {
                    b { "Shaders ↔ twin: " } "the same steps on the same numbers. Only rounding may differ, and it "
                    "is counted in units in the last place."
                }
                li {
                    b { "Twin ↔ rays: " } "the same but for visibility. Only sampling may differ: every mismatch "
                    "must lie at a boundary between two faces in the item buffer, or it is a bug."
                }
                li {
                    b { "Lockstep: " } "the CPU's shooters, repeated on the GPU, so that one rounding does not "
                    "send the two different ways."
                }
                li { b { "Free: " } "each chooses its own next shooter, as users run it." }
            }
            p {
                "The solvers agree on a scene when every condition in its table holds; beside each bound stands "
                "where it comes from."
            }
        }
    }
}
