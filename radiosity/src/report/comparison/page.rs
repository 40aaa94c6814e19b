//! Renders `report.html`: verdict, overview, a section per scene, and the explanation of the comparison.

use super::section::{SceneSection, format_error};
use super::tables::render_gate_mark;
use crate::report::format::{format_count, format_duration, format_percent};
use crate::report::page::{self, Page, file_name, render_verdict};
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use crate::report::viewer;
use maud::{Markup, html};
use oracle::compare::comparison::{Comparison, SceneComparison};

/// Renders the report; `notes` name the omitted scenes with reasons.
pub fn render_report(judged: &[SceneComparison], notes: &[String]) -> String {
    let scenes: Vec<SceneSection> = judged.iter().map(SceneSection::new).collect();
    Page {
        title: "Radiosity: CPU against GPU",
        bar: ("Scenes", section_links(judged)),
        verdict: render_headline(judged),
        style: "",
        body: html! {
            (page::render_notes(notes))
            @for scene in &scenes { (scene.render_pictures()) }
            (render_overview(judged))
            @for (k, scene) in scenes.iter().enumerate() { (scene.render_section(k)) }
            (render_explanation())
            (viewer::page_assets())
        },
    }
    .to_html()
}

fn section_links(judged: &[SceneComparison]) -> Markup {
    html! {
        a href="#top" { "Overview" }
        a href="#how" { "Method of comparison" }
        @for (k, scene) in judged.iter().enumerate() {
            a href={ "#scene-" (k + 1) } { (render_gate_mark(scene.all_agree())) " " (file_name(&scene.first.scene.name)) }
        }
    }
}

fn render_headline(judged: &[SceneComparison]) -> Markup {
    let agree = judged.iter().filter(|scene| scene.all_agree()).count();
    let all = judged.len();
    let scenes = if all == 1 { " scene" } else { " scenes" };
    match (all, agree) {
        (0, _) => render_verdict(Some(false), "Nothing compared", html! { "no scene was solved by both" }),
        (1, 1) => render_verdict(Some(true), "Agree", html! { "CPU and GPU, on the scene" }),
        _ if agree == all => render_verdict(Some(true), "Agree", html! { "CPU and GPU, on all " (all) (scenes) }),
        _ => render_verdict(
            Some(false),
            "Disagree",
            html! { "on " (all - agree) " of " (all) (scenes) },
        ),
    }
}

fn render_overview(judged: &[SceneComparison]) -> Markup {
    let both = |text: &dyn Fn(usize) -> String| html! { (text(0)) " · " (text(1)) };
    let row = &|k: usize, c: &Comparison| {
        let shots = match c.error_target {
            Some(_) => html! { "–" },
            None => both(&|i| format_count([&c.cpu, &c.gpu][i].shooters)),
        };
        let cells = [
            text_cell(render_gate_mark(c.solvers_agree())),
            text_cell(html! { a href={ "#scene-" (k + 1) } { (file_name(&c.scene.name)) } }),
            text_cell(c.preset.name()),
            number_cell(both(&|i| format_error(c, i))),
            number_cell(both(&|i| {
                format_count([c.mesh.faces.len(), c.mesh.texels.len()][i] as u64)
            })),
            number_cell(shots),
            number_cell(both(&|i| {
                format_percent([c.lockstep_difference, c.free_difference][i].relative_rms)
            })),
            number_cell(both(&|i| format_count([c.pairs.mismatched, c.pairs.unexplained][i]))),
            number_cell(both(&|i| format_percent([c.cpu_energy, c.gpu_energy][i].imbalance))),
            number_cell(both(&|i| format_duration(c.seconds[i]))),
        ];
        TableRow::new(cells).with_class_if(!c.solvers_agree(), "bad")
    };
    let scenes = judged.iter().enumerate();
    let rows = scenes.flat_map(|(k, scene)| scene.iter_comparisons().map(move |c| row(k, c)));
    let heads = [
        "",
        "Scene",
        "Preset",
        "#Error of the solution|CPU · GPU",
        "#Faces · texels",
        "#Shots|CPU · GPU",
        "#GPU − CPU, RMS|lockstep · free",
        "#Pairs mismatched|· unexplained",
        "#Energy imbalance|CPU · GPU",
        "#Time|CPU · GPU",
    ];
    render_table("overview", &heads, rows)
}

fn render_explanation() -> Markup {
    html! {
        section #how {
            h2 { "Method of comparison" }
            p {
                "Each scene is solved twice. On the " b.cpu { "CPU" } " rays determine the visibility between shooter "
                "and texel. On the " b.gpu { "GPU" } " the scene is drawn from the shooter, each face in its own colour "
                "(the item buffer), and a texel is visible if the pixel that it falls on has its face's colour. All other steps are the "
                "same."
            }
            p {
                "A comparison of these two alone could not distinguish a bug from the item buffer's finite pixels. "
                "A third solver is therefore compared with both: the " b { "twin" } ", the shaders' algorithm in plain "
                "Rust."
            }
            ol {
                li {
                    b { "Shaders ↔ twin: " } "the same steps on the same input. Only rounding may differ; it is "
                    "measured in units in the last place."
                }
                li {
                    b { "Twin ↔ rays: " } "the same except for visibility. Only sampling may differ: a mismatch away "
                    "from a boundary between two faces in the item buffer is a bug."
                }
                li {
                    b { "Lockstep: " } "the CPU's sequence of shooters is repeated on the GPU, so that rounding cannot "
                    "change the sequence."
                }
                li { b { "Free: " } "each solver chooses its own shooters, as in normal use." }
            }
            p {
                "Solves to an error use hierarchical radiosity instead of shooting: texels and nodes of a tree are linked "
                "by the same criteria on both processors. The GPU's links are compared with those that the CPU finds by "
                "rays, for each block of sixteen texels. The GPU's solution is compared twice: with a CPU solve that "
                "repeats its decisions (lockstep), and with an independent CPU solve by shafts and clusters (free), "
                "from which it may differ by the estimated errors."
            }
            p {
                "The solvers agree on a scene if every condition in its table holds; each bound is given with its "
                "reason. A broken condition means a fault in the code. Limits of the method, such as details smaller "
                "than a pixel, are reported separately as findings, with their size and what to change."
            }
            p {
                b { "Agreement is not accuracy: " } "two solvers of one method agree, however crude it is. The error "
                "of each solution is therefore given beside the verdict, against the dense matrix of all texels with "
                "independent form factors and visibility. By default two presets are compared: the default of "
                code { "solve" } ", and the paper's method (each face one shooter, disc form factors, one sample, an "
                "item buffer), which is fast and has errors of tens of per cent."
            }
        }
    }
}
