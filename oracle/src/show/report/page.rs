//! The page: what is compared, the verdicts, and a section per scene.

use super::section::{Drawn, error};
use super::tables::mark;
use crate::judge::comparison::Judged;
use crate::show::number::{count, duration, percent};
use crate::show::page::{self, Page, short, table, verdict};
use crate::show::viewer;
use maud::{Markup, html};

/// The whole report; `notes` says what was left out and why.
pub fn html(judged: &[Judged], notes: &[String]) -> String {
    let scenes: Vec<Drawn> = judged.iter().map(Drawn::new).collect();
    Page {
        title: "Radiosity: CPU against GPU",
        bar: ("Scenes", links(judged)),
        verdict: headline(judged),
        style: "",
        body: html! {
            (page::notes(notes))
            @for scene in &scenes { (scene.pictures()) }
            (overview(judged))
            @for (k, scene) in scenes.iter().enumerate() { (scene.section(k)) }
            (explanation())
            (viewer::once())
        },
    }
    .html()
}

fn links(judged: &[Judged]) -> Markup {
    html! {
        a href="#top" { "Overview" }
        a href="#how" { "How it is compared" }
        @for (k, scene) in judged.iter().enumerate() {
            a href={ "#scene-" (k + 1) } { (mark(scene.agree())) " " (short(&scene.first.scene.name)) }
        }
    }
}

fn headline(judged: &[Judged]) -> Markup {
    let agree = judged.iter().filter(|scene| scene.agree()).count();
    let all = judged.len();
    let scenes = if all == 1 { " scene" } else { " scenes" };
    match (all, agree) {
        (0, _) => verdict(
            Some(false),
            "Nothing compared",
            html! { "no scene was solved by both" },
        ),
        (1, 1) => verdict(Some(true), "Agree", html! { "CPU and GPU, on the scene" }),
        _ if agree == all => verdict(
            Some(true),
            "Agree",
            html! { "CPU and GPU, on all " (all) (scenes) },
        ),
        _ => verdict(
            Some(false),
            "Disagree",
            html! { "on " (all - agree) " of " (all) (scenes) },
        ),
    }
}

fn overview(judged: &[Judged]) -> Markup {
    let both = |text: &dyn Fn(usize) -> String| html! { (text(0)) " · " (text(1)) };
    let rows = judged.iter().enumerate();
    let rows = rows.flat_map(|(k, scene)| scene.ways().map(move |c| (k, c)));
    html! {
        (table("overview", &["", "Scene", "Solved", "#Error of the answer|CPU · GPU", "#Faces · texels",
            "#Shots|CPU · GPU", "#GPU − CPU, RMS|lockstep · free", "#Pairs mismatched|· unexplained",
            "#Energy imbalance|CPU · GPU", "#Time|CPU · GPU"], html! {
            @for (k, c) in rows {
                tr.bad[!c.agree()] {
                    td { (mark(c.agree())) }
                    td { a href={ "#scene-" (k + 1) } { (short(&c.scene.name)) } }
                    td { (c.way.name()) }
                    td.n { (both(&|i| error(c, i))) }
                    td.n { (both(&|i| count([c.mesh.faces.len(), c.mesh.texels.len()][i] as u64))) }
                    td.n {
                        @if c.asked.is_some() { "–" } @else { (both(&|i| count([&c.cpu, &c.gpu][i].shooters))) }
                    }
                    td.n { (both(&|i| percent([c.lockstep_difference, c.free_difference][i].relative_rms))) }
                    td.n { (both(&|i| count([c.pairs.mismatched, c.pairs.unexplained][i]))) }
                    td.n { (both(&|i| percent([c.cpu_energy, c.gpu_energy][i].imbalance))) }
                    td.n { (both(&|i| duration(c.seconds[i]))) }
                }
            }
        }))
    }
}

fn explanation() -> Markup {
    html! {
        section #how {
            h2 { "What is compared, and why in three ways" }
            p {
                "Each scene is solved twice. On the " b.cpu { "CPU" } " a ray decides whether a texel sees the "
                "face that is shooting. On the " b.gpu { "GPU" } " the scene is drawn as the shooter sees it, each "
                "face in its own colour (the item buffer), and a texel is lit where it finds its own colour. "
                "Everything else is meant to be the same."
            }
            p {
                "If only these two were compared, a bug and the item buffer's finite pixels would look alike. So a "
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
                "Where an answer is solved to an error nothing is shot: texels and nodes of a tree are linked, and both "
                "decide alike which links there are. So the GPU's links are held against those that the CPU finds by "
                "rays, question by question; its answer against the CPU's by the same decisions (lockstep), and "
                "against the CPU's as it solves by itself, with shafts and clusters (free). These two may differ by "
                "what they say of themselves."
            }
            p {
                "The solvers agree on a scene when every condition in its table holds; each bound is given with its "
                "reason. On any scene, only a fault in the code breaks a condition. What pixels cannot resolve is "
                "reported separately, with its size and with what mends it."
            }
            p {
                b { "Agreement is not accuracy: " } "two solvers of one method agree, however crude it is. So the "
                "error of each answer stands beside the verdict, against the dense matrix of all texels, which "
                "shares neither form factors nor visibility with them. Without options two ways are judged: what "
                code { "solve" } " does by default, and the paper's (each face one shooter, disc form factors, one "
                "sample, an item buffer), which is quick, and tens of per cent off."
            }
        }
    }
}
